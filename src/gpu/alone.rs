//! One kernel of many alone: the works before it run once, then the kernel runs repeatedly, each time on the data that it had the first
//! time. The code that records the whole also records these parts.

use std::sync::Arc;

use ash::vk;

use super::buffer::{AnyBuffer, Buffer};
use super::buffer_core::{BufferCore, Domain};
use super::error::GpuResult;
use super::kernel::{BindingAccess, Interface, Resource};
use super::pages::copy_bytes;
use super::part::{Alone, Kept, Part};
use super::recorder::Recorder;
use super::timer::SpanKind;

impl Recorder {
    /// The kernels that `record` would record, in order, as often as they come. Nothing is recorded.
    pub fn kernels_of(&mut self, record: impl FnOnce(&mut Self)) -> Vec<String> {
        self.part = Part::Names(Vec::new());
        record(self);
        match std::mem::take(&mut self.part) {
            Part::Names(names) => names,
            _ => unreachable!("names only are added to"),
        }
    }

    /// Records the works of `record` before its first dispatch of a kernel, and saves the buffers that the kernel writes. `None` if there
    /// is no such dispatch: then all was recorded.
    ///
    /// # Errors
    /// No memory.
    pub fn record_before(
        &mut self,
        kernel: &str,
        record: impl FnOnce(&mut Self),
    ) -> GpuResult<Option<Alone>> {
        self.part = Part::Before(kernel.to_owned());
        record(self);
        match std::mem::take(&mut self.part) {
            Part::Found(alone) => alone.map(Some),
            _ => Ok(None),
        }
    }

    /// Records only the first dispatch of that kernel in `record`, in a scope of this name. Before the scope, the kernel's buffers
    /// are restored to their first contents.
    ///
    /// # Panics
    /// If the dispatch writes other buffers than the one before which they were saved.
    pub fn record_alone(&mut self, alone: &Alone, scope: &str, record: impl FnOnce(&mut Self)) {
        self.part = Part::Only(alone.clone(), scope.to_owned());
        record(self);
        self.part = Part::Whole;
    }

    /// Must this dispatch be recorded? If so, the caller records it next.
    pub(crate) fn admits<I: Interface>(&mut self, name: &str, args: &I::Args<'_>) -> bool {
        if matches!(self.part, Part::Whole) {
            return true;
        }
        let resources = I::resources(args);
        let bound = resources.iter().zip(I::BINDINGS);
        let mut written: Vec<&BufferCore> = bound
            .filter(|(_, binding)| binding.access != BindingAccess::Read)
            .filter_map(|(resource, _): (&Resource<'_>, _)| resource.core())
            .collect();
        // Parts of one buffer are bound separately, so buffers may occur more than once.
        written.sort_by_key(|core| core.raw());
        written.dedup_by_key(|core| core.raw());
        self.admits_kernel(name, written)
    }

    /// As [`admits`](Self::admits), for any work that is timed as a kernel, with the buffers that it writes.
    pub(crate) fn admits_kernel(&mut self, name: &str, written: Vec<&BufferCore>) -> bool {
        match &mut self.part {
            Part::Whole => true,
            Part::Names(names) => {
                names.push(name.to_owned());
                false
            }
            Part::Before(kernel) if kernel == name => {
                self.part = Part::Found(self.keep(name, written));
                false
            }
            Part::Before(_) => true,
            Part::Only(alone, scope) if alone.0.kernel == name => {
                let (alone, scope) = (alone.clone(), std::mem::take(scope));
                assert!(
                    alone.0.are_of(&written),
                    "`{name}` writes other buffers than those whose contents were kept: keep them again"
                );
                for (original, kept, size) in &alone.0.buffers {
                    self.copy_all(kept.core(), original, *size);
                }
                self.begin_span(&scope, SpanKind::Scope);
                self.part = Part::Within;
                true
            }
            Part::Only(..) | Part::Found(_) | Part::Within | Part::Nothing => false,
        }
    }

    /// A dispatch, or a work that counts as one, has been recorded.
    pub(crate) fn ends_alone(&mut self) {
        if matches!(self.part, Part::Within) {
            self.end_span();
            self.part = Part::Nothing;
        }
    }

    /// Are copies and similar works skipped now?
    pub(crate) fn skips(&self) -> bool {
        !matches!(self.part, Part::Whole | Part::Before(_))
    }

    fn keep(&self, kernel: &str, written: Vec<&BufferCore>) -> GpuResult<Alone> {
        let mut buffers = Vec::new();
        for core in written {
            let size = core.size_in_bytes();
            if size == 0 {
                continue;
            }
            let name = format!("kept.{}", core.name());
            let words = (size / size_of::<u32>() as u64) as usize;
            let domain = match core.domain() {
                Domain::Pages => Domain::Pages,
                _ => Domain::Texels,
            };
            let kept = Buffer::new(self.ctx(), &name, words, domain)?;
            self.copy_all(core, kept.core(), size);
            buffers.push((core.shared(), kept, size));
        }
        let kernel = kernel.to_owned();
        Ok(Alone(Arc::new(Kept { kernel, buffers })))
    }

    /// Copies between full barriers, without the usual checks, so that a kernel that runs alone has its first buffers again.
    fn copy_all(&self, from: &BufferCore, to: &BufferCore, size: u64) {
        from.assert_of(self.ctx());
        to.assert_of(self.ctx());
        let all = vk::PipelineStageFlags::ALL_COMMANDS;
        self.full_barrier(all);
        let (from, to) = ((from.extent(), 0), (to.extent(), 0));
        // SAFETY: both are alive, and freed only after this frame. Both have this size.
        unsafe { copy_bytes(self.device(), self.raw(), from, to, size) };
        self.full_barrier(all);
    }
}

impl Kept {
    /// Are these the buffers that were kept? Both are in the same order, in which empty ones have no place.
    fn are_of(&self, written: &[&BufferCore]) -> bool {
        let kept = self.buffers.iter().map(|(core, ..)| Arc::as_ptr(core));
        let written = written.iter().filter(|core| core.size_in_bytes() > 0);
        kept.eq(written.map(|core| std::ptr::from_ref(*core)))
    }
}
