//! The structs that the host and the kernels share; `shaders/include/types.glsl` declares them for the kernels.
//! The build compares every size and offset with the reflected shaders: a mismatch does not compile.

use bytemuck::{Pod, Zeroable};

pub use crate::mesh::surface::{AtlasMap, HalfEdge, Seam, Triangle};

/// Where a particle is, and who it is.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Particle {
    /// Global triangle id.
    pub triangle: u32,
    /// Barycentric weight of corner B.
    pub u: f32,
    /// Barycentric weight of corner C.
    pub v: f32,
    /// Never changes; random streams are keyed by it.
    pub id: u32,
}

/// Where a particle is going.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Motion {
    /// `p` component of the heading, a unit vector in the tangent frame of the particle's triangle.
    pub heading_p: f32,
    /// `h` component of the heading.
    pub heading_h: f32,
    /// World length that the last walk ran out of edge-crossing attempts for; walked first in the next step.
    pub pending: f32,
    /// Bits for transfers (in flight, advanced); 0 without them.
    pub flags: u32,
}

/// A walk under way: a place, a heading and what remains to be walked. `u` is `weight_b`, `v` is `weight_c`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Walker {
    /// Global triangle id.
    pub triangle: u32,
    /// Barycentric weight of corner A.
    pub weight_a: f32,
    /// Barycentric weight of corner B.
    pub weight_b: f32,
    /// Barycentric weight of corner C.
    pub weight_c: f32,
    /// `p` component of the unit heading.
    pub heading_p: f32,
    /// `h` component of the unit heading.
    pub heading_h: f32,
    /// World length still to walk.
    pub remaining: f32,
    /// The corner whose half-edge the walk came in by, `NONE` at the start.
    pub entered_by: u32,
    /// 0 walked to the end, 1 stopped at an open border, 2 out of edge-crossing attempts.
    pub status: u32,
}
