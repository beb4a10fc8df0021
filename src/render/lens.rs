//! Depth of field: a lens of some width sees each picture from many places at once. Pictures from places spread over the lens, shifted so
//! that what is in focus stays, are averaged as light ([`Mean`](super::mean::Mean)), which is exact up to their number and needs no blur.

use std::f32::consts::TAU;

use glam::Vec2;

use super::camera::Camera;
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

/// The cameras of one picture of `size` pixels: so many, spread over a lens of this diameter, world units. All look the same way, and each
/// is shifted so that the plane at the distance `focus` stays where it is in the picture.
#[must_use]
pub fn cameras(camera: &Camera, diameter: f32, focus: f32, places: u32, size: Vec2) -> Vec<Camera> {
    // A spiral that covers the disc evenly (Vogel, 1979).
    let place = |i: u32| {
        let radius = 0.5 * diameter * ((i as f32 + 0.5) / places as f32).sqrt();
        radius * Vec2::from_angle(TAU * (i as f32 * 0.618_034).fract())
    };
    let middle = (0..places).map(place).sum::<Vec2>() / places.max(1) as f32;
    let in_picture = 1.0 / (focus * camera.half_sides(size));
    (0..places)
        .map(|i| {
            // Few places lie off the middle of the lens together.
            let place = place(i) - middle;
            Camera {
                target: camera.target + place.x * camera.right() + place.y * camera.up(),
                shift: camera.shift + place * in_picture,
                ..*camera
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::camera::MAX_PITCH;
    use glam::Vec3;

    /// Would catch: a lens that moves what is in focus, also off the axis and seen from above, one that does not move what is not, and
    /// few places that are all on one side.
    #[test]
    fn what_is_in_focus_stays_and_the_rest_moves() {
        let size = Vec2::new(640.0, 400.0);
        for (pitch, places) in [(0.0, PLACES), (1.0, 3), (MAX_PITCH, PLACES)] {
            let camera = Camera {
                distance: 4.0,
                yaw: 0.7,
                pitch,
                shift: Vec2::new(0.2, -0.1),
                ..Camera::default()
            };
            let focus = 3.0;
            let all = cameras(&camera, 0.2, focus, places, size);
            let spread = |distance: f32, aside: Vec2| {
                let aside = aside.x * camera.right() + aside.y * camera.up();
                let point = camera.eye() - distance * camera.backward() + aside;
                let middle = camera.pixel(point, size).unwrap();
                let pixels = all.iter().map(|camera| camera.pixel(point, size).unwrap());
                pixels
                    .map(|pixel| pixel.distance(middle))
                    .fold(0.0, f32::max)
            };
            for aside in [Vec2::ZERO, Vec2::new(0.7, -0.4)] {
                assert!(
                    spread(focus, aside) < 0.02,
                    "{pitch}: {}",
                    spread(focus, aside)
                );
                assert!(spread(2.0, aside) > 8.0 && spread(6.0, aside) > 5.0);
            }
            let mean = all.iter().map(Camera::eye).sum::<Vec3>() / places as f32;
            assert!(mean.distance(camera.eye()) < 1e-5, "{mean}");
        }
    }
}
