//! Kernels of a look that is about to be previewed, compiled by another thread, one look at a time: the last one that was asked for.

use myxo::scene::settings::Settings;
use myxo::sim::Simulation;

use crate::lab::job::Job;

/// The kernels that are being made, and those that were made last.
#[derive(Default)]
pub struct Ahead {
    making: Option<(Settings, Job<bool>)>,
    made: Option<Settings>,
}

impl Ahead {
    /// Can the simulation take over these settings without compiling anything? If not, that begins.
    pub fn are_made(&mut self, simulation: &Simulation, settings: &Settings) -> bool {
        if let Some((of, job)) = &mut self.making {
            if *of != *settings {
                job.cancel();
            }
            let Some(result) = job.take() else {
                return false;
            };
            let has_ended = result.unwrap_or_else(|error| {
                // What takes the settings over gets the error, too.
                log::debug!("kernels made ahead: {error}");
                true
            });
            self.made = has_ended.then(|| of.clone());
            self.making = None;
        }
        if self.made.as_ref() == Some(settings) {
            return true;
        }
        let Some(order) = simulation.order_kernels(settings) else {
            return true;
        };
        let job = Job::begin("making kernels", move |handle| {
            order.make(|| !handle.is_cancelled())
        });
        self.making = Some((settings.clone(), job));
        false
    }
}
