//! Passes: draws into images.
//!
//! A pass transitions its images to the right layout. Other buffers that its draws read, and that were written since the last pass, must be
//! named by [`Recorder::make_visible`] before it begins: to [`Access::Vertex`] for shaders, to [`Access::Index`] for indices.

use std::sync::atomic::Ordering;

use ash::{khr, vk};

use super::access::Access;
use super::buffer::{AnyBuffer, Buffer};
use super::buffer_core::BufferCore;
use super::context::Context;
use super::draws::{DepthTest, RasterPipeline, no_rendering};
use super::image::{Format, Image, ImageState};
use super::kernel::Draw;
use super::listing::Listed;
use super::recorder::Recorder;
use super::timer::SpanKind;

/// Vertices that 32-bit indices can address on every device.
const INDEXED_EVERYWHERE: usize = 1 << 24;

/// Can [`PassRecorder::draw_indexed`] address so many vertices?
pub(crate) fn reaches_by_index(ctx: &Context, vertices: usize) -> bool {
    vertices <= INDEXED_EVERYWHERE || ctx.device.features.full_draw_index_uint32 == vk::TRUE
}

/// The images of a pass.
#[derive(Clone, Copy, Debug)]
pub struct Targets<'a> {
    /// The render target.
    pub color: &'a Image,
    /// Takes the mean of the samples at the end, where `color` has several.
    pub resolve: Option<&'a Image>,
    /// Depth, of the same size and number of samples as `color`.
    pub depth: Option<&'a Image>,
    /// The depth test. The depth is cleared to the value that always loses.
    pub depth_test: DepthTest,
    /// Linear colour and alpha that the picture starts with; `None` keeps what is there.
    pub clear: Option<[f32; 4]>,
}

/// Records draws into the targets of a pass.
pub struct PassRecorder<'a> {
    rec: &'a mut Recorder,
    format: Format,
    samples: u32,
    depth: Option<DepthTest>,
    /// Is every draw timed separately?
    times_draws: bool,
    /// Is the pass skipped?
    skips: bool,
}

impl Recorder {
    /// Draws into images. Depth is not kept. That of pictures is reversed, so greater is nearer, which spreads the
    /// precision of floats evenly.
    ///
    /// # Panics
    /// If the targets do not fit each other, or the device cannot draw (then no pipeline could be made either).
    pub fn pass<R>(
        &mut self,
        name: &str,
        targets: &Targets<'_>,
        record: impl FnOnce(&mut PassRecorder<'_>) -> R,
    ) -> R {
        self.pass_as(SpanKind::Scope, name, targets, None, record)
    }

    /// As [`Recorder::pass`], for some rows of the images only; the others keep their content. In this way a large picture can be drawn in
    /// parts, with other work between them.
    ///
    /// # Panics
    /// As [`Recorder::pass`], and if the images do not have these rows.
    pub fn pass_rows<R>(
        &mut self,
        name: &str,
        targets: &Targets<'_>,
        rows: std::ops::Range<u32>,
        record: impl FnOnce(&mut PassRecorder<'_>) -> R,
    ) -> R {
        assert!(
            rows.start < rows.end && rows.end <= targets.color.size()[1],
            "`{}` does not have the rows {rows:?}",
            targets.color.name()
        );
        self.pass_as(SpanKind::Scope, name, targets, Some(rows), record)
    }

    /// As [`Recorder::pass`], but timed as a whole, like a kernel of this name. Devices that draw tile by tile cannot
    /// time single draws.
    ///
    /// # Panics
    /// As [`Recorder::pass`].
    pub fn pass_as_kernel<R>(
        &mut self,
        name: &str,
        targets: &Targets<'_>,
        record: impl FnOnce(&mut PassRecorder<'_>) -> R,
    ) -> R {
        self.pass_as(SpanKind::Kernel, name, targets, None, record)
    }

    /// Brings an image from its last state to `next`; its pixels may be lost unless `keep`.
    ///
    /// # Panics
    /// If it belongs to another context.
    pub(crate) fn transition(&mut self, image: &Image, next: ImageState, keep: bool) {
        image.assert_of(self.ctx());
        let (last, transition) = image.exchange_state(next, self.slices.count);
        self.transitions.push(transition);
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

    fn pass_as<R>(
        &mut self,
        kind: SpanKind,
        name: &str,
        targets: &Targets<'_>,
        rows: Option<std::ops::Range<u32>>,
        record: impl FnOnce(&mut PassRecorder<'_>) -> R,
    ) -> R {
        targets.assert_fitting(self.ctx());
        let takes_place = match kind {
            SpanKind::Kernel => self.admits_kernel(name, Vec::new()),
            _ => !self.skips(),
        };
        if takes_place {
            self.begin_pass(kind, name, targets, rows);
        }
        let result = record(&mut PassRecorder {
            rec: self,
            format: targets.color.format(),
            samples: targets.color.samples(),
            depth: targets.depth.map(|_| targets.depth_test),
            times_draws: takes_place && kind == SpanKind::Scope,
            skips: !takes_place,
        });
        if takes_place {
            self.end_pass(name);
        }
        result
    }

    /// Records everything of a pass that comes before its draws.
    fn begin_pass(
        &mut self,
        kind: SpanKind,
        name: &str,
        targets: &Targets<'_>,
        rows: Option<std::ops::Range<u32>>,
    ) {
        // Inside a pass there can be no breadcrumb, no entry of the debug list and no barrier.
        self.settle_order();
        if kind == SpanKind::Kernel {
            self.separate_pass();
        }
        self.leave_crumb(name);
        self.list_entry(|| Listed::Work(name.to_owned()));
        if self.ctx().draws_debug.load(Ordering::Relaxed) {
            self.announce_debug(name);
        }
        self.begin_span(name, kind);
        let keeps = rows.is_some();
        let keeps_color = keeps || targets.clear.is_none();
        self.transition(targets.color, ImageState::COLOR_TARGET, keeps_color);
        if let Some(resolve) = targets.resolve {
            self.transition(resolve, ImageState::COLOR_TARGET, keeps);
        }
        if let Some(depth) = targets.depth {
            self.transition(depth, ImageState::DEPTH_TARGET, false);
        }
        self.begin_rendering(name, targets, rows);
        self.is_in_pass = true;
    }

    /// Begins rendering into all rows of the targets, or only into these.
    fn begin_rendering(
        &self,
        name: &str,
        targets: &Targets<'_>,
        rows: Option<std::ops::Range<u32>>,
    ) {
        let attachments = [targets.color_attachment()];
        let depth_attachment = targets.depth_attachment();
        let [width, height] = targets.color.size();
        let rows = rows.unwrap_or(0..height);
        let area = vk::Rect2D {
            offset: vk::Offset2D {
                x: 0,
                y: rows.start as i32,
            },
            extent: vk::Extent2D {
                width,
                height: rows.len() as u32,
            },
        };
        let mut rendering = vk::RenderingInfo::default()
            .render_area(area)
            .layer_count(1)
            .color_attachments(&attachments);
        if let Some(depth_attachment) = &depth_attachment {
            rendering = rendering.depth_attachment(depth_attachment);
        }
        let viewport = vk::Viewport {
            x: 0.0,
            y: 0.0,
            width: width as f32,
            height: height as f32,
            min_depth: 0.0,
            max_depth: 1.0,
        };
        let loader = self.dynamic_rendering(name);
        // SAFETY: the images are alive and freed only after this frame; `begin_pass` has set their layouts.
        unsafe {
            loader.cmd_begin_rendering(self.raw(), &rendering);
            self.device().cmd_set_viewport(self.raw(), 0, &[viewport]);
            self.device().cmd_set_scissor(self.raw(), 0, &[area]);
        }
    }

    /// Records everything of a pass that comes after its draws.
    fn end_pass(&mut self, name: &str) {
        self.is_in_pass = false;
        // SAFETY: `begin_pass` has begun rendering.
        unsafe { self.dynamic_rendering(name).cmd_end_rendering(self.raw()) };
        self.end_span();
        self.ends_alone();
    }

    /// The functions of the device that begin and end a pass.
    fn dynamic_rendering(&self, name: &str) -> &khr::dynamic_rendering::Device {
        let ctx = self.ctx();
        let loader = ctx.device.dynamic_rendering.as_ref();
        loader.unwrap_or_else(|| panic!("{}", no_rendering(ctx, name)))
    }
}

impl PassRecorder<'_> {
    /// Draws `vertices` vertices `instances` times; none records nothing. Shaders fetch what they need by
    /// `gl_VertexIndex` and `gl_InstanceIndex`.
    ///
    /// # Panics
    /// If the pipeline was made for other targets, or a buffer was written and not made visible before the pass.
    pub fn draw<D: Draw>(
        &mut self,
        pipeline: &RasterPipeline<D>,
        vertices: u32,
        instances: u32,
        args: D::Args<'_>,
        params: D::Params,
    ) {
        let is_empty = vertices == 0 || instances == 0;
        self.draw_by(pipeline, is_empty, None, &args, &params, |rec| {
            // SAFETY: `draw_by` has bound pipeline, descriptors and constants for one layout.
            unsafe { rec.device().cmd_draw(rec.raw(), vertices, instances, 0, 0) };
        });
    }

    /// Draws a vertex for each index, which is its `gl_VertexIndex`; devices may do the work of equal ones once.
    ///
    /// # Panics
    /// As [`PassRecorder::draw`], also for the indices, by [`Access::Index`]; if these belong to another context.
    pub fn draw_indexed<D: Draw>(
        &mut self,
        pipeline: &RasterPipeline<D>,
        indices: &Buffer<u32>,
        args: D::Args<'_>,
        params: D::Params,
    ) {
        let core = indices.core();
        core.assert_of(self.rec.ctx());
        let is_empty = indices.is_empty();
        let count = indices.len() as u32;
        let more = Some((core, Access::Index));
        self.draw_by(pipeline, is_empty, more, &args, &params, |rec| {
            let (device, raw) = (rec.device(), rec.raw());
            // SAFETY: as in `draw`; the indices lie in the buffer, which was made for that.
            unsafe {
                device.cmd_bind_index_buffer(raw, core.whole(), 0, vk::IndexType::UINT32);
                device.cmd_draw_indexed(raw, count, 1, 0, 0, 0);
            }
        });
    }

    fn draw_by<D: Draw>(
        &mut self,
        pipeline: &RasterPipeline<D>,
        is_empty: bool,
        more: Option<(&BufferCore, Access)>,
        args: &D::Args<'_>,
        params: &D::Params,
        draw: impl FnOnce(&Recorder),
    ) {
        let options = pipeline.options();
        assert!(
            options.color == self.format
                && options.samples == self.samples
                && options.depth.then_some(options.depth_test) == self.depth,
            "`{}` was made for {:?}, {} samples, depth {:?}; the pass has {:?}, {} samples, depth {:?}",
            D::NAME,
            options.color,
            options.samples,
            options.depth.then_some(options.depth_test),
            self.format,
            self.samples,
            self.depth
        );
        if is_empty || self.skips {
            return;
        }
        self.rec
            .bind::<D>(&pipeline.core, Access::Vertex, more, args, params);
        if self.times_draws {
            self.rec.work(D::NAME, SpanKind::Draw, |rec| draw(rec));
        } else {
            draw(self.rec);
        }
    }

    /// The raw command buffer, inside the pass, for crates that draw by themselves.
    #[must_use]
    pub fn raw(&self) -> vk::CommandBuffer {
        self.rec.raw()
    }
}

impl Targets<'_> {
    /// Panics unless the images fit each other and belong to this context.
    fn assert_fitting(&self, ctx: &Context) {
        let color = self.color;
        for other in self.resolve.iter().chain(&self.depth) {
            assert!(
                other.size() == color.size(),
                "`{}` and `{}` differ in size",
                other.name(),
                color.name()
            );
        }
        for image in self.resolve.iter().chain(&self.depth).chain([&color]) {
            image.assert_of(ctx);
        }
        let samples = self.depth.map_or(color.samples(), Image::samples);
        assert!(
            samples == color.samples(),
            "depth has {samples} samples, `{}` has others",
            color.name()
        );
    }

    /// The render target, and the image that takes the mean of its samples.
    fn color_attachment(&self) -> vk::RenderingAttachmentInfo<'static> {
        let mut attachment = vk::RenderingAttachmentInfo::default()
            .image_view(self.color.view())
            .image_layout(ImageState::COLOR_TARGET.layout)
            .load_op(if self.clear.is_some() {
                vk::AttachmentLoadOp::CLEAR
            } else {
                vk::AttachmentLoadOp::LOAD
            })
            .store_op(vk::AttachmentStoreOp::STORE)
            .clear_value(vk::ClearValue {
                color: vk::ClearColorValue {
                    float32: self.clear.unwrap_or_default(),
                },
            });
        if let Some(resolve) = self.resolve {
            attachment = attachment
                .resolve_mode(vk::ResolveModeFlags::AVERAGE)
                .resolve_image_view(resolve.view())
                .resolve_image_layout(ImageState::COLOR_TARGET.layout);
        }
        attachment
    }

    /// The depth image, cleared to the value that always loses.
    fn depth_attachment(&self) -> Option<vk::RenderingAttachmentInfo<'static>> {
        let depth = self.depth?;
        let attachment = vk::RenderingAttachmentInfo::default()
            .image_view(depth.view())
            .image_layout(ImageState::DEPTH_TARGET.layout)
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .store_op(vk::AttachmentStoreOp::DONT_CARE)
            .clear_value(vk::ClearValue {
                depth_stencil: vk::ClearDepthStencilValue {
                    depth: match self.depth_test {
                        DepthTest::Greatest => 0.0,
                        DepthTest::Smallest => 1.0,
                    },
                    stencil: 0,
                },
            });
        Some(attachment)
    }
}
