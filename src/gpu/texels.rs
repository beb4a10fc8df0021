//! Texel buffers: a device buffer read as a one-dimensional texture, which is the fastest way to small tables on CPU
//! drivers, and written as one, which may be larger than a storage block. The shader declares `samplerBuffer` and
//! `texelFetch`, or `imageBuffer` and `imageStore`.

use std::marker::PhantomData;
use std::sync::Arc;

use ash::vk;
use bytemuck::Pod;

use super::buffer::{AnyBuffer, Buffer};
use super::buffer_core::BufferCore;
use super::deletion_queue::Deletion;
use super::error::{Check, GpuError, GpuResult};

/// Parts begin at multiples of so many texels: no device asks for more than 256 bytes.
pub const PART: u64 = 64;

/// A scalar that texels are made of.
pub trait TexelScalar: Pod {
    /// The format with one, two and four components.
    const FORMATS: [(usize, vk::Format); 3];
}

impl TexelScalar for f32 {
    const FORMATS: [(usize, vk::Format); 3] = [
        (1, vk::Format::R32_SFLOAT),
        (2, vk::Format::R32G32_SFLOAT),
        (4, vk::Format::R32G32B32A32_SFLOAT),
    ];
}

impl TexelScalar for u32 {
    const FORMATS: [(usize, vk::Format); 3] = [
        (1, vk::Format::R32_UINT),
        (2, vk::Format::R32G32_UINT),
        (4, vk::Format::R32G32B32A32_UINT),
    ];
}

impl TexelScalar for i32 {
    const FORMATS: [(usize, vk::Format); 3] = [
        (1, vk::Format::R32_SINT),
        (2, vk::Format::R32G32_SINT),
        (4, vk::Format::R32G32B32A32_SINT),
    ];
}

/// A view of a buffer as texels of one, two or four `S`; keeps the buffer alive.
pub struct Texels<S> {
    view: TexelsCore,
    scalar: PhantomData<S>,
}

/// The part of [`Texels`] that does not depend on the scalar.
pub struct TexelsCore {
    /// None where kernels reach the buffer without it.
    raw: Option<vk::BufferView>,
    buffer: Arc<BufferCore>,
    components: u32,
}

impl<S: TexelScalar> Texels<S> {
    /// Views a device buffer as texels of `components` scalars (1, 2 or 4).
    ///
    /// Kernels in their form for graphics cards take the buffer itself, as a storage block or in pages. A buffer with more texels than a
    /// view holds has no view there, and draws cannot read it.
    ///
    /// # Errors
    /// More texels than this device has in one view, or in one block.
    ///
    /// # Panics
    /// If the components are not 1, 2 or 4, the buffer is not a device buffer or does not divide into texels.
    pub fn new<T: Pod>(buffer: &Buffer<T>, components: usize) -> GpuResult<Self> {
        let texels = buffer.size_in_bytes() / (4 * components as u64);
        Self::of_part(buffer, components, 0..texels)
    }

    /// Views a part of a device buffer, which begins at a multiple of [`PART`] texels.
    ///
    /// # Errors
    /// As [`Texels::new`].
    ///
    /// # Panics
    /// As [`Texels::new`]; if the part does not begin so, or does not lie in the buffer.
    pub fn of_part<T: Pod>(
        buffer: &Buffer<T>,
        components: usize,
        part: std::ops::Range<u64>,
    ) -> GpuResult<Self> {
        let core = buffer.core().shared();
        let format = S::FORMATS
            .iter()
            .find(|(n, _)| *n == components)
            .map(|(_, format)| *format);
        let format =
            format.unwrap_or_else(|| panic!("a texel has 1, 2 or 4 components, not {components}"));
        assert!(
            core.domain().is_on_device(),
            "`{}` is not a device buffer",
            core.name()
        );
        let texel = 4 * components as u64;
        assert!(
            core.size_in_bytes().is_multiple_of(texel),
            "`{}` does not divide into texels of {texel} bytes",
            core.name()
        );
        let limit = u64::from(core.ctx().info().max_texel_buffer_elements);
        assert!(
            part.start.is_multiple_of(PART)
                && part.start <= part.end
                && part.end * texel <= core.size_in_bytes(),
            "`{}` has no part {part:?}",
            core.name()
        );
        let count = part.end - part.start;
        let whole = count * texel == core.size_in_bytes();
        if whole && count > limit && core.is_reached_without_view() {
            return Ok(Self {
                view: TexelsCore {
                    raw: None,
                    buffer: core,
                    components: components as u32,
                },
                scalar: PhantomData,
            });
        }
        if count > limit {
            return Err(GpuError::TooLarge {
                object: core.name().to_owned(),
                len: count,
                size: count * texel,
                limit_name: "maxTexelBufferElements",
                limit,
                largest: limit,
            });
        }
        let info = vk::BufferViewCreateInfo::default()
            .buffer(core.whole())
            .format(format)
            .offset(part.start * texel)
            // Vulkan has no empty views; buffers without elements have this much memory, too.
            .range((count * texel).max(texel));
        // SAFETY: the buffer is alive, and was made for texel views.
        let raw = unsafe { core.ctx().device.raw.create_buffer_view(&info, None) }
            .check("vkCreateBufferView", core.name())?;
        Ok(Self {
            view: TexelsCore {
                raw: Some(raw),
                buffer: core,
                components: components as u32,
            },
            scalar: PhantomData,
        })
    }

    /// The part without the scalar type.
    #[must_use]
    pub fn as_dyn(&self) -> &TexelsCore {
        &self.view
    }
}

impl TexelsCore {
    /// Null where there is none.
    pub(crate) fn raw(&self) -> vk::BufferView {
        self.raw.unwrap_or_default()
    }

    pub(crate) fn assert_viewed(&self) {
        assert!(
            self.raw.is_some(),
            "`{}` has {} bytes, more than a view of it has texels, and is bound as a texel buffer",
            self.buffer.name(),
            self.buffer.size_in_bytes()
        );
    }

    pub(crate) fn components(&self) -> u32 {
        self.components
    }
}

impl AnyBuffer for TexelsCore {
    fn core(&self) -> &BufferCore {
        &self.buffer
    }
}

impl Drop for TexelsCore {
    fn drop(&mut self) {
        if let Some(raw) = self.raw {
            self.buffer
                .ctx()
                .deletion_queue
                .add(Deletion::BufferView(raw));
        }
    }
}
