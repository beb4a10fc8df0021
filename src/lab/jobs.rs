//! Jobs beside the frames: a scene that loads, food that is measured, files that are written.

use crate::lab::ahead::Ahead;
use crate::lab::export::Exports;
use crate::lab::feeding::Feeder;
use crate::lab::loading::{Loading, Ready};
use crate::lab::networks::Networks;
use myxo::Result;

/// Jobs under way. `window/jobs.rs` polls all of them once a frame.
pub struct Jobs {
    /// The scene that comes next.
    pub loading: Option<Loading>,
    /// Scenes that were given up, until their threads have ended.
    replaced: Vec<Loading>,
    /// Distances to food that was changed.
    pub food: Feeder,
    /// Kernels of looks that are about to be previewed.
    pub ahead: Ahead,
    /// The network, while its lines are shown.
    pub network: Networks,
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
            ahead: Ahead::default(),
            network: Networks::default(),
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
        self.network.leave_device();
    }

    /// The scene that has loaded, or why it has not.
    pub fn take_loaded(&mut self) -> Option<(Loading, Result<Ready>)> {
        self.replaced.retain(|loading| !loading.has_ended());
        let result = self.loading.as_mut()?.take()?;
        Some((self.loading.take()?, result))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::loading::Origin;
    use crate::lab::on_device::{FORMAT, SMALL, context, scene};
    use myxo::Error;
    use myxo::mesh::atlas::AtlasError;
    use std::sync::{Arc, mpsc};
    use std::time::{Duration, Instant};

    fn wait_for(what: impl Fn() -> bool) {
        let begun = Instant::now();
        while !what() {
            assert!(begun.elapsed() < Duration::from_secs(60), "it hangs");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Would catch: a scene that was given up and still puts itself on a device that is left.
    #[test]
    fn scenes_that_were_given_up_end_and_leave_the_device() {
        let Some(ctx) = context() else { return };
        let mut jobs = Jobs::new(Exports::default());
        let load = |name: &str| {
            let (go, wait) = mpsc::channel::<()>();
            let load = move || {
                wait.recv().unwrap();
                Ok(scene("cube", &SMALL))
            };
            let name = (name.to_owned(), Origin::File);
            (go, Loading::begin(name, (&ctx, FORMAT), None, load))
        };
        let (go_first, first) = load("first");
        let (go_second, second) = load("second");
        jobs.load(first);
        jobs.load(second);
        let names = |jobs: &Jobs| -> Vec<String> {
            let loadings = jobs.replaced.iter().chain(&jobs.loading);
            loadings.map(|loading| loading.name.clone()).collect()
        };
        assert_eq!(names(&jobs), ["first", "second"]);
        assert!(jobs.replaced[0].is_cancelled());
        assert!(
            jobs.loading
                .as_ref()
                .is_some_and(|loading| !loading.is_cancelled())
        );
        // Neither uses the device yet, so that none is waited for, and none gets it later.
        jobs.leave_device();
        go_first.send(()).unwrap();
        go_second.send(()).unwrap();
        wait_for(|| jobs.replaced[0].has_ended());
        wait_for(|| jobs.loading.as_ref().is_some_and(Loading::has_ended));
        assert_eq!(Arc::strong_count(&ctx), 1);
        let (loading, result) = jobs.take_loaded().expect("it has ended");
        assert_eq!(loading.name, "second");
        assert!(matches!(result, Err(Error::Atlas(AtlasError::Cancelled))));
        assert!(names(&jobs).is_empty(), "the ended one is forgotten");
    }
}
