//! Files that commands write: checked before long work begins, and never seen half written under their final names.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use myxo::{Error, Result};

/// Makes sure that `path` can be written later: its folder is made where it is missing, and a file is created there
/// and removed again.
pub fn check_writable(path: &Path) -> Result<()> {
    if path.is_dir() {
        return Err(Error::Invalid(format!("cannot write {}: it is a folder, name a file in it", path.display())));
    }
    let folder = folder_of(path);
    std::fs::create_dir_all(&folder)
        .map_err(|source| Error::Io { action: "create the folder", path: folder.clone(), source })?;
    tempfile::NamedTempFile::new_in(&folder)
        .map_err(|source| Error::Io { action: "write into the folder", path: folder, source })?;
    Ok(())
}

/// Makes sure that `path` is a file that can be opened for reading.
pub fn check_readable(path: &Path) -> Result<()> {
    let unreadable = |source| Error::Io { action: "read", path: path.to_owned(), source };
    let file = std::fs::File::open(path).map_err(unreadable)?;
    if file.metadata().map_err(unreadable)?.is_dir() {
        return Err(Error::Invalid(format!("cannot read {}: it is a folder", path.display())));
    }
    Ok(())
}

/// Writes a whole file, or leaves what was there: a temporary file beside it takes its name when all is written.
pub fn write(path: &Path, content: &[u8]) -> Result<()> {
    let unwritable = |source| Error::Io { action: "write", path: path.to_owned(), source };
    // Devices and pipes such as /dev/stdout are written to, not replaced.
    if path.metadata().is_ok_and(|metadata| !metadata.is_file()) {
        return std::fs::write(path, content).map_err(unwritable);
    }
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        // Temporary files are private by default, and reports are for others to read.
        use std::os::unix::fs::PermissionsExt as _;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder_of(path)).map_err(unwritable)?;
    file.write_all(content).map_err(unwritable)?;
    file.persist(path).map_err(|error| unwritable(error.error))?;
    Ok(())
}

fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_whole_and_nothing_is_left_beside_it() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("deep/er/report.json");
        check_writable(&path).expect("missing folders are made");
        assert!(!path.exists(), "checking writes nothing under the final name");
        write(&path, b"one").expect("it can be written");
        write(&path, b"two").expect("it can be replaced");
        assert_eq!(std::fs::read(&path).expect("it is there"), b"two");
        assert_eq!(std::fs::read_dir(path.parent().expect("it has one")).expect("a folder").count(), 1);
    }

    #[test]
    fn folders_that_cannot_be_are_errors() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let file = folder.path().join("file");
        write(&file, b"").expect("it can be written");
        let message = check_writable(&file.join("x.png")).expect_err("a file is no folder").to_string();
        assert!(message.starts_with("cannot create the folder "), "{message}");
        let message = check_writable(folder.path()).expect_err("a folder is no file").to_string();
        assert!(message.contains("is a folder"), "{message}");
    }
}
