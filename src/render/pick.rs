//! Picking: the first triangle that a ray meets, found on the host.

use glam::{Affine3A, Vec3};

use super::camera::Ray;
use crate::mesh::surface::Surface;

/// The hit of a ray with a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Global triangle id.
    pub triangle: u32,
    /// Barycentric weight of corner B.
    pub u: f32,
    /// Barycentric weight of corner C.
    pub v: f32,
    /// The place in world space.
    pub position: Vec3,
    /// From the ray's origin, world units.
    pub distance: f32,
}

/// The nearest hit of a ray with any object, from either side; `world_from_object` has one pose an object, which may scale it
/// uniformly.
///
/// Every triangle is tried: a million take a few milliseconds, which is fast enough for clicks.
#[must_use]
pub fn pick(surface: &Surface, world_from_object: &[Affine3A], ray: &Ray) -> Option<Hit> {
    pick_among(surface, world_from_object, |_| true, ray)
}

/// As [`pick`], among those objects that are seen.
#[must_use]
pub fn pick_among(
    surface: &Surface,
    world_from_object: &[Affine3A],
    is_seen: impl Fn(usize) -> bool,
    ray: &Ray,
) -> Option<Hit> {
    let mut nearest = None;
    let objects = surface.objects.iter().zip(world_from_object).enumerate();
    for (_, (range, pose)) in objects.filter(|(object, _)| is_seen(*object)) {
        let in_object = ray.seen_from(pose);
        for triangle in range.triangles.0..range.triangles.1 {
            let corners =
                surface.corners[triangle as usize].map(|vertex| surface.positions[vertex as usize]);
            take_nearer(&mut nearest, triangle, corners, &in_object, ray);
        }
    }
    nearest
}

/// As [`pick`], for bundles of rays; the rays of a bundle have one origin and are close to each other. One pass over the triangles
/// serves all bundles, and most triangles are far from a bundle. Only objects that are seen count.
#[must_use]
pub fn pick_bundles(
    surface: &Surface,
    world_from_object: &[Affine3A],
    is_seen: impl Fn(usize) -> bool,
    bundles: &[Vec<Ray>],
) -> Vec<Vec<Option<Hit>>> {
    let mut hits: Vec<Vec<Option<Hit>>> =
        bundles.iter().map(|rays| vec![None; rays.len()]).collect();
    let cones: Vec<Cone> = bundles.iter().map(|rays| Cone::round(rays)).collect();
    let objects = surface.objects.iter().zip(world_from_object).enumerate();
    for (_, (range, pose)) in objects.filter(|(object, _)| is_seen(*object)) {
        let in_object: Vec<(Cone, Vec<Ray>)> = (cones.iter().zip(bundles))
            .map(|(cone, rays)| {
                let rays = rays.iter().map(|ray| ray.seen_from(pose)).collect();
                (cone.seen_from(pose), rays)
            })
            .collect();
        for triangle in range.triangles.0..range.triangles.1 {
            let corners =
                surface.corners[triangle as usize].map(|vertex| surface.positions[vertex as usize]);
            let [a, b, c] = corners;
            let middle = (a + b + c) / 3.0;
            let reach = corners.map(|corner| corner.distance_squared(middle));
            let reach = reach.into_iter().fold(0.0, f32::max).sqrt();
            for (bundle, (cone, rays)) in in_object.iter().enumerate() {
                if !cone.may_meet(middle, reach) {
                    continue;
                }
                for (i, ray) in rays.iter().enumerate() {
                    let nearest = &mut hits[bundle][i];
                    take_nearer(nearest, triangle, corners, ray, &bundles[bundle][i]);
                }
            }
        }
    }
    hits
}

/// Takes the hit of a ray with a triangle, if it is the nearest so far.
fn take_nearer(
    nearest: &mut Option<Hit>,
    triangle: u32,
    corners: [Vec3; 3],
    in_object: &Ray,
    ray: &Ray,
) {
    let Some((u, v, distance)) = meet(in_object, corners) else {
        return;
    };
    if nearest.is_none_or(|hit| distance < hit.distance) {
        *nearest = Some(Hit {
            triangle,
            u,
            v,
            position: ray.origin + distance * ray.direction,
            distance,
        });
    }
}

impl Ray {
    fn seen_from(&self, pose: &Affine3A) -> Self {
        let object_from_world = pose.inverse();
        Self {
            origin: object_from_world.transform_point3(self.origin),
            direction: object_from_world.transform_vector3(self.direction),
        }
    }
}

/// The cone around the rays of a bundle.
#[derive(Clone, Copy)]
struct Cone {
    axis: Ray,
    /// The cosine and sine of half its angle.
    sin: f32,
    cos: f32,
}

impl Cone {
    fn round(rays: &[Ray]) -> Self {
        let sum: Vec3 = rays.iter().map(|ray| ray.direction).sum();
        let axis = Ray {
            origin: rays.first().map_or(Vec3::ZERO, |ray| ray.origin),
            direction: sum.normalize_or(Vec3::Z),
        };
        let sines = rays.iter().map(|ray| {
            let is_before = ray.direction.dot(axis.direction) > 0.0;
            let sin = ray.direction.cross(axis.direction).length();
            if is_before { sin } else { 1.0 }
        });
        // Slightly wider than the rays, for rounding.
        let sin = (sines.fold(0.0, f32::max) + 1e-4).min(1.0);
        Self {
            axis,
            sin,
            cos: (1.0 - sin * sin).sqrt(),
        }
    }

    /// In an object's coordinates, which may be scaled.
    fn seen_from(&self, pose: &Affine3A) -> Self {
        let Ray { origin, direction } = self.axis.seen_from(pose);
        Self {
            axis: Ray {
                origin,
                direction: direction.normalize_or(Vec3::Z),
            },
            ..*self
        }
    }

    /// May a ball intersect the cone?
    fn may_meet(&self, middle: Vec3, reach: f32) -> bool {
        let from = middle - self.axis.origin;
        let along = from.dot(self.axis.direction);
        let beside = (from.length_squared() - along * along).max(0.0).sqrt();
        // Far away rounding errors are larger than small balls.
        let reach = 1.001 * reach + 1e-5 * along.abs();
        along >= -reach && beside * self.cos - along * self.sin <= reach
    }
}

/// Moeller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection" (1997): `u`, `v` and the distance.
fn meet(ray: &Ray, [a, b, c]: [Vec3; 3]) -> Option<(f32, f32, f32)> {
    let (ab, ac) = (b - a, c - a);
    let p = ray.direction.cross(ac);
    let determinant = ab.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let from_a = ray.origin - a;
    let u = from_a.dot(p) / determinant;
    let q = from_a.cross(ab);
    let v = ray.direction.dot(q) / determinant;
    let distance = ac.dot(q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0).then_some((u, v, distance))
}

#[cfg(test)]
mod tests {
    use glam::{Quat, Vec2};

    use super::*;
    use crate::mesh::Mesh;
    use crate::render::camera::Camera;

    #[test]
    fn the_nearest_of_two_objects_is_picked_where_the_camera_shows_it() {
        let cube = Mesh::builtin("cube").unwrap();
        let sphere = Mesh::builtin("icosphere?subdivisions=2").unwrap();
        let surface = Surface::build(&[(&cube, 1.0), (&sphere, 0.5)]);
        let turned = Affine3A::from_rotation_translation(
            Quat::from_rotation_y(0.6),
            Vec3::new(0.0, 0.0, 1.0),
        );
        let poses = [turned, Affine3A::from_translation(Vec3::new(2.5, 0.2, 0.0))];
        let size = Vec2::new(400.0, 300.0);
        let camera = Camera {
            distance: 9.0,
            ..Camera::default()
        };

        for (object, pose) in poses.iter().enumerate() {
            let centre = pose.transform_point3(Vec3::ZERO);
            let pixel = camera.pixel(centre, size).unwrap();
            let hit = pick(&surface, &poses, &camera.ray(pixel, size)).unwrap();
            let range = surface.objects[object].triangles;
            assert!((range.0..range.1).contains(&hit.triangle), "{hit:?}");
            assert!(camera.pixel(hit.position, size).unwrap().distance(pixel) < 0.05);
            assert!(
                hit.distance < camera.eye().distance(centre),
                "the near side is nearer than the centre"
            );
            // The barycentric weights name the same place.
            let [a, b, c] = surface.corners[hit.triangle as usize]
                .map(|vertex| surface.positions[vertex as usize]);
            let place = pose.transform_point3(a + hit.u * (b - a) + hit.v * (c - a));
            assert!(place.distance(hit.position) < 1e-4, "{place}");
        }
    }

    #[test]
    fn bundles_meet_what_their_rays_meet_one_by_one() {
        let meshes = [
            "icosphere?subdivisions=3",
            "cube",
            "torus?major=24&minor=12",
        ];
        let meshes = meshes.map(|name| Mesh::builtin(name).unwrap());
        let surface = Surface::build(&meshes.each_ref().map(|mesh| (mesh, 1.0)));
        let turned = Affine3A::from_rotation_translation(
            Quat::from_rotation_y(0.6),
            Vec3::new(0.0, 0.0, 1.0),
        );
        let poses = [
            turned,
            Affine3A::from_translation(Vec3::new(2.5, 0.2, 0.0)),
            // Drawn larger.
            Affine3A::from_translation(Vec3::new(-1.0, 0.4, -2.0))
                * Affine3A::from_scale(Vec3::splat(1.8)),
        ];
        let size = Vec2::new(160.0, 120.0);
        // From afar, and so near that triangles are beside the eye and behind it.
        for distance in [9.0, 1.4] {
            let camera = Camera {
                distance,
                ..Camera::default()
            };
            let bundles: Vec<Vec<Ray>> = (0..48)
                .map(|i| {
                    let middle = Vec2::new((i % 8) as f32 * 20.0, (i / 8) as f32 * 20.0);
                    let radius = 1.0 + 2.0 * i as f32;
                    let places = (0..12).map(|k| Vec2::from_angle(k as f32) * radius + middle);
                    places.map(|pixel| camera.ray(pixel, size)).collect()
                })
                .collect();
            let hits = pick_bundles(&surface, &poses, |_| true, &bundles);
            let one_by_one: Vec<Vec<Option<Hit>>> = (bundles.iter())
                .map(|rays| rays.iter().map(|ray| pick(&surface, &poses, ray)).collect())
                .collect();
            assert_eq!(hits, one_by_one);
            // Of those that are seen only.
            let is_seen = |object: usize| object != 1;
            let seen = pick_bundles(&surface, &poses, is_seen, &bundles);
            let all_rays = bundles.iter().flatten();
            let one_by_one = all_rays.map(|ray| pick_among(&surface, &poses, is_seen, ray));
            assert!(one_by_one.eq(seen.iter().flatten().copied()));
            let objects = seen.iter().flatten().flatten();
            let mut objects = objects.map(|hit| surface.triangles[hit.triangle as usize].object);
            assert!(objects.all(|object| object != 1));
            let count = hits.iter().flatten().flatten().count();
            assert!(count > 50, "{count}");
        }
        assert_eq!(
            pick_bundles(&surface, &poses, |_| true, &[Vec::new()]),
            [Vec::new()]
        );
    }

    #[test]
    fn a_ray_past_everything_hits_nothing() {
        let surface = Surface::build(&[(&Mesh::builtin("cube").unwrap(), 1.0)]);
        let ray = |origin, direction| Ray { origin, direction };
        let poses = [Affine3A::IDENTITY];
        assert_eq!(
            pick(&surface, &poses, &ray(Vec3::new(3.0, 0.0, 0.0), Vec3::Y)),
            None
        );
        // A triangle behind the eye is not hit.
        assert_eq!(
            pick(&surface, &poses, &ray(Vec3::new(0.1, 0.2, 3.0), Vec3::Z)),
            None
        );
        assert!(
            pick(
                &surface,
                &poses,
                &ray(Vec3::new(0.1, 0.2, 3.0), Vec3::NEG_Z)
            )
            .is_some()
        );
    }
}
