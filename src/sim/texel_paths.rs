//! The access paths of kernels to single texels of a texture. They depend on its size; the results do not.
//!
//! A texture whose texels one texel buffer holds is read and written texel by texel. One with more is read four texels at
//! once and written through two views, each of a part of it. Deposits are counted in a storage block, and diffusion writes to one, if it
//! holds the texture, because that is fastest.

use crate::gpu::{DeviceInfo, PART};

/// Parts of a texture that are written through separate views.
pub const BANDS: u64 = 2;

/// The access paths of a texture on a device.
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
    /// The access paths for `texels` texels.
    #[must_use]
    pub fn of(device: &DeviceInfo, texels: u64) -> Self {
        let fits = texels <= u64::from(device.max_texel_buffer_elements);
        Self {
            in_quads: !fits,
            band: if fits { u32::MAX } else { band(device) as u32 },
            outgrows_block: texels * size_of::<u32>() as u64 > device.max_storage_buffer_range,
        }
    }

    /// The largest number of texels.
    #[must_use]
    pub fn most_texels(device: &DeviceInfo) -> u64 {
        (BANDS * band(device)).max(device.max_texel_buffer_elements.into())
    }
}

/// Texels of a part: parts begin at offsets that every device allows for views.
fn band(device: &DeviceInfo) -> u64 {
    u64::from(device.max_texel_buffer_elements) / PART * PART
}
