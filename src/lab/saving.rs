//! Scene files that the lab writes: numbered, none over another, or by a name that somebody chose.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use myxo::whole_file::WholeFile;
use myxo::{Error, Result};

use super::out::Reserved;

/// Saves a scene's text, named after the scene. What makes the text knows the file's path, and may put others beside it.
pub fn save_scene(
    folder: &Path,
    name: &str,
    text: impl FnOnce(&Path) -> Result<String>,
) -> Result<PathBuf> {
    let name = Reserved::next(folder, name, "toml")?;
    write_scene(name.path(), text)
}

/// The same into this file, in the place of one that is there.
pub fn write_scene(path: &Path, text: impl FnOnce(&Path) -> Result<String>) -> Result<PathBuf> {
    let text = text(path)?;
    let written = WholeFile::create(path).and_then(|mut file| {
        file.write_all(text.as_bytes())?;
        file.finish()
    });
    written.map_err(|source| Error::Io {
        action: "write",
        path: path.to_owned(),
        source,
    })?;
    Ok(path.to_owned())
}

/// What somebody chose, with the ending of scene files.
///
/// # Errors
/// When it had no such ending, and the file with it is there already: nobody was asked about that one.
pub fn chosen(path: PathBuf) -> Result<PathBuf> {
    let has_ending = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("toml"));
    if has_ending {
        return Ok(path);
    }
    let mut with = path.into_os_string();
    with.push(".toml");
    let with = PathBuf::from(with);
    if with.exists() {
        return Err(Error::Invalid(format!(
            "{} is there already: save by its whole name to replace it",
            with.display()
        )));
    }
    Ok(with)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_numbered_and_nothing_is_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let first = save_scene(folder.path(), "torus", |_| Ok("seed = 1\n".to_owned())).unwrap();
        let second = save_scene(folder.path(), "torus", |_| Ok("seed = 2\n".to_owned())).unwrap();
        assert!(first.ends_with("torus_000001.toml") && second.ends_with("torus_000002.toml"));
        assert_eq!(std::fs::read_to_string(&second).unwrap(), "seed = 2\n");
        let named = chosen(folder.path().join("fern.v2")).unwrap();
        assert!(named.ends_with("fern.v2.toml"));
        for text in ["seed = 3\n", "seed = 4\n"] {
            write_scene(&named, |file| {
                assert_eq!(file, named);
                Ok(text.to_owned())
            })
            .unwrap();
            assert_eq!(std::fs::read_to_string(&named).unwrap(), text);
        }
        assert_eq!(chosen(named.clone()).unwrap(), named, "it was asked for");
        let error = chosen(folder.path().join("fern.v2"))
            .unwrap_err()
            .to_string();
        assert!(error.contains("fern.v2.toml is there already"), "{error}");
        let error = save_scene(&second, "torus", |_| Ok("".to_owned())).unwrap_err();
        assert!(error.to_string().contains("torus_000002.toml"), "{error}");
    }
}
