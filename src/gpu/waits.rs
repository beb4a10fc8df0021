//! The barriers of a recording: found from what dispatches, draws and copies use, recorded just before what has to wait, and
//! listed on request.

use ash::vk;

use super::access::{Access, Unordered, Use, Wait};
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
    /// From here to [`end_unordered`](Self::end_unordered), kernels do not wait for each other, so that they may overlap. Several of
    /// them may write the buffers in `shared`, for the reason that is given: each element belongs to one kernel, or changes by
    /// atomic operations whose order does not matter. No other buffer may be written by one of them and used by another.
    ///
    /// The validation layer sees buffers and not their elements, so where it watches, they wait for each other all the same.
    /// Other recordings that are open use none of the shared buffers.
    ///
    /// # Panics
    /// Within another group. What is recorded in the group panics if it writes what another work of it uses, or uses what
    /// another one writes, unless both are kernels and that is shared.
    pub fn begin_unordered(&mut self, reason: &'static str, shared: &[&dyn AnyBuffer]) {
        assert!(
            self.unordered.is_none(),
            "an unordered group lies within another one: {reason}"
        );
        let since = self.ctx().recordings().now();
        self.unordered = Some(Unordered {
            reason,
            shared: shared.iter().map(|buffer| buffer.core().raw()).collect(),
            since,
        });
        self.list_entry(|| Listed::Unordered(reason));
    }

    /// From here on works wait for their dependencies again.
    pub fn end_unordered(&mut self) {
        self.unordered = None;
        self.list_entry(|| Listed::Ordered);
    }

    /// Whether a work waits for earlier uses of a buffer as if it wrote it, and up to which work.
    ///
    /// # Panics
    /// If it depends on another work of its group by a buffer that the group does not share.
    fn waits_as(&self, work: &'static str, touch: &Touch<'_>) -> (bool, u64) {
        let Some(group) = &self.unordered else {
            return (touch.writes, u64::MAX);
        };
        let is_shared = touch.access == Access::Kernel && group.shared.contains(&touch.core.raw());
        let shared = is_shared.then_some(Access::Kernel);
        if let Some((other, wrote)) = (touch.core).conflict(touch.writes, group.since, shared) {
            panic!(
                "`{work}` {} `{}`, which `{other}` {}, and the two are in no order: {}",
                if touch.writes { "writes" } else { "reads" },
                touch.core.name(),
                if wrote { "writes" } else { "reads" },
                group.reason
            );
        }
        match is_shared {
            false => (touch.writes, u64::MAX),
            true if self.ctx().orders_groups => (touch.writes, u64::MAX),
            // The first one waits for all that comes before the group: it is not waited for by those after it, which may write.
            true => (true, group.since),
        }
    }

    /// Records the barrier that a work needs, if it needs one, and notes what it uses.
    ///
    /// # Panics
    /// If it would be needed within a pass, or a buffer belongs to another context.
    pub(crate) fn touch(&mut self, work: &'static str, touches: &[Touch<'_>]) {
        for touch in touches {
            touch.core.assert_of(self.ctx());
        }
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
            let (writes, up_to) = self.waits_as(work, touch);
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
            let (order, to) = (&self.recording.order, (touch.access, writes));
            (touch.core).wait_for(order, to, up_to, &mut wait, reason);
        }
        if separates && !self.is_in_pass {
            wait.separate(self.ctx().info().has_graphics);
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
        self.list_entry(|| Listed::Barrier(reasons));
    }

    /// After a recording that was dropped, waits for everything.
    pub(crate) fn settle_order(&mut self) {
        if self.is_in_pass {
            return;
        }
        let now = self.ctx().recordings().now();
        if self.recording.order.settle(now) {
            self.full_barrier(vk::PipelineStageFlags::ALL_COMMANDS);
            self.commands.barriers += 1;
            self.list_entry(|| Listed::Barrier(Vec::new()));
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

    /// From now on every kernel and every copy waits for the one before, even without a dependency, so that each can be timed by
    /// itself.
    pub fn separate_works(&mut self) {
        self.separates = true;
    }

    /// Lists what is recorded from now on.
    pub fn list(&mut self) {
        self.list = Some(Vec::new());
    }

    /// Works recorded since [`Recorder::list`], in order.
    pub fn listed(&mut self) -> Vec<Listed> {
        self.list.take().unwrap_or_default()
    }

    /// Adds to the list, where there is one.
    pub(crate) fn list_entry(&mut self, entry: impl FnOnce() -> Listed) {
        if let Some(list) = &mut self.list {
            list.push(entry());
        }
    }
}
