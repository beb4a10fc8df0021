//! Twins of `shaders/sort_count.comp`, `shaders/sort_scan.comp` and `shaders/sort_scatter.comp`: particles in the order in
//! which they lie together in the atlas.

use crate::mesh::strip::StripTriangle;
use crate::sim::field::atlas_position;
use crate::sim::kernels::SortCountParams;
use crate::sim::types::{Flow, Motion, Particle, Window};

/// The bin of a particle: its tile of the atlas; with windows, in its object's part of the bins.
#[must_use]
pub fn bin_of(
    windows: bool,
    params: &SortCountParams,
    strips: &[StripTriangle],
    particle: &Particle,
) -> u32 {
    let StripTriangle { shape, map, .. } = &strips[particle.triangle as usize];
    let [x, y] = atlas_position(map, particle.u, particle.v).map(|x| x as u32);
    let tile = (y >> params.tile_shift) * params.tiles_a_row + (x >> params.tile_shift);
    let object = if windows { shape.object } else { 0 };
    object * params.tile_count + tile
}

/// Twin of `shaders/sort_count.comp`.
pub fn sort_count(
    windows: bool,
    params: &SortCountParams,
    strips: &[StripTriangle],
    particles: &[Particle],
    motions: &[Motion],
    bins: &mut [u32],
) {
    for (particle, motion) in particles.iter().zip(motions) {
        if !(windows && motion.in_flight()) {
            bins[bin_of(windows, params, strips, particle) as usize] += 1;
        }
    }
}

/// Twin of `shaders/sort_scan.comp`.
pub fn sort_scan(bins: &mut [u32]) {
    let mut before = 0;
    for bin in bins {
        (*bin, before) = (before, before + *bin);
    }
}

/// Twin of `shaders/sort_scatter.comp`; the kernel may put the particles of a bin in another order.
pub fn sort_scatter(
    windows: Option<&[Window]>,
    params: &SortCountParams,
    strips: &[StripTriangle],
    flow: &Flow,
    bins: &mut [u32],
    (particles, motions): (&[Particle], &[Motion]),
    (sorted_particles, sorted_motions): (&mut [Particle], &mut [Motion]),
) {
    for (i, (particle, motion)) in particles.iter().zip(motions).enumerate() {
        let mut slot = i as u32;
        if windows.is_none() || !motion.in_flight() {
            let bin = bin_of(windows.is_some(), params, strips, particle);
            slot = bins[bin as usize];
            bins[bin as usize] += 1;
            if let Some(windows) = windows {
                slot = Window::slot(windows[0].start, flow.leaving + slot, params.particle_count);
            }
        }
        sorted_particles[slot as usize] = *particle;
        sorted_motions[slot as usize] = *motion;
    }
}
