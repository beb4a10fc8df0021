//! The kernels that sort a segment of the particles: their parameters and bindings. Twins of `shaders/sort_count.comp`,
//! `shaders/sort_scan.comp` and `shaders/sort_scatter.comp`: the order keeps particles that are near each other in the atlas together.

use crate::mesh::strip::StripTriangle;
use crate::sim::arrays::Arrays;
use crate::sim::kernels::{
    SortCount, SortCountArgs, SortCountParams, SortScan, SortScanArgs, SortScanParams, SortScatter,
    SortScatterArgs, SortScatterParams,
};
use crate::sim::plan::Plan;
use crate::sim::sorting::{Bins, Segment};
use crate::sim::state::State;
use crate::sim::types::{Motion, Particle, Window};
use crate::sim::work::{Call, StepKernel};

impl Plan<'_> {
    /// Counts a segment's particles in bins, and copies them aside.
    #[must_use]
    pub fn sort_count(&self, segment: Segment) -> Call<SortCount> {
        Call {
            on: (),
            constants: (),
            params: SortCountParams {
                particle_count: self.particle_count(),
                first: segment.first,
                count: segment.count,
                tile_shift: self.setup.bins.tile_shift,
            },
        }
    }

    /// Adds the counts up.
    #[must_use]
    pub fn sort_scan(&self) -> Call<SortScan> {
        Call {
            on: (),
            constants: (),
            params: SortScanParams {
                bin_count: self.setup.bins.count,
            },
        }
    }

    /// Puts a segment's particles back in order.
    #[must_use]
    pub fn sort_scatter(&self, segment: Segment) -> Call<SortScatter> {
        Call {
            on: (),
            constants: (),
            params: SortScatterParams {
                particle_count: self.particle_count(),
                first: segment.first,
                count: segment.count,
                tile_shift: self.setup.bins.tile_shift,
            },
        }
    }
}

impl StepKernel for SortCount {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> SortCountArgs<'s> {
        SortCountArgs {
            particles: &s.particles.texels,
            motions: &s.motions.texels,
            strips: &s.surface.strips,
            bins: &s.sorting.bins,
            segment_particles: &s.sorting.particles.texels,
            segment_motions: &s.sorting.motions.texels,
            windows: &s.transfers.windows,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        sort_count(
            &call.params,
            &a.setup.strips,
            &mut a.bins,
            &a.transfers.windows,
            (&a.particles, &a.motions),
            (&mut a.segment_particles, &mut a.segment_motions),
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
            segment_particles: &s.sorting.particles.texels,
            segment_motions: &s.sorting.motions.texels,
            strips: &s.surface.strips,
            bins: &s.sorting.bins,
            particles: &s.particles.texels,
            motions: &s.motions.texels,
            windows: &s.transfers.windows,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        sort_scatter(
            &call.params,
            &a.setup.strips,
            &mut a.bins,
            &a.transfers.windows,
            (&a.segment_particles, &a.segment_motions),
            (&mut a.particles, &mut a.motions),
        );
    }
}

/// The slot at this offset from the ring's beginning. Without windows the ring begins at slot 0.
fn slot_of(windows: &[Window], i: u32, ring: u32) -> usize {
    let start = windows.first().map_or(0, |window| window.start);
    Window::slot(start, i, ring) as usize
}

/// Twin of `shaders/sort_count.comp`.
pub fn sort_count(
    params: &SortCountParams,
    strips: &[StripTriangle],
    bins: &mut [u32],
    windows: &[Window],
    (particles, motions): (&[Particle], &[Motion]),
    (segment_particles, segment_motions): (&mut [Particle], &mut [Motion]),
) {
    for i in 0..params.count {
        let slot = slot_of(windows, params.first + i, params.particle_count);
        segment_particles[i as usize] = particles[slot];
        segment_motions[i as usize] = motions[slot];
        bins[Bins::of(params.tile_shift, strips, &particles[slot]) as usize] += 1;
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
    params: &SortScatterParams,
    strips: &[StripTriangle],
    bins: &mut [u32],
    windows: &[Window],
    (segment_particles, segment_motions): (&[Particle], &[Motion]),
    (particles, motions): (&mut [Particle], &mut [Motion]),
) {
    let segment = segment_particles.iter().zip(segment_motions);
    for (particle, motion) in segment.take(params.count as usize) {
        let bin = Bins::of(params.tile_shift, strips, particle) as usize;
        let place = params.first + bins[bin];
        bins[bin] += 1;
        let slot = slot_of(windows, place, params.particle_count);
        particles[slot] = *particle;
        motions[slot] = *motion;
    }
}
