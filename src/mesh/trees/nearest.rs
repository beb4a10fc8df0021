//! The point of a triangle that is nearest to a place. Twin of `shaders/include/nearest.glsl`.

use glam::Vec3;

use super::Face;
use crate::strict::{cross3, dot3};

/// Nearest is the inside of the triangle.
pub const FEATURE_FACE: u32 = 0;
/// Nearest is the edge that begins at corner A; the other two follow.
pub const FEATURE_EDGE: u32 = 1;
/// Nearest is corner A; the other two follow.
pub const FEATURE_CORNER: u32 = 4;

/// The nearest point of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestPoint {
    /// Weight of corner B.
    pub u: f32,
    /// Weight of corner C.
    pub v: f32,
    /// The square of the distance.
    pub square: f32,
    /// What it lies on.
    pub feature: u32,
}

/// A part of 1 by n / d; `by` is 1 / d.
#[inline]
fn part_by(n: f32, by: f32) -> f32 {
    if n > 0.0 { (n * by).min(1.0) } else { 0.0 }
}

fn rest_of(way: Vec3, ab: Vec3, ac: Vec3, u: f32, v: f32) -> Vec3 {
    (way - u * ab) - v * ac
}

/// The nearest point of a face.
#[must_use]
pub fn nearest_on_face(face: &Face, place: Vec3) -> NearestPoint {
    let way = place - face.a;
    let (ab, ac) = (face.ab, face.ac);
    let bc = ac - ab;
    let from_b = way - ab;
    let t_ab = part_by(dot3(ab, way), face.ab_by);
    let t_ca = part_by(dot3(ac, way), face.ac_by);
    let t_bc = part_by(dot3(bc, from_b), face.bc_by);
    let rest_bc = 1.0 - t_bc;
    let from_ab = way - t_ab * ab;
    let from_bc = from_b - t_bc * bc;
    let from_ca = way - t_ca * ac;
    let square_ab = dot3(from_ab, from_ab);
    let square_bc = dot3(from_bc, from_bc);
    let square_ca = dot3(from_ca, from_ca);

    let is_bc = square_bc < square_ab;
    let (mut u, mut v, mut from_edge, mut square) = if is_bc {
        (rest_bc, t_bc, from_bc, square_bc)
    } else {
        (t_ab, 0.0, from_ab, square_ab)
    };
    let is_ca = square_ca < square;
    if is_ca {
        (u, v, from_edge, square) = (0.0, t_ca, from_ca, square_ca);
    }
    let feature = if u == 0.0 && v == 0.0 {
        FEATURE_CORNER
    } else if u == 1.0 {
        FEATURE_CORNER + 1
    } else if v == 1.0 {
        FEATURE_CORNER + 2
    } else if is_ca {
        FEATURE_EDGE + 2
    } else if is_bc {
        FEATURE_EDGE + 1
    } else {
        FEATURE_EDGE
    };

    let turned = cross3(face.steep, from_edge);
    let more_u = dot3(ac, turned);
    let more_v = -dot3(ab, turned);
    let inner_u = u + more_u;
    let inner_v = v + more_v;
    let inner_w = (1.0 - inner_u) - inner_v;
    let from_inner = rest_of(from_edge, ab, ac, more_u, more_v);
    let inner_square = dot3(from_inner, from_inner);
    if inner_u > 0.0 && inner_v > 0.0 && inner_w > 0.0 && inner_square < square {
        return NearestPoint {
            u: inner_u,
            v: inner_v,
            square: inner_square,
            feature: FEATURE_FACE,
        };
    }
    NearestPoint {
        u,
        v,
        square,
        feature,
    }
}

/// Is a face nearer than the nearest so far? Of equally near ones it is the one with the lowest triangle.
#[must_use]
pub fn is_nearer(square: f32, triangle: u32, best_square: f32, best_triangle: u32) -> bool {
    square < best_square || (square == best_square && triangle < best_triangle)
}
