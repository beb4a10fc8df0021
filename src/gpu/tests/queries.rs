//! Frames of changing length in the same place of the ring: each resets only the queries that the one before it has written.

use std::time::Duration;

use super::selftest::*;
use super::*;

fn record(rec: &mut Recorder, spin: &Pipeline<Spin>, values: &Buffer<u32>, kernels: usize) {
    for _ in 0..kernels {
        let params = SpinParams {
            count: 64,
            rounds: 10,
        };
        rec.dispatch(spin, Threads(64), SpinArgs { values }, params);
    }
}

#[test]
fn longer_and_shorter_frames_and_those_that_are_dropped_leave_times_whole() {
    let Some(ctx) = context() else { return };
    let spin = Pipeline::<Spin>::new(&ctx, &()).unwrap();
    let values = Buffer::<u32>::zeroed(&ctx, "values", 64).unwrap();
    let mut frames = Frames::new(&ctx, 1).unwrap();
    // A dropped frame has written no queries, but would have reset those of the one before it.
    for (kernels, is_dropped) in [
        (1, true),
        (9, false),
        (2, false),
        (12, true),
        (12, false),
        (0, false),
        (12, false),
    ] {
        frames.timings_mut().clear();
        let mut rec = frames.begin().unwrap();
        frames.timings_mut().clear();
        record(&mut rec, &spin, &values, kernels);
        if is_dropped {
            continue;
        }
        frames.submit(rec).unwrap();
        frames.wait_idle().unwrap();
        if ctx.info().has_timestamps() {
            let report = frames.timings().report("frame");
            let times: Vec<f64> = report.rows.iter().map(|row| row.time.min_ms).collect();
            assert_eq!(times.len(), kernels.min(1));
            assert!(times.iter().all(|ms| *ms > 0.0), "{times:?}");
            let spans = frames.timings().frames().map(<[_]>::len);
            assert_eq!(spans.sum::<usize>(), 1 + kernels);
        }
    }
    assert_silent(&ctx);
}

/// Time that a frame waits for the device is no part of the host's work.
#[test]
fn time_spent_waiting_for_the_device_is_reported() {
    let Some(ctx) = context() else { return };
    let spin = Pipeline::<Spin>::new(&ctx, &()).unwrap();
    let values = Buffer::<u32>::zeroed(&ctx, "values", 4096).unwrap();
    let mut frames = Frames::new(&ctx, 1).unwrap();
    let rec = frames.begin().unwrap();
    assert_eq!(frames.waited(), Duration::ZERO, "no frame was waited for");
    frames.submit(rec).unwrap();
    let mut rec = frames.begin().unwrap();
    let params = SpinParams {
        count: 4096,
        rounds: 60_000,
    };
    let args = SpinArgs { values: &values };
    rec.dispatch(&spin, Threads(4096), args, params);
    frames.submit(rec).unwrap();
    let begun = std::time::Instant::now();
    let rec = frames.begin().unwrap();
    let whole = begun.elapsed();
    let waited = frames.waited();
    assert!(
        waited <= whole && waited * 2 > whole,
        "{waited:?} of {whole:?}"
    );
    frames.submit(rec).unwrap();
    frames.wait_idle().unwrap();
    assert_silent(&ctx);
}
