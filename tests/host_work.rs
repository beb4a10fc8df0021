//! How much a step asks of the host: one submit, and as few commands as its kernels need, whatever the step.

mod common;

use common::gpu;
use myxo::gpu::{Commands, Frames};
use myxo::scene::{Overrides, Scene};
use myxo::sim::Simulation;

/// What each of some steps records, after as many submits.
fn steps(scene: &str, set: &[&str], count: u64) -> Option<(usize, Vec<Commands>)> {
    let gpu = gpu()?;
    let overrides = Overrides {
        set: set.iter().map(|text| (*text).to_owned()).collect(),
        ..Overrides::default()
    };
    let scene = Scene::load(scene.as_ref(), &overrides).unwrap();
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let mut frames = Frames::new(&gpu.ctx, 2).unwrap();
    let submits = gpu.ctx.submits();
    let mut commands = Vec::new();
    for _ in 0..count {
        let mut rec = frames.begin().unwrap();
        simulation.record_step(&mut rec);
        commands.push(rec.commands());
        frames.submit(rec).unwrap();
    }
    frames.wait_idle().unwrap();
    assert_eq!(gpu.ctx.submits() - submits, count, "a step is one submit");
    let objects = simulation.setup().poses.len();
    drop(frames);
    drop(simulation);
    gpu.finish();
    Some((objects, commands))
}

/// The most of each kind in a step.
fn most(commands: &[Commands]) -> Commands {
    commands
        .iter()
        .fold(Commands::default(), |most, step| Commands {
            kernels: most.kernels.max(step.kernels),
            draws: most.draws.max(step.draws),
            copies: most.copies.max(step.copies),
            barriers: most.barriers.max(step.barriers),
        })
}

#[test]
fn a_step_of_one_object_is_one_submit_of_few_commands() {
    let set = ["particles.count=2000", "atlas.size=256"];
    let Some((objects, commands)) = steps("torus", &set, 34) else {
        return;
    };
    let usual = Commands {
        kernels: 5,
        draws: 0,
        copies: 2,
        barriers: 11,
    };
    // Particles are sorted in one of them.
    let sorted = Commands {
        kernels: 8,
        draws: 0,
        copies: 3,
        barriers: 16,
    };
    assert_eq!(objects, 1);
    assert_eq!(commands[5], usual);
    let most = most(&commands);
    assert_eq!(most, sorted, "of a step with three kernels more");
    assert!(
        commands
            .iter()
            .all(|step| *step == usual || *step == sorted)
    );
}

#[test]
fn a_step_of_many_objects_is_one_submit_too() {
    let set = ["particles.count=5000", "atlas.size=512"];
    let Some((objects, commands)) = steps("crowd", &set, 6) else {
        return;
    };
    assert_eq!(objects, 64);
    // Nine kernels a turn, and what all objects have together.
    let most = most(&commands);
    let objects = objects as u32;
    assert!(most.kernels <= 9 * objects + 7, "{most:?}");
    assert!(most.copies <= 2 * objects + 7, "{most:?}");
    assert!(most.barriers <= 17 * objects + 22, "{most:?}");
    assert_eq!(most.draws, 0);
    // The strategy that advances all objects together needs no turns.
    let set = [&set[..], &["transfer.strategy=direct"]].concat();
    let Some((_, direct)) = steps("crowd", &set, 6) else {
        return;
    };
    let direct = direct.iter().map(|step| step.kernels).max();
    assert!(direct <= Some(24), "{direct:?}");
}
