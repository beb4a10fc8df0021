//! The part of a buffer without its element type: memory, name, and the history from which barriers follow.

use std::sync::{Arc, Mutex, MutexGuard, Weak};

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocation;

use super::access::{Access, History, Order, Use, Wait};
use super::allocation::allocate;
use super::context::Context;
use super::deletion_queue::Deletion;
use super::error::{GpuError, GpuResult};
use super::pages::{Extent, address_table, most_in_pages, page_size};

/// The purpose of a buffer's memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Domain {
    /// Used by the device only; [`Context::upload`] and [`Context::download`] reach it. Fits one binding.
    Device,
    /// As `Device`, but kernels access it by [`Texels`](super::Texels), or draws as indices, so it may be larger than a binding.
    Texels,
    /// As `Texels`, for elements of 16 bytes. If the device [has pages](super::DeviceInfo::has_pages), it may be larger than an
    /// allocation: pipelines over [tables in pages](super::Tables) reach all of it.
    Pages,
    /// Written by the host, read by the device.
    Upload,
    /// Written by the device, read by the host.
    Readback,
}

impl Domain {
    /// Is it in memory that only the device accesses?
    #[must_use]
    pub fn is_on_device(self) -> bool {
        matches!(self, Domain::Device | Domain::Texels | Domain::Pages)
    }
}

/// The part of a [`Buffer`](super::Buffer) that does not depend on its element type.
pub struct BufferCore {
    pub(super) ctx: Arc<Context>,
    /// Itself, for whatever is to keep it alive.
    own: Weak<Self>,
    pub(super) name: String,
    pub(super) domain: Domain,
    pub(super) size: u64,
    extent: Extent,
    /// One a buffer of the extent; taken by `drop` only.
    allocations: Vec<Allocation>,
    /// The table with the addresses of its pages; taken by `drop` only.
    addresses: Option<(vk::Buffer, Allocation)>,
    state: Mutex<Uses>,
}

#[derive(Default)]
pub(super) struct Uses {
    history: History,
    /// The recordings that use the buffer. Some of them may be over.
    tickets: Vec<u64>,
    /// Something has been written.
    pub(super) has_content: bool,
    /// Slices of it that the host holds.
    pub(super) readers: usize,
}

impl BufferCore {
    pub(super) fn new(
        ctx: &Arc<Context>,
        name: &str,
        len: usize,
        element_size: u64,
        domain: Domain,
    ) -> GpuResult<Arc<Self>> {
        let info = ctx.info();
        let too_large = |limit_name, limit: u64| GpuError::TooLarge {
            object: name.to_owned(),
            len: len as u64,
            size: (len as u64).saturating_mul(element_size),
            limit_name,
            limit,
            largest: limit / element_size,
        };
        // Only these are bound whole; the others may be larger than a binding.
        let binding = if domain == Domain::Device {
            info.max_storage_buffer_range
        } else {
            u64::MAX
        };
        let size = (len as u64)
            .checked_mul(element_size)
            .ok_or_else(|| too_large("the size of an address", u64::MAX))?;
        if size > binding {
            return Err(too_large("maxStorageBufferRange", binding));
        }
        let in_pages = domain == Domain::Pages && info.has_pages;
        if in_pages && size > most_in_pages(info) {
            return Err(too_large("1024 pages", most_in_pages(info)));
        }
        if size > info.max_memory_allocation_size && !in_pages {
            return Err(too_large(
                "maxMemoryAllocationSize",
                info.max_memory_allocation_size,
            ));
        }

        let (location, usage) = match domain {
            Domain::Device | Domain::Texels | Domain::Pages => (
                MemoryLocation::GpuOnly,
                vk::BufferUsageFlags::UNIFORM_TEXEL_BUFFER
                    | vk::BufferUsageFlags::STORAGE_TEXEL_BUFFER,
            ),
            Domain::Upload => (MemoryLocation::CpuToGpu, vk::BufferUsageFlags::empty()),
            Domain::Readback => (MemoryLocation::GpuToCpu, vk::BufferUsageFlags::empty()),
        };
        let by_address = if in_pages {
            vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS
        } else {
            vk::BufferUsageFlags::empty()
        };
        let usage = usage
            | by_address
            | vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::INDIRECT_BUFFER
            | vk::BufferUsageFlags::INDEX_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        let page = if in_pages { page_size(info) } else { u64::MAX };
        let mut core = Self {
            ctx: Arc::clone(ctx),
            own: Weak::new(),
            name: name.to_owned(),
            domain,
            size,
            extent: Extent::in_pages(page),
            allocations: Vec::new(),
            addresses: None,
            state: Mutex::default(),
        };
        // Vulkan has no empty buffers.
        let mut rest = size.max(16);
        while rest > 0 {
            let own = rest.min(page);
            let (raw, allocation) = allocate(ctx, name, own, usage, location)?;
            ctx.device.set_name(raw, name);
            core.extent.add(raw);
            core.allocations.push(allocation);
            rest -= own;
        }
        if in_pages {
            core.addresses = Some(address_table(ctx, name, &core.extent)?);
        }
        Ok(Arc::new_cyclic(|own| {
            core.own = Weak::clone(own);
            core
        }))
    }

    /// The name it was made with.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Bytes that the elements take.
    #[must_use]
    pub fn size_in_bytes(&self) -> u64 {
        self.size
    }

    /// The purpose of the memory.
    #[must_use]
    pub fn domain(&self) -> Domain {
        self.domain
    }

    /// The raw handle, for crates that draw by themselves. If it has several pages, that of the first one.
    #[must_use]
    pub fn raw(&self) -> vk::Buffer {
        self.extent.first()
    }

    /// The buffers that hold its bytes.
    pub(crate) fn extent(&self) -> &Extent {
        &self.extent
    }

    /// The one buffer that all its bytes lie in.
    pub(crate) fn whole(&self) -> vk::Buffer {
        assert!(
            self.extent.is_whole(),
            "`{}` is stored in several pages, and this use needs it in one piece",
            self.name
        );
        self.extent.first()
    }

    /// Do kernels take it as a storage block that holds all of it, or in pages?
    pub(crate) fn is_reached_without_view(&self) -> bool {
        let fits = self.size <= self.ctx.info().max_storage_buffer_range;
        self.addresses.is_some() || (self.ctx.card_forms && fits)
    }

    /// The buffer with the addresses of its pages.
    pub(crate) fn addresses(&self) -> vk::Buffer {
        let (addresses, _) = self.addresses.as_ref().unwrap_or_else(|| {
            panic!(
                "`{}` was not made for pages, and is bound as a table in pages",
                self.name
            )
        });
        *addresses
    }

    pub(crate) fn ctx(&self) -> &Arc<Context> {
        &self.ctx
    }

    /// A share of it, which keeps it alive.
    pub(crate) fn shared(&self) -> Arc<Self> {
        self.own
            .upgrade()
            .expect("it is alive, because it is borrowed")
    }

    /// Panics unless it was made in this context.
    pub(crate) fn assert_of(&self, ctx: &Context) {
        assert!(
            std::ptr::eq(Arc::as_ptr(&self.ctx), ctx),
            "`{}` belongs to another context",
            self.name
        );
    }

    /// Fits one storage-buffer binding? Those of [`Domain::Device`] always do.
    pub(crate) fn assert_bindable(&self) {
        self.whole();
        let limit = self.ctx.info().max_storage_buffer_range;
        assert!(
            self.size <= limit,
            "`{}` has {} bytes; a binding has {limit} at most",
            self.name,
            self.size
        );
    }

    /// Bytes from its beginning that one storage-buffer binding holds, of whole groups of four words.
    pub(crate) fn first_part(&self) -> u64 {
        let limit = self.ctx.info().max_storage_buffer_range;
        if self.size <= limit {
            vk::WHOLE_SIZE
        } else {
            limit / 16 * 16
        }
    }

    /// Adds the earlier uses that a use has to wait for to a barrier; see [`History::wait_for`].
    pub(crate) fn wait_for(
        &self,
        order: &Order,
        to: (Access, bool),
        up_to: u64,
        wait: &mut Wait,
        reason: impl FnMut(&Use, bool),
    ) {
        self.lock().history.wait_for(order, to, up_to, wait, reason);
    }

    /// The work that a use would have to wait for; see [`History::conflict`].
    pub(crate) fn conflict(
        &self,
        writes: bool,
        since: u64,
        shared: Option<Access>,
    ) -> Option<(&'static str, bool)> {
        self.lock().history.conflict(writes, since, shared)
    }

    /// Notes a use in the frame `ticket`.
    pub(crate) fn note(
        &self,
        ticket: u64,
        work: &'static str,
        access: Access,
        at: u64,
        writes: bool,
    ) {
        let mut state = self.lock();
        if writes {
            self.assert_no_readers(&state, work);
        }
        if !state.tickets.contains(&ticket) {
            let queue = &self.ctx.deletion_queue;
            state.tickets.retain(|&earlier| queue.is_pending(earlier));
            state.tickets.push(ticket);
        }
        state.has_content |= writes;
        state.history.note(work, access, at, writes);
    }

    /// Has anything been written to it yet?
    pub(crate) fn has_content(&self) -> bool {
        self.lock().has_content
    }

    /// Forgets uses before a blocking transfer, which has full barriers.
    pub(crate) fn forget_history(&self) {
        let mut state = self.lock();
        state.history.clear();
        state.has_content = true;
    }

    pub(crate) fn is_in_use(&self) -> bool {
        self.is_used_by_any(&self.lock())
    }

    fn is_used_by_any(&self, state: &Uses) -> bool {
        let queue = &self.ctx.deletion_queue;
        (state.tickets.iter()).any(|&ticket| queue.is_pending(ticket))
    }

    /// Panics while a recording uses the buffer: a blocking copy would run before the recording, which is never meant.
    pub(crate) fn assert_not_being_recorded(&self) {
        let queue = &self.ctx.deletion_queue;
        let state = self.lock();
        assert!(
            !state.tickets.iter().any(|&ticket| queue.is_open(ticket)),
            "`{}` is used by a frame that is still being recorded: submit the frame before an upload or a download",
            self.name
        );
    }

    pub(super) fn mapped(&self, instead: &str) -> *mut std::ffi::c_void {
        let mapped = self.allocations.first().and_then(Allocation::mapped_ptr);
        let mapped = mapped.filter(|_| !self.domain.is_on_device());
        mapped
            .unwrap_or_else(|| panic!("`{}` is a device buffer; use ctx.{instead}", self.name))
            .as_ptr()
    }

    /// A slice that the host holds must not change.
    pub(crate) fn assert_not_read_by_host(&self, writer: &str) {
        self.assert_no_readers(&self.lock(), writer);
    }

    fn assert_no_readers(&self, state: &Uses, writer: &str) {
        assert!(
            state.readers == 0,
            "`{writer}` writes `{}` while the host holds a slice of it: drop the slice that as_slice returned first",
            self.name
        );
    }

    /// Locks it for the host. The frames that used it were waited for, which orders them before all that follows.
    ///
    /// # Panics
    /// If a frame that uses it has not finished.
    pub(super) fn lock_for_host(&self, what: &str) -> MutexGuard<'_, Uses> {
        let mut state = self.lock();
        assert!(
            !self.is_used_by_any(&state),
            "the host cannot {what} `{}`: a frame that uses it has not finished; wait for it",
            self.name
        );
        state.history.clear();
        state
    }

    pub(super) fn lock(&self) -> MutexGuard<'_, Uses> {
        self.state.lock().unwrap_or_else(|e| e.into_inner())
    }
}

impl Drop for BufferCore {
    fn drop(&mut self) {
        let allocations = self.allocations.drain(..);
        let buffers = self.extent.buffers().iter().copied().zip(allocations);
        for (raw, allocation) in buffers.chain(self.addresses.take()) {
            self.ctx
                .deletion_queue
                .add(Deletion::Buffer(raw, allocation));
        }
    }
}
