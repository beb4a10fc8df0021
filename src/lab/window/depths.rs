//! Surfaces seen in a brush's ring: a dab at its middle, and further dabs where surfaces are seen through the ring nearer or
//! farther than the first dab's ball reaches.

use glam::{Affine3A, Vec3};
use myxo::mesh::surface::Surface;
use myxo::render::camera::Ray;
use myxo::render::pick::{Hit, pick_bundles};
use myxo::sim::paint::{Ball, Dab, MOST_DEPTHS, Ring};

use crate::lab::marks::RunningMarks;
use crate::lab::tools::overlay::normal_towards;

/// Places seen farther than this from a ring's middle lie off the dab's ball, as a share of its radius: smooth surfaces seen
/// from the side exceed 1.
const OFF: f32 = 1.2;
/// The radius of balls over the ring's, so that places of one depth lie in them up to the ring's edge, also half a radius
/// nearer or farther than their middle.
const WIDER: f32 = 1.12;

/// The dabs of one frame's stroke, through the rings that are drawn round the pixels of these rays. If a ring shows one smooth
/// surface, its dab is one ball. Hidden objects are looked through, and locked ones have no dabs.
///
/// It iterates over the surface twice, however many rays there are.
pub fn dabs_seen(
    surface: &Surface,
    poses: &[Affine3A],
    marks: &RunningMarks,
    middles: &[Ray],
    dab: impl Fn(Vec3) -> Dab,
) -> Vec<Dab> {
    let alone: Vec<Vec<Ray>> = middles.iter().map(|ray| vec![*ray]).collect();
    let is_seen = |object: usize| !marks.is_hidden(object);
    let hits = pick_bundles(surface, poses, is_seen, &alone);
    let seen = middles.iter().zip(hits.into_iter().flatten());
    let (dabs, rings): (Vec<Dab>, Vec<Ring>) = seen
        .filter_map(|(ray, hit)| {
            let object = |hit: &Hit| surface.triangles[hit.triangle as usize].object as usize;
            let hit = hit.filter(|hit| !marks.is_locked(object(hit)))?;
            let ring = Ring {
                eye: ray.origin,
                normal: normal_at(surface, poses, &hit, ray.origin),
                balls: [None; MOST_DEPTHS],
            };
            Some((dab(hit.position), ring))
        })
        .unzip();
    let through: Vec<Vec<Ray>> = (dabs.iter().zip(&rings))
        .map(|(dab, ring)| through(dab, ring))
        .collect();
    let hits = pick_bundles(surface, poses, is_seen, &through);
    let seen = dabs.into_iter().zip(rings).zip(hits);
    seen.map(|((mut dab, mut ring), hits)| {
        let places: Vec<Option<Vec3>> = (hits.iter())
            .map(|hit| hit.map(|hit| hit.position))
            .collect();
        ring.balls = balls(&dab, ring.eye, &places);
        dab.ring = ring.balls[0].is_some().then_some(ring);
        dab
    })
    .collect()
}

fn normal_at(surface: &Surface, poses: &[Affine3A], hit: &Hit, eye: Vec3) -> Vec3 {
    let object = surface.triangles[hit.triangle as usize].object as usize;
    let corners = surface.corners[hit.triangle as usize].map(|vertex| {
        let place = surface.positions[vertex as usize];
        poses[object].transform_point3(place)
    });
    normal_towards(corners, eye)
}

/// The looks from the eye through a ring's plane.
fn through(dab: &Dab, ring: &Ring) -> Vec<Ray> {
    let [side, other] = ring.axes();
    let looks = Ring::looks().into_iter();
    looks
        .map(|look| {
            let place = dab.center + dab.radius * (look.x * side + look.y * other);
            Ray {
                origin: ring.eye,
                direction: (place - ring.eye).normalize_or(Vec3::Z),
            }
        })
        .collect()
}

/// Balls for the places that are seen through a ring and do not lie in the dab's own ball: one behind the other along the ray
/// through its middle, and as large as the ring appears there. If there are too many, those with most places are kept. There is
/// a place for each ray that hits a surface.
fn balls(dab: &Dab, eye: Vec3, places: &[Option<Vec3>]) -> [Option<Ball>; MOST_DEPTHS] {
    let to_middle = dab.center - eye;
    let (way, middle) = (to_middle.normalize_or(Vec3::Z), to_middle.length());
    let radius_at = |depth: f32| dab.radius * depth / middle;
    let met = (0..)
        .zip(places)
        .filter_map(|(look, place)| Some((look, (*place)?)));
    let mut depths: Vec<(u32, f32)> = met
        .filter(|(_, place)| place.distance(dab.center) > OFF * dab.radius)
        .map(|(look, place)| (look, (place - eye).dot(way)))
        .filter(|(_, depth)| *depth > 0.0)
        .collect();
    depths.sort_by(|a, b| a.1.total_cmp(&b.1));
    // Places within one radius share a ball.
    let mut groups: Vec<&[(u32, f32)]> = Vec::new();
    let mut rest = &depths[..];
    while let Some((_, first)) = rest.first() {
        let end = first + radius_at(*first);
        let (group, farther) = rest.split_at(rest.partition_point(|(_, depth)| *depth <= end));
        groups.push(group);
        rest = farther;
    }
    groups.sort_by_key(|group| std::cmp::Reverse(group.len()));
    let mut balls = [None; MOST_DEPTHS];
    for (ball, group) in balls.iter_mut().zip(groups) {
        let depth = group.iter().map(|(_, depth)| depth).sum::<f32>() / group.len() as f32;
        *ball = Some(Ball {
            center: eye + depth * way,
            radius: WIDER * radius_at(depth),
            looks: group.iter().fold(0, |looks, (look, _)| looks | 1 << look),
        });
    }
    balls
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;
    use myxo::render::Camera;
    use myxo::scene::Scene;
    use myxo::scene::settings::{ObjectSettings, Settings};
    use myxo::sim::Setup;
    use myxo::sim::paint::Brush;

    const SIZE: Vec2 = Vec2::new(640.0, 480.0);
    /// Radius of the ring, pixels.
    const RADIUS: f32 = 40.0;

    fn setup(objects: &[(&str, [f32; 3])]) -> Setup {
        let mut settings = Settings::default();
        settings.particles.count = 100;
        settings.atlas.size = 512;
        settings.objects = (objects.iter())
            .map(|(mesh, position)| ObjectSettings {
                mesh: format!("builtin:{mesh}"),
                position: position.map(f64::from),
                // Planes lie; these stand.
                rotation: if mesh.starts_with("plane") {
                    [90.0, 0.0, 0.0]
                } else {
                    [0.0; 3]
                },
                ..ObjectSettings::default()
            })
            .collect();
        let scene = Scene::from_settings("depths".to_owned(), settings, ".".into()).unwrap();
        Setup::new(&scene).unwrap()
    }

    fn poses(setup: &Setup) -> Vec<Affine3A> {
        let poses = setup.poses.iter().map(glam::DAffine3::from);
        poses
            .map(|pose| {
                Affine3A::from_mat3_translation(pose.matrix3.as_mat3(), pose.translation.as_vec3())
            })
            .collect()
    }

    /// The dab of a ring round the pixel where a place is seen.
    fn seen(setup: &Setup, camera: &Camera, place: Vec3) -> Dab {
        let pixel = camera.pixel(place, SIZE).unwrap();
        let poses = poses(setup);
        let ray = camera.ray(pixel, SIZE);
        let hit = myxo::render::pick::pick(&setup.surface, &poses, &ray).unwrap();
        let half_height = (0.5 * camera.vertical_fov).tan();
        let radius = RADIUS / SIZE.y * 2.0 * half_height * hit.distance;
        let dabs = dabs_seen(
            &setup.surface,
            &poses,
            &RunningMarks::default(),
            &[ray],
            |center| Dab {
                brush: Brush::Trail { amount: 1.0 },
                center,
                radius,
                eye: Some(camera.eye()),
                ring: None,
                number: 0,
            },
        );
        let [dab] = dabs[..] else {
            panic!("{} dabs", dabs.len())
        };
        dab
    }

    /// How strongly each of two objects is painted, all of it together, the farthest texel from the middle's pixel, and the
    /// pixel of the second object's that is farthest to the left.
    fn painted(setup: &Setup, camera: &Camera, dab: &Dab) -> ([f32; 2], f32, f32) {
        let poses = poses(setup);
        let middle = camera.pixel(dab.center, SIZE).unwrap();
        let (mut sums, mut farthest, mut leftmost) = ([0.0; 2], 0.0_f32, f32::MAX);
        for texel in dab.texels(setup, &setup.poses).unwrap() {
            sums[texel.object as usize] += texel.weight;
            let (triangle, u, v) = setup.atlas.surface_point_of(texel.texel).unwrap();
            let [a, b, c] = setup.surface.corners[triangle as usize]
                .map(|vertex| setup.surface.positions[vertex as usize]);
            let place = a + u * (b - a) + v * (c - a);
            let place = poses[texel.object as usize].transform_point3(place);
            let pixel = camera.pixel(place, SIZE).unwrap();
            farthest = farthest.max(pixel.distance(middle));
            if texel.object == 1 {
                leftmost = leftmost.min(pixel.x);
            }
        }
        (sums, farthest, leftmost)
    }

    fn camera() -> Camera {
        let mut camera = Camera {
            target: Vec3::ZERO,
            distance: 6.0,
            ..Camera::default()
        };
        camera.yaw = 0.0;
        camera.pitch = 0.0;
        camera
    }

    #[test]
    fn surfaces_seen_in_the_ring_are_painted_in_front_and_behind() {
        // One plane stands before the other, and does not reach as far to the right.
        let setup = setup(&[
            ("plane?columns=8&rows=8", [-1.0, 0.0, 1.0]),
            ("plane?columns=8&rows=8", [0.5, 0.0, -1.0]),
        ]);
        let camera = camera();
        let poses = poses(&setup);
        let (first, end) = setup.surface.objects[0].vertices;
        let own = setup.surface.positions[first as usize..end as usize].iter();
        let right = own.map(|place| poses[0].transform_point3(*place).x);
        let right = right.fold(f32::MIN, f32::max);
        let edge = Vec3::new(right, 0.0, 1.0);
        // Left of the edge the ring's middle is in front, right of it behind.
        for (middle, hit) in [(-0.05, 0), (0.05, 1)] {
            let dab = seen(&setup, &camera, edge + middle * Vec3::X);
            let (sums, farthest, leftmost) = painted(&setup, &camera, &dab);
            assert!(sums[0] > 20.0 && sums[1] > 20.0, "{hit}: {sums:?}");
            assert!(
                farthest < 1.05 * RADIUS,
                "{farthest} pixels from the middle"
            );
            let alone = Dab { ring: None, ..dab };
            let (alone, ..) = painted(&setup, &camera, &alone);
            assert_eq!(alone[1 - hit], 0.0, "the ball alone does not reach it");
            assert!((sums[hit] - alone[hit]).abs() < 1e-3, "not twice");
            if hit == 0 {
                let edge = camera.pixel(edge, SIZE).unwrap().x;
                assert!(
                    leftmost > edge - 0.4 * RADIUS,
                    "what the front hides is left alone"
                );
            }
            let balls = dab.ring.map(|ring| ring.balls.iter().flatten().count());
            assert_eq!(balls, Some(1), "places of one depth share a ball");
        }
        // Far from the edge there is one dab, as there is on what is round.
        for place in [edge - 0.7 * Vec3::X, edge + 0.7 * Vec3::X] {
            assert_eq!(seen(&setup, &camera, place).ring, None);
        }
    }

    #[test]
    fn one_smooth_surface_has_one_ball() {
        let setup = setup(&[("icosphere?subdivisions=5", [0.0; 3])]);
        let camera = camera();
        let highest = setup.surface.positions.iter().map(|place| place.y);
        let radius = highest.fold(0.0, f32::max);
        for share in [0.0, 0.3, 0.6] {
            let dab = seen(&setup, &camera, share * radius * Vec3::X);
            assert_eq!(dab.ring, None, "at {share} of its radius");
        }
    }

    #[test]
    fn balls_are_for_depths_that_most_places_have() {
        let dab = Dab {
            brush: Brush::NoGo,
            center: Vec3::new(0.0, 0.0, -10.0),
            radius: 1.0,
            eye: None,
            ring: None,
            number: 0,
        };
        let depths = [10.2, 12.0, 12.4, 12.8, 20.0, 20.5, 30.0, 40.0, 40.1];
        let places = depths.map(|depth| Some(Vec3::new(0.0, 0.5, -depth)));
        let found = balls(&dab, Vec3::ZERO, &places).map(|ball| ball.unwrap());
        for (ball, (wanted, looks)) in
            (found.into_iter()).zip([(12.4, 0b1110), (20.25, 0b11_0000), (40.05, 0b1_1000_0000)])
        {
            assert!((-ball.center.z - wanted).abs() < 1e-3);
            assert!((ball.radius - WIDER * 0.1 * wanted).abs() < 1e-3);
            assert_eq!(ball.looks, looks);
        }
        let near = [Some(Vec3::new(0.3, 0.5, -10.2)); 12];
        assert_eq!(balls(&dab, Vec3::ZERO, &near), [None; MOST_DEPTHS]);
    }
}
