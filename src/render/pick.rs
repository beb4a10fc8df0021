//! What lies under the pointer: the first triangle that a ray meets, found on the host.

use glam::{Affine3A, Vec3};

use super::camera::Ray;
use crate::mesh::surface::Surface;

/// Where a ray meets a surface.
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

/// The nearest hit of a ray with any object, from either side; `world_from_object` has one pose an object.
///
/// Every triangle is tried: a million take a few milliseconds, and nobody clicks more often than that.
#[must_use]
pub fn pick(surface: &Surface, world_from_object: &[Affine3A], ray: &Ray) -> Option<Hit> {
    let mut nearest: Option<Hit> = None;
    for (range, pose) in surface.objects.iter().zip(world_from_object) {
        let object_from_world = pose.inverse();
        let in_object = Ray {
            origin: object_from_world.transform_point3(ray.origin),
            direction: object_from_world.transform_vector3(ray.direction),
        };
        for triangle in range.triangles.0..range.triangles.1 {
            let corners =
                surface.corners[triangle as usize].map(|vertex| surface.positions[vertex as usize]);
            let Some((u, v, distance)) = meet(&in_object, corners) else {
                continue;
            };
            if nearest.is_none_or(|hit| distance < hit.distance) {
                let position = ray.origin + distance * ray.direction;
                nearest = Some(Hit {
                    triangle,
                    u,
                    v,
                    position,
                    distance,
                });
            }
        }
    }
    nearest
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
    fn a_ray_past_everything_hits_nothing() {
        let surface = Surface::build(&[(&Mesh::builtin("cube").unwrap(), 1.0)]);
        let ray = |origin, direction| Ray { origin, direction };
        let poses = [Affine3A::IDENTITY];
        assert_eq!(
            pick(&surface, &poses, &ray(Vec3::new(3.0, 0.0, 0.0), Vec3::Y)),
            None
        );
        // Behind the eye is not in front of it.
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
