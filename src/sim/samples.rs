//! The surface points under texels, in tiles: a few of them that lie close together, so that what is far from one of
//! them, or near, is so for all.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::types::{SampleTile, SurfaceSample};
use crate::mesh::atlas::Atlas;
use crate::mesh::surface::Surface;

/// Samples side by side that share one hint for each other object; a group of invocations is a multiple of them.
pub const TILE_SAMPLES: u32 = 16;

/// Half a tile: as many as CPU drivers take at once.
const HALF: usize = TILE_SAMPLES as usize / 2;

/// Slices below this are put in order by one thread.
const ALONE: usize = 1 << 13;

/// An owned texel: the surface point under it, and the triangle that owns it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Owned {
    /// Global triangle id.
    pub triangle: u32,
    /// Its surface point.
    pub sample: SurfaceSample,
}

/// Every object's owned texels, tile by tile.
pub(super) fn owned_texels(surface: &Surface, atlas: &Atlas) -> Vec<Vec<Owned>> {
    let mut texels: Vec<Owned> = (0..atlas.texel_count() as u32)
        .into_par_iter()
        .filter_map(|texel| {
            let (triangle, u, v) = atlas.surface_point_of(texel)?;
            let corners = surface.corners[triangle as usize];
            let [a, b, c] = corners.map(|vertex| surface.positions[vertex as usize].as_dvec3());
            let position: DVec3 = a + f64::from(u) * (b - a) + f64::from(v) * (c - a);
            let position = position.as_vec3();
            let sample = SurfaceSample { position, texel };
            Some(Owned { triangle, sample })
        })
        .collect();
    let object = |owned: &Owned| surface.triangles[owned.triangle as usize].object;
    texels.par_sort_by_key(object);
    let objects = 0..surface.objects.len() as u32;
    objects
        .map(|index| {
            let start = texels.partition_point(|owned| object(owned) < index);
            let end = texels.partition_point(|owned| object(owned) <= index);
            let mut own = texels[start..end].to_vec();
            put_together(&mut own);
            own
        })
        .collect()
}

/// Halves the box round the samples across its longest side, and its halves, until they are half tiles. Charts of the
/// atlas are too ragged for this: squares of texels leave tiles of twice the radius behind.
fn put_together(owned: &mut [Owned]) {
    if owned.len() <= HALF {
        owned.sort_unstable_by_key(|owned| owned.sample.texel);
        return;
    }
    let unit = if owned.len() > 2 * HALF {
        2 * HALF
    } else {
        HALF
    };
    // Whole tiles in the first half; only an object's last tile is not full.
    let middle = (owned.len() / 2).next_multiple_of(unit);
    let (low, high) = bounds(owned.iter().map(|owned| owned.sample.position));
    let axis = (high - low).max_position();
    let along = |owned: &Owned| owned.sample.position[axis];
    // By texel where they lie alike, so that the order is one.
    let (first, _, _) = owned.select_nth_unstable_by(middle, |a, b| {
        let order = along(a).total_cmp(&along(b));
        order.then(a.sample.texel.cmp(&b.sample.texel))
    });
    let middle = first.len();
    let (first, second) = owned.split_at_mut(middle);
    if first.len() < ALONE {
        put_together(first);
        put_together(second);
    } else {
        rayon::join(|| put_together(first), || put_together(second));
    }
}

/// A ball round samples, about the middle of their box.
pub(super) fn tile_of(samples: &[SurfaceSample]) -> SampleTile {
    let places = samples.iter().map(|sample| sample.position);
    let (low, high) = bounds(places.clone());
    let center = low.midpoint(high);
    let far = places.map(|place| place.as_dvec3().distance_squared(center.as_dvec3()));
    // Rounded up.
    let radius = far.fold(0.0, f64::max).sqrt() * 1.000_001;
    SampleTile {
        center,
        radius: radius as f32,
    }
}

fn bounds(places: impl Iterator<Item = Vec3>) -> (Vec3, Vec3) {
    let empty = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    places.fold(empty, |(low, high), place| {
        (low.min(place), high.max(place))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a square grid that come in no order: tiles of four by four, each texel once, whatever the threads.
    #[test]
    fn tiles_are_compact_and_whole() {
        let side = 256_u32;
        let count = side * side + 5;
        let shuffled: Vec<Owned> = (0..count)
            .map(|i| i * 40_499 % count)
            .map(|texel| Owned {
                triangle: texel / 7,
                sample: SurfaceSample {
                    position: Vec3::new((texel % side) as f32, (texel / side) as f32, 0.0),
                    texel,
                },
            })
            .collect();
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let mut owned = shuffled.clone();
            pool.unwrap().install(|| put_together(&mut owned));
            owned.iter().map(|o| o.sample).collect::<Vec<_>>()
        };
        let samples = with(1);
        assert!(samples == with(3));
        let mut texels: Vec<u32> = samples.iter().map(|sample| sample.texel).collect();
        texels.sort_unstable();
        assert!(texels.into_iter().eq(0..count));
        let tiles: Vec<SampleTile> = samples.chunks(TILE_SAMPLES as usize).map(tile_of).collect();
        let mean = tiles.iter().map(|tile| tile.radius).sum::<f32>() / tiles.len() as f32;
        assert!((2.0..2.5).contains(&mean), "{mean}");
        assert!(tiles.iter().all(|tile| tile.radius < 6.0));
    }
}
