//! Scene files that the lab writes, numbered, none over another.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use myxo::whole_file::WholeFile;
use myxo::{Error, Result};

use super::out::Reserved;

/// Saves a scene's text, named after the scene.
pub fn save_scene(folder: &Path, name: &str, text: &str) -> Result<PathBuf> {
    let name = Reserved::next(folder, name, "toml")?;
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
        let first = save_scene(folder.path(), "torus", "seed = 1\n").unwrap();
        let second = save_scene(folder.path(), "torus", "seed = 2\n").unwrap();
        assert!(first.ends_with("torus_000001.toml") && second.ends_with("torus_000002.toml"));
        assert_eq!(std::fs::read_to_string(&second).unwrap(), "seed = 2\n");
        let error = save_scene(&second, "torus", "").unwrap_err();
        assert!(error.to_string().contains("torus_000002.toml"), "{error}");
    }
}
