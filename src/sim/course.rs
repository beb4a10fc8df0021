//! The host's side of a simulation, for either engine: settings, time, poses, and the state of distances. It plans the steps.

use std::sync::Arc;

use bytemuck::Zeroable;
use glam::{Affine3A, DAffine3, Vec3};

use super::behaviour::physarums;
use super::cells::sharing_count;
use super::distance::{DistancePlanner, DistanceUpdate};
use super::food::FoodSet;
use super::movement::Movement;
use super::plan::{Changes, Means, Plan};
use super::pulse::{LivePulse, MOST_PULSES, Pulse};
use super::setup::Setup;
use super::snapshot::{FoodState, Snapshot};
use super::spread::trail_rates;
use super::step::step;
use super::types::{DistanceJob, Motion, Particle, Physarum, Pose, Shell, TrailRates};
use super::work::Step;
use crate::error::Result;
use crate::scene::settings::Settings;

/// The number of a step with distances and a sort: both are due in steps whose numbers are multiples of some number.
const DUE: u64 = 0;

/// What scents that cross contacts depend on, besides distances and the scents themselves.
#[derive(Clone, Debug, PartialEq)]
struct CrossedWith {
    poses: Vec<Pose>,
    /// The share that crosses.
    share: f32,
    /// The reach of distances, world units.
    reach: f32,
}

/// Are living particles one a cell, where they are to be?
fn are_apart(
    (particles, motions): (&[Particle], &[Motion]),
    settings: &Settings,
    setup: &Setup,
) -> bool {
    if !settings.physarum.rules().is_crowded() {
        return false;
    }
    let both = particles.iter().zip(motions);
    let living = both.filter(|(_, motion)| !motion.is_dead());
    sharing_count(
        living.map(|(particle, _)| particle),
        &setup.atlas,
        &setup.homes,
    ) == 0
}

/// A simulation without its buffers.
#[derive(Clone, Debug)]
pub struct Course {
    /// The setup of the scene.
    pub setup: Arc<Setup>,
    /// The settings of the next step.
    pub settings: Settings,
    movement: Movement,
    /// The poses on the engine after the steps so far.
    poses: Vec<Pose>,
    /// The poses in the last step, from which those of pictures may differ.
    poses_of_step: Vec<Pose>,
    /// The earlier poses on the engine after the steps so far.
    poses_before: Vec<Pose>,
    /// The parameters of particles on the engine after the steps so far.
    physarums: Vec<Physarum>,
    /// What passes do to the trail, as the engine has it after the steps so far.
    rates: Vec<TrailRates>,
    planner: DistancePlanner,
    /// What the scents on the engine have crossed contacts with; none if that is unknown.
    crossed_with: Option<CrossedWith>,
    /// The pulses that have begun and not ended, the oldest first.
    pulses: Vec<LivePulse>,
    /// The number of particles that a fed one counted as in the last step.
    fed_deposit: u32,
    /// Is it known that no cell has several particles? Never becomes true again: the way back to a state does not look at particles.
    apart: bool,
    step: u64,
}

impl Course {
    /// The course of a scene at step 0.
    #[must_use]
    pub fn new(setup: Arc<Setup>, settings: Settings) -> Self {
        Self {
            movement: Movement::new(&settings),
            poses: setup.poses.clone(),
            poses_of_step: setup.poses.clone(),
            poses_before: setup.poses.clone(),
            physarums: physarums(&settings, &setup),
            rates: trail_rates(&settings, &setup),
            planner: DistancePlanner::default(),
            crossed_with: None,
            pulses: Vec::new(),
            fed_deposit: 1,
            apart: are_apart((&setup.particles, &setup.motions), &settings, &setup),
            step: 0,
            setup,
            settings,
        }
    }

    /// This course with other settings.
    #[must_use]
    pub fn with_settings(&self, settings: &Settings) -> Self {
        let settings = settings.clone();
        Self {
            settings,
            ..self.clone()
        }
    }

    /// The next step. It then counts as done.
    #[must_use]
    pub fn next(&mut self, means: Means) -> Step {
        self.follow_settings();
        self.begin_pulses();
        let changes = self.changes();
        let mut plan = Plan::new(&self.settings, &self.setup, self.step, means);
        plan.add_pulses(&self.pulses);
        plan.changes = changes;
        plan.update_distances(&mut self.planner, self.step, &self.poses);
        let crossed_with = (plan.scent_crosses()).then(|| CrossedWith {
            poses: self.poses.clone(),
            share: self.settings.feeding.scent_across,
            reach: plan.lengths.reach,
        });
        // The host does not see what is eaten.
        plan.scents_stay = crossed_with == self.crossed_with
            && plan.distances.jobs.is_empty()
            && !self.setup.food_set.may_fall();
        plan.sort_as_in(self.step);
        plan.breeds = self.settings.population.is_due(self.step);
        let step = step(&plan);
        self.crossed_with = crossed_with;
        self.step += 1;
        self.pulses.retain(|pulse| !pulse.has_ended(self.step));
        self.fed_deposit = self.settings.feeding.fed_deposit;
        step
    }

    /// Replaces the food from the next step on. Other owners of the setup keep theirs.
    pub fn serve(&mut self, food_set: FoodSet) {
        self.setup = Arc::new(self.setup.with_food(food_set));
        self.crossed_with = None;
    }

    /// Begins a pulse with the next step. If [`MOST_PULSES`] are live, the oldest ends.
    ///
    /// # Errors
    /// When a number of it is out of its range.
    pub fn pulse(&mut self, pulse: &Pulse) -> Result<()> {
        pulse.check(self.setup.radius)?;
        self.add_pulse(pulse);
        Ok(())
    }

    fn add_pulse(&mut self, pulse: &Pulse) {
        if self.pulses.len() == MOST_PULSES {
            self.pulses.remove(0);
        }
        self.pulses.push(pulse.beginning_at(self.step));
    }

    /// Begins the scene's pulses whose turn is in the next step.
    fn begin_pulses(&mut self) {
        let (center, radius) = (self.setup.center, self.setup.radius);
        let begin = (self.settings.pulses.iter()).filter(|pulse| pulse.begins_in(self.step));
        let begin = begin.map(|settings| {
            let at = center + radius * Vec3::from_array(settings.at);
            Pulse::new(settings, at, radius)
        });
        for pulse in begin.collect::<Vec<_>>() {
            self.add_pulse(&pulse);
        }
    }

    /// The pulses that are live.
    #[must_use]
    pub fn pulses(&self) -> &[LivePulse] {
        &self.pulses
    }

    /// A step with every kernel that later steps can have by such settings. It is not to be executed: its update of distances is arbitrary.
    #[must_use]
    pub fn of_every_kernel(&self, settings: &Settings, means: Means) -> Step {
        let mut plan = Plan::new(settings, &self.setup, self.step, means);
        if !self.setup.distance.is_empty() {
            plan.distances.jobs = vec![DistanceJob::zeroed()];
        }
        plan.sort_as_in(DUE);
        plan.breeds = plan.is_mortal();
        let mut every = step(&plan);
        if !self.pulses.is_empty() || !settings.pulses.is_empty() {
            plan.shells = vec![Shell::zeroed()];
            every.add_acts(&plan);
        }
        every
    }

    /// The next step with a sort, and with the distances that are due. If nothing has moved since they were last computed, it has the
    /// distances of the first step. The step does not count as done.
    #[must_use]
    pub fn with_everything(&self, means: Means, changes: Changes) -> (Step, DistanceUpdate) {
        let mut plan = Plan::new(&self.settings, &self.setup, self.step, means);
        plan.changes = changes;
        plan.add_pulses(&self.pulses);
        for mut planner in [self.planner.clone(), DistancePlanner::default()] {
            plan.update_distances(&mut planner, DUE, &self.poses);
            if !plan.distances.jobs.is_empty() {
                break;
            }
        }
        plan.sort_as_in(DUE);
        plan.breeds = plan.is_mortal();
        (step(&plan), plan.distances)
    }

    /// Changes of the next step from the one before.
    pub fn changes(&mut self) -> Changes {
        let before = std::mem::take(&mut self.poses_of_step);
        let changes = Changes {
            poses: self.moved_at(self.step),
            poses_before: (before != self.poses_before).then(|| before.clone()),
            physarums: self.changed_physarums(),
            rates: self.changed_rates(),
        };
        self.poses_before = before;
        self.poses_of_step.clone_from(&self.poses);
        changes
    }

    /// The poses that the last step had, or those set since from outside, if the engine has others.
    pub fn moved(&mut self) -> Option<Vec<Pose>> {
        self.moved_at(self.last_step())
    }

    /// The poses that the last step had, or those set since from outside.
    pub fn shown_poses(&self) -> Vec<Pose> {
        self.poses_at(self.last_step())
    }

    fn poses_at(&self, step: u64) -> Vec<Pose> {
        let (tracks, origins) = (&self.setup.tracks, &self.setup.origins);
        let objects = &self.settings.objects;
        self.movement.poses(objects, tracks, origins, step)
    }

    /// Parameters of particles on each object, if they differ from those on the engine.
    fn changed_physarums(&mut self) -> Option<Vec<Physarum>> {
        let physarums = physarums(&self.settings, &self.setup);
        if physarums == self.physarums {
            return None;
        }
        self.physarums.clone_from(&physarums);
        Some(physarums)
    }

    /// What passes do to the trail, if it differs from what the engine has. Where objects agree, kernels take it as parameters.
    fn changed_rates(&mut self) -> Option<Vec<TrailRates>> {
        if !self.settings.has_own_rates() {
            return None;
        }
        let rates = trail_rates(&self.settings, &self.setup);
        if rates == self.rates {
            return None;
        }
        self.rates.clone_from(&rates);
        Some(rates)
    }

    fn moved_at(&mut self, step: u64) -> Option<Vec<Pose>> {
        let poses = self.poses_at(step);
        if poses == self.poses {
            return None;
        }
        self.poses.clone_from(&poses);
        Some(poses)
    }

    /// Looks for cells of a restored state that several particles share.
    pub fn look_for_shared_cells(&mut self, particles: (&[Particle], &[Motion])) {
        self.apart = self.apart && are_apart(particles, &self.settings, &self.setup);
    }

    /// Several particles may be in a cell.
    pub fn let_cells_be_shared(&mut self) {
        self.apart = false;
    }

    /// Is it known that no cell has several particles? The scene begins so if there is one a cell, and rules keep it so.
    #[must_use]
    pub fn is_apart(&self) -> bool {
        self.apart
    }

    /// Applies a changed time step: the last step's poses stay, and the next step uses the new rate.
    pub fn follow_settings(&mut self) {
        self.movement
            .set_dt(self.settings.time.dt, self.last_step());
    }

    /// The step whose poses are shown: the last one, or the first.
    fn last_step(&self) -> u64 {
        self.step.saturating_sub(1)
    }

    /// Steps done.
    #[must_use]
    pub fn step(&self) -> u64 {
        self.step
    }

    /// The present poses of objects.
    #[must_use]
    pub fn poses(&self) -> &[Pose] {
        &self.poses
    }

    /// Has any step computed distances?
    #[must_use]
    pub fn has_distances(&self) -> bool {
        self.planner.has_taken()
    }

    /// Sets the pose of an object from the next step on, in place of the scene's; `None` restores the scene's.
    ///
    /// # Errors
    /// When there is no such object, or the pose is not rigid.
    pub fn set_pose(&mut self, object: usize, world_from_object: Option<DAffine3>) -> Result<()> {
        self.movement.set_pose(object, world_from_object)
    }

    /// The pose of an object that was set from outside, if any.
    #[must_use]
    pub fn set_pose_of(&self, object: usize) -> Option<DAffine3> {
        self.movement.set_pose_of(object)
    }

    /// The pose of each object in the last step.
    #[must_use]
    pub fn world_from_object(&self) -> Vec<Affine3A> {
        let objects = &self.settings.objects;
        let (tracks, origins) = (&self.setup.tracks, &self.setup.origins);
        self.movement
            .world_from_object(objects, tracks, origins, self.last_step())
    }

    /// Seconds of the objects' motion in the last step.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.movement.time_at(self.last_step())
    }

    /// A snapshot with the parts on the host; the caller adds those in buffers.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        Snapshot {
            step: self.step,
            movement: self.movement.save(),
            last_poses: self.poses_of_step.clone(),
            origin: self.setup.origin(),
            distance_poses: self.planner.poses().to_vec(),
            kept_pairs: self.planner.kept(),
            pulses: self.pulses.clone(),
            food: FoodState {
                remaining: Vec::new(),
                fed_deposit: self.fed_deposit,
            },
            ..Snapshot::default()
        }
    }

    /// Continues from a snapshot of the same scene. Returns whether the distances that have been computed are those of the snapshot, too;
    /// otherwise they are not known.
    ///
    /// # Errors
    /// When its poses are damaged, or are those of another number of objects. Then nothing has changed.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<bool, String> {
        self.movement = snapshot.movement_of(self.settings.objects.len())?;
        let are_known = self.planner.has_taken()
            && self.planner.poses() == snapshot.distance_poses
            && self.planner.kept() == snapshot.kept_pairs;
        if !are_known {
            self.planner = DistancePlanner::resumed(&snapshot.distance_poses, &snapshot.kept_pairs);
        }
        self.crossed_with = None;
        self.pulses.clone_from(&snapshot.pulses);
        self.fed_deposit = snapshot.food.fed_deposit;
        self.step = snapshot.step;
        self.poses_of_step.clone_from(&snapshot.last_poses);
        self.follow_settings();
        Ok(are_known)
    }
}
