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

    /// No kernels are wanted. The thread ends after the one that it is compiling.
    pub fn give_up(&self) {
        if let Some((_, job)) = &self.making {
            job.cancel();
        }
    }

    /// Waits for what is being made, which has the device.
    pub fn close(&mut self) {
        if let Some((_, mut job)) = self.making.take() {
            job.cancel();
            // The result is not wanted any more.
            drop(job.wait());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::on_device::{SMALL, context, stage};
    use std::thread::sleep;
    use std::time::{Duration, Instant};

    /// Would catch: kernels of a morph to settings of other objects than those that run, as when a file was dropped, which are asked for by
    /// numbers that the running scene does not have.
    #[test]
    fn settings_of_other_objects_need_no_kernels() {
        let Some(ctx) = context() else { return };
        let stage = stage(&ctx, "cube", &SMALL);
        let mut settings = stage.simulation.settings().clone();
        settings.physarum.sensor_noise = 1.0;
        settings.objects.clear();
        assert!(Ahead::default().are_made(&stage.simulation, &settings));
        assert_eq!(ctx.messages(), [""; 0]);
    }

    /// Would catch: kernels that go on being compiled when no look is pointed at, and a look that is never ready after that.
    #[test]
    fn kernels_that_were_given_up_are_made_when_they_are_wanted_again() {
        let Some(ctx) = context() else { return };
        let stage = stage(&ctx, "cube", &SMALL);
        let mut settings = stage.simulation.settings().clone();
        settings.physarum.sensor_noise = 1.0;
        let mut ahead = Ahead::default();
        assert!(!ahead.are_made(&stage.simulation, &settings));
        ahead.give_up();
        let (_, job) = ahead.making.as_ref().expect("its thread may still work");
        assert!(job.is_cancelled());
        let begun = Instant::now();
        while !ahead.are_made(&stage.simulation, &settings) {
            assert!(begun.elapsed() < Duration::from_secs(60), "it hangs");
            sleep(Duration::from_millis(1));
        }
        assert_eq!(ctx.messages(), [""; 0]);
    }
}
