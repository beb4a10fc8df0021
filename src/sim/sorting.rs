//! Particles in an order that keeps those near each other in the atlas together, so that the texels that a group of them reads and counts
//! are near each other, too. No result depends on the order, because ids move with the particles. With one strategy each particle keeps its
//! slot.
//!
//! Particles begin in order, and each step sorts a [segment](Segments) of them, which takes memory and time for one segment, not for all
//! particles. The order is that of [bins](Bins), which are numbered object by object, so that each object's particles stay in its window,
//! if there are windows.

use rayon::prelude::*;

use super::field::atlas_position;
use super::types::Particle;
use crate::mesh::strip::{StripTriangle, TileBins};

/// Steps in which each segment is sorted once: a particle takes about twice as many to leave a tile. On `trio` each step since the last
/// sort makes `advance` 0.3 to 0.5 ms slower and a sort of all takes 42 ms; the sum is smallest at 13 to 17 steps.
pub const SORT_INTERVAL: u64 = 16;

/// Devices that are CPUs sort up to so many particles at once. In segments a step of `torus` takes 6 to 10 % longer there with 500,000
/// particles and 6 to 8 % with 2,000,000, because particles that cross a seam are out of order for several rounds; with 8,000,000 it takes
/// the same time.
const AT_ONCE_ON_CPU: u32 = 1 << 22;

/// Otherwise a segment has at least so many particles: on a graphics card the kernels of a sort take 20 to 30 microseconds to begin, and a
/// step of so many particles 70 to 100.
const SMALLEST: u32 = 1 << 19;

/// Tiles have at least this side, as a power of two, in texels.
const SMALLEST_SHIFT: u32 = 4;

/// No tile is larger than the atlas.
const LARGEST_SHIFT: u32 = 16;

/// The least number of particles per bin, on average: on a CPU each sort passes through all bins, which should take less time than its work
/// on the particles. A graphics card adds up 16 times as many parts in 16 microseconds.
const PARTICLES_A_BIN: usize = 16;

/// The number of bins that may always be used, and the largest number of bins: sums over them take little time.
const FEW_BINS: usize = 1 << 10;
const MOST_BINS: usize = 1 << 16;

/// On a graphics card each bin is divided into parts, 4 by 4, while there are no more parts than this. Particles whose texels lie in fewer
/// cache lines are read in fewer pieces there: on an NVIDIA H200 this makes `advance` 8 % faster with 10 million particles at 1024 x 1024,
/// and 13 % with 100 million at 4096 x 4096; parts of 8 by 8 are no faster. On a CPU it gains nothing.
const PART_BITS: u32 = 2;
const MOST_PARTS: u32 = 1 << 20;

/// log2 of how many parts a bin has along each side on a device, if there are so many bins.
#[must_use]
pub fn part_bits(bins: u32, on_cpu: bool) -> u32 {
    let fits = |bits: &u32| bins <= MOST_PARTS >> (2 * bits);
    let most = if on_cpu { 0 } else { PART_BITS };
    (0..=most).rev().find(fits).unwrap_or(0)
}

/// The number of parts of all bins on the device that has the most.
#[must_use]
pub fn most_parts(bins: u32) -> u32 {
    bins << (2 * part_bits(bins, false))
}

/// Counts of parts that a group of the kernels adds up: 16 for each of 128 invocations.
pub const STRETCH: u32 = 2048;

/// The number of such stretches.
#[must_use]
pub fn stretches(parts: u32) -> u32 {
    parts.div_ceil(STRETCH)
}

/// The range of slots that a step sorts, counted from the first slot, or from the ring's beginning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segment {
    /// The first particle.
    pub first: u32,
    /// The number of particles.
    pub count: u32,
}

/// How particles are divided into segments: several of the same length, except for half a segment at one end. That end alternates from
/// round to round, so that each segment overlaps half of both neighbours of the round before, and a particle whose place is in another
/// segment moves by half a segment per round. All particles are in order after as many rounds as there are halves, and stay so if they move
/// little in a round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segments {
    particles: u32,
    /// A power of two, up to [`SORT_INTERVAL`].
    count: u32,
}

impl Segments {
    /// The division for so many particles: the most segments that are not too small for the fixed cost of the kernels.
    #[must_use]
    pub fn of(particles: u32, on_cpu: bool) -> Self {
        if on_cpu && particles <= AT_ONCE_ON_CPU {
            return Self::new(particles, 1);
        }
        let count = (particles / SMALLEST).clamp(1, SORT_INTERVAL as u32);
        Self::new(particles, 1 << count.ilog2())
    }

    /// The largest number of particles that are copied at once, on any device.
    #[must_use]
    pub fn room(particles: u32) -> u32 {
        let of = |on_cpu| Self::of(particles, on_cpu).longest();
        of(true).max(of(false))
    }

    /// A given number of segments: a power of two, at most the number of steps in which each is sorted once.
    ///
    /// # Panics
    /// If it is another number.
    #[must_use]
    pub fn new(particles: u32, count: u32) -> Self {
        let fits = count.is_power_of_two() && u64::from(count) <= SORT_INTERVAL;
        assert!(fits, "{count} segments");
        Self { particles, count }
    }

    /// The number of segments.
    #[must_use]
    pub fn count(self) -> u32 {
        self.count
    }

    /// Particles in half a segment.
    fn half(self) -> u64 {
        u64::from(self.particles).div_ceil(2 * u64::from(self.count) - 1)
    }

    /// Particles in the longest segment.
    #[must_use]
    pub fn longest(self) -> u32 {
        (2 * self.half()).min(self.particles.into()) as u32
    }

    /// The segment that is sorted at the end of a step, if any is.
    #[must_use]
    pub fn due(self, step: u64) -> Option<Segment> {
        let interval = SORT_INTERVAL / u64::from(self.count);
        if !step.is_multiple_of(interval) {
            return None;
        }
        let (round, number) = (
            step / SORT_INTERVAL,
            step / interval % u64::from(self.count),
        );
        Some(self.segment(round, number)).filter(|segment| segment.count > 0)
    }

    /// The segment of this number in a round.
    fn segment(self, round: u64, number: u64) -> Segment {
        let shift = round % 2;
        let border = |halves: u64| (halves * self.half()).min(self.particles.into()) as u32;
        let first = border((2 * number).saturating_sub(shift));
        Segment {
            first,
            count: border(2 * number + 2 - shift) - first,
        }
    }
}

/// The bins that particles are sorted into. Triangles that are hardly larger than a tile of the atlas, and whose middles lie in the same
/// tile, share a bin; a larger one has separate bins, one for each tile that it may overlap. Bins are ordered by object, and within an
/// object so that bins of neighbouring tiles are near each other. A bin has [parts](part_bits), by the texel's place in its tile: those of
/// one row of parts after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bins {
    /// log2 of a tile's side, texels.
    pub tile_shift: u32,
    /// The number of bins.
    pub count: u32,
}

impl Bins {
    /// Numbers the bins, with the smallest tiles for which there are not too many bins for so many particles.
    #[must_use]
    pub fn number(strips: &mut [StripTriangle], particles: usize) -> Self {
        let most = (particles / PARTICLES_A_BIN).clamp(FEW_BINS, MOST_BINS);
        let mut shift = SMALLEST_SHIFT;
        loop {
            let shares = shares(strips, shift);
            let count: u64 = shares
                .chunk_by(Share::is_shared)
                .map(|own| own[0].bins())
                .sum();
            if count <= most as u64 || shift == LARGEST_SHIFT {
                hand_out(strips, &shares);
                return Self {
                    tile_shift: shift,
                    count: count as u32,
                };
            }
            shift += 1;
        }
    }

    /// The particle's part of its bin, numbered through all bins.
    #[must_use]
    pub fn part_of(
        (tile_shift, part_bits): (u32, u32),
        strips: &[StripTriangle],
        particle: &Particle,
    ) -> u32 {
        let StripTriangle { map, bins, .. } = &strips[particle.triangle as usize];
        let texel = atlas_position(map, particle.u, particle.v).map(|x| x as u32);
        let bin = bins.of_tile(texel.map(|x| x >> tile_shift));
        let mask = (1 << part_bits) - 1;
        let [x, y] = texel.map(|x| (x >> (tile_shift - part_bits)) & mask);
        (((bin << part_bits) + y) << part_bits) + x
    }
}

/// The bins of a triangle.
struct Share {
    object: u32,
    /// The tile of its middle: row and column. A particle that moves to the next tile is then no farther from its place than the length of
    /// a row of tiles.
    middle: [u32; 2],
    /// For a large triangle: its first tile, and its numbers of columns and rows of tiles.
    own: Option<([u32; 2], [u32; 2])>,
    triangle: u32,
}

impl Share {
    fn of(triangle: u32, strip: &StripTriangle, shift: u32) -> Self {
        let map = &strip.map;
        let corners = [map.origin, map.origin + map.du, map.origin + map.dv];
        let low = corners[0].min(corners[1]).min(corners[2]);
        let high = corners[0].max(corners[1]).max(corners[2]);
        let tile = |x: f32| x as u32 >> shift;
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        // Two tiles: smaller ones would take several bins for a part of each.
        let is_large = (high - low).max_element() > (2 << shift) as f32;
        let own = is_large.then(|| {
            // One more texel, for places that rounding moves outside.
            let first = [tile(low.x - 1.0), tile(low.y - 1.0)];
            let last = [tile(high.x + 1.0), tile(high.y + 1.0)];
            (first, [0, 1].map(|k| last[k] - first[k] + 1))
        });
        Self {
            object: strip.shape.object,
            middle: [tile(middle.y), tile(middle.x)],
            own,
            triangle,
        }
    }

    fn bins(&self) -> u64 {
        self.own
            .map_or(1, |(_, [a_row, rows])| u64::from(a_row) * u64::from(rows))
    }

    /// Do both triangles have the same bin?
    fn is_shared(&self, other: &Self) -> bool {
        let is_small = self.own.is_none() && other.own.is_none();
        is_small && (self.object, self.middle) == (other.object, other.middle)
    }
}

/// The shares of all triangles, in the order of their bins.
fn shares(strips: &[StripTriangle], shift: u32) -> Vec<Share> {
    let triangles = (0..strips.len() as u32).into_par_iter().zip(strips);
    let mut shares: Vec<Share> = triangles
        .map(|(triangle, strip)| Share::of(triangle, strip, shift))
        .collect();
    shares.par_sort_unstable_by_key(|share| {
        (
            share.object,
            share.middle,
            share.own.is_some(),
            share.triangle,
        )
    });
    shares
}

/// Writes the bins of triangles into their table.
fn hand_out(strips: &mut [StripTriangle], shares: &[Share]) {
    let mut bins = 0_u32;
    for sharing in shares.chunk_by(Share::is_shared) {
        let tile_bins = match sharing[0].own {
            None => TileBins {
                base: bins,
                strides: 0,
            },
            Some(([x, y], [a_row, _])) => TileBins {
                base: bins.wrapping_sub(y.wrapping_mul(a_row)).wrapping_sub(x),
                strides: a_row << 16 | 1,
            },
        };
        for share in sharing {
            strips[share.triangle as usize].bins = tile_bins;
        }
        bins = bins.wrapping_add(sharing[0].bins() as u32);
    }
}
