//! The kernels that sort particles: what they take, read and write. Twins of `shaders/sort_count.comp`,
//! `shaders/sort_scan.comp` and `shaders/sort_scatter.comp`: particles in the order in which they lie together in the atlas.

use crate::mesh::strip::StripTriangle;
use crate::sim::arrays::Arrays;
use crate::sim::field::atlas_position;
use crate::sim::kernels::SortCountParams;
use crate::sim::kernels::{
    SortCount, SortCountArgs, SortCountConstants, SortScan, SortScanArgs, SortScanParams,
    SortScatter, SortScatterArgs, SortScatterConstants, SortScatterParams,
};
use crate::sim::plan::Plan;
use crate::sim::sorting::Tiles;
use crate::sim::state::State;
use crate::sim::types::{Motion, Particle, Window};
use crate::sim::work::{Call, StepKernel};

impl Plan<'_> {
    /// Tiles of the atlas, each with a bin for every window; without windows objects need no order of their own.
    fn tiles(&self) -> (Tiles, u32) {
        let windows = if self.strategy.has_windows() {
            self.setup.poses.len()
        } else {
            1
        };
        (Tiles::of(&self.setup.atlas, windows), windows as u32)
    }

    /// Counts particles in tiles.
    #[must_use]
    pub fn sort_count(&self) -> Call<SortCount> {
        let (tiles, _) = self.tiles();
        Call {
            on: (),
            constants: SortCountConstants {
                windows: self.strategy.has_windows(),
            },
            params: SortCountParams {
                particle_count: self.particle_count(),
                tile_shift: tiles.shift,
                tiles_a_row: tiles.a_row,
                tile_count: tiles.count,
            },
        }
    }

    /// Adds the counts up.
    #[must_use]
    pub fn sort_scan(&self) -> Call<SortScan> {
        let (tiles, windows) = self.tiles();
        Call {
            on: (),
            constants: (),
            params: SortScanParams {
                bin_count: tiles.count * windows,
            },
        }
    }

    /// Puts particles in order.
    #[must_use]
    pub fn sort_scatter(&self) -> Call<SortScatter> {
        let count = self.sort_count().params;
        Call {
            on: (),
            constants: SortScatterConstants {
                windows: self.strategy.has_windows(),
            },
            params: SortScatterParams {
                particle_count: count.particle_count,
                tile_shift: count.tile_shift,
                tiles_a_row: count.tiles_a_row,
                tile_count: count.tile_count,
            },
        }
    }
}

impl StepKernel for SortCount {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> SortCountArgs<'s> {
        SortCountArgs {
            particles: &s.particles.texels,
            strips: &s.surface.strips,
            bins: &s.sorting.bins,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        sort_count(
            call.constants.windows,
            &call.params,
            &a.setup.strips,
            &a.particles,
            &mut a.bins,
        );
    }
}

impl StepKernel for SortScan {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> SortScanArgs<'s> {
        SortScanArgs {
            bins: &s.sorting.bins,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        sort_scan(&mut a.bins[..call.params.bin_count as usize]);
    }
}

impl StepKernel for SortScatter {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> SortScatterArgs<'s> {
        SortScatterArgs {
            particles: &s.particles.texels,
            motions: &s.motions.texels,
            strips: &s.surface.strips,
            bins: &s.sorting.bins,
            sorted_particles: &s.sorting.particles.texels,
            sorted_motions: &s.sorting.motions.texels,
            windows: &s.transfers.windows,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let SortScatterParams {
            particle_count,
            tile_shift,
            tiles_a_row,
            tile_count,
        } = call.params;
        let windows = call.constants.windows.then_some(&a.transfers.windows[..]);
        sort_scatter(
            windows,
            &SortCountParams {
                particle_count,
                tile_shift,
                tiles_a_row,
                tile_count,
            },
            &a.setup.strips,
            &mut a.bins,
            (&a.particles, &a.motions),
            (&mut a.sorted_particles, &mut a.sorted_motions),
        );
    }
}

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
    bins: &mut [u32],
) {
    for particle in particles {
        bins[bin_of(windows, params, strips, particle) as usize] += 1;
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
    bins: &mut [u32],
    (particles, motions): (&[Particle], &[Motion]),
    (sorted_particles, sorted_motions): (&mut [Particle], &mut [Motion]),
) {
    for (particle, motion) in particles.iter().zip(motions) {
        let bin = bin_of(windows.is_some(), params, strips, particle) as usize;
        let mut slot = bins[bin];
        bins[bin] += 1;
        if let Some(windows) = windows {
            slot = Window::slot(windows[0].start, slot, params.particle_count);
        }
        sorted_particles[slot as usize] = *particle;
        sorted_motions[slot as usize] = *motion;
    }
}
