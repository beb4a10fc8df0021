//! Tests whether back faces of an object can be seen from outside. They cannot if the object encloses a volume and faces outwards
//! everywhere. A closed surface may also cross itself, so that a part of it is visible inside out.

use glam::{Vec3, Vec3A};
use rayon::prelude::*;

use super::rays::Rays;

/// About so many triangles are tested; of larger objects every second, third and so on.
const SAMPLES: usize = 20_000;
/// A back face counts as visible if so many rays from it escape: a single one may pass between two triangles.
const AWAY: usize = 2;
/// Rays begin so far behind a triangle, in radii of the object.
const OFF: f32 = 1e-5;

/// Casts rays from the backs of triangles: from inside, no ray escapes.
pub(super) fn are_seen(positions: &[Vec3], corners: &[[u32; 3]]) -> bool {
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
    use crate::scene::settings::Settings;

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
