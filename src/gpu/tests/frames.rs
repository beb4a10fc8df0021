//! Frames in flight, times, breadcrumbs, readback and clocks.

use std::time::{Duration, Instant};

use super::selftest::*;
use super::*;
use crate::gpu::frame::FIRST_QUERIES;
use crate::gpu::{Span, SpanKind, Timings};

/// Longer than any work in these tests.
const LONG: Duration = Duration::from_secs(100);

#[test]
fn times_form_a_tree_and_add_up() {
    let Some(ctx) = context_with(ContextOptions::default()) else {
        return;
    };
    let spin = Pipeline::<Spin>::new(&ctx, &()).unwrap();
    let bump = Pipeline::<Bump>::new(&ctx, &()).unwrap();
    let values = Buffer::<u32>::zeroed(&ctx, "values", 4096).unwrap();
    let mut frames = Frames::new(&ctx, 2).unwrap();
    for _ in 0..3 {
        let mut rec = frames.begin().unwrap();
        for _ in 0..2 {
            rec.scope("step", |rec| {
                rec.scope("inner", |rec| {
                    let params = SpinParams {
                        count: 4096,
                        rounds: 1000,
                    };
                    rec.dispatch(&spin, Threads(4096), SpinArgs { values: &values }, params);
                });
                let params = BumpParams {
                    count: 4096,
                    amount: 1,
                };
                rec.dispatch(&bump, Threads(4096), BumpArgs { values: &values }, params);
            });
        }
        frames.submit(rec).unwrap();
    }
    frames.wait_idle().unwrap();
    if !ctx.info().has_timestamps() {
        assert!(frames.timings().report("step").is_empty());
        return;
    }
    let report = frames.timings().report("step");
    assert_eq!(report.steps, 6);
    let tree: Vec<_> = report
        .tree
        .iter()
        .map(|n| (n.name.as_str(), n.depth, n.per_step))
        .collect();
    assert_eq!(
        tree,
        [("inner", 0, 1.0), ("spin", 1, 1.0), ("bump", 0, 1.0)]
    );
    assert_eq!(report.rows[0].name, "spin");
    assert!(report.rows[0].time.mean_ms > 0.0);
    let sum: f64 = report.rows.iter().map(|r| r.time.mean_ms).sum();
    assert!(
        sum <= report.step.mean_ms && sum > 0.5 * report.step.mean_ms,
        "{sum} of {}",
        report.step.mean_ms
    );
    let frame = frames.timings().report("frame");
    assert_eq!(frame.steps, 3);
    assert!(frame.step.mean_ms >= 2.0 * report.step.min_ms);
}

#[test]
fn longer_work_takes_longer() {
    let Some(ctx) = context_with(ContextOptions::default()) else {
        return;
    };
    if !ctx.info().has_timestamps() {
        return;
    }
    let spin = Pipeline::<Spin>::new(&ctx, &()).unwrap();
    let values = Buffer::<u32>::zeroed(&ctx, "values", 64).unwrap();
    let mut frames = Frames::new(&ctx, 1).unwrap();
    let both = [("short", 3_000), ("long", 60_000)];
    for (name, rounds) in [("warm-up", 1)].into_iter().chain([both; 5].concat()) {
        let mut rec = frames.begin().unwrap();
        rec.scope(name, |rec| {
            rec.dispatch(
                &spin,
                Threads(64),
                SpinArgs { values: &values },
                SpinParams { count: 64, rounds },
            );
        });
        frames.submit(rec).unwrap();
    }
    frames.wait_idle().unwrap();
    // The shortest of five: a busy host makes single ones longer.
    let ms = |name| frames.timings().report(name).rows[0].time.min_ms;
    assert!(
        ms("long") > 3.0 * ms("short"),
        "{} and {} ms",
        ms("long"),
        ms("short")
    );
}

#[test]
fn a_frame_with_more_spans_than_queries_gets_more_the_next_time() {
    let Some(ctx) = context() else { return };
    let bump = Pipeline::<Bump>::new(&ctx, &()).unwrap();
    let values = Buffer::<u32>::zeroed(&ctx, "values", 1).unwrap();
    let mut frames = Frames::new(&ctx, 1).unwrap();
    // Two queries a span; the frame is one, too.
    let fit = FIRST_QUERIES / 2;
    let dispatches = fit + 100;
    for _ in 0..2 {
        let mut rec = frames.begin().unwrap();
        for _ in 0..dispatches {
            rec.dispatch(
                &bump,
                Threads(1),
                BumpArgs { values: &values },
                BumpParams {
                    count: 1,
                    amount: 1,
                },
            );
        }
        frames.submit(rec).unwrap();
    }
    frames.wait_idle().unwrap();
    if ctx.info().has_timestamps() {
        let lengths: Vec<_> = frames.timings().frames().map(<[Span]>::len).collect();
        assert_eq!(lengths, [fit as usize, dispatches as usize + 1]);
    }
    assert_eq!(ctx.download(&values).unwrap(), [2 * dispatches]);
    assert_silent(&ctx);
}

#[test]
fn a_hang_is_blamed_on_its_kernel() {
    let options = ContextOptions {
        timeout: Duration::from_millis(100),
        ..ContextOptions::default()
    };
    let Some(ctx) = context_with(options) else {
        return;
    };
    let (spin, bump) = (
        Pipeline::<Spin>::new(&ctx, &()).unwrap(),
        Pipeline::<Bump>::new(&ctx, &()).unwrap(),
    );
    let count = 4096;
    let values = Buffer::<u32>::zeroed(&ctx, "values", count as usize).unwrap();
    let mut frames = Frames::new(&ctx, 1).unwrap();
    let mut rec = frames.begin().unwrap();
    rec.dispatch(
        &bump,
        Threads(64),
        BumpArgs { values: &values },
        BumpParams {
            count: 64,
            amount: 1,
        },
    );
    // This takes seconds on a processor; a fast device may finish, and then there is no error.
    rec.dispatch(
        &spin,
        Threads(count),
        SpinArgs { values: &values },
        SpinParams {
            count,
            rounds: 60_000,
        },
    );
    rec.dispatch(
        &bump,
        Threads(64),
        BumpArgs { values: &values },
        BumpParams {
            count: 64,
            amount: 1,
        },
    );
    frames.submit(rec).unwrap();
    if let Err(error) = frames.wait_idle() {
        assert!(matches!(error, GpuError::Timeout { .. }), "{error}");
        let text = error.to_string();
        assert!(
            text.contains("the last kernel begun was `spin`, number 2 of 3 in its frame"),
            "{text}"
        );
        let again = ctx.wait_idle();
        assert!(
            again.is_ok() || matches!(again, Err(GpuError::Timeout { .. })),
            "{again:?}"
        );
        // With more time it finishes.
        let _patience = ctx.wait_longer(LONG);
        ctx.wait_idle().unwrap();
        frames.wait_idle().unwrap();
    } else {
        assert!(
            ctx.info().kind != DeviceKind::Cpu,
            "a processor cannot be that fast"
        );
    }
}

/// A caller can extend the timeout for a long frame.
#[test]
fn the_timeout_can_be_extended() {
    let options = ContextOptions {
        timeout: Duration::from_millis(1),
        ..ContextOptions::default()
    };
    let Some(ctx) = context_with(options) else {
        return;
    };
    let patience = ctx.wait_longer(Duration::from_secs(600));
    drop(ctx.wait_longer(Duration::MAX));
    assert_eq!(ctx.timeout(), Duration::from_millis(600_001));
    let spin = Pipeline::<Spin>::new(&ctx, &()).unwrap();
    let count = 4096;
    let values = Buffer::<u32>::zeroed(&ctx, "values", count as usize).unwrap();
    let mut frames = Frames::new(&ctx, 1).unwrap();
    let mut rec = frames.begin().unwrap();
    let rounds = 6000;
    let (threads, values) = (Threads(count), SpinArgs { values: &values });
    rec.dispatch(&spin, threads, values, SpinParams { count, rounds });
    frames.submit(rec).unwrap();
    frames.wait_idle().unwrap();
    drop(patience);
    assert_eq!(ctx.timeout(), Duration::from_millis(1));
    assert_silent(&ctx);
}

#[test]
fn objects_outlive_their_owners_while_a_frame_uses_them() {
    let Some(ctx) = context() else { return };
    let mut frames = Frames::new(&ctx, 2).unwrap();
    let back = Buffer::<u32>::new(&ctx, "back", 64, Domain::Readback).unwrap();
    let mut rec = frames.begin().unwrap();
    {
        let bump = Pipeline::<Bump>::new(&ctx, &()).unwrap();
        let values = Buffer::<u32>::zeroed(&ctx, "values", 64).unwrap();
        rec.dispatch(
            &bump,
            Threads(64),
            BumpArgs { values: &values },
            BumpParams {
                count: 64,
                amount: 5,
            },
        );
        rec.copy(&values, &back);
    }
    frames.submit(rec).unwrap();
    // A frame runs to its end after its ring is dropped.
    drop(frames);
    ctx.wait_idle().unwrap();
    let mut frames = Frames::new(&ctx, 1).unwrap();
    drop(frames.begin().unwrap());
    assert_eq!(back.as_slice()[..], [5; 64]);
    assert_silent(&ctx);
}

#[test]
fn results_are_read_back_some_frames_later() {
    let Some(ctx) = context() else { return };
    let bump = Pipeline::<Bump>::new(&ctx, &()).unwrap();
    let values = Buffer::<u32>::zeroed(&ctx, "values", 3).unwrap();
    let mut frames = Frames::new(&ctx, 2).unwrap();
    let mut readback = Readback::<u32>::new(&ctx, "values", 3, 3).unwrap();
    let mut found = Vec::new();
    for step in 0..10 {
        let mut rec = frames.begin().unwrap();
        rec.dispatch(
            &bump,
            Threads(3),
            BumpArgs { values: &values },
            BumpParams {
                count: 3,
                amount: 1,
            },
        );
        assert!(readback.record(&mut rec, &values, step));
        frames.submit(rec).unwrap();
        found.extend(readback.poll());
    }
    frames.wait_idle().unwrap();
    found.extend(std::iter::from_fn(|| readback.poll()));
    let expected: Vec<_> = (0..10)
        .map(|step| (step, vec![step as u32 + 1; 3]))
        .collect();
    assert_eq!(found, expected);
    // A dropped frame returns no copies.
    let mut rec = frames.begin().unwrap();
    assert!(readback.record(&mut rec, &values, 99));
    drop(rec);
    assert_eq!(readback.poll(), None);
    assert_silent(&ctx);
}

#[test]
fn host_and_device_share_a_clock() {
    let Some(ctx) = context() else { return };
    let values = Buffer::<u32>::zeroed(&ctx, "values", 1 << 20).unwrap();
    let mut frames = Frames::new(&ctx, 1).unwrap();
    let mut trace = Trace::new();
    let epoch = Instant::now();
    trace.span("frame", |trace| {
        let mut rec = frames.begin().unwrap();
        trace.span("record", |_| rec.fill(&values, 1));
        frames.submit(rec).unwrap();
        frames.wait_idle().unwrap();
    });
    let end = epoch.elapsed().as_nanos() as f64;
    let calibration = ctx.calibrate().unwrap();
    if let (Some(calibration), Some(spans)) = (&calibration, frames.timings().frames().next()) {
        let slack = calibration.deviation_ns + 1e6;
        for span in spans {
            let (begin, finish) = (
                calibration.since(epoch, span.begin_ns),
                calibration.since(epoch, span.end_ns),
            );
            assert!(
                -slack < begin && begin <= finish && finish < end + slack,
                "{} in 0 to {end}: {begin} to {finish}",
                span.name
            );
        }
    }
    let mut text = Vec::new();
    trace
        .write(&mut text, frames.timings(), calibration.as_ref())
        .unwrap();
    let json: serde_json::Value = serde_json::from_slice(&text).unwrap();
    let names: Vec<_> = json["traceEvents"]
        .as_array()
        .unwrap()
        .iter()
        .map(|e| e["name"].as_str().unwrap())
        .collect();
    assert_eq!(
        names[..4],
        ["thread_name", "thread_name", "frame", "record"]
    );
    assert_silent(&ctx);
}

#[test]
fn other_frames_come_between_slices_and_their_time_is_not_counted() {
    let Some(ctx) = context_with(ContextOptions::default()) else {
        return;
    };
    let spin = Pipeline::<Spin>::new(&ctx, &()).unwrap();
    let bump = Pipeline::<Bump>::new(&ctx, &()).unwrap();
    const COUNT: u32 = 1000;
    let values = Buffer::<u32>::zeroed(&ctx, "values", COUNT as usize).unwrap();
    let other = Buffer::<u32>::zeroed(&ctx, "other", COUNT as usize).unwrap();
    let mut frames = Frames::new(&ctx, 1).unwrap();
    let mut between = Frames::new(&ctx, 1).unwrap();
    let bumped = |rec: &mut Recorder, amount| {
        let params = BumpParams {
            count: COUNT,
            amount,
        };
        rec.dispatch(&bump, Threads(COUNT), BumpArgs { values: &values }, params);
    };
    for round in 1..=2 {
        let mut rec = frames.begin().unwrap();
        rec.slice(LONG, &Timings::default());
        rec.scope("step", |rec| {
            for amount in [1, 10, 100] {
                bumped(rec, amount);
            }
        });
        let mut seen = Vec::new();
        loop {
            // A frame of another ring, on another buffer.
            let mut answer = between.begin().unwrap();
            let params = SpinParams {
                count: COUNT,
                rounds: 10_000,
            };
            answer.dispatch(&spin, Threads(COUNT), SpinArgs { values: &other }, params);
            between.submit(answer).unwrap();
            between.wait_idle().unwrap();
            if !frames.run_slice(&mut rec).unwrap() {
                break;
            }
            seen.push(seen.len());
        }
        assert_eq!(seen.len(), 3, "a slice a kernel");
        frames.submit(rec).unwrap();
        frames.wait_idle().unwrap();
        assert_eq!(
            ctx.download(&values).unwrap(),
            [111 * round; COUNT as usize]
        );
        if ctx.info().has_timestamps() {
            let ms = |frames: &Frames, name| {
                let spans = frames.timings().frames().last().unwrap();
                let of_name = spans.iter().filter(|span| span.name == name);
                of_name.map(Span::ms).sum::<f64>()
            };
            let (step, answer) = (ms(&frames, "step"), ms(&between, "spin"));
            assert!(ms(&frames, "bump") <= step + 1e-6, "the kernels lie in it");
            assert!(
                step < 0.5 * answer,
                "{step} ms with {answer} ms between any two"
            );
            assert!(
                ms(&frames, "frame") < 0.5 * answer,
                "the frame has the same gaps"
            );
        }
    }
    assert_eq!(ctx.messages(), [""; 0]);
}

#[test]
fn what_is_left_of_slices_is_submitted_with_the_frame() {
    let Some(ctx) = context_with(ContextOptions::default()) else {
        return;
    };
    let bump = Pipeline::<Bump>::new(&ctx, &()).unwrap();
    let values = Buffer::<u32>::zeroed(&ctx, "values", 65).unwrap();
    let mut frames = Frames::new(&ctx, 2).unwrap();
    for run in [0, 1, 4] {
        let mut rec = frames.begin().unwrap();
        rec.slice(LONG, &Timings::default());
        for _ in 0..4 {
            let params = BumpParams {
                count: 65,
                amount: 1,
            };
            rec.dispatch(&bump, Threads(65), BumpArgs { values: &values }, params);
        }
        for _ in 0..run {
            assert!(frames.run_slice(&mut rec).unwrap());
        }
        frames.submit(rec).unwrap();
    }
    frames.wait_idle().unwrap();
    assert_eq!(ctx.download(&values).unwrap(), [12; 65]);
    assert_eq!(ctx.messages(), [""; 0]);
}

/// Programs that are closed within a step drop a frame of which a part has run.
#[test]
fn the_rest_of_slices_can_be_dropped() {
    let Some(ctx) = context_with(ContextOptions::default()) else {
        return;
    };
    let bump = Pipeline::<Bump>::new(&ctx, &()).unwrap();
    let values = Buffer::<u32>::zeroed(&ctx, "values", 65).unwrap();
    let mut frames = Frames::new(&ctx, 1).unwrap();
    let record = |rec: &mut Recorder| {
        for _ in 0..3 {
            let params = BumpParams {
                count: 65,
                amount: 1,
            };
            rec.dispatch(&bump, Threads(65), BumpArgs { values: &values }, params);
        }
    };
    let mut rec = frames.begin().unwrap();
    rec.slice(LONG, &Timings::default());
    record(&mut rec);
    assert!(frames.run_slice(&mut rec).unwrap());
    drop(rec);
    // Its place in the ring is free, and the slices that ran have their effect.
    let mut rec = frames.begin().unwrap();
    record(&mut rec);
    frames.submit(rec).unwrap();
    frames.wait_idle().unwrap();
    assert_eq!(ctx.download(&values).unwrap(), [4; 65]);
    assert_eq!(ctx.messages(), [""; 0]);
}

/// Would catch: a place in the ring whose commands are recorded anew while the device still executes them.
#[test]
fn a_frame_that_is_dropped_while_a_slice_runs_leaves_its_place() {
    let options = ContextOptions {
        // The layer sees a pool that is reset while it is in use.
        validation: true,
        timeout: Duration::from_millis(1),
        ..ContextOptions::default()
    };
    let Some(ctx) = context_with(options) else {
        return;
    };
    let patience = ctx.wait_longer(LONG);
    let spin = Pipeline::<Spin>::new(&ctx, &()).unwrap();
    let count = 4096;
    let values = Buffer::<u32>::zeroed(&ctx, "values", count as usize).unwrap();
    let other = Buffer::<u32>::zeroed(&ctx, "other", 3).unwrap();
    let mut frames = Frames::new(&ctx, 1).unwrap();
    let mut rec = frames.begin().unwrap();
    rec.slice(LONG, &Timings::default());
    // This takes far longer than a millisecond.
    let params = SpinParams {
        count,
        rounds: 6000,
    };
    for _ in 0..2 {
        rec.dispatch(&spin, Threads(count), SpinArgs { values: &values }, params);
    }
    drop(patience);
    let ran = frames.run_slice(&mut rec);
    assert!(
        ran.is_err() || ctx.info().kind != DeviceKind::Cpu,
        "a processor cannot be that fast"
    );
    drop(rec);
    let _patience = ctx.wait_longer(LONG);
    let mut rec = frames.begin().unwrap();
    rec.fill(&other, 7);
    frames.submit(rec).unwrap();
    frames.wait_idle().unwrap();
    assert_eq!(ctx.download(&other).unwrap(), [7; 3]);
    assert_silent(&ctx);
}

/// Would catch: memory that nothing was copied to, handed out as a copy.
#[test]
fn a_recording_of_one_kernel_alone_has_no_copies() {
    let Some(ctx) = context() else { return };
    let values = Buffer::<u32>::zeroed(&ctx, "values", 3).unwrap();
    let mut readback = Readback::<u32>::new(&ctx, "values", 3, 1).unwrap();
    let mut frames = Frames::new(&ctx, 1).unwrap();
    let mut rec = frames.begin().unwrap();
    let mut was_recorded = true;
    rec.kernels_of(|rec| was_recorded = readback.record(rec, &values, 1));
    frames.submit(rec).unwrap();
    frames.wait_idle().unwrap();
    assert!(!was_recorded);
    assert_eq!(readback.poll(), None);
}

fn kernel_span(name: &str, ms: f64) -> Span {
    Span {
        name: name.to_owned(),
        kind: SpanKind::Kernel,
        parent: None,
        begin_ns: 0.0,
        end_ns: ms * 1e6,
    }
}

/// Also if a dispatch has several rows of groups, and also the second time.
#[test]
fn kernels_that_take_long_are_several_slices() {
    let Some(ctx) = context_with(ContextOptions::default()) else {
        return;
    };
    let bump = Pipeline::<Bump>::new(&ctx, &()).unwrap();
    let mut recent = Timings::default();
    recent.push(vec![
        kernel_span("bump", 1.0),
        kernel_span("bump", 2.5),
        kernel_span("other", 40.0),
    ]);
    let mut frames = Frames::new(&ctx, 1).unwrap();
    // Many groups, one group, and three rows of them.
    let rows = 3 * 64 * ctx.info().max_group_count.min(65_535) - 1000;
    for (count, slices) in [(1000, 3), (65, 2), (64, 1), (rows, 3)] {
        let values = Buffer::<u32>::zeroed(&ctx, "values", count as usize).unwrap();
        for round in 1..=2 {
            let mut rec = frames.begin().unwrap();
            rec.slice(Duration::from_millis(1), &recent);
            let params = BumpParams { count, amount: 1 };
            let args = BumpArgs { values: &values };
            rec.scope("step", |rec| {
                rec.dispatch(&bump, Threads(count), args, params)
            });
            let mut seen = 0;
            while frames.run_slice(&mut rec).unwrap() {
                seen += 1;
            }
            frames.submit(rec).unwrap();
            frames.wait_idle().unwrap();
            let is_divided = ctx.info().kind == DeviceKind::Cpu;
            assert_eq!(seen, if is_divided { slices } else { 1 }, "{count}");
            let now = ctx.download(&values).unwrap();
            assert!(now.iter().all(|&value| value == round), "{count}");
            // One kernel, however many parts it has.
            let spans = frames.timings().frames().last();
            let names = spans.map(|spans| spans.iter().map(|s| s.name.as_str()).collect());
            let whole = ["frame", "step", "bump"];
            assert!(names.is_none_or(|names: Vec<&str>| names == whole));
        }
    }
    assert_eq!(ctx.messages(), [""; 0]);
}

/// Divided dispatches have the largest possible number of invocations, and the kernel skips the unused ones.
#[test]
fn dispatches_that_only_the_device_counts_are_divided_too() {
    let Some(ctx) = context_with(ContextOptions::default()) else {
        return;
    };
    let size_up = Pipeline::<SizeUp>::new(&ctx, &()).unwrap();
    let bump = Pipeline::<Bump>::new(&ctx, &()).unwrap();
    let mut frames = Frames::new(&ctx, 1).unwrap();
    const MOST: u32 = 10_000;
    for count in [0, 1, 700, MOST] {
        let groups = Buffer::<DispatchGroups>::zeroed(&ctx, "groups", 1).unwrap();
        let values = Buffer::<u32>::zeroed(&ctx, "values", MOST as usize).unwrap();
        // The first one is whole, because its time is not known yet; the second one has three parts.
        for slices in [1, 3] {
            let mut rec = frames.begin().unwrap();
            let params = SizeUpParams {
                count,
                group_size: 64,
            };
            let args = SizeUpArgs { groups: &groups };
            rec.dispatch(&size_up, Threads(1), args, params);
            let mut recent = Timings::default();
            if slices > 1 {
                recent.push(vec![kernel_span("bump", 29.0)]);
            }
            rec.slice(Duration::from_millis(10), &recent);
            let params = BumpParams { count, amount: 1 };
            let args = BumpArgs { values: &values };
            rec.dispatch_at_most(&bump, Threads(MOST), (&groups, 0), args, params);
            let mut seen = 0;
            while frames.run_slice(&mut rec).unwrap() {
                seen += 1;
            }
            frames.submit(rec).unwrap();
            frames.wait_idle().unwrap();
            let is_divided = ctx.info().kind == DeviceKind::Cpu;
            assert_eq!(seen, if is_divided { slices } else { 1 }, "{count}");
        }
        let (counted, rest) = (vec![2; count as usize], vec![0; (MOST - count) as usize]);
        assert_eq!(ctx.download(&values).unwrap(), [counted, rest].concat());
    }
    assert_eq!(ctx.messages(), [""; 0]);
}
