//! Missing barriers: the recorder's own check, and the validation layer behind it.

use super::selftest::*;
use super::*;

struct Setup {
    scale: Pipeline<Scale>,
    a: Buffer<f32>,
    b: Buffer<f32>,
    frames: Frames,
    ctx: Arc<Context>,
}

impl Setup {
    fn new(hazard_check: bool) -> Option<Self> {
        let ctx = context_with(ContextOptions {
            validation: true,
            hazard_check: Some(hazard_check),
            ..ContextOptions::default()
        })?;
        Some(Self {
            scale: Pipeline::new(&ctx, &ScaleConstants::default()).unwrap(),
            a: Buffer::zeroed(&ctx, "first", 64).unwrap(),
            b: Buffer::zeroed(&ctx, "second", 64).unwrap(),
            frames: Frames::new(&ctx, 1).unwrap(),
            ctx,
        })
    }

    fn scale(&self, rec: &mut Recorder, source: &Buffer<f32>, target: &Buffer<f32>) {
        let params = ScaleParams {
            count: 64,
            factor: glam::Vec2::ONE,
        };
        rec.dispatch(
            &self.scale,
            Threads(64),
            ScaleArgs { source, target },
            params,
        );
    }
}

#[test]
fn a_read_without_a_barrier_panics_naming_both_kernels_and_the_buffer() {
    let Some(mut s) = Setup::new(true) else {
        return;
    };
    let bump = Pipeline::<Bump>::new(&s.ctx, &()).unwrap();
    let values = Buffer::<u32>::zeroed(&s.ctx, "values", 64).unwrap();
    let copy = Buffer::<u32>::zeroed(&s.ctx, "copy of values", 64).unwrap();
    let mut rec = s.frames.begin().unwrap();
    rec.dispatch(
        &bump,
        Threads(64),
        BumpArgs { values: &values },
        BumpParams {
            count: 64,
            amount: 1,
        },
    );
    let text = panic_text(|| rec.copy(&values, &copy));
    assert_eq!(
        text,
        "missing barrier: `copy` reads the buffer `values`, which `bump` wrote before it; \
         record barrier(Access::Kernel, Access::Copy, ..) on it between the two"
    );
    rec.barrier(Access::Kernel, Access::Copy, &[&values]);
    rec.copy(&values, &copy);
    // Written after a read.
    let text = panic_text(|| {
        rec.dispatch(
            &bump,
            Threads(64),
            BumpArgs { values: &values },
            BumpParams {
                count: 64,
                amount: 1,
            },
        );
    });
    assert!(
        text.contains("`bump` writes the buffer `values`, which `bump` wrote"),
        "{text}"
    );
    rec.barrier(Access::Copy, Access::Kernel, &[&values]);
    rec.dispatch(
        &bump,
        Threads(64),
        BumpArgs { values: &values },
        BumpParams {
            count: 64,
            amount: 1,
        },
    );
    s.frames.submit(rec).unwrap();
    s.frames.wait_idle().unwrap();
    assert_eq!(s.ctx.download(&values).unwrap(), [2; 64]);
    assert_silent(&s.ctx);
}

#[test]
fn a_write_after_a_read_needs_a_barrier_also_in_a_later_frame() {
    let Some(mut s) = Setup::new(true) else {
        return;
    };
    let mut rec = s.frames.begin().unwrap();
    s.scale(&mut rec, &s.a, &s.b);
    s.frames.submit(rec).unwrap();
    let mut rec = s.frames.begin().unwrap();
    let text = panic_text(|| s.scale(&mut rec, &s.b, &s.a));
    // The buffer that was written is found first.
    assert!(
        text.contains("`scale` reads the buffer `second`, which `scale` wrote"),
        "{text}"
    );
    rec.barrier(Access::Kernel, Access::Kernel, &[&s.b]);
    let text = panic_text(|| s.scale(&mut rec, &s.b, &s.a));
    assert!(
        text.contains("`scale` writes the buffer `first`, which `scale` read"),
        "{text}"
    );
    rec.barrier(Access::Kernel, Access::Kernel, &[&s.a]);
    s.scale(&mut rec, &s.b, &s.a);
    s.frames.submit(rec).unwrap();
    // A transfer orders everything round itself.
    assert_eq!(s.ctx.download(&s.a).unwrap(), [10.0; 64]);
    s.ctx.fill(&s.a, 0).unwrap();
    s.ctx.fill(&s.b, 0).unwrap();
    let mut rec = s.frames.begin().unwrap();
    s.scale(&mut rec, &s.b, &s.a);
    s.frames.submit(rec).unwrap();
    s.frames.wait_idle().unwrap();
    assert_silent(&s.ctx);
}

#[test]
fn one_buffer_is_not_bound_twice_to_be_written() {
    let Some(mut s) = Setup::new(true) else {
        return;
    };
    let mut rec = s.frames.begin().unwrap();
    let text = panic_text(|| s.scale(&mut rec, &s.a, &s.a));
    assert_eq!(
        text,
        "`scale` binds the buffer `first` twice, as source and as target, and writes it"
    );
}

#[test]
fn barriers_chain() {
    let Some(mut s) = Setup::new(true) else {
        return;
    };
    let back = Buffer::<f32>::new(&s.ctx, "back", 64, Domain::Readback).unwrap();
    let mut rec = s.frames.begin().unwrap();
    rec.fill(&s.a, 0x3f80_0000);
    rec.barrier(Access::Copy, Access::Kernel, &[&s.a]);
    rec.barrier(Access::Kernel, Access::Copy, &[&s.a]);
    rec.copy(&s.a, &back);
    rec.barrier(Access::Copy, Access::Readback, &[&back]);
    s.frames.submit(rec).unwrap();
    let text = panic_text(|| assert_eq!(back.as_slice()[..], [1.0; 64]));
    assert!(
        text.contains("a frame that uses it has not finished"),
        "{text}"
    );
    s.frames.wait_idle().unwrap();
    assert_eq!(back.as_slice()[..], [1.0; 64]);
    assert_silent(&s.ctx);
}

#[test]
fn the_host_needs_a_barrier_to_read() {
    let Some(mut s) = Setup::new(true) else {
        return;
    };
    let back = Buffer::<f32>::new(&s.ctx, "back", 64, Domain::Readback).unwrap();
    let mut rec = s.frames.begin().unwrap();
    rec.copy(&s.a, &back);
    s.frames.submit(rec).unwrap();
    s.frames.wait_idle().unwrap();
    let text = panic_text(|| assert!(back.as_slice().is_empty()));
    assert!(
        text.contains("the host reads `back`, which `copy` wrote"),
        "{text}"
    );
}

#[test]
fn a_slice_that_the_host_holds_does_not_change() {
    let Some(mut s) = Setup::new(true) else {
        return;
    };
    let back = Buffer::<f32>::new(&s.ctx, "back", 64, Domain::Readback).unwrap();
    let slice = back.as_slice();
    let mut rec = s.frames.begin().unwrap();
    let text = panic_text(|| rec.copy(&s.a, &back));
    assert!(
        text.contains("`copy` writes `back` while the host holds a slice of it"),
        "{text}"
    );
    assert!(panic_text(|| s.ctx.fill(&back, 0).unwrap()).contains("`fill` writes `back`"));
    drop(slice);
    rec.copy(&s.a, &back);
}

/// If this fails, the validation layer is not watching, and every other test's silence means nothing.
#[test]
fn the_validation_layer_sees_a_barrier_that_is_left_out() {
    let Some(mut s) = Setup::new(false) else {
        return;
    };
    let mut rec = s.frames.begin().unwrap();
    s.scale(&mut rec, &s.a, &s.b);
    let other = Buffer::zeroed(&s.ctx, "third", 64).unwrap();
    s.scale(&mut rec, &s.b, &other);
    s.frames.submit(rec).unwrap();
    s.frames.wait_idle().unwrap();
    let messages = s.ctx.take_messages();
    assert!(
        messages.iter().any(|m| m.contains("READ_AFTER_WRITE")),
        "{messages:?}"
    );
    assert_silent(&s.ctx);
}

#[test]
fn a_transfer_does_not_overtake_a_frame_that_is_being_recorded() {
    let Some(mut s) = Setup::new(true) else {
        return;
    };
    let mut rec = s.frames.begin().unwrap();
    s.scale(&mut rec, &s.a, &s.b);
    let text = panic_text(|| assert!(s.ctx.download(&s.b).is_ok()));
    assert!(
        text.contains("`second` is used by a frame that is still being recorded"),
        "{text}"
    );
    drop(rec);
    assert_eq!(s.ctx.download(&s.b).unwrap(), [0.0; 64]);
}
