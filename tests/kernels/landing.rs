//! Particles that have left their objects land: the kernel against its twin.

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec3};
use myxo::gpu::{Buffer, Context, Pipeline, Texels, Threads};
use myxo::mesh::surface::{Surface, Triangle};
use myxo::mesh::{Mesh, suite};
use myxo::rng::{Purpose, random, unit};
use myxo::sim::ground::Ground;
use myxo::sim::kernels::{TransferIn, TransferInArgs, TransferInConstants, TransferInParams};
use myxo::sim::twin::transfer::transfer_in;
use myxo::sim::types::{Border, Flow, Motion, Particle, Pose, Transfer, Vertex};

use crate::bits::assert_same_bits;
use crate::common::gpu;

fn buffer<T: bytemuck::Pod>(ctx: &Arc<Context>, name: &str, data: &[T]) -> Buffer<T> {
    Buffer::from_slice(ctx, name, data).unwrap()
}

/// Objects of one triangle each.
struct Objects {
    triangles: Vec<Triangle>,
    corners: Vec<u32>,
    vertices: Vec<Vertex>,
    poses: Vec<Pose>,
}

impl Objects {
    fn new(count: u32) -> Self {
        let meshes: Vec<Mesh> = (0..count).map(|_| suite::slivers()).collect();
        let pooled: Vec<(&Mesh, f32)> = meshes.iter().map(|mesh| (mesh, 1.0)).collect();
        let surface = Surface::build(&pooled);
        let first = |object: usize| surface.objects[object].triangles.0 as usize;
        let triangles = (0..count as usize).map(|object| surface.triangles[first(object)]);
        let corners = (0..count as usize).flat_map(|object| surface.corners[first(object)]);
        let object_of = |vertex: usize| {
            let inside = |range: &(u32, u32)| (range.0..range.1).contains(&(vertex as u32));
            let found = surface.objects.iter().position(|o| inside(&o.vertices));
            found.expect("every vertex has an object") as u32
        };
        let vertex = |(i, &position): (usize, &Vec3)| Vertex {
            position,
            object: object_of(i),
        };
        let pose = |object: u32| {
            let turn = Quat::from_rotation_y(object as f32) * Quat::from_rotation_x(0.5);
            let place = Vec3::new(0.3 * object as f32, 0.1, -0.2);
            Pose::from(Affine3A::from_rotation_translation(turn, place))
        };
        Self {
            triangles: triangles.collect(),
            corners: corners.collect(),
            vertices: surface.positions.iter().enumerate().map(vertex).collect(),
            poses: (0..count).map(pose).collect(),
        }
    }

    fn ground(&self) -> Ground<'_> {
        Ground {
            triangles: &self.triangles,
            corners: &self.corners,
            vertices: &self.vertices,
            poses: &self.poses,
        }
    }
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
            // Some fly back to where they are.
            source: (target + u32::from(i % 4 != 0)) % objects,
            normal,
            target,
            triangle: target,
            ..Transfer::default()
        }
    };
    (0..count).map(transfer).collect()
}

#[test]
fn transfer_in_agrees_with_its_twin() {
    let Some(gpu) = gpu() else { return };
    let ctx = &gpu.ctx;
    let objects = Objects::new(4);
    let triangles = Texels::new(&buffer(ctx, "triangles", &objects.triangles), 4).unwrap();
    let corners = Texels::new(&buffer(ctx, "corners", &objects.corners), 1).unwrap();
    let vertices = words(&buffer(ctx, "vertices", &objects.vertices));
    let poses = Texels::new(&buffer(ctx, "poses", &objects.poses), 4).unwrap();
    for (count, windows, arrived) in [
        (1, false, 5),
        (63, true, 5),
        (64, false, 5),
        (65, true, 5),
        (1021, true, 5),
        // It is not counted any further.
        (1021, false, u32::MAX - 9),
    ] {
        let constants = TransferInConstants { windows };
        let pipeline = Pipeline::<TransferIn>::new(ctx, &constants).unwrap();
        let landing = transfers(count, 4);
        let back = landing.iter().filter(|t| t.source == t.target).count() as u32;
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
            flags: 7 << Motion::FED_SHIFT | Motion::SELECTED,
        };
        let motions_before = vec![flying; count as usize];
        // Room for more than there are: the rest must not be looked at.
        let capacity = count + 9;
        let mut transfer_buffer = landing.clone();
        transfer_buffer.resize(capacity as usize, transfers(1, 4)[0]);
        let mut flow = Flow {
            leaving: count,
            arrived,
            ..Flow::default()
        };
        let params = TransferInParams { capacity };
        let flow_buffer = buffer(ctx, "flow", &[flow]);
        let mut borders = vec![Border::default(); 4];
        borders[2].came = 3;
        let border_buffer = buffer(ctx, "borders", &borders);
        let particles = buffer(ctx, "particles", &before);
        let motions = buffer(ctx, "motions", &motions_before);
        gpu.run(|rec| {
            let args = TransferInArgs {
                transfers: &buffer(ctx, "transfers", &transfer_buffer),
                borders: &border_buffer,
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
        transfer_in(
            &constants,
            &params,
            &objects.ground(),
            &landing,
            &mut borders,
            &mut flow,
            (&mut twin, &mut twin_motions),
        );
        let what = format!("{count} transfers, windows {windows}");
        assert_eq!(ctx.download(&flow_buffer).unwrap(), [flow], "{what}");
        assert_eq!(flow.arrived, arrived.saturating_add(count), "{what}");
        assert_eq!(ctx.download(&border_buffer).unwrap(), borders, "{what}");
        let came: u32 = borders.iter().map(|border| border.came).sum();
        assert_eq!(came, 3 + if windows { count - back } else { 0 }, "{what}");
        assert_same_bits(&what, &ctx.download(&particles).unwrap(), &twin);
        assert_same_bits(&what, &ctx.download(&motions).unwrap(), &twin_motions);
        for Motion {
            heading_p,
            heading_h,
            ..
        } in twin_motions
        {
            assert!((heading_p.hypot(heading_h) - 1.0).abs() < 1e-6, "{what}");
        }
    }
    gpu.finish();
}
