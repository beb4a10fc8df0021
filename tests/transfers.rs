//! Particles change objects: the same by every strategy that keeps the order of turns, nobody lost, whatever happens.

mod common;

use common::{Gpu, gpu};
use myxo::gpu::Frames;
use myxo::scene::Scene;
use myxo::scene::settings::{ObjectSettings, Settings, Strategy};
use myxo::sim::checkpoint::Checkpoint;
use myxo::sim::{Simulation, Snapshot, twin};

/// Objects that stand in one another.
fn scene_of(meshes: &[(&str, [f32; 3])], change: impl FnOnce(&mut Settings)) -> Scene {
    let mut settings = Settings::default();
    settings.particles.count = 3000;
    settings.atlas.size = 256;
    settings.physarum.speed = 0.02;
    settings.objects = meshes
        .iter()
        .map(|&(mesh, position)| ObjectSettings {
            mesh: format!("builtin:{mesh}"),
            position,
            rotation: [10.0, 20.0, 30.0],
            ..ObjectSettings::default()
        })
        .collect();
    change(&mut settings);
    Scene::from_settings("test".to_owned(), settings, ".".into()).unwrap()
}

/// Three that touch one another.
fn trio(change: impl FnOnce(&mut Settings)) -> Scene {
    let meshes = [
        ("torus?major=24&minor=16", [0.0; 3]),
        ("cube", [0.9, 0.1, 0.0]),
        ("icosphere?subdivisions=2", [0.2, 1.0, 0.3]),
    ];
    scene_of(&meshes, change)
}

fn with(strategy: Strategy) -> impl FnOnce(&mut Settings) {
    move |settings| settings.transfer.strategy = strategy
}

fn advance(gpu: &Gpu, simulation: &mut Simulation, steps: u32) {
    let mut frames = Frames::new(&gpu.ctx, 2).unwrap();
    for _ in 0..steps {
        let mut rec = frames.begin().unwrap();
        simulation.record_step(&mut rec);
        frames.submit(rec).unwrap();
    }
    frames.wait_idle().unwrap();
}

/// Runs and checks every few steps.
fn run(gpu: &Gpu, scene: &Scene, steps: u32) -> Snapshot {
    let mut simulation = Simulation::new(&gpu.ctx, scene).unwrap();
    for _ in 0..steps / 5 {
        advance(gpu, &mut simulation, 5);
        let state = simulation.snapshot().unwrap();
        state.validate(simulation.setup()).unwrap();
    }
    simulation.snapshot().unwrap()
}

const IN_TURNS: [Strategy; 3] = [
    Strategy::Scattered,
    Strategy::Sequential,
    Strategy::Parallel,
];

#[test]
fn strategies_with_turns_give_the_same_bits() {
    let Some(gpu) = gpu() else { return };
    let ends = IN_TURNS.map(|strategy| run(&gpu, &trio(with(strategy)), 60));
    let [scattered, sequential, parallel] = &ends;
    assert_eq!(sequential.hash(), scattered.hash());
    assert_eq!(parallel.hash(), scattered.hash());
    let flow = parallel.transfers.flow;
    assert!(
        flow.arrived > 1000 && flow.refused == 0 && flow.mismatches == 0,
        "{flow:?}"
    );
    // Who left has arrived or is under way, and was counted by where from and where to.
    assert_eq!(
        flow.selected as usize,
        flow.arrived as usize + parallel.transfers.in_flight.len()
    );
    for end in &ends {
        assert_eq!(end.transfers.flux, parallel.transfers.flux);
        assert_eq!(end.transfers.flux.iter().sum::<u32>(), flow.selected);
    }
    assert!(
        parallel.transfers.flux.iter().filter(|&&n| n > 50).count() >= 4,
        "{:?}",
        parallel.transfers.flux
    );
    gpu.finish();
}

#[test]
fn every_strategy_gives_the_same_bits_twice() {
    let Some(gpu) = gpu() else { return };
    let mut hashes = Vec::new();
    for &strategy in Strategy::ALL {
        let scene = trio(with(strategy));
        let first = run(&gpu, &scene, 40);
        assert_eq!(run(&gpu, &scene, 40).hash(), first.hash(), "{strategy:?}");
        hashes.push(first.hash());
        let changes = first.transfers.flow.arrived;
        assert_eq!(
            changes > 0,
            strategy != Strategy::None,
            "{strategy:?}: {changes}"
        );
    }
    hashes.sort_unstable();
    hashes.dedup();
    assert_eq!(hashes.len(), 4, "none, respawn, those with turns, direct");
    gpu.finish();
}
