//! Twin of `shaders/tree_queries.comp`.

use crate::mesh::trees::sides::Sides;
use crate::sim::kernels::{TreeQueriesConstants, TreeQueriesParams};
use crate::sim::tree_queries::answer_on_host;
use crate::sim::types::TreeQuery;

/// Answers every query in place.
pub fn tree_queries(
    constants: &TreeQueriesConstants,
    params: &TreeQueriesParams,
    sides: &Sides,
    queries: &mut [TreeQuery],
) {
    for query in &mut queries[..params.query_count as usize] {
        answer_on_host(constants, sides, params.root, query);
    }
}
