//! What the ways read besides the state: a table for walks that turn their heading at edges, and where sensors read.

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec4};
use myxo::mesh::strip::StripTriangle;
use myxo::mesh::surface::{AtlasMap, NONE, Surface, Triangle};
use myxo::sim::field::atlas_position;
use myxo::sim::strip_walk::StripWalk;
use myxo::sim::types::{Motion, Particle, Physarum};
use myxo::sim::walker::WALK_DONE;
use rayon::prelude::*;

use super::ways::State;

/// The triangle behind an edge, for a walk that turns its heading at edges.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TurningEdge {
    /// Its triangle times 4 plus its corner; [`NONE`] at an open border.
    pub twin: u32,
    /// As that of the half-edge.
    pub cos: f32,
    pub sin: f32,
    pub pad: u32,
}

/// As [`StripTriangle`], which it is compared with: the same things side by side, as large and in the same places.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TurningTriangle {
    /// From corner A to B, from B to C, from C to A.
    pub edges: [TurningEdge; 3],
    pub shape: Triangle,
    pub map: AtlasMap,
    pub pad: [f32; 10],
}

const _: () = assert!(size_of::<TurningTriangle>() == size_of::<StripTriangle>());

/// The table of all triangles for walks that turn their heading at edges.
pub fn turning_strips(surface: &Surface, strips: &[StripTriangle]) -> Vec<TurningTriangle> {
    let edge_of = |halfedge: usize| {
        let edge = surface.halfedges[halfedge];
        TurningEdge {
            twin: match edge.twin {
                NONE => NONE,
                twin => 4 * (twin / 3) + twin % 3,
            },
            cos: edge.cos,
            sin: edge.sin,
            pad: 0,
        }
    };
    let all = strips.iter().enumerate();
    all.map(|(triangle, strip)| TurningTriangle {
        edges: [0, 1, 2].map(|corner| edge_of(3 * triangle + corner)),
        shape: strip.shape,
        map: strip.map,
        pad: [0.0; 10],
    })
    .collect()
}

/// The places that the sensors of each particle read, atlas positions: left and middle, then right and nothing. All of them walk, as in a
/// scene with `physarum.sensing = "walk"`. `own` is what all particles do.
pub fn sensor_places(
    strips: &[StripTriangle],
    attempts: u32,
    own: &Physarum,
    state: &State,
) -> Vec<Vec4> {
    let turn = Vec2::new(own.sensor_cos, own.sensor_sin);
    let places_of = |(particle, motion): (&Particle, &Motion)| {
        let heading = Vec2::new(motion.heading_p, motion.heading_h);
        let back = turn * Vec2::new(1.0, -1.0);
        let towards = [turn.rotate(heading), heading, back.rotate(heading)];
        let [left, middle, right] = towards.map(|heading| {
            let mut w = StripWalk {
                triangle: particle.triangle,
                u: particle.u,
                v: particle.v,
                heading: heading.to_array(),
                remaining: own.sensor_offset,
                status: WALK_DONE,
            };
            w.walk(strips, attempts, true);
            Vec2::from_array(atlas_position(&strips[w.triangle as usize].map, w.u, w.v))
        });
        [
            Vec4::new(left.x, left.y, middle.x, middle.y),
            Vec4::new(right.x, right.y, 0.0, 0.0),
        ]
    };
    let all = state.particles.par_iter().zip(&state.motions);
    all.flat_map_iter(places_of).collect()
}
