//! Straight walks on the surface in double precision: straight in each triangle, unfolded across each edge.
//!
//! This is the reference for the kernels, and seams are computed with it. Kernels walk in float32, in
//! two forms: particles and sensors by `shaders/include/strip.glsl` (twin `sim::strip_walk`), transfers, folding
//! and queries by `shaders/include/walk.glsl` (twin `sim::walker`).

use glam::{DVec2, DVec3};

use super::surface::{NONE, Surface};

/// A place on the surface: a triangle and its barycentric weights `u` (corner B) and `v` (corner C).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Global triangle id.
    pub triangle: u32,
    /// Weight of corner B.
    pub u: f64,
    /// Weight of corner C.
    pub v: f64,
}

/// A requested walk: its start, heading and length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WalkQuery {
    /// The start.
    pub start: SurfacePoint,
    /// Unit heading in the tangent frame of the start's triangle.
    pub heading: DVec2,
    /// Length to walk, world units; not negative.
    pub length: f64,
}

/// Behaviour of a walk at an open border.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BorderRule {
    /// The heading is mirrored and the walk continues.
    Reflect,
    /// The walk ends at the border.
    Stop,
}

/// Why a walk ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WalkStatus {
    /// The whole length was walked.
    Done,
    /// It stopped at an open border.
    Border,
    /// The crossings allowed were used up.
    OutOfAttempts,
}

/// The end of a walk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WalkEnd {
    /// The end point.
    pub point: SurfacePoint,
    /// Unit heading in the tangent frame of the end point's triangle.
    pub heading: DVec2,
    /// Length walked, world units.
    pub travelled: f64,
    /// Why it ended.
    pub status: WalkStatus,
}

/// A triangle's shape in its tangent frame, in double precision: A is the origin, B is `(ab, 0)`, C is `(cp, ch)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// `|B - A|`.
    pub ab: f64,
    /// `p` of C.
    pub cp: f64,
    /// `h` of C.
    pub ch: f64,
    /// Unit vector along `B - A`, object space.
    pub p: DVec3,
    /// Unit vector perpendicular to `p` in the triangle's plane, towards C, object space.
    pub h: DVec3,
}

impl Frame {
    /// The frame of one triangle of a surface.
    ///
    /// If rounding the scaled corners to float32 left no area, the shape is the one that kernels walk on, and the
    /// triangle's plane is some plane through its longest edge.
    #[must_use]
    pub fn of(surface: &Surface, triangle: u32) -> Self {
        let corners =
            surface.corners[triangle as usize].map(|i| surface.positions[i as usize].as_dvec3());
        let [a, b, c] = corners;
        let frame = Self::from_corners(a, b, c);
        if frame.has_area() {
            return frame;
        }
        let shape = surface.triangles[triangle as usize];
        let mut frame = Self {
            ab: f64::from(shape.ab),
            cp: f64::from(shape.cp),
            ch: f64::from(shape.ch),
            ..frame
        };
        let length = |k: usize| frame.edge(k).length_squared();
        let longest = (0..3).max_by(|&j, &k| length(j).total_cmp(&length(k)));
        let longest = longest.expect("a triangle has three edges");
        let along = (corners[(longest + 1) % 3] - corners[longest]).normalize_or(DVec3::X);
        let across = along.any_orthonormal_vector();
        let edge = frame.edge(longest).normalize();
        frame.p = edge.x * along - edge.y * across;
        frame.h = edge.y * along + edge.x * across;
        frame
    }

    /// The frame of the triangle A, B, C. Without area it has some direction for `p` and `h`, and never NaN.
    #[must_use]
    pub fn from_corners(a: DVec3, b: DVec3, c: DVec3) -> Self {
        let ab = (b - a).length();
        let p = (b - a).try_normalize().unwrap_or(DVec3::X);
        let cp = (c - a).dot(p);
        let across = (c - a) - cp * p;
        let ch = across.length();
        let h = across
            .try_normalize()
            .unwrap_or_else(|| p.any_orthonormal_vector());
        Self { ab, cp, ch, p, h }
    }

    /// Whether both extents are more than nothing in float32 too, so that a walk can divide by them.
    #[must_use]
    pub fn has_area(&self) -> bool {
        (self.ab as f32).is_normal() && (self.ch as f32).is_normal()
    }

    /// The three corners, in the frame.
    #[must_use]
    pub fn corners(&self) -> [DVec2; 3] {
        [
            DVec2::ZERO,
            DVec2::new(self.ab, 0.0),
            DVec2::new(self.cp, self.ch),
        ]
    }

    /// The vector along the half-edge that starts at a corner, in the frame.
    #[must_use]
    pub fn edge(&self, corner: usize) -> DVec2 {
        let corners = self.corners();
        corners[(corner + 1) % 3] - corners[corner]
    }

    /// The change of `(u, v)` for a step in the frame.
    #[must_use]
    pub fn uv_rate(&self, step: DVec2) -> DVec2 {
        let v = step.y / self.ch;
        DVec2::new((step.x - v * self.cp) / self.ab, v)
    }

    /// The point in the frame that has the weights `u` and `v`.
    #[must_use]
    pub fn position(&self, u: f64, v: f64) -> DVec2 {
        DVec2::new(u * self.ab + v * self.cp, v * self.ch)
    }
}

/// The heading in the frame of the neighbour, for a half-edge that is crossed.
#[must_use]
pub fn rotate_across(edge: DVec2, twin_edge: DVec2, heading: DVec2) -> DVec2 {
    let along = -twin_edge;
    let scale = 1.0 / (edge.length() * along.length());
    let rotation = DVec2::new(edge.dot(along), edge.perp_dot(along)) * scale;
    rotation.rotate(heading)
}

/// Walks `length` (world units) from a point in the direction of a unit heading.
///
/// `max_crossings` limits the edges crossed (reflections count too); `None` sets no limit but the mesh's own size.
#[must_use]
pub fn walk(
    surface: &Surface,
    start: SurfacePoint,
    heading: DVec2,
    length: f64,
    max_crossings: Option<u32>,
    border: BorderRule,
) -> WalkEnd {
    let SurfacePoint { mut triangle, u, v } = start;
    let mut weights = [1.0 - u - v, u, v];
    let mut heading = heading;
    let mut remaining = length;
    let mut entered_by = None;
    let mut crossings = 0;
    let end = |triangle, weights: [f64; 3], heading: DVec2, remaining: f64, status| WalkEnd {
        point: SurfacePoint {
            triangle,
            u: weights[1],
            v: weights[2],
        },
        heading: heading.normalize(),
        travelled: length - remaining,
        status,
    };
    loop {
        let frame = Frame::of(surface, triangle);
        let rate = frame.uv_rate(heading);
        let rates = [-rate.x - rate.y, rate.x, rate.y];
        // The edge opposite a corner is reached when that corner's weight is zero. The edge that the walk came in by
        // is left out: rounding must not send it straight back.
        let mut exit = None;
        let mut distance = f64::INFINITY;
        for opposite in 0..3 {
            let corner = (opposite + 1) % 3;
            if rates[opposite] < 0.0 && entered_by != Some(corner) {
                let t = (weights[opposite] / -rates[opposite]).max(0.0);
                if t < distance {
                    distance = t;
                    exit = Some(corner);
                }
            }
        }
        let Some(corner) = exit.filter(|_| distance < remaining) else {
            for k in 0..3 {
                weights[k] += rates[k] * remaining;
            }
            return end(triangle, clamped(weights), heading, 0.0, WalkStatus::Done);
        };
        remaining -= distance;
        let along =
            (weights[(corner + 1) % 3] + rates[(corner + 1) % 3] * distance).clamp(0.0, 1.0);
        let on_edge = |corner: usize, along: f64| {
            let mut weights = [0.0; 3];
            weights[corner] = 1.0 - along;
            weights[(corner + 1) % 3] = along;
            weights
        };
        let twin = surface.halfedges[3 * triangle as usize + corner].twin;
        let at_border = twin == NONE;
        if at_border && border == BorderRule::Stop {
            return end(
                triangle,
                on_edge(corner, along),
                heading,
                remaining,
                WalkStatus::Border,
            );
        }
        if max_crossings.is_some_and(|limit| crossings >= limit) {
            return end(
                triangle,
                on_edge(corner, along),
                heading,
                remaining,
                WalkStatus::OutOfAttempts,
            );
        }
        crossings += 1;
        if at_border {
            let normal = frame.edge(corner).perp().normalize();
            heading -= 2.0 * heading.dot(normal) * normal;
            weights = on_edge(corner, along);
            entered_by = Some(corner);
        } else {
            let edge = frame.edge(corner);
            let twin_corner = (twin % 3) as usize;
            triangle = twin / 3;
            heading = rotate_across(
                edge,
                Frame::of(surface, triangle).edge(twin_corner),
                heading,
            );
            weights = on_edge(twin_corner, 1.0 - along);
            entered_by = Some(twin_corner);
        }
    }
}

fn clamped(weights: [f64; 3]) -> [f64; 3] {
    let positive = weights.map(|w| w.max(0.0));
    let sum: f64 = positive.iter().sum();
    positive.map(|w| w / sum)
}
