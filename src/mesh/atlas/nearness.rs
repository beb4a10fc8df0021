//! Tests whether two parts of a chart's border that are far apart along it come within reach of the same texel.
//!
//! Such a texel would continue the one part for some reads and the other part for others. The two sides of a narrow wedge are near each
//! other on the surface as well, and both sides of a thin strip may be within reach of a texel: neither is a problem.

use glam::{DVec2, IVec2};

use super::fixed::Fixed;
use super::outline::Cells;

/// Parts of a border are far apart if the distance along it is more than this many texels, and this many times the reach.
const FAR: f64 = 8.0;

/// Takes closed loops of border edges in units, counter-clockwise; `loops` has the loop of each edge.
pub(super) fn is_near_itself(edges: &[[IVec2; 2]], loops: &[u32], fixed: Fixed) -> bool {
    let cells = Cells {
        side: fixed.texel,
        reach: fixed.reach,
    };
    // The start of each edge along its loop, and the length of the loop.
    let mut along = Vec::with_capacity(edges.len());
    let mut lengths: Vec<f64> = Vec::new();
    for (&[a, b], &in_loop) in edges.iter().zip(loops) {
        lengths.resize(in_loop as usize + 1, 0.0);
        let length = &mut lengths[in_loop as usize];
        along.push(*length);
        *length += (b - a).as_dvec2().length();
    }
    let far = FAR * f64::from(fixed.reach + fixed.texel);
    let are_far = |[e, f]: [u32; 2], [a, b]: [Side; 2]| {
        let [e, f] = [e, f].map(|edge| edge as usize);
        let apart = (along[e] + a.along - along[f] - b.along).abs();
        loops[e] != loops[f] || apart.min(lengths[loops[e] as usize] - apart) > far
    };
    let mut claims: Vec<(i32, i32, u32)> = Vec::new();
    for (index, &edge) in edges.iter().enumerate() {
        let (first, end) = cells.rows(edge);
        for row in first..end {
            let (from, to) = cells.columns(edge, row);
            claims.extend((from..to).map(|column| (row, column, index as u32)));
        }
    }
    claims.sort_unstable();
    claims
        .chunk_by(|a, b| (a.0, a.1) == (b.0, b.1))
        .any(|claims| {
            let (row, column, first) = claims[0];
            let centre = (IVec2::new(column, row) * fixed.texel + fixed.texel / 2).as_dvec2();
            claims[1..].iter().any(|&(.., other)| {
                let [a, b] = [first, other].map(|edge| side_of(edges[edge as usize], centre));
                // Between the two edges there is either a thin part of the chart or the outside.
                let farther = if a.distance > b.distance { a } else { b };
                farther.beside && farther.outside && are_far([first, other], [a, b])
            })
        })
}

/// A place in the coordinates of an edge.
#[derive(Clone, Copy)]
struct Side {
    distance: f64,
    /// How far along the edge the nearest point is.
    along: f64,
    /// Whether the nearest point is not an end of the edge.
    beside: bool,
    /// Is the place to the right of the edge?
    outside: bool,
}

fn side_of(edge: [IVec2; 2], place: DVec2) -> Side {
    let [a, b] = edge.map(|end| end.as_dvec2());
    let along = (place - a).dot(b - a) / (b - a).length_squared().max(1.0);
    let nearest = a + along.clamp(0.0, 1.0) * (b - a);
    Side {
        distance: (place - nearest).length(),
        along: (nearest - a).length(),
        beside: (0.0..=1.0).contains(&along),
        outside: (b - a).perp_dot(place - a) < 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A closed loop through corners given in texels.
    fn is_near(corners: &[(f64, f64)]) -> bool {
        let fixed = Fixed::new(1024, 1);
        let places: Vec<IVec2> = corners
            .iter()
            .map(|&(x, y)| (DVec2::new(x, y) * f64::from(fixed.texel)).as_ivec2())
            .collect();
        let edges: Vec<[IVec2; 2]> = (0..places.len())
            .map(|k| [places[k], places[(k + 1) % places.len()]])
            .collect();
        is_near_itself(&edges, &vec![0; edges.len()], fixed)
    }

    #[test]
    fn channels_are_found_and_strips_and_wedges_are_not() {
        // A horseshoe whose arms are this far apart.
        let horseshoe = |gap: f64| {
            is_near(&[
                (10.3, 10.2),
                (70.0 + gap, 10.2),
                (70.0 + gap, 90.7),
                (40.0 + gap, 90.7),
                (40.0 + gap, 40.2),
                (40.0, 40.2),
                (40.0, 90.7),
                (10.3, 90.7),
            ])
        };
        for gap in [0.1, 0.4, 0.7, 1.0] {
            assert!(horseshoe(gap), "{gap}");
        }
        for gap in [3.1, 5.0, 20.0] {
            assert!(!horseshoe(gap), "{gap}");
        }
        for width in [0.1, 0.5, 1.0, 1.7] {
            let strip = [
                (10.2, 20.3),
                (90.1, 31.7),
                (90.1, 31.7 + width),
                (10.2, 20.3 + width),
            ];
            assert!(!is_near(&strip), "{width}");
        }
        // A right angle with a wedge cut into it.
        let wedge = [
            (10.0, 10.0),
            (90.0, 10.0),
            (90.0, 90.0),
            (20.0, 20.0),
            (10.0, 90.0),
        ];
        assert!(!is_near(&wedge));
    }
}
