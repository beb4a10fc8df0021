//! The scene file as plain structs: every key with its default, nothing loaded and nothing checked.
//! [`super::file`] reads and writes them.
//!
//! Conventions, stated once: lengths are in scene radii unless a key says world units, angles are in degrees,
//! the scene's up axis is +Y. The allowed values are in [`super::parameters`], not here.

mod choices;
mod food;
mod look;
pub(super) mod physarum;
mod population;
mod pulse;
mod shown;
mod start;
mod trail;

use glam::{Affine3A, DVec3};
use serde::Serialize;

pub use choices::{
    AtlasMethod, Border, ColorMap, DepthMapping, DistanceMethod, Drawn, Easing, Heading, Model,
    ModelAnimation, ObjectStart, Preference, Repeat, RestartPlace, Sensing, SignRule, Start,
    StepOrder, Strategy, TrailAcross, Turning,
};
pub use food::{FeedingSettings, FoodSettings, MOST_FOODS};
pub use look::{SECOND_LOOKS, SecondLook, SecondLookSettings};
pub use physarum::{OwnPhysarum, PhysarumSettings};
pub use population::{MOST_POPULATION, PopulationSettings};
pub use pulse::{MOST_PULSE_ENTRIES, PulseSettings};
pub use shown::{Legend, Part, Show};
pub use start::{OwnStart, StartSettings};
pub use trail::{MOST_HALF_LIFE, OwnTrail, TrailSettings};

use super::motion::{self, MotionSettings};

/// A whole scene file. `Settings::default()` is a valid scene: one torus.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Settings {
    /// All random numbers depend on it; 0 to 4,294,967,295.
    pub seed: u64,
    /// The scene radius in world units, by which all lengths are multiplied; 0 measures it from the objects.
    pub radius: f32,
    /// How many particles there are and where they begin.
    pub particles: ParticleSettings,
    /// How particles sense, turn and walk.
    pub physarum: PhysarumSettings,
    /// How particles divide and die.
    pub population: PopulationSettings,
    /// The map of areas: places that attract, repel or may not be entered from the beginning.
    pub areas: AreaSettings,
    /// The second look, and where it is from the beginning.
    pub second_look: SecondLookSettings,
    /// How simulated time passes.
    pub time: TimeSettings,
    /// Diffusion and decay of the trail.
    pub trail: TrailSettings,
    /// The texture that holds every triangle.
    pub atlas: AtlasSettings,
    /// How particles change objects.
    pub transfer: TransferSettings,
    /// How distances between objects are taken.
    pub distance: DistanceSettings,
    /// Scattered food, and the behaviour of particles that have eaten.
    pub feeding: FeedingSettings,
    /// The camera of pictures.
    pub camera: CameraSettings,
    /// The look of pictures.
    pub picture: PictureSettings,
    /// The objects, at least one.
    #[serde(rename = "object")]
    pub objects: Vec<ObjectSettings>,
    /// Food and markers.
    #[serde(rename = "food", skip_serializing_if = "Vec::is_empty")]
    pub foods: Vec<FoodSettings>,
    /// Pulses that the scene begins by itself.
    #[serde(rename = "pulse", skip_serializing_if = "Vec::is_empty")]
    pub pulses: Vec<PulseSettings>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            seed: 7,
            radius: 0.0,
            particles: ParticleSettings::default(),
            physarum: PhysarumSettings::default(),
            population: PopulationSettings::default(),
            areas: AreaSettings::default(),
            second_look: SecondLookSettings::default(),
            time: TimeSettings::default(),
            trail: TrailSettings::default(),
            atlas: AtlasSettings::default(),
            transfer: TransferSettings::default(),
            distance: DistanceSettings::default(),
            feeding: FeedingSettings::default(),
            camera: CameraSettings::default(),
            picture: PictureSettings::default(),
            objects: vec![ObjectSettings::default()],
            foods: Vec::new(),
            pulses: Vec::new(),
        }
    }
}

/// `[particles]`
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParticleSettings {
    /// The number of particles on all objects together.
    pub count: u32,
    /// Their start places.
    pub start: Start,
    /// For `point`, `ring` and `disc`: the surface point nearest to this place, in scene radii from the scene's centre.
    pub start_at: [f32; 3],
    /// For `ring` and `disc`: how far along the surface from that point particles begin, in scene radii.
    pub start_radius: f32,
    /// The name of the only object that they begin on; empty for all.
    pub start_object: String,
    /// For `food`: which one, counted from 0; scattered ones come after the others.
    pub start_food: u32,
    /// For `mask`: a greyscale picture of the texture; a path relative to the scene file.
    pub start_mask: String,
    /// Their headings at the start.
    pub start_heading: Heading,
    /// For the heading `aligned`: a direction in the world.
    pub start_direction: [f32; 3],
}

impl Default for ParticleSettings {
    fn default() -> Self {
        Self {
            count: 500_000,
            start: Start::Uniform,
            start_at: [0.0, 1.0, 0.0],
            start_radius: 0.25,
            start_object: String::new(),
            start_food: 0,
            start_mask: String::new(),
            start_heading: Heading::Auto,
            start_direction: [1.0, 0.0, 0.0],
        }
    }
}

/// `[areas]`
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AreaSettings {
    /// A picture of the texture; a path relative to the scene file, empty for none.
    pub map: String,
    /// Trail units that sensors read more where the map is fully green, and less where it is fully blue.
    pub strength: f32,
}

impl Default for AreaSettings {
    fn default() -> Self {
        Self {
            map: String::new(),
            strength: 20.0,
        }
    }
}

/// `[time]`
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TimeSettings {
    /// Seconds of the objects' motion that pass in a step.
    pub dt: f32,
    /// Seconds of their motion before the first step; in single precision late ones would be milliseconds apart.
    pub start: f64,
    /// The most steps a second in the window; 0 for no cap.
    pub steps_per_second: f32,
}

impl Default for TimeSettings {
    fn default() -> Self {
        Self {
            dt: 1.0 / 60.0,
            start: 0.0,
            steps_per_second: 0.0,
        }
    }
}

/// `[atlas]`
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AtlasSettings {
    /// How triangles are laid out.
    pub method: AtlasMethod,
    /// Side of the square texture, in texels.
    pub size: u32,
    /// For `grid`: side of a cell in texels; 0 for the largest that fits.
    pub cell_size: u32,
}

impl Default for AtlasSettings {
    fn default() -> Self {
        Self {
            method: AtlasMethod::Charts,
            size: 1024,
            cell_size: 0,
        }
    }
}

/// `[transfer]`
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TransferSettings {
    /// The strategy for particles that go into another object.
    pub strategy: Strategy,
    /// For `respawn`: where particles restart.
    pub respawn: RestartPlace,
    /// Places with a smaller signed distance to other objects are covered, in scene radii.
    pub threshold: f32,
    /// How many particles may change objects in a step.
    pub buffer_size: u32,
}

impl Default for TransferSettings {
    fn default() -> Self {
        Self {
            strategy: Strategy::Parallel,
            respawn: RestartPlace::Anywhere,
            threshold: 0.0,
            buffer_size: 65_536,
        }
    }
}

/// `[distance]`
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DistanceSettings {
    /// How the nearest triangle is found.
    pub method: DistanceMethod,
    /// For `raster`: how distances become depths.
    pub depth: DepthMapping,
    /// For `clip`: how far the eye is before the near plane, in scene radii.
    pub depth_near: f32,
    /// For `logistic` and `arctangent`: the distance that the curve takes as 1, in scene radii; 0 for a quarter of the reach.
    pub depth_scale: f32,
    /// The rule that decides whether a place is inside of an object.
    pub sign: SignRule,
    /// Distances are updated at most every so many steps.
    pub interval: u32,
    /// Distances between objects are clamped beyond this, in scene radii.
    pub reach: f32,
}

impl Default for DistanceSettings {
    fn default() -> Self {
        Self {
            method: DistanceMethod::Bvh,
            depth: DepthMapping::Ordered,
            depth_near: 0.01,
            depth_scale: 0.0,
            sign: SignRule::Pseudonormal,
            interval: 1,
            reach: 0.2,
        }
    }
}

/// `[camera]`: an orbit about a target.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CameraSettings {
    /// Degrees about the up axis; 0 looks along -Z, positive goes round to the right.
    pub azimuth: f32,
    /// Degrees above the horizon.
    pub elevation: f32,
    /// From the target, in scene radii; 0 for the distance at which all objects fit into the picture.
    pub distance: f32,
    /// The point that the camera looks at, in scene radii from the scene's centre.
    pub target: [f32; 3],
    /// Vertical field of view, in degrees.
    pub field_of_view: f32,
}

impl Default for CameraSettings {
    fn default() -> Self {
        Self {
            azimuth: 35.0,
            elevation: 25.0,
            distance: 0.0,
            target: [0.0; 3],
            field_of_view: 40.0,
        }
    }
}

/// The background of pictures unless a scene sets another: the one that goes with the colour map.
pub const USUAL_BACKGROUND: [f32; 3] = [0.055, 0.06, 0.075];

/// `[picture]`
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PictureSettings {
    /// Trail value that gets the brightest colour; 0 takes it from the picture's own range.
    pub brightest: f32,
    /// Share of the brightest trail up to which everything has the darkest colour, 0 to 0.99.
    pub darkest: f32,
    /// The view.
    pub show: Show,
    /// Colours of the trail.
    pub color_map: ColorMap,
    /// The strength of the atlas's charts: 0 hides them, 0.5 shows them under the trail, 1 shows only them.
    pub charts: f32,
    /// Diameter of a drawn particle, in pixels.
    pub particle_size: f32,
    /// Direction of the key light, seen from the camera: degrees to the right, and above.
    pub light_azimuth: f32,
    /// Degrees above the camera.
    pub light_elevation: f32,
    /// The strength of ambient occlusion, 0 to 1.
    pub occlusion: f32,
    /// How strongly bright trail shines beyond its edges, 0 to 4.
    pub bloom: f32,
    /// How wet the surface is, 0 to 1.
    pub wetness: f32,
    /// Is the ground under the objects drawn?
    pub ground: Drawn,
    /// Are food and markers drawn?
    pub food: Drawn,
    /// Are the areas drawn that were painted to attract, to repel or as no-go?
    pub areas: Drawn,
    /// The background: red, green and blue in sRGB, 0 to 1.
    pub background: [f32; 3],
}

impl Default for PictureSettings {
    fn default() -> Self {
        Self {
            brightest: 0.0,
            darkest: 0.0,
            show: Show::default(),
            color_map: ColorMap::Myxo,
            charts: 0.0,
            particle_size: 1.5,
            light_azimuth: -40.0,
            light_elevation: 41.0,
            occlusion: 0.7,
            bloom: 1.0,
            wetness: 0.7,
            ground: Drawn::Shown,
            food: Drawn::Shown,
            areas: Drawn::Shown,
            background: USUAL_BACKGROUND,
        }
    }
}

/// The most objects of a scene: the host plans distances for all pairs.
pub const MOST_OBJECTS: usize = 4096;

/// `[[object]]`: a mesh and its pose.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObjectSettings {
    /// The object's name; empty takes the mesh's name.
    pub name: String,
    /// `builtin:NAME`, or a path relative to the scene file.
    pub mesh: String,
    /// World units.
    pub position: [f64; 3],
    /// Degrees about X, then Y, then Z, each about the world's axis.
    pub rotation: [f32; 3],
    /// Multiplies the mesh's coordinates; positive.
    pub scale: f32,
    /// For `charts`: texels per surface area, relative to the other objects.
    pub texel_weight: f32,
    /// The names of the objects whose distance counts for this one; empty for all others.
    pub distance_to: Vec<String>,
    /// Pairs of border edges of its mesh that are glued: a face and its edge, then the other face and its edge.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub glue: Vec<[u32; 4]>,
    /// The start of its particles, if it differs from the scene's.
    #[serde(skip_serializing_if = "OwnStart::is_default")]
    pub start: OwnStart,
    /// How it moves.
    #[serde(skip_serializing_if = "MotionSettings::is_default")]
    pub motion: MotionSettings,
    /// Parameters of its particles that differ from the scene's.
    #[serde(skip_serializing_if = "OwnPhysarum::is_empty")]
    pub physarum: OwnPhysarum,
    /// How its trail spreads and decays, where that differs from the scene's.
    #[serde(skip_serializing_if = "OwnTrail::is_empty")]
    pub trail: OwnTrail,
}

impl Default for ObjectSettings {
    fn default() -> Self {
        Self {
            name: String::new(),
            mesh: "builtin:torus".to_owned(),
            position: [0.0; 3],
            rotation: [0.0; 3],
            scale: 1.0,
            texel_weight: 1.0,
            distance_to: Vec::new(),
            glue: Vec::new(),
            start: OwnStart::default(),
            motion: MotionSettings::default(),
            physarum: OwnPhysarum::default(),
            trail: OwnTrail::default(),
        }
    }
}

impl Settings {
    /// Gives the objects these names, and with them all that names objects: whose distance counts, where particles begin, food.
    ///
    /// # Panics
    /// If there are not as many names as objects.
    pub fn rename_objects(&mut self, names: &[String]) {
        assert_eq!(names.len(), self.objects.len(), "there is a name for each");
        let before: Vec<String> = { self.objects.iter() }
            .map(|object| object.name.clone())
            .collect();
        let rename = |name: &mut String| {
            if let Some(place) = before.iter().position(|before| before == name) {
                name.clone_from(&names[place]);
            }
        };
        for object in &mut self.objects {
            rename(&mut object.name);
            object.distance_to.iter_mut().for_each(rename);
        }
        rename(&mut self.particles.start_object);
        self.foods
            .iter_mut()
            .for_each(|food| rename(&mut food.object));
    }
}

impl ObjectSettings {
    /// The pose before any motion: maps scaled object coordinates to world coordinates. It does not contain the
    /// scale.
    #[must_use]
    pub fn world_from_object(&self) -> Affine3A {
        let rotation = motion::euler(self.rotation).as_quat();
        let position = DVec3::from_array(self.position);
        Affine3A::from_rotation_translation(rotation, position.as_vec3())
    }
}
