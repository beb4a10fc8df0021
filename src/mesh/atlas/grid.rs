//! The `grid` layout: square cells of one size, row by row, with two neighbouring triangles in each.
//!
//! In a cell of `c` texels with a gutter of `g`, the inner square `[g, c - g]^2` holds a pair: the *lower* triangle
//! has its right angle at the square's origin, the *upper* one at the opposite corner, and the shared edge is the
//! diagonal `x + y = c` between them, so there is no seam between the two. A triangle without a partner is a lower one.
//! Texels whose centre lies on the diagonal are the lower triangle's, by rule; so every texel that can hold a point of a triangle is owned,
//! also if a lower triangle is alone.
//!
//! Every triangle takes equally many texels, whatever its shape: this suits meshes with even triangles.

use glam::{UVec2, Vec2};
use rayon::prelude::*;

use super::super::surface::{AtlasMap, NONE, Surface};
use super::{AtlasError, AtlasOptions, GutterTexel, Layout, pitch_of};

/// One of the two triangles of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Half {
    Lower,
    Upper,
}

/// The cells and what lies in them.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    size: u32,
    gutter: u32,
    /// Texels a cell, gutter included.
    cell_size: u32,
    /// Cells a row.
    columns: u32,
    /// Per cell: its lower triangle, and the upper one or [`NONE`].
    cells: Vec<[u32; 2]>,
    /// Per triangle: the corner where the edge that lies on the diagonal starts.
    diagonal: Vec<u8>,
    /// Distance kept from the borders of the inner square, so that rounding cannot leave it, texels.
    margin: f32,
}

impl Grid {
    pub(super) fn new(surface: &Surface, options: &AtlasOptions) -> Result<Self, AtlasError> {
        let (cells, diagonal) = pair_triangles(surface);
        let (size, gutter) = (options.size, options.gutter);
        let smallest = 2 * u64::from(gutter) + 2;
        if options.cell_size != 0 && u64::from(options.cell_size) < smallest {
            return Err(AtlasError::CellTooSmall {
                cell_size: options.cell_size,
                gutter,
                needed: smallest,
            });
        }
        // Squares of side c fit floor(size / c) a side, so the largest c is size over the least cells a side.
        let least_columns = least_root(cells.len());
        let largest = size / least_columns;
        let wanted = u64::from(options.cell_size).max(smallest);
        if u64::from(largest) < wanted {
            return Err(AtlasError::NoRoom {
                triangles: surface.corners.len(),
                cells: cells.len(),
                cell_size: wanted.min(u64::from(u32::MAX)) as u32,
                gutter,
                size,
                needed: wanted * u64::from(least_columns),
            });
        }
        let cell_size = match options.cell_size {
            0 => largest,
            c => c,
        };
        Ok(Self {
            size,
            gutter,
            cell_size,
            columns: size / cell_size,
            cells,
            diagonal,
            margin: margin(size, cell_size - 2 * gutter),
        })
    }

    /// Maps, owners, areas and the list of gutter texels.
    pub(super) fn layout(&self, surface: &Surface) -> Layout {
        let triangle_count = surface.corners.len();
        let mut maps = vec![bytemuck::Zeroable::zeroed(); triangle_count];
        let mut chart = vec![0; triangle_count];
        for (cell, &[lower, upper]) in self.cells.iter().enumerate() {
            maps[lower as usize] = self.map_of(cell, Half::Lower);
            chart[lower as usize] = cell as u32;
            if upper != NONE {
                maps[upper as usize] = self.map_of(cell, Half::Upper);
                chart[upper as usize] = cell as u32;
            }
        }
        let (owner, area) = self.texels(surface);
        Layout {
            maps,
            chart,
            chart_count: self.cells.len() as u32,
            cell_size: self.cell_size,
            owner,
            area,
            gutter_texels: self.gutter_texels(),
        }
    }

    fn cell_origin(&self, cell: usize) -> UVec2 {
        let cell = cell as u32;
        UVec2::new(cell % self.columns, cell / self.columns) * self.cell_size
    }

    /// All corner positions are exact in single precision, so a pair agrees on its diagonal.
    pub(super) fn map_of(&self, cell: usize, half: Half) -> AtlasMap {
        let [lower, upper] = self.cells[cell];
        let low = self.gutter as f32 + self.margin;
        let mut high = (self.cell_size - self.gutter) as f32 - self.margin;
        if upper == NONE {
            // The hypotenuse is a border too.
            high -= self.margin;
        }
        let (triangle, diagonal_start, diagonal_end, apex) = match half {
            Half::Lower => (lower, (high, low), (low, high), (low, low)),
            Half::Upper => (upper, (low, high), (high, low), (high, high)),
        };
        let start = self.diagonal[triangle as usize] as usize;
        let mut corners = [Vec2::ZERO; 3];
        corners[start] = diagonal_start.into();
        corners[(start + 1) % 3] = diagonal_end.into();
        corners[(start + 2) % 3] = apex.into();
        let origin = self.cell_origin(cell).as_vec2();
        AtlasMap {
            origin: origin + corners[0],
            du: corners[1] - corners[0],
            dv: corners[2] - corners[0],
        }
    }

    /// The half of a cell that owns a texel, by its place in the cell.
    fn half_at(&self, x: u32, y: u32, paired: bool) -> Option<Half> {
        let inner = self.gutter..self.cell_size - self.gutter;
        if !inner.contains(&x) || !inner.contains(&y) {
            None
        } else if x + y < self.cell_size {
            Some(Half::Lower)
        } else {
            paired.then_some(Half::Upper)
        }
    }

    /// The owner of a texel of the texture, without the array of them.
    #[cfg(test)]
    pub(super) fn owner_at(&self, x: u32, y: u32) -> u32 {
        let Some(cell) = self.cell_at(x, y) else {
            return NONE;
        };
        let [lower, upper] = self.cells[cell];
        match self.half_at(x % self.cell_size, y % self.cell_size, upper != NONE) {
            Some(Half::Lower) => lower,
            Some(Half::Upper) => upper,
            None => NONE,
        }
    }

    fn cell_at(&self, x: u32, y: u32) -> Option<usize> {
        let (column, row) = (x / self.cell_size, y / self.cell_size);
        let cell = row as usize * self.columns as usize + column as usize;
        (column < self.columns && cell < self.cells.len()).then_some(cell)
    }

    /// Owner and area of every texel.
    fn texels(&self, surface: &Surface) -> (Vec<u32>, Vec<f32>) {
        let pitch = pitch_of(self.size) as usize;
        let side = f64::from(self.cell_size - 2 * self.gutter);
        // A triangle fills half the inner square.
        let texel_area = |triangle: u32| match triangle {
            NONE => 0.0,
            _ => surface.area(triangle) / (0.5 * side * side),
        };
        let mut owner = vec![NONE; pitch * self.size as usize];
        let mut area = vec![0.0; pitch * self.size as usize];
        owner
            .par_chunks_mut(pitch)
            .zip(area.par_chunks_mut(pitch))
            .enumerate()
            .for_each(|(y, (owner, area))| {
                let y = y as u32;
                for column in 0..self.columns {
                    let Some(cell) = self.cell_at(column * self.cell_size, y) else {
                        break;
                    };
                    let [lower, upper] = self.cells[cell];
                    let areas = [texel_area(lower), texel_area(upper)];
                    for i in 0..self.cell_size {
                        let x = (column * self.cell_size + i) as usize;
                        let j = y % self.cell_size;
                        let Some(half) = self.half_at(i, j, upper != NONE) else {
                            continue;
                        };
                        owner[x] = self.cells[cell][half as usize];
                        // A texel on the diagonal is half in each triangle.
                        area[x] = if i + j + 1 == self.cell_size {
                            0.5 * (areas[0] + areas[1])
                        } else {
                            areas[half as usize]
                        } as f32;
                    }
                }
            });
        (owner, area)
    }

    /// In ascending order of texel.
    fn gutter_texels(&self) -> Vec<GutterTexel> {
        let pitch = pitch_of(self.size);
        let templates = [self.cell_gutter(false), self.cell_gutter(true)];
        let rows: Vec<Vec<GutterTexel>> = (0..self.size)
            .into_par_iter()
            .map(|y| {
                let mut row = Vec::new();
                for column in 0..self.columns {
                    let Some(cell) = self.cell_at(column * self.cell_size, y) else {
                        break;
                    };
                    let paired = self.cells[cell][1] != NONE;
                    let template = &templates[usize::from(paired)];
                    for &(i, half) in &template[(y % self.cell_size) as usize] {
                        row.push(GutterTexel {
                            texel: y * pitch + column * self.cell_size + i,
                            triangle: self.cells[cell][half as usize],
                        });
                    }
                }
                row
            })
            .collect();
        rows.concat()
    }

    /// The gutter texels of a cell: per row, the column and the nearest half.
    fn cell_gutter(&self, paired: bool) -> Vec<Vec<(u32, Half)>> {
        let (c, g) = (self.cell_size, self.gutter);
        let readable = |x: u32, y: u32| {
            // The nearest owned texel along both axes, if one is within the gutter's reach.
            let clamp = |k: u32| k.saturating_sub(g).max(g);
            let (x0, y0) = (clamp(x), clamp(y));
            self.half_at(x, y, paired).is_none() && (paired || x0 + y0 < c)
        };
        let nearest = |x: u32, y: u32| {
            let clamp = |k: u32| (2 * k + 1).clamp(2 * g, 2 * (c - g));
            if paired && clamp(x) + clamp(y) > 2 * c {
                Half::Upper
            } else {
                Half::Lower
            }
        };
        (0..c)
            .map(|y| {
                (0..c)
                    .filter(|&x| readable(x, y))
                    .map(|x| (x, nearest(x, y)))
                    .collect()
            })
            .collect()
    }

    #[cfg(test)]
    pub(super) fn cells(&self) -> &[[u32; 2]] {
        &self.cells
    }
}

/// The distance that maps keep from the borders of the inner square: the error of a position in single precision (four units in the last
/// place, and `uv` outside its triangle by 1e-6), rounded up to a number that keeps all corner positions exact.
fn margin(size: u32, side: u32) -> f32 {
    let unit = size.next_power_of_two() as f32 / 2_097_152.0;
    let slack = 3e-6 * side as f32 + 0.5 * unit;
    (slack / unit).ceil() * unit
}

/// The least `n` with `n * n >= count`.
fn least_root(count: usize) -> u32 {
    let mut root = (count as f64).sqrt() as u64;
    while root * root < count as u64 {
        root += 1;
    }
    root as u32
}

/// Pairs neighbouring triangles along their longest edges, greedily, and makes a cell of each pair and of each remaining triangle. Also
/// returns the corner of each triangle where its edge on the cell's diagonal starts.
fn pair_triangles(surface: &Surface) -> (Vec<[u32; 2]>, Vec<u8>) {
    let triangle_count = surface.corners.len();
    let mut edges: Vec<(f64, u32)> = (0..surface.halfedges.len() as u32)
        .filter(|&h| {
            let twin = surface.halfedges[h as usize].twin;
            twin != NONE && h / 3 < twin / 3
        })
        .map(|h| (squared_length(surface, h), h))
        .collect();
    edges.par_sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut partner = vec![NONE; triangle_count];
    let mut diagonal: Vec<u8> = (0..triangle_count as u32)
        .map(|t| longest_edge(surface, t))
        .collect();
    for (_, h) in edges {
        let twin = surface.halfedges[h as usize].twin;
        let (a, b) = (h / 3, twin / 3);
        if partner[a as usize] == NONE && partner[b as usize] == NONE {
            partner[a as usize] = b;
            partner[b as usize] = a;
            diagonal[a as usize] = (h % 3) as u8;
            diagonal[b as usize] = (twin % 3) as u8;
        }
    }
    let cells = (0..triangle_count as u32)
        .map(|t| [t, partner[t as usize]])
        .filter(|&[t, partner]| t < partner)
        .collect();
    (cells, diagonal)
}

fn longest_edge(surface: &Surface, triangle: u32) -> u8 {
    let mut longest = (0, 0.0);
    for corner in 0..3u8 {
        let length = squared_length(surface, 3 * triangle + u32::from(corner));
        if length > longest.1 {
            longest = (corner, length);
        }
    }
    longest.0
}

/// Squared length of an edge, bit for bit equal from both of its sides.
fn squared_length(surface: &Surface, halfedge: u32) -> f64 {
    let corners = surface.corners[halfedge as usize / 3];
    let corner = halfedge as usize % 3;
    let [a, b] = [corners[corner], corners[(corner + 1) % 3]]
        .map(|i| surface.positions[i as usize].as_dvec3());
    (b - a).length_squared()
}
