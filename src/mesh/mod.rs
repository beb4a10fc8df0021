//! Triangle-mesh geometry: loading, half-edges, the pooled surface, straight walks and the world atlas.
//!
//! Nothing here knows Vulkan or particles.
//!
//! Conventions, stated once:
//! - half-edge `h = 3 * triangle + corner` runs from that corner to the next one of its triangle;
//! - `uv` are the barycentric weights of corners 1 and 2: `P = A + u (B - A) + v (C - A)`;
//! - the tangent frame of a triangle is `p` along `B - A` and `h` perpendicular to it, towards `C`;
//! - closed meshes face outwards: the normal is `(B - A) x (C - A)`.

pub mod atlas;
mod edges;
mod error;
mod gltf;
mod load;
mod obj;
mod orient;
pub mod primitive;
mod report;
mod soup;
#[doc(hidden)]
pub mod suite;
pub mod surface;
pub mod walk;
mod weld;

use glam::{Vec2, Vec3};

pub use error::{MeshError, MeshProblem};
pub use report::MeshReport;
use walk::SurfacePoint;

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
    /// Texture coordinates of each triangle's corners (in the order of `corners`), if the model has them everywhere;
    /// as the file has them, so `v` points up in OBJ and down in glTF.
    pub uvs: Option<Vec<[Vec2; 3]>>,
    /// Sizes, topology, and everything odd.
    pub report: MeshReport,
}

impl Mesh {
    /// The lowest and the highest coordinates.
    #[must_use]
    pub fn bounds(&self) -> (Vec3, Vec3) {
        self.positions.iter().fold(
            (Vec3::INFINITY, Vec3::NEG_INFINITY),
            |(low, high), &position| (low.min(position), high.max(position)),
        )
    }

    /// The point that a file means by a face and the weights of its three corners, in the file's order and numbering.
    /// `None` when the file has no such triangle, or it was dropped.
    #[must_use]
    pub fn point_from_file(&self, face: u32, weights: [f64; 3]) -> Option<SurfacePoint> {
        let triangle = self.file_triangle.binary_search(&face).ok()?;
        let [_, second, third] = weights;
        let (u, v) = if self.flipped[triangle] {
            (third, second)
        } else {
            (second, third)
        };
        Some(SurfacePoint {
            triangle: triangle as u32,
            u,
            v,
        })
    }

    /// The face in the file and the weights of its three corners there, for a point on this mesh.
    ///
    /// # Panics
    /// When the mesh has no such triangle.
    #[must_use]
    pub fn point_to_file(&self, point: SurfacePoint) -> (u32, [f64; 3]) {
        let triangle = point.triangle as usize;
        let first = 1.0 - point.u - point.v;
        let weights = if self.flipped[triangle] {
            [first, point.v, point.u]
        } else {
            [first, point.u, point.v]
        };
        (self.file_triangle[triangle], weights)
    }
}
