//! The straightest path on the surface, in the tangent frame, in float32. Twin of `shaders/include/walk.glsl`.
//!
//! `CARRIES` stands for the shader's `WALK_CARRIES`: rounding errors are carried along.

use super::exact::{exact_product, exact_sum};
use super::types::Walker;
use crate::mesh::surface::{HalfEdge, NONE, Triangle};
use crate::strict::{LEAST_SIZE, positive, quotient, within};

/// The whole length was walked.
pub const WALK_DONE: u32 = 0;
/// The walk stopped at an open border.
pub const WALK_BORDER: u32 = 1;
/// The walk ran out of edge-crossing attempts.
pub const WALK_OUT_OF_ATTEMPTS: u32 = 2;

impl Walker {
    /// A walk of `length` (world units) that starts at `(triangle, u, v)`.
    #[must_use]
    pub fn at(triangle: u32, u: f32, v: f32, heading: [f32; 2], length: f32) -> Self {
        Self {
            triangle,
            weight_a: positive((1.0 - u) - v),
            weight_b: u,
            weight_c: v,
            heading_p: heading[0],
            heading_h: heading[1],
            remaining: length,
            entered_by: NONE,
            status: WALK_DONE,
            carry_a: 0.0,
            carry_b: 0.0,
            carry_c: 0.0,
            carry_p: 0.0,
            carry_h: 0.0,
            carry_remaining: 0.0,
        }
    }

    /// `(u, v)` for storage: inside the triangle whatever the rounding.
    #[must_use]
    pub fn uv(&self) -> [f32; 2] {
        let u = within(self.weight_b, 0.0, 1.0);
        [u, within(self.weight_c, 0.0, 1.0 - u)]
    }

    /// The heading, corrected to length 1 by one Newton step.
    #[must_use]
    pub fn heading(&self) -> [f32; 2] {
        let square = self.heading_p * self.heading_p + self.heading_h * self.heading_h;
        let scale = 1.5 - 0.5 * square;
        [self.heading_p * scale, self.heading_h * scale]
    }
}

/// A weight after some way, and its carry.
fn moved<const CARRIES: bool>(weight: f32, carry: f32, rate: f32, distance: f32) -> [f32; 2] {
    let change = rate * distance;
    if CARRIES {
        let carried = change + carry;
        let sum = exact_sum(weight, carried);
        return if sum[0] > 0.0 { sum } else { [0.0; 2] };
    }
    [positive(weight + change), 0.0]
}

/// One minus a place on an edge, and its carry.
fn from_other_end<const CARRIES: bool>(along: [f32; 2]) -> [f32; 2] {
    if CARRIES {
        let rest = exact_sum(1.0, -along[0]);
        return [rest[0], rest[1] - along[1]];
    }
    [1.0 - along[0], 0.0]
}

/// The remaining length after a distance, and its carry.
fn shortened<const CARRIES: bool>(remaining: f32, carry: f32, distance: f32) -> [f32; 2] {
    if CARRIES {
        let way = distance - carry;
        let left = positive(remaining - way);
        return [left, (remaining - left) - way];
    }
    [remaining - distance, 0.0]
}

/// A heading and its carry after a rotation: p, h, and the rounding error of each.
fn turned_by<const CARRIES: bool>(heading: [f32; 2], carry: [f32; 2], edge: HalfEdge) -> [f32; 4] {
    if CARRIES {
        let more = edge.fine_parts();
        let cos_p = exact_product(edge.cos, heading[0]);
        let sin_p = exact_product(edge.sin, heading[0]);
        let cos_h = exact_product(edge.cos, heading[1]);
        let sin_h = exact_product(edge.sin, heading[1]);
        let p = exact_sum(cos_p[0], -sin_h[0]);
        let h = exact_sum(sin_p[0], cos_h[0]);
        let mut dropped_p = p[1] + (cos_p[1] - sin_h[1]);
        let mut dropped_h = h[1] + (sin_p[1] + cos_h[1]);
        dropped_p += edge.cos * carry[0] - edge.sin * carry[1];
        dropped_h += edge.sin * carry[0] + edge.cos * carry[1];
        dropped_p += more[0] * heading[0] - more[1] * heading[1];
        dropped_h += more[1] * heading[0] + more[0] * heading[1];
        let p = exact_sum(p[0], dropped_p);
        let h = exact_sum(h[0], dropped_h);
        return [p[0], h[0], p[1], h[1]];
    }
    let p = edge.cos * heading[0] - edge.sin * heading[1];
    let h = edge.sin * heading[0] + edge.cos * heading[1];
    [p, h, 0.0, 0.0]
}

/// Walks what remains, over at most `attempts` edges. Reflections at open borders count as crossings.
pub fn walk<const CARRIES: bool>(
    triangles: &[Triangle],
    halfedges: &[HalfEdge],
    w: &mut Walker,
    mut attempts: u32,
    reflects: bool,
) {
    loop {
        let t = triangles[w.triangle as usize];
        let rate_c = quotient(w.heading_h, t.ch);
        let rate_b = quotient(w.heading_p - rate_c * t.cp, t.ab);
        let rate_a = -rate_b - rate_c;

        let way = |rate: f32, weight: f32, corner: u32| {
            if rate < -LEAST_SIZE && w.entered_by != corner {
                quotient(weight, -rate)
            } else {
                w.remaining
            }
        };
        let to_ab = way(rate_c, w.weight_c, 0);
        let to_bc = way(rate_a, w.weight_a, 1);
        let to_ca = way(rate_b, w.weight_b, 2);
        let distance = to_ab.min(to_bc).min(to_ca.min(w.remaining));
        let ends = distance == w.remaining;
        let corner = if to_ab == distance {
            0
        } else if to_bc == distance {
            1
        } else {
            2
        };

        let a = moved::<CARRIES>(w.weight_a, w.carry_a, rate_a, distance);
        let b = moved::<CARRIES>(w.weight_b, w.carry_b, rate_b, distance);
        let c = moved::<CARRIES>(w.weight_c, w.carry_c, rate_c, distance);
        let remaining = shortened::<CARRIES>(w.remaining, w.carry_remaining, distance);

        let edge = halfedges[3 * w.triangle as usize + corner];
        let at_border = edge.twin == NONE;
        let stops = ends || attempts == 0 || (at_border && !reflects);
        let stays = stops || at_border;
        let mut along = [b, c, a][corner];
        if CARRIES {
            let end_rate = [rate_b, rate_c, rate_a][corner];
            let start_rate = [rate_a, rate_b, rate_c][corner];
            if start_rate.abs() < end_rate.abs() {
                along = from_other_end::<CARRIES>([a, b, c][corner]);
            }
            if along[0] < 0.0 {
                along = [0.0; 2];
            } else if along[0] > 1.0 {
                along = [1.0, 0.0];
            }
        }
        along[0] = along[0].min(1.0);
        let rest = from_other_end::<CARRIES>(along);
        let next_corner = if stays { corner as u32 } else { edge.twin % 3 };
        let (start, end) = if stays { (rest, along) } else { (along, rest) };
        let zero = [0.0; 2];
        let [a, b, c] = match next_corner {
            _ if ends => [a, b, c],
            0 => [start, end, zero],
            1 => [zero, start, end],
            _ => [end, zero, start],
        };
        [w.weight_a, w.carry_a] = a;
        [w.weight_b, w.carry_b] = b;
        [w.weight_c, w.carry_c] = c;
        w.remaining = if CARRIES && ends { 0.0 } else { remaining[0] };
        w.carry_remaining = if ends { 0.0 } else { remaining[1] };
        w.status = if ends {
            WALK_DONE
        } else if at_border && !reflects {
            WALK_BORDER
        } else {
            WALK_OUT_OF_ATTEMPTS
        };
        if stops {
            return;
        }

        let side = if at_border { -1.0 } else { 1.0 };
        let heading = [w.heading_p, side * w.heading_h];
        let carry = [w.carry_p, side * w.carry_h];
        [w.heading_p, w.heading_h, w.carry_p, w.carry_h] =
            turned_by::<CARRIES>(heading, carry, edge);
        w.triangle = if stays { w.triangle } else { edge.twin / 3 };
        w.entered_by = next_corner;
        attempts -= 1;
    }
}
