//! Data to find the nearest triangle of an object, and the side of it on which a place lies: the triangles by
//! their corners, and the pseudonormals of their edges and vertices. All data are in object space, so that rigid motion costs nothing.
//! [`search`] and [`sides`] give the same results on the host as kernels.

mod afar;
mod build;
mod dipoles;
pub mod nearest;
mod pseudonormals;
pub mod search;
mod self_crossings;
pub mod sides;
#[cfg(test)]
mod tests;

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3, Vec4};

use super::surface::Surface;
use crate::strict::{dot3, reciprocal};
pub use afar::FacePoint;
pub use build::{GREATEST_DEPTH, Node};
pub use dipoles::Dipole;
pub use self_crossings::{MOST_CHECKED, self_crossings};

/// A triangle by one corner and the vectors from it to the other two.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Face {
    /// Corner A, object space.
    pub a: Vec3,
    /// Global triangle id.
    pub triangle: u32,
    /// B - A.
    pub ab: Vec3,
    /// 1 over the square of the length of `ab`, rounded so that the square times this is not less than 1.
    pub ab_by: f32,
    /// C - A.
    pub ac: Vec3,
    /// 1 over the square of the length of `ac`, rounded alike.
    pub ac_by: f32,
    /// The normal over the square of its length; zero if the triangle is degenerate: a line, within rounding.
    pub steep: Vec3,
    /// 1 over the square of the length of C - B, rounded alike.
    pub bc_by: f32,
}

impl Face {
    /// A triangle by its corner A and the ways from it to B and C.
    #[must_use]
    pub fn new(triangle: u32, a: Vec3, ab: Vec3, ac: Vec3) -> Self {
        let one_over = |square: f32| {
            let by = reciprocal(square);
            if square * by < 1.0 { by.next_up() } else { by }
        };
        let [side, other] = [ab, ac].map(Vec3::as_dvec3);
        let normal = side.cross(other);
        let square = normal.length_squared();
        let most = side.length_squared() * other.length_squared();
        // By its sine, and so that what it is multiplied by stays a number.
        let is_line = square <= 1e-20 * most || square < 1e-60;
        let bc = ac - ab;
        Self {
            a,
            triangle,
            ab,
            ab_by: one_over(dot3(ab, ab)),
            ac,
            ac_by: one_over(dot3(ac, ac)),
            steep: if is_line {
                Vec3::ZERO
            } else {
                (normal / square).as_vec3()
            },
            bc_by: one_over(dot3(bc, bc)),
        }
    }
}

/// One object's part of the pooled arrays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tree {
    /// Its first face.
    pub first_face: u32,
    /// How many it has.
    pub face_count: u32,
    /// Its first node, the root.
    pub first_node: u32,
    /// Lowest corner of the box round it, object space.
    pub low: Vec3,
    /// Highest corner of that box.
    pub high: Vec3,
    /// Has it no open border? Then it has an inside.
    pub is_closed: bool,
}

impl Tree {
    /// Centre and radius of the sphere round its box, object space.
    #[must_use]
    pub fn sphere(&self) -> (DVec3, f64) {
        let (low, high) = (self.low.as_dvec3(), self.high.as_dvec3());
        (0.5 * (low + high), 0.5 * low.distance(high))
    }
}

/// All objects of a surface, pooled.
#[derive(Clone, Debug, Default)]
pub struct Trees {
    /// Every triangle, object by object, in the order of the leaves.
    pub faces: Vec<Face>,
    /// Boxes round boxes round faces, object by object.
    pub nodes: Vec<Node>,
    /// For each node, the dipole of its faces.
    pub dipoles: Vec<Dipole>,
    /// Angle-weighted pseudonormals (Baerentzen and Aanaes 2005), object space: one for each half-edge, then one for
    /// each vertex.
    pub pseudonormals: Vec<Vec4>,
    /// One for each object.
    pub objects: Vec<Tree>,
}

impl Trees {
    /// Of every object of a surface.
    #[must_use]
    pub fn build(surface: &Surface) -> Self {
        let mut faces: Vec<Face> = (0..surface.corners.len() as u32)
            .map(|triangle| face(surface, triangle))
            .collect();
        let mut nodes = Vec::new();
        let objects = surface.objects.iter().enumerate().map(|(object, range)| {
            let (first, end) = range.triangles;
            let first_node = nodes.len() as u32;
            build::append_tree(&mut nodes, &mut faces[first as usize..end as usize], first);
            let [low, high] = surface.bounds(object);
            Tree {
                first_face: first,
                face_count: end - first,
                first_node,
                low,
                high,
                is_closed: surface.is_closed(object),
            }
        });
        let objects = objects.collect();
        Self {
            dipoles: dipoles::dipoles(&nodes, &faces),
            faces,
            nodes,
            pseudonormals: pseudonormals::pseudonormals(surface),
            objects,
        }
    }
}

fn face(surface: &Surface, triangle: u32) -> Face {
    let corners = surface.corners[triangle as usize];
    let [a, b, c] = corners.map(|vertex| surface.positions[vertex as usize]);
    // Each difference of two floats is rounded once.
    Face::new(triangle, a, b - a, c - a)
}
