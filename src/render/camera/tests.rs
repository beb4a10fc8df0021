//! Tests of cameras: positions, fitting, and drags.

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
fn nothing_is_cut_off_on_a_turn() {
    // A long box: it looks small from its end.
    let half = Vec3::new(3.0, 0.5, 0.25);
    let side = |i: i32, bit: i32| if i & bit == 0 { -1.0 } else { 1.0 };
    let corners = || (0..8).map(|i| half * Vec3::new(side(i, 1), side(i, 2), side(i, 4)));
    let mut all_round = Camera {
        yaw: 0.25 * TAU,
        pitch: 0.0,
        ..Camera::default()
    };
    let mut one_side = all_round;
    one_side.fit_points(corners(), SIZE);
    all_round.fit_all_round(corners(), SIZE);
    let seen = |camera: Camera, turns| {
        let camera = camera.turned(turns);
        corners().all(|point| {
            let pixel = camera.pixel(point, SIZE).expect("before the eye");
            pixel.cmpge(Vec2::ZERO).all() && pixel.cmple(SIZE).all()
        })
    };
    let turns = |i: i32| i as f32 / 48.0 - 1.0;
    assert!((0..97).all(|i| seen(all_round, turns(i))));
    assert!(seen(one_side, 0.0) && !seen(one_side, 0.25));
    let there = all_round.turned(0.25);
    assert_eq!(there.target, all_round.target);
    assert!((there.eye().y - all_round.eye().y).abs() < 1e-5);
    assert!((there.turned(-1.25).yaw - all_round.yaw).abs() < 1e-5);
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
fn a_flying_camera_turns_on_the_spot_and_goes_straight() {
    let mut flying = camera();
    flying.look(Vec2::new(40.0, -25.0), SIZE);
    assert_near(flying.eye(), camera().eye(), 1e-5);
    assert!(flying.backward().dot(camera().backward()) < 0.9999);
    // A drag to the right rotates to the right: the former middle is then left of the middle.
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
    let mut camera = camera();
    camera.shift = Vec2::new(0.3, -0.2);
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

/// Would catch: a scene that sits low in its picture, or partly under a bar.
#[test]
fn centred_points_fill_the_free_part_evenly() {
    let points: Vec<Vec3> = (0..300)
        .map(|i| {
            let angle = i as f32 * 0.7;
            Vec3::new(
                2.0 * angle.cos(),
                0.9 + 0.9 * (3.0 * angle).sin(),
                angle.sin(),
            )
        })
        .collect();
    for size in [SIZE, Vec2::new(200.0, 500.0), Vec2::new(900.0, 300.0)] {
        for margins in [[0.0; 4], [10.0, 20.0, 60.0, 0.0]] {
            let mut camera = camera();
            camera.target = Vec3::new(7.0, -3.0, 2.0);
            let before = camera;
            camera.fit_centered(points.iter().copied(), size, margins);
            let stays = Camera {
                distance: before.distance,
                shift: before.shift,
                ..camera
            };
            assert_eq!(stays, before);
            let pixels = points
                .iter()
                .map(|&point| camera.pixel(point, size).unwrap());
            let none = (Vec2::INFINITY, Vec2::NEG_INFINITY);
            let (low, high) = pixels.fold(none, |(low, high), p| (low.min(p), high.max(p)));
            let [left, above, right, below] = margins;
            let (from, to) = (Vec2::new(left, above), size - Vec2::new(right, below));
            assert!(
                low.cmpgt(from - 0.5).all() && high.cmplt(to + 0.5).all(),
                "{low} {high}"
            );
            let filled = (high - low) / (to - from);
            assert!(
                (filled.max_element() * POINT_MARGIN - 1.0).abs() < 1e-3,
                "{filled}"
            );
            let beside = (low + high - from - to) / (to - from);
            assert!(beside.abs().max_element() < 1e-3, "{beside}");
            let at = camera.pixel(camera.target, size).unwrap();
            let wanted = 0.5 * size * (1.0 + camera.shift * Vec2::new(1.0, -1.0));
            assert!(at.distance(wanted) < 0.01, "{at} {wanted}");
        }
    }
    let mut camera = camera();
    let before = camera;
    camera.fit_centered([], SIZE, [0.0; 4]);
    assert_eq!(camera, before);
    // Hidden windows, and one that is smaller than its margins.
    for size in [Vec2::ZERO, Vec2::new(100.0, 0.0), Vec2::new(1.0, 1.0)] {
        camera.fit_centered(points.iter().copied(), size, [0.0, 0.0, 130.0, 0.0]);
        assert!(
            camera.target.is_finite() && camera.distance.is_finite(),
            "{size}"
        );
    }
}

#[test]
fn a_minimised_window_gives_a_finite_matrix() {
    let mut camera = Camera::default();
    camera.fit(Vec3::ZERO, 0.0, Vec2::ZERO);
    assert!(camera.clip_from_world(Vec2::ZERO).is_finite());
    assert!(camera.ray(Vec2::ZERO, Vec2::ZERO).direction.is_finite());
}
