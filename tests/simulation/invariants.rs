//! Negative control of the checks that follow every step: a state in which one thing is wrong is refused with words
//! that say what and where, by [`Snapshot::validate`] and by the program.

use crate::common::gpu;
use myxo::gpu::Frames;
use myxo::scene::{Overrides, Scene};
use myxo::sim::checkpoint::Checkpoint;

use crate::program::{Folder, done, failed, path};
use glam::Vec3;
use myxo::sim::types::{Motion, Particle, Transfer, Window};
use myxo::sim::{Setup, Simulation, Snapshot};

const SCENE: &str = r#"
[particles]
count = 900
[physarum]
speed = 0.02
[atlas]
size = 128
[transfer]
strategy = "parallel"
[[object]]
name = "ring"
mesh = "builtin:torus?major=24&minor=16"
[[object]]
name = "box"
mesh = "builtin:cube"
position = [0.9, 0.1, 0.0]
rotation = [10.0, 20.0, 30.0]
"#;

/// What is done to a state in order, and what is said about it.
type Damage = (fn(&mut Snapshot), &'static str);

/// A slot whose particle is not in flight, and another one.
fn stayers(state: &Snapshot) -> [usize; 2] {
    let mut slots = (0..state.particles.len()).filter(|&s| !state.motions[s].is_selected());
    [slots.next().unwrap(), slots.next_back().unwrap()]
}

fn first_stayer(state: &mut Snapshot) -> &mut Particle {
    let [slot, _] = stayers(state);
    &mut state.particles[slot]
}

const DAMAGES: &[Damage] = &[
    // Particles counted, ids a permutation.
    (
        |s| {
            s.particles.pop();
        },
        "there are 899 particles, not 900",
    ),
    (
        |s| s.particles[7].id = s.particles[8].id,
        "1 particles are lost and 1 doubled",
    ),
    // Places and headings.
    (|s| first_stayer(s).u = -0.01, "is outside its triangle"),
    (|s| first_stayer(s).v = f32::NAN, "v = NaN"),
    (
        |s| (first_stayer(s).u, first_stayer(s).v) = (0.6, 0.5),
        "u = 0.6, v = 0.5",
    ),
    (
        |s| first_stayer(s).triangle = 1_000_000,
        "is on triangle 1000000, which does not exist",
    ),
    (
        |s| s.motions[5].heading_p += 1.0,
        "the heading of particle ",
    ),
    (|s| s.motions[5].pending = -1.0, "has -1 pending"),
    (|s| s.motions[5].pending = f32::NAN, "has NaN pending"),
    (|s| s.motions[5].heading_h = f32::NAN, "has length NaN"),
    (|s| s.trail[5] = f32::NAN, "the trail is NaN at texel 5"),
    // As many deposits as particles.
    (
        |s| *s.deposits.iter_mut().find(|n| **n > 0).unwrap() -= 1,
        "899 deposits on owned and gutter texels in the last step, not 900",
    ),
    // Windows are disjoint and complete, and hold their object's particles.
    (
        |s| s.transfers.windows[1].count -= 1,
        "the windows have 899 slots of 900",
    ),
    (
        |s| s.transfers.windows[1].start = (s.transfers.windows[1].start + 1) % 900,
        "the window of object 1 has",
    ),
    (
        |s| s.transfers.windows[0].count += 1,
        "of object 1 lies in the window of object 0",
    ),
    (
        |s| {
            s.transfers.windows.pop();
        },
        "1 windows for 2 objects",
    ),
    (
        |s| {
            let [from, to] = [0, 1].map(|object: usize| {
                let Window { start, count } = s.transfers.windows[object];
                Window::slot(start, count - 1, 900) as usize
            });
            s.particles.swap(from, to);
        },
        "lies in the window of object",
    ),
    // Checkpoints of earlier versions have particles in flight, with a transfer each.
    (
        |s| {
            let [slot, _] = stayers(s);
            s.motions[slot].flags |= 1;
        },
        "is in flight and has no transfer",
    ),
    (
        |s| s.transfers.in_flight[0].particle = stayers(s)[1] as u32,
        " transfer",
    ),
    (
        |s| s.transfers.in_flight[0].particle = 900,
        "a transfer of slot 900",
    ),
    (
        |s| s.transfers.in_flight[0].target ^= 1,
        "a transfer of slot",
    ),
    (
        |s| s.transfers.in_flight[0].source = 17,
        "has a transfer from object 17",
    ),
    (
        |s| s.transfers.in_flight[0].heading *= 2.0,
        "is in flight at",
    ),
    (
        |s| s.transfers.in_flight[0].position.y = f32::INFINITY,
        "is in flight at",
    ),
    (
        |s| {
            let twice = s.transfers.in_flight[0];
            s.transfers.in_flight.push(twice);
            s.transfers.flow.selected += 1;
        },
        "two transfers of slot",
    ),
    // Selected particles are counted.
    (
        |s| s.transfers.flow.arrived -= 1,
        "times a particle was selected, and 0 were refused",
    ),
    (|s| s.trail[99] = -1.0, "the trail is -1 at texel 99"),
    // Lists are as long as the scene makes them, and counts in their ranges: a checkpoint may come from anywhere.
    (|s| s.trail.truncate(7), "there are 7 texels of trail, not"),
    (|s| s.deposits.push(0), "texels of deposits, not"),
    (|s| s.bias = vec![0.0; 3], "there are 3 texels of bias, not"),
    (
        |s| s.transfers.flux.push(0),
        "there are 5 counts of flux, not 4",
    ),
    (|s| s.trail[5] = 3e38, "the trail is 3"),
    (|s| s.step = 1 << 60, "is the last"),
    (
        |s| s.transfers.flow.mismatches = 1,
        "were not equally many on both sides, 1 times",
    ),
];

/// The state after 15 steps.
fn state(scene: &Scene) -> Option<(Setup, Snapshot)> {
    let gpu = gpu()?;
    let mut simulation = Simulation::new(&gpu.ctx, scene).unwrap();
    let mut frames = Frames::new(&gpu.ctx, 2).unwrap();
    for _ in 0..15 {
        let mut rec = frames.begin().unwrap();
        simulation.record_step(&mut rec);
        frames.submit(rec).unwrap();
    }
    frames.wait_idle().unwrap();
    let state = simulation.snapshot().unwrap();
    let setup = simulation.setup().clone();
    drop((simulation, frames));
    gpu.finish();
    Some((setup, state))
}

/// The state as a version with particles in flight would have written it, with the first particle of the ring in flight.
fn with_a_flight(mut state: Snapshot, setup: &Setup) -> Snapshot {
    let slot = state.transfers.windows[0].start;
    let (triangle, _) = setup.surface.objects[1].triangles;
    state.motions[slot as usize].flags |= Motion::SELECTED;
    state.transfers.flow.selected += 1;
    state.transfers.in_flight = vec![Transfer {
        particle: slot,
        target: 1,
        triangle,
        heading: Vec3::X,
        normal: Vec3::Y,
        ..Transfer::default()
    }];
    state
}

#[test]
fn whatever_is_wrong_with_a_state_is_named() {
    let folder = Folder::new();
    let file = folder.with("two.toml", SCENE);
    let scene = Scene::load(&file, &Overrides::default()).unwrap();
    let Some((setup, state)) = state(&scene) else {
        return;
    };
    assert!(state.transfers.in_flight.is_empty());
    state.validate(&setup).unwrap();
    let state = with_a_flight(state, &setup);
    state.validate(&setup).unwrap();
    // Counters stop at the largest number.
    let mut late = state.clone();
    late.transfers.flow.selected = u32::MAX;
    late.transfers.flow.arrived = u32::MAX - 7;
    late.validate(&setup).unwrap();
    for (damage, expected) in DAMAGES {
        let mut damaged = state.clone();
        damage(&mut damaged);
        let problem = damaged.validate(&setup).expect_err(expected);
        assert!(problem.contains(expected), "{expected} in {problem}");
    }
}

/// Would catch: a library that takes a damaged state, so that kernels read and write out of bounds, and a simulation that has changed when
/// it refuses one.
#[test]
fn a_simulation_takes_no_damaged_state_and_stays_as_it_is() {
    let folder = Folder::new();
    let file = folder.with("two.toml", SCENE);
    let scene = Scene::load(&file, &Overrides::default()).unwrap();
    let (Some((setup, state)), Some(gpu)) = (state(&scene), gpu()) else {
        return;
    };
    let mut simulation = Simulation::from_setup(&gpu.ctx, &scene, setup.clone()).unwrap();
    simulation.restore(&state).unwrap();
    let whole = with_a_flight(state.clone(), &setup);
    let of_ranges: [fn(&mut Snapshot); 6] = [
        |s| s.bias = vec![f32::INFINITY; s.trail.len()],
        |s| s.looks = vec![2.0; s.trail.len()],
        |s| s.motions[5].pending = 1e30,
        |s| s.last_poses.clear(),
        |s| s.food.remaining.push(1),
        |s| s.step = 1 << 63,
    ];
    let all = DAMAGES.iter().map(|(damage, _)| damage).chain(&of_ranges);
    for (number, damage) in all.enumerate() {
        let mut damaged = whole.clone();
        damage(&mut damaged);
        let problem = simulation.restore(&damaged).expect_err("it is damaged");
        assert!(!problem.to_string().is_empty(), "{number}");
    }
    assert_eq!(simulation.snapshot().unwrap().hash(), state.hash());
    assert_eq!(simulation.areas().unwrap(), [0.0; 0]);
    assert_eq!(simulation.looks().unwrap(), [0.0; 0]);
    gpu.run(|rec| simulation.record_step(rec));
    let next = simulation.snapshot().unwrap();
    next.validate(&setup).unwrap();
    assert_eq!(next.step, state.step + 1);
    drop(simulation);
    gpu.finish();
}

/// One damage that any scene may have and one of transfers; the others are named alike, see above.
#[test]
fn the_program_does_not_go_on_from_a_damaged_state() {
    let folder = Folder::new();
    let file = folder.with("two.toml", SCENE);
    let scene = Scene::load(&file, &Overrides::default()).unwrap();
    let Some((setup, state)) = state(&scene) else {
        return;
    };
    let saved = folder.file("saved.state");
    let resume = |state: &Snapshot| {
        let checkpoint = Checkpoint::new(&scene, &setup, state.clone());
        checkpoint.write(&saved).unwrap();
        let command = [
            "profile",
            path(&file),
            "--validate",
            "--resume",
            path(&saved),
        ];
        let short = ["--steps", "3", "--warmup", "0", "--json"];
        [&command[..], &short[..]].concat()
    };
    done(&resume(&state));
    for (damage, expected) in [DAMAGES[2], DAMAGES[13]] {
        let mut damaged = state.clone();
        damage(&mut damaged);
        let message = failed(&resume(&damaged));
        assert!(message.contains("cannot resume from "), "{message}");
        assert!(message.contains(expected), "{expected} in {message}");
    }
}
