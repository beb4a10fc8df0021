//! The host's and the device's clocks on one axis.

use std::time::Instant;

use ash::vk;

use super::context::Context;
use super::error::{Check, GpuResult};

/// Both clocks at one moment.
#[derive(Clone, Copy, Debug)]
pub struct Calibration {
    /// The device's clock in nanoseconds, counted as in [`Span`](super::Span).
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

/// Nanoseconds from one reading of the device's clock to another, which may be the earlier one. Clocks wrap, and some count from 1970: so
/// long a time has no place in a floating-point number with its last nanoseconds, but the difference has.
fn nanoseconds(epoch: u64, ticks: u64, mask: u64, period: f64) -> f64 {
    let later = ticks.wrapping_sub(epoch) & mask;
    let earlier = epoch.wrapping_sub(ticks) & mask;
    match later <= earlier {
        true => later as f64 * period,
        false => -(earlier as f64) * period,
    }
}

impl Context {
    /// The bits of a reading of the device's clock that count.
    pub(super) fn tick_mask(&self) -> u64 {
        u64::MAX >> (64 - self.info().timestamp_valid_bits.clamp(1, 64))
    }

    /// A reading of the device's clock in nanoseconds since the first one.
    pub(super) fn device_ns(&self, ticks: u64) -> f64 {
        let epoch = *self.device.first_ticks.get_or_init(|| ticks);
        let period = f64::from(self.info().timestamp_period);
        nanoseconds(epoch, ticks, self.tick_mask(), period)
    }

    /// As [`device_ns`](Self::device_ns) of `ticks`, a little after `start`. In between the clock may begin anew, or come halfway round.
    pub(super) fn ns_after(&self, start: u64, ticks: u64) -> f64 {
        let period = f64::from(self.info().timestamp_period);
        self.device_ns(start) + nanoseconds(start, ticks, self.tick_mask(), period)
    }

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
                best = Some(Calibration {
                    device_ns: self.device_ns(ticks[0]),
                    host: before + width / 2,
                    deviation_ns,
                });
            }
        }
        Ok(best)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Would catch: times of devices whose clocks count from 1970, rounded to 256 ns; and intervals in which a clock begins anew.
    #[test]
    fn no_nanosecond_is_lost() {
        let year_2025 = 1_750_000_000_000_000_000;
        let of_all = |epoch, ticks| nanoseconds(epoch, ticks, u64::MAX, 1.0);
        assert_eq!(of_all(year_2025, year_2025 + 10_001), 10_001.0);
        assert_eq!(of_all(year_2025, year_2025 - 3), -3.0);
        let day = 86_400_000_000_000;
        assert_eq!(of_all(year_2025, year_2025 + day + 1), day as f64 + 1.0);
        let mask = (1 << 36) - 1;
        assert_eq!(nanoseconds(mask - 4, 5, mask, 0.5), 5.0);
        assert_eq!(nanoseconds(5, mask - 4, mask, 0.5), -5.0);
        // Halfway round, what is later is taken for earlier: readings near each other are compared with each other.
        let half = mask / 2;
        assert_eq!(nanoseconds(half, half + 9, mask, 1.0), 9.0);
    }
}
