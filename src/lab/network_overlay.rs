//! The lines of the network over the picture. They are drawn by the camera and the poses of the picture that they lie on, and only again
//! when those, or what objects hide, have changed.

use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::epaint::{ClippedShape, TessellationOptions, Tessellator};
use egui::{ClippedPrimitive, Color32, Rect, Shape, Stroke, pos2, vec2};
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

    /// Makes what is drawn over a picture that lies in the middle of this place, if something has changed.
    pub fn make(&mut self, view: &PictureView, picture: Place, pixels_per_point: f32) {
        let window = Window {
            picture,
            pixels_per_point,
        };
        let is_drawn = |(of, at): &(PictureView, Window)| of == view && *at == window;
        if !self.drawn.as_ref().is_some_and(is_drawn) {
            let shapes = self.shapes(view, window);
            // The interface would take small discs from its texture of letters, where their places change. These shapes stay longer.
            let options = TessellationOptions {
                prerasterized_discs: false,
                ..TessellationOptions::default()
            };
            let mut tessellator = Tessellator::new(pixels_per_point, options, [1, 1], Vec::new());
            self.primitives = tessellator.tessellate_shapes(shapes);
            self.drawn = Some((view.clone(), window));
        }
    }

    /// Draws what was made, and the interface over it, without a copy of either. Nothing is drawn without an interface.
    pub fn draw_below<T>(
        &mut self,
        interface: Vec<ClippedPrimitive>,
        draw: impl FnOnce(&[ClippedPrimitive]) -> T,
    ) -> T {
        if interface.is_empty() {
            return draw(&[]);
        }
        let count = self.primitives.len();
        self.primitives.extend(interface);
        let drawn = draw(&self.primitives);
        self.primitives.truncate(count);
        drawn
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
    use egui::epaint::{Primitive, Vertex, WHITE_UV};
    use glam::{Affine3A, Vec3};
    use myxo::render::Camera;
    use myxo::render::network_lines::{LINES, NODES, NetworkLines, Sight};
    use myxo::render::pick::pick;
    use myxo::scene::Scene;
    use myxo::scene::settings::Settings;
    use myxo::sim::Setup;
    use myxo::sim::graph::{Edge, Graph, Measures, Node, NodeKind};

    /// Points of the line that is drawn.
    const POINTS: usize = 12;
    const SIZE: [u32; 2] = [640, 480];

    /// A network with one line and a node at its end, which was found from elsewhere, from where nothing is visible; a view in which it is;
    /// and the line's pixels there.
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
            nodes: vec![Node {
                kind: NodeKind::End,
                object: 0,
                place: row[POINTS - 1].1,
                degree: 1,
                width: 0.1,
                foods: Vec::new(),
            }],
            edges: vec![Edge {
                from: 0,
                to: 0,
                length: 0.1,
                way: 0.1,
                beyond: [0.0; 2],
                width: 0.1,
                trail: 1.0,
                points: row.iter().map(|(_, place)| *place).collect(),
                objects: vec![0; POINTS],
                half_widths: Vec::new(),
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
        overlay.test_in_batches(BATCH, Duration::MAX);
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
    /// made again though nothing has changed or they were drawn, or not though a point has come into sight.
    #[test]
    fn points_are_tested_in_batches_and_lines_are_made_when_they_change() {
        let (found, view, _) = network();
        let mut overlay = NetworkOverlay::default();
        overlay.follow(&found, &view);
        let count = |overlay: &NetworkOverlay| overlay.visible.iter().filter(|is| **is).count();
        let scale = WINDOW.pixels_per_point;
        // The line has twelve points, and the node is one.
        for tested in [4, 8, 12, 13] {
            overlay.make(&view, WINDOW.picture, scale);
            assert!(overlay.drawn.is_some() && overlay.is_testing());
            overlay.test_in_batches(4, Duration::ZERO);
            assert_eq!(count(&overlay), tested);
            assert!(overlay.drawn.is_none(), "more of it is visible");
        }
        assert!(!overlay.is_testing());
        overlay.make(&view, WINDOW.picture, scale);
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
        assert_eq!(count(&overlay), POINTS + 1);
        let made = |overlay: &NetworkOverlay| -> Vec<*const Vertex> {
            let meshes = overlay.primitives.iter().map(mesh);
            meshes.map(<[Vertex]>::as_ptr).collect()
        };
        let before = made(&overlay);
        assert!(!before.is_empty());
        let interface = overlay.primitives.clone();
        let all = overlay.draw_below(interface, <[ClippedPrimitive]>::len);
        assert_eq!(all, 2 * before.len());
        assert_eq!(overlay.draw_below(Vec::new(), <[ClippedPrimitive]>::len), 0);
        overlay.make(&view, WINDOW.picture, scale);
        assert_eq!(made(&overlay), before, "nothing has changed");
    }

    /// The vertices of a mesh.
    fn mesh(clipped: &ClippedPrimitive) -> &[Vertex] {
        match &clipped.primitive {
            Primitive::Mesh(mesh) => &mesh.vertices,
            Primitive::Callback(_) => panic!("only meshes are drawn"),
        }
    }

    /// Would catch: nodes that are drawn with a part of the texture of letters, which is elsewhere when letters have come.
    #[test]
    fn nothing_is_taken_from_the_texture_of_letters() {
        let (found, view, _) = network();
        let mut overlay = NetworkOverlay::default();
        overlay.follow(&found, &view);
        overlay.test_in_batches(BATCH, Duration::MAX);
        overlay.make(&view, WINDOW.picture, WINDOW.pixels_per_point);
        let vertices: Vec<Vertex> = (overlay.primitives.iter())
            .flat_map(|clipped| mesh(clipped).to_vec())
            .collect();
        for color in [LINES, NODES].map(color_of) {
            assert!(vertices.iter().any(|vertex| vertex.color == color));
        }
        assert!(vertices.iter().all(|vertex| vertex.uv == WHITE_UV));
    }
}
