//! What is bound where a kernel is given nothing.

use std::sync::Arc;

use ash::vk;

use super::buffer::{AnyBuffer, Buffer};
use super::buffer_core::BufferCore;
use super::context::Context;
use super::error::GpuResult;
use super::kernel::Absent;
use super::texels::Texels;

/// Larger than any element.
const WORDS: usize = 64;

/// Zeros.
pub(crate) struct Placeholder {
    floats: Texels<f32>,
    words: Texels<u32>,
    read: Buffer<u32>,
    /// Of its own: the validation layer takes a block for written that the shader would write with other constants. So this
    /// one has barriers as every buffer has, and what is only read needs none.
    written: Buffer<u32>,
}

impl Placeholder {
    pub(crate) fn new(ctx: &Arc<Context>) -> GpuResult<Self> {
        let read = Buffer::<u32>::zeroed(ctx, "placeholder.read", WORDS)?;
        Ok(Self {
            floats: Texels::new(&read, 1)?,
            words: Texels::new(&read, 1)?,
            read,
            written: Buffer::zeroed(ctx, "placeholder.written", WORDS)?,
        })
    }

    /// In place of a storage block.
    pub(crate) fn block(&self, is_written: bool) -> &BufferCore {
        if is_written {
            self.written.core()
        } else {
            self.read.core()
        }
    }

    /// In place of a texel buffer; null for what is none.
    pub(crate) fn view(&self, absent: Absent) -> vk::BufferView {
        match absent {
            Absent::Block => vk::BufferView::null(),
            Absent::Floats => self.floats.as_dyn().raw(),
            Absent::Words => self.words.as_dyn().raw(),
        }
    }
}
