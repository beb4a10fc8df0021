//! The documents are true to the program: the guide has every key with its default and range, and the strips that
//! `docs/guide.toml` asks for; everything that documents link to or name exists.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Component, Path, PathBuf};

use crate::program::{self, text};
use myxo::scene::settings::Settings;
use myxo::scene::{Overrides, Scene};
use myxo::sweep::Study;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn file(name: &str) -> String {
    fs::read_to_string(root().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Markdown files with their folders.
fn documents() -> Vec<(PathBuf, String)> {
    let docs = fs::read_dir(root().join("docs")).expect("it is a folder");
    let mut paths: Vec<PathBuf> = docs
        .map(|entry| Path::new("docs").join(entry.expect("it can be listed").file_name()))
        .filter(|path| path.extension().is_some_and(|ending| ending == "md"))
        .collect();
    paths.push("README.md".into());
    paths
        .into_iter()
        .map(|path| (path.clone(), file(path.to_str().expect("it is text"))))
        .collect()
}

/// The targets of links and pictures of a document, relative to the project's folder; those to the web are left out.
fn links(document: &Path, text: &str) -> Vec<(PathBuf, Option<String>)> {
    let targets = text.split("](").skip(1).map(|rest| {
        let end = rest.find(')').expect("a link ends");
        &rest[..end]
    });
    targets
        .filter(|target| !target.contains("://"))
        .map(|target| {
            let (path, heading) = match target.split_once('#') {
                Some((path, heading)) => (path, Some(heading.to_owned())),
                None => (target, None),
            };
            if path.is_empty() {
                return (document.to_owned(), heading);
            }
            let folder = document.parent().expect("a document lies in a folder");
            (without_dots(&folder.join(path)), heading)
        })
        .collect()
}

/// `docs/../assets` is `assets`.
fn without_dots(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => assert!(plain.pop(), "{} leads out", path.display()),
            part => plain.push(part),
        }
    }
    plain
}

/// The anchor of a heading: small letters and hyphens.
fn anchor(heading: &str) -> String {
    let plain = heading.trim_start_matches('#').trim().to_lowercase();
    let letters = plain.chars().filter_map(|c| match c {
        ' ' | '-' => Some('-'),
        '_' => Some('_'),
        c if c.is_alphanumeric() => Some(c),
        _ => None,
    });
    letters.collect()
}

#[test]
fn link_targets_of_documents_exist() {
    let mut count = 0;
    for (document, text) in documents() {
        for (target, heading) in links(&document, &text) {
            let place = root().join(&target);
            assert!(
                place.exists(),
                "{} links to {}, which is missing",
                document.display(),
                target.display()
            );
            if let Some(heading) = heading {
                let headings = fs::read_to_string(&place).expect("it is text");
                let mut headings = headings.lines().filter(|line| line.starts_with('#'));
                assert!(
                    headings.any(|line| anchor(line) == heading),
                    "{} links to {}#{heading}, a heading that is missing",
                    document.display(),
                    target.display()
                );
            }
            count += 1;
        }
    }
    assert!(count > 80, "{count} links");
}

/// Checks that text in the code font that looks like a path is one.
#[test]
fn paths_in_documents_exist() {
    let mut count = 0;
    for name in ["docs/guide.md", "docs/code.md"] {
        for named in file(name).split('`').skip(1).step_by(2) {
            let folders = ["src/", "shaders/", "tests/", "docs/", "assets/", "benches/"];
            let is_path = folders.iter().any(|folder| named.starts_with(folder))
                && !named.contains([' ', '*', 'N']);
            if is_path {
                assert!(
                    root().join(named).exists(),
                    "{name} names {named}, which is missing"
                );
                count += 1;
            }
        }
    }
    assert!(count > 5, "{count} paths");
}

/// `myxo scenes --keys` lists each key with its default, and in the third line the allowed values.
#[test]
fn the_guide_has_every_key_with_its_default_and_range() {
    let keys = text(&program::myxo(&["scenes", "--keys"]).stdout);
    let guide = file("docs/guide.md");
    let mut missing = Vec::new();
    let mut lines = keys.lines().peekable();
    let mut count = 0;
    while let Some(head) = lines.next() {
        let mut about = Vec::new();
        while let Some(line) = lines.next_if(|line| line.starts_with(' ')) {
            about.push(line.trim());
        }
        let allowed = about
            .last()
            .expect("a key is explained")
            .trim_end_matches('.');
        let code = format!("`{head}`");
        if !(guide.lines()).any(|line| line.contains(&code) && line.contains(allowed)) {
            missing.push(format!("{code} · {allowed}"));
        }
        count += 1;
    }
    assert!(count > 80, "{count} keys");
    assert!(
        missing.is_empty(),
        "docs/guide.md lacks these lines:\n{}",
        missing.join("\n")
    );
}

/// The table of strips of `make guide`.
fn table() -> toml::Table {
    file("docs/guide.toml").parse().expect("it is TOML")
}

fn word(value: &toml::Value) -> String {
    value.as_str().expect("it is a text").to_owned()
}

/// Catches a renamed key before the quarter of an hour in which the strips are drawn.
#[test]
fn every_strip_sets_existing_keys() {
    let table = table();
    let list = |strip: &toml::Table, key: &str| -> Vec<String> {
        let list = strip.get(key).and_then(toml::Value::as_array);
        list.into_iter().flatten().map(word).collect()
    };
    for strip in table["strip"].as_array().expect("it has strips") {
        let strip = strip.as_table().expect("a strip is a table");
        let scene = word(strip.get("scene").unwrap_or(&table["scene"]));
        let set = [
            list(&table, "plain"),
            list(&table, "set"),
            list(strip, "set"),
        ]
        .concat();
        let values = list(strip, "values");
        assert!(values.len() > 1, "{strip}");
        for value in values {
            let mut set = set.clone();
            set.push(format!("{}={value}", word(&strip["key"])));
            let overrides = Overrides {
                set,
                ..Overrides::default()
            };
            Scene::read(Path::new(&scene), &overrides)
                .unwrap_or_else(|error| panic!("{strip}: {error}"));
        }
    }
}

/// Catches a study, a scene or a setting that is wrong, before all experiments are redone, and a figure that no command draws.
#[test]
fn the_commands_of_experiments_can_be_run() {
    let page = file("docs/experiments.md");
    let commands = page.lines().filter(|line| {
        let mut words = line.split(' ');
        matches!(words.next(), Some("myxo" | "cp"))
    });
    let mut written = BTreeSet::new();
    let mut count = 0;
    for command in commands {
        let words: Vec<&str> = command.split(' ').collect();
        let values = |option: &str| -> Vec<String> {
            let pairs = words.windows(2).filter(|pair| pair[0] == option);
            pairs.map(|pair| pair[1].to_owned()).collect()
        };
        written.extend(values("--out"));
        let overrides = Overrides {
            set: values("--set"),
            ..Overrides::default()
        };
        match words[..2] {
            ["cp", from] => {
                let folder = from.strip_suffix("/sheet.png").expect("it is a sheet");
                assert!(written.contains(folder), "{command}");
                written.insert(words[2].to_owned());
            }
            ["myxo", "sweep"] => {
                let study = Study::read(&root().join(words[2])).expect(command);
                assert!(
                    study.picture.is_some() && !study.axes.is_empty(),
                    "{command}"
                );
                let (_, jobs) = study.jobs().expect(command);
                let last = jobs.last().expect("a study has runs");
                last.scene().expect(command);
            }
            _ => {
                let scene = Scene::read(Path::new(words[2]), &overrides);
                scene.expect(command);
            }
        }
        count += 1;
    }
    assert!(count >= 8, "{count} commands");
    let folder = Path::new("assets/experiments");
    let shown: BTreeSet<String> = links(Path::new("docs/experiments.md"), &page)
        .into_iter()
        .filter(|(target, _)| target.starts_with(folder))
        .map(|(target, _)| target.to_str().expect("it is text").to_owned())
        .collect();
    written.retain(|file| Path::new(file).starts_with(folder));
    assert_eq!(shown, written, "shown, and drawn by the commands");
    for figure in shown {
        let bytes = fs::metadata(root().join(&figure))
            .expect("it is drawn")
            .len();
        assert!(bytes < 300_000, "{figure}: {bytes} bytes");
    }
}

/// The names of the strips.
fn strips() -> BTreeSet<String> {
    let table = table();
    let strips = table["strip"].as_array().expect("it has strips");
    let names = (strips.iter()).map(|strip| word(strip.get("name").unwrap_or(&strip["key"])));
    let set: BTreeSet<String> = names.collect();
    assert_eq!(set.len(), strips.len(), "each has a name of its own");
    set
}

#[test]
fn the_guide_shows_every_strip_and_no_picture_is_left_over() {
    let mut drawn: BTreeSet<String> = strips()
        .into_iter()
        .map(|name| format!("{name}.png"))
        .collect();
    assert!(drawn.len() > 30, "{drawn:?}");
    // The window is no strip.
    drawn.insert("window.png".to_owned());
    let folder = Path::new("assets/guide");
    let shown: BTreeSet<String> = links(Path::new("docs/guide.md"), &file("docs/guide.md"))
        .into_iter()
        .filter(|(target, _)| target.starts_with(folder))
        .map(|(target, _)| name_of(&target))
        .collect();
    assert_eq!(
        shown, drawn,
        "shown in docs/guide.md, and drawn by `make guide`"
    );
    let mut bytes = 0;
    let entries = fs::read_dir(root().join(folder)).expect("it is a folder");
    let kept: BTreeSet<String> = entries
        .map(|entry| {
            let entry = entry.expect("it can be listed");
            bytes += entry.metadata().expect("it is a file").len();
            name_of(&entry.path())
        })
        .collect();
    assert_eq!(
        kept,
        drawn,
        "in {}, and drawn by `make guide`",
        folder.display()
    );
    assert!(bytes < 12 << 20, "{bytes} bytes of pictures");
}

/// Keys without a picture, and why.
const UNSEEN: [(&str, &str); 10] = [
    ("physarum.order", "only the first step differs"),
    ("time.steps_per_second", "the same grows, more slowly"),
    ("distance.method", "the distances are the same"),
    ("distance.depth", "they differ in the last digits"),
    ("distance.depth_near", "they differ in the last digits"),
    ("distance.depth_scale", "they differ in the last digits"),
    ("distance.sign", "they differ in creases and at holes"),
    ("object.N.name", "it is a name"),
    (
        "object.N.glue",
        "what crosses an edge shows it, and no still picture",
    ),
    (
        "object.N.motion.model",
        "it needs a model that has an animation",
    ),
];

#[test]
fn every_key_has_a_picture_of_its_effect() {
    let keys = text(&program::myxo(&["scenes", "--keys"]).stdout);
    let strips = strips();
    let heads = keys.lines().filter(|line| !line.starts_with(' '));
    let keys: Vec<&str> = heads
        .filter_map(|head| Some(head.split_once(" = ")?.0))
        .collect();
    assert!(keys.len() > 80, "{keys:?}");
    let has_picture = |key: &str| {
        // An object's own parameters of particles share one picture, and so do those of its trail.
        let shared = ["object.N.physarum.", "object.N.trail."];
        shared.iter().any(|part| key.starts_with(part)) || strips.contains(&key.replace(".N.", "."))
    };
    assert!(strips.contains("object.physarum") && strips.contains("object.trail"));
    let lacking = keys.iter().filter(|key| !has_picture(key));
    let lacking: Vec<&str> = lacking.copied().collect();
    let mut unseen = UNSEEN.map(|(key, _)| key).to_vec();
    unseen.sort_by_key(|unseen| keys.iter().position(|key| key == unseen));
    assert_eq!(lacking, unseen);
}

/// Would catch: a plain scene that keeps a part of the reference scene's look, or that measures something else.
#[test]
fn plain_scenes_are_the_reference_scenes_without_a_look() {
    for name in ["cube", "torus"] {
        let read = |path: &Path| {
            Scene::read(path, &Overrides::default())
                .expect("it is right")
                .1
        };
        let reference = read(Path::new(name));
        let plain = read(&root().join(format!("benches/scenes/plain_{name}.toml")));
        let usual = Settings::default();
        assert_eq!(plain.physarum, usual.physarum, "{name}");
        assert_eq!(plain.trail, usual.trail, "{name}");
        let looked = Settings {
            physarum: reference.physarum.clone(),
            trail: reference.trail.clone(),
            picture: reference.picture.clone(),
            ..plain
        };
        assert_eq!(looked, reference, "{name}");
    }
}

fn name_of(path: &Path) -> String {
    let name = path.file_name().expect("it is a file");
    name.to_str().expect("it is text").to_owned()
}
