//! The rules of Jones (2010): one particle a cell on every surface, over seams and from object to object, on both engines; and each rule for itself.

use std::collections::{HashMap, HashSet};

use crate::advance;
use crate::common::{Gpu, TRIO, by_id, gpu, gpu_by_card_forms, scene, scene_of_several, set_up};
use crate::networks::mean;
use myxo::rng::{Purpose, random};
use myxo::scene::Scene;
use myxo::scene::settings::{
    FoodSettings, Heading, Model, ObjectStart, Preference, PulseSettings, Sensing, Settings, Start,
    StepOrder, Strategy, Turning,
};
use myxo::sim::beside::first_difference;
use myxo::sim::carry::carried;
use myxo::sim::cells::{cell_of, homes, sharing_count};
use myxo::sim::checkpoint::Checkpoint;
use myxo::sim::field::{atlas_position, texel_at};
use myxo::sim::paint::{Brush, Dab};
use myxo::sim::plan::{Means, Plan};
use myxo::sim::step::advance::Form;
use myxo::sim::{Setup, Simulation, Snapshot, twin};

const TORUS: &str = "builtin:torus?major=24&minor=16";

fn jones(settings: &mut Settings) {
    settings.physarum.model = Model::Jones;
    settings.physarum.rotation_angle = 45.0;
    settings.physarum.sensor_angle = 45.0;
    settings.physarum.deposit = 5.0;
    settings.physarum.speed = 0.02;
    settings.physarum.sensor_offset = 0.15;
    settings.trail.diffusion = 1.0;
    settings.trail.decay = 0.9;
    settings.particles.count = 1500;
    settings.atlas.size = 96;
}

fn crowded(mesh: &str, change: impl FnOnce(&mut Settings)) -> Scene {
    scene(mesh, |settings| {
        jones(settings);
        change(settings);
    })
}

/// Three objects that touch one another, of which particles take a third of the cells.
fn trio(change: impl FnOnce(&mut Settings)) -> Scene {
    scene_of_several(&TRIO, |settings| {
        jones(settings);
        settings.atlas.size = 128;
        change(settings);
    })
}

/// Particles that share a cell with an earlier one.
fn sharing(state: &Snapshot, setup: &Setup) -> usize {
    sharing_count(&state.particles, &setup.atlas, &homes(&setup.atlas))
}

/// Runs by the twins.
fn by_twins(scene: &Scene, steps: u32) -> Snapshot {
    let mut twin = twin::Simulation::new(Setup::new(scene).unwrap(), scene.settings.clone());
    for _ in 0..steps {
        twin.step();
    }
    twin.snapshot()
}

/// Would catch: two that win one cell, a cell that is left before another one may claim it, a seam behind which the cell is another one, and
/// a landing on a taken cell.
#[test]
fn no_two_particles_are_ever_in_one_cell() {
    let Some(gpu) = gpu() else { return };
    let dense = |settings: &mut Settings| settings.particles.count = 2500;
    for (what, scene, transfers) in [
        ("torus", crowded(TORUS, dense), false),
        (
            "plane",
            crowded("builtin:plane?columns=8&rows=8", dense),
            false,
        ),
        ("trio", trio(dense), true),
    ] {
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let mut stayed = 0;
        for step in 0..=200 {
            let state = simulation.snapshot().unwrap();
            let setup = simulation.setup();
            assert_eq!(sharing(&state, setup), 0, "{what}, step {step}");
            if step % 20 == 1 {
                state.validate(setup).unwrap();
                stayed += state.stayed_count();
            }
            advance(&gpu, &mut simulation, 1);
        }
        assert!(stayed > 500, "{what}: {stayed}");
        let flow = simulation.snapshot().unwrap().transfers.flow;
        assert_eq!(flow.arrived > 200, transfers, "{what}: {flow:?}");
        assert_eq!(
            flow.left_over > 0,
            scene.settings.physarum.rules().rounds < 9
        );
        let flux = simulation.snapshot().unwrap().transfers.flux;
        let returned: u32 = flux.iter().step_by(4).sum();
        assert_eq!(
            returned > 20,
            transfers,
            "some land on taken cells: {flux:?}"
        );
        let counted: u32 = flux.iter().sum();
        assert_eq!(counted, flow.arrived, "each counts once, where it ended");
        // Those that were sent back have crossed nothing.
        let changed = counted - returned;
        assert!(flow.crossed <= changed, "of {changed}: {flow:?}");
        assert_eq!(flow.crossed > 0, transfers, "{what}: {flow:?}");
    }
    // Without the rule they share cells.
    let shared = by_twins(&crowded(TORUS, |s| s.physarum.model = Model::Thesis), 1);
    let setup = Setup::new(&crowded(TORUS, |_| ())).unwrap();
    assert!(sharing(&shared, &setup) > 100);
    gpu.finish();
}

/// Compares both engines after each kernel.
fn compare(gpu: &Gpu, what: &str, scene: &Scene, dabs: &[Dab]) {
    let setup = set_up(&gpu.ctx, scene);
    let found = first_difference(&gpu.ctx, scene, &setup, 5, 3, dabs)
        .unwrap_or_else(|error| panic!("{what}: {error}"));
    assert!(found.is_none(), "{what}: {}", found.unwrap());
}

/// Rule by rule from one model to the other, and the other model with everything else that a step can have.
#[test]
fn each_rule_has_the_same_bits_on_both_engines() {
    type Change = fn(&mut Settings);
    let thesis = |settings: &mut Settings| settings.physarum.model = Model::Thesis;
    let rules: [(&str, Change); 8] = [
        ("move_first", |s| s.physarum.order = StepOrder::MoveFirst),
        ("one round", |s| s.physarum.occupancy_rounds = 1),
        ("fourteen rounds", |s| s.physarum.occupancy_rounds = 14),
        ("random ties", |s| s.physarum.turning = Turning::Random),
        ("random turns", |s| s.physarum.random_turn = 0.2),
        ("sensitivity", |s| s.physarum.sensitivity = 3.0),
        ("cells", |s| s.physarum.sensor_width = 1),
        ("wide sensors", |s| s.physarum.sensor_width = 5),
    ];
    let more: [(&str, Change); 7] = [
        ("jones", |_| ()),
        ("sense_first", |s| s.physarum.order = StepOrder::SenseFirst),
        ("walking", |s| s.physarum.sensing = Sensing::Walk),
        ("noise", |s| {
            s.physarum.sensor_noise = 1.0;
            s.physarum.gravity_weight = 3.0;
        }),
        ("few attempts", |s| s.physarum.edge_crossing_attempts = 1),
        ("food", |s| {
            let plate = FoodSettings {
                amount: 40,
                size: 0.3,
                ..FoodSettings::default()
            };
            s.foods = vec![plate];
            s.feeding.fed_steps = 3;
            s.feeding.fed_deposit = 4;
        }),
        ("pulse", |s| s.pulses = vec![PulseSettings::default()]),
    ];
    for (k, gpu) in [gpu(), gpu_by_card_forms()].into_iter().enumerate() {
        let Some(gpu) = gpu else { continue };
        // The forms for graphics cards have the same text but for lists and tables.
        let (rules, more) = match k {
            0 => (&rules[..], &more[..]),
            _ => (&rules[1..2], &more[..1]),
        };
        for &(what, change) in rules {
            let scene = crowded(TORUS, |settings| {
                thesis(settings);
                change(settings);
            });
            compare(&gpu, what, &scene, &[]);
        }
        for &(what, change) in more {
            compare(&gpu, what, &crowded(TORUS, change), &[]);
        }
        for strategy in [
            Strategy::None,
            Strategy::Scattered,
            Strategy::Sequential,
            Strategy::Parallel,
        ] {
            let scene = trio(|settings| settings.transfer.strategy = strategy);
            compare(&gpu, strategy.word(), &scene, &[]);
        }
        let full = trio(|settings| settings.transfer.buffer_size = 8);
        compare(&gpu, "few transfers", &full, &[]);
        // Many land where a particle would leave its cell in one more round.
        let crowd = trio(|settings| {
            settings.particles.count = 5000;
            settings.physarum.occupancy_rounds = 1;
        });
        compare(&gpu, "one round for a crowd", &crowd, &[]);
        compare(
            &gpu,
            "painted",
            &trio(|_| ()),
            &[dab(Brush::NoGo), dab(Brush::Particles { share: 0.3 })],
        );
        gpu.finish();
    }
}

fn dab(brush: Brush) -> Dab {
    Dab {
        brush,
        center: [0.9, 0.1, 0.5].into(),
        radius: 0.3,
        eye: None,
        ring: None,
        number: 3,
    }
}

/// Would catch: an order that changes more than the first step, or that does not keep particles from turning in it.
#[test]
fn the_order_of_the_stages_is_that_of_the_first_step() {
    let run = |(order, rounds): (StepOrder, u32), gravity: f32, steps: u32| {
        let scene = crowded(TORUS, |settings| {
            settings.physarum.model = Model::Thesis;
            settings.physarum.order = order;
            settings.physarum.occupancy_rounds = rounds;
            settings.physarum.gravity_weight = gravity;
            settings.physarum.random_turn = if gravity > 0.0 { 0.5 } else { 0.0 };
        });
        by_twins(&scene, steps)
    };
    for rounds in [0, 3] {
        let [senses, moves] =
            [StepOrder::SenseFirst, StepOrder::MoveFirst].map(|order| (order, rounds));
        // From an empty trail, what is sensed first is nothing.
        assert_eq!(run(senses, 0.0, 30).hash(), run(moves, 0.0, 30).hash());
        // What pulls in the first step does so only if particles sense in it.
        let free = run(senses, 0.0, 1).hash();
        assert_eq!(run(moves, 3.0, 1).hash(), free);
        assert_ne!(run(senses, 3.0, 1).hash(), free);
        assert_ne!(run(moves, 3.0, 2).hash(), run(moves, 0.0, 2).hash());
    }
}

/// Would catch: an outcome that depends on which particle comes first in the buffer.
#[test]
fn the_order_of_the_buffer_does_not_show() {
    let Some(gpu) = gpu() else { return };
    let scene = crowded(TORUS, |settings| settings.particles.count = 2500);
    let before = by_twins(&scene, 3);
    let mut other = before.clone();
    other.particles.reverse();
    other.motions.reverse();
    other.particles.rotate_left(777);
    other.motions.rotate_left(777);
    assert_eq!(other.hash(), before.hash());
    let ends = [&before, &other].map(|state| {
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        simulation.restore(state).unwrap();
        advance(&gpu, &mut simulation, 20);
        let mut twin = twin::Simulation::new(simulation.setup().clone(), scene.settings.clone());
        twin.restore(state);
        for _ in 0..20 {
            twin.step();
        }
        let end = simulation.snapshot().unwrap();
        assert!(end.stayed_count() > 100);
        assert_eq!(twin.snapshot().hash(), end.hash());
        end.hash()
    });
    assert_eq!(ends[0], ends[1]);
    gpu.finish();
}

/// Would catch: a deposit of a particle that was refused, and a heading that it keeps.
#[test]
fn refused_particles_stay_leave_nothing_and_look_about() {
    let scene = crowded(TORUS, |settings| {
        settings.particles.count = 2500;
        settings.physarum.order = StepOrder::SenseFirst;
    });
    let mut twin = twin::Simulation::new(Setup::new(&scene).unwrap(), scene.settings.clone());
    for _ in 0..4 {
        twin.step();
    }
    let before = by_id(&twin.snapshot());
    twin.step();
    let state = twin.snapshot();
    let atlas = &twin.setup().atlas;
    let (mut stayed, mut sums) = (0, [0.0; 2]);
    for ((old, _), (new, motion)) in before.iter().zip(by_id(&state)) {
        let position = atlas_position(&atlas.maps[new.triangle as usize], new.u, new.v);
        let deposits = state.deposits[texel_at(position, atlas.pitch) as usize];
        if motion.has_stayed() {
            assert_eq!((*old, deposits, motion.pending), (new, 0, 0.0));
            stayed += 1;
            sums[0] += motion.heading_p;
            sums[1] += motion.heading_h;
        } else {
            assert!(deposits == 1 && new != *old);
        }
    }
    assert!((250..2250).contains(&stayed), "{stayed}");
    // They head everywhere: sums of directions are a random walk.
    let most = 4.0 * (stayed as f32).sqrt();
    assert!(
        sums.iter().all(|sum| sum.abs() < most),
        "{sums:?} of {stayed}"
    );
    let left: u64 = state.deposits.iter().map(|&count| u64::from(count)).sum();
    assert_eq!(left, 2500 - stayed);
    // More rounds let more of them move, and leave fewer undecided.
    let ends = [1, 2, 9].map(|rounds| {
        let scene = crowded(TORUS, |settings| {
            settings.particles.count = 2500;
            settings.physarum.occupancy_rounds = rounds;
        });
        let left_over = by_twins(&scene, 20).transfers.flow.left_over;
        (by_twins(&scene, 1).stayed_count(), left_over)
    });
    assert!(ends[0].0 > ends[1].0, "{ends:?}");
    assert!(ends[0].1 > ends[1].1 && ends[1].1 > ends[2].1, "{ends:?}");
}

#[test]
fn particles_begin_one_a_cell() {
    let at_one_place = crowded(TORUS, |settings| {
        settings.particles.start = Start::Point;
        settings.particles.count = 400;
    });
    let setup = Setup::new(&at_one_place).unwrap();
    let state = Snapshot::start(&setup);
    assert_eq!(sharing(&state, &setup), 0);
    // They lie round the place: 400 cells are a square of 20 by 20.
    let places: Vec<_> = (state.particles.iter())
        .map(|particle| {
            let corners = setup.surface.corners[particle.triangle as usize];
            let [a, b, c] = corners.map(|i| setup.surface.positions[i as usize]);
            a + particle.u * (b - a) + particle.v * (c - a)
        })
        .collect();
    let side = (setup.atlas.mean_texel_area as f32).sqrt();
    let middle = places[0];
    let farthest = (places.iter())
        .map(|place| place.distance(middle))
        .fold(0.0, f32::max);
    assert!(farthest < 40.0 * side, "{farthest} of texels of {side}");

    // As many as there are cells: all are taken, and particles can only move within their own.
    let cells = setup.atlas.owned_count;
    let full = |count: u32| crowded(TORUS, |settings| settings.particles.count = count);
    let state = by_twins(&full(cells), 2);
    assert_eq!(sharing(&state, &setup), 0);
    assert!(state.stayed_count() > u64::from(cells) / 2);
    state.validate(&Setup::new(&full(cells)).unwrap()).unwrap();
    let message = Setup::new(&full(cells + 1)).unwrap_err().to_string();
    for part in [
        "particles.count = ",
        "one particle a cell",
        "atlas.size from 96",
    ] {
        assert!(message.contains(part), "{message}");
    }
    let restarting = trio(|settings| settings.transfer.strategy = Strategy::Respawn);
    let message = Setup::new(&restarting).unwrap_err().to_string();
    assert!(
        message.contains("transfer.strategy = \"respawn\""),
        "{message}"
    );
}

/// Particles on each of two equal objects at the start.
fn on_objects(change: impl Fn(&mut Settings)) -> [usize; 2] {
    let scene = scene_of_several(
        &[
            ("builtin:cube", [0.0; 3]),
            ("builtin:cube", [4.0, 0.0, 0.0]),
        ],
        |settings| {
            settings.atlas.size = 128;
            settings.particles.count = 6000;
            change(settings);
        },
    );
    let setup = Setup::new(&scene).unwrap();
    let mut counts = [0; 2];
    for particle in &setup.particles {
        counts[setup.surface.triangles[particle.triangle as usize].object as usize] += 1;
    }
    counts
}

/// Would catch: particles that find their cells taken and leave their object for others, so that it loses its share.
#[test]
fn objects_keep_their_particles_where_each_begins_in_a_cell_of_its_own() {
    let starts: [fn(&mut Settings); 3] = [
        |_| (),
        |settings| settings.objects[0].start.share = 3.0,
        |settings| settings.objects[1].start.place = ObjectStart::Point,
    ];
    for change in starts {
        let of_model = |model: Model| {
            on_objects(|settings| {
                settings.physarum.model = model;
                change(settings);
            })
        };
        assert_eq!(of_model(Model::Jones), of_model(Model::Thesis));
    }
}

/// Of 10,000 cells 6,000 are taken, as in sets that are drawn without repetition. Would catch: particles that go to cells beside those that were
/// drawn twice, which makes crowds; and headings that come of the places.
#[test]
fn cells_that_are_taken_at_the_start_are_drawn_without_repetition() {
    const SIDE: usize = 100;
    let beside = |taken: &[bool]| {
        let pairs = (0..SIDE * SIDE).map(|cell| {
            let right = cell / SIDE * SIDE + (cell + 1) % SIDE;
            let below = (cell + SIDE) % (SIDE * SIDE);
            usize::from(taken[cell] && taken[right]) + usize::from(taken[cell] && taken[below])
        });
        pairs.sum::<usize>() as f64
    };
    let drawn: Vec<f64> = (0..200)
        .map(|seed| {
            let mut cells: Vec<u32> = (0..(SIDE * SIDE) as u32).collect();
            cells.sort_by_key(|&cell| random(seed, cell, 0, Purpose::Paint));
            let mut taken = vec![false; SIDE * SIDE];
            for &cell in &cells[..6000] {
                taken[cell as usize] = true;
            }
            beside(&taken)
        })
        .collect();
    let middle = mean(&drawn);
    let squares: f64 = drawn.iter().map(|count| (count - middle).powi(2)).sum();
    let deviation = (squares / (drawn.len() - 1) as f64).sqrt();

    for seed in [1, 2, 3] {
        let scene = crowded("builtin:plane?periodic=true", |settings| {
            settings.atlas.size = SIDE as u32;
            settings.particles.count = 6000;
            settings.seed = seed;
        });
        let setup = Setup::new(&scene).unwrap();
        let atlas = &setup.atlas;
        let gutter = atlas.gutter;
        let mut taken = vec![false; SIDE * SIDE];
        for particle in &setup.particles {
            let cell = cell_of(particle, atlas, &setup.homes);
            let (x, y) = (cell % atlas.pitch - gutter, cell / atlas.pitch - gutter);
            taken[y as usize * SIDE + x as usize] = true;
        }
        let count = beside(&taken);
        assert!(
            (count - middle).abs() < 4.0 * deviation,
            "{count} pairs, and {middle} +- {deviation} of sets"
        );
        let sums = (setup.motions.iter()).fold([0.0, 0.0], |[p, h]: [f32; 2], motion| {
            [p + motion.heading_p, h + motion.heading_h]
        });
        let most = 4.0 * 6000.0_f32.sqrt();
        assert!(sums.iter().all(|sum| sum.abs() < most), "{sums:?}");
    }
}

/// Particles that a brush brings may come to one cell. They part, and no other one comes to them; on the device, too, which looks for shared
/// cells only after a brush was used, or where a restored state has some.
#[test]
fn particles_that_were_brought_to_one_cell_part() {
    let Some(gpu) = gpu() else { return };
    let scene = crowded(TORUS, |settings| {
        settings.particles.count = 300;
        // Without a trail nothing holds them together.
        settings.physarum.deposit = 0.0;
    });
    let mut twin = twin::Simulation::new(Setup::new(&scene).unwrap(), scene.settings.clone());
    twin.step();
    twin.paint(&dab(Brush::Particles { share: 0.8 })).unwrap();
    let count = |twin: &twin::Simulation| sharing(&twin.snapshot(), twin.setup());
    let homes = homes(&twin.setup().atlas);
    let cells_of = |twin: &twin::Simulation| -> Vec<u32> {
        let particles = by_id(&twin.snapshot()).into_iter();
        particles
            .map(|(particle, _)| cell_of(&particle, &twin.setup().atlas, &homes))
            .collect()
    };
    let mut before = count(&twin);
    assert!(before > 30, "{before}");
    // One device restores the state, and one gets there by the brush.
    let mut restored = Simulation::new(&gpu.ctx, &scene).unwrap();
    restored.restore(&twin.snapshot()).unwrap();
    let mut painted = Simulation::new(&gpu.ctx, &scene).unwrap();
    advance(&gpu, &mut painted, 1);
    gpu.run(|rec| {
        let brush = Brush::Particles { share: 0.8 };
        assert!(painted.paint(rec, &dab(brush)).unwrap().count() > 0);
    });
    for simulation in [&mut restored, &mut painted] {
        advance(&gpu, simulation, 20);
    }
    for step in 0..300 {
        if step == 20 {
            for simulation in [&restored, &painted] {
                let state = simulation.snapshot().unwrap();
                assert_eq!(state.hash(), twin.snapshot().hash());
            }
        }
        let old = cells_of(&twin);
        twin.step();
        let mut first = HashMap::new();
        for (id, cell) in cells_of(&twin).into_iter().enumerate() {
            let other = *first.entry(cell).or_insert(id);
            assert_eq!(old[id], old[other], "step {step}: {id} joins {other}");
        }
        before = count(&twin);
        twin.snapshot().validate(twin.setup()).unwrap();
    }
    assert_eq!(before, 0);
    gpu.finish();
}

/// Would catch: a mark of refused particles that a checkpoint or a new layout forgets, so that its deposits are too few.
#[test]
fn a_run_goes_on_from_a_checkpoint() {
    let Some(gpu) = gpu() else { return };
    let scene = trio(|_| ());
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    advance(&gpu, &mut simulation, 20);
    let kept = Checkpoint::new(&scene, simulation.setup(), simulation.snapshot().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("state");
    kept.write(&file).unwrap();
    let read = Checkpoint::read(&file).unwrap();
    assert!(read.snapshot.stayed_count() > 10);
    assert_eq!(read.check(&scene, simulation.setup()).unwrap(), [""; 0]);
    // A scene that is laid out again takes the marks over.
    let wider = Setup::new(&trio(|settings| settings.atlas.size = 160)).unwrap();
    let from = [Some(0), Some(1), Some(2)];
    let carried = carried(&read.snapshot, simulation.setup(), &wider, &from).unwrap();
    assert!(carried.stayed_count() > 10);
    carried.validate(&wider).unwrap();
    let mut other = Simulation::new(&gpu.ctx, &scene).unwrap();
    other.restore(&read.snapshot).unwrap();
    let mut restarting = scene.settings.clone();
    restarting.transfer.strategy = Strategy::Respawn;
    let refused = other.apply(&restarting).unwrap_err().to_string();
    assert!(
        refused.contains("there is one particle a cell"),
        "{refused}"
    );
    advance(&gpu, &mut simulation, 20);
    advance(&gpu, &mut other, 20);
    let [own, other] = [simulation, other].map(|s| s.snapshot().unwrap());
    assert_eq!(own.hash(), other.hash());
    assert_eq!(own.transfers.flow, other.transfers.flow);
    gpu.finish();
}

/// Particles at one place of a plane, with one heading, and a trail on all cells but that ahead.
fn at_a_fork(change: impl FnOnce(&mut Settings)) -> (twin::Simulation, Snapshot) {
    let scene = crowded("builtin:plane?columns=8&rows=8", |settings| {
        settings.physarum.model = Model::Thesis;
        settings.physarum.sensor_width = 1;
        settings.particles.count = 4000;
        settings.particles.start = Start::Point;
        settings.particles.start_at = [0.05, 0.0, 0.03];
        settings.particles.start_heading = Heading::Aligned;
        settings.particles.start_direction = [1.0, 0.0, 0.3];
        change(settings);
    });
    let setup = Setup::new(&scene).unwrap();
    let mut state = Snapshot::start(&setup);
    let settings = scene.settings.clone();
    let means = Means::of_host(false, 0);
    let plan = Plan::new(&settings, &setup, 0, means);
    let call = plan.advance(plan.terms(), Form::All);
    let own = myxo::sim::behaviour::physarums(&settings, &setup);
    let inputs = twin::AdvanceInputs::of_surface(&setup, &own);
    let (particle, motion) = (state.particles[0], state.motions[0]);
    let ahead = [motion.heading_p, motion.heading_h];
    let [_, middle, _] =
        twin::straight_places(&call.params, &inputs, &own[0], &particle, [ahead; 3]).unwrap();
    let texels = state.trail.iter_mut().zip(&setup.atlas.density);
    for (trail, density) in texels {
        *trail = if *density > 0.0 { 10.0 } else { 0.0 };
    }
    state.trail[texel_at(middle, setup.atlas.pitch) as usize] = 1.0;
    let mut twin = twin::Simulation::new(setup, settings);
    let trail = std::mem::take(&mut state.trail);
    state = Snapshot {
        trail,
        ..twin.snapshot()
    };
    twin.restore(&state);
    (twin, state)
}

/// How many turned left, right, anywhere else, and not at all.
fn turns((mut twin, before): (twin::Simulation, Snapshot)) -> [usize; 4] {
    let old = before.motions[0];
    twin.step();
    let mut counts = [0; 4];
    for (_, new) in by_id(&twin.snapshot()) {
        let cross = old.heading_p * new.heading_h - old.heading_h * new.heading_p;
        let dot = old.heading_p * new.heading_p + old.heading_h * new.heading_h;
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let is_near = |a: f32, b: f32| (a - b).abs() < 1e-3;
        let kind = match () {
            () if is_near(dot, half) && is_near(cross, half) => 0,
            () if is_near(dot, half) && is_near(cross, -half) => 1,
            () if is_near(dot, 1.0) => 3,
            () => 2,
        };
        counts[kind] += 1;
    }
    counts
}

/// Would catch: ties that lean to one side, random turns that are rarer or more frequent than asked for, and a threshold that is not compared.
#[test]
fn random_turns_have_the_shares_that_they_should() {
    // Twice five deviations of a fair coin.
    let [left, right, other, straight] = turns(at_a_fork(|s| s.physarum.turning = Turning::Random));
    assert!(
        left.abs_diff(right) < 640 && other + straight == 0,
        "{left}, {right}"
    );
    // Equal sides are no reason to turn for the other rule.
    assert_eq!(turns(at_a_fork(|_| ())), [0, 0, 0, 4000]);
    // With a probability of 0.3, within five deviations.
    let [_, _, other, straight] = turns(at_a_fork(|s| s.physarum.random_turn = 0.3));
    assert!(other.abs_diff(1200) < 150, "{other}");
    assert!(straight >= 4000 - 1350);
    // What is below the threshold is not sensed.
    for (threshold, turned) in [(0.5, 4000), (9.0, 4000), (11.0, 0)] {
        let [left, right, ..] = turns(at_a_fork(|s| {
            s.physarum.turning = Turning::Random;
            s.physarum.sensitivity = threshold;
        }));
        assert_eq!(left + right, turned, "{threshold}");
    }
    // A wide sensor sees less of the gap, but sees it.
    let [left, right, ..] = turns(at_a_fork(|s| {
        s.physarum.turning = Turning::Random;
        s.physarum.sensor_width = 3;
    }));
    assert_eq!(left + right, 4000);
}

/// Would catch: a favourite density of 0 that still means none, and a preference that the density overrules.
#[test]
fn particles_that_like_no_trail_turn_away_from_it() {
    let fork = |preference: Preference, density: f32| {
        at_a_fork(|s| {
            s.physarum.turning = Turning::Random;
            s.physarum.preference = preference;
            s.physarum.favourite_density = density;
        })
    };
    // Both sides have 10 times the trail of the middle.
    for (preference, density, turned) in [
        (Preference::Auto, 0.0, 4000),
        (Preference::Auto, 1.0, 0),
        (Preference::More, 1.0, 4000),
        (Preference::Favourite, 0.0, 0),
        (Preference::Favourite, 10.0, 4000),
    ] {
        let [left, right, _, straight] = turns(fork(preference, density));
        assert_eq!(left + right, turned, "{preference:?}, {density}");
        assert_eq!(straight, 4000 - turned, "{preference:?}, {density}");
    }
    // The middle has 10 times the trail of the sides.
    for (preference, turned) in [(Preference::More, 0), (Preference::Favourite, 4000)] {
        let (mut twin, mut state) = fork(preference, 0.0);
        for trail in state.trail.iter_mut().filter(|trail| **trail > 0.0) {
            *trail = 10.0 / *trail;
        }
        twin.restore(&state);
        let [left, right, ..] = turns((twin, state));
        assert_eq!(left + right, turned, "{preference:?}");
    }
}

/// Sensors read as many cells round each cell as the widest does: all are owned, or in the gutter and filled.
#[test]
fn wide_sensors_read_no_empty_texel() {
    for mesh in [
        TORUS,
        "builtin:cube?divisions=6",
        "builtin:plane?columns=8&rows=8",
    ] {
        let scene = crowded(mesh, |settings| settings.physarum.sensor_width = 9);
        let setup = Setup::new(&scene).unwrap();
        let atlas = &setup.atlas;
        assert_eq!(atlas.gutter, 4);
        let filled: HashSet<u32> = atlas.seams.iter().map(|seam| seam.texel).collect();
        let pitch = atlas.pitch as i32;
        for cell in (0..atlas.density.len()).filter(|&cell| atlas.density[cell] > 0.0) {
            for row in -4..=4 {
                for column in -4..=4 {
                    let texel = (cell as i32 + row * pitch + column) as u32;
                    let is_known = atlas.density[texel as usize] > 0.0 || filled.contains(&texel);
                    assert!(is_known, "{mesh}: {row}, {column} from {cell}");
                }
            }
        }
    }
}

/// Would catch: taps of the diffusion as far apart as the gutter of wide sensors is wide, with which rows of texels never spread, and keep
/// their deposits.
#[test]
fn wide_sensors_leave_no_deposits_behind() {
    for width in [1, 5, 9] {
        let scene = crowded(TORUS, |settings| settings.physarum.sensor_width = width);
        let state = by_twins(&scene, 20);
        state.validate(&Setup::new(&scene).unwrap()).unwrap();
    }
}

/// Every gutter texel has the cell that it takes most of.
#[test]
fn each_texel_has_a_cell() {
    let setup = Setup::new(&crowded(TORUS, |_| ())).unwrap();
    let atlas = &setup.atlas;
    for seam in &atlas.seams {
        let home = setup.homes[seam.texel as usize];
        let heaviest = seam.units().into_iter().max().unwrap();
        let place = seam
            .source
            .iter()
            .position(|&source| source == home)
            .unwrap();
        assert!(atlas.density[home as usize] > 0.0 && seam.units()[place] == heaviest);
    }
    for particle in &setup.particles {
        assert!(atlas.density[cell_of(particle, atlas, &setup.homes) as usize] > 0.0);
    }
    let plain = Setup::new(&scene(TORUS, |_| ())).unwrap();
    assert!(plain.homes.is_empty());
}
