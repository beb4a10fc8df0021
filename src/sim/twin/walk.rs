//! Twin of `shaders/include/walk.glsl`: the straightest path on the surface, in the tangent frame, in float32.
//!
//! `CARRIES` stands for the shader's `WALK_CARRIES`: what rounding drops is carried along.

use super::exact::{exact_product, exact_sum};
use crate::mesh::surface::{HalfEdge, NONE, Triangle};
use crate::sim::types::Walker;

/// The whole length was walked.
pub const WALK_DONE: u32 = 0;
/// The walk stopped at an open border.
pub const WALK_BORDER: u32 = 1;
/// The walk ran out of edge-crossing attempts.
pub const WALK_OUT_OF_ATTEMPTS: u32 = 2;

impl Walker {
    /// A walk that starts at `(triangle, u, v)` and has `length` (world units) before it.
    #[must_use]
    pub fn at(triangle: u32, u: f32, v: f32, heading: [f32; 2], length: f32) -> Self {
        Self {
            triangle,
            weight_a: ((1.0 - u) - v).max(0.0),
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
        let u = self.weight_b.clamp(0.0, 1.0);
        [u, self.weight_c.clamp(0.0, 1.0 - u)]
    }

    /// The heading, brought back to length 1 by one step of Newton's method.
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
    [(weight + change).max(0.0), 0.0]
}

/// One minus a place on an edge, and its carry.
fn from_other_end<const CARRIES: bool>(along: [f32; 2]) -> [f32; 2] {
    if CARRIES {
        let rest = exact_sum(1.0, -along[0]);
        return [rest[0], rest[1] - along[1]];
    }
    [1.0 - along[0], 0.0]
}

fn set_weights(w: &mut Walker, a: [f32; 2], b: [f32; 2], c: [f32; 2]) {
    [w.weight_a, w.weight_b, w.weight_c] = [a[0], b[0], c[0]];
    [w.carry_a, w.carry_b, w.carry_c] = [a[1], b[1], c[1]];
}

/// Puts the walker on the half-edge of a corner: the weights of its start and of its end.
fn set_on_edge(w: &mut Walker, corner: u32, start: [f32; 2], end: [f32; 2]) {
    let zero = [0.0; 2];
    match corner {
        0 => set_weights(w, start, end, zero),
        1 => set_weights(w, zero, start, end),
        _ => set_weights(w, end, zero, start),
    }
}

fn shorten<const CARRIES: bool>(w: &mut Walker, distance: f32) {
    if CARRIES {
        let way = distance - w.carry_remaining;
        let left = (w.remaining - way).max(0.0);
        w.carry_remaining = (w.remaining - left) - way;
        w.remaining = left;
    } else {
        w.remaining -= distance;
    }
}

fn turn<const CARRIES: bool>(w: &mut Walker, edge: HalfEdge) {
    if CARRIES {
        let fine = edge.fine_parts();
        let cos_p = exact_product(edge.cos, w.heading_p);
        let sin_p = exact_product(edge.sin, w.heading_p);
        let cos_h = exact_product(edge.cos, w.heading_h);
        let sin_h = exact_product(edge.sin, w.heading_h);
        let p = exact_sum(cos_p[0], -sin_h[0]);
        let h = exact_sum(sin_p[0], cos_h[0]);
        let mut dropped_p = p[1] + (cos_p[1] - sin_h[1]);
        let mut dropped_h = h[1] + (sin_p[1] + cos_h[1]);
        dropped_p += edge.cos * w.carry_p - edge.sin * w.carry_h;
        dropped_h += edge.sin * w.carry_p + edge.cos * w.carry_h;
        dropped_p += fine[0] * w.heading_p - fine[1] * w.heading_h;
        dropped_h += fine[1] * w.heading_p + fine[0] * w.heading_h;
        [w.heading_p, w.carry_p] = exact_sum(p[0], dropped_p);
        [w.heading_h, w.carry_h] = exact_sum(h[0], dropped_h);
    } else {
        let p = edge.cos * w.heading_p - edge.sin * w.heading_h;
        let h = edge.sin * w.heading_p + edge.cos * w.heading_h;
        w.heading_p = p;
        w.heading_h = h;
    }
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
        let rate_c = w.heading_h / t.ch;
        let rate_b = (w.heading_p - rate_c * t.cp) / t.ab;
        let rate_a = -rate_b - rate_c;

        let mut distance = w.remaining;
        let mut corner = NONE;
        if rate_c < 0.0 && w.entered_by != 0 {
            let d = w.weight_c / -rate_c;
            if d < distance {
                distance = d;
                corner = 0;
            }
        }
        if rate_a < 0.0 && w.entered_by != 1 {
            let d = w.weight_a / -rate_a;
            if d < distance {
                distance = d;
                corner = 1;
            }
        }
        if rate_b < 0.0 && w.entered_by != 2 {
            let d = w.weight_b / -rate_b;
            if d < distance {
                distance = d;
                corner = 2;
            }
        }
        let a = moved::<CARRIES>(w.weight_a, w.carry_a, rate_a, distance);
        let b = moved::<CARRIES>(w.weight_b, w.carry_b, rate_b, distance);
        let c = moved::<CARRIES>(w.weight_c, w.carry_c, rate_c, distance);
        shorten::<CARRIES>(w, distance);
        if corner == NONE {
            set_weights(w, a, b, c);
            w.remaining = 0.0;
            w.carry_remaining = 0.0;
            w.status = WALK_DONE;
            return;
        }

        let mut along = [b, c, a][corner as usize];
        if CARRIES {
            let end_rate = [rate_b, rate_c, rate_a][corner as usize];
            let start_rate = [rate_a, rate_b, rate_c][corner as usize];
            if start_rate.abs() < end_rate.abs() {
                along = from_other_end::<CARRIES>([a, b, c][corner as usize]);
            }
            if along[0] < 0.0 {
                along = [0.0; 2];
            }
        }
        if along[0] > 1.0 {
            along = [1.0, 0.0];
        }
        let rest = from_other_end::<CARRIES>(along);
        let edge = halfedges[(3 * w.triangle + corner) as usize];
        let at_border = edge.twin == NONE;
        let stops = at_border && !reflects;
        if stops || attempts == 0 {
            set_on_edge(w, corner, rest, along);
            w.status = if stops {
                WALK_BORDER
            } else {
                WALK_OUT_OF_ATTEMPTS
            };
            return;
        }
        attempts -= 1;

        let next_corner = if at_border { corner } else { edge.twin % 3 };
        w.triangle = if at_border { w.triangle } else { edge.twin / 3 };
        let (start, end) = if at_border {
            (rest, along)
        } else {
            (along, rest)
        };
        set_on_edge(w, next_corner, start, end);
        w.entered_by = next_corner;
        if at_border {
            w.heading_h = -w.heading_h;
            w.carry_h = -w.carry_h;
        }
        turn::<CARRIES>(w, edge);
    }
}
