//! Short flights of the camera: the picture follows for a moment, while the view already is where it will be.

use std::f32::consts::{PI, TAU};

use myxo::render::Camera;

/// How long the picture takes, seconds.
const SECONDS: f64 = 0.3;

/// The picture is on its way to where the camera is.
#[derive(Clone, Copy, Debug)]
pub struct Easing {
    from: Camera,
    began: f64,
}

impl Easing {
    /// Begins at a time in seconds, from what the picture shows.
    pub fn new(from: Camera, began: f64) -> Self {
        Self { from, began }
    }

    /// Has it arrived?
    pub fn is_over(&self, now: f64) -> bool {
        now >= self.began + SECONDS
    }

    /// What the picture shows at this time, on the way to this camera.
    pub fn shown(&self, to: &Camera, now: f64) -> Camera {
        if self.is_over(now) {
            return *to;
        }
        let share = ((now - self.began) / SECONDS).max(0.0) as f32;
        between(&self.from, to, share * share * (3.0 - 2.0 * share))
    }
}

/// A camera between two: by the shorter way round, and by equal factors of the distance.
fn between(from: &Camera, to: &Camera, share: f32) -> Camera {
    let turn = (to.yaw - from.yaw + PI).rem_euclid(TAU) - PI;
    let mix = |a: f32, b: f32| a + share * (b - a);
    Camera {
        target: from.target.lerp(to.target, share),
        distance: from.distance * (to.distance / from.distance).powf(share),
        yaw: (from.yaw + share * turn).rem_euclid(TAU),
        pitch: mix(from.pitch, to.pitch),
        vertical_fov: mix(from.vertical_fov, to.vertical_fov),
        shift: from.shift.lerp(to.shift, share),
        ..*to
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Would catch: a flight the long way round, one that jumps at its ends, and one that never ends.
    #[test]
    fn it_goes_the_short_way_and_arrives_exactly() {
        let from = Camera {
            yaw: 0.2,
            distance: 8.0,
            ..Camera::default()
        };
        let to = Camera {
            yaw: TAU - 0.3,
            distance: 2.0,
            shift: glam::Vec2::new(-0.2, 0.1),
            ..Camera::default()
        };
        let easing = Easing::new(from, 5.0);
        assert!(!easing.is_over(5.0) && easing.is_over(5.3));
        let first = easing.shown(&to, 5.0);
        assert!((first.yaw - from.yaw).abs() < 1e-5 && first.distance == from.distance);
        let middle = easing.shown(&to, 5.15);
        assert!((middle.yaw - (TAU - 0.05)).abs() < 1e-4, "{middle:?}");
        assert!((middle.distance - 4.0).abs() < 1e-4, "{middle:?}");
        assert!(middle.shift.distance(0.5 * to.shift) < 1e-4, "{middle:?}");
        assert_eq!(easing.shown(&to, 5.3), to);
    }
}
