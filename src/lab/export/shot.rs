//! A picture of any size, drawn in parts that are small enough for the window to continue between them; it may be the
//! mean of many.

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::UVec2;
use myxo::Result;
use myxo::gpu::{Buffer, Context, Domain, Format, Frames};
use myxo::render::exposure::Exposure;
use myxo::render::lens;
use myxo::render::mean::{self, Mean};
use myxo::render::{Camera, Canvas, View};

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
    passes: Option<Passes>,
    /// The stage's changes when the picture was begun.
    changes: u64,
    /// Rows that are drawn.
    done: u32,
    /// Rows of the next part.
    rows: u32,
}

/// How often a picture is drawn, and from where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Care {
    /// Once.
    Once,
    /// Several times from places within a pixel, as the window's picture at rest.
    Fine,
    /// From all over a lens of this diameter, world units, above 0.
    Lens(f32),
}

impl Care {
    /// For this view, with a lens of this diameter, world units, if that is above 0. Flat views have no use for more than one picture.
    pub fn of(self, view: &View, lens: f32) -> Self {
        if view.show.is_flat() {
            Self::Once
        } else if lens > 0.0 {
            Self::Lens(lens)
        } else {
            self
        }
    }
}

/// The pictures whose mean a picture is.
struct Passes {
    care: Care,
    mean: Mean,
    /// The cameras of the present picture.
    cameras: Vec<Camera>,
    /// The number of the pass that is drawn.
    at: usize,
    /// Of the lens. It stays for all pictures of a film, so that the blur does not jump.
    focus: Option<f32>,
}

impl Shot {
    /// Nothing is drawn.
    pub fn new(ctx: &Arc<Context>, size: [u32; 2], format: Format, care: Care) -> Result<Self> {
        let mean = match care {
            Care::Once => None,
            // Where there is no memory for it, the picture is drawn once.
            Care::Fine => Mean::new(ctx, size).ok(),
            Care::Lens(_) => Some(Mean::new(ctx, size)?),
        };
        let passes = mean.map(|mean| Passes {
            care,
            mean,
            cameras: Vec::new(),
            at: 0,
            focus: None,
        });
        let count = size[0] as usize * size[1] as usize;
        Ok(Self {
            canvas: Canvas::new(ctx, size, format)?,
            pixels: Buffer::new(ctx, "picture.pixels", count, Domain::Readback)?,
            format,
            passes,
            changes: 0,
            done: 0,
            rows: FIRST_ROWS,
        })
    }

    /// The share that is drawn.
    pub fn share(&self) -> f32 {
        let share = self.done as f32 / self.canvas.size()[1] as f32;
        match &self.passes {
            Some(passes) => (passes.at as f32 + share) / passes.cameras.len().max(1) as f32,
            None => share,
        }
    }

    /// Draws the next part and waits for it; true when the picture is whole. The state must stay as it is until then. The
    /// exposure follows the trail in the first part only.
    pub fn advance(&mut self, frames: &mut Frames, stage: &mut Stage, view: &View) -> Result<bool> {
        let begun = Instant::now();
        if self.changes != stage.changes {
            // What was painted or hidden meanwhile is in all of the picture, or in none of it.
            self.changes = stage.changes;
            self.begin_again();
        }
        let height = self.canvas.size()[1];
        let end = height.min(self.done + self.rows);
        let mut view = *view;
        let mut is_first = self.done == 0;
        if let Some(passes) = &mut self.passes {
            if is_first && passes.at == 0 {
                passes.begin(stage, &view, self.canvas.size());
            }
            is_first &= passes.at == 0;
            view.camera = passes.cameras[passes.at];
        }
        if let (false, Exposure::Auto { adaptation, .. }) = (is_first, &mut view.exposure) {
            *adaptation = 0.0;
        }
        let mut rec = frames.begin()?;
        stage.draw_rows(&mut rec, &view, &self.canvas, self.done..end);
        self.done = end;
        let mut is_whole = end == height;
        if let Some(passes) = self.passes.as_mut().filter(|_| is_whole) {
            passes.mean.record(&mut rec, self.canvas.image());
            passes.at += 1;
            is_whole = passes.at == passes.cameras.len();
            if !is_whole {
                self.done = 0;
            }
        }
        if is_whole {
            rec.copy_image(self.canvas.image(), &self.pixels);
        }
        frames.submit(rec)?;
        frames.wait_idle()?;
        let factor = PART.as_secs_f64() / begun.elapsed().as_secs_f64().max(1e-4);
        self.rows = (f64::from(self.rows) * factor.clamp(0.25, 2.0)).ceil() as u32;
        Ok(is_whole)
    }

    fn begin_again(&mut self) {
        self.done = 0;
        if let Some(passes) = &mut self.passes {
            passes.at = 0;
        }
    }

    /// The whole picture; the next one begins.
    pub fn take(&mut self, number: u64, view: &View) -> Frame {
        self.begin_again();
        Frame {
            number,
            size: self.canvas.size(),
            pixels: self.pixels.as_slice().as_flattened().to_vec(),
            is_blue_first: self.format == Format::Bgra8Srgb,
            is_transparent: view.is_transparent,
        }
    }
}

impl Passes {
    /// The cameras of a picture; a lens is focused on what was in the middle of the first one.
    fn begin(&mut self, stage: &Stage, view: &View, size: [u32; 2]) {
        self.mean.restart();
        let camera = &view.camera;
        let all = match self.care {
            Care::Lens(diameter) => {
                let size = UVec2::from_array(size).as_vec2();
                let focus = *self
                    .focus
                    .get_or_insert_with(|| lens::focus(camera, stage.pick(view, 0.5 * size, size)));
                lens::cameras(camera, diameter, focus, lens::PLACES, size)
            }
            _ => vec![*camera; mean::FINE as usize],
        };
        let all = (0..).zip(&all);
        self.cameras = all
            .map(|(number, camera)| mean::within_pixel(camera, size, number))
            .collect();
    }
}
