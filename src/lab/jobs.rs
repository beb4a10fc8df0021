//! Jobs beside the frames: a scene that loads, food that is measured, files that are written.

use crate::lab::export::Exports;
use crate::lab::feeding::Feeder;
use crate::lab::loading::{Loading, Ready};
use myxo::Result;

/// Jobs under way. `window/jobs.rs` polls all of them once a frame.
pub struct Jobs {
    /// The scene that comes next.
    pub loading: Option<Loading>,
    /// Scenes that were given up, until their threads have ended.
    replaced: Vec<Loading>,
    /// Distances to food that was changed.
    pub food: Feeder,
    /// Pictures, films, recordings and files of the state.
    pub exports: Exports,
}

impl Jobs {
    /// Nothing is on its way.
    pub fn new(exports: Exports) -> Self {
        Self {
            loading: None,
            replaced: Vec::new(),
            food: Feeder::default(),
            exports,
        }
    }

    /// Must the window look again soon, though nothing is due?
    pub fn are_waited_for(&self) -> bool {
        self.loading.is_some() || self.food.is_busy()
    }

    /// This scene comes next; one that was on its way is given up.
    pub fn load(&mut self, loading: Loading) {
        self.replaced.retain(|loading| !loading.has_ended());
        if let Some(replaced) = self.loading.replace(loading) {
            replaced.cancel();
            self.replaced.push(replaced);
        }
    }

    /// From then on no thread has anything of the device; those that were using it are waited for.
    pub fn leave_device(&mut self) {
        for loading in self.loading.iter_mut().chain(&mut self.replaced) {
            loading.leave_device();
        }
    }

    /// The scene that has loaded, or why it has not.
    pub fn take_loaded(&mut self) -> Option<(Loading, Result<Ready>)> {
        self.replaced.retain(|loading| !loading.has_ended());
        let result = self.loading.as_mut()?.take()?;
        Some((self.loading.take()?, result))
    }
}
