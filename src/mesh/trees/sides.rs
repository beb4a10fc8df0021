//! On which side of a surface a place lies, by one of three rules. Twin of `shaders/include/sign.glsl`.

use glam::{Vec3, Vec4};

use super::nearest::{FEATURE_CORNER, FEATURE_EDGE, NearestPoint, nearest_on_face};
use super::search::{box_square, limit_of, slack_of};
use super::{Dipole, Face, Node};
use crate::strict::{LEAST_SIZE, angle_of_vector, cross3, dot3, inverse_root, length3, root};

/// By the normal of the nearest face, edge or vertex.
pub const SIGN_PSEUDONORMAL: u32 = 0;
/// By how often the surface winds round the place.
pub const SIGN_WINDING: u32 = 1;
/// Outside if any of equally near faces looks towards the place.
pub const SIGN_FACING: u32 = 2;

/// From how many radii away faces together count as one dipole.
const DIPOLE_FAR: f32 = 2.0;

/// Half of the whole sphere.
const HALF_SPHERE: f32 = std::f32::consts::TAU;

/// The data for inside tests.
#[derive(Clone, Copy)]
pub struct Sides<'a> {
    /// Every triangle.
    pub faces: &'a [Face],
    /// Trees of them.
    pub nodes: &'a [Node],
    /// The dipole of each node.
    pub dipoles: &'a [Dipole],
    /// Of half-edges, then of vertices.
    pub pseudonormals: &'a [Vec4],
    /// Three vertex indices per triangle.
    pub corners: &'a [u32],
    /// Index of the first pseudonormal of a vertex.
    pub first_vertex_normal: u32,
}

fn outside_by_pseudonormal(sides: &Sides, slot: u32, place: Vec3, feature: u32) -> bool {
    let face = &sides.faces[slot as usize];
    let mut way = place - face.a;
    if feature == FEATURE_EDGE + 1 || feature == FEATURE_CORNER + 1 {
        way -= face.ab;
    } else if feature == FEATURE_CORNER + 2 {
        way -= face.ac;
    }
    let normal = if feature >= FEATURE_CORNER {
        let vertex = sides.corners[(3 * face.triangle + feature - FEATURE_CORNER) as usize];
        sides.pseudonormals[(sides.first_vertex_normal + vertex) as usize].truncate()
    } else if feature >= FEATURE_EDGE {
        sides.pseudonormals[(3 * face.triangle + feature - FEATURE_EDGE) as usize].truncate()
    } else {
        cross3(face.ab, face.ac)
    };
    dot3(way, normal) >= 0.0
}

fn solid_angle(face: &Face, place: Vec3) -> f32 {
    let a = face.a - place;
    let b = a + face.ab;
    let c = a + face.ac;
    let length_a = length3(a);
    let length_b = length3(b);
    let length_c = length3(c);
    let volume = dot3(a, cross3(b, c));
    let rest = ((length_a * length_b) * length_c + dot3(a, b) * length_c)
        + (dot3(b, c) * length_a + dot3(c, a) * length_b);
    if volume.abs() < LEAST_SIZE {
        0.0
    } else {
        2.0 * angle_of_vector(volume, rest)
    }
}

/// The solid angle of all faces of a tree.
#[must_use]
pub fn solid_angle_of_tree(sides: &Sides, root: u32, place: Vec3) -> f32 {
    let mut stack = vec![root];
    let mut sum = 0.0;
    while let Some(node) = stack.pop() {
        let dipole = &sides.dipoles[node as usize];
        let way = dipole.centre - place;
        let square = dot3(way, way);
        let near = DIPOLE_FAR * dipole.radius;
        let link = sides.nodes[node as usize].link;
        if square > near * near {
            let by = inverse_root(square);
            sum += ((dot3(dipole.normal, way) * by) * by) * by;
        } else if link < Node::LEAF {
            stack.extend([link, link + 1]);
        } else {
            let first = link % Node::LEAF;
            for slot in first..first + link / Node::LEAF {
                sum += solid_angle(&sides.faces[slot as usize], place);
            }
        }
    }
    sum
}

fn faces_place(face: &Face, place: Vec3) -> bool {
    dot3(place - face.a, cross3(face.ab, face.ac)) > 0.0
}

fn any_nearest_faces_place(sides: &Sides, root: u32, place: Vec3, distance: f32) -> bool {
    let limit = limit_of(distance, slack_of(&sides.nodes[root as usize]));
    let mut stack = vec![root];
    let mut any_does = false;
    while let Some(node) = stack.pop().filter(|_| !any_does) {
        let node = &sides.nodes[node as usize];
        if box_square(place, node) > limit {
            continue;
        }
        if node.link < Node::LEAF {
            stack.extend([node.link, node.link + 1]);
        } else {
            let first = node.link % Node::LEAF;
            for slot in first..first + node.link / Node::LEAF {
                let face = &sides.faces[slot as usize];
                any_does |=
                    nearest_on_face(face, place).square <= limit && faces_place(face, place);
            }
        }
    }
    any_does
}

/// Is a place outside an object, by a rule? `tree` is the first node of its tree, `slot` the nearest face, and `point` the nearest point on
/// it.
#[must_use]
pub fn is_outside(
    sides: &Sides,
    rule: u32,
    tree: u32,
    slot: u32,
    place: Vec3,
    point: &NearestPoint,
) -> bool {
    match rule {
        SIGN_WINDING => solid_angle_of_tree(sides, tree, place) < HALF_SPHERE,
        SIGN_FACING => any_nearest_faces_place(sides, tree, place, root(point.square)),
        _ => outside_by_pseudonormal(sides, slot, place, point.feature),
    }
}
