//! Files of a cache: what took long to compute once is read the next time.
//!
//! A file's name is a hash of all that its content depends on. It holds a magic word, a checksum and the content. A file that is
//! damaged, or of another program, counts as none and is replaced; nothing here can make the program fail.

use std::fs;
use std::hash::{DefaultHasher, Hasher};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use bytemuck::Pod;

use crate::whole_file::WholeFile;

/// Beyond so many bytes, or files, the least recently used files are removed.
const MOST_BYTES: u64 = 256 << 20;
const MOST_FILES: usize = 128;
/// Another process may still be writing a hidden file that is younger.
const ABANDONED_AFTER: Duration = Duration::from_secs(3600);

/// What a file holds.
#[derive(Debug)]
pub(crate) struct Kind {
    /// In messages.
    name: &'static str,
    ending: &'static str,
    /// With the version of the format.
    magic: &'static [u8; 8],
}

/// Where triangles lie in an atlas.
pub(crate) const LAYOUTS: Kind = Kind {
    name: "atlas",
    ending: "atlas",
    magic: b"MYXOAT01",
};

/// How much of the sky the corners of triangles see.
pub(crate) const OCCLUSION: Kind = Kind {
    name: "ambient occlusion",
    ending: "light",
    magic: b"MYXOLI01",
};

const KINDS: [&Kind; 2] = [&LAYOUTS, &OCCLUSION];

/// A file of a cache, which may exist.
#[derive(Debug)]
pub(crate) struct KeptFile {
    folder: PathBuf,
    path: PathBuf,
    kind: &'static Kind,
}

impl KeptFile {
    /// The file for content that depends on what the key is the hash of.
    pub fn new(folder: &Path, key: u128, kind: &'static Kind) -> Self {
        Self {
            folder: folder.to_owned(),
            path: folder.join(format!("{key:032x}.{}", kind.ending)),
            kind,
        }
    }

    /// Where it lies.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What `unpack` makes of the content, if the file is whole.
    pub fn load<T>(&self, unpack: impl FnOnce(&[u8]) -> Option<T>) -> Option<T> {
        let bytes = fs::read(&self.path).ok()?;
        let found = content(&bytes, self.kind).and_then(unpack);
        match &found {
            // Updates the time of use, by which old files are removed. If the system refuses, the time of creation counts.
            Some(_) => drop(
                fs::File::open(&self.path).and_then(|file| file.set_modified(SystemTime::now())),
            ),
            None => log::debug!("{} is damaged or of another program", self.path.display()),
        }
        found
    }

    /// Stores the content. The file is complete or absent at every moment, even if other processes write it, too.
    pub fn store(&self, content: &[u8]) {
        let written = WholeFile::create(&self.path).and_then(|mut file| {
            file.write_all(self.kind.magic)?;
            file.write_all(&crc32fast::hash(content).to_le_bytes())?;
            file.write_all(content)?;
            file.finish_or_discard()
        });
        if let Err(error) = written {
            log::warn!(
                "cannot keep the {} in {}: {error}; the next start takes as long",
                self.kind.name,
                self.path.display()
            );
        }
        if let Err(error) = tidy(&self.folder, MOST_BYTES, MOST_FILES) {
            log::debug!("cannot tidy {}: {error}", self.folder.display());
        }
    }
}

/// What follows the magic word and the checksum, if both are right.
fn content<'a>(bytes: &'a [u8], kind: &Kind) -> Option<&'a [u8]> {
    let (magic, rest) = bytes.split_first_chunk::<8>()?;
    let (sum, content) = rest.split_first_chunk::<4>()?;
    (magic == kind.magic && u32::from_le_bytes(*sum) == crc32fast::hash(content)).then_some(content)
}

/// Two hashes of 64 bits that begin differently: 128 bits, so that no two contents ever meet.
pub(crate) struct Hash([DefaultHasher; 2]);

impl Hash {
    pub fn new() -> Self {
        let mut second = DefaultHasher::new();
        second.write_u64(0x9E37_79B9_7F4A_7C15);
        Self([DefaultHasher::new(), second])
    }

    /// With its length, so that a longer slice and a shorter one after it are not the same as these the other way.
    pub fn slice<T: Pod>(&mut self, items: &[T]) {
        for hasher in &mut self.0 {
            hasher.write_u64(items.len() as u64);
            hasher.write(bytemuck::cast_slice(items));
        }
    }

    pub fn finish(self) -> u128 {
        let [first, second] = self.0.map(|hasher| u128::from(hasher.finish()));
        first << 64 | second
    }
}

/// Removes the files used least recently until the rest is small, and unfinished files of processes that ended.
fn tidy(folder: &Path, most_bytes: u64, most_files: usize) -> io::Result<()> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let Ok(metadata) = entry.metadata() else {
            continue; // Another process has just removed it.
        };
        let modified = metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH);
        let path = entry.path();
        let ending = path.extension().and_then(|ending| ending.to_str());
        let name = entry.file_name().to_string_lossy().into_owned();
        let is_one = KINDS.iter().any(|kind| ending == Some(kind.ending));
        if is_one && metadata.is_file() {
            files.push((modified, metadata.len(), path));
        } else if name.starts_with('.')
            && KINDS.iter().any(|kind| name.contains(kind.ending))
            && modified.elapsed().is_ok_and(|age| age > ABANDONED_AFTER)
        {
            let _ = fs::remove_file(path);
        }
    }
    // The latest first; names decide where times are equal.
    files.sort_by(|a, b| b.cmp(a));
    let mut bytes = 0;
    for (i, (_, len, path)) in files.iter().enumerate() {
        bytes += len;
        // The latest stays, however large: it was needed just now.
        if i > 0 && (bytes > most_bytes || i >= most_files) {
            let _ = fs::remove_file(path);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_files_are_read_and_others_are_none() {
        let folder = tempfile::tempdir().unwrap();
        let file = KeptFile::new(&folder.path().join("deep"), 7, &OCCLUSION);
        let read = || file.load(|content| Some(content.to_vec()));
        assert_eq!(read(), None);
        let content = [1, 2, 3, 4];
        file.store(&content);
        assert_eq!(read(), Some(content.to_vec()));
        let good = fs::read(file.path()).unwrap();
        for i in 0..good.len() {
            let mut bad = good.clone();
            bad[i] ^= 1;
            fs::write(file.path(), bad).unwrap();
            assert_eq!(read(), None, "byte {i}");
            fs::write(file.path(), &good[..i]).unwrap();
            assert_eq!(read(), None, "cut at {i}");
        }
        fs::write(file.path(), &good).unwrap();
        let other = KeptFile {
            kind: &LAYOUTS,
            ..file
        };
        assert_eq!(other.load(|_| Some(())), None, "it is of another kind");
    }

    #[test]
    fn the_least_recently_used_go_first() {
        let folder = tempfile::tempdir().unwrap();
        let now = SystemTime::now();
        let file = |name: &str, bytes: usize, age: u64| {
            let path = folder.path().join(name);
            fs::write(&path, vec![0; bytes]).unwrap();
            let file = fs::File::options().write(true).open(&path).unwrap();
            file.set_modified(now - Duration::from_secs(age)).unwrap();
            path
        };
        let made: Vec<PathBuf> = (0..5)
            .map(|i| {
                file(
                    &format!("{i}.{}", ["atlas", "light"][i as usize % 2]),
                    100,
                    10 * i,
                )
            })
            .collect();
        let foreign = file("pipelines.bin", 1000, 1_000_000);
        let young = file(".5.atlas.abc.part", 1000, 60);
        let abandoned = file(".6.atlas.abc.part", 1000, 7200);
        let left = || -> Vec<bool> { made.iter().map(|path| path.exists()).collect() };

        tidy(folder.path(), 1000, 4).unwrap();
        assert_eq!(left(), [true, true, true, true, false]);
        assert!(foreign.exists() && young.exists() && !abandoned.exists());
        tidy(folder.path(), 250, 4).unwrap();
        assert_eq!(left(), [true, true, false, false, false]);
        tidy(folder.path(), 50, 4).unwrap();
        assert_eq!(left(), [true, false, false, false, false]);
        assert!(foreign.exists());
    }
}
