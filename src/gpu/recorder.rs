//! A frame that is being recorded: its command buffer, scopes and their times, and marks for hangs and debug values.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use ash::vk;

use super::access::{Recording, Unordered, full_barrier};
use super::context::Context;
use super::fate::Fate;
use super::frame_resources::FrameResources;
use super::image::Transition;
use super::listing::Listed;
use super::part::Part;
use super::slices::Slices;
use super::timer::SpanKind;

/// A frame that is being recorded; [`Frames::begin`](super::Frames::begin) makes one and
/// [`Frames::submit`](super::Frames::submit) takes it.
pub struct Recorder {
    pub(crate) frame: Arc<FrameResources>,
    /// The command buffer that is being recorded.
    pub(crate) cmd: vk::CommandBuffer,
    pub(crate) slices: Slices,
    pub(crate) ticket: u64,
    pub(crate) spans: Vec<PendingSpan>,
    /// Indices of the scopes that are open.
    open: Vec<usize>,
    queries_used: u32,
    /// More than fit if it exceeds the pool; the next frame gets a larger one.
    pub(crate) queries_wanted: u32,
    pub(crate) submitted: bool,
    pub(crate) fate: Fate,
    /// Of images, in order.
    pub(crate) transitions: Vec<Transition>,
    /// Names of the works that have a breadcrumb, in order.
    pub(crate) works: Vec<String>,
    /// Kernels that may have called `debug_value`, in order.
    pub(crate) debug_kernels: Vec<String>,
    /// The part of the work that is really recorded.
    pub(crate) part: Part,
    pub(crate) commands: Commands,
    /// The list of everything recorded so far, if requested.
    pub(crate) list: Option<Vec<Listed>>,
    pub(crate) is_in_pass: bool,
    /// Something was written that the host reads.
    pub(crate) host_reads: bool,
    /// Must every kernel wait for the one before?
    pub(crate) separates: bool,
    /// Something has been recorded that a work can be separated from.
    pub(crate) has_work: bool,
    pub(crate) recording: Recording,
    /// The group that is being recorded.
    pub(crate) unordered: Option<Unordered>,
}

/// Counts of a frame's recorded commands, with which the host's work grows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Commands {
    /// Dispatches.
    pub kernels: u32,
    /// Draws that are timed one by one.
    pub draws: u32,
    /// Copies, fills and updates.
    pub copies: u32,
    /// Barriers.
    pub barriers: u32,
}

/// A span whose times are not known yet.
pub(crate) struct PendingSpan {
    pub(crate) name: String,
    pub(crate) kind: SpanKind,
    pub(crate) parent: Option<usize>,
    /// First of its two queries, where there was room.
    pub(crate) queries: Option<u32>,
}

impl Recorder {
    pub(crate) fn new(frame: Arc<FrameResources>) -> Self {
        let ticket = frame.ctx.deletion_queue.begin();
        let ctx = Arc::clone(&frame.ctx);
        let mut recorder = Self {
            cmd: frame.cmd,
            slices: Slices::default(),
            frame,
            ticket,
            spans: Vec::new(),
            open: Vec::new(),
            queries_used: 0,
            queries_wanted: 0,
            submitted: false,
            fate: Fate::default(),
            transitions: Vec::new(),
            works: Vec::new(),
            debug_kernels: Vec::new(),
            part: Part::Whole,
            commands: Commands::default(),
            list: None,
            is_in_pass: false,
            host_reads: false,
            separates: false,
            has_work: false,
            recording: ctx.recordings().begin(),
            unordered: None,
        };
        recorder.begin_span("frame", SpanKind::Frame);
        recorder
    }

    /// The context that the frame is for.
    #[must_use]
    pub fn ctx(&self) -> &Arc<Context> {
        &self.frame.ctx
    }

    /// The commands recorded so far.
    #[must_use]
    pub fn commands(&self) -> Commands {
        self.commands
    }

    /// The raw command buffer, for crates that draw by themselves.
    #[must_use]
    pub fn raw(&self) -> vk::CommandBuffer {
        self.cmd
    }

    /// Groups what `record` records under a name, in reports and in capture tools.
    pub fn scope<R>(&mut self, name: &str, record: impl FnOnce(&mut Self) -> R) -> R {
        self.begin_span(name, SpanKind::Scope);
        let result = record(self);
        self.end_span();
        result
    }

    pub(crate) fn leave_crumb(&mut self, name: &str) {
        if let Some(breadcrumbs) = &self.frame.breadcrumbs {
            breadcrumbs
                .lock()
                .unwrap_or_else(|e| e.into_inner())
                .leave(self.raw(), self.works.len() as u32);
            self.works.push(name.to_owned());
        }
    }

    /// Records in the debug list which kernel calls `debug_value` from now on.
    pub(crate) fn announce_debug(&mut self, name: &str) {
        let frame = Arc::clone(&self.frame);
        let list = frame.debug_list();
        let number = self.debug_kernels.len() as u32;
        self.debug_kernels.push(name.to_owned());
        let whole_head = [0, list.capacity, number, 0];
        // The count is only reset by the frame's first.
        let (offset, words) = if number == 0 {
            (0, &whole_head[..])
        } else {
            (8, &whole_head[2..3])
        };
        self.full_barrier(vk::PipelineStageFlags::ALL_COMMANDS);
        // SAFETY: the list is alive as long as the frame; the head lies in it.
        unsafe {
            let bytes = bytemuck::cast_slice(words);
            self.device()
                .cmd_update_buffer(self.raw(), list.buffer().core().raw(), offset, bytes);
        }
        self.full_barrier(vk::PipelineStageFlags::ALL_COMMANDS);
    }

    pub(crate) fn full_barrier(&self, to: vk::PipelineStageFlags) {
        // SAFETY: the command buffer is being recorded; in a pass there are no full barriers.
        unsafe { full_barrier(self.device(), self.raw(), to) };
    }

    pub(crate) fn begin_span(&mut self, name: &str, kind: SpanKind) {
        let queries = self.take_queries();
        if let Some(first) = queries {
            self.stamp(first);
        }
        self.ctx().device.begin_label(self.raw(), name);
        let parent = self.open.last().copied();
        self.open.push(self.spans.len());
        self.spans.push(PendingSpan {
            name: name.to_owned(),
            kind,
            parent,
            queries,
        });
    }

    /// The first of two queries, if there is room.
    pub(crate) fn take_queries(&mut self) -> Option<u32> {
        let first = self.queries_used;
        self.queries_wanted += 2;
        let fits = first + 2 <= self.frame.query_capacity;
        self.queries_used += if fits { 2 } else { 0 };
        fits.then_some(first)
    }

    pub(crate) fn end_span(&mut self) {
        let span = self.open.pop().expect("each span is closed once");
        self.ctx().device.end_label(self.raw());
        if let Some(first) = self.spans[span].queries {
            self.stamp(first + 1);
        }
    }

    /// Writes a timestamp when everything before it has finished.
    pub(crate) fn stamp(&self, query: u32) {
        // SAFETY: the query lies in the pool, was reset at the start of the frame and is written once.
        unsafe {
            self.device().cmd_write_timestamp(
                self.raw(),
                vk::PipelineStageFlags::BOTTOM_OF_PIPE,
                self.frame.queries,
                query,
            );
        }
    }

    /// The names of the scopes that are open.
    pub(crate) fn open_names(&self) -> impl Iterator<Item = &str> {
        self.open.iter().map(|&span| self.spans[span].name.as_str())
    }

    pub(crate) fn queries_used(&self) -> u32 {
        self.queries_used
    }

    pub(crate) fn device(&self) -> &ash::Device {
        &self.frame.ctx.device.raw
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        if self.submitted {
            return;
        }
        self.fate.drop_it();
        self.frame.ctx.recordings().dropped();
        // What was recorded into slices that were submitted happens.
        let run = self.slices.count - self.slices.waiting.len();
        let never = (self.transitions.iter()).filter(|transition| transition.slice >= run);
        never.rev().for_each(Transition::take_back);
        let deletion_queue = &self.frame.ctx.deletion_queue;
        if self.slices.is_running {
            self.frame.is_abandoned.store(true, Ordering::Relaxed);
            deletion_queue.submitted(self.ticket);
            deletion_queue.watch(self.ticket, self.frame.fence);
        } else {
            deletion_queue.end(self.ticket);
        }
    }
}
