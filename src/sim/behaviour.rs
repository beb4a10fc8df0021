//! Parameters of particles for kernels: a table with one row per object, and one for the second look.

use super::physarum::Physarum;
use super::setup::Setup;
use crate::scene::settings::{ObjectSettings, PhysarumSettings, Settings, TrailSettings};

/// The largest parameter in trail units, as scene files allow.
const MOST_TRAIL_UNITS: f32 = 1e6;

/// Parameters of particles on each object: the scene's values, overridden by the object's own; then those of the second look, or the
/// scene's if there is none.
#[must_use]
pub fn physarums(settings: &Settings, setup: &Setup) -> Vec<Physarum> {
    let objects = settings.objects.iter();
    let factor = deposit_factor(settings, setup);
    objects
        .map(|object| {
            let physarum = object.physarum.over(&settings.physarum);
            Physarum::of(&physarum, setup.radius, factor)
        })
        .chain([second(settings, setup)])
        .collect()
}

/// The row of the second look. Trails keep the units of the scene's look, so what it has in trail units is scaled by the means of both.
fn second(settings: &Settings, setup: &Setup) -> Physarum {
    let Some(look) = settings.second_look.look() else {
        let factor = deposit_factor(settings, setup);
        return Physarum::of(&settings.physarum, setup.radius, factor);
    };
    let mean = |physarum: &PhysarumSettings, trail: &TrailSettings| {
        let decay = f64::from(trail.remaining()).clamp(0.0, 0.999);
        let factor = f64::from(factor_of(physarum, setup));
        factor * f64::from(physarum.deposit) * (decay / (1.0 - decay)).max(0.01)
    };
    let (here, there) = (
        mean(&settings.physarum, &settings.trail),
        mean(&look.physarum, &look.trail),
    );
    let scale = if there > 0.0 {
        (here / there) as f32
    } else {
        1.0
    };
    let scaled = |value: f32| (scale * value).clamp(-MOST_TRAIL_UNITS, MOST_TRAIL_UNITS);
    let mut physarum = look.physarum.clone();
    for value in [
        &mut physarum.sensor_noise,
        &mut physarum.favourite_density,
        &mut physarum.gravity_weight,
        &mut physarum.decrowding_weight,
        &mut physarum.distance_weight,
    ] {
        *value = scaled(*value);
    }
    Physarum::of(&physarum, setup.radius, factor_of(&look.physarum, setup))
}

/// Factor on deposits and decrowding weights. If the settings name the density that they were made for, this factor keeps the mean of the
/// trail at its value for that density, for any number of particles and any size of the texture. It is 1 where the number of particles
/// changes.
#[must_use]
pub fn deposit_factor(settings: &Settings, setup: &Setup) -> f32 {
    factor_of(&settings.physarum, setup)
}

/// How much trail so many particles leave in a step, spread evenly over all objects, in the mean over the surface.
#[must_use]
pub fn mean_deposit(settings: &Settings, setup: &Setup, particles: u32) -> f64 {
    let deposit = deposits(settings, setup, particles);
    mean_over_surface(settings, setup, deposit)
}

/// The mean over the surface of the trail once it grows no more, if so many particles are spread evenly over all objects, each of them
/// leaves its deposit in every step, and what is left on an object decays as it does there. It is infinite if none of that decays.
#[must_use]
pub fn mean_trail(settings: &Settings, setup: &Setup, particles: u32) -> f64 {
    let deposit = deposits(settings, setup, particles);
    mean_over_surface(settings, setup, |object| {
        let left = deposit(object);
        let decay = f64::from(settings.trail_on(object).remaining());
        // Without deposits there is no trail, also where it would last.
        if left > 0.0 {
            left * decay / (1.0 - decay)
        } else {
            0.0
        }
    })
}

/// What is left on an object in a step, as a mean over its surface.
fn deposits(settings: &Settings, setup: &Setup, particles: u32) -> impl Fn(&ObjectSettings) -> f64 {
    let density = f64::from(particles) / f64::from(setup.atlas.owned_count.max(1));
    let factor = density * f64::from(deposit_factor(settings, setup));
    move |object| factor * f64::from(settings.deposit_on(object))
}

fn mean_over_surface(
    settings: &Settings,
    setup: &Setup,
    value: impl Fn(&ObjectSettings) -> f64,
) -> f64 {
    let (mut sum, mut all) = (0.0, 0.0);
    for (object, &area) in settings.objects.iter().zip(&setup.object_areas) {
        // Zero times an infinite value would be no number.
        if area > 0.0 {
            sum += area * value(object);
            all += area;
        }
    }
    if all > 0.0 { sum / all } else { 0.0 }
}

fn factor_of(physarum: &PhysarumSettings, setup: &Setup) -> f32 {
    let reference = physarum.reference_density;
    let count = setup.particles.len();
    if reference == 0.0 || count == 0 || setup.population.is_some() {
        return 1.0;
    }
    (f64::from(reference) * f64::from(setup.atlas.owned_count) / count as f64) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Overrides, Scene};
    use crate::sim::plan::{Means, Plan};
    use crate::sim::spread::Pass;

    #[test]
    fn deposits_and_decrowding_follow_the_density() {
        let mut settings = Settings {
            objects: vec![ObjectSettings {
                mesh: "builtin:cube".to_owned(),
                ..ObjectSettings::default()
            }],
            ..Settings::default()
        };
        settings.atlas.size = 64;
        settings.particles.count = 1000;
        settings.physarum.deposit = 2.0;
        settings.physarum.decrowding_weight = 0.5;
        settings.objects[0].physarum.decrowding_weight = Some(0.25);
        let scene = Scene::from_settings("cube".to_owned(), settings, "".into()).unwrap();
        let setup = Setup::new(&scene).unwrap();
        let density = 1000.0 / setup.atlas.owned_count as f32;
        let mut settings = scene.settings;
        for (reference, factor) in [(0.0, 1.0), (density, 1.0), (3.0 * density, 3.0)] {
            settings.physarum.reference_density = reference;
            let plan = Plan::new(&settings, &setup, 0, Means::of_host(false, 0));
            let found = [
                plan.diffuse(Pass::Last).params.deposit,
                plan.diffuse_seams(Pass::Last).params.deposit,
                physarums(&settings, &setup)[0].decrowding_weight,
            ];
            for (value, plain) in found.into_iter().zip([2.0, 2.0, 0.25]) {
                assert!(
                    (value - factor * plain).abs() < 1e-5,
                    "{found:?}, {reference}"
                );
            }
        }
    }

    /// Would catch: the scene's rates on an object that has others, an object that counts by its texels and not by its area, particles that
    /// do not count, and a bound at short or long trails.
    #[test]
    fn the_mean_of_the_trail_is_by_the_rates_of_each_object() {
        let scene = |objects: &[(f32, Option<f32>)]| {
            let mut settings = Settings::default();
            settings.atlas.size = 128;
            settings.particles.count = 1000;
            settings.physarum.deposit = 2.0;
            settings.trail.decay = 0.75;
            let objects = objects.iter().zip([0.0, 8.0]);
            let objects = objects.map(|(&(scale, half_life), x)| {
                let mut object = ObjectSettings {
                    mesh: "builtin:cube".to_owned(),
                    position: [x, 0.0, 0.0],
                    scale,
                    ..ObjectSettings::default()
                };
                object.trail.half_life = half_life;
                object
            });
            settings.objects = objects.collect();
            Scene::from_settings("cubes".to_owned(), settings, "".into()).unwrap()
        };
        let means = |scene: &Scene, particles: u32| {
            let setup = Setup::new(scene).unwrap();
            let density = f64::from(particles) / f64::from(setup.atlas.owned_count);
            [mean_trail, mean_deposit].map(|of| of(&scene.settings, &setup, particles) / density)
        };
        let assert_means = |scene: &Scene, particles: u32, expected: [f64; 2]| {
            let found = means(scene, particles);
            for (found, expected) in found.into_iter().zip(expected) {
                let is_near = (found - expected).abs() <= 1e-6 * expected;
                assert!(is_near || found == expected, "{found} for {expected}");
            }
        };
        // Three steps of deposits remain with a decay of 0.75, one with a half-life of one step.
        let mut alone = scene(&[(1.0, None)]);
        for particles in [1, 1000] {
            assert_means(&alone, particles, [6.0, 2.0]);
        }
        let same = scene(&[(1.0, None), (2.0, None)]);
        assert_means(&same, 1000, [6.0, 2.0]);
        // Four fifths of the area have the shorter one, whatever their share of the texels is.
        let mut other = scene(&[(1.0, None), (2.0, Some(1.0))]);
        for weight in [1.0, 3.0] {
            other.settings.objects[0].texel_weight = weight;
            assert_means(&other, 1000, [0.2 * 6.0 + 0.8 * 2.0, 2.0]);
        }
        other.settings.objects[1].physarum.deposit = Some(5.0);
        assert_means(&other, 1000, [0.2 * 6.0 + 0.8 * 5.0, 0.2 * 2.0 + 0.8 * 5.0]);
        // It has no bounds.
        for (decay, mean) in [
            (0.0, 0.0),
            (0.125, 2.0 / 7.0),
            (1.0 - 1.0 / 8192.0, 2.0 * 8191.0),
            (1.0, f64::INFINITY),
        ] {
            alone.settings.trail.decay = decay;
            assert_means(&alone, 1000, [mean, 2.0]);
        }
        alone.settings.physarum.deposit = 0.0;
        assert_means(&alone, 1000, [0.0, 0.0]);
    }

    /// Each of the object's own values has the effect of the scene's on that object, and none elsewhere.
    #[test]
    fn objects_have_values_of_their_own() {
        let scene = |key: &str, value: f32| {
            let set = vec!["atlas.size=256".to_owned(), format!("{key}={value}")];
            let overrides = Overrides {
                set,
                ..Overrides::default()
            };
            Scene::load("pair".as_ref(), &overrides).unwrap()
        };
        let plain = scene("particles.count", 1000.0);
        let setup = Setup::new(&plain).unwrap();
        let before = physarums(&plain.settings, &setup);
        for (key, value) in [
            ("speed", 0.003),
            ("rotation_angle", 11.0),
            ("sensor_angle", 13.0),
            ("sensor_offset", 0.017),
            ("sensor_noise", 0.019),
            ("favourite_density", 2.3),
            ("gravity_weight", 2.9),
            ("decrowding_weight", 0.31),
            ("distance_weight", 3.7),
            ("edge_crossing_attempts", 7.0),
        ] {
            let rows = |key: &str| physarums(&scene(key, value).settings, &setup);
            let of_all = rows(&format!("physarum.{key}"));
            let own = rows(&format!("object.1.physarum.{key}"));
            assert_ne!(of_all[1], before[1], "{key}");
            assert_eq!(own[..2], [before[0], of_all[1]], "{key}");
        }
    }
}
