//! Normals of edges and vertices, which decide whether a place is inside of a surface: Baerentzen and Aanaes, "Signed Distance
//! Computation Using the Angle Weighted Pseudonormal" (2005). The nearest face's normal alone is wrong where an edge or
//! a vertex is nearest.

use glam::{DVec3, Vec4};
use rayon::prelude::*;

use crate::mesh::surface::{NONE, Surface};
use crate::portable::atan2;

/// One for each half-edge, the sum of the unit normals on its two sides; then one for each vertex, the sum of the unit
/// normals round it, each times its angle there. At an open border there is one side. Unit vectors, or zero.
pub(super) fn pseudonormals(surface: &Surface) -> Vec<Vec4> {
    let corners = |triangle: usize| {
        surface.corners[triangle].map(|vertex| surface.positions[vertex as usize].as_dvec3())
    };
    let normals: Vec<DVec3> = (0..surface.corners.len())
        .into_par_iter()
        .map(|triangle| {
            let [a, b, c] = corners(triangle);
            (b - a).cross(c - a).normalize_or_zero()
        })
        .collect();
    let edges = surface.halfedges.par_iter().enumerate().map(|(h, edge)| {
        let here = normals[h / 3];
        match edge.twin {
            NONE => here,
            // What is glued lies elsewhere.
            _ if surface.is_glued(h as u32) => here,
            twin => (here + normals[twin as usize / 3]).normalize_or_zero(),
        }
    });
    let mut vertices = vec![DVec3::ZERO; surface.positions.len()];
    // One by one: the order of a sum shows in its last bits.
    for (triangle, normal) in normals.iter().enumerate() {
        let places = corners(triangle);
        for (k, &vertex) in surface.corners[triangle].iter().enumerate() {
            let here = places[k];
            let (to_next, to_last) = (places[(k + 1) % 3] - here, places[(k + 2) % 3] - here);
            let angle = atan2(to_next.cross(to_last).length(), to_next.dot(to_last));
            vertices[vertex as usize] += angle * normal;
        }
    }
    let vertices = vertices.into_par_iter().map(DVec3::normalize_or_zero);
    edges
        .chain(vertices)
        .map(|normal| normal.as_vec3().extend(0.0))
        .collect()
}
