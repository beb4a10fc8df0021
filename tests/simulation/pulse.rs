//! Pulses: both engines, what they do to particles over seams and on another object, and what is kept of them.

use crate::advance;
use crate::common::{Gpu, TRIO, gpu, scene, scene_of_several};
use glam::Vec3;
use myxo::scene::Scene;
use myxo::scene::settings::{PulseSettings, Sensing, Settings, Strategy};
use myxo::sim::checkpoint::Checkpoint;
use myxo::sim::ground::Ground;
use myxo::sim::pulse::{MOST_PULSES, Pulse};
use myxo::sim::{Setup, Simulation, Snapshot, twin};

/// A torus, a cube and a ball that touch; the cube turns.
fn trio(change: impl FnOnce(&mut Settings)) -> Scene {
    scene_of_several(&TRIO, |s| {
        s.particles.count = 3000;
        s.atlas.size = 128;
        s.physarum.speed = 0.02;
        s.objects[1].motion.spin = [0.0, 50.0, 0.0];
        change(s);
    })
}

fn pulse_at(center: Vec3, radius: f32) -> Pulse {
    Pulse {
        center,
        speed: 0.06 * radius,
        width: 0.3 * radius,
        reach: 1.2 * radius,
        strength: 0.8,
    }
}

/// A pulse of the scene, and one that is sent while it runs, on the device and by the twins: all states have equal hashes, before,
/// while they are live, and when they have ended.
///
/// Would catch: an engine that begins or ends a pulse in another step, kernels that differ from their twins in any form of sensing,
/// a long step into another object that only one engine notices, and code for pulses that changes scenes without any.
#[test]
fn both_engines_sweep_alike() {
    let Some(gpu) = gpu() else { return };
    for (strategy, sensing, speed) in [
        (Strategy::Parallel, Sensing::Auto, 0.02),
        (Strategy::Direct, Sensing::Walk, 0.02),
        // Faster than the pulse, which slows nothing.
        (Strategy::None, Sensing::Auto, 0.08),
    ] {
        let change = |s: &mut Settings| {
            s.transfer.strategy = strategy;
            s.physarum.sensing = sensing;
            s.physarum.speed = speed;
        };
        let plain = trio(change);
        let scene = trio(|s| {
            change(s);
            s.pulses = vec![PulseSettings {
                at: [0.3, 0.4, 0.2],
                step: 6,
                speed: 0.06,
                reach: 1.0,
                ..PulseSettings::default()
            }];
        });
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let setup = simulation.setup().clone();
        let mut host = twin::Simulation::new(setup.clone(), scene.settings.clone());
        let mut without = twin::Simulation::new(setup.clone(), plain.settings.clone());
        for step in 0..32 {
            if step == 9 {
                let pulse = pulse_at(setup.center + Vec3::new(0.0, 0.4, 0.0), setup.radius);
                simulation.pulse(&pulse).unwrap();
                host.pulse(&pulse).unwrap();
            }
            let live = simulation.pulses().len();
            gpu.run(|rec| simulation.record_step(rec));
            host.step();
            let state = simulation.snapshot().unwrap();
            state.validate(&setup).unwrap();
            assert_eq!(
                state.hash(),
                host.snapshot().hash(),
                "{strategy:?}, step {step}"
            );
            // Once it is another state it stays one.
            if step < 9 {
                without.step();
                let is_plain = state.hash() == without.snapshot().hash();
                assert_eq!(is_plain, step < 6, "{strategy:?}, step {step}");
            }
            assert_eq!(live > 0, (7..30).contains(&step), "step {step}");
        }
        assert!(simulation.pulses().is_empty() && host.snapshot().pulses.is_empty());
    }
    gpu.finish();
}

/// The mean of headings along the way from a place, over particles at such distances from it that are at places of a kind; and their number.
fn outward(
    state: &Snapshot,
    setup: &Setup,
    center: Vec3,
    distances: std::ops::Range<f32>,
    is_there: impl Fn(u32, Vec3) -> bool,
) -> (f64, usize) {
    let ground = Ground::of(setup, &state.last_poses);
    let (mut sum, mut count) = (0.0, 0);
    for (particle, motion) in state.particles.iter().zip(&state.motions) {
        let flight = ground.flight(particle, motion);
        let away = flight.position - center;
        let object = setup.surface.triangles[particle.triangle as usize].object;
        if distances.contains(&away.length()) && is_there(object, flight.position) {
            sum += f64::from(flight.heading.dot(away.normalize()));
            count += 1;
        }
    }
    (sum / f64::from(count as u32), count)
}

/// A pulse from the top of a cube, each of whose faces is a chart: over the seam, on its sides, and on a ball beside it that touches
/// nothing, particles in the front of the shell are swept along; without the pulse they go anywhere, and ahead of it they still do.
///
/// Would catch: a shell that ends at a seam or at its object, places or directions in the space of one object that are used in another's,
/// and pulses that turn particles inwards.
#[test]
fn pulses_pass_seams_and_reach_other_objects() {
    let of = |has_pulse: bool| {
        let scene = scene_of_several(
            &[
                ("cube?divisions=8", [0.0; 3]),
                ("icosphere?subdivisions=3", [3.0, -0.5, 0.4]),
            ],
            |s| {
                s.particles.count = 20_000;
                s.atlas.size = 256;
                s.radius = 2.0;
                s.objects[0].rotation = [0.0; 3];
                s.objects[1].motion.spin = [0.0, 0.0, 30.0];
                s.pulses = vec![PulseSettings {
                    at: [0.0; 3],
                    speed: 0.04,
                    width: 0.4,
                    reach: 4.0,
                    strength: if has_pulse { 0.8 } else { 0.0 },
                    ..PulseSettings::default()
                }];
            },
        );
        let mut setup = Setup::new(&scene).unwrap();
        // About the middle of the top.
        setup.center = Vec3::new(0.0, 1.0, 0.0);
        let mut simulation = twin::Simulation::new(setup, scene.settings.clone());
        let mut at = Vec::new();
        for step in 1..=40 {
            simulation.step();
            if step == 21 || step == 40 {
                at.push(simulation.snapshot());
            }
        }
        (simulation, at)
    };
    let (simulation, swept) = of(true);
    let (_, free) = of(false);
    let (setup, center) = (simulation.setup(), simulation.setup().center);
    let on_sides = |object: u32, place: Vec3| object == 0 && place.y < 0.95;
    let on_ball = |object: u32, _: Vec3| object == 1;
    let kinds: [&dyn Fn(u32, Vec3) -> bool; 2] = [&on_sides, &on_ball];
    for (i, steps) in [20.0, 39.0].into_iter().enumerate() {
        let front = 0.08 * steps;
        let ways = |states: &[Snapshot], distances: std::ops::Range<f32>| {
            outward(&states[i], setup, center, distances, kinds[i])
        };
        let (with, count) = ways(&swept, front..front + 0.25);
        let (without, _) = ways(&free, front..front + 0.25);
        assert!(count > 100, "{count} particles");
        assert!(
            with > 0.45 && without.abs() < 0.25,
            "{steps}: {with}, {without} without"
        );
        // What the shell has not reached is as it was.
        let (ahead, _) = ways(&swept, front + 0.6..front + 1.0);
        let (ahead_free, _) = ways(&free, front + 0.6..front + 1.0);
        assert!((ahead - ahead_free).abs() < 0.1, "{ahead}, {ahead_free}");
    }
}

fn run_on(gpu: &Gpu, simulation: &mut Simulation, steps: u32) -> u64 {
    advance(gpu, simulation, steps);
    simulation.snapshot().unwrap().hash()
}

/// A checkpoint with a live pulse goes on to the same hash, also in a simulation that had none; without the pulse it does not.
///
/// Would catch: pulses that a checkpoint loses or that begin again, and a resumed simulation without kernels for them.
#[test]
fn a_live_pulse_is_kept() {
    let Some(gpu) = gpu() else { return };
    let scene = trio(|_| ());
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    advance(&gpu, &mut simulation, 4);
    let (center, radius) = (simulation.setup().center, simulation.setup().radius);
    simulation
        .pulse(&pulse_at(center + Vec3::Y, radius))
        .unwrap();
    advance(&gpu, &mut simulation, 5);
    let half = simulation.snapshot().unwrap();
    assert_eq!(half.pulses.len(), 1);
    let whole = run_on(&gpu, &mut simulation, 8);

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("half.ckpt");
    let checkpoint = Checkpoint::new(&scene, simulation.setup(), half);
    checkpoint.write(&path).unwrap();
    let read = Checkpoint::read(&path).unwrap();
    assert_eq!(read.check(&scene, simulation.setup()), Ok(Vec::new()));
    let mut resumed = Simulation::new(&gpu.ctx, &scene).unwrap();
    resumed.restore(&read.snapshot).unwrap();
    assert_eq!(run_on(&gpu, &mut resumed, 8), whole);
    let mut still = read.snapshot.clone();
    still.pulses.clear();
    resumed.restore(&still).unwrap();
    assert_ne!(run_on(&gpu, &mut resumed, 8), whole);
    // Settings that make kernels again keep those of the pulse.
    resumed.restore(&read.snapshot).unwrap();
    let mut settings = resumed.settings().clone();
    settings.physarum.sensor_noise = 0.1;
    resumed.apply(&settings).unwrap();
    assert_ne!(run_on(&gpu, &mut resumed, 2), whole);
    gpu.finish();
}

/// Would catch: a ninth pulse that is lost or writes past the table of shells, and numbers out of their ranges that reach a kernel.
#[test]
fn a_ninth_pulse_replaces_the_oldest_and_impossible_ones_are_refused() {
    let Some(gpu) = gpu() else { return };
    let scene = scene("builtin:cube", |s| s.particles.count = 500);
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let radius = simulation.setup().radius;
    for i in 0..=MOST_PULSES {
        let center = Vec3::new(i as f32, 0.0, 0.0);
        simulation.pulse(&pulse_at(center, radius)).unwrap();
        advance(&gpu, &mut simulation, 1);
    }
    let live: Vec<f32> = (simulation.pulses().iter())
        .map(|pulse| pulse.center[0])
        .collect();
    assert_eq!(live, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
    let good = pulse_at(Vec3::ZERO, radius);
    let before = simulation.pulses().to_vec();
    for (wrong, words) in [
        (
            Pulse {
                center: Vec3::NAN,
                ..good
            },
            "at a finite place",
        ),
        (Pulse { speed: 0.0, ..good }, "a speed of 0 scene radii"),
        (
            Pulse {
                width: -1.0,
                ..good
            },
            "a width of -",
        ),
        (
            Pulse {
                reach: f32::INFINITY,
                ..good
            },
            "a reach of inf",
        ),
        (
            Pulse {
                speed: 2e3 * radius,
                ..good
            },
            "above 0, up to 1000",
        ),
        (
            Pulse {
                strength: 1.5,
                ..good
            },
            "a strength of 1.5: choose 0 to 1",
        ),
    ] {
        let problem = simulation.pulse(&wrong).unwrap_err().to_string();
        assert!(problem.contains(words), "{problem}");
    }
    assert_eq!(simulation.pulses(), before);
    gpu.finish();
}
