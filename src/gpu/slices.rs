//! A recording in slices: what takes the device long is handed to it kernel by kernel, and other frames come in between.

use std::collections::VecDeque;
use std::sync::PoisonError;
use std::sync::atomic::Ordering;

use ash::vk;

use super::crumbs::blame;
use super::error::{Check, GpuError, GpuResult};
use super::frame::{FrameResources, Frames};
use super::recorder::Recorder;
use super::transfer::wait_for;

/// What a recording has in slices.
#[derive(Default)]
pub(crate) struct Slices {
    /// Every kernel ends one.
    is_on: bool,
    /// How many there have been.
    count: usize,
    /// Those that the device has not been given yet.
    pub(crate) waiting: VecDeque<vk::CommandBuffer>,
    /// Where one ends and the next begins: of two queries the first. What lies between them is not the recording's time.
    pub(crate) gaps: Vec<u32>,
    /// Why there could be no more of them.
    failed: Option<GpuError>,
}

impl Slices {
    pub(crate) fn check(&mut self) -> GpuResult<()> {
        self.failed.take().map_or(Ok(()), Err)
    }
}

impl Recorder {
    /// From now on every kernel ends a slice. [`Frames::run_slice`] hands slices to the device one by one, and
    /// [`Frames::submit`] takes whatever is left. What is submitted in between must not touch what this recording uses, and
    /// has to come from another ring.
    pub fn slice(&mut self) {
        self.slices.is_on = true;
    }

    /// Ends a slice, if the recording has them.
    pub(crate) fn end_slice(&mut self) {
        if !self.slices.is_on {
            return;
        }
        let next = self.frame.slice(self.slices.count);
        let ended = next.and_then(|next| {
            // Labels are closed in the command buffer that opened them.
            let names: Vec<String> = self.open_names().map(str::to_owned).collect();
            for _ in &names {
                self.ctx().device.end_label(self.raw());
            }
            let gap = self.take_queries();
            if let Some(query) = gap {
                self.stamp(query);
                self.slices.gaps.push(query);
            }
            // SAFETY: it is being recorded, and no pass is open where a kernel has been dispatched.
            unsafe { self.device().end_command_buffer(self.raw()) }
                .check("vkEndCommandBuffer", "a slice of a frame")?;
            for name in &names {
                self.ctx().device.begin_label(next, name);
            }
            Ok((next, gap))
        });
        match ended {
            Ok((next, gap)) => {
                let ended = std::mem::replace(&mut self.cmd, next);
                self.slices.waiting.push_back(ended);
                self.slices.count += 1;
                if let Some(query) = gap {
                    self.stamp(query + 1);
                }
            }
            Err(error) => {
                self.slices.is_on = false;
                self.slices.failed = Some(error);
            }
        }
    }
}

impl FrameResources {
    /// The command buffer of a slice, in which recording begins.
    fn slice(&self, index: usize) -> GpuResult<vk::CommandBuffer> {
        const WHO: &str = "a slice of a frame";
        let mut cmds = self.slices.lock().unwrap_or_else(PoisonError::into_inner);
        let device = &self.ctx.device.raw;
        if index == cmds.len() {
            let info = vk::CommandBufferAllocateInfo::default()
                .command_pool(self.pool)
                .command_buffer_count(1);
            // SAFETY: the pool is this frame's, which one recorder has.
            let made = unsafe { device.allocate_command_buffers(&info) };
            let made = made.check("vkAllocateCommandBuffers", WHO)?[0];
            self.ctx.device.set_name(made, "slice");
            cmds.push(made);
        }
        let begin = vk::CommandBufferBeginInfo::default()
            .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the pool was reset when the frame began, and each index is asked for once.
        unsafe { device.begin_command_buffer(cmds[index], &begin) }
            .check("vkBeginCommandBuffer", WHO)?;
        Ok(cmds[index])
    }
}

impl Frames {
    /// Hands the next slice of a recording to the device, and waits for it. False where only what [`Frames::submit`]
    /// takes is left.
    ///
    /// # Errors
    /// The device was lost, did not finish in time, or is out of memory.
    pub fn run_slice(&self, recorder: &mut Recorder) -> GpuResult<bool> {
        const WHO: &str = "a slice of a frame";
        recorder.slices.check()?;
        let Some(cmd) = recorder.slices.waiting.pop_front() else {
            return Ok(false);
        };
        let ctx = recorder.ctx();
        let fence = recorder.frame.fence;
        let run = || {
            let cmds = [cmd];
            let info = [vk::SubmitInfo::default().command_buffers(&cmds)];
            // SAFETY: the fence belongs to a frame that is not submitted; what was recorded lives until the frame is over.
            let reset = unsafe { ctx.device.raw.reset_fences(&[fence]) };
            reset.check("vkResetFences", WHO)?;
            // SAFETY: as above.
            let submit = || unsafe { ctx.device.raw.queue_submit(*ctx.queue(), &info, fence) };
            let submitted = ctx.is_there().and_then(|()| submit());
            ctx.submits.fetch_add(1, Ordering::Relaxed);
            submitted.check("vkQueueSubmit", WHO)?;
            wait_for(ctx, fence, WHO)
        };
        run().map_err(|error| match recorder.frame.works_begun() {
            0 => error,
            count => blame(error, count, &recorder.works),
        })?;
        Ok(true)
    }
}
