//! What must hold over many steps: on the GPU, and by the twins.

use crate::advance;
use crate::common::{self, Gpu, TRIO, by_id, gpu, scene, scene_of, scene_of_several};
use glam::{DVec2, DVec3};
use myxo::mesh::suite;
use myxo::mesh::surface::Surface;
use myxo::mesh::walk::{BorderRule, SurfacePoint, walk};
use myxo::scene::settings::{
    Border, DepthMapping, DistanceMethod, Sensing, Settings, SignRule, StepOrder, Strategy,
};
use myxo::scene::{Overrides, Scene};
use myxo::sim::checkpoint::Checkpoint;
use myxo::sim::field::{atlas_position, texel_at};
use myxo::sim::types::Pose;
use myxo::sim::{Setup, Simulation, Snapshot, TINY_TRAIL, mean_trail, twin};

fn run(gpu: &Gpu, scene: &Scene, steps: u32) -> Snapshot {
    let mut simulation = Simulation::new(&gpu.ctx, scene).unwrap();
    advance(gpu, &mut simulation, steps);
    simulation.snapshot().unwrap()
}

#[test]
fn same_seed_same_hash() {
    let Some(gpu) = gpu() else { return };
    let change = |s: &mut Settings| {
        s.particles.count = 20_011;
        s.physarum.sensor_noise = 0.1;
    };
    let scene_7 = scene("builtin:torus?major=36&minor=24", change);
    let first = run(&gpu, &scene_7, 60);
    for _ in 0..2 {
        assert_eq!(run(&gpu, &scene_7, 60).hash(), first.hash());
    }
    let scene_8 = scene("builtin:torus?major=36&minor=24", |s| {
        change(s);
        s.seed = 8;
    });
    assert_ne!(run(&gpu, &scene_8, 60).hash(), first.hash());
    assert!(first.trail.iter().any(|&t| t > 1.0), "something has grown");
    gpu.finish();
}

#[test]
fn resumed_run_ends_in_the_same_hash() {
    let Some(gpu) = gpu() else { return };
    let scene = scene("builtin:icosphere?subdivisions=3", |s| {
        s.physarum.decrowding_weight = 0.5
    });
    let whole = run(&gpu, &scene, 40);
    let half = run(&gpu, &scene, 17);

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("half.ckpt");
    let mut resumed = Simulation::new(&gpu.ctx, &scene).unwrap();
    Checkpoint::new(&scene, resumed.setup(), half)
        .write(&path)
        .unwrap();
    resumed
        .restore(&Checkpoint::read(&path).unwrap().snapshot)
        .unwrap();
    advance(&gpu, &mut resumed, 23);
    assert_eq!(resumed.snapshot().unwrap().hash(), whole.hash());

    let smaller = common::scene("builtin:icosphere?subdivisions=3", |s| {
        s.particles.count = 4999
    });
    let mut other = Simulation::new(&gpu.ctx, &smaller).unwrap();
    let error = other.restore(&whole).unwrap_err().to_string();
    assert!(
        error.contains("5000 particles") && error.contains("4999"),
        "{error}"
    );
    gpu.finish();
}

/// The texel of every particle counts it, and no other does.
fn assert_deposits_are_counted(setup: &Setup, state: &Snapshot) {
    let mut expected = vec![0; state.deposits.len()];
    for p in &state.particles {
        let texel = texel_at(
            atlas_position(&setup.atlas.maps[p.triangle as usize], p.u, p.v),
            setup.atlas.pitch,
        );
        expected[texel as usize] += 1;
    }
    assert!(
        state.deposits == expected,
        "the deposits are not the particles' texels"
    );
}

/// In an atlas as small as holds it, where particles share texels and each is near a seam.
#[test]
fn nothing_is_lost_on_any_mesh() {
    let gpu = gpu();
    for mesh in suite::all() {
        let name = mesh.name.clone();
        let size = if mesh.corners.len() < 900 { 128 } else { 256 };
        let scene = scene_of(mesh, |s| {
            s.particles.count = 1500;
            s.atlas.size = size;
            s.physarum.speed = 0.05;
            s.physarum.edge_crossing_attempts = 4;
        });
        let setup = Setup::new(&scene).unwrap();
        let mut by_twin = twin::Simulation::new(setup.clone(), scene.settings.clone());
        for _ in 0..20 {
            by_twin.step();
        }
        let state = by_twin.snapshot();
        state
            .validate(&setup)
            .unwrap_or_else(|problem| panic!("{name}, by twin: {problem}"));
        assert_deposits_are_counted(&setup, &state);
        let Some(gpu) = &gpu else { continue };
        let state = run(gpu, &scene, 20);
        state
            .validate(&setup)
            .unwrap_or_else(|problem| panic!("{name}: {problem}"));
        assert_deposits_are_counted(&setup, &state);
    }
    if let Some(gpu) = gpu {
        gpu.finish();
    }
}

#[test]
fn trail_loses_exactly_what_decay_takes() {
    let Some(gpu) = gpu() else { return };
    let scene = scene("builtin:cube", |s| {
        s.trail.diffusion = 0.0;
        s.trail.decay = 0.9;
        s.physarum.deposit = 0.0;
    });
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let mut state = simulation.snapshot().unwrap();
    let owned = |texel: usize| simulation.setup().atlas.density[texel] > 0.0;
    let mut expected: Vec<f32> = (0..state.trail.len())
        .map(|texel| {
            if owned(texel) {
                10.0f32.powi(-((texel % 25) as i32))
            } else {
                0.0
            }
        })
        .collect();
    state.trail.clone_from(&expected);
    simulation.restore(&state).unwrap();
    advance(&gpu, &mut simulation, 7);
    for value in &mut expected {
        for _ in 0..7 {
            *value *= 0.9;
            if *value < TINY_TRAIL {
                *value = 0.0;
            }
        }
    }
    let after = simulation.snapshot().unwrap();
    for texel in (0..expected.len()).filter(|&texel| simulation.setup().atlas.density[texel] > 0.0)
    {
        assert_eq!(after.trail[texel], expected[texel], "texel {texel}");
    }
    gpu.finish();
}

/// With a reference density the mean of the trail does not depend on the number of particles or the texture: it is that of a density of
/// 0.5.
#[test]
fn a_look_holds_for_any_number_of_particles() {
    let Some(gpu) = gpu() else { return };
    let decay = 0.9;
    for (count, size) in [(2_000, 128), (30_000, 128), (8_000, 256)] {
        let scene = scene("builtin:torus?major=24&minor=16", |s| {
            s.particles.count = count;
            s.atlas.size = size;
            s.trail.decay = decay;
            s.physarum.deposit = 2.0;
            s.physarum.reference_density = 0.5;
        });
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        advance(&gpu, &mut simulation, 12);
        let state = simulation.snapshot().unwrap();
        let atlas = &simulation.setup().atlas;
        let owned = (0..state.trail.len()).filter(|&texel| atlas.density[texel] > 0.0);
        let mass: f64 = owned
            .map(|texel| f64::from(state.trail[texel] / atlas.density[texel]))
            .sum();
        let mean = mass / f64::from(atlas.owned_count);
        let expected: f64 = (1..=12)
            .map(|age| 2.0 * 0.5 * f64::from(decay).powi(age))
            .sum();
        assert!(
            (mean - expected).abs() < 1e-3 * expected,
            "{count} particles, {size}: {mean}, not {expected}"
        );
        // After infinitely many steps there would be more.
        let there = 1.0 - f64::from(decay).powi(12);
        let end = mean_trail(&scene.settings, simulation.setup(), count);
        assert!((there * end / expected - 1.0).abs() < 1e-6, "{end}");
    }
    gpu.finish();
}

/// A constant trail stays constant under diffusion, over every seam.
#[test]
fn constant_trail_stays_constant() {
    let Some(gpu) = gpu() else { return };
    for distance in [1, 3] {
        let scene = scene("builtin:torus?major=12&minor=8", |s| {
            s.trail.diffusion = 0.8;
            s.trail.diffusion_distance = distance;
            s.trail.decay = 1.0;
            s.physarum.deposit = 0.0;
        });
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let mut state = simulation.snapshot().unwrap();
        state.trail.fill(3.0);
        simulation.restore(&state).unwrap();
        advance(&gpu, &mut simulation, 30);
        let after = simulation.snapshot().unwrap();
        for (texel, &value) in after.trail.iter().enumerate() {
            if simulation.setup().atlas.density[texel] > 0.0 {
                assert!(
                    (value - 3.0).abs() < 1e-4,
                    "distance {distance}: {value} at texel {texel}"
                );
            }
        }
    }
    gpu.finish();
}

fn position(surface: &Surface, point: SurfacePoint) -> DVec3 {
    let [a, b, c] =
        surface.corners[point.triangle as usize].map(|i| surface.positions[i as usize].as_dvec3());
    a + point.u * (b - a) + point.v * (c - a)
}

/// Particles that never turn walk the straightest path, also when each walk may cross few edges: what is left over
/// is walked later, and only what is still pending is missing in the end.
#[test]
fn straight_walks_stay_straight_and_what_is_pending_is_walked() {
    let Some(gpu) = gpu() else { return };
    for (order, attempts, some_pending) in [
        (StepOrder::SenseFirst, 50, false),
        (StepOrder::SenseFirst, 2, true),
        (StepOrder::MoveFirst, 2, true),
    ] {
        let scene = scene("builtin:torus?major=60&minor=40", |s| {
            s.particles.count = 400;
            s.atlas.size = 512;
            s.physarum.rotation_angle = 0.0;
            s.physarum.speed = 0.09;
            s.physarum.edge_crossing_attempts = attempts;
            s.physarum.order = order;
        });
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let before = by_id(&simulation.snapshot().unwrap());
        let steps = 12;
        let mut most_pending = 0.0f32;
        for _ in 0..steps {
            advance(&gpu, &mut simulation, 1);
            let state = simulation.snapshot().unwrap();
            most_pending = state
                .motions
                .iter()
                .fold(most_pending, |most, m| most.max(m.pending));
        }
        assert_eq!(most_pending > 0.0, some_pending, "{attempts} attempts");
        let after = by_id(&simulation.snapshot().unwrap());
        let surface = &simulation.setup().surface;
        let speed = f64::from(scene.settings.physarum.speed * simulation.setup().radius);
        let mut misses: Vec<f64> = (0..400)
            .filter(|&i: &usize| f64::from(after[i].1.pending) < 0.999 * speed)
            .map(|i| {
                let (p, m) = before[i];
                let start = SurfacePoint {
                    triangle: p.triangle,
                    u: f64::from(p.u),
                    v: f64::from(p.v),
                };
                let heading = DVec2::new(f64::from(m.heading_p), f64::from(m.heading_h));
                let length = f64::from(steps) * speed - f64::from(after[i].1.pending);
                let end = walk(surface, start, heading, length, None, BorderRule::Reflect);
                let (p, _) = after[i];
                let here = SurfacePoint {
                    triangle: p.triangle,
                    u: f64::from(p.u),
                    v: f64::from(p.v),
                };
                position(surface, end.point).distance(position(surface, here))
            })
            .collect();
        assert!(
            misses.len() > 300,
            "{order:?}, {attempts} attempts: only {} particles keep up",
            misses.len()
        );
        misses.sort_by(f64::total_cmp);
        // The pending length is capped at one step; the few that lost some of it are in the last tenth.
        let nine_tenths = misses[misses.len() * 9 / 10];
        assert!(
            nine_tenths < 1e-4,
            "{attempts} attempts: nine tenths are within {nine_tenths}"
        );
    }
    gpu.finish();
}

#[test]
fn settings_change_while_it_runs_or_say_that_they_restart() {
    let Some(gpu) = gpu() else { return };
    let scene = scene("builtin:cube", |_| ());
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    advance(&gpu, &mut simulation, 3);
    let mut settings = scene.settings.clone();
    settings.trail.decay = 0.0;
    settings.physarum.sensor_noise = 0.5;
    simulation.apply(&settings).unwrap();
    advance(&gpu, &mut simulation, 1);
    let state = simulation.snapshot().unwrap();
    assert!(
        state.trail.iter().all(|&t| t == 0.0),
        "the new decay leaves nothing"
    );
    assert_eq!(state.step, 4);

    settings.objects[0].position = [0.0, 2.0, 0.0];
    settings.objects[0].rotation = [0.0, 0.0, 90.0];
    simulation.apply(&settings).unwrap();
    let poses = gpu.ctx.download(&simulation.state().objects.poses).unwrap();
    let expected = Pose::from(settings.objects[0].world_from_object());
    let off = (poses[0].x - expected.x).abs() + (poses[0].y - expected.y).abs();
    assert!(
        off.max_element() < 1e-6 && poses[0].z.distance(expected.z) < 1e-6,
        "objects move while it runs: {poses:?}"
    );
    settings.objects[0].scale = 2.0;
    let error = simulation.apply(&settings).unwrap_err().to_string();
    assert!(
        error.contains("object.0.scale") && error.contains("restart"),
        "{error}"
    );
    settings.objects[0].scale = 1.0;

    settings.trail.decay = f32::NAN;
    let error = simulation.apply(&settings).unwrap_err().to_string();
    assert!(
        error.contains("trail.decay = NaN is out of range"),
        "{error}"
    );
    settings.trail.decay = 0.9;

    settings.particles.count += 1;
    let error = simulation.apply(&settings).unwrap_err().to_string();
    assert!(
        error.contains("particles.count") && error.contains("restart"),
        "{error}"
    );
    gpu.finish();
}

/// Catches a kernel of a step that was not made when the settings changed: pipelines are made ahead, for every step that may come.
#[test]
fn every_live_change_finds_its_kernels() {
    let Some(gpu) = gpu() else { return };
    let scene = scene_of_several(&TRIO, |s| {
        s.particles.count = 500;
        s.atlas.size = 96;
        s.transfer.strategy = Strategy::None;
    });
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    type Change = fn(&mut Settings);
    let changes: [Change; 17] = [
        |s| s.transfer.strategy = Strategy::Respawn,
        |s| s.transfer.strategy = Strategy::Direct,
        |s| s.transfer.strategy = Strategy::Scattered,
        |s| s.transfer.strategy = Strategy::Sequential,
        |s| s.transfer.strategy = Strategy::Parallel,
        |s| s.transfer.buffer_size = 16,
        |s| s.distance.method = DistanceMethod::Brute,
        |s| s.distance.method = DistanceMethod::Raster,
        |s| s.distance.depth = DepthMapping::Logistic,
        |s| s.distance.sign = SignRule::Winding,
        |s| s.distance.method = DistanceMethod::Bvh,
        |s| s.physarum.sensing = Sensing::Walk,
        |s| s.physarum.border = Border::Stop,
        |s| s.trail.diffusion = 0.9,
        |s| s.physarum.gravity_weight = 1.0,
        |s| s.objects[1].physarum.speed = Some(0.01),
        |s| s.feeding.scattered = 2,
    ];
    let mut settings = scene.settings.clone();
    for change in changes {
        change(&mut settings);
        simulation.apply(&settings).unwrap();
        settings.objects[0].position[0] += 0.01;
        simulation.apply(&settings).unwrap();
        // A sort is due in one of them.
        let steps = if settings.feeding.scattered > 0 {
            17
        } else {
            2
        };
        advance(&gpu, &mut simulation, steps);
    }
    let texels = simulation.setup().atlas.density.len();
    simulation.set_areas(&vec![0.5; texels]).unwrap();
    advance(&gpu, &mut simulation, 2);
    simulation.forget_areas().unwrap();
    advance(&gpu, &mut simulation, 2);
    simulation
        .snapshot()
        .unwrap()
        .validate(simulation.setup())
        .unwrap();
    gpu.finish();
}

/// Two triangles, and a ladder of 400 on one side of them whose rungs are nearer to each other than rounding.
fn ladder() -> String {
    use std::fmt::Write as _;
    let mut text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n".to_owned();
    let [mut left, mut right] = [4, 3];
    let mut rung = |y: f64, aside: f64| {
        let (next_left, next_right) = (left.max(right) + 1, left.max(right) + 2);
        let _ = write!(
            text,
            "v {aside:e} {y:.12} {aside:e}\nv 1 {y:.12} 0\nf {left} {right} {next_right}\nf {left} {next_right} {next_left}\n"
        );
        [left, right] = [next_left, next_right];
    };
    for i in 0..200 {
        let gap = 1e-8 / f64::from(1 + i % 7);
        rung(1.0 + 1e-8 * f64::from(i) + gap, gap);
    }
    rung(2.0, 0.0);
    text
}

/// Catches headings of length 0 or NaN where triangles are points in the strip that a walk lays out, or have no normal.
#[test]
fn triangles_thinner_than_rounding_keep_headings() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("ladder.obj"), ladder()).unwrap();
    let file = folder.path().join("two.toml");
    let object = "[[object]]\nmesh = 'ladder.obj'\n";
    let moved = "position = [0.1, 0.1, 0.02]\nrotation = [10, 20, 30]\n";
    std::fs::write(&file, format!("{object}{object}{moved}")).unwrap();
    let set = [
        "particles.count=20000",
        "atlas.size=256",
        "physarum.speed=0.03",
    ];
    let overrides = Overrides {
        set: set.map(str::to_owned).into(),
        ..Overrides::default()
    };
    let scene = Scene::load(&file, &overrides).unwrap();
    let setup = Setup::new(&scene).unwrap();
    let mut by_twin = twin::Simulation::new(setup.clone(), scene.settings.clone());
    for _ in 0..30 {
        by_twin.step();
    }
    by_twin.snapshot().validate(&setup).unwrap();
    let Some(gpu) = gpu() else { return };
    run(&gpu, &scene, 60).validate(&setup).unwrap();
    gpu.finish();
}
