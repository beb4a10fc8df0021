//! `distance`: its parameters and bindings. Twin of `shaders/distance.comp`, and of
//! `shaders/include/distance.glsl` and `jobs.glsl`, which the other methods share.

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use crate::mesh::surface::NONE;
use crate::mesh::trees::nearest::{NearestPoint, is_nearer, nearest_on_face};
use crate::mesh::trees::search::{FAR, UNLIMITED, is_in_box, nearest_on, slack_of};
use crate::mesh::trees::sides::{Sides, is_outside};
use crate::mesh::trees::{Dipole, Face, Node};
use crate::sim::arrays::{Arrays, TileLooks};
use crate::sim::distance::{DistanceSetup, TILE_CANDIDATES, TILE_SAMPLES};
use crate::sim::kernels::{Distance, DistanceArgs, DistanceConstants, DistanceParams};
use crate::sim::plan::Plan;
use crate::sim::setup::Setup;
use crate::sim::state::State;
use crate::sim::types::{DistanceJob, ObjectPair, SampleTile, SurfaceSample};
use crate::sim::work::{Call, StepKernel};
use crate::strict::{root, settled};

impl Plan<'_> {
    /// Searches the texels of the listed tiles.
    pub fn distance(&self) -> Call<Distance> {
        let lengths = self.lengths;
        Call {
            on: (),
            constants: DistanceConstants {
                sign_rule: self.settings.distance.sign as u32,
                sees_across: self.finds_across(),
            },
            params: DistanceParams {
                tile_count: self.distances.tile_count(),
                first_vertex_normal: self.first_vertex_normal(),
                hint_count: self.setup.distance.hint_count(),
                reach: lengths.reach,
                threshold: lengths.threshold,
                deepest: lengths.deepest,
                near: lengths.near,
                sight: lengths.sight,
            },
        }
    }
}

impl StepKernel for Distance {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> DistanceArgs<'s> {
        DistanceArgs {
            pairs: &s.near.pairs.texels,
            samples: &s.near.samples.texels,
            faces: &s.trees.faces,
            pseudonormals: &s.trees.pseudonormals,
            corners: &s.surface.corners,
            distances: &s.near.distances,
            nearest: &s.near.nearest,
            nodes: &s.trees.nodes,
            dipoles: &s.trees.dipoles,
            hints: &s.near.hints.texels,
            candidates: &s.near.candidates.texels,
            listed: &s.near.listed.texels,
            listed_groups: &s.near.tile_groups,
            groups: &s.near.covered_groups,
            covered: &s.near.covered,
            surroundings: &s.across.surroundings,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        distance(
            &call.constants,
            &call.params,
            &DistanceInputs::of(&a.setup, &a.jobs, &a.pairs),
            &a.looks,
            &mut a.distances,
            &mut a.nearest,
        );
    }
}

/// In place of a near face: the whole tile is beyond reach, outside.
pub(super) const TILE_OUTSIDE: u32 = u32::MAX;

/// In place of a near face: the whole tile is beyond reach, inside of a closed object.
pub(super) const TILE_INSIDE: u32 = u32::MAX - 1;

/// Nothing is known.
pub(super) const TILE_UNKNOWN: u32 = u32::MAX - 2;

/// A hint from here on, but for those above, is a part of the tile's candidates.
pub(super) const LIST: u32 = 1 << 28;

/// Inputs of the kernels of signed distance.
#[derive(Clone, Copy)]
pub struct DistanceInputs<'a> {
    /// Objects whose distances are computed.
    pub jobs: &'a [DistanceJob],
    /// The other objects within reach of each of them.
    pub pairs: &'a [ObjectPair],
    /// Surface points under texels.
    pub samples: &'a [SurfaceSample],
    /// Balls round samples.
    pub tiles: &'a [SampleTile],
    /// Every triangle.
    pub faces: &'a [Face],
    /// Normals of half-edges, then of vertices.
    pub pseudonormals: &'a [Vec4],
    /// Three vertex indices per triangle.
    pub corners: &'a [u32],
    /// Trees of faces.
    pub nodes: &'a [Node],
    /// The far field of each node.
    pub dipoles: &'a [Dipole],
}

impl<'a> DistanceInputs<'a> {
    /// The inputs of a scene.
    #[must_use]
    pub fn of(setup: &'a Setup, jobs: &'a [DistanceJob], pairs: &'a [ObjectPair]) -> Self {
        let DistanceSetup {
            samples,
            tiles,
            trees,
            ..
        } = &setup.distance;
        Self {
            jobs,
            pairs,
            samples,
            tiles,
            faces: &trees.faces,
            pseudonormals: &trees.pseudonormals,
            corners: &setup.corners,
            nodes: &trees.nodes,
            dipoles: &trees.dipoles,
        }
    }

    /// The job and sample of an invocation, in kernels with one per sample; `None` for padding.
    pub(super) fn sample_of(&self, job_count: u32, i: u32) -> Option<(DistanceJob, SurfaceSample)> {
        let job = self.jobs[job_of(&self.jobs[..job_count as usize], i)];
        let in_job = i - job.first_thread;
        (in_job < job.sample_count)
            .then(|| (job, self.samples[(job.first_sample + in_job) as usize]))
    }

    /// The data for inside tests.
    #[must_use]
    pub fn sides(&self, first_vertex_normal: u32) -> Sides<'a> {
        Sides {
            faces: self.faces,
            nodes: self.nodes,
            dipoles: self.dipoles,
            pseudonormals: self.pseudonormals,
            corners: self.corners,
            first_vertex_normal,
        }
    }
}

/// Signed distance to other objects, and their nearest triangle. `looks` are the results of `distance_tiles`.
pub fn distance(
    constants: &DistanceConstants,
    params: &DistanceParams,
    inputs: &DistanceInputs,
    looks: &TileLooks,
    distances: &mut [f32],
    nearest: &mut [u32],
) {
    let sides = inputs.sides(params.first_vertex_normal);
    let one = |i: u32| {
        let tile = looks.listed[(i / TILE_SAMPLES) as usize];
        if i % TILE_SAMPLES >= tile.sample_count {
            return None;
        }
        let here = inputs.samples[(tile.first_sample + i % TILE_SAMPLES) as usize];

        let mut least = params.reach;
        let mut triangle = NONE;
        let first_hint = tile.tile * params.hint_count;
        let first_candidate = tile.tile * TILE_CANDIDATES;
        for p in 0..tile.pair_count {
            let hint = if p < params.hint_count {
                looks.hints[(first_hint + p) as usize]
            } else {
                TILE_UNKNOWN
            };
            if hint == TILE_OUTSIDE {
                continue;
            }
            if hint == TILE_INSIDE {
                if -params.reach < least {
                    (least, triangle) = (-params.reach, NONE);
                }
                continue;
            }
            let pair = &inputs.pairs[(tile.first_pair + p) as usize];
            let place = place_in_other(pair, here.position);
            let may_be_inside =
                pair.is_closed == 1 && is_in_box(inputs.nodes, pair.first_node, place);
            let bound = if may_be_inside {
                UNLIMITED
            } else {
                params.reach
            };
            let slot = if hint >= LIST && hint != TILE_UNKNOWN {
                let first = first_candidate + (hint - LIST) / 256;
                let end = first_candidate + hint % 256;
                let candidates = &looks.candidates[first as usize..end as usize];
                nearest_of(inputs.faces, candidates, place)
            } else {
                let near = (hint != TILE_UNKNOWN).then(|| {
                    let point = nearest_on_face(&inputs.faces[hint as usize], place);
                    root(point.square)
                });
                let bound = near.map_or(bound, |near| bound.min(near));
                let slot = nearest_on(inputs.nodes, inputs.faces, pair.first_node, place, bound);
                if slot == NONE && hint != TILE_UNKNOWN {
                    hint
                } else {
                    slot
                }
            };
            if slot == NONE {
                continue;
            }
            let face = &inputs.faces[slot as usize];
            let point = nearest_on_face(face, place);
            let distance = root(point.square);
            if distance >= bound {
                continue;
            }
            let rule = constants.sign_rule;
            let candidate =
                candidate_distance(&sides, rule, pair, slot, place, &point, params.reach);
            if candidate < least {
                least = candidate;
                triangle = if distance < params.reach {
                    face.triangle
                } else {
                    NONE
                };
            }
        }
        Some((here.texel as usize, least, triangle))
    };
    let count = looks.listed.len() as u32 * TILE_SAMPLES;
    for (texel, least, triangle) in found_by(count, one) {
        distances[texel] = settled(least);
        nearest[texel] = triangle;
    }
}

/// Results of invocations for their texels, in order, computed in parallel.
pub(super) fn found_by(
    count: u32,
    one: impl Fn(u32) -> Option<(usize, f32, u32)> + Sync + Send,
) -> Vec<(usize, f32, u32)> {
    (0..count).into_par_iter().filter_map(one).collect()
}

/// The nearest of some faces.
fn nearest_of(faces: &[Face], candidates: &[u32], place: Vec3) -> u32 {
    let (mut best_square, mut best_triangle, mut best_slot) = (FAR, NONE, NONE);
    for &slot in candidates {
        let face = &faces[slot as usize];
        let square = nearest_on_face(face, place).square;
        if is_nearer(square, face.triangle, best_square, best_triangle) {
            (best_square, best_triangle, best_slot) = (square, face.triangle, slot);
        }
    }
    best_slot
}

/// A place in the space of a pair's other object.
#[must_use]
pub fn place_in_other(pair: &ObjectPair, place: Vec3) -> Vec3 {
    Vec3::from([pair.x, pair.y, pair.z].map(|row| along(row, place)))
}

/// One coordinate of a place in another space.
#[must_use]
pub fn along(row: Vec4, place: Vec3) -> f32 {
    ((row.x * place.x + row.y * place.y) + row.z * place.z) + row.w
}

/// The job that an invocation belongs to: the last one that begins at it or before.
#[must_use]
pub fn job_of(jobs: &[DistanceJob], thread: u32) -> usize {
    let (mut low, mut high) = (0, jobs.len());
    while high - low > 1 {
        let middle = (low + high) / 2;
        if jobs[middle].first_thread <= thread {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// The signed distance to an object whose nearest face is known, clamped to reach, as it is compared with that to others.
#[must_use]
pub fn clamped_distance(distance: f32, outside: bool, is_closed: bool, reach: f32) -> f32 {
    let within = distance < reach;
    let clamped = if within { distance } else { reach };
    if outside || !(within || is_closed) {
        clamped
    } else {
        -clamped
    }
}

/// Twin of `shaders/include/candidate.glsl`: `slot` is the face that is nearest to the place, and `point` the nearest
/// point on it.
pub(super) fn candidate_distance(
    sides: &Sides,
    sign_rule: u32,
    pair: &ObjectPair,
    slot: u32,
    place: Vec3,
    point: &NearestPoint,
    reach: f32,
) -> f32 {
    let tree = pair.first_node;
    let distance = root(point.square);
    let outside = distance <= slack_of(&sides.nodes[tree as usize])
        || is_outside(sides, sign_rule, tree, slot, place, point);
    clamped_distance(distance, outside, pair.is_closed == 1, reach)
}
