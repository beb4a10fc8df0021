//! Who may touch a buffer after whom: the short list of accesses, and the check that every barrier is there.
//!
//! The checker follows the order of recording, which is the order of submission on the one queue. It keeps for each
//! buffer the last write and the reads since then, each with the accesses that barriers have ordered after it.

use std::fmt;

use ash::vk;

/// A way to touch a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// The host writes mapped memory.
    Upload,
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
    pub(crate) fn stage(self) -> vk::PipelineStageFlags {
        match self {
            Access::Upload | Access::Readback => vk::PipelineStageFlags::HOST,
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
    pub(crate) fn writes(self) -> vk::AccessFlags {
        match self {
            Access::Upload => vk::AccessFlags::HOST_WRITE,
            Access::Copy => vk::AccessFlags::TRANSFER_WRITE,
            Access::Kernel | Access::Vertex => vk::AccessFlags::SHADER_WRITE,
            Access::Indirect | Access::Index | Access::Readback => vk::AccessFlags::empty(),
        }
    }

    /// What it has to be made visible to.
    pub(crate) fn uses(self) -> vk::AccessFlags {
        match self {
            Access::Upload => vk::AccessFlags::HOST_WRITE,
            Access::Copy => vk::AccessFlags::TRANSFER_READ | vk::AccessFlags::TRANSFER_WRITE,
            Access::Kernel | Access::Vertex => {
                vk::AccessFlags::SHADER_READ | vk::AccessFlags::SHADER_WRITE
            }
            Access::Indirect => vk::AccessFlags::INDIRECT_COMMAND_READ,
            Access::Index => vk::AccessFlags::INDEX_READ,
            Access::Readback => vk::AccessFlags::HOST_READ,
        }
    }

    fn bit(self) -> u8 {
        1 << self as u8
    }
}

/// What the checker knows of one buffer.
#[derive(Debug, Default)]
pub(crate) struct History {
    write: Option<Use>,
    reads: Vec<Use>,
}

#[derive(Debug)]
struct Use {
    who: String,
    access: Access,
    /// Bits of the accesses that barriers have put after it.
    ordered_before: u8,
}

/// A barrier that is missing.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Hazard {
    buffer: String,
    earlier: String,
    earlier_wrote: bool,
    from: Access,
    later: String,
    later_writes: bool,
    to: Access,
}

impl fmt::Display for Hazard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let did = |writes: bool, past: bool| match (writes, past) {
            (true, true) => "wrote",
            (false, true) => "read",
            (true, false) => "writes",
            (false, false) => "reads",
        };
        write!(
            f,
            "missing barrier: `{}` {} the buffer `{}`, which `{}` {} before it; \
             record barrier(Access::{:?}, Access::{:?}, ..) on it between the two",
            self.later,
            did(self.later_writes, false),
            self.buffer,
            self.earlier,
            did(self.earlier_wrote, true),
            self.from,
            self.to,
        )
    }
}

impl History {
    /// Records a use; says which barrier it lacks.
    pub(crate) fn touch(
        &mut self,
        buffer: &str,
        who: &str,
        access: Access,
        reads: bool,
        writes: bool,
    ) -> Result<(), Hazard> {
        let after = |earlier: &Use, earlier_wrote| Hazard {
            buffer: buffer.to_owned(),
            earlier: earlier.who.clone(),
            earlier_wrote,
            from: earlier.access,
            later: who.to_owned(),
            later_writes: writes,
            to: access,
        };
        if let Some(write) = self
            .write
            .as_ref()
            .filter(|w| w.ordered_before & access.bit() == 0)
        {
            return Err(after(write, true));
        }
        if writes
            && let Some(read) = self
                .reads
                .iter()
                .find(|r| r.ordered_before & access.bit() == 0)
        {
            return Err(after(read, false));
        }
        let this = Use {
            who: who.to_owned(),
            access,
            ordered_before: 0,
        };
        if writes {
            self.reads.clear();
            self.write = Some(this);
        } else if reads {
            self.reads.retain(|r| r.access != access);
            self.reads.push(this);
        }
        Ok(())
    }

    /// Records a barrier. Barriers chain: what is ordered before `from` is ordered before `to` as well.
    pub(crate) fn barrier(&mut self, from: Access, to: Access) {
        for earlier in self.write.iter_mut().chain(&mut self.reads) {
            if earlier.access == from || earlier.ordered_before & from.bit() != 0 {
                earlier.ordered_before |= to.bit();
            }
        }
    }

    /// Forgets everything: a full barrier on the device, as uploads and downloads record round themselves.
    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }

    /// Has the last write been made visible to the host?
    pub(crate) fn unread_by_host(&self) -> Option<&str> {
        let write = self.write.as_ref()?;
        let visible =
            write.access == Access::Upload || write.ordered_before & Access::Readback.bit() != 0;
        (!visible).then_some(&write.who)
    }
}
