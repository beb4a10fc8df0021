//! What a mesh is like, everything odd about it, and what was done about that.

use std::fmt;

use super::edges::{next, previous, twins};
use super::surface::NONE;

/// Sizes, topology and oddities of one mesh; printed in one line when nothing is odd.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MeshReport {
    /// Triangles, without those that were dropped.
    pub triangles: usize,
    /// Welded vertices.
    pub vertices: usize,
    /// Edges, borders included.
    pub edges: usize,
    /// Pieces that hang together over edges.
    pub parts: usize,
    /// Half-edges without a twin.
    pub border_edges: usize,
    /// Closed chains of border edges.
    pub border_loops: usize,
    /// Vertices where the surface touches itself in a point; a walk cannot pass from one side to the other there.
    pub pinched_vertices: usize,
    /// Vertices - edges + triangles, where a pinched vertex counts once for each sheet that meets there.
    pub euler_characteristic: i64,
}

impl MeshReport {
    /// Measures the topology of welded triangles.
    pub(crate) fn measure(corners: &[[u32; 3]], vertices: usize) -> Self {
        let twins = twins(corners);
        let border_edges = twins.iter().filter(|&&twin| twin == NONE).count();
        let edges = border_edges + (twins.len() - border_edges) / 2;
        let fans = count_fans(&twins);
        Self {
            triangles: corners.len(),
            vertices,
            edges,
            parts: count_parts(&twins),
            border_edges,
            border_loops: count_border_loops(&twins),
            pinched_vertices: count_pinched(corners, &twins, vertices),
            euler_characteristic: fans as i64 - edges as i64 + corners.len() as i64,
        }
    }

    /// Whether no edge is open.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.border_edges == 0
    }

    /// The number of handles, summed over all parts, with every border loop taken for a hole in a closed surface.
    #[must_use]
    pub fn genus(&self) -> u64 {
        let capped = self.euler_characteristic + self.border_loops as i64;
        u64::try_from((2 * self.parts as i64 - capped) / 2).unwrap_or(0)
    }
}

impl fmt::Display for MeshReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} triangles, {} vertices",
            grouped(self.triangles),
            grouped(self.vertices)
        )?;
        if self.parts > 1 {
            write!(f, ", {} parts", grouped(self.parts))?;
        }
        if self.is_closed() {
            write!(f, ", closed")?;
        } else {
            write!(
                f,
                ", {} border edges in {} {}",
                grouped(self.border_edges),
                grouped(self.border_loops),
                if self.border_loops == 1 {
                    "loop"
                } else {
                    "loops"
                }
            )?;
        }
        write!(f, ", genus {}", self.genus())
    }
}

/// A count with commas between the thousands.
pub(crate) fn grouped(count: usize) -> String {
    let digits = count.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

fn count_parts(twins: &[u32]) -> usize {
    let mut seen = vec![false; twins.len() / 3];
    let mut parts = 0;
    let mut open = Vec::new();
    for first in 0..seen.len() {
        if std::mem::replace(&mut seen[first], true) {
            continue;
        }
        parts += 1;
        open.push(first);
        while let Some(triangle) = open.pop() {
            for &twin in &twins[3 * triangle..3 * triangle + 3] {
                if twin != NONE && !std::mem::replace(&mut seen[twin as usize / 3], true) {
                    open.push(twin as usize / 3);
                }
            }
        }
    }
    parts
}

/// Marks every corner of the fan of triangles round a vertex that a corner belongs to.
fn mark_fan(twins: &[u32], corner: u32, seen: &mut [bool]) {
    seen[corner as usize] = true;
    let mut left = twins[previous(corner) as usize];
    while left != NONE && !seen[left as usize] {
        seen[left as usize] = true;
        left = twins[previous(left) as usize];
    }
    let mut right = twins[corner as usize];
    while right != NONE && !seen[next(right) as usize] {
        seen[next(right) as usize] = true;
        right = twins[next(right) as usize];
    }
}

fn count_fans(twins: &[u32]) -> usize {
    let mut seen = vec![false; twins.len()];
    let mut fans = 0;
    for corner in 0..twins.len() {
        if !seen[corner] {
            mark_fan(twins, corner as u32, &mut seen);
            fans += 1;
        }
    }
    fans
}

fn count_pinched(corners: &[[u32; 3]], twins: &[u32], vertices: usize) -> usize {
    let mut seen = vec![false; twins.len()];
    let mut fans_at = vec![0_u32; vertices];
    for corner in 0..twins.len() {
        if !seen[corner] {
            mark_fan(twins, corner as u32, &mut seen);
            fans_at[corners[corner / 3][corner % 3] as usize] += 1;
        }
    }
    fans_at.iter().filter(|&&fans| fans > 1).count()
}

fn count_border_loops(twins: &[u32]) -> usize {
    let mut seen = vec![false; twins.len()];
    let mut loops = 0;
    for first in 0..twins.len() {
        if twins[first] != NONE || seen[first] {
            continue;
        }
        loops += 1;
        let mut border = first as u32;
        while !std::mem::replace(&mut seen[border as usize], true) {
            // Turn about the end of this border until the next one leaves it.
            border = next(border);
            while twins[border as usize] != NONE {
                border = next(twins[border as usize]);
            }
        }
    }
    loops
}
