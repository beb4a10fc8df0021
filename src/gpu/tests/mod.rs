//! Tests that need a device. They fail without one unless MYXO_SKIP_GPU_TESTS is set; then the skip is printed.

use std::sync::Arc;

use super::*;

/// The handles of `shaders/selftest`.
#[allow(
    missing_docs,
    dead_code,
    clippy::all,
    reason = "generated for the tests"
)]
mod selftest {
    include!(concat!(env!("OUT_DIR"), "/selftest.rs"));
    include!(concat!(env!("OUT_DIR"), "/selftest_draws.rs"));
}

use selftest::{DiscArgs, DiscDraw, DiscParams, Scale, ScaleArgs, ScaleConstants, ScaleParams};

/// A context with validation, or `None` where tests may be skipped.
fn context() -> Option<Arc<Context>> {
    context_with(ContextOptions {
        validation: true,
        ..ContextOptions::default()
    })
}

fn context_with(options: ContextOptions) -> Option<Arc<Context>> {
    match Context::new(&options) {
        Ok(ctx) => Some(ctx),
        Err(error) if std::env::var_os("MYXO_SKIP_GPU_TESTS").is_some() => {
            eprintln!("skipped: {error}");
            None
        }
        Err(error) => {
            panic!("{error}\n(set MYXO_SKIP_GPU_TESTS=1 to skip tests that need a device)")
        }
    }
}

#[track_caller]
fn assert_silent(ctx: &Context) {
    let messages = ctx.messages();
    assert!(
        messages.is_empty(),
        "validation says:\n{}",
        messages.join("\n")
    );
}

#[test]
fn a_kernel_runs_at_awkward_sizes() {
    let Some(ctx) = context() else { return };
    let scale = Pipeline::<Scale>::new(&ctx, &ScaleConstants::default()).unwrap();
    let mut frames = Frames::new(&ctx, 2).unwrap();
    for count in [0, 1, 63, 64, 65, 1000, 65_535 * 64 + 1, 65_536 * 64 + 65] {
        let data: Vec<f32> = (0..count).map(|i| (i % 4096) as f32).collect();
        let source = Buffer::from_slice(&ctx, "source", &data).unwrap();
        let target = Buffer::zeroed(&ctx, "target", count).unwrap();
        let mut rec = frames.begin().unwrap();
        let params = ScaleParams {
            count: count as u32,
            factor: glam::Vec2::new(2.0, 1.5),
        };
        rec.dispatch(
            &scale,
            Threads::of(count),
            ScaleArgs {
                source: &source,
                target: &target,
            },
            params,
        );
        frames.submit(rec).unwrap();
        let expected: Vec<f32> = data.iter().map(|x| x * 3.0 + 5.0).collect();
        let got = ctx.download(&target).unwrap();
        let wrong = (0..count).find(|&i| got[i] != expected[i]);
        assert!(
            wrong.is_none(),
            "{count} elements, first wrong is {wrong:?}: {:?}",
            wrong.map(|i| (got[i], expected[i]))
        );
    }
    frames.wait_idle().unwrap();
    assert_silent(&ctx);
}

#[test]
fn a_picture_is_drawn_and_read_back() {
    let Some(ctx) = context() else { return };
    for samples in [1, 4] {
        let options = RasterOptions {
            samples,
            ..RasterOptions::default()
        };
        let pipeline = RasterPipeline::<DiscDraw>::new(&ctx, &(), options).unwrap();
        let size = [37, 21];
        let color = Image::new(&ctx, "color", size, Format::Rgba8Srgb, samples).unwrap();
        let resolve =
            (samples > 1).then(|| Image::new(&ctx, "resolve", size, Format::Rgba8Srgb, 1).unwrap());
        let depth = Image::new(&ctx, "depth", size, Format::Depth32, samples).unwrap();
        // Covers the left half of the row in the middle.
        let centres = Buffer::from_slice(&ctx, "centres", &[glam::Vec2::new(-4.0, 0.0)]).unwrap();
        let pixels = Buffer::<[u8; 4]>::new(&ctx, "pixels", 37 * 21, Domain::Readback).unwrap();
        let mut frames = Frames::new(&ctx, 1).unwrap();
        let mut rec = frames.begin().unwrap();
        let targets = Targets {
            color: &color,
            resolve: resolve.as_ref(),
            depth: Some(&depth),
            clear: Some([0.0, 0.0, 1.0, 1.0]),
        };
        rec.pass("picture", &targets, |pass| {
            let params = DiscParams {
                color: glam::Vec4::new(1.0, 0.215_86, 0.0, 1.0),
                size: 4.0,
            };
            pass.draw(&pipeline, 3, 1, DiscArgs { centres: &centres }, params);
        });
        rec.copy_image(resolve.as_ref().unwrap_or(&color), &pixels);
        rec.barrier(Access::Copy, Access::Readback, &[&pixels]);
        frames.submit(rec).unwrap();
        frames.wait_idle().unwrap();
        let pixels = pixels.as_slice();
        assert_eq!(
            pixels[10 * 37],
            [255, 128, 0, 255],
            "left, {samples} samples"
        );
        assert_eq!(
            pixels[10 * 37 + 36],
            [0, 0, 255, 255],
            "right, {samples} samples"
        );
        let names: Vec<_> = frames
            .timings()
            .frames()
            .next()
            .unwrap()
            .iter()
            .map(|s| (s.name.clone(), s.kind))
            .collect();
        let expected = [
            ("frame", SpanKind::Frame),
            ("picture", SpanKind::Scope),
            ("disc", SpanKind::Draw),
            ("copy_image", SpanKind::Copy),
        ];
        assert_eq!(names, expected.map(|(name, kind)| (name.to_owned(), kind)));
    }
    assert_silent(&ctx);
}
