//! Normals for light: smooth where a surface bends gently, broken along its creases.
//!
//! Corners that meet at a vertex share a normal when one can go from triangle to triangle round the vertex without
//! crossing a crease, so a cylinder's side is smooth and its rim stays sharp. Glued edges are borders here: their sides lie apart.

use glam::{DVec3, Vec2, Vec3};

use crate::mesh::surface::{NONE, Surface};

/// Edges that bend by more than this are creases, in radians.
pub const CREASE_ANGLE: f32 = 0.7;

/// One unit normal in object space for each corner of each triangle, `3 * triangle + corner`.
///
/// Areas and angles are calculated in double precision: in single precision squares of areas are beyond all numbers for models whose unit
/// is very small or very large.
#[must_use]
pub fn corner_normals(surface: &Surface, crease_angle: f32) -> Vec<Vec3> {
    let corner_position = |corner: usize| {
        surface.positions[surface.corners[corner / 3][corner % 3] as usize].as_dvec3()
    };
    let face_normals: Vec<Vec3> = (0..surface.corners.len())
        .map(|t| {
            let [a, b, c] = [3 * t, 3 * t + 1, 3 * t + 2].map(corner_position);
            let normal = (b - a).cross(c - a).normalize_or(DVec3::Y);
            normal.as_vec3()
        })
        .collect();

    let mut groups = Groups::new(3 * surface.corners.len());
    let least_cosine = crease_angle.cos();
    for (halfedge, data) in surface.halfedges.iter().enumerate() {
        if data.twin == NONE || surface.is_glued(halfedge as u32) {
            continue;
        }
        let twin = data.twin as usize;
        if face_normals[halfedge / 3].dot(face_normals[twin / 3]) >= least_cosine {
            groups.join(halfedge, next(twin));
            groups.join(next(halfedge), twin);
        }
    }

    // Weighted by the angle at the corner, so that the result does not depend on how a polygon was cut into triangles.
    let mut sums = vec![Vec3::ZERO; face_normals.len() * 3];
    for corner in 0..sums.len() {
        let here = corner_position(corner);
        let (to_next, to_last) = (
            corner_position(next(corner)) - here,
            corner_position(next(next(corner))) - here,
        );
        let angle = to_next.cross(to_last).length().atan2(to_next.dot(to_last));
        sums[groups.root(corner)] += angle as f32 * face_normals[corner / 3];
    }
    (0..sums.len())
        .map(|corner| sums[groups.root(corner)].normalize_or(face_normals[corner / 3]))
        .collect()
}

/// A unit vector in 32 bits: folded onto an octahedron and then a square, 16 bits per side.
///
/// Cigolle et al., "A Survey of Efficient Representations for Independent Unit Vectors" (JCGT 3(2), 2014).
/// `shaders/include/shading.glsl` has the inverse.
#[must_use]
pub fn pack_normal(normal: Vec3) -> u32 {
    let flat = normal / normal.abs().element_sum().max(f32::MIN_POSITIVE);
    let mut square = Vec2::new(flat.x, flat.y);
    if flat.z < 0.0 {
        square =
            (1.0 - Vec2::new(square.y, square.x).abs()) * Vec2::new(sign(square.x), sign(square.y));
    }
    let bits = |value: f32| u32::from((value.clamp(-1.0, 1.0) * 32767.0).round() as i16 as u16);
    bits(square.x) | bits(square.y) << 16
}

/// 1 for zero too, unlike in mathematics: the fold must not lose a side.
fn sign(value: f32) -> f32 {
    if value < 0.0 { -1.0 } else { 1.0 }
}

/// The next corner, and the next half-edge, of the same triangle.
fn next(corner: usize) -> usize {
    if corner % 3 == 2 {
        corner - 2
    } else {
        corner + 1
    }
}

/// Disjoint sets of corners.
struct Groups {
    parent: Vec<usize>,
}

impl Groups {
    fn new(len: usize) -> Self {
        Self {
            parent: (0..len).collect(),
        }
    }

    fn root(&mut self, mut corner: usize) -> usize {
        while self.parent[corner] != corner {
            self.parent[corner] = self.parent[self.parent[corner]];
            corner = self.parent[corner];
        }
        corner
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        // The smaller root wins, so that the result does not depend on the order of the joins.
        self.parent[a.max(b)] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;

    fn unpack_normal(bits: u32) -> Vec3 {
        let side = |bits: u16| (f32::from(bits as i16) / 32767.0).max(-1.0);
        let (x, y) = (side(bits as u16), side((bits >> 16) as u16));
        let mut normal = Vec3::new(x, y, 1.0 - x.abs() - y.abs());
        let below = (-normal.z).max(0.0);
        normal.x -= sign(x) * below;
        normal.y -= sign(y) * below;
        normal.normalize()
    }

    #[test]
    fn packed_normals_return() {
        let mut directions = vec![
            Vec3::X,
            Vec3::NEG_X,
            Vec3::Y,
            Vec3::NEG_Y,
            Vec3::Z,
            Vec3::NEG_Z,
        ];
        for id in 0..2000 {
            let words = crate::rng::random(5, id, 0, crate::rng::Purpose::Start);
            let v = Vec3::from_array([0, 1, 2].map(|k| 2.0 * crate::rng::unit(words[k]) - 1.0));
            directions.extend(v.try_normalize());
        }
        for direction in directions {
            let returned = unpack_normal(pack_normal(direction));
            assert!(
                returned.distance(direction) < 1e-4,
                "{direction} came back as {returned}"
            );
        }
    }

    fn built(name: &str) -> Surface {
        Surface::build(&[(&Mesh::builtin(name).unwrap(), 1.5)])
    }

    /// Every corner with its position and its normal.
    fn corners(surface: &Surface, crease_angle: f32) -> impl Iterator<Item = (usize, Vec3, Vec3)> {
        let normals = corner_normals(surface, crease_angle)
            .into_iter()
            .enumerate();
        normals.map(|(corner, normal)| {
            let vertex = surface.corners[corner / 3][corner % 3];
            (corner, surface.positions[vertex as usize], normal)
        })
    }

    #[test]
    fn a_torus_is_smooth_and_a_cube_is_not() {
        for (corner, position, normal) in corners(&built("torus?major=48&minor=24"), CREASE_ANGLE) {
            let ring = Vec3::new(position.x, 0.0, position.z).normalize() * 1.5;
            let exact = (position - ring).normalize();
            assert!(
                normal.dot(exact) > 0.999,
                "corner {corner}: {normal}, should be {exact}"
            );
        }
        let cube = built("cube?divisions=3");
        for (corner, _, normal) in corners(&cube, CREASE_ANGLE) {
            let [a, b, c] = cube.corners[corner / 3].map(|v| cube.positions[v as usize]);
            let face = (b - a).cross(c - a).normalize();
            assert!(
                normal.distance(face) < 1e-5,
                "corner {corner}: {normal}, should be {face}"
            );
        }
    }

    /// Would catch: squares of areas in single precision, which are infinite for a large model, and zero for a small one.
    #[test]
    fn a_ball_is_round_in_every_unit() {
        let ball = Mesh::builtin("icosphere?subdivisions=2").unwrap();
        for radius in [1e-10, 1.0, 1e11] {
            let surface = Surface::build(&[(&ball, radius)]);
            for (corner, position, normal) in corners(&surface, CREASE_ANGLE) {
                let exact = position.as_dvec3().normalize().as_vec3();
                assert!(
                    normal.dot(exact) > 0.99,
                    "corner {corner} of a ball of {radius}: {normal}, should be {exact}"
                );
            }
        }
    }

    #[test]
    fn without_creases_a_cube_is_round_at_its_corners() {
        for (corner, position, normal) in corners(&built("cube"), 3.2) {
            assert!(
                normal.dot(position.normalize()) > 0.999,
                "corner {corner}: {normal}"
            );
        }
    }

    /// Would alone catch: a normal that is the mean over both sides of a glued edge, which lie apart.
    #[test]
    fn glued_ends_of_a_curved_strip_are_shaded_as_borders() {
        let mut strip = Mesh::builtin("plane?columns=2&rows=1").unwrap();
        for position in &mut strip.positions {
            position.y = 0.2 * position.x * position.x;
        }
        let band = strip.clone().glued(&[[0, 0, 3, 1]]).unwrap();
        let [strip, band] = [&strip, &band].map(|mesh| Surface::build(&[(mesh, 1.0)]));
        for &h in &band.glued {
            let (here, there) = (h as usize / 3, band.halfedges[h as usize].twin as usize / 3);
            let [here, there] = [here, there].map(|triangle| {
                let [a, b, c] = band.corners[triangle].map(|v| band.positions[v as usize]);
                (b - a).cross(c - a).normalize()
            });
            let angle = here.angle_between(there);
            assert!(0.3 < angle && angle < CREASE_ANGLE, "{angle}, no crease");
        }
        assert_eq!(band.glued.len(), 2);
        assert_eq!(
            corner_normals(&band, CREASE_ANGLE),
            corner_normals(&strip, CREASE_ANGLE)
        );
    }

    #[test]
    fn an_open_border_keeps_the_normal_of_its_own_side() {
        for (corner, _, normal) in corners(&built("plane?columns=3&rows=2"), CREASE_ANGLE) {
            assert!(normal.distance(Vec3::Y) < 1e-6, "corner {corner}: {normal}");
        }
    }
}
