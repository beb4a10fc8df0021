//! Recording of everything, or of one kernel alone.

use std::sync::Arc;

use super::buffer::Buffer;
use super::buffer_core::BufferCore;
use super::error::GpuResult;

/// A kernel that is to run alone, and the first contents of the buffers that it writes.
#[derive(Clone)]
pub struct Alone(pub(super) Arc<Kept>);

/// The shared data of an [`Alone`].
pub(super) struct Kept {
    pub(super) kernel: String,
    /// Each buffer that the kernel writes, its first content, and its size in bytes.
    pub(super) buffers: Vec<(Arc<BufferCore>, Buffer<u32>, u64)>,
}

/// The part of the work that is really recorded.
#[derive(Default)]
pub(crate) enum Part {
    /// All of it.
    #[default]
    Whole,
    /// None, and kernels are named.
    Names(Vec<String>),
    /// The works before the first dispatch of a kernel.
    Before(String),
    /// The kernel was found, and the contents of its buffers were kept.
    Found(GpuResult<Alone>),
    /// Its first dispatch, in a scope of this name.
    Only(Alone, String),
    /// That dispatch is being recorded.
    Within,
    /// Nothing more.
    Nothing,
}
