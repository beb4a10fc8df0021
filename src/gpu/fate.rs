//! What becomes of a recording: it is submitted, or it is dropped and never runs.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

const OPEN: u8 = 0;
const SUBMITTED: u8 = 1;
const DROPPED: u8 = 2;

/// What becomes of a recording. A clone of it outlives the recorder, so that what the host has noted while recording can be taken back.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fate(Arc<AtomicU8>);

impl Fate {
    /// Is it still being recorded?
    pub(crate) fn is_open(&self) -> bool {
        self.0.load(Ordering::Relaxed) == OPEN
    }

    /// Was it dropped? Slices of it may have run.
    pub(crate) fn was_dropped(&self) -> bool {
        self.0.load(Ordering::Relaxed) == DROPPED
    }

    /// Are both of one recording?
    pub(crate) fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    pub(crate) fn submit(&self) {
        self.0.store(SUBMITTED, Ordering::Relaxed);
    }

    pub(crate) fn drop_it(&self) {
        self.0.store(DROPPED, Ordering::Relaxed);
    }
}

/// The recordings that have changed what the host takes the device to hold, for as long as they may be dropped.
#[derive(Debug, Default)]
pub(crate) struct Fates(Vec<Fate>);

impl Fates {
    /// The recording changes it.
    pub(crate) fn note(&mut self, fate: &Fate) {
        self.0
            .retain(|earlier| earlier.is_open() || earlier.was_dropped());
        if !self.0.iter().any(|earlier| earlier.is(fate)) {
            self.0.push(fate.clone());
        }
    }

    /// Was one of them dropped since the last call? Then the device may hold something else.
    pub(crate) fn take_dropped(&mut self) -> bool {
        let dropped = self.0.iter().any(Fate::was_dropped);
        self.0.retain(Fate::is_open);
        dropped
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Would catch: a dropped recording that another one hides, and one that counts twice.
    #[test]
    fn a_dropped_recording_is_reported_once() {
        let [first, second] = [Fate::default(), Fate::default()];
        let mut fates = Fates::default();
        fates.note(&first);
        assert!(!fates.take_dropped());
        fates.note(&second);
        second.submit();
        first.drop_it();
        assert!(fates.take_dropped());
        assert!(!fates.take_dropped());
        fates.note(&second);
        assert!(!fates.take_dropped());
    }
}
