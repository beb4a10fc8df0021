//! The kernels that sort a segment of the particles: their parameters and bindings. Twins of `shaders/sort_count.comp`,
//! `shaders/sort_sums.comp`, `shaders/sort_scan.comp` and `shaders/sort_scatter.comp`: the order keeps particles that are near each other
//! in the atlas together.

use crate::gpu::{Kernel as _, Threads};
use crate::mesh::strip::StripTriangle;
use crate::sim::arrays::Arrays;
use crate::sim::kernels::{
    SortCount, SortCountArgs, SortCountParams, SortScan, SortScanArgs, SortScanParams, SortScatter,
    SortScatterArgs, SortScatterParams, SortSums, SortSumsArgs, SortSumsParams,
};
use crate::sim::plan::Plan;
use crate::sim::sorting::{Bins, STRETCH, Segment};
use crate::sim::state::State;
use crate::sim::types::{Motion, Particle, Window};
use crate::sim::work::{Call, StepKernel};

/// Parts of bins that an invocation of `sort_sums` and of `sort_scan` takes.
pub const RUN: u32 = 16;

// A group takes a stretch.
const _: () = assert!(STRETCH == RUN * SortSums::GROUP_SIZE);
const _: () = assert!(STRETCH == RUN * SortScan::GROUP_SIZE);

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
                part_bits: self.means.part_bits,
            },
        }
    }

    /// Adds the counts of each stretch up.
    #[must_use]
    pub fn sort_sums(&self) -> Call<SortSums> {
        Call {
            on: (),
            constants: (),
            params: SortSumsParams {
                bin_count: self.parts(),
            },
        }
    }

    /// Adds all counts up.
    #[must_use]
    pub fn sort_scan(&self) -> Call<SortScan> {
        Call {
            on: (),
            constants: (),
            params: SortScanParams {
                bin_count: self.parts(),
            },
        }
    }

    /// The number of parts of all bins.
    fn parts(&self) -> u32 {
        self.setup.bins.count << (2 * self.means.part_bits)
    }

    /// Invocations of the kernels that add up bins.
    #[must_use]
    pub fn bin_runs(&self) -> Threads {
        Threads(self.parts().div_ceil(RUN))
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
                part_bits: self.means.part_bits,
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

impl StepKernel for SortSums {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> SortSumsArgs<'s> {
        SortSumsArgs {
            bins: &s.sorting.bins,
            sums: &s.sorting.sums,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        sort_sums(&call.params, &a.bins, &mut a.bin_sums);
    }
}

impl StepKernel for SortScan {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> SortScanArgs<'s> {
        SortScanArgs {
            bins: &s.sorting.bins,
            sums: &s.sorting.sums,
            places: &s.sorting.places,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        sort_scan(&call.params, &mut a.bins, &a.bin_sums, &mut a.bin_places);
    }
}

impl StepKernel for SortScatter {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> SortScatterArgs<'s> {
        SortScatterArgs {
            segment_particles: &s.sorting.particles.texels,
            segment_motions: &s.sorting.motions.texels,
            strips: &s.surface.strips,
            places: &s.sorting.places,
            particles: &s.particles.texels,
            motions: &s.motions.texels,
            windows: &s.transfers.windows,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        sort_scatter(
            &call.params,
            &a.setup.strips,
            &mut a.bin_places,
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
    let tiles = (params.tile_shift, params.part_bits);
    for i in 0..params.count {
        let slot = slot_of(windows, params.first + i, params.particle_count);
        segment_particles[i as usize] = particles[slot];
        segment_motions[i as usize] = motions[slot];
        bins[Bins::part_of(tiles, strips, &particles[slot]) as usize] += 1;
    }
}

/// Twin of `shaders/sort_sums.comp`.
pub fn sort_sums(params: &SortSumsParams, bins: &[u32], sums: &mut [u32]) {
    let stretches = bins[..params.bin_count as usize].chunks(STRETCH as usize);
    for (sum, stretch) in sums.iter_mut().zip(stretches) {
        *sum = stretch.iter().sum();
    }
}

/// Twin of `shaders/sort_scan.comp`.
pub fn sort_scan(params: &SortScanParams, bins: &mut [u32], sums: &[u32], places: &mut [u32]) {
    let bins = bins[..params.bin_count as usize].chunks_mut(STRETCH as usize);
    let stretches = bins.zip(places.chunks_mut(STRETCH as usize));
    for (number, (bins, places)) in stretches.enumerate() {
        let mut before = sums[..number].iter().sum();
        for (bin, place) in bins.iter_mut().zip(places) {
            *place = before;
            before += std::mem::take(bin);
        }
    }
}

/// Twin of `shaders/sort_scatter.comp`; the kernel may put the particles of a bin in another order.
pub fn sort_scatter(
    params: &SortScatterParams,
    strips: &[StripTriangle],
    places: &mut [u32],
    windows: &[Window],
    (segment_particles, segment_motions): (&[Particle], &[Motion]),
    (particles, motions): (&mut [Particle], &mut [Motion]),
) {
    let tiles = (params.tile_shift, params.part_bits);
    let segment = segment_particles.iter().zip(segment_motions);
    for (particle, motion) in segment.take(params.count as usize) {
        let part = Bins::part_of(tiles, strips, particle) as usize;
        let place = params.first + places[part];
        places[part] += 1;
        let slot = slot_of(windows, place, params.particle_count);
        particles[slot] = *particle;
        motions[slot] = *motion;
    }
}
