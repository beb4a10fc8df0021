//! From a scene's settings to the numbers that kernels take: scene radii become world lengths, degrees become
//! cosines and sines. The twins take the same.

use super::distance::{DistancePlanner, DistanceRules, DistanceUpdate, TILE_SAMPLES};
use super::draws::DistanceRasterConstants;
use super::kernels::{
    Advance, AdvanceConstants, AdvanceParams, DiffuseConstants, DiffuseParams,
    DiffuseSeamsConstants, DiffuseSeamsParams, DistanceBruteConstants, DistanceBruteParams,
    DistanceConstants, DistanceMergeConstants, DistanceMergeParams, DistanceParams,
    DistanceTilesConstants, DistanceTilesParams, ExchangeSeamsConstants, ExchangeSeamsParams,
    MoveBorderConstants, ScentConstants, SortCountConstants, SortScatterConstants,
    TransferOutConstants, UnfoldConstants, UnfoldParams,
};
use super::setup::Setup;
use super::sorting::SortParams;
use super::texel_paths::TexelPaths;
use super::turns::{Turn, border_constants, departure_constants};
use super::types::{Physarum, Pose};
use crate::gpu::Kernel;
use crate::mesh::atlas::{Atlas, BLOCK_QUADS, GREATEST_DENSITY, GREATEST_DIFFUSION};
use crate::scene::settings::{
    Border, DistanceMethod, PhysarumSettings, Sensing, Settings, Strategy,
};

/// Trail values below this become zero. Decay turns them into denormal numbers, which some devices are 4 to 8 times
/// slower with, and nobody can see them.
pub const TINY_TRAIL: f32 = 1e-20;

/// All sensors walk.
pub const SENSORS_WALK: u32 = 0;
/// Sensors go straight ahead in the atlas, and particles that cannot do that are listed.
pub const SENSORS_STRAIGHT: u32 = 1;
/// The sensors of those walk.
const SENSORS_WALK_LISTED: u32 = 2;
/// Those of particles that were listed because they are near other objects go straight ahead.
const SENSORS_STRAIGHT_LISTED: u32 = 3;
/// Those of particles that were listed for both walk.
const SENSORS_WALK_NEAR: u32 = 4;

/// How far from its texel's centre a texel's distance may be another by reading between texels, in texel sides.
const TEXELS_BETWEEN: f32 = 2.0;

/// Groups that every device takes along one axis of a dispatch.
const GROUPS_A_ROW: u32 = 65_535;

/// Everything that one step's kernels take besides buffers.
#[derive(Clone, Debug)]
pub struct StepParams {
    /// Which distances are taken anew; none at first.
    pub distance_update: DistanceUpdate,
    /// For `distance_tiles`.
    pub distance_tiles: DistanceTilesParams,
    /// How they are taken.
    pub distance_method: DistanceMethod,
    /// For `distance`.
    pub distance: DistanceParams,
    /// For `distance_brute`.
    pub distance_brute: DistanceBruteParams,
    /// For `distance_merge`, in the first round.
    pub distance_merge: DistanceMergeParams,
    /// For `unfold`.
    pub unfold: UnfoldParams,
    /// Do sensors see other objects where these cover what they get to?
    pub sees_across: bool,
    /// The objects' turns, or one for all of them.
    pub turn: Turn,
    /// For `diffuse`; in two halves of a step for the second of them.
    pub diffuse: DiffuseParams,
    /// For `diffuse_seams`, likewise.
    pub diffuse_seams: DiffuseSeamsParams,
    /// Does the trail spread in two halves of a step?
    pub in_halves: bool,
    /// For `exchange_seams`.
    pub exchange_seams: ExchangeSeamsParams,
    /// For the kernels that sort particles, where that is due.
    pub sort: Option<SortParams>,
}

/// What is compiled into the kernels; a change makes new pipelines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepConstants {
    /// For `advance`.
    pub advance: AdvanceConstants,
    /// For `walk_sensors`, where sensors need not all walk.
    pub walk_sensors: Option<AdvanceConstants>,
    /// For `advance_near`, where the others see no other object.
    pub advance_near: Option<AdvanceConstants>,
    /// For `walk_near`, likewise.
    pub walk_near: Option<AdvanceConstants>,
    /// For `move_border`.
    pub move_border: MoveBorderConstants,
    /// For `transfer_out`.
    pub transfer_out: TransferOutConstants,
    /// For `unfold`.
    pub unfold: UnfoldConstants,
    /// For `diffuse`.
    pub diffuse: DiffuseConstants,
    /// For `diffuse_seams`.
    pub diffuse_seams: DiffuseSeamsConstants,
    /// For `exchange_seams`.
    pub exchange_seams: ExchangeSeamsConstants,
    /// For `sort_count`.
    pub sort_count: SortCountConstants,
    /// For `sort_scatter`.
    pub sort_scatter: SortScatterConstants,
    /// For `distance_tiles`.
    pub distance_tiles: DistanceTilesConstants,
    /// For `distance`.
    pub distance: DistanceConstants,
    /// For `distance_brute`.
    pub distance_brute: DistanceBruteConstants,
    /// For `distance_raster`, where distances are taken by it.
    pub distance_raster: Option<DistanceRasterConstants>,
    /// For `distance_merge`.
    pub distance_merge: DistanceMergeConstants,
    /// For `scent`, where there is food.
    pub scent: Option<ScentConstants>,
}

impl StepConstants {
    /// The optional terms that these settings use, for a texture that kernels get at by these ways.
    #[must_use]
    pub fn new(settings: &Settings, paths: TexelPaths) -> Self {
        let TexelPaths {
            in_quads: texels_in_quads,
            band,
            outgrows_block,
        } = paths;
        let sign_rule = settings.distance.sign as u32;
        let objects = settings.objects.iter();
        let kinds: Vec<PhysarumSettings> = objects
            .map(|object| object.physarum.over(&settings.physarum))
            .collect();
        let any = |uses: fn(&PhysarumSettings) -> bool| kinds.iter().any(uses);
        let gravity = any(|p| p.gravity_weight != 0.0);
        // Heights are those of triangles, and only a walk knows at which one it ends.
        let straight = settings.physarum.sensing == Sensing::Auto && !gravity;
        let advance = AdvanceConstants {
            sensor_noise: any(|p| p.sensor_noise > 0.0),
            favourite_density: any(|p| p.favourite_density > 0.0),
            gravity,
            decrowding: any(|p| p.decrowding_weight != 0.0),
            distance: any(|p| p.distance_weight != 0.0) && settings.objects.len() > 1,
            border_reflects: settings.physarum.border == Border::Reflect,
            selects: settings.strategy() != Strategy::None,
            turns: settings.strategy().has_turns(),
            windows: settings.strategy().has_windows(),
            own_physarum: settings.objects.iter().any(|o| !o.physarum.is_empty()),
            across: sees_across(settings),
            sensing: if straight {
                SENSORS_STRAIGHT
            } else {
                SENSORS_WALK
            },
            texels_in_quads,
            outgrows_block,
            band,
            painted: false,
            food: settings.food_count() > 0,
        };
        Self {
            advance,
            scent: (settings.food_count() > 0).then_some(ScentConstants {
                texels_in_quads,
                band,
            }),
            walk_sensors: straight.then_some(AdvanceConstants {
                sensing: SENSORS_WALK_LISTED,
                ..advance
            }),
            advance_near: (straight && advance.across).then_some(AdvanceConstants {
                sensing: SENSORS_STRAIGHT_LISTED,
                ..advance
            }),
            walk_near: (straight && advance.across).then_some(AdvanceConstants {
                sensing: SENSORS_WALK_NEAR,
                ..advance
            }),
            unfold: UnfoldConstants {
                border_reflects: settings.physarum.border == Border::Reflect,
                listed: settings.distance.method == DistanceMethod::Bvh,
            },
            move_border: border_constants(settings),
            transfer_out: departure_constants(settings, texels_in_quads),
            distance_tiles: DistanceTilesConstants { sign_rule },
            distance: DistanceConstants {
                sign_rule,
                sees_across: sees_across(settings),
            },
            distance_brute: DistanceBruteConstants { sign_rule },
            distance_raster: settings.uses_raster().then_some(DistanceRasterConstants {
                depth: settings.distance.depth as u32,
            }),
            distance_merge: DistanceMergeConstants { sign_rule },
            sort_count: SortCountConstants {
                windows: settings.strategy().has_windows(),
            },
            sort_scatter: SortScatterConstants {
                windows: settings.strategy().has_windows(),
            },
            diffuse: DiffuseConstants {
                distance: settings.trail.diffusion_distance as i32,
                outgrows_block,
            },
            diffuse_seams: DiffuseSeamsConstants {
                texels_in_quads,
                band,
            },
            exchange_seams: ExchangeSeamsConstants {
                texels_in_quads,
                band,
            },
        }
    }
}

impl StepConstants {
    /// The same where there is a bias that sensors read, or none.
    #[must_use]
    pub fn with_bias(mut self, painted: bool) -> Self {
        let forms = [
            Some(&mut self.advance),
            self.walk_sensors.as_mut(),
            self.advance_near.as_mut(),
            self.walk_near.as_mut(),
        ];
        (forms.into_iter().flatten()).for_each(|form| form.painted = painted);
        self.transfer_out.painted = painted;
        self
    }
}

impl StepParams {
    /// The parameters of step number `step`, counted from 0, with lists for `capacity` transfers.
    #[must_use]
    pub fn new(settings: &Settings, setup: &Setup, step: u64, capacity: u32) -> Self {
        let physarum = &settings.physarum;
        let atlas = &setup.atlas;
        let radius = setup.radius;
        let first_vertex_normal = setup.surface.halfedges.len() as u32;
        let in_halves = settings.trail.diffusion > GREATEST_DIFFUSION;
        let diffusion = settings.trail.diffusion * if in_halves { 0.5 } else { 1.0 };
        let factor = deposit_factor(settings, setup);
        let everywhere = physarum_row(physarum, radius, factor);
        let advance = AdvanceParams {
            particle_count: setup.particles.len() as u32,
            seed: seed_word(settings.seed),
            // Streams repeat after 2^32 steps: over two years at 60 steps a second.
            time_step: step as u32,
            attempts: physarum.edge_crossing_attempts,
            pitch: atlas.pitch,
            speed: everywhere.speed,
            sensor_offset: everywhere.sensor_offset,
            sensor_cos: everywhere.sensor_cos,
            sensor_sin: everywhere.sensor_sin,
            rotation_cos: everywhere.rotation_cos,
            rotation_sin: everywhere.rotation_sin,
            sensor_noise: everywhere.sensor_noise,
            favourite_density: everywhere.favourite_density,
            gravity_weight: everywhere.gravity_weight,
            decrowding_weight: everywhere.decrowding_weight,
            distance_weight: everywhere.distance_weight,
            last_texel: (atlas.size - 1) as f32,
            outlook_unit: atlas.outlook_unit(),
            walker_rows: (setup.particles.len() as u32)
                .div_ceil(Advance::GROUP_SIZE)
                .div_ceil(GROUPS_A_ROW)
                .max(1),
            fed_steps: settings.feeding.fed_steps,
            fed_deposit: settings.feeding.fed_deposit,
            fed_attraction: settings.feeding.fed_attraction,
            ..AdvanceParams::default()
        };
        let reach = settings.distance.reach * radius;
        // Sensors get no farther behind a crossing than they are away; nothing is known beyond reach.
        let farthest = sensor_offsets(settings).fold(0.0, f32::max) * radius;
        let advance = AdvanceParams {
            deepest: -farthest.min(reach),
            ..advance
        };
        let turn = Turn::new(settings, setup, advance, capacity);
        let fastest = speeds(settings).fold(0.0, f32::max) * radius;
        let near = turn.advance.transfer_threshold + fastest + TEXELS_BETWEEN * setup.texel_side;
        // A walk that is pending comes before that of the sensors, or of the step.
        // Where it is longer than the reach, everything is in sight: no distance is known that is longer than that.
        let sight = near + farthest.max(fastest);
        Self {
            distance_update: DistanceUpdate::default(),
            distance_tiles: DistanceTilesParams {
                tile_count: 0,
                job_count: 0,
                first_vertex_normal,
                hint_count: setup.distance.hint_count(),
                reach,
                is_first: 0,
            },
            distance_method: settings.distance.method,
            distance: DistanceParams {
                tile_count: 0,
                first_vertex_normal,
                hint_count: setup.distance.hint_count(),
                reach,
                threshold: turn.advance.transfer_threshold,
                deepest: turn.advance.deepest,
                near,
                sight,
            },
            distance_brute: DistanceBruteParams {
                thread_count: 0,
                job_count: 0,
                first_vertex_normal,
                reach,
            },
            distance_merge: DistanceMergeParams {
                thread_count: 0,
                job_count: 0,
                first_vertex_normal,
                reach,
                round: 0,
            },
            unfold: UnfoldParams {
                thread_count: 0,
                job_count: 0,
                pitch: atlas.pitch,
                attempts: physarum.edge_crossing_attempts,
                threshold: turn.advance.transfer_threshold,
                farthest,
                deepest: turn.advance.deepest,
                near,
                sight,
            },
            sees_across: sees_across(settings),
            turn,
            diffuse: DiffuseParams {
                diffusion,
                deposit: factor * physarum.deposit,
                decay: settings.trail.decay,
                ..spreading(atlas).0
            },
            diffuse_seams: DiffuseSeamsParams {
                diffusion,
                deposit: factor * physarum.deposit,
                decay: settings.trail.decay,
                ..spreading(atlas).1
            },
            in_halves,
            exchange_seams: ExchangeSeamsParams {
                seam_count: atlas.seams.len() as u32,
            },
            sort: SortParams::at_end_of(settings, setup, step),
        }
    }

    /// Lets the step take the distances that have changed since the planner was last asked; `poses` are the step's.
    pub fn update_distances(
        &mut self,
        planner: &mut DistancePlanner,
        settings: &Settings,
        setup: &Setup,
        step: u64,
        poses: &[Pose],
    ) {
        let rules = DistanceRules {
            reach: settings.distance.reach * setup.radius,
            method: settings.distance.method,
            depth: settings.distance.depth,
            sign: settings.distance.sign,
            threshold: self.unfold.threshold,
            farthest: self.unfold.farthest,
            near: self.unfold.near,
            sight: self.unfold.sight,
            sees_across: self.sees_across,
            walk: (
                settings.physarum.edge_crossing_attempts,
                settings.physarum.border == Border::Reflect,
            ),
        };
        let is_due = step.is_multiple_of(u64::from(settings.distance.interval.max(1)));
        self.distance_update = planner.update(&setup.distance, poses, rules, is_due);
        let thread_count = self.distance_update.thread_count;
        let job_count = self.distance_update.jobs.len() as u32;
        self.distance_tiles.tile_count = thread_count / TILE_SAMPLES;
        self.distance_tiles.job_count = job_count;
        self.distance.tile_count = thread_count / TILE_SAMPLES;
        self.distance_tiles.is_first = self.distance_update.is_first.into();
        self.distance_brute.thread_count = thread_count;
        self.distance_brute.job_count = job_count;
        self.distance_merge.thread_count = thread_count;
        self.distance_merge.job_count = job_count;
        self.unfold.thread_count = thread_count;
        self.unfold.job_count = job_count;
    }

    /// Diffusion above what the exchange tables take happens in two halves of a step, half of it in each. The first
    /// half does nothing else: deposits and decay come with the second, and so do the gutters, which diffusion does not
    /// read.
    #[must_use]
    pub fn first_half(&self) -> Option<Self> {
        self.in_halves.then(|| {
            let mut half = self.clone();
            (half.diffuse.deposit, half.diffuse.decay) = (0.0, 1.0);
            (half.diffuse_seams.deposit, half.diffuse_seams.decay) = (0.0, 1.0);
            half
        })
    }
}

/// Do sensors see other objects? Where particles change to them, they do.
fn sees_across(settings: &Settings) -> bool {
    !matches!(settings.strategy(), Strategy::None | Strategy::Respawn)
}

/// On each object, in scene radii a step.
fn speeds(settings: &Settings) -> impl Iterator<Item = f32> {
    let objects = settings.objects.iter();
    objects.map(|object| object.physarum.over(&settings.physarum).speed)
}

/// On each object, in scene radii.
fn sensor_offsets(settings: &Settings) -> impl Iterator<Item = f32> {
    let objects = settings.objects.iter();
    objects.map(|object| object.physarum.over(&settings.physarum).sensor_offset)
}

/// What particles do on each object: the scene's values with the object's own over them.
#[must_use]
pub fn physarums(settings: &Settings, setup: &Setup) -> Vec<Physarum> {
    let objects = settings.objects.iter();
    let factor = deposit_factor(settings, setup);
    objects
        .map(|object| {
            let physarum = object.physarum.over(&settings.physarum);
            physarum_row(&physarum, setup.radius, factor)
        })
        .collect()
}

/// What deposits and decrowding weights are multiplied by: where the settings say which density they were made for, the
/// trail's mean stays what it is there, whatever the number of particles and the size of the texture.
#[must_use]
pub fn deposit_factor(settings: &Settings, setup: &Setup) -> f32 {
    let reference = settings.physarum.reference_density;
    let count = setup.particles.len();
    if reference == 0.0 || count == 0 {
        return 1.0;
    }
    (f64::from(reference) * f64::from(setup.atlas.owned_count) / count as f64) as f32
}

fn physarum_row(physarum: &PhysarumSettings, radius: f32, factor: f32) -> Physarum {
    let (sensor_sin, sensor_cos) = physarum.sensor_angle.to_radians().sin_cos();
    let (rotation_sin, rotation_cos) = physarum.rotation_angle.to_radians().sin_cos();
    Physarum {
        speed: physarum.speed * radius,
        sensor_offset: physarum.sensor_offset * radius,
        sensor_cos,
        sensor_sin,
        rotation_cos,
        rotation_sin,
        sensor_noise: physarum.sensor_noise,
        favourite_density: physarum.favourite_density,
        gravity_weight: physarum.gravity_weight / radius,
        decrowding_weight: factor * physarum.decrowding_weight,
        distance_weight: physarum.distance_weight / radius,
        pad0: 0.0,
    }
}

/// The trail's two kernels on an atlas, without deposits, decay and diffusion.
pub(super) fn spreading(atlas: &Atlas) -> (DiffuseParams, DiffuseSeamsParams) {
    let diffuse = DiffuseParams {
        lane_count: BLOCK_QUADS * atlas.blocks.len() as u32,
        quad_count: atlas.pitch * atlas.size / 4,
        quads_a_row: atlas.pitch / 4,
        diffusion: 0.0,
        most_density: GREATEST_DENSITY,
        deposit: 0.0,
        decay: 1.0,
        tiny: TINY_TRAIL,
    };
    let diffuse_seams = DiffuseSeamsParams {
        row_count: atlas.exchange.rows.len() as u32,
        reach_across: atlas.gutter,
        reach_down: atlas.gutter * atlas.pitch,
        diffusion: 0.0,
        deposit: 0.0,
        decay: 1.0,
        tiny: TINY_TRAIL,
    };
    (diffuse, diffuse_seams)
}

/// The word that keys the random streams of a seed.
#[must_use]
pub fn seed_word(seed: u64) -> u32 {
    (seed ^ (seed >> 32)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::settings::ObjectSettings;
    use crate::scene::{Overrides, Scene};

    #[test]
    fn deposits_and_decrowding_follow_the_density() {
        let mut settings = Settings {
            objects: vec![ObjectSettings {
                mesh: "builtin:cube".to_owned(),
                ..ObjectSettings::default()
            }],
            ..Settings::default()
        };
        settings.atlas.size = 64;
        settings.particles.count = 1000;
        settings.physarum.deposit = 2.0;
        settings.physarum.decrowding_weight = 0.5;
        settings.objects[0].physarum.decrowding_weight = Some(0.25);
        let scene = Scene::from_settings("cube".to_owned(), settings, "".into()).unwrap();
        let setup = Setup::new(&scene).unwrap();
        let density = 1000.0 / setup.atlas.owned_count as f32;
        let mut settings = scene.settings;
        for (reference, factor) in [(0.0, 1.0), (density, 1.0), (3.0 * density, 3.0)] {
            settings.physarum.reference_density = reference;
            let params = StepParams::new(&settings, &setup, 0, 0);
            let found = [
                params.diffuse.deposit,
                params.diffuse_seams.deposit,
                params.turn.advance.decrowding_weight,
                physarums(&settings, &setup)[0].decrowding_weight,
            ];
            for (value, plain) in found.into_iter().zip([2.0, 2.0, 0.5, 0.25]) {
                assert!(
                    (value - factor * plain).abs() < 1e-5,
                    "{found:?}, {reference}"
                );
            }
        }
    }

    /// Each of the object's own values does there what the scene's would, and nothing elsewhere.
    #[test]
    fn objects_have_values_of_their_own() {
        let scene = |key: &str, value: f32| {
            let set = vec!["atlas.size=256".to_owned(), format!("{key}={value}")];
            let overrides = Overrides {
                set,
                ..Overrides::default()
            };
            Scene::load("pair".as_ref(), &overrides).unwrap()
        };
        let plain = scene("particles.count", 1000.0);
        let setup = Setup::new(&plain).unwrap();
        let before = physarums(&plain.settings, &setup);
        for (key, value) in [
            ("speed", 0.003),
            ("rotation_angle", 11.0),
            ("sensor_angle", 13.0),
            ("sensor_offset", 0.017),
            ("sensor_noise", 0.019),
            ("favourite_density", 2.3),
            ("gravity_weight", 2.9),
            ("decrowding_weight", 0.31),
            ("distance_weight", 3.7),
        ] {
            let rows = |key: &str| physarums(&scene(key, value).settings, &setup);
            let of_all = rows(&format!("physarum.{key}"));
            let own = rows(&format!("object.1.physarum.{key}"));
            assert_ne!(of_all[1], before[1], "{key}");
            assert_eq!(own, [before[0], of_all[1]], "{key}");
        }
    }
}
