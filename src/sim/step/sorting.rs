//! The end of a step in which particles are sorted.

use super::super::kernels::{SortCountArgs, SortScanArgs, SortScatterArgs};
use super::super::pipelines::Kernels;
use super::super::sorting::SortParams;
use super::super::state::State;
use crate::gpu::{Recorder, Threads};

/// Particles lie in other buffers afterwards.
pub(super) fn sort(rec: &mut Recorder, k: &Kernels, s: &mut State, params: &SortParams) {
    let bins = &s.sorting.bins;
    rec.fill(bins, 0);
    rec.dispatch(
        &k.sort_count,
        Threads(params.count.particle_count),
        SortCountArgs {
            particles: &s.particles_view,
            motions: &s.motions_view,
            strips: &s.strips,
            bins,
        },
        params.count,
    );
    rec.dispatch(&k.sort_scan, Threads(1), SortScanArgs { bins }, params.scan);
    rec.dispatch(
        &k.sort_scatter,
        Threads(params.scatter.particle_count),
        SortScatterArgs {
            particles: &s.particles_view,
            motions: &s.motions_view,
            strips: &s.strips,
            bins,
            sorted_particles: &s.sorting.particles_view,
            sorted_motions: &s.sorting.motions_view,
            windows: &s.transfers.windows,
            flow: &s.transfers.flow,
        },
        params.scatter,
    );
    s.swap_particles();
}
