//! Frames in flight: the host records one while the device works on those before.

use std::sync::atomic::Ordering;
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

use ash::vk;

use super::breadcrumbs::blame;
use super::context::Context;
use super::error::{Check, GpuError, GpuResult};
use super::frame_resources::FrameResources;
use super::info::DeviceKind;
use super::recorder::{PendingSpan, Recorder};
use super::slices::without_gaps;
use super::timer::{Span, Timings};

/// Queries of a frame at first; a frame that needs more gets them the next time.
pub(crate) const FIRST_QUERIES: u32 = 4096;

/// A ring of frames, each recorded, submitted and, when its turn comes again, waited for.
pub struct Frames {
    ctx: Arc<Context>,
    slots: Vec<Slot>,
    next: usize,
    timings: Timings,
    /// Time that the latest frame waited for the device.
    waited: Duration,
}

struct Slot {
    resources: Arc<FrameResources>,
    pending: Option<Pending>,
    /// Number of queries that the last frame wanted.
    wanted: u32,
    /// Number of queries, from the first on, that may be written since their last reset, or were never reset.
    unset: u32,
}

/// A submitted frame.
struct Pending {
    ticket: u64,
    spans: Vec<PendingSpan>,
    queries: u32,
    gaps: Vec<u32>,
    works: Vec<String>,
    debug_kernels: Vec<String>,
}

impl Frames {
    /// A ring of `in_flight` frames, at least one.
    ///
    /// # Errors
    /// No memory.
    pub fn new(ctx: &Arc<Context>, in_flight: usize) -> GpuResult<Self> {
        let slots = (0..in_flight.max(1))
            .map(|_| {
                let resources = Arc::new(FrameResources::new(ctx, FIRST_QUERIES)?);
                Ok(Slot {
                    resources,
                    pending: None,
                    wanted: 0,
                    unset: u32::MAX,
                })
            })
            .collect::<GpuResult<Vec<_>>>()?;
        Ok(Self {
            ctx: Arc::clone(ctx),
            slots,
            next: 0,
            timings: Timings::default(),
            waited: Duration::ZERO,
        })
    }

    /// Begins a frame; waits for the one that used the same place in the ring.
    ///
    /// # Errors
    /// The device was lost, or did not finish in time.
    ///
    /// # Panics
    /// If a frame that was begun in this place was neither submitted nor dropped.
    pub fn begin(&mut self) -> GpuResult<Recorder> {
        self.waited = Duration::ZERO;
        self.wait_slot(self.next)?;
        let slot = &mut self.slots[self.next];
        assert!(
            Arc::strong_count(&slot.resources) == 1,
            "submit or drop a frame before its place in the ring is used again"
        );
        let wants_more =
            slot.wanted > slot.resources.query_capacity && self.ctx.info().has_timestamps();
        if wants_more || slot.resources.is_abandoned.load(Ordering::Relaxed) {
            let queries = slot.wanted.next_power_of_two().max(FIRST_QUERIES);
            slot.resources = Arc::new(FrameResources::new(&self.ctx, queries)?);
            slot.unset = u32::MAX;
        }
        self.ctx.collect_garbage();
        slot.resources.start(slot.unset)?;
        // This holds until the frame is submitted: a dropped frame resets nothing, and parts of it may have run.
        slot.unset = u32::MAX;
        let recorder = Recorder::new(Arc::clone(&slot.resources));
        self.next = (self.next + 1) % self.slots.len();
        Ok(recorder)
    }

    /// Submits a frame to the device.
    ///
    /// # Errors
    /// The device was lost, or is out of memory.
    ///
    /// # Panics
    /// If the recorder is not of this ring.
    pub fn submit(&mut self, recorder: Recorder) -> GpuResult<()> {
        self.submit_with(recorder, &[], &[])
    }

    /// Records a frame, submits it, and waits until the device has done it: for work whose results are read at once. Steps that
    /// nothing waits for take less time by [`Frames::begin`] and [`Frames::submit`], because the host is ahead then.
    ///
    /// # Errors
    /// As [`Frames::begin`] and [`Frames::wait_idle`].
    pub fn run<T>(&mut self, record: impl FnOnce(&mut Recorder) -> T) -> GpuResult<T> {
        let mut recorder = self.begin()?;
        let recorded = record(&mut recorder);
        self.submit(recorder)?;
        self.wait_idle()?;
        Ok(recorded)
    }

    /// As [`Frames::submit`], waiting for semaphores at a stage and signalling others: for frames that are shown.
    ///
    /// # Errors
    /// As [`Frames::submit`].
    ///
    /// # Panics
    /// As [`Frames::submit`].
    pub(crate) fn submit_with(
        &mut self,
        mut recorder: Recorder,
        wait: &[(vk::Semaphore, vk::PipelineStageFlags)],
        signal: &[vk::Semaphore],
    ) -> GpuResult<()> {
        let index = self.place_of(&recorder);
        let index = index.expect("a frame is submitted to the ring that began it");
        (recorder.settle_slices()).map_err(|error| self.blame(error))?;
        recorder.finish();
        let frame = Arc::clone(&recorder.frame);
        let device = &self.ctx.device.raw;
        let (semaphores, stages): (Vec<_>, Vec<_>) = wait.iter().copied().unzip();
        let mut cmds: Vec<_> = recorder.slices.waiting.iter().copied().collect();
        cmds.push(recorder.raw());
        let info = [vk::SubmitInfo::default()
            .command_buffers(&cmds)
            .wait_semaphores(&semaphores)
            .wait_dst_stage_mask(&stages)
            .signal_semaphores(signal)];
        // SAFETY: the command buffer was recorded by `recorder`, whose objects live until the fence has signalled.
        unsafe {
            device
                .end_command_buffer(recorder.raw())
                .check("vkEndCommandBuffer", "a frame")?;
            device
                .reset_fences(&[frame.fence])
                .check("vkResetFences", "a frame")?;
        }
        // SAFETY: as above.
        let submit = || unsafe { device.queue_submit(*self.ctx.queue(), &info, frame.fence) };
        let ctx = &self.ctx;
        let submitted = ctx.heard(ctx.is_there().and_then(|()| submit()));
        self.ctx.submits.fetch_add(1, Ordering::Relaxed);
        submitted
            .check("vkQueueSubmit", "a frame")
            .map_err(|error| self.blame(error))?;
        self.ctx.deletion_queue.submitted(recorder.ticket);
        self.ctx.recordings().submitted(&recorder.recording);
        recorder.fate.submit();
        recorder.submitted = true;
        let slot = &mut self.slots[index];
        slot.wanted = recorder.queries_wanted;
        let queries = recorder.queries_used();
        slot.unset = queries;
        slot.pending = Some(Pending {
            ticket: recorder.ticket,
            spans: std::mem::take(&mut recorder.spans),
            queries,
            gaps: std::mem::take(&mut recorder.slices.gaps),
            works: std::mem::take(&mut recorder.works),
            debug_kernels: std::mem::take(&mut recorder.debug_kernels),
        });
        Ok(())
    }

    /// Submits the next slice of a recording to the device, and waits for it. False if only the rest is left, which [`Frames::submit`]
    /// submits.
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

    /// Waits for every frame that was submitted, oldest first.
    ///
    /// # Errors
    /// The device was lost, or did not finish in time.
    pub fn wait_idle(&mut self) -> GpuResult<()> {
        for i in 0..self.slots.len() {
            self.wait_slot((self.next + i) % self.slots.len())?;
        }
        self.ctx.collect_garbage();
        Ok(())
    }

    /// Time that the last [`Frames::begin`] waited for the device. The rest of its time is the host's own work.
    #[must_use]
    pub fn waited(&self) -> Duration {
        self.waited
    }

    /// Times of the frames that have finished and been waited for.
    #[must_use]
    pub fn timings(&self) -> &Timings {
        &self.timings
    }

    /// As [`Frames::timings`], to clear them or to change their capacity.
    pub fn timings_mut(&mut self) -> &mut Timings {
        &mut self.timings
    }

    /// The place in the ring of a frame that it began.
    fn place_of(&self, recorder: &Recorder) -> Option<usize> {
        let mut slots = self.slots.iter();
        slots.position(|slot| Arc::ptr_eq(&slot.resources, &recorder.frame))
    }

    /// Did this ring begin the frame?
    fn has_begun(&self, recorder: &Recorder) -> bool {
        self.place_of(recorder).is_some()
    }

    /// Adds the last breadcrumb of the unfinished frames to an error.
    fn blame(&self, error: GpuError) -> GpuError {
        let oldest_first =
            (0..self.slots.len()).map(|i| &self.slots[(self.next + i) % self.slots.len()]);
        let mut begun = oldest_first
            .filter_map(|slot| Some((slot.resources.works_begun(), slot.pending.as_ref()?)));
        // The device works in order, so the newest begun frame has the last breadcrumb.
        let last = begun.rfind(|(count, _)| *count > 0);
        match last {
            Some((count, pending)) => blame(error, count, &pending.works),
            None => error,
        }
    }

    fn wait_slot(&mut self, index: usize) -> GpuResult<()> {
        let slot = &mut self.slots[index];
        if slot.pending.is_none() {
            return Ok(());
        }
        let begun = Instant::now();
        let finished = self.ctx.wait_for(slot.resources.fence, "a frame");
        self.waited += begun.elapsed();
        if let Err(error) = finished {
            return Err(self.blame(error));
        }
        let slot = &mut self.slots[index];
        if let Some(pending) = slot.pending.take() {
            self.ctx.deletion_queue.end(pending.ticket);
            if !pending.debug_kernels.is_empty() {
                let entries = slot.resources.debug_list().read(&pending.debug_kernels);
                self.ctx
                    .debug
                    .lock()
                    .unwrap_or_else(PoisonError::into_inner)
                    .append(entries);
            }
            let begun = Instant::now();
            let spans = pending.into_spans(&slot.resources)?;
            // lavapipe waits here, too: for all that was submitted.
            if self.ctx.info().kind == DeviceKind::Cpu {
                self.waited += begun.elapsed();
            }
            self.timings.push(spans);
        }
        Ok(())
    }
}

impl Drop for Frames {
    fn drop(&mut self) {
        for slot in &mut self.slots {
            if let Some(pending) = slot.pending.take() {
                self.ctx
                    .deletion_queue
                    .watch(pending.ticket, slot.resources.fence);
            }
        }
    }
}

/// Submits the next slice, if there is one, and waits for it.
fn run_next(recorder: &mut Recorder) -> GpuResult<bool> {
    const WHAT: &str = "a slice of a frame";
    recorder.settle_slices()?;
    let Some(cmd) = recorder.slices.waiting.pop_front() else {
        return Ok(false);
    };
    let ctx = Arc::clone(recorder.ctx());
    let fence = recorder.frame.fence;
    let cmds = [cmd];
    let info = [vk::SubmitInfo::default().command_buffers(&cmds)];
    // SAFETY: the fence belongs to a frame of which nothing runs.
    unsafe { ctx.device.raw.reset_fences(&[fence]) }.check("vkResetFences", WHAT)?;
    // SAFETY: what was recorded lives until the frame is over.
    let submit = || unsafe { ctx.device.raw.queue_submit(*ctx.queue(), &info, fence) };
    let submitted = ctx.heard(ctx.is_there().and_then(|()| submit()));
    ctx.submits.fetch_add(1, Ordering::Relaxed);
    submitted.check("vkQueueSubmit", WHAT)?;
    recorder.slices.is_running = true;
    ctx.wait_for(fence, WHAT)?;
    recorder.slices.is_running = false;
    Ok(true)
}

impl Pending {
    /// The spans of the finished frame.
    fn into_spans(self, frame: &FrameResources) -> GpuResult<Vec<Span>> {
        if self.queries == 0 {
            return Ok(Vec::new());
        }
        let mut ticks = vec![0_u64; self.queries as usize];
        // SAFETY: the frame has finished, so every query that it wrote is available.
        unsafe {
            frame.ctx.device.raw.get_query_pool_results(
                frame.queries,
                0,
                &mut ticks,
                vk::QueryResultFlags::TYPE_64,
            )
        }
        .check("vkGetQueryPoolResults", "a frame")?;
        let ctx = &frame.ctx;
        without_gaps(&mut ticks, &self.gaps, ctx.tick_mask());
        let mut new_index = vec![None; self.spans.len()];
        let mut spans = Vec::with_capacity(self.spans.len());
        for (i, span) in self.spans.into_iter().enumerate() {
            let Some(first) = span.queries else { continue };
            let at = |query: u32| ctx.ns_after(ticks[0], ticks[query as usize]);
            new_index[i] = Some(spans.len());
            spans.push(Span {
                name: span.name,
                kind: span.kind,
                parent: span.parent.and_then(|p| new_index[p]),
                begin_ns: at(first),
                end_ns: at(first + 1),
            });
        }
        Ok(spans)
    }
}
