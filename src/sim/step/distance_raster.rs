//! `distance_raster`, which draws: its parameters and bindings. Twin of `shaders/distance_raster.vert` and
//! `shaders/distance_raster.frag`, and of `shaders/include/meets.glsl`.

use glam::{Vec3, Vec4};

use super::distance::{DistanceInputs, along};
use crate::gpu::{GpuError, Recorder};
use crate::mesh::trees::Node;
use crate::mesh::trees::nearest::nearest_on_face;
use crate::mesh::trees::search::{box_square, slack_of};
use crate::sim::arrays::Arrays;
use crate::sim::depth::depth_of;
use crate::sim::distance::{DepthLengths, DistanceUpdate};
use crate::sim::draws::{DistanceRasterArgs, DistanceRasterConstants, DistanceRasterDraw};
use crate::sim::pipelines::Pipelines;
use crate::sim::plan::Plan;
use crate::sim::raster::{RasterDraw, RasterLayout, raster_options};
use crate::sim::state::State;
use crate::sim::work::Work;
use std::sync::Arc;

/// A round in which every job has one of its pairs: the nearest faces of the other object are drawn.
#[derive(Debug)]
pub struct DrawDistances {
    constants: DistanceRasterConstants,
    update: Arc<DistanceUpdate>,
    round: u32,
    reach: f32,
    depths: DepthLengths,
}

impl Plan<'_> {
    /// Draws the nearest faces, in as many rounds as needed.
    pub fn distance_raster(&self) -> impl Iterator<Item = DrawDistances> + use<> {
        let update = Arc::new(self.distances.clone());
        let constants = DistanceRasterConstants {
            depth: self.settings.distance.depth as u32,
        };
        let reach = self.lengths.reach;
        let depths = DepthLengths::new(&self.settings.distance, self.setup.radius);
        (0..update.rounds()).map(move |round| DrawDistances {
            constants,
            update: Arc::clone(&update),
            round,
            reach,
            depths,
        })
    }
}

impl Work for DrawDistances {
    fn kernels(&self) -> Vec<&'static str> {
        vec!["distance_raster"]
    }

    fn prepare(&self, made: &mut Pipelines) -> Result<(), GpuError> {
        made.make_draw::<DistanceRasterDraw>(&self.constants, raster_options())
    }

    fn is_prepared(&self, made: &Pipelines) -> bool {
        made.has_draw::<DistanceRasterDraw>(&self.constants)
    }

    fn on_device(&self, rec: &mut Recorder, made: &Pipelines, s: &mut State) {
        let raster = s.raster();
        let (update, round) = (&self.update, self.round);
        let draws = raster.ranges.draws(update, round, self.reach, self.depths);
        if draws.is_empty() {
            return;
        }
        let args = DistanceRasterArgs {
            outlines: &raster.outlines,
            bounds: &raster.bounds,
            slots: &raster.slots,
            nodes: &s.trees.nodes,
            places: &raster.places,
            faces: &s.trees.faces,
        };
        rec.pass_as_kernel("distance_raster", &raster.targets(), |pass| {
            let pipeline = made.of_draw::<DistanceRasterDraw>();
            for draw in &draws {
                pass.draw(pipeline, draw.vertices, draw.instances, args, draw.params);
            }
        });
        rec.copy_image(&raster.target, &raster.winners);
    }

    fn on_host(&self, a: &mut Arrays) {
        let layout = RasterLayout::new(&a.setup);
        let (update, round) = (&self.update, self.round);
        let draws = layout.ranges.draws(update, round, self.reach, self.depths);
        let inputs = DistanceInputs::of(&a.setup, &a.jobs, &a.pairs);
        a.winners = distance_raster(&self.constants, &draws, &layout, &inputs);
    }
}

/// For each texel the slot of the drawn face with the smallest depth plus 1, or 0.
#[must_use]
pub fn distance_raster(
    constants: &DistanceRasterConstants,
    draws: &[RasterDraw],
    layout: &RasterLayout,
    inputs: &DistanceInputs,
) -> Vec<u32> {
    let mut winners = vec![0; layout.places.len()];
    let mut depths = vec![1.0; layout.places.len()];
    for draw in draws {
        let first = draw.params.first_outline;
        for other in draw.params.first_face..draw.params.first_face + draw.instances {
            let slot = layout.slots[other as usize];
            let face = &inputs.faces[slot as usize];
            for outline in first..first + draw.vertices / 3 {
                let triangle = layout.outlines[outline as usize].triangle;
                let bound = layout.bounds[triangle as usize];
                let to_other = |place: Vec3| {
                    let rows = [draw.params.x, draw.params.y, draw.params.z];
                    Vec3::from(rows.map(|row| along(row, place)))
                };
                if !meet(
                    &inputs.nodes[draw.params.first_node as usize],
                    to_other(bound.truncate()),
                    bound.w,
                    layout.bounds[other as usize],
                    draw.params.reach,
                    draw.params.farthest,
                ) {
                    continue;
                }
                let (start, end) = layout.owned[outline as usize];
                for &texel in &layout.texels[start as usize..end as usize] {
                    let place = to_other(layout.places[texel as usize].position);
                    let distance = nearest_on_face(face, place).square.sqrt();
                    if distance > draw.params.farthest {
                        continue;
                    }
                    let depth = depth_of(
                        constants.depth,
                        distance,
                        draw.params.farthest,
                        draw.params.near_plane,
                        draw.params.scale,
                    );
                    if depth < depths[texel as usize] {
                        depths[texel as usize] = depth;
                        winners[texel as usize] = slot + 1;
                    }
                }
            }
        }
    }
    winners
}

fn meet(
    root: &Node,
    centre: Vec3,
    radius: f32,
    other_bound: Vec4,
    reach: f32,
    farthest: f32,
) -> bool {
    let slack = 4.0 * slack_of(root);
    let to_box = 1.001 * radius + slack;
    let may_be_inside = box_square(centre, root) <= to_box * to_box;
    let most = if may_be_inside { farthest } else { reach };
    let limit = 1.001 * (radius + other_bound.w + most) + slack;
    let way = centre - other_bound.truncate();
    way.dot(way) <= limit * limit
}
