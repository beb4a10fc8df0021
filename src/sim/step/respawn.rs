//! `respawn`: its parameters and bindings. Twin of `shaders/respawn.comp`.

use crate::mesh::surface::Triangle;
use crate::rng::{Purpose, random, seed_word, unit};
use crate::sim::arrays::Arrays;
use crate::sim::kernels::{Respawn, RespawnArgs, RespawnConstants, RespawnParams};
use crate::sim::plan::Plan;
use crate::sim::restarts::Restarts;
use crate::sim::state::State;
use crate::sim::types::{Flow, Motion, Particle};
use crate::sim::work::{Call, StepKernel};
use crate::strict::turn_of;

impl Plan<'_> {
    /// Lets particles restart.
    #[must_use]
    pub fn respawn(&self) -> Call<Respawn> {
        Call {
            on: (),
            constants: RespawnConstants {
                from_start: self.settings.restarts_by_rule(),
            },
            params: RespawnParams {
                capacity: self.means.capacity,
                seed: seed_word(self.settings.seed),
                time_step: self.time_step(),
            },
        }
    }
}

impl StepKernel for Respawn {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> RespawnArgs<'s> {
        RespawnArgs {
            flow: &s.transfers.flow,
            particle_indices: &s.transfers.particle_indices,
            particles: &s.particles.texels,
            motions: &s.motions.texels,
            triangles: &s.surface.triangles,
            area_shares: &s.transfers.area_shares,
            object_triangles: &s.transfers.object_triangles,
            restarts: &s.transfers.restarts,
            restart_ranges: &s.transfers.restart_ranges,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let transfers = &mut a.transfers;
        respawn(
            &call.constants,
            &call.params,
            &mut transfers.flow[0],
            &transfers.particle_indices,
            &mut a.particles,
            &mut a.motions,
            &a.setup.surface.triangles,
            &transfers.area_shares,
            &transfers.object_triangles,
            &transfers.restarts,
        );
    }
}

/// Lets selected particles restart on their own object.
#[expect(clippy::too_many_arguments, reason = "those of the kernel")]
pub fn respawn(
    constants: &RespawnConstants,
    params: &RespawnParams,
    flow: &mut Flow,
    particle_indices: &[u32],
    particles: &mut [Particle],
    motions: &mut [Motion],
    triangles: &[Triangle],
    area_shares: &[u32],
    object_triangles: &[glam::UVec2],
    restarts: &Restarts,
) {
    for &slot in &particle_indices[..flow.leaving.min(params.capacity) as usize] {
        flow.arrived = flow.arrived.saturating_add(1);
        let particle = &mut particles[slot as usize];
        let words = random(params.seed, particle.id, params.time_step, Purpose::Respawn);
        let object = triangles[particle.triangle as usize].object as usize;
        let motion = &mut motions[slot as usize];
        let flags = motion.flags & !Motion::SELECTED;
        if constants.from_start {
            let places = restarts.ranges[object];
            if places.x < places.y {
                let place = 2 * (places.x + words[0] % (places.y - places.x)) as usize;
                let [start, heading] = [restarts.places[place], restarts.places[place + 1]];
                *particle = Particle {
                    triangle: start.x,
                    u: f32::from_bits(start.y),
                    v: f32::from_bits(start.z),
                    id: particle.id,
                };
                *motion = Motion {
                    heading_p: f32::from_bits(heading.x),
                    heading_h: f32::from_bits(heading.y),
                    pending: 0.0,
                    flags,
                };
                continue;
            }
        }
        let range = object_triangles[object];
        let last = range.y - 1;
        let shares = &area_shares[range.x as usize..last as usize];
        let (u, v) = (unit(words[1]), unit(words[2]));
        let beyond = u + v > 1.0;
        *particle = Particle {
            triangle: range.x + shares.partition_point(|&share| share <= words[0]) as u32,
            u: if beyond { 1.0 - u } else { u },
            v: if beyond { 1.0 - v } else { v },
            id: particle.id,
        };
        let heading = turn_of(words[3]);
        *motion = Motion {
            heading_p: heading.x,
            heading_h: heading.y,
            pending: 0.0,
            flags,
        };
    }
}
