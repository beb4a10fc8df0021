//! Lines of the network over the picture: when the trail is copied for them, and what comes of it.

use std::time::Instant;

use myxo::Result;
use myxo::gpu::Recorder;

use crate::lab::window::Lab;

impl Lab {
    /// Are the network's lines wanted? A window that closes begins nothing more.
    fn wants_network(&self) -> bool {
        self.interface.shows_network() && !self.closing
    }

    /// Are networks found now? Not of a preview, nor for a window that is not seen.
    fn finds_networks(&self) -> bool {
        let waits = self.runner.previewing.is_some() || self.host.is_hidden();
        self.wants_network() && !waits
    }

    /// Takes over a network that was found. One that cannot be found is not tried again until its lines are asked for once more.
    pub(super) fn poll_network(&mut self) {
        let (now, wants) = (self.host.now(), self.wants_network());
        let previewing = self.runner.previewing.as_mut();
        // It is of the state from before a preview, and waits for its end.
        let network = match previewing {
            Some(previewing) => &mut previewing.network,
            None => &mut self.clocks.facts.network,
        };
        let Some(stage) = self.runner.stage.as_ref().filter(|_| wants) else {
            self.jobs.network.give_up();
            *network = None;
            return;
        };
        network.take_if(|shown| shown.replaced != stage.replaced);
        match self.jobs.network.take(stage, now) {
            None => {}
            Some(Ok(found)) => *network = Some(found),
            Some(Err(error)) => {
                *network = None;
                self.interface.layout.network = false;
                self.notify(error.to_string(), true);
            }
        }
    }

    /// Another stage takes the place of the one whose network was found.
    pub(super) fn forget_network(&mut self) {
        self.jobs.network.forget_scene();
        self.clocks.facts.network = None;
    }

    /// Records a copy of the trail if its network is to be found.
    pub(super) fn record_network(&mut self, rec: &mut Recorder) -> Result<()> {
        let (now, finds) = (self.host.now(), self.finds_networks());
        let Some(stage) = self.runner.stage.as_ref().filter(|_| finds) else {
            return Ok(());
        };
        if !self.jobs.network.is_due(stage, now) {
            return Ok(());
        }
        let from = stage.viewpoint(&self.interface.shown_view().camera);
        let begun = self.jobs.network.begin(rec, stage, from, now);
        begun.or_else(|error| {
            self.interface.layout.network = false;
            self.report_unless_lost("The network's lines are not shown", error)
        })
    }

    /// When the network is to be asked for again, or more of its points are to be tested, though nothing else happens.
    pub(super) fn network_due(&self) -> Option<Instant> {
        let now = self.host.now();
        if self.lines.is_testing() && !self.host.is_hidden() {
            return Some(now);
        }
        let finds = self.finds_networks();
        let stage = self.runner.stage.as_ref().filter(|_| finds)?;
        self.jobs.network.due(stage, now)
    }
}
