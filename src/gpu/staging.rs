//! Vulkan objects that blocking transfers keep for reuse.

use ash::vk;
use gpu_allocator::vulkan::Allocation;

use super::deletion_queue::Deletion;

/// Vulkan objects of blocking transfers; made on first use.
#[derive(Default)]
pub(crate) struct Staging {
    pub(crate) pool: vk::CommandPool,
    /// Allocated once: synchronization validation (1.3.239) keeps about 3 kB of every command buffer that was freed.
    pub(crate) cmd: vk::CommandBuffer,
    pub(crate) fence: vk::Fence,
    pub(crate) upload: Option<(vk::Buffer, Allocation)>,
    pub(crate) download: Option<(vk::Buffer, Allocation)>,
}

impl Staging {
    /// All of it, to be destroyed.
    pub(crate) fn deletions(self) -> impl Iterator<Item = Deletion> {
        let frame = Deletion::Frame {
            pool: self.pool,
            queries: vk::QueryPool::null(),
            fence: self.fence,
        };
        let buffers = self.upload.into_iter().chain(self.download);
        let buffers = buffers.map(|(buffer, allocation)| Deletion::Buffer(buffer, allocation));
        std::iter::once(frame).chain(buffers)
    }
}
