//! The orbit camera, and its motion by drags and the wheel.
//!
//! World space is right-handed with +Y up. Clip space is Vulkan's: y down, and depth reversed, 1 at the near
//! plane and 0 at infinity, which spreads the precision of a float depth buffer evenly.
//! Pixels are counted from the top left corner; pixel `(0, 0)` has its centre at `(0.5, 0.5)`.

use std::f32::consts::TAU;

use glam::camera::rh::{proj::vulkan, view};
use glam::{Mat4, Vec2, Vec3, Vec4Swizzles};

/// The steepest pitch, in radians: straight up would leave the picture without an up direction. It is within the 88 degrees that scene
/// files allow.
pub const MAX_PITCH: f32 = 1.535;

/// Distances are kept in this range of the scene's radius, so that a wheel cannot lose the scene.
const DISTANCE_RANGE: (f32, f32) = (0.02, 50.0);

/// Margin round a sphere that [`Camera::fit`] fits into the picture.
const FIT_MARGIN: f32 = 1.06;

/// Margin round the points of [`Camera::fit_points`], as a factor of the picture's sides.
const POINT_MARGIN: f32 = 1.1;

/// The least part of half of a picture's side that points are fitted into, however far the picture is shifted.
const SOME_ROOM: Vec2 = Vec2::splat(0.1);

/// How often [`Camera::fit_centered`] halves the distances among which it looks: to 1 in 100,000.
const HALVINGS: u32 = 17;

/// The number of directions that [`Camera::fit_all_round`] tests; the margin covers those between.
const SIDES_OF_A_TURN: u32 = 24;

/// A camera that turns about a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The point that the camera turns about, in world space; in the middle of the picture, if that is not shifted.
    pub target: Vec3,
    /// From the eye to the target, world units.
    pub distance: f32,
    /// Radians about +Y; 0 looks along -Z, and a positive yaw takes the eye to the right, towards +X.
    pub yaw: f32,
    /// Radians above the horizon, within [`MAX_PITCH`] either way.
    pub pitch: f32,
    /// The angle between the picture's top and bottom, in radians.
    pub vertical_fov: f32,
    /// World units that count as the size of the scene; bounds the distance.
    pub scene_radius: f32,
    /// Where the target is in the picture: to the right of its middle and above, as a share of half of its sides. The picture is shifted,
    /// and not turned, as by a lens that is moved sideways.
    pub shift: Vec2,
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            target: Vec3::ZERO,
            distance: 3.0,
            yaw: 35_f32.to_radians(),
            pitch: 28_f32.to_radians(),
            vertical_fov: 35_f32.to_radians(),
            scene_radius: 1.0,
            shift: Vec2::ZERO,
        }
    }
}

/// Standard directions of a camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// At +Z.
    Front,
    /// At -Z.
    Back,
    /// At -X.
    Left,
    /// At +X.
    Right,
    /// At +Y, with -Z upwards.
    Top,
    /// At -Y, with +Z upwards.
    Bottom,
}

impl Side {
    /// All directions, with the titles of their buttons.
    pub const ALL: &'static [(Self, &'static str)] = &[
        (Self::Front, "Front"),
        (Self::Back, "Back"),
        (Self::Left, "Left"),
        (Self::Right, "Right"),
        (Self::Top, "Top"),
        (Self::Bottom, "Bottom"),
    ];
}

/// A half line in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// The start.
    pub origin: Vec3,
    /// The direction; a unit vector.
    pub direction: Vec3,
}

impl Camera {
    /// The default direction, as far away as a sphere needs to fill a picture of this size.
    #[must_use]
    pub fn fitted(centre: Vec3, radius: f32, size: Vec2) -> Self {
        let mut camera = Self::default();
        camera.fit(centre, radius, size);
        camera
    }

    /// Looks at a sphere from the present direction, from where it just fills a picture of `size` pixels.
    pub fn fit(&mut self, centre: Vec3, radius: f32, size: Vec2) {
        let radius = if radius.is_finite() && radius > 0.0 {
            radius
        } else {
            1.0
        };
        let half_vertical = 0.5 * self.vertical_fov;
        let half_horizontal = (half_vertical.tan() * aspect_ratio(size)).atan();
        self.target = centre;
        self.scene_radius = radius;
        self.distance = FIT_MARGIN * radius / half_vertical.min(half_horizontal).sin();
    }

    /// Looks at the target from the present direction, from where every point of `points` just fits into a picture of
    /// `size` pixels. Nearer than [`Camera::fit`] for everything that is no sphere. Without points nothing changes.
    pub fn fit_points(&mut self, points: impl IntoIterator<Item = Vec3>, size: Vec2) {
        let half = self.half_sides(size);
        // What is free on either side of the target.
        let left_below = half * (1.0 / POINT_MARGIN + self.shift).max(SOME_ROOM);
        let right_above = half * (1.0 / POINT_MARGIN - self.shift).max(SOME_ROOM);
        let (right, up, backward) = (self.right(), self.up(), self.backward());
        // A point is in the picture if x is at most `right_above.x` times its depth, `distance - z`, and so on.
        let distance = points.into_iter().map(|point| {
            let from_target = point - self.target;
            let place = Vec2::new(from_target.dot(right), from_target.dot(up));
            let depth = (place / right_above).max(-place / left_below);
            from_target.dot(backward) + depth.max_element()
        });
        let distance = distance.fold(0.0, f32::max);
        if distance > 0.0 && distance.is_finite() {
            self.distance = distance;
        }
    }

    /// Goes nearer or farther and shifts the picture, so that these points fill the middle of a picture of `size` pixels, less the
    /// `margins` of it on the left, above, on the right and below, in pixels. The target stays. Without points nothing changes.
    pub fn fit_centered(
        &mut self,
        points: impl IntoIterator<Item = Vec3>,
        size: Vec2,
        margins: [f32; 4],
    ) {
        // A window that is hidden has no picture.
        if size.min_element() <= 0.0 {
            return;
        }
        let half = self.half_sides(size);
        let [left, above, right, below] = margins;
        let free = (size - Vec2::new(left + right, above + below)).max(0.2 * size) / size;
        let middle = Vec2::new(left - right, below - above) / size;
        // Half the size of the free part, as slopes from the axis of view; with what fit_points leaves free, too.
        let extent = half * free / POINT_MARGIN;
        let axes = [self.right(), self.up(), self.backward()];
        let places = points.into_iter().map(|point| {
            let from_target = point - self.target;
            Vec3::from_array(axes.map(|axis| from_target.dot(axis)))
        });
        let places: Vec<Vec3> = places.filter(|place| place.is_finite()).collect();
        // At these distances every point is before the eye, and within the free part if that is in the middle of the picture.
        let nearest = places.iter().map(|place| place.z).fold(0.0, f32::max);
        let farthest = places
            .iter()
            .map(|place| place.z + (place.truncate().abs() / extent).max_element());
        let farthest = farthest.fold(0.0, f32::max);
        if farthest <= nearest || !farthest.is_finite() {
            return;
        }
        let slopes = |distance: f32| {
            let none = (Vec2::INFINITY, Vec2::NEG_INFINITY);
            places.iter().fold(none, |(low, high), place| {
                let slope = place.truncate() / (distance - place.z);
                (low.min(slope), high.max(slope))
            })
        };
        // The nearer, the more of the picture they fill.
        let (mut near, mut far) = (nearest, farthest);
        for _ in 0..HALVINGS {
            let distance = 0.5 * (near + far);
            let (low, high) = slopes(distance);
            match (high - low).cmple(2.0 * extent).all() {
                true => far = distance,
                false => near = distance,
            }
        }
        let (low, high) = slopes(far);
        self.distance = far;
        self.shift = middle - 0.5 * (low + high) / half;
    }

    /// As [`fit_points`](Self::fit_points), for all directions on a turn about the target: at the distance that the widest view needs, and
    /// the target in the middle of the picture.
    pub fn fit_all_round(&mut self, points: impl IntoIterator<Item = Vec3>, size: Vec2) {
        self.shift = Vec2::ZERO;
        let points: Vec<Vec3> = points.into_iter().collect();
        let distances = (0..SIDES_OF_A_TURN).map(|side| {
            let mut turned = self.turned(side as f32 / SIDES_OF_A_TURN as f32);
            turned.fit_points(points.iter().copied(), size);
            turned.distance
        });
        self.distance = distances.fold(0.0, f32::max);
    }

    /// The camera after so many turns about the target, at the same height; negative ones go the other way round.
    #[must_use]
    pub fn turned(mut self, turns: f32) -> Self {
        self.yaw = (self.yaw + turns * TAU).rem_euclid(TAU);
        self
    }

    /// The position of the eye.
    #[must_use]
    pub fn eye(&self) -> Vec3 {
        self.target + self.distance * self.backward()
    }

    /// The unit vector from the target to the eye.
    #[must_use]
    pub fn backward(&self) -> Vec3 {
        let (sin_yaw, cos_yaw) = self.yaw.sin_cos();
        let (sin_pitch, cos_pitch) = self.pitch.sin_cos();
        Vec3::new(cos_pitch * sin_yaw, sin_pitch, cos_pitch * cos_yaw)
    }

    /// The picture's right, a unit vector in world space.
    #[must_use]
    pub fn right(&self) -> Vec3 {
        let (sin_yaw, cos_yaw) = self.yaw.sin_cos();
        Vec3::new(cos_yaw, 0.0, -sin_yaw)
    }

    /// The picture's up, a unit vector in world space.
    #[must_use]
    pub fn up(&self) -> Vec3 {
        self.backward().cross(self.right())
    }

    /// Half of the width and of the height that a picture of `size` pixels shows at a distance of 1.
    #[must_use]
    pub fn half_sides(&self, size: Vec2) -> Vec2 {
        (0.5 * self.vertical_fov).tan() * Vec2::new(aspect_ratio(size), 1.0)
    }

    /// The near distance: nearer points are not drawn, world units.
    #[must_use]
    pub fn near(&self) -> f32 {
        0.01 * self.distance
    }

    /// The largest distance from the eye at which points may still be nearer than the near plane, in the corners of a picture of `size`
    /// pixels.
    #[must_use]
    pub fn near_corner(&self, size: Vec2) -> f32 {
        let farthest = self.half_sides(size) * (1.0 + self.shift.abs());
        let Vec2 { x: right, y: up } = farthest;
        self.near() * (1.0 + up * up + right * right).sqrt()
    }

    /// From world space to Vulkan's clip space, for a picture of `size` pixels.
    #[must_use]
    pub fn clip_from_world(&self, size: Vec2) -> Mat4 {
        let clip_from_view = vulkan::perspective_infinite_reverse(
            self.vertical_fov,
            aspect_ratio(size),
            self.near(),
        );
        let view_from_world = view::look_at_mat4(self.eye(), self.target, Vec3::Y);
        // In clip space y points down.
        let shift = Vec3::new(self.shift.x, -self.shift.y, 0.0);
        Mat4::from_translation(shift) * clip_from_view * view_from_world
    }

    /// The half line from the eye through a pixel position.
    #[must_use]
    pub fn ray(&self, pixel: Vec2, size: Vec2) -> Ray {
        let half_height = (0.5 * self.vertical_fov).tan();
        let target = 0.5 * size * (1.0 + Vec2::new(self.shift.x, -self.shift.y));
        let from_target = (pixel - target) * (2.0 / size.y.max(1.0)) * half_height;
        let direction = self.right() * from_target.x - self.up() * from_target.y - self.backward();
        Ray {
            origin: self.eye(),
            direction: direction.normalize(),
        }
    }

    /// The pixel position of a point, or `None` behind the eye.
    #[must_use]
    pub fn pixel(&self, point: Vec3, size: Vec2) -> Option<Vec2> {
        let clip = self.clip_from_world(size) * point.extend(1.0);
        (clip.w > 0.0).then(|| (clip.xy() / clip.w * 0.5 + 0.5) * size)
    }

    /// Orbits by a drag, in pixels; a picture's height is half a turn.
    pub fn orbit(&mut self, drag: Vec2, size: Vec2) {
        let radians_per_pixel = std::f32::consts::PI / size.y.max(1.0);
        self.yaw = (self.yaw - drag.x * radians_per_pixel).rem_euclid(TAU);
        self.pitch = (self.pitch + drag.y * radians_per_pixel).clamp(-MAX_PITCH, MAX_PITCH);
    }

    /// Pans by a drag: the point at the target's depth stays under the pointer.
    pub fn pan(&mut self, drag: Vec2, size: Vec2) {
        let world_per_pixel =
            2.0 * self.distance * (0.5 * self.vertical_fov).tan() / size.y.max(1.0);
        self.target += (self.up() * drag.y - self.right() * drag.x) * world_per_pixel;
    }

    /// Multiplies the distance by `factor` (below 1 comes nearer); the point at the target's depth stays under the pointer.
    pub fn zoom(&mut self, factor: f32, pixel: Vec2, size: Vec2) {
        let (nearest, farthest) = DISTANCE_RANGE;
        let distance = (self.distance * factor)
            .clamp(nearest * self.scene_radius, farthest * self.scene_radius);
        let factor = distance / self.distance;
        let under_pointer = self.on_target_plane(pixel, size);
        self.target = under_pointer + (self.target - under_pointer) * factor;
        self.distance = distance;
    }

    /// Rotates about the eye: `drag` in pixels; a picture's height is its field of view.
    pub fn look(&mut self, drag: Vec2, size: Vec2) {
        let eye = self.eye();
        let radians_per_pixel = self.vertical_fov / size.y.max(1.0);
        self.yaw = (self.yaw - drag.x * radians_per_pixel).rem_euclid(TAU);
        self.pitch = (self.pitch + drag.y * radians_per_pixel).clamp(-MAX_PITCH, MAX_PITCH);
        self.target = eye - self.distance * self.backward();
    }

    /// Translates to the right, up and backward, in camera axes and world units; the direction does not change.
    pub fn travel(&mut self, way: Vec3) {
        self.target += way.x * self.right() + way.y * self.up() + way.z * self.backward();
    }

    /// Changes the field of view and the distance such that objects at the target's depth keep their size.
    pub fn set_field_of_view(&mut self, vertical_fov: f32) {
        let before = (0.5 * self.vertical_fov).tan();
        self.vertical_fov = vertical_fov;
        let (nearest, farthest) = DISTANCE_RANGE;
        self.distance = (self.distance * before / (0.5 * vertical_fov).tan())
            .clamp(nearest * self.scene_radius, farthest * self.scene_radius);
    }

    /// Looks at the target from one of its sides.
    pub fn look_from(&mut self, side: Side) {
        let quarter = std::f32::consts::FRAC_PI_2;
        (self.yaw, self.pitch) = match side {
            Side::Front => (0.0, 0.0),
            Side::Right => (quarter, 0.0),
            Side::Back => (2.0 * quarter, 0.0),
            Side::Left => (3.0 * quarter, 0.0),
            Side::Top => (0.0, MAX_PITCH),
            Side::Bottom => (0.0, -MAX_PITCH),
        };
    }

    /// The point at the target's depth that a pixel shows.
    fn on_target_plane(&self, pixel: Vec2, size: Vec2) -> Vec3 {
        let ray = self.ray(pixel, size);
        let along = self.distance / -ray.direction.dot(self.backward());
        ray.origin + ray.direction * along
    }
}

/// Width over height; 1 for a picture without an area, as a minimised window has.
fn aspect_ratio(size: Vec2) -> f32 {
    if size.x > 0.0 && size.y > 0.0 {
        size.x / size.y
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests;
