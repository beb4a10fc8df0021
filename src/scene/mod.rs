//! Scenes: objects, parameters and the files that hold them. [`Scene::load`] turns a name or a file into meshes on
//! one pooled surface and checked settings: all that a simulation needs.
//!
//! Settings have world coordinates in double precision. `sim` and `render` use coordinates relative to [`Origins::world`] in single
//! precision, which they call world space.

pub mod builtin;
mod error;
pub mod file;
pub mod foods;
mod keyframes;
pub mod motion;
pub mod parameters;
pub mod presets;
pub mod problems;
mod rules;
pub mod settings;
mod starts;
mod strategy;
pub mod suggest;
#[cfg(test)]
mod tests;

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use glam::{Affine3A, DVec3, Vec3};

use crate::mesh::surface::Surface;
use crate::mesh::{Mesh, MeshError, RigidTrack, origin};
use crate::regular_file;

pub use error::SceneError;
pub use rules::Rules;
pub use settings::Settings;

use file::Reader;
use motion::{Origins, pose_from};
use problems::{Problem, Problems, listed};
use settings::{AreaSettings, ObjectSettings};

/// The largest world coordinate.
const FARTHEST: f64 = 4e12;

/// The look of a bare model.
const MODELS_PRESET: &str = "network";

/// Changes of a scene by the command line, in the order in which they are applied.
#[derive(Clone, Debug, Default)]
pub struct Overrides {
    /// The name of a built-in preset, or a preset's file.
    pub preset: Option<String>,
    /// `KEY=VALUE`, later ones over earlier ones.
    pub set: Vec<String>,
    /// The seed.
    pub seed: Option<u64>,
}

/// A scene, loaded and checked.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The built-in's name, or the file's without its ending.
    pub name: String,
    /// Every parameter; the radius is filled in, and every object has a name.
    pub settings: Settings,
    /// One mesh for each object, in the mesh's own coordinates.
    pub meshes: Vec<Mesh>,
    /// The animation of each object's model, if the object follows it.
    pub tracks: Vec<Option<RigidTrack>>,
    /// The origins of coordinates for each object; the world's origin is the same for all.
    pub origins: Vec<Origins>,
    /// All objects pooled, scaled to world lengths, each counted from its origin in `origins`.
    pub surface: Surface,
    /// The scene radius in world units, by which all lengths are multiplied; positive.
    pub radius: f32,
    /// The centre of the box round all objects, in world coordinates that are counted from the world's origin.
    pub center: Vec3,
    /// Relative mesh paths begin here; empty for built-in scenes.
    pub folder: PathBuf,
}

impl Scene {
    /// Loads a scene: the name of a built-in, a TOML file, or a bare model (`.obj`, `.stl`, `.ply`, `.glb`, `.gltf` or
    /// `builtin:MESH`), which makes a scene of one object with the look of the preset `network`.
    ///
    /// # Errors
    /// If there is no scene of that name, a file cannot be read, a key is unknown, a value is not allowed (all of them in one error), or a
    /// mesh cannot be used.
    pub fn load(scene: &Path, overrides: &Overrides) -> Result<Self, SceneError> {
        let (name, settings, folder) = Self::read(scene, overrides)?;
        Self::from_settings(name, settings, folder)
    }

    /// The name, settings and folder of a scene, without its meshes; see [`Self::load`].
    ///
    /// # Errors
    /// As for [`Self::load`], but for meshes.
    pub fn read(
        scene: &Path,
        overrides: &Overrides,
    ) -> Result<(String, Settings, PathBuf), SceneError> {
        let mut reader = Reader::new(Settings::default());
        let mut folder = PathBuf::new();
        let name = match Source::find(scene)? {
            Source::Builtin(builtin) => {
                reader.text("", builtin.text);
                builtin.name.to_owned()
            }
            Source::Model(mesh) => {
                // A point among the options of a built-in mesh begins no ending.
                let name = match mesh.strip_prefix(BUILTIN) {
                    Some(name) => name.to_owned(),
                    None => name_of(scene),
                };
                reader.settings.objects = vec![ObjectSettings {
                    mesh,
                    ..ObjectSettings::default()
                }];
                // With the plain defaults a network dies out after some hundred steps.
                if let Some(preset) = builtin::preset(MODELS_PRESET) {
                    reader.preset("", preset.text);
                }
                name
            }
            Source::File => {
                let text = regular_file::read_text(scene).map_err(|source| SceneError::Read {
                    path: scene.to_owned(),
                    source,
                })?;
                reader.text("", &text);
                folder = scene.parent().map(Path::to_owned).unwrap_or_default();
                name_of(scene)
            }
        };
        let settings = overridden(reader, scene, overrides)?;
        Ok((name, settings, folder))
    }

    /// As [`read`](Self::read), for the text of a scene file; errors use the name `scene`.
    ///
    /// # Errors
    /// When a key is unknown, or a value is not allowed.
    pub fn read_text(
        scene: &Path,
        text: &str,
        overrides: &Overrides,
    ) -> Result<Settings, SceneError> {
        let mut reader = Reader::new(Settings::default());
        reader.text("", text);
        overridden(reader, scene, overrides)
    }

    /// Loads the meshes of settings that have been read or changed. Relative mesh paths begin at `folder`.
    ///
    /// # Errors
    /// When a value is out of range, a mesh cannot be loaded, or the atlas has no room for all triangles.
    pub fn from_settings(
        name: String,
        settings: Settings,
        folder: PathBuf,
    ) -> Result<Self, SceneError> {
        check_ranges(&name, &settings)?;
        let mut meshes: Vec<Mesh> = Vec::with_capacity(settings.objects.len());
        let mut room = most_triangles(&settings);
        for (i, object) in settings.objects.iter().enumerate() {
            if let Some(name) = in_memory(&object.mesh) {
                return Err(SceneError::InMemory {
                    name: name.to_owned(),
                    number: i,
                });
            }
            let mesh = Mesh::open_within(&object.mesh, &folder, room);
            let mesh = mesh.map_err(|source| SceneError::Object {
                object: if object.name.is_empty() {
                    format!("object.{i}")
                } else {
                    object.name.clone()
                },
                source,
            })?;
            room -= mesh.corners.len() as u64;
            meshes.push(mesh);
        }
        let tracks = tracks(&name, &settings.objects, &folder)?;
        Self::from_meshes_and_tracks(name, settings, meshes, tracks, folder)
    }

    /// A scene of meshes that are in memory already, one for each object of the settings, whose `mesh` is read only
    /// for the animation of an object that follows its model's.
    ///
    /// # Errors
    /// When a value is out of range, edges cannot be glued, the scene is too small or too large to measure lengths by, or an object cannot
    /// follow its model.
    ///
    /// # Panics
    /// When there are not as many meshes as objects.
    pub fn from_meshes(
        name: String,
        settings: Settings,
        meshes: Vec<Mesh>,
        folder: PathBuf,
    ) -> Result<Self, SceneError> {
        check_ranges(&name, &settings)?;
        let tracks = tracks(&name, &settings.objects, &folder)?;
        Self::from_meshes_and_tracks(name, settings, meshes, tracks, folder)
    }

    fn from_meshes_and_tracks(
        name: String,
        mut settings: Settings,
        mut meshes: Vec<Mesh>,
        tracks: Vec<Option<RigidTrack>>,
        folder: PathBuf,
    ) -> Result<Self, SceneError> {
        assert_eq!(meshes.len(), settings.objects.len(), "one mesh an object");
        name_objects(&mut settings.objects, &meshes);
        foods::name(&mut settings);
        check_distance_to(&name, &settings.objects)?;
        foods::check(&name, &settings)?;
        starts::check(&name, &settings)?;
        starts::from_everywhere(&mut settings, &folder);
        let surface = pooled(&meshes, &settings.objects)?;
        for (mesh, object) in meshes.iter_mut().zip(&settings.objects) {
            // Set even if there are none: the mesh may come from a scene with another list.
            mesh.report.glued_pairs = mesh.glue.len() + object.glue.len();
        }
        check_thinness(&settings.objects, &surface)?;
        let origins = origins(&settings, &meshes, &tracks, &surface)?;
        let poses = poses(&settings.objects, &tracks, &origins, 0.0);
        let (center, measured) = bounds(&surface, &poses);
        if settings.radius == 0.0 {
            settings.radius = measured;
        }
        let is_too_large = f64::from(settings.radius) > parameters::MOST_RADIUS;
        if !settings.radius.is_normal() || !settings.radius.recip().is_normal() || is_too_large {
            return Err(SceneError::Radius {
                radius: settings.radius,
            });
        }
        Ok(Self {
            name,
            radius: settings.radius,
            settings,
            meshes,
            tracks,
            origins,
            surface,
            center,
            folder,
        })
    }

    /// The rigid pose of each object before the first step: takes the surface's coordinates, which are scaled, to
    /// world coordinates, both counted from their `origins`.
    #[must_use]
    pub fn world_from_object(&self) -> Vec<Affine3A> {
        self.world_from_object_at(self.settings.time.start)
    }

    /// The poses after `time` seconds of motion.
    #[must_use]
    pub fn world_from_object_at(&self, time: f64) -> Vec<Affine3A> {
        poses(&self.settings.objects, &self.tracks, &self.origins, time)
    }

    /// A warning for each object that is so small and so far from the others that single precision, in which all poses and places are
    /// stored, resolves it coarsely at the start.
    #[must_use]
    pub fn coarse_objects(&self) -> Vec<String> {
        let poses = self.world_from_object();
        let objects = self.settings.objects.iter().zip(&poses).enumerate();
        let coarse = objects.filter_map(|(i, (object, pose))| {
            let places = corners(self.surface.bounds(i)).map(|corner| pose.transform_point3(corner).as_dvec3());
            let places: Vec<DVec3> = places.collect();
            let (low, high) = origin::bounds(&places);
            let steps = origin::few_steps(low, high)?;
            let name = &object.name;
            Some(format!(
                "object `{name}` is far from the others for its size: single precision has {steps} steps across it there, \
                 so its place and what it meets are rounded; what grows on it is not"
            ))
        });
        coarse.collect()
    }

    /// The scene as a file that loads equally from any folder: every key, the measured radius, and absolute mesh paths.
    #[must_use]
    pub fn to_toml(&self) -> String {
        self.to_toml_as(&self.settings)
    }

    /// As [`to_toml`](Self::to_toml), with other settings for the same objects.
    #[must_use]
    pub fn to_toml_as(&self, settings: &Settings) -> String {
        self.to_toml_with(settings, None, &[])
    }

    /// As [`to_toml`](Self::to_toml), with areas whose map lies beside the file.
    #[must_use]
    pub fn to_toml_beside(&self, areas: &AreaSettings) -> String {
        self.to_toml_with(&self.settings, Some(areas), &[])
    }

    /// As [`to_toml_beside`](Self::to_toml_beside), with objects, by their numbers, whose meshes lie beside the file.
    pub(crate) fn to_toml_with_meshes(
        &self,
        areas: &AreaSettings,
        meshes: &[(usize, String)],
    ) -> String {
        self.to_toml_with(&self.settings, Some(areas), meshes)
    }

    /// Does a scene file in another folder find the models, masks and maps? Not if they lie in a folder whose name is not Unicode: then
    /// paths are relative to the scene's folder.
    #[must_use]
    pub fn is_found_from_everywhere(&self) -> bool {
        let settings = &self.settings;
        let objects = settings.objects.iter();
        let files = objects.flat_map(|object| [&object.mesh, &object.start.mask]);
        let mut files = files.chain([
            &settings.particles.start_mask,
            &settings.areas.map,
            &settings.second_look.map,
        ]);
        let is_named_whole = |file: &String| {
            let mut whole = file.clone();
            starts::make_whole(&mut whole, &self.folder);
            let is_no_file = file.is_empty() || file.starts_with(BUILTIN);
            is_no_file || in_memory(file).is_some() || Path::new(&whole).is_absolute()
        };
        files.all(is_named_whole)
    }

    /// Makes the paths of meshes, masks and maps absolute; relative ones begin at `folder`.
    pub fn make_paths_whole(settings: &mut Settings, folder: &Path) {
        for object in &mut settings.objects {
            if !object.mesh.starts_with(BUILTIN) && in_memory(&object.mesh).is_none() {
                starts::make_whole(&mut object.mesh, folder);
            }
        }
        starts::from_everywhere(settings, folder);
    }

    fn to_toml_with(
        &self,
        settings: &Settings,
        areas: Option<&AreaSettings>,
        meshes: &[(usize, String)],
    ) -> String {
        let mut settings = settings.clone();
        Self::make_paths_whole(&mut settings, &self.folder);
        if let Some(areas) = areas {
            settings.areas.clone_from(areas);
        }
        for (object, file) in meshes {
            settings.objects[*object].mesh.clone_from(file);
        }
        settings.to_toml()
    }
}

/// The settings read, with the user's overrides.
fn overridden(
    mut reader: Reader,
    scene: &Path,
    overrides: &Overrides,
) -> Result<Settings, SceneError> {
    if let Some(wanted) = &overrides.preset {
        reader.preset(&format!("preset {wanted}"), &presets::text_of(wanted)?);
    }
    for assignment in &overrides.set {
        reader.assignment(assignment);
    }
    if let Some(seed) = overrides.seed {
        let is_seed = |assignment: &&String| {
            let key = assignment.split('=').next();
            key.is_some_and(|key| key.trim() == "seed")
        };
        match overrides.set.iter().find(is_seed) {
            None => reader.seed(seed),
            // It is unknown which of the two is meant.
            Some(assignment) => reader.problems.push(Problem {
                place: format!("--seed {seed}"),
                message: format!(
                    "--set {assignment} sets the seed, too: leave one of the two away"
                ),
            }),
        }
    }
    reader.finish().map_err(|problems| SceneError::Problems {
        scene: scene.to_owned(),
        problems,
    })
}

/// The name of a scene: that of its file without the ending.
fn name_of(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}

/// The mean number. Every built-in scene has several texels per triangle.
const MOST_TRIANGLES_A_TEXEL: u64 = 16;
/// This many load in a second, and the error of the atlas names a size that is large enough.
const FEW_TRIANGLES: u64 = 1 << 20;

/// The prefix of built-in names.
pub(crate) const BUILTIN: &str = "builtin:";

/// The prefix of meshes that are in memory, before their names.
const MEMORY: &str = "memory:";

/// The name of a mesh that is in memory, or was when the scene was written; none of another.
pub(crate) fn in_memory(mesh: &str) -> Option<&str> {
    mesh.strip_prefix(MEMORY)
}

/// The kind of a SCENE argument.
enum Source {
    Builtin(&'static builtin::Builtin),
    Model(String),
    File,
}

impl Source {
    fn find(scene: &Path) -> Result<Self, SceneError> {
        if let Some(word) = scene.to_str() {
            if let Some(builtin) = builtin::scene(word) {
                return Ok(Self::Builtin(builtin));
            }
            if word.starts_with(BUILTIN) {
                return Ok(Self::Model(word.to_owned()));
            }
        }
        let ending = scene
            .extension()
            .map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        match ending.as_deref() {
            Some("obj" | "stl" | "ply" | "glb" | "gltf") => match scene.to_str() {
                Some(path) => Ok(Self::Model(path.to_owned())),
                // Mesh paths are texts in scene files.
                None => Err(SceneError::NotUnicode {
                    path: scene.to_owned(),
                }),
            },
            Some("toml") => Ok(Self::File),
            Some(_) if scene.is_file() => Err(SceneError::OtherFile {
                path: scene.to_owned(),
            }),
            _ if scene.is_file() => Ok(Self::File),
            _ => Err(SceneError::unknown_scene(scene)),
        }
    }
}

/// How many triangles a scene has room for in its atlas. If many triangles share a texel, particles cannot be distinguished any more; with
/// more triangles, loading stops before long work begins.
fn most_triangles(settings: &Settings) -> u64 {
    let texels = u64::from(settings.atlas.size).pow(2);
    (texels * MOST_TRIANGLES_A_TEXEL).max(FEW_TRIANGLES)
}

/// The meshes of all objects, each in its size and with the edges glued that its settings name.
fn pooled(meshes: &[Mesh], objects: &[ObjectSettings]) -> Result<Surface, SceneError> {
    let glued = meshes.iter().zip(objects);
    let glued: Vec<Cow<'_, Mesh>> = glued
        .map(|(mesh, object)| glued_as_set(mesh, object))
        .collect::<Result<_, SceneError>>()?;
    let scaled = glued.iter().zip(objects);
    let scaled: Vec<(&Mesh, f32)> = scaled
        .map(|(mesh, object)| (mesh.as_ref(), object.scale))
        .collect();
    Ok(Surface::build(&scaled))
}

/// The mesh of an object with the edges glued that its settings name.
fn glued_as_set<'a>(mesh: &'a Mesh, object: &ObjectSettings) -> Result<Cow<'a, Mesh>, SceneError> {
    if object.glue.is_empty() {
        return Ok(Cow::Borrowed(mesh));
    }
    match mesh.clone().glued(&object.glue) {
        Ok(glued) => Ok(Cow::Owned(glued)),
        Err(problem) => Err(SceneError::Object {
            object: object.name.clone(),
            source: MeshError::Bad {
                place: object.mesh.clone(),
                problem,
            },
        }),
    }
}

/// Names objects without a name after their meshes, and makes names unique. The first object to which a name is given keeps it, whichever
/// come before it.
fn name_objects(objects: &mut [ObjectSettings], meshes: &[Mesh]) {
    let given = objects.iter().map(|object| object.name.trim());
    let given = given.filter(|name| !name.is_empty());
    let mut taken: HashSet<String> = given.map(str::to_owned).collect();
    // Given names of the objects so far.
    let mut kept = HashSet::new();
    // For repeated names, the next number to try: smaller ones are taken.
    let mut next: HashMap<String, u32> = HashMap::new();
    for (object, mesh) in objects.iter_mut().zip(meshes) {
        let (wanted, is_first) = match object.name.trim() {
            "" => (mesh.name.clone(), false),
            given => (given.to_owned(), kept.insert(given.to_owned())),
        };
        let mut name = wanted.clone();
        if !is_first && taken.contains(&name) {
            let n = next.entry(wanted.clone()).or_insert(2);
            while taken.contains(&name) {
                name = format!("{wanted} {n}");
                *n += 1;
            }
        }
        taken.insert(name.clone());
        object.name = name;
    }
}

/// Every value must be one that its parameter allows.
fn check_ranges(scene: &str, settings: &Settings) -> Result<(), SceneError> {
    let problems = parameters::out_of_range(settings).into_iter();
    let problems: Problems = problems.map(Problem::from).collect();
    SceneError::unless_empty(scene, problems)
}

/// The largest ratio of length to width of a triangle: in thinner ones, directions have no digits in single precision.
const THINNEST: f64 = 2e-7;

/// Refuses objects most of whose surface is triangles so thin that a particle on them has no direction.
fn check_thinness(objects: &[ObjectSettings], surface: &Surface) -> Result<(), SceneError> {
    for (object, range) in objects.iter().zip(&surface.objects) {
        let (first, end) = range.triangles;
        let (mut all, mut thin, mut thinnest) = (0.0, 0.0, f64::INFINITY);
        for shape in &surface.triangles[first as usize..end as usize] {
            let [ab, cp, ch] = [shape.ab, shape.cp, shape.ch].map(f64::from);
            let length = |p: f64| (p * p + ch * ch).sqrt();
            let longest = ab.max(length(cp)).max(length(cp - ab));
            let width = ab * ch / (longest * longest);
            all += ab * ch;
            if width < THINNEST {
                thin += ab * ch;
                thinnest = width.min(thinnest);
            }
        }
        if thin > 0.5 * all {
            return Err(SceneError::TooThin {
                object: object.name.clone(),
                times: thinnest.recip(),
            });
        }
    }
    Ok(())
}

/// Every name that an object's `distance_to` lists must be another object's.
fn check_distance_to(scene: &str, objects: &[ObjectSettings]) -> Result<(), SceneError> {
    let mut problems = Problems::default();
    let names = || objects.iter().map(|object| object.name.as_str());
    let known: HashSet<&str> = names().collect();
    for (i, object) in objects.iter().enumerate() {
        for wanted in &object.distance_to {
            if *wanted != object.name && known.contains(wanted.as_str()) {
                continue;
            }
            problems.push_with(|| Problem {
                place: String::new(),
                message: if *wanted == object.name {
                    format!("object.{i}.distance_to names the object itself")
                } else if objects.len() == 1 {
                    format!("object.{i}.distance_to: there is no other object")
                } else {
                    format!(
                        "object.{i}.distance_to: there is no object \"{wanted}\"; the others are {}",
                        listed(names().filter(|name| *name != object.name))
                    )
                },
            });
        }
    }
    SceneError::unless_empty(scene, problems)
}

fn poses(
    objects: &[ObjectSettings],
    tracks: &[Option<RigidTrack>],
    origins: &[Origins],
    time: f64,
) -> Vec<Affine3A> {
    let objects = objects.iter().zip(tracks).zip(origins);
    objects
        .map(|((object, track), origins)| {
            motion::single(pose_from(object, track.as_ref(), time, origins))
        })
        .collect()
}

/// The origins of each object: the world's origin is near the objects at the start.
fn origins(
    settings: &Settings,
    meshes: &[Mesh],
    tracks: &[Option<RigidTrack>],
    surface: &Surface,
) -> Result<Vec<Origins>, SceneError> {
    let objects = settings.objects.iter().zip(meshes);
    let mut origins: Vec<Origins> = objects
        .map(|(object, mesh)| Origins {
            surface: f64::from(object.scale) * mesh.origin,
            ..Origins::default()
        })
        .collect();
    let mut low = DVec3::INFINITY;
    let mut high = DVec3::NEG_INFINITY;
    let objects = settings.objects.iter().zip(tracks).zip(&origins);
    for (i, ((object, track), origins)) in objects.enumerate() {
        let time = settings.time.start;
        let pose = pose_from(object, track.as_ref(), time, origins);
        for corner in corners(surface.bounds(i)) {
            let place = pose.transform_point3(corner.as_dvec3());
            (low, high) = (low.min(place), high.max(place));
        }
    }
    let farthest = low.abs().max(high.abs()).max_element();
    if farthest > FARTHEST {
        return Err(SceneError::TooFar { farthest });
    }
    let world = origin::of_scene(low, high);
    for origins in &mut origins {
        origins.world = world;
    }
    Ok(origins)
}

/// The eight corners of a box.
fn corners([low, high]: [Vec3; 2]) -> impl Iterator<Item = Vec3> {
    (0..8).map(move |i| {
        let upper = glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0);
        Vec3::select(upper, high, low)
    })
}

/// The animations of the models that objects follow.
fn tracks(
    scene: &str,
    objects: &[ObjectSettings],
    folder: &Path,
) -> Result<Vec<Option<RigidTrack>>, SceneError> {
    let mut problems = Problems::default();
    let mut tracks = Vec::with_capacity(objects.len());
    for (i, object) in objects.iter().enumerate() {
        tracks.push(None);
        if object.motion.model == settings::ModelAnimation::Still {
            continue;
        }
        match RigidTrack::open(&object.mesh, folder) {
            Ok(track) => tracks[i] = Some(track),
            // By its index, because not every object has a name yet.
            Err(source) => {
                problems.push(Problem::from(format!("object.{i}.motion.model: {source}")))
            }
        }
    }
    SceneError::unless_empty(scene, problems)?;
    Ok(tracks)
}

/// The centre of the box round everything, and the distance from it to the vertex farthest away, in the world.
fn bounds(surface: &Surface, poses: &[Affine3A]) -> (Vec3, f32) {
    let vertices = || {
        surface.objects.iter().zip(poses).flat_map(|(range, pose)| {
            let (first, end) = range.vertices;
            surface.positions[first as usize..end as usize]
                .iter()
                .map(|&p| pose.transform_point3(p))
        })
    };
    let (low, high) = vertices().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| {
        (low.min(p), high.max(p))
    });
    let center = low.midpoint(high);
    (
        center,
        vertices().map(|p| p.distance(center)).fold(0.0, f32::max),
    )
}
