//! One kernel of a step alone, to measure it.

use super::super::distance::DistancePlanner;
use super::super::params::StepParams;
use super::super::sorting::SortParams;
use super::super::step::{self, Changes};
use super::Simulation;
use crate::error::{Error, Result};
use crate::gpu::{Alone, Recorder};

impl Simulation {
    /// The kernels of a step, in order, as often as they run in a step that takes all distances. Records nothing.
    pub fn kernels(&mut self, rec: &mut Recorder) -> Vec<String> {
        let params = self.params_of_all();
        rec.kernels_of(|rec| self.record_and_return(rec, &params, &Changes::default()))
    }

    /// Records what the next step does before a kernel comes for the first time. The state is none that steps lead to
    /// afterwards; [`Simulation::restore`] leads back.
    ///
    /// # Errors
    /// When the step has no such kernel, or the device no memory for what the kernel changes.
    pub fn record_before(&mut self, rec: &mut Recorder, kernel: &str) -> Result<Alone> {
        let changes = self.changes();
        let params = self.params_of_all();
        let alone = rec.record_before(kernel, |rec| {
            self.record_and_return(rec, &params, &changes);
        })?;
        alone.ok_or_else(|| Error::Invalid(format!("no step of the scene has a kernel `{kernel}`")))
    }

    /// Records that kernel and nothing else, in a scope of this name, on what it would find in the step.
    pub fn record_alone(&mut self, rec: &mut Recorder, alone: &Alone, scope: &str) {
        let params = self.params_of_all();
        rec.record_alone(alone, scope, |rec| {
            self.record_and_return(rec, &params, &Changes::default());
        });
    }

    /// Those of the next step, with all distances, whatever has changed, and with a sort: that is what can be measured
    /// alone.
    fn params_of_all(&self) -> StepParams {
        let mut params = self.params();
        params.update_distances(
            &mut DistancePlanner::default(),
            &self.settings,
            &self.setup,
            self.step,
            &self.state.poses_recorded,
        );
        params.sort = SortParams::new(&self.settings, &self.setup);
        params
    }

    /// Records a step, after which buffers have the roles that they had before it.
    fn record_and_return(&mut self, rec: &mut Recorder, params: &StepParams, changes: &Changes) {
        let roles = self.state.roles();
        step::record(rec, &self.kernels, &mut self.state, params, changes);
        self.state.return_to(roles);
    }
}
