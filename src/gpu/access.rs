//! Who touches a buffer after whom, and the barriers that follow from it.
//!
//! Each buffer keeps its last write and the reads since then. The context keeps, for every two ways to touch a buffer, up to
//! when the one is ordered before the other. So a [`Recorder`](super::Recorder) finds what a dispatch, a draw or a copy has to
//! wait for, and records one barrier for all of it: none where nothing depends on anything. That follows the order of recording,
//! which is the order of submission on the one queue; two recordings that are open at once share only what neither writes.
//!
//! Barriers are over all memory: devices do not tell buffers apart in them.

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

    /// What may have been written and has to be made available.
    fn writes(self) -> vk::AccessFlags {
        match self {
            Access::Copy => vk::AccessFlags::TRANSFER_WRITE,
            Access::Kernel | Access::Vertex => vk::AccessFlags::SHADER_WRITE,
            Access::Indirect | Access::Index | Access::Readback => vk::AccessFlags::empty(),
        }
    }

    /// What it has to be made visible to.
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

    /// What is done by it, as in `kernel writes`.
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

/// A barrier in the making: what is waited for, by what.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Wait {
    /// Accesses that come before it, and those of them that have written.
    pub(crate) before: Accesses,
    pub(crate) written: Accesses,
    pub(crate) after: Accesses,
}

impl Wait {
    /// Records it.
    pub(crate) fn record(self, device: &ash::Device, cmd: vk::CommandBuffer) {
        let none = vk::AccessFlags::empty();
        let written = (self.written.each()).fold(none, |all, one| all | one.writes());
        // What has only been read is over when the stages are: nothing has to be made visible.
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

/// Up to when what was done is ordered before what is done next.
#[derive(Debug, Default)]
pub(crate) struct Order {
    /// Counts everything that is recorded.
    now: u64,
    /// Of each access, up to when it has finished before each other one; and up to when what it wrote is visible there.
    finished: [[u64; 6]; 6],
    visible: [[u64; 6]; 6],
}

impl Order {
    /// The next thing is recorded.
    pub(crate) fn advance(&mut self) -> u64 {
        self.now += 1;
        self.now
    }

    fn has_finished(&self, earlier: &Use, to: Access) -> bool {
        self.finished[earlier.access as usize][to as usize] >= earlier.at
    }

    fn is_visible(&self, earlier: &Use, to: Access) -> bool {
        self.visible[earlier.access as usize][to as usize] >= earlier.at
    }

    /// A barrier is recorded. Barriers chain: what is ordered before something that this one waits for is ordered before what
    /// comes after it as well.
    pub(crate) fn wait(&mut self, wait: &Wait) {
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
                self.finished[before][after] = self.now;
            }
            for before in wait.written.each().map(|access| access as usize) {
                self.visible[before][after] = self.now;
            }
        }
    }

    /// A recording with barriers in it was dropped: none of them took place, and nothing is known to be in order.
    pub(crate) fn forget(&mut self) {
        self.finished = Default::default();
        self.visible = Default::default();
    }
}

/// What is known of one buffer.
#[derive(Debug, Default)]
pub(crate) struct History {
    write: Option<Use>,
    reads: Vec<Use>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Use {
    pub(crate) who: &'static str,
    pub(crate) access: Access,
    at: u64,
}

impl History {
    /// Adds to a barrier what has to be waited for before a use. `tell` is given each of it, and whether it wrote.
    pub(crate) fn wait_for(
        &self,
        order: &Order,
        to: Access,
        writes: bool,
        wait: &mut Wait,
        mut tell: impl FnMut(&Use, bool),
    ) {
        if let Some(write) = &self.write
            && !order.is_visible(write, to)
        {
            tell(write, true);
            wait.before.add(write.access);
            wait.written.add(write.access);
            wait.after.add(to);
        }
        if writes {
            for read in &self.reads {
                if !order.has_finished(read, to) {
                    tell(read, false);
                    wait.before.add(read.access);
                    wait.after.add(to);
                }
            }
        }
    }

    /// Notes a use.
    pub(crate) fn note(&mut self, who: &'static str, access: Access, at: u64, writes: bool) {
        let this = Use { who, access, at };
        if writes {
            self.reads.clear();
            self.write = Some(this);
        } else {
            self.reads.retain(|read| read.access != access);
            self.reads.push(this);
        }
    }

    /// Forgets everything: a full barrier on the device, as uploads and downloads record round themselves.
    pub(crate) fn clear(&mut self) {
        self.write = None;
        self.reads.clear();
    }
}
