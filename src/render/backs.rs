//! Tests whether back faces of an object can be seen from outside. They cannot if the object encloses a volume and faces outwards
//! everywhere. A closed surface may also cross itself, so that a part of it is visible inside out.

use glam::{Vec3, Vec3A};
use rayon::prelude::*;

use super::rays::Rays;
use crate::kept_files::{Hash, KeptFile, OCCLUSION};
use crate::mesh::atlas::{AtlasError, Control};
use crate::mesh::surface::Surface;

/// About so many triangles are tested; of larger objects every second, third and so on.
const SAMPLES: usize = 20_000;
/// A back face counts as visible if so many rays from it escape: a single one may pass between two triangles.
const AWAY: usize = 2;
/// Rays begin so far behind a triangle, in radii of the object.
const OFF: f32 = 1e-5;

/// Raised whenever the answer may be another one than before.
const VERSION: u32 = 1;
/// Name of this work in progress reports.
pub(super) const DOING: &str = "testing back faces";

/// For each object: are backs of its triangles seen from outside? Kept in the control's folder, if that has one, and read the next
/// time.
///
/// # Errors
/// [`AtlasError::Cancelled`] when the work was stopped.
pub(super) fn seen_backs(
    surface: &Surface,
    control: &Control<'_>,
) -> Result<Vec<bool>, AtlasError> {
    control.step(DOING, 0.0)?;
    let file = { control.cache }.map(|folder| KeptFile::new(folder, key(surface), &OCCLUSION));
    let count = surface.objects.len();
    let all = |content: &[u8]| {
        let is_whole = content.len() == count && content.iter().all(|&seen| seen <= 1);
        is_whole.then(|| content.iter().map(|&seen| seen == 1).collect())
    };
    if let Some(kept) = file.as_ref().and_then(|file| file.load(all)) {
        return Ok(kept);
    }
    let mut found = Vec::with_capacity(count);
    for (object, range) in surface.objects.iter().enumerate() {
        let (first, end) = range.triangles;
        let corners = &surface.corners[first as usize..end as usize];
        found.push(!surface.is_closed(object) || are_seen(&surface.positions, corners));
        control.step(DOING, found.len() as f32 / count as f32)?;
    }
    if let Some(file) = file {
        let content: Vec<u8> = found.iter().map(|&seen| u8::from(seen)).collect();
        file.store(&content);
    }
    Ok(found)
}

/// A hash of everything that the answer depends on.
fn key(surface: &Surface) -> u128 {
    let mut hash = Hash::new();
    hash.slice(b"backs");
    hash.slice(&[VERSION, SAMPLES as u32, AWAY as u32]);
    hash.slice(&[OFF]);
    hash.slice(&surface.positions);
    hash.slice(&surface.corners);
    // Whether it is closed.
    hash.slice(&surface.halfedges);
    for object in &surface.objects {
        hash.slice(&[object.triangles.0, object.triangles.1]);
    }
    hash.finish()
}

/// Casts rays from the backs of triangles: from inside, no ray escapes.
fn are_seen(positions: &[Vec3], corners: &[[u32; 3]]) -> bool {
    let Some(rays) = Rays::new(positions, corners) else {
        return true;
    };
    let stride = corners.len().div_ceil(SAMPLES);
    (0..corners.len())
        .into_par_iter()
        .step_by(stride)
        .any(|triangle| is_seen(&rays, triangle))
}

fn is_seen(rays: &Rays, triangle: usize) -> bool {
    let triangle = &rays.triangles[triangle];
    let centre = (triangle.v0 + triangle.v1 + triangle.v2) / 3.0;
    let normal = (triangle.v1 - triangle.v0).cross(triangle.v2 - triangle.v0);
    let Some(back) = (-normal).try_normalize() else {
        return false;
    };
    let (side, other) = back.any_orthonormal_pair();
    // Straight back, and half sideways all round.
    let ways: [Vec3A; 6] = [
        back,
        back + 0.9 * side,
        back + 0.28 * side + 0.86 * other,
        back - 0.73 * side + 0.53 * other,
        back - 0.73 * side - 0.53 * other,
        back + 0.28 * side - 0.86 * other,
    ];
    let end = 4.0 * rays.radius;
    let away = ways
        .into_iter()
        .filter(|way| rays.free(centre, way.normalize(), OFF * rays.radius, end) >= end);
    away.take(AWAY).count() == AWAY
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use crate::scene::settings::{ObjectSettings, Settings};
    use std::sync::Mutex;

    fn mesh(name: &str) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let mut settings = Settings::default();
        settings.objects[0].mesh = name.to_owned();
        let scene = Scene::from_settings("test".to_owned(), settings, ".".into()).unwrap();
        (
            scene.surface.positions.clone(),
            scene.surface.corners.clone(),
        )
    }

    #[test]
    fn what_is_kept_equals_what_is_found_and_damage_is_mended() {
        let folder = tempfile::tempdir().unwrap();
        let meshes = ["builtin:plane", "builtin:icosphere", "builtin:cube"];
        let objects = meshes.map(|mesh| ObjectSettings {
            mesh: mesh.to_owned(),
            ..ObjectSettings::default()
        });
        let settings = Settings {
            objects: objects.to_vec(),
            ..Settings::default()
        };
        let scene = Scene::from_settings("test".to_owned(), settings, ".".into()).unwrap();
        let reports = Mutex::new(0);
        let count = |_: &'static str, _: f32| *reports.lock().unwrap() += 1;
        let control = Control {
            progress: Some(&count),
            cache: Some(folder.path()),
            ..Control::default()
        };
        let seen = || {
            *reports.lock().unwrap() = 0;
            let found = seen_backs(&scene.surface, &control).unwrap();
            // There is but one report where nothing is looked for.
            (found, *reports.lock().unwrap() > 1)
        };
        let plain = vec![true, false, false];
        assert_eq!(seen(), (plain.clone(), true));
        assert_eq!(seen(), (plain.clone(), false));
        let kept = KeptFile::new(folder.path(), key(&scene.surface), &OCCLUSION);
        for wrong in [&[1, 0][..], &[1, 0, 2]] {
            kept.store(wrong);
            assert_eq!(seen(), (plain.clone(), true), "{wrong:?}");
        }
        std::fs::write(kept.path(), "foreign").unwrap();
        assert_eq!(seen(), (plain.clone(), true));
        assert_eq!(seen(), (plain, false));
    }

    #[test]
    fn back_faces_of_a_closed_volume_are_never_seen() {
        for name in [
            "builtin:cube",
            "builtin:torus",
            "builtin:trefoil",
            "builtin:gyroid",
            "builtin:gear",
            "builtin:ring_gear",
        ] {
            let (positions, corners) = mesh(name);
            assert!(!are_seen(&positions, &corners), "{name}");
        }
        let (positions, corners) = mesh("builtin:plane");
        assert!(are_seen(&positions, &corners));
    }

    /// A ball with a smaller, inverted ball in it: a hollow, or a visible back face if it sticks out.
    #[test]
    fn everybody_sees_what_sticks_out_inside_out() {
        let (ball, triangles) = mesh("builtin:icosphere?subdivisions=3");
        let with = |x: f32| {
            let place = |p: &Vec3| 0.3 * *p + Vec3::new(x, 0.1, 0.0);
            let positions: Vec<Vec3> = ball.iter().copied().chain(ball.iter().map(place)).collect();
            let count = ball.len() as u32;
            let reversed = triangles
                .iter()
                .map(|&[a, b, c]| [a, c, b].map(|v| v + count));
            let corners: Vec<[u32; 3]> = triangles.iter().copied().chain(reversed).collect();
            are_seen(&positions, &corners)
        };
        assert!(!with(0.3));
        assert!(with(1.0));
        let all_turned: Vec<[u32; 3]> = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
        assert!(are_seen(&ball, &all_turned));
    }
}
