//! Pulses on the running simulation: they begin between steps.

use super::super::pulse::{LivePulse, Pulse};
use super::Simulation;
use crate::error::Result;

impl Simulation {
    /// Begins a pulse with the next recorded step. If [`MOST_PULSES`](super::super::pulse::MOST_PULSES) are live, the oldest of them ends
    /// for it. Does not wait for the device; only the first pulse makes kernels.
    ///
    /// The pulse is part of snapshots, checkpoints and hashes until it ends. Scene files have pulses that begin at given steps.
    ///
    /// ```no_run
    /// # use myxo::sim::pulse::Pulse;
    /// # fn pulse(simulation: &mut myxo::sim::Simulation) -> myxo::Result<()> {
    /// let radius = simulation.setup().radius;
    /// simulation.pulse(&Pulse {
    ///     center: glam::Vec3::new(0.0, 0.0, radius),
    ///     speed: 0.01 * radius,
    ///     width: 0.25 * radius,
    ///     reach: 2.0 * radius,
    ///     strength: 0.6,
    /// })
    /// # }
    /// ```
    ///
    /// # Errors
    /// When a number of the pulse is out of its range, or the device has no memory left. Then nothing has changed.
    pub fn pulse(&mut self, pulse: &Pulse) -> Result<()> {
        let mut course = self.course.clone();
        course.pulse(pulse)?;
        let every = course.of_every_kernel(self.settings(), self.means());
        every.prepare(&mut self.pipelines)?;
        self.course = course;
        Ok(())
    }

    /// The pulses that have begun and not ended, the oldest first.
    #[must_use]
    pub fn pulses(&self) -> &[LivePulse] {
        self.course.pulses()
    }
}
