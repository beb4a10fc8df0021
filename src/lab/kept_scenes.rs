//! Scenes that were left with changes that no file has: the last few of them, in the user's folder for data.

use std::path::{Path, PathBuf};
use std::time::SystemTime;
use std::{fs, io};

use image::RgbaImage;
use image::codecs::png::PngEncoder;
use myxo::sim::areas::map_beside;
use myxo::whole_file::write_whole;
use myxo::{Error, Result};

use crate::lab::saving::{name_in, save_scene};

/// Files that are kept; the oldest go.
const MOST: usize = 8;

/// One of them.
#[derive(Clone, Debug, PartialEq)]
pub struct KeptScene {
    /// The scene's name.
    pub name: String,
    /// The scene file.
    pub file: PathBuf,
    /// When it was left.
    pub since: SystemTime,
}

/// All of them, the last one first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KeptScenes {
    folder: Option<PathBuf>,
    all: Vec<KeptScene>,
}

impl KeptScenes {
    /// Reads the scenes in a folder, which need not exist.
    pub fn read(folder: Option<PathBuf>) -> Self {
        let mut all: Vec<KeptScene> = folder.iter().flat_map(|folder| files(folder)).collect();
        all.sort_by_key(|left| std::cmp::Reverse(left.since));
        Self { folder, all }
    }

    /// Takes up what other windows have left.
    pub fn read_again(&mut self) {
        *self = Self::read(self.folder.take());
    }

    /// The last one first.
    pub fn all(&self) -> &[KeptScene] {
        &self.all
    }

    /// Keeps a scene's text, which may have a map of areas beside it.
    pub fn keep(
        &mut self,
        name: &str,
        text: impl FnOnce(&Path) -> Result<String>,
    ) -> Result<PathBuf> {
        let Some(folder) = &self.folder else {
            return Err(Error::Invalid(format!(
                "{name} as you left it is not kept: there is no folder for your data (is HOME set?)"
            )));
        };
        let file = save_scene(folder, name, text)?;
        self.read_again();
        // Whatever the clock says, this one is the last.
        let place = self.all.iter().position(|left| left.file == file);
        let first = place.map_or(0, |place| place + 1);
        self.all[..first].rotate_right(usize::from(first > 0));
        for old in self.all.drain(MOST.min(self.all.len())..) {
            // Another window may have removed them.
            let _ = fs::remove_file(map_beside(&old.file));
            let _ = fs::remove_file(picture_beside(&old.file));
            let _ = fs::remove_file(old.file);
        }
        Ok(file)
    }

    /// Keeps a small picture beside the file of a scene.
    pub fn keep_picture(file: &Path, picture: &RgbaImage) -> Result<()> {
        let file = picture_beside(file);
        let mut bytes = Vec::new();
        let encoded = picture.write_with_encoder(PngEncoder::new(&mut bytes));
        let encoded = encoded.map_err(io::Error::other);
        let written = encoded.and_then(|()| write_whole(&file, &bytes));
        written.map_err(Error::io("write", file))
    }

    /// The scene is shown again, so it is no longer the next one to be removed.
    pub fn opened(left: &KeptScene) {
        let touched = fs::File::options().append(true).open(&left.file);
        // Without a right to do so it stays as old as it is.
        let _ = touched.and_then(|file| file.set_modified(SystemTime::now()));
    }
}

/// The path of a scene's small picture.
pub fn picture_beside(file: &Path) -> PathBuf {
    file.with_extension("png")
}

fn files(folder: &Path) -> Vec<KeptScene> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let scene = |entry: fs::DirEntry| {
        let file = entry.path();
        Some(KeptScene {
            name: name_in(&file)?,
            since: entry.metadata().ok()?.modified().ok()?,
            file,
        })
    };
    entries.filter_map(scene).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_ones_are_kept_and_nothing_else_is_touched() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("left");
        let mut left = KeptScenes::read(Some(folder.clone()));
        assert!(left.all().is_empty());
        for seed in 0..MOST + 3 {
            let name = if seed % 2 == 0 { "a_b" } else { "c" };
            let file = left.keep(name, |file| {
                fs::write(map_beside(file), "a map").unwrap();
                Ok(format!("seed = {seed}\n"))
            });
            let file = file.unwrap();
            KeptScenes::keep_picture(&file, &RgbaImage::new(3, 2)).unwrap();
            assert_eq!(left.all()[0].file, file, "the last one comes first");
            assert_eq!(left.all()[0].name, name);
            // The clock of files goes in steps: what comes next is later than this.
            let written = || {
                fs::write(folder.join("../clock"), "").unwrap();
                let file = fs::metadata(folder.join("../clock")).unwrap();
                file.modified().unwrap()
            };
            let begun = written();
            while written() <= begun {
                std::thread::yield_now();
            }
            fs::write(folder.join("mine.toml"), "mine").unwrap();
            fs::write(folder.join("notes_.toml"), "mine").unwrap();
        }
        assert_eq!(left.all().len(), MOST);
        assert_eq!(KeptScenes::read(Some(folder.clone())), left);
        let texts = left
            .all()
            .iter()
            .map(|left| fs::read_to_string(&left.file).unwrap());
        let wanted = (3..MOST + 3).rev().map(|seed| format!("seed = {seed}\n"));
        assert!(texts.eq(wanted));
        // Each has its map and its picture.
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 3 * MOST + 2);
        for left in left.all() {
            let picture = image::open(picture_beside(&left.file)).unwrap();
            assert_eq!((picture.width(), picture.height()), (3, 2));
        }

        // The oldest is shown again and another scene is left: the shown one is not removed.
        let oldest = left.all().last().unwrap().clone();
        KeptScenes::opened(&oldest);
        left.keep("c", |_| Ok(String::new())).unwrap();
        assert!(oldest.file.exists() && left.all().len() == MOST);

        let error = KeptScenes::default().keep("torus", |_| Ok(String::new()));
        let error = error.unwrap_err();
        assert!(error.to_string().contains("torus"), "{error}");
    }
}
