//! Draws a simulation: the lit surface with its trail, particles, the unwrapped atlas.
//!
//! Shaders write linear light; the images of a [`Canvas`] are of an sRGB format, which encodes it, once. Geometry is
//! pulled from the simulation's own buffers; the renderer adds only what pictures need, such as smooth normals.

use std::sync::Arc;

use glam::{Vec2, Vec3, Vec4};

use super::camera::Camera;
use super::charts;
use super::colormap;
use super::exposure::{self, Exposure};
use super::normals::{CREASE_ANGLE, corner_normals, pack_normal};
use super::view::View;
use crate::gpu::{
    Access, Blend, Buffer, Context, DepthTest, Domain, Format, GpuError, Image, PassRecorder,
    Pipeline, RasterOptions, RasterPipeline, Recorder, Targets, Texels, Threads, Topology,
};
use crate::scene::settings::{ColorMap, Show};
use crate::sim::draws::{
    AtlasViewArgs, AtlasViewConstants, AtlasViewDraw, AtlasViewParams, BackgroundDraw,
    BackgroundParams, ParticlesArgs, ParticlesDraw, ParticlesParams, SurfaceArgs, SurfaceConstants,
    SurfaceDraw, SurfaceParams,
};
use crate::sim::kernels::{
    Expose, ExposeArgs, ExposeParams, TrailHistogram, TrailHistogramArgs, TrailHistogramConstants,
    TrailHistogramParams,
};
use crate::sim::texel_paths::TexelPaths;
use crate::sim::{Setup, State};

/// Samples a pixel, where the device has them.
const SAMPLES: u32 = 4;
/// Light that the trail sends out itself, as a share of its colour.
const GLOW: f32 = 0.34;
/// How much of the trail is shown under particles, so that they stand out.
const TRAIL_UNDER_PARTICLES: f32 = 0.0;
/// From the eye, where the key light comes from: right, up, backward.
const KEY_FROM_EYE: Vec3 = Vec3::new(-0.55, 0.75, 0.65);

/// The images that a picture is drawn into.
pub struct Canvas {
    /// What is drawn into; several samples a pixel, where the device has them.
    color: Image,
    /// One sample a pixel, if `color` has more.
    resolved: Option<Image>,
    depth: Image,
}

impl Canvas {
    /// Images of `size` pixels, each side at least 1, with smooth edges where the device has several samples a pixel.
    ///
    /// # Errors
    /// When the device has no images of that size, or no memory for them.
    pub fn new(ctx: &Arc<Context>, size: [u32; 2], format: Format) -> Result<Self, GpuError> {
        Self::with_quality(ctx, size, format, Quality::Smooth)
    }

    /// The same, at the price that `quality` says.
    ///
    /// # Errors
    /// As for [`Canvas::new`].
    pub fn with_quality(
        ctx: &Arc<Context>,
        size: [u32; 2],
        format: Format,
        quality: Quality,
    ) -> Result<Self, GpuError> {
        let samples = quality.samples(ctx);
        let resolved = match samples {
            1 => None,
            _ => Some(Image::new(ctx, "picture.resolved", size, format, 1)?),
        };
        Ok(Self {
            color: Image::new(ctx, "picture.color", size, format, samples)?,
            depth: Image::new(ctx, "picture.depth", size, Format::Depth32, samples)?,
            resolved,
        })
    }

    /// Width and height, pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.color.size()
    }

    /// The finished picture, one sample a pixel.
    #[must_use]
    pub fn image(&self) -> &Image {
        self.resolved.as_ref().unwrap_or(&self.color)
    }
}

/// What edges cost. On a device that is a CPU, smooth ones take three times as long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    /// One sample a pixel.
    Quick,
    /// Four, or as many as the device has.
    Smooth,
}

impl Quality {
    fn samples(self, ctx: &Context) -> u32 {
        match self {
            Self::Quick => 1,
            Self::Smooth => SAMPLES.min(ctx.info().max_samples),
        }
    }
}

/// The pipelines for canvases with one number of samples.
struct Pipelines {
    samples: u32,
    surface: RasterPipeline<SurfaceDraw>,
    particles: RasterPipeline<ParticlesDraw>,
    background: RasterPipeline<BackgroundDraw>,
    atlas_view: RasterPipeline<AtlasViewDraw>,
}

impl Pipelines {
    fn new(
        ctx: &Arc<Context>,
        format: Format,
        samples: u32,
        texels_in_quads: bool,
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
        Ok(Self {
            samples,
            surface: RasterPipeline::new(ctx, &SurfaceConstants { texels_in_quads }, options)?,
            particles: RasterPipeline::new(ctx, &(), points)?,
            background: RasterPipeline::new(ctx, &(), behind)?,
            atlas_view: RasterPipeline::new(ctx, &AtlasViewConstants { texels_in_quads }, behind)?,
        })
    }
}

/// Draws the simulations of one setup.
pub struct Renderer {
    /// One set for each quality.
    pipelines: Vec<Pipelines>,
    trail_histogram: Pipeline<TrailHistogram>,
    expose: Pipeline<Expose>,
    /// Packed, one for each corner of each triangle.
    normals: Buffer<u32>,
    /// What each texel is, and in which colour its chart is shown.
    texels: Texels<u32>,
    /// The colour and the seams of each triangle.
    charts: Buffer<u32>,
    colors: Buffer<Vec4>,
    colors_are: Option<ColorMap>,
    histogram: Buffer<u32>,
    /// The trail value of the brightest colour, from picture to picture.
    brightest: Buffer<f32>,
    is_first: bool,
    shape: Shape,
}

/// One picture being drawn.
struct Shot<'a> {
    pipelines: &'a Pipelines,
    state: &'a State,
    view: &'a View,
    size: Vec2,
}

/// Sizes of what is drawn.
#[derive(Clone, Copy, Debug)]
struct Shape {
    corner_count: u32,
    particle_count: u32,
    texel_count: u32,
    size: u32,
    pitch: u32,
    radius: f32,
}

impl Renderer {
    /// A renderer for pictures of a setup, on canvases of this format.
    ///
    /// # Errors
    /// When the device cannot draw, or has no memory left.
    pub fn new(ctx: &Arc<Context>, setup: &Setup, format: Format) -> Result<Self, GpuError> {
        let mut samples = [Quality::Quick, Quality::Smooth]
            .map(|quality| quality.samples(ctx))
            .to_vec();
        samples.dedup();
        let texel_count = setup.atlas.texel_count() as u64;
        let texels_in_quads = TexelPaths::of(ctx.info(), texel_count).in_quads;
        let pipelines = samples
            .into_iter()
            .map(|samples| Pipelines::new(ctx, format, samples, texels_in_quads));
        let normals = corner_normals(&setup.surface, CREASE_ANGLE);
        let normals: Vec<u32> = normals.into_iter().map(pack_normal).collect();
        let (surface, atlas) = (&setup.surface, &setup.atlas);
        let chart_colors = charts::chart_colors(surface, atlas);
        let texels = charts::texel_words(surface, atlas, &chart_colors);
        let triangles = charts::triangle_words(surface, atlas, &chart_colors);
        Ok(Self {
            pipelines: pipelines.collect::<Result<_, _>>()?,
            trail_histogram: Pipeline::new(ctx, &TrailHistogramConstants { texels_in_quads })?,
            expose: Pipeline::new(ctx, &())?,
            normals: Buffer::from_slice(ctx, "normals", &normals)?,
            texels: Texels::new(
                &Buffer::from_slice_in(ctx, "texels", &texels, Domain::Texels)?,
                if texels_in_quads { 4 } else { 1 },
            )?,
            charts: Buffer::from_slice(ctx, "charts", &triangles)?,
            colors: Buffer::zeroed(ctx, "colors", colormap::LENGTH)?,
            colors_are: None,
            histogram: Buffer::zeroed(ctx, "histogram", exposure::BIN_COUNT as usize)?,
            brightest: Buffer::from_slice(ctx, "brightest", &[1.0])?,
            is_first: true,
            shape: Shape {
                corner_count: setup.corners.len() as u32,
                particle_count: setup.particles.len() as u32,
                texel_count: atlas.density.len() as u32,
                size: atlas.size,
                pitch: atlas.pitch,
                radius: setup.radius,
            },
        })
    }

    /// Records a picture of the simulation as it is after the last step recorded.
    pub fn draw(&mut self, rec: &mut Recorder, state: &State, view: &View, canvas: &Canvas) {
        rec.scope("picture", |rec| {
            self.prepare(rec, state, view);
            let trail = &state.trail.front;
            rec.barrier(
                Access::Kernel,
                Access::Vertex,
                &[trail, &state.particles, &self.brightest, &state.poses],
            );
            let targets = Targets {
                color: &canvas.color,
                resolve: canvas.resolved.as_ref(),
                depth: Some(&canvas.depth),
                depth_test: DepthTest::Greatest,
                clear: Some([0.0, 0.0, 0.0, 1.0]),
            };
            let [width, height] = canvas.size();
            let size = Vec2::new(width as f32, height as f32);
            let samples = canvas.color.samples();
            let pipelines = self.pipelines.iter().find(|set| set.samples == samples);
            let shot = Shot {
                pipelines: pipelines.expect("canvases come in the qualities that renderers have"),
                state,
                view,
                size,
            };
            rec.pass("draw", &targets, |pass| match view.show {
                Show::Atlas => self.draw_atlas(pass, &shot),
                Show::Surface => self.draw_surface(pass, &shot, 1.0),
                Show::Particles => {
                    self.draw_surface(pass, &shot, TRAIL_UNDER_PARTICLES);
                    self.draw_particles(pass, &shot);
                }
            });
            // The next steps and the next picture write over what was read.
            rec.barrier(
                Access::Vertex,
                Access::Kernel,
                &[trail, &state.particles, &self.brightest, &state.poses],
            );
        });
    }

    /// Colours and exposure.
    fn prepare(&mut self, rec: &mut Recorder, state: &State, view: &View) {
        if self.colors_are != Some(view.color_map) {
            self.colors_are = Some(view.color_map);
            rec.barrier(Access::Vertex, Access::Copy, &[&self.colors]);
            rec.update(&self.colors, 0, &view.color_map.table());
            rec.barrier(Access::Copy, Access::Vertex, &[&self.colors]);
        }
        match view.exposure {
            Exposure::Fixed(brightest) => {
                rec.barrier(Access::Kernel, Access::Copy, &[&self.brightest]);
                rec.fill(&self.brightest, brightest.max(f32::MIN_POSITIVE).to_bits());
                rec.barrier(Access::Copy, Access::Kernel, &[&self.brightest]);
                rec.barrier(Access::Copy, Access::Vertex, &[&self.brightest]);
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
                        trail: &state.trail.front_views.texels,
                        density: &state.density_views.texels,
                        histogram: &self.histogram,
                    },
                    TrailHistogramParams {
                        sample_count,
                        stride,
                    },
                );
                rec.barrier(Access::Kernel, Access::Kernel, &[&self.histogram]);
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
                        // The first picture has nothing to follow.
                        adaptation: if self.is_first { 1.0 } else { adaptation },
                    },
                );
                rec.barrier(
                    Access::Kernel,
                    Access::Kernel,
                    &[&self.histogram, &self.brightest],
                );
            }
        }
        self.is_first = false;
    }

    fn draw_surface(&self, pass: &mut PassRecorder<'_>, shot: &Shot<'_>, trail_share: f32) {
        let Shot {
            state, view, size, ..
        } = *shot;
        let camera = &view.camera;
        pass.draw(
            &shot.pipelines.surface,
            self.shape.corner_count,
            1,
            SurfaceArgs {
                corners: &state.corners,
                vertices: &state.vertices,
                normals: &self.normals,
                atlas_maps: &state.atlas_maps,
                poses: &state.poses,
                trail: &state.trail.front_views.texels,
                colors: &self.colors,
                brightest: &self.brightest,
                charts: &self.charts,
            },
            SurfaceParams {
                clip_from_world: camera.clip_from_world(size),
                eye: camera.eye(),
                trail_share: trail_share * view.trail_over_charts(),
                key_direction: key_direction(camera),
                glow: GLOW,
                size: self.shape.size,
                pitch: self.shape.pitch,
                chart_share: view.charts_under_trail(),
            },
        );
        // Last, because then it fills only the pixels that nothing covers.
        let params = BackgroundParams {
            color: view.background_light(),
            aspect: size.x / size.y,
        };
        pass.draw(&shot.pipelines.background, 3, 1, (), params);
    }

    fn draw_particles(&self, pass: &mut PassRecorder<'_>, shot: &Shot<'_>) {
        let Shot {
            state, view, size, ..
        } = *shot;
        let camera = &view.camera;
        let stride = self.particle_stride(view);
        let drawn = self.particles_drawn(view);
        pass.draw(
            &shot.pipelines.particles,
            drawn,
            1,
            ParticlesArgs {
                particles: &state.particles_view,
                corners: &state.corners,
                vertices: &state.vertices,
                poses: &state.poses,
                colors: &self.colors,
            },
            ParticlesParams {
                clip_from_world: camera.clip_from_world(size),
                eye: camera.eye(),
                lift: 0.003 * self.shape.radius
                    + view.particle_size * world_per_pixel(camera, size),
                diameter: view.particle_size.max(1.0),
                strength: particle_strength(drawn, self.shape.radius, view, size),
                stride,
            },
        );
    }

    /// How many particles a picture with this view has, if it shows particles.
    #[must_use]
    pub fn particles_drawn(&self, view: &View) -> u32 {
        self.shape
            .particle_count
            .div_ceil(self.particle_stride(view))
    }

    fn particle_stride(&self, view: &View) -> u32 {
        self.shape
            .particle_count
            .div_ceil(view.most_particles.max(1))
            .max(1)
    }

    fn draw_atlas(&self, pass: &mut PassRecorder<'_>, shot: &Shot<'_>) {
        let Shot {
            state, view, size, ..
        } = *shot;
        pass.draw(
            &shot.pipelines.atlas_view,
            3,
            1,
            AtlasViewArgs {
                trail: &state.trail.front_views.texels,
                texels: &self.texels,
                colors: &self.colors,
                brightest: &self.brightest,
            },
            AtlasViewParams {
                origin: view.atlas.origin(self.shape.size, size),
                texels_per_pixel: view.atlas.texels_per_pixel(self.shape.size, size),
                trail_share: view.trail_over_charts(),
                chart_share: view.charts_under_trail(),
                size: self.shape.size,
                pitch: self.shape.pitch,
            },
        );
    }
}

/// World units that a pixel covers at the target's distance.
fn world_per_pixel(camera: &Camera, size: Vec2) -> f32 {
    2.0 * camera.distance * (0.5 * camera.vertical_fov).tan() / size.y
}

/// Light of one point, such that a crowd of usual density is bright and does not burn out.
fn particle_strength(drawn: u32, radius: f32, view: &View, size: Vec2) -> f32 {
    let radius_in_pixels = radius / world_per_pixel(&view.camera, size);
    let area = (std::f32::consts::PI * radius_in_pixels * radius_in_pixels).max(1.0);
    // Half of them are on the far side.
    let points_in_a_pixel = 0.5 * drawn as f32 * view.particle_size * view.particle_size / area;
    (0.18 / points_in_a_pixel.max(1e-6)).clamp(0.03, 0.8)
}

/// Where the key light comes from, in world space: it moves with the camera, so that what is seen is lit.
fn key_direction(camera: &Camera) -> Vec3 {
    let Vec3 { x, y, z } = KEY_FROM_EYE;
    (x * camera.right() + y * camera.up() + z * camera.backward()).normalize()
}
