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

/// The smaller side of a picture, in pixels, in which the bloom is made of the levels as they are: the finest has a cell for 4 pixels, the
/// coarsest one for 128. In larger and smaller pictures it is as wide as a share of the picture, and lies between the levels.
const SIDE: f32 = 720.0;
/// How many levels that picture has.
const LEVELS: usize = 6;
/// The weight of each of them against the one that is finer.
const LEVEL_WEIGHT: f32 = 0.7;

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
        let coarsest = (LEVELS - 1) as f32 + doublings(size);
        let most = 1 + coarsest.ceil().max(1.0) as usize;
        let mut levels = vec![Level {
            across,
            down: size[1].div_ceil(4),
            first: 0,
        }];
        loop {
            let fine = levels[levels.len() - 1];
            let is_small = fine.across.min(fine.down) < 4 && levels.len() > 1;
            if is_small || levels.len() == most {
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

    /// The weights of the levels in a bloom; their sum is one.
    #[must_use]
    pub fn weights(&self) -> Vec<f32> {
        let last = (self.levels.len() - 1) as f32;
        let mut weights = vec![0.0; self.levels.len()];
        for k in 0..LEVELS {
            // Where this level of a picture of the usual side lies among those that there are.
            let place = (k as f32 + doublings(self.size)).clamp(0.0, last);
            let (finer, share) = (place as usize, place.fract());
            let weight = LEVEL_WEIGHT.powi(k as i32);
            weights[finer] += weight * (1.0 - share);
            if share > 0.0 {
                weights[finer + 1] += weight * share;
            }
        }
        let sum: f32 = weights.iter().sum();
        weights.iter().map(|weight| weight / sum).collect()
    }

    /// The weights of a level and of the sum of all coarser levels.
    #[must_use]
    pub fn kept_and_spread(&self, level: usize) -> [f32; 2] {
        let weights = self.weights();
        let is_coarsest = level + 2 == weights.len();
        [
            weights[level],
            if is_coarsest { weights[level + 1] } else { 1.0 },
        ]
    }
}

/// The logarithm to base 2 of the smaller side of a picture over [`SIDE`].
fn doublings(size: [u32; 2]) -> f32 {
    (size[0].min(size[1]) as f32 / SIDE).log2()
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
    /// Without bloom, with it, with it where pixels may be clear; each without and with smoothing.
    develop: [[Pipeline<Develop>; 2]; 3],
    /// Without bloom, with it, with it where pixels may be clear.
    smooth: [Pipeline<SmoothEdges>; 3],
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
        let develop = |blooms, smooths, may_be_clear| {
            let constants = DevelopConstants {
                blooms,
                smooths,
                may_be_clear,
            };
            Pipeline::new(ctx, &constants)
        };
        let smooth = |blooms, may_be_clear| {
            let constants = SmoothEdgesConstants {
                blooms,
                may_be_clear,
            };
            Pipeline::new(ctx, &constants)
        };
        Ok(Self {
            first: Pipeline::new(ctx, &())?,
            down: Pipeline::new(ctx, &())?,
            up: Pipeline::new(ctx, &())?,
            develop: [
                [develop(false, false, false)?, develop(false, true, false)?],
                [develop(true, false, false)?, develop(true, true, false)?],
                [develop(true, false, true)?, develop(true, true, true)?],
            ],
            smooth: [
                smooth(false, false)?,
                smooth(true, false)?,
                smooth(true, true)?,
            ],
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
        let form = match (how.bloom, how.is_opaque) {
            (None, _) => 0,
            (Some(_), true) => 1,
            (Some(_), false) => 2,
        };
        let is_opaque = u32::from(how.is_opaque);
        let [width, height] = shape.size;
        let cells_down = shape.levels[0].down;
        let quad_count = shape.across * height;
        rec.dispatch(
            &self.develop[form][usize::from(smooths)],
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
                &self.smooth[form],
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
            let strength = if is_last { bloom.strength } else { 1.0 };
            let [kept, spread] = shape.kept_and_spread(k);
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
                    kept,
                    spread,
                    strength,
                    is_last: u32::from(is_last),
                },
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    /// The bloom of a white square, a twentieth of the height wide, to the right of it, at shares of the height from its middle.
    fn halo(size: [u32; 2]) -> [f32; 3] {
        let shape = Shape::of(size).unwrap();
        let height = size[1] as f32;
        let from_middle = |i: u32, side: u32| (i as f32 + 0.5 - 0.5 * side as f32) / height;
        let (pitch, count) = (shape.pitch(), shape.pixel_count() as u32);
        let words = (0..count).map(|i| {
            let x = from_middle(i % pitch, size[0]).abs();
            let y = from_middle(i / pitch, size[1]).abs();
            if x.max(y) < 0.025 {
                u32::MAX
            } else {
                0xff00_0000
            }
        });
        let words: Vec<u32> = words.collect();
        let bloom = Bloom {
            threshold: 0.3,
            slope: 2.0,
            strength: 1.0,
        };
        let mut levels = vec![Vec3::ZERO; shape.cell_count()];
        twin::bloom_first(&shape, &bloom, true, &words, &mut levels, &mut 0);
        let pairs: Vec<[Level; 2]> = shape.levels.windows(2).map(|p| [p[0], p[1]]).collect();
        for &[fine, coarse] in &pairs {
            twin::bloom_down(fine, coarse, &mut levels);
        }
        for (k, &pair) in pairs.iter().enumerate().rev() {
            twin::bloom_up(pair, shape.kept_and_spread(k), 1.0, k == 0, &mut levels);
        }
        [0.06, 0.12, 0.3].map(|away| {
            let finest = shape.levels[0];
            let column = (0.5 * size[0] as f32 + away * height) / 4.0;
            let cell = finest.down / 2 * finest.across + column as u32;
            levels[cell as usize].x
        })
    }

    /// Would catch: bloom that is wide in small pictures and narrow in large ones, and weights that make it brighter.
    #[test]
    fn bloom_is_as_wide_in_pictures_of_every_size() {
        let usual = halo([1280, 720]);
        for size in [[640, 360], [1120, 630], [1920, 1080], [2560, 1440]] {
            let halo = halo(size);
            for (value, usual) in halo.iter().zip(usual) {
                assert!(
                    (value - usual).abs() < 0.12 * usual + 0.003,
                    "{size:?}: {halo:?}, {usual}"
                );
            }
        }
        for size in [[1, 1], [5, 3], [300, 20], [720, 1280], [16_384, 16_384]] {
            let shape = Shape::of(size).unwrap();
            let weights = shape.weights();
            assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-5, "{size:?}");
            assert_eq!(weights.len(), shape.levels.len());
        }
        let weights = Shape::of([1280, 720]).unwrap().weights();
        assert!(
            weights
                .windows(2)
                .all(|w| (w[1] / w[0] - LEVEL_WEIGHT).abs() < 1e-5)
        );
    }
}
