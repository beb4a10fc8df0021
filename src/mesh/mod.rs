//! Triangle-mesh geometry: loading, half-edges, the pooled surface, straight walks and the world atlas.
//!
//! Nothing here knows Vulkan or particles.
//!
//! Conventions, stated once:
//! - half-edge `h = 3 * triangle + corner` runs from that corner to the next one of its triangle;
//! - `uv` are the barycentric weights of corners 1 and 2: `P = A + u (B - A) + v (C - A)`;
//! - the tangent frame of a triangle is `p` along `B - A` and `h` perpendicular to it, towards `C`;
//! - closed meshes face outwards: the normal is `(B - A) x (C - A)`.

mod edges;
mod error;
pub mod primitive;
mod report;
pub mod surface;
pub mod walk;

use glam::{Vec2, Vec3};

pub use error::{MeshError, MeshProblem};
pub use report::MeshReport;

/// One model: welded, consistently wound, without degenerate triangles, and with a report of what was done to it.
///
/// Triangles keep the order of the file. A triangle of the file that was dropped leaves no gap, so `file_triangle`
/// says which one each came from.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// What people call it: the file's name without its ending, or the built-in's name.
    pub name: String,
    /// Welded vertices, in the file's own coordinates; every one is a corner of some triangle.
    pub positions: Vec<Vec3>,
    /// The corners of each triangle, wound to agree with its neighbours.
    pub corners: Vec<[u32; 3]>,
    /// Whether corners 1 and 2 of a triangle are swapped against the file.
    pub flipped: Vec<bool>,
    /// The triangle's number in the file, polygons fanned; ascending.
    pub file_triangle: Vec<u32>,
    /// Texture coordinates of each triangle's corners (in the order of `corners`), if the model has any.
    pub uvs: Option<Vec<[Vec2; 3]>>,
    /// Sizes, topology, and everything odd.
    pub report: MeshReport,
}

impl Mesh {
    /// A mesh from vertices and triangles that are already welded and well wound, as the primitives are.
    fn from_indexed(name: &str, positions: Vec<Vec3>, corners: Vec<[u32; 3]>) -> Self {
        let report = MeshReport::measure(&corners, positions.len());
        Self {
            name: name.to_owned(),
            flipped: vec![false; corners.len()],
            file_triangle: (0..corners.len() as u32).collect(),
            positions,
            corners,
            uvs: None,
            report,
        }
    }
}
