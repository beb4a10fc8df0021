//! Motions of an object by a handle: ways along axes, in planes and round rings, from pixels of the picture.

use glam::{DAffine3, DQuat, DVec3, EulerRot, Vec2, Vec3};
use myxo::render::Camera;
use myxo::scene::motion::{Origins, in_decimals, pose_at, pose_from};
use myxo::scene::settings::{ModelAnimation, ObjectSettings};

/// How far along an axis through `middle` the place is that lies nearest to what a pixel shows.
pub fn along_axis(camera: &Camera, size: Vec2, pixel: Vec2, middle: Vec3, axis: Vec3) -> f32 {
    let ray = camera.ray(pixel, size);
    // The point of the axis nearest to the ray; nearly parallel ones have none.
    let across = ray.direction - ray.direction.dot(axis) * axis;
    let slope = across.length_squared().max(1e-3);
    let from_eye = middle - ray.origin;
    let along_ray = from_eye.dot(across) / slope;
    (ray.origin + along_ray * ray.direction - middle).dot(axis)
}

/// By how much the ring about an axis has turned that a pointer holds and takes from one pixel to another, so that it stays
/// under the pointer. `radius` is the ring's, world length.
pub fn angle_round(
    camera: &Camera,
    size: Vec2,
    pixels: [Vec2; 2],
    middle: Vec3,
    axis: Vec3,
    radius: f32,
) -> f32 {
    let eye = camera.eye() - middle;
    if eye.normalize().dot(axis).abs() < EDGE_ON {
        // Seen from its edge it is a line: along it, the side that is seen goes round by as much as the pointer goes.
        let near = (eye - eye.dot(axis) * axis).normalize_or(camera.backward());
        let along = axis.cross(near);
        let [from, to] = pixels.map(|pixel| on_plane(camera, size, pixel, middle).dot(along));
        return (to - from) / radius;
    }
    let [from, to] = pixels.map(|pixel| {
        let ray = camera.ray(pixel, size);
        let slope = ray.direction.dot(axis);
        let slope = slope.abs().max(1e-6).copysign(slope);
        let along = (middle - ray.origin).dot(axis) / slope;
        let way = ray.origin + along * ray.direction - middle;
        // If the ray passes the horizon of the ring's plane, it meets the plane behind the eye.
        if along < 0.0 { -way } else { way }
    });
    from.cross(to).dot(axis).atan2(from.dot(to))
}

/// The cosine of the angle between an axis and the way to the eye up to which its ring is a line.
const EDGE_ON: f32 = 0.17;

/// The world length at a place that a pixel covers.
pub fn length_of_pixel(camera: &Camera, size: Vec2, place: Vec3) -> f32 {
    let depth = (camera.eye() - place).dot(camera.backward()).max(1e-6);
    2.0 * depth * (0.5 * camera.vertical_fov).tan() / size.y.max(1.0)
}

/// The point at which a pixel's ray meets the plane of the picture through `middle`.
pub fn on_plane(camera: &Camera, size: Vec2, pixel: Vec2, middle: Vec3) -> Vec3 {
    let ray = camera.ray(pixel, size);
    let normal = camera.backward();
    let along = (middle - ray.origin).dot(normal) / ray.direction.dot(normal).min(-1e-6);
    ray.origin + along * ray.direction
}

/// Moves an object by a way in the world. Its motion maps positions by an affine map, which three places determine. `radius` is
/// the scene's.
pub fn shift(object: &mut ObjectSettings, time: f64, way: DVec3, radius: f32) {
    let place = |position: [f64; 3]| {
        let mut other = object.clone();
        other.position = position;
        still_model(&mut other);
        pose_at(&other, None, time).translation
    };
    let origin = place([0.0; 3]);
    let [x, y, z] =
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| place(axis) - origin);
    // A rotation, so its transpose takes back.
    let back = DVec3::new(x.dot(way), y.dot(way), z.dot(way));
    object.position = in_decimals(DVec3::from_array(object.position) + back, radius);
}

/// Moves an object that was turned or scaled about its own origin, so that another place of it stays where it was, if its
/// surface is far from that origin. The place is given as the origins of coordinates counted from it, before and after.
pub fn keep_in_place(
    object: &mut ObjectSettings,
    before: &ObjectSettings,
    time: f64,
    pivots: [Origins; 2],
    radius: f32,
) {
    if pivots.iter().all(|pivot| pivot.surface == DVec3::ZERO) {
        return;
    }
    let place = |object: &ObjectSettings, pivot| {
        let mut object = object.clone();
        still_model(&mut object);
        pose_from(&object, None, time, pivot).translation
    };
    let way = place(before, &pivots[0]) - place(object, &pivots[1]);
    shift(object, time, way, radius);
}

/// Turns an object about an axis of the world, whatever stands round its rotation.
pub fn turn(object: &mut ObjectSettings, time: f64, axis: DVec3, angle: f64) {
    let rotation_of = |object: &ObjectSettings| {
        let pose: DAffine3 = pose_at(object, None, time);
        DQuat::from_mat3(&pose.matrix3).normalize()
    };
    let mut round = object.clone();
    still_model(&mut round);
    round.rotation = [0.0; 3];
    (round.motion.spin, round.motion.swing) = ([0.0; 3], [0.0; 3]);
    let round = rotation_of(&round);
    let mut own = object.clone();
    still_model(&mut own);
    own.motion = Default::default();
    let own = rotation_of(&own);
    let turned = round.inverse() * DQuat::from_axis_angle(axis, angle) * round * own;
    let (z, y, x) = turned.to_euler(EulerRot::ZYX);
    object.rotation = [x, y, z].map(|angle| angle.to_degrees() as f32);
}

/// A model's own animation is applied to where the object stands, and changes nothing about that.
fn still_model(object: &mut ObjectSettings) {
    object.motion.model = ModelAnimation::Still;
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXES: [Vec3; 3] = [Vec3::X, Vec3::Y, Vec3::Z];

    fn mover() -> ObjectSettings {
        let mut object = ObjectSettings {
            position: [0.5, 0.1, -0.3],
            rotation: [10.0, 20.0, 30.0],
            ..ObjectSettings::default()
        };
        object.motion.spin = [0.0, 40.0, 0.0];
        object.motion.orbit = [5.0, 20.0, 0.0];
        object.motion.slide = [0.1, 0.0, 0.0];
        object
    }

    #[test]
    fn an_object_that_moves_goes_where_the_handle_puts_it() {
        let before = mover();
        let time = 3.7;
        let mut after = before.clone();
        let way = DVec3::new(0.2, -0.4, 0.7);
        shift(&mut after, time, way, 1.0);
        let moved =
            pose_at(&after, None, time).translation - pose_at(&before, None, time).translation;
        assert!(moved.distance(way) < 1e-6, "{moved}");
        assert_eq!(after.motion, before.motion, "and still moves");
    }

    #[test]
    fn an_object_that_moves_turns_about_the_axis_of_the_world() {
        let before = mover();
        let (time, angle) = (3.7, 0.4);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            let mut after = before.clone();
            turn(&mut after, time, axis, angle);
            let rotation = |object| DQuat::from_mat3(&pose_at(object, None, time).matrix3);
            let expected = DQuat::from_axis_angle(axis, angle) * rotation(&before);
            let off = rotation(&after).angle_between(expected);
            assert!(off < 1e-5, "{off}");
            assert_eq!(after.position, before.position);
        }
    }

    /// Would catch: an object in map coordinates that is turned or scaled about an origin kilometres away.
    #[test]
    fn objects_far_from_their_own_origin_turn_and_grow_in_place() {
        let before = mover();
        let time = 3.7;
        let far = DVec3::new(512_345.5, 230.0, 5_412_345.25);
        let pivot = |scale: f64| Origins {
            world: far,
            surface: scale * far,
        };
        let place =
            |object: &ObjectSettings, pivot| pose_from(object, None, time, &pivot).translation;
        let mut turned = before.clone();
        turn(&mut turned, time, DVec3::Y, 0.4);
        keep_in_place(&mut turned, &before, time, [pivot(1.0); 2], 1.0);
        let off = place(&turned, pivot(1.0)) - place(&before, pivot(1.0));
        assert!(off.length() < 1e-5, "{off}");
        let mut grown = before.clone();
        grown.scale = 2.0;
        keep_in_place(&mut grown, &before, time, [pivot(1.0), pivot(2.0)], 1.0);
        let off = place(&grown, pivot(2.0)) - place(&before, pivot(1.0));
        assert!(off.length() < 1e-5, "{off}");
        // Near its origin it turns about that.
        let mut near = before.clone();
        near.scale = 2.0;
        keep_in_place(&mut near, &before, time, [Origins::default(); 2], 1.0);
        assert_eq!(near.position, before.position);
    }

    #[test]
    fn rings_follow_the_pointer() {
        let size = Vec2::new(640.0, 480.0);
        let middle = Vec3::new(0.1, 0.2, -0.1);
        for (yaw, pitch) in [(20.0_f32, 25.0_f32), (-130.0, 70.0), (65.0, -40.0)] {
            let camera = Camera {
                distance: 5.0,
                yaw: yaw.to_radians(),
                pitch: pitch.to_radians(),
                ..Camera::default()
            };
            for axis in AXES {
                let side = axis.any_orthonormal_vector();
                let place = |angle: f32| {
                    let (sin, cos) = angle.sin_cos();
                    middle + 0.4 * (cos * side + sin * axis.cross(side))
                };
                for begin in [0.3_f32, 1.9, 4.4] {
                    for turned in [-1.2_f32, 0.01, 0.8] {
                        let pixels = [begin, begin + turned]
                            .map(|angle| camera.pixel(place(angle), size).unwrap());
                        let angle = angle_round(&camera, size, pixels, middle, axis, 0.4);
                        assert!(
                            (angle - turned).abs() < 2e-3,
                            "{axis} from {yaw}, {pitch}: {angle} instead of {turned}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn a_ring_that_is_a_line_is_drawn_along_it() {
        let size = Vec2::new(640.0, 480.0);
        let camera = Camera {
            distance: 5.0,
            yaw: 0.0,
            pitch: 0.0,
            ..Camera::default()
        };
        let middle = camera.target;
        let at = camera.pixel(middle, size).unwrap();
        // The ring about Y is seen from in front: to the right is the way that its near side goes round.
        for begin in [-40.0, 0.0, 40.0] {
            for way in [-30.0, 6.0, 60.0] {
                let pixels = [begin, begin + way].map(|x| at + Vec2::new(x, 0.0));
                let radius = 60.0 * length_of_pixel(&camera, size, middle);
                let angle = angle_round(&camera, size, pixels, middle, Vec3::Y, radius);
                assert!((angle - way / 60.0).abs() < 1e-3, "{begin}, {way}: {angle}");
            }
        }
    }

    #[test]
    fn arrows_follow_the_pointer() {
        let camera = Camera {
            distance: 5.0,
            ..Camera::default()
        };
        let size = Vec2::new(640.0, 480.0);
        let middle = Vec3::new(0.1, 0.2, -0.1);
        for axis in AXES {
            let place = middle + 0.35 * axis;
            let pixel = camera.pixel(place, size).unwrap();
            let along = along_axis(&camera, size, pixel, middle, axis);
            assert!((along - 0.35).abs() < 1e-3, "{axis}: {along}");
        }
        let place = middle + 0.3 * camera.right() - 0.2 * camera.up();
        let pixel = camera.pixel(place, size).unwrap();
        assert!(on_plane(&camera, size, pixel, middle).distance(place) < 1e-4);
    }
}
