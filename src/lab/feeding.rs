//! Food that the user has changed is measured by another thread. The old food stays until the new one is ready; the newest
//! change wins.

use myxo::Error;
use myxo::scene::settings::Settings;
use myxo::sim::{FoodOrder, PreparedFood, Simulation};

use crate::lab::job::Job;

/// Distances that are being measured.
struct Measuring {
    /// The settings that ask for them.
    asked: Settings,
    job: Job<PreparedFood>,
}

impl Measuring {
    fn begin(asked: &Settings, order: FoodOrder) -> Self {
        Self {
            asked: asked.clone(),
            job: Job::begin("measuring food", move |handle| {
                handle.control(None, |control| order.prepare(control))
            }),
        }
    }

    /// Does it measure what these settings ask for, to the end?
    fn is_for(&self, wanted: &Settings) -> bool {
        let asked = &self.asked;
        !self.job.is_cancelled()
            && (&wanted.foods, &wanted.feeding) == (&asked.foods, &asked.feeding)
    }
}

/// The food that is being measured, and the food that is wanted.
#[derive(Default)]
pub struct Feeder {
    measuring: Option<Measuring>,
    /// The user's last settings, if their food is not there yet.
    wanted: Option<Settings>,
    /// At work for a stage that was left.
    left: Vec<Job<PreparedFood>>,
}

/// The result of a measurement.
pub enum Fed {
    /// The food can be used in the next step.
    Ready(Box<PreparedFood>),
    /// The food is refused: the settings, and the reason.
    Refused(Box<Settings>, Error),
}

impl Feeder {
    /// From now on this food is wanted, whatever was before.
    pub fn want(&mut self, simulation: &Simulation, settings: &Settings) {
        let runs = simulation.settings();
        let is_there = (&runs.foods, &runs.feeding) == (&settings.foods, &settings.feeding);
        self.wanted = (!is_there).then(|| settings.clone());
        let is_for = |measuring: &Measuring| {
            (self.wanted.as_ref()).is_some_and(|wanted| measuring.is_for(wanted))
        };
        if let Some(measuring) = self.measuring.as_ref().filter(|m| !is_for(m)) {
            measuring.job.cancel();
        }
        self.begin(simulation);
    }

    /// The stage that it worked for is left: nothing is wanted any more.
    pub fn leave(&mut self) {
        self.wanted = None;
        self.left.retain(|job| !job.has_ended());
        self.left.extend(self.measuring.take().map(|measuring| {
            measuring.job.cancel();
            measuring.job
        }));
    }

    /// Waits for what is at work, which has the device.
    pub fn close(&mut self) {
        self.leave();
        for mut job in self.left.drain(..) {
            // The result is not wanted any more.
            drop(job.wait());
        }
    }

    /// Is something on its way?
    pub fn is_busy(&self) -> bool {
        self.wanted.is_some() || self.measuring.is_some()
    }

    /// The result for the wanted settings, once. Results for outdated settings are dropped.
    pub fn take(&mut self, simulation: &Simulation) -> Option<Fed> {
        let measuring = self.measuring.as_mut()?;
        let is_wanted = (self.wanted.as_ref()).is_some_and(|wanted| measuring.is_for(wanted));
        let measured = measuring.job.take()?;
        let Measuring { asked, .. } = self.measuring.take()?;
        if !is_wanted {
            self.begin(simulation);
            return None;
        }
        self.wanted = None;
        Some(match measured {
            Ok(food) => Fed::Ready(Box::new(food)),
            Err(error) => Fed::Refused(Box::new(asked), error),
        })
    }

    /// One at a time: a slider that is dragged would ask for hundreds.
    fn begin(&mut self, simulation: &Simulation) {
        if self.measuring.is_some() {
            return;
        }
        let Some(wanted) = &self.wanted else {
            return;
        };
        let order = simulation.order_food(wanted);
        self.measuring = order.map(|order| Measuring::begin(wanted, order));
    }
}
