//! The kernels of the ring against their twins.

use std::sync::Arc;

use glam::Vec3;
use myxo::gpu::{Access, AnyBuffer, Buffer, Context, Pipeline, Texels, Threads};
use myxo::mesh::surface::NONE;
use myxo::rng::{Purpose, random, unit};
use myxo::sim::kernels::{
    DefragmentScan, DefragmentScanArgs, DefragmentSequential, DefragmentSequentialArgs,
    DefragmentSwap, DefragmentSwapArgs, MoveBorder, MoveBorderArgs, TransferIn, TransferInArgs,
    TransferInParams, TransferOut, TransferOutArgs, TransferOutParams,
};
use myxo::sim::twin::transfer::{transfer_in, transfer_out};
use myxo::sim::types::{Flow, Motion, Particle, Transfer};

use crate::common::gpu;
use crate::model::{Case, Objects, Order, Ring};

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
                    let particles = buffer(ctx, "particles", &ring.particles);
                    let motions = buffer(ctx, "motions", &ring.motions);
                    if order == Order::Sequential {
                        gpu.run(|rec| {
                            let args = DefragmentSequentialArgs {
                                flow: &flow,
                                windows: &windows,
                                departing: &departing,
                                particles: &particles,
                                motions: &motions,
                            };
                            let params = ring.sequential_params(object);
                            rec.dispatch(&one_pass, Threads(1), args, params);
                        });
                        ring.sequential(object);
                        assert_eq!(ctx.download(&particles).unwrap(), ring.particles);
                        assert_eq!(ctx.download(&motions).unwrap(), ring.motions);
                        assert_eq!(ctx.download(&departing).unwrap(), ring.departing);
                    } else {
                        let inside = buffer(ctx, "particle_indices", &ring.particle_indices);
                        let outside = buffer(ctx, "transfer_indices", &ring.transfer_indices);
                        gpu.run(|rec| {
                            let args = DefragmentScanArgs {
                                departing: &departing,
                                motions: &motions,
                                windows: &windows,
                                flow: &flow,
                                particle_indices: &inside,
                                transfer_indices: &outside,
                            };
                            let threads = Threads(capacity);
                            rec.dispatch(&scan, threads, args, ring.scan_params(object));
                            let next: [&dyn AnyBuffer; 2] = [&departing, &motions];
                            rec.barrier(Access::Kernel, Access::Kernel, &next);
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
                                particles: &particles,
                                motions: &motions,
                            };
                            rec.dispatch(&swap, Threads(capacity), args, ring.swap_params());
                        });
                        ring.swap();
                        assert_eq!(ctx.download(&particles).unwrap(), ring.particles);
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
    let corners = buffer(ctx, "corners", &objects.corners);
    let vertices = buffer(ctx, "vertices", &objects.vertices);
    let poses = buffer(ctx, "poses", &objects.poses);
    for (count, object) in [(1, NONE), (63, 2), (64, NONE), (65, 1), (1021, 0)] {
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
            arrived: 5,
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
                particles: &particles,
                motions: &motions,
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
        assert_eq!(flow.arrived + flow.passing, 5 + count, "{what}");
        assert_same_places(&what, &ctx.download(&particles).unwrap(), &twin, 2e-4);
        assert_same_headings(&what, &ctx.download(&motions).unwrap(), &twin_motions, 2e-4);
        let mut by_kernel = ctx.download(&departing).unwrap();
        by_kernel[..flow.passing as usize].sort_by_key(|transfer| transfer.particle);
        assert_eq!(by_kernel, twin_departing, "{what}");
    }
    gpu.finish();
}

#[test]
fn transfer_out_agrees_with_its_twin() {
    let Some(gpu) = gpu() else { return };
    let ctx = &gpu.ctx;
    let pipeline = Pipeline::<TransferOut>::new(ctx, &()).unwrap();
    let objects = Objects::new(4);
    let pitch = 16;
    let texels = pitch * 20;
    // Half of the texels know no triangle, whole neighbourhoods among them.
    let nearest: Vec<u32> = (0..texels)
        .map(|i| random(5, i / 2, 0, Purpose::Start)[0])
        .map(|word| if word % 2 == 0 { NONE } else { word % 4 })
        .collect();
    let atlas_maps: Vec<_> = (0..4)
        .map(|i| myxo::mesh::surface::AtlasMap {
            origin: glam::Vec2::new(1.0 + i as f32, 2.0),
            du: glam::Vec2::new(9.0, 1.0),
            dv: glam::Vec2::new(-0.4, 15.0),
        })
        .collect();
    for (count, carried) in [(1, 0), (63, 10), (64, 64), (1021, 3)] {
        let word = |i, k: usize| unit(random(6, i, 0, Purpose::Start)[k]);
        let particles: Vec<Particle> = (0..count)
            .map(|id| Particle {
                triangle: id % 4,
                u: word(id, 0),
                v: (1.0 - word(id, 0)) * word(id, 1),
                id,
            })
            .collect();
        let motion = |id| {
            let (heading_h, heading_p) = (7.0 * word(id, 2)).sin_cos();
            let flags = Motion::IN_FLIGHT;
            Motion {
                heading_p,
                heading_h,
                pending: 0.0,
                flags,
            }
        };
        let motions: Vec<Motion> = (0..count).map(motion).collect();
        let particle_indices: Vec<u32> = (0..count).rev().collect();
        let flow = Flow {
            leaving: count,
            carried,
            ..Flow::default()
        };
        let params = TransferOutParams {
            capacity: count + 3,
            pitch,
            object_count: 4,
        };
        let departing = Buffer::<Transfer>::zeroed(ctx, "departing", count as usize + 3).unwrap();
        let flux = Buffer::<u32>::zeroed(ctx, "flux", 16).unwrap();
        gpu.run(|rec| {
            let args = TransferOutArgs {
                flow: &buffer(ctx, "flow", &[flow]),
                particle_indices: &buffer(ctx, "particle_indices", &particle_indices),
                particles: &buffer(ctx, "particles", &particles),
                motions: &buffer(ctx, "motions", &motions),
                nearest: &buffer(ctx, "nearest", &nearest),
                atlas_maps: &buffer(ctx, "atlas_maps", &atlas_maps),
                departing: &departing,
                flux: &flux,
                triangles: &Texels::new(&buffer(ctx, "triangles", &objects.triangles), 4).unwrap(),
                corners: &buffer(ctx, "corners", &objects.corners),
                vertices: &buffer(ctx, "vertices", &objects.vertices),
                poses: &buffer(ctx, "poses", &objects.poses),
            };
            rec.dispatch(&pipeline, Threads(count + 3), args, params);
        });
        let mut twin = vec![Transfer::default(); count as usize + 3];
        let mut twin_flux = vec![0; 16];
        transfer_out(
            &params,
            &objects.ground(),
            &flow,
            &particle_indices,
            &particles,
            &motions,
            &nearest,
            &atlas_maps,
            &mut twin,
            &mut twin_flux,
        );
        assert_eq!(ctx.download(&flux).unwrap(), twin_flux);
        assert_eq!(twin_flux.iter().sum::<u32>(), count - carried);
        let mut elsewhere = 0;
        for (a, b) in ctx.download(&departing).unwrap().iter().zip(&twin) {
            if a.triangle != b.triangle {
                elsewhere += 1;
                continue;
            }
            let whole = |t: &Transfer| (t.particle, t.source, t.target);
            assert_eq!(whole(a), whole(b));
            for (x, y) in [
                (a.position, b.position),
                (a.heading, b.heading),
                (a.normal, b.normal),
            ] {
                assert!(x.distance(y) < 1e-5, "{a:?} by the kernel, {b:?}");
            }
        }
        assert!(elsewhere * 100 <= count, "{elsewhere} of {count}");
    }
    gpu.finish();
}
