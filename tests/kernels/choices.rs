//! Kernels that do in another way what parts of a step do, against their twins, and against each other: those of the example
//! `choices`, recorded by its own functions.

#[path = "../../examples/choices/differences.rs"]
#[allow(dead_code, reason = "the example uses all of it")]
mod differences;
#[path = "../../examples/choices/tables.rs"]
mod tables;
#[path = "../../examples/choices/twins.rs"]
mod twins;
#[path = "../../examples/choices/ways.rs"]
#[allow(dead_code, reason = "the example uses all of it")]
mod ways;

use crate::common::{awkward_sizes, gpu, scene};
use myxo::rng::{Purpose, random, unit};
use myxo::scene::Settings;
use myxo::scene::settings::Start;
use myxo::sim::Setup;
use myxo::sim::behaviour::physarums;
use myxo::sim::types::{Motion, Particle};

use ways::kernels::{CountDepositsParams, WalkCorrectedParams, WalkExactlyParams};
use ways::{Binding, Reach, State, WAYS, Walk, Walking, Ways};

const TORUS: &str = "builtin:torus?major=24&minor=16";

/// Particles at their start, some of them with way pending, on a random trail.
fn start(mesh: &str, count: u32, start: Start) -> (Settings, Setup, State) {
    let scene = scene(mesh, |settings| {
        settings.particles.count = count;
        settings.particles.start = start;
    });
    let setup = Setup::new(&scene).unwrap();
    let texels = setup.atlas.density.len() as u32;
    let mut state = State {
        particles: setup.particles.clone(),
        motions: setup.motions.clone(),
        trail: (0..texels)
            .map(|texel| unit(random(5, texel, 0, Purpose::Start)[0]))
            .collect(),
    };
    for (i, motion) in state.motions.iter_mut().enumerate() {
        motion.pending = [0.0, 0.013][i % 2];
    }
    (scene.settings, setup, state)
}

/// Nearly all are where the twin has them; on an edge, the last bit decides the triangle.
fn compare(what: &str, kernel: &(Vec<Particle>, Vec<Motion>), twin: &(Vec<Particle>, Vec<Motion>)) {
    let mut elsewhere = 0;
    for i in 0..twin.0.len() {
        let (a, b) = (&kernel.0[i], &twin.0[i]);
        let (m, n) = (&kernel.1[i], &twin.1[i]);
        assert_eq!((a.id, m.flags), (b.id, n.flags), "{what}");
        if a.triangle != b.triangle {
            elsewhere += 1;
            continue;
        }
        for (x, y) in [
            (a.u, b.u),
            (a.v, b.v),
            (m.heading_p, n.heading_p),
            (m.heading_h, n.heading_h),
            (m.pending, n.pending),
        ] {
            assert!(
                (x - y).abs() < 5e-4,
                "{what}, {i}: {a:?} {m:?}\n{b:?} {n:?}"
            );
        }
    }
    assert!(elsewhere * 100 <= twin.0.len(), "{what}: {elsewhere}");
}

/// The ends of the first `count` particles by the twins of walks.
fn twins_of(
    setup: &Setup,
    walk: Walk,
    mut particles: Vec<Particle>,
    mut motions: Vec<Motion>,
) -> (Vec<Particle>, Vec<Motion>) {
    let (attempts, way) = (walk.attempts, walk.length);
    let particle_count = particles.len() as u32;
    if walk.walking == Walking::Exact {
        let params = WalkExactlyParams {
            particle_count,
            attempts,
            way,
        };
        twins::walk_exactly(&params, &setup.strips, &mut particles, &mut motions);
    } else {
        let params = WalkCorrectedParams {
            particle_count,
            attempts,
            way,
        };
        let turning = tables::turning_strips(&setup.surface, &setup.strips);
        twins::walk_corrected(&params, &turning, &mut particles, &mut motions);
    }
    (particles, motions)
}

#[test]
fn walks_agree_with_their_twins() {
    let Some(gpu) = gpu() else { return };
    for mesh in [TORUS, "builtin:plane?columns=5&rows=4"] {
        let (settings, setup, state) = start(mesh, 1021, Start::default());
        let ways = Ways::new(&gpu.ctx, &settings, &setup, &state).unwrap();
        for count in awkward_sizes(64) {
            let particles = &state.particles[..count as usize];
            let motions = &state.motions[..count as usize];
            for (attempts, length) in [(10, 0.3), (1, 0.3), (0, 0.3), (10, 0.01)] {
                for walking in [Walking::Exact, Walking::Corrected] {
                    let walk = Walk {
                        reach: Reach::Step,
                        walking,
                        length,
                        attempts,
                    };
                    let kernel = ways.walked(walk, 1, particles, motions).unwrap();
                    let own = twins_of(&setup, walk, particles.to_vec(), motions.to_vec());
                    compare(&format!("{mesh}, {count}, {walk:?}"), &kernel, &own);
                }
            }
        }
    }
    gpu.finish();
}

/// The exact test ends where a walk in double precision does; walks that are corrected afterwards are off where corners are
/// passed, and where the way ends within the first triangle or behind one edge in the plane, are not.
#[test]
fn walks_that_are_corrected_are_off_at_corners_only() {
    let (_, setup, state) = start(TORUS, 3000, Start::default());
    let errors = |walking, attempts| -> Vec<f64> {
        let walk = Walk {
            reach: Reach::Step,
            walking,
            length: 0.3,
            attempts,
        };
        let (particles, motions) = (state.particles.clone(), state.motions.clone());
        let (walked, _) = twins_of(&setup, walk, particles, motions);
        for particle in &walked {
            assert!(particle.u >= 0.0 && particle.v >= 0.0 && particle.u + particle.v < 1.00001);
        }
        let (surface, length) = (&setup.surface, f64::from(walk.length));
        let ends = differences::errors(surface, &state.particles, &state.motions, length, &walked);
        let mut errors: Vec<f64> = ends.iter().map(|end| end.off).collect();
        errors.sort_by(f64::total_cmp);
        errors
    };
    let exact = errors(Walking::Exact, 20);
    assert!(exact[2850] < 1e-5, "{}", exact[2850]);
    let [often, once] = [20, 1].map(|attempts| errors(Walking::Corrected, attempts));
    assert!(often[100] < 1e-5 && often[2850] > 1e-3, "{often:?}");
    assert!(
        once[2850] > often[2850],
        "{} and {}",
        once[2850],
        often[2850]
    );
}

#[test]
fn counts_are_those_of_the_twin_however_particles_crowd() {
    let Some(gpu) = gpu() else { return };
    for (count, from) in [
        (1, Start::default()),
        (65, Start::default()),
        (5000, Start::default()),
        (5000, Start::Point),
    ] {
        let (settings, setup, state) = start(TORUS, count, from);
        let ways = Ways::new(&gpu.ctx, &settings, &setup, &state).unwrap();
        let params = CountDepositsParams {
            particle_count: count,
            pitch: setup.atlas.pitch,
        };
        let mut expected = vec![0; setup.atlas.density.len()];
        twins::count_deposits(&params, &setup.strips, &state.particles, &mut expected);
        assert_eq!(expected.iter().sum::<u32>(), count);
        let is_crowded = expected.iter().any(|count| *count > 1000);
        assert_eq!(is_crowded, from == Start::Point);
        let [counted, drawn] = ways.counts().unwrap();
        assert!(counted == expected, "{count} counted");
        assert!(drawn == expected, "{count} drawn");
    }
    gpu.finish();
}

#[test]
fn sensors_read_the_same_whichever_way_the_trail_is_bound() {
    let Some(gpu) = gpu() else { return };
    let (settings, setup, state) = start(TORUS, 1021, Start::default());
    let ways = Ways::new(&gpu.ctx, &settings, &setup, &state).unwrap();
    let attempts = settings.physarum.edge_crossing_attempts;
    let own = physarums(&settings, &setup)[0];
    let places = tables::sensor_places(&setup.strips, attempts, &own, &state);
    assert_eq!(places.len(), 2 * 1021);
    let expected = twins::read_sensors(&places, &state.trail, setup.atlas.pitch);
    for binding in [
        Binding::Texels,
        Binding::Block,
        Binding::StorageTexels,
        Binding::Image,
        Binding::Sampler,
    ] {
        let read = ways.readings(binding).unwrap();
        // Samplers weigh by 8 bits at the least: of three readings between 0 and 1, each off by 1/256 along both axes.
        let bound = match binding {
            Binding::Sampler => 6.0 / 256.0,
            _ => 2e-6,
        };
        for (i, (a, b)) in read.iter().zip(&expected).enumerate() {
            assert!((a - b).abs() <= bound, "{binding:?}, {i}: {a} and {b}");
        }
    }
    gpu.finish();
}

#[test]
fn every_way_has_its_own_name() {
    let mut kernels = WAYS.map(|way| way.kernel).to_vec();
    kernels.sort_unstable();
    kernels.dedup();
    assert_eq!(kernels.len(), WAYS.len());
}

#[test]
fn percentiles_are_values_of_the_list() {
    let values = (0..=100).rev().map(f64::from).collect();
    assert_eq!(differences::percentiles(values), [50.0, 95.0, 100.0]);
    assert_eq!(differences::percentiles(vec![3.0]), [3.0; 3]);
    assert_eq!(differences::percentiles(Vec::new()), [0.0; 3]);
}
