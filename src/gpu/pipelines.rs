//! The pipelines of a context. They stay until it ends, so that none is compiled twice: settings that change back and
//! forth, and scenes that follow each other, find what was made before.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher as _};
use std::sync::{Mutex, MutexGuard, PoisonError};

use ash::vk;

use super::graveyard::Corpse;
use super::kernel::{Constants, Interface};

/// All that a pipeline is made from.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct PipelineKey {
    shader: &'static str,
    /// By which times and messages show it.
    name: &'static str,
    /// Of modules and options.
    hash: u64,
    constants: Vec<(u32, [u8; 4])>,
}

impl PipelineKey {
    /// Of these modules and whatever else is not a constant.
    pub(crate) fn new<I: Interface>(
        made_of: impl Hash,
        constants: &I::Constants,
        name: &'static str,
    ) -> Self {
        let mut hasher = DefaultHasher::new();
        made_of.hash(&mut hasher);
        Self {
            shader: I::NAME,
            name,
            hash: hasher.finish(),
            constants: constants.values(),
        }
    }
}

/// A pipeline and what belongs to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PipelineHandles {
    pub(crate) pipeline: vk::Pipeline,
    pub(crate) layout: vk::PipelineLayout,
    pub(crate) set_layout: vk::DescriptorSetLayout,
    /// Files of its modules that come from the folder `MYXO_SPIRV`.
    pub(crate) replaced: [Option<&'static str>; 2],
}

impl PipelineHandles {
    pub(crate) fn corpse(self) -> Corpse {
        Corpse::Pipeline(self.pipeline, self.layout, self.set_layout)
    }
}

/// Cache of pipelines by key.
#[derive(Default)]
pub(crate) struct Pipelines(Mutex<HashMap<PipelineKey, PipelineHandles>>);

impl Pipelines {
    pub(crate) fn get(&self, key: &PipelineKey) -> Option<PipelineHandles> {
        self.lock().get(key).copied()
    }

    /// Keeps what was just made, and returns what is to be used: where another thread was faster, the one that it made.
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
