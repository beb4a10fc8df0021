//! Twin of `shaders/transfer_queries.comp`.

use crate::sim::crossing::Terrain;
use crate::sim::kernels::TransferQueriesParams;
use crate::sim::transfer_walk::walk_on;
use crate::sim::types::Walker;

/// Continues every query, by the attempts of one dispatch. A query has two walkers.
pub fn transfer_queries(
    params: &TransferQueriesParams,
    terrain: &Terrain,
    phases: &mut [u32],
    walkers: &mut [Walker],
) {
    let queries = phases.iter_mut().zip(walkers.chunks_exact_mut(2));
    for (phase, walkers) in queries.take(params.query_count as usize) {
        walk_on(terrain, params.attempts, phase, walkers);
    }
}
