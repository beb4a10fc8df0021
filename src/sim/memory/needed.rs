//! What is known of the memory that a scene takes before it is taken, and before there is an atlas.

use super::super::distance::{MOST_HINTS, TILE_SAMPLES};
use super::super::types::{ListedTile, SampleTile};
use super::{
    CANDIDATES, FIELDS, FOOD_FIELDS, NORMAL, SAMPLE, TEXEL, painted_bytes, particle_bytes,
    texel_bytes, texel_count, triangle_bytes,
};
use crate::mesh::trees::{Dipole, Face, Node};
use crate::scene::Scene;

/// About how many bytes a scene takes on the device, from its settings and meshes, before there is an atlas: what its
/// seams take, what the raster method draws from, the lists of transfers and those of whom food reaches come on top; of
/// several objects every texel is counted as if it belonged to one.
#[must_use]
pub fn needed(scene: &Scene) -> u64 {
    let settings = &scene.settings;
    let texels = texel_count(settings.atlas.size.into());
    let food = if settings.food_count() > 0 {
        FOOD_FIELDS
    } else {
        0
    };
    let painted = if settings.areas.map.is_empty() {
        0
    } else {
        TEXEL
    };
    let triangles = scene.surface.corners.len() as u64;
    particle_bytes(settings.particles.count.into(), scene.surface.objects.len())
        + texel_bytes(texels)
        + (food + painted) * texels
        + triangle_bytes(triangles)
        + distances_needed(scene.surface.objects.len() as u64, texels, triangles)
}

/// What distances between so many objects take.
fn distances_needed(objects: u64, texels: u64, triangles: u64) -> u64 {
    if objects < 2 {
        return 0;
    }
    let word = size_of::<u32>() as u64;
    // Its hints and how far it is from each of others' reach, its state, and its place in the list of those that are looked at.
    let hints = (objects - 1).min(MOST_HINTS.into());
    let tile = (size_of::<SampleTile>() + size_of::<ListedTile>()) as u64 + (1 + 2 * hints) * word;
    // Its triangle, and its place in the list of those that are covered.
    let sample = SAMPLE + 2 * word + CANDIDATES;
    let in_tree = (size_of::<Face>() + size_of::<Node>() + size_of::<Dipole>()) as u64;
    texels * (FIELDS + sample)
        + texels / u64::from(TILE_SAMPLES) * tile
        + triangles * (in_tree + 3 * NORMAL)
}

/// What a field that was painted takes, before there is an atlas.
#[must_use]
pub fn needed_for_painted(scene: &Scene) -> u64 {
    painted_bytes(texel_count(scene.settings.atlas.size.into()))
}
