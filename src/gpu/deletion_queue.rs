//! The deletion queue: Vulkan objects that were dropped while the device may still use them.
//!
//! Every recording takes a ticket. A dropped object is destroyed once all recordings begun before the drop are over, whether
//! they finished on the device or were discarded.

use std::collections::BTreeSet;
use std::sync::{Mutex, MutexGuard};

use ash::{khr, vk};
use gpu_allocator::vulkan::Allocation;

/// A Vulkan object to destroy.
pub(crate) enum Deletion {
    Buffer(vk::Buffer, Allocation),
    BufferView(vk::BufferView),
    Sampler(vk::Sampler),
    Semaphore(vk::Semaphore),
    Swapchain(khr::swapchain::Device, vk::SwapchainKHR),
    Surface(khr::surface::Instance, vk::SurfaceKHR),
    Image(vk::ImageView, vk::Image, Option<Allocation>),
    Pipeline(vk::Pipeline, vk::PipelineLayout, vk::DescriptorSetLayout),
    Frame {
        pool: vk::CommandPool,
        queries: vk::QueryPool,
        fence: vk::Fence,
    },
}

/// Dropped objects, and the recordings that are not over.
#[derive(Default)]
pub(crate) struct DeletionQueue(Mutex<Inner>);

#[derive(Default)]
struct Inner {
    newest: u64,
    pending: BTreeSet<u64>,
    /// Recordings among `pending` that are not submitted yet.
    open: BTreeSet<u64>,
    /// Submitted recordings that nothing waits for: their fences are polled.
    watched: Vec<(u64, vk::Fence)>,
    /// The newest ticket at the time of the drop, and the object.
    deletions: Vec<(u64, Deletion)>,
}

impl DeletionQueue {
    /// A new recording begins; returns its ticket.
    pub(crate) fn begin(&self) -> u64 {
        let mut inner = self.lock();
        inner.newest += 1;
        let ticket = inner.newest;
        inner.pending.insert(ticket);
        inner.open.insert(ticket);
        ticket
    }

    /// A recording was submitted.
    pub(crate) fn submitted(&self, ticket: u64) {
        self.lock().open.remove(&ticket);
    }

    /// A recording is over.
    pub(crate) fn end(&self, ticket: u64) {
        let mut inner = self.lock();
        inner.pending.remove(&ticket);
        inner.open.remove(&ticket);
    }

    /// From now on polls the recording's fence, since nothing will wait for it.
    pub(crate) fn watch(&self, ticket: u64, fence: vk::Fence) {
        self.lock().watched.push((ticket, fence));
    }

    /// Is this recording not over yet?
    pub(crate) fn is_pending(&self, ticket: u64) -> bool {
        self.lock().pending.contains(&ticket)
    }

    /// Is this recording not submitted yet?
    pub(crate) fn is_open(&self, ticket: u64) -> bool {
        self.lock().open.contains(&ticket)
    }

    /// Queues an object until no recording can use it any more.
    pub(crate) fn add(&self, deletion: Deletion) {
        let mut inner = self.lock();
        let newest = inner.newest;
        inner.deletions.push((newest, deletion));
    }

    /// The objects that no recording can use any more.
    pub(crate) fn take_unused(&self, device: &ash::Device) -> Vec<Deletion> {
        let mut inner = self.lock();
        let Inner {
            pending,
            watched,
            deletions,
            ..
        } = &mut *inner;
        watched.retain(|&(ticket, fence)| {
            // SAFETY: the fence waits in this queue itself, under a ticket at least as new.
            let running = matches!(unsafe { device.get_fence_status(fence) }, Ok(false));
            if !running {
                pending.remove(&ticket);
            }
            running
        });
        let oldest = pending.first().copied().unwrap_or(u64::MAX);
        let (unused, used) = std::mem::take(deletions)
            .into_iter()
            .partition(|&(newest, _)| newest < oldest);
        *deletions = used;
        let unused: Vec<(u64, Deletion)> = unused;
        unused.into_iter().map(|(_, deletion)| deletion).collect()
    }

    /// All objects, at the end of the device.
    pub(crate) fn take_all(&self) -> Vec<Deletion> {
        std::mem::take(&mut self.lock().deletions)
            .into_iter()
            .map(|(_, deletion)| deletion)
            .collect()
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.0.lock().unwrap_or_else(|e| e.into_inner())
    }
}
