//! Twin of `shaders/include/walk.glsl`: the straightest path on the surface, in the tangent frame, in float32.

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

/// Walks what remains, over at most `attempts` edges. Reflections at open borders count as crossings.
pub fn walk(
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
        let a = (w.weight_a + rate_a * distance).max(0.0);
        let b = (w.weight_b + rate_b * distance).max(0.0);
        let c = (w.weight_c + rate_c * distance).max(0.0);
        w.remaining -= distance;
        if corner == NONE {
            (w.weight_a, w.weight_b, w.weight_c) = (a, b, c);
            w.remaining = 0.0;
            w.status = WALK_DONE;
            return;
        }

        let along = [b, c, a][corner as usize].min(1.0);
        let edge = halfedges[(3 * w.triangle + corner) as usize];
        let at_border = edge.twin == NONE;
        let stops = at_border && !reflects;
        if stops || attempts == 0 {
            let start = 1.0 - along;
            [w.weight_a, w.weight_b, w.weight_c] = on_edge(corner, start, along);
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
            (1.0 - along, along)
        } else {
            (along, 1.0 - along)
        };
        [w.weight_a, w.weight_b, w.weight_c] = on_edge(next_corner, start, end);
        w.entered_by = next_corner;
        let heading_h = if at_border { -w.heading_h } else { w.heading_h };
        let p = edge.cos * w.heading_p - edge.sin * heading_h;
        let h = edge.sin * w.heading_p + edge.cos * heading_h;
        w.heading_p = p;
        w.heading_h = h;
    }
}

/// The three weights of a point on the half-edge of `corner`.
fn on_edge(corner: u32, start: f32, end: f32) -> [f32; 3] {
    match corner {
        0 => [start, end, 0.0],
        1 => [0.0, start, end],
        _ => [end, 0.0, start],
    }
}
