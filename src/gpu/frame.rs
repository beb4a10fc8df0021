//! Frames in flight: the host records one while the device works on those before.

use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use ash::vk;

use super::context::Context;
use super::crumbs::{Crumbs, blame};
use super::debug::DebugList;
use super::error::{Check, GpuError, GpuResult};
use super::graveyard::Corpse;
use super::recorder::{PendingSpan, Recorder};
use super::slices::without_gaps;
use super::timer::{Span, Timings};
use super::transfer::wait_for;
use super::waits::recordings;

/// Queries of a frame at first; a frame that needs more gets them the next time.
pub(crate) const FIRST_QUERIES: u32 = 4096;

/// A ring of frames, each recorded, submitted and, when its turn comes again, waited for.
pub struct Frames {
    ctx: Arc<Context>,
    slots: Vec<Slot>,
    next: usize,
    timings: Timings,
    /// How long the frame that was begun last has waited for the device.
    waited: Duration,
}

struct Slot {
    resources: Arc<FrameResources>,
    pending: Option<Pending>,
    /// How many queries the last frame wanted.
    wanted: u32,
    /// So many, from the first on, may have been written since they were reset, or never were.
    unset: u32,
}

/// What is known of a frame that was submitted.
struct Pending {
    ticket: u64,
    spans: Vec<PendingSpan>,
    queries: u32,
    gaps: Vec<u32>,
    works: Vec<String>,
    debug_kernels: Vec<String>,
}

/// What one frame records into.
pub(crate) struct FrameResources {
    pub(crate) ctx: Arc<Context>,
    pub(crate) pool: vk::CommandPool,
    pub(crate) cmd: vk::CommandBuffer,
    pub(crate) fence: vk::Fence,
    pub(crate) queries: vk::QueryPool,
    pub(crate) query_capacity: u32,
    pub(crate) crumbs: Option<Mutex<Crumbs>>,
    debug: OnceLock<DebugList>,
    /// Command buffers of slices, made as they are needed.
    pub(crate) slices: Mutex<Vec<vk::CommandBuffer>>,
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
        if slot.wanted > slot.resources.query_capacity && self.ctx.info().has_timestamps() {
            slot.resources = Arc::new(FrameResources::new(
                &self.ctx,
                slot.wanted.next_power_of_two(),
            )?);
            slot.unset = u32::MAX;
        }
        self.ctx.collect_garbage();
        slot.resources.start(slot.unset)?;
        // Until it is submitted: a frame that is dropped resets nothing, and parts of it may have run.
        slot.unset = u32::MAX;
        let recorder = Recorder::new(Arc::clone(&slot.resources));
        self.next = (self.next + 1) % self.slots.len();
        Ok(recorder)
    }

    /// Hands a frame to the device.
    ///
    /// # Errors
    /// The device was lost, or is out of memory.
    ///
    /// # Panics
    /// If the recorder is not of this ring.
    pub fn submit(&mut self, recorder: Recorder) -> GpuResult<()> {
        self.submit_with(recorder, &[], &[])
    }

    /// As [`Frames::submit`], waiting for semaphores at a stage and signalling others: for frames that are shown.
    ///
    /// # Errors
    /// As [`Frames::submit`].
    ///
    /// # Panics
    /// As [`Frames::submit`].
    pub fn submit_with(
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
        let mut cmds: Vec<_> = recorder.slices.waiting.drain(..).collect();
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
        self.ctx.graveyard.submitted(recorder.ticket);
        recordings(&self.ctx).submitted(&recorder.recording);
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

    /// How long [`Frames::begin`] has waited for the device the last time. What else it takes is the host's own work.
    #[must_use]
    pub fn waited(&self) -> Duration {
        self.waited
    }

    /// Times of the frames that have finished and been waited for.
    #[must_use]
    pub fn timings(&self) -> &Timings {
        &self.timings
    }

    /// As [`Frames::timings`], to clear them or to change their window.
    pub fn timings_mut(&mut self) -> &mut Timings {
        &mut self.timings
    }

    /// The place in the ring of a frame that it began.
    fn place_of(&self, recorder: &Recorder) -> Option<usize> {
        let mut slots = self.slots.iter();
        slots.position(|slot| Arc::ptr_eq(&slot.resources, &recorder.frame))
    }

    /// Did this ring begin the frame?
    pub(crate) fn has_begun(&self, recorder: &Recorder) -> bool {
        self.place_of(recorder).is_some()
    }

    /// Adds what the crumbs of the unfinished frames tell to an error.
    fn blame(&self, error: GpuError) -> GpuError {
        let oldest_first =
            (0..self.slots.len()).map(|i| &self.slots[(self.next + i) % self.slots.len()]);
        let mut begun = oldest_first
            .filter_map(|slot| Some((slot.resources.works_begun(), slot.pending.as_ref()?)));
        // The device works in order: the newest frame that has begun is the one.
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
        let finished = wait_for(&self.ctx, slot.resources.fence, "a frame");
        self.waited += begun.elapsed();
        if let Err(error) = finished {
            return Err(self.blame(error));
        }
        let slot = &mut self.slots[index];
        if let Some(pending) = slot.pending.take() {
            self.ctx.graveyard.end(pending.ticket);
            if !pending.debug_kernels.is_empty() {
                let told = slot.resources.debug_list().read(&pending.debug_kernels);
                self.ctx
                    .debug
                    .lock()
                    .unwrap_or_else(PoisonError::into_inner)
                    .append(told);
            }
            self.timings.push(slot.resources.read_spans(pending)?);
        }
        Ok(())
    }
}

impl Drop for Frames {
    fn drop(&mut self) {
        for slot in &mut self.slots {
            if let Some(pending) = slot.pending.take() {
                self.ctx
                    .graveyard
                    .adopt(pending.ticket, slot.resources.fence);
            }
        }
    }
}

impl FrameResources {
    fn new(ctx: &Arc<Context>, queries: u32) -> GpuResult<Self> {
        const WHO: &str = "a frame";
        let mut this = Self {
            ctx: Arc::clone(ctx),
            pool: vk::CommandPool::null(),
            cmd: vk::CommandBuffer::null(),
            fence: vk::Fence::null(),
            queries: vk::QueryPool::null(),
            query_capacity: 0,
            crumbs: if ctx.breadcrumbs {
                Some(Mutex::new(Crumbs::new(ctx)?))
            } else {
                None
            },
            debug: OnceLock::new(),
            slices: Mutex::new(Vec::new()),
        };
        let device = &ctx.device.raw;
        // SAFETY: the device is alive; `this` owns each handle as soon as it exists.
        unsafe {
            let info = vk::CommandPoolCreateInfo::default().queue_family_index(ctx.queue_family());
            this.pool = device
                .create_command_pool(&info, None)
                .check("vkCreateCommandPool", WHO)?;
            let info = vk::CommandBufferAllocateInfo::default()
                .command_pool(this.pool)
                .command_buffer_count(1);
            this.cmd = device
                .allocate_command_buffers(&info)
                .check("vkAllocateCommandBuffers", WHO)?[0];
            this.fence = device
                .create_fence(&vk::FenceCreateInfo::default(), None)
                .check("vkCreateFence", WHO)?;
            if ctx.info().has_timestamps() {
                let info = vk::QueryPoolCreateInfo::default()
                    .query_type(vk::QueryType::TIMESTAMP)
                    .query_count(queries);
                this.queries = device
                    .create_query_pool(&info, None)
                    .check("vkCreateQueryPool", WHO)?;
                this.query_capacity = queries;
            }
        }
        ctx.device.set_name(this.cmd, "frame");
        Ok(this)
    }

    /// Made by the first shader that includes `debug.glsl`.
    pub(crate) fn debug_list(&self) -> &DebugList {
        self.debug.get_or_init(|| {
            let list = DebugList::new(&self.ctx, self.ctx.debug_capacity);
            list.unwrap_or_else(|error| panic!("no room for the values that kernels tell: {error}"))
        })
    }

    pub(crate) fn works_begun(&self) -> usize {
        self.crumbs.as_ref().map_or(0, |c| {
            c.lock().unwrap_or_else(PoisonError::into_inner).begun()
        })
    }

    /// Begins to record, with the first of the queries reset: what others a frame uses were never written since they were.
    fn start(&self, unset: u32) -> GpuResult<()> {
        if let Some(crumbs) = &self.crumbs {
            crumbs
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .clear();
        }
        let device = &self.ctx.device.raw;
        let begin = vk::CommandBufferBeginInfo::default()
            .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the last frame in this place has finished, and no recorder has it.
        unsafe {
            device
                .reset_command_pool(self.pool, vk::CommandPoolResetFlags::empty())
                .check("vkResetCommandPool", "a frame")?;
            device
                .begin_command_buffer(self.cmd, &begin)
                .check("vkBeginCommandBuffer", "a frame")?;
            let unset = unset.min(self.query_capacity);
            if unset > 0 {
                device.cmd_reset_query_pool(self.cmd, self.queries, 0, unset);
            }
        }
        Ok(())
    }

    fn read_spans(&self, pending: Pending) -> GpuResult<Vec<Span>> {
        if pending.queries == 0 {
            return Ok(Vec::new());
        }
        let mut ticks = vec![0_u64; pending.queries as usize];
        // SAFETY: the frame has finished, so every query that it wrote is available.
        unsafe {
            self.ctx.device.raw.get_query_pool_results(
                self.queries,
                0,
                &mut ticks,
                vk::QueryResultFlags::TYPE_64,
            )
        }
        .check("vkGetQueryPoolResults", "a frame")?;
        let info = self.ctx.info();
        let mask = u64::MAX >> (64 - info.timestamp_valid_bits.clamp(1, 64));
        let period = f64::from(info.timestamp_period);
        without_gaps(&mut ticks, &pending.gaps, mask);
        let start = ticks[0] & mask;
        let mut new_index = vec![None; pending.spans.len()];
        let mut spans = Vec::with_capacity(pending.spans.len());
        for (i, span) in pending.spans.into_iter().enumerate() {
            let Some(first) = span.queries else { continue };
            // Counters wrap: count from the frame's own start.
            let since_start =
                |query: u32| (ticks[query as usize].wrapping_sub(start) & mask) as f64 * period;
            let base = start as f64 * period;
            new_index[i] = Some(spans.len());
            spans.push(Span {
                name: span.name,
                kind: span.kind,
                parent: span.parent.and_then(|p| new_index[p]),
                begin_ns: base + since_start(first),
                end_ns: base + since_start(first + 1),
            });
        }
        Ok(spans)
    }
}

impl Drop for FrameResources {
    fn drop(&mut self) {
        self.ctx.graveyard.add(Corpse::Frame {
            pool: self.pool,
            queries: self.queries,
            fence: self.fence,
        });
    }
}
