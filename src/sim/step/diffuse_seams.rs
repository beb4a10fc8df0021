//! `diffuse_seams`: its parameters and bindings. Twin of `shaders/diffuse_seams.comp`.

use crate::mesh::atlas::{ExchangeEntry, ExchangeRow};
use crate::sim::arrays::Arrays;
use crate::sim::kernels::{
    DiffuseSeams, DiffuseSeamsArgs, DiffuseSeamsConstants, DiffuseSeamsParams,
};
use crate::sim::plan::Plan;
use crate::sim::spread::{Pass, RatesOfTexels, spreading, texel_objects};
use crate::sim::state::State;
use crate::sim::types::TrailRates;
use crate::sim::work::{Call, StepKernel};

impl Plan<'_> {
    /// The diffusion of texels beside seams.
    #[must_use]
    pub fn diffuse_seams(&self, pass: Pass) -> Call<DiffuseSeams> {
        let rates = self.rates_of_all(pass);
        Call {
            on: (),
            constants: DiffuseSeamsConstants {
                own_rates: self.own_rates,
                paths: self.means.paths,
            },
            params: DiffuseSeamsParams {
                diffusion: rates.diffusion,
                deposit: rates.deposit,
                decay: rates.decay,
                first_rates: self.first_rates(pass),
                ..spreading(&self.setup.atlas).1
            },
        }
    }
}

impl StepKernel for DiffuseSeams {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> DiffuseSeamsArgs<'s> {
        DiffuseSeamsArgs {
            rows: &s.atlas.spread.rows,
            entries: &s.atlas.spread.entries,
            trail: &s.trail.front,
            deposits: &s.deposits.front,
            next_trail: &s.trail.back,
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
        diffuse_seams(
            &call.constants,
            &call.params,
            &atlas.exchange.rows,
            &atlas.exchange.entries,
            &a.trail,
            &a.deposits,
            &atlas.density,
            (&objects, &a.rates),
            &mut a.next_trail,
        );
    }
}

/// Spreads, deposits and decays the trail of the texels of `rows` into `next_trail`, by rates as [`diffuse`](super::diffuse::diffuse).
#[expect(clippy::too_many_arguments, reason = "those of the kernel")]
pub fn diffuse_seams(
    constants: &DiffuseSeamsConstants,
    params: &DiffuseSeamsParams,
    rows: &[ExchangeRow],
    entries: &[ExchangeEntry],
    trail: &[f32],
    deposits: &[u32],
    density: &[f32],
    (objects, rates): (&[u32], &[TrailRates]),
    next_trail: &mut [f32],
) {
    let offsets =
        ExchangeRow::neighbours(params.reach_down / params.reach_across, params.reach_across);
    let of_texels = RatesOfTexels {
        shared: TrailRates {
            diffusion: params.diffusion,
            deposit: params.deposit,
            decay: params.decay,
            pad0: 0.0,
        },
        own: (constants.own_rates).then(|| (objects, &rates[params.first_rates as usize..])),
    };
    for row in &rows[..params.row_count as usize] {
        let texel = row.texel as usize;
        let here = trail[texel];
        let mut inside = 0.0;
        for (bit, offset) in offsets.iter().enumerate() {
            if row.mask() >> bit & 1 == 1 {
                inside += trail[(texel as i64 + offset) as usize] - here;
            }
        }
        let mut next = row.first as usize;
        let mut end = next + row.pair_count as usize;
        let mut across = 0.0;
        for pair in &entries[next..end] {
            across += pair.weight * (trail[pair.texel as usize] - here);
        }
        next = end;
        end += row.deposit_count() as usize;
        let mut counted = deposits[texel] as f32;
        for part in &entries[next..end] {
            counted += part.weight * deposits[part.texel as usize] as f32;
        }
        let own = density[texel];
        let of = of_texels.at(texel);
        let spread = here + (of.diffusion * own) * (row.conductance * inside + across);
        let value = (spread + (of.deposit * counted) * own) * of.decay;
        next_trail[texel] = if value >= params.tiny { value } else { 0.0 };
    }
}
