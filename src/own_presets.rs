//! Presets of one's own: files in the user's folder for data, each with a small picture beside it.

use std::io::Read as _;
use std::path::{Path, PathBuf};

use image::RgbaImage;
use myxo::plain_text::Shown as _;
use myxo::scene::file::Reader;
use myxo::scene::presets::is_preset;
use myxo::scene::settings::Settings;
use myxo::scene::{SceneError, builtin};
use myxo::whole_file::write_whole;
use myxo::{Error, Result};

/// The largest preset file, bytes.
const LARGEST: u64 = 64 << 10;
/// The longest name, letters.
const LONGEST_NAME: usize = 40;
/// Characters that some systems do not allow in file names.
const NOT_IN_NAMES: &str = r#"/\:*?"<>|"#;

/// A preset that the user has kept.
#[derive(Clone, Debug, PartialEq)]
pub struct Own {
    /// Its name, which is that of its file.
    pub name: String,
    /// The TOML text.
    pub text: String,
    /// Why it cannot be used, if so.
    pub problem: Option<String>,
}

/// All presets of the user.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OwnPresets {
    folder: Option<PathBuf>,
    all: Vec<Own>,
}

impl OwnPresets {
    /// Their folder; `None` if the user has no folder for data.
    pub fn folder() -> Option<PathBuf> {
        directories::ProjectDirs::from("", "", "myxo").map(|dirs| dirs.data_dir().join("presets"))
    }

    /// Reads a folder, which need not exist.
    pub fn read(folder: Option<PathBuf>) -> Self {
        let mut all: Vec<Own> = folder.iter().flat_map(|folder| files(folder)).collect();
        all.sort_by_key(|own| own.name.to_lowercase());
        Self { folder, all }
    }

    /// Reads the folder again, for changes by other windows and programs.
    pub fn read_again(&mut self) {
        *self = Self::read(self.folder.take());
    }

    /// In the order of their names.
    pub fn all(&self) -> &[Own] {
        &self.all
    }

    /// The one with this name.
    pub fn find(&self, name: &str) -> Option<&Own> {
        self.all.iter().find(|own| own.name == name)
    }

    /// The path of its small picture, which may be missing.
    pub fn picture(&self, name: &str) -> Option<PathBuf> {
        Some(self.path(name)?.with_extension("png"))
    }

    fn path(&self, name: &str) -> Option<PathBuf> {
        Some(self.folder.as_ref()?.join(format!("{name}.toml")))
    }

    /// Saves a preset; one of the same name is replaced.
    pub fn save(&mut self, name: &str, text: &str, picture: &RgbaImage) -> Result<PathBuf> {
        let name = check_name(name).map_err(Error::Invalid)?;
        let Some(path) = self.path(name) else {
            return Err(Error::Invalid(
                "no preset can be kept: there is no folder for your data (is HOME set?)".to_owned(),
            ));
        };
        write(&path, text.as_bytes())?;
        let mut bytes = Vec::new();
        let encoder = image::codecs::png::PngEncoder::new(&mut bytes);
        let encoded = picture.write_with_encoder(encoder);
        let encoded = encoded.map_err(std::io::Error::other).map(|()| bytes);
        let file = path.with_extension("png");
        let bytes = encoded.map_err(Error::io("write", &file))?;
        write(&file, &bytes)?;
        self.read_again();
        Ok(path)
    }

    /// Removes one, with its picture.
    pub fn remove(&mut self, name: &str) -> Result<()> {
        if let (Some(path), Some(_)) = (self.path(name), self.find(name)) {
            let removed = std::fs::remove_file(&path);
            removed.map_err(Error::io("remove", &path))?;
            // It may have no picture.
            let _ = std::fs::remove_file(path.with_extension("png"));
        }
        self.read_again();
        Ok(())
    }
}

/// The settings with a preset applied.
pub fn with_preset(settings: &Settings, name: &str, text: &str) -> Result<Settings> {
    let mut reader = Reader::new(settings.clone());
    reader.preset("", text);
    Ok(reader.finish().map_err(|problems| SceneError::Problems {
        scene: format!("preset {name}").into(),
        problems,
    })?)
}

/// What a preset is, in a sentence: the comment at its beginning, if it has one.
pub fn summary(text: &str) -> &str {
    let first = text.lines().next().unwrap_or("");
    first.strip_prefix('#').unwrap_or("").trim()
}

/// The trimmed name, if a file can have it and no built-in preset has it.
pub fn check_name(name: &str) -> Result<&str, String> {
    let name = name.trim();
    if name.is_empty() {
        return Err("a preset needs a name".to_owned());
    }
    if name.chars().count() > LONGEST_NAME {
        return Err(format!(
            "the name is too long: {LONGEST_NAME} letters are the most"
        ));
    }
    if let Some(letter) = name
        .chars()
        .find(|c| c.is_control() || NOT_IN_NAMES.contains(*c))
    {
        return Err(format!(
            "{letter:?} cannot be in the name, because names of files cannot contain it"
        ));
    }
    if name.starts_with('.') || name.ends_with('.') {
        return Err("the name can neither begin nor end with a full stop".to_owned());
    }
    if builtin::preset(name).is_some() {
        return Err(format!(
            "{name} comes with the program: choose another name"
        ));
    }
    Ok(name)
}

/// The text of a small file; `None` if it is no regular file, is too large or cannot be read.
fn small_text(path: &Path) -> Option<String> {
    // Reading a pipe would wait for a writer.
    if !path.metadata().ok()?.is_file() {
        return None;
    }
    let file = std::fs::File::open(path).ok()?;
    let mut text = String::new();
    file.take(LARGEST + 1).read_to_string(&mut text).ok()?;
    (text.len() as u64 <= LARGEST).then_some(text)
}

/// The text of a file that looks like a preset, judged without loading its settings.
pub fn preset_in(path: &Path) -> Option<String> {
    let ending = path.extension()?;
    if !ending.eq_ignore_ascii_case("toml") {
        return None;
    }
    small_text(path).filter(|text| is_preset(text))
}

/// Every `.toml` file of a folder.
fn files(folder: &Path) -> Vec<Own> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let presets = entries.filter_map(|entry| {
        let path = entry.path();
        let name = path.file_stem()?.to_str()?.to_owned();
        if path.extension()? != "toml" || name.starts_with('.') {
            return None;
        }
        let text = small_text(&path);
        let problem = match &text {
            None => Some(format!("{} cannot be read as text", path.shown())),
            Some(_) if builtin::preset(&name).is_some() => Some(format!(
                "a preset that comes with the program is called {name}, too: rename {}",
                path.shown()
            )),
            Some(text) => with_preset(&Settings::default(), &name, text)
                .err()
                .map(|error| error.to_string()),
        };
        let text = text.unwrap_or_default();
        Some(Own {
            name,
            text,
            problem,
        })
    });
    presets.collect()
}

fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    write_whole(path, bytes).map_err(Error::io("write", path))
}

#[cfg(test)]
mod tests {
    use super::*;
    use myxo::scene::presets;

    #[test]
    fn presets_are_kept_replaced_and_removed() {
        let folder = tempfile::tempdir().unwrap();
        let below = folder.path().join("myxo/presets");
        let mut own = OwnPresets::read(Some(below.clone()));
        assert_eq!(own.all(), [], "there is no folder yet");
        let picture = RgbaImage::from_pixel(30, 20, image::Rgba([9, 99, 9, 255]));
        let mut settings = Settings::default();
        for decay in [0.5, 0.6] {
            settings.trail.decay = decay;
            let text = presets::to_toml(&settings, "Mine.");
            let path = own.save(" Moss, old ", &text, &picture).unwrap();
            assert_eq!(path, below.join("Moss, old.toml"));
            let kept = own.find("Moss, old").expect("it is listed");
            assert_eq!((kept.text.as_str(), &kept.problem), (text.as_str(), &None));
        }
        let text = presets::to_toml(&Settings::default(), "Another.");
        own.save("algae", &text, &picture).unwrap();
        let names = |own: &OwnPresets| -> Vec<String> {
            own.all().iter().map(|own| own.name.clone()).collect()
        };
        assert_eq!(names(&own), ["algae", "Moss, old"]);
        let seen = image::open(own.picture("algae").unwrap()).unwrap();
        assert_eq!(seen.into_rgba8(), picture);
        // Another window sees the same presets, and removing one there removes it here.
        let mut other = OwnPresets::read(Some(below.clone()));
        assert_eq!(other, own);
        other.remove("algae").unwrap();
        other.remove("algae").unwrap();
        own.read_again();
        assert_eq!(names(&own), ["Moss, old"]);
        assert_eq!(std::fs::read_dir(&below).unwrap().count(), 2);
        assert!(OwnPresets::read(None).save("x", &text, &picture).is_err());
        // If a file has the name of the folder, saving fails.
        let mut wrong = OwnPresets::read(Some(below.join("Moss, old.toml")));
        assert_eq!(wrong.all(), []);
        let error = wrong.save("x", &text, &picture).unwrap_err().to_string();
        assert!(error.contains("x.toml"), "{error}");
    }

    #[test]
    fn broken_files_are_listed_with_their_problem() {
        let folder = tempfile::tempdir().unwrap();
        let put = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes);
        put("a.toml", b"[trail]\ndecay = 2\n").unwrap();
        put("b.toml", &[0xff, 0xfe]).unwrap();
        put("c.toml", "#".repeat(LARGEST as usize + 1).as_bytes()).unwrap();
        put("d.toml", b"[trail]\ndecay = 0.5\n").unwrap();
        put("e.txt", b"[trail]\ndecay = 0.5\n").unwrap();
        std::fs::create_dir(folder.path().join("f.toml")).unwrap();
        let own = OwnPresets::read(Some(folder.path().to_owned()));
        let listed: Vec<(&str, bool)> = own
            .all()
            .iter()
            .map(|own| (own.name.as_str(), own.problem.is_some()))
            .collect();
        let expected = [
            ("a", true),
            ("b", true),
            ("c", true),
            ("d", false),
            ("f", true),
        ];
        assert_eq!(listed, expected);
        let problem = own.find("a").unwrap().problem.as_ref().unwrap();
        assert!(
            problem.contains("line 2") && problem.contains("0 to 1"),
            "{problem}"
        );
        assert_eq!(preset_in(&folder.path().join("b.toml")), None);
        assert_eq!(preset_in(&folder.path().join("e.txt")), None);
        assert!(
            preset_in(&folder.path().join("a.toml")).is_some(),
            "it is one, and wrong"
        );
    }

    #[test]
    fn names_must_be_valid_file_names() {
        assert_eq!(check_name("  my look 2 "), Ok("my look 2"));
        for name in [
            "", " ", "cells", "a/b", "a\\b", "..", ".hidden", "x.", "a\nb", "a:b",
        ] {
            assert!(check_name(name).is_err(), "{name:?}");
        }
        assert!(check_name(&"ä".repeat(LONGEST_NAME)).is_ok());
        assert!(check_name(&"ä".repeat(LONGEST_NAME + 1)).is_err());
    }
}
