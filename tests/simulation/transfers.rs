//! Particles change objects: the same by every strategy, none lost, whatever happens.

use crate::advance;
use std::collections::{BTreeMap, BTreeSet};

use crate::common::{Gpu, TRIO, awkward_sizes, by_id, gpu, scene_of_several};
use myxo::gpu::{Buffer, Pipeline, Texels, Threads};
use myxo::scene::settings::{
    ObjectStart, OwnPhysarum, OwnTrail, RestartPlace, Settings, Start, Strategy,
};
use myxo::scene::{Overrides, Scene};
use myxo::sim::checkpoint::Checkpoint;
use myxo::sim::kernels::{Respawn, RespawnArgs, RespawnConstants, RespawnParams};
use myxo::sim::restarts::Restarts;
use myxo::sim::transfers::{area_shares, object_triangles};
use myxo::sim::types::{Flow, Motion, Particle};
use myxo::sim::{Setup, Simulation, Snapshot, twin};

/// Objects that stand in one another.
fn scene_of(meshes: &[(&str, [f32; 3])], change: impl FnOnce(&mut Settings)) -> Scene {
    scene_of_several(meshes, |settings| {
        settings.particles.count = 3000;
        settings.atlas.size = 160;
        settings.physarum.speed = 0.02;
        change(settings);
    })
}

/// Three that touch one another.
fn trio(change: impl FnOnce(&mut Settings)) -> Scene {
    scene_of(&TRIO, change)
}

fn with(strategy: Strategy) -> impl FnOnce(&mut Settings) {
    move |settings| settings.transfer.strategy = strategy
}

/// Runs and checks every step.
fn run(gpu: &Gpu, scene: &Scene, steps: u32) -> Snapshot {
    run_on(gpu, &mut Simulation::new(&gpu.ctx, scene).unwrap(), steps)
}

/// As [`run`], of a simulation that may have begun.
fn run_on(gpu: &Gpu, simulation: &mut Simulation, steps: u32) -> Snapshot {
    for _ in 0..steps {
        advance(gpu, simulation, 1);
        let state = simulation.snapshot().unwrap();
        state.validate(simulation.setup()).unwrap();
    }
    simulation.snapshot().unwrap()
}

/// They differ in how they keep the buffer.
const THAT_TRANSFER: [Strategy; 4] = [
    Strategy::Scattered,
    Strategy::Sequential,
    Strategy::Parallel,
    Strategy::Direct,
];

#[test]
fn strategies_that_transfer_give_the_same_bits() {
    let Some(gpu) = gpu() else { return };
    let ends = THAT_TRANSFER.map(|strategy| run(&gpu, &trio(with(strategy)), 60));
    let parallel = &ends[2];
    assert_eq!(ends.each_ref().map(Snapshot::hash), [parallel.hash(); 4]);
    let flow = parallel.transfers.flow;
    assert!(
        flow.arrived > 1000 && flow.refused == 0 && flow.mismatches == 0,
        "{flow:?}"
    );
    // All that left have arrived, and were counted by where from and where to.
    assert_eq!(flow.selected, flow.arrived);
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

/// Once the particles that began inside of other objects have left them, most transfers cross the line in which the objects
/// meet, rather than go to the nearest point. For the rest, the texels' coarse field selects too late or too early.
#[test]
fn most_cross_where_the_objects_meet() {
    let Some(gpu) = gpu() else { return };
    let scene = trio(|settings| settings.atlas.size = 256);
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let mut flow = || {
        advance(&gpu, &mut simulation, 100);
        simulation.snapshot().unwrap().transfers.flow
    };
    let (before, after) = (flow(), flow());
    let selected = after.selected - before.selected;
    let crossed = after.crossed - before.crossed;
    assert!(
        selected > 300 && crossed * 4 > selected * 3,
        "{crossed} of {selected}"
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
        // The others end as the parallel one does.
        if [Strategy::None, Strategy::Respawn, Strategy::Parallel].contains(&strategy) {
            assert_eq!(run(&gpu, &scene, 40).hash(), first.hash(), "{strategy:?}");
        }
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
    assert_eq!(hashes.len(), 3, "none, respawn, those that transfer");
    gpu.finish();
}

/// Ids of particles that left their object in a step, arrived on another one, or restarted, each with the object that it is on
/// or goes to.
fn changed(setup: &Setup, before: &Snapshot, after: &Snapshot) -> BTreeMap<u32, u32> {
    let object = |p: &Particle| setup.surface.triangles[p.triangle as usize].object;
    let place = |p: &Particle| {
        let [a, b, c] = setup.surface.corners[p.triangle as usize]
            .map(|vertex| setup.surface.positions[vertex as usize]);
        a + p.u * (b - a) + p.v * (c - a)
    };
    // What walks stays on its object, and gets no farther than some steps.
    let jumps = |a: &Particle, b: &Particle| {
        object(a) != object(b) || place(a).distance(place(b)) > 5.0 * 0.02 * setup.radius
    };
    let both = by_id(before).into_iter().zip(by_id(after));
    let jumped = both
        .filter(|((a, _), (b, _))| jumps(a, b))
        .map(|(_, (b, _))| (b.id, object(&b)));
    jumped.collect()
}

/// All sensors walk.
#[test]
fn a_step_agrees_with_its_twin_by_every_strategy() {
    agrees_with_its_twin(|settings| {
        settings.physarum.gravity_weight = 3.0;
        settings.particles.count = 1500;
    });
}

/// Sensors read straight ahead if they can, and particles near other objects are separated, with all terms of sensors
/// but for heights.
#[test]
fn a_step_in_four_forms_agrees_with_its_twin_by_every_strategy() {
    let forms = agrees_with_its_twin(|settings| {
        settings.particles.count = 1500;
        // Texels as fine as that leave room between the forms.
        settings.atlas.size = 256;
        settings.physarum.sensor_noise = 0.05;
        settings.physarum.decrowding_weight = 0.3;
        settings.physarum.distance_weight = -2.0;
        settings.physarum.favourite_density = 4.0;
        // Sensors reach farther than a step, and meet other objects from places where a step would not.
        settings.physarum.sensor_offset = 0.12;
        // Some particles have a pending rest to walk, and do not read straight ahead before it is walked.
        settings.physarum.edge_crossing_attempts = 2;
    });
    for (strategy, forms) in forms {
        let [here, walk, near, walk_near] = forms;
        assert!(here > 20 && walk > 20, "{strategy:?}: {forms:?}");
        // Sensors see other objects where particles go there.
        let sees_others = ![Strategy::None, Strategy::Respawn].contains(&strategy);
        assert_eq!(near > 20, sees_others, "{strategy:?}: {forms:?}");
        assert_eq!(walk_near > 20, sees_others, "{strategy:?}: {forms:?}");
    }
}

/// If sensors look farther than distances reach, all walking particles are listed as ones that may see other objects.
#[test]
fn a_step_with_a_short_reach_agrees_with_its_twin_by_every_strategy() {
    let forms = agrees_with_its_twin(|settings| {
        settings.particles.count = 5000;
        settings.atlas.size = 256;
        settings.physarum.sensor_offset = 0.12;
        settings.distance.reach = 0.03;
    });
    for (strategy, [_, walk, _, walk_near]) in forms {
        let sees_others = ![Strategy::None, Strategy::Respawn].contains(&strategy);
        let [none, many] = if sees_others {
            [walk, walk_near]
        } else {
            [walk_near, walk]
        };
        assert!(none == 0 && many > 20, "{strategy:?}: {walk}, {walk_near}");
    }
}

/// Every object has values of its own, far from the scene's.
#[test]
fn a_step_with_values_of_objects_agrees_with_its_twin_by_every_strategy() {
    agrees_with_its_twin(|settings| {
        settings.particles.count = 1500;
        let own = [(0.7_f32, 1), (1.0, 3), (1.4, 9)];
        for (object, (factor, attempts)) in settings.objects.iter_mut().zip(own) {
            object.physarum = OwnPhysarum {
                speed: Some(0.02 * factor),
                rotation_angle: Some(40.0 * factor),
                sensor_angle: Some(30.0 * factor),
                sensor_offset: Some(0.06 * factor),
                sensor_noise: Some(0.1 * factor),
                deposit: Some(2.0 * factor),
                edge_crossing_attempts: Some(attempts),
                favourite_density: Some(4.0 * factor),
                gravity_weight: Some(3.0 * factor),
                decrowding_weight: Some(0.3 * factor),
                distance_weight: Some(-2.0 * factor),
            };
            object.trail = OwnTrail {
                diffusion: Some(0.6 * factor),
                decay: Some(0.6 * factor),
                ..OwnTrail::default()
            };
        }
    });
}

/// Compares a step by the kernels with one by the twins, from the same state, to the bit. Returns the number of particles in each form of
/// `advance`.
fn agrees_with_its_twin(change: impl Fn(&mut Settings)) -> Vec<(Strategy, [usize; 4])> {
    let mut forms = Vec::new();
    let Some(gpu) = gpu() else { return forms };
    for &strategy in Strategy::ALL {
        let scene = trio(|s| {
            s.transfer.strategy = strategy;
            s.transfer.threshold = 0.01;
            change(s);
        });
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let setup = simulation.setup().clone();
        let mut by_twin = twin::Simulation::new(setup.clone(), scene.settings.clone());
        for _ in 0..6 {
            by_twin.step();
            by_twin.snapshot().validate(&setup).unwrap();
        }
        let before = by_twin.snapshot();
        simulation.restore(&before).unwrap();
        by_twin.restore(&before);
        let selected_before = before.transfers.flow.selected;
        advance(&gpu, &mut simulation, 1);
        by_twin.step();
        let (kernel, twin) = (simulation.snapshot().unwrap(), by_twin.snapshot());
        // The kernel's lists hold exactly those that the twin has in each form.
        let listed = gpu.ctx.download(&simulation.state().walkers.count).unwrap();
        let [_, walk, near, walk_near] = by_twin.forms().map(|count| count as u32);
        assert_eq!(listed, [walk, near, walk_near], "{strategy:?}");
        kernel.validate(&setup).unwrap();
        twin.validate(&setup).unwrap();
        // Particles that change objects, and the objects that they go to.
        let [by_kernel, by_twins] = [&kernel, &twin].map(|after| changed(&setup, &before, after));
        assert_eq!(by_kernel, by_twins, "{strategy:?}");
        assert_eq!(kernel.hash(), twin.hash(), "{strategy:?}");
        assert_eq!(
            by_twins.len() > 20,
            strategy != Strategy::None,
            "{strategy:?}: {}",
            by_twins.len()
        );
        let selected = |state: &Snapshot| state.transfers.flow.selected - selected_before;
        assert_eq!(
            selected(&twin) > 5,
            strategy != Strategy::None,
            "{strategy:?}"
        );
        assert_eq!(selected(&kernel), selected(&twin), "{strategy:?}");
        forms.push((strategy, by_twin.forms()));
    }
    gpu.finish();
    forms
}

#[test]
fn strategies_change_while_it_runs() {
    let Some(gpu) = gpu() else { return };
    let scene = trio(with(Strategy::Parallel));
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let mut settings = scene.settings.clone();
    // From every strategy to every other one.
    for &from in Strategy::ALL {
        for &to in Strategy::ALL {
            for strategy in [from, to] {
                settings.transfer.strategy = strategy;
                simulation.apply(&settings).unwrap();
                let state = simulation.snapshot().unwrap();
                state.validate(simulation.setup()).unwrap();
                advance(&gpu, &mut simulation, 2);
                let state = simulation.snapshot().unwrap();
                state.validate(simulation.setup()).unwrap();
                assert_eq!(
                    state.transfers.windows.len(),
                    3 * usize::from(strategy.has_windows())
                );
            }
        }
    }
    // A change makes no difference to what is computed.
    let plain = run(&gpu, &scene, 40);
    let mut changing = Simulation::new(&gpu.ctx, &scene).unwrap();
    let mut settings = scene.settings.clone();
    for k in 0..8 {
        settings.transfer.strategy = THAT_TRANSFER[k % 4];
        changing.apply(&settings).unwrap();
        advance(&gpu, &mut changing, 5);
    }
    assert_eq!(changing.snapshot().unwrap().hash(), plain.hash());
    gpu.finish();
}

#[test]
fn a_resumed_run_ends_in_the_same_hash() {
    let Some(gpu) = gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("half.ckpt");
    for &strategy in Strategy::ALL {
        let scene = trio(with(strategy));
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let half = run_on(&gpu, &mut simulation, 15);
        let whole = run_on(&gpu, &mut simulation, 15);
        let mut resumed = Simulation::new(&gpu.ctx, &scene).unwrap();
        let checkpoint = Checkpoint::new(&scene, resumed.setup(), half.clone());
        checkpoint.write(&path).unwrap();
        let checkpoint = Checkpoint::read(&path).unwrap();
        assert_eq!(checkpoint.snapshot, half);
        checkpoint.check(&scene, resumed.setup()).unwrap();
        resumed.restore(&checkpoint.snapshot).unwrap();
        advance(&gpu, &mut resumed, 15);
        let end = resumed.snapshot().unwrap();
        assert_eq!(end.hash(), whole.hash(), "{strategy:?}");
        assert_eq!(end.transfers.flow.selected, whole.transfers.flow.selected);
        assert_eq!(end.transfers.flux, whole.transfers.flux);
    }
    gpu.finish();
}

/// Catches a choice of those that leave that depends on the order of atomic additions.
#[test]
fn full_buffers_give_the_same_bits_by_every_strategy_and_twice() {
    let Some(gpu) = gpu() else { return };
    let end = |strategy| {
        let scene = trio(|s| {
            s.transfer.strategy = strategy;
            s.transfer.buffer_size = 16;
        });
        let end = run(&gpu, &scene, 40);
        assert!(end.transfers.flow.refused > 100, "{:?}", end.transfers.flow);
        end.hash()
    };
    let ends = THAT_TRANSFER.map(end);
    assert_eq!(ends, [end(Strategy::Parallel); 4]);
    assert_eq!(end(Strategy::Respawn), end(Strategy::Respawn));
    gpu.finish();
}

#[test]
fn full_buffers_refuse_are_counted_and_lose_no_particle() {
    let Some(gpu) = gpu() else { return };
    for strategy in [
        Strategy::Scattered,
        Strategy::Sequential,
        Strategy::Parallel,
        Strategy::Direct,
        Strategy::Respawn,
    ] {
        let with_room_for = |buffer_size: u32| {
            let scene = trio(|s| {
                s.transfer.strategy = strategy;
                s.transfer.buffer_size = buffer_size;
            });
            run(&gpu, &scene, 40)
        };
        let end = with_room_for(4);
        let flow = end.transfers.flow;
        assert!(flow.refused > 0 && flow.most_wanted > 4, "{flow:?}");
        assert!(flow.arrived > 0 && flow.mismatches == 0, "{flow:?}");
        assert_eq!(flow.selected, flow.refused + flow.arrived);
        // The size that it names would have done.
        let wide = with_room_for(flow.most_wanted).transfers.flow;
        assert_eq!(wide.refused, 0, "{strategy:?}: {flow:?}, {wide:?}");
    }
    gpu.finish();
}

/// A single particle, far fewer particles than objects, all of them on one object, thresholds that cover everything or
/// nothing, identical objects in one place.
#[test]
fn odd_scenes_have_their_outcome() {
    let Some(gpu) = gpu() else { return };
    for strategy in [Strategy::Sequential, Strategy::Parallel, Strategy::Direct] {
        for (count, threshold, start) in [
            (1, 0.0, Start::Uniform),
            (2, 100.0, Start::Uniform),
            (700, 100.0, Start::Uniform),
            (700, -100.0, Start::Uniform),
            (701, 0.02, Start::Point),
        ] {
            let scene = trio(|s| {
                s.transfer.strategy = strategy;
                s.transfer.threshold = threshold;
                s.particles.count = count;
                s.particles.start = start;
            });
            let flow = run(&gpu, &scene, 20).transfers.flow;
            if threshold < -1.0 {
                assert_eq!(flow.selected, 0, "nothing is covered");
            }
            if count == 700 && threshold > 1.0 {
                assert!(flow.arrived > 100, "everything within reach is: {flow:?}");
            }
            assert_eq!(flow.refused, 0);
        }
    }
    // With a single object there is nothing to change to, whatever the strategy.
    let ends = [Strategy::None, Strategy::Parallel, Strategy::Respawn].map(|strategy| {
        let scene = scene_of(&[("cube", [0.0; 3])], with(strategy));
        run(&gpu, &scene, 10).hash()
    });
    assert_eq!(ends, [ends[0]; 3]);
    gpu.finish();
}

/// Each surface is exactly where the other one is. What lies on a surface is not inside of it, so neither object covers the
/// other, and every particle stays on its own.
#[test]
fn identical_objects_in_one_place_have_their_outcome() {
    let Some(gpu) = gpu() else { return };
    for strategy in [Strategy::Sequential, Strategy::Parallel, Strategy::Direct] {
        let same = [("cube?divisions=4", [0.0; 3]); 2];
        let scene = scene_of(&same, with(strategy));
        // Each run is checked after every step: no particle is lost or doubled, and no value is NaN.
        let end = run(&gpu, &scene, 20);
        assert_eq!(run(&gpu, &scene, 20).hash(), end.hash(), "{strategy:?}");
        assert_eq!(end.transfers.flow.selected, 0, "{strategy:?}");

        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        advance(&gpu, &mut simulation, 1);
        let state = simulation.state();
        let distances = gpu.ctx.download(&state.near.distances).unwrap();
        let nearest = gpu.ctx.download(&state.near.nearest).unwrap();
        let setup = simulation.setup();
        for (sample, &own) in setup.distance.samples.iter().zip(&setup.distance.owners) {
            let (distance, nearest) = (
                distances[sample.texel as usize],
                nearest[sample.texel as usize],
            );
            assert!((0.0..1e-6 * setup.radius).contains(&distance), "{distance}");
            let object = |triangle: u32| setup.surface.triangles[triangle as usize].object;
            assert_eq!(object(nearest), 1 - object(own));
        }
    }
    gpu.finish();
}

/// Those that restart lie on the object that they were on, anywhere by area.
#[test]
fn respawned_particles_stay_on_their_object() {
    let Some(gpu) = gpu() else { return };
    let scene = trio(|s| {
        s.transfer.strategy = Strategy::Respawn;
        s.transfer.threshold = 0.1;
        s.physarum.speed = 0.05;
    });
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let triangles = simulation.setup().surface.triangles.clone();
    // By their ids: the buffer is sorted meanwhile.
    let objects = |state: &Snapshot| -> BTreeMap<u32, u32> {
        let object = |p: &Particle| (p.id, triangles[p.triangle as usize].object);
        state.particles.iter().map(object).collect()
    };
    let before = objects(&simulation.snapshot().unwrap());
    advance(&gpu, &mut simulation, 30);
    let state = simulation.snapshot().unwrap();
    state.validate(simulation.setup()).unwrap();
    let after = objects(&state);
    assert!(after == before, "a particle is on another object");
    assert!(state.transfers.flow.arrived > 1000);
    gpu.finish();
}

/// The kernel and its twin on the same lists, of which not all are taken up, and entries of which stand in no order.
#[test]
fn respawn_agrees_with_its_twin() {
    let Some(gpu) = gpu() else { return };
    for place in [RestartPlace::Anywhere, RestartPlace::Start] {
        respawn_agrees(&gpu, place);
    }
    gpu.finish();
}

fn respawn_agrees(gpu: &Gpu, place: RestartPlace) {
    let ctx = &gpu.ctx;
    let scene = trio(|s| {
        s.transfer.strategy = Strategy::Respawn;
        s.transfer.respawn = place;
        // None begin on the last object: its particles restart anywhere.
        let name = |k: usize| format!("object {k}");
        for (k, object) in s.objects.iter_mut().enumerate() {
            object.name = name(k);
        }
        s.particles.start_object = name(0);
        s.objects[1].start.place = ObjectStart::Ring;
    });
    let setup = Setup::new(&scene).unwrap();
    let restarts = Restarts::of(&setup, &scene.settings);
    let surface = &setup.surface;
    let constants = RespawnConstants {
        from_start: place == RestartPlace::Start,
    };
    assert_eq!(restarts.ranges.len() == 3, constants.from_start);
    if constants.from_start {
        let has_some = restarts.ranges.iter().map(|range| range.x < range.y);
        assert!(has_some.eq([true, true, false]));
    }
    let count = surface.triangles.len() as u32;
    let (shares, ranges) = (area_shares(surface), object_triangles(surface));
    let pipeline = Pipeline::<Respawn>::new(ctx, &constants).unwrap();
    for leaving in awkward_sizes(64) {
        let all = 2 * leaving + 3;
        let mut particles: Vec<Particle> = (0..all)
            .map(|i| Particle {
                triangle: (i * 37) % count,
                u: 0.25,
                v: 0.5,
                id: all - 1 - i,
            })
            .collect();
        let mut motions = vec![
            Motion {
                heading_p: 1.0,
                heading_h: 0.0,
                pending: 0.5,
                flags: Motion::SELECTED | 1 << 20,
            };
            all as usize
        ];
        // Each once, from the end; then one that must not be read.
        let slots: Vec<u32> = (0..leaving + 1)
            .map(|i| all - 1 - 2 * i.min(leaving))
            .collect();
        for capacity in [leaving, leaving / 2] {
            let params = RespawnParams {
                capacity,
                seed: 5,
                time_step: 70_001,
            };
            let mut flow = Flow {
                leaving,
                arrived: 9,
                ..Flow::default()
            };
            let flow_buffer = Buffer::from_slice(ctx, "flow", &[flow]).unwrap();
            let particle_buffer = Buffer::from_slice(ctx, "particles", &particles).unwrap();
            let motion_buffer = Buffer::from_slice(ctx, "motions", &motions).unwrap();
            let triangles = Buffer::from_slice(ctx, "triangles", &surface.triangles).unwrap();
            gpu.run(|rec| {
                rec.dispatch(
                    &pipeline,
                    Threads(leaving + 1),
                    RespawnArgs {
                        flow: &flow_buffer,
                        particle_indices: &Buffer::from_slice(ctx, "slots", &slots).unwrap(),
                        particles: &Texels::new(&particle_buffer, 4).unwrap(),
                        motions: &Texels::new(&motion_buffer, 4).unwrap(),
                        triangles: &Texels::new(&triangles, 4).unwrap(),
                        area_shares: &Buffer::from_slice(ctx, "shares", &shares).unwrap(),
                        object_triangles: &Buffer::from_slice(ctx, "ranges", &ranges).unwrap(),
                        restarts: &Buffer::from_slice(ctx, "restarts", &restarts.places).unwrap(),
                        restart_ranges: &Buffer::from_slice(ctx, "parts", &restarts.ranges)
                            .unwrap(),
                    },
                    params,
                );
            });
            twin::respawn(
                &constants,
                &params,
                &mut flow,
                &slots,
                &mut particles,
                &mut motions,
                &surface.triangles,
                &shares,
                &ranges,
                &restarts,
            );
            assert_eq!(ctx.download(&flow_buffer).unwrap(), [flow]);
            assert_eq!(flow.arrived, 9 + capacity);
            assert_eq!(ctx.download(&particle_buffer).unwrap(), particles);
            let on_device: Vec<Motion> = ctx.download(&motion_buffer).unwrap();
            for (a, b) in on_device.iter().zip(&motions) {
                assert_eq!((a.pending, a.flags), (b.pending, b.flags));
                let off = (a.heading_p - b.heading_p).hypot(a.heading_h - b.heading_h);
                assert!(off < 1e-5, "{a:?}, and {b:?}");
            }
        }
    }
}

/// Would catch: particles that restart anywhere, or that walk on from where they began. After each step, those that have restarted in it
/// are where particles began, and no other one is.
#[test]
fn particles_restart_where_they_began() {
    let Some(gpu) = gpu() else { return };
    let scene = trio(|s| {
        s.transfer.strategy = Strategy::Respawn;
        s.transfer.respawn = RestartPlace::Start;
        s.transfer.threshold = 0.1;
        s.physarum.speed = 0.05;
        s.particles.start = Start::Disc;
    });
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let place = |p: &Particle| (p.triangle, p.u.to_bits(), p.v.to_bits());
    let began: BTreeSet<_> = simulation.setup().particles.iter().map(place).collect();
    let mut arrived = 0;
    for step in 0..60 {
        advance(&gpu, &mut simulation, 1);
        let state = simulation.snapshot().unwrap();
        let there = state.particles.iter().filter(|p| began.contains(&place(p)));
        let now = state.transfers.flow.arrived;
        assert_eq!(there.count() as u32, now - arrived, "step {step}");
        arrived = now;
    }
    assert!(arrived > 100, "{arrived}");
    gpu.finish();
}

/// Would catch: places of a run that goes on from a checkpoint, on either engine, where particles would begin now that an object has been
/// moved; and places that are forgotten while particles change objects, until they restart again.
#[test]
fn restart_places_stay_where_particles_began() {
    let Some(gpu) = gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("moved.ckpt");
    for strategy in [Strategy::Respawn, Strategy::Parallel] {
        let mut scene = trio(|s| {
            s.particles.count = 1000;
            s.particles.start = Start::Disc;
            s.atlas.size = 128;
            s.transfer.strategy = strategy;
            s.transfer.respawn = RestartPlace::Start;
            s.transfer.threshold = 0.1;
            s.physarum.speed = 0.05;
        });
        let mut going_on = Simulation::new(&gpu.ctx, &scene).unwrap();
        advance(&gpu, &mut going_on, 10);
        scene.settings.objects[1].position[0] += 0.3;
        going_on.apply(&scene.settings).unwrap();
        advance(&gpu, &mut going_on, 10);
        let state = going_on.snapshot().unwrap();
        let before = state.transfers.flow.arrived;
        let checkpoint = Checkpoint::new(&scene, going_on.setup(), state);
        checkpoint.write(&path).unwrap();
        let checkpoint = Checkpoint::read(&path).unwrap();
        let scene = checkpoint.own_scene(&path, &Overrides::default()).unwrap();
        let setup = Setup::new(&scene).unwrap();
        assert_ne!(setup.particles, going_on.setup().particles);
        checkpoint.check(&scene, &setup).unwrap();
        let mut damaged = checkpoint.clone();
        damaged.snapshot.transfers.restarts.places[0].x = u32::MAX;
        let problem = damaged.check(&scene, &setup).unwrap_err();
        assert!(problem.contains("place 0 to restart at"), "{problem}");
        damaged.snapshot.transfers.restarts.ranges[0].y += 1;
        let problem = damaged.check(&scene, &setup).unwrap_err();
        assert!(problem.contains("to restart at are damaged"), "{problem}");

        let mut resumed = Simulation::from_setup(&gpu.ctx, &scene, setup.clone()).unwrap();
        resumed.restore(&checkpoint.snapshot).unwrap();
        let mut settings = scene.settings.clone();
        settings.transfer.strategy = Strategy::Respawn;
        let mut by_twin = twin::Simulation::new(setup, settings);
        by_twin.restore(&checkpoint.snapshot);
        for simulation in [&mut going_on, &mut resumed] {
            let mut settings = simulation.settings().clone();
            settings.transfer.strategy = Strategy::Respawn;
            simulation.apply(&settings).unwrap();
            advance(&gpu, simulation, 10);
        }
        (0..10).for_each(|_| by_twin.step());
        let end = going_on.snapshot().unwrap();
        assert!(end.transfers.flow.arrived > before, "some have restarted");
        let others = [resumed.snapshot().unwrap(), by_twin.snapshot()];
        let places = &end.transfers.restarts;
        assert!(
            others
                .iter()
                .all(|other| other.transfers.restarts == *places)
        );
        let hashes = others.map(|other| other.hash());
        assert_eq!(hashes, [end.hash(); 2], "{strategy:?}");
    }
    gpu.finish();
}
