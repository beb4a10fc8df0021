//! Triangle-mesh geometry: loading, half-edges, the pooled surface, straight walks and the world atlas.
//!
//! This layer has neither Vulkan nor particles.
//!
//! A model comes in through `load` (files, read by `obj`, `stl`, `ply` and `gltf`) or [`builtin`] as a `soup` of
//! triangles. [`origin`] chooses the origin of its coordinates, `weld` merges vertices at one place and drops triangles without area,
//! `stitch` joins borders that coincide within rounding error, `orient` makes windings agree, and the result is a [`Mesh`] with a
//! [`MeshReport`]. `glue` joins borders that lie apart. [`surface`] pools meshes for the kernels, with the rotation across every edge;
//! [`walk`] is the reference for walks on it.
//!
//! Conventions, stated once:
//! - half-edge `h = 3 * triangle + corner` runs from that corner to the next one of its triangle;
//! - `uv` are the barycentric weights of corners 1 and 2: `P = A + u (B - A) + v (C - A)`;
//! - the tangent frame of a triangle is `p` along `B - A` and `h` perpendicular to it, towards `C`;
//! - closed meshes face outwards: the normal is `(B - A) x (C - A)`.

pub mod atlas;
#[cfg(test)]
mod bad_files;
pub mod builtin;
mod edges;
mod embedded;
mod error;
#[cfg(test)]
mod foreign_files;
pub mod gear;
mod gltf;
mod glue;
mod load;
mod obj;
mod orient;
pub mod origin;
mod ply;
mod polygon;
pub mod primitive;
#[cfg(test)]
mod random_files;
mod report;
mod soup;
mod stitch;
mod stl;
pub mod strip;
#[doc(hidden)]
pub mod suite;
pub mod surface;
pub mod surface_distance;
mod text;
#[cfg(test)]
mod text_files;
pub mod trees;
pub mod walk;
mod weld;

use glam::{DVec3, Vec2, Vec3};

pub use error::{MeshError, MeshProblem};
pub use gltf::RigidTrack;
pub use report::{Crossings, MeshReport};
use walk::SurfacePoint;

/// One model: welded, consistently wound, without degenerate triangles, and with a report of repairs.
///
/// Triangles keep the order of the file. Dropped triangles leave no gap, so `file_triangle` has the number of each in the file.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Its name: the file's name without its ending, or the built-in's name.
    pub name: String,
    /// Welded vertices, in the file's own coordinates counted from `origin`; every one is a corner of some triangle.
    pub positions: Vec<Vec3>,
    /// The origin of positions, in the file's coordinates; zero unless the model is small and far from zero.
    pub origin: DVec3,
    /// The corners of each triangle, wound to agree with its neighbours; the edge from the first to the second is the
    /// shortest.
    pub corners: Vec<[u32; 3]>,
    /// For each triangle, which corner of the file's triangle each of its corners is. They differ where winding was repaired, and because
    /// every triangle begins with its shortest edge: in a needle, the tangent frame along a long edge would lose digits of everything that
    /// a walk computes.
    pub file_corners: Vec<[u8; 3]>,
    /// The triangle's number in the file, polygons cut up; ascending.
    pub file_triangle: Vec<u32>,
    /// Texture coordinates of each triangle's corners (in the order of `corners`), if the model has them everywhere;
    /// as the file has them, so `v` points up in OBJ and PLY and down in glTF.
    pub uvs: Option<Vec<[Vec2; 3]>>,
    /// Pairs of border half-edges that are one edge, although they lie apart; ascending, and the lower one first. Triangles are numbered as
    /// in `corners`.
    pub glue: Vec<[u32; 2]>,
    /// Sizes, topology, and defects.
    pub report: MeshReport,
}

impl Mesh {
    /// The lowest and the highest coordinates, counted from `origin`.
    #[must_use]
    pub fn bounds(&self) -> (Vec3, Vec3) {
        self.positions.iter().fold(
            (Vec3::INFINITY, Vec3::NEG_INFINITY),
            |(low, high), &position| (low.min(position), high.max(position)),
        )
    }

    /// The point given by a face of the file and the weights of its three corners, in the file's order and numbering.
    /// `None` when the file has no such triangle, or it was dropped.
    #[must_use]
    pub fn point_from_file(&self, face: u32, weights: [f64; 3]) -> Option<SurfacePoint> {
        let triangle = self.file_triangle.binary_search(&face).ok()?;
        let [_, u, v] = self.file_corners[triangle].map(|corner| weights[corner as usize]);
        Some(SurfacePoint {
            triangle: triangle as u32,
            u,
            v,
        })
    }

    /// Is a triangle wound against the file?
    ///
    /// # Panics
    /// When the mesh has no such triangle.
    #[must_use]
    pub fn is_flipped(&self, triangle: u32) -> bool {
        let [a, b, _] = self.file_corners[triangle as usize];
        (a + 1) % 3 != b
    }

    /// The face in the file and the weights of its three corners there, for a point on this mesh.
    ///
    /// # Panics
    /// When the mesh has no such triangle.
    #[must_use]
    pub fn point_to_file(&self, point: SurfacePoint) -> (u32, [f64; 3]) {
        let triangle = point.triangle as usize;
        let ours = [1.0 - point.u - point.v, point.u, point.v];
        let mut weights = [0.0; 3];
        for (weight, corner) in ours.into_iter().zip(self.file_corners[triangle]) {
            weights[corner as usize] = weight;
        }
        (self.file_triangle[triangle], weights)
    }
}
