//! How much a step asks of the host: one submit, and as few commands as its kernels need, whatever the step. And what is
//! done beside it, by other threads or without waiting, has the same result.

use crate::common::{Gpu, gpu, set_up};
use myxo::gpu::{Commands, Frames};
use myxo::mesh::atlas::Control;
use myxo::scene::settings::{FoodSettings, Settings};
use myxo::scene::{Overrides, Scene};
use myxo::sim::paint::{Brush, Dab};
use myxo::sim::{Setup, Simulation};

/// What each of some steps records, after as many submits.
fn steps(gpu: &Gpu, scene: &Scene, setup: Setup, count: u64) -> (usize, Vec<Commands>) {
    let mut simulation = Simulation::from_setup(&gpu.ctx, scene, setup).unwrap();
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
    (simulation.setup().poses.len(), commands)
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
    let Some(gpu) = gpu() else { return };
    let scene = load("torus", &["particles.count=2000", "atlas.size=256"]);
    let (objects, commands) = steps(&gpu, &scene, set_up(&gpu.ctx, &scene), 34);
    gpu.finish();
    let usual = Commands {
        kernels: 5,
        draws: 0,
        copies: 2,
        barriers: 7,
    };
    // Particles are sorted in some of them.
    let sorted = Commands {
        kernels: 9,
        draws: 0,
        copies: 2,
        barriers: 8,
    };
    assert_eq!(objects, 1);
    assert_eq!(commands[5], usual);
    let most = most(&commands);
    assert_eq!(most, sorted, "of a step with four kernels more");
    // The first step waits for nothing that came before.
    let is_either = |step: &Commands| {
        let like = if step.kernels == 5 { usual } else { sorted };
        step.barriers <= like.barriers
            && *step
                == Commands {
                    barriers: step.barriers,
                    ..like
                }
    };
    assert!(commands.iter().all(is_either), "{commands:?}");
}

#[test]
fn a_step_of_many_objects_is_one_submit_too() {
    let Some(gpu) = gpu() else { return };
    let set = ["particles.count=5000", "atlas.size=192"];
    let scene = load("crowd", &set);
    let setup = set_up(&gpu.ctx, &scene);
    let (objects, commands) = steps(&gpu, &scene, setup, 6);
    assert_eq!(objects, 64);
    // As many as with two objects: all take their step together.
    let bounds = |most: Commands, kernels_to_sort: u32| {
        assert!(most.kernels <= 24 + kernels_to_sort, "{most:?}");
        assert!(most.copies <= 9, "{most:?}");
        assert!(most.barriers <= 26, "{most:?}");
        assert_eq!(most.draws, 0);
    };
    // After the first of these steps particles are sorted.
    bounds(commands[0], 4);
    bounds(most(&commands[1..]), 0);
    gpu.finish();
}

fn load(scene: &str, set: &[&str]) -> Scene {
    let overrides = Overrides {
        set: set.iter().map(|text| (*text).to_owned()).collect(),
        ..Overrides::default()
    };
    Scene::load(scene.as_ref(), &overrides).unwrap()
}

fn grow(simulation: &mut Simulation, frames: &mut Frames, steps: u32) {
    for _ in 0..steps {
        let mut rec = frames.begin().unwrap();
        simulation.record_step(&mut rec);
        frames.submit(rec).unwrap();
    }
    frames.wait_idle().unwrap();
}

/// A food with room for many.
fn food(at: [f32; 3], amount: u32) -> FoodSettings {
    FoodSettings {
        at: at.map(f64::from),
        amount,
        size: 0.3,
        ..FoodSettings::default()
    }
}

/// While it is measured everything continues; when it is served, it is as if it had been measured then.
#[test]
fn food_that_is_measured_aside_is_the_same_food() {
    let Some(gpu) = gpu() else { return };
    let scene = load("torus", &["particles.count=3000", "atlas.size=128"]);
    let setup = set_up(&gpu.ctx, &scene);
    let mut frames = Frames::new(&gpu.ctx, 2).unwrap();
    let scale = scene.settings.objects[0].scale;
    let corners = |i: usize| (scene.surface.positions[i] / scale).to_array();
    let places = [corners(0), corners(700), corners(1500)];
    let with = |foods: &[(usize, u32)]| Settings {
        foods: (foods.iter())
            .map(|&(place, amount)| food(places[place], amount))
            .collect(),
        ..scene.settings.clone()
    };
    let changes = [
        with(&[(0, 900)]),
        with(&[(0, 900), (1, 0)]),
        with(&[(1, 0), (2, 400), (0, 900)]),
        with(&[(2, 400)]),
        with(&[]),
    ];
    let grown = [false, true].map(|aside| {
        let mut simulation = Simulation::from_setup(&gpu.ctx, &scene, setup.clone()).unwrap();
        let mut states = Vec::new();
        for settings in &changes {
            let food = aside.then(|| {
                let order = simulation.order_food(settings).expect("it is other food");
                std::thread::spawn(move || order.prepare(&Control::default()))
            });
            grow(&mut simulation, &mut frames, 4);
            match food {
                Some(food) => {
                    let food = food.join().unwrap().unwrap();
                    assert!(food.is_of(settings));
                    simulation.apply_with_food(settings, food).unwrap();
                }
                None => simulation.apply(settings).unwrap(),
            }
            assert!(simulation.order_food(settings).is_none(), "it is there");
            grow(&mut simulation, &mut frames, 4);
            let state = simulation.snapshot().unwrap();
            state.validate(simulation.setup()).unwrap();
            states.push(state);
        }
        states
    });
    let left: Vec<&[u32]> = grown[0].iter().map(|s| &s.food.remaining[..]).collect();
    assert!(left[0][0] < 900 && left[2][2] < left[1][0], "{left:?}");
    for (plain, aside) in grown[0].iter().zip(&grown[1]) {
        assert_eq!(plain.food, aside.food);
        assert_eq!(plain.hash(), aside.hash(), "{left:?}");
    }

    // An order that something else has overtaken, and one that cannot be.
    let mut simulation = Simulation::from_setup(&gpu.ctx, &scene, setup).unwrap();
    simulation.apply(&changes[0]).unwrap();
    let mut same_places = changes[0].clone();
    same_places.feeding.fed_deposit += 1;
    let overtaken = simulation.order_food(&same_places).unwrap();
    let overtaken = overtaken.prepare(&Control::default()).unwrap();
    simulation.apply(&changes[3]).unwrap();
    simulation.apply_with_food(&same_places, overtaken).unwrap();
    assert_eq!(simulation.remaining().unwrap(), [900]);
    assert_eq!(simulation.food_places().len(), 1);
    let mut off = changes[0].clone();
    off.foods.push(food([0.0, 50.0, 0.0], 1));
    let order = simulation.order_food(&off).unwrap();
    let problem = order
        .prepare(&Control::default())
        .map(|_| ())
        .unwrap_err()
        .to_string();
    assert!(problem.contains("food.1.at is "), "{problem}");
    assert_eq!(simulation.settings().foods, changes[0].foods);
    drop((simulation, frames));
    gpu.finish();
}

/// What is copied in a frame, with a step after it, is the state before that step.
#[test]
fn a_state_is_copied_without_waiting() {
    let Some(gpu) = gpu() else { return };
    let mut frames = Frames::new(&gpu.ctx, 2).unwrap();
    let small = ["particles.count=4000", "atlas.size=192"];
    for (scene, more) in [
        ("torus", &["feeding.scattered=2", "feeding.amount=500"][..]),
        ("trio", &["transfer.threshold=0.01"]),
        ("trio", &["transfer.strategy=direct"]),
        ("cube", &[]),
    ] {
        let scene = load(scene, &[&small[..], more].concat());
        let setup = set_up(&gpu.ctx, &scene);
        let mut simulation = Simulation::from_setup(&gpu.ctx, &scene, setup).unwrap();
        for round in 0..3 {
            if round == 1 {
                let mut rec = frames.begin().unwrap();
                let dab = Dab {
                    brush: Brush::Attract { amount: 3.0 },
                    center: scene.surface.positions[0],
                    radius: 0.3 * scene.radius,
                    eye: None,
                    ring: None,
                    number: 0,
                };
                simulation.paint(&mut rec, &dab).unwrap();
                frames.submit(rec).unwrap();
                frames.wait_idle().unwrap();
            }
            let state = simulation.snapshot().unwrap();
            let distances = simulation.distances().unwrap();
            let submits = gpu.ctx.submits();
            let mut rec = frames.begin().unwrap();
            let mut copy = simulation.record_snapshot(&mut rec).unwrap();
            simulation.record_step(&mut rec);
            assert!(!copy.is_there(), "the frame has not begun");
            frames.submit(rec).unwrap();
            assert_eq!(gpu.ctx.submits() - submits, 1, "nothing waits");
            frames.wait_idle().unwrap();
            assert!(copy.is_there());
            let (copied, copied_distances) = copy.take();
            assert!(copied == state && copied_distances == distances);
            grow(&mut simulation, &mut frames, 5);
        }
    }
    drop(frames);
    gpu.finish();
}
