//! Depth of field: a lens of some width sees each picture from many places at once. Pictures from places spread over the lens, all
//! aimed at the point in focus, are averaged as light ([`Mean`](super::mean::Mean)), which is exact up to their number and needs no blur.

use std::f32::consts::TAU;

use glam::Vec2;

use super::camera::{Camera, MAX_PITCH};
use super::pick::Hit;

/// Places on a lens that show no steps if it is not too wide.
pub const PLACES: u32 = 32;

/// The widest lens, scene radii.
pub const WIDEST: f32 = 1.0;

/// The distance before a camera of what is in focus: of what the middle of the picture shows, if it shows a surface, or of the target.
#[must_use]
pub fn focus(camera: &Camera, middle: Option<Hit>) -> f32 {
    middle.map_or(camera.distance, |hit| {
        (camera.eye() - hit.position).dot(camera.backward())
    })
}

/// The cameras of one picture: so many, spread over a lens of this diameter, world units, and aimed at what is at this distance before the middle
/// of the picture.
#[must_use]
pub fn cameras(camera: &Camera, diameter: f32, focus: f32, places: u32) -> Vec<Camera> {
    let target = camera.eye() - focus * camera.backward();
    (0..places)
        .map(|i| {
            // A spiral that covers the disc evenly (Vogel, 1979).
            let radius = 0.5 * diameter * ((i as f32 + 0.5) / places as f32).sqrt();
            let angle = TAU * (i as f32 * 0.618_034).fract();
            let Vec2 { x, y } = radius * Vec2::from_angle(angle);
            let eye = camera.eye() + x * camera.right() + y * camera.up();
            let from_target = eye - target;
            let distance = from_target.length();
            let pitch = (from_target.y / distance).clamp(-1.0, 1.0).asin();
            Camera {
                target,
                distance,
                yaw: from_target.x.atan2(from_target.z),
                pitch: pitch.clamp(-MAX_PITCH, MAX_PITCH),
                ..*camera
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// Would catch: a lens that moves what is in focus, and one that does not move what is not.
    #[test]
    fn what_is_in_focus_stays_and_the_rest_moves() {
        let size = Vec2::new(640.0, 400.0);
        let camera = Camera {
            distance: 4.0,
            yaw: 0.7,
            pitch: 0.3,
            ..Camera::default()
        };
        let focus = 3.0;
        let at = |distance: f32| camera.eye() - distance * camera.backward();
        let spread = |point: Vec3| {
            let pixels = cameras(&camera, 0.2, focus, PLACES).into_iter();
            let pixels = pixels.map(|camera| camera.pixel(point, size).unwrap());
            let from_middle = pixels.map(|pixel| pixel.distance(0.5 * size));
            from_middle.fold(0.0, f32::max)
        };
        assert!(spread(at(focus)) < 0.1, "{}", spread(at(focus)));
        assert!(spread(at(2.0)) > 10.0 && spread(at(6.0)) > 5.0);
        let all = cameras(&camera, 0.2, focus, PLACES);
        let mean = all.iter().map(Camera::eye).sum::<Vec3>() / PLACES as f32;
        assert!(mean.distance(camera.eye()) < 0.01, "{mean}");
    }
}
