//! The point of a triangle that is nearest to a place. Twin of `shaders/include/nearest.glsl`.

use glam::Vec3;

use super::Face;

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

fn rest_of(way: Vec3, ab: Vec3, ac: Vec3, u: f32, v: f32) -> Vec3 {
    (way - u * ab) - v * ac
}

/// The nearest point of a triangle, `way` being the way to the place from corner A.
#[must_use]
pub fn nearest_in_face(way: Vec3, ab: Vec3, ac: Vec3) -> NearestPoint {
    let ab_way = ab.dot(way);
    let ac_way = ac.dot(way);
    let ab_ab = ab.dot(ab);
    let ab_ac = ab.dot(ac);
    let ac_ac = ac.dot(ac);

    let t_ab = (ab_way / ab_ab).clamp(0.0, 1.0);
    let t_ca = (ac_way / ac_ac).clamp(0.0, 1.0);
    let bc_way = (ac_way - ab_way) + (ab_ab - ab_ac);
    let bc_bc = (ab_ab - ab_ac) + (ac_ac - ab_ac);
    let t_bc = (bc_way / bc_bc).clamp(0.0, 1.0);
    let rest_bc = 1.0 - t_bc;
    let from_ab = rest_of(way, ab, ac, t_ab, 0.0);
    let from_bc = rest_of(way, ab, ac, rest_bc, t_bc);
    let from_ca = rest_of(way, ab, ac, 0.0, t_ca);
    let square_ab = from_ab.dot(from_ab);
    let square_bc = from_bc.dot(from_bc);
    let square_ca = from_ca.dot(from_ca);

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

    let normal = ab.cross(ac);
    let normal_square = normal.dot(normal);
    let more_u = from_edge.cross(ac).dot(normal) / normal_square;
    let more_v = ab.cross(from_edge).dot(normal) / normal_square;
    let inner_u = u + more_u;
    let inner_v = v + more_v;
    let inner_w = (1.0 - inner_u) - inner_v;
    let from_inner = rest_of(from_edge, ab, ac, more_u, more_v);
    let inner_square = from_inner.dot(from_inner);
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

/// The nearest point of a face.
#[must_use]
pub fn nearest_on_face(face: &Face, place: Vec3) -> NearestPoint {
    nearest_in_face(place - face.a, face.ab, face.ac)
}
