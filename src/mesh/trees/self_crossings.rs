//! Triangles of a mesh that go through each other: the mesh intersects itself.

use std::collections::HashMap;
use std::sync::OnceLock;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::{Face, Node, build};
use crate::mesh::{Crossings, Mesh};

/// Meshes of more triangles are not checked.
pub const MOST_CHECKED: usize = 1 << 17;
/// The most triangles that one is compared with. Where more crowd round one, pairs are left out, so that no mesh takes more than seconds.
const MOST_COMPARED: u32 = 512;
/// The most triangles that are looked at for one. Those of a fan have a common corner and are not compared, but their boxes meet.
const MOST_VISITED: u32 = 8192;
/// Crossings are as deep as this share of the mesh's size: triangles that touch within rounding do not cross.
const SHALLOW: f64 = 1e-6;
/// The sizes of meshes that are checked: products of lengths stay far within single precision.
const SIZES: std::ops::Range<f64> = 1e-12..1e12;

/// Where an edge goes through a corner, no more triangles round it are looked at.
const MOST_ROUND: usize = 4096;

/// The pairs of triangles that go through each other, without a common corner. Where an edge goes through a side or a corner of triangles,
/// each of these counts. Meshes of more than [`MOST_CHECKED`] triangles are not checked.
#[must_use]
pub fn self_crossings(mesh: &Mesh) -> Crossings {
    let (low, high) = mesh.bounds();
    let size = low.as_dvec3().distance(high.as_dvec3());
    let count = mesh.corners.len();
    if count > MOST_CHECKED || !SIZES.contains(&size) {
        return Crossings {
            are_unchecked: true,
            ..Crossings::default()
        };
    }
    let (nodes, faces) = tree_of(mesh);
    let sheets = Sheets::new(mesh, SHALLOW * size);
    let found = (0..count)
        .into_par_iter()
        .map(|triangle| crossed_by(&sheets, &nodes, &faces, triangle).crossings);
    found.reduce(Crossings::default, |one, other| Crossings {
        pairs: one.pairs + other.pairs,
        are_partial: one.are_partial || other.are_partial,
        are_unchecked: false,
    })
}

fn tree_of(mesh: &Mesh) -> (Vec<Node>, Vec<Face>) {
    let mut faces: Vec<Face> = (0..mesh.corners.len())
        .map(|triangle| {
            let [a, b, c] = corners_of(mesh, triangle);
            Face::new(triangle as u32, a, b - a, c - a)
        })
        .collect();
    let mut nodes = Vec::new();
    build::append_tree(&mut nodes, &mut faces, 0);
    (nodes, faces)
}

fn corners_of(mesh: &Mesh, triangle: usize) -> [Vec3; 3] {
    mesh.corners[triangle].map(|vertex| mesh.positions[vertex as usize])
}

/// What is found for one triangle.
#[derive(Default)]
struct Found {
    crossings: Crossings,
    /// How many triangles were looked at, and how many of these were compared with it.
    visited: u32,
    compared: u32,
}

/// The triangles after this one that go through it.
fn crossed_by(sheets: &Sheets<'_>, nodes: &[Node], faces: &[Face], triangle: usize) -> Found {
    let mesh = sheets.mesh;
    let own = mesh.corners[triangle];
    let corners = corners_of(mesh, triangle);
    let [a, b, c] = corners;
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let mut found = Found::default();
    let mut open = vec![0];
    while let Some(index) = open.pop() {
        let node = &nodes[index as usize];
        if node.low.cmpgt(high).any() || node.high.cmplt(low).any() {
            continue;
        }
        if node.link < Node::LEAF {
            open.extend([node.link, node.link + 1]);
            continue;
        }
        let first = node.link % Node::LEAF;
        for face in &faces[first as usize..(first + node.link / Node::LEAF) as usize] {
            if found.visited == MOST_VISITED {
                found.crossings.are_partial = true;
                return found;
            }
            found.visited += 1;
            let other = face.triangle as usize;
            let is_joined = mesh.corners[other]
                .iter()
                .any(|vertex| own.contains(vertex));
            if other <= triangle || is_joined {
                continue;
            }
            if found.compared == MOST_COMPARED {
                found.crossings.are_partial = true;
                return found;
            }
            found.compared += 1;
            let cross = sheets.pierces(triangle, other) || sheets.pierces(other, triangle);
            found.crossings.pairs += usize::from(cross);
        }
    }
    found
}

/// The triangles of a mesh and how they lie beside each other.
struct Sheets<'a> {
    mesh: &'a Mesh,
    /// What lies within this length of a plane or a line touches it.
    shallow: f64,
    /// The triangle of each side, by its corners in order; found when it is first needed.
    sides: OnceLock<HashMap<[u32; 2], usize>>,
}

impl<'a> Sheets<'a> {
    fn new(mesh: &'a Mesh, shallow: f64) -> Self {
        Self {
            mesh,
            shallow,
            sides: OnceLock::new(),
        }
    }

    /// Does an edge of a triangle go through another one, from one side of it to the other? Where it goes through a side or a corner, it
    /// has to go through all triangles there, in the same direction: at a fold it may only touch, as it does at an open border.
    fn pierces(&self, edges: usize, triangle: usize) -> bool {
        let [edges, corners] =
            [edges, triangle].map(|t| corners_of(self.mesh, t).map(Vec3::as_dvec3));
        let normal = normal_of(corners);
        let heights = edges.map(|place| normal.dot(place - corners[0]));
        (0..3).any(|k| {
            let ends = [k, (k + 1) % 3];
            let [start, end] = ends.map(|i| heights[i]);
            let Some(goes_up) = self.goes_up([start, end]) else {
                return false;
            };
            let [from, to] = ends.map(|i| edges[i]);
            let place = from + start / (start - end) * (to - from);
            // How far inside of each side it is.
            let inside = [0, 1, 2].map(|i| {
                let along = (corners[(i + 1) % 3] - corners[i]).normalize_or_zero();
                normal.dot(along.cross(place - corners[i]))
            });
            let goes_through = |other: usize| {
                let corners = corners_of(self.mesh, other).map(Vec3::as_dvec3);
                let normal = normal_of(corners);
                let heights = [from, to].map(|place| normal.dot(place - corners[0]));
                self.goes_up(heights) == Some(goes_up)
            };
            self.is_hit(triangle, inside, goes_through)
        })
    }

    /// Is a place that lies so far inside of each side in a triangle? At a side or a corner all others there have to agree.
    fn is_hit(
        &self,
        triangle: usize,
        inside: [f64; 3],
        goes_through: impl Fn(usize) -> bool,
    ) -> bool {
        if inside.iter().any(|&inside| inside < -self.shallow) {
            return false;
        }
        let [a, b, c] = self.mesh.corners[triangle];
        let is_through_side = |side: [u32; 2]| self.beyond(side).is_some_and(&goes_through);
        match inside.map(|inside| inside <= self.shallow) {
            [false, false, false] => true,
            [true, false, false] => is_through_side([a, b]),
            [false, true, false] => is_through_side([b, c]),
            [false, false, true] => is_through_side([c, a]),
            // Between two sides lies their common corner.
            [true, false, true] => self.is_through_corner(triangle, a, goes_through),
            [true, true, false] => self.is_through_corner(triangle, b, goes_through),
            [false, true, true] => self.is_through_corner(triangle, c, goes_through),
            [true, true, true] => false,
        }
    }

    /// Does an edge whose ends are so high over a plane go through it, and up?
    fn goes_up(&self, [start, end]: [f64; 2]) -> Option<bool> {
        let crosses = start.min(end) <= -self.shallow && start.max(end) >= self.shallow;
        crosses.then_some(start < end)
    }

    fn is_through_corner(
        &self,
        first: usize,
        corner: u32,
        goes_through: impl Fn(usize) -> bool,
    ) -> bool {
        let mut at = first;
        for _ in 0..MOST_ROUND {
            let names = self.mesh.corners[at];
            let Some(k) = names.iter().position(|&name| name == corner) else {
                return false;
            };
            let Some(next) = self.beyond([corner, names[(k + 1) % 3]]) else {
                return false;
            };
            if next == first {
                return true;
            }
            if !goes_through(next) {
                return false;
            }
            at = next;
        }
        false
    }

    /// The triangle on the other side of a side that goes from one corner to another.
    fn beyond(&self, [a, b]: [u32; 2]) -> Option<usize> {
        let sides = self.sides.get_or_init(|| {
            let corners = self.mesh.corners.iter().enumerate();
            let sides = corners.flat_map(|(triangle, &[a, b, c])| {
                [([a, b], triangle), ([b, c], triangle), ([c, a], triangle)]
            });
            sides.collect()
        });
        sides.get(&[b, a]).copied()
    }
}

fn normal_of([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{MeshReport, primitive, suite};

    /// Two copies of a mesh, the second one moved.
    fn twice(mesh: &Mesh, way: Vec3) -> Mesh {
        let moved = mesh.positions.iter().map(|position| *position + way);
        let positions: Vec<Vec3> = mesh.positions.iter().copied().chain(moved).collect();
        let before = mesh.positions.len() as u32;
        let again = mesh
            .corners
            .iter()
            .map(|corners| corners.map(|c| c + before));
        let corners: Vec<[u32; 3]> = mesh.corners.iter().copied().chain(again).collect();
        suite::mesh("twice", &positions, &corners)
    }

    /// Would catch: boxes of the tree that miss a triangle, a pair that counts twice or not at all, and neighbours that count.
    #[test]
    fn pairs_are_those_of_comparing_all() {
        let ball = primitive::icosphere(2);
        for way in [
            Vec3::new(0.31, 0.17, 0.05),
            Vec3::new(1.6, 0.1, 0.2),
            Vec3::new(2.5, 0.0, 0.0),
        ] {
            let both = twice(&ball, way);
            let size = {
                let (low, high) = both.bounds();
                low.as_dvec3().distance(high.as_dvec3())
            };
            let sheets = Sheets::new(&both, SHALLOW * size);
            let mut expected = 0;
            for i in 0..both.corners.len() {
                for j in 0..i {
                    let joined = both.corners[i]
                        .iter()
                        .any(|vertex| both.corners[j].contains(vertex));
                    let cross = sheets.pierces(i, j) || sheets.pierces(j, i);
                    expected += usize::from(cross && !joined);
                }
            }
            let expected_crossings = Crossings {
                pairs: expected,
                ..Crossings::default()
            };
            assert_eq!(self_crossings(&both), expected_crossings, "{way}");
            assert_eq!(expected > 10, way.x < 2.0, "{way}: {expected}");
        }
        for mesh in [ball, primitive::torus(24, 16, 0.4), primitive::cube(3)] {
            assert_eq!(self_crossings(&mesh), Crossings::default(), "{}", mesh.name);
        }
    }

    /// Would catch: triangles that only touch, or end on one another within rounding, which many models have.
    #[test]
    fn triangles_cross_only_if_one_goes_through_the_other() {
        let flat = [
            Vec3::new(-1.0, -1.0, 0.0),
            Vec3::new(1.0, -1.0, 0.0),
            Vec3::new(0.0, 1.0, 0.0),
        ];
        for (top, x, pairs) in [
            (1.0, 0.0, 1),
            (1.0, 3.0, 0),
            (0.0, 0.0, 0),
            (1e-7, 0.0, 0),
            (-0.1, 0.0, 0),
        ] {
            let upright = [
                Vec3::new(x, 0.1, -1.0),
                Vec3::new(x, 0.0, top),
                Vec3::new(x, -0.3, -1.0),
            ];
            let positions = [flat, upright].concat();
            let mesh = suite::mesh("two", &positions, &[[0, 1, 2], [3, 4, 5]]);
            assert_eq!(self_crossings(&mesh).pairs, pairs, "{top}, {x}");
        }
    }

    /// A grid of so many by 4 cells, each with one diagonal: the place of its corner `i, j` is `at(i, j)`.
    fn grid(columns: u32, at: impl Fn(f32, f32) -> Vec3) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let places = (0..=columns).flat_map(|i| (0..=4).map(move |j| (i as f32, j as f32)));
        let cells = (0..columns).flat_map(|i| (0..4).map(move |j| 5 * i + j));
        let corners = cells.flat_map(|a| [[a, a + 5, a + 6], [a, a + 6, a + 1]]);
        (places.map(|(i, j)| at(i, j)).collect(), corners.collect())
    }

    /// Would catch: sheets that go through each other at sides and corners of triangles only, of which none was seen, and sheets and boxes
    /// that only touch there and count.
    #[test]
    fn sheets_cross_also_where_edges_meet_edges() {
        // One lies, the other one stands on edge, in the plane of a line of the first one's sides.
        for (columns, shift, cross) in [
            (4, 0.0, true),
            (4, 0.5, true),
            // The first one ends there.
            (2, 0.0, false),
            (2, 0.5, false),
        ] {
            let (lying, first) = grid(columns, |i, j| Vec3::new(i, j, 0.0));
            let (upright, second) = grid(4, |i, j| Vec3::new(2.0, j + shift, i - 1.5));
            let before = lying.len() as u32;
            let second = second
                .iter()
                .map(|corners| corners.map(|corner| corner + before));
            let corners: Vec<[u32; 3]> = first.into_iter().chain(second).collect();
            let mesh = suite::mesh("sheets", &[lying, upright].concat(), &corners);
            let pairs = self_crossings(&mesh).pairs;
            assert_eq!(pairs > 0, cross, "{columns}, {shift}: {pairs}");
        }
        let cube = primitive::cube(2);
        let (low, high) = cube.bounds();
        let side = high.x - low.x;
        for beside in [[0.25, 0.25], [0.5, 0.25], [1.0, 0.25]] {
            let [y, z] = beside.map(|part| part * side);
            let both = twice(&cube, Vec3::new(side, y, z));
            assert_eq!(self_crossings(&both).pairs, 0, "{beside:?}");
        }
    }

    /// Would catch: a fan in which every triangle looks at every other one, and a count that passes for the whole one where not all were
    /// compared, also if none was found.
    #[test]
    fn fans_take_no_longer_than_their_bound() {
        const COUNT: u32 = 20_000;
        let turn = |i: u32| std::f32::consts::TAU * i as f32 / COUNT as f32;
        let rim = (0..COUNT).map(|i| Vec3::new(turn(i).cos(), turn(i).sin(), 0.0));
        let positions: Vec<Vec3> = std::iter::once(Vec3::ZERO).chain(rim).collect();
        let corners: Vec<[u32; 3]> = (0..COUNT)
            .map(|i| [0, 1 + i, 1 + (i + 1) % COUNT])
            .collect();
        let fan = suite::mesh("fan", &positions, &corners);
        assert_eq!(fan.corners.len(), COUNT as usize);
        let (nodes, faces) = tree_of(&fan);
        let sheets = Sheets::new(&fan, 1e-6);
        for triangle in (0..COUNT as usize).step_by(999) {
            let found = crossed_by(&sheets, &nodes, &faces, triangle);
            assert_eq!((found.visited, found.compared), (MOST_VISITED, 0));
            assert!(found.crossings.are_partial && found.crossings.pairs == 0);
        }
        for (pairs, are_partial, beginning) in [
            (3, true, "at least 3 pairs of"),
            (3, false, "3 pairs of"),
            (0, true, "not all pairs of triangles were compared"),
        ] {
            let report = MeshReport {
                self_crossings: Crossings {
                    pairs,
                    are_partial,
                    are_unchecked: false,
                },
                ..MeshReport::default()
            };
            let said = report.oddities();
            assert!(
                said.len() == 1 && said[0].starts_with(beginning),
                "{said:?}"
            );
        }
        assert_eq!(MeshReport::default().oddities(), [""; 0]);
    }

    /// Would catch: a mesh that passes for one without crossings because it was not checked, and a reason that is not its own.
    #[test]
    fn meshes_that_are_not_checked_say_so() {
        let fine = primitive::torus(362, 182, 0.4);
        assert!(fine.corners.len() > MOST_CHECKED);
        let mut tiny = primitive::cube(1);
        for place in &mut tiny.positions {
            *place *= 1e-13;
        }
        for (mesh, why) in [
            (fine, "there are more than 131,072"),
            (tiny, "the mesh is too large or too small"),
        ] {
            let found = self_crossings(&mesh);
            assert!(found.are_unchecked, "{}", mesh.name);
            let report = MeshReport {
                self_crossings: found,
                ..mesh.report
            };
            let said = report.oddities().join("; ");
            let expected = format!(
                "no pairs of triangles were compared, because {why}: the mesh may intersect itself"
            );
            assert_eq!(said, expected);
        }
    }

    /// Would catch: a model that is read without the check.
    #[test]
    fn files_that_intersect_themselves_say_so() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("two.obj");
        for (x, is_odd) in [(0.5, true), (5.0, false)] {
            let cubes = twice(&primitive::cube(1), Vec3::new(x, 0.4, 0.3));
            std::fs::write(&path, suite::obj_text(&cubes, false)).unwrap();
            let report = Mesh::load(&path).unwrap().report;
            assert_eq!(report.self_crossings, self_crossings(&cubes));
            let said = report.oddities().join("\n");
            assert_eq!(said.contains("go through each other"), is_odd, "{said}");
        }
    }
}
