//! A straight walk through a strip of triangles, laid out flat as it goes. Twin of `shaders/include/strip.glsl`.

use glam::Vec2;

use super::walker::{WALK_BORDER, WALK_DONE, WALK_OUT_OF_ATTEMPTS};
use crate::mesh::strip::StripTriangle;
use crate::mesh::surface::NONE;
use crate::strict::{cross2, direction2_or, quotient, reciprocal, within};

/// No triangle that is laid out has less area.
const TINY: f32 = 1e-30;

/// A walk: where it is and how it continues.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StripWalk {
    /// The triangle.
    pub triangle: u32,
    /// Weight of its corner B.
    pub u: f32,
    /// Weight of its corner C.
    pub v: f32,
    /// In the triangle's frame, of unit length.
    pub heading: [f32; 2],
    /// World length still to walk.
    pub remaining: f32,
    /// [`WALK_DONE`], [`WALK_BORDER`] or [`WALK_OUT_OF_ATTEMPTS`].
    pub status: u32,
}

impl StripWalk {
    /// Length left of a walk that ran out of edge-crossing attempts; 0 for other walks.
    #[must_use]
    pub fn pending(&self) -> f32 {
        if self.status == WALK_OUT_OF_ATTEMPTS {
            self.remaining
        } else {
            0.0
        }
    }

    /// Walks what remains, over at most `attempts` edges. Reflections at open borders count as crossings.
    pub fn walk(&mut self, strips: &[StripTriangle], mut attempts: u32, reflects: bool) {
        let [p, h] = self.heading;
        let shape = strips[self.triangle as usize].shape;
        let point = Vec2::new(self.u * shape.ab + self.v * shape.cp, self.v * shape.ch);
        // As seen from the start: x along the way, y to the left of it.
        let seen = |x: f32, y: f32| {
            let (x, y) = (x - point.x, y - point.y);
            Vec2::new(x * p + y * h, y * p - x * h)
        };
        let [a, b, c] = [
            seen(0.0, 0.0),
            seen(shape.ab, 0.0),
            seen(shape.cp, shape.ch),
        ];
        // The edge ahead begins on the right and ends on the left.
        let (corner, mut right, mut left, mut third) = if a.y <= 0.0 && b.y > 0.0 {
            (0, a, b, c)
        } else if b.y <= 0.0 && c.y > 0.0 {
            (1, b, c, a)
        } else {
            (2, c, a, b)
        };
        let mut edge = 4 * self.triangle + corner;
        let mut stays = true;
        let mut mirrored = false;
        let (end, status) = loop {
            // The distance of the edge ahead is the quotient of these.
            let way = right.x * left.y - left.x * right.y;
            let width = left.y - right.y;
            let ends = if width > 0.0 {
                way >= self.remaining * width
            } else {
                right.x.min(left.x) >= self.remaining
            };
            if ends {
                break (self.remaining, WALK_DONE);
            }
            let behind = strips[edge as usize / 4].edges[edge as usize % 4];
            let at_border = behind.twin == NONE;
            if attempts == 0 || (at_border && !reflects) {
                let end = within(quotient(way, width), 0.0, self.remaining);
                break if at_border && !reflects {
                    (end, WALK_BORDER)
                } else {
                    (end, WALK_OUT_OF_ATTEMPTS)
                };
            }
            mirrored ^= at_border;
            let entered = if at_border { edge } else { behind.twin };
            let (start, stop) = if mirrored {
                (right, left)
            } else {
                (left, right)
            };
            let way = stop - start;
            let off = if mirrored { -behind.off } else { behind.off };
            let apex = Vec2::new(
                start.x + (behind.along * way.x - off * way.y),
                start.y + (behind.along * way.y + off * way.x),
            );
            let turns_right = apex.y > 0.0;
            third = if turns_right { left } else { right };
            if turns_right {
                left = apex;
            } else {
                right = apex;
            }
            let corner = entered & 3;
            let after = if corner == 2 { 0 } else { corner + 1 };
            let before = if corner == 0 { 2 } else { corner - 1 };
            edge = (entered & !3)
                + if turns_right == mirrored {
                    before
                } else {
                    after
                };
            stays = false;
            attempts -= 1;
        };

        let corner = edge & 3;
        let scale = 1.5 - 0.5 * (p * p + h * h);
        let kept = [p * scale, h * scale];
        // The reciprocal of a triangle's area, which is kept away from zero.
        let by = |area: f32| reciprocal(if area.abs() > TINY { area } else { TINY });
        let (u, v);
        // Within its first triangle, a walk does not depend on the surrounding triangles.
        if stays {
            let by = by(shape.ab * shape.ch);
            let rate_u = (p * shape.ch - h * shape.cp) * by;
            let rate_v = (h * shape.ab) * by;
            u = self.u + rate_u * end;
            v = self.v + rate_v * end;
            self.heading = kept;
        } else {
            let (start, stop) = if mirrored {
                (left, right)
            } else {
                (right, left)
            };
            let (stop, apex) = (stop - start, third - start);
            let place = Vec2::new(end, 0.0) - start;
            let by = by(cross2(stop, apex));
            let of_stop = cross2(place, apex) * by;
            let of_third = cross2(stop, place) * by;
            let of_start = (1.0 - of_stop) - of_third;
            (u, v) = match corner {
                0 => (of_stop, of_third),
                1 => (of_start, of_stop),
                _ => (of_third, of_start),
            };
            let ab = match corner {
                0 => stop,
                1 => -apex,
                _ => apex - stop,
            };
            let turned = Vec2::new(ab.x, if mirrored { ab.y } else { -ab.y });
            // In the strip, a triangle much thinner than the way is long may be a point. Then the heading keeps its direction.
            self.heading = direction2_or(turned, kept.into()).into();
        }
        self.triangle = edge >> 2;
        self.u = within(u, 0.0, 1.0);
        self.v = within(v, 0.0, 1.0 - self.u);
        self.remaining -= end;
        self.status = status;
    }
}
