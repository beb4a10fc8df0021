//! The checks of an atlas's invariants, for tests and for `--validate`.

use rayon::prelude::*;

use super::super::surface::{NONE, Surface};
use super::gutter::Affine;
use super::owners::{self, Conflict};
use super::{Atlas, AtlasMethod, AtlasOptions, surface_area};
use crate::rng::{Purpose, random, unit};

/// How far outside its owner's triangle an owned texel's centre may lie, in texels: the margin that maps keep.
const CENTRE_SLACK: f64 = 0.2;

/// That margin for a chart that holds no texel's centre, whose only texel is one that it touches: half a texel along both
/// axes.
const ONLY_SLACK: f64 = 0.71;

/// Points of each triangle that are checked besides its corners and its centroid.
const RANDOM_POINTS: u32 = 6;

impl Atlas {
    /// Checks every invariant against the surface that the atlas was built from.
    ///
    /// # Errors
    /// The first violation, with its texel or triangle.
    pub fn validate(&self, surface: &Surface) -> Result<(), String> {
        self.check_sizes(surface)
            .and_then(|()| self.check_charts())
            .and_then(|()| self.check_owners())
            .and_then(|()| self.check_areas(surface))
            .and_then(|()| self.check_seams())
            .and_then(|()| self.check_conflicts(surface))
            .and_then(|()| {
                let chart_of = self.chart_of_texels();
                self.check_halo(&chart_of)?;
                self.check_reads(&chart_of)
            })
    }

    fn check_sizes(&self, surface: &Surface) -> Result<(), String> {
        let triangles = surface.corners.len();
        let texels = self.texel_count();
        let sizes = [
            ("maps", self.maps.len(), triangles),
            ("chart", self.chart.len(), triangles),
            ("owner", self.owner.len(), texels),
            ("area", self.area.len(), texels),
            ("density", self.density.len(), texels),
            ("seams", self.seams.len(), self.gutter_texels.len()),
        ];
        for (name, len, expected) in sizes {
            ensure(len == expected, || {
                format!("{name} has {len} entries, not {expected}")
            })?;
        }
        ensure(
            self.pitch >= self.size && self.pitch.is_multiple_of(4),
            || format!("pitch {} for size {}", self.pitch, self.size),
        )?;
        ensure((1..=self.gutter).contains(&self.taps), || {
            format!("taps {} apart for a gutter of {}", self.taps, self.gutter)
        })
    }

    /// Charts are numbered without gaps, and each owns a texel.
    fn check_charts(&self) -> Result<(), String> {
        if let Some(chart) = self.chart.iter().find(|&&c| c >= self.chart_count) {
            return Err(format!("there is a chart {chart} of {}", self.chart_count));
        }
        match self.texels_of_charts().iter().position(|&count| count == 0) {
            Some(chart) => Err(format!("chart {chart} owns no texel")),
            None => Ok(()),
        }
    }

    /// How many texels each chart owns.
    fn texels_of_charts(&self) -> Vec<u32> {
        let mut texels = vec![0; self.chart_count as usize];
        for &owner in &self.owner {
            if let Some(&chart) = self.chart.get(owner as usize) {
                texels[chart as usize] += 1;
            }
        }
        texels
    }

    /// No two charts take the same texel. Maps of `grid` are not on the fixed-point grid.
    fn check_conflicts(&self, surface: &Surface) -> Result<(), String> {
        if self.method == AtlasMethod::Grid {
            return Ok(());
        }
        let options = AtlasOptions {
            method: self.method,
            size: self.size,
            gutter: self.gutter,
            ..AtlasOptions::default()
        };
        match owners::conflict(surface, &self.maps, &self.chart, &options) {
            Some(Conflict { triangles, .. }) => Err(format!(
                "the charts of triangles {triangles:?} want the same texel"
            )),
            None => Ok(()),
        }
    }

    /// Per texel the chart that it belongs to, owned or gutter, or [`NONE`].
    fn chart_of_texels(&self) -> Vec<u32> {
        let mut chart_of = vec![NONE; self.texel_count()];
        for (texel, &owner) in self.owner.iter().enumerate() {
            if owner != NONE {
                chart_of[texel] = self.chart[owner as usize];
            }
        }
        for gutter_texel in &self.gutter_texels {
            chart_of[gutter_texel.texel as usize] = self.chart[gutter_texel.triangle as usize];
        }
        chart_of
    }

    /// Reads at points of a triangle, rounding included, and the gutter's width round them touch texels of its chart only.
    fn check_reads(&self, chart_of: &[u32]) -> Result<(), String> {
        let third = 1.0 / 3.0;
        let points = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (third, third)];
        // A read touches centres that are less than one texel away along both axes.
        let reach = f64::from(self.gutter) + 4.0 * f64::from(f32::EPSILON) * f64::from(self.size);
        let size = f64::from(self.size);
        (0..self.maps.len() as u32)
            .into_par_iter()
            .try_for_each(|t| {
                let random = (0..RANDOM_POINTS).map(|k| {
                    let [u, v, ..] = random(1, t, k, Purpose::Start).map(unit);
                    match k % 3 {
                        0 => (u, 1.0 - u),
                        1 => (u, 0.0),
                        _ if u + v > 1.0 => (1.0 - u, 1.0 - v),
                        _ => (u, v),
                    }
                });
                for (u, v) in points.into_iter().chain(random) {
                    let position = self.position_of(t, u, v).as_dvec2();
                    // `grid` has its margin inside its cells, not in its gutter.
                    let reach = match self.method {
                        AtlasMethod::Grid => f64::from(self.gutter) - 0.001,
                        _ => reach,
                    };
                    let low = (position - reach - 0.5).ceil();
                    let high = (position + reach - 0.5).floor();
                    ensure(
                        low.min_element() >= 0.0 && high.max_element() < size,
                        || format!("triangle {t} reaches {position}, the texture's border"),
                    )?;
                    for y in low.y as usize..=high.y as usize {
                        let row = y * self.pitch as usize;
                        let texels = &chart_of[row + low.x as usize..=row + high.x as usize];
                        ensure(texels.iter().all(|&c| c == self.chart[t as usize]), || {
                            format!("triangle {t} at {position} is not in its chart's texels")
                        })?;
                    }
                    let owner = self.owner[self.texel_of(t, u, v) as usize];
                    ensure(self.method != AtlasMethod::Grid || owner != NONE, || {
                        format!("triangle {t} at {position} is not in its chart's texels")
                    })?;
                }
                Ok(())
            })
    }

    /// Every owner contains its texel's centre, or the texel is its chart's only one.
    fn check_owners(&self) -> Result<(), String> {
        let texels = self.texels_of_charts();
        let owned: u64 = self
            .owner
            .par_iter()
            .enumerate()
            .filter(|&(_, &owner)| owner != NONE)
            .map(|(texel, &owner)| {
                let map = self
                    .maps
                    .get(owner as usize)
                    .ok_or_else(|| format!("texel {texel} is owned by triangle {owner}"))?;
                let distance = Affine::of(map).distance(self.centre_of(texel as u32).as_dvec2());
                let only = texels[self.chart[owner as usize] as usize] == 1;
                let slack = if only { ONLY_SLACK } else { CENTRE_SLACK };
                ensure(distance < slack, || {
                    format!("the centre of texel {texel} is outside its owner {owner}")
                })?;
                Ok(1)
            })
            .sum::<Result<u64, String>>()?;
        ensure(owned == u64::from(self.owned_count), || {
            format!("{owned} owned texels, not {}", self.owned_count)
        })
    }

    fn check_areas(&self, surface: &Surface) -> Result<(), String> {
        for (texel, &owner) in self.owner.iter().enumerate() {
            let (area, density) = (self.area[texel], self.density[texel]);
            let right = if owner == NONE {
                area == 0.0 && density == 0.0
            } else {
                area > 0.0 && density > 0.0 && density.is_finite()
            };
            ensure(right, || {
                format!("texel {texel} has area {area} and density {density}")
            })?;
        }
        let sum: f64 = self.area.iter().map(|&a| f64::from(a)).sum();
        let whole = surface_area(surface);
        ensure((sum / whole - 1.0).abs() < 1e-5, || {
            format!("texel areas add up to {sum}, the surface has {whole}")
        })
    }

    /// Rows name owned texels only and their weights sum to exactly 1.
    fn check_seams(&self) -> Result<(), String> {
        let mut previous = None;
        for (seam, gutter_texel) in self.seams.iter().zip(&self.gutter_texels) {
            let texel = seam.texel;
            ensure(
                texel == gutter_texel.texel && previous < Some(texel),
                || format!("the row of texel {texel} is out of order"),
            )?;
            previous = Some(texel);
            ensure(self.owner.get(texel as usize) == Some(&NONE), || {
                format!("texel {texel} has a row and an owner")
            })?;
            for (source, weight) in seam.source.into_iter().zip(seam.weights()) {
                let owned = self.owner.get(source as usize).is_some_and(|&t| t != NONE);
                ensure(owned && (0.0..=1.0).contains(&weight), || {
                    format!("texel {texel} reads texel {source} with weight {weight}")
                })?;
            }
            let sum: f32 = seam.weights().iter().sum();
            ensure(sum == 1.0, || {
                format!("the weights of texel {texel} sum to {sum}")
            })?;
        }
        Ok(())
    }

    /// All that reads near an owned texel can touch is owned by its chart or has a row of its chart.
    fn check_halo(&self, chart_of: &[u32]) -> Result<(), String> {
        let g = self.gutter as usize;
        let pitch = self.pitch as usize;
        (0..self.size as usize).into_par_iter().try_for_each(|y| {
            for x in 0..self.size as usize {
                let owner = self.owner[y * pitch + x];
                if owner == NONE {
                    continue;
                }
                let chart = self.chart[owner as usize];
                let last = self.size as usize - g;
                let room = (g..last).contains(&x) && (g..last).contains(&y);
                ensure(room, || format!("no gutter at ({x}, {y})"))?;
                for row in y - g..=y + g {
                    let from = row * pitch + x - g;
                    let same = chart_of[from..=from + 2 * g].iter().all(|&c| c == chart);
                    ensure(same, || {
                        format!("chart {chart} ends within the gutter of ({x}, {y})")
                    })?;
                }
            }
            Ok(())
        })
    }
}

fn ensure(holds: bool, problem: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(problem()) }
}
