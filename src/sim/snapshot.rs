//! The whole state of a simulation on the host, for hashes, checks, checkpoints and exports.

mod checks;

use std::borrow::Cow;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::distance::KeptPair;
use super::movement::SavedMovement;
use super::pulse::LivePulse;
use super::setup::Setup;
use super::transfers::TransferState;
use super::types::{Motion, Particle, Population, Pose, Transfer};
use crate::strict::settled;

/// The state after some step. The default belongs to no scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshot {
    /// Steps done.
    pub step: u64,
    /// The objects' time, and their poses from outside.
    pub movement: SavedMovement,
    /// The poses of the last step, without those that were set afterwards; before the first step the scene's.
    pub last_poses: Vec<Pose>,
    /// The poses for which distances between objects were last computed; none before the first time.
    pub distance_poses: Vec<Pose>,
    /// Pairs of objects that have moved by no more than rounding since their distances were computed, with the poses of that time.
    pub kept_pairs: Vec<KeptPair>,
    /// Places and ids of particles. Of dead ones, which their flags mark, only the ids have a meaning.
    pub particles: Vec<Particle>,
    /// Their headings, pending lengths and flags.
    pub motions: Vec<Motion>,
    /// Origin of poses and transfers, in world coordinates.
    pub origin: DVec3,
    /// The trail, one per texel, gutters filled.
    pub trail: Vec<f32>,
    /// The last step's deposits, one per texel.
    pub deposits: Vec<u32>,
    /// Counters of transfers, the objects' windows, and where particles restart.
    pub transfers: TransferState,
    /// The painted bias, one value per texel, gutters filled; empty if nothing was painted.
    pub bias: Vec<f32>,
    /// The remaining meals of foods.
    pub food: FoodState,
    /// The pulses that have begun and not ended, the oldest first.
    pub pulses: Vec<LivePulse>,
    /// Weights of the second look, one per texel, gutters filled; empty if nothing was painted.
    pub looks: Vec<f32>,
    /// One if the population grows and shrinks: how many particles are alive, and counters.
    pub population: Vec<Population>,
}

/// Food and markers after some step.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FoodState {
    /// The remaining meals of each; always 1 for endless food.
    pub remaining: Vec<u32>,
    /// The number of particles that a fed one counted as in the last step's deposits.
    pub fed_deposit: u32,
}

impl Default for FoodState {
    fn default() -> Self {
        Self {
            remaining: Vec::new(),
            fed_deposit: 1,
        }
    }
}

/// Distances to other objects, from every texel.
#[derive(Clone, Debug, PartialEq)]
pub struct Distances {
    /// Signed distance to the nearest other object, world units, within reach either way; gutters filled.
    pub signed: Vec<f32>,
    /// The triangle of another object that is nearest, `NONE` beyond reach; valid on owned texels only.
    pub nearest: Vec<u32>,
}

/// How the ids of a population differ from one of each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Census {
    /// Ids that no particle has.
    pub lost: u64,
    /// Particles whose id another particle has, too.
    pub doubled: u64,
}

impl Snapshot {
    /// The state before the first step.
    #[must_use]
    pub fn start(setup: &Setup) -> Self {
        let texels = setup.atlas.density.len();
        let meals = setup.food_set.meals(None);
        Self {
            last_poses: setup.poses.clone(),
            particles: setup.particles.clone(),
            motions: setup.motions.clone(),
            origin: setup.origin(),
            trail: vec![0.0; texels],
            deposits: vec![0; texels],
            bias: setup.bias.clone(),
            looks: setup.looks.clone(),
            population: setup.population.into_iter().collect(),
            food: FoodState {
                remaining: meals.iter().map(|meal| meal.remaining).collect(),
                ..FoodState::default()
            },
            ..Self::default()
        }
    }

    /// The state with coordinates counted from another origin. With an equal origin its bits stay; otherwise poses and transfers are
    /// rounded once.
    #[must_use]
    pub fn counted_from(&self, origin: DVec3) -> Cow<'_, Self> {
        if origin == self.origin {
            return Cow::Borrowed(self);
        }
        let by = self.origin - origin;
        let moved = |x: f32, by: f64| (f64::from(x) + by) as f32;
        let mut state = self.clone();
        state.origin = origin;
        for pose in state.last_poses.iter_mut().chain(&mut state.distance_poses) {
            pose.x.w = moved(pose.x.w, by.x);
            pose.y.w = moved(pose.y.w, by.y);
            pose.z.w = moved(pose.z.w, by.z);
        }
        for pulse in &mut state.pulses {
            let center = Vec3::from_array(pulse.center).as_dvec3() + by;
            pulse.center = center.as_vec3().to_array();
        }
        for transfer in &mut state.transfers.in_flight {
            transfer.position = (transfer.position.as_dvec3() + by).as_vec3();
        }
        Cow::Owned(state)
    }

    /// Replaces zeros with a sign, and numbers that some devices treat as zero, by 0, as steps store them: checkpoints of earlier versions
    /// may have such numbers.
    pub(super) fn settle(&mut self) {
        self.particles.par_iter_mut().for_each(|particle| {
            particle.u = settled(particle.u);
            particle.v = settled(particle.v);
        });
        self.motions.par_iter_mut().for_each(|motion| {
            motion.heading_p = settled(motion.heading_p);
            motion.heading_h = settled(motion.heading_h);
            motion.pending = settled(motion.pending);
        });
        let texels = self.trail.par_iter_mut().chain(&mut self.bias);
        let texels = texels.chain(&mut self.looks);
        texels.for_each(|value| *value = settled(*value));
    }

    /// Clears the counts within steps. Versions with other arithmetic had marks of the last advance where dead particles, those that were
    /// refused a cell, and hungry ones are marked now, and something else in the count of those that were refused.
    pub(super) fn forget_turns(&mut self, is_earlier: bool) {
        const STAMP: u32 = 0xfffe;
        let flow = &mut self.transfers.flow;
        *flow = flow.between_steps();
        if is_earlier {
            flow.left_over = 0;
            for motion in &mut self.motions {
                motion.flags &= !STAMP;
            }
        }
    }

    /// A hash of the number of steps, everything that living particles carry, the trail's bits, paint (the bias and the weights of the
    /// second look), the remaining food and live pulses; not of poses, of the objects' time, of the last step's deposits or of counters.
    /// The order of particles has no effect, so two runs with particles in different slots compare equal.
    #[must_use]
    pub fn hash(&self) -> u64 {
        let particles = self
            .particles
            .par_iter()
            .zip(&self.motions)
            .filter(|(_, motion)| !motion.is_dead())
            .map(|(particle, motion)| {
                let words: [u32; 8] = bytemuck::cast([
                    bytemuck::cast::<_, [u32; 4]>(*particle),
                    bytemuck::cast(*motion),
                ]);
                hash_words(&words)
            });
        let trail = self
            .trail
            .par_iter()
            .enumerate()
            .map(|(texel, value)| hash_words(&[texel as u32, value.to_bits()]));
        let in_flight = self.transfers.in_flight.par_iter().map(|transfer| {
            let id = self.particles[transfer.particle as usize].id;
            // The hash has the particle's id instead of its slot.
            let particle = Transfer {
                particle: id,
                ..*transfer
            };
            hash_words(&bytemuck::cast::<_, [u32; 16]>(particle))
        });
        // A field in which everything was erased counts as absent.
        let painted = self.bias.par_iter().enumerate();
        let bias = painted
            .filter(|(_, value)| **value != 0.0)
            .map(|(texel, value)| hash_words(&[BIAS, texel as u32, value.to_bits()]));
        let painted = self.looks.par_iter().enumerate();
        let looks = painted
            .filter(|(_, value)| **value != 0.0)
            .map(|(texel, value)| hash_words(&[LOOK, texel as u32, value.to_bits()]));
        let remaining = self.food.remaining.par_iter().enumerate();
        let food = remaining.map(|(food, left)| hash_words(&[FOOD, food as u32, *left]));
        let live = self.pulses.par_iter().enumerate();
        let pulses = live.map(|(i, pulse)| {
            let words: [u32; 10] = bytemuck::cast(*pulse);
            hash_words(
                &[PULSE, i as u32]
                    .into_iter()
                    .chain(words)
                    .collect::<Vec<_>>(),
            )
        });
        particles
            .chain(trail)
            .chain(in_flight)
            .chain(bias)
            .chain(food)
            .chain(pulses)
            .chain(looks)
            .reduce(|| 0, u64::wrapping_add)
            .wrapping_add(self.step)
    }

    /// Does every id exist exactly once?
    #[must_use]
    pub fn census(&self) -> Census {
        let mut seen = vec![false; self.particles.len()];
        let mut census = Census::default();
        for particle in &self.particles {
            match seen.get_mut(particle.id as usize) {
                Some(seen) if !*seen => *seen = true,
                _ => census.doubled += 1,
            }
        }
        census.lost = seen.iter().filter(|seen| !**seen).count() as u64;
        census
    }

    /// The sum of trail value times surface area over the texels that a triangle owns.
    #[must_use]
    pub fn trail_mass(&self, setup: &Setup) -> f64 {
        self.trail
            .iter()
            .zip(&setup.atlas.area)
            .map(|(&value, &area)| f64::from(value) * f64::from(area))
            .sum()
    }

    /// The number of particles that are alive.
    #[must_use]
    pub fn living_count(&self) -> u64 {
        let living = self.motions.iter().filter(|motion| !motion.is_dead());
        living.count() as u64
    }

    /// The sum of deposits in the last step: one per living particle that was not refused a cell, more for fed ones.
    #[must_use]
    pub fn deposit_count(&self) -> u64 {
        let left = self.motions.iter().filter(|motion| motion.has_deposited());
        let amounts = left.map(|motion| match motion.fed() {
            0 => 1,
            _ => u64::from(self.food.fed_deposit),
        });
        amounts.sum()
    }

    /// The number of particles that were refused a cell in the last step, with one particle a cell.
    #[must_use]
    pub fn stayed_count(&self) -> u64 {
        let stayed = self.motions.iter().filter(|motion| motion.has_stayed());
        stayed.count() as u64
    }
}

/// Makes the hash of a texel's bias differ from that of its trail.
const BIAS: u32 = 0xb1a5;
/// Makes the hash of an amount of food differ from that of other values.
const FOOD: u32 = 0xf00d;
/// Makes the hash of a texel's second look differ from that of its trail.
const LOOK: u32 = 0x100c;
/// Makes the hash of a pulse differ from that of other values.
const PULSE: u32 = 0x9015e;

/// Mixes words to 64 bits, with a multiplication and a shift for each (the finalizer of MurmurHash3, Appleby 2011).
fn hash_words(words: &[u32]) -> u64 {
    words.iter().fold(0x9e37_79b9_7f4a_7c15, |hash, &word| {
        let mut h = (hash ^ u64::from(word)).wrapping_mul(0xff51_afd7_ed55_8ccd);
        h ^= h >> 33;
        h = h.wrapping_mul(0xc4ce_b9fe_1a85_ec53);
        h ^ (h >> 33)
    })
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable as _;
    use glam::{Affine3A, Vec3};

    use super::*;

    /// Would catch: objects in wrong places after a scene with another origin has loaded a state.
    #[test]
    fn states_are_counted_from_the_origin_of_the_scene_that_takes_them() {
        let near = Snapshot {
            last_poses: vec![Affine3A::from_translation(Vec3::new(0.5, -2.0, 3.0)).into()],
            distance_poses: vec![Affine3A::from_translation(Vec3::X).into()],
            pulses: vec![LivePulse {
                center: [1.0, 2.0, 4.0],
                ..LivePulse::zeroed()
            }],
            ..snapshot()
        };
        assert!(matches!(near.counted_from(DVec3::ZERO), Cow::Borrowed(_)));
        let origin = DVec3::new(64.0, -128.0, 0.25);
        let moved = near.counted_from(origin).into_owned();
        let pose = &moved.last_poses[0];
        assert_eq!([pose.x.w, pose.y.w, pose.z.w], [-63.5, 126.0, 2.75]);
        assert_eq!(moved.distance_poses[0].x.w, -63.0);
        assert_eq!(moved.pulses[0].center, [-63.0, 130.0, 3.75]);
        assert_eq!(moved.origin, origin);
        assert_eq!(*moved.counted_from(DVec3::ZERO), near);
    }

    #[test]
    fn what_some_devices_take_for_zero_is_taken_up_as_zero() {
        let mut odd = snapshot();
        odd.particles[5].u = -0.0;
        odd.particles[6].v = 1e-40;
        odd.motions[7].heading_h = -0.0;
        odd.motions[8].heading_p = -1e-45;
        odd.motions[9].pending = f32::MIN_POSITIVE.next_down();
        odd.trail[2] = -0.0;
        odd.bias = vec![1e-42, -0.0, f32::MIN_POSITIVE, -3.0];
        odd.settle();
        let mut plain = snapshot();
        plain.particles[5].u = 0.0;
        plain.particles[6].v = 0.0;
        plain.motions[8].heading_p = 0.0;
        plain.motions[9].pending = 0.0;
        plain.bias = vec![0.0, 0.0, f32::MIN_POSITIVE, -3.0];
        assert_eq!(odd.hash(), plain.hash());
        assert!(odd.bias.iter().all(|value| value.to_bits() != 0x8000_0000));
    }

    fn snapshot() -> Snapshot {
        let particles: Vec<Particle> = (0..100)
            .map(|id| Particle {
                triangle: id % 7,
                u: 0.25,
                v: 0.5,
                id,
            })
            .collect();
        let motions = particles
            .iter()
            .map(|p| Motion {
                heading_p: 1.0,
                heading_h: 0.0,
                pending: p.id as f32,
                flags: 0,
            })
            .collect();
        Snapshot {
            step: 3,
            particles,
            motions,
            trail: vec![0.5, 0.25, 0.0, 1.0],
            deposits: vec![0; 4],
            ..Snapshot::default()
        }
    }

    #[test]
    fn hash_ignores_slots_and_sees_everything_else() {
        let state = snapshot();
        let mut moved = state.clone();
        moved.particles.swap(3, 90);
        moved.motions.swap(3, 90);
        assert_eq!(moved.hash(), state.hash());

        let mut changed = state.clone();
        changed.motions.swap(3, 90);
        assert_ne!(changed.hash(), state.hash(), "headings belong to particles");
        let mut changed = state.clone();
        changed.trail.swap(0, 1);
        assert_ne!(
            changed.hash(),
            state.hash(),
            "trail values belong to texels"
        );
        let mut changed = state.clone();
        changed.particles[5].u = f32::from_bits(changed.particles[5].u.to_bits() + 1);
        assert_ne!(changed.hash(), state.hash(), "the last bit counts");

        let mut painted = state.clone();
        painted.bias = vec![0.0; 4];
        assert_eq!(painted.hash(), state.hash(), "all erased is as none");
        painted.bias[2] = -1.0;
        assert_ne!(painted.hash(), state.hash(), "what was painted counts");

        let mut swept = state.clone();
        let pulse = LivePulse {
            first_step: 3,
            ..LivePulse::zeroed()
        };
        swept.pulses = vec![pulse];
        assert_ne!(swept.hash(), state.hash(), "live pulses count");
        let mut later = swept.clone();
        later.pulses[0].first_step = 2;
        assert_ne!(later.hash(), swept.hash(), "and when they began");

        let mut fed = state.clone();
        fed.food.remaining = vec![5, 1];
        assert_ne!(fed.hash(), state.hash(), "what is left to eat counts");
        let mut eaten = fed.clone();
        eaten.food.remaining = vec![1, 5];
        assert_ne!(eaten.hash(), fed.hash(), "and of which food");
        eaten.food = fed.food.clone();
        eaten.motions[8].flags = 3 << Motion::FED_SHIFT;
        assert_ne!(eaten.hash(), fed.hash(), "and which particles are fed");

        let flight = Transfer {
            particle: 3,
            target: 1,
            ..Transfer::default()
        };
        let mut flying = state.clone();
        flying.transfers.in_flight.push(flight);
        assert_ne!(flying.hash(), state.hash(), "flights count");
        let mut moved = flying.clone();
        moved.particles.swap(3, 90);
        moved.motions.swap(3, 90);
        moved.transfers.in_flight[0].particle = 90;
        assert_eq!(moved.hash(), flying.hash(), "wherever the particle lies");
        moved.transfers.in_flight[0].target = 2;
        assert_ne!(moved.hash(), flying.hash());
    }

    /// The hash does not depend on how threads share the work.
    #[test]
    fn hash_does_not_depend_on_the_number_of_threads() {
        let mut state = snapshot();
        state.trail = (0..100_000).map(|i| i as f32).collect();
        let with_threads = |count| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
            pool.expect("there are threads").install(|| state.hash())
        };
        let one = with_threads(1);
        for count in [2, 3, 16] {
            assert_eq!(with_threads(count), one, "{count} threads");
        }
        let next = Snapshot {
            step: 4,
            ..state.clone()
        };
        assert_ne!(next.hash(), one, "the step counts");
    }

    #[test]
    fn census_counts_lost_and_doubled() {
        let mut state = snapshot();
        assert_eq!(state.census(), Census::default());
        state.particles[10].id = 11;
        state.particles[20].id = 100;
        assert_eq!(
            state.census(),
            Census {
                lost: 2,
                doubled: 2
            }
        );
    }
}
