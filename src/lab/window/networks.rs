//! Lines of the network over the picture: when the trail is copied for them, and what comes of it.

use std::time::Instant;

use myxo::Result;
use myxo::gpu::Recorder;
use myxo::render::network_lines::Viewpoint;

use crate::lab::stage::Stage;
use crate::lab::window::Lab;

impl Lab {
    /// Are the network's lines wanted? A window that closes begins nothing more.
    fn wants_network(&self) -> bool {
        self.interface.shows_network() && !self.closing
    }

    /// The stage whose network is wanted.
    fn stage_with_network(&self) -> Option<&Stage> {
        let wants = self.wants_network();
        self.runner.stage.as_ref().filter(|_| wants)
    }

    /// Takes over a network that was found. One that cannot be found is not tried again until its lines are asked for once more.
    pub(super) fn poll_network(&mut self) {
        let (now, wants) = (self.host.now(), self.wants_network());
        let facts = &mut self.clocks.facts;
        let Some(stage) = self.runner.stage.as_ref().filter(|_| wants) else {
            self.jobs.network.rest();
            facts.network = None;
            return;
        };
        facts
            .network
            .take_if(|shown| shown.replaced != stage.replaced);
        match self.jobs.network.take(stage, now) {
            None => {}
            Some(Ok(found)) => facts.network = Some(found),
            Some(Err(error)) => {
                facts.network = None;
                self.interface.layout.network = false;
                self.notify(error.to_string(), true);
            }
        }
    }

    /// Another stage takes the place of the one whose network was found.
    pub(super) fn forget_network(&mut self) {
        self.jobs.network.rest();
        self.clocks.facts.network = None;
    }

    /// Records a copy of the trail if its network is to be found.
    pub(super) fn record_network(&mut self, rec: &mut Recorder) -> Result<()> {
        let now = self.host.now();
        let Some(stage) = self.stage_with_network() else {
            return Ok(());
        };
        if !self.jobs.network.is_due(stage, now) {
            return Ok(());
        }
        let from = Viewpoint {
            eye: self.interface.shown_view().camera.eye(),
            poses: stage.drawn_poses(),
            hidden: stage.marks.hidden.clone(),
        };
        let Some(stage) = &self.runner.stage else {
            return Ok(());
        };
        let begun = self.jobs.network.begin(rec, stage, from, now);
        begun.or_else(|error| {
            self.interface.layout.network = false;
            self.report_unless_lost("The network's lines are not shown", error)
        })
    }

    /// When the network is to be looked at again, though nothing else happens.
    pub(super) fn network_due(&self) -> Option<Instant> {
        let stage = self.stage_with_network()?;
        self.jobs.network.due(stage, self.host.now())
    }
}
