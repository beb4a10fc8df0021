//! Straight walks of any length on the GPU, by the code that particles walk with: what `myxo query geodesic` answers.

use std::sync::Arc;

use super::kernels::{WalkQueries, WalkQueriesArgs, WalkQueriesConstants, WalkQueriesParams};
use super::twin::walk::WALK_OUT_OF_ATTEMPTS;
use super::types::Walker;
use crate::error::{Error, Result};
use crate::gpu::{Access, Buffer, Context, Domain, Frames, Pipeline, Texels, Threads};
use crate::mesh::surface::Surface;
use crate::mesh::walk::BorderRule;

/// Edge crossings of one dispatch: a walk goes on in the next one, so that no dispatch runs for seconds.
const ATTEMPTS: u32 = 4096;

/// Walks every walker to its end, over as many edges as it takes.
///
/// # Errors
/// When a walk makes no progress any more, which a sound mesh does not cause; or when the device fails.
pub fn walk_queries(
    ctx: &Arc<Context>,
    surface: &Surface,
    walkers: &[Walker],
    border: BorderRule,
) -> Result<Vec<Walker>> {
    if walkers.is_empty() {
        return Ok(Vec::new());
    }
    let constants = WalkQueriesConstants {
        border_reflects: border == BorderRule::Reflect,
    };
    let pipeline = Pipeline::<WalkQueries>::new(ctx, &constants)?;
    let triangles = Texels::new(
        &Buffer::from_slice(ctx, "triangles", &surface.triangles)?,
        4,
    )?;
    let halfedges = Texels::new(
        &Buffer::from_slice(ctx, "halfedges", &surface.halfedges)?,
        4,
    )?;
    let buffer = Buffer::new(ctx, "walkers", walkers.len(), Domain::Device)?;
    ctx.upload(&buffer, walkers)?;

    let mut frames = Frames::new(ctx, 1)?;
    let mut before = walkers.to_vec();
    loop {
        let mut rec = frames.begin()?;
        rec.dispatch(
            &pipeline,
            Threads(walkers.len() as u32),
            WalkQueriesArgs {
                triangles: &triangles,
                halfedges: &halfedges,
                walkers: &buffer,
            },
            WalkQueriesParams {
                walk_count: walkers.len() as u32,
                attempts: ATTEMPTS,
            },
        );
        rec.barrier(Access::Kernel, Access::Copy, &[&buffer]);
        frames.submit(rec)?;
        frames.wait_idle()?;
        let after = ctx.download(&buffer)?;
        let unfinished = |w: &Walker| w.status == WALK_OUT_OF_ATTEMPTS;
        if !after.iter().any(unfinished) {
            return Ok(after);
        }
        if let Some(i) = (0..after.len())
            .find(|&i| unfinished(&after[i]) && after[i].remaining >= before[i].remaining)
        {
            return Err(Error::Invalid(format!(
                "walk {i} turns round a vertex of triangle {} and gets no further: move its start a little",
                after[i].triangle
            )));
        }
        before = after;
    }
}
