//! Textures on the device, as kernels read and write them: whole, texel by texel, or four texels at once, by the ways that
//! [`TexelPaths`] says.

use std::sync::Arc;

use bytemuck::Pod;
use glam::{UVec4, Vec4};

use super::buffers::{self, Counts};
use super::texel_paths::{TexelPaths, band};
use crate::gpu::{Buffer, Context, GpuError, TexelScalar, Texels};
use crate::mesh::atlas::Atlas;

/// A buffer with a value a texel, seen through texel buffers.
pub struct Views<T> {
    /// Four texels at once.
    pub quads: Texels<T>,
    /// One by one; four at once where [`TexelPaths`] says so.
    pub texels: Texels<T>,
    /// One by one, to write: the first part.
    pub low: Texels<T>,
    /// The second one; the first again where there is but one.
    pub high: Texels<T>,
}

impl<T: TexelScalar> Views<T> {
    /// Those of a buffer with a value a texel.
    ///
    /// # Errors
    /// When it has more texels than the device has ways to.
    pub fn new(ctx: &Context, buffer: &Buffer<T>) -> Result<Self, GpuError> {
        let texels = buffer.len() as u64;
        let paths = TexelPaths::of(ctx.info(), texels);
        let band = band(ctx.info());
        let (low, high) = if paths.in_quads {
            (0..band, band..texels)
        } else {
            (0..texels, 0..texels)
        };
        Ok(Self {
            quads: Texels::new(buffer, 4)?,
            texels: Texels::new(buffer, if paths.in_quads { 4 } else { 1 })?,
            low: Texels::of_part(buffer, 1, low)?,
            high: Texels::of_part(buffer, 1, high)?,
        })
    }
}

/// What the kernels that spread the trail read of an atlas.
pub struct SpreadTables {
    /// One a texel: mean texel area by this texel's area, 0 where no triangle owns it.
    pub density: Buffer<f32>,
    /// The density as kernels read it.
    pub density_views: Views<f32>,
    /// One a block of texels of which any is in use: its first quad.
    pub blocks: Texels<u32>,
    /// Two texels of four words for each texel that exchanges across a seam.
    pub rows: Texels<u32>,
    /// What it exchanges with; two entries of two words each.
    pub entries: Texels<u32>,
}

impl SpreadTables {
    /// Those of an atlas.
    ///
    /// # Errors
    /// No memory.
    pub(super) fn new(ctx: &Arc<Context>, atlas: &Atlas) -> Result<Self, GpuError> {
        let exchange = atlas.exchange.packed(&atlas.density);
        let counts = &Counts {
            texels: atlas.texel_count() as u64,
            blocks: atlas.blocks.len() as u64,
            rows: exchange.rows.len() as u64,
            entries: exchange.entries.len() as u64,
            ..Counts::default()
        };
        let density = buffers::DENSITY.of(ctx, counts, &atlas.density)?;
        let blocks = buffers::BLOCKS.of(ctx, counts, &atlas.blocks)?;
        let rows = buffers::EXCHANGE_ROWS.of(ctx, counts, &exchange.rows)?;
        let entries = buffers::EXCHANGE_ENTRIES.of(ctx, counts, &exchange.entries)?;
        Ok(Self {
            density_views: Views::new(ctx, &density)?,
            density,
            blocks: buffers::BLOCKS.texels(&blocks)?,
            rows: buffers::EXCHANGE_ROWS.texels(&rows)?,
            entries: buffers::EXCHANGE_ENTRIES.texels(&entries)?,
        })
    }
}

/// A number of which a block has four side by side.
pub trait InFours: TexelScalar {
    /// Four of it.
    type Four: Pod;
}

impl InFours for f32 {
    type Four = Vec4;
}

impl InFours for u32 {
    type Four = UVec4;
}

/// Two buffers that change roles each step.
pub struct PingPong<T: InFours> {
    /// What is read now.
    pub front: Buffer<T>,
    /// The front, as diffusion reads it.
    pub front_views: Views<T>,
    /// What is written for the next step, or was read in the last one.
    pub back: Buffer<T>,
    /// The back, as diffusion reads it.
    pub back_views: Views<T>,
    /// The back as a block, four texels side by side.
    pub back_blocks: Buffer<T::Four>,
    front_blocks: Buffer<T::Four>,
    /// Was front back at first?
    pub(super) is_swapped: bool,
}

impl<T: InFours> PingPong<T> {
    pub(super) fn of(ctx: &Context, front: Buffer<T>, back: Buffer<T>) -> Result<Self, GpuError> {
        Ok(Self {
            front_views: Views::new(ctx, &front)?,
            back_views: Views::new(ctx, &back)?,
            front_blocks: front.cast(),
            back_blocks: back.cast(),
            front,
            back,
            is_swapped: false,
        })
    }

    /// Front becomes back.
    pub fn swap(&mut self) {
        std::mem::swap(&mut self.front, &mut self.back);
        std::mem::swap(&mut self.front_views, &mut self.back_views);
        std::mem::swap(&mut self.front_blocks, &mut self.back_blocks);
        self.is_swapped = !self.is_swapped;
    }
}

/// What is bound in the place of a texture that is written another way.
pub struct Unused {
    floats: Buffer<Vec4>,
    float_quads: Texels<f32>,
    words: Buffer<u32>,
    word_blocks: Buffer<UVec4>,
    word_quads: Texels<u32>,
    word_texels: Texels<u32>,
}

/// Where diffusion writes to.
pub struct Spread<'a> {
    /// The trail.
    pub next_trail: &'a Buffer<Vec4>,
    /// The same by another way.
    pub next_trail_quads: &'a Texels<f32>,
    /// Deposits that are cleared.
    pub previous_deposits: &'a Buffer<UVec4>,
    /// The same by another way.
    pub previous_deposits_quads: &'a Texels<u32>,
}

/// Where deposits are counted.
pub struct Counted<'a> {
    /// All of them.
    pub block: &'a Buffer<u32>,
    /// Those of the first part by another way.
    pub low: &'a Texels<u32>,
    /// Those of the second.
    pub high: &'a Texels<u32>,
}

impl Unused {
    /// One quad of each kind.
    ///
    /// # Errors
    /// No memory.
    pub fn new(ctx: &Arc<Context>) -> Result<Self, GpuError> {
        let floats: Buffer<f32> = buffers::UNUSED_FLOATS.zeroed(ctx, &Counts::default())?;
        let words: Buffer<u32> = buffers::UNUSED_WORDS.zeroed(ctx, &Counts::default())?;
        Ok(Self {
            float_quads: Texels::new(&floats, 4)?,
            floats: floats.cast(),
            word_quads: Texels::new(&words, 4)?,
            word_texels: Texels::new(&words, 1)?,
            word_blocks: words.cast(),
            words,
        })
    }

    pub(super) fn words(&self) -> &Buffer<u32> {
        &self.words
    }

    /// What `diffuse` writes, by the way that suits the texture.
    #[must_use]
    pub fn spread<'a>(
        &'a self,
        outgrows_block: bool,
        trail: &'a PingPong<f32>,
        deposits: &'a PingPong<u32>,
    ) -> Spread<'a> {
        if outgrows_block {
            Spread {
                next_trail: &self.floats,
                next_trail_quads: &trail.back_views.quads,
                previous_deposits: &self.word_blocks,
                previous_deposits_quads: &deposits.back_views.quads,
            }
        } else {
            Spread {
                next_trail: &trail.back_blocks,
                next_trail_quads: &self.float_quads,
                previous_deposits: &deposits.back_blocks,
                previous_deposits_quads: &self.word_quads,
            }
        }
    }

    /// Where `advance` counts, by the way that suits the texture.
    #[must_use]
    pub fn counted<'a>(&'a self, outgrows_block: bool, deposits: &'a PingPong<u32>) -> Counted<'a> {
        if outgrows_block {
            Counted {
                block: &self.words,
                low: &deposits.front_views.low,
                high: &deposits.front_views.high,
            }
        } else {
            Counted {
                block: &deposits.front,
                low: &self.word_texels,
                high: &self.word_texels,
            }
        }
    }
}
