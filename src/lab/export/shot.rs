//! A picture of any size, drawn in parts that are small enough for the window to continue between them.

use std::sync::Arc;
use std::time::{Duration, Instant};

use myxo::Result;
use myxo::gpu::{Buffer, Context, Domain, Format, Frames};
use myxo::render::exposure::Exposure;
use myxo::render::{Canvas, View};

use crate::lab::export::encoder::Frame;
use crate::lab::stage::Stage;

/// The time that one part should take.
const PART: Duration = Duration::from_millis(35);
/// Rows of the first part.
const FIRST_ROWS: u32 = 64;

/// A picture that is being drawn.
pub struct Shot {
    canvas: Canvas,
    pixels: Buffer<[u8; 4]>,
    format: Format,
    /// Rows that are drawn.
    done: u32,
    /// Rows of the next part.
    rows: u32,
}

impl Shot {
    /// Nothing is drawn.
    pub fn new(ctx: &Arc<Context>, size: [u32; 2], format: Format) -> Result<Self> {
        let count = size[0] as usize * size[1] as usize;
        Ok(Self {
            canvas: Canvas::new(ctx, size, format)?,
            pixels: Buffer::new(ctx, "picture.pixels", count, Domain::Readback)?,
            format,
            done: 0,
            rows: FIRST_ROWS,
        })
    }

    /// The share that is drawn.
    pub fn share(&self) -> f32 {
        self.done as f32 / self.canvas.size()[1] as f32
    }

    /// Draws the next part and waits for it; true when the picture is whole. The state must stay as it is until then. The
    /// exposure follows the trail in the first part only.
    pub fn advance(&mut self, frames: &mut Frames, stage: &mut Stage, view: &View) -> Result<bool> {
        let begun = Instant::now();
        let height = self.canvas.size()[1];
        let end = height.min(self.done + self.rows);
        let mut view = *view;
        if let (1.., Exposure::Auto { adaptation, .. }) = (self.done, &mut view.exposure) {
            *adaptation = 0.0;
        }
        let mut rec = frames.begin()?;
        stage.draw_rows(&mut rec, &view, &self.canvas, self.done..end);
        let is_whole = end == height;
        if is_whole {
            rec.copy_image(self.canvas.image(), &self.pixels);
        }
        frames.submit(rec)?;
        frames.wait_idle()?;
        self.done = end;
        let factor = PART.as_secs_f64() / begun.elapsed().as_secs_f64().max(1e-4);
        self.rows = (f64::from(self.rows) * factor.clamp(0.25, 2.0)).ceil() as u32;
        Ok(is_whole)
    }

    /// The whole picture; the next one begins.
    pub fn take(&mut self, number: u64, view: &View) -> Frame {
        self.done = 0;
        Frame {
            number,
            size: self.canvas.size(),
            pixels: self.pixels.as_slice().as_flattened().to_vec(),
            is_blue_first: self.format == Format::Bgra8Srgb,
            is_transparent: view.is_transparent,
        }
    }
}
