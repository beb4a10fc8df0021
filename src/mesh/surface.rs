//! The pooled surface: every object's triangles in one set of arrays, with all that a walk needs, precomputed.
//!
//! Triangle ids are global over all objects of a scene; a triangle says which object it belongs to.

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};

/// No half-edge: the other side of an open border.
pub const NONE: u32 = u32::MAX;

/// A triangle's shape in its own tangent frame: corner A is the origin, B is `(ab, 0)`, C is `(cp, ch)`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Triangle {
    /// `|B - A|`, world units.
    pub ab: f32,
    /// `p` of corner C; negative where the angle at A is obtuse.
    pub cp: f32,
    /// `h` of corner C, always positive.
    pub ch: f32,
    /// The object that the triangle belongs to.
    pub object: u32,
}

/// What a walk needs to cross a half-edge.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct HalfEdge {
    /// The same edge seen from the neighbour, or [`NONE`] at an open border.
    pub twin: u32,
    /// Cosine of the rotation that takes a heading in this triangle's frame to the twin's frame.
    pub cos: f32,
    /// Sine of the same rotation.
    pub sin: f32,
    /// Keeps the stride at 16 bytes.
    pub pad0: u32,
}

/// The affine map from a triangle's `uv` to atlas texels: `origin + u * du + v * dv`; texel centres lie at `+ 0.5`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct AtlasMap {
    /// Texel position of corner A.
    pub origin: Vec2,
    /// Texel position of B minus that of A.
    pub du: Vec2,
    /// Texel position of C minus that of A.
    pub dv: Vec2,
}

/// How one gutter texel is filled: a weighted sum of up to four owned texels across the seam.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Seam {
    /// The gutter texel, `y * pitch + x`.
    pub texel: u32,
    /// Owned texels; unused places repeat a used one with weight 0.
    pub source: [u32; 4],
    /// Weights, which sum to 1.
    pub weight: [f32; 4],
}

/// The range of one object in the pooled arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ObjectRange {
    /// First triangle, and one past the last.
    pub triangles: (u32, u32),
    /// First vertex, and one past the last.
    pub vertices: (u32, u32),
}

/// All objects of a scene, pooled.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Welded vertices in object space, already multiplied by the object's scale, so lengths are world lengths.
    pub positions: Vec<Vec3>,
    /// Corners of each triangle, consistently wound.
    pub corners: Vec<[u32; 3]>,
    /// Tangent-frame shape of each triangle.
    pub triangles: Vec<Triangle>,
    /// Three for each triangle.
    pub halfedges: Vec<HalfEdge>,
    /// One for each object.
    pub objects: Vec<ObjectRange>,
}
