//! The pipelines of a context. They stay until it ends, so that none is compiled twice: programs that change constants back and forth, or
//! restart a scene on one context, find the earlier pipelines.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher as _};
use std::sync::{Mutex, MutexGuard, PoisonError};

use ash::vk;

use super::deletion_queue::Deletion;

/// The inputs of a pipeline.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct PipelineKey {
    shader: &'static str,
    /// Name in times and messages.
    name: &'static str,
    /// Hash of modules and options.
    hash: u64,
    constants: Vec<(u32, [u8; 4])>,
}

impl PipelineKey {
    /// The key of a shader: its modules and all else that is not a constant, and the numbers and bits of its constants.
    pub(crate) fn new(
        shader: &'static str,
        made_of: impl Hash,
        constants: Vec<(u32, [u8; 4])>,
        name: &'static str,
    ) -> Self {
        let mut hasher = DefaultHasher::new();
        made_of.hash(&mut hasher);
        Self {
            shader,
            name,
            hash: hasher.finish(),
            constants,
        }
    }
}

/// The form in which a shader was compiled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Form {
    /// Are texel buffers bound as storage blocks?
    pub(crate) in_blocks: bool,
    /// Are tables that may lie in pages and are only written texel buffers, because they outgrow a storage block?
    pub(crate) is_large: bool,
    /// Are tables that may lie in pages bound by address?
    pub(crate) in_pages: bool,
}

/// A pipeline and its layouts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PipelineHandles {
    pub(crate) pipeline: vk::Pipeline,
    pub(crate) layout: vk::PipelineLayout,
    pub(crate) set_layout: vk::DescriptorSetLayout,
    /// Files of its modules that come from the folder `MYXO_SPIRV`.
    pub(crate) replaced: [Option<&'static str>; 2],
    pub(crate) form: Form,
}

impl PipelineHandles {
    pub(crate) fn deletion(self) -> Deletion {
        Deletion::Pipeline(self.pipeline, self.layout, self.set_layout)
    }
}

/// Cache of pipelines by key.
#[derive(Default)]
pub(crate) struct Pipelines(Mutex<HashMap<PipelineKey, PipelineHandles>>);

impl Pipelines {
    pub(crate) fn get(&self, key: &PipelineKey) -> Option<PipelineHandles> {
        self.lock().get(key).copied()
    }

    /// Adds a new pipeline, and returns the one to use: if another thread was faster, the one that it added.
    pub(crate) fn keep(&self, key: PipelineKey, made: PipelineHandles) -> PipelineHandles {
        *self.lock().entry(key).or_insert(made)
    }

    pub(crate) fn take_all(&self) -> Vec<PipelineHandles> {
        self.lock().drain().map(|(_, made)| made).collect()
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<PipelineKey, PipelineHandles>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
