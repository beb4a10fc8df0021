//! How the trail spreads in a step: the parameters of its two kernels.

use super::kernels::{DiffuseParams, DiffuseSeamsParams};
use super::plan::Plan;
use crate::error::{Error, Result};
use crate::mesh::atlas::{Atlas, BLOCK_QUADS, GREATEST_DENSITY, GREATEST_DIFFUSION};
use crate::scene::parameters::grouped;
use crate::scene::settings::TrailSettings;

/// Trail values below this become zero. Decay would turn them into denormal numbers, with which some devices are 4 to 8 times slower, and
/// no picture shows them.
pub const TINY_TRAIL: f32 = 1e-20;

/// The greatest diffusion length, texels of mean area: it takes forty passes.
const GREATEST_LENGTH: f64 = 4.0;
/// The variance of the mean of nine taps along either axis, squares of their distance.
const VARIANCE: f64 = 2.0 / 3.0;

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

/// How much a step spreads, as a multiple of the mean of nine taps: 1 is that mean, and more is several of them.
fn spread_of(trail: &TrailSettings, radius: f32, atlas: &Atlas) -> f64 {
    if trail.diffusion_length <= 0.0 {
        return f64::from(trail.diffusion);
    }
    let taps = f64::from(trail.diffusion_distance);
    length_squared(trail, radius, atlas) / (VARIANCE * taps * taps)
}

/// The square of the diffusion length, texels of mean area.
fn length_squared(trail: &TrailSettings, radius: f32, atlas: &Atlas) -> f64 {
    let length = f64::from(trail.diffusion_length) * f64::from(radius);
    length * length / atlas.mean_texel_area
}

/// Checks that the trail spreads no farther in a step than it can.
///
/// # Errors
/// When the diffusion length is greater than four texels; says the greatest.
pub fn check_length(trail: &TrailSettings, radius: f32, atlas: &Atlas) -> Result<()> {
    let squared = length_squared(trail, radius, atlas);
    if squared <= GREATEST_LENGTH * GREATEST_LENGTH {
        return Ok(());
    }
    let length = f64::from(trail.diffusion_length);
    // Rounded down, so that it is not too long itself.
    let greatest = (1e6 * length * GREATEST_LENGTH / squared.sqrt()).floor() / 1e6;
    Err(Error::Invalid(format!(
        "trail.diffusion_length = {}: that is {:.1} texels, and the trail spreads by {GREATEST_LENGTH} in a step, at the most: use {greatest} or \
         less, or lower atlas.size from {}",
        trail.diffusion_length,
        squared.sqrt(),
        grouped(atlas.size.into()),
    )))
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
        reach_across: atlas.gutter,
        reach_down: atlas.gutter * atlas.pitch,
        diffusion: 0.0,
        deposit: 0.0,
        decay: 1.0,
        tiny: TINY_TRAIL,
    };
    (diffuse, diffuse_seams)
}
