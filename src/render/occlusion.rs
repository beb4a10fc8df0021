//! The share of the sky that each corner of a mesh sees past its own object, for ambient occlusion.
//!
//! Computed once by rays through a tree of boxes. Objects are rigid, so it stays valid however they move. Occlusion by other objects
//! is computed from the distances between objects, in the picture itself.

use std::collections::HashMap;
use std::f32::consts::TAU;

use glam::{Vec3, Vec3A};
use rayon::prelude::*;

use super::rays::Rays;
use crate::mesh::surface::Surface;

/// Rays of a place; fewer where there are many places.
const RAYS: (usize, usize) = (8, 48);
/// Rays of all places together, about: a fifth of a second on two cores; more would be felt when a scene is opened.
const ALL_RAYS: usize = 500_000;
/// With more places than this, occlusion is not computed, and all places see the whole sky.
pub(super) const MOST_PLACES: usize = 200_000;
/// Occluders farther than this do not count, in radii of the object.
const REACH: f32 = 0.8;
/// How far from the surface rays begin, in radii of the object.
const OFF: f32 = 2e-3;

/// For each corner of each triangle, `3 * triangle + corner`, the share of the sky above it that is open, squared for stronger contrast: 0
/// to 255; the number of places where there are more than `most_places`. `normals` has one for each.
pub fn openness(surface: &Surface, normals: &[Vec3], most_places: usize) -> Result<Vec<u8>, usize> {
    let mut open = vec![255; normals.len()];
    let mut places: Vec<Vec<(u32, Vec3)>> = Vec::new();
    let mut place_of = vec![0_u32; normals.len()];
    for object in &surface.objects {
        let (first, end) = object.triangles;
        let mut known = HashMap::new();
        let mut own = Vec::new();
        for corner in 3 * first as usize..3 * end as usize {
            let vertex = surface.corners[corner / 3][corner % 3];
            let bits = normals[corner].to_array().map(f32::to_bits);
            place_of[corner] = *known.entry((vertex, bits)).or_insert_with(|| {
                own.push((vertex, normals[corner]));
                own.len() as u32 - 1
            });
        }
        places.push(own);
    }
    let count: usize = places.iter().map(Vec::len).sum();
    if count > most_places {
        return Err(count);
    }
    let rays = (ALL_RAYS / count.max(1)).clamp(RAYS.0, RAYS.1);
    for (object, own) in surface.objects.iter().zip(&places) {
        let (first, end) = object.triangles;
        let found = of_object(surface, (first as usize, end as usize), own, rays);
        for corner in 3 * first as usize..3 * end as usize {
            open[corner] = found[place_of[corner] as usize];
        }
    }
    Ok(open)
}

/// Openness of places on one object, each a vertex and a normal.
fn of_object(
    surface: &Surface,
    (first, end): (usize, usize),
    places: &[(u32, Vec3)],
    rays: usize,
) -> Vec<u8> {
    let Some(object) = Rays::new(&surface.positions, &surface.corners[first..end]) else {
        return vec![255; places.len()];
    };
    let fan = fan(rays);
    places
        .par_iter()
        .map(|&(vertex, normal)| {
            let corner = surface.positions[vertex as usize];
            let open = open_share(&object, corner.into(), normal.into(), &fan);
            (255.0 * open * open).round() as u8
        })
        .collect()
}

/// The share of the sky that one place sees.
fn open_share(object: &Rays, corner: Vec3A, normal: Vec3A, fan: &[Vec3]) -> f32 {
    let reach = REACH * object.radius;
    let from = corner + OFF * object.radius * normal;
    let (side, other) = normal.any_orthonormal_pair();
    // 1 for a close occluder, 0 for one at `reach` or for none.
    let hidden: f32 = fan
        .iter()
        .map(|ray| ray.x * side + ray.y * other + ray.z * normal)
        .map(|direction| 1.0 - object.free(from, direction, 0.0, reach) / reach)
        .sum();
    1.0 - hidden / fan.len() as f32
}

/// Directions about +Z, each with the weight of its cosine: Malley's method on the points of a sunflower (Vogel 1979).
fn fan(rays: usize) -> Vec<Vec3> {
    let golden = 0.618_034;
    (0..rays)
        .map(|i| {
            let square = (i as f32 + 0.5) / rays as f32;
            let (sin, cos) = (TAU * golden * i as f32).sin_cos();
            Vec3::new(
                square.sqrt() * cos,
                square.sqrt() * sin,
                (1.0 - square).sqrt(),
            )
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::normals::{CREASE_ANGLE, corner_normals};
    use crate::scene::Scene;
    use crate::scene::settings::Settings;

    fn open_of(mesh: &str) -> (Scene, Vec<u8>) {
        let mut settings = Settings::default();
        settings.objects[0].mesh = mesh.to_owned();
        let scene = Scene::from_settings("test".to_owned(), settings, ".".into()).unwrap();
        let normals = corner_normals(&scene.surface, CREASE_ANGLE);
        let open = openness(&scene.surface, &normals, MOST_PLACES).unwrap();
        (scene, open)
    }

    #[test]
    fn of_too_many_places_it_is_said_how_many_there_are() {
        let mut settings = Settings::default();
        settings.objects[0].mesh = "builtin:torus?major=700&minor=300".to_owned();
        let scene = Scene::from_settings("test".to_owned(), settings, ".".into()).unwrap();
        let normals = corner_normals(&scene.surface, CREASE_ANGLE);
        let found = openness(&scene.surface, &normals, MOST_PLACES);
        assert_eq!(found, Err(210_000));
    }

    #[test]
    fn the_open_share_of_the_sky_is_squared() {
        let (scene, open) = open_of("builtin:torus?major=48&minor=24&tube=0.7");
        let surface = &scene.surface;
        let (darkest, &found) = (open.iter().enumerate())
            .min_by_key(|(_, open)| **open)
            .unwrap();
        let normal = corner_normals(surface, CREASE_ANGLE)[darkest];
        let vertex = surface.corners[darkest / 3][darkest % 3];
        let corner = surface.positions[vertex as usize];
        let object = Rays::new(&surface.positions, &surface.corners).unwrap();
        let share = open_share(&object, corner.into(), normal.into(), &fan(RAYS.1));
        assert!((0.2..0.8).contains(&share), "{share}");
        let expected = 255.0 * share * share;
        assert!((f32::from(found) - expected).abs() <= 1.0, "{found}");
    }

    #[test]
    fn what_is_convex_sees_the_whole_sky() {
        for mesh in ["builtin:cube", "builtin:icosphere?subdivisions=3"] {
            let (_, open) = open_of(mesh);
            assert!(open.iter().all(|&share| share > 250), "{mesh}");
        }
    }

    #[test]
    fn a_ring_is_darker_inside_than_outside_and_alike_all_round() {
        let (scene, open) = open_of("builtin:torus?major=48&minor=24");
        let surface = &scene.surface;
        let of = |inside: bool| -> Vec<u8> {
            let places = surface.corners.as_flattened().iter().zip(&open);
            let radii = |v: u32| surface.positions[v as usize].with_y(0.0).length();
            let (least, most) = (0..surface.positions.len() as u32)
                .map(radii)
                .fold((f32::MAX, 0.0_f32), |(a, b), r| (a.min(r), b.max(r)));
            let edge = 0.02 * (most - least);
            places
                .filter(|(v, _)| {
                    let r = radii(**v);
                    if inside {
                        r < least + edge
                    } else {
                        r > most - edge
                    }
                })
                .map(|(_, &share)| share)
                .collect()
        };
        let [inside, outside] = [true, false].map(of);
        assert!(!inside.is_empty() && outside.iter().all(|&share| share > 250));
        let (low, high) = (inside.iter().min().unwrap(), inside.iter().max().unwrap());
        assert!(*high < 245 && high - low < 30, "{low} to {high}");
    }
}
