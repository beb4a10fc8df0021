//! Measures of a layout's quality: for tables, pictures and tests.

use std::fmt;

use glam::IVec2;
use rayon::prelude::*;

use super::super::surface::{NONE, Surface};
use super::fixed::{Fixed, twice_area};
use super::{Atlas, AtlasMethod};
use crate::plain_text::counted;

/// How much of the texture a layout uses, and how well triangles keep their size and shape in it.
#[derive(Clone, Debug, PartialEq)]
pub struct AtlasStatistics {
    /// Triangles laid out.
    pub triangles: usize,
    /// Charts they lie in.
    pub charts: u32,
    /// Area of the triangles in the texture, as a share of the texture.
    pub utilisation: f64,
    /// Texels whose centre is in a triangle.
    pub owned_texels: u64,
    /// Texels beside those that reads may touch.
    pub gutter_texels: u64,
    /// Texels that are neither.
    pub empty_texels: u64,
    /// Texels per surface area of a triangle over the mean of all: 5, 50 and 95 % percentiles over the surface. NaN if no triangle has area
    /// in the texture.
    pub area_percentiles: [f64; 3],
    /// Longest stretch over shortest in a triangle's map, 1 if it keeps its angles: 5, 50 and 95 % percentiles over the surface.
    pub stretch_percentiles: [f64; 3],
    /// The largest such stretch; infinite where a triangle has no area in the texture.
    pub worst_stretch: f64,
    /// Triangles in which no texel has its centre.
    pub unowned_triangles: usize,
    /// Triangles without area in the texture: their stretch is infinite.
    pub flat_triangles: usize,
    /// Edges between two triangles that do not lie side by side in the texture.
    pub seam_edges: usize,
}

/// A surface with a smaller share of the texture's texels gives a warning.
const HARDLY_ANY: f64 = 0.001;

const PERCENTILES: [f64; 3] = [0.05, 0.5, 0.95];

/// The distortion of one triangle by its map.
struct Distortion {
    /// On the surface, world units squared.
    area: f64,
    /// In the texture, texels squared.
    texels: f64,
    stretch: f64,
}

impl Atlas {
    /// Measures the layout, which is that of `surface`.
    #[must_use]
    pub fn statistics(&self, surface: &Surface) -> AtlasStatistics {
        let distortions: Vec<Distortion> = (0..self.maps.len() as u32)
            .into_par_iter()
            .map(|triangle| self.distortion(surface, triangle))
            .collect();
        let area: f64 = distortions.iter().map(|d| d.area).sum();
        let texels: f64 = distortions.iter().map(|d| d.texels).sum();
        let mean = texels / area;
        let relative = distortions.iter().filter(|d| d.area > 0.0);
        let relative = relative.map(|d| (d.texels / d.area / mean, d.area));
        let stretch = || distortions.iter().map(|d| (d.stretch, d.area));

        let mut owns = vec![false; self.maps.len()];
        for (texel, &owner) in self.owner.iter().enumerate() {
            if owner != NONE && !owns[owner as usize] {
                owns[owner as usize] = self.holds_centre(owner, texel as u32);
            }
        }
        let all = u64::from(self.size) * u64::from(self.size);
        let (owned, gutter) = (u64::from(self.owned_count), self.gutter_texels.len() as u64);
        AtlasStatistics {
            triangles: self.maps.len(),
            charts: self.chart_count,
            utilisation: texels / all as f64,
            owned_texels: owned,
            gutter_texels: gutter,
            empty_texels: all - owned - gutter,
            area_percentiles: percentiles(relative.collect()),
            stretch_percentiles: percentiles(stretch().collect()),
            worst_stretch: stretch().map(|(stretch, _)| stretch).fold(1.0, f64::max),
            unowned_triangles: owns.iter().filter(|&&owns| !owns).count(),
            flat_triangles: distortions.iter().filter(|d| d.texels == 0.0).count(),
            seam_edges: (0..surface.halfedges.len() as u32)
                .into_par_iter()
                .filter(|&h| {
                    let twin = surface.halfedges[h as usize].twin;
                    twin != NONE && h < twin && self.is_seam(surface, h)
                })
                .count(),
        }
    }

    /// Does an owner hold its texel's centre? The owner of a chart's only texel may not.
    fn holds_centre(&self, owner: u32, texel: u32) -> bool {
        if self.method == AtlasMethod::Grid {
            return true;
        }
        let fixed = Fixed::new(self.size, self.gutter);
        let mut corners = fixed.corners_of(&self.maps[owner as usize]);
        let centre = [texel % self.pitch, texel / self.pitch].map(|k| k as i32);
        let centre = IVec2::from(centre) * fixed.texel + fixed.texel / 2;
        let area = twice_area(corners);
        if area < 0 {
            corners.swap(1, 2);
        }
        let [a, b, c] = corners;
        let beside = |start, end| twice_area([start, end, centre]);
        area != 0 && beside(a, b) >= 0 && beside(b, c) >= 0 && beside(c, a) >= 0
    }

    /// A warning if the layout leaves hardly any texels for the surface.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        let texels = f64::from(self.size) * f64::from(self.size);
        let owned = f64::from(self.owned_count);
        (owned < HARDLY_ANY * texels).then(|| {
            format!(
                "of the {texels} texels of the atlas only {owned} {} on the surface: triangles that are far longer than \
                 wide have hardly any; split them into shorter ones",
                if self.owned_count == 1 { "is" } else { "are" }
            )
        })
    }

    /// Is the edge of a half-edge at a chart's border? Either there is no triangle beyond it, or that triangle is elsewhere in the texture.
    #[must_use]
    pub fn is_seam(&self, surface: &Surface, halfedge: u32) -> bool {
        /// Corners closer than this, in texels, count as one.
        const SAME: f32 = 1e-3;
        let twin = surface.halfedges[halfedge as usize].twin;
        if twin == NONE || self.chart[halfedge as usize / 3] != self.chart[twin as usize / 3] {
            return true;
        }
        let ([a, b], [c, d]) = (self.edge(halfedge), self.edge(twin));
        (a - d).abs().max_element() > SAME || (b - c).abs().max_element() > SAME
    }

    /// Texture positions of both ends of a half-edge, in texels.
    #[must_use]
    pub fn edge(&self, halfedge: u32) -> [glam::Vec2; 2] {
        let triangle = halfedge / 3;
        [halfedge % 3, (halfedge + 1) % 3].map(|corner| match corner {
            0 => self.position_of(triangle, 0.0, 0.0),
            1 => self.position_of(triangle, 1.0, 0.0),
            _ => self.position_of(triangle, 0.0, 1.0),
        })
    }

    fn distortion(&self, surface: &Surface, triangle: u32) -> Distortion {
        let shape = surface.triangles[triangle as usize];
        let (ab, cp, ch) = (
            f64::from(shape.ab),
            f64::from(shape.cp),
            f64::from(shape.ch),
        );
        let map = &self.maps[triangle as usize];
        let (du, dv) = (map.du.as_dvec2(), map.dv.as_dvec2());
        // Texels for a world unit along `p` and along `h`; then the singular values of that matrix, as in Sander et
        // al., "Texture Mapping Progressive Meshes" (2001).
        let p = du / ab;
        let h = (dv - cp * p) / ch;
        let (sum, difference) = (
            p.length_squared() + h.length_squared(),
            2.0 * p.perp_dot(h).abs(),
        );
        let root = (sum * sum - difference * difference).max(0.0).sqrt();
        let (long, short) = (
            (0.5 * (sum + root)).sqrt(),
            (0.5 * (sum - root)).max(0.0).sqrt(),
        );
        Distortion {
            area: surface.area(triangle),
            texels: 0.5 * du.perp_dot(dv).abs(),
            stretch: if short > 0.0 {
                long / short
            } else {
                f64::INFINITY
            },
        }
    }
}

/// The 5, 50 and 95 % percentiles of weighted values.
fn percentiles(mut values: Vec<(f64, f64)>) -> [f64; 3] {
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let all: f64 = values.iter().map(|(_, weight)| weight).sum();
    PERCENTILES.map(|share| {
        let mut below = 0.0;
        let found = values.iter().find(|(_, weight)| {
            below += weight;
            below >= share * all
        });
        found
            .or(values.last())
            .map_or(f64::NAN, |(value, _)| *value)
    })
}

impl fmt::Display for AtlasStatistics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [low, middle, high] = self.area_percentiles;
        write!(
            f,
            "{} in {}, {:.1} % of the texture used, texels per area {low:.2} {middle:.2} {high:.2}, \
             stretch up to {:.2}",
            counted(self.triangles, "triangle", "triangles"),
            counted(self.charts as usize, "chart", "charts"),
            100.0 * self.utilisation,
            self.stretch_percentiles[2],
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::AtlasOptions;
    use super::*;

    use glam::Vec2;

    #[test]
    fn a_cube_in_a_grid_is_measured_as_by_hand() {
        let (surface, atlas) = Atlas::of_cells("cube", 64);
        let found = atlas.statistics(&surface);
        assert_eq!((found.triangles, found.charts), (12, 6));
        assert_eq!(
            found.owned_texels + found.gutter_texels + found.empty_texels,
            64 * 64
        );
        // Each owned texel is a square texel of a triangle, but for those that borders cut.
        let owned = found.owned_texels as f64 / 4096.0;
        assert!((found.utilisation - owned).abs() < 0.1, "{found:?}");
        for value in found
            .area_percentiles
            .into_iter()
            .chain(found.stretch_percentiles)
        {
            assert!((value - 1.0).abs() < 0.02, "{found:?}");
        }
        assert_eq!(found.unowned_triangles, 0);
        // 18 edges, of which the 6 diagonals lie inside of cells.
        assert_eq!(found.seam_edges, 12);
    }

    #[test]
    fn stretched_and_shrunken_triangles_are_seen() {
        let (surface, mut atlas) = Atlas::of_cells("cube", 64);
        for map in &mut atlas.maps[..6] {
            map.du.x *= 0.5;
            map.dv.x *= 0.5;
        }
        let found = atlas.statistics(&surface);
        // Half of the surface has half the texels: the mean is 3/4.
        let [low, _, high] = found.area_percentiles;
        assert!((low - 2.0 / 3.0).abs() < 0.02, "{found:?}");
        assert!((high - 4.0 / 3.0).abs() < 0.02, "{found:?}");
        assert!((found.worst_stretch - 2.0).abs() < 0.05, "{found:?}");
        assert!((found.stretch_percentiles[0] - 1.0).abs() < 0.02);
        atlas.maps[3].dv = Vec2::ZERO;
        assert_eq!(atlas.statistics(&surface).worst_stretch, f64::INFINITY);
    }

    #[test]
    fn triangles_without_a_texel_are_counted() {
        let (surface, mut atlas) = Atlas::of_cells("cube", 64);
        for owner in &mut atlas.owner {
            if *owner == 5 || *owner == 7 {
                *owner = 4;
            }
        }
        assert_eq!(atlas.statistics(&surface).unowned_triangles, 2);
    }

    #[test]
    fn a_sliver_between_all_centres_holds_none() {
        use crate::mesh::suite;
        use glam::Vec3;
        let corners = [Vec3::ZERO, 1000.0 * Vec3::X, Vec3::new(500.0, 1e-4, 0.0)];
        let sliver = suite::mesh("sliver", &corners, &[[0, 1, 2]]);
        let surface = Surface::build(&[(&sliver, 1.0)]);
        let options = AtlasOptions {
            size: 128,
            ..AtlasOptions::default()
        };
        let atlas = Atlas::build(&surface, &options).unwrap();
        let found = atlas.statistics(&surface);
        assert_eq!(
            [found.unowned_triangles, found.flat_triangles],
            [1, 1],
            "{found:?}"
        );
        let warning = atlas.warning().unwrap();
        assert!(
            warning.contains("16384 texels of the atlas only 1 is on"),
            "{warning}"
        );
        let (surface, atlas) = Atlas::of_cells("cube", 64);
        assert_eq!(atlas.statistics(&surface).flat_triangles, 0);
        assert_eq!(atlas.warning(), None);
    }

    #[test]
    fn percentiles_go_by_weight() {
        let values = vec![(3.0, 1.0), (1.0, 94.0), (2.0, 5.0)];
        assert_eq!(percentiles(values), [1.0, 1.0, 2.0]);
        assert_eq!(percentiles(vec![(7.0, 0.0)]), [7.0; 3]);
        assert!(percentiles(Vec::new())[0].is_nan());
    }

    #[test]
    fn every_open_border_is_a_seam() {
        let (surface, atlas) = Atlas::of_cells("plane?columns=3&rows=3", 64);
        let borders = (0..surface.halfedges.len() as u32)
            .filter(|&h| surface.halfedges[h as usize].twin == NONE);
        for h in borders {
            assert!(atlas.is_seam(&surface, h));
        }
    }
}
