//! What times are measured by: a kernel that copies, and a device that is kept busy until its times are steady.

use std::time::Duration;

use glam::UVec4;
use myxo::gpu::{Buffer, Pipeline, Threads};
use myxo::sim::kernels::{CopyWords, CopyWordsArgs, CopyWordsParams};
use myxo::sim::twin;
use myxo::sim::yardstick::{copy_bandwidth, keep_busy_for};

use crate::common::{awkward_sizes, gpu};

#[test]
fn copy_words_agrees_with_its_twin() {
    let Some(gpu) = gpu() else { return };
    let ctx = &gpu.ctx;
    let pipeline = Pipeline::<CopyWords>::new(ctx, &()).unwrap();
    for quad_count in awkward_sizes(256).into_iter().filter(|&count| count > 0) {
        let quad = |i: u32| UVec4::new(i, !i, i.wrapping_mul(77), 5);
        // One more than is copied.
        let words: Vec<UVec4> = (0..=quad_count).map(quad).collect();
        let source = Buffer::from_slice(ctx, "source", &words).unwrap();
        let target = Buffer::<UVec4>::zeroed(ctx, "target", words.len()).unwrap();
        let params = CopyWordsParams { quad_count };
        gpu.run(|rec| {
            let args = CopyWordsArgs {
                source: &source,
                target: &target,
            };
            rec.dispatch(&pipeline, Threads(quad_count), args, params);
        });
        let mut expected = vec![UVec4::ZERO; words.len()];
        twin::copy_words(&params, &words, &mut expected);
        assert_eq!(ctx.download(&target).unwrap(), expected, "{quad_count}");
    }
    gpu.finish();
}

/// Catches copies that are not measured, and a device that is kept busy for ever.
#[test]
fn copies_are_measured_and_the_device_is_kept_busy_for_a_time() {
    let Some(gpu) = gpu() else { return };
    let ctx = &gpu.ctx;
    if let Some((measured, _)) = copy_bandwidth(ctx, 2).unwrap() {
        assert_eq!(measured.runs, 2);
        assert!(measured.bytes_per_second() > 1e6, "{measured:?}");
    }
    let time = Duration::from_millis(1)..Duration::from_millis(50);
    let kept = keep_busy_for(ctx, time).unwrap();
    assert!(kept.seconds >= 0.001, "{kept:?}");
    assert!(kept.is_steady || kept.seconds >= 0.05, "{kept:?}");
    gpu.finish();
}
