//! The share of the sky that each corner of a mesh sees past its own object, for ambient occlusion.
//!
//! Computed once by rays through a tree of boxes. Objects are rigid, so it stays valid however they move. Occlusion by other objects
//! is computed from the distances between objects, in the picture itself.

use std::collections::HashMap;
use std::f32::consts::TAU;

use glam::{Vec3, Vec3A};
use rayon::prelude::*;

use super::rays::Rays;
use crate::kept_files::{Hash, KeptFile, OCCLUSION};
use crate::mesh::atlas::{AtlasError, Control};
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

/// Raised whenever corners are found to be open in another way than before.
const VERSION: u32 = 1;
/// Name of this work in progress reports.
pub(super) const DOING: &str = "computing light";
/// Rays between two progress reports, about.
const BATCH: usize = 100_000;

/// How open corners are; the number of places where there are too many.
pub type Openness = Result<Vec<u8>, usize>;

/// For each corner of each triangle, `3 * triangle + corner`, the share of the sky above it that is open, squared for
/// stronger contrast: 0 to 255; the number of places where there are more than `most_places`. `normals` has one
/// for each. It is kept in the control's folder, if that has one, and read the next time.
///
/// # Errors
/// [`AtlasError::Cancelled`] when the work was stopped.
pub fn openness(
    surface: &Surface,
    normals: &[Vec3],
    most_places: usize,
    control: &Control<'_>,
) -> Result<Openness, AtlasError> {
    control.step(DOING, 0.0)?;
    let file = control
        .cache
        .map(|folder| KeptFile::new(folder, key(surface, normals), &OCCLUSION));
    let all = |content: &[u8]| (content.len() == normals.len()).then(|| content.to_vec());
    if let Some(kept) = file.as_ref().and_then(|file| file.load(all)) {
        return Ok(Ok(kept));
    }
    let found = computed(surface, normals, most_places, control)?;
    if let (Some(file), Ok(open)) = (file, &found) {
        file.store(open);
    }
    Ok(found)
}

/// A hash of everything that the openness depends on, other than the greatest number of places.
fn key(surface: &Surface, normals: &[Vec3]) -> u128 {
    let mut hash = Hash::new();
    hash.slice(&[VERSION, RAYS.0 as u32, RAYS.1 as u32, ALL_RAYS as u32]);
    hash.slice(&[REACH, OFF]);
    hash.slice(&surface.positions);
    hash.slice(&surface.corners);
    for object in &surface.objects {
        hash.slice(&[object.triangles.0, object.triangles.1]);
    }
    hash.slice(normals);
    hash.finish()
}

/// As [`openness`], by rays.
fn computed(
    surface: &Surface,
    normals: &[Vec3],
    most_places: usize,
    control: &Control<'_>,
) -> Result<Openness, AtlasError> {
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
        return Ok(Err(count));
    }
    let rays = (ALL_RAYS / count.max(1)).clamp(RAYS.0, RAYS.1);
    let mut done = 0;
    for (object, own) in surface.objects.iter().zip(&places) {
        let (first, end) = object.triangles;
        let shares = [done, done + own.len()].map(|places| places as f32 / count as f32);
        let triangles = (first as usize, end as usize);
        let found = control.part(shares[0]..shares[1], |control| {
            of_object(surface, triangles, own, rays, control)
        })?;
        done += own.len();
        for corner in 3 * first as usize..3 * end as usize {
            open[corner] = found[place_of[corner] as usize];
        }
    }
    Ok(Ok(open))
}

/// Openness of places on one object, each a vertex and a normal.
fn of_object(
    surface: &Surface,
    (first, end): (usize, usize),
    places: &[(u32, Vec3)],
    rays: usize,
    control: &Control<'_>,
) -> Result<Vec<u8>, AtlasError> {
    let Some(object) = Rays::new(&surface.positions, &surface.corners[first..end]) else {
        return Ok(vec![255; places.len()]);
    };
    let fan = fan(rays);
    let mut open = Vec::with_capacity(places.len());
    for batch in places.chunks(BATCH / rays) {
        open.par_extend(batch.par_iter().map(|&(vertex, normal)| {
            let corner = surface.positions[vertex as usize];
            let open = open_share(&object, corner.into(), normal.into(), &fan);
            (255.0 * open * open).round() as u8
        }));
        control.step(DOING, open.len() as f32 / places.len() as f32)?;
    }
    Ok(open)
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
    use std::fs;
    use std::sync::Mutex;

    use crate::render::normals::{CREASE_ANGLE, corner_normals};
    use crate::scene::Scene;
    use crate::scene::settings::Settings;

    fn open_of(mesh: &str) -> (Scene, Vec<u8>) {
        let mut settings = Settings::default();
        settings.objects[0].mesh = mesh.to_owned();
        let scene = Scene::from_settings("test".to_owned(), settings, ".".into()).unwrap();
        let normals = corner_normals(&scene.surface, CREASE_ANGLE);
        let control = Control::default();
        let open = openness(&scene.surface, &normals, MOST_PLACES, &control).unwrap();
        (scene, open.unwrap())
    }

    #[test]
    fn of_too_many_places_it_is_said_how_many_there_are() {
        let mut settings = Settings::default();
        settings.objects[0].mesh = "builtin:torus?major=700&minor=300".to_owned();
        let scene = Scene::from_settings("test".to_owned(), settings, ".".into()).unwrap();
        let normals = corner_normals(&scene.surface, CREASE_ANGLE);
        let control = Control::default();
        let found = openness(&scene.surface, &normals, MOST_PLACES, &control);
        assert_eq!(found, Ok(Err(210_000)));
    }

    #[test]
    fn what_is_kept_equals_what_is_computed_and_damage_is_mended() {
        let folder = tempfile::tempdir().unwrap();
        let (scene, plain) = open_of("builtin:torus?major=48&minor=24&tube=0.7");
        let surface = &scene.surface;
        let reports = Mutex::new(0);
        let count = |doing: &'static str, _: f32| {
            assert_eq!(doing, DOING);
            *reports.lock().unwrap() += 1;
        };
        let control = Control {
            progress: Some(&count),
            cache: Some(folder.path()),
            ..Control::default()
        };
        let normals = corner_normals(surface, CREASE_ANGLE);
        let open = |normals: &[Vec3]| {
            *reports.lock().unwrap() = 0;
            let found = openness(surface, normals, MOST_PLACES, &control).unwrap();
            // There is but one report where nothing is computed.
            (found.unwrap(), *reports.lock().unwrap() > 1)
        };
        assert_eq!(open(&normals), (plain.clone(), true));
        assert_eq!(open(&normals), (plain.clone(), false));
        let files = || fs::read_dir(folder.path()).unwrap().map(Result::unwrap);
        let file = files().next().unwrap().path();
        let whole = fs::read(&file).unwrap();
        let mut flipped = whole.clone();
        *flipped.last_mut().unwrap() ^= 1;
        for broken in [&flipped[..], &whole[..whole.len() - 1], b"", b"foreign"] {
            fs::write(&file, broken).unwrap();
            assert_eq!(open(&normals), (plain.clone(), true));
            assert_eq!(open(&normals), (plain.clone(), false));
        }
        // A whole file of too few corners is none.
        let kept = KeptFile::new(folder.path(), key(surface, &normals), &OCCLUSION);
        kept.store(&plain[1..]);
        assert_eq!(open(&normals), (plain.clone(), true));
        // Other normals are another case.
        let flat = corner_normals(surface, 0.0);
        assert!(open(&flat).1);
        assert_eq!(files().count(), 2);
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
