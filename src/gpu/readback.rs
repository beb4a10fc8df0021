//! Small results, read some frames later without waiting for the device.

use std::collections::VecDeque;
use std::sync::Arc;

use bytemuck::Pod;

use super::access::Access;
use super::buffer::{AnyBuffer, Buffer, Domain};
use super::context::Context;
use super::error::GpuResult;
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
///     rec.barrier(Access::Kernel, Access::Copy, &[counters]);
///     readback.record(&mut rec, counters, 0);
///     rec.barrier(Access::Copy, Access::Kernel, &[counters]);
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
    waiting: VecDeque<(u64, usize, u64)>,
    ctx: Arc<Context>,
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
            ctx: Arc::clone(ctx),
        })
    }

    /// Copies `source` under a number of the caller's choice, such as the step's. Without a free slot it does nothing
    /// and returns `false`: the host reads too seldom.
    ///
    /// # Panics
    /// If `source` has more elements than a slot, or lacks the barrier to [`Access::Copy`].
    pub fn record(&mut self, rec: &mut Recorder, source: &Buffer<T>, number: u64) -> bool {
        let free =
            (0..self.slots.len()).find(|i| !self.waiting.iter().any(|(_, slot, _)| slot == i));
        let Some(slot) = free else { return false };
        let target = &self.slots[slot];
        // The slot's last copy was read on the host, after its frame had finished.
        target.core().forget_history();
        rec.copy(source, target);
        rec.barrier(Access::Copy, Access::Readback, &[target]);
        self.waiting.push_back((number, slot, rec.ticket));
        true
    }

    /// The oldest copy that has arrived and was not returned yet, with its number. Does not wait.
    pub fn poll(&mut self) -> Option<(u64, Vec<T>)> {
        loop {
            let &(number, slot, ticket) = self.waiting.front()?;
            if self.slots[slot].is_in_use() {
                return None;
            }
            self.waiting.pop_front();
            if !self.ctx.graveyard.was_discarded(ticket) {
                return Some((number, self.slots[slot].as_slice().to_vec()));
            }
        }
    }
}
