//! Kernels that other settings need, compiled on another thread before the settings are applied, so that this does not wait for them.

use std::sync::{Arc, Weak};

use super::super::course::Course;
use super::super::pipelines::Pipelines;
use super::super::plan::Means;
use super::{Simulation, tables_of};
use crate::error::Result;
use crate::gpu::Context;
use crate::scene::settings::Settings;

/// The kernels of a simulation with other settings. Any thread can make them.
pub struct KernelOrder {
    /// Weak, so that an order that waits does not keep the device alive.
    ctx: Weak<Context>,
    course: Course,
    means: Means,
    settings: Settings,
}

impl Simulation {
    /// The kernels that these settings need beside those of the present ones; none if the simulation has them all, or if they are settings of
    /// another number of objects, which it cannot take over.
    #[must_use]
    pub fn order_kernels(&self, settings: &Settings) -> Option<KernelOrder> {
        if settings.objects.len() != self.settings().objects.len() {
            return None;
        }
        let means = self.means();
        let every = self.course.of_every_kernel(settings, means);
        (!every.is_prepared(&self.pipelines)).then(|| KernelOrder {
            ctx: Arc::downgrade(&self.ctx),
            course: self.course.clone(),
            means,
            settings: settings.clone(),
        })
    }
}

impl KernelOrder {
    /// Compiles them, one after the other while `goes_on` says so. The device keeps them, and [`Simulation::apply`] finds them there.
    /// Returns false if some are missing, because it was to stop or because the device is gone.
    ///
    /// # Errors
    /// When the device refuses one.
    pub fn make(self, goes_on: impl Fn() -> bool) -> Result<bool> {
        let Some(ctx) = self.ctx.upgrade().filter(|ctx| !ctx.is_lost()) else {
            return Ok(false);
        };
        let every = self.course.of_every_kernel(&self.settings, self.means);
        let mut pipelines = Pipelines::new(&ctx, tables_of(&ctx, &self.course.setup));
        for work in every.works() {
            if !goes_on() {
                return Ok(false);
            }
            work.prepare(&mut pipelines)?;
        }
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::ContextOptions;
    use crate::scene::{Overrides, Scene};

    /// Would catch: an order that makes other kernels than the settings then need, that never ends to be given, or that says it has made
    /// all though it was stopped.
    #[test]
    fn ordered_kernels_are_those_that_the_settings_need() {
        let ctx = match Context::new(&ContextOptions::default()) {
            Ok(ctx) => ctx,
            Err(error) if std::env::var_os("MYXO_ALLOW_NO_DEVICE").is_some() => {
                return eprintln!("skipped: {error}");
            }
            Err(error) => panic!("{error}"),
        };
        let overrides = Overrides {
            set: vec!["particles.count=500".to_owned(), "atlas.size=64".to_owned()],
            ..Overrides::default()
        };
        let scene = Scene::load("cube".as_ref(), &overrides).unwrap();
        let mut simulation = Simulation::new(&ctx, &scene).unwrap();
        let mut settings = simulation.settings().clone();
        settings.trail.decay = 0.5;
        assert!(simulation.order_kernels(&settings).is_none(), "a number");
        settings.physarum.sensor_noise = 1.0;
        let order = || simulation.order_kernels(&settings);
        let stopped = order().expect("it is a constant");
        assert!(!stopped.make(|| false).unwrap());
        let order = order().expect("it is not there yet");
        let made = std::thread::spawn(|| order.make(|| true)).join().unwrap();
        assert!(made.unwrap());
        simulation.apply(&settings).unwrap();
        assert!(simulation.order_kernels(&settings).is_none());
        // An order outlives its device.
        let order = simulation.order_kernels(&scene.settings).expect("back");
        drop((simulation, ctx));
        assert!(!order.make(|| true).unwrap());
    }
}
