//! The kernels of a step, compiled. They own no buffers.

use std::sync::Arc;

use super::draws::DistanceRasterDraw;
use super::kernels::{
    Advance, AdvanceConstants, DefragmentScan, DefragmentSequential, DefragmentSwap, Diffuse,
    DiffuseSeams, Digest, Distance, DistanceBrute, DistanceMerge, DistanceTiles, ExchangeSeams,
    MoveBorder, Respawn, Scent, SortCount, SortScan, SortScatter, TransferIn, TransferOut, Unfold,
};
use super::params::StepConstants;
use super::raster::raster_options;
use crate::gpu::{Context, GpuError, Pipeline, RasterPipeline};

/// Kernels that together advance every particle once: the first lists for the others what it leaves. By the names that timers
/// show.
pub const FORMS_OF_ADVANCE: [&str; 4] = ["advance", WALK_SENSORS, ADVANCE_NEAR, WALK_NEAR];
const WALK_SENSORS: &str = "walk_sensors";
const ADVANCE_NEAR: &str = "advance_near";
const WALK_NEAR: &str = "walk_near";

/// The pipelines of a step, with the optional terms of the present settings compiled in.
pub struct Kernels {
    /// Says which faces of other objects are near tiles of texels.
    pub distance_tiles: Pipeline<DistanceTiles>,
    /// Takes distances between objects.
    pub distance: Pipeline<Distance>,
    /// The same by looking at every triangle.
    pub distance_brute: Pipeline<DistanceBrute>,
    /// The same by drawing, where that is the method.
    pub distance_raster: Option<RasterPipeline<DistanceRasterDraw>>,
    /// Takes the distances to what was drawn.
    pub distance_merge: Pipeline<DistanceMerge>,
    /// Where walks go on on other objects.
    pub unfold: Pipeline<Unfold>,
    /// Moves particles.
    pub advance: Pipeline<Advance>,
    /// Moves those whose sensors must walk, where the others' need not.
    pub walk_sensors: Option<Pipeline<Advance>>,
    /// The same kernel for particles near other objects, where it knows of none for the rest.
    pub advance_near: Option<Pipeline<Advance>>,
    /// And for those whose sensors must walk, too.
    pub walk_near: Option<Pipeline<Advance>>,
    /// Lets transfers land.
    pub transfer_in: Pipeline<TransferIn>,
    /// Ends an object's turn.
    pub move_border: Pipeline<MoveBorder>,
    /// Lets particles leave.
    pub transfer_out: Pipeline<TransferOut>,
    /// Lists particles in wrong windows.
    pub defragment_scan: Pipeline<DefragmentScan>,
    /// Exchanges them.
    pub defragment_swap: Pipeline<DefragmentSwap>,
    /// The same by one invocation.
    pub defragment_sequential: Pipeline<DefragmentSequential>,
    /// Lets particles begin anew.
    pub respawn: Pipeline<Respawn>,
    /// Spreads and decays the trail.
    pub diffuse: Pipeline<Diffuse>,
    /// The same for texels beside seams.
    pub diffuse_seams: Pipeline<DiffuseSeams>,
    /// Fills gutters.
    pub exchange_seams: Pipeline<ExchangeSeams>,
    /// Counts particles in tiles.
    pub sort_count: Pipeline<SortCount>,
    /// Adds the counts up.
    pub sort_scan: Pipeline<SortScan>,
    /// Puts particles in order.
    pub sort_scatter: Pipeline<SortScatter>,
    /// Takes away what was eaten, where there is food.
    pub digest: Option<Pipeline<Digest>>,
    /// Sums up what sensors read of food and markers.
    pub scent: Option<Pipeline<Scent>>,
    /// Is the texture larger than a storage block?
    pub outgrows_block: bool,
}

impl Kernels {
    /// Compiles the kernels of a step.
    pub fn new(ctx: &Arc<Context>, constants: &StepConstants) -> Result<Self, GpuError> {
        let form = |name, constants: &Option<AdvanceConstants>| {
            let constants = constants.as_ref();
            constants
                .map(|constants| Pipeline::named(ctx, constants, name))
                .transpose()
        };
        Ok(Self {
            distance_tiles: Pipeline::new(ctx, &constants.distance_tiles)?,
            distance: Pipeline::new(ctx, &constants.distance)?,
            distance_brute: Pipeline::new(ctx, &constants.distance_brute)?,
            distance_raster: (constants.distance_raster.as_ref())
                .map(|constants| RasterPipeline::new(ctx, constants, raster_options()))
                .transpose()?,
            distance_merge: Pipeline::new(ctx, &constants.distance_merge)?,
            unfold: Pipeline::new(ctx, &constants.unfold)?,
            advance: Pipeline::new(ctx, &constants.advance)?,
            walk_sensors: form(WALK_SENSORS, &constants.walk_sensors)?,
            advance_near: form(ADVANCE_NEAR, &constants.advance_near)?,
            walk_near: form(WALK_NEAR, &constants.walk_near)?,
            transfer_in: Pipeline::new(ctx, &())?,
            move_border: Pipeline::new(ctx, &constants.move_border)?,
            transfer_out: Pipeline::new(ctx, &constants.transfer_out)?,
            defragment_scan: Pipeline::new(ctx, &())?,
            defragment_swap: Pipeline::new(ctx, &())?,
            defragment_sequential: Pipeline::new(ctx, &())?,
            respawn: Pipeline::new(ctx, &())?,
            diffuse: Pipeline::new(ctx, &constants.diffuse)?,
            diffuse_seams: Pipeline::new(ctx, &constants.diffuse_seams)?,
            exchange_seams: Pipeline::new(ctx, &constants.exchange_seams)?,
            sort_count: Pipeline::new(ctx, &constants.sort_count)?,
            sort_scan: Pipeline::new(ctx, &())?,
            sort_scatter: Pipeline::new(ctx, &constants.sort_scatter)?,
            digest: (constants.scent.is_some())
                .then(|| Pipeline::new(ctx, &()))
                .transpose()?,
            scent: (constants.scent.as_ref())
                .map(|constants| Pipeline::new(ctx, constants))
                .transpose()?,
            outgrows_block: constants.advance.outgrows_block,
        })
    }
}
