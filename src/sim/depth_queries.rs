//! Depths of distances on the GPU, by the code that `distance_raster` uses.

use std::sync::Arc;

use super::distance::DepthLengths;
use super::kernels::{DepthQueries, DepthQueriesArgs, DepthQueriesConstants, DepthQueriesParams};
use crate::error::Result;
use crate::gpu::{Buffer, Context, Frames, Pipeline, Threads};
use crate::scene::settings::DepthMapping;

/// The depth of each distance, for distances clamped to `reach`, by mappings of these lengths.
///
/// # Errors
/// When the device fails or has too little memory.
pub fn depth_queries(
    ctx: &Arc<Context>,
    mapping: DepthMapping,
    reach: f32,
    lengths: DepthLengths,
    distances: &[f32],
) -> Result<Vec<f32>> {
    let constants = DepthQueriesConstants {
        depth: mapping as u32,
    };
    let pipeline = Pipeline::<DepthQueries>::new(ctx, &constants)?;
    let asked = Buffer::from_slice(ctx, "distances", distances)?;
    let depths = Buffer::<f32>::zeroed(ctx, "depths", distances.len())?;
    Frames::new(ctx, 1)?.run(|rec| {
        rec.dispatch(
            &pipeline,
            Threads::of(distances.len()),
            DepthQueriesArgs {
                distances: &asked,
                depths: &depths,
            },
            DepthQueriesParams {
                query_count: distances.len() as u32,
                reach,
                near_plane: lengths.near,
                scale: lengths.scale_within(reach),
            },
        )
    })?;
    Ok(ctx.download(&depths)?)
}
