//! The lines of the network over the picture. They follow the camera and the objects from frame to frame, and so does what hides them.

use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{Color32, Rect, Stroke, Ui, vec2};
use glam::Vec2;
use myxo::render::Camera;
use myxo::render::network_lines::{DARK, DIMMED, LINES, Viewpoint};

use crate::lab::facts::NetworkFacts;

/// A frame spends no more on which points are hidden. Of a large network the rest follows in the next frames.
const LOOKS_FOR: Duration = Duration::from_millis(4);
/// Points from one look at the clock to the next.
const AT_ONCE: usize = 256;

/// The lines as they were drawn last.
#[derive(Clone, Debug, Default)]
pub struct NetworkOverlay {
    found: Option<Arc<NetworkFacts>>,
    /// From where the points are looked at, and which are seen.
    from: Viewpoint,
    seen: Vec<bool>,
    /// The next point to look at, and how many are left.
    next: usize,
    left: usize,
}

impl NetworkOverlay {
    /// Nothing is shown.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Draws the lines of a network over the picture that `camera` takes from there.
    pub fn show(
        &mut self,
        ui: &Ui,
        picture: Rect,
        found: &Arc<NetworkFacts>,
        camera: &Camera,
        from: Viewpoint,
    ) {
        self.follow(found, from);
        self.look(found);
        if self.left > 0 {
            ui.ctx().request_repaint();
        }
        self.draw(ui, picture, found, camera);
    }

    /// Another network is shown, or from elsewhere. Until a point is looked at it counts as seen, or not, as before.
    fn follow(&mut self, found: &Arc<NetworkFacts>, from: Viewpoint) {
        let known = self.found.as_ref();
        if !known.is_some_and(|known| Arc::ptr_eq(known, found)) {
            self.found = Some(Arc::clone(found));
            self.from.clone_from(&found.from);
            self.seen.clone_from(&found.seen);
            (self.next, self.left) = (0, 0);
        }
        if self.from != from {
            self.from = from;
            self.left = found.lines.count();
        }
    }

    /// Looks at points, one after the other.
    fn look(&mut self, found: &NetworkFacts) {
        let count = found.lines.count();
        let begun = Instant::now();
        while self.left > 0 {
            let end = count.min(self.next + AT_ONCE.min(self.left));
            let points = self.next..end;
            (found.lines).look(&found.sight, &self.from, points, &mut self.seen);
            self.left -= end - self.next;
            self.next = if end == count { 0 } else { end };
            if begun.elapsed() >= LOOKS_FOR {
                break;
            }
        }
    }

    fn draw(&self, ui: &Ui, picture: Rect, found: &NetworkFacts, camera: &Camera) {
        let scale = ui.ctx().pixels_per_point();
        let size = scale * Vec2::new(picture.width(), picture.height());
        let strokes = found.lines.strokes(&self.seen, &self.from, camera, size);
        let painter = ui.painter_at(picture);
        let dark = (255.0 * (1.0 - DIMMED)).round() as u8;
        painter.rect_filled(picture, 0.0, Color32::from_black_alpha(dark));
        let at = |pixel: &Vec2| picture.min + vec2(pixel.x, pixel.y) / scale;
        let wide = strokes.half_width + strokes.outline;
        for (half, color) in [(wide, DARK), (strokes.half_width, LINES)] {
            let stroke = Stroke::new(2.0 * half / scale, color_of(color));
            for line in &strokes.lines {
                painter.line(line.iter().map(at).collect(), stroke);
            }
        }
        for disc in &strokes.discs {
            let middle = at(&disc.middle);
            let wide = disc.radius + strokes.outline;
            for (radius, color) in [(wide, DARK), (disc.radius, disc.color)] {
                painter.circle_filled(middle, radius / scale, color_of(color));
            }
        }
    }
}

/// A colour of lines or nodes, as the interface has it.
pub fn color_of([red, green, blue]: [u8; 3]) -> Color32 {
    Color32::from_rgb(red, green, blue)
}
