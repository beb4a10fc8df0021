//! Which particles a picture draws, and in which order: by their ids, so that pictures do not depend on where particles lie
//! in memory, and a picture of some of them shows the same ones in each step.
//!
//! This file has the CPU twin of its kernel; [`super::renderer`] records it.

use crate::sim::types::Particle;

/// From one drawn id to the next, such that no more than `most` of `count` particles are drawn; at least 1.
#[must_use]
pub fn stride(count: u32, most: u32) -> u32 {
    count.div_ceil(most.max(1)).max(1)
}

/// How many particles of `count` have an id that is a multiple of `stride`.
#[must_use]
pub fn drawn(count: u32, stride: u32) -> u32 {
    count.div_ceil(stride)
}

/// Twin of `shaders/draw_order.comp`.
pub fn draw_order(particle_count: u32, stride: u32, particles: &[Particle], order: &mut [u32]) {
    for slot in 0..particle_count {
        let id = particles[slot as usize].id;
        if id.is_multiple_of(stride) {
            order[(id / stride) as usize] = slot;
        }
    }
}
