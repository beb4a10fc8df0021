//! Progress of long work, above all of making an atlas; a way to stop it; and the folder of cached layouts.

use std::fmt;
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use super::AtlasError;

/// Progress reports, cancellation and cache of a long computation. The default reports nothing, never cancels, and caches nothing.
#[derive(Clone, Copy, Default)]
pub struct Control<'a> {
    /// Called with the name of the present work and the share of all work that is done, 0 to 1; from any thread, at a moderate rate.
    pub progress: Option<&'a (dyn Fn(&'static str, f32) + Sync)>,
    /// Set from any thread to stop the work.
    pub cancelled: Option<&'a AtomicBool>,
    /// The folder for cached layouts and occlusion.
    pub cache: Option<&'a Path>,
}

impl fmt::Debug for Control<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Control").finish_non_exhaustive()
    }
}

impl Control<'_> {
    /// Does a part of the work: the shares that `work` reports, 0 to 1, lie in `shares` of the whole.
    pub fn part<R>(&self, shares: Range<f32>, work: impl FnOnce(&Control<'_>) -> R) -> R {
        let Some(progress) = self.progress else {
            return work(self);
        };
        let of_part = |doing: &'static str, done: f32| {
            let done = done.clamp(0.0, 1.0);
            progress(doing, shares.start * (1.0 - done) + shares.end * done);
        };
        work(&Control {
            progress: Some(&of_part),
            ..*self
        })
    }

    /// Reports the progress of the work.
    ///
    /// # Errors
    /// [`AtlasError::Cancelled`] when it is to stop.
    pub(crate) fn step(&self, doing: &'static str, done: f32) -> Result<(), AtlasError> {
        if let Some(progress) = self.progress {
            progress(doing, done);
        }
        self.check()
    }

    /// # Errors
    /// [`AtlasError::Cancelled`] when the work is to stop.
    pub(crate) fn check(&self) -> Result<(), AtlasError> {
        match self.cancelled {
            Some(cancelled) if cancelled.load(Ordering::Relaxed) => Err(AtlasError::Cancelled),
            _ => Ok(()),
        }
    }
}
