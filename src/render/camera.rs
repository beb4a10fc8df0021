//! The orbit camera: where a picture is taken from, and how a hand moves it.
//!
//! World space is right-handed with +Y up. Clip space is Vulkan's: y down, and depth reversed, 1 at the near
//! plane and 0 at infinity, which spreads the precision of a float depth buffer evenly.
//! Pixels are counted from the top left corner; pixel `(0, 0)` has its centre at `(0.5, 0.5)`.

use glam::camera::rh::{proj::vulkan, view};
use glam::{Mat4, Vec2, Vec3, Vec4Swizzles};

/// The steepest pitch, in radians: straight up would leave the picture without an upright. It is within the 88 degrees that
/// scene files may say.
pub const MAX_PITCH: f32 = 1.535;

/// Distances are kept in this range of the scene's radius, so that a wheel cannot lose the scene.
const DISTANCE_RANGE: (f32, f32) = (0.02, 50.0);

/// Room left round a sphere that [`Camera::fit`] fills the picture with.
const FIT_MARGIN: f32 = 1.06;

/// The same for the points of [`Camera::fit_points`], as a factor of the picture's sides.
const POINT_MARGIN: f32 = 1.1;

/// A camera that turns about a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The point in the middle of the picture, in world space.
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
        }
    }
}

/// Where a camera can stand.
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
    /// All of them, and as buttons call them.
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
    /// Where it begins.
    pub origin: Vec3,
    /// Where it goes; a unit vector.
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
        let half_height = (0.5 * self.vertical_fov).tan() / POINT_MARGIN;
        let half_width = half_height * aspect_ratio(size);
        let (right, up, backward) = (self.right(), self.up(), self.backward());
        // A point is in the picture if |x| is at most half_width times its depth, `distance - z`; likewise for y.
        let distance = points.into_iter().map(|point| {
            let from_target = point - self.target;
            let (x, y) = (from_target.dot(right), from_target.dot(up));
            from_target.dot(backward) + (x.abs() / half_width).max(y.abs() / half_height)
        });
        let distance = distance.fold(0.0, f32::max);
        if distance > 0.0 && distance.is_finite() {
            self.distance = distance;
        }
    }

    /// Where the eye is.
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

    /// What lies less far before the eye than this is not drawn, world units.
    #[must_use]
    pub fn near(&self) -> f32 {
        0.01 * self.distance
    }

    /// How far from the eye something can be and yet not be drawn, in the corners of a picture of `size` pixels.
    #[must_use]
    pub fn near_corner(&self, size: Vec2) -> f32 {
        let up = (0.5 * self.vertical_fov).tan();
        let right = up * aspect_ratio(size);
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
        clip_from_view * view_from_world
    }

    /// The half line from the eye through a pixel position.
    #[must_use]
    pub fn ray(&self, pixel: Vec2, size: Vec2) -> Ray {
        let half_height = (0.5 * self.vertical_fov).tan();
        let from_middle = (pixel - 0.5 * size) * (2.0 / size.y.max(1.0)) * half_height;
        let direction = self.right() * from_middle.x - self.up() * from_middle.y - self.backward();
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

    /// Turns the scene with the hand: `drag` in pixels; a picture's height is half a turn.
    pub fn orbit(&mut self, drag: Vec2, size: Vec2) {
        let radians_per_pixel = std::f32::consts::PI / size.y.max(1.0);
        self.yaw = (self.yaw - drag.x * radians_per_pixel).rem_euclid(std::f32::consts::TAU);
        self.pitch = (self.pitch + drag.y * radians_per_pixel).clamp(-MAX_PITCH, MAX_PITCH);
    }

    /// Moves the scene with the hand: what lies at the target's depth stays under the pointer.
    pub fn pan(&mut self, drag: Vec2, size: Vec2) {
        let world_per_pixel =
            2.0 * self.distance * (0.5 * self.vertical_fov).tan() / size.y.max(1.0);
        self.target += (self.up() * drag.y - self.right() * drag.x) * world_per_pixel;
    }

    /// Multiplies the distance by `factor` (below 1 comes nearer); what the pointer is on, at the target's depth,
    /// stays under the pointer.
    pub fn zoom(&mut self, factor: f32, pixel: Vec2, size: Vec2) {
        let (nearest, farthest) = DISTANCE_RANGE;
        let distance = (self.distance * factor)
            .clamp(nearest * self.scene_radius, farthest * self.scene_radius);
        let factor = distance / self.distance;
        let under_pointer = self.on_target_plane(pixel, size);
        self.target = under_pointer + (self.target - under_pointer) * factor;
        self.distance = distance;
    }

    /// Turns where it stands: `drag` in pixels; a picture's height is its field of view.
    pub fn look(&mut self, drag: Vec2, size: Vec2) {
        let eye = self.eye();
        let radians_per_pixel = self.vertical_fov / size.y.max(1.0);
        self.yaw = (self.yaw - drag.x * radians_per_pixel).rem_euclid(std::f32::consts::TAU);
        self.pitch = (self.pitch + drag.y * radians_per_pixel).clamp(-MAX_PITCH, MAX_PITCH);
        self.target = eye - self.distance * self.backward();
    }

    /// Goes a way, to the right, up and backward as it looks, in world units; it goes on looking the same way.
    pub fn travel(&mut self, way: Vec3) {
        self.target += way.x * self.right() + way.y * self.up() + way.z * self.backward();
    }

    /// Opens or closes, and comes nearer or goes back, so that what lies at the target's depth stays as large.
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
mod tests {
    use super::*;

    const SIZE: Vec2 = Vec2::new(640.0, 360.0);

    fn camera() -> Camera {
        let mut camera = Camera::fitted(Vec3::new(0.5, -1.0, 2.0), 1.7, SIZE);
        camera.yaw = 0.8;
        camera.pitch = 0.4;
        camera
    }

    fn assert_near(a: Vec3, b: Vec3, tolerance: f32) {
        assert!(a.distance(b) < tolerance, "{a} is not {b}");
    }

    #[test]
    fn the_target_is_in_the_middle_of_the_picture() {
        let camera = camera();
        let pixel = camera.pixel(camera.target, SIZE).unwrap();
        assert!(pixel.distance(0.5 * SIZE) < 1e-3, "{pixel}");
    }

    #[test]
    fn sides_are_where_they_say() {
        for (side, towards) in [
            (Side::Front, Vec3::Z),
            (Side::Back, Vec3::NEG_Z),
            (Side::Left, Vec3::NEG_X),
            (Side::Right, Vec3::X),
            (Side::Top, Vec3::Y),
            (Side::Bottom, Vec3::NEG_Y),
        ] {
            let mut turned = camera();
            turned.look_from(side);
            assert!(turned.backward().dot(towards) > 0.999, "{side:?}");
            assert_eq!(
                (turned.target, turned.distance),
                (camera().target, camera().distance)
            );
        }
        assert_eq!(Side::ALL.len(), 6);
    }

    #[test]
    fn who_flies_turns_on_the_spot_and_goes_straight() {
        let mut flying = camera();
        flying.look(Vec2::new(40.0, -25.0), SIZE);
        assert_near(flying.eye(), camera().eye(), 1e-5);
        assert!(flying.backward().dot(camera().backward()) < 0.9999);
        // The hand to the right turns to the right: what was in the middle is left of it.
        let seen = flying.pixel(camera().target, SIZE).unwrap();
        assert!(
            seen.x < 0.5 * SIZE.x - 20.0 && seen.y > 0.5 * SIZE.y + 10.0,
            "{seen}"
        );
        let before = flying.eye();
        flying.travel(Vec3::new(0.3, -0.2, -0.5));
        let gone = flying.eye() - before;
        assert!((gone.dot(flying.right()) - 0.3).abs() < 1e-5);
        assert!((gone.dot(flying.up()) + 0.2).abs() < 1e-5);
        assert!((gone.dot(flying.backward()) + 0.5).abs() < 1e-5);
    }

    #[test]
    fn another_field_of_view_leaves_the_target_as_large() {
        let mut wide = camera();
        let beside = wide.target + 0.3 * wide.right() + 0.1 * wide.up();
        let before = wide.pixel(beside, SIZE).unwrap();
        wide.set_field_of_view(1.6);
        assert_eq!(wide.vertical_fov, 1.6);
        assert!(wide.distance < 0.7 * camera().distance);
        assert!(wide.pixel(beside, SIZE).unwrap().distance(before) < 0.01);
    }

    #[test]
    fn right_is_right_and_up_is_up() {
        let camera = camera();
        let middle = camera.pixel(camera.target, SIZE).unwrap();
        let right = camera
            .pixel(camera.target + 0.1 * camera.right(), SIZE)
            .unwrap();
        let above = camera.pixel(camera.target + Vec3::Y * 0.1, SIZE).unwrap();
        assert!(
            right.x > middle.x + 1.0 && (right.y - middle.y).abs() < 0.01,
            "{right}"
        );
        assert!(
            above.y < middle.y - 1.0 && (above.x - middle.x).abs() < 0.01,
            "{above}"
        );
        // With no yaw the eye is on +Z and sees +X on its right.
        let front = Camera {
            yaw: 0.0,
            pitch: 0.0,
            ..Camera::default()
        };
        assert_near(front.eye(), Vec3::Z * front.distance, 1e-6);
        assert!(front.pixel(Vec3::X, SIZE).unwrap().x > 0.5 * SIZE.x);
    }

    #[test]
    fn the_frame_is_orthonormal_and_agrees_with_the_matrix() {
        let camera = camera();
        let (right, up, backward) = (camera.right(), camera.up(), camera.backward());
        for (a, b) in [(right, up), (up, backward), (backward, right)] {
            assert!(a.dot(b).abs() < 1e-6);
        }
        assert_near(right.cross(up), backward, 1e-6);
        let view = view::look_at_mat4(camera.eye(), camera.target, Vec3::Y);
        assert_near(view.transform_vector3(right), Vec3::X, 1e-5);
        assert_near(view.transform_vector3(up), Vec3::Y, 1e-5);
    }

    #[test]
    fn depth_is_one_at_the_near_plane_and_falls_to_zero() {
        let camera = camera();
        let clip_from_world = camera.clip_from_world(SIZE);
        let depth = |distance: f32| {
            let clip = clip_from_world * (camera.eye() - distance * camera.backward()).extend(1.0);
            clip.z / clip.w
        };
        assert!((depth(0.01 * camera.distance) - 1.0).abs() < 1e-4);
        assert!(depth(1.0) > depth(2.0) && depth(2.0) > depth(1e4) && depth(1e4) > 0.0);
        assert!(depth(1e4) < 0.01);
    }

    #[test]
    fn a_ray_goes_through_the_pixel_that_shows_its_points() {
        let camera = camera();
        for pixel in [
            Vec2::new(0.5, 0.5),
            Vec2::new(600.0, 20.0),
            Vec2::new(320.0, 180.0),
            Vec2::new(7.0, 351.0),
        ] {
            let ray = camera.ray(pixel, SIZE);
            assert!((ray.direction.length() - 1.0).abs() < 1e-6);
            for along in [0.7, 3.0, 40.0] {
                let shown = camera
                    .pixel(ray.origin + along * ray.direction, SIZE)
                    .unwrap();
                assert!(shown.distance(pixel) < 0.02, "{pixel} shows {shown}");
            }
        }
    }

    #[test]
    fn what_is_behind_the_eye_has_no_pixel() {
        let camera = camera();
        assert_eq!(camera.pixel(camera.eye() + camera.backward(), SIZE), None);
    }

    #[test]
    fn zoom_keeps_the_point_under_the_pointer() {
        let pointer = Vec2::new(500.0, 60.0);
        let mut camera = camera();
        let point = camera.on_target_plane(pointer, SIZE);
        let before = camera.distance;
        camera.zoom(0.5, pointer, SIZE);
        assert!((camera.distance - 0.5 * before).abs() < 1e-5);
        assert!(camera.pixel(point, SIZE).unwrap().distance(pointer) < 0.01);
        camera.zoom(3.0, pointer, SIZE);
        assert!(camera.pixel(point, SIZE).unwrap().distance(pointer) < 0.01);
    }

    #[test]
    fn zoom_cannot_lose_the_scene() {
        let mut camera = camera();
        for _ in 0..1000 {
            camera.zoom(0.5, 0.5 * SIZE, SIZE);
        }
        assert!((camera.distance / camera.scene_radius - 0.02).abs() < 1e-4);
        for _ in 0..1000 {
            camera.zoom(2.0, Vec2::new(3.0, 5.0), SIZE);
        }
        assert!((camera.distance / camera.scene_radius - 50.0).abs() < 0.1);
        assert!(camera.target.is_finite());
    }

    #[test]
    fn pan_moves_the_scene_with_the_hand() {
        let mut camera = camera();
        let (from, to) = (Vec2::new(100.0, 200.0), Vec2::new(180.0, 150.0));
        let point = camera.on_target_plane(from, SIZE);
        camera.pan(to - from, SIZE);
        assert!(camera.pixel(point, SIZE).unwrap().distance(to) < 0.01);
    }

    #[test]
    fn orbit_turns_the_near_side_with_the_hand_and_stops_at_the_poles() {
        let mut camera = camera();
        let near_side = camera.target + 0.3 * camera.backward();
        let before = camera.pixel(near_side, SIZE).unwrap();
        camera.orbit(Vec2::new(20.0, 10.0), SIZE);
        let after = camera.pixel(near_side, SIZE).unwrap();
        assert!(
            after.x > before.x + 0.5 && after.y > before.y + 0.5,
            "{before} to {after}"
        );
        camera.orbit(Vec2::new(0.0, 1e5), SIZE);
        assert_eq!(camera.pitch, MAX_PITCH);
        camera.orbit(Vec2::new(0.0, -1e6), SIZE);
        assert_eq!(camera.pitch, -MAX_PITCH);
        assert!(camera.clip_from_world(SIZE).is_finite());
    }

    #[test]
    fn a_fitted_sphere_fills_the_smaller_side_and_no_more() {
        for size in [Vec2::new(640.0, 360.0), Vec2::new(300.0, 900.0)] {
            let (centre, radius) = (Vec3::new(3.0, 2.0, 1.0), 2.5);
            let camera = Camera::fitted(centre, radius, size);
            // The silhouette of a sphere is the circle where its tangent cone touches it.
            let sine = radius / camera.distance;
            let touching = centre + camera.backward() * radius * sine;
            let reach = radius * (1.0 - sine * sine).sqrt();
            let shorter = size.min_element();
            let side = if size.x < size.y {
                camera.right()
            } else {
                camera.up()
            };
            let edge = camera.pixel(touching + side * reach, size).unwrap();
            let filled = edge.distance(0.5 * size) / (0.5 * shorter);
            assert!(filled > 0.9 && filled < 1.0, "{filled}");
        }
    }

    #[test]
    fn fitted_points_are_inside_and_the_outermost_nearly_at_the_margin() {
        let points: Vec<Vec3> = (0..300)
            .map(|i| {
                let angle = i as f32 * 0.7;
                Vec3::new(2.0 * angle.cos(), 0.3 * (3.0 * angle).sin(), angle.sin())
            })
            .collect();
        for size in [SIZE, Vec2::new(200.0, 500.0)] {
            let mut camera = camera();
            camera.target = Vec3::ZERO;
            camera.fit_points(points.iter().copied(), size);
            let outermost = points
                .iter()
                .map(|&point| {
                    let from_middle = camera.pixel(point, size).unwrap() / size - 0.5;
                    2.0 * from_middle.abs().max_element()
                })
                .fold(0.0, f32::max);
            assert!((outermost - 1.0 / POINT_MARGIN).abs() < 1e-3, "{outermost}");
        }
        let mut camera = camera();
        let before = camera;
        camera.fit_points([], SIZE);
        assert_eq!(camera, before);
    }

    #[test]
    fn a_minimised_window_gives_a_finite_matrix() {
        let mut camera = Camera::default();
        camera.fit(Vec3::ZERO, 0.0, Vec2::ZERO);
        assert!(camera.clip_from_world(Vec2::ZERO).is_finite());
        assert!(camera.ray(Vec2::ZERO, Vec2::ZERO).direction.is_finite());
    }
}
