//! A scene before its first step: the surface, its atlas and the particles at their start.
//! The GPU simulation and the CPU twins begin from one setup.

use std::ops::{Deref, DerefMut};
use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::areas::AreaMap;
use super::cells::{check_room, check_rules, homes, nests};
use super::distance::DistanceSetup;
use super::food::{FoodSet, places};
use super::looks::weights_of;
use super::sorting::Bins;
use super::spread_length::{self, check_lengths};
use super::start::{self, Lots, Masks, Starts};
use super::surroundings::surroundings;
use super::types::{Motion, Particle, Population, Pose, Vertex};
use crate::error::Result;
use crate::mesh::RigidTrack;
use crate::mesh::atlas::{Atlas, AtlasOptions, Control};
use crate::mesh::strip::StripTriangle;
use crate::mesh::surface::{ObjectRange, Surface};
use crate::rng::seed_word;
use crate::scene::motion::Origins;
use crate::scene::settings::Settings;
use crate::scene::{BUILTIN, Scene};

/// Names of work in progress reports: particles get their places.
pub const STARTING: &str = "starting particles";
/// Names of work in progress reports: how far lines in the texture stay on the surface.
pub const LOOKING: &str = "measuring charts";

/// The state of a scene at step 0, on the host. But for food it is a [`FixedSetup`], whose fields are also those of the set-up. A clone
/// shares it until either is changed.
#[derive(Clone, Debug)]
pub struct Setup {
    fixed: Arc<FixedSetup>,
    /// Food and markers; a running simulation may replace them.
    pub food_set: FoodSet,
}

/// What no other food changes of a scene's state at step 0: surface, atlas, particles, and what follows from them.
#[derive(Clone, Debug)]
pub struct FixedSetup {
    /// All objects, pooled.
    pub surface: Surface,
    /// The place of every triangle in the trail's texture.
    pub atlas: Atlas,
    /// Particles at their start, dead ones among them; the slot is the id.
    pub particles: Vec<Particle>,
    /// Their headings.
    pub motions: Vec<Motion>,
    /// How many of them are alive, if their number changes.
    pub population: Option<Population>,
    /// Per texel: radius in texels within which straight lines stay on the surface around it.
    pub clearance: Vec<u8>,
    /// Per texel: the distance up to which straight lines to places of its chart are walks on the surface, its chart's hue, and marks for
    /// places near other objects.
    pub surroundings: Vec<u16>,
    /// Per texel its cell, the owned texel that stands for it; empty if no rule of the scene asks for it.
    pub homes: Vec<u32>,
    /// Per texel the triangle on which particles are born in it, or `NONE`; empty if their number is constant.
    pub nests: Vec<u32>,
    /// Side of a texel, world units, on the object that has the largest, on average.
    pub texel_side: f32,
    /// The data that walks read, triangle by triangle, and the bins for sorting particles on it.
    pub strips: Vec<StripTriangle>,
    /// The number of bins, and the size of their tiles.
    pub bins: Bins,
    /// Three vertex indices per triangle.
    pub corners: Vec<u32>,
    /// Object space.
    pub vertices: Vec<Vertex>,
    /// Per texel: trail units that are added to sensor readings, by the scene's area map; empty if it has none.
    pub bias: Vec<f32>,
    /// Per texel: the weight of the second look, by the scene's map of it; empty if it has none.
    pub looks: Vec<f32>,
    /// World from object at step 0, one per object.
    pub poses: Vec<Pose>,
    /// The animations that objects follow, one per object.
    pub tracks: Vec<Option<RigidTrack>>,
    /// The origins of coordinates, one per object.
    pub origins: Vec<Origins>,
    /// The surface area of each object, world units squared.
    pub object_areas: Vec<f64>,
    /// Data for distances between objects.
    pub distance: DistanceSetup,
    /// Scene radius, world units: what lengths in settings are multiplied by.
    pub radius: f32,
    /// Centre of the scene, in world space: what places in scene radii are counted from.
    pub center: Vec3,
}

impl Deref for Setup {
    type Target = FixedSetup;

    fn deref(&self) -> &FixedSetup {
        &self.fixed
    }
}

impl DerefMut for Setup {
    fn deref_mut(&mut self) -> &mut FixedSetup {
        Arc::make_mut(&mut self.fixed)
    }
}

impl Setup {
    /// This set-up with other food. It shares everything else.
    #[must_use]
    pub fn with_food(&self, food_set: FoodSet) -> Self {
        Self {
            fixed: Arc::clone(&self.fixed),
            food_set,
        }
    }

    /// Warnings where a diffusion length is set and the trail does not spread by it.
    #[must_use]
    pub fn diffusion_warnings(&self, settings: &Settings) -> Vec<String> {
        spread_length::diffusion_warnings(&self.surface, &self.atlas, settings)
    }

    /// Lays out the atlas and starts the particles.
    ///
    /// # Errors
    /// When the texture has no room for the triangles (the message names a size that has), a start's mask or the area map cannot be read,
    /// a food is too far from its object, or the diffusion length is more than four texels. With one particle a cell, when there are more
    /// particles than cells, or particles restart, wherever they do.
    pub fn new(scene: &Scene) -> Result<Self> {
        Self::with_control(scene, &Control::default())
    }

    /// The origin of world coordinates.
    #[must_use]
    pub fn origin(&self) -> DVec3 {
        // All objects have one world origin.
        self.origins
            .first()
            .map_or(DVec3::ZERO, |origins| origins.world)
    }

    /// As [`new`](Self::new). `control` gets the progress, can cancel the work, and names the folder in which the layout of the
    /// atlas is kept.
    ///
    /// # Errors
    /// As [`new`](Self::new), and when it was stopped.
    pub fn with_control(scene: &Scene, control: &Control<'_>) -> Result<Self> {
        let settings = &scene.settings;
        check_rules(settings)?;
        let masks = Masks::open(scene)?;
        let map = area_map(scene)?;
        let foods = places(settings, &scene.surface, &scene.origins, scene.radius)?;
        let shares = if foods.is_empty() {
            [0.92, 0.95, 0.98, 1.0]
        } else {
            [0.7, 0.72, 0.75, 0.77]
        };
        let atlas = control.part(0.0..shares[0], |control| {
            Atlas::build_with(&scene.surface, &atlas_options(settings), control)
        })?;
        check_room(settings, &atlas)?;
        check_lengths(settings, scene.radius, &atlas)?;
        control.step(STARTING, shares[0])?;
        let (homes, nests) = homes_and_nests(settings, &atlas);
        let starts = Starts::of(scene, &atlas, &masks, &foods)?;
        let (particles, motions) = start_particles(scene, &atlas, &starts, &homes, control)?;
        let population = settings.population.is_on().then(|| Population {
            living: settings.particles.count,
            ..Population::default()
        });
        control.step(LOOKING, shares[1])?;
        let clearance = atlas.clearances(&scene.surface);
        let outlooks = atlas.outlooks(&scene.surface, &clearance);
        let surroundings = surroundings(&atlas, &outlooks);
        let bias = map.map(|map| map.bias(&atlas, settings.areas.strength));
        let bias = bias.transpose()?;
        let looks = look_weights(scene, &atlas)?;
        control.step(LOOKING, shares[2])?;
        let mut strips = scene.surface.strips(&atlas.maps);
        let bins = Bins::number(&mut strips, particles.len());
        let distance = DistanceSetup::new(&scene.surface, &atlas, others(settings));
        let food_set = control.part(shares[3]..1.0, |control| {
            FoodSet::new(&scene.surface, &atlas, foods, None, control)
        })?;
        let food_set = food_set.crossing(settings.scent_crosses());
        let poses = scene.world_from_object().into_iter().map(Pose::from);
        let fixed = FixedSetup {
            clearance,
            surroundings,
            homes,
            nests,
            bias: bias.unwrap_or_default(),
            looks,
            texel_side: texel_side(&atlas, &distance),
            strips,
            bins,
            corners: scene.surface.corners.as_flattened().to_vec(),
            vertices: Vertex::of(&scene.surface),
            poses: poses.collect(),
            tracks: scene.tracks.clone(),
            origins: scene.origins.clone(),
            object_areas: object_areas(&scene.surface),
            distance,
            surface: scene.surface.clone(),
            radius: scene.radius,
            center: scene.center,
            atlas,
            particles,
            motions,
            population,
        };
        Ok(Self {
            fixed: Arc::new(fixed),
            food_set,
        })
    }
}

/// The scene's area map, if it has one.
fn area_map(scene: &Scene) -> Result<Option<AreaMap>> {
    let map = &scene.settings.areas.map;
    if map.is_empty() {
        return Ok(None);
    }
    let path = match map.starts_with(BUILTIN) {
        true => map.into(),
        false => scene.folder.join(map),
    };
    AreaMap::open(&path, scene.settings.atlas.size).map(Some)
}

/// Homes and nests of texels, each empty if the scene does not need them.
fn homes_and_nests(settings: &Settings, atlas: &Atlas) -> (Vec<u32>, Vec<u32>) {
    let has_population = settings.population.is_on();
    let homes = if settings.physarum.rules().has_cells() || has_population {
        homes(atlas)
    } else {
        Vec::new()
    };
    let nests = if has_population {
        nests(atlas, &homes)
    } else {
        Vec::new()
    };
    (homes, nests)
}

/// Particles at their start, dead ones among them, and their motions.
fn start_particles(
    scene: &Scene,
    atlas: &Atlas,
    starts: &Starts,
    homes: &[u32],
    control: &Control<'_>,
) -> Result<(Vec<Particle>, Vec<Motion>)> {
    let settings = &scene.settings;
    let seed = seed_word(settings.seed);
    let lots = Lots::new(&scene.surface, starts, seed);
    let (mut particles, mut motions) = lots.all(settings.slots(), control)?;
    // The others are dead, and lie where they would have begun.
    let living = settings.particles.count as usize;
    if settings.physarum.rules().is_crowded() {
        let both = (&mut particles[..living], &mut motions[..living]);
        let draw_again = |id, object, attempt| lots.draw_again(id, object, attempt);
        start::apart(both, &scene.surface, atlas, homes, draw_again, control)?;
    }
    for motion in &mut motions[living..] {
        motion.flags = Motion::DEAD;
    }
    Ok((particles, motions))
}

/// Weights of the second look, by the scene's map of it; empty if it has none.
fn look_weights(scene: &Scene, atlas: &Atlas) -> Result<Vec<f32>> {
    let map = &scene.settings.second_look.map;
    match map.is_empty() {
        true => Ok(Vec::new()),
        false => weights_of(&scene.folder.join(map), atlas),
    }
}

fn object_areas(surface: &Surface) -> Vec<f64> {
    let area = |range: &ObjectRange| -> f64 {
        let (first, end) = range.triangles;
        (first..end).map(|triangle| surface.area(triangle)).sum()
    };
    surface.objects.iter().map(area).collect()
}

/// Side of a texel on the object that has the largest, on average.
fn texel_side(atlas: &Atlas, distance: &DistanceSetup) -> f32 {
    let areas = distance.ranges.iter().map(|&(first, end)| {
        let own = &distance.samples[first as usize..end as usize];
        let areas = own
            .iter()
            .map(|sample| atlas.mean_texel_area / f64::from(atlas.density[sample.texel as usize]));
        areas.sum::<f64>() / own.len().max(1) as f64
    });
    areas.fold(atlas.mean_texel_area, f64::max).sqrt() as f32
}

/// The settings' options of the atlas.
#[must_use]
pub fn atlas_options(settings: &Settings) -> AtlasOptions {
    AtlasOptions {
        method: settings.atlas.method,
        size: settings.atlas.size,
        cell_size: settings.atlas.cell_size,
        gutter: (settings.trail.diffusion_distance)
            .max(settings.physarum.rules().reach.unwrap_or(0))
            .max(settings.population.reach())
            .max(1),
        taps: settings.trail.diffusion_distance,
        weights: weights(settings),
        turn: 0,
    }
}

/// None if all are equal, so that the atlas does not depend on their value.
fn weights(settings: &Settings) -> Vec<f32> {
    let weights = settings.objects.iter().map(|object| object.texel_weight);
    let weights: Vec<f32> = weights.collect();
    if weights.iter().all(|weight| *weight == weights[0]) {
        return Vec::new();
    }
    weights
}

/// For each object, the others that its distances are taken to.
pub(super) fn others(settings: &Settings) -> Vec<Vec<u32>> {
    let objects = &settings.objects;
    let counts = |of: usize, other: usize| {
        let names = &objects[of].distance_to;
        other != of && (names.is_empty() || names.contains(&objects[other].name))
    };
    let all = 0..objects.len();
    all.clone()
        .map(|object| {
            let others = all.clone().filter(|&other| counts(object, other));
            others.map(|other| other as u32).collect()
        })
        .collect()
}

impl Vertex {
    /// The data of all objects of a surface.
    #[must_use]
    pub fn of(surface: &Surface) -> Vec<Self> {
        let objects = surface.objects.iter().enumerate();
        let vertices = objects.flat_map(|(object, range)| {
            let (first, end) = range.vertices;
            let positions = &surface.positions[first as usize..end as usize];
            positions.iter().map(move |&position| Self {
                position,
                object: object as u32,
            })
        });
        vertices.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::settings::{AtlasMethod, ObjectSettings};

    /// Would catch: other food that copies surface and atlas, which takes long where another thread shares them, and a change that reaches
    /// those who share them.
    #[test]
    fn other_food_shares_the_rest_of_a_setup() {
        let mut settings = Settings::default();
        settings.particles.count = 10;
        settings.atlas.size = 64;
        settings.objects[0].mesh = "builtin:cube".to_owned();
        let scene = Scene::from_settings("cube".to_owned(), settings, "".into()).unwrap();
        let setup = Setup::new(&scene).unwrap();
        let mut other = setup.with_food(FoodSet::default());
        assert!(std::ptr::eq(&setup.atlas, &other.atlas));
        let radius = setup.radius;
        other.radius = 2.0 * radius;
        assert_eq!([setup.radius, other.radius], [radius, 2.0 * radius]);
    }

    #[test]
    fn a_heavier_object_has_more_texels_for_its_area() {
        let mut settings = Settings::default();
        settings.particles.count = 10;
        settings.atlas.method = AtlasMethod::Charts;
        settings.atlas.size = 256;
        settings.objects = ["builtin:cube?divisions=4", "builtin:plane?columns=8&rows=8"]
            .map(|mesh| ObjectSettings {
                mesh: mesh.to_owned(),
                ..ObjectSettings::default()
            })
            .to_vec();
        let ratio = |settings: &Settings| {
            let name = "two".to_owned();
            let scene = Scene::from_settings(name, settings.clone(), "".into()).unwrap();
            let setup = Setup::new(&scene).unwrap();
            let (surface, atlas) = (&setup.surface, &setup.atlas);
            let [first, second] = [0, 1].map(|object: usize| {
                let (start, end) = surface.objects[object].triangles;
                let sum = |part: &dyn Fn(usize) -> f32| -> f32 {
                    (start as usize..end as usize).map(part).sum()
                };
                let texels = sum(&|t| atlas.maps[t].du.perp_dot(atlas.maps[t].dv));
                texels / sum(&|t| surface.triangles[t].ab * surface.triangles[t].ch)
            });
            second / first
        };
        assert!(atlas_options(&settings).weights.is_empty());
        assert!((ratio(&settings) - 1.0).abs() < 0.02);
        settings.objects[1].texel_weight = 4.0;
        assert_eq!(atlas_options(&settings).weights, [1.0, 4.0]);
        assert!(
            (ratio(&settings) / 4.0 - 1.0).abs() < 0.05,
            "{}",
            ratio(&settings)
        );
        // Equal weights have no effect.
        settings.objects[0].texel_weight = 4.0;
        assert!(atlas_options(&settings).weights.is_empty());
    }
}
