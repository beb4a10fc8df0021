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
}

use selftest::{Scale, ScaleArgs, ScaleConstants, ScaleParams};

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
