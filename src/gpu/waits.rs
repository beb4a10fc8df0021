//! The barriers of a recording: found from what dispatches, draws and copies use, recorded just before what has to wait, and
//! listed on request.

use super::access::{Access, Use, Wait};
use super::buffer::AnyBuffer;
use super::buffer_core::BufferCore;
use super::listing::{Listed, Reason};
use super::recorder::Recorder;

/// A use of a buffer.
#[derive(Clone, Copy)]
pub(crate) struct Touch<'a> {
    pub(crate) core: &'a BufferCore,
    pub(crate) access: Access,
    pub(crate) writes: bool,
}

impl Recorder {
    /// Records the barrier that a work needs, if it needs one, and notes what it uses.
    ///
    /// # Panics
    /// If it would be needed within a pass.
    pub(crate) fn touch(&mut self, work: &'static str, touches: &[Touch<'_>]) {
        self.wait_before(work, touches, self.separates && self.has_work);
        self.has_work = true;
        let at = self.ctx().recordings().count();
        for touch in touches {
            (touch.core).note(self.ticket, work, touch.access, at, touch.writes);
            self.host_reads |= touch.writes && !touch.core.domain().is_on_device();
        }
    }

    /// Records the barrier that a work needs, if it needs one, or is separated from the one before.
    fn wait_before(&mut self, work: &'static str, touches: &[Touch<'_>], separates: bool) {
        let mut wait = Wait::default();
        let mut reasons = Vec::new();
        let lists = self.list.is_some();
        self.settle_order();
        for touch in touches {
            let reason = |earlier: &Use, wrote: bool| {
                if lists || self.is_in_pass {
                    reasons.push(Reason {
                        buffer: touch.core.name().to_owned(),
                        earlier: (earlier.work, earlier.access.word()),
                        earlier_wrote: wrote,
                        later: (work, touch.access.word()),
                        later_writes: touch.writes,
                    });
                }
            };
            let order = &self.recording.order;
            (touch.core).wait_for(order, touch.access, touch.writes, &mut wait, reason);
        }
        if separates && !self.is_in_pass {
            wait.separate();
        }
        if wait.before.is_empty() {
            return;
        }
        assert!(
            !self.is_in_pass,
            "within a pass there are no barriers, and one is needed: {}; call make_visible before the pass",
            reasons.first().map(ToString::to_string).unwrap_or_default()
        );
        let now = self.ctx().recordings().now();
        self.recording.order.wait(&wait, now);
        self.commands.barriers += 1;
        if self.ctx().leave_out != Some(self.commands.barriers - 1) {
            wait.record(self.device(), self.raw());
        }
        if let Some(list) = &mut self.list {
            list.push(Listed::Barrier(reasons));
        }
    }

    /// After a recording that was dropped, waits for everything.
    pub(crate) fn settle_order(&mut self) {
        if self.is_in_pass {
            return;
        }
        let now = self.ctx().recordings().now();
        if self.recording.order.settle(now) {
            self.full_barrier(ash::vk::PipelineStageFlags::ALL_COMMANDS);
            self.commands.barriers += 1;
            if let Some(list) = &mut self.list {
                list.push(Listed::Barrier(Vec::new()));
            }
        }
    }

    /// Waits for the work before a pass that has a time of its own.
    pub(crate) fn separate_pass(&mut self) {
        self.wait_before("a pass", &[], self.separates && self.has_work);
        self.has_work = true;
    }

    /// Orders what comes after `buffers` were written: draws of passes that follow may read them so. Within a pass there can be
    /// no barriers, so that what its draws read has to be named before it.
    ///
    /// # Panics
    /// Within a pass.
    pub fn make_visible(&mut self, to: Access, buffers: &[&dyn AnyBuffer]) {
        if self.skips() {
            return;
        }
        let touches: Vec<_> = buffers
            .iter()
            .map(|buffer| Touch {
                core: buffer.core(),
                access: to,
                writes: false,
            })
            .collect();
        self.wait_before("a pass", &touches, false);
    }

    /// Makes what was written for the host visible to it, at the end.
    pub(crate) fn make_visible_to_host(&mut self) {
        if !std::mem::take(&mut self.host_reads) {
            return;
        }
        let mut wait = Wait::default();
        for access in [Access::Copy, Access::Kernel] {
            wait.before.add(access);
            wait.written.add(access);
        }
        wait.after.add(Access::Readback);
        let now = self.ctx().recordings().now();
        self.recording.order.wait(&wait, now);
        wait.record(self.device(), self.raw());
    }

    /// From now on every kernel and every copy waits for the one before, so that each has a time of its own, also where nothing
    /// else makes it wait.
    pub fn separate_works(&mut self) {
        self.separates = true;
    }

    /// Lists what is recorded from now on.
    pub fn list(&mut self) {
        self.list = Some(Vec::new());
    }

    /// What was recorded since [`Recorder::list`], in order.
    pub fn listed(&mut self) -> Vec<Listed> {
        self.list.take().unwrap_or_default()
    }

    pub(crate) fn list_work(&mut self, name: &str) {
        if let Some(list) = &mut self.list {
            list.push(Listed::Work(name.to_owned()));
        }
    }
}
