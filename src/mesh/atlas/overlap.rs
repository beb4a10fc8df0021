//! Tests whether triangles overlap in the texture.

use glam::{I64Vec2, IVec2};
use rayon::prelude::*;

use super::fixed::{Fixed, twice_area};
use super::{AtlasError, Control};

/// Triangles may overlap by this fraction of a texel (1/50), along the axis of least overlap, because exporters round coordinates.
const TOLERANCE: i32 = 50;

/// Squares along a side of the grid that triangles are sorted into, at the most.
const MOST_SQUARES: usize = 1024;

/// Two triangles that overlap, if any do; always the same two.
pub(super) fn first(
    corners: &[[IVec2; 3]],
    fixed: Fixed,
    control: &Control<'_>,
) -> Result<Option<(u32, u32)>, AtlasError> {
    let slack = (fixed.texel / TOLERANCE).max(2);
    let boxes: Vec<[IVec2; 2]> = corners
        .iter()
        .map(|[a, b, c]| [a.min(*b).min(*c), a.max(*b).max(*c)])
        .collect();
    let (mut low, mut high) = (IVec2::MAX, IVec2::MIN);
    for &[from, to] in &boxes {
        low = low.min(from);
        high = high.max(to);
    }
    let count = ((corners.len() as f64).sqrt() as usize).clamp(1, MOST_SQUARES);
    let step = ((high - low) / count as i32 + 1).max(IVec2::ONE);
    let mut squares: Vec<Vec<u32>> = vec![Vec::new(); count * count];
    for (t, &[from, to]) in boxes.iter().enumerate() {
        let [from, to] = [from, to].map(|place| ((place - low) / step).as_uvec2());
        for y in from.y..=to.y {
            for x in from.x..=to.x {
                squares[y as usize * count + x as usize].push(t as u32);
            }
        }
    }
    let found = squares.into_par_iter().map(|mut square| {
        control.check()?;
        // From left to right, so that a triangle is compared only with those beside it.
        square.sort_unstable_by_key(|&t| (boxes[t as usize][0].x, t));
        for (k, &a) in square.iter().enumerate() {
            let [from, to] = boxes[a as usize];
            let beside = square[k + 1..]
                .iter()
                .take_while(|&&b| boxes[b as usize][0].x < to.x);
            for &b in beside {
                let other = boxes[b as usize];
                if other[0].y < to.y
                    && from.y < other[1].y
                    && overlap(corners[a as usize], corners[b as usize], slack)
                {
                    return Ok(Some((a.min(b), a.max(b))));
                }
            }
        }
        Ok(None)
    });
    found
        .find_first(|found| !matches!(found, Ok(None)))
        .unwrap_or(Ok(None))
}

/// Do two triangles overlap? Tests whether a line parallel to an edge separates them.
fn overlap(a: [IVec2; 3], b: [IVec2; 3], slack: i32) -> bool {
    let lies_beside = |a: [IVec2; 3], b: [IVec2; 3]| {
        let orientation = twice_area(a).signum();
        (0..3).any(|k| {
            let (start, end) = (a[k].as_i64vec2(), a[(k + 1) % 3].as_i64vec2());
            let along = end - start;
            let outwards = I64Vec2::new(along.y, -along.x) * orientation;
            let least = b.map(|corner| outwards.dot(corner.as_i64vec2() - start));
            let least = least[0].min(least[1]).min(least[2]);
            let length = (along.length_squared() as f64).sqrt();
            least as f64 >= -f64::from(slack) * length
        })
    };
    // Triangles without area in the texture overlap nothing.
    let has_area = twice_area(a) != 0 && twice_area(b) != 0;
    has_area && !lies_beside(a, b) && !lies_beside(b, a)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separated_and_touching_triangles_do_not_overlap() {
        let place = |x: i32, y: i32| IVec2::new(1000 * x, 1000 * y);
        let a = [place(0, 0), place(4, 0), place(0, 4)];
        for (b, expected) in [
            ([place(4, 0), place(4, 4), place(0, 4)], false),
            ([place(4, 4), place(4, 0), place(0, 4)], false),
            ([place(5, 0), place(9, 0), place(5, 4)], false),
            ([place(0, 0), place(0, -4), place(4, 0)], false),
            ([place(1, 1), place(2, 1), place(1, 2)], true),
            ([place(-1, 1), place(9, 1), place(9, 2)], true),
            ([place(0, 0), place(0, 4), place(4, 0)], true),
            ([place(3, 3), place(9, 3), place(3, 9)], false),
        ] {
            assert_eq!(overlap(a, b, 2), expected, "{b:?}");
            assert_eq!(overlap(b, a, 2), expected, "{b:?}");
        }
    }
}
