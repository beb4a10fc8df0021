//! The plan of a step: from a scene's settings to the parameters of kernels. Scene radii become world lengths, degrees become cosines and
//! sines.

use super::distance::{DepthLengths, DistancePlanner, DistanceRules, DistanceUpdate};
use super::pulse::LivePulse;
use super::setup::Setup;
use super::sorting::{Segment, Segments};
use super::spread::{Pass, trail_rates};
use super::texel_paths::TexelPaths;
use super::types::{Physarum, Pose, Shell, TrailRates};
use crate::gpu::Threads;
use crate::scene::Rules;
use crate::scene::settings::{Border, PhysarumSettings, Settings, Strategy};

/// Bound on the error of a distance that is read between texels, in texel sides.
const TEXELS_BETWEEN: f32 = 2.0;

/// How far behind a crossing covered texels are found into which the trail spreads, in texel sides for each texel between the taps. The
/// farthest tap is 1.42 away, and texels may be longer one way than the other.
const TAPS_ACROSS: f32 = 2.0;

/// What an engine provides: access paths to textures, a painted bias, and the capacity for transfers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Means {
    /// How kernels access single texels.
    pub paths: TexelPaths,
    /// Was any bias painted?
    pub painted: bool,
    /// Are there weights of a second look?
    pub looks: bool,
    /// Is it known that no cell has several particles, where there is to be one a cell?
    pub apart: bool,
    /// How many transfers the lists hold.
    pub capacity: u32,
    /// How particles are cut into segments, of which a step sorts one.
    pub segments: Segments,
    /// log2 of how many parts the bins of particles have along each side.
    pub part_bits: u32,
}

impl Means {
    /// The means of the host, which sorts nothing, and for which nothing is too large.
    #[must_use]
    pub fn of_host(painted: bool, capacity: u32) -> Self {
        let paths = TexelPaths::default();
        Self {
            paths,
            painted,
            looks: false,
            apart: false,
            capacity,
            segments: Segments::new(0, 1),
            part_bits: 0,
        }
    }
}

/// Values that the host uploads because they differ from the step before.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    /// World from object, one per object.
    pub poses: Option<Vec<Pose>>,
    /// World from object in the step before this one.
    pub poses_before: Option<Vec<Pose>>,
    /// Parameters of particles, one per object.
    pub physarums: Option<Vec<Physarum>>,
    /// What passes do to the trail, in each kind of pass a row per object, where objects differ.
    pub rates: Option<Vec<TrailRates>>,
}

/// Lengths that several kernels take, world units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lengths {
    /// Distances to other objects are clamped beyond this.
    pub reach: f32,
    /// The signed distance below which a place is covered.
    pub threshold: f32,
    /// Length of the longest path to a sensor, or of one by which the trail spreads to another object, if that is longer.
    pub farthest: f32,
    /// Length of the longest step.
    pub fastest: f32,
    /// The signed distance up to which sensors see nothing.
    pub deepest: f32,
    /// At a larger distance, a particle cannot meet another object in a step.
    pub near: f32,
    /// As `near`, for particles that walk to their sensors.
    pub sight: f32,
}

impl Lengths {
    /// The lengths of a scene, with those of its second look if it takes effect.
    #[must_use]
    pub fn new(settings: &Settings, setup: &Setup, has_looks: bool) -> Self {
        let radius = setup.radius;
        let reach = settings.distance.reach * radius;
        // Without distances, nothing is covered.
        let threshold = settings.transfer.threshold.min(settings.distance.reach) * radius;
        let most = |of: fn(&PhysarumSettings) -> f32| {
            let objects = settings.objects.iter();
            let own = objects.map(|object| of(&object.physarum.over(&settings.physarum)));
            let second = (settings.second_look.look()).filter(|_| has_looks);
            let second = second.map(|look| of(&look.physarum));
            own.chain(second).fold(0.0, f32::max) * radius
        };
        let spreads = match settings.trail_crosses() {
            true => TAPS_ACROSS * setup.atlas.taps as f32 * setup.texel_side,
            false => 0.0,
        };
        let farthest = most(|own| own.sensor_offset).max(spreads);
        let fastest = most(|own| own.speed);
        let plain = Self {
            reach,
            threshold,
            farthest,
            fastest,
            // Sensors get no farther behind a crossing than their offset; beyond the reach no distances are known.
            deepest: -farthest.min(reach),
            near: 0.0,
            sight: 0.0,
        };
        plain.with_steps(fastest, setup)
    }

    /// The lengths if steps may be so long.
    fn with_steps(self, fastest: f32, setup: &Setup) -> Self {
        let near = self.threshold + fastest + TEXELS_BETWEEN * setup.texel_side;
        Self {
            fastest,
            near,
            // A pending walk comes before the walk of the sensors, or of the step.
            // If it is longer than the reach, everything is in sight, because distances are clamped to the reach.
            sight: near + self.farthest.max(fastest),
            ..self
        }
    }
}

/// Everything that a step depends on besides buffers.
pub struct Plan<'a> {
    /// The settings of this step.
    pub settings: &'a Settings,
    /// The setup of the scene.
    pub setup: &'a Setup,
    /// Number of the step, counted from 0.
    pub step: u64,
    /// The means of the engine.
    pub means: Means,
    /// The strategy that takes effect.
    pub strategy: Strategy,
    /// Does some object have its own parameters of particles?
    pub own_physarum: bool,
    /// The rules of particles.
    pub rules: Rules,
    /// Lengths that several kernels take.
    pub lengths: Lengths,
    /// What passes do to the trail: in each kind of pass a row per object.
    pub rates: Vec<TrailRates>,
    /// Do objects differ in that?
    pub own_rates: bool,
    /// Changes from the step before.
    pub changes: Changes,
    /// The shells of live pulses.
    pub shells: Vec<Shell>,
    /// The distances to update; initially none.
    pub distances: DistanceUpdate,
    /// The particles that are sorted at the end, if any are.
    pub segment: Option<Segment>,
    /// Is it time for births and deaths?
    pub breeds: bool,
    /// Are the scents that cross contacts those of the step before, because nothing has changed that they depend on?
    pub scents_stay: bool,
}

impl<'a> Plan<'a> {
    /// The plan of step number `step`, counted from 0, with no changes.
    #[must_use]
    pub fn new(settings: &'a Settings, setup: &'a Setup, step: u64, means: Means) -> Self {
        Self {
            settings,
            setup,
            step,
            means,
            strategy: settings.strategy(),
            own_physarum: (settings.objects.iter()).any(|o| o.physarum.concerns_particles()),
            rules: settings.physarum.rules(),
            lengths: Lengths::new(settings, setup, means.looks),
            rates: trail_rates(settings, setup),
            own_rates: settings.has_own_rates(),
            changes: Changes::default(),
            shells: Vec::new(),
            distances: DistanceUpdate::default(),
            segment: None,
            breeds: false,
            scents_stay: false,
        }
    }

    /// Adds pulses, which must be live; particles that they carry take longer steps. Comes before
    /// [`update_distances`](Self::update_distances).
    pub fn add_pulses(&mut self, pulses: &[LivePulse]) {
        self.shells = (pulses.iter())
            .map(|pulse| pulse.shell_in(self.step))
            .collect();
        let speeds = self.shells.iter().map(|shell| shell.speed);
        let fastest = speeds.fold(self.lengths.fastest, f32::max);
        self.lengths = self.lengths.with_steps(fastest, self.setup);
    }

    /// Adds the update of distances that have changed since the planner was last used; `poses` are the step's.
    pub fn update_distances(&mut self, planner: &mut DistancePlanner, step: u64, poses: &[Pose]) {
        let (settings, lengths) = (self.settings, self.lengths);
        let rules = DistanceRules {
            reach: lengths.reach,
            method: settings.distance.method,
            depth: settings.distance.depth,
            depths: DepthLengths::new(&settings.distance, self.setup.radius),
            sign: settings.distance.sign,
            threshold: lengths.threshold,
            farthest: lengths.farthest,
            near: lengths.near,
            sight: lengths.sight,
            sees_across: self.finds_across(),
            walk: (self.most_attempts(), self.border_reflects()),
        };
        let is_due = step.is_multiple_of(u64::from(self.settings.distance.interval.max(1)));
        self.distances = planner.update(&self.setup.distance, poses, rules, is_due);
    }

    /// Adds the sort of the segment that is due in step number `step`, if any.
    pub fn sort_as_in(&mut self, step: u64) {
        if self.strategy.may_sort() {
            self.segment = self.means.segments.due(step);
        }
    }

    /// What a pass does to the trail where all objects agree: the rates of the first one.
    #[must_use]
    pub fn rates_of_all(&self, pass: Pass) -> TrailRates {
        self.rates[self.first_rates(pass) as usize]
    }

    /// The first row of a pass in the table of rates.
    #[must_use]
    pub fn first_rates(&self, pass: Pass) -> u32 {
        pass as u32 * self.object_count()
    }

    /// Edge crossings that one walk may make on the object that allows the most. Places at which sensors see other objects are found by so
    /// many.
    #[must_use]
    pub fn most_attempts(&self) -> u32 {
        let settings = self.settings;
        let objects = settings.objects.iter();
        let own = objects.map(|object| object.physarum.over(&settings.physarum));
        let attempts = own.map(|own| own.edge_crossing_attempts);
        attempts
            .max()
            .unwrap_or(settings.physarum.edge_crossing_attempts)
    }

    /// Are walks reflected at open borders?
    #[must_use]
    pub fn border_reflects(&self) -> bool {
        self.settings.physarum.border == Border::Reflect
    }

    /// Is there food, or are there markers?
    #[must_use]
    pub fn has_food(&self) -> bool {
        self.settings.food_count() > 0
    }

    /// Does the second look take effect anywhere?
    #[must_use]
    pub fn has_looks(&self) -> bool {
        self.means.looks && self.settings.second_look.is_some()
    }

    /// Does the scent of food and markers cross from object to object?
    #[must_use]
    pub fn scent_crosses(&self) -> bool {
        self.settings.scent_crosses()
    }

    /// Does the trail spread over the lines in which surfaces meet?
    #[must_use]
    pub fn trail_crosses(&self) -> bool {
        self.settings.trail_crosses()
    }

    /// Are places on other objects found for covered texels? They are if sensors see them, or the trail spreads there.
    #[must_use]
    pub fn finds_across(&self) -> bool {
        self.strategy.sees_across() || self.trail_crosses()
    }

    /// One invocation for each sample, which is an owned texel of a scene of several objects.
    #[must_use]
    pub fn samples(&self) -> Threads {
        Threads(self.setup.distance.samples.len() as u32)
    }

    /// Is food projected into the trail?
    #[must_use]
    pub fn projects(&self) -> bool {
        self.settings.projects()
    }

    /// One invocation for each texel at which food is projected into the trail.
    #[must_use]
    pub fn projected(&self) -> Threads {
        Threads(self.setup.food_set.projected.len() as u32)
    }

    /// May particles be dead?
    #[must_use]
    pub fn is_mortal(&self) -> bool {
        self.settings.population.is_on()
    }

    /// Do particles die of hunger?
    #[must_use]
    pub fn is_hungry(&self) -> bool {
        self.settings.starves()
    }

    /// Number of foods and markers.
    #[must_use]
    pub fn foods(&self) -> u32 {
        self.setup.food_set.places.len() as u32
    }

    /// One invocation for each gutter texel that is read.
    #[must_use]
    pub fn seams(&self) -> Threads {
        Threads(self.setup.atlas.seams.len() as u32)
    }

    /// Number of objects.
    #[must_use]
    pub fn object_count(&self) -> u32 {
        self.setup.poses.len() as u32
    }

    /// Number of particles, dead ones among them.
    #[must_use]
    pub fn particle_count(&self) -> u32 {
        self.setup.particles.len() as u32
    }

    /// The word of the step that random streams take. They repeat after 2^32 steps: over two years at 60 steps a second.
    #[must_use]
    pub fn time_step(&self) -> u32 {
        self.step as u32
    }

    /// Index of the first vertex normal, behind the normals of half-edges.
    #[must_use]
    pub fn first_vertex_normal(&self) -> u32 {
        self.setup.surface.halfedges.len() as u32
    }
}
