//! Twin of `shaders/teleport.comp`.

use glam::UVec2;

use crate::mesh::surface::Triangle;
use crate::rng::{Purpose, random, unit};
use crate::sim::kernels::TeleportParams;
use crate::sim::types::{Motion, Particle};
use crate::strict::turn_of;

/// Moves some particles to places that a brush has touched, each on its own object.
pub fn teleport(
    params: &TeleportParams,
    places: &[Particle],
    place_ranges: &[UVec2],
    triangles: &[Triangle],
    particles: &mut [Particle],
    motions: &mut [Motion],
) {
    for i in 0..params.particle_count as usize {
        let particle = particles[i];
        let range = place_ranges[triangles[particle.triangle as usize].object as usize];
        let words = random(params.seed, particle.id, params.dab, Purpose::Paint);
        if range.y == 0 || unit(words[0]) >= params.share {
            continue;
        }
        let place = places[(range.x + words[1] % range.y) as usize];
        particles[i] = Particle {
            id: particle.id,
            ..place
        };
        let heading = turn_of(words[2]);
        motions[i] = Motion {
            heading_p: heading.x,
            heading_h: heading.y,
            pending: 0.0,
            flags: motions[i].flags,
        };
    }
}
