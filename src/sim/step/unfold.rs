//! `unfold`: its parameters and bindings. Twin of `shaders/unfold.comp`.

use glam::{Vec2, Vec3};

use super::distance::{job_of, place_in_other};
use crate::mesh::surface::{AtlasMap, HalfEdge, NONE};
use crate::scene::settings::DistanceMethod;
use crate::sim::arrays::Arrays;
use crate::sim::direction::flat_direction;
use crate::sim::distance::TILE_SAMPLES;
use crate::sim::field::{atlas_position, packed_position};
use crate::sim::ground::{Ground, nearest_weights};
use crate::sim::kernels::{Unfold, UnfoldArgs, UnfoldConstants, UnfoldParams};
use crate::sim::plan::Plan;
use crate::sim::state::State;
use crate::sim::surroundings::{COVERED, MARKS, marks_at};
use crate::sim::types::{DistanceJob, ListedTile, ObjectPair, SurfaceSample, Walker};
use crate::sim::walker::walk;
use crate::sim::work::{Call, StepKernel};
use crate::strict::{cross3, dot2, dot3, length3, positive, reciprocal, root};

impl Plan<'_> {
    /// Finds where walks continue on other objects.
    pub fn unfold(&self) -> Call<Unfold> {
        let lengths = self.lengths;
        Call {
            on: (),
            constants: UnfoldConstants {
                border_reflects: self.border_reflects(),
                listed: self.settings.distance.method == DistanceMethod::Bvh,
            },
            params: UnfoldParams {
                thread_count: self.distances.thread_count,
                job_count: self.distances.jobs.len() as u32,
                pitch: self.setup.atlas.pitch,
                attempts: self.most_attempts(),
                threshold: lengths.threshold,
                farthest: lengths.farthest,
                deepest: lengths.deepest,
                near: lengths.near,
                sight: lengths.sight,
            },
        }
    }
}

impl StepKernel for Unfold {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> UnfoldArgs<'s> {
        UnfoldArgs {
            jobs: &s.near.jobs,
            pairs: &s.near.pairs.texels,
            samples: &s.near.samples.texels,
            owners: &s.near.owners,
            distances: &s.near.distances.texels,
            nearest: &s.near.nearest.texels,
            triangles: &s.surface.triangles,
            halfedges: &s.surface.halfedges,
            corners: &s.surface.corners,
            vertices: &s.surface.vertices,
            strips: &s.surface.strips,
            across: &s.across.places,
            surroundings: &s.across.surroundings,
            across_triangles: &s.across.triangles,
            listed: &s.near.listed.texels,
            groups: &s.near.covered_groups,
            covered: &s.near.covered.texels,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let inputs = UnfoldInputs {
            jobs: &a.jobs,
            pairs: &a.pairs,
            samples: &a.setup.distance.samples,
            owners: &a.setup.distance.owners,
            distances: &a.distances,
            nearest: &a.nearest,
            halfedges: &a.setup.surface.halfedges,
            ground: Ground::of(&a.setup, &a.poses),
            atlas_maps: &a.setup.atlas.maps,
            listed: &a.looks.listed,
        };
        unfold(
            &call.constants,
            &call.params,
            &inputs,
            &mut a.across,
            &mut a.across_triangles,
            &mut a.surroundings,
        );
    }
}

/// Planes that meet at a smaller sine than this meet far away, or nowhere.
const LEAST_SINE: f32 = 0.02;

/// Inputs of `unfold`.
#[derive(Clone, Copy)]
pub struct UnfoldInputs<'a> {
    /// Objects whose distances were computed.
    pub jobs: &'a [DistanceJob],
    /// The other objects within reach of each of them.
    pub pairs: &'a [ObjectPair],
    /// Surface points under texels.
    pub samples: &'a [SurfaceSample],
    /// The triangle of each.
    pub owners: &'a [u32],
    /// Signed distance to other objects.
    pub distances: &'a [f32],
    /// The nearest triangle of another object.
    pub nearest: &'a [u32],
    /// Crossings.
    pub halfedges: &'a [HalfEdge],
    /// The surface; poses do not matter.
    pub ground: Ground<'a>,
    /// Triangle to atlas.
    pub atlas_maps: &'a [AtlasMap],
    /// The searched tiles, if distances are computed tile by tile.
    pub listed: &'a [ListedTile],
}

/// Marks texels near other objects, and finds for covered ones the place on the other object where walks continue.
pub fn unfold(
    constants: &UnfoldConstants,
    params: &UnfoldParams,
    inputs: &UnfoldInputs,
    across: &mut [u32],
    across_triangles: &mut [u32],
    surroundings: &mut [u16],
) {
    let count = if constants.listed {
        inputs.listed.len() as u32 * TILE_SAMPLES
    } else {
        params.thread_count
    };
    for i in 0..count {
        let (pairs, sample) = if constants.listed {
            let tile = inputs.listed[(i / TILE_SAMPLES) as usize];
            if i % TILE_SAMPLES >= tile.sample_count {
                continue;
            }
            let pairs = (tile.first_pair, tile.pair_count);
            (pairs, tile.first_sample + i % TILE_SAMPLES)
        } else {
            let job = inputs.jobs[job_of(&inputs.jobs[..params.job_count as usize], i)];
            if i - job.first_thread >= job.sample_count {
                continue;
            }
            let pairs = (job.first_pair, job.pair_count);
            (pairs, job.first_sample + (i - job.first_thread))
        };
        let sample = sample as usize;
        let SurfaceSample { position, texel } = inputs.samples[sample];
        // On the device, `distance` marks texels if covered ones are listed.
        let marked = marks_at(inputs.distances[texel as usize], params);
        let around = &mut surroundings[texel as usize];
        *around = *around & !MARKS | marked;
        if marked & COVERED == 0 {
            continue;
        }
        let triangle = inputs.nearest[texel as usize];
        let (first, count) = (pairs.0 as usize, pairs.1 as usize);
        let (last, others) = inputs.pairs[first..first + count]
            .split_last()
            .expect("what is covered has another object");
        let pair = others
            .iter()
            .find(|pair| triangle.wrapping_sub(pair.first_face) < pair.face_count)
            .unwrap_or(last);
        let own_triangle = inputs.owners[sample];
        let [place, on] = place_across(
            constants,
            params,
            inputs,
            pair,
            position,
            own_triangle,
            triangle,
        );
        across[texel as usize] = place;
        across_triangles[texel as usize] = on;
    }
}

fn place_across(
    constants: &UnfoldConstants,
    params: &UnfoldParams,
    inputs: &UnfoldInputs,
    pair: &ObjectPair,
    position: Vec3,
    own_triangle: u32,
    triangle: u32,
) -> [u32; 2] {
    let ground = &inputs.ground;
    let shape = &ground.triangles[triangle as usize];
    let frame = ground.frame(triangle);
    let place = place_in_other(pair, position) - frame.origin;
    let normal = ground.frame(own_triangle).normal;
    let own_normal = Vec3::from([pair.x, pair.y, pair.z].map(|row| dot3(row.truncate(), normal)));
    let cosine = dot3(own_normal, frame.normal);
    let sine = length3(cross3(own_normal, frame.normal));
    let depth = positive(-dot3(place, frame.normal));
    if sine < LEAST_SINE || depth > params.farthest * sine {
        return [NONE; 2];
    }
    let by_sine = reciprocal(sine);
    let behind = depth * by_sine;
    let to_line = (behind * by_sine) * (frame.normal - cosine * own_normal);
    let up = by_sine * (own_normal - cosine * frame.normal);
    let [u, v] = nearest_weights(shape, dot3(place, frame.p), dot3(place, frame.h));
    let way = to_line + behind * up;
    let flat_way = Vec2::new(dot3(way, frame.p), dot3(way, frame.h));
    let distance = root(dot2(flat_way, flat_way));
    let heading = flat_direction(flat_way);
    let mut w = Walker::at(triangle, u, v, heading.to_array(), distance);
    let reflects = constants.border_reflects;
    walk::<false>(
        ground.triangles,
        inputs.halfedges,
        &mut w,
        params.attempts,
        reflects,
    );
    let [u, v] = w.uv();
    let position = atlas_position(&inputs.atlas_maps[w.triangle as usize], u, v);
    [packed_position(position, params.pitch), w.triangle]
}
