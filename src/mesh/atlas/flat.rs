//! A flattened piece of the surface, before it has a place in the texture.

use glam::DVec2;

/// Neighbouring triangles of one object, flattened side by side: a disc without a fold.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FlatChart {
    /// The object that all its triangles belong to.
    pub object: u32,
    /// In ascending order.
    pub triangles: Vec<u32>,
    /// Per triangle: where its three corners lie, world units, counter-clockwise. Triangles that share an edge inside the
    /// chart have bitwise equal corners there. The chart's area is that of its triangles on the surface.
    pub corners: Vec<[DVec2; 3]>,
}
