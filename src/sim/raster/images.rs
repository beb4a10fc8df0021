//! Inputs and targets of the method `raster`, on the device.

use std::sync::Arc;

use super::{RasterLayout, RasterRanges};
use crate::gpu::{
    Buffer, Context, DepthTest, Format, GpuError, Image, RasterOptions, Targets, Texels,
};
use crate::sim::buffers::{self, Counts};
use crate::sim::setup::Setup;

/// The options of the pipeline.
#[must_use]
pub fn raster_options() -> RasterOptions {
    RasterOptions {
        color: Format::R32Uint,
        depth_test: DepthTest::Smallest,
        ..RasterOptions::default()
    }
}

/// Inputs and targets of the draws, on the device.
pub struct Raster {
    /// Outlines of the triangles that own texels; two words each.
    pub outlines: Texels<u32>,
    /// A ball round each triangle.
    pub bounds: Texels<u32>,
    /// Each triangle's place among the faces.
    pub slots: Buffer<u32>,
    /// The surface point under each texel, and the triangle that owns it.
    pub places: Texels<u32>,
    /// For each texel the slot of the nearest face plus 1, 0 for none.
    pub target: Image,
    /// The smallest depth of each texel.
    pub depth: Image,
    /// The target, as kernels read it.
    pub winners: Buffer<u32>,
    /// The outlines of each object.
    pub ranges: RasterRanges,
}

impl Raster {
    /// Takes the memory and uploads the inputs.
    ///
    /// # Errors
    /// When the device has no memory left, or no images of the atlas's size.
    pub fn new(ctx: &Arc<Context>, counts: &Counts, setup: &Setup) -> Result<Self, GpuError> {
        let layout = RasterLayout::new(setup);
        let size = layout.ranges.size;
        let outlines = buffers::OUTLINES.of(ctx, counts, &layout.outlines)?;
        let bounds = buffers::BOUNDS.of(ctx, counts, &layout.bounds)?;
        let places = buffers::PLACES.of(ctx, counts, &layout.places)?;
        Ok(Self {
            outlines: buffers::OUTLINES.texels(&outlines)?,
            bounds: buffers::BOUNDS.texels(&bounds)?,
            slots: buffers::SLOTS.of(ctx, counts, &layout.slots)?,
            places: buffers::PLACES.texels(&places)?,
            target: Image::new(ctx, buffers::RASTER_TARGET.name, size, Format::R32Uint, 1)?,
            depth: Image::new(ctx, buffers::RASTER_DEPTH.name, size, Format::Depth32, 1)?,
            winners: buffers::WINNERS.zeroed(ctx, counts)?,
            ranges: layout.ranges,
        })
    }

    /// The images of the pass.
    #[must_use]
    pub fn targets(&self) -> Targets<'_> {
        Targets {
            color: &self.target,
            resolve: None,
            depth: Some(&self.depth),
            depth_test: DepthTest::Smallest,
            clear: Some([0.0; 4]),
        }
    }
}
