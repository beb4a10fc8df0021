//! What a step is to do: from a scene's settings to the numbers that kernels take. Scene radii become world lengths, degrees
//! become cosines and sines.

use super::behaviour::deposit_factor;
use super::distance::{DistancePlanner, DistanceRules, DistanceUpdate};
use super::setup::Setup;
use super::sorting::{Segment, Segments};
use super::texel_paths::TexelPaths;
use super::types::{Physarum, Pose};
use crate::gpu::Threads;
use crate::scene::settings::{Border, PhysarumSettings, Settings, Strategy};

/// How far from its texel's centre a texel's distance may be another by reading between texels, in texel sides.
const TEXELS_BETWEEN: f32 = 2.0;

/// What the step has to work with: the ways to textures, what is painted, and room for transfers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Means {
    /// How kernels get at single texels.
    pub paths: TexelPaths,
    /// Is there anything that was painted for sensors to read?
    pub painted: bool,
    /// How many transfers the lists hold.
    pub capacity: u32,
    /// How particles are cut into segments, of which a step sorts one.
    pub segments: Segments,
}

impl Means {
    /// Those of a host, which sorts nothing: nothing is too large for it.
    #[must_use]
    pub fn of_host(painted: bool, capacity: u32) -> Self {
        let paths = TexelPaths::default();
        Self {
            paths,
            painted,
            capacity,
            segments: Segments::new(0, 1),
        }
    }
}

/// Values that the host uploads because they differ from the step before.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    /// World from object, one an object.
    pub poses: Option<Vec<Pose>>,
    /// World from object in the step before this one.
    pub poses_before: Option<Vec<Pose>>,
    /// Parameters of particles, one per object.
    pub physarums: Option<Vec<Physarum>>,
}

/// Lengths that several kernels take, world units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lengths {
    /// How far distances to other objects are known.
    pub reach: f32,
    /// The signed distance below which a place is covered.
    pub threshold: f32,
    /// Length of the longest path to a sensor.
    pub farthest: f32,
    /// The signed distance up to which sensors see nothing.
    pub deepest: f32,
    /// A place beyond this has nothing to do with another object in a step.
    pub near: f32,
    /// As `near`, for particles that walk to their sensors.
    pub sight: f32,
}

impl Lengths {
    /// Of a scene.
    #[must_use]
    pub fn new(settings: &Settings, setup: &Setup) -> Self {
        let radius = setup.radius;
        let reach = settings.distance.reach * radius;
        // Where nothing is known of distances, nothing is covered.
        let threshold = settings.transfer.threshold.min(settings.distance.reach) * radius;
        let most = |of: fn(&PhysarumSettings) -> f32| {
            let objects = settings.objects.iter();
            let own = objects.map(|object| of(&object.physarum.over(&settings.physarum)));
            own.fold(0.0, f32::max) * radius
        };
        let farthest = most(|own| own.sensor_offset);
        let fastest = most(|own| own.speed);
        let near = threshold + fastest + TEXELS_BETWEEN * setup.texel_side;
        Self {
            reach,
            threshold,
            farthest,
            // Sensors get no farther behind a crossing than they are away; nothing is known beyond reach.
            deepest: -farthest.min(reach),
            near,
            // A walk that is pending comes before that of the sensors, or of the step.
            // Where it is longer than the reach, everything is in sight: no distance is known that is longer than that.
            sight: near + farthest.max(fastest),
        }
    }
}

/// Everything that a step depends on besides buffers.
pub struct Plan<'a> {
    /// Those that hold in this step.
    pub settings: &'a Settings,
    /// What it runs on.
    pub setup: &'a Setup,
    /// Counted from 0.
    pub step: u64,
    /// What the engine has.
    pub means: Means,
    /// The strategy that takes effect.
    pub strategy: Strategy,
    /// Has some object values of its own for what particles do?
    pub own_physarum: bool,
    /// Lengths that several kernels take.
    pub lengths: Lengths,
    /// What deposits and decrowding weights are multiplied by.
    pub deposit_factor: f32,
    /// What differs from the step before.
    pub changes: Changes,
    /// Which distances are taken anew; none at first.
    pub distances: DistanceUpdate,
    /// The particles that are sorted at the end, if any are.
    pub segment: Option<Segment>,
}

impl<'a> Plan<'a> {
    /// Of step number `step`, counted from 0, in which nothing has changed.
    #[must_use]
    pub fn new(settings: &'a Settings, setup: &'a Setup, step: u64, means: Means) -> Self {
        Self {
            settings,
            setup,
            step,
            means,
            strategy: settings.strategy(),
            own_physarum: settings.objects.iter().any(|o| !o.physarum.is_empty()),
            lengths: Lengths::new(settings, setup),
            deposit_factor: deposit_factor(settings, setup),
            changes: Changes::default(),
            distances: DistanceUpdate::default(),
            segment: None,
        }
    }

    /// Lets the step take the distances that have changed since the planner was last asked; `poses` are the step's.
    pub fn update_distances(&mut self, planner: &mut DistancePlanner, step: u64, poses: &[Pose]) {
        let (settings, lengths) = (self.settings, self.lengths);
        let rules = DistanceRules {
            reach: lengths.reach,
            method: settings.distance.method,
            depth: settings.distance.depth,
            sign: settings.distance.sign,
            threshold: lengths.threshold,
            farthest: lengths.farthest,
            near: lengths.near,
            sight: lengths.sight,
            sees_across: self.strategy.sees_across(),
            walk: (
                settings.physarum.edge_crossing_attempts,
                self.border_reflects(),
            ),
        };
        let is_due = step.is_multiple_of(u64::from(self.settings.distance.interval.max(1)));
        self.distances = planner.update(&self.setup.distance, poses, rules, is_due);
    }

    /// Lets the step sort the segment that is due in the one of this number, if any is.
    pub fn sort_as_in(&mut self, step: u64) {
        if self.strategy.may_sort() {
            self.segment = self.means.segments.due(step);
        }
    }

    /// Do walks go on from open borders, in the direction of a mirror?
    #[must_use]
    pub fn border_reflects(&self) -> bool {
        self.settings.physarum.border == Border::Reflect
    }

    /// Is there food, or are there markers?
    #[must_use]
    pub fn has_food(&self) -> bool {
        self.settings.food_count() > 0
    }

    /// How many foods and markers there are.
    #[must_use]
    pub fn foods(&self) -> u32 {
        self.setup.food_set.places.len() as u32
    }

    /// One invocation for each gutter texel that is read.
    #[must_use]
    pub fn seams(&self) -> Threads {
        Threads(self.setup.atlas.seams.len() as u32)
    }

    /// How many objects there are.
    #[must_use]
    pub fn object_count(&self) -> u32 {
        self.setup.poses.len() as u32
    }

    /// How many particles there are.
    #[must_use]
    pub fn particle_count(&self) -> u32 {
        self.setup.particles.len() as u32
    }

    /// The word of the step that random streams take. They repeat after 2^32 steps: over two years at 60 steps a second.
    #[must_use]
    pub fn time_step(&self) -> u32 {
        self.step as u32
    }

    /// Where the normals of vertices begin, behind those of half-edges.
    #[must_use]
    pub fn first_vertex_normal(&self) -> u32 {
        self.setup.surface.halfedges.len() as u32
    }
}
