//! The world atlas: one texture in which every triangle of every object has its place.
//!
//! A *chart* is a part of the texture in which neighbouring triangles lie side by side; a texel is *owned* by the
//! triangle that holds its centre; *gutter* texels round each chart are a halo for reads: a row of weights says from
//! which owned texels each is filled, so that a bilinear read near a seam sees what lies across it.
//!
//! **Invariant:** every texel whose centre is within `gutter` texels (in either direction) of any point of a chart is
//! owned by that chart or is its gutter. Therefore bilinear reads at points of a triangle, and deposits, never touch another
//! chart's texels or empty ones. Every chart owns a texel, however small it is.
//!
//! **Invariant:** with `grid` the texel that holds the mapped position of any point of a triangle is owned, by that
//! triangle or by another one of its chart. With the other methods it may be gutter: deposits there go to the owned texels behind it.
//!
//! Methods differ in the layout, that is, in the places of charts. All methods fill gutter texels in the same way.

mod balance;
mod bitmap;
mod cache;
mod charts;
mod clearance;
mod conductances;
mod control;
mod exchange;
mod fixed;
mod flat;
mod grid;
mod gutter;
mod nearness;
mod outline;
mod outlook;
mod overlap;
mod own_uvs;
mod owners;
mod packed;
mod piece;
mod pieces;
mod pile;
mod place;
mod rows;
mod statistics;
mod table;
#[cfg(test)]
mod tests;
mod torus;
mod validate;

use std::fmt;

use glam::{DVec2, Vec2};
use rayon::prelude::*;

use self::conductances::Layers;
use self::torus::Torus;
use super::surface::{AtlasMap, NONE, Seam, Surface};
use crate::choice::choice;
use crate::plain_text::counted;
pub use clearance::UNIT as CLEARANCE_UNIT;
pub use control::Control;
pub use exchange::{
    BLOCK_QUADS, BLOCK_ROWS, Exchange, ExchangeEntry, ExchangeRow, GREATEST_DENSITY,
    GREATEST_DIFFUSION,
};
pub use outlook::Outlooks;
pub use packed::{PackedEntries, PackedExchange, PackedRow};
pub use statistics::AtlasStatistics;

/// The largest texture side; in single precision, positions in it have nine bits for fractions of a texel.
pub const MAX_SIZE: u32 = 32_768;

/// Name of computing the diffusion across seams in progress reports.
const JOINING: &str = "joining seams";

choice! {
    /// How triangles are laid out in the texture.
    AtlasMethod {
        /// Few large charts in which triangles keep their angles and, nearly, their size.
        #[default]
        Charts = "charts",
        /// Square cells of one size, two neighbouring triangles in each.
        Grid = "grid",
        /// As the model's own texture coordinates say.
        Mesh = "mesh",
    }
}

/// Options of an atlas.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AtlasOptions {
    /// How triangles are laid out.
    pub method: AtlasMethod,
    /// Texture side in texels, 1 to [`MAX_SIZE`]; any number, not only powers of two. By `charts`, a square whose opposite sides are glued,
    /// if it is the only object, has so many owned texels a side, and the texture is larger by the gutter on both sides.
    pub size: u32,
    /// Side of a `grid` cell in texels, gutter included; 0 takes the largest that fits.
    pub cell_size: u32,
    /// Width of the halo round each chart in texels; less than 1 counts as 1, which bilinear reads need.
    pub gutter: u32,
    /// Texels between the taps of the diffusion, at most the gutter; 0 takes the gutter.
    pub taps: u32,
    /// For `charts`, one per object: its texels per surface area, relative to the others; empty: all equal.
    pub weights: Vec<f32>,
    /// For `charts`: a seed for random angles by which charts are turned before they are packed; 0 turns none. It allows tests that trails
    /// do not depend on the orientation of charts.
    pub turn: u64,
}

impl AtlasOptions {
    /// The options with the gutter raised to what bilinear reads need, and the taps' distance within it, if such an atlas is possible.
    fn checked(&self, surface: &Surface) -> Result<Self, AtlasError> {
        if self.size == 0 || self.size > MAX_SIZE {
            return Err(AtlasError::Size(self.size));
        }
        if surface.corners.is_empty() {
            return Err(AtlasError::Empty);
        }
        let gutter = self.gutter.max(1);
        let taps = match self.taps {
            0 => gutter,
            taps => taps.min(gutter),
        };
        Ok(Self {
            gutter,
            taps,
            ..self.clone()
        })
    }
}

/// Why there is no atlas.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AtlasError {
    /// Nothing to lay out.
    #[error(
        "the atlas has no triangles to lay out: give the scene at least one mesh with triangles"
    )]
    Empty,
    /// The texture side is not in the range.
    #[error("atlas size {0} is out of range: choose from 1 to {MAX_SIZE}")]
    Size(u32),
    /// A square with glued sides has no room for its gutter.
    #[error(
        "atlas size {size} is the side of a plane without borders, and with its gutter of {gutter} the texture would be larger \
         than {MAX_SIZE}: choose {most} at most"
    )]
    NoRoomForGutter {
        /// The texels along a side.
        size: u32,
        /// The gutter, texels.
        gutter: u32,
        /// The largest size that works.
        most: u32,
    },
    /// The work was cancelled.
    #[error("interrupted while setting up")]
    Cancelled,
    /// A cell has no room for two triangles and their gutter.
    #[error(
        "atlas cell size {cell_size} is too small for a gutter of {gutter}: choose at least {needed}, \
         or 0 for the largest that fits"
    )]
    CellTooSmall {
        /// The cell side asked for, texels.
        cell_size: u32,
        /// The gutter, texels.
        gutter: u32,
        /// The smallest cell side that works.
        needed: u64,
    },
    /// More triangles than the texture has room for.
    #[error(
        "an atlas of size {size} has no room for {triangles} in {cells} of at least {cell_size} x {cell_size} texels \
         (gutter {gutter}): {advice}",
        triangles = counted(*triangles, "triangle", "triangles"),
        cells = counted(*cells, "cell", "cells"),
        advice = room_advice(*needed)
    )]
    NoRoom {
        /// Triangles of the surface.
        triangles: usize,
        /// Cells that they take.
        cells: usize,
        /// The smallest cell side allowed here, texels.
        cell_size: u32,
        /// The gutter, texels.
        gutter: u32,
        /// The texture side asked for.
        size: u32,
        /// The smallest texture side that works.
        needed: u64,
    },
    /// The model's own texture coordinates cannot be used.
    #[error(
        "the texture coordinates of object {object} cannot be its atlas: {problem}; repair them, or choose \
         atlas.method charts or grid"
    )]
    OwnUvs {
        /// The object, counted from 1.
        object: u32,
        /// The problem, and its place.
        problem: String,
    },
    /// The model's own texture coordinates leave too little room at this size.
    #[error(
        "the texture coordinates of object {object} leave too little room for a gutter of {gutter} in an atlas of size \
         {size}: {problem}; raise atlas.size to {advice}",
        advice = if *tried { format!("{needed} or more") } else { format!("about {needed}") }
    )]
    OwnUvsTooDense {
        /// The object, counted from 1.
        object: u32,
        /// The gutter, texels.
        gutter: u32,
        /// The texture side asked for.
        size: u32,
        /// The parts that are too near to each other, and their place.
        problem: String,
        /// A texture side that works, or that should.
        needed: u32,
        /// Whether that was tried; very large ones are not.
        tried: bool,
    },
    /// More charts than the texture has room for.
    #[error(
        "an atlas of size {size} has no room for {charts} with a gutter of {gutter}: {advice}",
        charts = counted(*charts, "chart", "charts"),
        advice = chart_advice(*needed)
    )]
    NoRoomForCharts {
        /// Charts that the triangles are in.
        charts: usize,
        /// The gutter, texels.
        gutter: u32,
        /// The texture side asked for.
        size: u32,
        /// A texture side that works, a few per cent above the smallest at the most; more than [`MAX_SIZE`] if none does.
        needed: u64,
    },
}

fn chart_advice(needed: u64) -> String {
    if needed <= u64::from(MAX_SIZE) {
        format!("raise atlas.size to {needed} or more")
    } else {
        format!(
            "that takes more than {MAX_SIZE}, the largest; use meshes with fewer parts and triangles, or a smaller gutter"
        )
    }
}

fn room_advice(needed: u64) -> String {
    if needed <= u64::from(MAX_SIZE) {
        format!("raise atlas.size to {needed} or more")
    } else {
        format!(
            "that takes {needed}, above the largest, {MAX_SIZE}; use meshes with fewer triangles"
        )
    }
}

/// A texel that no triangle owns but that reads may touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GutterTexel {
    /// `y * pitch + x`.
    pub texel: u32,
    /// The nearest triangle, in texels, of the chart that the texel belongs to.
    pub triangle: u32,
}

/// The places of charts, which the method decides. The rest of the atlas follows from them.
#[derive(Clone, Debug)]
struct Layout {
    maps: Vec<AtlasMap>,
    chart: Vec<u32>,
    chart_count: u32,
    cell_size: u32,
    owner: Vec<u32>,
    /// Per texel: the surface area that lies in it, world units squared, on owned and on gutter texels.
    area: Vec<f32>,
    gutter_texels: Vec<GutterTexel>,
}

/// Every triangle's place in one texture, the owner of each texel, and how the gutter is filled.
#[derive(Clone, Debug)]
pub struct Atlas {
    /// Texture side in texels.
    pub size: u32,
    /// Texels from one row to the next: `size` rounded up to a multiple of 4. Buffers have `pitch * size` texels.
    pub pitch: u32,
    /// Width of the halo round each chart, texels.
    pub gutter: u32,
    /// Texels between the taps of the diffusion that the exchange and the blocks are made for, 1 to the gutter.
    pub taps: u32,
    /// How it was laid out.
    pub method: AtlasMethod,
    /// Side of a `grid` cell in texels; 0 with other methods.
    pub cell_size: u32,
    /// Number of charts.
    pub chart_count: u32,
    /// Number of owned texels.
    pub owned_count: u32,
    /// Mean surface area of an owned texel, world units squared.
    pub mean_texel_area: f64,
    /// Per triangle: the affine map from `uv` to texels.
    pub maps: Vec<AtlasMap>,
    /// Per triangle: its chart.
    pub chart: Vec<u32>,
    /// Per texel: the triangle that holds its centre, or [`NONE`].
    pub owner: Vec<u32>,
    /// Per texel: the surface area that an owned texel covers, world units squared; 0 for all others. The sum is the surface's area.
    pub area: Vec<f32>,
    /// Per texel: mean texel area over this texel's area for owned texels, 0 for all others.
    pub density: Vec<f32>,
    /// The gutter texels that can be read, in ascending order.
    pub gutter_texels: Vec<GutterTexel>,
    /// How each of them is filled, in the same order.
    pub seams: Vec<Seam>,
    /// How texels beside seams exchange trail.
    pub exchange: Exchange,
    /// The largest diffusion that one pass takes: 1, which is the mean of nine, where all texels cover nearly the same area, or
    /// [`GREATEST_DIFFUSION`].
    pub greatest_diffusion: f32,
    /// The first quads of the blocks, of [`BLOCK_ROWS`] rows of [`BLOCK_QUADS`] quads, with owned or gutter texels in
    /// them.
    pub blocks: Vec<u32>,
}

impl Atlas {
    /// Lays out all triangles of a surface. The result depends on nothing but the arguments.
    ///
    /// # Errors
    /// When the size is out of range or the texture has no room; the message names a size that works.
    pub fn build(surface: &Surface, options: &AtlasOptions) -> Result<Self, AtlasError> {
        Self::build_with(surface, options, &Control::default())
    }

    /// As [`build`](Self::build), with progress reports and cancellation by `control`.
    ///
    /// # Errors
    /// As [`build`](Self::build), and [`AtlasError::Cancelled`].
    pub fn build_with(
        surface: &Surface,
        options: &AtlasOptions,
        control: &Control<'_>,
    ) -> Result<Self, AtlasError> {
        let mut options = options.checked(surface)?;
        let torus = Torus::of(surface, &options);
        if torus.is_some() {
            options.size = Torus::side(&options)?;
        }
        let layout = match &torus {
            Some(torus) => torus.layout(&surface.cut(), &options, control)?,
            None => Self::layout(&surface.cut(), &options, control)?,
        };
        let (seams, ways) = gutter::seams(surface, &layout, pitch_of(options.size), control)?;
        let is_plain = torus.is_some();
        let atlas = Self::assemble(
            surface,
            &options,
            layout,
            seams,
            (&ways[..], is_plain),
            control,
        )?;
        // A cancellation in the meantime returns an error, too.
        control.step(JOINING, 1.0)?;
        Ok(atlas)
    }

    /// The places of charts, in which glued edges are seams: of the surface without them.
    fn layout(
        cut: &Surface,
        options: &AtlasOptions,
        control: &Control<'_>,
    ) -> Result<Layout, AtlasError> {
        Ok(match options.method {
            AtlasMethod::Charts => {
                let (maps, chart, chart_count) = cache::kept(cut, options, control, || {
                    let flat = charts::flat_charts(cut, control)?;
                    place::place(cut, flat, options, control)
                })?;
                owners::derive(cut, maps, chart, chart_count, options, control)?
            }
            AtlasMethod::Grid => {
                control.step(owners::DOING, owners::START)?;
                grid::Grid::new(cut, options)?.layout(cut)
            }
            AtlasMethod::Mesh => {
                let (maps, chart, chart_count) = own_uvs::place(cut, options, control)?;
                owners::derive(cut, maps, chart, chart_count, options, control)?
            }
        })
    }

    /// `ways` go with the seams; `is_plain` says that the stencil goes on over all seams.
    fn assemble(
        surface: &Surface,
        options: &AtlasOptions,
        mut layout: Layout,
        seams: Vec<Seam>,
        (ways, is_plain): (&[gutter::Way], bool),
        control: &Control<'_>,
    ) -> Result<Self, AtlasError> {
        control.step(JOINING, 0.82)?;
        give_to_owned(&mut layout.area, &seams);
        let owned_count = layout.owner.par_iter().filter(|&&t| t != NONE).count();
        let mean_texel_area = surface_area(surface) / owned_count as f64;
        let density: Vec<f32> = layout
            .area
            .par_iter()
            .map(|&area| match area {
                0.0 => 0.0,
                _ => ((mean_texel_area / f64::from(area)) as f32).min(f32::MAX),
            })
            .collect();
        let pitch = pitch_of(options.size);
        let deposited = match options.method {
            // No point of a triangle lies outside the texels that its cell owns.
            AtlasMethod::Grid => vec![false; seams.len()],
            _ => exchange::deposited(&layout.maps, pitch, &layout.gutter_texels),
        };
        let layers = Layers {
            owner: &layout.owner,
            chart: &layout.chart,
            density: &density,
            whole: &whole_texels(surface, &layout.maps, mean_texel_area),
            seams: &seams,
            ways,
            deposited: &deposited,
            is_plain,
            pitch,
            distance: options.taps,
            offsets: ExchangeRow::neighbours(pitch, options.taps),
        };
        let conductances = layers.conductances(control)?;
        control.check()?;
        let exchange = conductances.tables(&layers);
        let blocks = exchange::used_blocks(&density, &seams, options.taps * pitch / 4);
        Ok(Self {
            size: options.size,
            pitch,
            gutter: options.gutter,
            taps: options.taps,
            method: options.method,
            cell_size: layout.cell_size,
            chart_count: layout.chart_count,
            owned_count: owned_count as u32,
            mean_texel_area,
            maps: layout.maps,
            chart: layout.chart,
            owner: layout.owner,
            area: layout.area,
            gutter_texels: layout.gutter_texels,
            seams,
            greatest_diffusion: exchange::greatest_diffusion(&density, &exchange),
            density,
            exchange,
            blocks,
        })
    }

    /// Length of the per-texel arrays: `pitch * size`.
    #[must_use]
    pub fn texel_count(&self) -> usize {
        self.pitch as usize * self.size as usize
    }

    /// Texture position of a point of a triangle, in texels; the kernels compute it with equal operations in equal order.
    #[must_use]
    pub fn position_of(&self, triangle: u32, u: f32, v: f32) -> Vec2 {
        position(&self.maps[triangle as usize], u, v)
    }

    /// The texel that holds a point of a triangle: for `u, v >= 0` and `u + v <= 1` an owned one, or with other methods
    /// than `grid` a gutter texel of the same chart.
    #[must_use]
    pub fn texel_of(&self, triangle: u32, u: f32, v: f32) -> u32 {
        let position = self.position_of(triangle, u, v);
        position.y as u32 * self.pitch + position.x as u32
    }

    /// Position of a texel's centre in the texture, in texels.
    #[must_use]
    pub fn centre_of(&self, texel: u32) -> Vec2 {
        Vec2::new(
            (texel % self.pitch) as f32 + 0.5,
            (texel / self.pitch) as f32 + 0.5,
        )
    }

    /// The surface point under an owned texel's centre: its triangle, `u` and `v`, moved inside where the centre lies
    /// on the triangle's edge. `None` for texels that are not owned.
    #[must_use]
    pub fn surface_point_of(&self, texel: u32) -> Option<(u32, f32, f32)> {
        self.surface_point_in(texel, DVec2::splat(0.5))
    }

    /// As [`surface_point_of`](Self::surface_point_of), for a place within the texel, from 0 to 1 along both sides.
    #[must_use]
    pub fn surface_point_in(&self, texel: u32, place: DVec2) -> Option<(u32, f32, f32)> {
        let triangle = self.owner[texel as usize];
        (triangle != NONE).then(|| {
            let corner = self.centre_of(texel).as_dvec2() - 0.5;
            let map = gutter::Affine::of(&self.maps[triangle as usize]);
            let uv = map.nearest_uv(corner + place);
            (triangle, uv.x as f32, uv.y as f32)
        })
    }
}

impl fmt::Display for Atlas {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{0} x {0} texels by {1}: ",
            self.size,
            self.method.word()
        )?;
        match self.cell_size {
            0 => f.write_str(&counted(self.chart_count as usize, "chart", "charts"))?,
            c => {
                let cells = counted(self.chart_count as usize, "cell", "cells");
                write!(f, "{cells} of {c} x {c}")?;
            }
        }
        let texels = f64::from(self.size) * f64::from(self.size);
        write!(
            f,
            ", gutter {}; {} owned and {} gutter texels, {:.1} % of the texture owned",
            self.gutter,
            self.owned_count,
            self.seams.len(),
            100.0 * f64::from(self.owned_count) / texels,
        )
    }
}

/// Moves the areas of gutter texels to the owned texels behind them, by the weights of reads, as diffusion and deposits do.
fn give_to_owned(area: &mut [f32], seams: &[Seam]) {
    for seam in seams {
        let given = std::mem::take(&mut area[seam.texel as usize]);
        for (source, weight) in seam.source.into_iter().zip(seam.weights()) {
            area[source as usize] += weight * given;
        }
    }
}

/// Per triangle: the surface area of a texel that lies wholly in it, in mean texel areas.
fn whole_texels(surface: &Surface, maps: &[AtlasMap], mean_texel_area: f64) -> Vec<f32> {
    maps.par_iter()
        .enumerate()
        .map(|(triangle, map)| {
            let texels = 0.5 * map.du.as_dvec2().perp_dot(map.dv.as_dvec2()).abs();
            let area = surface.area(triangle as u32) / mean_texel_area;
            (area / texels.max(f64::MIN_POSITIVE)) as f32
        })
        .collect()
}

fn pitch_of(size: u32) -> u32 {
    size.next_multiple_of(4)
}

fn position(map: &AtlasMap, u: f32, v: f32) -> Vec2 {
    map.origin + u * map.du + v * map.dv
}

/// Summed in order: a parallel sum of floats would differ from run to run.
fn surface_area(surface: &Surface) -> f64 {
    (0..surface.triangles.len() as u32)
        .map(|t| surface.area(t))
        .sum()
}
