//! Which part of what is recorded takes place: all of it, or one kernel alone.

use std::sync::Arc;

use super::buffer::Buffer;
use super::error::GpuResult;
use super::pages::Extent;

/// A kernel that is to run alone, and what it found in the buffers that it writes.
#[derive(Clone)]
pub struct Alone(pub(super) Arc<Kept>);

/// What an [`Alone`] shares.
pub(super) struct Kept {
    pub(super) kernel: String,
    /// Each buffer that the kernel writes, what was in it, and how many bytes.
    pub(super) buffers: Vec<(Extent, Buffer<u32>, u64)>,
}

/// Which part of the work that is recorded takes place.
#[derive(Default)]
pub(crate) enum Part {
    /// All of it.
    #[default]
    Whole,
    /// None, and kernels are named.
    Names(Vec<String>),
    /// What comes before the first dispatch of a kernel.
    Before(String),
    /// Such a kernel was met, and what it would find was kept.
    Found(GpuResult<Alone>),
    /// Its first dispatch, in a scope of this name.
    Only(Alone, String),
    /// That dispatch is being recorded.
    Within,
    /// Nothing more.
    Nothing,
}
