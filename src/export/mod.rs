//! Exports of a simulation: models with the trail on them, data for other programs, the present scene.
//!
//! | ending | content | written by |
//! | --- | --- | --- |
//! | `.glb` | every object at its pose, with the trail as texture or vertex colours | [`glb`] |
//! | `.ply` | one mesh in world coordinates, with normals, colours and the trail at its vertices | [`ply`] |
//! | `.npz` | particles, texels, meshes and poses, as arrays for NumPy | [`npz`] |
//! | `.toml` | a scene file that begins where the objects are now, with meshes that were in memory beside it | [`Export::scene_file`] |
//!
//! **Invariant:** the same state of the same program and device gives the same bytes.

pub mod corners;
pub mod glb;
mod meshes;
mod network;
pub mod npz;
pub mod paint;
pub mod ply;
mod watch;

use std::borrow::Cow;
use std::io::{self, BufWriter, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use glam::{Affine3A, DAffine3, DVec3, EulerRot, Vec2, Vec3};
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::gpu::{Context, Fate, Recorder};
use crate::plain_text::{Shown as _, escaped};
use crate::render::View;
use crate::render::output::Written;
use crate::scene::Scene;
use crate::scene::motion::{MotionSettings, Origins};
use crate::scene::settings::AreaSettings;
use crate::sim::areas::{map_for, name_beside, picture_of, write as write_areas};
use crate::sim::checkpoint::Checkpoint;
use crate::sim::field::trail_at;
use crate::sim::{Distances, Setup, Simulation, Snapshot, SnapshotCopy};
use crate::whole_file::WholeFile;
use meshes::MeshFile;
pub use network::{NetworkFile, NetworkFormat, network_columns};
use paint::Paint;
pub use watch::Watch;
use watch::Watched;

/// The default size of pictures in pixels; the camera of an exported model fits its shape.
const PICTURE: Vec2 = Vec2::new(1280.0, 720.0);

/// How often the export polls whether a state has arrived.
const LOOKS_EVERY: Duration = Duration::from_millis(2);

/// The format of a file, by its ending.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Binary glTF 2.0.
    Glb,
    /// Binary, little-endian PLY 1.0.
    Ply,
    /// A zip archive of NumPy arrays.
    Npz,
    /// A scene file.
    Toml,
}

impl Format {
    /// The format of a file of this name; `None` if the ending is unknown.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "glb" => Some(Self::Glb),
            "ply" => Some(Self::Ply),
            "npz" => Some(Self::Npz),
            "toml" => Some(Self::Toml),
            _ => None,
        }
    }
}

/// How a GLB carries the trail's colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Colors {
    /// As a texture with every texel of the trail, however coarse the mesh is.
    #[default]
    Texture,
    /// As vertex colours, for programs without textures: only as fine as the mesh.
    Vertex,
}

/// A state of a simulation, ready to be written.
pub struct Export<'a> {
    /// The scene, with the settings that its next step would use.
    pub scene: Scene,
    /// Surface and atlas.
    pub setup: Arc<Setup>,
    /// Particles and trail.
    pub snapshot: Cow<'a, Snapshot>,
    /// The distances between objects, where some have been taken.
    pub distances: Option<Distances>,
    /// The pose of each object in the last step, counted from the scene's origins.
    pub world_from_object: Vec<Affine3A>,
    /// The poses of objects that were set by `set_pose`, from scaled coordinates to world coordinates.
    set_from_outside: Vec<Option<DAffine3>>,
    /// Seconds of the objects' motion.
    pub time: f64,
    /// The view of its pictures.
    pub view: View,
    /// The name of the device that computed it.
    pub device: String,
    /// The device's driver and its version.
    pub driver: String,
}

impl<'a> Export<'a> {
    /// The present state of a simulation of `scene`, of which `snapshot` was taken just now.
    ///
    /// # Errors
    /// When the device is lost or its memory is full.
    pub fn of(scene: &Scene, simulation: &Simulation, snapshot: &'a Snapshot) -> Result<Self> {
        let mut export = Self::build(scene, simulation, Cow::Borrowed(snapshot));
        export.distances = simulation.distances()?;
        Ok(export)
    }

    fn build(scene: &Scene, simulation: &Simulation, snapshot: Cow<'a, Snapshot>) -> Self {
        let scene = Scene {
            settings: simulation.settings().clone(),
            ..scene.clone()
        };
        let objects = 0..scene.settings.objects.len();
        let info = simulation.ctx().info();
        Self {
            setup: simulation.shared_setup(),
            snapshot,
            distances: None,
            world_from_object: simulation.world_from_object(),
            set_from_outside: objects.map(|i| simulation.set_pose_of(i)).collect(),
            time: simulation.time(),
            view: View::of(&scene, PICTURE),
            device: info.name.clone(),
            driver: format!("{} {}", info.driver, info.driver_version),
            scene,
        }
    }

    /// Maps a place that is counted from the scene's origin to world coordinates.
    fn in_world(&self, place: Vec3) -> DVec3 {
        place.as_dvec3() + self.setup.origin()
    }

    /// Is the world's origin, or that of a surface, elsewhere? Then places take double precision.
    fn is_far_from_origin(&self) -> bool {
        let afar = |origins: &Origins| *origins != Origins::default();
        self.scene.origins.iter().any(afar)
    }

    /// The scene at this state as a scene file: every key, with objects at their present poses and times. Particles, trail and
    /// areas that were painted are not in it; checkpoints keep those, and [`ExportFile::write`] puts areas beside it, and meshes that are
    /// in memory.
    #[must_use]
    pub fn scene_file(&self) -> String {
        self.scene_file_with(None)
    }

    /// The same with areas and meshes, each by its object's number, that lie beside the file.
    fn scene_file_with(&self, beside: Option<(&AreaSettings, &[(usize, String)])>) -> String {
        let mut scene = self.scene.clone();
        let mut objects = scene.settings.objects.iter();
        if objects.any(|object| !object.motion.is_still()) {
            scene.settings.time.start = self.time;
        }
        for (object, pose) in scene
            .settings
            .objects
            .iter_mut()
            .zip(&self.set_from_outside)
        {
            if let Some(pose) = pose {
                let (_, turn, translation) = pose.to_scale_rotation_translation();
                let (z, y, x) = turn.to_euler(EulerRot::ZYX);
                object.rotation = [x, y, z].map(|angle| angle.to_degrees() as f32);
                object.position = translation.to_array();
                object.motion = MotionSettings::default();
            }
        }
        format!(
            "# {}, as it was at step {}. Particles and trail start again from this file; a checkpoint keeps them.\n\n{}",
            escaped(&self.scene.name),
            self.snapshot.step,
            match beside {
                Some((areas, meshes)) => scene.to_toml_with_meshes(areas, meshes),
                None => scene.to_toml(),
            }
        )
    }

    /// The colours of its trail.
    #[must_use]
    pub fn paint(&self) -> Paint {
        let atlas = &self.setup.atlas;
        Paint::new(&self.view, &self.snapshot.trail, &atlas.density)
    }

    /// The trail at a place in the atlas, in texels, and the weight of the second look there.
    fn trail_and_second_look(&self, place: [f32; 2]) -> (f32, f32) {
        let pitch = self.setup.atlas.pitch;
        let Snapshot { trail, looks, .. } = &*self.snapshot;
        let weight = match looks.as_slice() {
            [] => 0.0,
            looks => trail_at(looks, place, pitch),
        };
        (trail_at(trail, place, pitch), weight)
    }

    /// The mean distance of neighbouring vertices in the trail's texture, in texels: vertex colours lose finer details.
    #[must_use]
    pub fn texels_between_vertices(&self) -> f32 {
        let maps = &self.setup.atlas.maps;
        let lengths = maps.iter().map(|map| {
            let edges = [map.du, map.dv, map.dv - map.du];
            edges.iter().map(|edge| edge.length()).sum::<f32>() / 3.0
        });
        lengths.sum::<f32>() / maps.len().max(1) as f32
    }

    /// Writes the state in a format.
    ///
    /// # Errors
    /// When the disk is full, or it is larger than the format allows.
    pub fn write(
        &self,
        format: Format,
        colors: Colors,
        out: &mut (impl Write + Seek),
    ) -> io::Result<()> {
        match format {
            Format::Glb => glb::write(self, colors, out),
            Format::Ply => ply::write(self, out),
            Format::Npz => npz::write(self, out),
            Format::Toml => out.write_all(self.scene_file().as_bytes()),
        }
    }
}

/// A state that is being copied from the device, with all data that its export needs, so that another thread can write it while the
/// simulation continues.
pub struct ExportOnTheWay {
    /// Everything except the state; it may be changed.
    pub export: Export<'static>,
    copy: SnapshotCopy,
    /// Of the recording that has the copies.
    fate: Fate,
    ctx: Arc<Context>,
}

impl ExportOnTheWay {
    /// Records copies of the present state of a simulation of `scene`. Does not wait.
    ///
    /// # Errors
    /// No memory.
    pub fn record(scene: &Scene, simulation: &Simulation, rec: &mut Recorder) -> Result<Self> {
        Ok(Self {
            export: Export::build(scene, simulation, Cow::Owned(Snapshot::default())),
            copy: simulation.record_snapshot(rec)?,
            fate: rec.fate.clone(),
            ctx: Arc::clone(rec.ctx()),
        })
    }

    /// Waits until the frame in which it was recorded has finished. That is noticed when [`Frames::begin`](crate::gpu::Frames::begin) or
    /// [`Frames::wait_idle`](crate::gpu::Frames::wait_idle) waits for the frame: another thread must do so meanwhile, or this one before.
    /// Otherwise it waits until it is cancelled.
    ///
    /// # Errors
    /// When it was cancelled, the device was lost, or the recording was dropped and not submitted.
    pub fn wait(mut self, watch: &Watch) -> Result<Export<'static>> {
        while !self.copy.is_there() {
            if watch.is_cancelled() {
                return Err(Error::Invalid("it was cancelled".to_owned()));
            }
            // A device that is lost drops recordings, too, and is lost first.
            let was_dropped = self.fate.was_dropped();
            if self.ctx.is_lost() {
                return Err(Error::Invalid(
                    "the device was lost before the state had been copied: nothing is exported"
                        .to_owned(),
                ));
            }
            if was_dropped {
                return Err(Error::Invalid(
                    "the frame that copies the state was dropped: nothing is exported".to_owned(),
                ));
            }
            thread::sleep(LOOKS_EVERY);
        }
        let (snapshot, distances) = self.copy.take();
        Ok(Export {
            snapshot: Cow::Owned(snapshot),
            distances,
            ..self.export
        })
    }
}

/// A file to which a state will be written.
#[derive(Debug)]
pub struct ExportFile {
    file: WholeFile,
    format: Format,
}

impl ExportFile {
    /// Begins the file under a temporary name; the ending decides the format.
    ///
    /// # Errors
    /// Errors that do not depend on the state: an unknown ending, a folder that cannot be written.
    pub fn create(path: &Path) -> Result<Self> {
        let format = Format::of(path).ok_or_else(|| {
            Error::Invalid(format!(
                "{}: unknown output format; call it NAME.glb (model with texture), NAME.ply (mesh with colours), \
                 NAME.npz (all data) or NAME.toml (scene file)",
                path.shown()
            ))
        })?;
        Ok(Self {
            file: WholeFile::create(path).map_err(Error::io("write", path))?,
            format,
        })
    }

    /// Does its format have the trail at vertices only?
    #[must_use]
    pub fn is_as_fine_as_its_mesh(&self, colors: Colors) -> bool {
        match self.format {
            Format::Ply => true,
            Format::Glb => colors == Colors::Vertex,
            Format::Npz | Format::Toml => false,
        }
    }

    /// The name that it will have.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// Writes the state and gives the file its name.
    ///
    /// # Errors
    /// As [`Export::write`], and when a scene with painted areas or with meshes in memory is to have a name that is not Unicode; then there
    /// is no file, and one that had the name before stays.
    pub fn write(self, export: &Export<'_>, colors: Colors) -> Result<Written> {
        self.write_watched(export, colors, &Watch::default())
    }

    /// As [`write`](Self::write), with progress reports and cancellation by `watch`.
    ///
    /// # Errors
    /// As [`write`](Self::write), and when it was cancelled.
    pub fn write_watched(
        self,
        export: &Export<'_>,
        colors: Colors,
        watch: &Watch,
    ) -> Result<Written> {
        let path = self.path().to_owned();
        let mut files = vec![path.clone()];
        let (bias, atlas) = (&export.snapshot.bias, &export.setup.atlas);
        let is_scene = self.format == Format::Toml;
        let areas = is_scene.then(|| picture_of(bias, atlas)).flatten();
        let strength = areas.map(|(_, strength)| strength);
        let map = if is_scene {
            map_for(&path)
        } else {
            PathBuf::new()
        };
        let says = match strength {
            Some(strength) => AreaSettings {
                map: name_beside(&map)?,
                strength,
            },
            None => AreaSettings::default(),
        };
        let meshes = if is_scene {
            meshes::beside(&path, &export.scene.settings)?
        } else {
            Vec::new()
        };
        let hidden = || -> io::Result<WholeFile> {
            let file = Watched::new(self.file, watch);
            let mut out = BufWriter::with_capacity(1 << 20, file);
            if is_scene {
                let names: Vec<_> = meshes.iter().map(MeshFile::named).collect();
                let text = export.scene_file_with(Some((&says, names.as_slice())));
                out.write_all(text.as_bytes())?;
            } else {
                export.write(self.format, colors, &mut out)?;
            }
            Ok(out.into_inner()?.into_inner())
        };
        let file = hidden().map_err(Error::io("write", &path))?;
        // The scene gets its name only after the files that it names exist.
        if is_scene && write_areas(&map, bias, atlas)?.is_some() {
            files.push(map);
        }
        for mesh in meshes {
            mesh.write(&export.scene)?;
            files.push(mesh.path);
        }
        file.finish().map_err(Error::io("write", &path))?;
        Ok(Written { files, frames: 1 })
    }
}

/// Writes a state as a checkpoint, with progress reports and cancellation.
///
/// # Errors
/// As [`ExportFile::write_watched`].
pub fn write_checkpoint(export: Export<'_>, path: &Path, watch: &Watch) -> Result<Written> {
    let Export {
        scene,
        setup,
        snapshot,
        ..
    } = export;
    let checkpoint = Checkpoint::new(&scene, &setup, snapshot.into_owned());
    let whole = || -> io::Result<()> {
        let mut file = Watched::new(WholeFile::create(path)?, watch);
        checkpoint.write_to(&mut file)?;
        file.into_inner().finish()?;
        Ok(())
    };
    whole().map_err(Error::io("write", path))?;
    Ok(Written {
        files: vec![path.to_owned()],
        frames: 1,
    })
}
