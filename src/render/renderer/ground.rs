//! The ground under a scene, and the soft shadow on it where objects come near: they are drawn from below into a small square, as
//! the share of the sky that each place loses, and that is blurred.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::Renderer;
use crate::gpu::{
    Access, Buffer, Context, DepthTest, Format, GpuError, Image, Pipeline, RasterOptions,
    RasterPipeline, Recorder, Targets, Texels, Threads,
};
use crate::render::view::Ground;
use crate::sim::State;
use crate::sim::draws::{FootprintArgs, FootprintDraw, FootprintParams};
use crate::sim::kernels::{Soften, SoftenArgs, SoftenConstants, SoftenParams};
use crate::sim::types::Pose;

/// Cells along a side of the square; as in `shaders/include/ground.glsl`.
pub const SIDE: u32 = 128;
/// Half the square's side, in radii of the ground.
const EXTENT: f32 = 2.0;
/// Cells between those that are read, of one blur after the other.
const BLURS: [u32; 2] = [1, 2];
/// Weights of `shaders/soften.comp`.
const WEIGHTS: [f32; 7] = [
    0.160_834, 0.148_467, 0.116_788, 0.078_288, 0.044_720, 0.021_768, 0.009_029,
];

/// Twin of `shaders/soften.comp`, after the words were turned into shares.
#[must_use]
pub fn soften(is_down: bool, apart: u32, shadow: &[f32]) -> Vec<f32> {
    let side = SIDE as usize;
    let pace = if is_down { side } else { 1 };
    (0..side * side)
        .map(|i| {
            let place = if is_down { i / side } else { i % side };
            let mut sum = shadow[i] * WEIGHTS[0];
            for (k, weight) in WEIGHTS.iter().enumerate().skip(1) {
                let steps = k * apart as usize;
                let before = if place >= steps {
                    shadow[i - steps * pace]
                } else {
                    0.0
                };
                let after = if place + steps < side {
                    shadow[i + steps * pace]
                } else {
                    0.0
                };
                sum += (before + after) * weight;
            }
            sum
        })
        .collect()
}

/// A shadow of another moment is of these.
#[derive(Clone, Debug, PartialEq)]
struct Cast {
    ground: Ground,
    poses: Vec<Pose>,
}

/// The shadow on the ground.
pub(super) struct Shadow {
    footprint: RasterPipeline<FootprintDraw>,
    first: Pipeline<Soften>,
    soften: Pipeline<Soften>,
    image: Image,
    depth: Image,
    words: Buffer<u32>,
    word_cells: Texels<u32>,
    /// The one that pictures read, and one to blur between.
    shadows: [Buffer<f32>; 2],
    cast: Option<Cast>,
}

impl Shadow {
    pub fn new(ctx: &Arc<Context>) -> Result<Self, GpuError> {
        let format = Format::Rgba8;
        let size = [SIDE, SIDE];
        let count = (SIDE * SIDE) as usize;
        let options = RasterOptions {
            color: format,
            ..RasterOptions::default()
        };
        let words = Buffer::zeroed(ctx, "ground.words", count)?;
        let shadows = [
            Buffer::zeroed(ctx, "ground.shadow", count)?,
            Buffer::zeroed(ctx, "ground.blurred", count)?,
        ];
        Ok(Self {
            footprint: RasterPipeline::new(ctx, &(), options)?,
            first: Pipeline::new(ctx, &SoftenConstants { is_first: true })?,
            soften: Pipeline::new(ctx, &SoftenConstants { is_first: false })?,
            image: Image::new(ctx, "ground.footprint", size, format, 1)?,
            depth: Image::new(ctx, "ground.depth", size, Format::Depth32, 1)?,
            word_cells: Texels::new(&words, 1)?,
            words,
            shadows,
            cast: None,
        })
    }

    /// Half the square's side under a ground, world units.
    pub fn extent(ground: &Ground) -> f32 {
        EXTENT * ground.radius
    }

    /// What pictures read.
    pub fn buffer(&self) -> &Buffer<f32> {
        &self.shadows[0]
    }

    fn blur(&self, rec: &mut Recorder) {
        let (mut from, mut is_first) = (0, true);
        for apart in BLURS {
            for is_down in [0, 1] {
                let pipeline = if is_first { &self.first } else { &self.soften };
                let args = SoftenArgs {
                    footprint: &self.word_cells,
                    shadow: &self.shadows[from],
                    softened: &self.shadows[1 - from],
                };
                let params = SoftenParams {
                    cell_count: SIDE * SIDE,
                    is_down,
                    apart,
                };
                rec.dispatch(pipeline, Threads(SIDE * SIDE), args, params);
                (from, is_first) = (1 - from, false);
            }
        }
        assert_eq!(from, 0, "an even number of blurs ends where pictures read");
    }
}

impl Shadow {
    /// It is drawn again before the next picture that shows it.
    pub(super) fn forget(&mut self) {
        self.cast = None;
    }
}

impl Renderer {
    /// Records the shadow on the ground, unless it is there already; `poses` are those on the device.
    pub(super) fn cast_shadow(
        &mut self,
        rec: &mut Recorder,
        state: &State,
        ground: Ground,
        poses: Vec<Pose>,
    ) {
        let cast = Some(Cast { ground, poses });
        let shadow = &mut self.shadow;
        if shadow.cast == cast {
            return;
        }
        shadow.cast = cast;
        rec.make_visible(Access::Vertex, &[&state.objects.poses]);
        let targets = Targets {
            color: &shadow.image,
            resolve: None,
            depth: Some(&shadow.depth),
            depth_test: DepthTest::Greatest,
            clear: Some([0.0; 4]),
        };
        rec.pass("shadow", &targets, |pass| {
            pass.draw(
                &shadow.footprint,
                self.shape.corner_count,
                1,
                FootprintArgs {
                    corners: &state.surface.corners,
                    vertices: &state.surface.vertices,
                    poses: &state.objects.poses.texels,
                },
                FootprintParams {
                    middle: Vec2::new(ground.middle.x, ground.middle.z),
                    extent: Shadow::extent(&ground),
                    ground: ground.height,
                },
            );
        });
        rec.copy_image(&shadow.image, &shadow.words);
        shadow.blur(rec);
    }
}

/// The place of the ground's middle on it.
pub(super) fn middle(ground: &Ground) -> Vec3 {
    ground.middle.with_y(ground.height)
}
