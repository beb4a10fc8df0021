//! Twin of `shaders/include/distance.glsl`: what the kernels of signed distance share.

use glam::{Vec3, Vec4};

use super::nearest::Sides;
use crate::mesh::trees::Face;
use crate::sim::types::{DistanceJob, ObjectPair, SurfaceSample};

/// What the kernels of signed distance read.
#[derive(Clone, Copy)]
pub struct DistanceInputs<'a> {
    /// Objects whose distances are taken.
    pub jobs: &'a [DistanceJob],
    /// Which other objects each of them has within reach.
    pub pairs: &'a [ObjectPair],
    /// Surface points under texels.
    pub samples: &'a [SurfaceSample],
    /// Every triangle.
    pub faces: &'a [Face],
    /// Of half-edges, then of vertices.
    pub pseudonormals: &'a [Vec4],
    /// Three vertex indices a triangle.
    pub corners: &'a [u32],
}

impl<'a> DistanceInputs<'a> {
    /// What tells the sides of a surface.
    #[must_use]
    pub fn sides(&self, first_vertex_normal: u32) -> Sides<'a> {
        Sides {
            faces: self.faces,
            pseudonormals: self.pseudonormals,
            corners: self.corners,
            first_vertex_normal,
        }
    }
}

/// A place in the space of a pair's other object.
#[must_use]
pub fn place_in_other(pair: &ObjectPair, place: Vec3) -> Vec3 {
    let along = |row: Vec4| ((row.x * place.x + row.y * place.y) + row.z * place.z) + row.w;
    Vec3::new(along(pair.x), along(pair.y), along(pair.z))
}

/// The job that an invocation belongs to: the last one that begins at it or before.
#[must_use]
pub fn job_of(jobs: &[DistanceJob], thread: u32) -> usize {
    let (mut low, mut high) = (0, jobs.len());
    while high - low > 1 {
        let middle = (low + high) / 2;
        if jobs[middle].first_thread <= thread {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}
