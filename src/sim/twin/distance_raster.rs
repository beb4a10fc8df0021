//! Twin of `shaders/distance_raster.vert` and `shaders/distance_raster.frag`, and of `shaders/include/meets.glsl`.

use glam::{Vec3, Vec4};

use super::depth::depth_of;
use super::distance::{DistanceInputs, along};
use crate::mesh::trees::Node;
use crate::mesh::trees::nearest::nearest_on_face;
use crate::mesh::trees::search::{box_square, slack_of};
use crate::sim::params::{StepConstants, StepParams};
use crate::sim::raster::RasterLayout;

/// For each texel the slot of the face that is nearest by its depth and 1, or 0: what a round of an update draws.
///
/// # Panics
/// If distances are taken by another method.
#[must_use]
pub fn distance_raster(
    constants: &StepConstants,
    params: &StepParams,
    round: u32,
    layout: &RasterLayout,
    inputs: &DistanceInputs,
) -> Vec<u32> {
    let constants = constants.distance_raster.as_ref().expect("the method");
    let mut winners = vec![0; layout.places.len()];
    let mut depths = vec![1.0; layout.places.len()];
    let reach = params.distance_merge.reach;
    for draw in layout.ranges.draws(&params.distance_update, round, reach) {
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
                    let depth = depth_of(constants.depth, distance, draw.params.farthest);
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
