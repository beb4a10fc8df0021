//! Triangles of a mesh that go through each other: the mesh intersects itself.

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

/// The pairs of triangles that go through each other, without a common corner. Meshes of more than [`MOST_CHECKED`] triangles are not
/// checked.
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
    let shallow = SHALLOW * size;
    let found = (0..count)
        .into_par_iter()
        .map(|triangle| crossed_by(mesh, &nodes, &faces, triangle, shallow).crossings);
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
fn crossed_by(mesh: &Mesh, nodes: &[Node], faces: &[Face], triangle: usize, shallow: f64) -> Found {
    let own = mesh.corners[triangle];
    let corners = corners_of(mesh, triangle);
    let [a, b, c] = corners;
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let one = corners.map(Vec3::as_dvec3);
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
            let two = corners_of(mesh, other).map(Vec3::as_dvec3);
            let cross = pierces(one, two, shallow) || pierces(two, one, shallow);
            found.crossings.pairs += usize::from(cross);
        }
    }
    found
}

/// Does an edge of a triangle go through the inside of another one, from one side of it to the other?
fn pierces(edges: [DVec3; 3], triangle: [DVec3; 3], shallow: f64) -> bool {
    let [a, b, c] = triangle;
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let heights = edges.map(|corner| normal.dot(corner - a));
    (0..3).any(|k| {
        let (from, to) = (edges[k], edges[(k + 1) % 3]);
        let (start, end) = (heights[k], heights[(k + 1) % 3]);
        if start.min(end) > -shallow || start.max(end) < shallow {
            return false;
        }
        let place = from + start / (start - end) * (to - from);
        (0..3).all(|i| {
            let (corner, next) = (triangle[i], triangle[(i + 1) % 3]);
            normal.dot((next - corner).cross(place - corner)) > 0.0
        })
    })
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
            let mut expected = 0;
            for i in 0..both.corners.len() {
                for j in 0..i {
                    let [one, two] = [i, j].map(|t| corners_of(&both, t).map(Vec3::as_dvec3));
                    let joined = both.corners[i]
                        .iter()
                        .any(|vertex| both.corners[j].contains(vertex));
                    let cross = pierces(one, two, 1e-6 * size) || pierces(two, one, 1e-6 * size);
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
        for triangle in (0..COUNT as usize).step_by(999) {
            let found = crossed_by(&fan, &nodes, &faces, triangle, 1e-6);
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
