//! Ends of sensors straight ahead in the atlas. Twin of the part of `shaders/include/sensing.glsl` that does not walk.

use super::field::{atlas_position, texel_at};
use super::kernels::AdvanceParams;
use super::surroundings::is_clear;
use super::types::Particle;
use crate::mesh::strip::StripTriangle;
use crate::strict::{dot2, within};

/// Ends of a particle's three sensors straight ahead, in texels, `offset` away along three headings, and whether all three paths are
/// clear.
#[must_use]
pub fn straight_ahead(
    params: &AdvanceParams,
    strips: &[StripTriangle],
    surroundings: &[u16],
    offset: f32,
    particle: &Particle,
    towards: [[f32; 2]; 3],
) -> ([[f32; 2]; 3], bool) {
    let StripTriangle {
        map,
        texels: [p, h],
        ..
    } = &strips[particle.triangle as usize];
    let from = atlas_position(map, particle.u, particle.v);
    let ways = towards.map(|[x, y]| offset * (x * *p + y * *h));
    let around = |place| surroundings[texel_at(place, params.pitch) as usize];
    let here = around(from);
    let places = ways.map(|way| [from[0] + way.x, from[1] + way.y]);
    let all_clear = ways.iter().zip(places).all(|(way, to)| {
        let there = around(to.map(|x| within(x, 0.0, params.last_texel)));
        is_clear(dot2(*way, *way), params.outlook_unit, here, there)
    });
    (places, all_clear)
}
