//! `scent_across`: its parameters and bindings. Twin of `shaders/scent_across.comp`.

use glam::Vec3;

use crate::mesh::surface::{AtlasMap, NONE};
use crate::sim::arrays::Arrays;
use crate::sim::field::{atlas_position, trail_at};
use crate::sim::ground::{Ground, nearest_weights, place_in};
use crate::sim::kernels::{ScentAcross, ScentAcrossArgs, ScentAcrossConstants, ScentAcrossParams};
use crate::sim::plan::Plan;
use crate::sim::state::State;
use crate::sim::types::SurfaceSample;
use crate::sim::work::{Call, StepKernel};
use crate::strict::{dot3, positive, settled};

impl Plan<'_> {
    /// Sums up what sensors read where scents cross contacts.
    #[must_use]
    pub fn scent_across(&self) -> Call<ScentAcross> {
        let reach = self.lengths.reach;
        Call {
            on: (),
            constants: ScentAcrossConstants {
                paths: self.means.paths,
            },
            params: ScentAcrossParams {
                sample_count: self.samples().0,
                pitch: self.setup.atlas.pitch,
                share: self.settings.feeding.scent_across,
                by_reach: if reach > 0.0 { 1.0 / reach } else { 0.0 },
            },
        }
    }
}

impl StepKernel for ScentAcross {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> ScentAcrossArgs<'s> {
        let food = s.food();
        ScentAcrossArgs {
            samples: &s.near.samples.texels,
            owners: &s.near.owners,
            distances: &s.near.distances.texels,
            nearest: &s.near.nearest.texels,
            triangles: &s.surface.triangles,
            corners: &s.surface.corners,
            vertices: &s.surface.vertices,
            strips: &s.surface.strips,
            poses: &s.objects.poses.texels,
            scent: &food.scent,
            around: food.around(),
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let setup = &a.setup;
        let inputs = ScentAcrossInputs {
            samples: &setup.distance.samples,
            owners: &setup.distance.owners,
            distances: &a.distances,
            nearest: &a.nearest,
            ground: Ground::of(setup, &a.poses),
            atlas_maps: &setup.atlas.maps,
            scent: &a.scent,
        };
        scent_across(&call.params, &inputs, &mut a.around);
    }
}

/// Inputs of `scent_across`.
#[derive(Clone, Copy)]
pub struct ScentAcrossInputs<'a> {
    /// Surface points under texels.
    pub samples: &'a [SurfaceSample],
    /// The triangle of each.
    pub owners: &'a [u32],
    /// Signed distance to other objects.
    pub distances: &'a [f32],
    /// The nearest triangle of another object.
    pub nearest: &'a [u32],
    /// The surface and the poses.
    pub ground: Ground<'a>,
    /// Triangle to atlas.
    pub atlas_maps: &'a [AtlasMap],
    /// The scents of each object's own food.
    pub scent: &'a [f32],
}

/// Sums up each texel's own scent, and a share of that at the nearest place of another object.
pub fn scent_across(
    params: &ScentAcrossParams,
    inputs: &ScentAcrossInputs<'_>,
    around: &mut [f32],
) {
    let count = params.sample_count as usize;
    let samples = inputs.samples[..count].iter().zip(inputs.owners);
    for (here, &owner) in samples {
        let texel = here.texel as usize;
        let triangle = inputs.nearest[texel];
        let across = if triangle == NONE {
            0.0
        } else {
            let smelled = scent_near(params, inputs, triangle, owner, here.position);
            let near = positive(1.0 - inputs.distances[texel].abs() * params.by_reach);
            settled((params.share * (near * near)) * smelled)
        };
        around[texel] = inputs.scent[texel] + across;
    }
}

/// The scent on a triangle at the point that is nearest to a place on another one, which is in the space of its object.
fn scent_near(
    params: &ScentAcrossParams,
    inputs: &ScentAcrossInputs<'_>,
    triangle: u32,
    owner: u32,
    position: Vec3,
) -> f32 {
    let ground = &inputs.ground;
    let shape = &ground.triangles[triangle as usize];
    let frame = ground.frame(triangle);
    let [other, own] = [shape, &ground.triangles[owner as usize]]
        .map(|triangle| &ground.poses[triangle.object as usize]);
    let way = place_in(other, own, position) - frame.origin;
    let [u, v] = nearest_weights(shape, dot3(way, frame.p), dot3(way, frame.h));
    let position = atlas_position(&inputs.atlas_maps[triangle as usize], u, v);
    trail_at(inputs.scent, position, params.pitch)
}
