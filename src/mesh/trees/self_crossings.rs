//! Triangles of a mesh that go through each other: the mesh intersects itself.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::{Face, Node, build};
use crate::mesh::Mesh;

/// Meshes of more triangles are not checked.
pub const MOST_CHECKED: usize = 1 << 17;
/// The most triangles that one is compared with. Where more crowd round one, pairs are left out, so that no mesh takes more than seconds.
const MOST_COMPARED: u32 = 512;
/// Crossings are as deep as this share of the mesh's size: triangles that touch within rounding do not cross.
const SHALLOW: f64 = 1e-6;
/// The sizes of meshes that are checked: products of lengths stay far within single precision.
const SIZES: std::ops::Range<f64> = 1e-12..1e12;

/// The number of pairs of triangles that go through each other, without a common corner; 0 for a mesh of more than [`MOST_CHECKED`]
/// triangles.
#[must_use]
pub fn self_crossings(mesh: &Mesh) -> usize {
    let (low, high) = mesh.bounds();
    let size = low.as_dvec3().distance(high.as_dvec3());
    let count = mesh.corners.len();
    if count > MOST_CHECKED || !SIZES.contains(&size) {
        return 0;
    }
    let mut faces: Vec<Face> = (0..count)
        .map(|triangle| {
            let [a, b, c] = corners_of(mesh, triangle);
            Face::new(triangle as u32, a, b - a, c - a)
        })
        .collect();
    let mut nodes = Vec::new();
    build::append_tree(&mut nodes, &mut faces, 0);
    let shallow = SHALLOW * size;
    (0..count)
        .into_par_iter()
        .map(|triangle| crossed_by(mesh, &nodes, &faces, triangle, shallow))
        .sum()
}

fn corners_of(mesh: &Mesh, triangle: usize) -> [Vec3; 3] {
    mesh.corners[triangle].map(|vertex| mesh.positions[vertex as usize])
}

/// How many triangles after this one go through it.
fn crossed_by(mesh: &Mesh, nodes: &[Node], faces: &[Face], triangle: usize, shallow: f64) -> usize {
    let own = mesh.corners[triangle];
    let corners = corners_of(mesh, triangle);
    let [a, b, c] = corners;
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let one = corners.map(Vec3::as_dvec3);
    let (mut count, mut compared) = (0, 0);
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
            let other = face.triangle as usize;
            let is_joined = mesh.corners[other]
                .iter()
                .any(|vertex| own.contains(vertex));
            if other <= triangle || is_joined {
                continue;
            }
            if compared == MOST_COMPARED {
                return count;
            }
            compared += 1;
            let two = corners_of(mesh, other).map(Vec3::as_dvec3);
            count += usize::from(pierces(one, two, shallow) || pierces(two, one, shallow));
        }
    }
    count
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
    use crate::mesh::{primitive, suite};

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
            assert_eq!(self_crossings(&both), expected, "{way}");
            assert_eq!(expected > 10, way.x < 2.0, "{way}: {expected}");
        }
        for mesh in [ball, primitive::torus(24, 16, 0.4), primitive::cube(3)] {
            assert_eq!(self_crossings(&mesh), 0, "{}", mesh.name);
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
            assert_eq!(self_crossings(&mesh), pairs, "{top}, {x}");
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
