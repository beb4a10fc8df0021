//! Checkpoints: the whole state in one file, so that an interrupted run continues and ends in the same hash.
//!
//! Layout, little-endian: the magic `MYXOCKPT`, a version (u32), the length of the header (u32), the header (JSON),
//! then the parts that `src/sim/kept.rs` lists, in that order and as they lie in memory, then the CRC-32 of all that precedes
//! it (u32).

use std::io::{BufWriter, Read as _, Write};
use std::path::Path;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::arithmetic;
use super::kept::{KEPT, Lengths};
use super::movement::SavedMovement;
use super::setup::Setup;
use super::snapshot::{FoodState, Snapshot};
use crate::error::{Error, Result};
use crate::plain_text::Shown as _;
use crate::regular_file;
use crate::scene::file::Reader;
use crate::scene::parameters::{Effect, PARAMETERS, Parameter};
use crate::scene::settings::Settings;
use crate::scene::{Overrides, Scene};
use crate::whole_file::WholeFile;

const MAGIC: &[u8; 8] = b"MYXOCKPT";
/// The earliest version that is read. Its files lack live pulses and second looks, which came with version 7, and populations and the
/// places of restarts, which came with version 8.
const OLDEST: u32 = 6;
/// The version of files that are written, also of those without later parts: earlier programs could not read these either, because the
/// scene in them has every key, and programs refuse keys that came later.
const VERSION: u32 = 8;

#[derive(Serialize, Deserialize)]
struct Header {
    step: u64,
    /// Elements of each section.
    #[serde(flatten)]
    lengths: Lengths,
    fed_deposit: u32,
    /// Bits of doubles; older versions counted everything from zero.
    #[serde(default)]
    origin: [u64; 3],
    /// The scene file that it was written with.
    scene: String,
    layout: u32,
    /// Absent in checkpoints of earlier versions.
    #[serde(default)]
    arithmetic: u32,
    movement: SavedMovement,
}

/// A checkpoint as it lies in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// The scene file that it was written with, as TOML.
    pub scene: String,
    /// A hash of the surface and the atlas: particles and texels are valid on these only.
    pub layout: u32,
    /// The [arithmetic](arithmetic::VERSION) that it was written with; 0 by earlier versions.
    pub arithmetic: u32,
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
    /// A state of a simulation of `scene`.
    #[must_use]
    pub fn new(scene: &Scene, setup: &Setup, snapshot: Snapshot) -> Self {
        Self {
            scene: scene.to_toml(),
            layout: layout(setup),
            arithmetic: arithmetic::VERSION,
            snapshot,
        }
    }

    /// Checks that a simulation of `scene` can continue from here. Returns notes on settings that differ and take effect from now on,
    /// such as `trail.decay = 0.9, which was 0.95`, and a note if the checkpoint was written with other arithmetic.
    ///
    /// # Errors
    /// Names what differs and cannot, or what is wrong with the state.
    pub fn check(&self, scene: &Scene, setup: &Setup) -> Result<Vec<String>, String> {
        let same_layout = self.layout == layout(setup);
        let mut reader = Reader::new(Settings::default());
        reader.text("", &self.scene);
        // A scene that this program cannot read counts as a different one.
        let Ok(then) = reader.finish() else {
            return Err("it was written with a scene that this version cannot read".to_owned());
        };
        let now = &scene.settings;
        let fixed = |parameter: &Parameter| parameter.effect == Effect::Restart;
        let (fixed, live): (Vec<_>, Vec<_>) = PARAMETERS
            .iter()
            .filter(|parameter| parameter.differs(&then, now))
            .partition(|parameter| fixed(parameter));
        let difference = |parameter: &&Parameter| {
            let (then, now) = (parameter.value(&then), parameter.value(now));
            format!("{} = {now}, which was {then}", parameter.key)
        };
        if !fixed.is_empty() || !same_layout {
            let mut differences: Vec<String> = fixed.iter().map(difference).collect();
            if differences.is_empty() {
                differences.push("other meshes or scales".to_owned());
            }
            return Err(format!(
                "the scene here has {}; resume with the scene and the settings that it was written with",
                differences.join(", and ")
            ));
        }
        self.snapshot.check(setup)?;
        let of_the_state =
            |parameter: &&&Parameter| !["camera", "picture"].contains(&parameter.section());
        let mut notes: Vec<String> = live.iter().filter(of_the_state).map(difference).collect();
        if self.arithmetic != arithmetic::VERSION {
            notes.push(
                "it was written by a version with other arithmetic, so that hashes of states from here on cannot be compared with those \
                 of runs from the start"
                    .to_owned(),
            );
        }
        Ok(notes)
    }

    /// Writes the file. It appears under its name only when it is whole.
    ///
    /// # Errors
    /// When the folder cannot be written to or the disk is full; the file that was there before stays.
    pub fn write(&self, path: &Path) -> Result<()> {
        let error = Error::io("write", path);
        let mut file = WholeFile::create(path).map_err(&error)?;
        self.write_to(&mut file).map_err(&error)?;
        file.finish().map_err(&error)?;
        Ok(())
    }

    /// Writes what is in the file.
    pub(crate) fn write_to(&self, file: &mut impl Write) -> std::io::Result<()> {
        let Self {
            scene,
            layout,
            arithmetic,
            snapshot,
        } = self;
        let header = serde_json::to_vec(&Header {
            step: snapshot.step,
            lengths: Lengths::of(snapshot),
            fed_deposit: snapshot.food.fed_deposit,
            origin: snapshot.origin.to_array().map(f64::to_bits),
            scene: scene.clone(),
            layout: *layout,
            arithmetic: *arithmetic,
            movement: snapshot.movement.clone(),
        })?;
        let mut out = Checked {
            inner: BufWriter::new(file),
            crc: crc32fast::Hasher::new(),
        };
        out.put(MAGIC)?;
        out.put(&VERSION.to_le_bytes())?;
        out.put(&(header.len() as u32).to_le_bytes())?;
        out.put(&header)?;
        for part in KEPT {
            out.put(part.bytes(snapshot))?;
        }
        let crc = out.crc.finalize();
        out.inner.write_all(&crc.to_le_bytes())?;
        out.inner.flush()
    }

    /// Does the file begin as checkpoints do?
    #[must_use]
    pub fn is_one(path: &Path) -> bool {
        let mut begins = [0; MAGIC.len()];
        regular_file::open(path).is_ok_and(|(mut file, _)| file.read_exact(&mut begins).is_ok())
            && begins == *MAGIC
    }

    /// The scene that it was written with, with the user's overrides; `path` is that of the checkpoint.
    ///
    /// # Errors
    /// When the scene cannot be read, or a mesh is no longer at its path.
    pub fn own_scene(&self, path: &Path, overrides: &Overrides) -> Result<Scene> {
        let settings = Scene::read_text(path, &self.scene, overrides)?;
        let name = path.file_stem().unwrap_or(path.as_os_str());
        let name = name.to_string_lossy().into_owned();
        // Its paths are absolute, except those with names that are not Unicode.
        let folder = path.parent().map(Path::to_owned).unwrap_or_default();
        Ok(Scene::from_settings(name, settings, folder)?)
    }

    /// Reads a file back.
    ///
    /// # Errors
    /// When it is no checkpoint, of another version, cut short, or damaged.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = read_like(path, MAGIC).map_err(Error::io("read", path))?;
        Self::from_bytes(&bytes).map_err(|problem| {
            Error::Invalid(format!("cannot resume from {}: {problem}", path.shown()))
        })
    }

    /// Reads what a file holds.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
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
        if !(OLDEST..=VERSION).contains(&version) {
            return Err(format!(
                "it has version {version}, this program reads versions {OLDEST} to {VERSION}"
            ));
        }
        let Some((body, crc)) = bytes.split_last_chunk::<4>() else {
            return Err(cut_short());
        };
        rest = rest.strip_suffix(crc).ok_or_else(cut_short)?;
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
        let mut header: Header =
            serde_json::from_slice(header).map_err(|e| format!("its header is damaged: {e}"))?;
        let mut snapshot = Snapshot {
            step: header.step,
            movement: header.movement,
            origin: DVec3::from_array(header.origin.map(f64::from_bits)),
            food: FoodState {
                fed_deposit: header.fed_deposit.max(1),
                ..FoodState::default()
            },
            ..Snapshot::default()
        };
        for part in KEPT {
            part.read(&mut snapshot, &mut rest, &mut header.lengths)
                .ok_or_else(cut_short)?;
        }
        if !rest.is_empty() {
            return Err(format!("it has {} bytes too many", rest.len()));
        }
        snapshot.forget_turns(header.arithmetic == 0);
        Ok(Self {
            scene: header.scene,
            layout: header.layout,
            arithmetic: header.arithmetic,
            snapshot,
        })
    }
}

/// The whole file if it begins with `magic`, otherwise only its beginning, because other files may be very large.
fn read_like(path: &Path, magic: &[u8]) -> std::io::Result<Vec<u8>> {
    let (mut file, _) = regular_file::open(path)?;
    let mut bytes = Vec::new();
    (&file).take(magic.len() as u64).read_to_end(&mut bytes)?;
    if bytes == magic {
        file.read_to_end(&mut bytes)?;
    }
    Ok(bytes)
}

/// A number that other meshes, scales or atlases very likely don't have.
fn layout(setup: &Setup) -> u32 {
    let mut crc = crc32fast::Hasher::new();
    crc.update(bytemuck::cast_slice(&setup.surface.positions));
    crc.update(bytemuck::cast_slice(&setup.surface.corners));
    for &h in &setup.surface.glued {
        let twin = setup.surface.halfedges[h as usize].twin;
        crc.update(bytemuck::cast_slice(&[h, twin]));
    }
    crc.update(bytemuck::cast_slice(&setup.atlas.maps));
    crc.update(&setup.atlas.pitch.to_le_bytes());
    crc.finalize()
}

fn take<'a>(rest: &mut &'a [u8], length: usize) -> Option<&'a [u8]> {
    let (head, tail) = rest.split_at_checked(length)?;
    *rest = tail;
    Some(head)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Affine3A, UVec2, UVec4};

    use crate::sim::distance::KeptPair;
    use crate::sim::pulse::LivePulse;
    use crate::sim::restarts::Restarts;
    use crate::sim::transfers::TransferState;
    use crate::sim::twin;
    use crate::sim::types::{Flow, Motion, Particle, Population, Transfer, Window};

    /// Every field by name and none empty, so that the tests find a field that the list of kept parts lacks.
    fn checkpoint() -> Checkpoint {
        Checkpoint {
            scene: "seed = 9\n".to_owned(),
            layout: 7,
            arithmetic: 1,
            snapshot: Snapshot {
                step: 41,
                movement: SavedMovement::default(),
                last_poses: vec![Affine3A::from_rotation_x(0.1).into(); 2],
                origin: DVec3::new(512_320.0, 0.0, -1e7),
                distance_poses: vec![Affine3A::from_rotation_y(0.3).into(); 2],
                kept_pairs: vec![KeptPair {
                    other_from_object: Affine3A::from_rotation_z(0.2).into(),
                    object: 1,
                    other: 0,
                    pad0: [0; 2],
                }],
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
                        flags: 12 << Motion::HUNGRY_SHIFT
                    };
                    33
                ],
                trail: (0..55).map(|i| i as f32 * 0.1).collect(),
                bias: (0..55).map(|i| i as f32 - 20.0).collect(),
                deposits: (0..55).collect(),
                food: FoodState {
                    remaining: vec![7, 0, 1],
                    fed_deposit: 4,
                },
                transfers: TransferState {
                    windows: vec![Window { start: 3, count: 5 }; 2],
                    in_flight: vec![
                        Transfer {
                            particle: 9,
                            ..Transfer::default()
                        };
                        3
                    ],
                    flow: Flow {
                        selected: 8,
                        ..Flow::default()
                    },
                    flux: vec![0, 7, 6, 0],
                    restarts: Restarts {
                        places: vec![UVec4::new(5, 1, 2, 0); 6],
                        ranges: vec![UVec2::new(0, 2), UVec2::new(2, 3)],
                    },
                },
                looks: vec![0.25; 55],
                population: vec![Population {
                    living: 31,
                    births: 9,
                    deaths: 11,
                    refused: 3,
                    born: 2,
                    died: 1,
                }],
                pulses: vec![
                    LivePulse {
                        center: [1.0, -2.0, 0.5],
                        speed: 0.01,
                        width: 0.25,
                        reach: 2.0,
                        strength: 0.6,
                        pad0: 0,
                        first_step: 40,
                    };
                    2
                ],
            },
        }
    }

    /// Would catch: a state of another arithmetic that continues without a note.
    #[test]
    fn states_of_another_arithmetic_go_on_with_a_note() {
        let mut settings = Settings::default();
        settings.particles.count = 10;
        settings.atlas.size = 64;
        settings.objects[0].mesh = "builtin:cube".to_owned();
        let scene = Scene::from_settings("test".to_owned(), settings, "".into()).unwrap();
        let setup = Setup::new(&scene).unwrap();
        let mut simulation = twin::Simulation::new(setup.clone(), scene.settings.clone());
        simulation.step();
        let mut checkpoint = Checkpoint::new(&scene, &setup, simulation.snapshot());
        assert_eq!(checkpoint.check(&scene, &setup), Ok(Vec::new()));
        let mut bytes = Vec::new();
        checkpoint.arithmetic = 0;
        checkpoint.write_to(&mut bytes).unwrap();
        let read = Checkpoint::from_bytes(&bytes).unwrap();
        assert_eq!(read, checkpoint);
        let notes = read.check(&scene, &setup).unwrap();
        assert!(
            notes.len() == 1 && notes[0].contains("other arithmetic"),
            "{notes:?}"
        );
    }

    /// Catches marks and counts of one step that are kept from a checkpoint of an earlier version.
    #[test]
    fn what_earlier_versions_kept_of_turns_is_forgotten() {
        let mut earlier = checkpoint();
        earlier.arithmetic = 0;
        earlier.snapshot.motions[7].flags = 3 << Motion::FED_SHIFT | 0x1234;
        earlier.snapshot.motions[8].flags = Motion::SELECTED | 0x40;
        earlier.snapshot.transfers.flow = Flow {
            wanted: 3,
            leaving: 5,
            listed: 7,
            left_over: 9,
            selected: 11,
            refused: 2,
            ..Flow::default()
        };
        let mut bytes = Vec::new();
        earlier.write_to(&mut bytes).unwrap();
        let read = Checkpoint::from_bytes(&bytes).unwrap().snapshot;
        let flags = [7, 8].map(|i: usize| read.motions[i].flags);
        assert_eq!(flags, [3 << Motion::FED_SHIFT, Motion::SELECTED]);
        let expected = Flow {
            selected: 11,
            refused: 2,
            ..Flow::default()
        };
        assert_eq!(read.transfers.flow, expected);
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

    /// Would catch: files of earlier versions that are not read, because their headers lack the lengths of parts that came later.
    #[test]
    fn files_of_earlier_versions_are_read() {
        let mut earlier = checkpoint();
        earlier.snapshot.population.clear();
        earlier.snapshot.transfers.restarts = Restarts::default();
        let latest = "\"population\":0,\"restart_places\":0,\"restart_ranges\":0,";
        let bytes = as_version(7, latest, &earlier);
        assert_eq!(Checkpoint::from_bytes(&bytes).unwrap(), earlier);
        earlier.snapshot.pulses.clear();
        earlier.snapshot.looks.clear();
        let later = format!("\"pulses\":0,\"looks\":0,{latest}");
        let bytes = as_version(6, &later, &earlier);
        assert_eq!(Checkpoint::from_bytes(&bytes).unwrap(), earlier);
    }

    /// A file as a program of that version wrote it, whose header had no such lengths.
    fn as_version(version: u32, lengths: &str, checkpoint: &Checkpoint) -> Vec<u8> {
        let mut bytes = Vec::new();
        checkpoint.write_to(&mut bytes).unwrap();
        let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let header = std::str::from_utf8(&bytes[16..16 + length]).unwrap();
        let header = header.replacen(lengths, "", 1);
        assert_eq!(header.len() + lengths.len(), length);
        let mut whole = MAGIC.to_vec();
        whole.extend(version.to_le_bytes());
        whole.extend((header.len() as u32).to_le_bytes());
        whole.extend(header.as_bytes());
        whole.extend(&bytes[16 + length..bytes.len() - 4]);
        whole.extend(crc32fast::hash(&whole).to_le_bytes());
        whole
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
            let problem = Checkpoint::from_bytes(&bytes).unwrap_err();
            assert!(problem.contains(expected), "{name}: {problem}");
        }
    }
}
