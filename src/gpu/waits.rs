//! The barriers of a recording: found from what dispatches, draws and copies touch, recorded just before what has to wait, and
//! listed where somebody wants to see them.

use std::fmt;
use std::sync::PoisonError;

use super::access::{Access, Accesses, Use, Wait};
use super::buffer::AnyBuffer;
use super::buffer_core::BufferCore;
use super::recorder::Recorder;

/// A buffer that something touches.
#[derive(Clone, Copy)]
pub(crate) struct Touch<'a> {
    pub(crate) core: &'a BufferCore,
    pub(crate) access: Access,
    pub(crate) writes: bool,
}

/// What a recording has, in order, as [`Recorder::listed`] tells it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Listed {
    /// A kernel, a copy or a pass, by its name.
    Work(String),
    /// A barrier, and everything that it is for; nothing where it only separates two works, so that each has its own time.
    Barrier(Vec<Reason>),
}

/// One buffer for which a barrier is needed: who touched it before, and who comes after.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reason {
    /// The buffer's name.
    pub buffer: String,
    /// What came before, and by which access.
    pub earlier: (&'static str, &'static str),
    /// Did that write, or only read?
    pub earlier_wrote: bool,
    /// What comes after, and by which access.
    pub later: (&'static str, &'static str),
    /// Does that write, or only read?
    pub later_writes: bool,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let did = |writes: bool, past: &'static str| if writes { "wrote" } else { past };
        let Self { earlier, later, .. } = self;
        write!(
            f,
            "{}: {} {} it ({}), {} {} it ({})",
            self.buffer,
            earlier.0,
            did(self.earlier_wrote, "read"),
            earlier.1,
            later.0,
            if self.later_writes { "writes" } else { "reads" },
            later.1
        )
    }
}

impl Recorder {
    /// Records the barrier that this needs, if it needs one, and notes what it touches.
    ///
    /// # Panics
    /// If it would be needed within a pass.
    pub(crate) fn touch(&mut self, who: &'static str, touches: &[Touch<'_>]) {
        self.wait_before(who, touches);
        let at = self.order(|order| order.advance());
        for touch in touches {
            (touch.core).note(self.ticket, who, touch.access, at, touch.writes);
            self.host_reads |= touch.writes && !touch.core.domain().is_on_device();
        }
    }

    /// Records the barrier that this needs, if it needs one.
    fn wait_before(&mut self, who: &'static str, touches: &[Touch<'_>]) {
        let mut wait = Wait::default();
        let mut reasons = Vec::new();
        let lists = self.list.is_some();
        let ctx = std::sync::Arc::clone(self.ctx());
        let mut order = ctx.order.lock().unwrap_or_else(PoisonError::into_inner);
        for touch in touches {
            let tell = |earlier: &Use, wrote: bool| {
                if lists || self.is_in_pass {
                    reasons.push(Reason {
                        buffer: touch.core.name().to_owned(),
                        earlier: (earlier.who, earlier.access.word()),
                        earlier_wrote: wrote,
                        later: (who, touch.access.word()),
                        later_writes: touch.writes,
                    });
                }
            };
            (touch.core).wait_for(&order, touch.access, touch.writes, &mut wait, tell);
        }
        if wait.before.is_empty() {
            return;
        }
        if self.is_in_pass {
            // Without the lock, so that a test that catches it can go on.
            drop(order);
            panic!(
                "within a pass there are no barriers, and one is needed: {}; call make_visible before the pass",
                reasons.first().map(ToString::to_string).unwrap_or_default()
            );
        }
        order.wait(&wait);
        drop(order);
        self.has_waited = true;
        self.commands.barriers += 1;
        if self.ctx().leave_out != Some(self.commands.barriers - 1) {
            wait.record(self.device(), self.raw());
        }
        if let Some(list) = &mut self.list {
            list.push(Listed::Barrier(reasons));
        }
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
        self.wait_before("a pass", &touches);
    }

    /// Makes what was written for the host visible to it, at the end.
    pub(crate) fn make_visible_to_host(&mut self) {
        if !std::mem::take(&mut self.host_reads) {
            return;
        }
        let mut all = Accesses::default();
        [Access::Copy, Access::Kernel]
            .into_iter()
            .for_each(|access| all.add(access));
        let mut wait = Wait {
            before: all,
            written: all,
            ..Wait::default()
        };
        wait.after.add(Access::Readback);
        self.order(|order| order.wait(&wait));
        wait.record(self.device(), self.raw());
    }

    /// From now on every kernel and every copy waits for the one before, so that each has a time of its own, also where nothing
    /// else makes it wait.
    pub fn separate_works(&mut self) {
        self.separates = true;
    }

    /// Waits for what comes before, where each has a time of its own and it does not wait for it anyway.
    pub(crate) fn separate(&mut self) {
        let has_waited = std::mem::take(&mut self.has_waited);
        if !self.separates || has_waited {
            return;
        }
        let mut wait = Wait::default();
        for access in [Access::Copy, Access::Kernel, Access::Vertex] {
            wait.before.add(access);
            wait.written.add(access);
            wait.after.add(access);
        }
        self.order(|order| order.wait(&wait));
        wait.record(self.device(), self.raw());
        if let Some(list) = &mut self.list {
            list.push(Listed::Barrier(Vec::new()));
        }
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

    fn order<R>(&self, change: impl FnOnce(&mut super::access::Order) -> R) -> R {
        let mut order = (self.ctx().order.lock()).unwrap_or_else(PoisonError::into_inner);
        change(&mut order)
    }

    /// It is dropped, and none of its barriers takes place.
    pub(crate) fn forget_order(&self) {
        self.order(super::access::Order::forget);
    }
}
