//! Draws a simulation: the lit surface with its trail, particles, the other views, the unwrapped atlas.
//!
//! Shaders write linear light; the images of a [`Canvas`] are of an sRGB format, which encodes it, once. Geometry is
//! pulled from the simulation's own buffers; the renderer adds only data for pictures, such as smooth normals, and for quick pictures
//! shared vertices.

mod fields;
mod foods;
pub mod ground;
mod painted;
mod particles;
mod sides;
mod surface;

use std::ops::Range;
use std::sync::Arc;

use glam::{Vec2, Vec3, Vec4};

use super::camera::Camera;
pub use super::canvas::{Canvas, Quality};
use super::colormap;
use super::develop::{Developer, Development};
use super::exposure::{self, Exposure};
use super::prepared::Prepared;
use super::shared_vertices::SharedVertices;
use super::view::View;
use crate::gpu::{
    Access, AnyBuffer, Blend, Buffer, Context, DepthTest, Domain, Fate, Fates, Format, GpuError,
    Interface, PassRecorder, Pipeline, RasterOptions, RasterPipeline, Readback, Recorder, Tables,
    Targets, Threads, Topology,
};
use crate::scene::settings::{ColorMap, Part};
use crate::sim::draws::{
    AtlasViewArgs, AtlasViewConstants, AtlasViewDraw, AtlasViewParams, BackgroundArgs,
    BackgroundDraw, BackgroundParams, FieldsConstants, FieldsDraw, FoodsDraw, PaintedDraw,
    ParticlesDraw, QuickSurfaceConstants, QuickSurfaceDraw, SurfaceConstants, SurfaceDraw,
};
use crate::sim::kernels::{
    DrawOrder, Expose, ExposeArgs, ExposeParams, TrailHistogram, TrailHistogramArgs,
    TrailHistogramConstants, TrailHistogramParams,
};
use crate::sim::texel_paths::TexelPaths;
use crate::sim::texture::Texture;
use crate::sim::types::Pose;
use crate::sim::{Setup, State, memory};
use fields::Field;
use ground::Shadow;
use sides::Sides;
use surface::Lighting;

/// The pipelines for canvases with one number of samples.
struct Pipelines {
    samples: u32,
    surface: Sides<SurfaceDraw>,
    /// The surface without relief and charts.
    plain_surface: Sides<SurfaceDraw>,
    /// The second look, without relief and with it, laid over the surface.
    second_looks: [Sides<SurfaceDraw>; 2],
    /// The surface from shared vertices. With several samples per pixel, the shading point may lie beside the triangle, and the
    /// shader needs the triangle's own corners to move it back.
    quick_surface: Option<Sides<QuickSurfaceDraw>>,
    fields: Sides<FieldsDraw>,
    particles: RasterPipeline<ParticlesDraw>,
    /// Particles in the hues of headings, blended so that they do not add up to white.
    headings: RasterPipeline<ParticlesDraw>,
    background: RasterPipeline<BackgroundDraw>,
    /// The unwrapped texture, and the second look, laid over it.
    atlas_view: RasterPipeline<AtlasViewDraw>,
    second_atlas_view: RasterPipeline<AtlasViewDraw>,
    painted: RasterPipeline<PaintedDraw>,
    foods: RasterPipeline<FoodsDraw>,
}

impl Pipelines {
    fn new(
        ctx: &Arc<Context>,
        format: Format,
        samples: u32,
        paths: TexelPaths,
        others: bool,
        tables: Tables,
    ) -> Result<Self, GpuError> {
        let options = RasterOptions {
            color: format,
            samples,
            ..RasterOptions::default()
        };
        let behind = RasterOptions {
            depth_write: false,
            ..options
        };
        let points = RasterOptions {
            topology: Topology::Points,
            blend: Blend::Add,
            ..behind
        };
        let constants = |extras, looks| SurfaceConstants {
            paths,
            extras,
            others,
            looks,
        };
        let surface = |extras| Sides::new(ctx, &constants(extras, false), options);
        let over = RasterOptions {
            blend: Blend::Alpha,
            ..behind
        };
        let second_look = |extras| Sides::new(ctx, &constants(extras, true), over);
        let atlas_view = |looks, options| {
            RasterPipeline::new(ctx, &AtlasViewConstants { paths, looks }, options)
        };
        let quick_surface = QuickSurfaceConstants { paths, others };
        let quick_surface = || Sides::new(ctx, &quick_surface, options);
        Ok(Self {
            painted: painted::pipeline(ctx, format, samples, paths)?,
            foods: foods::pipeline(ctx, format, samples)?,
            samples,
            surface: surface(true)?,
            second_looks: [second_look(false)?, second_look(true)?],
            plain_surface: surface(false)?,
            quick_surface: (samples == 1).then(quick_surface).transpose()?,
            fields: Sides::new(ctx, &FieldsConstants { paths }, options)?,
            particles: RasterPipeline::over(ctx, &(), points, tables)?,
            headings: RasterPipeline::over(
                ctx,
                &(),
                RasterOptions {
                    blend: Blend::Max,
                    ..points
                },
                tables,
            )?,
            background: RasterPipeline::new(ctx, &(), behind)?,
            atlas_view: atlas_view(false, behind)?,
            second_atlas_view: atlas_view(true, over)?,
        })
    }
}

/// Draws the simulations of one setup.
pub struct Renderer {
    /// One set for each quality.
    pipelines: Vec<Pipelines>,
    draw_order: Pipeline<DrawOrder>,
    trail_histogram: Pipeline<TrailHistogram>,
    expose: Pipeline<Expose>,
    developer: Developer,
    shadow: Shadow,
    shared: Option<SharedVertices>,
    /// Packed, one for each corner of each triangle.
    normals: Buffer<u32>,
    /// How much of the sky each corner sees, four to a word.
    openness: Buffer<u32>,
    /// One per object.
    object_colors: Buffer<Vec4>,
    /// The kind of each texel, and the colour of its chart.
    texels: Texture<u32>,
    /// The colour and the seams of each triangle.
    charts: Buffer<u32>,
    colors: Buffer<Vec4>,
    colors_are: Option<(ColorMap, f32)>,
    /// Those of the second look.
    second_colors: Buffer<Vec4>,
    second_colors_are: Option<(ColorMap, f32)>,
    /// The slots of the particles that are drawn.
    order: Buffer<u32>,
    histogram: Buffer<u32>,
    /// The trail value of the brightest colour, kept from picture to picture.
    brightest: Buffer<f32>,
    /// The recording of the first picture.
    first: Option<Fate>,
    /// The recordings that have changed the colours, or the shadow.
    fates: Fates,
    shape: Shape,
    /// Objects that pictures do not show.
    hidden: Vec<bool>,
    /// Bounding boxes of the objects, if no back face can be seen from outside.
    boxes: Option<Vec<[Vec3; 2]>>,
}

/// One picture being drawn.
struct Shot<'a> {
    pipelines: &'a Pipelines,
    state: &'a State,
    view: &'a View,
    lighting: Lighting,
    size: Vec2,
    /// No back face is visible.
    fronts_only: bool,
}

/// Sizes of the drawn data.
#[derive(Clone, Copy, Debug)]
struct Shape {
    corner_count: u32,
    particle_count: u32,
    /// The number of particles that brightness is for.
    usual_count: u32,
    /// Texels that triangles own.
    owned_count: u32,
    texel_count: u32,
    size: u32,
    pitch: u32,
    radius: f32,
}

/// How many particles a picture may have: of more than a storage block can list, only a part is drawn.
fn most_drawn(ctx: &Context, particles: usize) -> usize {
    let limit = ctx.info().max_storage_buffer_range / size_of::<u32>() as u64;
    particles.min(usize::try_from(limit).unwrap_or(usize::MAX))
}

impl Renderer {
    /// A renderer for pictures of a setup, on canvases of this format.
    ///
    /// # Errors
    /// When the device cannot draw, or has no memory left.
    pub fn new(ctx: &Arc<Context>, setup: &Setup, format: Format) -> Result<Self, GpuError> {
        Self::from_prepared(ctx, setup, &Prepared::new(setup), format)
    }

    /// As [`Renderer::new`], with data that the host has prepared before, for example on another thread.
    ///
    /// # Errors
    /// As [`Renderer::new`].
    pub fn from_prepared(
        ctx: &Arc<Context>,
        setup: &Setup,
        prepared: &Prepared,
        format: Format,
    ) -> Result<Self, GpuError> {
        let mut samples = [Quality::Quick, Quality::Smooth]
            .map(|quality| quality.samples(ctx))
            .to_vec();
        samples.dedup();
        let texel_count = setup.atlas.texel_count() as u64;
        let paths = TexelPaths::of(ctx.info(), texel_count);
        let others = setup.poses.len() > 1;
        let tables = memory::tables(ctx.info(), setup.particles.len() as u64);
        let pipelines = samples
            .into_iter()
            .map(|samples| Pipelines::new(ctx, format, samples, paths, others, tables));
        let Prepared {
            shared,
            normals,
            openness,
            object_colors,
            texels,
            charts,
            boxes,
            ..
        } = prepared;
        let atlas = &setup.atlas;
        let owned_count = atlas.density.iter().filter(|d| **d > 0.0).count() as u32;
        let particle_count = setup.particles.len() as u32;
        let usual_count = match setup.population {
            // It may grow until about half of the texels are taken.
            Some(_) => particle_count.min(owned_count / 2),
            None => particle_count,
        };
        let shared = { shared.as_ref() }.map(|shared| SharedVertices::new(ctx, shared));
        Ok(Self {
            shared: shared.transpose()?.flatten(),
            pipelines: pipelines.collect::<Result<_, _>>()?,
            draw_order: Pipeline::over(ctx, &(), DrawOrder::NAME, tables)?,
            trail_histogram: Pipeline::new(ctx, &TrailHistogramConstants { paths })?,
            expose: Pipeline::new(ctx, &())?,
            developer: Developer::new(ctx)?,
            shadow: Shadow::new(ctx)?,
            normals: Buffer::from_slice(ctx, "normals", normals)?,
            openness: Buffer::from_slice(ctx, "openness", openness)?,
            object_colors: Buffer::from_slice(ctx, "object_colors", object_colors)?,
            texels: Texture::new(
                ctx,
                Buffer::from_slice_in(ctx, "texels", texels, Domain::Texels)?,
            )?,
            charts: Buffer::from_slice(ctx, "charts", charts)?,
            colors: Buffer::zeroed(ctx, "colors", colormap::LENGTH)?,
            colors_are: None,
            second_colors: Buffer::zeroed(ctx, "second_colors", colormap::LENGTH)?,
            second_colors_are: None,
            order: Buffer::zeroed(ctx, "order", most_drawn(ctx, setup.particles.len()))?,
            histogram: Buffer::zeroed(ctx, "histogram", exposure::BIN_COUNT as usize)?,
            brightest: Buffer::from_slice(ctx, "brightest", &[1.0])?,
            first: None,
            fates: Fates::default(),
            hidden: Vec::new(),
            boxes: boxes.clone(),
            shape: Shape {
                corner_count: setup.corners.len() as u32,
                particle_count,
                usual_count,
                owned_count,
                texel_count: atlas.density.len() as u32,
                size: atlas.size,
                pitch: atlas.pitch,
                radius: setup.radius,
            },
        })
    }

    /// Pictures do not show these objects from now on, nor particles, food and painted areas on them: one for each object; those
    /// beyond the end are shown. The atlas shows all.
    pub fn hide(&mut self, objects: &[bool]) {
        self.hidden = objects.to_vec();
    }

    /// Records a picture of the simulation as it is after the last step recorded.
    pub fn draw(&mut self, rec: &mut Recorder, state: &State, view: &View, canvas: &Canvas) {
        let rows = 0..canvas.size()[1];
        self.draw_rows(rec, state, view, canvas, rows);
    }

    /// Records some rows of it; the others keep what they have.
    ///
    /// # Panics
    /// If the canvas does not have these rows.
    pub fn draw_rows(
        &mut self,
        rec: &mut Recorder,
        state: &State,
        view: &View,
        canvas: &Canvas,
        rows: Range<u32>,
    ) {
        self.draw_pictures(rec, state, &[(*view, canvas, rows)]);
    }

    /// Records several pictures of the same moment, with the exposure of the first view.
    pub fn draw_beside(&mut self, rec: &mut Recorder, state: &State, pictures: &[(View, &Canvas)]) {
        let pictures = pictures.iter().copied();
        let whole = pictures.map(|(view, canvas)| (view, canvas, 0..canvas.size()[1]));
        self.draw_pictures(rec, state, &whole.collect::<Vec<_>>());
    }

    /// The same in bands of rows, so many a picture. In a recording that is [in slices](Recorder::slice) each is one, so that other
    /// frames may come in between; they must not use these canvases.
    pub fn draw_in_bands(
        &mut self,
        rec: &mut Recorder,
        state: &State,
        pictures: &[(View, &Canvas)],
        bands: u32,
    ) {
        let mut all = Vec::new();
        for &(view, canvas) in pictures {
            let [_, height] = canvas.size();
            let edge = |band: u32| (u64::from(height) * u64::from(band) / u64::from(bands)) as u32;
            all.extend((0..bands).map(|band| (view, canvas, edge(band)..edge(band + 1))));
        }
        all.retain(|(.., rows)| !rows.is_empty());
        self.draw_pictures(rec, state, &all);
    }

    fn draw_pictures(
        &mut self,
        rec: &mut Recorder,
        state: &State,
        pictures: &[(View, &Canvas, Range<u32>)],
    ) {
        rec.scope("picture", |rec| {
            let Some((first, ..)) = pictures.first() else {
                return;
            };
            self.prepare(rec, state, first);
            self.prepare_ground(rec, state, first);
            rec.make_visible(Access::Vertex, &self.read(state));
            for (view, canvas, rows) in pictures {
                self.draw_one(rec, state, view, canvas, rows.clone());
                rec.end_slice();
            }
        });
    }

    /// Buffers that the simulation writes and pictures read.
    fn read<'a>(&'a self, state: &'a State) -> Vec<&'a dyn AnyBuffer> {
        let mut read: Vec<&dyn AnyBuffer> = vec![
            &state.trail.front,
            &state.deposits.back,
            &state.near.distances,
            &state.near.nearest,
            &state.particles,
            &state.motions,
            &self.brightest,
            &self.colors,
            &state.objects.poses,
            self.shadow.buffer(),
        ];
        // Painting between steps writes it.
        if let Some(bias) = &state.bias {
            read.push(bias);
        }
        if let Some(food) = &state.food {
            read.push(&food.meals);
        }
        if let Some(looks) = &state.looks {
            read.extend([&**looks as &dyn AnyBuffer, &self.second_colors]);
        }
        read
    }

    fn draw_one(
        &self,
        rec: &mut Recorder,
        state: &State,
        view: &View,
        canvas: &Canvas,
        rows: Range<u32>,
    ) {
        let targets = Targets {
            color: &canvas.color,
            resolve: canvas.resolved.as_ref(),
            depth: Some(&canvas.depth),
            depth_test: DepthTest::Greatest,
            clear: Some([0.0, 0.0, 0.0, f32::from(!view.is_transparent)]),
        };
        let [width, height] = canvas.size();
        let is_whole = rows.end == height;
        let size = Vec2::new(width as f32, height as f32);
        let samples = canvas.color.samples();
        let pipelines = self.pipelines.iter().find(|set| set.samples == samples);
        let shot = Shot {
            pipelines: pipelines.expect("canvases come in the qualities that renderers have"),
            state,
            view,
            lighting: Lighting::of(view.show),
            size,
            fronts_only: (self.boxes.as_ref()).is_some_and(|boxes| {
                sides::is_outside(&view.camera, size, boxes, &state.objects.recorded)
            }),
        };
        let has_points = view.show.has(Part::Points);
        if has_points {
            self.order_particles(rec, state, view);
        }
        // Without other objects, and before the first step, there are no distances to be read.
        let has_all = !view.show.has(Part::Distances) || state.near.reach > 0.0;
        let field = Field::of(view.show).filter(|_| has_all);
        let hides = !view.show.is_flat() && self.hidden.contains(&true);
        if hides {
            rec.update_long(&state.objects.poses, &self.poses_seen(state, view));
            rec.make_visible(Access::Vertex, &[&state.objects.poses]);
        }
        rec.pass_rows("draw", &targets, rows, |pass| {
            if view.show.is_flat() {
                return self.draw_atlas(pass, &shot);
            }
            match field {
                Some(field) => self.draw_fields(pass, &shot, field),
                None => {
                    self.draw_surface(pass, &shot);
                    self.draw_second_look(pass, &shot);
                }
            }
            // Painted areas and food are shown in every view of the surface.
            self.draw_painted(pass, &shot);
            Self::draw_foods(pass, &shot);
            self.draw_background(pass, &shot);
            if has_points {
                self.draw_particles(pass, &shot);
            }
        });
        if hides {
            rec.update_long(&state.objects.poses, &state.objects.recorded);
        }
        if let Some(darkroom) = canvas.darkroom.as_ref().filter(|_| is_whole) {
            let is_lit = field.is_none() && !view.show.is_flat();
            let how = Development {
                bloom: shot.lighting.bloom(view.bloom).filter(|_| !view.is_plain),
                is_opaque: is_lit && !view.is_transparent,
                smooths: !view.show.is_flat() && !view.is_plain,
            };
            self.developer.record(rec, canvas.drawn(), darkroom, how);
        }
    }

    /// The poses of a picture: hidden objects lie in a point behind the eye.
    fn poses_seen(&self, state: &State, view: &View) -> Vec<Pose> {
        let Vec3 { x, y, z } = view.camera.eye() + self.shape.radius * view.camera.backward();
        let behind = Pose {
            x: Vec4::new(0.0, 0.0, 0.0, x),
            y: Vec4::new(0.0, 0.0, 0.0, y),
            z: Vec4::new(0.0, 0.0, 0.0, z),
        };
        let poses = state.objects.recorded.iter().enumerate();
        let seen = poses.map(|(i, pose)| match self.hidden.get(i) {
            Some(true) => behind,
            _ => *pose,
        });
        seen.collect()
    }

    /// Records a copy of the trail value that gets the brightest colour in the pictures recorded so far.
    pub fn record_brightest(&self, rec: &mut Recorder, readback: &mut Readback<f32>, tag: u64) {
        readback.record(rec, &self.brightest, tag);
    }

    /// The number of pixels, in all opaque pictures so far, whose light was not a number, or without end; they are black. Light comes out
    /// so if the trail is.
    #[must_use]
    pub fn flaws(&self) -> &Buffer<u32> {
        &self.developer.flaws
    }

    /// If a recording was dropped, what it was to write to the device is not there.
    fn take_back_what_was_dropped(&mut self) {
        if self.fates.take_dropped() {
            (self.colors_are, self.second_colors_are) = (None, None);
            self.shadow.forget();
        }
    }

    /// Colours and exposure.
    fn prepare(&mut self, rec: &mut Recorder, state: &State, view: &View) {
        self.take_back_what_was_dropped();
        self.fates.note(&rec.fate);
        let is_first = self.first.as_ref().is_none_or(Fate::was_dropped);
        if is_first {
            self.first = Some(rec.fate.clone());
        }
        let colors = (view.color_map, view.darkest);
        if self.colors_are != Some(colors) {
            self.colors_are = Some(colors);
            rec.update(&self.colors, 0, &view.color_map.table(view.darkest));
        }
        let second = view.second_colors.map(|map| (map, view.darkest));
        if let Some((map, darkest)) = second.filter(|_| self.second_colors_are != second) {
            self.second_colors_are = second;
            rec.update(&self.second_colors, 0, &map.table(darkest));
        }
        match view.exposure {
            Exposure::Fixed(brightest) => {
                rec.fill(&self.brightest, brightest.max(f32::MIN_POSITIVE).to_bits());
            }
            Exposure::Auto {
                clipped_share,
                adaptation,
            } => {
                let stride = exposure::stride(self.shape.texel_count);
                let sample_count = self.shape.texel_count.div_ceil(stride);
                rec.dispatch(
                    &self.trail_histogram,
                    Threads(sample_count),
                    TrailHistogramArgs {
                        trail: &state.trail.front,
                        density: &state.atlas.spread.density,
                        histogram: &self.histogram,
                    },
                    TrailHistogramParams {
                        sample_count,
                        stride,
                    },
                );
                rec.dispatch(
                    &self.expose,
                    Threads(1),
                    ExposeArgs {
                        histogram: &self.histogram,
                        brightest: &self.brightest,
                    },
                    ExposeParams {
                        count: 1,
                        clipped_share,
                        // The first picture has no earlier exposure to follow.
                        adaptation: if is_first { 1.0 } else { adaptation },
                    },
                );
            }
        }
    }

    /// The shadow on the ground, if this view shows it.
    fn prepare_ground(&mut self, rec: &mut Recorder, state: &State, view: &View) {
        let Some(ground) = view.ground_seen() else {
            return;
        };
        let hides = self.hidden.contains(&true);
        let poses = match hides {
            true => self.poses_seen(state, view),
            false => state.objects.recorded.clone(),
        };
        if hides {
            rec.update_long(&state.objects.poses, &poses);
        }
        self.cast_shadow(rec, state, ground, poses);
        if hides {
            rec.update_long(&state.objects.poses, &state.objects.recorded);
        }
    }

    /// Drawn after the surface, so that it fills only uncovered pixels.
    fn draw_background(&self, pass: &mut PassRecorder<'_>, shot: &Shot<'_>) {
        let (view, size) = (shot.view, shot.size);
        if view.is_transparent {
            return;
        }
        let camera = &view.camera;
        let half = camera.half_sides(size);
        let (right, up) = (half.x * camera.right(), half.y * camera.up());
        let ground = view.ground_seen();
        let middle = ground.as_ref().map_or(Vec3::ZERO, ground::middle);
        let params = BackgroundParams {
            color: shot.lighting.background * view.background_light(),
            aspect: size.x / size.y,
            eye: camera.eye(),
            ground: middle.y,
            right,
            extent: ground.as_ref().map_or(0.0, Shadow::extent),
            up,
            middle_x: middle.x,
            ahead: -camera.backward() - camera.shift.x * right - camera.shift.y * up,
            middle_z: middle.z,
        };
        let args = BackgroundArgs {
            shadow: self.shadow.buffer(),
        };
        pass.draw(&shot.pipelines.background, 3, 1, args, params);
    }

    fn draw_atlas(&self, pass: &mut PassRecorder<'_>, shot: &Shot<'_>) {
        let Shot {
            state, view, size, ..
        } = *shot;
        let params = AtlasViewParams {
            origin: view.atlas.origin(self.shape.size, size),
            texels_per_pixel: view.atlas.texels_per_pixel(self.shape.size, size),
            trail_share: view.trail_over_charts(),
            chart_share: view.charts_under_trail(),
            size: self.shape.size,
            pitch: self.shape.pitch,
        };
        let trail = &state.trail.front;
        let args = AtlasViewArgs {
            trail,
            charts: &self.texels,
            colors: &self.colors,
            brightest: &self.brightest,
            // Only the second look reads weights.
            looks: trail,
        };
        pass.draw(&shot.pipelines.atlas_view, 3, 1, args, params);
        if let (Some(looks), Some(_)) = (&state.looks, view.second_colors) {
            let args = AtlasViewArgs {
                colors: &self.second_colors,
                looks,
                ..args
            };
            pass.draw(&shot.pipelines.second_atlas_view, 3, 1, args, params);
        }
    }
}

/// World units that a pixel covers at the target's distance.
fn world_per_pixel(camera: &Camera, size: Vec2) -> f32 {
    2.0 * camera.distance * (0.5 * camera.vertical_fov).tan() / size.y
}
