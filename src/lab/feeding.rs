//! Food that the hand has changed, measured by another thread. Until it is ready what there was stays; the newest change
//! wins.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

use myxo::mesh::atlas::Control;
use myxo::scene::settings::Settings;
use myxo::sim::{FoodOrder, PreparedFood, Simulation};
use myxo::{Error, Result};

use crate::lab::worker::joined;

/// At work; it can be told to stop, as soon as it looks.
struct Worker {
    asked: Settings,
    stopped: Arc<AtomicBool>,
    thread: JoinHandle<Result<PreparedFood>>,
}

impl Worker {
    fn begin(asked: &Settings, order: FoodOrder) -> Self {
        let stopped = Arc::new(AtomicBool::new(false));
        let stop = Arc::clone(&stopped);
        let thread = thread::spawn(move || {
            order.prepare(&Control {
                cancelled: Some(&stop),
                ..Control::default()
            })
        });
        Self {
            asked: asked.clone(),
            stopped,
            thread,
        }
    }

    fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
    }

    /// Does it measure what these settings ask for, to the end?
    fn is_for(&self, wanted: &Settings) -> bool {
        let asked = &self.asked;
        !self.stopped.load(Ordering::Relaxed)
            && (&wanted.foods, &wanted.feeding) == (&asked.foods, &asked.feeding)
    }
}

/// What is being measured, and what is wanted.
#[derive(Default)]
pub struct Feeder {
    worker: Option<Worker>,
    /// What the hand has set last, if it is not there yet.
    wanted: Option<Settings>,
    /// At work for a stage that was left.
    left: Vec<JoinHandle<Result<PreparedFood>>>,
}

/// What came of it.
pub enum Fed {
    /// It can be there with the next step.
    Ready(Box<PreparedFood>),
    /// It cannot; what was asked for, and why.
    Refused(Box<Settings>, Error),
}

impl Feeder {
    /// From now on this food is wanted, whatever was before.
    pub fn want(&mut self, simulation: &Simulation, settings: &Settings) {
        let runs = simulation.settings();
        let is_there = (&runs.foods, &runs.feeding) == (&settings.foods, &settings.feeding);
        self.wanted = (!is_there).then(|| settings.clone());
        if let Some(worker) = &self.worker
            && !self
                .wanted
                .as_ref()
                .is_some_and(|wanted| worker.is_for(wanted))
        {
            worker.stop();
        }
        self.begin(simulation);
    }

    /// The stage that it worked for is left: nothing is wanted any more.
    pub fn leave(&mut self) {
        self.wanted = None;
        self.left.retain(|worker| !worker.is_finished());
        self.left.extend(self.worker.take().map(|worker| {
            worker.stop();
            worker.thread
        }));
    }

    /// Waits for what is at work, which has the device.
    pub fn close(&mut self) {
        self.leave();
        for worker in self.left.drain(..) {
            // Nobody wants what came of it.
            drop(worker.join());
        }
    }

    /// Is something on its way?
    pub fn is_busy(&self) -> bool {
        self.wanted.is_some() || self.worker.is_some()
    }

    /// What came of what is wanted, once. What nobody wants any more is dropped.
    pub fn take(&mut self, simulation: &Simulation) -> Option<Fed> {
        let worker = self.worker.take_if(|worker| worker.thread.is_finished())?;
        let is_wanted = (self.wanted.as_ref()).is_some_and(|wanted| worker.is_for(wanted));
        let Worker { asked, thread, .. } = worker;
        let measured = joined("measuring food", thread);
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
        if self.worker.is_some() {
            return;
        }
        let Some(wanted) = &self.wanted else {
            return;
        };
        let order = simulation.order_food(wanted);
        self.worker = order.map(|order| Worker::begin(wanted, order));
    }
}
