//! The host's and the device's clocks on one axis.

use std::time::Instant;

use ash::vk;

use super::context::Context;
use super::error::{Check, GpuResult};

/// Both clocks at one moment.
#[derive(Clone, Copy, Debug)]
pub struct Calibration {
    /// The device's clock in nanoseconds, as in [`Span`](super::Span).
    pub device_ns: f64,
    /// The host's clock.
    pub host: Instant,
    /// Bound on the difference between the two clocks, nanoseconds.
    pub deviation_ns: f64,
}

impl Calibration {
    /// A device time as nanoseconds since `epoch`; negative before it.
    #[must_use]
    pub fn since(&self, epoch: Instant, device_ns: f64) -> f64 {
        let offset = match self.host.checked_duration_since(epoch) {
            Some(later) => later.as_nanos() as f64,
            None => -(epoch.duration_since(self.host).as_nanos() as f64),
        };
        offset + device_ns - self.device_ns
    }
}

impl Context {
    /// Reads both clocks; `None` without VK_EXT_calibrated_timestamps or timestamps.
    ///
    /// # Errors
    /// The device was lost.
    pub fn calibrate(&self) -> GpuResult<Option<Calibration>> {
        let info = self.info();
        let Some(loader) = self
            .device
            .calibrated
            .as_ref()
            .filter(|_| info.has_timestamps())
        else {
            return Ok(None);
        };
        let device =
            [vk::CalibratedTimestampInfoKHR::default().time_domain(vk::TimeDomainKHR::DEVICE)];
        // The host's own clock is read on both sides of the call, which spares its time domains. The narrowest of a
        // few tries was not interrupted.
        let mut best: Option<Calibration> = None;
        for _ in 0..5 {
            let before = Instant::now();
            // SAFETY: the device is alive.
            let (ticks, _) = unsafe { loader.get_calibrated_timestamps(&device) }
                .check("vkGetCalibratedTimestampsEXT", &info.name)?;
            let width = before.elapsed();
            let deviation_ns = width.as_nanos() as f64 / 2.0;
            if best.is_none_or(|b| deviation_ns < b.deviation_ns) {
                let mask = u64::MAX >> (64 - info.timestamp_valid_bits.clamp(1, 64));
                let device_ns = (ticks[0] & mask) as f64 * f64::from(info.timestamp_period);
                best = Some(Calibration {
                    device_ns,
                    host: before + width / 2,
                    deviation_ns,
                });
            }
        }
        Ok(best)
    }
}
