//! How far the making of an atlas is, and a way to stop it.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};

use super::AtlasError;

/// What a long computation tells and asks while it runs. The default tells nobody and never stops.
#[derive(Clone, Copy, Default)]
pub struct Control<'a> {
    /// Told what is being done and how much of all is done, 0 to 1; from any thread, and not too often.
    pub progress: Option<&'a (dyn Fn(&'static str, f32) + Sync)>,
    /// Set by anybody to stop the work.
    pub cancelled: Option<&'a AtomicBool>,
}

impl fmt::Debug for Control<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Control").finish_non_exhaustive()
    }
}

impl Control<'_> {
    /// Tells how far the work is.
    ///
    /// # Errors
    /// [`AtlasError::Cancelled`] when it is to stop.
    pub(super) fn step(&self, doing: &'static str, done: f32) -> Result<(), AtlasError> {
        if let Some(progress) = self.progress {
            progress(doing, done);
        }
        self.check()
    }

    /// # Errors
    /// [`AtlasError::Cancelled`] when the work is to stop.
    pub(super) fn check(&self) -> Result<(), AtlasError> {
        match self.cancelled {
            Some(cancelled) if cancelled.load(Ordering::Relaxed) => Err(AtlasError::Cancelled),
            _ => Ok(()),
        }
    }
}
