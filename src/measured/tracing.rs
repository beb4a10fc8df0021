//! The host's side of a session's trace, and the conversion of the device's times to the same clock.

use std::time::Instant;

use myxo::gpu::{Calibration, Context, Timings, Trace};
use myxo::{Error, Result};

/// The host's spans while it is traced.
pub struct Tracing {
    trace: Trace,
    calibration: Option<Calibration>,
    first_submit: Option<Instant>,
}

impl Tracing {
    /// Begins now.
    pub fn begin(ctx: &Context) -> Result<Self> {
        Ok(Self {
            calibration: ctx.calibrate()?,
            trace: Trace::new(),
            first_submit: None,
        })
    }

    /// A frame is about to be submitted.
    pub fn submits(&mut self) {
        self.first_submit.get_or_insert_with(Instant::now);
    }

    /// The trace as JSON, and how well its tracks agree.
    pub fn json(&self, ctx: &Context, timings: &Timings) -> Result<(Vec<u8>, String)> {
        let first_span = timings.frames().next().and_then(|frame| frame.first());
        let (calibration, agreement) = match (self.calibration, first_span) {
            (Some(first), Some(_)) => {
                let last = ctx.calibrate()?;
                let calibration = last.map_or(first, |last| between(first, last));
                let within = calibration.deviation_ns.ceil();
                (
                    Some(calibration),
                    format!("host and GPU on one clock, within {within:.0} ns"),
                )
            }
            (None, Some(span)) => (
                self.first_submit.map(|host| Calibration {
                    device_ns: span.begin_ns,
                    host,
                    deviation_ns: f64::INFINITY,
                }),
                "the device lacks VK_EXT_calibrated_timestamps: the GPU's track is shifted so that it begins with the \
                 first submit"
                    .to_owned(),
            ),
            (_, None) => (
                None,
                "the device has no timestamps: the GPU's track is empty".to_owned(),
            ),
        };
        let mut json = Vec::new();
        self.trace
            .write(&mut json, timings, calibration.as_ref())
            .map_err(Error::io("write", "the trace"))?;
        Ok((json, agreement))
    }
}

/// Does `work` as a span of the trace.
pub fn spanned<R>(trace: &mut Option<Tracing>, name: &str, work: impl FnOnce() -> R) -> R {
    match trace {
        Some(tracing) => tracing.trace.span(name, |_| work()),
        None => work(),
    }
}

/// Clocks run apart: the offset half-way from one calibration to the other is at most half the difference wrong.
fn between(first: Calibration, last: Calibration) -> Calibration {
    let host_ns = last.host.duration_since(first.host).as_nanos() as f64;
    let drift_ns = host_ns - (last.device_ns - first.device_ns);
    Calibration {
        device_ns: first.device_ns - 0.5 * drift_ns,
        host: first.host,
        deviation_ns: first.deviation_ns.max(last.deviation_ns) + 0.5 * drift_ns.abs(),
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn clocks_that_run_apart_are_taken_in_the_middle() {
        let epoch = Instant::now();
        let at = |device_ns, host_ms| Calibration {
            device_ns,
            host: epoch + Duration::from_millis(host_ms),
            deviation_ns: 10.0,
        };
        // In 100 ms of the host the device counts 600 ns less.
        let (first, last) = (at(5000.0, 0), at(5000.0 + 1e8 - 600.0, 100));
        let middle = between(first, last);
        assert_eq!(middle.since(epoch, first.device_ns), 300.0);
        assert_eq!(middle.since(epoch, last.device_ns), 1e8 - 300.0);
        assert_eq!(middle.deviation_ns, 310.0);
    }
}
