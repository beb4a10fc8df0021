//! The kernels that let particles leave and land: their parameters, bindings and twins.

use crate::mesh::surface::{AtlasMap, NONE};
use crate::mesh::trees::search::{UNLIMITED, nearest_on};
use crate::mesh::trees::sides::Sides;
use crate::sim::arrays::Arrays;
use crate::sim::crossing::Terrain;
use crate::sim::field::{atlas_position, texel_at};
use crate::sim::ground::{Flight, Ground};
use crate::sim::kernels::{
    TransferIn, TransferInArgs, TransferInConstants, TransferInParams, TransferOut,
    TransferOutArgs, TransferOutConstants, TransferOutParams,
};
use crate::sim::looks::between;
use crate::sim::paint::NO_GO_BELOW;
use crate::sim::plan::Plan;
use crate::sim::state::State;
use crate::sim::types::{Border, Flow, Motion, Particle, Physarum, Pose, Transfer};
use crate::sim::walker::WALK_OUT_OF_ATTEMPTS;
use crate::sim::work::{Call, StepKernel};
use crate::strict::{positive, settled};

impl Plan<'_> {
    /// Lets particles that have left land.
    #[must_use]
    pub fn transfer_in(&self) -> Call<TransferIn> {
        Call {
            on: (),
            constants: TransferInConstants {
                windows: self.strategy.has_windows(),
            },
            params: TransferInParams {
                capacity: self.means.capacity,
            },
        }
    }

    /// Lets selected particles leave.
    pub fn transfer_out(&self) -> Call<TransferOut> {
        Call {
            on: (),
            constants: TransferOutConstants {
                border_reflects: self.border_reflects(),
                sign_rule: self.settings.distance.sign as u32,
                own_physarum: self.own_physarum,
                painted: self.means.painted,
                looks: self.has_looks(),
                paths: self.means.paths,
            },
            params: TransferOutParams {
                capacity: self.means.capacity,
                pitch: self.setup.atlas.pitch,
                object_count: self.object_count(),
                attempts: self.settings.physarum.edge_crossing_attempts,
                first_vertex_normal: self.first_vertex_normal(),
                second_look: self.object_count(),
            },
        }
    }
}

impl StepKernel for TransferIn {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> TransferInArgs<'s> {
        TransferInArgs {
            transfers: &s.transfers.transfers,
            borders: &s.transfers.borders,
            flow: &s.transfers.flow,
            particles: &s.particles.texels,
            motions: &s.motions.texels,
            triangles: &s.surface.triangles,
            corners: &s.surface.corners,
            vertices: &s.surface.vertices,
            poses: &s.objects.poses.texels,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let t = &mut a.transfers;
        transfer_in(
            &call.constants,
            &call.params,
            &Ground::of(&a.setup, &a.poses),
            &t.transfers,
            &mut t.borders,
            &mut t.flow[0],
            (&mut a.particles, &mut a.motions),
        );
    }
}

impl StepKernel for TransferOut {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> TransferOutArgs<'s> {
        TransferOutArgs {
            flow: &s.transfers.flow,
            particle_indices: &s.transfers.particle_indices,
            particles: &s.particles.texels,
            motions: &s.motions.texels,
            nearest: &s.near.nearest.texels,
            strips: &s.surface.strips,
            transfers: &s.transfers.transfers,
            flux: &s.transfers.flux,
            triangles: &s.surface.triangles,
            halfedges: &s.surface.halfedges,
            corners: &s.surface.corners,
            vertices: &s.surface.vertices,
            poses: &s.objects.poses.texels,
            physarums: &s.objects.physarums,
            roots: &s.trees.roots,
            nodes: &s.trees.nodes,
            faces: &s.trees.faces,
            pseudonormals: &s.trees.pseudonormals,
            dipoles: &s.trees.dipoles,
            poses_before: &s.objects.poses_before.texels,
            bias: s.bias.as_ref(),
            looks: s.looks.as_ref(),
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let constants = &call.constants;
        let roots = a.setup.distance.roots();
        let t = &mut a.transfers;
        transfer_out(
            constants,
            &call.params,
            &Terrain::of(
                &a.setup,
                &a.poses,
                &roots,
                constants.sign_rule,
                constants.border_reflects,
            ),
            &a.poses_before,
            &mut t.flow[0],
            &t.particle_indices,
            &a.particles,
            &a.motions,
            &a.physarums,
            &a.nearest,
            &a.setup.atlas.maps,
            (&a.bias, &a.weights),
            &mut t.transfers,
            &mut t.flux,
        );
    }
}

/// Twin of `shaders/transfer_in.comp`.
pub fn transfer_in(
    constants: &TransferInConstants,
    params: &TransferInParams,
    ground: &Ground,
    transfers: &[Transfer],
    borders: &mut [Border],
    flow: &mut Flow,
    (particles, motions): (&mut [Particle], &mut [Motion]),
) {
    for transfer in &transfers[..flow.leaving.min(params.capacity) as usize] {
        if constants.windows && transfer.source != transfer.target {
            borders[transfer.source as usize].left += 1;
            borders[transfer.target as usize].came += 1;
        }
        flow.arrived = flow.arrived.saturating_add(1);
        if transfer.stays == 1 {
            continue;
        }
        let slot = transfer.particle as usize;
        ground.land(transfer, &mut particles[slot], &mut motions[slot]);
    }
}

/// Twin of `shaders/transfer_out.comp`.
#[expect(clippy::too_many_arguments, reason = "those of the kernel")]
pub fn transfer_out(
    constants: &TransferOutConstants,
    params: &TransferOutParams,
    terrain: &Terrain,
    poses_before: &[Pose],
    flow: &mut Flow,
    particle_indices: &[u32],
    particles: &[Particle],
    motions: &[Motion],
    physarums: &[Physarum],
    nearest: &[u32],
    atlas_maps: &[AtlasMap],
    (bias, looks): (&[f32], &[f32]),
    transfers: &mut [Transfer],
    flux: &mut [u32],
) {
    let ground = &terrain.ground;
    for i in 0..flow.leaving.min(params.capacity) {
        let slot = particle_indices[i as usize];
        let particle = &particles[slot as usize];
        let motion = &motions[slot as usize];
        let source = ground.triangles[particle.triangle as usize].object;
        let map = &atlas_maps[particle.triangle as usize];
        let here = atlas_position(map, particle.u, particle.v);
        let near = nearest_triangle(nearest, here, params.pitch);
        let mut triangle = if near == NONE {
            particle.triangle
        } else {
            near
        };
        let mut target = ground.triangles[triangle as usize].object;
        let from = ground.flight(particle, motion);
        let mut flight = from;
        let mut left = 0.0;
        let mut crosses = false;
        if near != NONE {
            let own = |object: u32| {
                let row = if constants.own_physarum { object } else { 0 };
                physarums[row as usize]
            };
            let attempts_on = |object: u32| match constants.own_physarum {
                true => own(object).attempts,
                false => params.attempts,
            };
            let mut speed = own(source).speed;
            if constants.looks {
                let second = physarums[params.second_look as usize].speed;
                let weight = looks[texel_at(here, params.pitch) as usize];
                speed = between(speed, second, weight);
            }
            let way = positive(speed - motion.pending);
            let met = terrain.meeting_behind(
                poses_before,
                particle,
                motion,
                [source, target],
                way,
                attempts_on(source),
            );
            if let Some((meeting, rest)) = met {
                let attempts = attempts_on(target);
                let w = terrain.walker_on_target(&meeting, source, rest, attempts);
                triangle = w.triangle;
                if w.status == WALK_OUT_OF_ATTEMPTS {
                    left = w.remaining;
                }
                crosses = true;
                flight = terrain.flight_of_walker(&w);
            } else {
                let Sides { nodes, faces, .. } = terrain.sides;
                let place = ground.place_in(target, flight.position);
                let root = terrain.roots[target as usize];
                let face = nearest_on(nodes, faces, root, place, UNLIMITED);
                // As in the kernel for a search that has not ended.
                if face != NONE {
                    triangle = faces[face as usize].triangle;
                }
            }
        }
        let is_no_go = |triangle: u32, [u, v]: [f32; 2]| {
            let position = atlas_position(&atlas_maps[triangle as usize], u, v);
            bias[texel_at(position, params.pitch) as usize] < NO_GO_BELOW
        };
        if constants.painted
            && target != source
            && !is_no_go(particle.triangle, [particle.u, particle.v])
            && is_no_go(triangle, ground.landing(triangle, &flight).0)
        {
            triangle = particle.triangle;
            target = source;
            flight = Flight {
                heading: -from.heading,
                ..from
            };
            left = 0.0;
            crosses = false;
        }
        flow.crossed = flow.crossed.saturating_add(u32::from(crosses));
        let flight = flight.settled();
        transfers[i as usize] = Transfer {
            position: flight.position,
            particle: slot,
            heading: flight.heading,
            source,
            normal: flight.normal,
            target,
            triangle,
            rest: settled(left),
            stays: 2 * u32::from(crosses),
            ..Transfer::default()
        };
        let left = &mut flux[(source * params.object_count + target) as usize];
        *left = left.saturating_add(1);
    }
}

/// The nearest triangle of the texel with the largest weight among the four around that have one.
fn nearest_triangle(nearest: &[u32], position: [f32; 2], pitch: u32) -> u32 {
    let corner = position.map(|x| x - 0.5);
    let low = corner.map(f32::floor);
    let f = [corner[0] - low[0], corner[1] - low[1]];
    let rest = f.map(|x| 1.0 - x);
    let texel = low[1] as u32 * pitch + low[0] as u32;
    let (mut found, mut most) = (NONE, -1.0);
    for k in 0..4 {
        let (right, below) = (k & 1 != 0, k & 2 != 0);
        let place = texel + u32::from(right) + if below { pitch } else { 0 };
        let near = nearest[place as usize];
        let weight = if right { f[0] } else { rest[0] } * if below { f[1] } else { rest[1] };
        if near != NONE && weight > most {
            (found, most) = (near, weight);
        }
    }
    found
}
