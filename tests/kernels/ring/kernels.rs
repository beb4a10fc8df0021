//! The kernels of the ring against their twins.

use std::sync::Arc;

use glam::Vec3;
use myxo::gpu::{Buffer, Context, Pipeline, Texels, Threads};
use myxo::mesh::surface::NONE;
use myxo::rng::{Purpose, random, unit};
use myxo::sim::kernels::{
    DefragmentScan, DefragmentScanArgs, DefragmentSequential, DefragmentSequentialArgs,
    DefragmentSequentialParams, DefragmentSwap, DefragmentSwapArgs, MoveBorder, MoveBorderArgs,
    TransferIn, TransferInArgs, TransferInParams,
};
use myxo::sim::loops::dispatches_of;
use myxo::sim::twin::transfer::transfer_in;
use myxo::sim::types::{Flow, Motion, Particle, Transfer, Window};

use super::model::{Case, Objects, Order, Ring};
use crate::common::gpu;

fn buffer<T: bytemuck::Pod>(ctx: &Arc<Context>, name: &str, data: &[T]) -> Buffer<T> {
    Buffer::from_slice(ctx, name, data).unwrap()
}

/// Drives the model, and puts in order by the kernels what the model puts in order by the twins.
#[test]
fn windows_are_kept_as_the_twins_keep_them() {
    let Some(gpu) = gpu() else { return };
    let ctx = &gpu.ctx;
    let scan = Pipeline::<DefragmentScan>::new(ctx, &()).unwrap();
    let swap = Pipeline::<DefragmentSwap>::new(ctx, &()).unwrap();
    let one_pass = Pipeline::<DefragmentSequential>::new(ctx, &()).unwrap();
    let sizes = [
        (1, 2, 1.0, 1),
        (65, 3, 0.4, 65),
        (199, 3, 1.0, 16),
        (1021, 5, 0.3, 1021),
        // More rounds of one pass than a loop has on lavapipe.
        (90_001, 2, 0.9, 90_001),
    ];
    for (k, (particles, objects, share, capacity)) in sizes.into_iter().enumerate() {
        for order in [Order::Sequential, Order::Parallel] {
            let case = Case {
                particles,
                objects,
                capacity,
                share,
                all_on: (k % 2 == 1).then_some(0),
                seed: 40 + k as u32,
            };
            let mut ring = Ring::new(case, order);
            let (constants, _) = ring.border_params(0);
            let border = Pipeline::<MoveBorder>::new(ctx, &constants).unwrap();
            for _ in 0..3 {
                for object in 0..objects {
                    ring.begin_turn(object);
                    let flow = buffer(ctx, "flow", &[ring.flow]);
                    let windows = buffer(ctx, "windows", &ring.windows);
                    let groups = buffer(ctx, "groups", &ring.groups);
                    let (_, params) = ring.border_params(object);
                    gpu.run(|rec| {
                        let args = MoveBorderArgs {
                            flow: &flow,
                            windows: &windows,
                            groups: &groups,
                        };
                        rec.dispatch(&border, Threads(1), args, params);
                    });
                    ring.move_border(object);
                    assert_eq!(ctx.download(&flow).unwrap(), [ring.flow], "{case:?}");
                    assert_eq!(ctx.download(&windows).unwrap(), ring.windows, "{case:?}");
                    assert_eq!(ctx.download(&groups).unwrap(), ring.groups, "{case:?}");

                    ring.depart(object);
                    let departing = buffer(ctx, "departing", &ring.departing);
                    let particles_buffer = buffer(ctx, "particles", &ring.particles);
                    let motions = buffer(ctx, "motions", &ring.motions);
                    if order == Order::Sequential {
                        let [inside, outside] = [&ring.particle_indices, &ring.transfer_indices]
                            .map(|list| buffer(ctx, "list", list));
                        let first = ring.sequential_params(object);
                        // The last part finds nothing left to do.
                        for part in 0..=dispatches_of(2 * u64::from(capacity)) {
                            gpu.run(|rec| {
                                let args = DefragmentSequentialArgs {
                                    flow: &flow,
                                    windows: &windows,
                                    departing: &departing,
                                    particles: &words(&particles_buffer),
                                    motions: &words(&motions),
                                    particle_indices: &inside,
                                    transfer_indices: &outside,
                                };
                                let params = DefragmentSequentialParams { part, ..first };
                                rec.dispatch(&one_pass, Threads(1), args, params);
                            });
                        }
                        ring.sequential(object);
                        assert_eq!(ctx.download(&flow).unwrap(), [ring.flow], "{case:?}");
                        assert_eq!(ctx.download(&particles_buffer).unwrap(), ring.particles);
                        assert_eq!(ctx.download(&motions).unwrap(), ring.motions);
                        assert_eq!(ctx.download(&departing).unwrap(), ring.departing);
                    } else {
                        let inside = buffer(ctx, "particle_indices", &ring.particle_indices);
                        let outside = buffer(ctx, "transfer_indices", &ring.transfer_indices);
                        gpu.run(|rec| {
                            let args = DefragmentScanArgs {
                                departing: &departing,
                                motions: &words(&motions),
                                windows: &windows,
                                flow: &flow,
                                particle_indices: &inside,
                                transfer_indices: &outside,
                            };
                            let threads = Threads(capacity);
                            rec.dispatch(&scan, threads, args, ring.scan_params(object));
                        });
                        ring.scan(object);
                        assert_eq!(ctx.download(&flow).unwrap(), [ring.flow], "{case:?}");
                        // The same entries in any order; the twin goes on with the kernel's.
                        let listed = ring.flow.stayers as usize;
                        for (list, of_twin) in [
                            (&inside, &mut ring.particle_indices),
                            (&outside, &mut ring.transfer_indices),
                        ] {
                            let by_kernel = ctx.download(list).unwrap();
                            let sorted = |list: &[u32]| {
                                let mut list = list[..listed].to_vec();
                                list.sort_unstable();
                                list
                            };
                            assert_eq!(sorted(&by_kernel), sorted(of_twin), "{case:?}");
                            *of_twin = by_kernel;
                        }
                        gpu.run(|rec| {
                            let args = DefragmentSwapArgs {
                                flow: &flow,
                                particle_indices: &inside,
                                transfer_indices: &outside,
                                departing: &departing,
                                particles: &words(&particles_buffer),
                                motions: &words(&motions),
                            };
                            rec.dispatch(&swap, Threads(capacity), args, ring.swap_params());
                        });
                        ring.swap();
                        assert_eq!(ctx.download(&particles_buffer).unwrap(), ring.particles);
                        assert_eq!(ctx.download(&motions).unwrap(), ring.motions);
                        assert_eq!(ctx.download(&departing).unwrap(), ring.departing);
                    }
                    ring.end_turn();
                    ring.check(object);
                }
                ring.step += 1;
            }
        }
    }
    gpu.finish();
}

/// Fewer parts than one invocation needs for all transfers leave some out of place, and that is told.
#[test]
fn what_one_invocation_did_not_get_to_is_told() {
    let Some(gpu) = gpu() else { return };
    let ctx = &gpu.ctx;
    let pipeline = Pipeline::<DefragmentSequential>::new(ctx, &()).unwrap();
    let case = Case {
        particles: 90_001,
        objects: 2,
        capacity: 90_001,
        share: 0.9,
        all_on: None,
        seed: 46,
    };
    for parts in [1, dispatches_of(2 * u64::from(case.capacity))] {
        let mut ring = Ring::new(case, Order::Sequential);
        ring.begin_turn(0);
        ring.move_border(0);
        ring.depart(0);
        let leaving = ring.flow.leaving;
        let flow = buffer(ctx, "flow", &[ring.flow]);
        let windows = buffer(ctx, "windows", &ring.windows);
        let departing = buffer(ctx, "departing", &ring.departing);
        let particles = buffer(ctx, "particles", &ring.particles);
        let motions = buffer(ctx, "motions", &ring.motions);
        let [inside, outside] =
            [&ring.particle_indices, &ring.transfer_indices].map(|list| buffer(ctx, "list", list));
        for part in 0..parts {
            gpu.run(|rec| {
                let args = DefragmentSequentialArgs {
                    flow: &flow,
                    windows: &windows,
                    departing: &departing,
                    particles: &words(&particles),
                    motions: &words(&motions),
                    particle_indices: &inside,
                    transfer_indices: &outside,
                };
                let first = ring.sequential_params(0);
                let params = DefragmentSequentialParams { part, ..first };
                rec.dispatch(&pipeline, Threads(1), args, params);
            });
        }
        ring.flow = ctx.download(&flow).unwrap()[0];
        let start = ring.windows[1].start;
        let departing = ctx.download(&departing).unwrap();
        let is_outside = |transfer: &&Transfer| {
            Window::offset(start, transfer.particle, case.particles) >= leaving
        };
        let left = departing[..leaving as usize].iter().filter(is_outside);
        let left = left.count() as u32;
        assert!(parts == 1 || left == 0, "{left} of {leaving}");
        let outside = ring.flow.outside;
        assert!(outside >= left, "{outside}, {left} of {leaving}");
        ring.move_border(1);
        let is_missed = u32::from(outside > 0);
        assert_eq!(ring.flow.mismatches, is_missed, "{left} of {leaving}");
    }
    gpu.finish();
}

/// Counters that have come to the largest number stay there, by kernel and twin alike.
#[test]
fn counters_of_turns_do_not_begin_anew() {
    let Some(gpu) = gpu() else { return };
    let ctx = &gpu.ctx;
    let case = Case {
        particles: 199,
        objects: 2,
        capacity: 16,
        share: 1.0,
        all_on: None,
        seed: 47,
    };
    for before in [0, u32::MAX - 100, u32::MAX - 3, u32::MAX] {
        let mut ring = Ring::new(case, Order::Scattered);
        ring.flow.selected = before;
        ring.flow.refused = before;
        ring.begin_turn(0);
        let (constants, params) = ring.border_params(0);
        let border = Pipeline::<MoveBorder>::new(ctx, &constants).unwrap();
        let flow = buffer(ctx, "flow", &[ring.flow]);
        let windows = buffer(ctx, "windows", &ring.windows);
        let groups = buffer(ctx, "groups", &ring.groups);
        let wanted = ring.flow.wanted;
        gpu.run(|rec| {
            let args = MoveBorderArgs {
                flow: &flow,
                windows: &windows,
                groups: &groups,
            };
            rec.dispatch(&border, Threads(1), args, params);
        });
        ring.move_border(0);
        assert_eq!(ctx.download(&flow).unwrap(), [ring.flow]);
        let expected = [wanted, wanted - 16].map(|more| before.saturating_add(more));
        assert!(wanted > 16);
        assert_eq!([ring.flow.selected, ring.flow.refused], expected);
    }
    gpu.finish();
}

/// Particles or motions, as kernels get at them.
fn words<T: bytemuck::Pod>(buffer: &Buffer<T>) -> Texels<u32> {
    Texels::new(buffer, 4).unwrap()
}

fn direction(words: [u32; 4]) -> Vec3 {
    let [a, b, c, _] = words.map(|word| 2.0 * unit(word) - 1.0);
    Vec3::new(a, b, c + 1e-3).normalize()
}

/// Transfers from anywhere in any direction; some of them right above the triangle, some with a normal against its.
fn transfers(count: u32, objects: u32) -> Vec<Transfer> {
    let transfer = |i| {
        let words = |k| random(83, i, k, Purpose::Start);
        let normal = direction(words(0));
        let heading = normal.cross(direction(words(1))).normalize();
        let target = words(2)[0] % objects;
        Transfer {
            position: direction(words(3)) * (0.1 + 2.0 * unit(words(2)[1])),
            particle: i,
            heading,
            source: (target + 1) % objects,
            normal,
            target,
            triangle: target,
            ..Transfer::default()
        }
    };
    (0..count).map(transfer).collect()
}

fn assert_same_places(what: &str, kernel: &[Particle], twin: &[Particle], bound: f32) {
    for (a, b) in kernel.iter().zip(twin) {
        assert_eq!((a.triangle, a.id), (b.triangle, b.id), "{what}");
        let off = (a.u - b.u).abs().max((a.v - b.v).abs());
        assert!(off <= bound, "{what}: {a:?} by the kernel, {b:?}");
    }
}

fn assert_same_headings(what: &str, kernel: &[Motion], twin: &[Motion], bound: f32) {
    for (a, b) in kernel.iter().zip(twin) {
        assert_eq!((a.flags, a.pending), (b.flags, b.pending), "{what}");
        let off = (a.heading_p - b.heading_p).abs() + (a.heading_h - b.heading_h).abs();
        assert!(off <= bound, "{what}: {a:?} by the kernel, {b:?}");
        assert!((a.heading_p.hypot(a.heading_h) - 1.0).abs() < 1e-6);
    }
}

#[test]
fn transfer_in_agrees_with_its_twin() {
    let Some(gpu) = gpu() else { return };
    let ctx = &gpu.ctx;
    let pipeline = Pipeline::<TransferIn>::new(ctx, &()).unwrap();
    let objects = Objects::new(4);
    let triangles = Texels::new(&buffer(ctx, "triangles", &objects.triangles), 4).unwrap();
    let corners = Texels::new(&buffer(ctx, "corners", &objects.corners), 1).unwrap();
    let vertices = words(&buffer(ctx, "vertices", &objects.vertices));
    let poses = Texels::new(&buffer(ctx, "poses", &objects.poses), 4).unwrap();
    for (count, object, arrived) in [
        (1, NONE, 5),
        (63, 2, 5),
        (64, NONE, 5),
        (65, 1, 5),
        (1021, 0, 5),
        // It is not counted any further.
        (1021, NONE, u32::MAX - 9),
    ] {
        let arriving = transfers(count, 4);
        let particle = |id| Particle {
            triangle: 3,
            u: 0.5,
            v: 0.25,
            id,
        };
        let before: Vec<Particle> = (0..count).map(particle).collect();
        let flying = Motion {
            heading_p: 0.6,
            heading_h: 0.8,
            pending: 0.125,
            flags: 7 << 1 | Motion::IN_FLIGHT,
        };
        let motions_before = vec![flying; count as usize];
        // Room for more than there are: the rest must not be looked at.
        let capacity = count + 9;
        let mut arriving_buffer = arriving.clone();
        arriving_buffer.resize(capacity as usize, transfers(1, 4)[0]);
        let mut flow = Flow {
            leaving: count,
            arrived,
            ..Flow::default()
        };
        let params = TransferInParams { object, capacity };
        let flow_buffer = buffer(ctx, "flow", &[flow]);
        let departing = Buffer::<Transfer>::zeroed(ctx, "departing", capacity as usize).unwrap();
        let particles = buffer(ctx, "particles", &before);
        let motions = buffer(ctx, "motions", &motions_before);
        gpu.run(|rec| {
            let args = TransferInArgs {
                arriving: &buffer(ctx, "arriving", &arriving_buffer),
                departing: &departing,
                flow: &flow_buffer,
                particles: &words(&particles),
                motions: &words(&motions),
                triangles: &triangles,
                corners: &corners,
                vertices: &vertices,
                poses: &poses,
            };
            rec.dispatch(&pipeline, Threads(capacity), args, params);
        });
        let (mut twin, mut twin_motions) = (before, motions_before);
        let mut twin_departing = vec![Transfer::default(); capacity as usize];
        transfer_in(
            &params,
            &objects.ground(),
            &arriving,
            &mut twin_departing,
            &mut flow,
            &mut twin,
            &mut twin_motions,
        );
        let what = format!("{count} transfers, object {object}");
        assert_eq!(ctx.download(&flow_buffer).unwrap(), [flow], "{what}");
        let landed = count - flow.passing;
        assert_eq!(flow.arrived, arrived.saturating_add(landed), "{what}");
        assert_same_places(&what, &ctx.download(&particles).unwrap(), &twin, 2e-4);
        assert_same_headings(&what, &ctx.download(&motions).unwrap(), &twin_motions, 2e-4);
        let mut by_kernel = ctx.download(&departing).unwrap();
        by_kernel[..flow.passing as usize].sort_by_key(|transfer| transfer.particle);
        assert_eq!(by_kernel, twin_departing, "{what}");
    }
    gpu.finish();
}
