//! Placeholders for arguments that are absent.

use std::sync::Arc;

use ash::vk;

use super::buffer::{AnyBuffer, Buffer};
use super::buffer_core::{BufferCore, Domain};
use super::context::Context;
use super::error::GpuResult;
use super::kernel::Absent;
use super::texels::Texels;

/// Larger than any element.
const WORDS: usize = 64;

/// Buffers of any content: no invocation accesses them, so nothing ever waits for them. They belong to a frame, because a context that
/// owned a buffer would own itself.
pub(crate) struct Placeholder {
    floats: Texels<f32>,
    words: Texels<u32>,
    block: Buffer<u32>,
}

impl Placeholder {
    pub(crate) fn new(ctx: &Arc<Context>) -> GpuResult<Self> {
        let block = Buffer::<u32>::new(ctx, "placeholder", WORDS, Domain::Texels)?;
        Ok(Self {
            floats: Texels::new(&block, 1)?,
            words: Texels::new(&block, 1)?,
            block,
        })
    }

    /// The dummy for a storage block.
    pub(crate) fn block(&self) -> &BufferCore {
        self.block.core()
    }

    /// The dummy for a texel buffer; null for a block.
    pub(crate) fn view(&self, absent: Absent) -> vk::BufferView {
        match absent {
            Absent::Block => vk::BufferView::null(),
            Absent::Floats => self.floats.as_dyn().raw(),
            Absent::Words => self.words.as_dyn().raw(),
        }
    }
}
