//! Twins of the kernels, for the tests in `tests/kernels/choices.rs`. Twin of `shaders/include/sensors.glsl`, too.

use glam::Vec4;
use myxo::mesh::strip::StripTriangle;
use myxo::mesh::surface::NONE;
use myxo::sim::field::{atlas_position, texel_at, trail_at};
use myxo::sim::strip_walk::StripWalk;
use myxo::sim::types::{Motion, Particle};
use myxo::sim::walker::WALK_DONE;

use super::tables::TurningTriangle;
use super::ways::kernels::{CountDepositsParams, WalkCorrectedParams, WalkExactlyParams};

/// Twin of `shaders/choices/walk_exactly.comp`.
pub fn walk_exactly(
    params: &WalkExactlyParams,
    strips: &[StripTriangle],
    particles: &mut [Particle],
    motions: &mut [Motion],
) {
    let all = particles.iter_mut().zip(motions);
    for (particle, motion) in all.take(params.particle_count as usize) {
        let mut w = StripWalk {
            triangle: particle.triangle,
            u: particle.u,
            v: particle.v,
            heading: [motion.heading_p, motion.heading_h],
            remaining: motion.pending + params.way,
            status: WALK_DONE,
        };
        w.walk(strips, params.attempts, true);
        (particle.triangle, particle.u, particle.v) = (w.triangle, w.u, w.v);
        [motion.heading_p, motion.heading_h] = w.heading;
        motion.pending = w.pending();
    }
}

/// Twin of `shaders/choices/walk_corrected.comp`.
pub fn walk_corrected(
    params: &WalkCorrectedParams,
    strips: &[TurningTriangle],
    particles: &mut [Particle],
    motions: &mut [Motion],
) {
    let all = particles.iter_mut().zip(motions);
    for (particle, motion) in all.take(params.particle_count as usize) {
        let mut triangle = particle.triangle;
        let (mut b, mut c) = (particle.u, particle.v);
        let (mut p, mut h) = (motion.heading_p, motion.heading_h);
        let mut remaining = motion.pending + params.way;
        let mut attempts = params.attempts;
        loop {
            let strip = &strips[triangle as usize];
            let shape = strip.shape;
            let a = (1.0 - b) - c;
            let way_c = remaining * h / shape.ch;
            let way_b = (remaining * p - way_c * shape.cp) / shape.ab;
            let (to_b, to_c) = (b + way_b, c + way_c);
            let to_a = (1.0 - to_b) - to_c;
            let least = to_a.min(to_b.min(to_c));
            if least >= 0.0 || attempts == 0 {
                (b, c) = (to_b, to_c);
                break;
            }
            // The edge that is left, its weight before, and where along it from and to.
            let (corner, before, from, to) = if to_c == least {
                (0, c, b, to_b)
            } else if to_a == least {
                (1, a, c, to_c)
            } else {
                (2, b, a, to_a)
            };
            let before = before.max(0.0);
            let part = before / (before - least.min(-1e-30));
            let along = (from + part * (to - from)).clamp(0.0, 1.0);
            let rest = 1.0 - along;
            let edge = strip.edges[corner];
            let at_border = edge.twin == NONE;
            let (next, start, end) = if at_border {
                (corner as u32, rest, along)
            } else {
                triangle = edge.twin >> 2;
                (edge.twin & 3, along, rest)
            };
            (b, c) = match next {
                0 => (end, 0.0),
                1 => (start, end),
                _ => (0.0, start),
            };
            let mirrored = if at_border { -h } else { h };
            (p, h) = (
                edge.cos * p - edge.sin * mirrored,
                edge.sin * p + edge.cos * mirrored,
            );
            remaining -= part * remaining;
            attempts -= 1;
        }
        let b = b.clamp(0.0, 1.0);
        (particle.triangle, particle.u, particle.v) = (triangle, b, c.clamp(0.0, 1.0 - b));
        let scale = 1.5 - 0.5 * (p * p + h * h);
        (motion.heading_p, motion.heading_h) = (p * scale, h * scale);
        motion.pending = 0.0;
    }
}

/// Twin of `shaders/choices/count_deposits.comp`, and of `draw_deposits` in the same folder.
pub fn count_deposits(
    params: &CountDepositsParams,
    strips: &[StripTriangle],
    particles: &[Particle],
    deposits: &mut [u32],
) {
    for particle in &particles[..params.particle_count as usize] {
        let map = &strips[particle.triangle as usize].map;
        let position = atlas_position(map, particle.u, particle.v);
        deposits[texel_at(position, params.pitch) as usize] += 1;
    }
}

/// Twin of `shaders/choices/read_texels.comp`.
/// Twin of `shaders/choices/read_block.comp`.
/// Twin of `shaders/choices/read_storage_texels.comp`.
/// Twin of `shaders/choices/read_image.comp`.
/// Twin of `shaders/choices/read_sampler.comp`, whose weights devices round as they like, to 8 bits or so.
pub fn read_sensors(places: &[Vec4], trail: &[f32], pitch: u32) -> Vec<f32> {
    let sensed = |x, y| trail_at(trail, [x, y], pitch);
    let sum = |pair: &[Vec4]| {
        let [first, second] = [pair[0], pair[1]];
        (sensed(first.x, first.y) + sensed(first.z, first.w)) + sensed(second.x, second.y)
    };
    places.chunks_exact(2).map(sum).collect()
}
