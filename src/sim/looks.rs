//! The second look: how its parameters mix with those of the first, by weights, one per texel; and the map of weights that a scene begins
//! with. Twin of `shaders/include/looks.glsl`.

use std::path::Path;

use glam::Vec2;
use rayon::prelude::*;

use super::field::fill_gutters;
use super::physarum::Physarum;
use super::texture_map;
use crate::error::{Error, Result};
use crate::mesh::atlas::Atlas;
use crate::mesh::surface::NONE;
use crate::plain_text::Shown as _;
use crate::strict::{direction2_or, settled};

/// Its name in messages.
const WHAT: &str = "map of the second look";

/// Parameters between those of two looks: those of the first at the weight 0, those of the second at 1.
#[must_use]
pub fn mixed_look(one: Physarum, other: &Physarum, weight: f32) -> Physarum {
    if weight <= 0.0 {
        return one;
    }
    let part = |a: f32, b: f32| a + weight * (b - a);
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
    let both = one.favourite_density > 0.0 && other.favourite_density > 0.0;
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
        pad0: 0.0,
    }
}

/// The weights of the second look by a picture of the texture: its lightness at the centre of each texel; gutters filled.
///
/// # Errors
/// When it cannot be read, or is black on all triangles.
pub fn weights_of(path: &Path, atlas: &Atlas) -> Result<Vec<f32>> {
    let picture = texture_map::read(path, WHAT, atlas.size)?.into_luma_alpha16();
    let (width, height) = picture.dimensions();
    let at = |place: u32, side: u32| {
        let pixel = (2 * u64::from(place) + 1) * u64::from(side) / (2 * u64::from(atlas.size));
        (pixel as u32).min(side - 1)
    };
    let full = f32::from(u16::MAX);
    let mut weights = vec![0.0; atlas.owner.len()];
    for (texel, owner) in (0u32..).zip(&atlas.owner) {
        if *owner == NONE {
            continue;
        }
        let (column, row) = (texel % atlas.pitch, texel / atlas.pitch);
        let [light, alpha] = picture.get_pixel(at(column, width), at(row, height)).0;
        weights[texel as usize] = f32::from(light) / full * (f32::from(alpha) / full);
    }
    if weights.iter().all(|weight| *weight == 0.0) {
        return Err(Error::Invalid(format!(
            "{}: the {WHAT} is black wherever the texture holds a triangle: paint white on black, where `myxo atlas SCENE --out FILE.png` \
             draws what you mean",
            path.shown()
        )));
    }
    fill_gutters(&atlas.seams, &mut weights);
    weights
        .par_iter_mut()
        .for_each(|weight| *weight = settled(*weight));
    Ok(weights)
}
