//! Origins of coordinates. Single precision has 24 bits: a model a metre wide that is 5,000 km from the origin, as in map coordinates,
//! would have steps of half a metre. Therefore coordinates far from the origin are counted from a place nearby, chosen in double precision
//! before anything is rounded.

use glam::DVec3;

use crate::portable::power_of_two_from;

/// In extents of a model or scene: within this distance from the origin, coordinates are counted from the origin itself. Single precision
/// loses at most five bits there.
const NEAR: f64 = 16.0;

/// In extents: how far apart the places are that a scene's coordinates can be counted from. One about the origin that is
/// moved by a multiple keeps every bit.
const APART: f64 = 8.0;

/// Fewer steps of single precision across a model are reported: details are lost that a picture shows.
const FEW: f64 = 65_536.0;

/// The origin of the coordinates of a mesh in a box: zero, or if the box is small and far away, its middle.
/// If a mesh around the origin with decimal coordinates is moved, nearly all of them keep their bits.
#[must_use]
pub fn of_mesh(low: DVec3, high: DVec3) -> DVec3 {
    if is_far_away(low, high) {
        low.midpoint(high)
    } else {
        DVec3::ZERO
    }
}

/// The origin of the coordinates of a scene in a box: zero, or if the box is small and far away, a place
/// near its middle. That is a multiple of a power of two, so that the difference from it is exact if a scene is moved by such a multiple.
#[must_use]
pub fn of_scene(low: DVec3, high: DVec3) -> DVec3 {
    if !is_far_away(low, high) {
        return DVec3::ZERO;
    }
    let apart = power_of_two_from(APART * (high - low).max_element());
    (low.midpoint(high) / apart).round() * apart
}

fn is_far_away(low: DVec3, high: DVec3) -> bool {
    let extent = (high - low).max_element();
    let farthest = low.abs().max(high.abs()).max_element();
    // A box that is not finite is refused elsewhere, and a point has no extent.
    farthest.is_finite() && extent > 0.0 && farthest > NEAR * extent
}

/// The lowest and the highest coordinates.
pub(crate) fn bounds<'a>(positions: impl IntoIterator<Item = &'a DVec3>) -> (DVec3, DVec3) {
    let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let both = |(low, high): (DVec3, DVec3), p: &DVec3| (low.min(*p), high.max(*p));
    positions.into_iter().fold(empty, both)
}

/// How many steps of single precision lie across a box of coordinates that were stored so, if they are few because the
/// box is far from the origin.
pub(crate) fn steps_across(low: DVec3, high: DVec3) -> Option<usize> {
    if !is_far_away(low, high) {
        return None;
    }
    few_steps(low, high)
}

/// How many steps of single precision lie across a box, if they are few.
pub(crate) fn few_steps(low: DVec3, high: DVec3) -> Option<usize> {
    // The axis that counts is the one with the coarsest steps.
    let farthest = low.abs().max(high.abs()).max_element() as f32;
    let step = f64::from(farthest.next_up() - farthest);
    let steps = (high - low).max_element() / step;
    (steps < FEW).then_some(steps as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn about(middle: DVec3, half: f64) -> DVec3 {
        of_scene(middle - half, middle + half)
    }

    /// Would catch: a scene near the origin that is counted from elsewhere, so that its bits change; a far one that is
    /// not; and a place that moves with less than the whole scene.
    #[test]
    fn what_is_far_is_counted_from_a_multiple_of_a_power_of_two() {
        assert_eq!(about(DVec3::splat(15.0), 0.5), DVec3::ZERO);
        assert_eq!(about(DVec3::splat(1e7), 1e6), DVec3::ZERO);
        // Extent 3 takes multiples of 32.
        let far = DVec3::new(512_345.0, 231.0, -5_412_345.0);
        let origin = about(far, 1.5);
        assert_eq!(origin, DVec3::new(512_352.0, 224.0, -5_412_352.0));
        let moved = about(far + DVec3::new(-1e7, 3.2e6, 32.0), 1.5);
        assert_eq!(moved - origin, DVec3::new(-1e7, 3.2e6, 32.0));
        for nothing in [DVec3::INFINITY, DVec3::NAN] {
            assert_eq!(of_scene(nothing, nothing), DVec3::ZERO);
            assert_eq!(of_mesh(nothing, nothing), DVec3::ZERO);
        }
        assert_eq!(about(DVec3::splat(1e9), 0.0), DVec3::ZERO);
    }

    /// Would catch: a sentence about lost digits where none are lost, or none where they are.
    #[test]
    fn stored_steps_are_counted_where_they_are_few() {
        let at = |x: f64| steps_across(DVec3::X * x, DVec3::X * (x + 6.0));
        // Single precision has steps of 0.5 from 2^22 on.
        assert_eq!(at(5_412_345.0), Some(12));
        assert_eq!(at(1000.0), None);
        assert_eq!(at(-3.0), None);
    }
}
