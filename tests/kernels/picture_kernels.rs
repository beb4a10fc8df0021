//! The kernels that pictures need agree with their twins.

use crate::common::{awkward_sizes, gpu};
use myxo::gpu::{Buffer, Pipeline, Texels, Threads};
use myxo::mesh::surface::NONE;
use myxo::render::draw_order;
use myxo::render::exposure::{self, BIN_COUNT};
use myxo::rng::{Purpose, random, unit};
use myxo::sim::Texture;
use myxo::sim::kernels::{
    DrawOrder, DrawOrderArgs, DrawOrderParams, Expose, ExposeArgs, ExposeParams, TrailHistogram,
    TrailHistogramArgs, TrailHistogramConstants, TrailHistogramParams,
};
use myxo::sim::types::Particle;

#[test]
fn draw_order_agrees_with_its_twin() {
    let Some(gpu) = gpu() else { return };
    let pipeline = Pipeline::<DrawOrder>::new(&gpu.ctx, &()).unwrap();
    for count in awkward_sizes(256).into_iter().filter(|&count| count > 0) {
        // Ids in an order of their own: 7919 is a prime.
        let particles: Vec<Particle> = (0..u64::from(count))
            .map(|slot| Particle {
                triangle: 0,
                u: 0.0,
                v: 0.0,
                id: ((slot * 7919 + 11) % u64::from(count)) as u32,
            })
            .collect();
        let buffer = Buffer::from_slice(&gpu.ctx, "particles", &particles).unwrap();
        let view = Texels::new(&buffer, 4).unwrap();
        for most in [u32::MAX, count, count / 2, 5, 1] {
            let stride = draw_order::stride(count, most);
            let drawn = draw_order::drawn(count, stride);
            assert!(drawn >= 1 && drawn <= most.max(1), "{drawn} of {most}");
            let mut twin = vec![NONE; count as usize];
            let order = Buffer::from_slice(&gpu.ctx, "order", &twin).unwrap();
            gpu.run(|rec| {
                let args = DrawOrderArgs {
                    particles: &view,
                    order: &order,
                };
                let params = DrawOrderParams {
                    particle_count: count,
                    stride,
                };
                rec.dispatch(&pipeline, Threads(count), args, params);
            });
            draw_order::draw_order(count, stride, &particles, &mut twin);
            assert_eq!(gpu.ctx.download(&order).unwrap(), twin, "{count}, {stride}");
            let listed = twin.iter().filter(|&&slot| slot != NONE).count();
            assert_eq!(listed, drawn as usize, "{count}, stride {stride}");
        }
    }
    gpu.finish();
}

#[test]
fn exposure_kernels_agree_with_their_twins() {
    let Some(gpu) = gpu() else { return };
    let constants = TrailHistogramConstants::default();
    let histogram_pipeline = Pipeline::<TrailHistogram>::new(&gpu.ctx, &constants).unwrap();
    let expose_pipeline = Pipeline::<Expose>::new(&gpu.ctx, &()).unwrap();
    for sample_count in awkward_sizes(256).into_iter().filter(|&count| count > 0) {
        for stride in [1, 3] {
            let texel_count = ((sample_count - 1) * stride + 1).next_multiple_of(4);
            let words = |i: u32| random(sample_count, i, 0, Purpose::Start);
            let trail: Vec<f32> = (0..texel_count)
                .map(|i| 2_f32.powf(64.0 * unit(words(i)[0]) - 20.0))
                .collect();
            let density: Vec<f32> = (0..texel_count)
                .map(|i| [0.0, 1.0, 0.3, 17.0][words(i)[1] as usize % 4])
                .collect();
            let bins = BIN_COUNT as usize;
            let mut twin_histogram = vec![0; 2 * bins];
            twin_histogram[bins + 40] = 12;
            let mut twin_brightest = [3.0, 5.0];
            let [trail_texture, density_texture] =
                [("trail", &trail), ("density", &density)].map(|(name, values)| {
                    let buffer = Buffer::from_slice(&gpu.ctx, name, values).unwrap();
                    Texture::new(&gpu.ctx, buffer).unwrap()
                });
            let histogram = Buffer::from_slice(&gpu.ctx, "histogram", &twin_histogram).unwrap();
            let brightest = Buffer::from_slice(&gpu.ctx, "brightest", &twin_brightest).unwrap();
            gpu.run(|rec| {
                let args = TrailHistogramArgs {
                    trail: &trail_texture,
                    density: &density_texture,
                    histogram: &histogram,
                };
                rec.dispatch(
                    &histogram_pipeline,
                    Threads(sample_count),
                    args,
                    TrailHistogramParams {
                        sample_count,
                        stride,
                    },
                );
            });
            exposure::trail_histogram(sample_count, stride, &trail, &density, &mut twin_histogram);
            assert_eq!(
                gpu.ctx.download(&histogram).unwrap(),
                twin_histogram,
                "{sample_count}, stride {stride}"
            );
            gpu.run(|rec| {
                let args = ExposeArgs {
                    histogram: &histogram,
                    brightest: &brightest,
                };
                let params = ExposeParams {
                    count: 2,
                    clipped_share: 0.11,
                    adaptation: 0.3,
                };
                rec.dispatch(&expose_pipeline, Threads(2), args, params);
            });
            exposure::expose(2, 0.11, 0.3, &mut twin_histogram, &mut twin_brightest);
            assert_eq!(gpu.ctx.download(&histogram).unwrap(), twin_histogram);
            let here = gpu.ctx.download(&brightest).unwrap();
            for (a, b) in here.iter().zip(twin_brightest) {
                assert!(
                    (a - b).abs() <= 1e-5 * b.abs(),
                    "{sample_count}, stride {stride}: {here:?}, twin {twin_brightest:?}"
                );
            }
        }
    }
    gpu.finish();
}
