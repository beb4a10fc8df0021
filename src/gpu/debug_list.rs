//! The list to which `debug_value` of `shaders/include/debug.glsl` writes.
//!
//! Each frame has its own guarded list, bound by the recorder wherever a shader includes that file. Before each such
//! dispatch the recorder writes its number into the list's head, by which an entry's kernel is found.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::buffer::{AnyBuffer, Buffer};
use super::buffer_core::Domain;
use super::context::Context;
use super::debug::{DebugEntries, DebugEntry, DebugValue};
use super::error::GpuResult;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct RawEntry {
    dispatch: u32,
    invocation: u32,
    tag: u32,
    kind: u32,
    bits: u32,
}

/// Words before the first entry: count, capacity, number of the dispatch, and one unused.
const HEAD: usize = 4;
const ENTRY: usize = size_of::<RawEntry>() / 4;

/// The list of one frame.
pub(crate) struct DebugList {
    pub(crate) words: Buffer<u32>,
    pub(crate) capacity: u32,
}

impl DebugList {
    pub(crate) fn new(ctx: &Arc<Context>, capacity: u32) -> GpuResult<Self> {
        let words = Buffer::new(
            ctx,
            "debug",
            HEAD + ENTRY * capacity as usize,
            Domain::Readback,
        )?;
        Ok(Self { words, capacity })
    }

    /// The values that the finished frame has written; `kernels` names its dispatches.
    pub(crate) fn read(&self, kernels: &[String]) -> DebugEntries {
        let words = self.words.as_slice();
        let (head, list) = words.split_at(HEAD);
        let count = head[0].min(self.capacity);
        let raw: &[RawEntry] = bytemuck::cast_slice(&list[..ENTRY * count as usize]);
        let mut raw = raw.to_vec();
        raw.sort_by_key(|e| (e.dispatch, e.invocation));
        let entries = raw.iter().map(|e| DebugEntry {
            kernel: kernels
                .get(e.dispatch as usize)
                .cloned()
                .unwrap_or_default(),
            invocation: e.invocation,
            tag: e.tag,
            value: match e.kind {
                0 => DebugValue::Uint(e.bits),
                1 => DebugValue::Int(e.bits as i32),
                _ => DebugValue::Float(f32::from_bits(e.bits)),
            },
        });
        DebugEntries {
            entries: entries.collect(),
            overflow: u64::from(head[0] - count),
        }
    }

    pub(crate) fn buffer(&self) -> &dyn AnyBuffer {
        &self.words
    }
}
