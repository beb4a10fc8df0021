//! Straight walks of any length on the GPU, by the code that particles walk with, for `myxo query geodesic`.
//!
//! Unlike particles, these walkers carry rounding errors along, so their ends are exact to a few last places of float32, for any number of
//! edges.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::kernels::{WalkQueries, WalkQueriesArgs, WalkQueriesConstants, WalkQueriesParams};
use super::types::Walker;
use super::walker::{WALK_BORDER, WALK_DONE, WALK_OUT_OF_ATTEMPTS};
use crate::error::Result;
use crate::gpu::{Buffer, Context, Frames, Pipeline, Texels, Threads};
use crate::mesh::surface::{NONE, Surface};
use crate::mesh::walk::{BorderRule, SurfacePoint, WalkEnd, WalkQuery, WalkStatus};

/// Walks of one dispatch.
const BATCH: usize = 1 << 20;

/// Edge crossings of one dispatch, all walks together: a walk continues in the next one, so that no dispatch runs for
/// seconds.
const CROSSINGS: usize = 1 << 25;

/// Walks every query to its end, over as many edges as it takes, and answers in the same order.
///
/// A walk that goes round a vertex and makes no progress any more, which a sound mesh does not cause, ends there with
/// [`WalkStatus::OutOfAttempts`].
///
/// # Errors
/// When the device fails or has too little memory.
pub fn walk_queries(
    ctx: &Arc<Context>,
    surface: &Surface,
    queries: &[WalkQuery],
    border: BorderRule,
) -> Result<Vec<WalkEnd>> {
    let mut ends = Vec::with_capacity(queries.len());
    if queries.is_empty() {
        return Ok(ends);
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
    let mut frames = Frames::new(ctx, 1)?;

    for batch in queries.chunks(BATCH) {
        let mut walkers: Vec<Walker> = batch.iter().map(walker_of).collect();
        let buffer = Buffer::from_slice(ctx, "walkers", &walkers)?;
        let attempts = (CROSSINGS / walkers.len()).clamp(1, 4096);
        // A walk through a vertex may cross all its edges without progress.
        let mut patience = surface.halfedges.len() / attempts + 2;
        while patience > 0 {
            frames.run(|rec| {
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
                        attempts: attempts as u32,
                    },
                )
            })?;
            let before = std::mem::replace(&mut walkers, ctx.download(&buffer)?);
            let under_way = |w: &Walker| w.status == WALK_OUT_OF_ATTEMPTS;
            let mut pairs = walkers.iter().zip(&before).filter(|(w, _)| under_way(w));
            if pairs.clone().next().is_none() {
                break;
            }
            if pairs.all(|(after, before)| left(after) >= left(before)) {
                patience -= 1;
            }
        }
        ends.extend(walkers.iter().zip(batch).map(|(w, query)| end_of(w, query)));
    }
    Ok(ends)
}

/// A number as a float32, and its rounding error.
fn split(number: f64) -> [f32; 2] {
    let rounded = number as f32;
    [rounded, (number - f64::from(rounded)) as f32]
}

fn joined(rounded: f32, dropped: f32) -> f64 {
    f64::from(rounded) + f64::from(dropped)
}

/// The length that a walker has yet to walk.
pub(super) fn left(w: &Walker) -> f64 {
    joined(w.remaining, w.carry_remaining)
}

/// A walker before its first step. Its status is out of attempts, so that the kernel continues it.
#[must_use]
pub fn walker_of(query: &WalkQuery) -> Walker {
    let SurfacePoint { triangle, u, v } = query.start;
    let [weight_a, carry_a] = split((1.0 - u - v).max(0.0));
    let [weight_b, carry_b] = split(u);
    let [weight_c, carry_c] = split(v);
    let [heading_p, carry_p] = split(query.heading.x);
    let [heading_h, carry_h] = split(query.heading.y);
    let [remaining, carry_remaining] = split(query.length);
    Walker {
        triangle,
        weight_a,
        weight_b,
        weight_c,
        heading_p,
        heading_h,
        remaining,
        entered_by: NONE,
        status: WALK_OUT_OF_ATTEMPTS,
        carry_a,
        carry_b,
        carry_c,
        carry_p,
        carry_h,
        carry_remaining,
    }
}

/// The end of a query's walk.
#[must_use]
pub fn end_of(w: &Walker, query: &WalkQuery) -> WalkEnd {
    let weights = DVec3::new(
        joined(w.weight_a, w.carry_a),
        joined(w.weight_b, w.carry_b),
        joined(w.weight_c, w.carry_c),
    );
    let weights = weights.max(DVec3::ZERO);
    let weights = weights / weights.element_sum();
    WalkEnd {
        point: SurfacePoint {
            triangle: w.triangle,
            u: weights.y,
            v: weights.z,
        },
        heading: DVec2::new(
            joined(w.heading_p, w.carry_p),
            joined(w.heading_h, w.carry_h),
        )
        .normalize(),
        travelled: query.length - left(w),
        status: match w.status {
            WALK_DONE => WalkStatus::Done,
            WALK_BORDER => WalkStatus::Border,
            _ => WalkStatus::OutOfAttempts,
        },
    }
}
