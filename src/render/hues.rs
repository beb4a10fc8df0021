//! Colours that distinguish things or show a direction: equally light, and different in hue alone.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::colormap::linear_from_oklab;

/// OKLab's lightness and chroma of them all.
const LIGHTNESS: f32 = 0.75;
const CHROMA: f32 = 0.125;
/// Radians from OKLab's first axis to red.
const RED: f32 = 0.5;
/// Turns from the hue of one object to that of the next: the golden ratio's, so that consecutive objects have different hues, however many
/// there are.
const BETWEEN_OBJECTS: f32 = 0.381_966;
/// The hue of the first object.
const FIRST: f32 = 0.14;

/// Light of a hue, in turns from red by way of yellow, green and blue. Twin of `hue_light` in `shading.glsl`.
#[must_use]
pub fn hue_light(turn: f32) -> Vec3 {
    let ab = CHROMA * Vec2::from_angle(TAU * turn + RED);
    linear_from_oklab(Vec3::new(LIGHTNESS, ab.x, ab.y)).clamp(Vec3::ZERO, Vec3::ONE)
}

/// The light of an object in the views.
#[must_use]
pub fn object_light(object: usize) -> Vec3 {
    hue_light((FIRST + BETWEEN_OBJECTS * object as f32).fract())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hues_go_round_and_objects_side_by_side_differ() {
        let [red, green, blue] = [0.0, 0.28, 0.62].map(hue_light);
        assert!(red.x > red.y && red.x > red.z, "{red}");
        assert!(green.y > green.x && green.y > green.z, "{green}");
        assert!(blue.z > blue.x && blue.z > blue.y, "{blue}");
        assert!(hue_light(0.999).distance(hue_light(0.0)) < 0.01);
        for object in 0..40 {
            for later in 1..4 {
                let [a, b] = [object, object + later].map(object_light);
                assert!(a.distance(b) > 0.1, "{object} and {later} after it");
            }
        }
    }
}
