//! Jobs beside the frames: a scene that loads, food that is measured, files that are written.

use crate::lab::feeding::Feeder;
use crate::lab::loading::{Loading, Ready};
use crate::lab::out::TakeOut;
use myxo::Result;

/// Jobs under way. `window/jobs.rs` polls all of them once a frame.
pub struct Jobs {
    /// The scene that comes next.
    pub loading: Option<Loading>,
    /// Distances to food that was changed.
    pub food: Feeder,
    /// Pictures, films, recordings and files of the state.
    pub exports: TakeOut,
}

impl Jobs {
    /// Nothing is on its way.
    pub fn new(exports: TakeOut) -> Self {
        Self {
            loading: None,
            food: Feeder::default(),
            exports,
        }
    }

    /// Must the window look again soon, though nothing is due?
    pub fn are_waited_for(&self) -> bool {
        self.loading.is_some() || self.food.is_busy()
    }

    /// The scene that has loaded, or why it has not.
    pub fn take_loaded(&mut self) -> Option<(Loading, Result<Ready>)> {
        let result = self.loading.as_mut()?.take()?;
        Some((self.loading.take()?, result))
    }
}
