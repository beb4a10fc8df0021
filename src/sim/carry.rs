//! Transfers the state of a running simulation to a scene with more or fewer objects, or with another atlas size.

use rayon::prelude::*;

use super::field::{fill_gutters, texel_at, trail_at};
use super::food::FoodPlace;
use super::paint::{GREATEST, NO_GO, NO_GO_BELOW};
use super::setup::Setup;
use super::snapshot::{FoodState, Snapshot};
use super::transfers::TransferState;
use super::types::{Motion, Particle};

/// The state of `old` on the surface of `new`; `from` says for each object of `new` which of `old` it was, if any. Particles and trail stay
/// at their places on their objects, and food keeps its remaining amounts. New objects get as many particles as would begin on them, taken
/// uniformly from everywhere; particles whose object was removed restart, spread over all objects. Distances and transfers restart.
///
/// None if that is impossible: with another number of particles, dead ones included, so that a population needs room for as many as it had;
/// with a population that grows and shrinks in only one of them; or if an object has another mesh.
#[must_use]
pub fn carried(
    snapshot: &Snapshot,
    old: &Setup,
    new: &Setup,
    from: &[Option<usize>],
) -> Option<Snapshot> {
    let to = becoming(old, new, from)?;
    let has_population = !snapshot.population.is_empty();
    if new.particles.len() != snapshot.particles.len() || new.population.is_some() != has_population
    {
        return None;
    }
    let (particles, motions) = carried_particles(snapshot, old, new, from, &to);
    let pitch = old.atlas.pitch;
    let trail = field(old, new, from, &|position| {
        trail_at(&snapshot.trail, position, pitch)
    });
    let deposits = deposits_of(snapshot, new, &particles, &motions);
    let snapshot = &*snapshot.counted_from(new.origin());
    let last_poses = from.iter().zip(&new.poses);
    Some(Snapshot {
        step: snapshot.step,
        movement: snapshot.movement.of_objects(from),
        last_poses: last_poses
            .map(|(from, pose)| from.map_or(*pose, |was| snapshot.last_poses[was]))
            .collect(),
        origin: new.origin(),
        // Each field by name, so that the compiler finds a new field that is missing here.
        distance_poses: Vec::new(),
        kept_pairs: Vec::new(),
        particles,
        motions,
        trail,
        deposits,
        transfers: TransferState::default(),
        bias: carried_bias(&snapshot.bias, old, new, from)?,
        food: FoodState {
            remaining: left_of(snapshot, old, new, from),
            ..snapshot.food
        },
        pulses: snapshot.pulses.clone(),
        looks: carried_looks(&snapshot.looks, old, new, from)?,
        population: snapshot.population.clone(),
    })
}

/// Painted areas of `old`, one per texel, on the surface of `new`: as in [`carried`], also with another number of particles. An empty bias
/// stays empty.
///
/// None if an object has another mesh.
#[must_use]
pub fn carried_bias(
    bias: &[f32],
    old: &Setup,
    new: &Setup,
    from: &[Option<usize>],
) -> Option<Vec<f32>> {
    becoming(old, new, from)?;
    if bias.is_empty() {
        return Some(Vec::new());
    }
    let pitch = old.atlas.pitch;
    Some(field(old, new, from, &|position| {
        // Gutters may mix no-go areas with others: here each value is one or the other.
        match bias[texel_at(position, pitch) as usize] {
            value if value < NO_GO_BELOW => NO_GO,
            value if value < -GREATEST => 0.0,
            value => value,
        }
    }))
}

/// Weights of a second look; as [`carried_bias`].
#[must_use]
pub fn carried_looks(
    looks: &[f32],
    old: &Setup,
    new: &Setup,
    from: &[Option<usize>],
) -> Option<Vec<f32>> {
    becoming(old, new, from)?;
    if looks.is_empty() {
        return Some(Vec::new());
    }
    let pitch = old.atlas.pitch;
    Some(field(old, new, from, &|position| {
        trail_at(looks, position, pitch).clamp(0.0, 1.0)
    }))
}

/// Particles and their motions on the surface of `new`, slot by slot. `to` is the inverse of `from`: for each object of `old` its index in
/// `new`.
fn carried_particles(
    snapshot: &Snapshot,
    old: &Setup,
    new: &Setup,
    from: &[Option<usize>],
    to: &[Option<usize>],
) -> (Vec<Particle>, Vec<Motion>) {
    let is_new = |place: &usize| from[object_of(new, new.particles[*place].triangle)].is_none();
    let count = new.particles.len();
    // Start places follow ids, so the ids that draw places on new objects were in one region before. Moving those would empty it. Instead
    // every n-th particle moves; the places of these were spread over all objects.
    let new_places: Vec<usize> = (0..count).filter(is_new).collect();
    let new_place = |id: usize| {
        let before = |id: usize| (id as u64 * new_places.len() as u64 / count as u64) as usize;
        (before(id + 1) > before(id)).then(|| new_places[before(id)])
    };
    let carry = |(particle, motion): (&Particle, &Motion)| {
        let id = particle.id as usize;
        let begins_at = |place: usize| {
            let begins = Particle {
                id: particle.id,
                ..new.particles[place]
            };
            // Dead ones stay dead.
            let begun = Motion {
                flags: motion.flags & Motion::DEAD,
                ..new.motions[place]
            };
            (begins, begun)
        };
        if let Some(place) = new_place(id) {
            return begins_at(place);
        }
        let Some(object) = to[object_of(old, particle.triangle)] else {
            // For the same reason, each begins at the start place of another one.
            return begins_at((id + count / 2) % count);
        };
        at_its_place((particle, motion), old, new, object)
    };
    let both = snapshot.particles.par_iter().zip(&snapshot.motions);
    both.map(carry).unzip()
}

/// A particle at its place on its object, which is `object` of `new`. Its pending length grows with the object.
fn at_its_place(
    (particle, motion): (&Particle, &Motion),
    old: &Setup,
    new: &Setup,
    object: usize,
) -> (Particle, Motion) {
    let was = object_of(old, particle.triangle);
    let triangle = particle.triangle - first(old, was) + first(new, object);
    let length = |setup: &Setup, triangle: u32| setup.surface.triangles[triangle as usize].ab;
    let grown = length(new, triangle) / length(old, particle.triangle);
    let pending = motion.pending * grown;
    let motion = Motion {
        pending: if pending.is_finite() { pending } else { 0.0 },
        ..*motion
    };
    (
        Particle {
            triangle,
            ..*particle
        },
        motion,
    )
}

/// The last step's deposits: one per living particle, as after every step. Particles that stayed in it left none.
fn deposits_of(
    snapshot: &Snapshot,
    new: &Setup,
    particles: &[Particle],
    motions: &[Motion],
) -> Vec<u32> {
    let mut deposits = vec![0; new.atlas.texel_count()];
    if snapshot.step > 0 {
        let all = particles.iter().zip(motions);
        for (particle, motion) in all.filter(|(_, motion)| motion.has_deposited()) {
            let texel = new
                .atlas
                .texel_of(particle.triangle, particle.u, particle.v);
            deposits[texel as usize] += match motion.fed() {
                0 => 1,
                _ => snapshot.food.fed_deposit,
            };
        }
    }
    deposits
}

/// For each object of `old` its index in `new`, if it still exists; `None` if one has another mesh.
fn becoming(old: &Setup, new: &Setup, from: &[Option<usize>]) -> Option<Vec<Option<usize>>> {
    let triangles = |setup: &Setup, object: usize| {
        let range = setup.surface.objects.get(object)?;
        Some(range.triangles.1 - range.triangles.0)
    };
    let mut to = vec![None; old.poses.len()];
    for (object, from) in from.iter().enumerate() {
        let Some(was) = *from else { continue };
        if triangles(old, was)? != triangles(new, object)? {
            return None;
        }
        *to.get_mut(was)? = Some(object);
    }
    (from.len() == new.poses.len()).then_some(to)
}

/// The object that a triangle belongs to.
fn object_of(setup: &Setup, triangle: u32) -> usize {
    setup.surface.triangles[triangle as usize].object as usize
}

/// An object's first triangle.
fn first(setup: &Setup, object: usize) -> u32 {
    setup.surface.objects[object].triangles.0
}

/// A field of `new`, gutters filled, with the values of `old` at the same places of the surface; 0 on new objects.
fn field(
    old: &Setup,
    new: &Setup,
    from: &[Option<usize>],
    read: &(dyn Fn([f32; 2]) -> f32 + Sync),
) -> Vec<f32> {
    // The position of a texel's surface point in the old atlas.
    let old_position = |texel: usize| {
        let (triangle, u, v) = new.atlas.surface_point_of(texel as u32)?;
        let object = object_of(new, triangle);
        let was = from[object]?;
        let triangle = triangle - first(new, object) + first(old, was);
        Some(old.atlas.position_of(triangle, u, v).to_array())
    };
    let texels = (0..new.atlas.texel_count()).into_par_iter();
    let mut values: Vec<f32> = texels
        .map(|texel| old_position(texel).map_or(0.0, read))
        .collect();
    fill_gutters(&new.atlas.seams, &mut values);
    values
}

/// The remaining meals of each of the new scene's foods: unchanged foods keep theirs.
fn left_of(snapshot: &Snapshot, old: &Setup, new: &Setup, from: &[Option<usize>]) -> Vec<u32> {
    let left = |place: &FoodPlace| {
        let object = place.object as usize;
        let was = from[object]?;
        let first = |setup: &Setup, object: usize| setup.surface.objects[object].triangles.0;
        let triangle = place.point.triangle - first(new, object) + first(old, was);
        let at = |other: &FoodPlace| {
            let [u, v] = [other.point.u - place.point.u, other.point.v - place.point.v];
            let apart = (u * u + v * v).sqrt();
            other.point.triangle == triangle && apart < 1e-3 && other.amount == place.amount
        };
        let food = old.food_set.places.iter().position(at)?;
        snapshot.food.remaining.get(food).copied()
    };
    let places = new.food_set.places.iter();
    places
        .map(|place| place.meal(left(place)).remaining)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use crate::scene::settings::{ObjectSettings, Settings};
    use crate::sim::pulse::Pulse;
    use crate::sim::twin;
    use glam::Vec3;

    fn settings(objects: &[(&str, f32)]) -> Settings {
        let mut settings = Settings::default();
        settings.particles.count = 3000;
        settings.atlas.size = 128;
        settings.radius = 1.0;
        settings.objects = (objects.iter())
            .map(|(mesh, scale)| ObjectSettings {
                mesh: format!("builtin:{mesh}"),
                scale: *scale,
                ..ObjectSettings::default()
            })
            .collect();
        for (i, object) in settings.objects.iter_mut().enumerate() {
            object.position = [2.5 * i as f64, 0.0, 0.0];
        }
        settings
    }

    fn setup(settings: &Settings) -> Setup {
        let scene = Scene::from_settings("carry".to_owned(), settings.clone(), ".".into());
        Setup::new(&scene.unwrap()).unwrap()
    }

    const CUBE: (&str, f32) = ("cube?divisions=4", 1.0);
    const BALL: (&str, f32) = ("icosphere?subdivisions=2", 1.0);

    fn grown() -> (twin::Simulation, Snapshot) {
        let settings = settings(&[CUBE, BALL]);
        let mut simulation = twin::Simulation::new(setup(&settings), settings);
        for _ in 0..5 {
            simulation.step();
        }
        let snapshot = simulation.snapshot();
        (simulation, snapshot)
    }

    /// Checks that a simulation continues from the state, without losing particles.
    fn goes_on(settings: &Settings, state: &Snapshot) {
        let new = setup(settings);
        state.validate(&new).unwrap();
        let mut simulation = twin::Simulation::new(new, settings.clone());
        simulation.restore(state);
        simulation.step();
        simulation.snapshot().validate(simulation.setup()).unwrap();
    }

    #[test]
    fn the_same_scene_keeps_everything() {
        let (simulation, mut state) = grown();
        let same = simulation.setup();
        let pulse = Pulse {
            center: Vec3::Y,
            speed: 0.02,
            width: 0.1,
            reach: 2.0,
            strength: 0.5,
        };
        state.pulses = vec![pulse.beginning_at(4)];
        let carried = carried(&state, same, same, &[Some(0), Some(1)]).unwrap();
        assert_eq!(carried.particles, state.particles);
        assert_eq!(carried.pulses, state.pulses);
        let off = carried.trail.iter().zip(&state.trail);
        let off = off.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off < 1e-3, "{off}");
        goes_on(simulation.settings(), &carried);
    }

    #[test]
    fn an_object_that_grows_keeps_its_trail() {
        let (simulation, state) = grown();
        let larger = settings(&[CUBE, (BALL.0, 1.5)]);
        let new = setup(&larger);
        let carried = carried(&state, simulation.setup(), &new, &[Some(0), Some(1)]).unwrap();
        let mean = |trail: &[f32], setup: &Setup, object: u32| {
            let own: Vec<f32> = (trail.iter().zip(&setup.atlas.owner))
                .filter(|(_, owner)| {
                    let shape = setup.surface.triangles.get(**owner as usize);
                    shape.is_some_and(|shape| shape.object == object)
                })
                .map(|(value, _)| *value)
                .collect();
            own.iter().sum::<f32>() / own.len() as f32
        };
        for object in [0, 1] {
            let before = mean(&state.trail, simulation.setup(), object);
            let after = mean(&carried.trail, &new, object);
            assert!((after / before - 1.0).abs() < 0.1, "{before}, {after}");
        }
        goes_on(&larger, &carried);
    }

    #[test]
    fn objects_that_come_get_their_share_and_those_that_go_leave_theirs() {
        let (simulation, state) = grown();
        let more = settings(&[CUBE, BALL, BALL]);
        let new = setup(&more);
        let from = [Some(0), Some(1), None];
        let three = carried(&state, simulation.setup(), &new, &from).unwrap();
        let on = |state: &Snapshot, setup: &Setup, object: u32| {
            let own = state.particles.iter().filter(|particle| {
                setup.surface.triangles[particle.triangle as usize].object == object
            });
            own.count()
        };
        // By area: 24 to a cube, 4 pi to each ball.
        let share = on(&three, &new, 2) as f64 / 3000.0;
        assert!((share - 12.3 / (24.0 + 2.0 * 12.3)).abs() < 0.04, "{share}");
        goes_on(&more, &three);

        // They come from everywhere: on both sides of each of the other objects the same share stays.
        let halves = |state: &Snapshot, setup: &Setup, object: u32| {
            let surface = &setup.surface;
            let mut counts = [0_u32; 6];
            for particle in &state.particles {
                let triangle = particle.triangle as usize;
                if surface.triangles[triangle].object != object {
                    continue;
                }
                let corners = surface.corners[triangle].map(|i| surface.positions[i as usize]);
                let at: Vec3 = corners.into_iter().sum();
                for axis in 0..3 {
                    counts[2 * axis + usize::from(at[axis] > 0.0)] += 1;
                }
            }
            counts.map(f64::from)
        };
        for object in [0, 1] {
            let before = halves(&state, simulation.setup(), object);
            let after = halves(&three, &new, object);
            let stay = f64::from(on(&three, &new, object) as u32)
                / f64::from(on(&state, simulation.setup(), object) as u32);
            for (before, after) in before.into_iter().zip(after) {
                let off = after / before / stay;
                assert!(
                    (off - 1.0).abs() < 0.15,
                    "{object}: {before}, {after} of {stay}"
                );
            }
        }

        let less = settings(&[BALL]);
        let alone = carried(&state, simulation.setup(), &setup(&less), &[Some(1)]).unwrap();
        assert_eq!(alone.particles.len(), 3000);
        // They go everywhere, each to a different place.
        let mut places: Vec<[u32; 3]> = (alone.particles.iter())
            .map(|p| [p.triangle, p.u.to_bits(), p.v.to_bits()])
            .collect();
        places.sort_unstable();
        places.dedup();
        assert_eq!(places.len(), 3000);
        let before = halves(&state, simulation.setup(), 1);
        let after = halves(&alone, &setup(&less), 0);
        let grown = 3000.0 / f64::from(on(&state, simulation.setup(), 1) as u32);
        for (before, after) in before.into_iter().zip(after) {
            let off = after / before / grown;
            assert!((off - 1.0).abs() < 0.15, "{before}, {after} of {grown}");
        }
        goes_on(&less, &alone);
        // With another mesh, or another number of particles, nothing can be transferred.
        assert!(carried(&state, simulation.setup(), &setup(&less), &[Some(0)]).is_none());
        let mut fewer = less;
        fewer.particles.count = 10;
        assert!(carried(&state, simulation.setup(), &setup(&fewer), &[Some(1)]).is_none());
    }
}
