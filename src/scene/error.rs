//! Errors of a scene, each with advice.

use std::path::{Path, PathBuf};

use super::problems::Problems;
use super::suggest::nearest;
use super::{builtin, parameters};
use crate::mesh::MeshError;
use crate::plain_text::{Shown as _, quoted};

/// Why a scene could not be loaded.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// No built-in scene has this name, and no file either.
    #[error(
        "there is no scene `{name}`{suggestion}: the built-in ones are {known}; a scene can also be a .toml file or a model (.obj, .stl, .ply, .glb, .gltf)"
    )]
    UnknownScene {
        /// The requested name.
        name: String,
        /// `, did you mean ...?`, or nothing.
        suggestion: String,
        /// All names.
        known: String,
    },
    /// A file of another kind, by its ending.
    #[error(
        "{path}: neither a scene nor a model by the ending of its name: models are .obj, .stl, .ply, .glb, .gltf, scenes .toml",
        path = path.shown()
    )]
    OtherFile {
        /// The file.
        path: PathBuf,
    },
    /// No preset has this name.
    #[error(
        "there is no preset `{name}`{suggestion}: the presets are {known}; a preset can also be a .toml file"
    )]
    UnknownPreset {
        /// The requested name.
        name: String,
        /// `, did you mean ...?`, or nothing.
        suggestion: String,
        /// All names.
        known: String,
    },
    /// The file of a preset could not be read.
    #[error("cannot read the preset {path}: {source}", path = path.shown())]
    ReadPreset {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The scene file could not be read.
    #[error("cannot read the scene {path}: {source}", path = path.shown())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// Keys or values are wrong; the message lists the first of them, and says how many there are.
    #[error("{}", problems.describe(&scene.to_string_lossy()))]
    Problems {
        /// The requested scene.
        scene: PathBuf,
        /// The problems.
        problems: Problems,
    },
    /// An object's mesh cannot be used.
    #[error("object `{}`: {source}", quoted(object))]
    Object {
        /// The object's name, or its place in the file.
        object: String,
        /// The problem of its mesh.
        source: MeshError,
    },
    /// An object's mesh was in memory, and no file has it.
    #[error(
        "the mesh of `{}` was an array in Python: pass the scene to `Simulation.resume`, or set object.{number}.mesh to a file",
        quoted(name)
    )]
    InMemory {
        /// The name of the mesh.
        name: String,
        /// The object's number.
        number: usize,
    },
    /// The objects are too small or too large to define the unit of lengths.
    #[error(
        "the scene radius comes to {radius:e} world units, which lengths cannot be multiplied by: set `radius`, or scale the objects"
    )]
    Radius {
        /// The measured or set radius.
        radius: f32,
    },
    /// An object is a rod or a needle, too thin for directions in single precision.
    #[error(
        "object `{}`: most of its surface consists of triangles up to {times:.0e} times as long as wide, and particles can walk on triangles up to 5e6: make the object thicker, or split the triangles into shorter ones",
        quoted(object)
    )]
    TooThin {
        /// The object's name.
        object: String,
        /// Its length by its width.
        times: f64,
    },
    /// The objects are too far from the origin.
    #[error(
        "the objects reach {farthest:e} world units from the origin, and 4e12 is the most: move them nearer, or scale them down"
    )]
    TooFar {
        /// The greatest coordinate.
        farthest: f64,
    },
    /// A model's path is not Unicode, which scene files are written in.
    #[error("{path}: the path is not Unicode, and scene files are: rename it", path = path.shown())]
    NotUnicode {
        /// The path.
        path: PathBuf,
    },
}

impl SceneError {
    /// Refuses a scene that has problems.
    pub(super) fn unless_empty(scene: &str, problems: Problems) -> Result<(), Self> {
        if problems.is_empty() {
            return Ok(());
        }
        let scene = PathBuf::from(scene);
        Err(Self::Problems { scene, problems })
    }

    pub(super) fn unknown_scene(scene: &Path) -> Self {
        let name = scene.to_string_lossy().into_owned();
        let names: Vec<_> = builtin::SCENES.iter().map(|scene| scene.name).collect();
        let (suggestion, known) = suggest(&name, &names);
        Self::UnknownScene {
            name: quoted(&name).into_owned(),
            suggestion,
            known,
        }
    }

    pub(super) fn unknown_preset(name: &str) -> Self {
        let names: Vec<_> = builtin::PRESETS.iter().map(|preset| preset.name).collect();
        let (suggestion, known) = suggest(name, &names);
        Self::UnknownPreset {
            name: quoted(name).into_owned(),
            suggestion,
            known,
        }
    }
}

fn suggest(name: &str, names: &[&str]) -> (String, String) {
    let suggestion =
        nearest(name, names.iter().copied()).map(|near| format!(", did you mean `{near}`?"));
    (suggestion.unwrap_or_default(), parameters::all_of(names))
}
