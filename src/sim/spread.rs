//! How the trail spreads in a step: the parameters of its two kernels.

use super::kernels::{DiffuseParams, DiffuseSeamsParams};
use super::plan::Plan;
use super::spread_length::spread_of;
use crate::mesh::atlas::{Atlas, BLOCK_QUADS, GREATEST_DENSITY, GREATEST_DIFFUSION};

/// Trail values below this become zero. Decay would turn them into denormal numbers, with which some devices are 4 to 8 times slower, and
/// no picture shows them.
pub const TINY_TRAIL: f32 = 1e-20;

/// Diffusion above the limit of the exchange tables is done in several passes of a step, an equal part of it in each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// One that only spreads: deposits, decay and the filling of gutters, which diffusion does not read, come with the last one.
    Spreading,
    /// The last pass, or the whole step.
    Last,
}

/// Rates of one pass of a diffusion step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rates {
    /// The share that is spread.
    pub diffusion: f32,
    /// Trail units a particle.
    pub deposit: f32,
    /// The share that stays.
    pub decay: f32,
}

/// The number of passes of a step.
#[must_use]
pub fn passes(plan: &Plan<'_>) -> u32 {
    let spread = spread_of(&plan.settings.trail, plan.setup.radius, &plan.setup.atlas);
    (spread / f64::from(GREATEST_DIFFUSION)).ceil().max(1.0) as u32
}

/// The rates of one pass.
#[must_use]
pub fn rate_of(plan: &Plan<'_>, pass: Pass) -> Rates {
    let trail = &plan.settings.trail;
    let spread = spread_of(trail, plan.setup.radius, &plan.setup.atlas);
    let diffusion = (spread / f64::from(passes(plan))) as f32;
    let (deposit, decay) = match pass {
        Pass::Spreading => (0.0, 1.0),
        Pass::Last => (
            plan.deposit_factor * plan.settings.physarum.deposit,
            trail.remaining(),
        ),
    };
    Rates {
        diffusion,
        deposit,
        decay,
    }
}

/// The trail's two kernels on an atlas, without deposits, decay and diffusion.
#[must_use]
pub fn spreading(atlas: &Atlas) -> (DiffuseParams, DiffuseSeamsParams) {
    let diffuse = DiffuseParams {
        lane_count: BLOCK_QUADS * atlas.blocks.len() as u32,
        quad_count: atlas.pitch * atlas.size / 4,
        quads_a_row: atlas.pitch / 4,
        diffusion: 0.0,
        most_density: GREATEST_DENSITY,
        deposit: 0.0,
        decay: 1.0,
        tiny: TINY_TRAIL,
    };
    let diffuse_seams = DiffuseSeamsParams {
        row_count: atlas.exchange.rows.len() as u32,
        reach_across: atlas.taps,
        reach_down: atlas.taps * atlas.pitch,
        diffusion: 0.0,
        deposit: 0.0,
        decay: 1.0,
        tiny: TINY_TRAIL,
    };
    (diffuse, diffuse_seams)
}
