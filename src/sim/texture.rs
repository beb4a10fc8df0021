//! Textures on the device, as kernels read and write them: texel by texel, four texels at once, or as a block, by the access paths in
//! [`TexelPaths`]. A shader declares the paths that it uses, and its kernel takes the texture as one argument.

use std::ops::Deref;
use std::sync::Arc;

use super::buffers::{self, Counts};
use super::texel_paths::TexelPaths;
use crate::gpu::{AnyBuffer, Buffer, BufferCore, Context, GpuError, TexelScalar, Texels};
use crate::mesh::atlas::Atlas;

/// A buffer with one value per texel, and all access paths to it. As a block, it is bound up to the largest size of a block.
pub struct Texture<T> {
    buffer: Buffer<T>,
    /// Four texels at once.
    pub quads: Texels<T>,
    /// One by one, or four at once, by [`TexelPaths`].
    pub texels: Texels<T>,
    /// One by one, to write: the first part.
    pub low: Texels<T>,
    /// The second part; the first again if there is only one.
    pub high: Texels<T>,
}

impl<T: TexelScalar> Texture<T> {
    /// A texture from a buffer with one value per texel, a multiple of four.
    ///
    /// # Errors
    /// When it has more texels than the device has access to.
    pub fn new(ctx: &Context, buffer: Buffer<T>) -> Result<Self, GpuError> {
        let paths = TexelPaths::of(ctx.info(), buffer.len() as u64);
        Self::by_paths(paths, buffer)
    }

    /// A texture whose texels kernels access by these paths.
    ///
    /// # Errors
    /// When the device does not support these paths for it.
    pub fn by_paths(paths: TexelPaths, buffer: Buffer<T>) -> Result<Self, GpuError> {
        let (band, texels) = (u64::from(paths.band), buffer.len() as u64);
        let (low, high) = if paths.in_quads {
            (0..band, band..texels)
        } else {
            (0..texels, 0..texels)
        };
        Ok(Self {
            quads: Texels::new(&buffer, 4)?,
            texels: Texels::new(&buffer, if paths.in_quads { 4 } else { 1 })?,
            low: Texels::of_part(&buffer, 1, low)?,
            high: Texels::of_part(&buffer, 1, high)?,
            buffer,
        })
    }
}

impl<T> Deref for Texture<T> {
    type Target = Buffer<T>;

    fn deref(&self) -> &Buffer<T> {
        &self.buffer
    }
}

impl<T> AnyBuffer for Texture<T> {
    fn core(&self) -> &BufferCore {
        self.buffer.core()
    }
}

/// Tables of an atlas for the diffusion kernels.
pub struct SpreadTables {
    /// One per texel: mean texel area by this texel's area, 0 where no triangle owns it.
    pub density: Texture<f32>,
    /// One per block with at least one texel in use: its first quad.
    pub blocks: Texels<u32>,
    /// Two texels of four words for each texel that exchanges across a seam.
    pub rows: Texels<u32>,
    /// Exchange entries, in pairs of two words each.
    pub entries: Texels<u32>,
}

impl SpreadTables {
    /// The tables of an atlas.
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
            density: Texture::new(ctx, density)?,
            blocks: buffers::BLOCKS.texels(&blocks)?,
            rows: buffers::EXCHANGE_ROWS.texels(&rows)?,
            entries: buffers::EXCHANGE_ENTRIES.texels(&entries)?,
        })
    }
}

/// Two textures that change roles each step.
pub struct PingPong<T> {
    /// The texture that is read now.
    pub front: Texture<T>,
    /// The texture that is written for the next step, or was read in the last one.
    pub back: Texture<T>,
    /// Are the roles exchanged, compared with the beginning?
    pub(super) is_swapped: bool,
}

impl<T: TexelScalar> PingPong<T> {
    pub(super) fn of(ctx: &Context, front: Buffer<T>, back: Buffer<T>) -> Result<Self, GpuError> {
        Ok(Self {
            front: Texture::new(ctx, front)?,
            back: Texture::new(ctx, back)?,
            is_swapped: false,
        })
    }

    /// Front becomes back.
    pub fn swap(&mut self) {
        std::mem::swap(&mut self.front, &mut self.back);
        self.is_swapped = !self.is_swapped;
    }
}
