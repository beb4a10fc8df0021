//! `diffuse`: its parameters and bindings. Twin of `shaders/diffuse.comp`, a texel at a time.

use rayon::prelude::*;

use crate::mesh::atlas::BLOCK_ROWS;
use crate::sim::arrays::Arrays;
use crate::sim::kernels::{Diffuse, DiffuseArgs, DiffuseConstants, DiffuseParams};
use crate::sim::plan::Plan;
use crate::sim::spread::{Pass, RatesOfTexels, spreading, texel_objects};
use crate::sim::state::State;
use crate::sim::types::TrailRates;
use crate::sim::work::{Call, StepKernel};

impl Plan<'_> {
    /// Spreads and decays the trail.
    #[must_use]
    pub fn diffuse(&self, pass: Pass) -> Call<Diffuse> {
        let rates = self.rates_of_all(pass);
        Call {
            on: (),
            constants: DiffuseConstants {
                distance: self.setup.atlas.taps as i32,
                own_rates: self.own_rates,
                paths: self.means.paths,
            },
            params: DiffuseParams {
                diffusion: rates.diffusion,
                deposit: rates.deposit,
                decay: rates.decay,
                first_rates: self.first_rates(pass),
                ..spreading(&self.setup.atlas).0
            },
        }
    }
}

impl StepKernel for Diffuse {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> DiffuseArgs<'s> {
        DiffuseArgs {
            blocks: &s.atlas.spread.blocks,
            trail: &s.trail.front,
            deposits: &s.deposits.front,
            density: &s.atlas.spread.density,
            next_trail: &s.trail.back,
            previous_deposits: &s.deposits.back,
            objects: s.trail_objects.as_ref(),
            rates: Some(&s.objects.rates),
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let atlas = &a.setup.atlas;
        let objects = match call.constants.own_rates {
            true => texel_objects(&a.setup),
            false => Vec::new(),
        };
        diffuse(
            &call.constants,
            &call.params,
            &atlas.blocks,
            &a.trail,
            &a.deposits,
            &atlas.density,
            (&objects, &a.rates),
            &mut a.next_trail,
            &mut a.previous_deposits,
        );
    }
}

/// Spreads, deposits and decays the trail of the blocks into `next_trail`, and clears `previous_deposits`. With own rates those of each
/// texel's object, by the objects of texels and the table of rates, take the place of the parameters.
#[expect(clippy::too_many_arguments, reason = "those of the kernel")]
pub fn diffuse(
    constants: &DiffuseConstants,
    params: &DiffuseParams,
    blocks: &[u32],
    trail: &[f32],
    deposits: &[u32],
    density: &[f32],
    (objects, rates): (&[u32], &[TrailRates]),
    next_trail: &mut [f32],
    previous_deposits: &mut [u32],
) {
    let distance = constants.distance as usize;
    let last = params.quad_count - 1;
    // Quads beyond the buffer's ends are never needed; the kernel reads the first or the last one there.
    let excess = |quad: u32, lane: usize, thrice: f32| {
        let before = 4 * (quad.max(1) - 1) as usize;
        let after = 4 * (quad + 1).min(last) as usize;
        let middle = 4 * quad as usize;
        let left = if lane >= distance {
            trail[middle + lane - distance]
        } else {
            trail[before + 4 + lane - distance]
        };
        let right = if lane + distance < 4 {
            trail[middle + lane + distance]
        } else {
            trail[after + lane + distance - 4]
        };
        ((left + trail[middle + lane]) + right) - thrice
    };
    let of_texels = RatesOfTexels {
        shared: TrailRates {
            diffusion: params.diffusion,
            deposit: params.deposit,
            decay: params.decay,
            pad0: 0.0,
        },
        own: (constants.own_rates).then(|| (objects, &rates[params.first_rates as usize..])),
    };
    // Four texels side by side.
    let quad_of = |quad: u32, reach: u32| {
        let up = quad.max(reach) - reach;
        let down = (quad + reach).min(last);
        [0, 1, 2, 3].map(|lane| {
            let texel = 4 * quad as usize + lane;
            let (owned, here) = (density[texel], trail[texel]);
            let own = of_texels.at(texel);
            let thrice = 3.0 * here;
            let more = (excess(up, lane, thrice) + excess(quad, lane, thrice))
                + excess(down, lane, thrice);
            let rate = (own.diffusion * owned.min(params.most_density)) * (1.0 / 9.0);
            let spread = here + rate * more;
            let value = (spread + (own.deposit * deposits[texel] as f32) * owned) * own.decay;
            if value >= params.tiny && owned > 0.0 {
                value
            } else {
                0.0
            }
        })
    };
    // Lanes are independent.
    let one = |i: u32| {
        let reach = constants.distance as u32 * params.quads_a_row;
        let first = blocks[i as usize / 4] + i % 4;
        let quads = (0..BLOCK_ROWS).map(move |row| first + row * reach);
        let inside = quads.filter(|quad| *quad < params.quad_count);
        inside.map(move |quad| (quad, quad_of(quad, reach)))
    };
    let lanes = (0..params.lane_count).into_par_iter();
    let spread: Vec<(u32, [f32; 4])> = lanes.flat_map_iter(one).collect();
    for (quad, values) in spread {
        let texels = 4 * quad as usize..4 * quad as usize + 4;
        next_trail[texels.clone()].copy_from_slice(&values);
        previous_deposits[texels].fill(0);
    }
}
