//! Draws an egui interface over a picture.
//!
//! The only file that uses `egui-ash-renderer`. Interfaces blend in the encoded values that they are designed in, so
//! this draws to images whose format is NOT sRGB and stores values as they are.

use std::sync::Arc;

use ash::vk;
use egui::epaint::ImageDelta;
use egui::{ClippedPrimitive, ColorImage, ImageData, TextureId, TexturesDelta};
use egui_ash_renderer::{
    DynamicRendering, Options, RenderMode, Renderer as EguiRenderer, RendererError,
    allocator::GpuAllocator,
};

use crate::error::{Error, Result};
use crate::gpu::{Context, Format, GpuError, PassRecorder, no_rendering};

/// The objects that egui needs on the device.
pub struct Gui {
    ctx: Arc<Context>,
    /// Taken by `drop` only.
    renderer: Option<EguiRenderer<GpuAllocator>>,
    /// For uploads of textures.
    pool: vk::CommandPool,
    letters: Letters,
}

/// What the texture of all letters holds, the only one that egui changes in parts. `egui-ash-renderer` gives up the rest of a texture when
/// it changes a part (the old layout of its barrier is undefined), which some devices take literally, and does not wait for a frame that
/// still reads it. So the texture is made again as a whole, for which it does wait.
#[derive(Default)]
struct Letters(Arc<ColorImage>);

impl Letters {
    /// The change, as one of the whole texture if it is one of letters.
    fn whole(&mut self, id: TextureId, change: ImageDelta) -> ImageDelta {
        if id != TextureId::default() {
            return change;
        }
        let ImageData::Color(part) = change.image;
        match change.pos {
            None => self.0 = part,
            Some([left, top]) => {
                let whole = Arc::make_mut(&mut self.0);
                let width = whole.width();
                for (row, pixels) in part.pixels.chunks(part.width().max(1)).enumerate() {
                    let first = (top + row) * width + left;
                    whole.pixels[first..first + pixels.len()].copy_from_slice(pixels);
                }
            }
        }
        ImageDelta::full(Arc::clone(&self.0), change.options)
    }
}

impl Gui {
    /// A painter for images of this format, with the window's number of frames in flight.
    ///
    /// # Errors
    /// When the device cannot draw, refuses the pipeline or has no memory.
    pub fn new(ctx: &Arc<Context>, format: Format, frames_in_flight: usize) -> Result<Self> {
        if !ctx.info().has_dynamic_rendering {
            return Err(no_rendering(ctx, "the interface").into());
        }
        let options = Options {
            in_flight_frames: frames_in_flight,
            srgb_framebuffer: false,
            ..Options::default()
        };
        let mode = RenderMode::DynamicRendering(DynamicRendering {
            color_attachment_format: format.raw(),
            depth_attachment_format: None,
            stencil_attachment_format: None,
        });
        let device = ctx.raw_device();
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(ctx.queue_family())
            .flags(vk::CommandPoolCreateFlags::TRANSIENT);
        // SAFETY: the device is alive.
        let pool = unsafe { device.create_command_pool(&info, None) }
            .map_err(|source| failed("vkCreateCommandPool", source.into()))?;
        // The pool has its owner before anything else can fail.
        let mut gui = Self {
            ctx: Arc::clone(ctx),
            renderer: None,
            pool,
            letters: Letters::default(),
        };
        let renderer =
            EguiRenderer::with_gpu_allocator(ctx.allocator(), device.clone(), mode, options);
        gui.renderer = Some(renderer.map_err(|source| failed("making the pipeline", source))?);
        Ok(gui)
    }

    /// Applies changes of egui's textures. Rare (a letter that was not shown before, a closed image), so it
    /// may wait for the device.
    ///
    /// # Errors
    /// When there is no memory, or the device is lost.
    pub fn update_textures(&mut self, mut delta: TexturesDelta) -> Result<()> {
        let Some(renderer) = &mut self.renderer else {
            return Ok(());
        };
        // The renderer waits as well, but without limit.
        if !delta.is_empty()
            && let Err(error) = self.ctx.wait_idle()
        {
            // The textures are lost with the device; egui would report dropped changes as a mistake.
            delta.clear();
            return Err(error.into());
        }
        let mut first_error = None;
        for (id, changes) in delta.set.drain() {
            for change in changes {
                let change = self.letters.whole(id, change);
                let queue = self.ctx.queue();
                if let Err(error) = renderer.set_texture(*queue, self.pool, id, &change) {
                    first_error.get_or_insert(error);
                }
            }
        }
        for id in delta.free.drain() {
            if let Err(error) = renderer.free_texture(id) {
                first_error.get_or_insert(error);
            }
        }
        first_error.map_or(Ok(()), |error| Err(failed("a texture", error)))
    }

    /// Draws an interface over the content of the pass; the pass must have no depth and one sample a pixel.
    ///
    /// # Errors
    /// When there is no memory for the vertices.
    pub fn draw(
        &mut self,
        pass: &mut PassRecorder<'_>,
        size: [u32; 2],
        pixels_per_point: f32,
        primitives: &[ClippedPrimitive],
    ) -> Result<()> {
        let [width, height] = size;
        let extent = vk::Extent2D { width, height };
        let Some(renderer) = &mut self.renderer else {
            return Ok(());
        };
        renderer
            .cmd_draw(pass.raw(), extent, pixels_per_point, primitives)
            .map_err(|source| failed("drawing", source))
    }
}

impl Drop for Gui {
    fn drop(&mut self) {
        // egui's renderer frees its objects at once; the device must have finished with them.
        if !self.ctx.finishes() {
            std::mem::forget((self.renderer.take(), Arc::clone(&self.ctx)));
            return;
        }
        self.renderer = None;
        // SAFETY: nothing uses the pool any more.
        unsafe { self.ctx.raw_device().destroy_command_pool(self.pool, None) };
    }
}

fn failed(what: &str, source: RendererError) -> Error {
    if matches!(source, RendererError::Vulkan(vk::Result::ERROR_DEVICE_LOST)) {
        return Error::Gpu(GpuError::DeviceLost {
            call: "drawing the interface",
            last: format!("it was busy with {what}"),
        });
    }
    Error::Invalid(format!(
        "the interface could not be drawn ({what}: {source}): close other programs that use the device, or name another with --device"
    ))
}

#[cfg(test)]
mod tests {
    use egui::{Color32, TextureOptions};

    use super::*;

    /// Would catch: letters of before that are lost when one more is shown, and a part that lies elsewhere.
    #[test]
    fn parts_of_letters_become_the_whole_texture() {
        let filled = |size, grey| ColorImage::filled(size, Color32::from_gray(grey));
        let options = TextureOptions::LINEAR;
        let mut letters = Letters::default();
        let id = TextureId::default();
        let _ = letters.whole(id, ImageDelta::full(filled([5, 4], 1), options));
        for (at, size, grey) in [([3, 0], [2, 2], 2), ([0, 3], [1, 1], 3)] {
            let part = ImageDelta::partial(at, filled(size, grey), options);
            let change = letters.whole(id, part);
            assert_eq!((change.pos, change.image.size()), (None, [5, 4]));
        }
        let greys: Vec<u8> = letters.0.pixels.iter().map(|pixel| pixel.r()).collect();
        let rows = [[1, 1, 1, 2, 2], [1, 1, 1, 2, 2], [1; 5], [3, 1, 1, 1, 1]];
        assert_eq!(greys, rows.as_flattened());
        let other = ImageDelta::full(filled([1, 1], 9), options);
        assert_eq!(
            letters.whole(TextureId::User(1), other).image.size(),
            [1, 1]
        );
        assert_eq!(letters.0.size, [5, 4]);
    }
}
