//! Trees that hold every face once and no deeper than searches have room for.

use super::nearest::{FEATURE_CORNER, nearest_on_face};
use super::*;
use crate::mesh::{Mesh, suite};
use crate::rng::{Purpose, random, unit};

/// Every face lies in one leaf, within all boxes above it; no leaf is deeper than allowed.
fn assert_sound(trees: &Trees, surface: &Surface) {
    let mut seen = vec![false; trees.faces.len()];
    for (object, tree) in trees.objects.iter().enumerate() {
        let mut open = vec![(tree.first_node, Vec3::NEG_INFINITY, Vec3::INFINITY, 0)];
        while let Some((index, low, high, depth)) = open.pop() {
            assert!(depth <= GREATEST_DEPTH, "{depth} deep");
            let node = trees.nodes[index as usize];
            assert!(node.low.cmpge(low).all() && node.high.cmple(high).all());
            if node.link < Node::LEAF {
                open.extend([0, 1].map(|k| (node.link + k, node.low, node.high, depth + 1)));
                continue;
            }
            let (first, count) = (node.link % Node::LEAF, node.link / Node::LEAF);
            assert!(count > 0);
            for slot in first..first + count {
                let face = trees.faces[slot as usize];
                assert!(!std::mem::replace(&mut seen[slot as usize], true));
                assert_eq!(
                    surface.triangles[face.triangle as usize].object,
                    object as u32
                );
                for corner in [face.a, face.a + face.ab, face.a + face.ac] {
                    assert!(corner.cmpge(node.low).all() && corner.cmple(node.high).all());
                }
            }
        }
    }
    assert!(seen.iter().all(|&seen| seen), "a face is in no leaf");
}

#[test]
fn trees_hold_every_face_once() {
    let meshes = suite::all();
    let objects: Vec<(&Mesh, f32)> = meshes.iter().map(|mesh| (mesh, 1.5)).collect();
    let surface = Surface::build(&objects);
    let trees = Trees::build(&surface);
    assert_sound(&trees, &surface);
    for (tree, mesh) in trees.objects.iter().zip(&meshes) {
        let (low, high) = mesh.bounds();
        assert_eq!(
            (tree.low, tree.high),
            (1.5 * low, 1.5 * high),
            "{}",
            mesh.name
        );
    }
}

/// Triangles in one another, each half as large as the last.
#[test]
fn trees_of_nested_triangles_are_not_too_deep() {
    let mut faces: Vec<Face> = (0..110)
        .map(|i| {
            let size = 0.5f32.powi(i);
            Face::new(i as u32, Vec3::ZERO, Vec3::X * size, Vec3::Y * size)
        })
        .collect();
    let mut nodes = Vec::new();
    build::append_tree(&mut nodes, &mut faces, 0);
    let leaves = nodes.iter().filter(|node| node.link >= Node::LEAF);
    let held: u32 = leaves.map(|node| node.link / Node::LEAF).sum();
    assert_eq!(held, 110);
    let mut triangles: Vec<u32> = faces.iter().map(|face| face.triangle).collect();
    triangles.sort_unstable();
    assert!(triangles.into_iter().eq(0..110));
    assert!(build::depth(&nodes) <= GREATEST_DEPTH);
}

/// On closed meshes every pseudonormal of a vertex looks away from the volume: a small way along it leads outside.
#[test]
fn pseudonormals_of_a_cube_look_outwards() {
    let mesh = Mesh::builtin("cube").unwrap();
    let surface = Surface::build(&[(&mesh, 2.0)]);
    let trees = Trees::build(&surface);
    let (edges, vertices) = trees.pseudonormals.split_at(surface.halfedges.len());
    for (vertex, normal) in vertices.iter().enumerate() {
        let outwards = surface.positions[vertex].normalize();
        assert!(normal.truncate().distance(outwards) < 1e-6, "{normal}");
    }
    for (h, normal) in edges.iter().enumerate() {
        let corners = surface.corners[h / 3].map(|v| surface.positions[v as usize]);
        let middle = corners[h % 3].midpoint(corners[(h + 1) % 3]);
        // A diagonal lies in a face of the cube, another edge between two: there it looks along two axes.
        let outwards = middle.signum() * (middle.abs().cmpgt(Vec3::splat(1e-3))).select_one();
        assert!(
            normal.truncate().distance(outwards.normalize()) < 1e-6,
            "{normal}"
        );
        assert!((normal.truncate().length() - 1.0).abs() < 1e-6);
    }
}

#[test]
fn nearest_points_stay_distinct_from_afar() {
    let mesh = Mesh::builtin("cube").unwrap();
    let trees = Trees::build(&Surface::build(&[(&mesh, 1.0)]));
    let v = DVec3::new;
    for (place, expected) in [
        // Over a face, by an edge, off a corner.
        (v(0.3, 5.0e6, -0.2), v(0.3, 1.0, -0.2)),
        (v(5.0, 3.5e7, 0.25), v(1.0, 1.0, 0.25)),
        (v(-5.0, 3.0, 8.0e11), v(-1.0, 1.0, 1.0)),
        (v(1.0e12, -1.0e12, 1.0e12), v(1.0, -1.0, 1.0)),
        (v(0.25, 0.1, 0.0), v(1.0, 0.1, 0.0)),
    ] {
        let point = trees.nearest_in_double(0, place);
        let off = point.position.distance(expected);
        assert!(off < 1e-7, "{place}: {point:?}");
        let face = &trees.faces[point.slot as usize];
        let [a, ab, ac] = [face.a, face.ab, face.ac].map(Vec3::as_dvec3);
        assert_eq!(point.position, a + point.u * ab + point.v * ac);
    }
}

/// Corners that have become one, sides without length.
#[test]
fn faces_without_area_have_nearest_points() {
    let shapes = [
        [Vec3::ZERO; 2],
        [Vec3::X; 2],
        [Vec3::ZERO, Vec3::Y],
        [Vec3::X, 2.0 * Vec3::X],
    ];
    for [ab, ac] in shapes {
        let mut faces = [Face::new(0, Vec3::ZERO, ab, ac)];
        let mut nodes = Vec::new();
        build::append_tree(&mut nodes, &mut faces, 0);
        let trees = Trees {
            faces: faces.to_vec(),
            nodes,
            objects: vec![Tree {
                first_face: 0,
                face_count: 1,
                first_node: 0,
                low: Vec3::ZERO,
                high: ab.max(ac),
                is_closed: false,
            }],
            ..Trees::default()
        };
        let point = trees.nearest_in_double(0, DVec3::new(100.0, 100.0, 0.0));
        assert_eq!(point.position, ab.max(ac).as_dvec3());
    }
}

trait SelectOne {
    fn select_one(self) -> Vec3;
}

impl SelectOne for glam::BVec3 {
    /// 1 where true.
    fn select_one(self) -> Vec3 {
        Vec3::select(self, Vec3::ONE, Vec3::ZERO)
    }
}

/// Places at corners and beyond them, in faces of every size: a corner is the nearest feature there, not an edge by rounding.
#[test]
fn corners_are_nearest_to_places_at_them() {
    for i in 0..2000 {
        let [x, y, z, w] = random(5, i, 0, Purpose::Start).map(|word| 2.0 * unit(word) - 1.0);
        let size = [1.0, 1e-3, 1e-6, 1e3][i as usize % 4];
        let (ab, ac) = (size * Vec3::new(x, y, z), size * Vec3::new(z, w, x));
        let face = Face::new(0, Vec3::ZERO, ab, ac);
        for (place, feature) in [
            (Vec3::ZERO, FEATURE_CORNER),
            (ab, FEATURE_CORNER + 1),
            (ac, FEATURE_CORNER + 2),
        ] {
            let point = nearest_on_face(&face, place);
            assert_eq!(point.square, 0.0, "{face:?}");
            assert_eq!(point.feature, feature, "{face:?}");
        }
    }
}

/// Needles, faces without area, tiny and huge ones: what is found lies on the face, and is as near as its corners at least.
#[test]
fn nearest_points_lie_on_faces_of_all_shapes() {
    let v = Vec3::new;
    let shapes = [
        [Vec3::ZERO; 2],
        [Vec3::X; 2],
        [Vec3::ZERO, Vec3::Y],
        [Vec3::X, 2.0 * Vec3::X],
        [Vec3::X, v(1.0, 1e-7, 0.0)],
        [Vec3::X, v(0.5, 1e-20, 0.0)],
        [v(1e-20, 0.0, 0.0), v(0.0, 1e-20, 0.0)],
        [v(1e6, 0.0, 0.0), v(3.0, 1e6, 1e-3)],
        [Vec3::X, v(-0.3, 0.8, 0.2)],
    ];
    for [ab, ac] in shapes {
        let face = Face::new(0, Vec3::ZERO, ab, ac);
        for i in 0..300 {
            let [x, y, z, _] = random(6, i, 0, Purpose::Start).map(|word| 2.0 * unit(word) - 1.0);
            let place = [1e-3, 1.0, 1e6][i as usize % 3] * v(x, y, z);
            let point = nearest_on_face(&face, place);
            assert!(point.u >= 0.0 && point.v >= 0.0, "{face:?}, {point:?}");
            assert!(point.u + point.v < 1.000_001, "{face:?}, {point:?}");
            let corners = [Vec3::ZERO, ab, ac].map(|corner| place.distance(corner));
            let least = corners.into_iter().fold(f32::INFINITY, f32::min);
            let size = ab.length().max(ac.length());
            assert!(
                point.square.sqrt() <= least + 1e-6 * (size + place.length()),
                "{face:?}, {place}: {point:?}, {least}"
            );
        }
    }
}
