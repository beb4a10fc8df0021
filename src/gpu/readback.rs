//! Small results and pictures, read some frames later without waiting for the device.

use std::collections::VecDeque;
use std::sync::Arc;

use bytemuck::Pod;

use super::buffer::{AnyBuffer, Buffer};
use super::buffer_core::Domain;
use super::context::Context;
use super::error::GpuResult;
use super::fate::Fate;
use super::image::Image;
use super::recorder::Recorder;

/// A ring of copies of a buffer, each read when its frame has finished.
///
/// ```no_run
/// # use myxo::gpu::*;
/// # fn frame(ctx: &std::sync::Arc<Context>, frames: &mut Frames, counters: &Buffer<u32>) -> GpuResult<()> {
/// let mut readback = Readback::<u32>::new(ctx, "counters", counters.len(), 3)?;
/// loop {
///     let mut rec = frames.begin()?;
///     // ... dispatches that write `counters`, then:
///     readback.record(&mut rec, counters, 0);
///     frames.submit(rec)?;
///     while let Some((_number, values)) = readback.poll() {
///         println!("{} overflows", values[0]);
///     }
/// }
/// # }
/// ```
pub struct Readback<T> {
    slots: Vec<Buffer<T>>,
    /// Number, slot and recording, oldest first.
    waiting: VecDeque<(u64, usize, Fate)>,
}

impl<T: Pod> Readback<T> {
    /// A ring of `slots` copies of `len` elements; one slot more than frames in flight never skips.
    ///
    /// # Errors
    /// No memory.
    pub fn new(ctx: &Arc<Context>, name: &str, len: usize, slots: usize) -> GpuResult<Self> {
        let slots = (0..slots.max(1))
            .map(|i| Buffer::new(ctx, &format!("{name}.readback{i}"), len, Domain::Readback));
        Ok(Self {
            slots: slots.collect::<GpuResult<_>>()?,
            waiting: VecDeque::new(),
        })
    }

    /// Copies `source` under a number of the caller's choice, such as the step's. Without a free slot it does nothing
    /// and returns `false`: the host reads too seldom. So it does in a recording of one kernel alone, which copies nothing.
    ///
    /// # Panics
    /// If `source` has more elements than a slot.
    pub fn record(&mut self, rec: &mut Recorder, source: &Buffer<T>, number: u64) -> bool {
        self.record_range(rec, source, 0..source.len(), number)
    }

    /// As [`record`](Self::record), for a range of the elements.
    ///
    /// # Panics
    /// If a slot has not as many elements, or `source` lacks any of them.
    pub fn record_range(
        &mut self,
        rec: &mut Recorder,
        source: &Buffer<T>,
        range: std::ops::Range<usize>,
        number: u64,
    ) -> bool {
        if rec.skips() {
            return false;
        }
        let free =
            (0..self.slots.len()).find(|i| !self.waiting.iter().any(|(_, slot, _)| slot == i));
        let Some(slot) = free else { return false };
        let target = &self.slots[slot];
        // The slot's last copy was read on the host, after its frame had finished.
        target.core().forget_history();
        rec.copy_range(source, range, target, 0);
        self.waiting.push_back((number, slot, rec.fate.clone()));
        true
    }

    /// The oldest copy that has arrived and was not returned yet, with its number. Does not wait. A copy arrives when
    /// [`Frames::begin`](super::Frames::begin) or [`Frames::wait_idle`](super::Frames::wait_idle) has waited for its frame.
    pub fn poll(&mut self) -> Option<(u64, Vec<T>)> {
        loop {
            let (_, slot, _) = self.waiting.front()?;
            if self.slots[*slot].is_in_use() {
                return None;
            }
            let (number, slot, fate) = self.waiting.pop_front()?;
            if !fate.was_dropped() {
                return Some((number, self.slots[slot].as_slice().to_vec()));
            }
        }
    }
}

/// As [`Readback`], for images with four bytes per pixel, each of any size.
pub struct ReadbackImage {
    name: String,
    slots: Vec<Option<Buffer<[u8; 4]>>>,
    /// Number, size, slot and recording, oldest first.
    waiting: VecDeque<(u64, [u32; 2], usize, Fate)>,
    ctx: Arc<Context>,
}

impl ReadbackImage {
    /// A ring of `slots` copies, which take memory when they are first needed.
    #[must_use]
    pub fn new(ctx: &Arc<Context>, name: &str, slots: usize) -> Self {
        Self {
            name: name.to_owned(),
            slots: (0..slots.max(1)).map(|_| None).collect(),
            waiting: VecDeque::new(),
            ctx: Arc::clone(ctx),
        }
    }

    /// Copies an image under a number of the caller's choice. Without a free slot it does nothing and returns `false`:
    /// the host reads too seldom.
    ///
    /// # Errors
    /// No memory.
    ///
    /// # Panics
    /// If a pixel does not have four bytes.
    pub fn record(&mut self, rec: &mut Recorder, image: &Image, number: u64) -> GpuResult<bool> {
        if rec.skips() {
            return Ok(false);
        }
        let taken = |i: &usize| self.waiting.iter().any(|(.., slot, _)| slot == i);
        let Some(slot) = (0..self.slots.len()).find(|i| !taken(i)) else {
            return Ok(false);
        };
        let size = image.size();
        let len = size[0] as usize * size[1] as usize;
        let fits = |buffer: &Buffer<[u8; 4]>| buffer.len() == len;
        if !self.slots[slot].as_ref().is_some_and(fits) {
            let name = format!("{}.readback{slot}", self.name);
            self.slots[slot] = Some(Buffer::new(&self.ctx, &name, len, Domain::Readback)?);
        }
        let target = self.slots[slot].as_ref().expect("made above");
        // The slot's last copy was read on the host, after its frame had finished.
        target.core().forget_history();
        rec.copy_image(image, target);
        self.waiting
            .push_back((number, size, slot, rec.fate.clone()));
        Ok(true)
    }

    /// The oldest copy that has arrived and was not returned yet: its number, its size, and its pixels row by row. Does
    /// not wait.
    pub fn poll(&mut self) -> Option<(u64, [u32; 2], Vec<u8>)> {
        loop {
            let (.., slot, _) = self.waiting.front()?;
            let buffer = self.slots[*slot].as_ref().expect("it was recorded");
            if buffer.is_in_use() {
                return None;
            }
            let (number, size, _, fate) = self.waiting.pop_front()?;
            if !fate.was_dropped() {
                let pixels = buffer.as_slice().as_flattened().to_vec();
                return Some((number, size, pixels));
            }
        }
    }
}
