//! The second look: how its parameters mix with those of the first, by weights, one per texel; and the map of weights that a scene begins
//! with. Twin of `shaders/include/looks.glsl`.

use std::path::Path;

use glam::Vec2;

use super::physarum::Physarum;
use super::texture_map;
use crate::error::{Error, Result};
use crate::mesh::atlas::Atlas;
use crate::plain_text::Shown as _;
use crate::strict::direction2_or;

/// Its name in messages.
const WHAT: &str = "map of the second look";

/// A parameter between those of two looks.
#[must_use]
pub fn between(one: f32, other: f32, weight: f32) -> f32 {
    one + weight * (other - one)
}

/// Parameters between those of two looks: those of the first at the weight 0, those of the second at 1.
#[must_use]
pub fn mixed_look(one: Physarum, other: &Physarum, weight: f32) -> Physarum {
    if weight <= 0.0 {
        return one;
    }
    let part = |a: f32, b: f32| between(a, b, weight);
    let turn = |a: Vec2, b: Vec2| direction2_or(Vec2::new(part(a.x, b.x), part(a.y, b.y)), a);
    let sensor = turn(
        Vec2::new(one.sensor_cos, one.sensor_sin),
        Vec2::new(other.sensor_cos, other.sensor_sin),
    );
    let rotation = turn(
        Vec2::new(one.rotation_cos, one.rotation_sin),
        Vec2::new(other.rotation_cos, other.rotation_sin),
    );
    // Without a favourite density more is better; there is nothing between.
    let both = one.favourite_density >= 0.0 && other.favourite_density >= 0.0;
    let favourite = if both {
        part(one.favourite_density, other.favourite_density)
    } else if weight < 0.5 {
        one.favourite_density
    } else {
        other.favourite_density
    };
    Physarum {
        speed: part(one.speed, other.speed),
        sensor_offset: part(one.sensor_offset, other.sensor_offset),
        sensor_cos: sensor.x,
        sensor_sin: sensor.y,
        rotation_cos: rotation.x,
        rotation_sin: rotation.y,
        sensor_noise: part(one.sensor_noise, other.sensor_noise),
        favourite_density: favourite,
        gravity_weight: part(one.gravity_weight, other.gravity_weight),
        decrowding_weight: part(one.decrowding_weight, other.decrowding_weight),
        distance_weight: part(one.distance_weight, other.distance_weight),
        attempts: one.attempts,
    }
}

/// The weights of the second look by a picture of the texture: its lightness at the centre of each texel; gutters filled.
///
/// # Errors
/// When it cannot be read, or is black on all triangles.
pub fn weights_of(path: &Path, atlas: &Atlas) -> Result<Vec<f32>> {
    let picture = texture_map::read(path, WHAT, atlas.size)?.into_luma_alpha16();
    let full = f32::from(u16::MAX);
    let weights = texture_map::field_of(atlas, picture.dimensions(), |x, y| {
        let [light, alpha] = picture.get_pixel(x, y).0;
        f32::from(light) / full * (f32::from(alpha) / full)
    });
    // The least weight that a pixel can have, 2e-10, is not settled to 0.
    if weights.iter().all(|weight| *weight == 0.0) {
        return Err(Error::Invalid(format!(
            "{}: the {WHAT} is black wherever the texture holds a triangle: paint white on black, where `myxo atlas SCENE --out FILE.png` \
             draws what you mean",
            path.shown()
        )));
    }
    Ok(weights)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::surface::NONE;
    use crate::scene::Scene;
    use crate::scene::settings::Settings;
    use crate::sim::Setup;
    use crate::sim::behaviour::physarums;
    use image::{GrayImage, Luma};

    fn setup(look: &str) -> (Settings, Setup) {
        let mut settings = Settings::default();
        settings.particles.count = 10;
        settings.atlas.size = 61;
        "builtin:cube".clone_into(&mut settings.objects[0].mesh);
        look.clone_into(&mut settings.second_look.preset);
        let scene = Scene::from_settings("cube".to_owned(), settings, "".into()).unwrap();
        let setup = Setup::new(&scene).unwrap();
        (scene.settings, setup)
    }

    /// Would catch: weights of other texels than the map's, and a map that says nothing without a word.
    #[test]
    fn maps_are_read_at_the_centres_of_texels() {
        let (_, setup) = setup("none");
        let (atlas, folder) = (&setup.atlas, tempfile::tempdir().unwrap());
        let path = folder.path().join("map.png");
        let map = GrayImage::from_fn(2, 1, |x, _| Luma([[51, 255][x as usize]]));
        map.save(&path).unwrap();
        let weights = weights_of(&path, atlas).unwrap();
        for (texel, owner) in (0u32..).zip(&atlas.owner) {
            if *owner != NONE {
                let is_left = 2 * (texel % atlas.pitch) + 1 < atlas.size;
                let expected = if is_left { 0.2 } else { 1.0 };
                assert!((weights[texel as usize] - expected).abs() < 1e-4);
            }
        }
        GrayImage::new(4, 4).save(&path).unwrap();
        let problem = weights_of(&path, atlas).unwrap_err().to_string();
        assert!(
            problem.contains("map.png: the map of the second look is black"),
            "{problem}"
        );
        std::fs::write(&path, "white").unwrap();
        let problem = weights_of(&path, atlas).unwrap_err().to_string();
        assert!(
            problem.contains("map.png: the map of the second look must be a PNG"),
            "{problem}"
        );
    }

    /// Would catch: a mixture that leaves one look at 0 or does not get to the other at 1, and turns that are not of length one.
    #[test]
    fn mixtures_go_from_one_look_to_the_other() {
        let (settings, setup) = setup("streams");
        let rows = physarums(&settings, &setup);
        let [one, other] = [rows[0], rows[1]];
        assert_eq!(mixed_look(one, &other, 0.0), one);
        let words = |row: &Physarum| bytemuck::cast::<_, [f32; 12]>(*row);
        let near = |a: f32, b: f32| (a - b).abs() <= 1e-5 * (1.0 + a.abs());
        let whole = mixed_look(one, &other, 1.0);
        assert_eq!(whole.attempts, one.attempts, "those of the object");
        let mut both = words(&whole).into_iter().zip(words(&other));
        assert!(both.all(|(a, b)| near(a, b)), "{whole:?}, {other:?}");
        for k in 1..10 {
            let mixed = mixed_look(one, &other, 0.1 * k as f32);
            for (cos, sin) in [
                (mixed.sensor_cos, mixed.sensor_sin),
                (mixed.rotation_cos, mixed.rotation_sin),
            ] {
                assert!(near(cos.hypot(sin), 1.0), "{mixed:?}");
            }
            let (low, high) = (one.speed.min(other.speed), one.speed.max(other.speed));
            assert!(low < mixed.speed && mixed.speed < high);
            let has_favourite = mixed.favourite_density >= 0.0;
            let nearer = if k < 5 { &one } else { &other };
            assert_eq!(has_favourite, nearer.favourite_density >= 0.0, "{k}");
        }
    }
}
