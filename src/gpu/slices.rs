//! A recording in slices: what takes the device long is handed to it kernel by kernel, and other frames come in between.
//! Kernels that take long themselves are divided.

use std::collections::{HashMap, VecDeque};
use std::sync::atomic::Ordering;
use std::sync::{Arc, PoisonError};
use std::time::Duration;

use ash::vk;

use super::context::Context;
use super::crumbs::blame;
use super::error::{Check, GpuError, GpuResult};
use super::frame::{FrameResources, Frames};
use super::info::DeviceKind;
use super::recorder::Recorder;
use super::timer::{SpanKind, Timings};
use super::transfer::wait_for;

const WHO: &str = "a slice of a frame";

/// So many frames tell how long kernels take.
const LATELY: usize = 8;

/// What a recording has in slices.
#[derive(Default)]
pub(crate) struct Slices {
    /// Every kernel ends one.
    is_on: bool,
    /// Of kernels that take long, how many slices each is.
    parts: HashMap<String, u32>,
    /// How many have ended.
    count: usize,
    /// Those that the device has not been given yet.
    pub(crate) waiting: VecDeque<vk::CommandBuffer>,
    /// Where one ends and the next begins: of two queries the first. What lies between them is not the recording's time.
    pub(crate) gaps: Vec<u32>,
    /// The device was given one and is not known to have finished it.
    pub(crate) is_running: bool,
    /// Why the recording cannot be submitted.
    failed: Option<GpuError>,
}

impl Recorder {
    /// From now on every kernel ends a slice. [`Frames::run_slice`] hands slices to the device one by one, and
    /// [`Frames::submit`] takes whatever is left. What is submitted in between must not touch what this recording uses, and
    /// has to come from another ring.
    ///
    /// A dispatch of a kernel that has lately taken longer than `longest` is as many slices as that asks for, on devices
    /// that are processors. [`Recorder::dispatch_indirect`] stays whole.
    pub fn slice(&mut self, longest: Duration, lately: &Timings) {
        self.slices.is_on = true;
        if !divides(self.ctx()) {
            return;
        }
        let longest_ms = longest.as_secs_f64().max(1e-4) * 1e3;
        for spans in lately.frames().rev().take(LATELY) {
            for span in spans.iter().filter(|s| s.kind == SpanKind::Kernel) {
                let parts = (span.ms() / longest_ms).ceil() as u32;
                if parts > 1 {
                    let most = self.slices.parts.entry(span.name.clone()).or_default();
                    *most = parts.max(*most);
                }
            }
        }
    }

    /// Is a dispatch of a kernel divided?
    pub(crate) fn takes_long(&self, kernel: &str) -> bool {
        self.slices.is_on && self.slices.parts.contains_key(kernel)
    }

    /// The parts of a dispatch with these groups: the first group of each, and how many.
    pub(crate) fn parts_of(
        &self,
        kernel: &str,
        groups: [u32; 2],
    ) -> impl Iterator<Item = [[u32; 2]; 2]> + use<> {
        let parts = match self.slices.parts.get(kernel) {
            Some(&parts) if self.slices.is_on => parts,
            _ => 1,
        };
        parts_of(groups, parts)
    }

    /// Dispatches a part of the groups of what is bound.
    pub(crate) fn dispatch_part(&self, [first, count]: [[u32; 2]; 2]) {
        // SAFETY: pipeline, descriptors and constants were bound for this layout, and where there is more than one part,
        // the pipeline was made for it.
        unsafe {
            match first {
                [0, 0] => (self.device()).cmd_dispatch(self.raw(), count[0], count[1], 1),
                [x, y] => {
                    let [width, height] = count;
                    (self.device()).cmd_dispatch_base(self.raw(), x, y, 0, width, height, 1);
                }
            }
        }
    }

    /// Can the device be given the rest? Where a slice was not finished in time, this waits for it once more.
    pub(crate) fn settle_slices(&mut self) -> GpuResult<()> {
        if self.slices.is_running {
            wait_for(self.ctx(), self.frame.fence, WHO)?;
            self.slices.is_running = false;
        }
        self.slices.failed.take().map_or(Ok(()), Err)
    }

    /// Ends a slice, if the recording has them.
    pub(crate) fn end_slice(&mut self) {
        if !self.slices.is_on {
            return;
        }
        let next = match self.frame.slice(self.slices.count) {
            Ok(next) => next,
            Err(error) => {
                // It goes on in the present one.
                self.slices.is_on = false;
                self.slices.failed = Some(error);
                return;
            }
        };
        let gap = self.take_queries();
        if let Some(query) = gap {
            self.stamp(query);
        }
        // Labels are closed in the command buffer that opened them.
        let names: Vec<String> = self.open_names().map(str::to_owned).collect();
        for _ in &names {
            self.ctx().device.end_label(self.raw());
        }
        // SAFETY: it is being recorded, and no pass is open where a kernel has been dispatched.
        let ended = unsafe { self.device().end_command_buffer(self.raw()) };
        if let Err(error) = ended.check("vkEndCommandBuffer", WHO) {
            self.slices.failed = Some(error);
        }
        self.slices.waiting.push_back(self.cmd);
        self.slices.count += 1;
        self.cmd = next;
        for name in &names {
            self.ctx().device.begin_label(next, name);
        }
        if let Some(query) = gap {
            self.stamp(query + 1);
            self.slices.gaps.push(query);
        }
    }
}

/// Are pipelines of this device made for parts of a dispatch? Where slices are short anyway, they need not be.
pub(crate) fn divides(ctx: &Context) -> bool {
    ctx.info().kind == DeviceKind::Cpu
}

/// Parts of about the same size, whole rows where there are several: kernels count their invocations by the width.
fn parts_of([width, rows]: [u32; 2], parts: u32) -> impl Iterator<Item = [[u32; 2]; 2]> {
    let whole = if rows > 1 { rows } else { width };
    let parts = parts.clamp(1, whole.max(1));
    let cut = move |part: u32| (u64::from(whole) * u64::from(part) / u64::from(parts)) as u32;
    (0..parts).map(move |part| {
        let (first, count) = (cut(part), cut(part + 1) - cut(part));
        if rows > 1 {
            [[0, first], [width, count]]
        } else {
            [[first, 0], [count, rows]]
        }
    })
}

/// Takes what came in the gaps out of times: of each gap its two queries. A time is as much earlier as gaps have ended before.
pub(crate) fn without_gaps(ticks: &mut [u64], gaps: &[u32], mask: u64) {
    let Some(&start) = ticks.first() else {
        return;
    };
    // Counters wrap: count from the frame's own start.
    let since_start = |tick: u64| tick.wrapping_sub(start) & mask;
    // Slices follow each other, so gaps do.
    let mut ends = Vec::with_capacity(gaps.len());
    let mut sum = 0;
    for &gap in gaps {
        let [from, to] = [gap, gap + 1].map(|query| since_start(ticks[query as usize]));
        sum += to.saturating_sub(from);
        ends.push((to, sum));
    }
    for tick in ticks {
        let time = since_start(*tick);
        let before = ends.partition_point(|&(end, _)| end <= time);
        let sum = before.checked_sub(1).map_or(0, |last| ends[last].1);
        *tick = tick.wrapping_sub(sum);
    }
}

impl FrameResources {
    /// The command buffer of a slice, in which recording begins.
    fn slice(&self, index: usize) -> GpuResult<vk::CommandBuffer> {
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
    ///
    /// # Panics
    /// If the recorder is not of this ring.
    pub fn run_slice(&self, recorder: &mut Recorder) -> GpuResult<bool> {
        assert!(
            self.has_begun(recorder),
            "a slice is run by the ring that began its frame"
        );
        run_next(recorder).map_err(|error| match recorder.frame.works_begun() {
            0 => error,
            count => blame(error, count, &recorder.works),
        })
    }
}

/// Submits the next slice, if there is one, and waits for it.
fn run_next(recorder: &mut Recorder) -> GpuResult<bool> {
    recorder.settle_slices()?;
    let Some(cmd) = recorder.slices.waiting.pop_front() else {
        return Ok(false);
    };
    let ctx = Arc::clone(recorder.ctx());
    let fence = recorder.frame.fence;
    let cmds = [cmd];
    let info = [vk::SubmitInfo::default().command_buffers(&cmds)];
    // SAFETY: the fence belongs to a frame of which nothing runs.
    unsafe { ctx.device.raw.reset_fences(&[fence]) }.check("vkResetFences", WHO)?;
    // SAFETY: what was recorded lives until the frame is over.
    let submit = || unsafe { ctx.device.raw.queue_submit(*ctx.queue(), &info, fence) };
    let submitted = ctx.heard(ctx.is_there().and_then(|()| submit()));
    ctx.submits.fetch_add(1, Ordering::Relaxed);
    submitted.check("vkQueueSubmit", WHO)?;
    recorder.slices.is_running = true;
    wait_for(&ctx, fence, WHO)?;
    recorder.slices.is_running = false;
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::{parts_of, without_gaps};

    #[test]
    fn parts_are_all_of_a_dispatch_once() {
        for (groups, wanted) in [
            ([1, 1], 3),
            ([5, 1], 1),
            ([5, 1], 3),
            ([65_535, 1], 7),
            ([40_000, 3], 2),
            ([40_000, 3], 9),
        ] {
            let parts: Vec<_> = parts_of(groups, wanted).collect();
            let most = if groups[1] > 1 { groups[1] } else { groups[0] };
            assert_eq!(parts.len() as u32, wanted.min(most));
            let mut next = 0;
            for [[x, y], [width, height]] in &parts {
                assert!(*width > 0 && *height > 0);
                // As kernels count groups, in whole rows of a dispatch whose width they know.
                assert!(*y == 0 || *width == groups[0]);
                assert_eq!(y * width + x, next);
                next += width * height;
            }
            assert_eq!(next, groups[0] * groups[1]);
        }
    }

    #[test]
    fn what_came_between_slices_is_nobodys_time() {
        // Queries of a frame 0 and 1, a step 2 and 3, then kernels of 10 ticks each with gaps of 100 and 1000 after them.
        // The counter has eight bits more than it keeps, and wraps on the way.
        let mask = 0xfff;
        let times = [
            0, 1150, 2, 1148, 5, 15, 17, 117, 119, 129, 131, 1131, 1134, 1144,
        ];
        let mut ticks: Vec<u64> = times.map(|time: u64| (time + 3500) & mask).into();
        without_gaps(&mut ticks, &[6, 10], mask);
        let left: Vec<u64> = ticks.iter().map(|t| t.wrapping_sub(3500) & mask).collect();
        assert_eq!(left, [0, 50, 2, 48, 5, 15, 17, 17, 19, 29, 31, 31, 34, 44]);
        let mut none: [u64; 0] = [];
        without_gaps(&mut none, &[], mask);
        let mut without = [7, 9];
        without_gaps(&mut without, &[], mask);
        assert_eq!(without, [7, 9]);
    }
}
