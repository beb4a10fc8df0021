//! Groups half-edges by their edge, and pairs twins.

use rayon::slice::ParallelSliceMut;

use super::surface::NONE;

/// The corner that a half-edge starts at, and the one that it runs to.
pub(crate) fn ends(corners: &[[u32; 3]], halfedge: u32) -> (u32, u32) {
    let triangle = corners[halfedge as usize / 3];
    let corner = halfedge as usize % 3;
    (triangle[corner], triangle[(corner + 1) % 3])
}

/// The half-edge after this one in its triangle.
pub(crate) fn next(halfedge: u32) -> u32 {
    if halfedge % 3 == 2 {
        halfedge - 2
    } else {
        halfedge + 1
    }
}

/// The half-edge before this one in its triangle.
pub(crate) fn previous(halfedge: u32) -> u32 {
    if halfedge.is_multiple_of(3) {
        halfedge + 2
    } else {
        halfedge - 1
    }
}

/// Every half-edge, sorted so that those of one edge are adjacent, and ascending within an edge.
pub(crate) struct EdgeGroups {
    sorted: Vec<(u64, u32)>,
}

impl EdgeGroups {
    /// Groups the half-edges of triangles whose three corners differ.
    pub(crate) fn new(corners: &[[u32; 3]]) -> Self {
        let mut sorted: Vec<(u64, u32)> = corners
            .iter()
            .enumerate()
            .flat_map(|(triangle, &[a, b, c])| {
                let first = 3 * triangle as u32;
                [
                    (edge_key(a, b), first),
                    (edge_key(b, c), first + 1),
                    (edge_key(c, a), first + 2),
                ]
            })
            .collect();
        sorted.par_sort_unstable();
        Self { sorted }
    }

    /// The half-edges of each edge in turn: one at a border, two inside, more where the mesh is not a manifold.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &[(u64, u32)]> {
        self.sorted.chunk_by(|a, b| a.0 == b.0)
    }

    /// Follows triangles of which corners 1 and 2 have been swapped.
    pub(crate) fn flip(&mut self, flipped: &[bool]) {
        for (_, halfedge) in &mut self.sorted {
            let (triangle, corner) = (*halfedge / 3, *halfedge % 3);
            if flipped[triangle as usize] {
                *halfedge = 3 * triangle + 2 - corner;
            }
        }
    }

    /// The twin of every half-edge, or [`NONE`].
    ///
    /// The rule, for any number of triangles at an edge: the first half-edge in file order and the first that runs
    /// against it are twins, and all others are borders. Two triangles of opposite winding stay borders to each other.
    pub(crate) fn twins(&self, corners: &[[u32; 3]]) -> Vec<u32> {
        let mut twins = vec![NONE; 3 * corners.len()];
        for group in self.iter() {
            let (_, first) = group[0];
            let (start, _) = ends(corners, first);
            let against = group[1..]
                .iter()
                .find(|(_, h)| ends(corners, *h).1 == start);
            if let Some(&(_, second)) = against {
                twins[first as usize] = second;
                twins[second as usize] = first;
            }
        }
        twins
    }
}

fn edge_key(a: u32, b: u32) -> u64 {
    u64::from(a.min(b)) << 32 | u64::from(a.max(b))
}
