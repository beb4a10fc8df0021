//! Kernels that walk, and whole steps, against their twins: integers equal, floats within a stated bound, at awkward sizes.

use crate::bits::assert_same_bits;
use crate::common::{Gpu, awkward_sizes, gpu, scene};
use glam::DVec2;
use myxo::gpu::Kernel as _;
use myxo::gpu::{Buffer, Context, Domain, Pipeline, Texels, Threads};
use myxo::mesh::surface::Surface;
use myxo::mesh::walk::{SurfacePoint, WalkQuery};
use myxo::mesh::{Mesh, suite};
use myxo::rng::{Purpose, random, unit};
use myxo::scene::settings::{Border, Preference, PulseSettings, Sensing, Settings};
use myxo::sim::behaviour::physarums;
use myxo::sim::kernels::{
    Advance, WalkQueries, WalkQueriesArgs, WalkQueriesConstants, WalkQueriesParams,
};
use myxo::sim::plan::{Means, Plan};
use myxo::sim::queries::walker_of;
use myxo::sim::step::advance::Form;
use myxo::sim::types::Walker;
use myxo::sim::walker::WALK_OUT_OF_ATTEMPTS;
use myxo::sim::{Setup, Simulation, Snapshot, twin};
use std::sync::Arc;

fn buffer<T: bytemuck::Pod>(ctx: &Arc<Context>, name: &str, data: &[T]) -> Buffer<T> {
    let buffer = Buffer::new(ctx, name, data.len(), Domain::Device).unwrap();
    ctx.upload(&buffer, data).unwrap();
    buffer
}

/// Walks at random over a mesh, some of them long, some on their first edge already.
fn walkers(surface: &Surface, count: u32) -> Vec<Walker> {
    let walker = |i| {
        let [a, b, c, d] = random(29, i, 0, Purpose::Start).map(|w| f64::from(unit(w)));
        let (u, v) = if b + c > 1.0 {
            (1.0 - b, 1.0 - c)
        } else {
            (b, c)
        };
        let on_edge = if i % 7 == 3 { 0.0 } else { 1.0 };
        walker_of(&WalkQuery {
            start: SurfacePoint {
                triangle: (a * surface.triangles.len() as f64) as u32,
                u: on_edge * u,
                v,
            },
            heading: DVec2::from_angle(std::f64::consts::TAU * d),
            length: [0.0, 0.01, 1.0, 5.0][i as usize % 4] * (1.0 + d),
        })
    };
    (0..count).map(walker).collect()
}

#[test]
fn walk_queries_agrees_with_its_twin() {
    let Some(gpu) = gpu() else { return };
    let meshes = [
        Mesh::builtin("torus?major=24&minor=16").unwrap(),
        suite::tube(12, 5),
        suite::slivers(),
    ];
    for (mesh, border_reflects) in meshes.iter().flat_map(|m| [(m, false), (m, true)]) {
        let surface = Surface::build(&[(mesh, 1.0)]);
        let constants = WalkQueriesConstants { border_reflects };
        let pipeline = Pipeline::<WalkQueries>::new(&gpu.ctx, &constants).unwrap();
        let triangles = buffer(&gpu.ctx, "triangles", &surface.triangles);
        let halfedges = buffer(&gpu.ctx, "halfedges", &surface.halfedges);
        let triangles = Texels::new(&triangles, 4).unwrap();
        let halfedges = Texels::new(&halfedges, 4).unwrap();
        for count in awkward_sizes(64).into_iter().filter(|&count| count > 0) {
            let mut twin = walkers(&surface, count);
            let walkers = buffer(&gpu.ctx, "walkers", &twin);
            // In pieces: where it stopped a walk continues.
            for attempts in [3, 0, 40, 1000] {
                let params = WalkQueriesParams {
                    walk_count: count,
                    attempts,
                };
                let (t, h) = (&surface.triangles, &surface.halfedges);
                twin::walk_queries(&constants, &params, t, h, &mut twin);
                gpu.run(|rec| {
                    rec.dispatch(
                        &pipeline,
                        Threads(count),
                        WalkQueriesArgs {
                            triangles: &triangles,
                            halfedges: &halfedges,
                            walkers: &walkers,
                        },
                        params,
                    );
                });
                let kernel = gpu.ctx.download(&walkers).unwrap();
                let what = format!("{}, {attempts} attempts of {count}", mesh.name);
                assert_same_bits(&what, &kernel, &twin);
            }
            let has_ended = |w: &Walker| w.status != WALK_OUT_OF_ATTEMPTS;
            assert!(twin.iter().all(has_ended), "all get to their ends");
        }
    }
    gpu.finish();
}

/// A state with trails to sense and particles under way: what some steps of the twin leave.
fn grown(setup: &Setup, settings: &Settings, steps: u32) -> Snapshot {
    let mut twin = twin::Simulation::new(setup.clone(), settings.clone());
    for _ in 0..steps {
        twin.step();
    }
    twin.snapshot()
}

/// One step by the kernels and one by the twins, from the same state.
fn compare_a_step(gpu: &Gpu, what: &str, scene: &myxo::scene::Scene) {
    let mut simulation = Simulation::new(&gpu.ctx, scene).unwrap();
    let setup = simulation.setup().clone();
    let before = grown(&setup, &scene.settings, 4);
    simulation.restore(&before).unwrap();
    gpu.run(|rec| simulation.record_step(rec));
    let kernel = simulation.snapshot().unwrap();
    kernel.validate(&setup).unwrap();

    let mut twin = twin::Simulation::new(setup.clone(), scene.settings.clone());
    twin.restore(&before);
    twin.step();
    let twin = twin.snapshot();
    twin.validate(&setup).unwrap();

    assert_same_bits(what, &kernel.particles, &twin.particles);
    assert_same_bits(what, &kernel.motions, &twin.motions);
    assert_same_bits(what, &kernel.trail, &twin.trail);
    assert_eq!(kernel.deposits, twin.deposits, "{what}");
    assert_eq!(kernel.food, twin.food, "{what}");
    assert_eq!(kernel.transfers.flow, twin.transfers.flow, "{what}");
    let deposited: u64 = kernel.deposits.iter().map(|&n| u64::from(n)).sum();
    assert_eq!(deposited, kernel.deposit_count(), "{what}");
}

#[test]
fn advance_agrees_with_its_twin() {
    let Some(gpu) = gpu() else { return };
    type Change = fn(&mut Settings);
    let variants: [(&str, Change); 16] = [
        ("plain", |_| ()),
        ("walking sensors", |s| s.physarum.sensing = Sensing::Walk),
        ("food", |s| {
            s.feeding.scattered = 5;
            s.feeding.radius = 0.9;
            s.feeding.strength = 9.0;
            s.feeding.amount = 900;
            s.feeding.size = 0.2;
            s.feeding.fed_steps = 3;
            s.feeding.fed_deposit = 3;
            s.feeding.fed_attraction = 0.3;
        }),
        ("markers that repel", |s| {
            s.feeding.scattered = 3;
            s.feeding.strength = -7.0;
            s.feeding.size = 0.0;
        }),
        ("pulses", |s| {
            // Two cross each other, and one begins in this step.
            let pulse = |at: [f32; 3], step| PulseSettings {
                at,
                step,
                speed: 0.1,
                width: 0.5,
                ..PulseSettings::default()
            };
            s.pulses = vec![
                pulse([0.4, 0.5, 0.3], 1),
                pulse([-0.2, 0.6, 0.0], 2),
                pulse([0.0; 3], 4),
            ];
        }),
        ("noise", |s| s.physarum.sensor_noise = 0.8),
        ("favourite density", |s| s.physarum.favourite_density = 2.0),
        ("no trail is best", |s| {
            s.physarum.preference = Preference::Favourite;
        }),
        ("gravity", |s| s.physarum.gravity_weight = 3.0),
        ("decrowding", |s| s.physarum.decrowding_weight = 0.7),
        ("decrowding and a reference density", |s| {
            s.physarum.decrowding_weight = 0.7;
            s.physarum.reference_density = 3.0;
        }),
        ("few attempts, long steps", |s| {
            s.physarum.edge_crossing_attempts = 1;
            s.physarum.speed = 0.3;
        }),
        ("far sensors", |s| {
            s.physarum.sensor_offset = 0.7;
            s.physarum.edge_crossing_attempts = 40;
        }),
        ("stop at borders", |s| {
            s.physarum.border = Border::Stop;
            s.physarum.speed = 0.2;
        }),
        ("everything", |s| {
            s.physarum.sensor_noise = 0.3;
            s.physarum.favourite_density = 1.0;
            s.physarum.gravity_weight = -1.0;
            s.physarum.decrowding_weight = 0.2;
            s.trail.diffusion_distance = 2;
        }),
        ("everything but gravity", |s| {
            s.physarum.sensor_noise = 0.3;
            s.physarum.favourite_density = 1.0;
            s.physarum.decrowding_weight = 0.2;
            s.physarum.edge_crossing_attempts = 2;
            s.physarum.speed = 0.1;
        }),
    ];
    for mesh in [
        "builtin:cube",
        "builtin:torus?major=24&minor=16",
        "builtin:plane?columns=9&rows=6",
    ] {
        for (name, change) in variants {
            let scene = scene(mesh, |s| {
                s.atlas.size = 128;
                s.objects[0].rotation = [20.0, 30.0, 40.0];
                s.objects[0].position = [0.3, -0.2, 0.1];
                change(s);
            });
            compare_a_step(&gpu, &format!("{mesh}, {name}"), &scene);
        }
    }
    gpu.finish();
}

#[test]
fn steps_agree_at_awkward_sizes() {
    let Some(gpu) = gpu() else { return };
    let groups = [awkward_sizes(64), awkward_sizes(Advance::GROUP_SIZE)].concat();
    for count in groups.into_iter().filter(|&count| count > 0) {
        for size in [64, 97, 203] {
            let scene = scene("builtin:cube", |s| {
                s.particles.count = count;
                s.atlas.size = size;
                // Enough trail for clear decisions with a single particle.
                s.physarum.sensor_noise = 1.0;
            });
            compare_a_step(&gpu, &format!("{count} particles, {size} texels"), &scene);
        }
    }
    gpu.finish();
}

/// The parameters and constants that the kernels are compared with are those of the settings.
#[test]
fn settings_reach_the_kernels() {
    let scene = scene("builtin:cube", |s| {
        s.radius = 2.0;
        s.physarum.speed = 0.25;
        s.physarum.sensor_offset = 0.5;
        s.physarum.sensor_angle = 90.0;
        s.physarum.rotation_angle = 180.0;
        s.physarum.gravity_weight = 4.0;
    });
    let setup = Setup::new(&scene).unwrap();
    let plan = Plan::new(&scene.settings, &setup, 9, Means::of_host(false, 1));
    let advance = plan.advance(plan.terms(), Form::All);
    let params = physarums(&scene.settings, &setup)[0];
    assert_eq!(
        (params.speed, params.sensor_offset, params.gravity_weight),
        (0.5, 1.0, 2.0)
    );
    assert!(params.sensor_cos.abs() < 1e-6 && (params.sensor_sin - 1.0).abs() < 1e-6);
    assert!((params.rotation_cos + 1.0).abs() < 1e-6);
    assert_eq!(advance.params.time_step, 9);
    let constants = advance.constants;
    assert!(constants.gravity && !constants.sensor_noise && constants.border_reflects);
}
