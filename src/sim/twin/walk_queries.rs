//! Twin of `shaders/walk_queries.comp`.

use crate::mesh::surface::{HalfEdge, Triangle};
use crate::sim::kernels::{WalkQueriesConstants, WalkQueriesParams};
use crate::sim::types::Walker;
use crate::sim::walker::{WALK_OUT_OF_ATTEMPTS, walk};

/// Walks every walker that is not at its end over some more edges.
pub fn walk_queries(
    constants: &WalkQueriesConstants,
    params: &WalkQueriesParams,
    triangles: &[Triangle],
    halfedges: &[HalfEdge],
    walkers: &mut [Walker],
) {
    for w in &mut walkers[..params.walk_count as usize] {
        if w.status != WALK_OUT_OF_ATTEMPTS {
            continue;
        }
        walk::<true>(
            triangles,
            halfedges,
            w,
            params.attempts,
            constants.border_reflects,
        );
    }
}
