//! The end of a step in which particles are sorted.

use super::super::pipelines::Kernels;
use super::super::sorting::SortParams;
use super::super::state::State;
use super::arguments;
use crate::gpu::{Recorder, Threads};

/// Particles lie in other buffers afterwards.
pub(super) fn sort(rec: &mut Recorder, k: &Kernels, s: &mut State, params: &SortParams) {
    let bins = &s.sorting.bins;
    rec.fill(bins, 0);
    rec.dispatch(
        &k.sort_count,
        Threads(params.count.particle_count),
        arguments::sort_count(s),
        params.count,
    );
    rec.dispatch(
        &k.sort_scan,
        Threads(1),
        arguments::sort_scan(s),
        params.scan,
    );
    rec.dispatch(
        &k.sort_scatter,
        Threads(params.scatter.particle_count),
        arguments::sort_scatter(s),
        params.scatter,
    );
    s.swap_particles();
}
