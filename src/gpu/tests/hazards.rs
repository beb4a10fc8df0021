//! Barriers: present where a work depends on another, absent elsewhere, and the validation layer reports a missing one.

use super::selftest::*;
use super::*;

struct Setup {
    scale: Pipeline<Scale>,
    a: Buffer<f32>,
    b: Buffer<f32>,
    c: Buffer<f32>,
    frames: Frames,
    ctx: Arc<Context>,
}

impl Setup {
    fn new() -> Option<Self> {
        Self::with(ContextOptions::default())
    }

    fn with(options: ContextOptions) -> Option<Self> {
        Self::with_just(ContextOptions {
            validation: true,
            ..options
        })
    }

    fn with_just(options: ContextOptions) -> Option<Self> {
        let ctx = context_with(options)?;
        let buffer = |name| Buffer::zeroed(&ctx, name, 64).unwrap();
        Some(Self {
            scale: Pipeline::new(&ctx, &ScaleConstants::default()).unwrap(),
            a: buffer("first"),
            b: buffer("second"),
            c: buffer("third"),
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

    /// Records, submits and waits; returns what was listed, a line each.
    fn listed(&mut self, record: impl FnOnce(&Self, &mut Recorder)) -> Vec<String> {
        let mut rec = self.frames.begin().unwrap();
        rec.list();
        record(self, &mut rec);
        let listed = rec.listed();
        self.frames.submit(rec).unwrap();
        self.frames.wait_idle().unwrap();
        lines(&listed)
    }
}

fn lines(listed: &[Listed]) -> Vec<String> {
    let line = |listed: &Listed| match listed {
        Listed::Work(name) => name.clone(),
        Listed::Unordered(reason) => format!("in no order: {reason}"),
        Listed::Ordered => "in order".to_owned(),
        Listed::Barrier(reasons) => {
            let reasons: Vec<String> = reasons.iter().map(ToString::to_string).collect();
            format!("- {}", reasons.join("; "))
        }
    };
    listed.iter().map(line).collect()
}

/// Catches barriers that are missing, or that nothing needs: two kernels that only read the same may overlap.
#[test]
fn barriers_stand_where_works_depend_and_nowhere_else() {
    let Some(mut s) = Setup::new() else { return };
    let d = Buffer::zeroed(&s.ctx, "fourth", 64).unwrap();
    let listed = s.listed(|s, rec| {
        s.scale(rec, &s.a, &s.b);
        s.scale(rec, &s.a, &s.c);
        s.scale(rec, &s.b, &d);
        // Ordered by the barrier above, as `second` is.
        s.scale(rec, &s.c, &s.a);
    });
    assert_eq!(
        listed,
        [
            "scale",
            "scale",
            "- second: scale wrote it (kernel), scale reads it (kernel)",
            "scale",
            "scale",
        ]
    );
    assert_silent(&s.ctx);
}

/// Catches histories that end with a frame: the next one is submitted to the same queue.
#[test]
fn a_later_frame_waits_for_an_earlier_one() {
    let Some(mut s) = Setup::new() else { return };
    let first = s.listed(|s, rec| s.scale(rec, &s.a, &s.b));
    assert_eq!(first, ["scale"]);
    let second = s.listed(|s, rec| {
        rec.fill(&s.a, 0x3f80_0000);
        s.scale(rec, &s.a, &s.b);
    });
    assert_eq!(
        second,
        [
            "- first: scale read it (kernel), fill writes it (copy)",
            "fill",
            "- first: fill wrote it (copy), scale reads it (kernel); second: scale wrote it (kernel), scale writes it (kernel)",
            "scale",
        ]
    );
    assert_silent(&s.ctx);
    // A transfer orders everything before and after it.
    s.ctx.fill(&s.a, 0).unwrap();
    s.ctx.fill(&s.b, 0).unwrap();
    assert_eq!(s.listed(|s, rec| s.scale(rec, &s.b, &s.a)), ["scale"]);
    assert_silent(&s.ctx);
}

/// Catches wrong histories after a dropped recording: its barriers did not happen, and its uses have replaced earlier ones.
#[test]
fn after_a_recording_that_was_dropped_the_next_one_waits_for_everything() {
    let Some(mut s) = Setup::new() else { return };
    s.listed(|s, rec| s.scale(rec, &s.a, &s.b));
    // A write after a write, and one after a read.
    let mut rec = s.frames.begin().unwrap();
    rec.fill(&s.b, 0);
    rec.fill(&s.a, 0);
    drop(rec);
    let listed = s.listed(|s, rec| {
        s.scale(rec, &s.b, &s.c);
        s.scale(rec, &s.c, &s.a);
    });
    let wait = "- third: scale wrote it (kernel), scale reads it (kernel)";
    assert_eq!(listed, ["- ", "scale", wait, "scale"]);
    assert_silent(&s.ctx);
}

/// Catches a barrier of one recording that counts for another one, whose work it does not stand between.
#[test]
fn two_recordings_that_are_open_at_once_order_nothing_for_each_other() {
    let Some(mut s) = Setup::new() else { return };
    let [d, e, f] = ["d", "e", "f"].map(|name| Buffer::zeroed(&s.ctx, name, 64).unwrap());
    let mut others = Frames::new(&s.ctx, 1).unwrap();
    let mut one = s.frames.begin().unwrap();
    let mut other = others.begin().unwrap();
    one.list();
    s.scale(&mut one, &s.a, &s.b);
    s.scale(&mut other, &d, &e);
    s.scale(&mut other, &e, &f);
    s.scale(&mut one, &s.b, &s.c);
    let wait = "- second: scale wrote it (kernel), scale reads it (kernel)";
    assert_eq!(lines(&one.listed()), ["scale", wait, "scale"]);
    s.frames.submit(one).unwrap();
    others.submit(other).unwrap();
    others.wait_idle().unwrap();
    // Nor for the next recording: it is not known which of the two was first.
    let listed = s.listed(|s, rec| s.scale(rec, &s.b, &d));
    assert_eq!(listed.len(), 2, "{listed:?}");
    assert_silent(&s.ctx);
}

/// Catches a kernel that waits for the groups of its dispatch, but not for the data that it reads.
#[test]
fn groups_and_data_of_a_kernel_are_both_waited_for() {
    let Some(mut s) = Setup::new() else { return };
    let bump = Pipeline::<Bump>::new(&s.ctx, &()).unwrap();
    let one = DispatchGroups { x: 1, y: 1, z: 1 };
    let groups = Buffer::from_slice(&s.ctx, "groups", &[one]).unwrap();
    for separates in [false, true] {
        let listed = s.listed(|s, rec| {
            if separates {
                rec.separate_works();
            }
            let params = BumpParams {
                count: 3,
                amount: 0,
            };
            let values = groups.cast::<u32>();
            rec.dispatch(&bump, Threads(3), BumpArgs { values: &values }, params);
            s.scale(rec, &s.a, &s.b);
            let args = ScaleArgs {
                source: &s.b,
                target: &s.c,
            };
            let params = ScaleParams {
                count: 64,
                factor: glam::Vec2::ONE,
            };
            rec.dispatch_indirect(&s.scale, (&groups, 0), args, params);
            rec.update(&groups, 0, &[one]);
        });
        let works: Vec<&String> = listed.iter().filter(|l| !l.starts_with("- ")).collect();
        assert_eq!(works, ["bump", "scale", "scale", "update"]);
        let last = &listed[listed.len() - 2];
        let reason = "groups: scale read it (indirect), update writes it (copy)";
        assert!(last.contains(reason), "{last}");
        assert_silent(&s.ctx);
    }
}

/// Catches results that the host reads before they are there.
#[test]
fn the_host_reads_what_was_written_last() {
    let Some(mut s) = Setup::new() else { return };
    let back = Buffer::<f32>::new(&s.ctx, "back", 64, Domain::Readback).unwrap();
    let mut rec = s.frames.begin().unwrap();
    rec.fill(&s.a, 0x3f80_0000);
    rec.copy(&s.a, &back);
    rec.fill(&s.a, 0x4000_0000);
    rec.copy(&s.a, &back);
    s.frames.submit(rec).unwrap();
    let text = panic_text(|| assert_eq!(back.as_slice()[..], [1.0; 64]));
    assert!(
        text.contains("a frame that uses it has not finished"),
        "{text}"
    );
    s.frames.wait_idle().unwrap();
    assert_eq!(back.as_slice()[..], [2.0; 64]);
    assert_silent(&s.ctx);
}

/// Catches a time that covers two kernels: to have its own time, a kernel must wait for the one before.
#[test]
fn kernels_that_could_overlap_are_separated_to_be_timed() {
    let Some(mut s) = Setup::new() else { return };
    let listed = s.listed(|s, rec| {
        rec.separate_works();
        s.scale(rec, &s.a, &s.b);
        s.scale(rec, &s.a, &s.c);
    });
    assert_eq!(listed, ["scale", "- ", "scale"]);
    assert_silent(&s.ctx);
}

/// Catches a dispatch whose groups are uninitialised memory.
#[test]
fn groups_that_nothing_has_written_are_refused() {
    let Some(mut s) = Setup::new() else { return };
    let groups = Buffer::<DispatchGroups>::new(&s.ctx, "how often", 1, Domain::Device).unwrap();
    let mut rec = s.frames.begin().unwrap();
    let args = ScaleArgs {
        source: &s.a,
        target: &s.b,
    };
    let params = ScaleParams {
        count: 64,
        factor: glam::Vec2::ONE,
    };
    let text = panic_text(|| rec.dispatch_indirect(&s.scale, (&groups, 0), args, params));
    assert_eq!(
        text,
        "`how often` says how often `scale` runs, and nothing has been written to it"
    );
}

/// Catches unneeded barriers within a group, missing ones before it, and works after it that begin too early.
#[test]
fn kernels_in_no_order_wait_for_what_comes_before_them_only() {
    let watched = |validation| ContextOptions {
        validation,
        ..ContextOptions::default()
    };
    for validation in [false, true] {
        let Some(mut s) = Setup::with_just(watched(validation)) else {
            return;
        };
        let d = Buffer::zeroed(&s.ctx, "fourth", 64).unwrap();
        let listed = s.listed(|s, rec| {
            s.scale(rec, &s.c, &s.a);
            rec.begin_unordered("each has its half", &[&s.b]);
            s.scale(rec, &s.a, &s.b);
            s.scale(rec, &d, &s.b);
            rec.end_unordered();
            s.scale(rec, &s.b, &s.c);
        });
        let mut expected = vec![
            "scale",
            "in no order: each has its half",
            "- first: scale wrote it (kernel), scale reads it (kernel)",
            "scale",
            "- second: scale wrote it (kernel), scale writes it (kernel)",
            "scale",
            "in order",
            "- second: scale wrote it (kernel), scale reads it (kernel)",
            "scale",
        ];
        if !validation {
            expected.remove(4);
        }
        assert_eq!(listed, expected);
        assert_silent(&s.ctx);
    }
}

/// Catches an unordered group whose kernels do depend on each other, also if a barrier happens to be between them.
#[test]
fn kernels_that_depend_on_each_other_are_refused_in_one_group() {
    let Some(mut s) = Setup::new() else { return };
    let d = Buffer::zeroed(&s.ctx, "fourth", 64).unwrap();
    let mut refused = |second: &dyn Fn(&Setup, &mut Recorder)| {
        let mut rec = s.frames.begin().unwrap();
        rec.begin_unordered("each is said to be alone", &[&s.c]);
        s.scale(&mut rec, &s.a, &s.c);
        s.scale(&mut rec, &s.a, &s.b);
        s.scale(&mut rec, &d, &s.c);
        panic_text(|| second(&s, &mut rec))
    };
    assert_eq!(
        refused(&|s, rec| s.scale(rec, &d, &s.b)),
        "`scale` writes `second`, which `scale` writes, and the two are in no order: each is said to be alone"
    );
    assert_eq!(
        refused(&|s, rec| s.scale(rec, &s.b, &s.c)),
        "`scale` reads `second`, which `scale` writes, and the two are in no order: each is said to be alone"
    );
    assert_eq!(
        refused(&|s, rec| s.scale(rec, &d, &s.a)),
        "`scale` writes `first`, which `scale` reads, and the two are in no order: each is said to be alone"
    );
    // Copies write whole ranges: a copy in a group must not write a buffer that its kernels write.
    assert_eq!(
        refused(&|s, rec| rec.fill(&s.c, 0)),
        "`fill` writes `third`, which `scale` writes, and the two are in no order: each is said to be alone"
    );
    assert_eq!(
        refused(&|_, rec| rec.begin_unordered("another one", &[])),
        "an unordered group lies within another one: another one"
    );
    let mut rec = s.frames.begin().unwrap();
    rec.begin_unordered("each is said to be alone", &[&s.c]);
    rec.fill(&s.c, 0);
    assert_eq!(
        panic_text(|| s.scale(&mut rec, &s.a, &s.c)),
        "`scale` writes `third`, which `fill` writes, and the two are in no order: each is said to be alone"
    );
    drop(rec);
}

#[test]
fn one_buffer_is_not_bound_twice_to_be_written() {
    let Some(mut s) = Setup::new() else { return };
    let mut rec = s.frames.begin().unwrap();
    let text = panic_text(|| s.scale(&mut rec, &s.a, &s.a));
    assert_eq!(
        text,
        "`scale` binds the buffer `first` twice, as source and as target, and writes it"
    );
}

/// Catches unneeded barriers for the dummy buffers of absent arguments, and a validation layer that counts them as written.
#[test]
fn arguments_may_be_absent() {
    let Some(mut s) = Setup::new() else { return };
    let buffer = |name| Buffer::from_slice(&s.ctx, name, &[1_u32; 64]).unwrap();
    let [source, a, b, words, more, sums] =
        ["source", "a", "b", "words", "more", "sums"].map(buffer);
    let floats = Buffer::from_slice(&s.ctx, "floats", &[2_f32; 64]).unwrap();
    let (float_texels, word_texels) = (
        Texels::new(&floats, 1).unwrap(),
        Texels::new(&words, 1).unwrap(),
    );
    let pipeline = |reads, adds| {
        Pipeline::<Optional>::new(&s.ctx, &OptionalConstants { reads, adds }).unwrap()
    };
    let [copy, reads, all] =
        [(false, false), (true, false), (true, true)].map(|(reads, adds)| pipeline(reads, adds));
    let params = OptionalParams { count: 64 };
    let absent = |target| OptionalArgs {
        source: &source,
        target,
        floats: None,
        words: None,
        more: None,
        sums: None,
    };
    let with_reads = |target| OptionalArgs {
        floats: Some(&float_texels),
        words: Some(&word_texels),
        more: Some(&more),
        ..absent(target)
    };
    let listed = s.listed(|_, rec| {
        rec.dispatch(&copy, Threads(64), absent(&a), params);
        rec.dispatch(&copy, Threads(64), absent(&b), params);
    });
    assert_eq!(listed, ["optional", "optional"]);
    assert_eq!(s.ctx.download(&b).unwrap(), [1; 64]);
    s.listed(|_, rec| rec.dispatch(&reads, Threads(64), with_reads(&a), params));
    assert_eq!(s.ctx.download(&a).unwrap(), [5; 64]);
    let args = OptionalArgs {
        sums: Some(&sums),
        ..with_reads(&a)
    };
    s.listed(|_, rec| rec.dispatch(&all, Threads(64), args, params));
    assert_eq!(s.ctx.download(&sums).unwrap(), [6; 64]);
    assert_silent(&s.ctx);
}

#[test]
fn a_slice_that_the_host_holds_does_not_change() {
    let Some(mut s) = Setup::new() else { return };
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

/// Catches a buffer that counts as free because the last recording that uses it was dropped.
#[test]
fn a_dropped_recording_does_not_hide_one_that_runs() {
    let Some(mut s) = Setup::new() else { return };
    let back = Buffer::<f32>::new(&s.ctx, "back", 64, Domain::Readback).unwrap();
    let mut others = Frames::new(&s.ctx, 1).unwrap();
    let mut rec = s.frames.begin().unwrap();
    rec.copy(&s.a, &back);
    let mut other = others.begin().unwrap();
    other.copy(&s.b, &back);
    drop(other);
    let text = panic_text(|| s.ctx.fill(&back, 0).unwrap());
    assert!(text.contains("still being recorded"), "{text}");
    s.frames.submit(rec).unwrap();
    assert!(back.is_in_use());
    let text = panic_text(|| drop(back.as_slice()));
    assert!(
        text.contains("a frame that uses it has not finished"),
        "{text}"
    );
    s.frames.wait_idle().unwrap();
    assert!(!back.is_in_use());
    assert_eq!(back.as_slice()[..], [0.0; 64]);
    assert_silent(&s.ctx);
}

/// Catches handles of one device that are given to another one.
#[test]
fn buffers_of_another_context_are_refused() {
    let Some(mut s) = Setup::new() else { return };
    let Some(another) = context() else { return };
    let foreign = Buffer::<f32>::zeroed(&another, "foreign", 64).unwrap();
    let mut rec = s.frames.begin().unwrap();
    let mut texts = vec![
        panic_text(|| rec.copy(&foreign, &s.a)),
        panic_text(|| rec.fill(&foreign, 0)),
        panic_text(|| s.scale(&mut rec, &s.a, &foreign)),
    ];
    drop(rec);
    texts.push(panic_text(|| s.ctx.fill(&foreign, 0).unwrap()));
    texts.push(panic_text(|| s.ctx.upload(&foreign, &[1.0]).unwrap()));
    texts.push(panic_text(|| drop(s.ctx.download(&foreign))));
    assert_eq!(texts, ["`foreign` belongs to another context"; 6]);
    assert_silent(&s.ctx);
}

/// Catches first contents that are copied to buffers which the kernel no longer writes, and which may be gone.
#[test]
fn a_kernel_that_writes_other_buffers_does_not_run_alone() {
    let Some(mut s) = Setup::new() else { return };
    let mut rec = s.frames.begin().unwrap();
    let alone = rec.record_before("scale", |rec| s.scale(rec, &s.a, &s.b));
    let alone = alone.unwrap().expect("it is recorded");
    s.frames.submit(rec).unwrap();
    let mut rec = s.frames.begin().unwrap();
    let text = panic_text(|| rec.record_alone(&alone, "step", |rec| s.scale(rec, &s.a, &s.c)));
    assert!(text.contains("`scale` writes other buffers"), "{text}");
    drop(rec);
    let mut rec = s.frames.begin().unwrap();
    rec.record_alone(&alone, "step", |rec| s.scale(rec, &s.a, &s.b));
    s.frames.submit(rec).unwrap();
    s.frames.wait_idle().unwrap();
    assert_silent(&s.ctx);
}

/// Catches a kernel that would read or write beyond the end of a buffer, which drivers do not report.
#[test]
fn a_buffer_that_is_too_short_for_its_dispatch_is_an_error_with_both_names() {
    let Some(mut s) = Setup::with(ContextOptions {
        hazard_check: Some(false),
        ..ContextOptions::default()
    }) else {
        return;
    };
    let short = Buffer::zeroed(&s.ctx, "short", 63).unwrap();
    let mut rec = s.frames.begin().unwrap();
    let text = panic_text(|| s.scale(&mut rec, &s.a, &short));
    assert!(
        text.contains(
            "`scale` runs 64 invocations, which need 64 elements of target, and `short` has 63"
        ),
        "{text}"
    );
    drop(rec);
}

/// If this fails, the validation layer is not watching, and every other test's silence means nothing.
#[test]
fn the_validation_layer_sees_a_barrier_that_is_left_out() {
    let left_out = ContextOptions {
        leave_out: Some(0),
        ..ContextOptions::default()
    };
    let Some(mut s) = Setup::with(left_out) else {
        return;
    };
    s.listed(|s, rec| {
        s.scale(rec, &s.a, &s.b);
        s.scale(rec, &s.b, &s.c);
    });
    let messages = s.ctx.take_messages();
    assert!(
        messages.iter().any(|m| m.contains("READ_AFTER_WRITE")),
        "{messages:?}"
    );
    assert_silent(&s.ctx);
}

#[test]
fn a_transfer_does_not_overtake_a_frame_that_is_being_recorded() {
    let Some(mut s) = Setup::new() else { return };
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
