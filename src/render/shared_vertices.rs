//! Vertices for pictures: corners with equal attributes are one vertex, so that a device shades it once.
//!
//! Corners around a vertex of the mesh differ at creases, which break the normal, and at seams of the texture.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};

use crate::gpu::{Buffer, Context, Domain, GpuError, Texels, reaches_by_index};
use crate::mesh::surface::{AtlasMap, NONE};
use crate::sim::types::Vertex;

/// Places in the atlas closer than this, in texels, count as equal, because each triangle has rounded its own.
const SAME_TEXEL: f32 = 1.0 / 32.0;
/// The most vertices of a place that are searched for an equal one. If so many differ, one more does not matter.
const MOST_LOOKS: usize = 16;

/// Two texels of four words: `shaders/include/shared_vertex.glsl` reads them.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(super) struct SharedVertex {
    /// Object space.
    pub position: Vec3,
    pub object: u32,
    /// Position in the atlas.
    pub texel: Vec2,
    /// Packed, object space.
    pub normal: u32,
    /// The share of the sky that it sees.
    pub openness: f32,
}

impl SharedVertex {
    fn is_like(&self, other: &Self) -> bool {
        self.normal == other.normal
            && self.openness == other.openness
            && (self.texel - other.texel).abs().max_element() < SAME_TEXEL
    }
}

/// The attributes by which corners are joined.
pub(super) struct Corners<'a> {
    /// The vertex of each, three per triangle.
    pub vertex_of: &'a [u32],
    pub vertices: &'a [Vertex],
    /// One per triangle.
    pub maps: &'a [AtlasMap],
    /// Packed, one per corner.
    pub normals: &'a [u32],
    /// One per corner.
    pub openness: &'a [u8],
}

/// The vertices, in the order of triangles, and the vertex of each corner.
pub(super) fn share(corners: &Corners<'_>) -> (Vec<SharedVertex>, Vec<u32>) {
    let mut shared: Vec<SharedVertex> = Vec::with_capacity(corners.vertices.len());
    // For each vertex of the mesh the last shared vertex made from it, and for each of those the previous one.
    let mut last = vec![NONE; corners.vertices.len()];
    let mut before: Vec<u32> = Vec::with_capacity(corners.vertices.len());
    let join = |(corner, &vertex): (usize, &u32)| {
        let Vertex { position, object } = corners.vertices[vertex as usize];
        let AtlasMap { origin, du, dv } = corners.maps[corner / 3];
        let mine = SharedVertex {
            position,
            object,
            texel: origin + [Vec2::ZERO, du, dv][corner % 3],
            normal: corners.normals[corner],
            openness: f32::from(corners.openness[corner]) / 255.0,
        };
        let known = std::iter::successors(Some(last[vertex as usize]), |&i| {
            before.get(i as usize).copied()
        });
        let known = known.take_while(|&i| i != NONE).take(MOST_LOOKS);
        let alike = { known }.find(|&i| shared[i as usize].is_like(&mine));
        alike.unwrap_or_else(|| {
            let new = shared.len() as u32;
            shared.push(mine);
            before.push(std::mem::replace(&mut last[vertex as usize], new));
            new
        })
    };
    let indices = corners.vertex_of.iter().enumerate().map(join).collect();
    (shared, indices)
}

/// Shared vertices on the device.
pub(super) struct SharedVertices {
    /// Two texels per vertex.
    pub vertices: Texels<u32>,
    /// The vertex of each corner of each triangle.
    pub indices: Buffer<u32>,
}

impl SharedVertices {
    /// Uploads them, unless there are more than the device can index.
    ///
    /// # Errors
    /// The device has no memory left.
    pub(super) fn new(
        ctx: &Arc<Context>,
        (vertices, indices): &(Vec<SharedVertex>, Vec<u32>),
    ) -> Result<Option<Self>, GpuError> {
        let texels = size_of_val(vertices.as_slice()) / 16;
        if !reaches_by_index(ctx, vertices.len())
            || texels > ctx.info().max_texel_buffer_elements as usize
        {
            return Ok(None);
        }
        let vertices = Buffer::from_slice_in(ctx, "shared_vertices", vertices, Domain::Texels)?;
        Ok(Some(Self {
            vertices: Texels::new(&vertices, 4)?,
            indices: Buffer::from_slice_in(ctx, "indices", indices, Domain::Texels)?,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::mesh::atlas::{Atlas, AtlasMethod, AtlasOptions};
    use crate::mesh::surface::Surface;
    use crate::render::normals::{CREASE_ANGLE, corner_normals, pack_normal};

    fn shared(mesh: &str, method: AtlasMethod) -> (usize, Vec<SharedVertex>) {
        let surface = Surface::build(&[(&Mesh::builtin(mesh).unwrap(), 1.0)]);
        let options = AtlasOptions {
            method,
            size: 512,
            ..AtlasOptions::default()
        };
        let atlas = Atlas::build(&surface, &options).unwrap();
        let normals = corner_normals(&surface, CREASE_ANGLE);
        let normals: Vec<u32> = normals.into_iter().map(pack_normal).collect();
        let vertices: Vec<Vertex> = (surface.positions.iter())
            .map(|&position| Vertex {
                position,
                object: 3,
            })
            .collect();
        let vertex_of = surface.corners.as_flattened();
        // Corners of a vertex have equal openness, except one corner.
        let mut openness: Vec<u8> = vertex_of.iter().map(|v| (v % 200) as u8).collect();
        openness[4] = 255;
        let (shared, indices) = share(&Corners {
            vertex_of,
            vertices: &vertices,
            maps: &atlas.maps,
            normals: &normals,
            openness: &openness,
        });
        // Each corner's vertex has its attributes.
        assert_eq!(indices.len(), vertex_of.len());
        for (corner, &index) in indices.iter().enumerate() {
            let found = shared[index as usize];
            let AtlasMap { origin, du, dv } = atlas.maps[corner / 3];
            let texel = origin + [Vec2::ZERO, du, dv][corner % 3];
            assert_eq!(
                found.position,
                surface.positions[vertex_of[corner] as usize]
            );
            assert_eq!(found.object, 3);
            assert_eq!(found.normal, normals[corner]);
            assert_eq!(found.openness, f32::from(openness[corner]) / 255.0);
            assert!(
                found.texel.distance(texel) < 0.05,
                "{corner}: {} {texel}",
                found.texel
            );
        }
        (surface.corners.len(), shared)
    }

    #[test]
    fn corners_that_look_alike_are_one_vertex() {
        // Closed and smooth: half as many vertices as triangles, and those of the cuts once more; and one more for the corner with another
        // openness.
        let (triangles, torus) = shared("torus", AtlasMethod::Charts);
        assert!(
            (triangles / 2 + 1..triangles * 6 / 10).contains(&torus.len()),
            "{triangles} {}",
            torus.len()
        );
        // Three faces of another normal meet at each corner of a cube.
        let (triangles, cube) = shared("cube", AtlasMethod::Charts);
        assert!(
            cube.len() >= 24 && cube.len() < 3 * triangles,
            "{triangles} {}",
            cube.len()
        );
        // In the grid, triangles have nothing in common.
        let (triangles, grid) = shared("icosphere?subdivisions=2", AtlasMethod::Grid);
        assert!(grid.len() > 2 * triangles, "{triangles} {}", grid.len());
    }
}
