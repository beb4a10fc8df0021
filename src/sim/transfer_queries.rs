//! Straight walks on the GPU that change once from an object to another one, at their first crossing, by the code of the simulation, for
//! `myxo query transfer`.

use std::sync::Arc;

use super::crossing::Terrain;
use super::ground::Ground;
use super::kernels::{
    TransferQueries, TransferQueriesArgs, TransferQueriesConstants, TransferQueriesParams,
};
use super::queries::{end_of, left, walker_of};
use super::transfer_walk::{PHASE_DONE, PHASE_ON_SOURCE, walk_on};
use super::types::{Pose, Vertex, Walker};
use crate::error::Result;
use crate::gpu::{Buffer, Context, Frames, GpuResult, Pipeline, Texels, Threads};
use crate::mesh::surface::Surface;
use crate::mesh::trees::Trees;
use crate::mesh::trees::sides::Sides;
use crate::mesh::walk::{WalkEnd, WalkQuery};
use crate::scene::settings::SignRule;

/// Queries of one dispatch.
const BATCH: usize = 1 << 14;

/// Segments of one dispatch, all queries together, so that none runs for seconds.
const SEGMENTS: usize = 1 << 22;

/// Answers every query in the same order. The surface has two objects, with their poses: walks begin on the first, stop at open borders,
/// and change to the second at their first crossing. The object on which a walk ends is that of its last triangle.
///
/// If no walk advances on the device, because a search does not end there, the host makes the next attempts, with equal arithmetic.
///
/// A walk that goes round a vertex and makes no progress any more, which a sound mesh does not cause, ends there with
/// [`WalkStatus::OutOfAttempts`](crate::mesh::walk::WalkStatus).
///
/// # Errors
/// When the device fails or has too little memory.
pub fn transfer_queries(
    ctx: &Arc<Context>,
    surface: &Surface,
    poses: [Pose; 2],
    sign: SignRule,
    queries: &[WalkQuery],
) -> Result<Vec<WalkEnd>> {
    let constants = TransferQueriesConstants {
        sign_rule: sign as u32,
    };
    let pipeline = Pipeline::<TransferQueries>::new(ctx, &constants)?;
    let trees = Trees::build(surface);
    let texels = |name, words: &[u32]| Texels::new(&Buffer::from_slice(ctx, name, words)?, 4);
    let triangles = texels("triangles", bytemuck::cast_slice(&surface.triangles))?;
    let halfedges = texels("halfedges", bytemuck::cast_slice(&surface.halfedges))?;
    let nodes = texels("nodes", bytemuck::cast_slice(&trees.nodes))?;
    let dipoles = texels("dipoles", bytemuck::cast_slice(&trees.dipoles))?;
    let faces = texels("faces", bytemuck::cast_slice(&trees.faces))?;
    let pseudonormals = texels("pseudonormals", bytemuck::cast_slice(&trees.pseudonormals))?;
    let corners = Buffer::from_slice(ctx, "corners", surface.corners.as_flattened())?;
    let corners = Texels::new(&corners, 1)?;
    let host_vertices = Vertex::of(surface);
    let vertices = texels("vertices", bytemuck::cast_slice(&host_vertices))?;
    let host_roots: Vec<u32> = trees.objects.iter().map(|tree| tree.first_node).collect();
    let roots = Buffer::from_slice(ctx, "roots", &host_roots)?;
    let ground = Ground {
        triangles: &surface.triangles,
        corners: surface.corners.as_flattened(),
        vertices: &host_vertices,
        poses: &poses,
    };
    let terrain = terrain_of(surface, &trees, ground, &host_roots, constants.sign_rule);
    let poses = Texels::new(&Buffer::from_slice(ctx, "poses", &poses)?, 4)?;
    let mut frames = Frames::new(ctx, 1)?;

    let mut ends = Vec::with_capacity(queries.len());
    for batch in queries.chunks(BATCH) {
        let walkers = walk_batch(ctx, &terrain, batch, |phases, walkers, params| {
            frames.run(|rec| {
                rec.dispatch(
                    &pipeline,
                    Threads::of(batch.len()),
                    TransferQueriesArgs {
                        triangles: &triangles,
                        halfedges: &halfedges,
                        corners: &corners,
                        vertices: &vertices,
                        poses: &poses,
                        roots: &roots,
                        nodes: &nodes,
                        faces: &faces,
                        pseudonormals: &pseudonormals,
                        dipoles: &dipoles,
                        phases,
                        walkers,
                    },
                    params,
                )
            })
        })?;
        let outer = walkers.iter().step_by(2);
        ends.extend(outer.zip(batch).map(|(w, query)| end_of(w, query)));
    }
    Ok(ends)
}

/// The surface for walks on the host.
fn terrain_of<'a>(
    surface: &'a Surface,
    trees: &'a Trees,
    ground: Ground<'a>,
    roots: &'a [u32],
    sign_rule: u32,
) -> Terrain<'a> {
    Terrain {
        ground,
        halfedges: &surface.halfedges,
        sides: Sides {
            faces: &trees.faces,
            nodes: &trees.nodes,
            dipoles: &trees.dipoles,
            pseudonormals: &trees.pseudonormals,
            corners: surface.corners.as_flattened(),
            first_vertex_normal: surface.halfedges.len() as u32,
        },
        roots,
        sign_rule,
        reflects: false,
    }
}

/// Walks the queries of a batch to their ends, and returns the two walkers of each. `dispatch` runs the kernel once on their phases and
/// walkers, and waits for it.
fn walk_batch(
    ctx: &Arc<Context>,
    terrain: &Terrain,
    batch: &[WalkQuery],
    mut dispatch: impl FnMut(&Buffer<u32>, &Buffer<Walker>, TransferQueriesParams) -> GpuResult<()>,
) -> Result<Vec<Walker>> {
    let mut walkers: Vec<Walker> = batch.iter().flat_map(|q| [walker_of(q); 2]).collect();
    let mut phases = vec![PHASE_ON_SOURCE; batch.len()];
    let phases_buffer = Buffer::from_slice(ctx, "phases", &phases)?;
    let walkers_buffer = Buffer::from_slice(ctx, "walkers", &walkers)?;
    let attempts = (SEGMENTS / batch.len()).clamp(2, 4096);
    let params = TransferQueriesParams {
        query_count: batch.len() as u32,
        attempts: attempts as u32,
        first_vertex_normal: terrain.sides.first_vertex_normal,
    };
    // A walk through a vertex may cross all its edges without progress.
    let mut patience = terrain.halfedges.len() / attempts + 2;
    while patience > 0 {
        dispatch(&phases_buffer, &walkers_buffer, params)?;
        phases = ctx.download(&phases_buffer)?;
        let before = std::mem::replace(&mut walkers, ctx.download(&walkers_buffer)?);
        if phases.iter().all(|&phase| phase == PHASE_DONE) {
            break;
        }
        let stands_still = |(w, before): (&Walker, &Walker)| left(w) >= left(before);
        if walkers.iter().zip(&before).all(stands_still) {
            patience -= 1;
            let queries = phases.iter_mut().zip(walkers.chunks_exact_mut(2));
            for (phase, walkers) in queries {
                walk_on(terrain, params.attempts, phase, walkers);
            }
            ctx.upload(&phases_buffer, &phases)?;
            ctx.upload(&walkers_buffer, &walkers)?;
        }
    }
    Ok(walkers)
}
