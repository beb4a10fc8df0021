//! The kernels that develop pictures, and the shadow on the ground, agree with their twins to the bit.

use crate::common::gpu;
use glam::Vec3;
use myxo::gpu::{Buffer, DispatchGroups, Kernel as _, Pipeline, Texels, Threads};
use myxo::render::develop::{Bloom, Shape, twin};
use myxo::render::mean;
use myxo::render::renderer::ground;
use myxo::rng::{Purpose, random};
use myxo::sim::kernels::{
    Average, AverageArgs, AverageParams, BloomDown, BloomDownArgs, BloomDownParams, BloomFirst,
    BloomFirstArgs, BloomFirstParams, BloomUp, BloomUpArgs, BloomUpParams, Develop, DevelopArgs,
    DevelopConstants, DevelopParams, SmoothEdges, SmoothEdgesArgs, SmoothEdgesConstants,
    SmoothEdgesParams, Soften, SoftenArgs, SoftenConstants, SoftenParams,
};

/// From one pixel on, with sides that are no multiples of four, and one that has all levels.
const SIZES: [[u32; 2]; 8] = [
    [1, 1],
    [3, 2],
    [4, 4],
    [5, 9],
    [1, 130],
    [131, 1],
    [67, 45],
    [300, 270],
];
const BLOOM: Bloom = Bloom {
    threshold: 0.2,
    slope: 1.5,
    strength: 0.8,
};

/// A picture with slanted bright bars on darkness, noise, and an alpha that is not whole everywhere.
fn picture(shape: &Shape) -> Vec<u32> {
    let words = (0..shape.pixel_count() as u32).map(|i| {
        let (x, y) = (i % shape.pitch(), i / shape.pitch());
        let [noise, ..] = random(7, i, 0, Purpose::Start);
        let is_bar = (3 * x + 5 * y) / 31 % 2 == 0;
        let color = if is_bar { 0xfff0_c850 } else { 0xff0a_0810 };
        match noise % 23 {
            0 => noise,
            1 => color & 0x80ff_ffff,
            _ => color,
        }
    });
    words.collect()
}

/// Would catch: any difference between a kernel and its twin, at sizes without whole groups, cells or levels.
#[test]
fn developing_kernels_agree_with_their_twins() {
    let Some(gpu) = gpu() else { return };
    let ctx = &gpu.ctx;
    let first = Pipeline::<BloomFirst>::new(ctx, &()).unwrap();
    let down = Pipeline::<BloomDown>::new(ctx, &()).unwrap();
    let up = Pipeline::<BloomUp>::new(ctx, &()).unwrap();
    for size in SIZES {
        let shape = Shape::of(size).unwrap();
        let words = picture(&shape);
        let picture = Buffer::from_slice(ctx, "picture", &words).unwrap();
        let [quads, singles] = [4, 1].map(|n| Texels::new(&picture, n).unwrap());
        let cells = Buffer::<f32>::zeroed(ctx, "bloom", 4 * shape.cell_count()).unwrap();
        let bloom = Texels::new(&cells, 4).unwrap();
        let mut levels = vec![Vec3::ZERO; shape.cell_count()];
        let compare = |levels: &[Vec3], what: &str| {
            let found = ctx.download(&cells).unwrap();
            for (i, (found, twin)) in found.chunks(4).zip(levels).enumerate() {
                assert_eq!(found[..3], twin.to_array(), "{size:?}, {what}, cell {i}");
            }
        };
        let [width, height] = size;
        for is_opaque in [false, true] {
            let flaws = Buffer::from_slice(ctx, "flaws", &[5_u32]).unwrap();
            gpu.run(|rec| {
                let args = BloomFirstArgs {
                    picture: &quads,
                    bloom: &bloom,
                    flaws: &flaws,
                };
                let params = BloomFirstParams {
                    cell_count: shape.levels[0].count() as u32,
                    across: shape.across,
                    width,
                    height,
                    threshold: BLOOM.threshold,
                    slope: BLOOM.slope,
                    is_opaque: u32::from(is_opaque),
                };
                rec.dispatch(&first, Threads(params.cell_count), args, params);
            });
            let mut counted = 5;
            twin::bloom_first(&shape, &BLOOM, is_opaque, &words, &mut levels, &mut counted);
            assert_eq!(ctx.download(&flaws).unwrap(), [counted], "{size:?}");
            compare(&levels, "first");
        }
        for pair in shape.levels.windows(2) {
            let [fine, coarse] = [pair[0], pair[1]];
            gpu.run(|rec| {
                let params = BloomDownParams {
                    cell_count: coarse.count() as u32,
                    across: coarse.across,
                    first: coarse.first,
                    fine_across: fine.across,
                    fine_down: fine.down,
                    fine_first: fine.first,
                };
                let args = BloomDownArgs { bloom: &bloom };
                rec.dispatch(&down, Threads(params.cell_count), args, params);
            });
            twin::bloom_down(fine, coarse, &mut levels);
        }
        compare(&levels, "down");
        for (k, pair) in shape.levels.windows(2).enumerate().rev() {
            let [fine, coarse] = [pair[0], pair[1]];
            let strength = if k == 0 { BLOOM.strength } else { 1.0 };
            let [kept, spread] = shape.kept_and_spread(k);
            gpu.run(|rec| {
                let params = BloomUpParams {
                    cell_count: fine.count() as u32,
                    across: fine.across,
                    first: fine.first,
                    coarse_across: coarse.across,
                    coarse_down: coarse.down,
                    coarse_first: coarse.first,
                    kept,
                    spread,
                    strength,
                    is_last: u32::from(k == 0),
                };
                let args = BloomUpArgs { bloom: &bloom };
                rec.dispatch(&up, Threads(params.cell_count), args, params);
            });
            let weights = [kept, spread];
            twin::bloom_up([fine, coarse], weights, strength, k == 0, &mut levels);
        }
        compare(&levels, "up");
        for (blooms, is_opaque) in [(false, true), (true, false), (true, true)] {
            develops(
                &gpu,
                &shape,
                (&words, &quads, &singles),
                &bloom,
                &levels,
                [blooms, is_opaque],
            );
        }
    }
    gpu.finish();
}

/// The last two kernels, with and without bloom and alpha.
fn develops(
    gpu: &crate::common::Gpu,
    shape: &Shape,
    (words, quads, singles): (&[u32], &Texels<u32>, &Texels<u32>),
    bloom: &Texels<f32>,
    levels: &[Vec3],
    [blooms, is_opaque]: [bool; 2],
) {
    let ctx = &gpu.ctx;
    let may_be_clear = blooms && !is_opaque;
    let develop = DevelopConstants {
        blooms,
        smooths: true,
        may_be_clear,
    };
    let develop = Pipeline::<Develop>::new(ctx, &develop).unwrap();
    let smooth = SmoothEdgesConstants {
        blooms,
        may_be_clear,
    };
    let smooth = Pipeline::<SmoothEdges>::new(ctx, &smooth).unwrap();
    let count = shape.pixel_count();
    let developed = Buffer::<u32>::zeroed(ctx, "developed", count).unwrap();
    let [into_quads, into_singles] = [4, 1].map(|n| Texels::new(&developed, n).unwrap());
    let edges = Buffer::<u32>::zeroed(ctx, "edges", count).unwrap();
    let none = DispatchGroups { x: 0, y: 0, z: 1 };
    let groups = [none, DispatchGroups::default()];
    let groups = Buffer::from_slice(ctx, "groups", &groups).unwrap();
    let [width, height] = shape.size;
    let cells_down = shape.levels[0].down;
    gpu.run(|rec| {
        let params = DevelopParams {
            quad_count: count as u32 / 4,
            across: shape.across,
            width,
            height,
            cells_down,
            is_opaque: u32::from(is_opaque),
            in_group: SmoothEdges::GROUP_SIZE,
        };
        let args = DevelopArgs {
            picture: quads,
            bloom,
            developed: &into_quads,
            edges: &edges,
            groups: &groups,
        };
        rec.dispatch(&develop, Threads(params.quad_count), args, params);
    });
    let levels = if blooms { levels } else { &[] };
    let (mut twin, twin_edges) = twin::develop(shape, is_opaque, words, levels);
    assert_eq!(ctx.download(&developed).unwrap(), twin, "{shape:?}");
    let listed = ctx.download(&groups).unwrap()[1].x as usize;
    let mut found = ctx.download(&edges).unwrap()[..listed].to_vec();
    found.sort_unstable();
    assert_eq!(found, twin_edges, "{shape:?}");
    gpu.run(|rec| {
        let args = SmoothEdgesArgs {
            edges: &edges,
            groups: &groups,
            picture: singles,
            bloom,
            developed: &into_singles,
        };
        let params = SmoothEdgesParams {
            pitch: shape.pitch(),
            width,
            height,
            cells_down,
            is_opaque: u32::from(is_opaque),
        };
        rec.dispatch_indirect(&smooth, (&groups, 0), args, params);
    });
    let before = twin.clone();
    twin::smooth_edges(shape, is_opaque, &twin_edges, words, levels, &mut twin);
    assert_eq!(ctx.download(&developed).unwrap(), twin, "{shape:?}");
    assert!(
        width.min(height) < 40 || before != twin,
        "edges are smoothed"
    );
    if !blooms && is_opaque {
        // Where there is neither bloom nor edge, a picture keeps its bytes.
        let kept = (0..count).filter(|i| !twin_edges.contains(&(*i as u32)));
        for i in kept {
            assert_eq!(twin[i], words[i] | 0xff00_0000, "pixel {i}");
        }
    }
}

/// Would catch: a blur of the shadow that differs from its twin, or that loses or gains shade.
#[test]
fn soften_agrees_with_its_twin() {
    let Some(gpu) = gpu() else { return };
    let ctx = &gpu.ctx;
    let side = ground::SIDE as usize;
    let words: Vec<u32> = (0..(side * side) as u32)
        .map(|i| random(3, i, 0, Purpose::Start)[0])
        .collect();
    let mut twin: Vec<f32> = words
        .iter()
        .map(|w| (w & 255) as f32 * (1.0 / 255.0))
        .collect();
    let before: f32 = twin.iter().sum();
    let footprint = Buffer::from_slice(ctx, "footprint", &words).unwrap();
    let footprint = Texels::new(&footprint, 1).unwrap();
    let shadows = ["a", "b"].map(|name| Buffer::<f32>::zeroed(ctx, name, side * side).unwrap());
    let mut from = 0;
    for (is_first, is_down, apart) in [(true, 0, 1), (false, 1, 1), (false, 0, 2), (false, 1, 40)] {
        let pipeline = Pipeline::<Soften>::new(ctx, &SoftenConstants { is_first }).unwrap();
        gpu.run(|rec| {
            let args = SoftenArgs {
                footprint: &footprint,
                shadow: &shadows[from],
                softened: &shadows[1 - from],
            };
            let params = SoftenParams {
                cell_count: ground::SIDE * ground::SIDE,
                is_down,
                apart,
            };
            rec.dispatch(&pipeline, Threads(params.cell_count), args, params);
        });
        from = 1 - from;
        twin = ground::soften(is_down == 1, apart, &twin);
        assert_eq!(ctx.download(&shadows[from]).unwrap(), twin, "{apart}");
        if apart == 1 {
            let after: f32 = twin.iter().sum();
            // Only what is blurred over the edges of the square is lost.
            assert!(
                (0.93..1.0).contains(&(after / before)),
                "{after} of {before}"
            );
        }
    }
    gpu.finish();
}

/// Would catch: a mean of pictures that differs from its twin, one that begins with what a former mean has left, and pixels that are left out.
#[test]
fn average_agrees_with_its_twin() {
    let Some(gpu) = gpu() else { return };
    let ctx = &gpu.ctx;
    let average = Pipeline::<Average>::new(ctx, &()).unwrap();
    let light = Buffer::from_slice(ctx, "light", mean::light()).unwrap();
    let light = Texels::new(&light, 1).unwrap();
    for pixel_count in [1, 63, 1000] {
        let all = pixel_count as usize;
        let stale = vec![0x1234_5678_u32; 4 * all];
        let sums = Buffer::from_slice(ctx, "sums", &stale).unwrap();
        let all_sums = Texels::new(&sums, 4).unwrap();
        let mut twin_sums = vec![[7; 4]; all];
        for pictures in 1..=5 {
            let words = (0..pixel_count).map(|i| random(pictures, i, 0, Purpose::Start)[0]);
            let mut twin: Vec<u32> = words.collect();
            let picture = Buffer::from_slice(ctx, "picture", &twin).unwrap();
            let texels = Texels::new(&picture, 1).unwrap();
            gpu.run(|rec| {
                let args = AverageArgs {
                    light: &light,
                    sums: &all_sums,
                    picture: &texels,
                };
                let params = AverageParams {
                    pixel_count,
                    pictures,
                };
                rec.dispatch(&average, Threads(pixel_count), args, params);
            });
            mean::average(pictures, &mut twin_sums, &mut twin);
            assert_eq!(ctx.download(&picture).unwrap(), twin, "{pictures}");
            let found = ctx.download(&sums).unwrap();
            assert_eq!(found, twin_sums.as_flattened(), "{pictures}");
        }
    }
    gpu.finish();
}
