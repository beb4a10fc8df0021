//! Limits of the distance method `brute` on a CPU.

use super::loops::ROUNDS;
use super::setup::others;
use crate::gpu::{DeviceInfo, DeviceKind};
use crate::mesh::surface::Surface;
use crate::scene::parameters::grouped;
use crate::scene::settings::{DistanceMethod, Settings};

/// Triangles that `distance_brute` looks at in a round of its loop.
const FACES_A_ROUND: u64 = 4;

/// With the method `brute`, makes sure that the other objects of no object have more triangles than the device can search.
///
/// # Errors
/// Names the first such object, the number of triangles, and what helps.
pub fn check(device: &DeviceInfo, surface: &Surface, settings: &Settings) -> Result<(), String> {
    let is_asked = settings.objects.len() > 1 && settings.distance.method == DistanceMethod::Brute;
    if !is_asked || device.kind != DeviceKind::Cpu {
        return Ok(());
    }
    let triangles = |object: &u32| {
        let (first, end) = surface.objects[*object as usize].triangles;
        u64::from(end - first)
    };
    for (object, others) in others(settings).into_iter().enumerate() {
        let in_rounds = |other| triangles(other).div_ceil(FACES_A_ROUND) + 1;
        if others.iter().map(in_rounds).sum::<u64>() > ROUNDS.into() {
            let all = others.iter().map(triangles).sum::<u64>();
            return Err(format!(
                "distance.method = \"brute\" looks at all {} triangles of other objects for each texel of `{}`, and this \
                 device ends loops after about {}: use distance.method = \"bvh\", smaller meshes, or `distance_to`",
                grouped(all as f64),
                settings.objects[object].name,
                grouped((FACES_A_ROUND * u64::from(ROUNDS)) as f64),
            ));
        }
    }
    Ok(())
}
