//! Nearest points and crossings on one mesh on the GPU, by the code of the simulation, for `myxo query sdf`.

use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

use super::kernels::{TreeQueries, TreeQueriesArgs, TreeQueriesConstants, TreeQueriesParams};
use super::types::TreeQuery;
use crate::error::Result;
use crate::gpu::{Buffer, Context, Frames, Pipeline, Texels, Threads};
use crate::mesh::surface::Surface;
use crate::mesh::trees::Trees;
use crate::mesh::trees::nearest::nearest_on_face;
use crate::mesh::trees::search::{UNLIMITED, first_crossing, nearest_on};
use crate::mesh::trees::sides::{Sides, is_outside};
use crate::scene::settings::SignRule;
use crate::strict::root;

/// Queries of one dispatch, so that none runs for seconds.
const BATCH: usize = 1 << 16;

impl TreeQuery {
    /// A query for the nearest point to a place.
    #[must_use]
    pub fn nearest(place: Vec3) -> Self {
        Self::crossing(place, place)
    }

    /// A query for the first crossing of the segment between two places with the surface.
    #[must_use]
    pub fn crossing(place: Vec3, end: Vec3) -> Self {
        Self {
            place,
            slot: 0,
            end,
            result: 0.0,
            u: 0.0,
            v: 0.0,
            ended: 0,
            pad0: 0,
        }
    }
}

/// The kind of the queries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// The nearest point and the signed distance to it.
    Nearest(SignRule),
    /// The first crossing, and the share of the segment before it.
    Crossing,
}

impl Question {
    /// The kernel's specialization constants.
    #[must_use]
    pub fn constants(self) -> TreeQueriesConstants {
        match self {
            Self::Nearest(rule) => TreeQueriesConstants {
                crossings: false,
                sign_rule: rule as u32,
            },
            Self::Crossing => TreeQueriesConstants {
                crossings: true,
                sign_rule: 0,
            },
        }
    }
}

/// Answers every query about the first object of a surface, in place. A slot is a place in [`Trees::faces`].
///
/// A query whose search does not end on the device is [answered on the host](answer_on_host), by the same arithmetic.
///
/// # Errors
/// When the device fails or has too little memory.
pub fn tree_queries(
    ctx: &Arc<Context>,
    surface: &Surface,
    trees: &Trees,
    question: Question,
    queries: &mut [TreeQuery],
) -> Result<()> {
    let constants = question.constants();
    let pipeline = Pipeline::<TreeQueries>::new(ctx, &constants)?;
    let first_vertex_normal = surface.halfedges.len() as u32;
    let sides = Sides {
        nodes: &trees.nodes,
        faces: &trees.faces,
        corners: surface.corners.as_flattened(),
        dipoles: &trees.dipoles,
        pseudonormals: &trees.pseudonormals,
        first_vertex_normal,
    };
    let nodes = Texels::new(&Buffer::from_slice(ctx, "nodes", &trees.nodes)?, 4)?;
    let dipoles = Texels::new(&Buffer::from_slice(ctx, "dipoles", &trees.dipoles)?, 4)?;
    let faces = Texels::new(&Buffer::from_slice(ctx, "faces", &trees.faces)?, 4)?;
    let pseudonormals = Texels::new(
        &Buffer::from_slice(ctx, "pseudonormals", &trees.pseudonormals)?,
        4,
    )?;
    let corners = Buffer::from_slice(ctx, "corners", surface.corners.as_flattened())?;
    let corners = Texels::new(&corners, 1)?;
    let mut frames = Frames::new(ctx, 1)?;
    for batch in queries.chunks_mut(BATCH) {
        let buffer = Buffer::from_slice(ctx, "queries", batch)?;
        let params = TreeQueriesParams {
            query_count: batch.len() as u32,
            root: trees.objects[0].first_node,
            first_vertex_normal,
        };
        frames.run(|rec| {
            rec.dispatch(
                &pipeline,
                Threads::of(batch.len()),
                TreeQueriesArgs {
                    nodes: &nodes,
                    dipoles: &dipoles,
                    faces: &faces,
                    pseudonormals: &pseudonormals,
                    corners: &corners,
                    queries: &buffer,
                },
                params,
            )
        })?;
        let answers = ctx.download(&buffer)?;
        batch
            .par_iter_mut()
            .zip(answers)
            .for_each(|(query, answer)| {
                if answer.ended == 1 {
                    *query = answer;
                } else {
                    answer_on_host(&constants, &sides, params.root, query);
                }
            });
    }
    Ok(())
}

/// Answers one query about a tree on the host, in place; `tree` is the first node of its tree.
pub fn answer_on_host(
    constants: &TreeQueriesConstants,
    sides: &Sides,
    tree: u32,
    query: &mut TreeQuery,
) {
    let (nodes, faces) = (sides.nodes, sides.faces);
    query.ended = 1;
    if constants.crossings {
        let crossing = first_crossing(nodes, faces, tree, query.place, query.end);
        query.slot = crossing.slot;
        query.result = crossing.t;
        query.u = crossing.u;
        query.v = crossing.v;
        return;
    }
    query.slot = nearest_on(nodes, faces, tree, query.place, UNLIMITED);
    let point = nearest_on_face(&faces[query.slot as usize], query.place);
    let rule = constants.sign_rule;
    let outside = is_outside(sides, rule, tree, query.slot, query.place, &point);
    let distance = root(point.square);
    query.result = if outside { distance } else { -distance };
    query.u = point.u;
    query.v = point.v;
}
