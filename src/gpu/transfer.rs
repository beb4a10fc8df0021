//! Blocking transfers: upload, download and fill, through staging memory and chunk by chunk.

use std::sync::atomic::Ordering;

use ash::vk;
use bytemuck::Pod;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocation;

use super::buffer::{AnyBuffer, Buffer};
use super::buffer_core::allocate;
use super::context::Context;
use super::error::{Check, GpuError, GpuResult, advice};
use super::graveyard::Corpse;

/// Bytes that one chunk moves.
const CHUNK: u64 = 8 << 20;

/// What blocking transfers use; made on first use.
#[derive(Default)]
pub(crate) struct Transfer {
    pool: vk::CommandPool,
    /// Allocated once: synchronization validation (1.3.239) keeps what it knows of every command buffer that was freed, about 3 kB.
    cmd: vk::CommandBuffer,
    fence: vk::Fence,
    upload: Option<(vk::Buffer, Allocation)>,
    download: Option<(vk::Buffer, Allocation)>,
}

impl Transfer {
    pub(crate) fn destroy(self, ctx: &Context) {
        let device = &ctx.device.raw;
        // SAFETY: the device is idle and nobody else has these; null handles are allowed.
        unsafe {
            device.destroy_command_pool(self.pool, None);
            device.destroy_fence(self.fence, None);
            for (buffer, allocation) in self.upload.into_iter().chain(self.download) {
                device.destroy_buffer(buffer, None);
                ctx.free(allocation);
            }
        }
    }

    /// A transfer that still runs keeps what it uses; the next one makes everything anew.
    fn abandon(&mut self, ctx: &Context) {
        let left = std::mem::take(self);
        let ticket = ctx.graveyard.begin();
        ctx.graveyard.submitted(ticket);
        ctx.graveyard.adopt(ticket, left.fence);
        let queries = vk::QueryPool::null();
        ctx.graveyard.add(Corpse::Frame {
            pool: left.pool,
            queries,
            fence: left.fence,
        });
        for (buffer, allocation) in left.upload.into_iter().chain(left.download) {
            ctx.graveyard.add(Corpse::Buffer(buffer, allocation));
        }
    }

    /// Records, submits and waits.
    fn run(&mut self, ctx: &Context, record: impl FnOnce(vk::CommandBuffer)) -> GpuResult<()> {
        const WHO: &str = "a transfer";
        let device = &ctx.device.raw;
        // SAFETY: for all calls, the handles are this device's, and nothing of them is in use between two runs.
        unsafe {
            if self.pool == vk::CommandPool::null() {
                let info =
                    vk::CommandPoolCreateInfo::default().queue_family_index(ctx.queue_family());
                self.pool = device
                    .create_command_pool(&info, None)
                    .check("vkCreateCommandPool", WHO)?;
            }
            if self.cmd == vk::CommandBuffer::null() {
                let info = vk::CommandBufferAllocateInfo::default()
                    .command_pool(self.pool)
                    .command_buffer_count(1);
                self.cmd = device
                    .allocate_command_buffers(&info)
                    .check("vkAllocateCommandBuffers", WHO)?[0];
            }
            if self.fence == vk::Fence::null() {
                self.fence = device
                    .create_fence(&vk::FenceCreateInfo::default(), None)
                    .check("vkCreateFence", WHO)?;
            }
            device
                .reset_command_pool(self.pool, vk::CommandPoolResetFlags::RELEASE_RESOURCES)
                .check("vkResetCommandPool", WHO)?;
            device
                .reset_fences(&[self.fence])
                .check("vkResetFences", WHO)?;
            let cmds = [self.cmd];
            let begin = vk::CommandBufferBeginInfo::default()
                .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
            let recorded = device
                .begin_command_buffer(cmds[0], &begin)
                .check("vkBeginCommandBuffer", WHO)
                .and_then(|()| {
                    full_barrier(
                        device,
                        cmds[0],
                        vk::PipelineStageFlags::empty(),
                        vk::AccessFlags::empty(),
                    );
                    record(cmds[0]);
                    full_barrier(
                        device,
                        cmds[0],
                        vk::PipelineStageFlags::HOST,
                        vk::AccessFlags::HOST_READ,
                    );
                    device
                        .end_command_buffer(cmds[0])
                        .check("vkEndCommandBuffer", WHO)
                });
            let finished = recorded.and_then(|()| {
                let submits = [vk::SubmitInfo::default().command_buffers(&cmds)];
                ctx.submits.fetch_add(1, Ordering::Relaxed);
                device
                    .queue_submit(*ctx.queue(), &submits, self.fence)
                    .check("vkQueueSubmit", WHO)?;
                wait_for(ctx, self.fence, WHO)
            });
            if matches!(finished, Err(GpuError::Timeout { .. })) {
                self.abandon(ctx);
            }
            finished
        }
    }
}

/// Waits for a fence, for as long as the context allows.
pub(crate) fn wait_for(ctx: &Context, fence: vk::Fence, who: &str) -> GpuResult<()> {
    let timeout = ctx.timeout();
    let nanoseconds = u64::try_from(timeout.as_nanos()).unwrap_or(u64::MAX);
    // SAFETY: the fence is this device's.
    let waited = unsafe { ctx.device.raw.wait_for_fences(&[fence], true, nanoseconds) };
    match ctx.heard(ctx.is_there().and(waited)) {
        Err(vk::Result::TIMEOUT) => Err(GpuError::Timeout {
            seconds: timeout.as_secs(),
            last: format!("it was busy with {who}"),
            advice: advice(""),
        }),
        other => other.check("vkWaitForFences", who),
    }
}

fn full_barrier(
    device: &ash::Device,
    cmd: vk::CommandBuffer,
    more: vk::PipelineStageFlags,
    access: vk::AccessFlags,
) {
    let all = vk::PipelineStageFlags::ALL_COMMANDS;
    let barrier = vk::MemoryBarrier::default()
        .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
        .dst_access_mask(vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE | access);
    // SAFETY: `cmd` is being recorded.
    unsafe {
        device.cmd_pipeline_barrier(
            cmd,
            all,
            all | more,
            vk::DependencyFlags::empty(),
            &[barrier],
            &[],
            &[],
        )
    };
}

impl Context {
    /// Writes `data` to the start of `buffer`, and waits. Work submitted before and after is ordered round it.
    ///
    /// # Errors
    /// No memory, a device that was lost or does not answer.
    ///
    /// # Panics
    /// If `data` is longer than the buffer, or a frame that uses it is still being recorded.
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
        let fits = start
            .checked_add(data.len())
            .is_some_and(|end| end <= buffer.len());
        assert!(
            fits,
            "`{}` has {} elements: {} from {start} on do not fit",
            buffer.name(),
            buffer.len(),
            data.len()
        );
        let core = buffer.core();
        core.assert_not_being_recorded();
        core.assert_not_read_by_host("upload");
        let mut transfer = self.transfer.lock().unwrap_or_else(|e| e.into_inner());
        let mut target = (start * size_of::<T>()) as u64;
        for chunk in bytemuck::cast_slice::<T, u8>(data).chunks(CHUNK as usize) {
            let (staging, allocation) = staging(
                self,
                &mut transfer.upload,
                "transfer.upload",
                MemoryLocation::CpuToGpu,
            )?;
            let mapped = allocation
                .mapped_slice_mut()
                .expect("staging memory is mapped");
            mapped[..chunk.len()].copy_from_slice(chunk);
            let copy = vk::BufferCopy::default()
                .dst_offset(target)
                .size(chunk.len() as u64);
            transfer.run(self, |cmd| {
                // SAFETY: both buffers are alive and `copy` lies in both.
                unsafe {
                    self.device
                        .raw
                        .cmd_copy_buffer(cmd, staging, core.raw(), &[copy])
                };
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
    /// If a frame that uses the buffer is still being recorded.
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
        let fits = range.start <= range.end && range.end <= buffer.len();
        assert!(
            fits,
            "`{}` has {} elements, not {range:?}",
            buffer.name(),
            buffer.len()
        );
        let core = buffer.core();
        core.assert_not_being_recorded();
        let mut transfer = self.transfer.lock().unwrap_or_else(|e| e.into_inner());
        let mut data = vec![T::zeroed(); range.len()];
        let mut source = (range.start * size_of::<T>()) as u64;
        for chunk in bytemuck::cast_slice_mut::<T, u8>(&mut data).chunks_mut(CHUNK as usize) {
            let (staging, _) = staging(
                self,
                &mut transfer.download,
                "transfer.download",
                MemoryLocation::GpuToCpu,
            )?;
            let copy = vk::BufferCopy::default()
                .src_offset(source)
                .size(chunk.len() as u64);
            transfer.run(self, |cmd| {
                // SAFETY: both buffers are alive and `copy` lies in both.
                unsafe {
                    self.device
                        .raw
                        .cmd_copy_buffer(cmd, core.raw(), staging, &[copy])
                };
            })?;
            let mapped = transfer
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
    /// If a frame that uses the buffer is still being recorded.
    pub fn fill(&self, buffer: &dyn AnyBuffer, value: u32) -> GpuResult<()> {
        let core = buffer.core();
        core.assert_not_being_recorded();
        core.assert_not_read_by_host("fill");
        if core.size_in_bytes() == 0 {
            return Ok(());
        }
        let mut transfer = self.transfer.lock().unwrap_or_else(|e| e.into_inner());
        transfer.run(self, |cmd| {
            // SAFETY: the buffer is alive; its size is a multiple of 4.
            unsafe {
                self.device
                    .raw
                    .cmd_fill_buffer(cmd, core.raw(), 0, core.size_in_bytes(), value)
            };
        })?;
        core.forget_history();
        Ok(())
    }
}

fn staging<'a>(
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
