//! The data for a straight walk through a strip of triangles, unfolded into the plane: for every edge the triangle behind it and the place
//! of that triangle's third corner relative to the edge. A walk needs one read per edge, and no rotation of headings.
//! [`walk`](super::walk) is the reference.

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, Vec2};
use rayon::prelude::*;

use super::surface::{AtlasMap, NONE, Surface, Triangle};
use crate::strict::reciprocal;

/// The triangle behind an edge.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct StripEdge {
    /// Its triangle times 4 plus its corner: the edge as that triangle sees it. [`NONE`] at an open border, where the
    /// triangle itself lies behind, mirrored.
    pub twin: u32,
    /// The position of its third corner along the edge, in parts of the edge, from the start as that triangle sees it.
    pub along: f32,
    /// How far off the edge, in parts of the edge; positive.
    pub off: f32,
    /// Always 0.
    pub pad: u32,
}

/// A triangle, the triangles behind its edges, and its place in the atlas: all data of a step, contiguous. 128 bytes, so that none lies
/// in more cache lines than it has to.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct StripTriangle {
    /// From corner A to B, from B to C, from C to A.
    pub edges: [StripEdge; 3],
    /// Its own shape.
    pub shape: Triangle,
    /// Its place in the atlas.
    pub map: AtlasMap,
    /// The bins of particles on it when they are sorted; zeros until bins are numbered.
    pub bins: TileBins,
    /// The way in the atlas, in texels, of one world unit along the first axis of its frame, and along the second.
    pub texels: [Vec2; 2],
    /// Always 0.
    pub pad: [u32; 4],
}

/// Which bin each tile of the atlas has, for the particles of a triangle.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct TileBins {
    /// The bin of the tile in the atlas's corner, if that had one; sums wrap round.
    pub base: u32,
    /// How many bins on the next tile of the row is, and in the upper half that of the column; 0 where all tiles have one bin.
    pub strides: u32,
}

impl TileBins {
    /// The bin of a tile, by its column and row.
    #[must_use]
    pub fn of_tile(self, [x, y]: [u32; 2]) -> u32 {
        let [of_row, of_column] = [self.strides & 0xffff, self.strides >> 16];
        let way = x
            .wrapping_mul(of_row)
            .wrapping_add(y.wrapping_mul(of_column));
        self.base.wrapping_add(way)
    }
}

impl Surface {
    /// The table of all triangles, which lie so in the atlas.
    #[must_use]
    pub fn strips(&self, maps: &[AtlasMap]) -> Vec<StripTriangle> {
        self.triangles
            .par_iter()
            .zip(maps)
            .enumerate()
            .map(|(triangle, (&shape, &map))| StripTriangle {
                edges: [0, 1, 2].map(|corner| {
                    let halfedge = 3 * triangle as u32 + corner;
                    let twin = self.halfedges[halfedge as usize].twin;
                    let behind = if twin == NONE { halfedge } else { twin };
                    let third = self.third_corner(behind);
                    StripEdge {
                        twin: if twin == NONE {
                            NONE
                        } else {
                            4 * (twin / 3) + twin % 3
                        },
                        along: third.x as f32,
                        off: third.y as f32,
                        pad: 0,
                    }
                }),
                shape,
                map,
                bins: TileBins::default(),
                texels: texels_of_frame(shape, map),
                pad: [0; 4],
            })
            .collect()
    }

    /// The position of the third corner of a half-edge's triangle along the half-edge and off it, in parts of its length.
    fn third_corner(&self, halfedge: u32) -> DVec2 {
        let Triangle { ab, cp, ch, .. } = self.triangles[halfedge as usize / 3];
        let corners = [
            DVec2::ZERO,
            DVec2::new(ab.into(), 0.0),
            DVec2::new(cp.into(), ch.into()),
        ];
        let [start, end, third] = [0, 1, 2].map(|k| corners[(halfedge as usize % 3 + k) % 3]);
        let (edge, way) = (end - start, third - start);
        DVec2::new(edge.dot(way), edge.perp_dot(way)) / edge.length_squared()
    }
}

/// Texels per world unit along the two axes of a triangle's frame.
fn texels_of_frame(shape: Triangle, map: AtlasMap) -> [Vec2; 2] {
    let Triangle { ab, cp, ch, .. } = shape;
    let by = reciprocal(ab * ch);
    [map.du * (ch * by), (ab * map.dv - cp * map.du) * by]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::primitive;

    #[test]
    fn the_triangle_behind_an_edge_is_seen_from_there() {
        let mesh = primitive::plane(1, 1);
        let surface = Surface::build(&[(&mesh, 1.0)]);
        let maps = vec![bytemuck::Zeroable::zeroed(); surface.triangles.len()];
        let strips = surface.strips(&maps);
        for (triangle, strip) in strips.iter().enumerate() {
            for (corner, edge) in strip.edges.iter().enumerate() {
                let [a, b] = [corner, (corner + 1) % 3]
                    .map(|k| surface.positions[surface.corners[triangle][k] as usize]);
                let (behind, start, end) = if edge.twin == NONE {
                    let opposite = surface.corners[triangle][(corner + 2) % 3];
                    (opposite, a, b)
                } else {
                    let [other, its] = [edge.twin as usize / 4, edge.twin as usize % 4];
                    (surface.corners[other][(its + 2) % 3], b, a)
                };
                let way = surface.positions[behind as usize] - start;
                let along = way.dot(end - start) / (end - start).length_squared();
                let off = (way - along * (end - start)).length() / (end - start).length();
                assert!((along - edge.along).abs() < 1e-6 && (off - edge.off).abs() < 1e-6);
            }
        }
    }
}
