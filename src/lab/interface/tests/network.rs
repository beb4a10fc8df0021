//! The network's lines over the picture.

use std::sync::Arc;

use egui::Shape;
use egui::epaint::ColorMode;
use glam::Affine3A;
use myxo::render::network_lines::{LINES, NetworkLines, Sight};
use myxo::render::pick::pick;
use myxo::sim::Setup;
use myxo::sim::graph::{Edge, Graph, Measures};

use super::*;
use crate::lab::facts::NetworkFacts;
use crate::lab::network_overlay::color_of;

/// Points of the line that is drawn.
const POINTS: usize = 12;

impl Harness {
    /// The lines of the network in the last frame.
    fn lines(&self) -> Vec<Vec<Pos2>> {
        fn look(shape: &Shape, found: &mut Vec<Vec<Pos2>>) {
            match shape {
                Shape::Vec(shapes) => shapes.iter().for_each(|shape| look(shape, found)),
                Shape::Path(path) if path.stroke.color == ColorMode::Solid(color_of(LINES)) => {
                    found.push(path.points.clone());
                }
                _ => {}
            }
        }
        let mut found = Vec::new();
        let shapes = self.shapes.iter();
        shapes.for_each(|clipped| look(&clipped.shape, &mut found));
        found
    }

    /// Gives the interface a network with one line that the picture sees; where it is to be drawn.
    fn has_a_network(&mut self) -> Vec<Pos2> {
        let mut settings = Settings::default();
        settings.particles.count = 10;
        settings.atlas.size = 128;
        let scene = Scene::from_settings("torus".to_owned(), settings, ".".into()).unwrap();
        let setup = Setup::new(&scene).unwrap();
        let poses = vec![Affine3A::IDENTITY];
        let picture = self.frame(vec![]).picture;
        let size = Vec2::new(picture.width(), picture.height());
        let camera = self.interface.document.view.camera;
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
        let mut rows = (0..size.y as u32).step_by(4);
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
        self.facts.pointer.poses = poses;
        // It was found from elsewhere, from where nothing was seen.
        self.facts.network = Some(Arc::new(NetworkFacts {
            step: 1234,
            replaced: 0,
            measures: Measures {
                nodes: 2,
                edges: 1,
                length: 0.1,
                ..Measures::default()
            },
            seen: vec![false; lines.count()],
            lines,
            sight: Arc::new(Sight::new(&setup)),
            from: Viewpoint::default(),
        }));
        let points = row
            .iter()
            .map(|(pixel, _)| picture.min + vec2(pixel.x, pixel.y));
        points.collect()
    }
}

/// Would catch: lines that are drawn without being asked for, beside their places, on an object that was moved or hidden, on the flat
/// atlas, or in a scene that has gone.
#[test]
fn lines_are_where_their_object_is_while_they_are_asked_for() {
    let mut harness = Harness::new();
    let places = harness.has_a_network();
    harness.frame(vec![]);
    assert!(harness.lines().is_empty(), "they are not asked for");
    harness.press(Key::N);
    harness.frame(vec![]);
    let lines = harness.lines();
    let [line] = &lines[..] else {
        panic!("{lines:?}")
    };
    assert_eq!(line.len(), POINTS);
    for (at, place) in line.iter().zip(&places) {
        assert!(at.distance(*place) < 0.1, "{at:?}, not {place:?}");
    }
    let text = "step 1,234: 2 nodes, 1 edge of 0.10 radii, 0 cycles";
    assert_eq!(harness.places_of(text).len(), 1);
    // Dragged up, with its line.
    let before = line.clone();
    let up = Affine3A::from_translation(0.05 * Vec3::Y);
    harness.facts.pointer.poses = vec![up];
    harness.frame(vec![]);
    let moved = harness.lines();
    assert!(moved[0][0].y < before[0].y - 2.0, "{moved:?}");
    harness.facts.pointer.poses = vec![Affine3A::IDENTITY];

    harness.interface.document.marks.hide(0, true);
    harness.frame(vec![]);
    assert!(harness.lines().is_empty(), "it is not drawn");
    harness.interface.document.marks.hide(0, false);
    // Flat, it has none, and the key changes nothing but says why.
    harness.press(Key::Num0);
    harness.frame(vec![]);
    assert!(harness.lines().is_empty() && !harness.interface.shows_network());
    harness.press(Key::N);
    let notice = harness.interface.notices.text().expect("it says why");
    assert!(notice.contains("lie on the surface"), "{notice}");
    harness.press(Key::Num1);
    harness.frame(vec![]);
    let again = harness.lines();
    assert!(
        again[0][0].distance(before[0]) < 0.1,
        "{again:?}, not {before:?}"
    );
    // Another scene is there, and its network is not found yet.
    harness.facts.network = None;
    harness.frame(vec![]);
    assert!(harness.lines().is_empty() && harness.interface.shows_network());
    assert_eq!(harness.places_of("the network is being found").len(), 1);
    harness.press(Key::N);
    assert!(!harness.interface.shows_network());
}
