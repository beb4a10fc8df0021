//! Alternative kernels, which do parts of a step in another way, for `myxo bench choices`.
//! No simulation runs them. Their twins are in `twin/choices.rs`.

/// Their typed handles, as the build generates them from `shaders/choices/*.comp`.
#[allow(
    clippy::identity_op,
    clippy::derivable_impls,
    reason = "generated: offsets may be 0, and defaults those of the type"
)]
pub mod kernels {
    include!(concat!(env!("OUT_DIR"), "/choices.rs"));
}

/// Generated handles of the draws.
#[allow(
    clippy::identity_op,
    clippy::derivable_impls,
    reason = "generated: offsets may be 0, and defaults those of the type"
)]
pub mod draws {
    include!(concat!(env!("OUT_DIR"), "/choices_draws.rs"));
}

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec4};
use rayon::prelude::*;

use super::field::atlas_position;
use super::kernels::AdvanceParams;
use super::sensors::straight_ahead;
use super::setup::Setup;
use super::strip_walk::StripWalk;
use super::types::{Motion, Particle, Physarum};
use super::walker::WALK_DONE;
use crate::mesh::strip::StripTriangle;
use crate::mesh::surface::{AtlasMap, NONE, Surface, Triangle};

/// The triangle behind an edge, for a walk that turns its heading at edges.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TurningEdge {
    /// Its triangle times 4 plus its corner; [`NONE`] at an open border.
    pub twin: u32,
    /// As [`HalfEdge::cos`](crate::mesh::surface::HalfEdge::cos).
    pub cos: f32,
    /// As [`HalfEdge::sin`](crate::mesh::surface::HalfEdge::sin).
    pub sin: f32,
    /// Always 0.
    pub pad: u32,
}

/// As [`StripTriangle`], which it is compared with: the same things side by side, as large and in the same places.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TurningTriangle {
    /// From corner A to B, from B to C, from C to A.
    pub edges: [TurningEdge; 3],
    /// Its own shape.
    pub shape: Triangle,
    /// Its place in the atlas.
    pub map: AtlasMap,
    /// Always 0.
    pub pad: [f32; 2],
}

const _: () = assert!(size_of::<TurningTriangle>() == size_of::<StripTriangle>());

/// The table of all triangles for walks that turn their heading at edges.
#[must_use]
pub fn turning_strips(surface: &Surface, strips: &[StripTriangle]) -> Vec<TurningTriangle> {
    let all = strips.iter().enumerate();
    all.map(|(triangle, strip)| TurningTriangle {
        edges: [0, 1, 2].map(|corner| {
            let edge = surface.halfedges[3 * triangle + corner];
            TurningEdge {
                twin: match edge.twin {
                    NONE => NONE,
                    twin => 4 * (twin / 3) + twin % 3,
                },
                cos: edge.cos,
                sin: edge.sin,
                pad: 0,
            }
        }),
        shape: strip.shape,
        map: strip.map,
        pad: [0.0; 2],
    })
    .collect()
}

/// Atlas positions at which the sensors of each particle read: left and middle, then right and an unused one. As in a step, sensors
/// read straight ahead in the atlas where the path is clear, and walk elsewhere. `own` are the parameters of all particles.
#[must_use]
pub fn sensor_places(
    setup: &Setup,
    params: &AdvanceParams,
    own: &Physarum,
    particles: &[Particle],
    motions: &[Motion],
) -> Vec<Vec4> {
    let (strips, surroundings) = (&setup.strips, &setup.surroundings);
    let offset = own.sensor_offset;
    let turn = Vec2::new(own.sensor_cos, own.sensor_sin);
    let places_of = |(particle, motion): (&Particle, &Motion)| {
        let heading = Vec2::new(motion.heading_p, motion.heading_h);
        let towards = [
            turn.rotate(heading),
            heading,
            (turn * Vec2::new(1.0, -1.0)).rotate(heading),
        ];
        let towards = towards.map(|heading| heading.to_array());
        let walked = |heading| {
            let mut w = StripWalk {
                triangle: particle.triangle,
                u: particle.u,
                v: particle.v,
                heading,
                remaining: offset,
                status: WALK_DONE,
            };
            w.walk(strips, params.attempts, true);
            atlas_position(&strips[w.triangle as usize].map, w.u, w.v)
        };
        let (ahead, is_clear) =
            straight_ahead(params, strips, surroundings, offset, particle, towards);
        let places = if is_clear { ahead } else { towards.map(walked) };
        let [left, middle, right] = places.map(Vec2::from_array);
        [
            Vec4::new(left.x, left.y, middle.x, middle.y),
            Vec4::new(right.x, right.y, 0.0, 0.0),
        ]
    };
    particles
        .par_iter()
        .zip(motions)
        .flat_map_iter(places_of)
        .collect()
}
