//! Scene files that the lab writes, numbered, none over another.

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
    let text = text(name.path())?;
    let written = WholeFile::create(name.path()).and_then(|mut file| {
        file.write_all(text.as_bytes())?;
        file.finish()
    });
    written.map_err(|source| Error::Io {
        action: "write",
        path: name.path().to_owned(),
        source,
    })?;
    Ok(name.path().to_owned())
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
        let error = save_scene(&second, "torus", |_| Ok("".to_owned())).unwrap_err();
        assert!(error.to_string().contains("torus_000002.toml"), "{error}");
    }
}
