//! A recording in slices: a recording that takes the device long is submitted kernel by kernel, so that other frames can run between. Slow
//! kernels are divided.

use std::time::Duration;

use super::error::{Check, GpuResult};
use super::kernel::divides;
use super::recorder::Recorder;
use super::slices::parts_of;
use super::timer::{SpanKind, Timings};

const WHAT: &str = "a slice of a frame";

/// Kernel times are estimated from so many frames.
const RECENT: usize = 8;

impl Recorder {
    /// From now on every kernel ends a slice, and so does every picture or band of one. [`Frames::run_slice`](super::Frames::run_slice)
    /// submits slices one by one, and [`Frames::submit`](super::Frames::submit) submits the rest. Frames submitted in between must not use
    /// the buffers of this recording, and must come from another ring.
    ///
    /// On devices that are processors, a dispatch of a kernel that has recently taken longer than `longest` is divided into slices of about
    /// that time. [`Recorder::dispatch_indirect`] stays whole.
    pub fn slice(&mut self, longest: Duration, recent: &Timings) {
        self.slices.is_on = true;
        if !divides(self.ctx()) {
            return;
        }
        let longest_ms = longest.as_secs_f64().max(1e-4) * 1e3;
        for spans in recent.frames().rev().take(RECENT) {
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

    /// Dispatches a part of the groups of the bound kernel.
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

    /// Checks that the rest can be submitted. If a slice was not finished in time, waits for it once more.
    pub(crate) fn settle_slices(&mut self) -> GpuResult<()> {
        if self.slices.is_running {
            self.ctx().wait_for(self.frame.fence, WHAT)?;
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
                // The recording continues in the present command buffer.
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
        if let Err(error) = ended.check("vkEndCommandBuffer", WHAT) {
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
