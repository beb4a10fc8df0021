//! Invariants that every state must satisfy.

use super::super::distance::KeptPair;
use super::super::kept::check_lengths;
use super::super::movement::{FARTHEST, MOST_STEPS, Movement, is_rigid};
use super::super::paint::{GREATEST, NO_GO};
use super::super::pulse::MOST_PULSES;
use super::super::setup::Setup;
use super::super::types::Particle;
use super::{Census, Snapshot};

/// No trail reaches this density; sums over texels stay finite below it.
const MOST_TRAIL: f32 = 1e30;

/// The largest trail value in a checkpoint: in later steps, with rounding, it stays below [`MOST_TRAIL`].
const MOST_LOADED_TRAIL: f32 = 0.1 * MOST_TRAIL;

/// Scene radii. Also with changes of speed and size during a run, pending lengths stay below it.
const MOST_PENDING: f32 = 1e9;

/// How much smaller a scene may become while a pulse is live.
const GROWN: f32 = 1000.0;

/// Gutters hold weighted sums of other texels, whose weights are 1 in sum but for rounding.
const BLENDED: f32 = 1.001;

impl Snapshot {
    /// The largest trail value from which steps can continue.
    pub const MOST_TRAIL: f32 = MOST_LOADED_TRAIL;

    /// Checks everything that a simulation of this setup needs to continue from here: [`validate`](Self::validate),
    /// [`check_ranges`](Self::check_ranges), [`movement_of`](Self::movement_of) and [`check_food`](Self::check_food).
    ///
    /// # Errors
    /// Names the first thing that is wrong.
    pub fn check(&self, setup: &Setup) -> Result<(), String> {
        self.validate(setup)?;
        self.check_ranges(setup)?;
        self.movement_of(setup.poses.len())?;
        self.check_food(setup.food_set.places.len())
    }

    /// Checks everything that must hold after every step.
    ///
    /// # Errors
    /// Names the first particle or texel that breaks a rule, and the rule.
    pub fn validate(&self, setup: &Setup) -> Result<(), String> {
        check_lengths(self, setup)?;
        if self.step > MOST_STEPS {
            return Err(format!(
                "it is at step {}, and {MOST_STEPS} is the last",
                self.step
            ));
        }
        let census = self.census();
        if census != Census::default() {
            return Err(format!(
                "{} particles are lost and {} doubled",
                census.lost, census.doubled
            ));
        }
        let living = self.living_count();
        let counted = match self.population.first() {
            Some(population) => u64::from(population.living),
            None => self.particles.len() as u64,
        };
        if living != counted {
            return Err(format!(
                "{living} particles are alive, and {counted} are counted"
            ));
        }
        for (particle, motion) in self.particles.iter().zip(&self.motions) {
            let Particle { triangle, u, v, id } = *particle;
            if triangle as usize >= setup.surface.triangles.len() {
                return Err(format!(
                    "particle {id} is on triangle {triangle}, which does not exist"
                ));
            }
            if !(u >= 0.0 && v >= 0.0 && u + v <= 1.0) {
                return Err(format!(
                    "particle {id} is outside its triangle {triangle}: u = {u}, v = {v}"
                ));
            }
            let [p, h] = [motion.heading_p, motion.heading_h];
            let length = (p * p + h * h).sqrt();
            let is_unit = (length - 1.0).abs() < 1e-5;
            if !is_unit {
                return Err(format!("the heading of particle {id} has length {length}"));
            }
            if !(motion.pending >= 0.0 && motion.pending.is_finite()) {
                return Err(format!("particle {id} has {} pending", motion.pending));
            }
        }
        self.transfers
            .validate(&self.particles, &self.motions, setup)?;
        // Deposits on texels that are neither owned nor gutter would be lost.
        let in_gutters = setup.atlas.seams.iter();
        let mut deposited: u64 = in_gutters
            .map(|seam| u64::from(self.deposits[seam.texel as usize]))
            .sum();
        for (texel, (&value, &deposits)) in self.trail.iter().zip(&self.deposits).enumerate() {
            if !(0.0..=MOST_TRAIL).contains(&value) {
                return Err(format!("the trail is {value} at texel {texel}"));
            }
            if setup.atlas.density[texel] > 0.0 {
                deposited += u64::from(deposits);
            }
        }
        if let Some(texel) = self.bias.iter().position(|value| !value.is_finite()) {
            return Err(format!("the bias is {} at texel {texel}", self.bias[texel]));
        }
        let expected = if self.step == 0 {
            0
        } else {
            self.deposit_count()
        };
        if deposited != expected {
            return Err(format!(
                "{deposited} deposits on owned and gutter texels in the last step, not {expected}"
            ));
        }
        Ok(())
    }

    /// Checks that steps can continue from here: no number is so large that arithmetic with it exceeds the range of single precision. The
    /// states of a simulation are far from that, but a checkpoint may hold any numbers. The caller has called [`validate`](Self::validate).
    ///
    /// # Errors
    /// Names the first number that is out of its range.
    pub fn check_ranges(&self, setup: &Setup) -> Result<(), String> {
        let away = self.origin - setup.origin();
        if !away.is_finite() || away.abs().max_element() > FARTHEST {
            return Err("its origin is too far from the scene's".to_owned());
        }
        // A pending length is at most that of a step, which is at most 10 scene radii.
        let most_pending = MOST_PENDING * setup.radius;
        let mut both = self.particles.iter().zip(&self.motions);
        if let Some((particle, motion)) = both.find(|(_, motion)| motion.pending > most_pending) {
            return Err(format!(
                "particle {} has {} pending, and at most {most_pending} is possible",
                particle.id, motion.pending
            ));
        }
        let mut trail = self.trail.iter().enumerate();
        if let Some((texel, value)) = trail.find(|(_, value)| **value > MOST_LOADED_TRAIL) {
            return Err(format!(
                "the trail is {value} at texel {texel}, and a run can continue from at most {MOST_LOADED_TRAIL:e}"
            ));
        }
        let mut bias = self.bias.iter().enumerate();
        let possible = NO_GO * BLENDED..=GREATEST * BLENDED;
        if let Some((texel, value)) = bias.find(|(_, value)| !possible.contains(*value)) {
            return Err(format!(
                "the bias is {value} at texel {texel}, and {NO_GO:e} to {GREATEST:e} is possible"
            ));
        }
        let mut looks = self.looks.iter().enumerate();
        if let Some((texel, weight)) = looks.find(|(_, weight)| !(0.0..=BLENDED).contains(*weight))
        {
            return Err(format!(
                "the weight of the second look is {weight} at texel {texel}, and 0 to 1 is possible"
            ));
        }
        self.check_pulses(setup)?;
        self.transfers.check_ranges(&self.particles, most_pending)
    }

    /// Could a simulation have these pulses?
    fn check_pulses(&self, setup: &Setup) -> Result<(), String> {
        let there = self.pulses.len();
        if there > MOST_PULSES {
            return Err(format!(
                "it has {there} pulses, and {MOST_PULSES} are possible"
            ));
        }
        for (i, live) in self.pulses.iter().enumerate() {
            let is_near = live.center.iter().all(|x| f64::from(x.abs()) <= FARTHEST);
            // They may have begun in a larger scene.
            let is_possible = live.pulse().check(GROWN * setup.radius).is_ok();
            let is_possible = is_possible && live.first_step <= self.step;
            if !is_near || !is_possible {
                return Err(format!("its pulse {i} is damaged"));
            }
        }
        Ok(())
    }

    /// The movement of a scene's objects from here on, if it has this many.
    ///
    /// # Errors
    /// When poses are damaged, or are those of another number of objects.
    pub fn movement_of(&self, objects: usize) -> Result<Movement, String> {
        let movement = self.movement.restore(self.step);
        let there = self.movement.object_count();
        let last = &self.last_poses;
        let are_sound = [there, last.len()] == [objects; 2] && last.iter().all(is_rigid);
        let movement = movement.filter(|_| are_sound).ok_or_else(|| {
            format!(
                "the checkpoint has the poses of {there} objects, or they are damaged; the scene has {objects}"
            )
        })?;
        let there = self.distance_poses.len();
        let is_sound = |pair: &KeptPair| {
            let objects = objects as u32;
            pair.object < objects && pair.other < objects && is_rigid(&pair.other_from_object)
        };
        if ![0, objects].contains(&there)
            || !self.distance_poses.iter().all(is_rigid)
            || !self.kept_pairs.iter().all(is_sound)
        {
            return Err(format!(
                "the checkpoint has distances taken with the poses of {there} objects, or these are damaged; \
                 the scene has {objects}"
            ));
        }
        Ok(movement)
    }

    /// Does it have the remaining amounts of so many foods and markers? A state without any is of a scene without food.
    ///
    /// # Errors
    /// When it has those of another number of foods.
    pub fn check_food(&self, here: usize) -> Result<(), String> {
        let there = self.food.remaining.len();
        if there == here {
            return Ok(());
        }
        Err(format!(
            "the checkpoint has {there} foods and markers, and the scene has {here}: \
             resume with the scene that it was written with"
        ))
    }
}
