//! What a window has measured in its last frames with steps, to be written as `myxo profile` writes its measurements.

use myxo::gpu::{Context, Timings, Trace};
use myxo::scene::Scene;
use myxo::sim::Simulation;
use myxo::{Error, Result};

use super::report::Report;
use super::times;

/// Times of the last frames with steps, and what they are of.
#[derive(Clone, Debug)]
pub struct RecentTimes {
    report: Report,
    timings: Timings,
}

impl RecentTimes {
    /// Of what the timers have now; `None` if they have no steps.
    pub fn new(
        ctx: &Context,
        scene: &Scene,
        simulation: &Simulation,
        timings: &Timings,
        steps_per_second: f64,
    ) -> Option<Self> {
        let measured = timings.report("step");
        if measured.is_empty() {
            return None;
        }
        let setup = simulation.setup();
        let rows = times::Of {
            setup,
            segments: simulation.segments(),
            advancing: times::all_advancing(setup),
            bandwidth: None,
            kept_busy: None,
        };
        Some(Self {
            report: Report {
                steps: simulation.step(),
                wall_ms_per_step: (steps_per_second > 0.0).then(|| 1e3 / steps_per_second),
                kernels: times::rows(&measured, rows),
                ..Report::of(ctx.info(), scene, simulation.settings(), setup, &measured)
            },
            timings: timings.clone(),
        })
    }

    /// The report, as `myxo profile --report` writes it. It has neither a state hash nor counters: the state has changed since.
    pub fn report(&self) -> String {
        self.report.clone().on_this_host().to_json()
    }

    /// The trace, as `myxo profile --trace` writes it. It begins with the first frame; the host's track is empty.
    pub fn trace(&self) -> Result<Vec<u8>> {
        let mut json = Vec::new();
        let written = Trace::new().write(&mut json, &self.timings, None);
        written.map_err(Error::io("write", "the trace"))?;
        Ok(json)
    }
}
