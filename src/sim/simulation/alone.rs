//! One kernel of a step alone, to measure it.

use std::sync::Arc;

use super::super::distance::DistanceUpdate;
use super::super::plan::Changes;
use super::super::work::Step;
use super::Simulation;
use crate::error::{Error, Result};
use crate::gpu::{Alone, Recorder};

/// A kernel of the next step that is to run alone: copies of its inputs, and the planned step.
#[derive(Clone)]
pub struct KernelAlone {
    recorded: Alone,
    step: Arc<Step>,
    distances: DistanceUpdate,
}

impl KernelAlone {
    /// The step's update of distances.
    #[must_use]
    pub fn distances(&self) -> &DistanceUpdate {
        &self.distances
    }
}

impl Simulation {
    /// The kernels of a step that computes distances, in order, as often as they run. Records nothing.
    pub fn kernels(&mut self, rec: &mut Recorder) -> Vec<String> {
        let (step, _) = self
            .course
            .with_everything(self.means(), Changes::default());
        rec.kernels_of(|rec| self.record_and_return(rec, &step))
    }

    /// Records the part of the next step before a kernel's first run. Afterwards the state is invalid; [`Simulation::restore`] repairs it,
    /// and one step later distances are known again.
    ///
    /// # Errors
    /// When the step has no such kernel, or the device has no memory for copies of the buffers that the kernel changes.
    pub fn record_before(&mut self, rec: &mut Recorder, kernel: &str) -> Result<KernelAlone> {
        let changes = self.course.changes();
        self.state.follow(self.course.poses());
        let means = self.means();
        let (step, _) = self.course.with_everything(means, changes);
        let alone = rec.record_before(kernel, |rec| self.record_and_return(rec, &step))?;
        let recorded = alone.ok_or_else(|| {
            Error::Invalid(format!("no step of the scene has a kernel `{kernel}`"))
        })?;
        let (step, distances) = self.course.with_everything(means, Changes::default());
        Ok(KernelAlone {
            recorded,
            step: Arc::new(step),
            distances,
        })
    }

    /// Records only that kernel, in a scope of this name, on the inputs that it has in the step.
    ///
    /// # Panics
    /// If a buffer that it writes was replaced since they were copied, as [`Simulation::restore`] replaces those of food.
    pub fn record_alone(&mut self, rec: &mut Recorder, alone: &KernelAlone, scope: &str) {
        rec.record_alone(&alone.recorded, scope, |rec| {
            self.record_and_return(rec, &alone.step);
        });
    }

    /// Records a step, after which buffers have the roles that they had before it.
    fn record_and_return(&mut self, rec: &mut Recorder, step: &Step) {
        let roles = self.state.roles();
        step.on_device(rec, &self.pipelines, &mut self.state);
        self.state.return_to(roles);
    }
}
