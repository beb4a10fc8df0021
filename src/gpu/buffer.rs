//! Typed, named buffers.

use std::marker::PhantomData;
use std::sync::{Arc, Mutex, MutexGuard};

use ash::vk;
use bytemuck::Pod;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};

use super::access::{Access, History};
use super::context::Context;
use super::error::{Check, GpuError, GpuResult};
use super::graveyard::Corpse;

/// What a buffer's memory is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Domain {
    /// Used by the device only; [`Context::upload`] and [`Context::download`] reach it.
    Device,
    /// Written by the host, read by the device.
    Upload,
    /// Written by the device, read by the host.
    Readback,
}

/// `len` elements of `T` on the device.
///
/// Device buffers start with whatever the memory held; see [`Buffer::zeroed`] and [`Buffer::from_slice`].
pub struct Buffer<T> {
    core: Arc<BufferCore>,
    element: PhantomData<T>,
}

/// The elements of a mapped buffer, which no frame can write meanwhile.
pub struct Mapped<'a, T> {
    elements: &'a [T],
    core: &'a BufferCore,
}

impl<T> std::ops::Deref for Mapped<'_, T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        self.elements
    }
}

impl<T> Drop for Mapped<'_, T> {
    fn drop(&mut self) {
        self.core.lock().readers -= 1;
    }
}

/// A buffer of any element type, as barriers and arguments take it.
pub trait AnyBuffer {
    /// What does not depend on the element type.
    fn core(&self) -> &BufferCore;
}

/// The part of a [`Buffer`] that does not depend on its element type.
pub struct BufferCore {
    ctx: Arc<Context>,
    name: String,
    domain: Domain,
    size: u64,
    raw: vk::Buffer,
    /// Taken by `drop` only.
    allocation: Option<Allocation>,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    history: History,
    /// The last recording that uses the buffer.
    ticket: u64,
    /// Slices of it that the host holds.
    readers: usize,
}

impl<T: Pod> Buffer<T> {
    /// Allocates `len` elements; the name appears in errors, in the checker's messages and in capture tools.
    ///
    /// # Errors
    /// More than one binding or one allocation of this device can hold, or no memory.
    pub fn new(ctx: &Arc<Context>, name: &str, len: usize, domain: Domain) -> GpuResult<Self> {
        const {
            assert!(
                align_of::<T>() <= 16,
                "mapped memory is aligned to 16 bytes"
            )
        };
        const {
            assert!(
                size_of::<T>() > 0 && size_of::<T>().is_multiple_of(4),
                "elements have a multiple of 4 bytes"
            )
        };
        let core = BufferCore::new(ctx, name, len, size_of::<T>() as u64, domain)?;
        Ok(Self {
            core: Arc::new(core),
            element: PhantomData,
        })
    }

    /// A device buffer of zeros.
    ///
    /// # Errors
    /// As [`Buffer::new`]; the device was lost.
    pub fn zeroed(ctx: &Arc<Context>, name: &str, len: usize) -> GpuResult<Self> {
        let buffer = Self::new(ctx, name, len, Domain::Device)?;
        ctx.fill(&buffer, 0)?;
        Ok(buffer)
    }

    /// A device buffer that holds `data`.
    ///
    /// # Errors
    /// As [`Buffer::new`]; the device was lost.
    pub fn from_slice(ctx: &Arc<Context>, name: &str, data: &[T]) -> GpuResult<Self> {
        let buffer = Self::new(ctx, name, data.len(), Domain::Device)?;
        ctx.upload(&buffer, data)?;
        Ok(buffer)
    }

    /// The mapped elements of an `Upload` or `Readback` buffer.
    ///
    /// # Panics
    /// If a frame that uses the buffer has not finished, or no barrier made its writes visible to the host.
    #[must_use]
    pub fn as_slice(&self) -> Mapped<'_, T> {
        let core = &self.core;
        core.assert_not_in_use("read");
        {
            let mut state = core.lock();
            if core.ctx.hazard_check
                && let Some(writer) = state.history.unread_by_host()
            {
                let text = format!(
                    "missing barrier: the host reads `{}`, which `{writer}` wrote; record barrier(.., Access::Readback, ..)",
                    core.name
                );
                drop(state);
                panic!("{text}");
            }
            // The frames that used it were waited for, which orders them before all that follows.
            state.history.clear();
            state.readers += 1;
        }
        let data = core.mapped("download").cast();
        // SAFETY: the memory holds `len` elements of plain data and lives as long as `self`. Nobody writes it: no frame
        // that uses the buffer is unfinished, recording one that writes it panics while `readers` counts this, and
        // writing on the host needs the buffer exclusively.
        let elements = unsafe { std::slice::from_raw_parts(data, self.len()) };
        Mapped { elements, core }
    }

    /// As [`Buffer::as_slice`], to write.
    ///
    /// # Panics
    /// If a frame that uses the buffer has not finished.
    #[must_use]
    pub fn as_mut_slice(&mut self) -> &mut [T] {
        let core = &self.core;
        core.assert_not_in_use("write");
        core.lock().history.clear();
        // SAFETY: as in `as_slice`; and nobody else has the buffer, since texel views are of device buffers only.
        unsafe { std::slice::from_raw_parts_mut(core.mapped("upload").cast(), self.len()) }
    }
}

impl<T> Buffer<T> {
    /// Elements.
    #[must_use]
    pub fn len(&self) -> usize {
        (self.core.size / size_of::<T>() as u64) as usize
    }

    /// Has it no elements?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.core.size == 0
    }

    /// Bytes that the elements take.
    #[must_use]
    pub fn size_in_bytes(&self) -> u64 {
        self.core.size
    }

    /// The name it was made with.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.core.name
    }

    /// Does an unfinished frame use it?
    #[must_use]
    pub fn is_in_use(&self) -> bool {
        self.core.is_in_use()
    }
}

impl<T: Pod> Buffer<T> {
    /// The same device memory seen as elements of another type, such as four floats as one vector, so that a kernel
    /// can use wide loads. Costs nothing.
    ///
    /// # Panics
    /// If the buffer is mapped, or its size is no multiple of the other type's.
    #[must_use]
    pub fn cast<U: Pod>(&self) -> Buffer<U> {
        let core = &self.core;
        assert!(
            core.domain == Domain::Device && core.size.is_multiple_of(size_of::<U>() as u64),
            "`{}` has {} bytes and cannot be seen as elements of {}",
            core.name,
            core.size,
            size_of::<U>()
        );
        Buffer {
            core: Arc::clone(core),
            element: PhantomData,
        }
    }
}

impl<T> Buffer<T> {
    pub(crate) fn shared(&self) -> Arc<BufferCore> {
        Arc::clone(&self.core)
    }
}

impl<T> AnyBuffer for Buffer<T> {
    fn core(&self) -> &BufferCore {
        &self.core
    }
}

impl<T> std::fmt::Debug for Buffer<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "Buffer({:?}, {} x {})",
            self.core.name,
            self.len(),
            std::any::type_name::<T>()
        )
    }
}

impl BufferCore {
    fn new(
        ctx: &Arc<Context>,
        name: &str,
        len: usize,
        element_size: u64,
        domain: Domain,
    ) -> GpuResult<Self> {
        let info = ctx.info();
        let too_large = |limit_name, limit: u64| GpuError::TooLarge {
            object: name.to_owned(),
            len: len as u64,
            size: (len as u64).saturating_mul(element_size),
            limit_name,
            limit,
            largest: limit / element_size,
        };
        // Only device buffers are bound whole; the others may be larger than a binding.
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
        if size > info.max_memory_allocation_size {
            return Err(too_large(
                "maxMemoryAllocationSize",
                info.max_memory_allocation_size,
            ));
        }

        let (location, usage) = match domain {
            Domain::Device => (
                MemoryLocation::GpuOnly,
                vk::BufferUsageFlags::UNIFORM_TEXEL_BUFFER,
            ),
            Domain::Upload => (MemoryLocation::CpuToGpu, vk::BufferUsageFlags::empty()),
            Domain::Readback => (MemoryLocation::GpuToCpu, vk::BufferUsageFlags::empty()),
        };
        let usage = usage
            | vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::INDIRECT_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        // Vulkan has no empty buffers.
        let (raw, allocation) = allocate(ctx, name, size.max(16), usage, location)?;
        ctx.device.set_name(raw, name);
        Ok(Self {
            ctx: Arc::clone(ctx),
            name: name.to_owned(),
            domain,
            size,
            raw,
            allocation: Some(allocation),
            state: Mutex::default(),
        })
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

    /// What the memory is for.
    #[must_use]
    pub fn domain(&self) -> Domain {
        self.domain
    }

    /// The raw handle, for crates that draw by themselves.
    #[must_use]
    pub fn raw(&self) -> vk::Buffer {
        self.raw
    }

    pub(crate) fn ctx(&self) -> &Arc<Context> {
        &self.ctx
    }

    /// Fits one storage-buffer binding? Device buffers always do.
    pub(crate) fn assert_bindable(&self) {
        let limit = self.ctx.info().max_storage_buffer_range;
        assert!(
            self.size <= limit,
            "`{}` has {} bytes; a binding has {limit} at most",
            self.name,
            self.size
        );
    }

    /// Records a use in the frame `ticket`, and panics if a barrier is missing.
    pub(crate) fn touch(&self, ticket: u64, who: &str, access: Access, reads: bool, writes: bool) {
        if writes {
            self.assert_not_read_by_host(who);
        }
        let hazard = {
            let mut state = self.lock();
            state.ticket = ticket;
            if !self.ctx.hazard_check {
                return;
            }
            state.history.touch(&self.name, who, access, reads, writes)
        };
        // Outside the lock, so that a test that catches the panic can go on using the buffer.
        if let Err(hazard) = hazard {
            panic!("{hazard}");
        }
    }

    pub(crate) fn barrier(&self, ticket: u64, from: Access, to: Access) {
        let mut state = self.lock();
        state.ticket = ticket;
        state.history.barrier(from, to);
    }

    /// A full barrier was put round a blocking transfer.
    pub(crate) fn forget_history(&self) {
        self.lock().history.clear();
    }

    pub(crate) fn is_in_use(&self) -> bool {
        let ticket = self.lock().ticket;
        self.ctx.graveyard.is_pending(ticket)
    }

    /// Blocking transfers run before what is being recorded, which nobody means.
    pub(crate) fn assert_not_being_recorded(&self) {
        let ticket = self.lock().ticket;
        assert!(
            !self.ctx.graveyard.is_open(ticket),
            "`{}` is used by a frame that is still being recorded: submit the frame before an upload or a download",
            self.name
        );
    }

    fn mapped(&self, instead: &str) -> *mut std::ffi::c_void {
        let mapped = self.allocation.as_ref().and_then(Allocation::mapped_ptr);
        let mapped = mapped.filter(|_| self.domain != Domain::Device);
        mapped
            .unwrap_or_else(|| panic!("`{}` is a device buffer; use ctx.{instead}", self.name))
            .as_ptr()
    }

    /// A slice that the host holds must not change.
    pub(crate) fn assert_not_read_by_host(&self, who: &str) {
        let readers = self.lock().readers;
        assert!(
            readers == 0,
            "`{who}` writes `{}` while the host holds a slice of it: drop what as_slice returned first",
            self.name
        );
    }

    fn assert_not_in_use(&self, what: &str) {
        assert!(
            !self.is_in_use(),
            "the host cannot {what} `{}`: a frame that uses it has not finished; wait for it",
            self.name
        );
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(|e| e.into_inner())
    }
}

impl Drop for BufferCore {
    fn drop(&mut self) {
        if let Some(allocation) = self.allocation.take() {
            self.ctx.graveyard.add(Corpse::Buffer(self.raw, allocation));
        }
    }
}

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
