//! Food and markers: a low dome for each, which shrinks as the food is eaten.

use std::sync::Arc;

use super::{Renderer, Shot};
use crate::gpu::{Context, Format, GpuError, PassRecorder, RasterOptions, RasterPipeline};
use crate::sim::draws::{FoodsArgs, FoodsDraw, FoodsParams};

/// Vertices of a dome: `SIDES * RINGS * 6` of `shaders/foods.vert`.
const VERTICES: u32 = 20 * 8 * 6;

/// Draws them on canvases of one format and one number of samples.
pub(super) fn pipeline(
    ctx: &Arc<Context>,
    format: Format,
    samples: u32,
) -> Result<RasterPipeline<FoodsDraw>, GpuError> {
    let options = RasterOptions {
        color: format,
        samples,
        ..RasterOptions::default()
    };
    RasterPipeline::new(ctx, &(), options)
}

impl Renderer {
    /// Records the draw, if there is food and it is shown.
    pub(super) fn draw_foods(pass: &mut PassRecorder<'_>, shot: &Shot<'_>) {
        let (state, view) = (shot.state, shot.view);
        let Some(food) = state.food.as_ref().filter(|_| view.shows_food) else {
            return;
        };
        let camera = &view.camera;
        pass.draw(
            &shot.pipelines.foods,
            VERTICES,
            food.food_count,
            FoodsArgs {
                marks: &food.marks,
                meals: &food.meals,
                poses: &state.objects.poses,
            },
            FoodsParams {
                clip_from_world: camera.clip_from_world(shot.size),
                eye: camera.eye(),
                lamp: shot.lighting.lamp,
                key_direction: view.light.direction(camera),
                glow: shot.lighting.food_glow,
            },
        );
    }
}
