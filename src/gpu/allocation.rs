//! Raw buffers with memory.

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};

use super::context::Context;
use super::error::{Check, GpuError, GpuResult};

/// A raw buffer with memory bound to it; nothing is left behind on errors.
pub(crate) fn allocate(
    ctx: &Context,
    name: &str,
    size: u64,
    usage: vk::BufferUsageFlags,
    location: MemoryLocation,
) -> GpuResult<(vk::Buffer, Allocation)> {
    let device = &ctx.device.raw;
    let info = vk::BufferCreateInfo::default()
        .size(size)
        .usage(usage)
        .sharing_mode(vk::SharingMode::EXCLUSIVE);
    // SAFETY: the device is alive; so below.
    let raw = unsafe { device.create_buffer(&info, None) }.check("vkCreateBuffer", name)?;
    // SAFETY: `raw` was made just now.
    let requirements = unsafe { device.get_buffer_memory_requirements(raw) };
    let description = AllocationCreateDesc {
        name,
        requirements,
        location,
        linear: true,
        allocation_scheme: AllocationScheme::GpuAllocatorManaged,
    };
    let allocation = ctx.lock_allocator().allocate(&description);
    let bound = allocation
        .map_err(|source| GpuError::OutOfMemory {
            object: name.to_owned(),
            size,
            source,
        })
        .and_then(|allocation| {
            // SAFETY: the allocation fits `raw`'s requirements and is used by nothing else.
            let bound =
                unsafe { device.bind_buffer_memory(raw, allocation.memory(), allocation.offset()) };
            match bound.check("vkBindBufferMemory", name) {
                Ok(()) => Ok(allocation),
                Err(error) => {
                    ctx.free(allocation);
                    Err(error)
                }
            }
        });
    match bound {
        Ok(allocation) => Ok((raw, allocation)),
        Err(error) => {
            // SAFETY: used by nothing.
            unsafe { device.destroy_buffer(raw, None) };
            Err(error)
        }
    }
}
