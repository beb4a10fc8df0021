//! Breadcrumbs: which work the device has begun, for the error that ends a hang or a lost device.
//!
//! Every dispatch, draw and copy writes its number to host-visible memory right before it. The memory survives the
//! loss of the device, unlike everything that would have to be asked of it.

use std::sync::Arc;

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocation;

use super::buffer_core::allocate;
use super::context::Context;
use super::error::{GpuError, GpuResult, advice};
use super::graveyard::Corpse;

/// Works of one frame that have their own crumb; later ones are known by the last of these.
const CAPACITY: u32 = 4096;
const BEGUN: u32 = 0x6d79_786f;

/// The crumbs of one frame.
pub(crate) struct Crumbs {
    ctx: Arc<Context>,
    raw: vk::Buffer,
    /// Taken by `drop` only.
    allocation: Option<Allocation>,
}

impl Crumbs {
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
            // Each crumb has a place of its own, so they need no barriers among them.
            // SAFETY: `cmd` is being recorded, outside of a pass; the range lies in the buffer.
            unsafe {
                self.ctx
                    .device
                    .raw
                    .cmd_fill_buffer(cmd, self.raw, u64::from(index) * 4, 4, BEGUN)
            };
        }
    }

    /// How many works the device has begun.
    pub(crate) fn begun(&self) -> usize {
        let bytes = self
            .allocation
            .as_ref()
            .and_then(Allocation::mapped_slice)
            .unwrap_or_default();
        bytes
            .chunks_exact(4)
            .take_while(|crumb| **crumb == BEGUN.to_ne_bytes())
            .count()
    }
}

impl Drop for Crumbs {
    fn drop(&mut self) {
        if let Some(allocation) = self.allocation.take() {
            self.ctx.graveyard.add(Corpse::Buffer(self.raw, allocation));
        }
    }
}

/// Adds to a timeout or a lost device what the device was last seen to begin.
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
            advice: advice(kernel.map_or("", String::as_str)),
        },
        GpuError::DeviceLost { call, .. } => GpuError::DeviceLost { call, last: text },
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a timeout tells to do makes the kernel shorter that it was in.
    #[test]
    fn advice_is_for_the_kernel_that_took_too_long() {
        for (kernel, words, never) in [
            ("advance", "particles.count", "distance"),
            ("diffuse", "a smaller atlas (atlas.size)", "distance"),
            ("distance_brute", "distance.method = \"bvh\"", "particles"),
            ("distance_merge", "distance.method = \"bvh\"", "particles"),
            ("distance_raster", "distance.method = \"bvh\"", "particles"),
            ("distance_tiles", "distance.reach", "distance.method"),
            ("distance", "distance.reach", "distance.method"),
            ("unfold", "distance.reach", "particles"),
        ] {
            let error = GpuError::Timeout {
                seconds: 60,
                last: String::new(),
                advice: advice(""),
            };
            let works = ["pose", kernel, "sort_count"].map(str::to_owned);
            let text = blame(error, 2, &works).to_string();
            let begins = format!(
                "the device did not finish within 60 s; the last kernel begun was `{kernel}`, number 2 of 3 in its frame. Use "
            );
            assert!(text.starts_with(&begins), "{text}");
            assert!(
                text.contains(words) && text.contains("atlas.size"),
                "{text}"
            );
            let advice = text.rsplit_once(". ").unwrap().1;
            assert!(!advice.contains(never), "{text}");
            assert!(!advice.contains("limit"), "nobody can raise it: {text}");
        }
    }
}
