//! Presets: looks, that is, values for `[physarum]`, `[trail]` and `[feeding]` and the colours of the trail, built in or from files.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::path::Path;

use toml::de::DeTable;

use super::builtin;
use super::error::SceneError;
use super::parameters::{Kind, PARAMETERS, Parameter};
use super::settings::Settings;
use crate::regular_file;

/// The sections of scene files that a look consists of. The last one has only the colours of the trail.
const SECTIONS: [&str; 4] = ["physarum", "trail", "feeding", PICTURE];
const PICTURE: &str = "picture";
const COLOURS: &str = "color_map";

/// The parts of a look, for messages.
pub(super) const PARTS: &str =
    "the sections [physarum], [trail] and [feeding], and picture.color_map";

/// Keys of these sections that belong to the scene and not to a look: its model, its steps, what sensors are, how trail and scent spread.
const HOW: [&str; 13] = [
    "physarum.border",
    "physarum.edge_crossing_attempts",
    "physarum.sensing",
    "physarum.model",
    "physarum.order",
    "physarum.occupancy_rounds",
    "physarum.sensor_width",
    "trail.diffusion_length",
    "trail.across",
    "trail.half_life",
    "feeding.projection",
    "feeding.projection_covered",
    "feeding.scent_across",
];

/// Is the key part of a look?
#[must_use]
pub fn is_look(parameter: &Parameter) -> bool {
    match parameter.section() {
        PICTURE => parameter.key.ends_with(COLOURS),
        section => SECTIONS.contains(&section) && !HOW.contains(&parameter.key),
    }
}

/// The look of `settings` as the text of a preset; `summary`, one line, describes it.
///
/// ```
/// use myxo::scene::{presets, settings::Settings};
///
/// let text = presets::to_toml(&Settings::default(), "As everything begins.");
/// assert!(text.starts_with("# As everything begins.\n[physarum]\n"));
/// assert!(presets::is_preset(&text));
/// ```
#[must_use]
pub fn to_toml(settings: &Settings, summary: &str) -> String {
    let summary = summary.split_whitespace().collect::<Vec<_>>().join(" ");
    let mut text = format!("# {summary}\n");
    for (i, section) in SECTIONS.into_iter().enumerate() {
        let _ = writeln!(text, "{}[{section}]", if i > 0 { "\n" } else { "" });
        let of_section = PARAMETERS.iter().filter(|p| p.section() == section);
        for parameter in of_section.filter(|parameter| is_look(parameter)) {
            let quote = match parameter.kind {
                Kind::Choice { .. } | Kind::Text { .. } => "\"",
                _ => "",
            };
            let key = parameter.key.rsplit('.').next().unwrap_or_default();
            let value = parameter.value(settings);
            let _ = writeln!(text, "{key} = {quote}{value}{quote}");
        }
    }
    text
}

/// Does the text hold a look and nothing else? A scene file with only the keys of a look counts, too.
#[must_use]
pub fn is_preset(text: &str) -> bool {
    DeTable::parse(text)
        .is_ok_and(|table| !table.get_ref().is_empty() && foreign(table.get_ref()).is_none())
}

/// The first key that is not part of a look, and its offset.
pub(super) fn foreign(table: &DeTable<'_>) -> Option<(usize, String)> {
    let sections = table.iter().filter_map(|(section, value)| {
        let name = section.get_ref();
        if !SECTIONS.contains(&name.as_ref()) {
            return Some((section.span().start, name.to_string()));
        }
        let keys = value.get_ref().as_table().filter(|_| name == PICTURE)?;
        let other = keys.keys().filter(|key| key.get_ref() != COLOURS);
        let other = other.min_by_key(|key| key.span().start)?;
        Some((other.span().start, format!("{name}.{}", other.get_ref())))
    });
    sections.min_by_key(|&(start, _)| start)
}

/// The text of a preset by name: a built-in one, or a `.toml` file.
pub(super) fn text_of(wanted: &str) -> Result<Cow<'static, str>, SceneError> {
    if let Some(preset) = builtin::preset(wanted) {
        return Ok(Cow::Borrowed(preset.text));
    }
    let path = Path::new(wanted);
    let is_toml = path
        .extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("toml"));
    if !is_toml && !path.is_file() {
        return Err(SceneError::unknown_preset(wanted));
    }
    let text = regular_file::read_text(path).map_err(|source| SceneError::ReadPreset {
        path: path.to_owned(),
        source,
    })?;
    Ok(Cow::Owned(text))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::file::Reader;
    use crate::scene::problems::Problems;
    use crate::scene::settings::{ColorMap, Preference, Turning};
    use crate::scene::{Overrides, Scene};

    fn read(settings: Settings, text: &str) -> Result<Settings, Vec<String>> {
        let mut reader = Reader::new(settings);
        reader.preset("preset mine", text);
        let texts = |problems: Problems| problems.iter().map(ToString::to_string).collect();
        reader.finish().map_err(texts)
    }

    #[test]
    fn a_look_comes_back_from_its_text_on_any_scene() {
        let mut settings = Settings::default();
        settings.physarum.speed = 0.00123;
        settings.physarum.favourite_density = 17.5;
        settings.physarum.distance_weight = -1e-5;
        settings.trail.decay = 0.875;
        settings.trail.diffusion_distance = 3;
        settings.picture.color_map = ColorMap::Ice;
        settings.seed = 99;
        let text = to_toml(&settings, "Mine,\nin two lines.");
        assert!(text.starts_with("# Mine, in two lines.\n"), "{text}");
        assert!(is_preset(&text));
        let other = Settings::default();
        let mut with = read(other.clone(), &text).expect("it is right");
        for parameter in PARAMETERS {
            let differs = parameter.differs(&with, &settings);
            assert!(!(is_look(parameter) && differs), "{}", parameter.key);
            if is_look(parameter) {
                parameter.copy(&other, &mut with);
            }
        }
        assert_eq!(with, other, "nothing else has changed");
        for preset in builtin::PRESETS {
            assert!(is_preset(preset.text), "{}", preset.name);
        }
    }

    /// Would catch: an older preset, whose density of 0 means none, that avoids all trail on a scene that does.
    #[test]
    fn looks_that_say_no_preference_have_none() {
        let mut settings = Settings::default();
        settings.physarum.preference = Preference::Favourite;
        let text = "[physarum]\nfavourite_density = 0";
        let read_on = |text: &str| read(settings.clone(), text).expect("it is right");
        assert_eq!(read_on(text).physarum.favourite(), None);
        let text = format!("{text}\npreference = \"favourite\"");
        assert_eq!(read_on(&text).physarum.favourite(), Some(0.0));
    }

    /// Would catch: a look kept by an earlier version that frays after `cords`, on whose rules it says nothing.
    #[test]
    fn looks_that_say_no_rules_of_turning_and_sensing_have_those_of_the_model() {
        let mut settings = Settings::default();
        settings.physarum.turning = Turning::Random;
        settings.physarum.random_turn = 0.2;
        settings.physarum.sensitivity = 8.0;
        let read_on = |text: &str| read(settings.clone(), text).expect("it is right").physarum;
        let plain = Settings::default().physarum;
        assert_eq!(read_on("[trail]\ndecay = 0.5"), plain);
        let own = read_on("[physarum]\nrandom_turn = 0.1");
        assert_eq!(
            (own.turning, own.random_turn, own.sensitivity),
            (plain.turning, 0.1, 0.0)
        );
    }

    #[test]
    fn texts_that_are_no_presets_are_refused() {
        for scene in builtin::SCENES {
            assert!(!is_preset(scene.text), "{}", scene.name);
        }
        let problem = |text| read(Settings::default(), text).expect_err("it is wrong");
        for (text, part) in [
            ("", "it has nothing of a look"),
            ("# nothing", "it has nothing of a look"),
            ("[physarum", "line 1: not valid TOML"),
            ("seed = 1\n[trail]\ndecay = 0.5", "line 1: seed is no part"),
            ("[atlas]\nsize = 64", "line 1: atlas is no part of a look"),
            (
                "[picture]\ncolor_map = \"ice\"\nshow = \"relief\"",
                "line 3: picture.show is no part of a look",
            ),
        ] {
            assert!(!is_preset(text), "{text}");
            let [problem] = &problem(text)[..] else {
                panic!("one message for {text}");
            };
            assert!(problem.starts_with("preset mine"), "{problem}");
            assert!(problem.contains(part), "{problem}");
        }
        assert!(is_preset("[trail]\ndecay = 7"), "a preset, and a wrong one");
        let found = problem("[trail]\ndecay = 7\ndiffusoin = 1");
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].contains("line 2") && found[1].contains("did you mean"));
    }

    #[test]
    fn files_are_presets_on_the_command_line() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("mine.toml");
        let with = |preset: &Path| {
            let overrides = Overrides {
                preset: Some(preset.to_str().unwrap().to_owned()),
                ..Overrides::default()
            };
            Scene::read(Path::new("cube"), &overrides)
        };
        let message = with(&file).expect_err("there is none").to_string();
        assert!(message.starts_with("cannot read the preset"), "{message}");
        std::fs::write(&file, "[trail]\ndecay = 0.5\n").unwrap();
        let (name, settings, _) = with(&file).expect("it is right");
        assert_eq!((name.as_str(), settings.trail.decay), ("cube", 0.5));
        std::fs::write(&file, "[[object]]\nmesh = \"builtin:cube\"\n").unwrap();
        let message = with(&file).expect_err("it is a scene").to_string();
        assert!(
            message.contains("mine.toml") && message.contains("object is no part of a look"),
            "{message}"
        );
        std::fs::write(&file, [0xff, 0xfe, 0x00]).unwrap();
        assert!(with(&file).is_err(), "no text");
        let message = with(folder.path()).expect_err("a folder").to_string();
        assert!(message.starts_with("there is no preset"), "{message}");
    }
}
