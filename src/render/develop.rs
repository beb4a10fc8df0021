//! Development: what happens to a picture after it was drawn. Bright trail blooms, and jagged edges are smoothed.
//!
//! Pictures are drawn through the film curve (`film` in `shaders/include/shading.glsl`) sample by sample, into images of four bytes: then
//! the mean of samples at the edge of something bright is smooth. So the bloom is of what a picture shows, not of unbounded light: the
//! bright part of it, spread by a pyramid of coarser and coarser levels (as Jimenez, "Next Generation Post Processing in Call of Duty",
//! 2014), and added as light behind glass, so that nothing is clipped. All is done by kernels on words of four bytes, which give the
//! same bits on every device.

pub mod twin;

use std::sync::Arc;

use crate::gpu::{
    Buffer, Context, DispatchGroups, Format, GpuError, Image, Kernel as _, Pipeline, Recorder,
    Texels, Threads,
};
use crate::sim::kernels::{
    BloomDown, BloomDownArgs, BloomDownParams, BloomFirst, BloomFirstArgs, BloomFirstParams,
    BloomUp, BloomUpArgs, BloomUpParams, Develop, DevelopArgs, DevelopConstants, DevelopParams,
    SmoothEdges, SmoothEdgesArgs, SmoothEdgesConstants, SmoothEdgesParams,
};

/// The most levels of a bloom: the coarsest has a cell for 128 pixels.
const MOST_LEVELS: usize = 6;
/// The weight of each level against the one that is finer.
pub const LEVEL_WEIGHT: f32 = 0.7;

/// Which light of a picture blooms, and how much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bloom {
    /// Light, 0 to 1, from which on pixels bloom.
    pub threshold: f32,
    /// Over `1 / slope` more they come to bloom wholly.
    pub slope: f32,
    /// The light of the bloom as a share of the light that blooms.
    pub strength: f32,
}

/// One level of a bloom: cells in rows, from an element of the buffer on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level {
    /// Cells in a row.
    pub across: u32,
    /// Rows.
    pub down: u32,
    /// The first element.
    pub first: u32,
}

impl Level {
    /// Its number of cells.
    #[must_use]
    pub fn count(self) -> usize {
        self.across as usize * self.down as usize
    }
}

/// The sizes of what a picture is developed in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Of the picture, pixels.
    pub size: [u32; 2],
    /// Fours of pixels in a row, and cells of the finest level.
    pub across: u32,
    /// Levels of the bloom, at least two, the finest first.
    pub levels: Vec<Level>,
}

impl Shape {
    /// For a picture of `size` pixels, each side at least 1; none if elements of its buffers cannot be counted by 32 bits.
    #[must_use]
    pub fn of(size: [u32; 2]) -> Option<Self> {
        let across = size[0].div_ceil(4);
        (across.checked_mul(4)?).checked_mul(size[1])?;
        let mut levels = vec![Level {
            across,
            down: size[1].div_ceil(4),
            first: 0,
        }];
        loop {
            let fine = levels[levels.len() - 1];
            let is_small = fine.across.min(fine.down) < 4 && levels.len() > 1;
            if is_small || levels.len() == MOST_LEVELS {
                break;
            }
            levels.push(Level {
                across: fine.across.div_ceil(2),
                down: fine.down.div_ceil(2),
                first: fine.first + fine.count() as u32,
            });
        }
        Some(Self {
            size,
            across,
            levels,
        })
    }

    /// Pixels from a row to the next.
    #[must_use]
    pub fn pitch(&self) -> u32 {
        4 * self.across
    }

    /// Pixels, with those at the ends of rows.
    #[must_use]
    pub fn pixel_count(&self) -> usize {
        self.pitch() as usize * self.size[1] as usize
    }

    /// Cells of all levels.
    #[must_use]
    pub fn cell_count(&self) -> usize {
        self.levels.iter().map(|level| level.count()).sum()
    }

    /// The share of all levels' sum that a bloom is.
    #[must_use]
    pub fn share_of_sum(&self) -> f32 {
        let weights = (0..self.levels.len()).map(|k| LEVEL_WEIGHT.powi(k as i32));
        1.0 / weights.sum::<f32>()
    }
}

/// Words of a picture, in the ways that kernels access them.
struct Words {
    buffer: Buffer<u32>,
    quads: Texels<u32>,
    singles: Texels<u32>,
}

impl Words {
    fn new(ctx: &Arc<Context>, name: &str, len: usize) -> Result<Self, GpuError> {
        let buffer = Buffer::zeroed(ctx, name, len)?;
        Ok(Self {
            quads: Texels::new(&buffer, 4)?,
            singles: Texels::new(&buffer, 1)?,
            buffer,
        })
    }
}

/// What one canvas needs to be developed.
pub(super) struct Darkroom {
    /// The developed picture.
    pub image: Image,
    shape: Shape,
    picture: Words,
    developed: Words,
    bloom_cells: Texels<f32>,
    /// Pixels at edges; one element if edges are smooth already.
    edges: Buffer<u32>,
    /// The dispatch over them, and their number.
    groups: Buffer<DispatchGroups>,
    has_edges: bool,
}

impl Darkroom {
    /// For pictures of this size and format; `has_edges` says that their edges are jagged.
    pub fn new(
        ctx: &Arc<Context>,
        size: [u32; 2],
        format: Format,
        has_edges: bool,
    ) -> Result<Self, GpuError> {
        let too_large = || GpuError::Unsupported {
            what: format!("bloom in pictures of {} x {} pixels", size[0], size[1]),
            missing: "buffers of so many pixels".to_owned(),
            device: ctx.info().name.clone(),
        };
        let shape = Shape::of(size).ok_or_else(too_large)?;
        let bloom = Buffer::<f32>::zeroed(ctx, "picture.bloom", 4 * shape.cell_count())?;
        let edge_count = if has_edges { shape.pixel_count() } else { 1 };
        Ok(Self {
            image: Image::new(ctx, "picture.developed", size, format, 1)?,
            picture: Words::new(ctx, "picture.words", shape.pixel_count())?,
            developed: Words::new(ctx, "picture.developed_words", shape.pixel_count())?,
            bloom_cells: Texels::new(&bloom, 4)?,
            edges: Buffer::zeroed(ctx, "picture.edges", edge_count)?,
            groups: Buffer::zeroed(ctx, "picture.edge_groups", 2)?,
            has_edges,
            shape,
        })
    }

    /// Bytes of its buffers for a picture with smooth edges: a word a pixel, drawn and developed, and four a cell of the bloom.
    pub fn buffer_bytes(shape: &Shape) -> u64 {
        4 * (2 * shape.pixel_count() + 4 * shape.cell_count()) as u64
    }
}

/// The pipelines that develop pictures.
pub(super) struct Developer {
    first: Pipeline<BloomFirst>,
    down: Pipeline<BloomDown>,
    up: Pipeline<BloomUp>,
    /// Without bloom and smoothing, with smoothing, with bloom, with both.
    develop: [Pipeline<Develop>; 4],
    /// Without and with bloom.
    smooth: [Pipeline<SmoothEdges>; 2],
    /// Pixels so far whose light was not a number.
    pub flaws: Buffer<u32>,
}

/// What is done to a picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Development {
    pub bloom: Option<Bloom>,
    /// It has no alpha of its own: pixels with less than 255 are marked.
    pub is_opaque: bool,
    /// Its jagged edges, if it has such, are smoothed.
    pub smooths: bool,
}

impl Developer {
    pub fn new(ctx: &Arc<Context>) -> Result<Self, GpuError> {
        let develop = |blooms, smooths| Pipeline::new(ctx, &DevelopConstants { blooms, smooths });
        let smooth = |blooms| Pipeline::new(ctx, &SmoothEdgesConstants { blooms });
        Ok(Self {
            first: Pipeline::new(ctx, &())?,
            down: Pipeline::new(ctx, &())?,
            up: Pipeline::new(ctx, &())?,
            develop: [
                develop(false, false)?,
                develop(false, true)?,
                develop(true, false)?,
                develop(true, true)?,
            ],
            smooth: [smooth(false)?, smooth(true)?],
            flaws: Buffer::zeroed(ctx, "picture.flaws", 1)?,
        })
    }

    /// Records the development of a drawn image into the one of the darkroom.
    pub fn record(&self, rec: &mut Recorder, drawn: &Image, room: &Darkroom, how: Development) {
        let shape = &room.shape;
        let smooths = how.smooths && room.has_edges;
        if !smooths && !how.is_opaque && how.bloom.is_none() {
            return rec.copy_image_to(drawn, &room.image, [0, 0]);
        }
        rec.copy_image_in_rows(drawn, &room.picture.buffer, shape.pitch());
        // Without bloom the first level only counts marked pixels.
        let bloom = how.bloom.unwrap_or(Bloom {
            threshold: 1.0,
            slope: 1.0,
            strength: 0.0,
        });
        self.record_bloom(rec, room, bloom, how);
        if smooths {
            let none = DispatchGroups { x: 0, y: 0, z: 1 };
            rec.update(&room.groups, 0, &[none, DispatchGroups::default()]);
        }
        let blooms = how.bloom.is_some();
        let is_opaque = u32::from(how.is_opaque);
        let [width, height] = shape.size;
        let cells_down = shape.levels[0].down;
        let quad_count = shape.across * height;
        rec.dispatch(
            &self.develop[2 * usize::from(blooms) + usize::from(smooths)],
            Threads(quad_count),
            DevelopArgs {
                picture: &room.picture.quads,
                bloom: &room.bloom_cells,
                developed: &room.developed.quads,
                edges: &room.edges,
                groups: &room.groups,
            },
            DevelopParams {
                quad_count,
                across: shape.across,
                width,
                height,
                cells_down,
                is_opaque,
                in_group: SmoothEdges::GROUP_SIZE,
            },
        );
        if smooths {
            rec.dispatch_indirect(
                &self.smooth[usize::from(blooms)],
                (&room.groups, 0),
                SmoothEdgesArgs {
                    edges: &room.edges,
                    groups: &room.groups,
                    picture: &room.picture.singles,
                    bloom: &room.bloom_cells,
                    developed: &room.developed.singles,
                },
                SmoothEdgesParams {
                    pitch: shape.pitch(),
                    width,
                    height,
                    cells_down,
                    is_opaque,
                },
            );
        }
        rec.copy_to_image(&room.developed.buffer, &room.image, shape.pitch());
    }

    fn record_bloom(&self, rec: &mut Recorder, room: &Darkroom, bloom: Bloom, how: Development) {
        let shape = &room.shape;
        let [width, height] = shape.size;
        let finest = shape.levels[0];
        rec.dispatch(
            &self.first,
            Threads(finest.count() as u32),
            BloomFirstArgs {
                picture: &room.picture.quads,
                bloom: &room.bloom_cells,
                flaws: &self.flaws,
            },
            BloomFirstParams {
                cell_count: finest.count() as u32,
                across: shape.across,
                width,
                height,
                threshold: bloom.threshold,
                slope: bloom.slope,
                is_opaque: u32::from(how.is_opaque),
            },
        );
        if how.bloom.is_none() {
            return;
        }
        for pair in shape.levels.windows(2) {
            let [fine, coarse] = [pair[0], pair[1]];
            rec.dispatch(
                &self.down,
                Threads(coarse.count() as u32),
                BloomDownArgs {
                    bloom: &room.bloom_cells,
                },
                BloomDownParams {
                    cell_count: coarse.count() as u32,
                    across: coarse.across,
                    first: coarse.first,
                    fine_across: fine.across,
                    fine_down: fine.down,
                    fine_first: fine.first,
                },
            );
        }
        for (k, pair) in shape.levels.windows(2).enumerate().rev() {
            let [fine, coarse] = [pair[0], pair[1]];
            let is_last = k == 0;
            let strength = match is_last {
                true => bloom.strength * shape.share_of_sum(),
                false => 1.0,
            };
            rec.dispatch(
                &self.up,
                Threads(fine.count() as u32),
                BloomUpArgs {
                    bloom: &room.bloom_cells,
                },
                BloomUpParams {
                    cell_count: fine.count() as u32,
                    across: fine.across,
                    first: fine.first,
                    coarse_across: coarse.across,
                    coarse_down: coarse.down,
                    coarse_first: coarse.first,
                    spread: LEVEL_WEIGHT,
                    strength,
                    is_last: u32::from(is_last),
                },
            );
        }
    }
}
