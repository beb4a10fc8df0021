//! How far the trail spreads in a step, as a length on the surface.

use crate::error::{Error, Result};
use crate::mesh::atlas::Atlas;
use crate::scene::parameters::grouped;
use crate::scene::settings::{Settings, TrailSettings};

/// The greatest diffusion length, texels of mean area: it takes forty passes with taps one texel apart.
const GREATEST_LENGTH: f64 = 4.0;
/// The variance of the mean of nine taps along either axis, squares of their distance.
const VARIANCE: f64 = 2.0 / 3.0;
/// What settings, which have 24 bits, round off a square.
const ROUNDING: f64 = 1e-6;

/// How much a step spreads, as a multiple of the mean of nine taps: 1 is that mean, and more is several of them.
#[must_use]
pub fn spread_of(trail: &TrailSettings, radius: f32, atlas: &Atlas) -> f64 {
    if trail.diffusion_length <= 0.0 {
        return f64::from(trail.diffusion);
    }
    let taps = f64::from(atlas.taps);
    // Rounding may bring the greatest length a little beyond itself, which would take a pass more.
    let squared = length_squared(trail, radius, atlas).min(GREATEST_LENGTH * GREATEST_LENGTH);
    squared / (VARIANCE * taps * taps)
}

/// The square of the diffusion length, texels of mean area.
fn length_squared(trail: &TrailSettings, radius: f32, atlas: &Atlas) -> f64 {
    let length = f64::from(trail.diffusion_length) * f64::from(radius);
    length * length / atlas.mean_texel_area
}

/// Checks that the trail spreads no farther in a step than it can, on any object.
///
/// # Errors
/// When a diffusion length is greater than four texels; says the greatest.
pub fn check_lengths(settings: &Settings, radius: f32, atlas: &Atlas) -> Result<()> {
    check("", &settings.trail, radius, atlas)?;
    for (i, object) in settings.objects.iter().enumerate() {
        if object.trail.diffusion_length.is_some() {
            let trail = settings.trail_on(object);
            check(&format!("object.{i}."), &trail, radius, atlas)?;
        }
    }
    Ok(())
}

fn check(prefix: &str, trail: &TrailSettings, radius: f32, atlas: &Atlas) -> Result<()> {
    let squared = length_squared(trail, radius, atlas);
    if squared <= GREATEST_LENGTH * GREATEST_LENGTH * (1.0 + ROUNDING) {
        return Ok(());
    }
    let length = f64::from(trail.diffusion_length);
    // Rounded down, so that it is not too long itself.
    let greatest = (1e6 * length * GREATEST_LENGTH / squared.sqrt()).floor() / 1e6;
    Err(Error::Invalid(format!(
        "{prefix}trail.diffusion_length = {}: that is {:.1} texels, and the trail spreads by {GREATEST_LENGTH} in a step, at the most: use \
         {greatest} or less, or lower atlas.size from {}",
        trail.diffusion_length,
        squared.sqrt(),
        grouped(atlas.size.into()),
    )))
}
