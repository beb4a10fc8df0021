//! By which ways kernels get at the single texels of a texture: a large one takes others than a small one, and the same
//! bits come out.
//!
//! A texture whose texels one texel buffer holds is read and written texel by texel. One with more is read four texels at
//! once and written through two views, each of a part of it. Deposits are counted in a storage block, and diffusion writes
//! to one, as long as it holds the texture: that is fastest.

use std::sync::Arc;

use glam::{UVec4, Vec4};

use super::state::PingPong;
use crate::gpu::{Buffer, Context, DeviceInfo, GpuError, PART, Texels};

/// Parts of a texture that are written through views of their own.
pub const BANDS: u64 = 2;

/// The ways for a texture on a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TexelPaths {
    /// Are texels read four at once?
    pub in_quads: bool,
    /// Texels of the first part.
    pub band: u32,
    /// Is the texture larger than a storage block?
    pub outgrows_block: bool,
}

impl Default for TexelPaths {
    fn default() -> Self {
        Self {
            in_quads: false,
            band: u32::MAX,
            outgrows_block: false,
        }
    }
}

impl TexelPaths {
    /// Those for so many texels.
    #[must_use]
    pub fn of(device: &DeviceInfo, texels: u64) -> Self {
        let fits = texels <= u64::from(device.max_texel_buffer_elements);
        Self {
            in_quads: !fits,
            band: if fits { u32::MAX } else { band(device) as u32 },
            outgrows_block: texels * size_of::<u32>() as u64 > device.max_storage_buffer_range,
        }
    }

    /// How many texels there may be.
    #[must_use]
    pub fn most_texels(device: &DeviceInfo) -> u64 {
        (BANDS * band(device)).max(device.max_texel_buffer_elements.into())
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
        let floats: Buffer<f32> = Buffer::zeroed(ctx, "unused.floats", 4)?;
        let words: Buffer<u32> = Buffer::zeroed(ctx, "unused.words", 4)?;
        Ok(Self {
            float_quads: Texels::new(&floats, 4)?,
            floats: floats.cast(),
            word_quads: Texels::new(&words, 4)?,
            word_texels: Texels::new(&words, 1)?,
            word_blocks: words.cast(),
            words,
        })
    }

    /// Bytes of both.
    #[must_use]
    pub fn size_in_bytes(&self) -> u64 {
        self.floats.size_in_bytes() + self.words.size_in_bytes()
    }

    /// The same before they are made.
    pub(super) const SIZE: u64 = 2 * 4 * size_of::<f32>() as u64;

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

/// Texels of a part: parts begin where every device lets views begin.
pub(super) fn band(device: &DeviceInfo) -> u64 {
    u64::from(device.max_texel_buffer_elements) / PART * PART
}
