//! How long a device may take for the distances of one step, by the number of comparisons, so that slow computations do not count as hung.

use std::time::Duration;

use super::distance::DistanceSetup;
use crate::scene::settings::DistanceMethod;

/// Nanoseconds for one texel and triangle in `distance_brute`: four times what lavapipe takes on two cores.
const NS_A_TRIANGLE: u64 = 30;
/// Nanoseconds for a corner that `distance_raster` draws.
const NS_A_CORNER: u64 = 60;
/// Nanoseconds for a texel that `distance_raster` draws for a triangle.
const NS_A_FRAGMENT: u64 = 30;

/// The limit for the distances of all objects to all others that count for them, as if all of those were within reach.
#[must_use]
pub fn for_distances(setup: &DistanceSetup, method: DistanceMethod) -> Duration {
    let mut ns = 0_u64;
    let objects = setup.ranges.iter().zip(&setup.others).enumerate();
    for (object, (&(first, end), others)) in objects {
        let triangles = |object: usize| u64::from(setup.trees.objects[object].face_count);
        let texels = u64::from(end - first);
        // Triangles without a texel are not drawn.
        let drawn = triangles(object).min(texels);
        for &other in others {
            let looked_at = triangles(other as usize);
            ns = ns.saturating_add(match method {
                // Searches in trees are quick: if they take too long, the device has hung.
                DistanceMethod::Bvh => 0,
                DistanceMethod::Brute => NS_A_TRIANGLE * texels * looked_at,
                DistanceMethod::Raster => {
                    (3 * NS_A_CORNER * drawn + NS_A_FRAGMENT * texels) * looked_at
                }
            });
        }
    }
    Duration::from_nanos(ns)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene::{Overrides, Scene};
    use crate::sim::Setup;

    /// Times of lavapipe on two idle cores are less than half of the time limit.
    #[test]
    fn slow_methods_may_take_as_long_as_they_were_seen_to() {
        let scene = Scene::load(
            Path::new("trio"),
            &Overrides {
                set: ["particles.count=100", "atlas.size=192"]
                    .map(str::to_owned)
                    .into(),
                ..Overrides::default()
            },
        );
        let setup = Setup::new(&scene.unwrap()).unwrap();
        let seconds = |method| for_distances(&setup.distance, method).as_secs_f64();
        assert!(seconds(DistanceMethod::Raster) > 150.0);
        assert!(seconds(DistanceMethod::Brute) > 10.0);
        // A device that hangs is detected as soon as before.
        assert_eq!(seconds(DistanceMethod::Bvh), 0.0);
        let alone =
            Setup::new(&Scene::load(Path::new("builtin:cube"), &Overrides::default()).unwrap());
        let alone = alone.unwrap();
        assert_eq!(
            for_distances(&alone.distance, DistanceMethod::Raster),
            Duration::ZERO
        );
    }
}
