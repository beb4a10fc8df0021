//! One piece of recorded work: what it binds, the barrier before it, its label and its times.

use std::sync::Arc;

use ash::vk;

use super::access::Access;
use super::buffer_core::BufferCore;
use super::info::DeviceKind;
use super::kernel::{
    Binding, BindingAccess, BindingKind, Interface, Params, PipelineCore, Resource, descriptor_type,
};
use super::listing::Listed;
use super::module::note_used;
use super::recorder::Recorder;
use super::timer::SpanKind;
use super::waits::Touch;

impl Recorder {
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
        self.check_arguments::<I>(pipeline, &resources);
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
        let buffers = self.buffers_of::<I>(pipeline, &resources);
        let views = self.views_of(&resources);
        let images = images_of(&resources);
        let debug = I::DEBUG_BINDING.map(|number| (number, [self.debug_buffer()]));
        let mut writes: Vec<_> = I::BINDINGS
            .iter()
            .enumerate()
            .map(|(i, binding)| {
                vk::WriteDescriptorSet::default()
                    .dst_binding(binding.number)
                    .descriptor_count(1)
                    .descriptor_type(descriptor_type(pipeline.bound_as(binding)))
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

    /// The buffer of each resource, or its placeholder; null for images.
    fn buffers_of<I: Interface>(
        &self,
        pipeline: &PipelineCore,
        resources: &[Resource<'_>],
    ) -> Vec<vk::DescriptorBufferInfo> {
        (resources.iter().zip(I::BINDINGS))
            .map(|(r, binding)| {
                let core = match r {
                    Resource::Absent(_) => Some(self.frame.placeholder.block()),
                    _ => r.core(),
                };
                let range = match r {
                    Resource::FirstPart(buffer) => buffer.core().first_part(),
                    _ => vk::WHOLE_SIZE,
                };
                let raw = match core {
                    None => vk::Buffer::null(),
                    Some(core) if pipeline.reaches_pages(binding) => core.addresses(),
                    Some(core) => core.raw(),
                };
                vk::DescriptorBufferInfo::default().buffer(raw).range(range)
            })
            .collect()
    }

    /// The texel view of each resource, or its placeholder; null where there is none.
    fn views_of(&self, resources: &[Resource<'_>]) -> Vec<vk::BufferView> {
        resources
            .iter()
            .map(|r| match r {
                Resource::Texels(texels) => texels.raw(),
                Resource::Absent(absent) => self.frame.placeholder.view(*absent),
                _ => vk::BufferView::null(),
            })
            .collect()
    }

    fn debug_buffer(&self) -> vk::DescriptorBufferInfo {
        let core = self.frame.debug_list().buffer().core();
        vk::DescriptorBufferInfo::default()
            .buffer(core.raw())
            .range(vk::WHOLE_SIZE)
    }

    fn check_arguments<I: Interface>(&self, pipeline: &PipelineCore, resources: &[Resource<'_>]) {
        let name = pipeline.name;
        for (i, (resource, binding)) in resources.iter().zip(I::BINDINGS).enumerate() {
            if let Resource::Sampled(sampled) = resource {
                sampled.image().assert_of(self.ctx());
            }
            let Some(core) = resource.core() else {
                continue;
            };
            core.assert_of(self.ctx());
            match (resource, pipeline.bound_as(binding)) {
                _ if pipeline.reaches_pages(binding) => {}
                (Resource::Buffer(_), _) | (Resource::Texels(_), BindingKind::Storage) => {
                    core.assert_bindable();
                }
                (Resource::Texels(texels), BindingKind::StorageTexels { components }) => {
                    texels.assert_viewed();
                    assert!(
                        texels.components() == components,
                        "`{name}` binds `{}` as {}, whose texels have {components} components, not {}",
                        core.name(),
                        binding.name,
                        texels.components()
                    );
                }
                (Resource::Texels(texels), _) => texels.assert_viewed(),
                _ => {}
            }
            let others = resources.iter().zip(I::BINDINGS).skip(i + 1);
            for (other, other_binding) in others.filter(|_| self.ctx().hazard_check) {
                // A buffer that is both read as texels and written: the invocation that writes an element reads it first, or the
                // dispatch does not write it, as the kernel's header says. For textures this holds for the paths of one argument.
                let are_ways = binding.argument == other_binding.argument;
                let own = !is_way(binding)
                    && !is_way(other_binding)
                    && [(binding, other_binding), (other_binding, binding)]
                        .iter()
                        .any(|(written, read)| {
                            written.access == BindingAccess::Write
                                && read.kind == BindingKind::Texels
                        });
                let written = !are_ways
                    && !own
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
            self.list_entry(|| Listed::Work(name.to_owned()));
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

    /// Closes the frame's own span.
    pub(crate) fn finish(&mut self) {
        self.make_visible_to_host();
        if !self.debug_kernels.is_empty() {
            self.full_barrier(vk::PipelineStageFlags::HOST);
        }
        self.end_span();
        assert!(self.open_names().next().is_none(), "a scope is still open");
        assert!(self.unordered.is_none(), "an unordered group is still open");
    }
}

/// The image of each resource; null where there is none.
fn images_of(resources: &[Resource<'_>]) -> Vec<vk::DescriptorImageInfo> {
    resources
        .iter()
        .map(|r| match r {
            Resource::Sampled(sampled) => sampled.descriptor(),
            _ => vk::DescriptorImageInfo::default(),
        })
        .collect()
}

fn is_of(resource: &Resource<'_>, core: &BufferCore) -> bool {
    resource.core().is_some_and(|own| own.raw() == core.raw())
}

/// One of the ways into what is bound.
fn is_way(binding: &Binding) -> bool {
    binding.name != binding.argument
}
