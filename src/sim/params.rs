//! From a scene's settings to the numbers that kernels take: scene radii become world lengths, degrees become
//! cosines and sines. The twins take the same.

use super::kernels::{
    AdvanceConstants, AdvanceParams, DiffuseConstants, DiffuseParams, ExchangeSeamsParams,
};
use super::setup::Setup;
use crate::scene::settings::{Border, Settings};

/// Trail values below this become zero. Decay turns them into denormal numbers, which some devices are 4 to 8 times
/// slower with, and nobody can see them.
pub const TINY_TRAIL: f32 = 1e-20;

/// Everything that one step's kernels take besides buffers.
#[derive(Clone, Copy, Debug)]
pub struct StepParams {
    /// For `advance`.
    pub advance: AdvanceParams,
    /// For `diffuse`.
    pub diffuse: DiffuseParams,
    /// For `exchange_seams`.
    pub exchange_seams: ExchangeSeamsParams,
}

/// What is compiled into the kernels; a change makes new pipelines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepConstants {
    /// For `advance`.
    pub advance: AdvanceConstants,
    /// For `diffuse`.
    pub diffuse: DiffuseConstants,
}

impl StepConstants {
    /// The optional terms that these settings use.
    #[must_use]
    pub fn new(settings: &Settings) -> Self {
        let physarum = &settings.physarum;
        Self {
            advance: AdvanceConstants {
                sensor_noise: physarum.sensor_noise > 0.0,
                favourite_density: physarum.favourite_density > 0.0,
                gravity: physarum.gravity_weight != 0.0,
                decrowding: physarum.decrowding_weight != 0.0,
                border_reflects: physarum.border == Border::Reflect,
            },
            diffuse: DiffuseConstants {
                distance: settings.trail.diffusion_distance as i32,
            },
        }
    }
}

impl StepParams {
    /// The parameters of step number `step`, counted from 0.
    #[must_use]
    pub fn new(settings: &Settings, setup: &Setup, step: u64) -> Self {
        let physarum = &settings.physarum;
        let atlas = &setup.atlas;
        let radius = setup.radius;
        let (sensor_sin, sensor_cos) = physarum.sensor_angle.to_radians().sin_cos();
        let (rotation_sin, rotation_cos) = physarum.rotation_angle.to_radians().sin_cos();
        Self {
            advance: AdvanceParams {
                particle_count: setup.particles.len() as u32,
                seed: seed_word(settings.seed),
                // Streams repeat after 2^32 steps: over two years at 60 steps a second.
                time_step: step as u32,
                attempts: physarum.edge_crossing_attempts,
                pitch: atlas.pitch,
                speed: physarum.speed * radius,
                sensor_offset: physarum.sensor_offset * radius,
                sensor_cos,
                sensor_sin,
                rotation_cos,
                rotation_sin,
                sensor_noise: physarum.sensor_noise,
                favourite_density: physarum.favourite_density,
                gravity_weight: physarum.gravity_weight / radius,
                decrowding_weight: physarum.decrowding_weight,
            },
            diffuse: DiffuseParams {
                quad_count: atlas.pitch * atlas.size / 4,
                quads_a_row: atlas.pitch / 4,
                rows: atlas.size,
                diffusion: settings.trail.diffusion,
                deposit: physarum.deposit,
                decay: settings.trail.decay,
                tiny: TINY_TRAIL,
            },
            exchange_seams: ExchangeSeamsParams {
                seam_count: atlas.seams.len() as u32,
            },
        }
    }
}

/// The word that keys the random streams of a seed.
#[must_use]
pub fn seed_word(seed: u64) -> u32 {
    (seed ^ (seed >> 32)) as u32
}
