//! The lines of the network over the picture. They are drawn by the camera and the poses of the picture that they lie on, and only again
//! when those, or what objects hide, have changed.

use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::epaint::ClippedShape;
use egui::{ClippedPrimitive, Color32, Context, Rect, Shape, Stroke, pos2, vec2};
use glam::Vec2;
use myxo::render::network_lines::{DIMMED, Mark, Viewpoint};

use crate::lab::facts::NetworkFacts;
use crate::lab::place::Place;
use crate::lab::stage::PictureView;

/// A frame spends no more on finding which points are hidden. Of a large network the rest follows in the next frames.
const TESTS_FOR: Duration = Duration::from_millis(4);
/// Points from one look at the clock to the next.
const BATCH: usize = 256;

/// Where the lines are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Window {
    picture: Place,
    pixels_per_point: f32,
}

/// The lines of a network over a picture.
#[derive(Default)]
pub struct NetworkOverlay {
    found: Option<Arc<NetworkFacts>>,
    /// From where it is known which points are visible, and which are.
    from: Viewpoint,
    visible: Vec<bool>,
    /// The next point to test, and how many are left.
    next: usize,
    left: usize,
    /// What is drawn, and for which picture and where; none if what is visible has changed.
    drawn: Option<(PictureView, Window)>,
    primitives: Vec<ClippedPrimitive>,
}

impl NetworkOverlay {
    /// Nothing is shown.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Another network is shown, or another picture. Until a point is tested it counts as visible, or not, as before.
    pub fn follow(&mut self, found: &Arc<NetworkFacts>, view: &PictureView) {
        let known = self.found.as_ref();
        if !known.is_some_and(|known| Arc::ptr_eq(known, found)) {
            self.found = Some(Arc::clone(found));
            self.from.clone_from(&found.from);
            self.visible.clone_from(&found.visible);
            (self.next, self.left) = (0, 0);
            self.drawn = None;
        }
        if self.from != view.from {
            self.from.clone_from(&view.from);
            self.left = found.lines.count();
        }
    }

    /// Tests points for a while.
    pub fn test_points(&mut self) {
        self.test_in_batches(BATCH, TESTS_FOR);
    }

    /// Tests points in batches of this size until `time` has gone by: one batch at the least.
    fn test_in_batches(&mut self, batch: usize, time: Duration) {
        let Some(found) = self.found.clone() else {
            return;
        };
        let begun = Instant::now();
        while self.left > 0 {
            let points = self.batch(batch, found.lines.count());
            let before = self.visible[points.clone()].to_vec();
            (found.lines).find_visible(&found.sight, &self.from, points.clone(), &mut self.visible);
            if self.visible[points] != before[..] {
                self.drawn = None;
            }
            if begun.elapsed() >= time {
                break;
            }
        }
    }

    /// The next points of `count`, which then count as tested.
    fn batch(&mut self, size: usize, count: usize) -> Range<usize> {
        let end = count.min(self.next + size.min(self.left));
        let points = self.next..end;
        self.left -= points.len();
        self.next = if end == count { 0 } else { end };
        points
    }

    /// Are there points left to test?
    pub fn is_testing(&self) -> bool {
        self.left > 0
    }

    /// What is drawn over a picture that lies in the middle of this place.
    pub fn primitives(
        &mut self,
        ctx: &Context,
        view: &PictureView,
        picture: Place,
        pixels_per_point: f32,
    ) -> &[ClippedPrimitive] {
        let window = Window {
            picture,
            pixels_per_point,
        };
        let is_drawn = |(of, at): &(PictureView, Window)| of == view && *at == window;
        if !self.drawn.as_ref().is_some_and(is_drawn) {
            let shapes = self.shapes(view, window);
            self.primitives = ctx.tessellate(shapes, pixels_per_point);
            self.drawn = Some((view.clone(), window));
        }
        &self.primitives
    }

    fn shapes(&self, view: &PictureView, window: Window) -> Vec<ClippedShape> {
        let Some(found) = &self.found else {
            return Vec::new();
        };
        let Place { corner, size } = window.picture;
        let scale = window.pixels_per_point;
        let [corner, size, canvas] =
            [corner, size, view.size].map(|[x, y]| Vec2::new(x as f32, y as f32));
        let first = corner + (0.5 * (size - canvas)).trunc();
        let at = |pixel: &Vec2| {
            let at = (first + *pixel) / scale;
            pos2(at.x, at.y)
        };
        let clip_rect = Rect::from_min_size(
            pos2(corner.x / scale, corner.y / scale),
            vec2(size.x / scale, size.y / scale),
        );
        let dark = (255.0 * (1.0 - DIMMED)).round() as u8;
        let strokes = (found.lines).strokes(&self.visible, &view.from, &view.camera, canvas);
        let marks = strokes.marks().map(|mark| match mark {
            Mark::Line {
                points,
                half_width,
                color,
            } => {
                let stroke = Stroke::new(2.0 * half_width / scale, color_of(color));
                Shape::line(points.iter().map(at).collect(), stroke)
            }
            Mark::Disc {
                middle,
                radius,
                color,
            } => Shape::circle_filled(at(&middle), radius / scale, color_of(color)),
        });
        let ground = Shape::rect_filled(clip_rect, 0.0, Color32::from_black_alpha(dark));
        let shapes = std::iter::once(ground).chain(marks);
        shapes
            .map(|shape| ClippedShape { clip_rect, shape })
            .collect()
    }
}

/// A colour of lines or nodes, as the interface has it.
pub fn color_of([red, green, blue]: [u8; 3]) -> Color32 {
    Color32::from_rgb(red, green, blue)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Affine3A, Vec3};
    use myxo::render::Camera;
    use myxo::render::network_lines::{LINES, NetworkLines, Sight};
    use myxo::render::pick::pick;
    use myxo::scene::Scene;
    use myxo::scene::settings::Settings;
    use myxo::sim::Setup;
    use myxo::sim::graph::{Edge, Graph, Measures};

    /// Points of the line that is drawn.
    const POINTS: usize = 12;
    const SIZE: [u32; 2] = [640, 480];

    /// A network with one line, which was found from elsewhere, from where nothing is visible; a view in which it is; and its pixels there.
    fn network() -> (Arc<NetworkFacts>, PictureView, Vec<Vec2>) {
        let mut settings = Settings::default();
        settings.particles.count = 10;
        settings.atlas.size = 128;
        let scene = Scene::from_settings("torus".to_owned(), settings, ".".into()).unwrap();
        let setup = Setup::new(&scene).unwrap();
        let poses = vec![Affine3A::IDENTITY];
        let size = Vec2::new(SIZE[0] as f32, SIZE[1] as f32);
        let camera = Camera::fitted(setup.center, setup.radius, size);
        let place = |pixel: Vec2| {
            let hit = pick(&setup.surface, &poses, &camera.ray(pixel, size))?;
            Some((hit.position / setup.radius).as_dvec3().to_array())
        };
        // A row of pixels that the torus fills, a little below its upper edge.
        let row = |y: u32| {
            let pixels = (0..POINTS).map(|i| {
                let x = 0.45 * size.x + 3.0 * i as f32;
                Vec2::new(x.round(), y as f32)
            });
            let row = pixels.map(|pixel| Some((pixel, place(pixel)?)));
            row.collect::<Option<Vec<_>>>()
        };
        let mut rows = (0..SIZE[1]).step_by(4);
        let row = rows.find_map(|y| row(y).and_then(|_| row(y + 16)));
        let row = row.expect("the torus is in the picture");
        let graph = Graph {
            nodes: Vec::new(),
            edges: vec![Edge {
                from: 0,
                to: 0,
                length: 0.1,
                width: 0.1,
                trail: 1.0,
                points: row.iter().map(|(_, place)| *place).collect(),
                objects: vec![0; POINTS],
                breaks: Vec::new(),
            }],
        };
        let lines = NetworkLines::new(&graph, &setup, &poses, 1);
        let found = NetworkFacts {
            step: 1234,
            replaced: 0,
            measures: Measures::default(),
            visible: vec![false; lines.count()],
            lines,
            sight: Arc::new(Sight::new(&setup)),
            from: Viewpoint::default(),
        };
        let from = Viewpoint {
            eye: camera.eye(),
            poses,
            hidden: Vec::new(),
        };
        let view = PictureView {
            camera,
            size: SIZE,
            from,
        };
        let pixels = row.iter().map(|(pixel, _)| *pixel);
        (Arc::new(found), view, pixels.collect())
    }

    /// The window has two pixels a point, and the picture is 10 and 30 pixels from its corner.
    const WINDOW: Window = Window {
        picture: Place {
            corner: [10, 30],
            size: SIZE,
        },
        pixels_per_point: 2.0,
    };

    /// The points of the bright lines, in pixels of the picture.
    fn lines(overlay: &NetworkOverlay, view: &PictureView, window: Window) -> Vec<Vec<Vec2>> {
        let bright = egui::epaint::ColorMode::Solid(color_of(LINES));
        let shapes = overlay.shapes(view, window).into_iter();
        let lines = shapes.filter_map(|clipped| match clipped.shape {
            Shape::Path(path) if path.stroke.color == bright => Some(path.points),
            _ => None,
        });
        let pixels = lines.map(|points| {
            let pixels = points.iter().map(|at| {
                let at = WINDOW.pixels_per_point * Vec2::new(at.x, at.y);
                at - Vec2::new(10.0, 30.0)
            });
            pixels.collect()
        });
        pixels.collect()
    }

    /// Would catch: lines beside their places, on an object that has moved or is hidden, and beside a picture that is larger or smaller
    /// than its place.
    #[test]
    fn lines_are_where_the_picture_has_their_object() {
        let (found, view, pixels) = network();
        let mut overlay = NetworkOverlay::default();
        overlay.follow(&found, &view);
        assert!(lines(&overlay, &view, WINDOW).is_empty(), "from elsewhere");
        overlay.test_in_batches(POINTS, Duration::MAX);
        let first = lines(&overlay, &view, WINDOW);
        assert_eq!((first.len(), first[0].len()), (1, POINTS));
        for (at, pixel) in first[0].iter().zip(&pixels) {
            assert!(at.distance(*pixel) < 0.1, "{at}, not {pixel}");
        }
        // In a wider and lower place the picture is in the middle.
        let mut other = WINDOW;
        other.picture.size = [SIZE[0] + 100, SIZE[1] - 60];
        let beside = lines(&overlay, &view, other);
        let by = beside[0][0] - first[0][0];
        assert!(by.distance(Vec2::new(50.0, -30.0)) < 0.01, "{by}");

        let mut moved = view.clone();
        moved.from.poses = vec![Affine3A::from_translation(0.05 * Vec3::Y)];
        overlay.follow(&found, &moved);
        overlay.test_points();
        let up = lines(&overlay, &moved, WINDOW);
        assert!(up[0][0].y < first[0][0].y - 2.0, "{up:?}");
        let mut hidden = view.clone();
        hidden.from.hidden = vec![true];
        overlay.follow(&found, &hidden);
        overlay.test_points();
        assert!(lines(&overlay, &hidden, WINDOW).is_empty());
        overlay.clear();
        assert!(overlay.shapes(&view, WINDOW).is_empty());
    }

    /// Would catch: points that are never tested, or again and again; a frame that tests all though its time is over; and lines that are
    /// made again though nothing has changed, or not though a point has come into sight.
    #[test]
    fn points_are_tested_in_batches_and_lines_are_made_when_they_change() {
        let (found, view, _) = network();
        let ctx = Context::default();
        let output = ctx.run_ui(egui::RawInput::default(), |_| {});
        output.drop_without_applying_deltas();
        let mut overlay = NetworkOverlay::default();
        overlay.follow(&found, &view);
        let count = |overlay: &NetworkOverlay| overlay.visible.iter().filter(|is| **is).count();
        let scale = WINDOW.pixels_per_point;
        for tested in [4, 8, 12] {
            overlay.primitives(&ctx, &view, WINDOW.picture, scale);
            assert!(overlay.drawn.is_some() && overlay.is_testing());
            overlay.test_in_batches(4, Duration::ZERO);
            assert_eq!(count(&overlay), tested);
            assert!(overlay.drawn.is_none(), "more of it is visible");
        }
        assert!(!overlay.is_testing());
        overlay.primitives(&ctx, &view, WINDOW.picture, scale);
        // The camera turns a little, and back: all are tested again, and are visible as before.
        let mut turned = view.clone();
        turned.from.eye += 0.001 * Vec3::X;
        for view in [&turned, &view] {
            overlay.follow(&found, view);
            overlay.test_in_batches(5, Duration::ZERO);
            assert!(overlay.is_testing() && overlay.drawn.is_some());
        }
        overlay.test_in_batches(5, Duration::MAX);
        assert!(!overlay.is_testing() && overlay.drawn.is_some());
        assert_eq!(count(&overlay), POINTS);
        let before = overlay.primitives.as_ptr();
        overlay.primitives(&ctx, &view, WINDOW.picture, scale);
        assert_eq!(overlay.primitives.as_ptr(), before, "nothing has changed");
        assert!(!overlay.primitives.is_empty());
    }
}
