//! References for measured times: the device's copy bandwidth, by its own copies and by a kernel, and warming a device up to a steady
//! speed.

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::UVec4;

use super::kernels::{CopyWords, CopyWordsArgs, CopyWordsParams};
use crate::gpu::{
    Buffer, Context, CopyBandwidth, DeviceKind, Domain, Frames, GpuError, Pipeline, Recorder,
    Threads,
};

/// The fastest way of copying on the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CopiedBy {
    /// Its own copies.
    Copies,
    /// A kernel, four words an invocation.
    Kernel,
}

/// How fast the device copies from buffer to buffer by the faster method, measured so many times, after [warming up](keep_busy). `None` if
/// it has no timestamps, or ones that are too coarse.
///
/// # Errors
/// When the device has no memory left, or is lost.
pub fn copy_bandwidth(
    ctx: &Arc<Context>,
    runs: usize,
) -> Result<Option<(CopyBandwidth, CopiedBy)>, GpuError> {
    keep_busy(ctx)?;
    let copies = CopyBandwidth::measure(ctx, runs, Recorder::copy)?;
    let pipeline = Pipeline::new(ctx, &())?;
    let by_kernel = CopyBandwidth::measure(ctx, runs, |rec, source, target| {
        copy_by_kernel(&pipeline, rec, source, target);
    })?;
    Ok(faster(copies, by_kernel))
}

fn faster(
    copies: Option<CopyBandwidth>,
    by_kernel: Option<CopyBandwidth>,
) -> Option<(CopyBandwidth, CopiedBy)> {
    let both = [(copies, CopiedBy::Copies), (by_kernel, CopiedBy::Kernel)];
    let measured = both.into_iter().filter_map(|(of, by)| Some((of?, by)));
    measured.max_by(|(a, _), (b, _)| a.bytes_per_second().total_cmp(&b.bytes_per_second()))
}

fn copy_by_kernel(
    pipeline: &Pipeline<CopyWords>,
    rec: &mut Recorder,
    source: &Buffer<u32>,
    target: &Buffer<u32>,
) {
    let quad_count = (source.len() / 4) as u32;
    let args = CopyWordsArgs {
        source: &source.cast::<UVec4>(),
        target: &target.cast::<UVec4>(),
    };
    let params = CopyWordsParams { quad_count };
    rec.dispatch(pipeline, Threads(quad_count), args, params);
}

/// How long a device was kept busy before anything was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeptBusy {
    /// Seconds.
    pub seconds: f64,
    /// Were its times steady at the end?
    pub is_steady: bool,
}

/// A graphics card's clock rises once it has something to do, which takes longer than a few short steps.
const LONGEST: Duration = Duration::from_secs(3);
const SHORTEST: Duration = Duration::from_millis(100);
/// Words that a copy copies: more than caches hold.
const WORDS: usize = 16 << 20;
/// How long a round of copies takes, about.
const ROUND_MS: f64 = 25.0;
const MOST_COPIES: usize = 1000;
/// Rounds that are to agree, and how well: the slowest takes no more than so many times as long as the fastest.
const ROUNDS: usize = 8;
const AGREEMENT: f64 = 1.02;

/// Keeps a graphics card busy until its times are steady, for 3 seconds at the most. `None` for drivers that run on processors, for devices
/// without timestamps, and if there is no memory for it.
///
/// # Errors
/// When the device is lost.
pub fn keep_busy(ctx: &Arc<Context>) -> Result<Option<KeptBusy>, GpuError> {
    let info = ctx.info();
    if info.kind == DeviceKind::Cpu || !info.has_timestamps() {
        return Ok(None);
    }
    match keep_busy_for(ctx, SHORTEST..LONGEST) {
        Err(GpuError::OutOfMemory { .. }) => Ok(None),
        kept => kept.map(Some),
    }
}

/// As [`keep_busy`], on any device, for a duration in the given range.
///
/// # Errors
/// When the device has no memory left, or is lost.
pub fn keep_busy_for(
    ctx: &Arc<Context>,
    time: std::ops::Range<Duration>,
) -> Result<KeptBusy, GpuError> {
    let pipeline = Pipeline::new(ctx, &())?;
    let buffer = |name| Buffer::<u32>::new(ctx, name, WORDS, Domain::Device);
    let (source, target) = (buffer("busy.source")?, buffer("busy.target")?);
    ctx.fill(&source, 0x5eed_5eed)?;
    let mut frames = Frames::new(ctx, 2)?;
    let mut rounds: Vec<f64> = Vec::new();
    let mut copies = 1;
    let begun = Instant::now();
    loop {
        frames.run(|rec| {
            rec.scope("round", |rec| {
                for _ in 0..copies {
                    copy_by_kernel(&pipeline, rec, &source, &target);
                }
            })
        })?;
        let spans = frames.timings().frames().last();
        let round = spans.and_then(|spans| spans.iter().find(|span| span.name == "round"));
        // The time of a copy.
        rounds.extend(round.map(|round| round.ms() / copies as f64));
        copies = rounds.last().map_or(1, |&ms| {
            ((ROUND_MS / ms.max(1e-6)) as usize).clamp(1, MOST_COPIES)
        });
        let elapsed = begun.elapsed();
        let is_steady = is_steady(&rounds);
        if elapsed >= time.end || (elapsed >= time.start && is_steady) {
            return Ok(KeptBusy {
                seconds: elapsed.as_secs_f64(),
                is_steady,
            });
        }
    }
}

/// Do the last rounds take equally long?
fn is_steady(rounds: &[f64]) -> bool {
    let Some(last) = rounds.len().checked_sub(ROUNDS) else {
        return false;
    };
    let last = &rounds[last..];
    let least = last.iter().copied().fold(f64::INFINITY, f64::min);
    let most = last.iter().copied().fold(0.0, f64::max);
    least > 0.0 && most <= AGREEMENT * least
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Catches a device that is taken for steady while its clock still rises, and one that is never steady.
    #[test]
    fn a_device_is_steady_once_its_rounds_agree() {
        assert!(!is_steady(&[1.0; 7]));
        let mut rounds = vec![9.0, 1.0, 1.01, 1.0, 1.02, 1.0, 1.0, 1.01, 1.0];
        assert!(is_steady(&rounds));
        rounds.push(1.03);
        assert!(!is_steady(&rounds));
        let rises: Vec<f64> = (0..60).map(|k| 1.0 + 2.0 * 0.8_f64.powi(k)).collect();
        let steady = (0..rises.len()).find(|&end| is_steady(&rises[..end]));
        assert!(steady.is_some_and(|end| rises[end] < 1.02), "{steady:?}");
        let slowly: Vec<f64> = (0..60).map(|k| 0.997_f64.powi(k)).collect();
        assert!((0..slowly.len()).all(|end| !is_steady(&slowly[..end])));
    }

    /// Catches a reference that is the slower one of the two methods.
    #[test]
    fn the_faster_way_to_copy_counts() {
        let of = |ms: f64| {
            Some(CopyBandwidth {
                size_in_bytes: 1 << 20,
                runs: 1,
                time: crate::gpu::Statistics::of(vec![ms]),
            })
        };
        let by = |copies, kernel| faster(copies, kernel).map(|(_, by)| by);
        assert_eq!(by(of(1.0), of(2.0)), Some(CopiedBy::Copies));
        assert_eq!(by(of(2.0), of(1.0)), Some(CopiedBy::Kernel));
        assert_eq!(by(None, of(1.0)), Some(CopiedBy::Kernel));
        assert_eq!(by(None, None), None);
    }
}
