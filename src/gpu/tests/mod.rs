//! Tests that need a device. They fail without one unless MYXO_ALLOW_NO_DEVICE is set; then the skip is printed.

mod debug;
mod device;
mod draw;
mod frames;
mod hazards;
mod kernels;
mod queries;
#[cfg(all(target_os = "linux", feature = "app"))]
mod window;

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
        Err(error) if std::env::var_os("MYXO_ALLOW_NO_DEVICE").is_some() => {
            eprintln!("skipped: {error}");
            None
        }
        Err(error) => {
            panic!("{error}\n(set MYXO_ALLOW_NO_DEVICE=1 to skip tests that need a device)")
        }
    }
}

/// Fails the test if the validation layer has said anything.
#[track_caller]
fn assert_silent(ctx: &Context) {
    let messages = ctx.messages();
    assert!(
        messages.is_empty(),
        "validation says:\n{}",
        messages.join("\n")
    );
}

/// The panic message of `run`.
fn panic_text(run: impl FnOnce()) -> String {
    let payload =
        std::panic::catch_unwind(std::panic::AssertUnwindSafe(run)).expect_err("this panics");
    let text = payload.downcast_ref::<String>().cloned();
    text.or_else(|| payload.downcast_ref::<&str>().map(|s| (*s).to_owned()))
        .unwrap_or_default()
}
