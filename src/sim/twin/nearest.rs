//! Twin of `shaders/include/nearest.glsl`: the point of a triangle that is nearest to a place, and on which side of the
//! surface the place lies.

use glam::{Vec3, Vec4};

use crate::mesh::trees::Face;

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

/// What tells the sides of a surface.
#[derive(Clone, Copy)]
pub struct Sides<'a> {
    /// Every triangle.
    pub faces: &'a [Face],
    /// Of half-edges, then of vertices.
    pub pseudonormals: &'a [Vec4],
    /// Three vertex indices a triangle.
    pub corners: &'a [u32],
    /// Where those of vertices begin.
    pub first_vertex_normal: u32,
}

fn square_of(way: Vec3, ab: Vec3, ac: Vec3, u: f32, v: f32) -> f32 {
    let rest = (way - u * ab) - v * ac;
    rest.dot(rest)
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
    let square_ab = square_of(way, ab, ac, t_ab, 0.0);
    let square_bc = square_of(way, ab, ac, rest_bc, t_bc);
    let square_ca = square_of(way, ab, ac, 0.0, t_ca);

    let is_bc = square_bc < square_ab;
    let (mut u, mut v, mut square) = if is_bc {
        (rest_bc, t_bc, square_bc)
    } else {
        (t_ab, 0.0, square_ab)
    };
    let is_ca = square_ca < square;
    if is_ca {
        (u, v, square) = (0.0, t_ca, square_ca);
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

    let area = ab_ab * ac_ac - ab_ac * ab_ac;
    let inner_u = (ac_ac * ab_way - ab_ac * ac_way) / area;
    let inner_v = (ab_ab * ac_way - ab_ac * ab_way) / area;
    let inner_w = (1.0 - inner_u) - inner_v;
    let inner_square = square_of(way, ab, ac, inner_u, inner_v);
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

/// Is a place outside, by the pseudonormal of the feature that is nearest to it?
#[must_use]
pub fn outside_by_pseudonormal(sides: &Sides, slot: u32, place: Vec3, feature: u32) -> bool {
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
        face.ab.cross(face.ac)
    };
    way.dot(normal) >= 0.0
}
