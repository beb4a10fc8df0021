//! How far the trail spreads in a step, as a length on the surface.

use crate::error::{Error, Result};
use crate::mesh::atlas::{Atlas, AtlasMethod, GREATEST_DENSITY};
use crate::mesh::surface::{NONE, Surface};
use crate::scene::parameters::grouped;
use crate::scene::settings::{Settings, TrailSettings};

/// The greatest diffusion length, texels of mean area: it takes forty passes with taps one texel apart.
const GREATEST_LENGTH: f64 = 4.0;
/// The variance of the mean of nine taps along either axis, squares of their distance.
const VARIANCE: f64 = 2.0 / 3.0;
/// What settings, which have 24 bits, round off a square.
const ROUNDING: f64 = 1e-6;

/// Textures in which some triangles are stretched by more than this give a warning.
const MOST_STRETCH: f64 = 1.2;

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

/// Warnings where a diffusion length is set and the trail does not spread by it: on objects whose texels are far finer than the mean,
/// and in textures that do not keep angles.
#[must_use]
pub fn diffusion_warnings(surface: &Surface, atlas: &Atlas, settings: &Settings) -> Vec<String> {
    let objects = settings.objects.iter();
    let by_length: Vec<bool> = objects
        .map(|object| settings.trail_on(object).diffusion_length > 0.0)
        .collect();
    if !by_length.contains(&true) {
        return Vec::new();
    }
    let mut sums = vec![(0.0, 0.0); by_length.len()];
    for (&owner, &area) in atlas.owner.iter().zip(&atlas.area) {
        if owner != NONE {
            let object = surface.triangles[owner as usize].object;
            let (texels, whole) = &mut sums[object as usize];
            *texels += 1.0;
            *whole += f64::from(area);
        }
    }
    let most = f64::from(GREATEST_DENSITY);
    let objects = settings.objects.iter().zip(&by_length).zip(&sums);
    let fine = objects.filter_map(|((object, is_by_length), (texels, whole))| {
        let density = texels * atlas.mean_texel_area / whole;
        (*is_by_length && density > most).then(|| {
            format!(
                "object `{}`: its texels are {density:.1} times as fine as the mean of all, and its trail spreads only {:.0} % of the \
                 diffusion length in a step: choose texel_weight so that they are no more than {most:.1} times as fine",
                object.name,
                100.0 * (most / density).sqrt()
            )
        })
    });
    let mut warnings: Vec<String> = fine.collect();
    if atlas.method != AtlasMethod::Charts {
        let [.., stretch] = atlas.statistics(surface).stretch_percentiles;
        if stretch > MOST_STRETCH {
            warnings.push(format!(
                "some triangles are {stretch:.1} times as long in the texture for their width as they are, so that the trail spreads \
                 by other lengths than the diffusion length, and not alike in every direction: atlas.method = \"charts\" keeps angles"
            ));
        }
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use crate::scene::settings::ObjectSettings;
    use crate::sim::setup::Setup;

    fn warnings(meshes: &[&str], set: impl Fn(&mut Settings)) -> Vec<String> {
        let mut settings = Settings::default();
        settings.atlas.size = 128;
        settings.particles.count = 10;
        settings.trail.diffusion_length = 0.01;
        let objects = meshes.iter().enumerate().map(|(i, mesh)| ObjectSettings {
            mesh: format!("builtin:{mesh}"),
            position: [4.0 * i as f64, 0.0, 0.0],
            ..ObjectSettings::default()
        });
        settings.objects = objects.collect();
        set(&mut settings);
        let scene = Scene::from_settings("one".to_owned(), settings, "".into()).unwrap();
        let setup = Setup::new(&scene).unwrap();
        setup.diffusion_warnings(&scene.settings)
    }

    /// Would catch: scenes whose trail spreads less far than they say, or not alike in every direction, without a word; and warnings where
    /// it does.
    #[test]
    fn lengths_that_are_not_met_give_warnings() {
        let three = ["cube"; 3];
        assert_eq!(warnings(&three, |_| ()), [""; 0]);
        let fine = |settings: &mut Settings| settings.objects[1].texel_weight = 16.0;
        let said = warnings(&three, fine);
        assert!(
            said.len() == 1 && said[0].contains("of the diffusion length"),
            "{said:?}"
        );
        let without = |settings: &mut Settings| {
            fine(settings);
            settings.trail.diffusion_length = 0.0;
        };
        assert_eq!(warnings(&three, without), [""; 0]);
        let grid = |settings: &mut Settings| settings.atlas.method = AtlasMethod::Grid;
        let said = warnings(&["plane?columns=4&rows=16"], grid);
        assert!(
            said.len() == 1 && said[0].contains("4.0 times as long"),
            "{said:?}"
        );
        assert_eq!(warnings(&["plane?columns=4&rows=4"], grid), [""; 0]);
    }
}
