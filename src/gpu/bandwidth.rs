//! Measures the device's memory bandwidth by a large copy from one buffer to another. Reports give kernel times as
//! fractions of it.

use std::sync::Arc;

use super::buffer::Buffer;
use super::buffer_core::Domain;
use super::context::Context;
use super::error::GpuResult;
use super::frame::Frames;
use super::info::DeviceKind;
use super::recorder::Recorder;
use super::report::Statistics;

/// Bytes of one copy on CPUs: far more than their caches hold.
const BYTES: u64 = 64 << 20;
/// Bytes of one copy on graphics cards, which are fast enough for more.
const BYTES_OF_CARDS: u64 = 256 << 20;
/// Untimed copies at first, in which the system allocates the memory.
const WARMUP: usize = 2;

/// Speed of copies from buffer to buffer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CopyBandwidth {
    /// Bytes of one copy, each of which is read and written once.
    pub size_in_bytes: u64,
    /// Copies that were measured.
    pub runs: usize,
    /// The time of one.
    pub time: Statistics,
}

impl CopyBandwidth {
    /// Copies between two buffers of the device so many times, as `copy` records it; the words are a multiple of four. `None` if the device
    /// has no timestamps, or they are too coarse.
    ///
    /// # Errors
    /// When the device has no memory left, or is lost.
    pub fn measure(
        ctx: &Arc<Context>,
        runs: usize,
        copy: impl Fn(&mut Recorder, &Buffer<u32>, &Buffer<u32>),
    ) -> GpuResult<Option<Self>> {
        let info = ctx.info();
        if !info.has_timestamps() {
            return Ok(None);
        }
        let wanted = match info.kind {
            DeviceKind::Discrete | DeviceKind::Integrated | DeviceKind::Virtual => BYTES_OF_CARDS,
            DeviceKind::Cpu | DeviceKind::Other => BYTES,
        };
        let most = info
            .max_storage_buffer_range
            .min(info.max_memory_allocation_size);
        let words = (wanted.min(most) / 16 * 4) as usize;
        let buffer = |name| Buffer::<u32>::new(ctx, name, words, Domain::Device);
        let (source, target) = (buffer("bandwidth.source")?, buffer("bandwidth.target")?);
        // Memory that was not written yet may all be one page of zeros, which is quick to read.
        ctx.fill(&source, 0x5eed_5eed)?;
        let mut frames = Frames::new(ctx, 1)?;
        for _ in 0..WARMUP + runs {
            let mut rec = frames.begin()?;
            rec.scope("copy", |rec| copy(rec, &source, &target));
            frames.submit(rec)?;
        }
        frames.wait_idle()?;
        let copies = frames.timings().frames().skip(WARMUP);
        let times = copies.filter_map(|spans| spans.iter().find(|span| span.name == "copy"));
        let times: Vec<f64> = times.map(super::timer::Span::ms).collect();
        let measured = Self {
            size_in_bytes: source.size_in_bytes(),
            runs: times.len(),
            time: Statistics::of(times),
        };
        Ok((measured.time.median_ms > 0.0).then_some(measured))
    }

    /// Bytes read and bytes written in a second, together, by the median.
    #[must_use]
    pub fn bytes_per_second(&self) -> f64 {
        2.0 * self.size_in_bytes as f64 / (self.time.median_ms * 1e-3)
    }
}
