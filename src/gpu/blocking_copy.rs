//! Blocking transfers: upload, download and fill, through staging memory and chunk by chunk.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use ash::vk;
use bytemuck::Pod;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocation;

use super::access::full_barrier;
use super::allocation::allocate;
use super::buffer::{AnyBuffer, Buffer};
use super::buffer_core::Domain;
use super::context::Context;
use super::error::{Check, GpuResult};
use super::pages::{Extent, copy_bytes};
use super::staging::Staging;

/// Bytes that one chunk moves.
const CHUNK: u64 = 8 << 20;

impl Staging {
    /// A transfer that still runs keeps what it uses; the next one creates its own.
    fn abandon(&mut self, ctx: &Context) {
        let ticket = ctx.deletion_queue.begin();
        ctx.deletion_queue.submitted(ticket);
        ctx.deletion_queue.watch(ticket, self.fence);
        for deletion in std::mem::take(self).deletions() {
            ctx.deletion_queue.add(deletion);
        }
    }

    /// Records, submits and waits.
    fn run(&mut self, ctx: &Context, record: impl FnOnce(vk::CommandBuffer)) -> GpuResult<()> {
        const WHAT: &str = "a transfer";
        let device = &ctx.device.raw;
        let all = vk::PipelineStageFlags::ALL_COMMANDS;
        // SAFETY: for all calls, the handles are this device's, and nothing of them is in use between two runs.
        unsafe {
            if self.pool == vk::CommandPool::null() {
                let info =
                    vk::CommandPoolCreateInfo::default().queue_family_index(ctx.queue_family());
                self.pool = device
                    .create_command_pool(&info, None)
                    .check("vkCreateCommandPool", WHAT)?;
            }
            if self.cmd == vk::CommandBuffer::null() {
                let info = vk::CommandBufferAllocateInfo::default()
                    .command_pool(self.pool)
                    .command_buffer_count(1);
                self.cmd = device
                    .allocate_command_buffers(&info)
                    .check("vkAllocateCommandBuffers", WHAT)?[0];
            }
            if self.fence == vk::Fence::null() {
                self.fence = device
                    .create_fence(&vk::FenceCreateInfo::default(), None)
                    .check("vkCreateFence", WHAT)?;
            }
            device
                .reset_command_pool(self.pool, vk::CommandPoolResetFlags::RELEASE_RESOURCES)
                .check("vkResetCommandPool", WHAT)?;
            device
                .reset_fences(&[self.fence])
                .check("vkResetFences", WHAT)?;
            let cmds = [self.cmd];
            let begin = vk::CommandBufferBeginInfo::default()
                .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
            let recorded = device
                .begin_command_buffer(cmds[0], &begin)
                .check("vkBeginCommandBuffer", WHAT)
                .and_then(|()| {
                    full_barrier(device, cmds[0], all);
                    record(cmds[0]);
                    full_barrier(device, cmds[0], all | vk::PipelineStageFlags::HOST);
                    device
                        .end_command_buffer(cmds[0])
                        .check("vkEndCommandBuffer", WHAT)
                });
            let finished = recorded.and_then(|()| {
                let submits = [vk::SubmitInfo::default().command_buffers(&cmds)];
                ctx.submits.fetch_add(1, Ordering::Relaxed);
                let submit = || device.queue_submit(*ctx.queue(), &submits, self.fence);
                ctx.heard(ctx.is_there().and_then(|()| submit()))
                    .check("vkQueueSubmit", WHAT)
            });
            finished?;
            // After any error it may still run.
            ctx.wait_for(self.fence, WHAT)
                .inspect_err(|_| self.abandon(ctx))
        }
    }
}

impl<T: Pod> Buffer<T> {
    /// A device buffer of zeros.
    ///
    /// # Errors
    /// As [`Buffer::new`]; the device was lost.
    pub fn zeroed(ctx: &Arc<Context>, name: &str, len: usize) -> GpuResult<Self> {
        Self::zeroed_in(ctx, name, len, Domain::Device)
    }

    /// As [`zeroed`](Self::zeroed), in a [`Domain`].
    ///
    /// # Errors
    /// As [`Buffer::zeroed`].
    pub fn zeroed_in(
        ctx: &Arc<Context>,
        name: &str,
        len: usize,
        domain: Domain,
    ) -> GpuResult<Self> {
        let buffer = Self::new(ctx, name, len, domain)?;
        ctx.fill(&buffer, 0)?;
        Ok(buffer)
    }

    /// A device buffer that holds `data`.
    ///
    /// # Errors
    /// As [`Buffer::new`]; the device was lost.
    pub fn from_slice(ctx: &Arc<Context>, name: &str, data: &[T]) -> GpuResult<Self> {
        Self::from_slice_in(ctx, name, data, Domain::Device)
    }

    /// As [`from_slice`](Self::from_slice), in a [`Domain`].
    ///
    /// # Errors
    /// As [`Buffer::from_slice`].
    pub fn from_slice_in(
        ctx: &Arc<Context>,
        name: &str,
        data: &[T],
        domain: Domain,
    ) -> GpuResult<Self> {
        let buffer = Self::new(ctx, name, data.len(), domain)?;
        ctx.upload(&buffer, data)?;
        Ok(buffer)
    }
}

impl Context {
    /// Writes `data` to the start of `buffer`, and waits. Work submitted before and after is ordered round it.
    ///
    /// # Errors
    /// No memory, a device that was lost or does not answer.
    ///
    /// # Panics
    /// If `data` is longer than the buffer, a frame that uses it is still being recorded, or it belongs to another context.
    pub fn upload<T: Pod>(&self, buffer: &Buffer<T>, data: &[T]) -> GpuResult<()> {
        self.upload_at(buffer, 0, data)
    }

    /// As [`Context::upload`], from the element `start` on.
    ///
    /// # Errors
    /// As [`Context::upload`].
    ///
    /// # Panics
    /// As [`Context::upload`].
    pub fn upload_at<T: Pod>(&self, buffer: &Buffer<T>, start: usize, data: &[T]) -> GpuResult<()> {
        buffer.assert_fits(start, data.len());
        let core = buffer.core();
        core.assert_of(self);
        core.assert_not_being_recorded();
        core.assert_not_read_by_host("upload");
        let mut staging = self.staging.lock().unwrap_or_else(|e| e.into_inner());
        let mut target = (start * size_of::<T>()) as u64;
        for chunk in bytemuck::cast_slice::<T, u8>(data).chunks(CHUNK as usize) {
            let (source, allocation) = mapped_buffer(
                self,
                &mut staging.upload,
                "transfer.upload",
                MemoryLocation::CpuToGpu,
            )?;
            let mapped = allocation
                .mapped_slice_mut()
                .expect("staging memory is mapped");
            mapped[..chunk.len()].copy_from_slice(chunk);
            let (source, size) = (Extent::whole(source), chunk.len() as u64);
            // SAFETY: both are alive until the transfer has finished; the bytes lie in them.
            staging.run(self, |cmd| unsafe {
                let to = (core.extent(), target);
                copy_bytes(&self.device.raw, cmd, (&source, 0), to, size);
            })?;
            target += chunk.len() as u64;
        }
        core.forget_history();
        Ok(())
    }

    /// Reads all of `buffer`, after all work submitted so far.
    ///
    /// # Errors
    /// No memory, a device that was lost or does not answer.
    ///
    /// # Panics
    /// If a frame that uses the buffer is still being recorded, or it belongs to another context.
    pub fn download<T: Pod>(&self, buffer: &Buffer<T>) -> GpuResult<Vec<T>> {
        self.download_range(buffer, 0..buffer.len())
    }

    /// As [`Context::download`], a range of elements.
    ///
    /// # Errors
    /// As [`Context::download`].
    ///
    /// # Panics
    /// As [`Context::download`]; if the range does not lie in the buffer.
    pub fn download_range<T: Pod>(
        &self,
        buffer: &Buffer<T>,
        range: std::ops::Range<usize>,
    ) -> GpuResult<Vec<T>> {
        buffer.assert_has(&range);
        let core = buffer.core();
        core.assert_of(self);
        core.assert_not_being_recorded();
        let mut staging = self.staging.lock().unwrap_or_else(|e| e.into_inner());
        let mut data = vec![T::zeroed(); range.len()];
        let mut source = (range.start * size_of::<T>()) as u64;
        for chunk in bytemuck::cast_slice_mut::<T, u8>(&mut data).chunks_mut(CHUNK as usize) {
            let (target, _) = mapped_buffer(
                self,
                &mut staging.download,
                "transfer.download",
                MemoryLocation::GpuToCpu,
            )?;
            let (target, size) = (Extent::whole(target), chunk.len() as u64);
            // SAFETY: both are alive until the transfer has finished; the bytes lie in them.
            staging.run(self, |cmd| unsafe {
                let from = (core.extent(), source);
                copy_bytes(&self.device.raw, cmd, from, (&target, 0), size);
            })?;
            let mapped = staging
                .download
                .as_ref()
                .and_then(|(_, allocation)| allocation.mapped_slice());
            chunk.copy_from_slice(&mapped.expect("staging memory is mapped")[..chunk.len()]);
            source += chunk.len() as u64;
        }
        core.forget_history();
        Ok(data)
    }

    /// Fills a buffer with a 32-bit value, and waits.
    ///
    /// # Errors
    /// A device that was lost or does not answer.
    ///
    /// # Panics
    /// If a frame that uses the buffer is still being recorded, or it belongs to another context.
    pub fn fill(&self, buffer: &dyn AnyBuffer, value: u32) -> GpuResult<()> {
        let core = buffer.core();
        core.assert_of(self);
        core.assert_not_being_recorded();
        core.assert_not_read_by_host("fill");
        if core.size_in_bytes() == 0 {
            return Ok(());
        }
        let mut staging = self.staging.lock().unwrap_or_else(|e| e.into_inner());
        // SAFETY: the buffer is alive; its size is a multiple of 4.
        staging.run(self, |cmd| unsafe {
            core.extent().fill(&self.device.raw, cmd, value);
        })?;
        core.forget_history();
        Ok(())
    }
}

/// The buffer in `slot`, made if there is none yet.
fn mapped_buffer<'a>(
    ctx: &Context,
    slot: &'a mut Option<(vk::Buffer, Allocation)>,
    name: &str,
    location: MemoryLocation,
) -> GpuResult<(vk::Buffer, &'a mut Allocation)> {
    if slot.is_none() {
        let usage = vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
        let made = allocate(ctx, name, CHUNK, usage, location)?;
        ctx.device.set_name(made.0, name);
        *slot = Some(made);
    }
    let (buffer, allocation) = slot.as_mut().expect("made above");
    Ok((*buffer, allocation))
}
