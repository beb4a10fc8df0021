//! Files that commands write: opened before long work begins, and never seen half written under their final names.

use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use myxo::whole_file::WholeFile;
use myxo::{Error, Result};

use super::console;

/// Where data goes that an option names: a file, or `-` for the standard output.
#[derive(Debug)]
pub struct Sink {
    path: PathBuf,
    target: Target,
}

#[derive(Debug)]
enum Target {
    Stdout,
    Whole(WholeFile),
    /// A pipe or a device such as `/dev/stderr`, which must not be replaced by a file.
    Special(File),
}

impl Sink {
    /// Opens it; a file's folder is made where it is missing.
    pub fn create(path: &Path) -> Result<Self> {
        let unwritable = |source| Error::Io {
            action: "write",
            path: path.to_owned(),
            source,
        };
        let special = path
            .metadata()
            .is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir());
        let target = if path.as_os_str() == "-" {
            Target::Stdout
        } else if special {
            Target::Special(File::options().write(true).open(path).map_err(unwritable)?)
        } else {
            Target::Whole(WholeFile::create(path).map_err(unwritable)?)
        };
        Ok(Self {
            path: path.to_owned(),
            target,
        })
    }

    /// Writes everything and ends it.
    pub fn write(self, content: impl AsRef<[u8]>) -> Result<()> {
        let content = content.as_ref();
        let written = match self.target {
            Target::Stdout => return console::print(content),
            Target::Special(mut file) => file.write_all(content),
            Target::Whole(mut file) => file
                .write_all(content)
                .and_then(|()| file.finish().map(|_| ())),
        };
        written.map_err(|source| Error::Io {
            action: "write",
            path: self.path,
            source,
        })
    }
}

/// Makes sure that `path` is a file that can be opened for reading.
pub fn check_readable(path: &Path) -> Result<()> {
    let unreadable = |source| Error::Io {
        action: "read",
        path: path.to_owned(),
        source,
    };
    let metadata = path.metadata().map_err(unreadable)?;
    if metadata.is_dir() {
        return Err(unreadable(std::io::ErrorKind::IsADirectory.into()));
    }
    // Opening a pipe may wait for ever.
    if !metadata.is_file() {
        let problem = std::io::Error::other("it is not a regular file");
        return Err(unreadable(problem));
    }
    File::open(path).map_err(unreadable)?;
    Ok(())
}

/// Makes sure that `path` can be written later, and leaves nothing there.
pub fn check_writable(path: &Path) -> Result<()> {
    WholeFile::create(path).map_err(|source| Error::Io {
        action: "write",
        path: path.to_owned(),
        source,
    })?;
    Ok(())
}

/// Refuses files that would overwrite each other.
pub fn check_distinct<'a>(paths: impl Iterator<Item = &'a PathBuf>) -> Result<()> {
    let mut seen = std::collections::BTreeSet::new();
    for path in paths {
        if !seen.insert(std::path::absolute(path).unwrap_or_else(|_| path.clone())) {
            return Err(Error::Invalid(format!(
                "{} is named twice: give each file its own name",
                path.display()
            )));
        }
    }
    Ok(())
}
