//! Twin of `shaders/tree_queries.comp`.

use super::bvh::{UNLIMITED, first_crossing, nearest_on};
use super::nearest::nearest_on_face;
use super::sign::{Sides, is_outside};
use crate::sim::kernels::{TreeQueriesConstants, TreeQueriesParams};
use crate::sim::types::TreeQuery;

/// Answers every query in place.
pub fn tree_queries(
    constants: &TreeQueriesConstants,
    params: &TreeQueriesParams,
    sides: &Sides,
    queries: &mut [TreeQuery],
) {
    let (nodes, faces) = (sides.nodes, sides.faces);
    for query in &mut queries[..params.query_count as usize] {
        if constants.crossings {
            let crossing = first_crossing(nodes, faces, params.root, query.place, query.end);
            query.slot = crossing.slot;
            query.result = crossing.t;
            query.u = crossing.u;
            query.v = crossing.v;
        } else {
            query.slot = nearest_on(nodes, faces, params.root, query.place, UNLIMITED);
            let point = nearest_on_face(&faces[query.slot as usize], query.place);
            let outside = is_outside(
                sides,
                constants.sign_rule,
                params.root,
                query.slot,
                query.place,
                &point,
            );
            query.result = if outside {
                point.square.sqrt()
            } else {
                -point.square.sqrt()
            };
            query.u = point.u;
            query.v = point.v;
        }
    }
}
