//! Targets of leaving particles: the kernels compared with their twins, and both with folds in closed form.

mod landing;
mod overtaken;
mod queries;
mod swept;
mod unfold;

use std::f64::consts::TAU;

use crate::bits::assert_same_bits;
use crate::common::{Gpu, gpu, scene_of_several};
use glam::{Affine3A, DAffine3, DQuat, DVec3};
use myxo::gpu::{Buffer, Pipeline, Texels, Threads};
use myxo::mesh::surface::NONE;
use myxo::rng::{Purpose, random, unit};
use myxo::scene::Scene;
use myxo::scene::settings::Settings;
use myxo::sim::crossing::Terrain;
use myxo::sim::ground::Ground;
use myxo::sim::kernels::{TransferOut, TransferOutArgs, TransferOutConstants, TransferOutParams};
use myxo::sim::paint::NO_GO;
use myxo::sim::texel_paths::TexelPaths;
use myxo::sim::twin::transfer::transfer_out;
use myxo::sim::types::{Flow, Motion, Particle, Physarum, Pose, Transfer};
use myxo::sim::{Setup, Texture, twin};

/// Objects that reach into one another, an open one among them.
fn scene(meshes: &[(&str, [f32; 3])], change: impl FnOnce(&mut Settings)) -> Scene {
    scene_of_several(meshes, |settings| {
        settings.particles.count = 1021;
        settings.atlas.size = 128;
        settings.distance.reach = 0.5;
        change(settings);
    })
}

fn pose(world_from_object: DAffine3) -> Pose {
    let columns = world_from_object.to_cols_array().map(|x| x as f32);
    Pose::from(Affine3A::from_cols_array(&columns))
}

/// What `transfer_out` is asked.
#[derive(Clone, Copy)]
struct Case<'a> {
    setup: &'a Setup,
    poses: &'a [Pose],
    poses_before: &'a [Pose],
    nearest: &'a [u32],
    particles: &'a [Particle],
    motions: &'a [Motion],
    physarums: &'a [Physarum],
    /// One per texel, where something is painted.
    bias: &'a [f32],
    looks: &'a [f32],
    constants: TransferOutConstants,
    /// What every counter holds before.
    counted: u32,
}

impl Case<'_> {
    fn flow(&self) -> Flow {
        Flow {
            leaving: self.particles.len() as u32,
            crossed: self.counted,
            ..Flow::default()
        }
    }

    /// Every particle leaves, the last one first.
    fn particle_indices(&self) -> Vec<u32> {
        (0..self.particles.len() as u32).rev().collect()
    }

    fn flux(&self) -> Vec<u32> {
        vec![self.counted; self.poses.len().pow(2)]
    }

    fn params(&self) -> TransferOutParams {
        TransferOutParams {
            capacity: self.particles.len() as u32 + 3,
            pitch: self.setup.atlas.pitch,
            object_count: self.poses.len() as u32,
            attempts: 10,
            first_vertex_normal: self.setup.surface.halfedges.len() as u32,
            second_look: self.poses.len() as u32,
        }
    }

    /// What leaves, the flux, and how many have crossed.
    fn by_kernel(&self, gpu: &Gpu) -> (Vec<Transfer>, Vec<u32>, u32) {
        let ctx = &gpu.ctx;
        let pipeline = Pipeline::<TransferOut>::new(ctx, &self.constants).unwrap();
        let (surface, trees) = (&self.setup.surface, &self.setup.distance.trees);
        let view = |name: &str, words: &[u32], components| {
            Texels::new(&Buffer::from_slice(ctx, name, words).unwrap(), components).unwrap()
        };
        let texels = |name: &str, words: &[u32]| view(name, words, 4);
        let poses = |name: &str, poses: &[Pose]| {
            Texels::new(&Buffer::from_slice(ctx, name, poses).unwrap(), 4).unwrap()
        };
        let params = self.params();
        let transfers =
            Buffer::<Transfer>::zeroed(ctx, "transfers", params.capacity as usize).unwrap();
        let flux = Buffer::from_slice(ctx, "flux", &self.flux()).unwrap();
        let uploaded = (
            Buffer::from_slice(ctx, "flow", &[self.flow()]).unwrap(),
            Buffer::from_slice(ctx, "particle_indices", &self.particle_indices()).unwrap(),
            texels("particles", bytemuck::cast_slice(self.particles)),
            texels("motions", bytemuck::cast_slice(self.motions)),
            view("nearest", self.nearest, 1),
            texels("strips", bytemuck::cast_slice(&self.setup.strips)),
            view("corners", &self.setup.corners, 1),
            texels("vertices", bytemuck::cast_slice(&self.setup.vertices)),
            poses("poses", self.poses),
            Buffer::from_slice(ctx, "physarums", self.physarums).unwrap(),
            Buffer::from_slice(ctx, "roots", &self.setup.distance.roots()).unwrap(),
            poses("poses_before", self.poses_before),
        );
        let painted = |name: &str, values: &[f32]| {
            (!values.is_empty()).then(|| {
                let buffer = Buffer::from_slice(ctx, name, values).unwrap();
                Texture::new(ctx, buffer).unwrap()
            })
        };
        let (bias, looks) = (painted("bias", self.bias), painted("looks", self.looks));
        gpu.run(|rec| {
            let args = TransferOutArgs {
                flow: &uploaded.0,
                particle_indices: &uploaded.1,
                particles: &uploaded.2,
                motions: &uploaded.3,
                nearest: &uploaded.4,
                strips: &uploaded.5,
                transfers: &transfers,
                flux: &flux,
                triangles: &texels("triangles", bytemuck::cast_slice(&surface.triangles)),
                halfedges: &texels("halfedges", bytemuck::cast_slice(&surface.halfedges)),
                corners: &uploaded.6,
                vertices: &uploaded.7,
                poses: &uploaded.8,
                physarums: &uploaded.9,
                roots: &uploaded.10,
                nodes: &texels("nodes", bytemuck::cast_slice(&trees.nodes)),
                faces: &texels("faces", bytemuck::cast_slice(&trees.faces)),
                pseudonormals: &texels("pseudonormals", bytemuck::cast_slice(&trees.pseudonormals)),
                dipoles: &texels("dipoles", bytemuck::cast_slice(&trees.dipoles)),
                poses_before: &uploaded.11,
                bias: bias.as_ref(),
                looks: looks.as_ref(),
            };
            rec.dispatch(&pipeline, Threads(params.capacity), args, params);
        });
        (
            ctx.download(&transfers).unwrap(),
            ctx.download(&flux).unwrap(),
            ctx.download(&uploaded.0).unwrap()[0].crossed,
        )
    }

    fn by_twin(&self) -> (Vec<Transfer>, Vec<u32>, u32) {
        let mut flow = self.flow();
        let params = self.params();
        let mut transfers = vec![Transfer::default(); params.capacity as usize];
        let mut flux = self.flux();
        let roots = self.setup.distance.roots();
        let constants = &self.constants;
        transfer_out(
            constants,
            &params,
            &Terrain::of(
                self.setup,
                self.poses,
                &roots,
                constants.sign_rule,
                constants.border_reflects,
            ),
            self.poses_before,
            &mut flow,
            &self.particle_indices(),
            self.particles,
            self.motions,
            self.physarums,
            self.nearest,
            &self.setup.atlas.maps,
            (self.bias, self.looks),
            &mut transfers,
            &mut flux,
        );
        (transfers, flux, flow.crossed)
    }
}

fn word(particle: usize, k: usize) -> f32 {
    unit(random(6, particle as u32, 0, Purpose::Start)[k])
}

fn heading(turn: f32, pending: f32) -> Motion {
    let (heading_h, heading_p) = (turn * TAU as f32).sin_cos();
    Motion {
        heading_p,
        heading_h,
        pending,
        flags: Motion::SELECTED,
    }
}

/// Particles that do nothing but go so far.
fn of_speed(speed: f32) -> Physarum {
    Physarum {
        speed,
        attempts: 10,
        ..bytemuck::Zeroable::zeroed()
    }
}

/// Random particles of which many have just gone into another object.
#[test]
fn transfer_out_agrees_with_its_twin() {
    let Some(gpu) = gpu() else { return };
    let meshes = [
        ("torus?major=12&minor=8", [0.0; 3]),
        ("icosphere?subdivisions=2", [0.5, 0.3, 0.1]),
        ("plane?columns=4&rows=3", [0.1, -0.1, 0.0]),
    ];
    let mut scene = scene(&meshes, |_| ());
    let (mut crossed, mut all, mut back) = (0, 0, 0);
    for (count, sign_rule, own_physarum, painted) in [
        (1, 0, false, false),
        (63, 1, true, true),
        (64, 2, false, false),
        (1021, 0, true, false),
        (1021, 1, false, false),
        (1021, 0, false, true),
        (1021, 2, true, false),
    ] {
        scene.settings.particles.count = count;
        let setup = Setup::new(&scene).unwrap();
        let mut twin = twin::Simulation::new(setup.clone(), scene.settings.clone());
        twin.step();
        let nearest = twin.distances().1.to_vec();
        let motions: Vec<Motion> = (0..count as usize)
            .map(|i| heading(word(i, 0), 0.05 * (word(i, 1) - 0.8).max(0.0)))
            .collect();
        let mut physarums = [0.2, 0.1, 0.3, 0.25].map(of_speed);
        physarums[1].attempts = 2;
        physarums[2].attempts = 5;
        if own_physarum && sign_rule == 2 {
            // Long steps over many edges, with few attempts to cross them, other ones on each object.
            physarums = [0.8, 0.6, 0.9, 0.25].map(of_speed);
            for (physarum, attempts) in physarums.iter_mut().zip([3, 1, 2]) {
                physarum.attempts = attempts;
            }
        }
        // In some of the cases objects have moved in the step.
        let turn = if sign_rule == 0 { 0.0 } else { 0.1 };
        let objects = scene.settings.objects.iter().zip([0.0, turn, -turn]);
        let poses_before: Vec<Pose> = objects
            .map(|(object, turn)| Affine3A::from_rotation_y(turn) * object.world_from_object())
            .map(Pose::from)
            .collect();
        // Squares of 5 x 5 texels, of which every other one may not be entered.
        let bias: Vec<f32> = (0..setup.atlas.texel_count() as u32)
            .map(|texel| (texel % setup.atlas.pitch / 5, texel / setup.atlas.pitch / 5))
            .map(|(x, y)| if (x + y) % 2 == 0 { NO_GO } else { 7.0 })
            .collect();
        let looks: Vec<f32> = bias
            .iter()
            .map(|&bias| if bias == NO_GO { 0.25 } else { 1.0 })
            .collect();
        let case = Case {
            setup: &setup,
            poses: &setup.poses,
            poses_before: &poses_before,
            bias: &bias,
            looks: &looks,
            nearest: &nearest,
            particles: &setup.particles,
            motions: &motions,
            physarums: &physarums,
            constants: TransferOutConstants {
                border_reflects: count % 2 == 1,
                sign_rule,
                own_physarum,
                painted,
                looks: painted,
                paths: TexelPaths::default(),
            },
            counted: 0,
        };
        let (kernel, flux, kernel_crossed) = case.by_kernel(&gpu);
        let (twin, twin_flux, twin_crossed) = case.by_twin();
        let what = format!("{count} particles, rule {sign_rule}, painted {painted}");
        assert_same_bits(&what, &kernel, &twin);
        assert_eq!(
            (&flux, kernel_crossed),
            (&twin_flux, twin_crossed),
            "{what}"
        );
        assert_eq!(flux.iter().sum::<u32>(), count);
        // The same case with nothing painted.
        let mut free = Case { counted: 0, ..case };
        free.constants.painted = false;
        let (free, ..) = free.by_twin();
        let turned = |(t, freely): &(&Transfer, &Transfer)| {
            t.target == t.source && freely.target != freely.source
        };
        back += twin.iter().zip(&free).filter(turned).count();
        if !painted {
            crossed += kernel_crossed;
            all += count;
        }

        // Counters that come to the largest number stay there.
        let counted = u32::MAX - 2;
        let (_, more_flux, kernel_crossed) = Case { counted, ..case }.by_kernel(&gpu);
        let summed = flux.iter().map(|more| counted.saturating_add(*more));
        assert_eq!(more_flux, summed.collect::<Vec<_>>());
        if twin_crossed > 10 {
            assert_eq!(kernel_crossed, u32::MAX);
        }
    }
    // Both ways out of the kernel were taken.
    assert!(
        crossed > all / 20 && crossed < all - all / 20,
        "{crossed} of {all}"
    );
    // And particles from outside of no-go areas went back.
    assert!(back > 50, "{back}");
    gpu.finish();
}

/// Two planes that cross at an angle, somewhere in the world: a particle that has gone through the other one is folded
/// about the line, and continues on the side that the first plane's normal points to.
#[test]
fn particles_go_on_as_the_fold_says() {
    let Some(gpu) = gpu() else { return };
    let meshes = [
        ("plane?columns=3&rows=2", [0.0; 3]),
        ("plane?columns=5&rows=7", [0.0; 3]),
    ];
    let scene = scene(&meshes, |s| s.particles.count = 400);
    let setup = Setup::new(&scene).unwrap();
    let scale = f64::from(setup.surface.positions[0].abs().max_element());
    let anywhere = DAffine3::from_rotation_translation(
        DQuat::from_axis_angle(DVec3::new(1.0, -2.0, 0.5).normalize(), 2.2),
        DVec3::new(0.7, -0.3, 1.9),
    );
    let ground_poses = [pose(anywhere); 2];
    let ground = Ground::of(&setup, &ground_poses);
    let speed = 0.4 * scale;
    for angle in [30.0_f64, 60.0, 90.0, 120.0, 150.0, 3.0] {
        // The planes lie in X and Z of their own spaces; the line is the axis that one is turned about.
        let turn = DQuat::from_axis_angle(DVec3::new(0.8, 0.0, -0.6), angle.to_radians());
        let world_from_other = anywhere * DAffine3::from_quat(turn);
        let poses = [pose(anywhere), pose(world_from_other)];
        let line = anywhere.matrix3 * DVec3::new(0.8, 0.0, -0.6);
        let origin = anywhere.translation;
        let own_normal = anywhere.matrix3 * DVec3::Y;
        let up = (world_from_other.matrix3 * DVec3::Y).cross(line);
        let up = up * up.dot(own_normal).signum();
        let first = setup.surface.objects[1].triangles.0;
        let nearest = vec![first; setup.atlas.texel_count()];
        let on_first: Vec<Particle> = setup
            .particles
            .iter()
            .copied()
            .filter(|p| p.triangle < first)
            .collect();
        let motions: Vec<Motion> = (0..on_first.len())
            .map(|i| heading(word(i, 2), 0.0))
            .collect();
        let physarums = [of_speed(speed as f32); 2];
        let case = Case {
            setup: &setup,
            poses: &poses,
            poses_before: &poses,
            nearest: &nearest,
            particles: &on_first,
            motions: &motions,
            physarums: &physarums,
            bias: &[],
            looks: &[],
            constants: TransferOutConstants {
                border_reflects: true,
                sign_rule: 0,
                own_physarum: false,
                painted: false,
                looks: false,
                paths: TexelPaths::default(),
            },
            counted: 0,
        };
        let (transfers, flux, crossed) = case.by_kernel(&gpu);
        assert_eq!(flux, [0, on_first.len() as u32, 0, 0]);
        let mut folded = 0;
        for transfer in &transfers[..on_first.len()] {
            let slot = transfer.particle as usize;
            let start = ground.flight(&on_first[slot], &motions[slot]);
            let (place, way) = (start.position.as_dvec3(), start.heading.as_dvec3());
            // How far behind it the line is, along its way.
            let across = line.cross(own_normal);
            let rest = (place - origin).dot(across) / way.dot(across);
            let before = place - speed * way;
            let object_place = |p: DVec3| anywhere.inverse().transform_point3(p).abs();
            let is_on_plane = |p: DVec3| object_place(p).max_element() < 0.98 * scale;
            let crossing = place - rest * way;
            let along = way.dot(line);
            let out = along * line + (1.0 - along * along).sqrt() * up;
            let end = crossing + rest * out;
            if !(rest > 1e-3 && rest < 0.99 * speed && [before, end].into_iter().all(is_on_plane)) {
                continue;
            }
            folded += 1;
            assert!(setup.surface.triangles[transfer.triangle as usize].object == 1);
            let off = transfer.position.as_dvec3().distance(end) / scale;
            assert!(off < 1e-5, "{angle} degrees: {off}: {transfer:?}");
            let turned = transfer.heading.as_dvec3().angle_between(out).to_degrees();
            assert!(turned < 0.01, "{angle} degrees: {turned}");
        }
        assert!(
            folded > 10 && crossed >= folded,
            "{angle} degrees: {folded}, {crossed}"
        );
    }
    gpu.finish();
}

/// One that has no triangle near comes back to where it is, and one that met nothing goes to the nearest point.
#[test]
fn particles_without_a_crossing_go_to_the_nearest_point() {
    let Some(gpu) = gpu() else { return };
    let meshes = [
        ("plane?columns=3&rows=2", [0.0; 3]),
        ("icosphere?subdivisions=3", [0.0; 3]),
    ];
    let scene = scene(&meshes, |s| s.particles.count = 200);
    let setup = Setup::new(&scene).unwrap();
    let first = setup.surface.objects[1].triangles.0;
    let particles: Vec<Particle> = setup
        .particles
        .iter()
        .copied()
        .filter(|p| p.triangle < first)
        .collect();
    let motions: Vec<Motion> = (0..particles.len())
        .map(|i| heading(word(i, 0), 0.0))
        .collect();
    let far = DAffine3::from_translation(DVec3::new(0.0, 30.0, 0.0));
    let poses = [pose(DAffine3::IDENTITY), pose(far)];
    for known in [true, false] {
        let nearest = vec![if known { first } else { NONE }; setup.atlas.texel_count()];
        let case = Case {
            setup: &setup,
            poses: &poses,
            poses_before: &poses,
            nearest: &nearest,
            particles: &particles,
            motions: &motions,
            physarums: &[of_speed(0.1); 2],
            bias: &[],
            looks: &[],
            constants: TransferOutConstants {
                border_reflects: true,
                sign_rule: 0,
                own_physarum: false,
                painted: false,
                looks: false,
                paths: TexelPaths::default(),
            },
            counted: 0,
        };
        let (transfers, flux, crossed) = case.by_kernel(&gpu);
        assert_eq!(crossed, 0);
        let ground = Ground::of(&setup, &poses);
        let count = particles.len() as u32;
        assert_eq!(
            flux,
            if known {
                [0, count, 0, 0]
            } else {
                [count, 0, 0, 0]
            }
        );
        for transfer in &transfers[..particles.len()] {
            let slot = transfer.particle as usize;
            let start = ground.flight(&particles[slot], &motions[slot]);
            assert!(transfer.position.distance(start.position) < 1e-6);
            assert!(transfer.heading.distance(start.heading) < 1e-6);
            if known {
                // From below, the way to the ball goes to its middle.
                let (uv, _) = ground.landing(transfer.triangle, &start);
                let landed = Particle {
                    triangle: transfer.triangle,
                    u: uv[0],
                    v: uv[1],
                    id: 0,
                };
                let place = ground.flight(&landed, &motions[slot]).position.as_dvec3();
                let way = start.position.as_dvec3() - far.translation;
                let expected = far.translation + way.normalize() * 0.998;
                assert!(place.distance(expected) < 0.05, "{place} {expected}");
            } else {
                assert_eq!(transfer.triangle, particles[slot].triangle);
            }
        }
    }
    gpu.finish();
}
