//! The tint of painted areas: green attracts, violet repels, red stripes are no-go.

use std::sync::Arc;

use super::{Renderer, Shot};
use crate::gpu::{Blend, Context, Format, GpuError, PassRecorder, RasterOptions, RasterPipeline};
use crate::sim::draws::{PaintedArgs, PaintedConstants, PaintedDraw, PaintedParams};
use crate::sim::texel_paths::TexelPaths;

/// Trail units of a bias that is clearly visible. Brushes of the lab reach about ten times the mean trail.
const USUAL: f32 = 60.0;

/// Draws the tint on canvases of one format and one number of samples.
pub(super) fn pipeline(
    ctx: &Arc<Context>,
    format: Format,
    samples: u32,
    paths: TexelPaths,
) -> Result<RasterPipeline<PaintedDraw>, GpuError> {
    let options = RasterOptions {
        color: format,
        samples,
        depth_write: false,
        blend: Blend::Alpha,
        ..RasterOptions::default()
    };
    RasterPipeline::new(ctx, &PaintedConstants { paths }, options)
}

impl Renderer {
    /// Records the draw, if there are painted areas.
    pub(super) fn draw_painted(&self, pass: &mut PassRecorder<'_>, shot: &Shot<'_>) {
        let Some(bias) = &shot.state.bias else {
            return;
        };
        if !shot.view.shows_areas {
            return;
        }
        let state = shot.state;
        pass.draw(
            &shot.pipelines.painted,
            self.shape.corner_count,
            1,
            PaintedArgs {
                corners: &state.surface.corners,
                vertices: &state.surface.vertices,
                strips: &state.surface.strips,
                poses: &state.objects.poses.texels,
                bias,
            },
            PaintedParams {
                clip_from_world: shot.view.camera.clip_from_world(shot.size),
                size: self.shape.size,
                pitch: self.shape.pitch,
                usual: USUAL,
            },
        );
    }
}
