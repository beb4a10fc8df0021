//! Starts under a mask: a greyscale picture of the whole texture, whose lightness is the density of particles.

use std::path::{Path, PathBuf};

use glam::Vec2;
use image::{DynamicImage, GrayImage};

use super::{area, triangles_of};
use crate::error::{Error, Result};
use crate::mesh::atlas::Atlas;
use crate::mesh::surface::Surface;
use crate::plain_text::Shown as _;
use crate::scene::parameters::grouped;
use crate::sim::texture_map;

/// Masks with more pixels a side are reduced to this number.
const FINEST: u32 = 2048;

/// With more cells than this, long thin triangles have fewer than their lengths ask for; light cells take 12 bytes each.
const MANY_CELLS: u64 = 1 << 25;

/// More cells than this are refused.
const MOST_CELLS: u64 = 1 << 28;

/// The cells a pixel that a triangle may have where there are many. One whose height is a quarter of its longest edge has as many by its
/// length, and those that are less thin have fewer.
const CELLS_A_PIXEL: f32 = 8.0;

/// Its name in messages.
const WHAT: &str = "start mask";

/// A greyscale picture of the texture.
#[derive(Clone, Debug)]
pub struct Mask {
    path: PathBuf,
    pixels: GrayImage,
}

impl Mask {
    /// Reads a PNG. Transparent pixels count as black.
    ///
    /// # Errors
    /// When there is no such file, it is no picture, or it has more pixels than masks for an atlas of this size may have.
    pub fn open(path: &Path, atlas_size: u32) -> Result<Self> {
        let picture = texture_map::read(path, WHAT, atlas_size)?;
        Ok(Self::of_picture(path, picture))
    }

    /// As [`open`](Self::open), for a PNG in memory; `path` is its name in messages.
    ///
    /// # Errors
    /// When it is no picture, or it has more pixels than masks for an atlas of this size may have.
    pub fn from_bytes(path: &Path, bytes: &[u8], atlas_size: u32) -> Result<Self> {
        let picture = texture_map::decode(path, WHAT, bytes, atlas_size)?;
        Ok(Self::of_picture(path, picture))
    }

    fn of_picture(path: &Path, picture: DynamicImage) -> Self {
        let picture = picture.into_luma_alpha8();
        let (width, height) = picture.dimensions();
        let pixels = GrayImage::from_fn(width, height, |x, y| {
            let [light, alpha] = picture.get_pixel(x, y).0;
            image::Luma([(u16::from(light) * u16::from(alpha) / 255) as u8])
        });
        Self {
            path: path.to_owned(),
            pixels,
        }
    }

    /// A mask that is in memory; `name` is for messages.
    #[must_use]
    pub fn of(name: &str, pixels: GrayImage) -> Self {
        Self {
            path: name.into(),
            pixels,
        }
    }

    /// The lightness, 0 to 1, at a place of the texture, whose sides are 1.
    #[must_use]
    pub fn light(&self, place: Vec2) -> f64 {
        let (width, height) = self.pixels.dimensions();
        let x = ((place.x * width as f32) as u32).min(width - 1);
        let y = ((place.y * height as f32) as u32).min(height - 1);
        f64::from(self.pixels.get_pixel(x, y).0[0]) / 255.0
    }
}

/// The surface in cells of about a pixel of a mask, and the share of particles that begin in each. Where long thin triangles would have
/// too many cells, theirs are longer.
#[derive(Clone, Debug)]
pub struct MaskTable {
    /// Per triangle that has light cells: its id, rows of cells, and where its cells begin.
    triangles: Vec<(u32, u32, u32)>,
    /// Light cells, by their place in their triangle.
    cells: Vec<u32>,
    /// Per light cell: area times light of all cells up to it, itself included.
    up_to: Vec<f64>,
}

impl MaskTable {
    /// Lays a mask over the texture.
    ///
    /// # Errors
    /// When it is black on all triangles, or on those of one object if one is given; when it has too many pixels for so many triangles.
    pub fn new(mask: &Mask, surface: &Surface, atlas: &Atlas, object: Option<u32>) -> Result<Self> {
        let (width, height) = mask.pixels.dimensions();
        let side = Vec2::new(width.min(FINEST) as f32, height.min(FINEST) as f32);
        let to_texture = 1.0 / atlas.size as f32;
        let rows_on = |triangle: u32, are_many: bool| {
            let map = &atlas.maps[triangle as usize];
            let edges = [map.du, map.dv, map.dv - map.du];
            rows_of(edges.map(|edge| edge * to_texture * side), are_many)
        };
        let cells_of = |are_many: bool| {
            let rows = triangles_of(surface, object).map(|triangle| rows_on(triangle, are_many));
            rows.map(|rows| u64::from(rows * rows)).sum::<u64>()
        };
        let are_many = cells_of(false) > MANY_CELLS;
        if are_many {
            check_cells(mask, cells_of(true))?;
        }
        let mut table = Self {
            triangles: Vec::new(),
            cells: Vec::new(),
            up_to: Vec::new(),
        };
        let mut sum = 0.0;
        for triangle in triangles_of(surface, object) {
            let rows = rows_on(triangle, are_many);
            let cell_area = area(surface, triangle) / f64::from(rows * rows);
            let first = table.cells.len() as u32;
            for cell in 0..rows * rows {
                let corners = corners(cell, rows);
                let [u, v] = [0, 1].map(|k| corners.iter().map(|c| c[k]).sum::<f32>() / 3.0);
                let light = mask.light(atlas.position_of(triangle, u, v) * to_texture);
                if light > 0.0 {
                    sum += light * cell_area;
                    table.cells.push(cell);
                    table.up_to.push(sum);
                }
            }
            if table.cells.len() as u32 > first {
                table.triangles.push((triangle, rows, first));
            }
        }
        if sum > 0.0 {
            return Ok(table);
        }
        Err(Error::Invalid(format!(
            "{}: the start mask is black wherever the texture holds a triangle{}: paint over a picture that `myxo atlas \
             SCENE --out FILE.png` draws",
            mask.path.shown(),
            if object.is_some() {
                " of the object"
            } else {
                ""
            }
        )))
    }

    /// The place of a share of all particles, in a cell, at the pair's place within the cell: triangle, u, v.
    pub(super) fn place(&self, share: f64, (a, b): (f32, f32)) -> (u32, f32, f32) {
        let last = self.up_to.len() - 1;
        let wanted = share * self.up_to[last];
        let at = self
            .up_to
            .partition_point(|&up_to| up_to <= wanted)
            .min(last);
        let owner = self
            .triangles
            .partition_point(|&(.., first)| first as usize <= at)
            - 1;
        let (triangle, rows, _) = self.triangles[owner];
        let [p, q, r] = corners(self.cells[at], rows);
        let [u, v] = [0, 1].map(|k| p[k] + a * (q[k] - p[k]) + b * (r[k] - p[k]));
        let u = u.clamp(0.0, 1.0);
        (triangle, u, v.clamp(0.0, 1.0 - u))
    }
}

/// The rows of cells of a triangle whose edges these are, in pixels: cells are no longer than a pixel, unless there are many and it is
/// thin.
fn rows_of(edges: [Vec2; 3], are_many: bool) -> u32 {
    let longest = edges.map(Vec2::length).into_iter().fold(0.0, f32::max);
    let rows = (longest.ceil() as u32).clamp(1, FINEST);
    if !are_many {
        return rows;
    }
    let pixels = 0.5 * edges[0].perp_dot(edges[1]).abs();
    let by_area = (CELLS_A_PIXEL * pixels).sqrt().ceil() as u32;
    by_area.clamp(1, rows)
}

/// Refuses to lay a mask over the surface in too many cells.
fn check_cells(mask: &Mask, cells: u64) -> Result<()> {
    if cells <= MOST_CELLS {
        return Ok(());
    }
    let [cells, most] = [cells, MOST_CELLS].map(|count| grouped(count as f64));
    Err(Error::Invalid(format!(
        "{}: the start mask takes {cells} cells on the triangles where particles may begin, and there may be {most}: scale it down, or \
         use models with fewer triangles",
        mask.path.shown()
    )))
}

/// The corners of a cell, as u and v, of a triangle in so many rows of cells: row `k` has `2 k + 1` of them, the first row
/// touches corner A.
fn corners(cell: u32, rows: u32) -> [[f32; 2]; 3] {
    let row = cell.isqrt();
    let along = cell - row * row;
    let (m, scale) = (along / 2, 1.0 / rows as f32);
    let point = |level: u32, m: u32| [(level - m) as f32 * scale, m as f32 * scale];
    if along.is_multiple_of(2) {
        [point(row, m), point(row + 1, m), point(row + 1, m + 1)]
    } else {
        [point(row, m), point(row + 1, m + 1), point(row, m + 1)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::mesh::atlas::{AtlasMethod, AtlasOptions};
    use crate::sim::start::{StartHeading, StartPlace, StartRule, Starts, start};

    fn on(mesh: &str) -> (Surface, Atlas) {
        let mesh = Mesh::builtin(mesh).unwrap();
        let surface = Surface::build(&[(&mesh, 1.0)]);
        let options = AtlasOptions {
            method: AtlasMethod::Charts,
            size: 128,
            ..AtlasOptions::default()
        };
        let atlas = Atlas::build(&surface, &options).unwrap();
        (surface, atlas)
    }

    #[test]
    fn cells_cover_a_triangle_once() {
        let rows = 5;
        let area = |[p, q, r]: [[f32; 2]; 3]| {
            (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
        };
        let mut middles = std::collections::BTreeSet::new();
        for cell in 0..rows * rows {
            let corners = corners(cell, rows);
            assert!((area(corners) - 1.0 / (rows * rows) as f32).abs() < 1e-6);
            let [u, v] = [0, 1].map(|k| corners.iter().map(|c| c[k]).sum::<f32>());
            assert!(u > 0.0 && v > 0.0 && u + v < 3.0);
            middles.insert([u, v].map(|x| (1000.0 * x).round() as i32));
        }
        assert_eq!(middles.len(), (rows * rows) as usize);
    }

    #[test]
    fn particles_begin_where_the_mask_is_light_and_as_many_as_it_is() {
        for mesh in ["torus?major=24&minor=16", "cube"] {
            let (surface, atlas) = on(mesh);
            // Black, half light, light; a chequerboard of patches of 8 x 8 pixels.
            let level = |x: u32, y: u32| [0_u8, 102, 204][((x / 8 + y / 8) % 3) as usize];
            let pixels = GrayImage::from_fn(128, 128, |x, y| image::Luma([level(x, y)]));
            let mask = Mask::of("test", pixels);
            let table = MaskTable::new(&mask, &surface, &atlas, None).unwrap();
            let starts = Starts {
                scene: StartRule {
                    place: StartPlace::Mask(table),
                    object: None,
                    heading: StartHeading::Auto,
                },
                own: Vec::new(),
                shares: Vec::new(),
            };
            let (particles, motions) = start(&surface, &starts, 60_000, 11);
            // Area of the texture's patches, by cells.
            let white = Mask::of("white", GrayImage::from_pixel(512, 512, image::Luma([255])));
            let fine = MaskTable::new(&white, &surface, &atlas, None).unwrap();
            let mut areas = [0.0; 3];
            for k in 0..200_000 {
                let share = (f64::from(k) + 0.5) / 200_000.0;
                let (t, u, v) = fine.place(share, (1.0 / 3.0, 1.0 / 3.0));
                let at = atlas.position_of(t, u, v);
                areas[((at.x as u32 / 8 + at.y as u32 / 8) % 3) as usize] += 1.0;
            }
            let (mut counts, mut strays) = ([0.0; 3], 0);
            for (p, m) in particles.iter().zip(&motions) {
                assert!(p.u >= 0.0 && p.v >= 0.0 && p.u + p.v <= 1.0);
                assert!((m.heading_p.hypot(m.heading_h) - 1.0).abs() < 3e-7);
                let at = atlas.position_of(p.triangle, p.u, p.v);
                let patch = |d: Vec2| {
                    let at = at + d;
                    ((at.x.max(0.0) as u32 / 8 + at.y.max(0.0) as u32 / 8) % 3) as usize
                };
                counts[patch(Vec2::ZERO)] += 1.0;
                // Cells have the size of a pixel: no particle is farther inside a dark part.
                let near =
                    [-1.0, 0.0, 1.0].map(|x| [-1.0, 0.0, 1.0].map(|y| patch(Vec2::new(x, y))));
                strays += u32::from(near.as_flattened().iter().all(|&k| k == 0));
            }
            assert_eq!(strays, 0, "{mesh}");
            let density = |k: usize| counts[k] / areas[k];
            let ratio: f64 = density(2) / density(1);
            assert!((ratio - 2.0).abs() < 0.15, "{mesh}: {ratio}");
            assert!(
                density(0) < 0.12 * density(2),
                "{mesh}: {counts:?} {areas:?}"
            );
        }
    }

    /// Would catch: two hundred triangles that take a million cells each, particles that begin beside the mask instead, and fewer cells of
    /// triangles that are not thin.
    #[test]
    fn long_thin_triangles_take_cells_by_their_area() {
        let (surface, atlas) = on("plane?columns=1&rows=100");
        // Nearly as long as the mask, and a hundredth of that high.
        let left = GrayImage::from_fn(1024, 1024, |x, _| image::Luma([255 * u8::from(x < 512)]));
        let table = MaskTable::new(&Mask::of("left", left), &surface, &atlas, None).unwrap();
        let cells = table.cells.len();
        assert!((100_000..16_000_000).contains(&cells), "{cells}");
        for k in 0..1000 {
            let share = (f64::from(k) + 0.5) / 1000.0;
            let (t, u, v) = table.place(share, (0.25, 0.5));
            // Cells are some pixels long, and eight pixels are a texel.
            let at = atlas.position_of(t, u, v);
            assert!(at.x < 66.0, "{at}");
        }
        for edges in [
            [[0.3, 0.0], [0.0, 0.2]],
            [[40.0, 0.0], [20.0, 10.1]],
            [[7.0, 0.0], [3.0, 6.5]],
            [[300.0, 1.0], [-2.0, 300.0]],
        ] {
            let [a, b] = edges.map(Vec2::from_array);
            let edges = [a, b, b - a];
            assert_eq!(rows_of(edges, true), rows_of(edges, false), "{edges:?}");
        }
        let [a, b] = [Vec2::new(2000.0, 0.0), Vec2::new(1000.0, 1.0)];
        assert_eq!(rows_of([a, b, b - a], false), 2000);
        assert_eq!(rows_of([a, b, b - a], true), 90);
    }

    /// Would catch: more cells than can be numbered, and a message that does not say what to do.
    #[test]
    fn too_many_cells_are_refused() {
        let mask = Mask::of("fine.png", GrayImage::new(4, 4));
        assert!(check_cells(&mask, MOST_CELLS).is_ok());
        let error = check_cells(&mask, 5_000_000_000).unwrap_err().to_string();
        assert!(
            error.contains("fine.png: ") && error.contains("5,000,000,000 cells"),
            "{error}"
        );
        assert!(error.contains("scale it down"), "{error}");
    }

    #[test]
    fn masks_without_light_or_without_a_picture_are_errors_that_help() {
        let (surface, atlas) = on("cube");
        let black = Mask::of("black.png", GrayImage::new(4, 4));
        let error = MaskTable::new(&black, &surface, &atlas, None).unwrap_err();
        assert!(
            error.to_string().contains("black.png") && error.to_string().contains("myxo atlas")
        );
        let folder = tempfile::tempdir().unwrap();
        let none = folder.path().join("none.png");
        let error = Mask::open(&none, 64).unwrap_err().to_string();
        assert!(
            error.contains("cannot read") && error.contains("none.png"),
            "{error}"
        );
        std::fs::write(&none, "no picture").unwrap();
        let error = Mask::open(&none, 64).unwrap_err().to_string();
        assert!(error.contains("must be a PNG"), "{error}");
        let clear =
            image::RgbaImage::from_fn(2, 1, |x, _| image::Rgba([255, 255, 255, 255 * x as u8]));
        clear.save(&none).unwrap();
        let mask = Mask::open(&none, 64).unwrap();
        assert_eq!(mask.light(Vec2::new(0.2, 0.5)), 0.0);
        assert_eq!(mask.light(Vec2::new(0.8, 0.5)), 1.0);
    }
}
