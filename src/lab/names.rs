//! Names of exported files: numbered and never over another, also if several windows write to one folder.

use std::fs::{self, File};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use myxo::sim::areas::map_beside;
use myxo::{Error, Result};

/// A file name that is reserved as long as this value lives.
#[derive(Debug)]
pub struct Reserved {
    path: PathBuf,
    /// A hidden, empty file beside it.
    mark: PathBuf,
}

impl Reserved {
    /// `stem_000001.ending` in the folder, which is made if it does not exist, or the next number that is free; without an
    /// ending a folder's name.
    pub fn next(folder: &Path, stem: &str, ending: &str) -> Result<Self> {
        if !folder.as_os_str().is_empty() {
            fs::create_dir_all(folder).map_err(Error::io("write", folder))?;
        }
        let dot = if ending.is_empty() { "" } else { "." };
        for number in 1.. {
            let name = format!("{stem}_{number:06}{dot}{ending}");
            let path = folder.join(&name);
            // A scene that is gone may have left its map.
            let map = map_beside(&path);
            if path.exists() || ending == "toml" && map.exists() {
                continue;
            }
            let mark = folder.join(format!(".{name}.taken"));
            match File::create_new(&mark) {
                Ok(_) => {}
                Err(error) if error.kind() == ErrorKind::AlreadyExists => continue,
                Err(error) => return Err(Error::io("write", path)(error)),
            }
            let reserved = Self { path, mark };
            // The previous owner of the mark may have written the file just now.
            if !reserved.path.exists() {
                return Ok(reserved);
            }
        }
        unreachable!("numbers do not end")
    }

    /// The name.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The path with a separator at its end, for writers that recognize folders by it.
    pub fn as_folder(&self) -> PathBuf {
        self.path.join("")
    }
}

impl Drop for Reserved {
    fn drop(&mut self) {
        // Nothing depends on it but a number.
        let _ = fs::remove_file(&self.mark);
    }
}

/// A name without the number of [`Reserved::next`] at its end, if it has one: a file made from a saved file has the next
/// number, and not two numbers.
pub fn unnumbered(name: &str) -> &str {
    match name.rsplit_once('_') {
        Some((stem, number))
            if !stem.is_empty()
                && number.len() == 6
                && number.bytes().all(|byte| byte.is_ascii_digit()) =>
        {
            stem
        }
        _ => name,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_continue_and_do_not_add_up() {
        for (name, stem) in [
            ("mine_000001", "mine"),
            ("mine", "mine"),
            ("mine_2024", "mine_2024"),
            ("my_own_123456", "my_own"),
            ("_000001", "_000001"),
            ("a_00000b", "a_00000b"),
        ] {
            assert_eq!(unnumbered(name), stem);
        }
    }

    #[test]
    fn names_are_free_and_reserved_once() {
        let folder = tempfile::tempdir().unwrap();
        let below = folder.path().join("new/pictures");
        let next = || Reserved::next(&below, "film", "mp4").unwrap();
        let (first, second) = (next(), next());
        assert!(first.path().ends_with("film_000001.mp4"));
        assert!(second.path().ends_with("film_000002.mp4"));
        fs::write(second.path(), "it").unwrap();
        drop((first, second));
        assert!(next().path().ends_with("film_000001.mp4"));
        fs::write(below.join("film_000001.mp4"), "it").unwrap();
        assert!(next().path().ends_with("film_000003.mp4"));
        fs::write(below.join("a_000001_areas.png"), "of a scene that is gone").unwrap();
        let scene = Reserved::next(&below, "a", "toml").unwrap();
        assert!(scene.path().ends_with("a_000002.toml"));
        drop(scene);
        let frames = Reserved::next(&below, "film", "").unwrap();
        assert!(
            frames
                .as_folder()
                .to_string_lossy()
                .ends_with("film_000001/")
        );
        drop(frames);
        let left = fs::read_dir(&below).unwrap().count();
        assert_eq!(left, 3, "marks are gone");
        let file = below.join("film_000001.mp4");
        let error = Reserved::next(&file, "film", "mp4").unwrap_err();
        assert!(error.to_string().contains("film_000001.mp4"), "{error}");
    }

    #[test]
    fn many_threads_take_different_names() {
        let folder = tempfile::tempdir().unwrap();
        let threads: Vec<_> = (0..8)
            .map(|_| {
                let folder = folder.path().to_owned();
                std::thread::spawn(move || {
                    (0..20)
                        .map(|_| {
                            let name = Reserved::next(&folder, "shot", "png").unwrap();
                            File::create_new(name.path()).expect("the name is free");
                        })
                        .count()
                })
            })
            .collect();
        for thread in threads {
            assert_eq!(thread.join().unwrap(), 20);
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 160);
    }
}
