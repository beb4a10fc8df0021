//! The network's graph, drawn over a picture of the scene: its edges as lines where they are seen, its nodes as discs.

use glam::{Affine3A, DVec3, Vec2, Vec3A};
use image::RgbaImage;

use super::camera::Camera;
use super::rays::Rays;
use crate::mesh::surface::Surface;
use crate::sim::Setup;
use crate::sim::graph::{Graph, NodeKind};

/// What is behind the lines keeps this share of its light.
const DIMMED: f32 = 0.55;
/// In small pictures lines are not finer than in one that is this high.
const SMALL: f32 = 540.0;
/// Half the width of a line, and the radii of nodes, in pixels of a picture that is 720 high.
const LINE: f32 = 1.1;
const JUNCTION: f32 = 3.0;
const END: f32 = 2.2;
const FOOD: f32 = 6.5;
/// The dark edge round each of them.
const OUTLINE: f32 = 1.1;
/// What is so much behind the surface is seen, as a share of the scene radius: points lie in the middles of texels.
const BEHIND: f32 = 0.012;

const DARK: [f32; 3] = [8.0, 14.0, 22.0];
const EDGE: [f32; 3] = [120.0, 226.0, 255.0];
const NODE: [f32; 3] = [255.0, 255.0, 255.0];
const AT_FOOD: [f32; 3] = [255.0, 196.0, 60.0];

/// Draws a graph over a picture that `camera` has taken of objects in these poses. What an object hides is left out. Camera and poses count
/// from the origin of the set-up.
pub fn draw_network(
    picture: &mut RgbaImage,
    graph: &Graph,
    setup: &Setup,
    world_from_object: &[Affine3A],
    camera: &Camera,
) {
    for pixel in picture.pixels_mut() {
        for light in &mut pixel.0[..3] {
            *light = (f32::from(*light) * DIMMED).round() as u8;
        }
    }
    let size = Vec2::new(picture.width() as f32, picture.height() as f32);
    let eye = Eye {
        camera,
        size,
        rays: rays(&setup.surface, world_from_object),
        radius: setup.radius,
        origin: setup.origin(),
    };
    let unit = size.y.max(SMALL) / 720.0;
    let lines: Vec<[Vec2; 2]> = (graph.edges.iter())
        .flat_map(|edge| edge.pieces())
        .flat_map(|piece| {
            let seen: Vec<Option<Vec2>> = piece.iter().map(|at| eye.sees(*at)).collect();
            let pair = |pair: &[Option<Vec2>]| Some([pair[0]?, pair[1]?]);
            let pairs: Vec<[Vec2; 2]> = seen.windows(2).filter_map(pair).collect();
            pairs
        })
        .collect();
    let discs: Vec<(Vec2, f32, [f32; 3])> = (graph.nodes.iter())
        .filter_map(|node| {
            let (radius, color) = match (node.foods.is_empty(), node.kind) {
                (false, _) => (FOOD, AT_FOOD),
                (true, NodeKind::Junction) => (JUNCTION, NODE),
                (true, NodeKind::End | NodeKind::Spot) => (END, NODE),
                (true, NodeKind::Loop | NodeKind::Through) => return None,
            };
            Some((eye.sees(node.place)?, radius, color))
        })
        .collect();
    // The edges of all come first, so that none cuts another line.
    for (half, color) in [(LINE + OUTLINE, DARK), (LINE, EDGE)] {
        for line in &lines {
            draw_line(picture, *line, unit * half, color);
        }
    }
    for (at, radius, color) in discs {
        draw_line(picture, [at, at], unit * (radius + OUTLINE), DARK);
        draw_line(picture, [at, at], unit * radius, color);
    }
}

/// Rays through all triangles, where they are in the world. `None` if they have no size.
fn rays(surface: &Surface, world_from_object: &[Affine3A]) -> Option<Rays> {
    let mut positions = surface.positions.clone();
    for (range, pose) in surface.objects.iter().zip(world_from_object) {
        let (first, end) = range.vertices;
        for position in &mut positions[first as usize..end as usize] {
            *position = pose.transform_point3(*position);
        }
    }
    Rays::new(&positions, &surface.corners)
}

struct Eye<'a> {
    camera: &'a Camera,
    size: Vec2,
    rays: Option<Rays>,
    /// The scene radius, world units.
    radius: f32,
    /// The origin of the camera's coordinates, world units.
    origin: DVec3,
}

impl Eye<'_> {
    /// Where a place, in scene radii, is in the picture, if nothing hides it.
    fn sees(&self, place: [f64; 3]) -> Option<Vec2> {
        let place = f64::from(self.radius) * DVec3::from_array(place);
        let place = (place - self.origin).as_vec3();
        let pixel = self.camera.pixel(place, self.size)?;
        let eye = self.camera.eye();
        let distance = place.distance(eye);
        let end = distance - BEHIND * self.radius;
        let way = (place - eye) / distance;
        let free = |rays: &Rays| rays.free(Vec3A::from(eye), Vec3A::from(way), 0.0, end) >= end;
        // What is too near the eye to be drawn hides nothing.
        let is_seen = end <= 0.0 || self.rays.as_ref().is_none_or(free);
        is_seen.then_some(pixel)
    }
}

/// A line with round ends; a disc if they are one point. Pixels at its edge get a share.
fn draw_line(picture: &mut RgbaImage, [from, to]: [Vec2; 2], half: f32, color: [f32; 3]) {
    let reach = Vec2::splat(half + 1.0);
    let size = Vec2::new(picture.width() as f32, picture.height() as f32);
    let low = (from.min(to) - reach).clamp(Vec2::ZERO, size).as_uvec2();
    let high = (from.max(to) + reach).clamp(Vec2::ZERO, size).as_uvec2();
    let along = to - from;
    let squared = along.length_squared();
    for y in low.y..high.y.min(picture.height()) {
        for x in low.x..high.x.min(picture.width()) {
            let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) - from;
            let share = match squared > 0.0 {
                true => (at.dot(along) / squared).clamp(0.0, 1.0),
                false => 0.0,
            };
            let covered = (half + 0.5 - at.distance(share * along)).clamp(0.0, 1.0);
            let pixel = picture.get_pixel_mut(x, y);
            for (light, color) in pixel.0.iter_mut().zip(color) {
                let before = f32::from(*light);
                *light = (before + covered * (color - before)).round() as u8;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Overrides, Scene};
    use crate::sim::graph::{Edge, Node};
    use glam::{DAffine3, Vec3};
    use image::Rgba;
    use std::path::Path;

    fn node(kind: NodeKind, place: [f64; 3]) -> Node {
        Node {
            kind,
            object: 0,
            place,
            degree: 1,
            width: 0.1,
            foods: Vec::new(),
        }
    }

    /// Would catch: lines and nodes on the far side that show through, lines beside their places, also far from the world's origin, and
    /// a picture that is dimmed where it is empty only.
    #[test]
    fn lines_are_drawn_where_they_are_seen() {
        for x in ["0", "300000"] {
            let set = [
                format!("object.0.position=[{x}, 0, 0]"),
                "atlas.size=128".to_owned(),
                "particles.count=10".to_owned(),
            ];
            let overrides = Overrides {
                set: set.to_vec(),
                ..Overrides::default()
            };
            let scene = Scene::load(Path::new("sphere"), &overrides).unwrap();
            let setup = Setup::new(&scene).unwrap();
            let poses: Vec<Affine3A> = (setup.poses.iter())
                .map(|pose| {
                    let pose = DAffine3::from(pose);
                    let matrix = pose.matrix3.as_mat3();
                    Affine3A::from_mat3_translation(matrix, pose.translation.as_vec3())
                })
                .collect();
            check(&setup, &poses);
        }
    }

    fn check(setup: &Setup, poses: &[Affine3A]) {
        let camera = Camera::fitted(Vec3::ZERO, setup.radius, Vec2::new(200.0, 200.0));
        let middle = setup.origin() / f64::from(setup.radius);
        let towards = (camera.eye() / camera.eye().length()).as_dvec3();
        let right = camera.right().as_dvec3();
        let [front, back] = [1.0, -1.0].map(|side| {
            let place =
                |turn: f64| (middle + side * towards * turn.cos() + right * turn.sin()).to_array();
            (-8..=8)
                .map(|i| place(0.05 * f64::from(i)))
                .collect::<Vec<_>>()
        });
        let drawn = |points: &Vec<[f64; 3]>| {
            let mut picture = RgbaImage::from_pixel(200, 200, Rgba([100, 100, 100, 255]));
            let graph = Graph {
                nodes: vec![
                    node(NodeKind::End, points[0]),
                    node(NodeKind::Junction, points[16]),
                ],
                edges: vec![Edge {
                    from: 0,
                    to: 1,
                    length: 0.8,
                    width: 0.1,
                    trail: 1.0,
                    points: points.clone(),
                    breaks: Vec::new(),
                }],
            };
            draw_network(&mut picture, &graph, setup, poses, &camera);
            picture
        };
        let plain = Rgba([55, 55, 55, 255]);
        assert!(drawn(&back).pixels().all(|pixel| *pixel == plain));
        let picture = drawn(&front);
        let middle = picture.get_pixel(100, 100).0;
        assert!(middle[2] > 100 && middle[2] > middle[0] + 40, "{middle:?}");
        let changed: Vec<(u32, u32)> = (picture.enumerate_pixels())
            .filter(|(.., pixel)| **pixel != plain)
            .map(|(x, y, _)| (x, y))
            .collect();
        assert!(
            changed.iter().all(|(_, y)| (96..=103).contains(y)),
            "a level line"
        );
        assert!(changed.len() > 100 && picture.pixels().all(|pixel| pixel.0[3] == 255));
    }
}
