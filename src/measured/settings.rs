//! The settings of a run as reports have them: every key of its scene file; and the differences between two runs.

use std::collections::BTreeSet;

use myxo::scene::Scene;
use myxo::scene::settings::Settings;
use serde_json::{Value, json};

/// Every key of a scene that runs with these settings, as its scene file has them: `physarum.speed` is `["physarum"]["speed"]`.
pub fn of(scene: &Scene, settings: &Settings) -> Value {
    toml::from_str(&scene.to_toml_as(settings)).expect("a scene file is TOML without dates")
}

/// The settings of the second run that differ: `physarum.speed = 0.006, which was 0.004`. The seed is left out: reports have it as a field
/// of its own.
pub fn differences(first: &Value, second: &Value) -> Vec<String> {
    let mut lines = Vec::new();
    compare("", first, second, &mut lines);
    lines.retain(|line| !line.starts_with("seed ="));
    lines
}

fn compare(key: &str, first: &Value, second: &Value, lines: &mut Vec<String>) {
    let dotted = |name: &str| match key {
        "" => name.to_owned(),
        section => format!("{section}.{name}"),
    };
    match (first, second) {
        (Value::Object(a), Value::Object(b)) => {
            let names: BTreeSet<&String> = a.keys().chain(b.keys()).collect();
            for name in names {
                let [a, b] = [a, b].map(|table| table.get(name).unwrap_or(&Value::Null));
                compare(&dotted(name), a, b, lines);
            }
        }
        // Objects and foods.
        (Value::Array(a), Value::Array(b)) if a.iter().chain(b).any(Value::is_object) => {
            for i in 0..a.len().max(b.len()) {
                let [a, b] = [a, b].map(|list| list.get(i).unwrap_or(&Value::Null));
                compare(&dotted(&i.to_string()), a, b, lines);
            }
        }
        (a, b) if a == b => {}
        // A section that one version lacks is compared key by key; an object or a food is not.
        (Value::Null, Value::Object(_)) if !ends_with_number(key) => {
            compare(key, &json!({}), second, lines);
        }
        (Value::Null, b) if has_keys(b) => lines.push(format!("{key} is in the second only")),
        (a, Value::Null) if has_keys(a) => lines.push(format!("{key} is in the first only")),
        (a, b) => lines.push(format!("{key} = {}, which was {}", shown(b), shown(a))),
    }
}

/// Is it an object of the scene, a food, or a list of these?
fn has_keys(value: &Value) -> bool {
    let list = value.as_array();
    value.is_object() || list.is_some_and(|list| list.iter().any(Value::is_object))
}

fn ends_with_number(key: &str) -> bool {
    key.ends_with(|last: char| last.is_ascii_digit())
}

/// A value as the scene file writes it; words without quotes.
fn shown(value: &Value) -> String {
    match value {
        Value::Null => "not set".to_owned(),
        Value::String(word) => word.clone(),
        Value::Array(values) => {
            let values: Vec<String> = values.iter().map(shown).collect();
            format!("[{}]", values.join(", "))
        }
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use myxo::scene::Overrides;

    fn of_scene(name: &str, set: &[&str]) -> Value {
        let overrides = Overrides {
            set: set.iter().map(|&text| text.to_owned()).collect(),
            ..Overrides::default()
        };
        let scene = Scene::load(name.as_ref(), &overrides).expect("it loads");
        of(&scene, &scene.settings)
    }

    #[test]
    fn keys_are_those_of_the_scene_file_and_numbers_as_short_as_there() {
        let settings = of_scene("cube", &["physarum.speed=0.006", "particles.count=9"]);
        assert_eq!(settings["physarum"]["speed"], 0.006);
        assert_eq!(settings["particles"]["count"], 9);
        assert_eq!(settings["object"][0]["mesh"], "builtin:cube");
        assert!(settings["radius"].as_f64() > Some(0.0), "as measured");
    }

    /// Catches recorded reports of scenes that have changed since; `make bench` measures them again.
    #[test]
    fn recorded_reports_are_of_the_scenes_as_they_are() {
        let results = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/results");
        let mut checked = 0;
        for folder in [results.clone(), results.join("objects")] {
            for entry in std::fs::read_dir(folder).expect("it is a folder") {
                let path = entry.expect("it can be listed").path();
                if path.extension().is_some_and(|ending| ending == "json") {
                    checked += check_report(&path);
                }
            }
        }
        assert!(checked >= 5, "{checked} reports");
    }

    /// Returns how many scenes a report has settings of. Reports of versions without settings name their commit.
    fn check_report(path: &Path) -> usize {
        let json = std::fs::read(path).expect("it can be read");
        let report: Value = serde_json::from_slice(&json).expect("it is JSON");
        // Reports of two scenes in turn have two.
        let first = report.get("first").unwrap_or(&report);
        let command = first["command"].as_str().expect("it is text");
        let words: Vec<&str> = command.split(' ').collect();
        let after = |option: &str| -> Vec<&str> {
            let pairs = words.windows(2).filter(|pair| pair[0] == option);
            pairs.map(|pair| pair[1]).collect()
        };
        let scenes = words.iter().skip(2).zip(words.iter().skip(1));
        let scenes =
            scenes.filter(|(word, before)| !word.starts_with("--") && !before.starts_with("--"));
        let scene = scenes
            .map(|(word, _)| *word)
            .next()
            .expect("it names a scene");
        let (set, against) = (after("--set"), after("--against"));
        let second = match against[..] {
            [key_value] if key_value.contains('=') => Some((scene, [&set[..], &against].concat())),
            [other] => Some((other, set.clone())),
            _ => None,
        };
        let reports = [(first, Some((scene, set))), (&report["second"], second)];
        let recorded =
            (reports.into_iter()).filter_map(|(report, of)| Some((report.get("settings")?, of?)));
        recorded
            .map(|(recorded, (scene, set))| {
                let mut lines = differences(recorded, &of_scene(scene, &set));
                // New keys and the look of pictures do not change the time of a step.
                lines.retain(|line| !line.ends_with("which was not set"));
                lines.retain(|line| !line.starts_with("picture.") && !line.starts_with("camera."));
                assert!(lines.is_empty(), "{}: {lines:?}", path.display());
            })
            .count()
    }

    #[test]
    fn keys_that_differ_are_listed_as_a_resumed_run_lists_them() {
        let a = of_scene("trio", &["physarum.speed=0.004", "radius=1.5"]);
        assert!(differences(&a, &a).is_empty());
        let b = [
            "physarum.speed=0.006",
            "physarum.border=stop",
            "seed=99",
            "radius=1.5",
            "object.1.position=[1, 2.5, 3]",
        ];
        let lines = differences(&a, &of_scene("trio", &b));
        assert_eq!(lines.len(), 3, "{lines:?}");
        assert!(lines[0].starts_with("object.1.position = [1.0, 2.5, 3.0], which was ["));
        assert_eq!(lines[1], "physarum.border = stop, which was reflect");
        assert_eq!(lines[2], "physarum.speed = 0.006, which was 0.004");
        let lines = differences(&a, &of_scene("torus", &[]));
        assert!(lines.contains(&"object.2 is in the first only".to_owned()));
    }
}
