//! The distance around a texel within which the texture continues its chart: there a straight line in the texture is a walk on the surface,
//! up to the distortion of lengths and angles by flattening.
//!
//! Near a chart's border, where precision matters, the distance is that to the border's edges. Farther inside it is the distance between
//! texel centres, by the lower envelope of parabolas in each row (Felzenszwalb and Huttenlocher, "Distance Transforms of Sampled
//! Functions", 2012).

use glam::Vec2;
use rayon::prelude::*;

use super::super::surface::{NONE, Surface};
use super::Atlas;

/// Unit of clearances, texels.
pub const UNIT: f32 = 0.5;
/// Larger clearances are clamped to this.
pub const FARTHEST: u8 = 255;

/// The largest distance from a point to the centre of its texel.
const TO_CENTRE: f32 = 0.7072;
/// The largest distance from the centre of a blocked texel to the border in it.
const TO_BORDER: f32 = 0.8;
/// Up to this distance from border edges, in texels, the distance is exact.
const NEAR: f32 = 8.0;
/// Rows of texels that are processed together.
const BAND: usize = 64;

impl Atlas {
    /// Per texel: from any point in it, a straight line of so many half texels stays in its chart; 0 for texels that are not
    /// owned.
    #[must_use]
    pub fn clearances(&self, surface: &Surface) -> Vec<u8> {
        let pitch = self.pitch as usize;
        let borders: Vec<[Vec2; 2]> = (0..surface.halfedges.len() as u32)
            .filter(|&halfedge| self.is_seam(surface, halfedge))
            .map(|halfedge| self.edge(halfedge))
            .collect();
        let mut blocked: Vec<bool> = self.owner.iter().map(|&owner| owner == NONE).collect();
        for &edge in &borders {
            self.block(&mut blocked, edge);
        }
        let along_columns = down_columns(&blocked, pitch);
        let mut clearances = vec![0; blocked.len()];
        clearances
            .par_chunks_mut(pitch)
            .zip(along_columns.par_chunks(pitch))
            .for_each_init(Envelope::default, |envelope, (row, heights)| {
                envelope.over(heights);
                envelope.for_each(heights.len(), |x, squared| {
                    row[x] = clearance_of((squared as f32).sqrt() - TO_BORDER);
                });
            });
        self.refine_near_borders(&borders, &mut clearances);
        clearances
    }

    /// Near borders, computes clearances from the distance to border edges.
    fn refine_near_borders(&self, borders: &[[Vec2; 2]], clearances: &mut [u8]) {
        let pitch = self.pitch as usize;
        let band_of = |y: f32| (y.max(0.0) as usize / BAND).min((self.size as usize - 1) / BAND);
        let mut bands = vec![Vec::new(); (self.size as usize).div_ceil(BAND)];
        for edge in borders {
            let [low, high] = [edge[0].y.min(edge[1].y), edge[0].y.max(edge[1].y)];
            for band in &mut bands[band_of(low - NEAR)..=band_of(high + NEAR)] {
                band.push(*edge);
            }
        }
        let rows = clearances.par_chunks_mut(BAND * pitch);
        let owners = self.owner.par_chunks(BAND * pitch);
        let init = || vec![0.0_f32; BAND * pitch];
        rows.zip(owners).zip(bands).enumerate().for_each_init(
            init,
            |squares, (band, ((clearances, owners), borders))| {
                squares.fill(NEAR * NEAR);
                for edge in borders {
                    approach(squares, pitch, band * BAND, edge);
                }
                for ((clearance, &owner), &square) in
                    clearances.iter_mut().zip(owners).zip(&*squares)
                {
                    let near = clearance_of(square.sqrt());
                    *clearance = if owner == NONE {
                        0
                    } else if square < NEAR * NEAR {
                        near
                    } else {
                        near.max(*clearance)
                    };
                }
            },
        );
    }

    /// Blocks the texels that a border edge passes through. A chart may come so near to itself that no texel lies between.
    fn block(&self, blocked: &mut [bool], [a, b]: [Vec2; 2]) {
        let last = Vec2::new(self.pitch as f32, self.size as f32) - 1.0;
        // Two points a texel, so that none is skipped, except where the edge cuts less than 0.1 texels off a corner.
        let pieces = (2.0 * (b - a).abs().max_element()).ceil().max(1.0);
        for i in 0..=pieces as u32 {
            let point = (a + (b - a) * (i as f32 / pieces)).clamp(Vec2::ZERO, last);
            blocked[point.y as usize * self.pitch as usize + point.x as usize] = true;
        }
    }
}

/// The clearance of all points in a texel, from the distance of its centre.
fn clearance_of(distance: f32) -> u8 {
    ((distance - TO_CENTRE) / UNIT).clamp(0.0, f32::from(FARTHEST)) as u8
}

/// Lowers the squared distances of texel centres, in rows from `first_row` on, to the distance from an edge, where that is near.
fn approach(squares: &mut [f32], pitch: usize, first_row: usize, [a, b]: [Vec2; 2]) {
    let way = b - a;
    let per_square = way.length_squared().max(f32::MIN_POSITIVE).recip();
    let texels = |low: f32, high: f32, count: usize| {
        (low - 0.5).ceil().max(0.0) as usize..(high + 0.5).floor().clamp(0.0, count as f32) as usize
    };
    let first = first_row as f32;
    let [low, high] = [a.y.min(b.y) - NEAR - first, a.y.max(b.y) + NEAR - first];
    for row in texels(low, high, squares.len() / pitch) {
        let y = first + row as f32 + 0.5;
        // The part of the edge that is near this row.
        let [from, to] = if way.y == 0.0 {
            [0.0, 1.0]
        } else {
            [y - NEAR, y + NEAR].map(|y| ((y - a.y) / way.y).clamp(0.0, 1.0))
        };
        let ends = [a.x + from * way.x, a.x + to * way.x];
        let [left, right] = [ends[0].min(ends[1]) - NEAR, ends[0].max(ends[1]) + NEAR];
        for x in texels(left, right, pitch) {
            let centre = Vec2::new(x as f32 + 0.5, y);
            let along = ((centre - a).dot(way) * per_square).clamp(0.0, 1.0);
            let square = &mut squares[row * pitch + x];
            *square = square.min((a + along * way).distance_squared(centre));
        }
    }
}

/// Per texel: rows to the nearest blocked texel of its column, clamped.
fn down_columns(blocked: &[bool], pitch: usize) -> Vec<u16> {
    /// Values beyond [`FARTHEST`] must stay beyond it after the square root.
    const MOST: u16 = FARTHEST as u16 + 2;
    let mut heights: Vec<u16> = blocked.iter().map(|&b| if b { 0 } else { MOST }).collect();
    // The surface ends at the sides of the texture.
    for edge in [0, blocked.len() - pitch] {
        heights[edge..edge + pitch]
            .iter_mut()
            .for_each(|h| *h = (*h).min(1));
    }
    for texel in pitch..heights.len() {
        heights[texel] = heights[texel].min(heights[texel - pitch] + 1);
    }
    for texel in (0..heights.len() - pitch).rev() {
        heights[texel] = heights[texel].min(heights[texel + pitch] + 1);
    }
    heights
}

/// The lower envelope of the parabolas `(x - place)^2 + height^2` of a row.
#[derive(Default)]
struct Envelope {
    /// The parabolas that are lowest somewhere: place and squared height, from left to right.
    parabolas: Vec<(i64, i64)>,
    /// The place from which on each of them is the lowest.
    starts: Vec<i64>,
}

impl Envelope {
    fn over(&mut self, heights: &[u16]) {
        self.parabolas.clear();
        self.starts.clear();
        // The texture ends at both sides of the row.
        self.add(-1, 0);
        for (place, &height) in heights.iter().enumerate() {
            self.add(place as i64, i64::from(height) * i64::from(height));
        }
        self.add(heights.len() as i64, 0);
    }

    fn add(&mut self, place: i64, square: i64) {
        let mut start = i64::MIN;
        while let Some(&(before, square_before)) = self.parabolas.last() {
            // The first whole place where the new one is not above the last one.
            let numerator = (square + place * place) - (square_before + before * before);
            let twice = 2 * (place - before);
            start = numerator.div_euclid(twice) + i64::from(numerator.rem_euclid(twice) > 0);
            if self.starts.last().is_some_and(|&last| start <= last) {
                self.parabolas.pop();
                self.starts.pop();
                start = i64::MIN;
            } else {
                break;
            }
        }
        self.parabolas.push((place, square));
        self.starts.push(start);
    }

    fn for_each(&self, len: usize, mut each: impl FnMut(usize, i64)) {
        let mut k = 0;
        for x in 0..len {
            while self
                .starts
                .get(k + 1)
                .is_some_and(|&start| start <= x as i64)
            {
                k += 1;
            }
            let (place, square) = self.parabolas[k];
            let way = x as i64 - place;
            each(x, way * way + square);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_envelope_is_the_least_of_all_parabolas() {
        let heights: Vec<u16> = (0..97u32).map(|i| (i * i * 7919 % 31) as u16).collect();
        let mut envelope = Envelope::default();
        for heights in [&heights[..], &heights[..1], &[40; 20], &[0, 9, 9, 9]] {
            envelope.over(heights);
            let mut squares = Vec::new();
            envelope.for_each(heights.len(), |_, squared| squares.push(squared));
            let expected = (0..heights.len() as i64).map(|x| {
                let inside = heights.iter().enumerate();
                let inside = inside.map(|(i, &h)| (x - i as i64).pow(2) + i64::from(h).pow(2));
                let outside = [(x + 1).pow(2), (x - heights.len() as i64).pow(2)];
                inside.chain(outside).min().unwrap()
            });
            assert_eq!(squares, expected.collect::<Vec<_>>());
        }
    }
}
