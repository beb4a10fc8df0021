//! Pipelines that draw, and the passes that they draw in.
//!
//! A pass brings its images into the right layout by itself. Buffers that its shaders read need their barrier, to
//! [`Access::Vertex`], before the pass begins.

use std::marker::PhantomData;
use std::sync::Arc;

use ash::vk;
use bytemuck::Pod;

use super::access::Access;
use super::buffer::{AnyBuffer, Buffer};
use super::context::Context;
use super::error::{Check, GpuError, GpuResult};
use super::image::{Format, Image, ImageState};
use super::kernel::{Draw, PipelineCore, ShaderModule, Specialization};
use super::recorder::Recorder;
use super::timer::SpanKind;

/// What vertices are joined to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Topology {
    /// Three vertices a triangle.
    #[default]
    Triangles,
    /// A strip of triangles.
    TriangleStrip,
    /// Two vertices a line.
    Lines,
    /// A point each; the vertex shader writes `gl_PointSize`.
    Points,
}

/// How a fragment joins the pixel's colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Blend {
    /// It replaces the colour.
    #[default]
    Opaque,
    /// It covers the colour by its alpha; colours are not multiplied by alpha beforehand.
    Alpha,
    /// It is added, weighted by its alpha.
    Add,
}

/// What a [`RasterPipeline`] draws into and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RasterOptions {
    /// Format of the colour target.
    pub color: Format,
    /// The pass has a depth target, and fragments behind what it holds, that is, of smaller depth, are dropped.
    pub depth: bool,
    /// Fragments write their depth, where there is a depth target.
    pub depth_write: bool,
    /// Samples of a pixel.
    pub samples: u32,
    /// What vertices are joined to.
    pub topology: Topology,
    /// How fragments join the picture.
    pub blend: Blend,
    /// Triangles that turn their back (clockwise in the picture) are dropped.
    pub cull_back_faces: bool,
}

impl Default for RasterOptions {
    fn default() -> Self {
        Self {
            color: Format::Rgba8Srgb,
            depth: true,
            depth_write: true,
            samples: 1,
            topology: Topology::Triangles,
            blend: Blend::Opaque,
            cull_back_faces: false,
        }
    }
}

/// A pipeline that draws `D`.
pub struct RasterPipeline<D> {
    core: PipelineCore,
    options: RasterOptions,
    draw: PhantomData<fn() -> D>,
}

impl<D: Draw> RasterPipeline<D> {
    /// Makes the pipeline with these specialization constants.
    ///
    /// # Errors
    /// The device cannot draw (VK_KHR_dynamic_rendering), or the driver refuses the pipeline.
    pub fn new(
        ctx: &Arc<Context>,
        constants: &D::Constants,
        options: RasterOptions,
    ) -> GpuResult<Self> {
        if !ctx.info().has_dynamic_rendering {
            return Err(no_rendering(ctx, D::NAME));
        }
        let stages = vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT;
        let mut core = PipelineCore::layouts::<D>(ctx, stages)?;
        let vertex = ShaderModule::new(ctx, D::VERTEX, D::NAME)?;
        let fragment = ShaderModule::new(ctx, D::FRAGMENT, D::NAME)?;
        let specialization = Specialization::new(constants);
        let specialization = specialization.info();
        let stage = |stage, module: &ShaderModule<'_>| {
            vk::PipelineShaderStageCreateInfo::default()
                .stage(stage)
                .module(module.raw)
                .name(c"main")
                .specialization_info(&specialization)
        };
        let stages = [
            stage(vk::ShaderStageFlags::VERTEX, &vertex),
            stage(vk::ShaderStageFlags::FRAGMENT, &fragment),
        ];
        let vertex_input = vk::PipelineVertexInputStateCreateInfo::default();
        let assembly =
            vk::PipelineInputAssemblyStateCreateInfo::default().topology(match options.topology {
                Topology::Triangles => vk::PrimitiveTopology::TRIANGLE_LIST,
                Topology::TriangleStrip => vk::PrimitiveTopology::TRIANGLE_STRIP,
                Topology::Lines => vk::PrimitiveTopology::LINE_LIST,
                Topology::Points => vk::PrimitiveTopology::POINT_LIST,
            });
        let viewport = vk::PipelineViewportStateCreateInfo::default()
            .viewport_count(1)
            .scissor_count(1);
        let raster = vk::PipelineRasterizationStateCreateInfo::default()
            .polygon_mode(vk::PolygonMode::FILL)
            .cull_mode(if options.cull_back_faces {
                vk::CullModeFlags::BACK
            } else {
                vk::CullModeFlags::NONE
            })
            .front_face(vk::FrontFace::COUNTER_CLOCKWISE)
            .line_width(1.0);
        let samples = vk::PipelineMultisampleStateCreateInfo::default()
            .rasterization_samples(vk::SampleCountFlags::from_raw(options.samples));
        let depth = vk::PipelineDepthStencilStateCreateInfo::default()
            .depth_test_enable(options.depth)
            .depth_write_enable(options.depth && options.depth_write)
            .depth_compare_op(vk::CompareOp::GREATER_OR_EQUAL);
        let attachments = [blend_state(options.blend)];
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&attachments);
        let dynamic = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
        let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
        let colors = [options.color.raw()];
        let depth_format = if options.depth {
            Format::Depth32.raw()
        } else {
            vk::Format::UNDEFINED
        };
        let mut rendering = vk::PipelineRenderingCreateInfo::default()
            .color_attachment_formats(&colors)
            .depth_attachment_format(depth_format);
        let info = [vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .vertex_input_state(&vertex_input)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .rasterization_state(&raster)
            .multisample_state(&samples)
            .depth_stencil_state(&depth)
            .color_blend_state(&blend)
            .dynamic_state(&dynamic)
            .layout(core.layout)
            .push_next(&mut rendering)];
        // SAFETY: all that `info` points to is alive.
        let made = unsafe {
            ctx.device
                .raw
                .create_graphics_pipelines(vk::PipelineCache::null(), &info, None)
        };
        core.pipeline = made
            .map_err(|(_, e)| e)
            .check("vkCreateGraphicsPipelines", D::NAME)?[0];
        ctx.device.set_name(core.pipeline, D::NAME);
        Ok(Self {
            core,
            options,
            draw: PhantomData,
        })
    }

    /// What it was made with.
    #[must_use]
    pub fn options(&self) -> &RasterOptions {
        &self.options
    }
}

fn blend_state(blend: Blend) -> vk::PipelineColorBlendAttachmentState {
    let state = vk::PipelineColorBlendAttachmentState::default()
        .color_write_mask(vk::ColorComponentFlags::RGBA)
        .blend_enable(blend != Blend::Opaque)
        .src_color_blend_factor(vk::BlendFactor::SRC_ALPHA)
        .src_alpha_blend_factor(vk::BlendFactor::ONE);
    let target = if blend == Blend::Add {
        vk::BlendFactor::ONE
    } else {
        vk::BlendFactor::ONE_MINUS_SRC_ALPHA
    };
    state
        .dst_color_blend_factor(target)
        .dst_alpha_blend_factor(target)
}

fn no_rendering(ctx: &Context, what: &str) -> GpuError {
    GpuError::Unsupported {
        what: format!("drawing {what}"),
        missing: "VK_KHR_dynamic_rendering on a queue with graphics".to_owned(),
        device: ctx.info().name.clone(),
    }
}

/// The images of a pass.
#[derive(Clone, Copy, Debug)]
pub struct Targets<'a> {
    /// What is drawn into.
    pub color: &'a Image,
    /// Takes the mean of the samples at the end, where `color` has several.
    pub resolve: Option<&'a Image>,
    /// Depth, of the same size and number of samples as `color`; 0 is far away.
    pub depth: Option<&'a Image>,
    /// Linear colour and alpha that the picture starts with; `None` keeps what is there.
    pub clear: Option<[f32; 4]>,
}

/// Records draws into the targets of a pass.
pub struct PassRecorder<'a> {
    rec: &'a mut Recorder,
    format: Format,
    samples: u32,
    depth: bool,
}

impl Recorder {
    /// Draws into images. Depth always starts at 0 and is not kept; it is reversed, so greater is nearer, which
    /// spreads the precision of floats evenly.
    ///
    /// # Panics
    /// If the targets do not fit each other, or the device cannot draw (then no pipeline could be made either).
    pub fn pass<R>(
        &mut self,
        name: &str,
        targets: &Targets<'_>,
        record: impl FnOnce(&mut PassRecorder<'_>) -> R,
    ) -> R {
        let color = targets.color;
        for other in targets.resolve.iter().chain(&targets.depth) {
            assert!(
                other.size() == color.size(),
                "`{}` and `{}` differ in size",
                other.name(),
                color.name()
            );
        }
        for image in targets.resolve.iter().chain(&targets.depth).chain([&color]) {
            assert!(
                Arc::ptr_eq(image.ctx(), self.ctx()),
                "`{}` belongs to another context",
                image.name()
            );
        }
        let samples = targets.depth.map_or(color.samples(), Image::samples);
        assert!(
            samples == color.samples(),
            "depth has {samples} samples, `{}` has others",
            color.name()
        );

        self.begin_span(name, SpanKind::Scope);
        self.transition(color, ImageState::COLOR_TARGET, targets.clear.is_none());
        if let Some(resolve) = targets.resolve {
            self.transition(resolve, ImageState::COLOR_TARGET, false);
        }
        if let Some(depth) = targets.depth {
            self.transition(depth, ImageState::DEPTH_TARGET, false);
        }
        let mut attachment = vk::RenderingAttachmentInfo::default()
            .image_view(color.view())
            .image_layout(ImageState::COLOR_TARGET.layout)
            .load_op(if targets.clear.is_some() {
                vk::AttachmentLoadOp::CLEAR
            } else {
                vk::AttachmentLoadOp::LOAD
            })
            .store_op(vk::AttachmentStoreOp::STORE)
            .clear_value(vk::ClearValue {
                color: vk::ClearColorValue {
                    float32: targets.clear.unwrap_or_default(),
                },
            });
        if let Some(resolve) = targets.resolve {
            attachment = attachment
                .resolve_mode(vk::ResolveModeFlags::AVERAGE)
                .resolve_image_view(resolve.view())
                .resolve_image_layout(ImageState::COLOR_TARGET.layout);
        }
        let attachments = [attachment];
        let [width, height] = color.size();
        let area = vk::Rect2D {
            offset: vk::Offset2D::default(),
            extent: vk::Extent2D { width, height },
        };
        let mut rendering = vk::RenderingInfo::default()
            .render_area(area)
            .layer_count(1)
            .color_attachments(&attachments);
        let depth_attachment;
        if let Some(depth) = targets.depth {
            depth_attachment = vk::RenderingAttachmentInfo::default()
                .image_view(depth.view())
                .image_layout(ImageState::DEPTH_TARGET.layout)
                .load_op(vk::AttachmentLoadOp::CLEAR)
                .store_op(vk::AttachmentStoreOp::DONT_CARE)
                .clear_value(vk::ClearValue {
                    depth_stencil: vk::ClearDepthStencilValue {
                        depth: 0.0,
                        stencil: 0,
                    },
                });
            rendering = rendering.depth_attachment(&depth_attachment);
        }
        let viewport = vk::Viewport {
            x: 0.0,
            y: 0.0,
            width: width as f32,
            height: height as f32,
            min_depth: 0.0,
            max_depth: 1.0,
        };
        let ctx = Arc::clone(self.ctx());
        let loader = ctx
            .device
            .dynamic_rendering
            .as_ref()
            .unwrap_or_else(|| panic!("{}", no_rendering(&ctx, name)));
        // SAFETY: the images are alive and freed only after this frame; their layouts were set above.
        unsafe {
            loader.cmd_begin_rendering(self.raw(), &rendering);
            self.device().cmd_set_viewport(self.raw(), 0, &[viewport]);
            self.device().cmd_set_scissor(self.raw(), 0, &[area]);
        }
        let (format, depth) = (color.format(), targets.depth.is_some());
        let result = record(&mut PassRecorder {
            rec: self,
            format,
            samples,
            depth,
        });
        // SAFETY: begun above.
        unsafe { loader.cmd_end_rendering(self.raw()) };
        self.end_span();
        result
    }

    /// Copies an image to the start of a buffer, row by row without gaps.
    ///
    /// # Panics
    /// If an element is not as large as a pixel, the buffer is too short, the image has several samples or depth, or a
    /// barrier is missing.
    pub fn copy_image<T: Pod>(&mut self, image: &Image, buffer: &Buffer<T>) {
        let [width, height] = image.size();
        assert!(
            image.samples() == 1 && image.format() != Format::Depth32,
            "`{}` cannot be copied",
            image.name()
        );
        let fits = size_of::<T>() == image.format().pixel_size()
            && buffer.len() >= width as usize * height as usize;
        assert!(
            fits,
            "`{}` does not hold {width} x {height} pixels of {:?}",
            buffer.name(),
            image.format()
        );
        let core = buffer.core();
        core.touch(self.ticket, "copy_image", Access::Copy, false, true);
        self.transition(image, ImageState::COPY_SOURCE, true);
        let region = vk::BufferImageCopy::default()
            .image_subresource(
                vk::ImageSubresourceLayers::default()
                    .aspect_mask(vk::ImageAspectFlags::COLOR)
                    .layer_count(1),
            )
            .image_extent(vk::Extent3D {
                width,
                height,
                depth: 1,
            });
        self.work("copy_image", SpanKind::Copy, |rec| {
            let layout = ImageState::COPY_SOURCE.layout;
            // SAFETY: image and buffer are alive and freed only after this frame; the region lies in both.
            unsafe {
                rec.device().cmd_copy_image_to_buffer(
                    rec.raw(),
                    image.raw(),
                    layout,
                    core.raw(),
                    &[region],
                );
            }
        });
    }

    /// Brings an image from its last state to `next`; its pixels may be lost unless `keep`.
    pub(crate) fn transition(&mut self, image: &Image, next: ImageState, keep: bool) {
        let last = image.exchange_state(next);
        let barrier = vk::ImageMemoryBarrier::default()
            .src_access_mask(last.access)
            .dst_access_mask(next.access)
            .old_layout(if keep {
                last.layout
            } else {
                vk::ImageLayout::UNDEFINED
            })
            .new_layout(next.layout)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(image.raw())
            .subresource_range(image.range());
        let none = vk::DependencyFlags::empty();
        // SAFETY: the image is alive and freed only after this frame.
        unsafe {
            self.device().cmd_pipeline_barrier(
                self.raw(),
                last.stage,
                next.stage,
                none,
                &[],
                &[],
                &[barrier],
            );
        }
    }
}

impl PassRecorder<'_> {
    /// Draws `vertices` vertices `instances` times; none records nothing. Shaders fetch what they need by
    /// `gl_VertexIndex` and `gl_InstanceIndex`.
    ///
    /// # Panics
    /// If the pipeline was made for other targets, or a barrier is missing before the pass.
    pub fn draw<D: Draw>(
        &mut self,
        pipeline: &RasterPipeline<D>,
        vertices: u32,
        instances: u32,
        args: D::Args<'_>,
        params: D::Params,
    ) {
        let options = &pipeline.options;
        assert!(
            options.color == self.format
                && options.samples == self.samples
                && options.depth == self.depth,
            "`{}` was made for {:?}, {} samples, depth {}; the pass has {:?}, {} samples, depth {}",
            D::NAME,
            options.color,
            options.samples,
            options.depth,
            self.format,
            self.samples,
            self.depth
        );
        if vertices == 0 || instances == 0 {
            return;
        }
        self.rec.bind::<D>(
            &pipeline.core,
            vk::PipelineBindPoint::GRAPHICS,
            Access::Vertex,
            &args,
            &params,
        );
        self.rec.work(D::NAME, SpanKind::Draw, |rec| {
            // SAFETY: pipeline, descriptors and constants were bound for this layout above.
            unsafe { rec.device().cmd_draw(rec.raw(), vertices, instances, 0, 0) };
        });
    }

    /// The raw command buffer, inside the pass, for crates that draw by themselves.
    #[must_use]
    pub fn raw(&self) -> vk::CommandBuffer {
        self.rec.raw()
    }
}
