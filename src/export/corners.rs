//! Joins corners of triangles with equal normals and places in the atlas to vertices that triangles share.

use std::collections::HashMap;

use glam::Vec3;

use crate::mesh::atlas::Atlas;
use crate::mesh::surface::Surface;
use crate::render::normals::{CREASE_ANGLE, corner_normals, pack_normal};

/// Places in the atlas closer than this, in parts of a texel, count as equal.
const PARTS: f32 = 64.0;

/// Vertices, and triangles of them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Shared {
    /// For each vertex one of its corners, `3 * triangle + k`, for the attributes.
    pub corners: Vec<u32>,
    /// Three for each triangle.
    pub indices: Vec<u32>,
}

/// The attributes in which corners of one vertex may differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// Normals.
    Creases,
    /// Normals, and places in the atlas.
    CreasesAndSeams,
}

/// Normals of all corners of a surface, object space.
#[must_use]
pub fn normals(surface: &Surface) -> Vec<Vec3> {
    corner_normals(surface, CREASE_ANGLE)
}

/// The vertices of these triangles, in the order in which corners come.
#[must_use]
pub fn share(
    surface: &Surface,
    atlas: &Atlas,
    normals: &[Vec3],
    triangles: std::ops::Range<u32>,
    split: Split,
) -> Shared {
    let mut shared = Shared::default();
    let mut known = HashMap::new();
    for triangle in triangles {
        for k in 0..3 {
            let corner = 3 * triangle + k;
            let place = match split {
                Split::Creases => None,
                Split::CreasesAndSeams => {
                    let texel = atlas_position(atlas, corner);
                    let parts = texel.map(|x| (x * PARTS).round() as u32);
                    Some((atlas.chart[triangle as usize], parts))
                }
            };
            let vertex = surface.corners[triangle as usize][k as usize];
            let key = (vertex, pack_normal(normals[corner as usize]), place);
            let index = *known.entry(key).or_insert_with(|| {
                shared.corners.push(corner);
                shared.corners.len() as u32 - 1
            });
            shared.indices.push(index);
        }
    }
    shared
}

/// The position of a corner in the atlas, in texels.
#[must_use]
pub fn atlas_position(atlas: &Atlas, corner: u32) -> [f32; 2] {
    let (u, v) = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)][corner as usize % 3];
    atlas.position_of(corner / 3, u, v).to_array()
}

/// The vertex of a corner, object space.
#[must_use]
pub fn position(surface: &Surface, corner: u32) -> Vec3 {
    let vertex = surface.corners[corner as usize / 3][corner as usize % 3];
    surface.positions[vertex as usize]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::mesh::atlas::{AtlasMethod, AtlasOptions};

    /// A cube whose sides are charts of their own or not: 8 vertices, of which each has three normals.
    #[test]
    fn vertices_are_split_along_creases_and_seams_only() {
        let surface = Surface::build(&[(&Mesh::builtin("cube?divisions=3").unwrap(), 1.0)]);
        let options = AtlasOptions {
            method: AtlasMethod::Charts,
            size: 128,
            ..AtlasOptions::default()
        };
        let atlas = Atlas::build(&surface, &options).unwrap();
        let normals = normals(&surface);
        let all = 0..surface.corners.len() as u32;
        let creased = share(&surface, &atlas, &normals, all.clone(), Split::Creases);
        // 16 vertices a side.
        assert_eq!(creased.corners.len(), 6 * 16);
        let seamed = share(&surface, &atlas, &normals, all, Split::CreasesAndSeams);
        assert!(seamed.corners.len() >= creased.corners.len());
        for shared in [&creased, &seamed] {
            for (corner, &index) in shared.indices.iter().enumerate() {
                let (here, there) = (corner as u32, shared.corners[index as usize]);
                assert_eq!(position(&surface, here), position(&surface, there));
                let off = normals[corner].distance(normals[there as usize]);
                assert!(off < 1e-3, "corner {corner}: {off}");
            }
        }
        for (corner, &index) in seamed.indices.iter().enumerate() {
            let [here, there] = [corner as u32, seamed.corners[index as usize]]
                .map(|corner| glam::Vec2::from_array(atlas_position(&atlas, corner)));
            assert!(here.distance(there) < 0.05, "corner {corner}");
        }
    }
}
