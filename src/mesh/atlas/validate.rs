//! The checks of an atlas's invariants, for tests and for `--validate`.

use glam::Vec2;
use rayon::prelude::*;

use super::super::surface::{NONE, Surface};
use super::gutter::Affine;
use super::{Atlas, surface_area};

/// How far outside its owner's triangle an owned texel's centre may lie, in texels: the margin that maps keep.
const CENTRE_SLACK: f64 = 0.2;

impl Atlas {
    /// Checks every invariant against the surface that the atlas was built from.
    ///
    /// # Errors
    /// The first thing that is wrong, with its texel or triangle.
    pub fn validate(&self, surface: &Surface) -> Result<(), String> {
        self.check_sizes(surface)
            .and_then(|()| self.check_maps())
            .and_then(|()| self.check_owners())
            .and_then(|()| self.check_areas(surface))
            .and_then(|()| self.check_seams())
            .and_then(|()| self.check_halo())
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
        )
    }

    /// Corners and centroid of every triangle fall into owned texels of its own chart.
    fn check_maps(&self) -> Result<(), String> {
        let third = 1.0 / 3.0;
        let points = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (third, third)];
        (0..self.maps.len() as u32)
            .into_par_iter()
            .try_for_each(|t| {
                for (u, v) in points {
                    let position = self.position_of(t, u, v);
                    let inside = Vec2::ZERO.cmple(position) & position.cmplt(self.size_vector());
                    ensure(inside.all(), || format!("triangle {t} reaches {position}"))?;
                    let owner = self.owner[self.texel_of(t, u, v) as usize];
                    ensure(
                        owner != NONE && self.chart[owner as usize] == self.chart[t as usize],
                        || format!("triangle {t} at {position} is not in its chart's texels"),
                    )?;
                }
                Ok(())
            })
    }

    fn size_vector(&self) -> Vec2 {
        Vec2::splat(self.size as f32)
    }

    /// Every owner contains its texel's centre.
    fn check_owners(&self) -> Result<(), String> {
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
                let uv = Affine::of(map).uv_of(self.centre_of(texel as u32).as_dvec2());
                let least = uv.x.min(uv.y).min(1.0 - uv.x - uv.y);
                let slack = CENTRE_SLACK / f64::from(map.du.length().min(map.dv.length()));
                ensure(least > -slack, || {
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
    fn check_halo(&self) -> Result<(), String> {
        let mut chart_of = vec![NONE; self.texel_count()];
        for (texel, &owner) in self.owner.iter().enumerate() {
            if owner != NONE {
                chart_of[texel] = self.chart[owner as usize];
            }
        }
        for gutter_texel in &self.gutter_texels {
            chart_of[gutter_texel.texel as usize] = self.chart[gutter_texel.triangle as usize];
        }
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
