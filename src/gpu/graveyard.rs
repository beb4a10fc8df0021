//! Objects that were dropped while the device may still use them.
//!
//! Every recording takes a ticket. A dropped object waits until every recording that was begun before is over, whether
//! it finished on the device or was thrown away.

use std::collections::BTreeSet;
use std::sync::{Mutex, MutexGuard};

use ash::{khr, vk};
use gpu_allocator::vulkan::Allocation;

/// Something to destroy.
pub(crate) enum Corpse {
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

/// The dropped objects and the recordings that are not over.
#[derive(Default)]
pub(crate) struct Graveyard(Mutex<Inner>);

#[derive(Default)]
struct Inner {
    newest: u64,
    pending: BTreeSet<u64>,
    /// Those of `pending` that are not submitted yet.
    open: BTreeSet<u64>,
    /// Recordings that were thrown away instead of submitted.
    discarded: BTreeSet<u64>,
    /// Submitted recordings whose owner is gone; their fences are asked instead.
    orphans: Vec<(u64, vk::Fence)>,
    /// The newest ticket when it was dropped, and the object.
    corpses: Vec<(u64, Corpse)>,
}

impl Graveyard {
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

    /// A recording was thrown away.
    pub(crate) fn discard(&self, ticket: u64) {
        self.end(ticket);
        self.lock().discarded.insert(ticket);
    }

    /// Was this recording thrown away?
    pub(crate) fn was_discarded(&self, ticket: u64) -> bool {
        self.lock().discarded.contains(&ticket)
    }

    /// Nobody will wait for this recording: from now on its fence is asked.
    pub(crate) fn adopt(&self, ticket: u64, fence: vk::Fence) {
        self.lock().orphans.push((ticket, fence));
    }

    /// Is this recording not over yet?
    pub(crate) fn is_pending(&self, ticket: u64) -> bool {
        self.lock().pending.contains(&ticket)
    }

    /// Is this recording not submitted yet?
    pub(crate) fn is_open(&self, ticket: u64) -> bool {
        self.lock().open.contains(&ticket)
    }

    pub(crate) fn add(&self, corpse: Corpse) {
        let mut inner = self.lock();
        let newest = inner.newest;
        inner.corpses.push((newest, corpse));
    }

    pub(crate) fn take_unused(&self, device: &ash::Device) -> Vec<Corpse> {
        let mut inner = self.lock();
        let Inner {
            pending,
            orphans,
            corpses,
            ..
        } = &mut *inner;
        orphans.retain(|&(ticket, fence)| {
            // SAFETY: the fence lies in the graveyard itself, under a ticket at least as new.
            let running = matches!(unsafe { device.get_fence_status(fence) }, Ok(false));
            if !running {
                pending.remove(&ticket);
            }
            running
        });
        let oldest = pending.first().copied().unwrap_or(u64::MAX);
        let (unused, used) = std::mem::take(corpses)
            .into_iter()
            .partition(|&(newest, _)| newest < oldest);
        *corpses = used;
        let unused: Vec<(u64, Corpse)> = unused;
        unused.into_iter().map(|(_, corpse)| corpse).collect()
    }

    pub(crate) fn take_all(&self) -> Vec<Corpse> {
        std::mem::take(&mut self.lock().corpses)
            .into_iter()
            .map(|(_, corpse)| corpse)
            .collect()
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.0.lock().unwrap_or_else(|e| e.into_inner())
    }
}
