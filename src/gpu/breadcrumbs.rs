//! Breadcrumbs: which work the device has begun, for the error message after a hang or a lost device.
//!
//! Every dispatch, draw and copy writes a mark to host-visible memory right before it. The memory survives the
//! loss of the device, when calls to the device fail.

use std::sync::Arc;

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocation;

use super::allocation::allocate;
use super::context::Context;
use super::deletion_queue::Deletion;
use super::error::{GpuError, GpuResult};

/// Works of one frame that have their own breadcrumb. Errors name the last of these for later works.
const CAPACITY: u32 = 4096;
const BEGUN: u32 = 0x6d79_786f;

/// The breadcrumbs of one frame.
pub(crate) struct Breadcrumbs {
    ctx: Arc<Context>,
    raw: vk::Buffer,
    /// Taken by `drop` only.
    allocation: Option<Allocation>,
}

impl Breadcrumbs {
    pub(crate) fn new(ctx: &Arc<Context>) -> GpuResult<Self> {
        let size = u64::from(CAPACITY) * 4;
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let (raw, allocation) =
            allocate(ctx, "breadcrumbs", size, usage, MemoryLocation::GpuToCpu)?;
        ctx.device.set_name(raw, "breadcrumbs");
        Ok(Self {
            ctx: Arc::clone(ctx),
            raw,
            allocation: Some(allocation),
        })
    }

    /// Forgets the last frame, which has finished.
    pub(crate) fn clear(&mut self) {
        if let Some(bytes) = self
            .allocation
            .as_mut()
            .and_then(Allocation::mapped_slice_mut)
        {
            bytes.fill(0);
        }
    }

    /// Records that the work number `index` begins.
    pub(crate) fn leave(&self, cmd: vk::CommandBuffer, index: u32) {
        if index < CAPACITY {
            // Each breadcrumb has its own address, so they need no barriers between them.
            // SAFETY: `cmd` is being recorded, outside of a pass; the range lies in the buffer.
            unsafe {
                self.ctx
                    .device
                    .raw
                    .cmd_fill_buffer(cmd, self.raw, u64::from(index) * 4, 4, BEGUN)
            };
        }
    }

    /// Number of works that the device has begun.
    pub(crate) fn begun(&self) -> usize {
        let mapped = self.allocation.as_ref().and_then(Allocation::mapped_ptr);
        let Some(first) = mapped.map(|mapped| mapped.cast::<u32>()) else {
            return 0;
        };
        let has_begun = |index: &usize| {
            // SAFETY: the memory has this many words, and is aligned as a buffer. The device may be writing it, so there is no
            // reference to it.
            let word = unsafe { first.add(*index).read_volatile() };
            word == BEGUN
        };
        (0..CAPACITY as usize).take_while(has_begun).count()
    }
}

impl Drop for Breadcrumbs {
    fn drop(&mut self) {
        if let Some(allocation) = self.allocation.take() {
            self.ctx
                .deletion_queue
                .add(Deletion::Buffer(self.raw, allocation));
        }
    }
}

/// Adds the last work that the device began to a timeout or lost-device error.
pub(crate) fn blame(error: GpuError, begun: usize, works: &[String]) -> GpuError {
    let kernel = begun.checked_sub(1).and_then(|i| works.get(i));
    let text = match kernel {
        Some(name) => format!(
            "the last kernel begun was `{name}`, number {begun} of {} in its frame",
            works.len()
        ),
        None => "it had not begun the frame".to_owned(),
    };
    match error {
        GpuError::Timeout { seconds, .. } => GpuError::Timeout {
            seconds,
            last: text,
            kernel: kernel.cloned(),
        },
        GpuError::DeviceLost { call, .. } => GpuError::DeviceLost { call, last: text },
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernel_that_took_too_long_is_named() {
        let timeout = || GpuError::Timeout {
            seconds: 60,
            last: String::new(),
            kernel: None,
        };
        let works = ["first", "second", "third"].map(str::to_owned);
        let error = blame(timeout(), 2, &works);
        assert_eq!(
            error.to_string(),
            "the device did not finish within 60 s; the last kernel begun was `second`, number 2 of 3 in its frame"
        );
        let GpuError::Timeout { kernel, .. } = error else {
            panic!("{error}");
        };
        assert_eq!(kernel.as_deref(), Some("second"));
        let error = blame(timeout(), 0, &works);
        assert!(matches!(error, GpuError::Timeout { kernel: None, .. }));
        assert!(error.to_string().ends_with("it had not begun the frame"));
    }
}
