//! One kernel of a step alone, to measure it.

use super::super::distance::{DistancePlanner, DistanceUpdate};
use super::super::params::StepParams;
use super::super::sorting::SortParams;
use super::super::step::{self, Changes};
use super::Simulation;
use crate::error::{Error, Result};
use crate::gpu::{Alone, Recorder};

/// A kernel of the next step that is to run alone: what it found there, and all that the step was to do.
#[derive(Clone)]
pub struct KernelAlone {
    recorded: Alone,
    params: StepParams,
}

impl KernelAlone {
    /// Which distances the step takes, and what is known from the one before.
    #[must_use]
    pub fn distances(&self) -> &DistanceUpdate {
        &self.params.distance_update
    }
}

impl Simulation {
    /// The kernels of a step, in order, as often as they run in a step that takes distances. Records nothing.
    pub fn kernels(&mut self, rec: &mut Recorder) -> Vec<String> {
        let params = self.params_of_all();
        rec.kernels_of(|rec| self.record_and_return(rec, &params, &Changes::default()))
    }

    /// Records what the next step does before a kernel comes for the first time. The state is none that steps lead to
    /// afterwards; [`Simulation::restore`] leads back, and one step after it distances are known again.
    ///
    /// # Errors
    /// When the step has no such kernel, or the device no memory for what the kernel changes.
    pub fn record_before(&mut self, rec: &mut Recorder, kernel: &str) -> Result<KernelAlone> {
        let changes = self.changes();
        let params = self.params_of_all();
        let alone = rec.record_before(kernel, |rec| {
            self.record_and_return(rec, &params, &changes);
        })?;
        let recorded = alone.ok_or_else(|| {
            Error::Invalid(format!("no step of the scene has a kernel `{kernel}`"))
        })?;
        Ok(KernelAlone { recorded, params })
    }

    /// Records that kernel and nothing else, in a scope of this name, on what it would find in the step.
    pub fn record_alone(&mut self, rec: &mut Recorder, alone: &KernelAlone, scope: &str) {
        rec.record_alone(&alone.recorded, scope, |rec| {
            self.record_and_return(rec, &alone.params, &Changes::default());
        });
    }

    /// Those of the next step, with a sort, and with the distances that are due: so every kernel can be measured alone. As
    /// in a step, distances are taken with what is known from the last time. Where nothing has moved since then no step
    /// takes any, and only as the first one would can they be measured.
    fn params_of_all(&self) -> StepParams {
        // Of all steps those that are a multiple of the interval take distances; the first one always does.
        const DUE: u64 = 0;
        let mut params = self.params();
        for mut planner in [self.planner.clone(), DistancePlanner::default()] {
            let poses = &self.state.poses_recorded;
            params.update_distances(&mut planner, &self.settings, &self.setup, DUE, poses);
            if !params.distance_update.jobs.is_empty() {
                break;
            }
        }
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
