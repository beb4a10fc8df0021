//! Records a frame: dispatches, copies and scopes, each timed, labelled and checked, and the barriers that they need.

use std::sync::Arc;

use ash::vk;

use super::access::{Access, Recording};
use super::alone::Part;
use super::buffer_core::BufferCore;
use super::context::Context;
use super::frame::FrameResources;
use super::info::DeviceKind;
use super::kernel::{
    Binding, BindingAccess, BindingKind, Interface, Params, PipelineCore, Resource, descriptor_type,
};
use super::module::note_used;
use super::slices::Slices;
use super::timer::SpanKind;
use super::waits::{Listed, Touch, recordings};

/// A frame in the making; [`Frames::begin`](super::Frames::begin) makes one and
/// [`Frames::submit`](super::Frames::submit) takes it.
pub struct Recorder {
    pub(crate) frame: Arc<FrameResources>,
    /// What is being recorded into.
    pub(crate) cmd: vk::CommandBuffer,
    pub(crate) slices: Slices,
    pub(crate) ticket: u64,
    pub(crate) spans: Vec<PendingSpan>,
    /// Indices of the scopes that are open.
    open: Vec<usize>,
    queries_used: u32,
    /// More than fit if it exceeds the pool; the next frame gets a larger one.
    pub(crate) queries_wanted: u32,
    pub(crate) submitted: bool,
    /// What has left a crumb, in order.
    pub(crate) works: Vec<String>,
    /// What may have called `debug_value`, in order.
    pub(crate) debug_kernels: Vec<String>,
    /// Which part of what is recorded takes place.
    pub(crate) part: Part,
    pub(crate) commands: Commands,
    /// Everything so far, where that is listed.
    pub(crate) list: Option<Vec<Listed>>,
    pub(crate) is_in_pass: bool,
    /// Something was written that the host reads.
    pub(crate) host_reads: bool,
    /// Does every kernel wait for the one before?
    pub(crate) separates: bool,
    /// Something has been recorded that a work can be separated from.
    pub(crate) has_work: bool,
    pub(crate) recording: Recording,
}

/// How much a frame has recorded so far: what the host does for it grows with these.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Commands {
    /// Dispatches.
    pub kernels: u32,
    /// Draws that are timed one by one.
    pub draws: u32,
    /// Copies, fills and updates.
    pub copies: u32,
    /// Barriers.
    pub barriers: u32,
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
        let ctx = Arc::clone(&frame.ctx);
        let mut recorder = Self {
            cmd: frame.cmd,
            slices: Slices::default(),
            frame,
            ticket,
            spans: Vec::new(),
            open: Vec::new(),
            queries_used: 0,
            queries_wanted: 0,
            submitted: false,
            works: Vec::new(),
            debug_kernels: Vec::new(),
            part: Part::Whole,
            commands: Commands::default(),
            list: None,
            is_in_pass: false,
            host_reads: false,
            separates: false,
            has_work: false,
            recording: recordings(&ctx).begin(),
        };
        recorder.begin_span("frame", SpanKind::Frame);
        recorder
    }

    /// The context that the frame is for.
    #[must_use]
    pub fn ctx(&self) -> &Arc<Context> {
        &self.frame.ctx
    }

    /// What it has recorded so far.
    #[must_use]
    pub fn commands(&self) -> Commands {
        self.commands
    }

    /// The raw command buffer, for crates that draw by themselves.
    #[must_use]
    pub fn raw(&self) -> vk::CommandBuffer {
        self.cmd
    }

    /// Groups what `record` records under a name, in reports and in capture tools.
    pub fn scope<R>(&mut self, name: &str, record: impl FnOnce(&mut Self) -> R) -> R {
        self.begin_span(name, SpanKind::Scope);
        let result = record(self);
        self.end_span();
        result
    }

    /// Checks and binds everything that a pipeline needs, after the barrier that this needs; `more` is read beside it.
    pub(crate) fn bind<I: Interface>(
        &mut self,
        pipeline: &PipelineCore,
        access: Access,
        more: Option<(&BufferCore, Access)>,
        args: &I::Args<'_>,
        params: &I::Params,
    ) {
        let point = match access {
            Access::Kernel => vk::PipelineBindPoint::COMPUTE,
            _ => vk::PipelineBindPoint::GRAPHICS,
        };
        assert!(
            Arc::ptr_eq(&pipeline.ctx, self.ctx()),
            "the pipeline `{}` belongs to another context",
            pipeline.name
        );
        let resources = I::resources(args);
        self.check_arguments::<I>(pipeline.name, &resources);
        let mut touches: Vec<Touch<'_>> = Vec::with_capacity(resources.len() + 1);
        for (resource, binding) in resources.iter().zip(I::BINDINGS) {
            let Some(core) = resource.core() else {
                continue;
            };
            let writes = binding.access != BindingAccess::Read;
            match touches
                .iter_mut()
                .find(|other| other.core.raw() == core.raw())
            {
                Some(other) => other.writes |= writes,
                None => touches.push(Touch {
                    core,
                    access,
                    writes,
                }),
            }
        }
        if let Some((core, access)) = more {
            let is_written = |other: &Touch<'_>| other.writes && other.core.raw() == core.raw();
            assert!(
                !touches.iter().any(is_written),
                "`{}` writes the buffer `{}`, which says what it runs on",
                pipeline.name,
                core.name()
            );
            touches.push(Touch {
                core,
                access,
                writes: false,
            });
        }
        self.touch(pipeline.name, &touches);
        if I::DEBUG_BINDING.is_some() && point == vk::PipelineBindPoint::COMPUTE {
            self.announce_debug(pipeline.name);
        }
        self.put::<I>(pipeline, point, args, params);
    }

    /// Binds what was checked, in whichever command buffer is being recorded.
    pub(crate) fn put<I: Interface>(
        &self,
        pipeline: &PipelineCore,
        point: vk::PipelineBindPoint,
        args: &I::Args<'_>,
        params: &I::Params,
    ) {
        if pipeline.replaced != [None; 2] {
            note_used(pipeline.replaced.into_iter().flatten());
        }
        let resources = I::resources(args);
        let buffers: Vec<_> = resources
            .iter()
            .map(|r| {
                vk::DescriptorBufferInfo::default()
                    .buffer(r.core().map_or(vk::Buffer::null(), BufferCore::raw))
                    .range(vk::WHOLE_SIZE)
            })
            .collect();
        let views: Vec<_> = resources
            .iter()
            .map(|r| match r {
                Resource::Texels(texels) => texels.raw(),
                Resource::Buffer(_) | Resource::Sampled(_) => vk::BufferView::null(),
            })
            .collect();
        let images: Vec<_> = resources
            .iter()
            .map(|r| match r {
                Resource::Sampled(sampled) => sampled.descriptor(),
                _ => vk::DescriptorImageInfo::default(),
            })
            .collect();
        let debug = I::DEBUG_BINDING.map(|number| {
            let core = self.frame.debug_list().buffer().core();
            (
                number,
                [vk::DescriptorBufferInfo::default()
                    .buffer(core.raw())
                    .range(vk::WHOLE_SIZE)],
            )
        });
        let mut writes: Vec<_> = I::BINDINGS
            .iter()
            .enumerate()
            .map(|(i, binding)| {
                vk::WriteDescriptorSet::default()
                    .dst_binding(binding.number)
                    .descriptor_count(1)
                    .descriptor_type(descriptor_type(binding.kind))
                    .buffer_info(&buffers[i..=i])
                    .texel_buffer_view(&views[i..=i])
                    .image_info(&images[i..=i])
            })
            .collect();
        if let Some((number, info)) = &debug {
            let kind = descriptor_type(BindingKind::Storage);
            writes.push(
                vk::WriteDescriptorSet::default()
                    .dst_binding(*number)
                    .descriptor_type(kind)
                    .buffer_info(info),
            );
        }
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

    fn check_arguments<I: Interface>(&self, name: &str, resources: &[Resource<'_>]) {
        for (i, (resource, binding)) in resources.iter().zip(I::BINDINGS).enumerate() {
            let Some(core) = resource.core() else {
                continue;
            };
            assert!(
                Arc::ptr_eq(core.ctx(), self.ctx()),
                "`{}` belongs to another context",
                core.name()
            );
            match (resource, binding.kind) {
                (Resource::Buffer(_), _) => core.assert_bindable(),
                (Resource::Texels(texels), BindingKind::StorageTexels { components }) => assert!(
                    texels.components() == components,
                    "`{name}` binds `{}` as {}, whose texels have {components} components, not {}",
                    core.name(),
                    binding.name,
                    texels.components()
                ),
                (Resource::Texels(_) | Resource::Sampled(_), _) => {}
            }
            let others = resources.iter().zip(I::BINDINGS).skip(i + 1);
            for (other, other_binding) in others.filter(|_| self.ctx().hazard_check) {
                // What is read as texels beside what is written is read by the invocation that writes it, before that, or
                // nobody writes it here: the kernel's header says so. Parts of a buffer are written one by one.
                let own = [(binding, other_binding), (other_binding, binding)]
                    .iter()
                    .any(|(written, read)| {
                        written.access == BindingAccess::Write && read.kind == BindingKind::Texels
                    });
                let parts = is_written_as_texels(binding) && is_written_as_texels(other_binding);
                let written = !own
                    && !parts
                    && (binding.access != BindingAccess::Read
                        || other_binding.access != BindingAccess::Read);
                assert!(
                    !is_of(other, core) || !written,
                    "`{}` binds the buffer `{}` twice, as {} and as {}, and writes it",
                    name,
                    core.name(),
                    binding.name,
                    other_binding.name
                );
            }
        }
    }

    /// Records one piece of work with its label and its times.
    pub(crate) fn work(&mut self, name: &str, kind: SpanKind, record: impl FnOnce(&mut Self)) {
        match kind {
            SpanKind::Kernel => self.commands.kernels += 1,
            SpanKind::Draw => self.commands.draws += 1,
            SpanKind::Copy => self.commands.copies += 1,
            SpanKind::Frame | SpanKind::Scope => {}
        }
        if kind != SpanKind::Draw {
            self.leave_crumb(name);
            self.list_work(name);
        }
        self.begin_span(name, kind);
        if kind != SpanKind::Draw {
            self.write_stamps();
        }
        record(self);
        self.end_span();
        self.ends_alone();
        if kind == SpanKind::Kernel {
            self.end_slice();
        }
    }

    /// Once a picture has been drawn, llvmpipe keeps timestamps back until it next flushes, which would be after the
    /// work that they stand before: every kernel would seem to take no time. An empty barrier makes it flush.
    fn write_stamps(&self) {
        if self.ctx().info().kind != DeviceKind::Cpu || !self.ctx().info().has_timestamps() {
            return;
        }
        let (before, after) = (
            vk::PipelineStageFlags::TOP_OF_PIPE,
            vk::PipelineStageFlags::BOTTOM_OF_PIPE,
        );
        let none = vk::DependencyFlags::empty();
        // SAFETY: the command buffer is being recorded, outside of a pass.
        unsafe {
            self.device()
                .cmd_pipeline_barrier(self.raw(), before, after, none, &[], &[], &[])
        };
    }

    pub(crate) fn leave_crumb(&mut self, name: &str) {
        if let Some(crumbs) = &self.frame.crumbs {
            crumbs
                .lock()
                .unwrap_or_else(|e| e.into_inner())
                .leave(self.raw(), self.works.len() as u32);
            self.works.push(name.to_owned());
        }
    }

    /// Says in the debug list who calls `debug_value` from now on.
    pub(crate) fn announce_debug(&mut self, name: &str) {
        let frame = Arc::clone(&self.frame);
        let list = frame.debug_list();
        let number = self.debug_kernels.len() as u32;
        self.debug_kernels.push(name.to_owned());
        let whole_head = [0, list.capacity, number, 0];
        // The count is only reset by the frame's first.
        let (offset, words) = if number == 0 {
            (0, &whole_head[..])
        } else {
            (8, &whole_head[2..3])
        };
        self.full_barrier(vk::PipelineStageFlags::ALL_COMMANDS);
        // SAFETY: the list is alive as long as the frame; the head lies in it.
        unsafe {
            let bytes = bytemuck::cast_slice(words);
            self.device()
                .cmd_update_buffer(self.raw(), list.buffer().core().raw(), offset, bytes);
        }
        self.full_barrier(vk::PipelineStageFlags::ALL_COMMANDS);
    }

    pub(crate) fn full_barrier(&self, to: vk::PipelineStageFlags) {
        let host = to.contains(vk::PipelineStageFlags::HOST);
        let barrier = vk::MemoryBarrier::default()
            .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
            .dst_access_mask(if host {
                vk::AccessFlags::HOST_READ
            } else {
                vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE
            });
        let (from, none) = (
            vk::PipelineStageFlags::ALL_COMMANDS,
            vk::DependencyFlags::empty(),
        );
        // SAFETY: the command buffer is being recorded.
        unsafe {
            self.device()
                .cmd_pipeline_barrier(self.raw(), from, to, none, &[barrier], &[], &[])
        };
    }

    pub(crate) fn begin_span(&mut self, name: &str, kind: SpanKind) {
        let queries = self.take_queries();
        if let Some(first) = queries {
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

    /// The first of two queries, if there is room.
    pub(crate) fn take_queries(&mut self) -> Option<u32> {
        let first = self.queries_used;
        self.queries_wanted += 2;
        let fits = first + 2 <= self.frame.query_capacity;
        self.queries_used += if fits { 2 } else { 0 };
        fits.then_some(first)
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
    pub(crate) fn stamp(&self, query: u32) {
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
        self.make_visible_to_host();
        if !self.debug_kernels.is_empty() {
            self.full_barrier(vk::PipelineStageFlags::HOST);
        }
        self.end_span();
        assert!(self.open.is_empty(), "a scope is still open");
    }

    /// The names of the scopes that are open.
    pub(crate) fn open_names(&self) -> impl Iterator<Item = &str> {
        self.open.iter().map(|&span| self.spans[span].name.as_str())
    }

    pub(crate) fn queries_used(&self) -> u32 {
        self.queries_used
    }

    pub(crate) fn device(&self) -> &ash::Device {
        &self.frame.ctx.device.raw
    }
}

fn is_of(resource: &Resource<'_>, core: &BufferCore) -> bool {
    resource.core().is_some_and(|own| own.raw() == core.raw())
}

fn is_written_as_texels(binding: &Binding) -> bool {
    matches!(binding.kind, BindingKind::StorageTexels { .. })
}

impl Drop for Recorder {
    fn drop(&mut self) {
        if !self.submitted {
            recordings(&self.frame.ctx).dropped();
        }
        let graveyard = &self.frame.ctx.graveyard;
        if self.slices.is_running {
            graveyard.submitted(self.ticket);
            graveyard.adopt(self.ticket, self.frame.fence);
        } else if !self.submitted {
            graveyard.discard(self.ticket);
        }
    }
}
