//! Kernels of a look that is about to be previewed, compiled by another thread, one look at a time.

use myxo::scene::settings::Settings;
use myxo::sim::Simulation;

use crate::lab::job::Job;

/// The kernels that are being made, and those that were made last.
#[derive(Default)]
pub struct Ahead {
    making: Option<(Settings, Job<()>)>,
    made: Option<Settings>,
}

impl Ahead {
    /// Can the simulation take over these settings without compiling anything? If not, that begins.
    pub fn are_made(&mut self, simulation: &Simulation, settings: &Settings) -> bool {
        if let Some((of, job)) = &mut self.making {
            let Some(result) = job.take() else {
                return false;
            };
            if let Err(error) = result {
                // What takes the settings over gets the error, too.
                log::debug!("kernels made ahead: {error}");
            }
            self.made = Some(of.clone());
            self.making = None;
        }
        if self.made.as_ref() == Some(settings) {
            return true;
        }
        let Some(order) = simulation.order_kernels(settings) else {
            return true;
        };
        let job = Job::begin("making kernels", move |_| order.make());
        self.making = Some((settings.clone(), job));
        false
    }
}
