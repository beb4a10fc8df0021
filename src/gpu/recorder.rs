//! Records a frame: dispatches, barriers, copies and scopes, each timed, labelled and checked.

use std::sync::Arc;

use ash::vk;
use bytemuck::Pod;

use super::access::Access;
use super::buffer::{AnyBuffer, Buffer};
use super::context::Context;
use super::frame::FrameResources;
use super::kernel::{
    BindingAccess, Interface, Kernel, Params, Pipeline, PipelineCore, Resource, Threads,
    descriptor_type,
};
use super::timer::SpanKind;

/// A frame in the making; [`Frames::begin`](super::Frames::begin) makes one and
/// [`Frames::submit`](super::Frames::submit) takes it.
pub struct Recorder {
    pub(crate) frame: Arc<FrameResources>,
    pub(crate) ticket: u64,
    pub(crate) spans: Vec<PendingSpan>,
    /// Indices of the scopes that are open.
    open: Vec<usize>,
    queries_used: u32,
    /// More than fit if it exceeds the pool; the next frame gets a larger one.
    pub(crate) queries_wanted: u32,
    pub(crate) submitted: bool,
}

/// A span whose times are not known yet.
pub(crate) struct PendingSpan {
    pub(crate) name: String,
    pub(crate) kind: SpanKind,
    pub(crate) parent: Option<usize>,
    /// First of its two queries, where there was room.
    pub(crate) queries: Option<u32>,
}

impl Recorder {
    pub(crate) fn new(frame: Arc<FrameResources>) -> Self {
        let ticket = frame.ctx.graveyard.begin();
        let mut recorder = Self {
            frame,
            ticket,
            spans: Vec::new(),
            open: Vec::new(),
            queries_used: 0,
            queries_wanted: 0,
            submitted: false,
        };
        recorder.begin_span("frame", SpanKind::Frame);
        recorder
    }

    /// The context that the frame is for.
    #[must_use]
    pub fn ctx(&self) -> &Arc<Context> {
        &self.frame.ctx
    }

    /// The raw command buffer, for crates that draw by themselves.
    #[must_use]
    pub fn raw(&self) -> vk::CommandBuffer {
        self.frame.cmd
    }

    /// Runs a kernel with at least `threads` invocations; none records nothing.
    ///
    /// # Panics
    /// If a barrier is missing, or one buffer is bound twice and written.
    pub fn dispatch<K: Kernel>(
        &mut self,
        pipeline: &Pipeline<K>,
        threads: Threads,
        args: K::Args<'_>,
        params: K::Params,
    ) {
        let Some([x, y]) = threads.groups(K::GROUP_SIZE, self.ctx().info().max_group_count) else {
            return;
        };
        self.bind::<K>(
            pipeline.core(),
            vk::PipelineBindPoint::COMPUTE,
            Access::Kernel,
            &args,
            &params,
        );
        self.work(K::NAME, SpanKind::Kernel, |rec| {
            // SAFETY: pipeline, descriptors and constants were bound for this layout above.
            unsafe { rec.device().cmd_dispatch(rec.raw(), x, y, 1) };
        });
    }

    /// What was done by `from` to the buffers happens before, and is seen by, what `to` does next.
    pub fn barrier(&mut self, from: Access, to: Access, buffers: &[&dyn AnyBuffer]) {
        let barriers: Vec<_> = buffers
            .iter()
            .map(|buffer| {
                let core = buffer.core();
                core.barrier(self.ticket, from, to);
                vk::BufferMemoryBarrier::default()
                    .src_access_mask(from.writes())
                    .dst_access_mask(to.uses())
                    .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                    .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                    .buffer(core.raw())
                    .size(vk::WHOLE_SIZE)
            })
            .collect();
        let (before, after) = (from.stage(), to.stage());
        // SAFETY: the buffers are alive, and freed only after this frame.
        unsafe {
            self.device().cmd_pipeline_barrier(
                self.raw(),
                before,
                after,
                vk::DependencyFlags::empty(),
                &[],
                &barriers,
                &[],
            )
        };
    }

    /// Copies all of `source` to the start of `target`.
    ///
    /// # Panics
    /// If `target` is shorter, both are one, or a barrier is missing.
    pub fn copy<T: Pod>(&mut self, source: &Buffer<T>, target: &Buffer<T>) {
        self.copy_range(source, 0..source.len(), target, 0);
    }

    /// Copies a range of elements of `source` to `target`, from the element `start` on.
    ///
    /// # Panics
    /// If the range does not lie in both, both are one, or a barrier is missing.
    pub fn copy_range<T: Pod>(
        &mut self,
        source: &Buffer<T>,
        range: std::ops::Range<usize>,
        target: &Buffer<T>,
        start: usize,
    ) {
        let fits = range.start <= range.end && range.end <= source.len();
        assert!(
            fits,
            "`{}` has {} elements, not {range:?}",
            source.name(),
            source.len()
        );
        let fits = start
            .checked_add(range.len())
            .is_some_and(|end| end <= target.len());
        assert!(
            fits,
            "`{}` has {} elements: {} from {start} on do not fit",
            target.name(),
            target.len(),
            range.len()
        );
        let (from, to) = (source.core(), target.core());
        assert!(
            from.raw() != to.raw(),
            "`{}` cannot be copied to itself",
            source.name()
        );
        let element = size_of::<T>() as u64;
        let copy = vk::BufferCopy {
            src_offset: range.start as u64 * element,
            dst_offset: start as u64 * element,
            size: range.len() as u64 * element,
        };
        if copy.size == 0 {
            return;
        }
        from.touch(self.ticket, "copy", Access::Copy, true, false);
        to.touch(self.ticket, "copy", Access::Copy, false, true);
        self.work("copy", SpanKind::Copy, |rec| {
            // SAFETY: both buffers are alive and freed only after this frame; the range lies in both.
            unsafe {
                rec.device()
                    .cmd_copy_buffer(rec.raw(), from.raw(), to.raw(), &[copy])
            };
        });
    }

    /// Fills a buffer with a 32-bit value.
    ///
    /// # Panics
    /// If a barrier is missing.
    pub fn fill(&mut self, buffer: &dyn AnyBuffer, value: u32) {
        let core = buffer.core();
        if core.size_in_bytes() == 0 {
            return;
        }
        core.touch(self.ticket, "fill", Access::Copy, false, true);
        self.work("fill", SpanKind::Copy, |rec| {
            // SAFETY: the buffer is alive and freed only after this frame; its size is a multiple of 4.
            unsafe {
                rec.device()
                    .cmd_fill_buffer(rec.raw(), core.raw(), 0, core.size_in_bytes(), value)
            };
        });
    }

    /// Writes a few elements, which travel in the command buffer, from the element `start` on.
    ///
    /// # Panics
    /// If they do not fit the buffer or take more than 65,536 bytes; if a barrier is missing.
    pub fn update<T: Pod>(&mut self, buffer: &Buffer<T>, start: usize, data: &[T]) {
        let fits = start
            .checked_add(data.len())
            .is_some_and(|end| end <= buffer.len());
        assert!(
            fits,
            "`{}` has {} elements: {} from {start} on do not fit",
            buffer.name(),
            buffer.len(),
            data.len()
        );
        assert!(
            size_of_val(data) <= 65_536,
            "{} bytes do not fit a command buffer; use an upload buffer",
            size_of_val(data)
        );
        if data.is_empty() {
            return;
        }
        let core = buffer.core();
        core.touch(self.ticket, "update", Access::Copy, false, true);
        self.work("update", SpanKind::Copy, |rec| {
            let offset = (start * size_of::<T>()) as u64;
            // SAFETY: the buffer is alive and freed only after this frame; elements have a multiple of 4 bytes.
            unsafe {
                rec.device().cmd_update_buffer(
                    rec.raw(),
                    core.raw(),
                    offset,
                    bytemuck::cast_slice(data),
                )
            };
        });
    }

    /// Groups what `record` records under a name, in reports and in capture tools.
    pub fn scope<R>(&mut self, name: &str, record: impl FnOnce(&mut Self) -> R) -> R {
        self.begin_span(name, SpanKind::Scope);
        let result = record(self);
        self.end_span();
        result
    }

    /// Checks and binds everything that a pipeline needs.
    pub(crate) fn bind<I: Interface>(
        &mut self,
        pipeline: &PipelineCore,
        point: vk::PipelineBindPoint,
        access: Access,
        args: &I::Args<'_>,
        params: &I::Params,
    ) {
        assert!(
            Arc::ptr_eq(&pipeline.ctx, self.ctx()),
            "the pipeline `{}` belongs to another context",
            I::NAME
        );
        let resources = I::resources(args);
        self.check_hazards::<I>(&resources, access);
        let buffers: Vec<_> = resources
            .iter()
            .map(|r| {
                vk::DescriptorBufferInfo::default()
                    .buffer(r.core().raw())
                    .range(vk::WHOLE_SIZE)
            })
            .collect();
        let views: Vec<_> = resources
            .iter()
            .map(|r| match r {
                Resource::Texels(texels) => texels.raw(),
                Resource::Buffer(_) => vk::BufferView::null(),
            })
            .collect();
        let writes: Vec<_> = I::BINDINGS
            .iter()
            .enumerate()
            .map(|(i, binding)| {
                vk::WriteDescriptorSet::default()
                    .dst_binding(binding.number)
                    .descriptor_count(1)
                    .descriptor_type(descriptor_type(binding.kind))
                    .buffer_info(&buffers[i..=i])
                    .texel_buffer_view(&views[i..=i])
            })
            .collect();
        let mut bytes = [0; 128];
        let bytes = &mut bytes[..<I::Params as Params>::SIZE];
        params.write(bytes);
        let stages = match point {
            vk::PipelineBindPoint::COMPUTE => vk::ShaderStageFlags::COMPUTE,
            _ => vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT,
        };
        let cmd = self.raw();
        // SAFETY: the pipeline, its layout, and every buffer are alive and freed only after this frame.
        unsafe {
            self.device()
                .cmd_bind_pipeline(cmd, point, pipeline.pipeline);
            if !writes.is_empty() {
                self.ctx().device.push_descriptor.cmd_push_descriptor_set(
                    cmd,
                    point,
                    pipeline.layout,
                    0,
                    &writes,
                );
            }
            if !bytes.is_empty() {
                self.device()
                    .cmd_push_constants(cmd, pipeline.layout, stages, 0, bytes);
            }
        }
    }

    fn check_hazards<I: Interface>(&self, resources: &[Resource<'_>], access: Access) {
        for (i, (resource, binding)) in resources.iter().zip(I::BINDINGS).enumerate() {
            let core = resource.core();
            assert!(
                Arc::ptr_eq(core.ctx(), self.ctx()),
                "`{}` belongs to another context",
                core.name()
            );
            if matches!(resource, Resource::Buffer(_)) {
                core.assert_bindable();
            }
            for (other, other_binding) in resources.iter().zip(I::BINDINGS).skip(i + 1) {
                let written = binding.access != BindingAccess::Read
                    || other_binding.access != BindingAccess::Read;
                assert!(
                    other.core().raw() != core.raw() || !written || !self.ctx().hazard_check,
                    "`{}` binds the buffer `{}` twice, as {} and as {}, and writes it",
                    I::NAME,
                    core.name(),
                    binding.name,
                    other_binding.name
                );
            }
        }
        for (resource, binding) in resources.iter().zip(I::BINDINGS) {
            let reads = binding.access != BindingAccess::Write;
            let writes = binding.access != BindingAccess::Read;
            resource
                .core()
                .touch(self.ticket, I::NAME, access, reads, writes);
        }
    }

    /// Records one piece of work with its label and its times.
    pub(crate) fn work(&mut self, name: &str, kind: SpanKind, record: impl FnOnce(&Self)) {
        self.begin_span(name, kind);
        record(self);
        self.end_span();
    }

    pub(crate) fn begin_span(&mut self, name: &str, kind: SpanKind) {
        let fits = self.queries_used + 2 <= self.frame.query_capacity;
        self.queries_wanted += 2;
        let queries = fits.then_some(self.queries_used);
        if let Some(first) = queries {
            self.queries_used += 2;
            self.stamp(first);
        }
        self.ctx().device.begin_label(self.raw(), name);
        let parent = self.open.last().copied();
        self.open.push(self.spans.len());
        self.spans.push(PendingSpan {
            name: name.to_owned(),
            kind,
            parent,
            queries,
        });
    }

    pub(crate) fn end_span(&mut self) {
        let span = self
            .open
            .pop()
            .expect("spans are closed by who opened them");
        self.ctx().device.end_label(self.raw());
        if let Some(first) = self.spans[span].queries {
            self.stamp(first + 1);
        }
    }

    /// Written when everything before it has finished.
    fn stamp(&self, query: u32) {
        // SAFETY: the query lies in the pool, was reset at the start of the frame and is written once.
        unsafe {
            self.device().cmd_write_timestamp(
                self.raw(),
                vk::PipelineStageFlags::BOTTOM_OF_PIPE,
                self.frame.queries,
                query,
            );
        }
    }

    /// Closes the frame's own span.
    pub(crate) fn finish(&mut self) {
        self.end_span();
        assert!(self.open.is_empty(), "a scope is still open");
    }

    pub(crate) fn queries_used(&self) -> u32 {
        self.queries_used
    }

    pub(crate) fn device(&self) -> &ash::Device {
        &self.frame.ctx.device.raw
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        if !self.submitted {
            self.frame.ctx.graveyard.end(self.ticket);
        }
    }
}
