//! Checkpoints: the whole state in one file, so that an interrupted run goes on and ends in the same hash.
//!
//! Layout, little-endian: the magic `MYXOCKPT`, a version (u32), the length of the header (u32), the header (JSON),
//! then particles, motions, trail and deposits as they lie in memory, then the CRC-32 of all that precedes it (u32).

use std::fs::File;
use std::io::{BufWriter, Read, Write};
use std::path::Path;

use bytemuck::Pod;
use serde::{Deserialize, Serialize};

use super::snapshot::Snapshot;
use crate::error::{Error, Result};

const MAGIC: &[u8; 8] = b"MYXOCKPT";
const VERSION: u32 = 1;

#[derive(Serialize, Deserialize)]
struct Header {
    step: u64,
    particles: u64,
    texels: u64,
    /// The scene file that it was written with.
    scene: String,
}

/// A checkpoint as it lies in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// The scene file that it was written with, as TOML.
    pub scene: String,
    /// The state.
    pub snapshot: Snapshot,
}

/// Writes to the wrapped file and keeps the checksum.
struct Checked<W> {
    inner: W,
    crc: crc32fast::Hasher,
}

impl<W: Write> Checked<W> {
    fn put(&mut self, bytes: &[u8]) -> std::io::Result<()> {
        self.crc.update(bytes);
        self.inner.write_all(bytes)
    }
}

impl Checkpoint {
    /// Writes the file. It appears under its name only when it is whole.
    ///
    /// # Errors
    /// When the folder cannot be written to or the disk is full; the file that was there before stays.
    pub fn write(&self, path: &Path) -> Result<()> {
        let error = |source| Error::Io {
            action: "write",
            path: path.to_owned(),
            source,
        };
        let folder = path
            .parent()
            .filter(|p| !p.as_os_str().is_empty())
            .unwrap_or(Path::new("."));
        let mut file = tempfile::NamedTempFile::new_in(folder).map_err(error)?;
        self.write_to(file.as_file_mut()).map_err(error)?;
        file.persist(path).map_err(|e| error(e.error))?;
        Ok(())
    }

    fn write_to(&self, file: &mut File) -> std::io::Result<()> {
        let Snapshot {
            step,
            particles,
            motions,
            trail,
            deposits,
        } = &self.snapshot;
        let header = serde_json::to_vec(&Header {
            step: *step,
            particles: particles.len() as u64,
            texels: trail.len() as u64,
            scene: self.scene.clone(),
        })?;
        let mut out = Checked {
            inner: BufWriter::new(file),
            crc: crc32fast::Hasher::new(),
        };
        out.put(MAGIC)?;
        out.put(&VERSION.to_le_bytes())?;
        out.put(&(header.len() as u32).to_le_bytes())?;
        out.put(&header)?;
        out.put(bytemuck::cast_slice(particles))?;
        out.put(bytemuck::cast_slice(motions))?;
        out.put(bytemuck::cast_slice(trail))?;
        out.put(bytemuck::cast_slice(deposits))?;
        let crc = out.crc.finalize();
        out.inner.write_all(&crc.to_le_bytes())?;
        out.inner.flush()
    }

    /// Reads a file back.
    ///
    /// # Errors
    /// When it is no checkpoint, of another version, cut short, or damaged.
    pub fn read(path: &Path) -> Result<Self> {
        let mut bytes = Vec::new();
        File::open(path)
            .and_then(|mut file| file.read_to_end(&mut bytes))
            .map_err(|source| Error::Io {
                action: "read",
                path: path.to_owned(),
                source,
            })?;
        Self::parse(&bytes).map_err(|problem| {
            Error::Invalid(format!("cannot resume from {}: {problem}", path.display()))
        })
    }

    fn parse(bytes: &[u8]) -> Result<Self, String> {
        let cut_short = || "the file is cut short: it was not written to its end".to_owned();
        if bytes.get(..MAGIC.len()) != Some(MAGIC) {
            return Err("it is not a checkpoint of myxo".to_owned());
        }
        let mut rest = &bytes[MAGIC.len()..];
        let version = u32::from_le_bytes(
            take(&mut rest, 4)
                .ok_or_else(cut_short)?
                .try_into()
                .expect("4 bytes"),
        );
        if version != VERSION {
            return Err(format!(
                "it has version {version}, this program reads version {VERSION}"
            ));
        }
        let Some((body, crc)) = bytes.split_last_chunk::<4>() else {
            return Err(cut_short());
        };
        let length = u32::from_le_bytes(
            take(&mut rest, 4)
                .ok_or_else(cut_short)?
                .try_into()
                .expect("4 bytes"),
        );
        let header = take(&mut rest, length as usize).ok_or_else(cut_short)?;
        if crc32fast::hash(body) != u32::from_le_bytes(*crc) {
            return Err("its checksum is wrong: the file is damaged or cut short".to_owned());
        }
        let header: Header =
            serde_json::from_slice(header).map_err(|e| format!("its header is damaged: {e}"))?;
        let checkpoint = Self {
            scene: header.scene,
            snapshot: Snapshot {
                step: header.step,
                particles: array(&mut rest, header.particles).ok_or_else(cut_short)?,
                motions: array(&mut rest, header.particles).ok_or_else(cut_short)?,
                trail: array(&mut rest, header.texels).ok_or_else(cut_short)?,
                deposits: array(&mut rest, header.texels).ok_or_else(cut_short)?,
            },
        };
        if rest.len() != crc.len() {
            return Err(format!("it has {} bytes too many", rest.len() - crc.len()));
        }
        Ok(checkpoint)
    }
}

fn take<'a>(rest: &mut &'a [u8], length: usize) -> Option<&'a [u8]> {
    let (head, tail) = rest.split_at_checked(length)?;
    *rest = tail;
    Some(head)
}

fn array<T: Pod>(rest: &mut &[u8], length: u64) -> Option<Vec<T>> {
    let bytes = usize::try_from(length).ok()?.checked_mul(size_of::<T>())?;
    Some(bytemuck::pod_collect_to_vec(take(rest, bytes)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sim::types::{Motion, Particle};

    fn checkpoint() -> Checkpoint {
        Checkpoint {
            scene: "seed = 9\n".to_owned(),
            snapshot: Snapshot {
                step: 41,
                particles: (0..33)
                    .map(|id| Particle {
                        triangle: id,
                        u: 0.125,
                        v: 0.5,
                        id,
                    })
                    .collect(),
                motions: vec![
                    Motion {
                        heading_p: 0.6,
                        heading_h: 0.8,
                        pending: 0.0,
                        flags: 0
                    };
                    33
                ],
                trail: (0..55).map(|i| i as f32 * 0.1).collect(),
                deposits: (0..55).collect(),
            },
        }
    }

    #[test]
    fn what_is_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("state.ckpt");
        checkpoint().write(&path).unwrap();
        assert_eq!(Checkpoint::read(&path).unwrap(), checkpoint());
        assert_eq!(
            std::fs::read_dir(folder.path()).unwrap().count(),
            1,
            "no temporary file stays"
        );
    }

    #[test]
    fn damage_is_found_and_said() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("state.ckpt");
        checkpoint().write(&path).unwrap();
        let whole = std::fs::read(&path).unwrap();
        for (name, bytes, expected) in [
            ("cut", whole[..whole.len() - 9].to_vec(), "checksum"),
            ("short", whole[..10].to_vec(), "cut short"),
            (
                "other",
                b"PNG or so, surely long enough".to_vec(),
                "not a checkpoint",
            ),
            (
                "bit",
                {
                    let mut b = whole.clone();
                    b[200] ^= 1;
                    b
                },
                "checksum",
            ),
            (
                "version",
                {
                    let mut b = whole.clone();
                    b[8] = 9;
                    b
                },
                "version 9",
            ),
        ] {
            let problem = Checkpoint::parse(&bytes).unwrap_err();
            assert!(problem.contains(expected), "{name}: {problem}");
        }
    }
}
