//! The order in which buffers are used, and the barriers that follow from it.
//!
//! Each buffer keeps its last write and the reads since then. A recording keeps, for every two kinds of access, the work up to which the
//! first is ordered before the second. From these a [`Recorder`](super::Recorder) finds what a dispatch, a draw or a copy has to wait for,
//! and records one barrier for all of it, or none if nothing has to be ordered.
//!
//! A recording begins with the order of those before it, because they are submitted to the same queue before it. If two recordings are open
//! at once, it is not known which is submitted first: they may share only buffers that neither writes, and each one's order counts for
//! itself only. If a recording is dropped, the uses that buffers keep did not happen: the next one begins with a barrier for everything.
//!
//! Barriers are over all memory: drivers ignore the buffer ranges of buffer barriers.

use ash::vk;

/// A way to touch a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Copies, fills and updates.
    Copy,
    /// Compute kernels.
    Kernel,
    /// Arguments of an indirect dispatch or draw.
    Indirect,
    /// Vertex and fragment shaders.
    Vertex,
    /// The indices of an indexed draw.
    Index,
    /// The host reads mapped memory.
    Readback,
}

impl Access {
    const ALL: [Self; 6] = [
        Self::Copy,
        Self::Kernel,
        Self::Indirect,
        Self::Vertex,
        Self::Index,
        Self::Readback,
    ];

    fn stage(self) -> vk::PipelineStageFlags {
        match self {
            Access::Readback => vk::PipelineStageFlags::HOST,
            Access::Copy => vk::PipelineStageFlags::TRANSFER,
            Access::Kernel => vk::PipelineStageFlags::COMPUTE_SHADER,
            Access::Indirect => vk::PipelineStageFlags::DRAW_INDIRECT,
            Access::Vertex => {
                vk::PipelineStageFlags::VERTEX_SHADER | vk::PipelineStageFlags::FRAGMENT_SHADER
            }
            Access::Index => vk::PipelineStageFlags::VERTEX_INPUT,
        }
    }

    /// Access flags of writes that must be made available.
    fn writes(self) -> vk::AccessFlags {
        match self {
            Access::Copy => vk::AccessFlags::TRANSFER_WRITE,
            Access::Kernel | Access::Vertex => vk::AccessFlags::SHADER_WRITE,
            Access::Indirect | Access::Index | Access::Readback => vk::AccessFlags::empty(),
        }
    }

    /// Access flags of uses to which writes must be made visible.
    fn uses(self) -> vk::AccessFlags {
        match self {
            Access::Copy => vk::AccessFlags::TRANSFER_READ | vk::AccessFlags::TRANSFER_WRITE,
            Access::Kernel | Access::Vertex => {
                vk::AccessFlags::SHADER_READ | vk::AccessFlags::SHADER_WRITE
            }
            Access::Indirect => vk::AccessFlags::INDIRECT_COMMAND_READ,
            Access::Index => vk::AccessFlags::INDEX_READ,
            Access::Readback => vk::AccessFlags::HOST_READ,
        }
    }

    /// Its name in messages, as in `kernel writes`.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Access::Copy => "copy",
            Access::Kernel => "kernel",
            Access::Indirect => "indirect",
            Access::Vertex => "draw",
            Access::Index => "index",
            Access::Readback => "host",
        }
    }
}

/// Some ways to touch a buffer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Accesses(u8);

impl Accesses {
    pub(crate) fn add(&mut self, access: Access) {
        self.0 |= 1 << access as u8;
    }

    pub(crate) fn is_empty(self) -> bool {
        self.0 == 0
    }

    pub(crate) fn each(self) -> impl Iterator<Item = Access> {
        (Access::ALL.into_iter()).filter(move |&access| self.0 & (1 << access as u8) != 0)
    }

    fn stages(self) -> vk::PipelineStageFlags {
        self.each()
            .fold(vk::PipelineStageFlags::empty(), |all, one| {
                all | one.stage()
            })
    }
}

/// A barrier to be recorded: the accesses before and after it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Wait {
    /// Accesses before it that are waited for, and those of them that have written.
    pub(crate) before: Accesses,
    pub(crate) written: Accesses,
    pub(crate) after: Accesses,
}

impl Wait {
    /// Also orders every work before it and every work after it, on a queue that draws or only computes.
    pub(crate) fn separate(&mut self, draws: bool) {
        let all = [Access::Copy, Access::Kernel, Access::Vertex];
        for &access in &all[..if draws { 3 } else { 2 }] {
            self.before.add(access);
            self.written.add(access);
            self.after.add(access);
        }
        self.after.add(Access::Indirect);
    }

    /// Records it.
    pub(crate) fn record(self, device: &ash::Device, cmd: vk::CommandBuffer) {
        let none = vk::AccessFlags::empty();
        let written = (self.written.each()).fold(none, |all, one| all | one.writes());
        // After reads only, an execution dependency suffices: nothing has to be made visible.
        let used = if self.written.is_empty() {
            none
        } else {
            self.after.each().fold(none, |all, one| all | one.uses())
        };
        let barrier = vk::MemoryBarrier::default()
            .src_access_mask(written)
            .dst_access_mask(used);
        let (before, after) = (self.before.stages(), self.after.stages());
        // SAFETY: `cmd` is being recorded, outside of a pass.
        unsafe {
            device.cmd_pipeline_barrier(
                cmd,
                before,
                after,
                vk::DependencyFlags::empty(),
                &[barrier],
                &[],
                &[],
            )
        };
    }
}

/// Orders all work before it against later work of the device (`ALL_COMMANDS`), of the host (`HOST`), or of both.
///
/// # Safety
/// `cmd` is being recorded, outside of a pass.
pub(crate) unsafe fn full_barrier(
    device: &ash::Device,
    cmd: vk::CommandBuffer,
    to: vk::PipelineStageFlags,
) {
    let all = vk::PipelineStageFlags::ALL_COMMANDS;
    let mut access = vk::AccessFlags::empty();
    if to.contains(all) {
        access |= vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE;
    }
    if to.contains(vk::PipelineStageFlags::HOST) {
        access |= vk::AccessFlags::HOST_READ;
    }
    debug_assert!(!access.is_empty(), "it is for neither");
    let barrier = vk::MemoryBarrier::default()
        .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
        .dst_access_mask(access);
    let none = vk::DependencyFlags::empty();
    // SAFETY: the caller's.
    unsafe { device.cmd_pipeline_barrier(cmd, all, to, none, &[barrier], &[], &[]) };
}

/// For every two kinds of access, up to which work they are ordered. All works that are recorded in a context are numbered.
#[derive(Clone, Debug, Default)]
pub(crate) struct Order {
    /// For each pair of accesses: the work up to which the first has finished before the second, and the one up to which its writes are
    /// visible.
    finished: [[u64; 6]; 6],
    visible: [[u64; 6]; 6],
    /// A recording was dropped, so buffers keep uses that did not happen, and lack others.
    is_unknown: bool,
}

/// The context's record of all recordings.
#[derive(Debug, Default)]
pub(crate) struct Recordings {
    /// The number of the last recorded work.
    now: u64,
    begun: u64,
    open: u64,
    /// The order after all submitted recordings.
    order: Order,
}

/// A recording.
#[derive(Debug)]
pub(crate) struct Recording {
    number: u64,
    /// No other recording was open when it began.
    was_alone: bool,
    pub(crate) order: Order,
}

impl Recordings {
    pub(crate) fn begin(&mut self) -> Recording {
        self.begun += 1;
        self.open += 1;
        Recording {
            number: self.begun,
            was_alone: self.open == 1,
            order: self.order.clone(),
        }
    }

    /// Numbers the next work.
    pub(crate) fn count(&mut self) -> u64 {
        self.now += 1;
        self.now
    }

    /// The number of the last recorded work.
    pub(crate) fn now(&self) -> u64 {
        self.now
    }

    pub(crate) fn submitted(&mut self, recording: &Recording) {
        self.open -= 1;
        if recording.was_alone && self.begun == recording.number {
            self.order = recording.order.clone();
        } else {
            // The order is not known, so later recordings wait again.
            let is_unknown = self.order.is_unknown;
            self.order = Order::default();
            self.order.is_unknown = is_unknown;
        }
    }

    pub(crate) fn dropped(&mut self) {
        self.open -= 1;
        self.order.is_unknown = true;
    }
}

impl Order {
    /// Must the recording begin with a barrier for everything? Marks the order as known.
    pub(crate) fn settle(&mut self, now: u64) -> bool {
        if !std::mem::take(&mut self.is_unknown) {
            return false;
        }
        self.finished = [[now; 6]; 6];
        self.visible = [[now; 6]; 6];
        true
    }

    fn has_finished(&self, earlier: &Use, to: Access) -> bool {
        self.finished[earlier.access as usize][to as usize] >= earlier.at
    }

    fn is_visible(&self, earlier: &Use, to: Access) -> bool {
        self.visible[earlier.access as usize][to as usize] >= earlier.at
    }

    /// Notes a barrier after all works up to `now`. Barriers chain: a work that is ordered before one that this barrier waits for is also
    /// ordered before the works after it.
    pub(crate) fn wait(&mut self, wait: &Wait, now: u64) {
        let (finished, visible) = (self.finished, self.visible);
        for after in wait.after.each().map(|access| access as usize) {
            for before in wait.before.each().map(|access| access as usize) {
                for other in 0..finished.len() {
                    let chained = finished[other][before];
                    let up_to = &mut self.finished[other][after];
                    *up_to = chained.max(*up_to);
                    if !wait.written.is_empty() {
                        let chained = visible[other][before];
                        let up_to = &mut self.visible[other][after];
                        *up_to = chained.max(*up_to);
                    }
                }
                self.finished[before][after] = now;
            }
            for before in wait.written.each().map(|access| access as usize) {
                self.visible[before][after] = now;
            }
        }
    }
}

/// Kernels that wait for what comes before them, and not for each other.
#[derive(Debug)]
pub(crate) struct Unordered {
    pub(crate) reason: &'static str,
    /// The buffers that more than one of them may write.
    pub(crate) shared: Vec<vk::Buffer>,
    /// The last work before the first of them.
    pub(crate) since: u64,
}

/// The last uses of one buffer.
#[derive(Debug, Default)]
pub(crate) struct History {
    write: Option<Use>,
    reads: Vec<Use>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Use {
    /// The kernel, copy or pass.
    pub(crate) work: &'static str,
    pub(crate) access: Access,
    at: u64,
}

impl History {
    /// Adds the earlier uses that a use has to wait for to a barrier, except those after `up_to`. Calls `reason` with each of them, and
    /// whether it wrote.
    pub(crate) fn wait_for(
        &self,
        order: &Order,
        (to, writes): (Access, bool),
        up_to: u64,
        wait: &mut Wait,
        mut reason: impl FnMut(&Use, bool),
    ) {
        if let Some(write) = &self.write
            && write.at <= up_to
            && !order.is_visible(write, to)
        {
            reason(write, true);
            wait.before.add(write.access);
            wait.written.add(write.access);
            wait.after.add(to);
        }
        if writes {
            for read in &self.reads {
                if read.at <= up_to && !order.has_finished(read, to) {
                    reason(read, false);
                    wait.before.add(read.access);
                    wait.after.add(to);
                }
            }
        }
    }

    /// The work recorded after `since` that a use would have to wait for, regardless of barriers, and whether it wrote. Uses by the
    /// shared access do not count.
    pub(crate) fn conflict(
        &self,
        writes: bool,
        since: u64,
        shared: Option<Access>,
    ) -> Option<(&'static str, bool)> {
        let of = |earlier: &Use, wrote| {
            let counts = earlier.at > since && Some(earlier.access) != shared;
            counts.then_some((earlier.work, wrote))
        };
        let write = self.write.as_ref().and_then(|write| of(write, true));
        let mut reads = self.reads.iter().filter(|_| writes);
        write.or_else(|| reads.find_map(|read| of(read, false)))
    }

    /// Notes a use.
    pub(crate) fn note(&mut self, work: &'static str, access: Access, at: u64, writes: bool) {
        let this = Use { work, access, at };
        if writes {
            self.reads.clear();
            self.write = Some(this);
        } else {
            self.reads.retain(|read| read.access != access);
            self.reads.push(this);
        }
    }

    /// Forgets all uses, because of a full barrier, such as uploads and downloads record before and after themselves.
    pub(crate) fn clear(&mut self) {
        self.write = None;
        self.reads.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An event of a recording.
    enum Event {
        Use {
            buffer: usize,
            access: Access,
            writes: bool,
            /// The number of the unordered group that shares the buffer, if it is used so.
            group: Option<u64>,
        },
        Barrier(Wait),
    }

    /// Goes through all barriers after a use, one by one: has the use finished before a next event with this access, and are its writes
    /// visible there?
    fn is_over(later: &[Event], from: Access, to: Access) -> [bool; 2] {
        let [mut over, mut visible] = [Accesses::default(); 2];
        for event in later {
            let Event::Barrier(wait) = event else {
                continue;
            };
            let has = |set: Accesses, access: Access| set.each().any(|one| one == access);
            let meets = |a: Accesses, b: Accesses| a.each().any(|one| has(b, one));
            if has(wait.before, from) || meets(wait.before, over) {
                wait.after.each().for_each(|access| over.add(access));
            }
            let makes_visible = !wait.written.is_empty() && meets(wait.before, visible);
            if has(wait.written, from) || makes_visible {
                wait.after.each().for_each(|access| visible.add(access));
            }
        }
        let has = |set: Accesses| set.each().any(|one| one == to);
        [has(over), has(visible)]
    }

    /// Is there an earlier use that this one must wait for, but does not? Uses of a shared buffer by one group need no order.
    fn has_hazard(
        events: &[Event],
        (buffer, access, writes): (usize, Access, bool),
        group: Option<u64>,
    ) -> bool {
        (0..events.len()).any(|i| match events[i] {
            Event::Use {
                buffer: other,
                access: from,
                writes: wrote,
                group: of,
            } if other == buffer && (wrote || writes) && (of.is_none() || of != group) => {
                let [over, visible] = is_over(&events[i + 1..], from, access);
                !(if wrote { visible } else { over })
            }
            _ => false,
        })
    }

    /// Catches a hazard between any two uses, however far apart and by whatever chain of barriers; and a barrier that nothing
    /// needs.
    #[test]
    fn every_hazard_has_a_barrier_and_every_barrier_a_hazard() {
        let mut state = 7_u64;
        let mut random = |below: u64| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) % below
        };
        let mut barriers = 0;
        for _ in 0..400 {
            let mut order = Order::default();
            let mut histories: [History; 4] = Default::default();
            let mut events: Vec<Event> = Vec::new();
            // The last work before an unordered group, which shares the first two buffers.
            let mut group: Option<u64> = None;
            for at in 1..=30 {
                group = match group {
                    None if random(6) == 0 => Some(at - 1),
                    Some(_) if random(4) == 0 => None,
                    same => same,
                };
                let access = match group {
                    None => Access::ALL[random(5) as usize],
                    Some(_) => Access::Kernel,
                };
                let can_write = matches!(access, Access::Copy | Access::Kernel);
                let shared = |buffer| group.filter(|_| buffer < 2);
                let mut uses = Vec::new();
                for buffer in 0..histories.len() {
                    if random(3) == 0 {
                        uses.push((buffer, access, can_write && random(2) == 0));
                    }
                }
                // A use of a buffer that is not shared is refused if it depends on another work of the group.
                let is_refused = |&(buffer, _, writes): &(usize, Access, bool)| {
                    let conflict = |since| histories[buffer].conflict(writes, since, None);
                    shared(buffer).is_none() && group.and_then(conflict).is_some()
                };
                if uses.iter().any(is_refused) {
                    continue;
                }
                let mut wait = Wait::default();
                for &(buffer, access, writes) in &uses {
                    let (writes, up_to) = match shared(buffer) {
                        None => (writes, u64::MAX),
                        Some(since) => (true, since),
                    };
                    let history = &histories[buffer];
                    history.wait_for(&order, (access, writes), up_to, &mut wait, |_, _| ());
                }
                let hazard = |&one: &(usize, Access, bool)| has_hazard(&events, one, shared(one.0));
                let is_needed = uses.iter().any(hazard);
                let waits = !wait.before.is_empty();
                // A kernel of a group waits as if it wrote the shared buffers.
                assert!(
                    waits == is_needed || (waits && group.is_some()),
                    "work {at}"
                );
                if waits {
                    order.wait(&wait, at - 1);
                    events.push(Event::Barrier(wait));
                    barriers += 1;
                }
                for &(buffer, access, writes) in &uses {
                    let group = shared(buffer);
                    let one = (buffer, access, writes);
                    assert!(!has_hazard(&events, one, group), "work {at}");
                    histories[buffer].note("a work", access, at, writes);
                    let event = Event::Use {
                        buffer,
                        access,
                        writes,
                        group,
                    };
                    events.push(event);
                }
            }
        }
        assert!(barriers > 4000, "{barriers}");
    }
}
