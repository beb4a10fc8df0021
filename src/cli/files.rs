//! Files that commands write: opened before long work begins, and never seen half written under their final names.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use myxo::plain_text::Shown as _;
use myxo::regular_file::Identity;
use myxo::whole_file::WholeFile;
use myxo::{Error, Result, regular_file};

use crate::console;

/// The destination of an option: a file, or `-` for the standard output.
#[derive(Debug)]
pub struct Sink {
    path: PathBuf,
    target: Target,
}

#[derive(Debug)]
enum Target {
    Stdout,
    Whole(WholeFile),
}

impl Sink {
    /// Opens it; creates a file's folder if it is missing.
    pub fn create(path: &Path) -> Result<Self> {
        let target = if path.as_os_str() == "-" {
            Target::Stdout
        } else {
            Target::Whole(WholeFile::create(path).map_err(Error::io("write", path))?)
        };
        Ok(Self {
            path: path.to_owned(),
            target,
        })
    }

    /// Makes sure that it can be opened later, and leaves nothing there.
    pub fn check(path: &Path) -> Result<()> {
        if path.as_os_str() == "-" {
            return Ok(());
        }
        check_writable(path)
    }

    /// Writes everything and closes it.
    pub fn write(self, content: impl AsRef<[u8]>) -> Result<()> {
        let content = content.as_ref();
        let written = match self.target {
            Target::Stdout => return console::write(content),
            Target::Whole(mut file) => file
                .write_all(content)
                .and_then(|()| file.finish().map(|_| ())),
        };
        written.map_err(Error::io("write", self.path))
    }
}

/// Makes sure that `path` is a file that can be opened for reading.
pub fn check_readable(path: &Path) -> Result<()> {
    let opened = regular_file::open(path).map_err(Error::io("read", path));
    opened.map(|_| ())
}

/// Makes sure that `path` can be written later, and leaves nothing there.
pub fn check_writable(path: &Path) -> Result<()> {
    WholeFile::check(path).map_err(Error::io("write", path))
}

/// Refuses outputs that are the same file, even under different names.
pub fn check_distinct<'a>(outputs: impl Iterator<Item = &'a PathBuf>) -> Result<()> {
    let mut seen: Vec<(Identity, &Path)> = Vec::new();
    for path in outputs {
        let Some(identity) = Identity::of(path) else {
            continue;
        };
        match seen.iter().find(|(other, _)| *other == identity) {
            None => seen.push((identity, path)),
            Some((_, other)) if *other == path => {
                return Err(Error::Invalid(format!(
                    "{} is named twice: give each file its own name",
                    path.shown()
                )));
            }
            Some((_, other)) => {
                return Err(Error::Invalid(format!(
                    "{} and {} are one file: give each file its own name",
                    other.shown(),
                    path.shown()
                )));
            }
        }
    }
    Ok(())
}

/// Refuses outputs that the run has read: a scene, a model or a checkpoint would be lost. `or` ends the message with another way out.
pub fn check_unread<'a>(outputs: impl Iterator<Item = &'a PathBuf>, or: &str) -> Result<()> {
    for path in outputs {
        if Identity::of(path).is_some_and(|identity| identity.was_read()) {
            return Err(Error::Invalid(format!(
                "{} is an input of this run and would be replaced: give the output another name{or}",
                path.shown()
            )));
        }
    }
    Ok(())
}
