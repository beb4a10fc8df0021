//! Input files: only regular files of a bounded size are read. A pipe or a device may never end, and opening a pipe waits
//! until another program writes to it.

use std::collections::BTreeSet;
use std::fs::{File, Metadata};
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use crate::whole_file::followed;

/// Scene files and presets are text, and no longer than this.
pub const MOST_TEXT: u64 = 16 << 20;

/// Opens a regular file, and returns its length in bytes.
///
/// # Errors
/// When it cannot be opened, or is a folder, a pipe or a device.
pub fn open(path: &Path) -> io::Result<(File, u64)> {
    let metadata = path.metadata()?;
    check_kind(&metadata)?;
    if let Some(identity) = Identity::of(path)
        && let Ok(mut read) = READ.lock()
    {
        read.insert(identity);
    }
    Ok((File::open(path)?, metadata.len()))
}

fn check_kind(metadata: &Metadata) -> io::Result<()> {
    if metadata.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    if !metadata.is_file() {
        return Err(io::Error::other("it is not a regular file"));
    }
    Ok(())
}

/// The files that this process has read.
static READ: Mutex<BTreeSet<Identity>> = Mutex::new(BTreeSet::new());

/// The identity of a file, by which paths with links and `..` can be compared.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Identity(Inner);

#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Inner {
    /// Device and inode of an existing file.
    #[cfg(unix)]
    There(u64, u64),
    /// The path, without links, of a file that does not exist yet, or on systems without inodes.
    Path(PathBuf),
}

impl Identity {
    /// The identity of a file, existing or not. `None` for folders, devices and pipes, to which several outputs may go.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        let Ok(metadata) = path.metadata() else {
            let whole = std::path::absolute(followed(path).ok()?).ok()?;
            let (folder, name) = (whole.parent()?, whole.file_name()?);
            let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
            return Some(Self(Inner::Path(folder.join(name))));
        };
        if !metadata.is_file() {
            return None;
        }
        #[cfg(unix)]
        {
            use std::os::unix::fs::MetadataExt as _;
            Some(Self(Inner::There(metadata.dev(), metadata.ino())))
        }
        #[cfg(not(unix))]
        path.canonicalize().ok().map(|path| Self(Inner::Path(path)))
    }

    /// Has this process read the file?
    #[must_use]
    pub fn was_read(&self) -> bool {
        READ.lock().is_ok_and(|read| read.contains(self))
    }
}

/// Reads a regular file of at most so many bytes.
///
/// # Errors
/// As for [`open`], and when it is longer.
pub fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let (file, length) = open(path)?;
    if length > most {
        return Err(too_long(length, most));
    }
    let mut bytes = Vec::with_capacity(length as usize);
    // Some regular files have no length, such as those of /proc.
    file.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Err(too_long(bytes.len() as u64, most));
    }
    Ok(bytes)
}

/// Reads a scene file or a preset.
///
/// # Errors
/// As for [`read`], and when it is not UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    String::from_utf8(read(path, MOST_TEXT)?)
        .map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "it is not UTF-8 text"))
}

fn too_long(length: u64, most: u64) -> io::Error {
    io::Error::other(format!(
        "it has {length} bytes, and at most {most} are read"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Catches a missing check of the kind of file, with which reading the device or the pipe would not end, and of the length, with which
    /// a sparse file of a terabyte would fill the memory.
    #[test]
    #[cfg(target_os = "linux")]
    fn only_regular_files_of_a_bounded_size_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.expect("it is installed").success());
        let sparse = folder.path().join("sparse");
        File::create(&sparse).unwrap().set_len(1 << 40).unwrap();
        let binary = folder.path().join("binary");
        std::fs::write(&binary, [0xff, 0xfe, 0]).unwrap();
        for (path, words) in [
            (Path::new("/dev/zero"), "not a regular file"),
            (&pipe, "not a regular file"),
            (folder.path(), "is a directory"),
            (&sparse, "it has 1099511627776 bytes, and at most 16777216"),
            (&binary, "it is not UTF-8 text"),
            (&folder.path().join("none"), "No such file"),
        ] {
            let error = read_text(path).unwrap_err().to_string();
            assert!(error.contains(words), "{}: {error}", path.display());
        }
        assert_eq!(read(&binary, 3).unwrap(), [0xff, 0xfe, 0]);
        assert!(read(&binary, 2).is_err());
        assert!(
            read_text(Path::new("/proc/self/status"))
                .unwrap()
                .contains("Pid")
        );
    }
}
