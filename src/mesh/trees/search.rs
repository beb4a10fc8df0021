//! Searches in the tree of one object, in object space: the nearest face, and the first one that a segment crosses. Twin of
//! `shaders/include/bvh.glsl`.

use glam::Vec3;

use super::nearest::{is_nearer, nearest_on_face};
use super::{Face, GREATEST_DEPTH, Node};
use crate::mesh::surface::NONE;
use crate::strict::{LEAST_SIZE, cross3, dot3, reciprocal, within};

/// A leaf without faces.
const NOTHING: u32 = 15 << 28;

/// More than any square.
pub const FAR: f32 = 3.0e38;

/// A reach to which everything is near.
pub const UNLIMITED: f32 = 1.0e18;

/// Bound on the rounding error of a length in a tree, relative to its largest coordinate.
const ROUNDING: f32 = 1e-6;

/// Bound on the relative rounding error of a length. And of its square.
const LENGTH_ROUNDING: f32 = 1.000_001;
const SQUARE_ROUNDING: f32 = 1.000_003;

/// The square of the distance from a place to a node's box; 0 inside of it.
pub(crate) fn box_square(place: Vec3, node: &Node) -> f32 {
    let way = (node.low - place).max(place - node.high).max(Vec3::ZERO);
    dot3(way, way)
}

/// Bound on the rounding error of a length in a tree.
#[must_use]
pub fn slack_of(root: &Node) -> f32 {
    ROUNDING * root.low.abs().max(root.high.abs()).max_element()
}

/// The square of a distance, raised by a bound on rounding.
pub(super) fn limit_of(distance: f32, slack: f32) -> f32 {
    let most = distance * LENGTH_ROUNDING + slack;
    (most * most).min(FAR)
}

/// As [`limit_of`], from the squared distance. Instead of the root it takes a number that is up to 7 % larger.
fn limit_of_square(square: f32, slack: f32) -> f32 {
    let above = f32::from_bits(0x1fc0_0000 + (square.to_bits() >> 1));
    let limit = (square * SQUARE_ROUNDING + (2.0 * slack) * above) + slack * slack;
    limit.min(FAR)
}

/// Does a place lie in the box round an object?
#[must_use]
pub fn is_in_box(nodes: &[Node], root: u32, place: Vec3) -> bool {
    let node = &nodes[root as usize];
    place.cmpge(node.low).all() && place.cmple(node.high).all()
}

/// The slot of the face nearest to a place, [`NONE`] if none is nearer than reach (or little more).
#[must_use]
pub fn nearest_on(nodes: &[Node], faces: &[Face], root: u32, place: Vec3, reach: f32) -> u32 {
    let mut stack = [(0, 0.0); GREATEST_DEPTH];
    let mut top = 0;

    let node = &nodes[root as usize];
    let slack = slack_of(node);
    let mut limit = limit_of(reach, slack);
    let mut best_square = FAR;
    let mut best_triangle = NONE;
    let mut best_slot = NONE;
    let mut link = node.link;
    let mut searches = box_square(place, node) <= limit;
    while searches {
        while link < Node::LEAF {
            let a = &nodes[link as usize];
            let b = &nodes[link as usize + 1];
            let square_a = box_square(place, a);
            let square_b = box_square(place, b);
            let a_first = square_a <= square_b;
            let far_square = if a_first { square_b } else { square_a };
            if far_square <= limit {
                stack[top] = (if a_first { b.link } else { a.link }, far_square);
                top += 1;
            }
            link = if square_a.min(square_b) > limit {
                NOTHING
            } else if a_first {
                a.link
            } else {
                b.link
            };
        }
        let first = link % Node::LEAF;
        let end = if link == NOTHING {
            0
        } else {
            first + link / Node::LEAF
        };
        for slot in first..end {
            let face = &faces[slot as usize];
            let square = nearest_on_face(face, place).square;
            if is_nearer(square, face.triangle, best_square, best_triangle) {
                best_square = square;
                best_triangle = face.triangle;
                best_slot = slot;
            }
        }
        limit = limit.min(limit_of_square(best_square, slack));
        searches = false;
        while top > 0 && !searches {
            top -= 1;
            link = stack[top].0;
            searches = stack[top].1 <= limit;
        }
    }
    best_slot
}

/// The first crossing of a segment with a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The face, [`NONE`] if nowhere.
    pub slot: u32,
    /// How much of the way from the segment's start.
    pub t: f32,
    /// Weight of corner B.
    pub u: f32,
    /// Weight of corner C.
    pub v: f32,
}

/// How far outside of a triangle, in weights, a crossing still counts.
const CROSSING_MARGIN: f32 = 1e-6;

fn entry_of(from: Vec3, inverse: Vec3, low: Vec3, high: Vec3) -> f32 {
    let to_low = (low - from) * inverse;
    let to_high = (high - from) * inverse;
    let enter = to_low.min(to_high).max_element().max(0.0);
    let leave = to_low.max(to_high).min_element().min(1.0);
    if enter <= leave { enter } else { FAR }
}

/// The first face that the segment from a place to another crosses, both included; the lowest triangle of several at
/// once.
#[must_use]
pub fn first_crossing(nodes: &[Node], faces: &[Face], root: u32, from: Vec3, to: Vec3) -> Crossing {
    let mut stack = [(0, 0.0); GREATEST_DEPTH];
    let mut top = 0;

    let mut best = Crossing {
        slot: NONE,
        t: FAR,
        u: 0.0,
        v: 0.0,
    };
    let mut best_triangle = NONE;

    let way = to - from;
    let inverse = Vec3::from(way.to_array().map(reciprocal));
    let node = &nodes[root as usize];
    let slack = Vec3::splat(slack_of(node));
    let entry = |node: &Node| entry_of(from, inverse, node.low - slack, node.high + slack);
    let mut link = node.link;
    let mut searches = entry(node) < FAR;
    while searches {
        while link < Node::LEAF {
            let a = &nodes[link as usize];
            let b = &nodes[link as usize + 1];
            let entry_a = entry(a);
            let entry_b = entry(b);
            let a_first = entry_a <= entry_b;
            let far_entry = if a_first { entry_b } else { entry_a };
            if far_entry < FAR && far_entry <= best.t {
                stack[top] = (if a_first { b.link } else { a.link }, far_entry);
                top += 1;
            }
            let near_entry = entry_a.min(entry_b);
            link = if near_entry == FAR || near_entry > best.t {
                NOTHING
            } else if a_first {
                a.link
            } else {
                b.link
            };
        }
        let first = link % Node::LEAF;
        let end = if link == NOTHING {
            0
        } else {
            first + link / Node::LEAF
        };
        for slot in first..end {
            let face = &faces[slot as usize];
            let start = from - face.a;
            let across = cross3(way, face.ac);
            let volume = dot3(face.ab, across);
            let along = cross3(start, face.ab);
            let by = reciprocal(volume);
            let u = dot3(start, across) * by;
            let v = dot3(way, along) * by;
            let w = (1.0 - u) - v;
            let from_plane = dot3(face.ac, along);
            let passed = if volume < 0.0 {
                -from_plane
            } else {
                from_plane
            };
            let size = volume.abs();
            let t = if passed >= size {
                1.0
            } else {
                within(passed * by.abs(), 0.0, 1.0)
            };
            let crosses = u >= -CROSSING_MARGIN
                && v >= -CROSSING_MARGIN
                && w >= -CROSSING_MARGIN
                && passed >= 0.0
                && passed <= size
                && size >= LEAST_SIZE;
            if crosses && is_nearer(t, face.triangle, best.t, best_triangle) {
                let u = within(u, 0.0, 1.0);
                best = Crossing {
                    slot,
                    t,
                    u,
                    v: within(v, 0.0, 1.0 - u),
                };
                best_triangle = face.triangle;
            }
        }
        searches = false;
        while top > 0 && !searches {
            top -= 1;
            link = stack[top].0;
            searches = stack[top].1 <= best.t;
        }
    }
    best
}
