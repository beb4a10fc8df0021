//! What times are measured by: how fast the device copies, by its own copies and by a kernel, and a device that has come to the speed
//! at which it stays.

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::UVec4;

use super::kernels::{CopyWords, CopyWordsArgs, CopyWordsParams};
use crate::gpu::{
    Buffer, Context, CopyBandwidth, DeviceKind, Domain, Frames, GpuError, Pipeline, Recorder, Span,
    Threads,
};

/// What the device copies with, fastest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CopiedBy {
    /// Its own copies.
    Copies,
    /// A kernel, four words an invocation.
    Kernel,
}

/// How fast the device copies from buffer to buffer by the faster way, so many times. `None` where it has no timestamps, or ones
/// too coarse to tell.
///
/// # Errors
/// When the device has no memory left, or is lost.
pub fn copy_bandwidth(
    ctx: &Arc<Context>,
    runs: usize,
) -> Result<Option<(CopyBandwidth, CopiedBy)>, GpuError> {
    let copies = CopyBandwidth::measure(ctx, runs, Recorder::copy)?;
    let pipeline = Pipeline::new(ctx, &())?;
    let by_kernel = CopyBandwidth::measure(ctx, runs, |rec, source, target| {
        copy_by_kernel(&pipeline, rec, source, target);
    })?;
    let both = [(copies, CopiedBy::Copies), (by_kernel, CopiedBy::Kernel)];
    let measured = both.into_iter().filter_map(|(of, by)| Some((of?, by)));
    Ok(measured.max_by(|(a, _), (b, _)| a.bytes_per_second().total_cmp(&b.bytes_per_second())))
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
/// Words that a copy copies, and copies in a round.
const WORDS: usize = 4 << 20;
const COPIES: usize = 64;
/// Rounds whose medians are to agree, and how well: the slowest takes so many times as long as the fastest.
const ROUNDS: usize = 4;
const AGREEMENT: f64 = 1.02;

/// Keeps a graphics card busy until its times are steady, for 3 seconds at the most. `None` where that means nothing: for drivers
/// that run on processors, and devices without timestamps.
///
/// # Errors
/// When the device has no memory left, or is lost.
pub fn keep_busy(ctx: &Arc<Context>) -> Result<Option<KeptBusy>, GpuError> {
    let info = ctx.info();
    if info.kind == DeviceKind::Cpu || !info.has_timestamps() {
        return Ok(None);
    }
    keep_busy_for(ctx, SHORTEST..LONGEST).map(Some)
}

/// The same on any device, for so long at least and at the most.
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
    let begun = Instant::now();
    loop {
        let mut rec = frames.begin()?;
        rec.scope("round", |rec| {
            for _ in 0..COPIES {
                copy_by_kernel(&pipeline, rec, &source, &target);
            }
        });
        frames.submit(rec)?;
        frames.wait_idle()?;
        let spans = frames.timings().frames().last();
        let round = spans.and_then(|spans| spans.iter().find(|span| span.name == "round"));
        rounds.extend(round.map(Span::ms));
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
        assert!(!is_steady(&[1.0, 1.0, 1.0]));
        assert!(is_steady(&[9.0, 1.0, 1.01, 1.0, 1.02]));
        assert!(!is_steady(&[1.0, 1.0, 1.0, 1.0, 1.03]));
        let rises: Vec<f64> = (0..40)
            .map(|round| 1.0 + 2.0 * 0.8_f64.powi(round))
            .collect();
        let steady = (0..rises.len()).find(|&end| is_steady(&rises[..end]));
        assert!(steady.is_some_and(|end| rises[end] < 1.05), "{steady:?}");
    }
}
