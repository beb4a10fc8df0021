//! Pipelines that draw; passes use them.

use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use ash::vk;

use super::context::Context;
use super::error::{Check, GpuError, GpuResult};
use super::image::Format;
use super::kernel::{Constants, Draw, PipelineCore, ShaderModule, Specialization, Tables};
use super::module::Module;
use super::pipelines::{Form, PipelineKey};

/// Primitives that vertices form.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
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

/// Blending of a fragment with the pixel's colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Blend {
    /// It replaces the colour.
    #[default]
    Opaque,
    /// It covers the colour by its alpha; colours are not multiplied by alpha beforehand.
    Alpha,
    /// It is added; colours are multiplied by alpha beforehand.
    Add,
    /// Each channel takes the maximum.
    Max,
}

/// The comparison of fragment depths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DepthTest {
    /// The one of greater depth, of equal ones the later: depth is reversed.
    #[default]
    Greatest,
    /// The one of smaller depth, of equal ones the earlier.
    Smallest,
}

/// Target and state of a [`RasterPipeline`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct RasterOptions {
    /// Format of the colour target.
    pub color: Format,
    /// The pass has a depth target, and fragments behind its depths are dropped.
    pub depth: bool,
    /// The depth test; equal for all draws of a pass.
    pub depth_test: DepthTest,
    /// Fragments write their depth, where there is a depth target.
    pub depth_write: bool,
    /// Samples of a pixel.
    pub samples: u32,
    /// Primitives that vertices form.
    pub topology: Topology,
    /// Blending.
    pub blend: Blend,
    /// Back faces (clockwise in the picture) are dropped.
    pub cull_back_faces: bool,
}

impl Default for RasterOptions {
    fn default() -> Self {
        Self {
            color: Format::Rgba8Srgb,
            depth: true,
            depth_test: DepthTest::Greatest,
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
    pub(crate) core: PipelineCore,
    options: RasterOptions,
    draw: PhantomData<fn() -> D>,
}

impl<D: Draw> RasterPipeline<D> {
    /// The pipeline with these specialization constants and options. It is compiled the first time that the context is asked for
    /// it.
    ///
    /// # Errors
    /// The device cannot draw (VK_KHR_dynamic_rendering), or the driver refuses the pipeline.
    pub fn new(
        ctx: &Arc<Context>,
        constants: &D::Constants,
        options: RasterOptions,
    ) -> GpuResult<Self> {
        Self::over(ctx, constants, options, Tables::InOnePiece)
    }

    /// As [`new`](Self::new), for tables that may lie in pages.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn over(
        ctx: &Arc<Context>,
        constants: &D::Constants,
        options: RasterOptions,
        tables: Tables,
    ) -> GpuResult<Self> {
        if !ctx.info().has_dynamic_rendering {
            return Err(no_rendering(ctx, D::NAME));
        }
        if D::DEBUG_BINDING.is_some() {
            admit_debug_values(ctx, D::NAME)?;
        }
        let paged = |module: Module| module.for_pages.filter(|_| tables == Tables::InPages);
        let form = Form {
            in_blocks: false,
            is_large: false,
            in_pages: paged(D::VERTEX).is_some() || paged(D::FRAGMENT).is_some(),
        };
        let key = PipelineKey::new(
            D::NAME,
            (D::VERTEX, D::FRAGMENT, options, form),
            constants.values(),
            D::NAME,
        );
        if let Some(made) = ctx.pipelines.get(&key) {
            return Ok(Self {
                core: PipelineCore::kept(ctx, D::NAME, made),
                options,
                draw: PhantomData,
            });
        }
        let stages = vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT;
        let mut core = PipelineCore::layouts::<D>(ctx, stages, form)?;
        let vertex = paged(D::VERTEX).unwrap_or(&D::VERTEX);
        let vertex = ShaderModule::new(ctx, vertex, D::NAME)?;
        let fragment = paged(D::FRAGMENT).unwrap_or(&D::FRAGMENT);
        let fragment = ShaderModule::new(ctx, fragment, D::NAME)?;
        core.replaced = [vertex.replaced, fragment.replaced];
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
        core.pipeline = graphics_pipeline(ctx, D::NAME, &stages, core.layout, options)?;
        ctx.device.set_name(core.pipeline, D::NAME);
        Ok(Self {
            core: core.keep(key),
            options,
            draw: PhantomData,
        })
    }

    /// The options that it was made with.
    #[must_use]
    pub fn options(&self) -> &RasterOptions {
        &self.options
    }
}

/// Notes that a draw may write debug values; fails if the device cannot do that.
fn admit_debug_values(ctx: &Context, name: &str) -> GpuResult<()> {
    let features = &ctx.device.features;
    if features.vertex_pipeline_stores_and_atomics & features.fragment_stores_and_atomics
        == vk::FALSE
    {
        return Err(GpuError::Unsupported {
            what: format!("debug_value in {name}"),
            missing: "atomics in vertex and fragment shaders".to_owned(),
            device: ctx.info().name.clone(),
        });
    }
    ctx.draws_debug.store(true, Ordering::Relaxed);
    Ok(())
}

/// Makes the Vulkan pipeline of these stages.
fn graphics_pipeline(
    ctx: &Context,
    name: &str,
    stages: &[vk::PipelineShaderStageCreateInfo<'_>],
    layout: vk::PipelineLayout,
    options: RasterOptions,
) -> GpuResult<vk::Pipeline> {
    let vertex_input = vk::PipelineVertexInputStateCreateInfo::default();
    let assembly = assembly_state(options.topology);
    let viewport = vk::PipelineViewportStateCreateInfo::default()
        .viewport_count(1)
        .scissor_count(1);
    let raster = raster_state(options.cull_back_faces);
    let samples = vk::PipelineMultisampleStateCreateInfo::default()
        .rasterization_samples(vk::SampleCountFlags::from_raw(options.samples));
    let depth = depth_state(options);
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
        .stages(stages)
        .vertex_input_state(&vertex_input)
        .input_assembly_state(&assembly)
        .viewport_state(&viewport)
        .rasterization_state(&raster)
        .multisample_state(&samples)
        .depth_stencil_state(&depth)
        .color_blend_state(&blend)
        .dynamic_state(&dynamic)
        .layout(layout)
        .push_next(&mut rendering)];
    // SAFETY: all that `info` points to is alive.
    let made = unsafe {
        ctx.device
            .raw
            .create_graphics_pipelines(ctx.pipeline_cache(), &info, None)
    };
    let made = made
        .map_err(|(_, e)| e)
        .check("vkCreateGraphicsPipelines", name)?;
    Ok(made[0])
}

fn assembly_state(topology: Topology) -> vk::PipelineInputAssemblyStateCreateInfo<'static> {
    vk::PipelineInputAssemblyStateCreateInfo::default().topology(match topology {
        Topology::Triangles => vk::PrimitiveTopology::TRIANGLE_LIST,
        Topology::TriangleStrip => vk::PrimitiveTopology::TRIANGLE_STRIP,
        Topology::Lines => vk::PrimitiveTopology::LINE_LIST,
        Topology::Points => vk::PrimitiveTopology::POINT_LIST,
    })
}

fn raster_state(cull_back_faces: bool) -> vk::PipelineRasterizationStateCreateInfo<'static> {
    vk::PipelineRasterizationStateCreateInfo::default()
        .polygon_mode(vk::PolygonMode::FILL)
        .cull_mode(if cull_back_faces {
            vk::CullModeFlags::BACK
        } else {
            vk::CullModeFlags::NONE
        })
        .front_face(vk::FrontFace::COUNTER_CLOCKWISE)
        .line_width(1.0)
}

fn depth_state(options: RasterOptions) -> vk::PipelineDepthStencilStateCreateInfo<'static> {
    vk::PipelineDepthStencilStateCreateInfo::default()
        .depth_test_enable(options.depth)
        .depth_write_enable(options.depth && options.depth_write)
        .depth_compare_op(match options.depth_test {
            DepthTest::Greatest => vk::CompareOp::GREATER_OR_EQUAL,
            DepthTest::Smallest => vk::CompareOp::LESS,
        })
}

fn blend_state(blend: Blend) -> vk::PipelineColorBlendAttachmentState {
    let operation = match blend {
        Blend::Max => vk::BlendOp::MAX,
        _ => vk::BlendOp::ADD,
    };
    // The maximum has no factors.
    let (source, target) = match blend {
        Blend::Add => (vk::BlendFactor::ONE, vk::BlendFactor::ONE),
        _ => (
            vk::BlendFactor::SRC_ALPHA,
            vk::BlendFactor::ONE_MINUS_SRC_ALPHA,
        ),
    };
    vk::PipelineColorBlendAttachmentState::default()
        .color_blend_op(operation)
        .alpha_blend_op(operation)
        .color_write_mask(vk::ColorComponentFlags::RGBA)
        .blend_enable(blend != Blend::Opaque)
        .src_color_blend_factor(source)
        .src_alpha_blend_factor(vk::BlendFactor::ONE)
        .dst_color_blend_factor(target)
        .dst_alpha_blend_factor(target)
}

pub(crate) fn no_rendering(ctx: &Context, what: &str) -> GpuError {
    GpuError::Unsupported {
        what: format!("drawing {what}"),
        missing: "VK_KHR_dynamic_rendering on a queue with graphics".to_owned(),
        device: ctx.info().name.clone(),
    }
}
