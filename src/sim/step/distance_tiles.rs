//! `distance_tiles`: its parameters and bindings. Twin of `shaders/distance_tiles.comp`: which faces of other objects
//! may be nearest to tiles of samples, and which tiles must be searched.

use glam::Vec3;

use super::distance::{
    DistanceInputs, LIST, TILE_INSIDE, TILE_OUTSIDE, TILE_UNKNOWN, job_of, place_in_other,
};
use crate::mesh::surface::NONE;
use crate::mesh::trees::nearest::{NearestPoint, nearest_on_face};
use crate::mesh::trees::search::{UNLIMITED, is_in_box, nearest_on, slack_of};
use crate::mesh::trees::sides::is_outside;
use crate::mesh::trees::{Face, Node};
use crate::scene::settings::SignRule;
use crate::sim::arrays::{Arrays, TileLooks};
use crate::sim::distance::{TILE_CANDIDATES, TILE_SAMPLES};
use crate::sim::kernels::{
    DistanceTiles, DistanceTilesArgs, DistanceTilesConstants, DistanceTilesParams,
};
use crate::sim::plan::Plan;
use crate::sim::state::State;
use crate::sim::types::{ListedTile, ObjectPair, SampleTile};
use crate::sim::work::{Call, StepKernel};
use crate::strict::{direction3_or, dot3, inverse_root, quotient, root};

impl Plan<'_> {
    /// Finds the faces that are near the tiles of moved objects.
    pub fn distance_tiles(&self) -> Call<DistanceTiles> {
        Call {
            on: (),
            constants: DistanceTilesConstants {
                sign_rule: self.settings.distance.sign as u32,
            },
            params: DistanceTilesParams {
                tile_count: self.distances.tile_count(),
                job_count: self.distances.jobs.len() as u32,
                first_vertex_normal: self.first_vertex_normal(),
                hint_count: self.setup.distance.hint_count(),
                reach: self.lengths.reach,
                is_first: self.distances.is_first.into(),
            },
        }
    }
}

impl StepKernel for DistanceTiles {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> DistanceTilesArgs<'s> {
        DistanceTilesArgs {
            jobs: &s.near.jobs,
            pairs: &s.near.pairs.texels,
            tiles: &s.near.tiles,
            faces: &s.trees.faces,
            pseudonormals: &s.trees.pseudonormals,
            corners: &s.surface.corners,
            hints: &s.near.hints,
            nodes: &s.trees.nodes,
            dipoles: &s.trees.dipoles,
            candidates: &s.near.candidates,
            tile_states: &s.near.tile_states,
            listed: &s.near.listed,
            groups: &s.near.tile_groups,
            moves: &s.near.moves,
            margins: &s.near.margins,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        a.looks = distance_tiles(
            &call.constants,
            &call.params,
            &DistanceInputs::of(&a.setup, &a.jobs, &a.pairs),
            &a.moves,
            &mut a.tile_states,
            &mut a.margins,
        );
    }
}

/// Bound on the rounding of a length, relative to the largest coordinate.
const ROUNDING: f32 = 1e-6;

/// Bound on the rounding of distances that are compared over many updates, in slacks.
const MARGIN_SLACK: f32 = 8.0;

/// A ball of places, and the face that is nearest to its middle.
struct Ball {
    middle: Vec3,
    radius_square: f32,
    distance: f32,
    direction: Vec3,
    bend: f32,
    farthest: f32,
}

/// Processes all tiles of the jobs. `states` are the uniform states of the tiles' texels; `margins` say how far each tile is from being
/// within reach of each pair's other object, whose places have come nearer by up to `moves`.
#[must_use]
pub fn distance_tiles(
    constants: &DistanceTilesConstants,
    params: &DistanceTilesParams,
    inputs: &DistanceInputs,
    moves: &[f32],
    states: &mut [u32],
    margins: &mut [f32],
) -> TileLooks {
    let sides = inputs.sides(params.first_vertex_normal);
    let mut looks = TileLooks {
        hints: vec![0; (params.tile_count * params.hint_count) as usize],
        candidates: vec![0; (params.tile_count * TILE_CANDIDATES) as usize],
        listed: Vec::new(),
    };
    for i in 0..params.tile_count {
        let jobs = &inputs.jobs[..params.job_count as usize];
        let job = jobs[job_of(jobs, i * TILE_SAMPLES)];
        let in_job = i - job.first_thread / TILE_SAMPLES;
        if in_job * TILE_SAMPLES >= job.sample_count {
            continue;
        }
        let tile = inputs.tiles[(job.first_tile + in_job) as usize];
        let near = params.reach + tile.radius;
        let mut state = if job.pair_count <= params.hint_count {
            TILE_OUTSIDE
        } else {
            TILE_UNKNOWN
        };
        let mut candidates = Vec::new();

        for p in 0..job.pair_count.min(params.hint_count) {
            let pair = &inputs.pairs[(job.first_pair + p) as usize];
            let place = place_in_other(pair, tile.center);
            let is_closed = pair.is_closed == 1;
            let decides = constants.sign_rule == SignRule::Pseudonormal as u32 || !is_closed;
            let may_be_inside = is_closed && is_in_box(inputs.nodes, pair.first_node, place);
            let margin = &mut margins[((job.first_tile + in_job) * params.hint_count + p) as usize];
            let left = margin.abs() - moves[(job.first_pair + p) as usize];
            let tree = &inputs.nodes[pair.first_node as usize];
            let slack = slack_of(tree);
            let reach = if may_be_inside {
                UNLIMITED
            } else if decides {
                near + params.reach
            } else {
                near
            };
            let mut hint = if decides { TILE_OUTSIDE } else { TILE_UNKNOWN };
            let is_settled = decides && left > 0.0;
            let slot = match is_settled {
                true => NONE,
                false => nearest_on(inputs.nodes, inputs.faces, pair.first_node, place, reach),
            };
            if is_settled {
                let inside = *margin < 0.0;
                hint = if inside { TILE_INSIDE } else { TILE_OUTSIDE };
                *margin = if inside { -left } else { left };
            } else if slot == NONE {
                let rest = params.reach - MARGIN_SLACK * slack;
                *margin = if decides && rest > 0.0 { rest } else { 0.0 };
            } else {
                let face = &inputs.faces[slot as usize];
                let point = nearest_on_face(face, place);
                let distance = root(point.square);
                let beyond = near + slack;
                *margin = 0.0;
                let searches = distance <= beyond || !decides;
                let outside = || {
                    let (rule, tree) = (constants.sign_rule, pair.first_node);
                    is_outside(&sides, rule, tree, slot, place, &point)
                };
                hint = if searches {
                    let ball = Ball::of(tree, face, &point, place, &tile);
                    let first = candidates.len();
                    candidates.extend(collected(inputs, pair, &ball));
                    if candidates.len() <= TILE_CANDIDATES as usize {
                        LIST + 256 * first as u32 + candidates.len() as u32
                    } else {
                        candidates.truncate(first);
                        slot
                    }
                } else {
                    let inside = is_closed && !outside();
                    let rest = (distance - beyond) - MARGIN_SLACK * slack;
                    *margin = if rest <= 0.0 {
                        0.0
                    } else if inside {
                        -rest
                    } else {
                        rest
                    };
                    if inside { TILE_INSIDE } else { TILE_OUTSIDE }
                };
            }
            looks.hints[(i * params.hint_count + p) as usize] = hint;
            state = if hint < TILE_INSIDE || state == TILE_UNKNOWN {
                TILE_UNKNOWN
            } else {
                state.min(hint)
            };
        }
        let first = (i * TILE_CANDIDATES) as usize;
        looks.candidates[first..first + candidates.len()].copy_from_slice(&candidates);
        let last = &mut states[(job.first_tile + in_job) as usize];
        if state == TILE_UNKNOWN || params.is_first == 1 || *last != state {
            let first = in_job * TILE_SAMPLES;
            looks.listed.push(ListedTile {
                tile: i,
                first_sample: job.first_sample + first,
                sample_count: (job.sample_count - first).min(TILE_SAMPLES),
                first_pair: job.first_pair,
                pair_count: job.pair_count,
                hinted: job.pair_count.min(params.hint_count),
                ..ListedTile::default()
            });
        }
        *last = state;
    }
    looks
}

impl Ball {
    fn of(tree: &Node, face: &Face, point: &NearestPoint, place: Vec3, tile: &SampleTile) -> Self {
        let to_face = (face.a + point.u * face.ab) + point.v * face.ac;
        let from_middle = (tile.center.abs() + place.abs()).max_element();
        let slack = 8.0 * slack_of(tree) + 4.0 * ROUNDING * from_middle;
        let radius = 1.001 * tile.radius + slack;
        let distance = root(point.square);
        let slack = slack + 1e-5 * (distance + radius);
        let farthest = 2.0 * radius + slack;
        let rest = distance - radius;
        let bend = (0.5 * radius) * quotient(radius, rest) + slack;
        Self {
            middle: place,
            radius_square: radius * radius,
            distance,
            direction: direction3_or(place - to_face, Vec3::ZERO),
            bend: if rest > 0.0 {
                bend.min(farthest)
            } else {
                farthest
            },
            farthest,
        }
    }

    /// May a convex shape hold the nearest point for some place in the ball? `way` leads to the middle from the shape's nearest point.
    fn may_be_nearest(&self, way: Vec3) -> bool {
        let square = dot3(way, way);
        let by = inverse_root(square);
        let distance = square * by;
        let more = distance - self.distance;
        let turned = way * by - self.direction;
        let turn_square = self.radius_square * dot3(turned, turned);
        let beyond = more - self.bend;
        more <= self.farthest && (beyond <= 0.0 || beyond * beyond <= turn_square)
    }
}

/// The faces that are nearest to some place in the ball, and maybe others.
fn collected(inputs: &DistanceInputs, pair: &ObjectPair, ball: &Ball) -> Vec<u32> {
    let mut found = Vec::new();
    let mut stack = vec![inputs.nodes[pair.first_node as usize].link];
    while let Some(link) = stack.pop() {
        if link < Node::LEAF {
            for node in &inputs.nodes[link as usize..link as usize + 2] {
                let nearest = ball.middle.clamp(node.low, node.high);
                if ball.may_be_nearest(ball.middle - nearest) {
                    stack.push(node.link);
                }
            }
            continue;
        }
        let first = link % Node::LEAF;
        for slot in first..first + link / Node::LEAF {
            let face = &inputs.faces[slot as usize];
            let point = nearest_on_face(face, ball.middle);
            let way = ((ball.middle - face.a) - point.u * face.ab) - point.v * face.ac;
            if ball.may_be_nearest(way) {
                found.push(slot);
            }
        }
    }
    found
}
