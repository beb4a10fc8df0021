//! A trace of host and device on one clock, as Chrome (`chrome://tracing`) and Perfetto read it.

use std::io::{self, Write};
use std::time::Instant;

use serde_json::{Value, json};

use super::clock::Calibration;
use super::timer::{SpanKind, Timings};

/// Spans of the host, to be written together with the device's.
#[derive(Debug)]
pub struct Trace {
    epoch: Instant,
    host: Vec<HostSpan>,
}

/// One interval of the host's time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HostSpan {
    /// Name of the host's work.
    pub name: String,
    /// Start, in nanoseconds since the trace began.
    pub begin_ns: u64,
    /// End, in nanoseconds since the trace began.
    pub end_ns: u64,
}

impl Default for Trace {
    fn default() -> Self {
        Self::new()
    }
}

impl Trace {
    /// Begins now.
    #[must_use]
    pub fn new() -> Self {
        Self {
            epoch: Instant::now(),
            host: Vec::new(),
        }
    }

    /// Measures what `work` does; spans may nest.
    pub fn span<R>(&mut self, name: &str, work: impl FnOnce(&mut Self) -> R) -> R {
        let begin_ns = self.now();
        let index = self.host.len();
        self.host.push(HostSpan {
            name: name.to_owned(),
            begin_ns,
            end_ns: begin_ns,
        });
        let result = work(self);
        self.host[index].end_ns = self.now();
        result
    }

    /// Adds an interval that was measured elsewhere.
    pub fn add(&mut self, name: &str, begin: Instant, end: Instant) {
        let since =
            |moment: Instant| moment.saturating_duration_since(self.epoch).as_nanos() as u64;
        self.host.push(HostSpan {
            name: name.to_owned(),
            begin_ns: since(begin),
            end_ns: since(end),
        });
    }

    /// Writes the host's spans and those of the frames in `timings`. Without a calibration the device's clock is
    /// shifted so that its first frame begins with the trace, which only shows lengths.
    ///
    /// # Errors
    /// When writing fails.
    pub fn write(
        &self,
        out: &mut impl Write,
        timings: &Timings,
        calibration: Option<&Calibration>,
    ) -> io::Result<()> {
        let first = timings
            .frames()
            .next()
            .and_then(|f| f.first())
            .map_or(0.0, |s| s.begin_ns);
        let on_host =
            |device_ns| calibration.map_or(device_ns - first, |c| c.since(self.epoch, device_ns));
        let mut events = vec![track_name(HOST, "host"), track_name(DEVICE, "device")];
        events.extend(
            self.host
                .iter()
                .map(|s| event(HOST, &s.name, "host", s.begin_ns as f64, s.end_ns as f64)),
        );
        for span in timings.frames().flatten() {
            let kind = match span.kind {
                SpanKind::Frame => "frame",
                SpanKind::Scope => "scope",
                SpanKind::Kernel => "kernel",
                SpanKind::Draw => "draw",
                SpanKind::Copy => "copy",
            };
            events.push(event(
                DEVICE,
                &span.name,
                kind,
                on_host(span.begin_ns),
                on_host(span.end_ns),
            ));
        }
        let document = json!({ "displayTimeUnit": "ms", "traceEvents": events });
        serde_json::to_writer(&mut *out, &document)?;
        out.write_all(b"\n")
    }

    fn now(&self) -> u64 {
        self.epoch.elapsed().as_nanos() as u64
    }
}

const HOST: u32 = 1;
const DEVICE: u32 = 2;

fn event(track: u32, name: &str, kind: &str, begin_ns: f64, end_ns: f64) -> Value {
    // The format counts in microseconds.
    json!({ "name": name, "cat": kind, "ph": "X", "pid": 1, "tid": track, "ts": begin_ns * 1e-3, "dur": (end_ns - begin_ns) * 1e-3 })
}

fn track_name(track: u32, name: &str) -> Value {
    json!({ "name": "thread_name", "ph": "M", "pid": 1, "tid": track, "args": { "name": name } })
}
