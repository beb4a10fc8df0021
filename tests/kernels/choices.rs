//! Kernels that do in another way what parts of a step do, against their twins, and against each other.

use std::sync::Arc;

use crate::common::{Gpu, awkward_sizes, gpu, scene};
use glam::{DVec2, Vec2, Vec4};
use myxo::gpu::{
    Blend, Buffer, Context, DepthTest, Domain, Format, Image, Pipeline, RasterOptions,
    RasterPipeline, Sampled, Targets, Texels, Threads, Topology,
};
use myxo::mesh::walk::{BorderRule, SurfacePoint, walk};
use myxo::rng::{Purpose, random, unit};
use myxo::sim::Setup;
use myxo::sim::behaviour::physarums;
use myxo::sim::choices::draws::{DrawDepositsArgs, DrawDepositsDraw, DrawDepositsParams};
use myxo::sim::choices::kernels::*;
use myxo::sim::choices::{sensor_places, turning_strips};
use myxo::sim::plan::{Means, Plan};
use myxo::sim::step::advance::Form;
use myxo::sim::twin::choices as twin;
use myxo::sim::types::{Motion, Particle};

fn texels<T: bytemuck::Pod>(ctx: &Arc<Context>, name: &str, data: &[T]) -> Texels<u32> {
    let buffer = Buffer::from_slice_in(ctx, name, data, Domain::Texels).unwrap();
    Texels::new(&buffer, 4).unwrap()
}

/// Particles at their start, some of them with way pending.
fn start(mesh: &str, count: u32) -> Setup {
    let scene = scene(mesh, |settings| settings.particles.count = count.max(1));
    let mut setup = Setup::new(&scene).unwrap();
    setup.particles.truncate(count as usize);
    setup.motions.truncate(count as usize);
    for (i, motion) in setup.motions.iter_mut().enumerate() {
        motion.pending = [0.0, 0.013][i % 2];
    }
    setup
}

/// Runs `walk` on the device and gives what it leaves.
fn walked(
    gpu: &Gpu,
    setup: &Setup,
    walk: impl FnOnce(&mut myxo::gpu::Recorder, [&Texels<u32>; 4]),
) -> (Vec<Particle>, Vec<Motion>) {
    let from = [
        texels(&gpu.ctx, "particles_before", &setup.particles),
        texels(&gpu.ctx, "motions_before", &setup.motions),
    ];
    let len = setup.particles.len();
    let particles =
        Buffer::<Particle>::zeroed_in(&gpu.ctx, "particles", len, Domain::Texels).unwrap();
    let motions = Buffer::<Motion>::zeroed_in(&gpu.ctx, "motions", len, Domain::Texels).unwrap();
    let to = [
        Texels::new(&particles, 4).unwrap(),
        Texels::new(&motions, 4).unwrap(),
    ];
    gpu.run(|rec| walk(rec, [&from[0], &from[1], &to[0], &to[1]]));
    let particles = gpu.ctx.download(&particles).unwrap();
    (particles, gpu.ctx.download(&motions).unwrap())
}

/// Nearly all are where the twin has them; on an edge, the last bit decides the triangle.
fn compare(what: &str, kernel: &(Vec<Particle>, Vec<Motion>), twin: &(Vec<Particle>, Vec<Motion>)) {
    let mut elsewhere = 0;
    for i in 0..twin.0.len() {
        let (a, b) = (&kernel.0[i], &twin.0[i]);
        let (m, n) = (&kernel.1[i], &twin.1[i]);
        assert_eq!((a.id, m.flags), (b.id, n.flags), "{what}");
        if a.triangle != b.triangle {
            elsewhere += 1;
            continue;
        }
        for (x, y) in [
            (a.u, b.u),
            (a.v, b.v),
            (m.heading_p, n.heading_p),
            (m.heading_h, n.heading_h),
            (m.pending, n.pending),
        ] {
            assert!(
                (x - y).abs() < 5e-4,
                "{what}, {i}: {a:?} {m:?}\n{b:?} {n:?}"
            );
        }
    }
    assert!(elsewhere * 100 <= twin.0.len(), "{what}: {elsewhere}");
}

#[test]
fn walks_agree_with_their_twins() {
    let Some(gpu) = gpu() else { return };
    let exactly = Pipeline::<WalkExactly>::new(&gpu.ctx, &()).unwrap();
    let corrected = Pipeline::<WalkCorrected>::new(&gpu.ctx, &()).unwrap();
    for mesh in [
        "builtin:torus?major=24&minor=16",
        "builtin:plane?columns=5&rows=4",
    ] {
        for count in awkward_sizes(64) {
            let setup = start(mesh, count);
            let strips = texels(&gpu.ctx, "strips", &setup.strips);
            let turning = turning_strips(&setup.surface, &setup.strips);
            let turning_texels = texels(&gpu.ctx, "turning", &turning);
            for (attempts, way) in [(10, 0.3), (1, 0.3), (0, 0.3), (10, 0.01)] {
                let what = format!("{mesh}, {count}, {attempts} attempts, {way}");
                let params = WalkExactlyParams {
                    particle_count: count,
                    attempts,
                    way,
                };
                let kernel = walked(
                    &gpu,
                    &setup,
                    |rec, [before, motions_before, to, motions]| {
                        let args = WalkExactlyArgs {
                            particles_before: before,
                            motions_before,
                            strips: &strips,
                            particles: to,
                            motions,
                        };
                        rec.dispatch(&exactly, Threads(count), args, params);
                    },
                );
                let mut own = (setup.particles.clone(), setup.motions.clone());
                twin::walk_exactly(&params, &setup.strips, &mut own.0, &mut own.1);
                compare(&format!("exactly: {what}"), &kernel, &own);

                let params = WalkCorrectedParams {
                    particle_count: count,
                    attempts,
                    way,
                };
                let kernel = walked(
                    &gpu,
                    &setup,
                    |rec, [before, motions_before, to, motions]| {
                        let args = WalkCorrectedArgs {
                            particles_before: before,
                            motions_before,
                            strips: &turning_texels,
                            particles: to,
                            motions,
                        };
                        rec.dispatch(&corrected, Threads(count), args, params);
                    },
                );
                let mut own = (setup.particles.clone(), setup.motions.clone());
                twin::walk_corrected(&params, &turning, &mut own.0, &mut own.1);
                compare(&format!("corrected: {what}"), &kernel, &own);
            }
        }
    }
    gpu.finish();
}

/// The exact test ends where a walk in double precision does. Correcting afterwards is off where the path passes corners, and is
/// exact where it ends within the first triangle or behind one edge in the plane.
#[test]
fn walks_that_are_corrected_are_off_at_corners_only() {
    let setup = start("builtin:torus?major=24&minor=16", 3000);
    let turning = turning_strips(&setup.surface, &setup.strips);
    let way = 0.3;
    let place = |triangle: u32, u: f64, v: f64| {
        let corners = setup.surface.corners[triangle as usize];
        let [a, b, c] = corners.map(|i| setup.surface.positions[i as usize].as_dvec3());
        a + u * (b - a) + v * (c - a)
    };
    let errors = |particles: &[Particle]| -> Vec<f64> {
        let off = |(i, end): (usize, &Particle)| {
            let (from, motion) = (&setup.particles[i], &setup.motions[i]);
            let start = SurfacePoint {
                triangle: from.triangle,
                u: from.u.into(),
                v: from.v.into(),
            };
            let heading = DVec2::new(motion.heading_p.into(), motion.heading_h.into());
            let whole = f64::from(way) + f64::from(motion.pending);
            let rule = BorderRule::Reflect;
            let end_in_double = walk(
                &setup.surface,
                start,
                heading.normalize(),
                whole,
                None,
                rule,
            );
            let point = end_in_double.point;
            let reference = place(point.triangle, point.u, point.v);
            reference.distance(place(end.triangle, end.u.into(), end.v.into())) / whole
        };
        let mut errors: Vec<f64> = particles.iter().enumerate().map(off).collect();
        errors.sort_by(f64::total_cmp);
        errors
    };
    let count = setup.particles.len() as u32;
    let mut exact = (setup.particles.clone(), setup.motions.clone());
    let params = WalkExactlyParams {
        particle_count: count,
        attempts: 20,
        way,
    };
    twin::walk_exactly(&params, &setup.strips, &mut exact.0, &mut exact.1);
    let exact = errors(&exact.0);
    assert!(exact[2850] < 1e-5, "{}", exact[2850]);
    let corrected = |attempts| {
        let mut own = (setup.particles.clone(), setup.motions.clone());
        let params = WalkCorrectedParams {
            particle_count: count,
            attempts,
            way,
        };
        twin::walk_corrected(&params, &turning, &mut own.0, &mut own.1);
        for particle in &own.0 {
            assert!(particle.u >= 0.0 && particle.v >= 0.0 && particle.u + particle.v < 1.00001);
        }
        errors(&own.0)
    };
    let [often, once] = [corrected(20), corrected(1)];
    println!(
        "off: {} {} {}; {} {} {}",
        often[1500], often[2850], often[2999], once[1500], once[2850], once[2999]
    );
    assert!(often[100] < 1e-5 && often[2850] > 1e-3, "{often:?}");
    assert!(
        once[2850] > often[2850],
        "{} and {}",
        once[2850],
        often[2850]
    );
}

#[test]
fn counts_are_those_of_the_twin_however_particles_crowd() {
    let Some(gpu) = gpu() else { return };
    let ctx = &gpu.ctx;
    let count = Pipeline::<CountDeposits>::new(ctx, &()).unwrap();
    let options = RasterOptions {
        color: Format::R32Float,
        depth: false,
        blend: Blend::Add,
        topology: Topology::Points,
        ..RasterOptions::default()
    };
    assert!(Format::R32Float.blends(ctx), "CPU drivers can");
    let draw = RasterPipeline::<DrawDepositsDraw>::new(ctx, &(), options).unwrap();
    for (size, crowded) in [(1, false), (65, false), (5000, false), (5000, true)] {
        let mut setup = start("builtin:torus?major=24&minor=16", size);
        if crowded {
            let first = setup.particles[0];
            for particle in &mut setup.particles {
                *particle = Particle {
                    id: particle.id,
                    ..first
                };
            }
        }
        let atlas = &setup.atlas;
        let params = CountDepositsParams {
            particle_count: size,
            pitch: atlas.pitch,
        };
        let mut expected = vec![0; atlas.density.len()];
        twin::count_deposits(&params, &setup.strips, &setup.particles, &mut expected);
        assert_eq!(expected.iter().sum::<u32>(), size);
        assert_eq!(expected.contains(&5000), crowded);

        let particles = texels(ctx, "particles", &setup.particles);
        let strips = texels(ctx, "strips", &setup.strips);
        let deposits = Buffer::<u32>::zeroed(ctx, "deposits", expected.len()).unwrap();
        let image_size = [atlas.pitch, atlas.size];
        let target = Image::new(ctx, "target", image_size, Format::R32Float, 1).unwrap();
        let drawn = Buffer::<f32>::zeroed(ctx, "drawn", expected.len()).unwrap();
        gpu.run(|rec| {
            let args = CountDepositsArgs {
                particles: &particles,
                strips: &strips,
                deposits: &deposits,
            };
            rec.dispatch(&count, Threads(size), args, params);
            let targets = Targets {
                color: &target,
                resolve: None,
                depth: None,
                depth_test: DepthTest::Greatest,
                clear: Some([0.0; 4]),
            };
            // Cleared in a pass of its own, as where ways are compared.
            rec.pass("clear", &targets, |_| {});
            let targets = Targets {
                clear: None,
                ..targets
            };
            rec.pass_as_kernel("draw_deposits", &targets, |pass| {
                let args = DrawDepositsArgs {
                    particles: &particles,
                    strips: &strips,
                };
                let [width, height] = image_size.map(|side| side as f32);
                let params = DrawDepositsParams {
                    pixel: 2.0 / Vec2::new(width, height),
                };
                pass.draw(&draw, size, 1, args, params);
            });
            rec.copy_image(&target, &drawn);
        });
        assert!(
            ctx.download(&deposits).unwrap() == expected,
            "{size} counted"
        );
        let drawn = ctx.download(&drawn).unwrap();
        let drawn: Vec<u32> = drawn.into_iter().map(|count| count as u32).collect();
        assert!(drawn == expected, "{size} drawn");
    }
    gpu.finish();
}

#[test]
fn sensors_read_the_same_whichever_way_the_trail_is_bound() {
    let Some(gpu) = gpu() else { return };
    let ctx = &gpu.ctx;
    let setup = start("builtin:torus?major=24&minor=16", 1021);
    let scene = scene("builtin:torus?major=24&minor=16", |_| {});
    let plan = Plan::new(&scene.settings, &setup, 0, Means::of_host(false, 1));
    let params = plan.advance(plan.terms(), Form::All).params;
    let own = physarums(&scene.settings, &setup)[0];
    let places = sensor_places(&setup, &params, &own, &setup.particles, &setup.motions);
    assert_eq!(places.len(), 2 * 1021);
    let [pitch, size] = [setup.atlas.pitch, setup.atlas.size];
    let trail: Vec<f32> = (0..pitch * size)
        .map(|texel| unit(random(5, texel, 0, Purpose::Start)[0]))
        .collect();
    let expected = twin::read_sensors(&places, &trail, pitch);

    let place_buffer = Buffer::from_slice_in(ctx, "places", &places, Domain::Texels).unwrap();
    let place_texels = Texels::<f32>::new::<Vec4>(&place_buffer, 4).unwrap();
    let buffer = Buffer::from_slice_in(ctx, "trail", &trail, Domain::Texels).unwrap();
    let view = Texels::<f32>::new(&buffer, 1).unwrap();
    let image = Sampled::new(ctx, "trail", [pitch, size]).unwrap();
    gpu.run(|rec| rec.copy_to_sampled(&buffer, &image));
    let particle_count = 1021;
    for way in 0..5 {
        let values = Buffer::<f32>::zeroed(ctx, "values", 1021).unwrap();
        let (places, values) = (&place_texels, &values);
        let threads = Threads(particle_count);
        gpu.run(|rec| match way {
            0 => {
                let trail = &view;
                let pipeline = Pipeline::<ReadTexels>::new(ctx, &()).unwrap();
                let args = ReadTexelsArgs {
                    places,
                    values,
                    trail,
                };
                let params = ReadTexelsParams {
                    particle_count,
                    pitch,
                };
                rec.dispatch(&pipeline, threads, args, params);
            }
            1 => {
                let trail = &buffer;
                let pipeline = Pipeline::<ReadBlock>::new(ctx, &()).unwrap();
                let args = ReadBlockArgs {
                    places,
                    values,
                    trail,
                };
                let params = ReadBlockParams {
                    particle_count,
                    pitch,
                };
                rec.dispatch(&pipeline, threads, args, params);
            }
            2 => {
                let trail = &view;
                let pipeline = Pipeline::<ReadStorageTexels>::new(ctx, &()).unwrap();
                let args = ReadStorageTexelsArgs {
                    places,
                    values,
                    trail,
                };
                let params = ReadStorageTexelsParams {
                    particle_count,
                    pitch,
                };
                rec.dispatch(&pipeline, threads, args, params);
            }
            3 => {
                let trail = &image;
                let pipeline = Pipeline::<ReadImage>::new(ctx, &()).unwrap();
                let args = ReadImageArgs {
                    places,
                    values,
                    trail,
                };
                rec.dispatch(&pipeline, threads, args, ReadImageParams { particle_count });
            }
            _ => {
                let trail = &image;
                let pipeline = Pipeline::<ReadSampler>::new(ctx, &()).unwrap();
                let args = ReadSamplerArgs {
                    places,
                    values,
                    trail,
                };
                let params = ReadSamplerParams {
                    particle_count,
                    texel: 1.0 / Vec2::new(pitch as f32, size as f32),
                };
                rec.dispatch(&pipeline, threads, args, params);
            }
        });
        let read = ctx.download(values).unwrap();
        // Samplers weigh by 8 bits at the least: of three readings between 0 and 1, each off by 1/256 along both axes.
        let bound = if way == 4 { 6.0 / 256.0 } else { 2e-6 };
        for (i, (a, b)) in read.iter().zip(&expected).enumerate() {
            assert!((a - b).abs() <= bound, "way {way}, {i}: {a} and {b}");
        }
    }
    gpu.finish();
}
