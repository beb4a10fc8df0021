//! How gutter texels are filled, for any layout.
//!
//! A gutter texel is a place beyond its chart's border. From the border point nearest to it, just inside, a straight
//! walk goes the way that the chart's map says, over the seam and on; where it ends, the trail is read bilinearly.
//! Texels of that read that are themselves gutter texels are replaced by their own rows, again and again, until only
//! owned texels remain. Open borders reflect the walk; at vertices the edge that the walk meets decides.

use glam::{DVec2, Vec2};
use rayon::prelude::*;

use super::super::surface::{AtlasMap, NONE, Seam, Surface};
use super::super::walk::{BorderRule, Frame, SurfacePoint, walk};
use super::{GutterTexel, Layout};

/// How far inside its triangle a walk starts, as a share of the way to the centroid. Exactly on the border the walk
/// would meet that edge at distance 0, and a vertex would be on two edges at once.
const INSET: f64 = 1e-6;

/// A gutter may reach over many small triangles; a walk that goes on for longer than this reads where it stands.
const MAX_CROSSINGS: u32 = 4096;

/// Lighter taps are dropped: the margin that the maps keep makes such taps where a walk really ends on a texel's
/// centre.
const LEAST_TAP: f64 = 1.0 / 256.0;

/// How often gutter texels in rows are replaced by their own rows at the most.
const MAX_SWEEPS: u32 = 40;

/// A row that changes less than this in a sweep has settled.
const SETTLED: f32 = 1e-6;

/// Texels that a row may hold while it is resolved; the lightest are dropped.
const ROW_CAPACITY: usize = 8;

/// Final weights are multiples of 1 / 2^23, so they and their sums are exact in single precision.
const WEIGHT_UNITS: f64 = 8_388_608.0;

/// An [`AtlasMap`] in double precision, with its inverse.
#[derive(Clone, Copy, Debug)]
pub(super) struct Affine {
    origin: DVec2,
    du: DVec2,
    dv: DVec2,
}

impl Affine {
    pub(super) fn of(map: &AtlasMap) -> Self {
        Self {
            origin: map.origin.as_dvec2(),
            du: map.du.as_dvec2(),
            dv: map.dv.as_dvec2(),
        }
    }

    fn position_of(&self, uv: DVec2) -> DVec2 {
        self.origin + uv.x * self.du + uv.y * self.dv
    }

    pub(super) fn uv_of(&self, position: DVec2) -> DVec2 {
        let offset = position - self.origin;
        DVec2::new(offset.perp_dot(self.dv), self.du.perp_dot(offset)) / self.du.perp_dot(self.dv)
    }

    /// The `uv` of the point of the triangle's border that is nearest to a position, in texels.
    fn nearest_border_point(&self, position: DVec2) -> DVec2 {
        let corners = [DVec2::ZERO, DVec2::X, DVec2::Y];
        let mut nearest = (DVec2::ZERO, f64::INFINITY);
        for corner in 0..3 {
            let (start, end) = (corners[corner], corners[(corner + 1) % 3]);
            let (a, b) = (self.position_of(start), self.position_of(end));
            let along = (position - a).dot(b - a) / (b - a).length_squared();
            let along = along.clamp(0.0, 1.0);
            let distance = (a + along * (b - a) - position).length_squared();
            if distance < nearest.1 {
                nearest = (start + along * (end - start), distance);
            }
        }
        nearest.0
    }
}

/// One row for each gutter texel of a layout, in the same order.
///
/// # Panics
/// When a point of the surface has no owned or gutter texel under it: then the layout is wrong.
pub(super) fn seams(surface: &Surface, layout: &Layout, pitch: u32) -> Vec<Seam> {
    let finder = Finder::new(&layout.gutter_texels, pitch, layout.owner.len());
    let taps: Vec<Taps> = layout
        .gutter_texels
        .par_iter()
        .map(|&gutter_texel| {
            let position = unfold(surface, &layout.maps, pitch, gutter_texel);
            Taps::at(position, pitch, &layout.owner, &finder)
        })
        .collect();
    let rows = Rows::resolve(&taps);
    layout
        .gutter_texels
        .par_iter()
        .enumerate()
        .map(|(k, gutter_texel)| rows.row(k as u32).into_seam(gutter_texel.texel))
        .collect()
}

/// Where in the texture the surface is that lies under a gutter texel's centre when its chart is carried on.
fn unfold(surface: &Surface, maps: &[AtlasMap], pitch: u32, gutter_texel: GutterTexel) -> DVec2 {
    let GutterTexel { texel, triangle } = gutter_texel;
    let centre = Vec2::new((texel % pitch) as f32, (texel / pitch) as f32).as_dvec2() + 0.5;
    let map = Affine::of(&maps[triangle as usize]);
    let border = map.nearest_border_point(centre);
    let inside = border + INSET * (DVec2::splat(1.0 / 3.0) - border);
    let offset = map.uv_of(centre) - inside;
    let step = Frame::of(surface, triangle).position(offset.x, offset.y);
    let length = step.length();
    let start = SurfacePoint {
        triangle,
        u: inside.x,
        v: inside.y,
    };
    let end = walk(
        surface,
        start,
        step / length,
        length,
        Some(MAX_CROSSINGS),
        BorderRule::Reflect,
    )
    .point;
    Affine::of(&maps[end.triangle as usize]).position_of(DVec2::new(end.u, end.v))
}

/// Finds the place of a gutter texel in the ascending list of them.
struct Finder<'a> {
    gutter_texels: &'a [GutterTexel],
    pitch: u32,
    /// Per row of the texture: where it starts in the list; and the list's length.
    row_starts: Vec<usize>,
}

impl<'a> Finder<'a> {
    fn new(gutter_texels: &'a [GutterTexel], pitch: u32, texel_count: usize) -> Self {
        let row_starts = (0..=texel_count as u32 / pitch)
            .map(|y| gutter_texels.partition_point(|g| g.texel < y * pitch))
            .collect();
        Self {
            gutter_texels,
            pitch,
            row_starts,
        }
    }

    fn find(&self, texel: u32) -> Option<u32> {
        let y = (texel / self.pitch) as usize;
        let start = *self.row_starts.get(y)?;
        let row = &self.gutter_texels[start..*self.row_starts.get(y + 1)?];
        let found = row.binary_search_by_key(&texel, |g| g.texel).ok()?;
        Some((start + found) as u32)
    }
}

/// A bilinear read: up to four texels, the owned ones first.
#[derive(Clone, Copy, Debug)]
struct Taps {
    /// Owned texels, then indices into the list of gutter texels.
    index: [u32; 4],
    weight: [f32; 4],
    owned: u8,
    count: u8,
}

impl Taps {
    fn at(position: DVec2, pitch: u32, owner: &[u32], finder: &Finder) -> Self {
        let mut taps = Self {
            index: [0; 4],
            weight: [0.0; 4],
            owned: 0,
            count: 0,
        };
        let mut in_gutter = [(0, 0.0); 4];
        let mut in_gutter_count = 0;
        let corner = (position - 0.5).floor();
        let far = position - 0.5 - corner;
        for (x, y) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let along = |far: f64, k: u32| if k == 1 { far } else { 1.0 - far };
            let weight = along(far.x, x) * along(far.y, y);
            if weight < LEAST_TAP {
                continue;
            }
            // Every texel read is in the texture: charts have a gutter all round.
            let texel = (corner.y as u32 + y) * pitch + corner.x as u32 + x;
            if owner[texel as usize] != NONE {
                taps.push(texel, weight as f32);
            } else if let Some(found) = finder.find(texel) {
                in_gutter[in_gutter_count] = (found, weight as f32);
                in_gutter_count += 1;
            }
        }
        taps.owned = taps.count;
        for &(found, weight) in &in_gutter[..in_gutter_count] {
            taps.push(found, weight);
        }
        assert!(
            taps.count > 0,
            "no texel under the surface at {position} of the atlas"
        );
        taps
    }

    fn push(&mut self, index: u32, weight: f32) {
        self.index[self.count as usize] = index;
        self.weight[self.count as usize] = weight;
        self.count += 1;
    }

    fn owned(&self) -> impl Iterator<Item = (u32, f32)> + '_ {
        self.range(0, self.owned)
    }

    fn in_gutter(&self) -> impl Iterator<Item = (u32, f32)> + '_ {
        self.range(self.owned, self.count)
    }

    fn range(&self, from: u8, to: u8) -> impl Iterator<Item = (u32, f32)> + '_ {
        (from as usize..to as usize).map(|k| (self.index[k], self.weight[k]))
    }

    fn all_owned(&self) -> bool {
        self.owned == self.count
    }
}

/// Owned texels and their weights, heaviest first; the weights sum to 1 unless there are none.
#[derive(Clone, Copy, Debug, Default)]
struct Row {
    texel: [u32; ROW_CAPACITY],
    weight: [f32; ROW_CAPACITY],
    count: u8,
}

impl Row {
    /// Weights of the same texel are added up, in the order in which they come.
    fn of(entries: impl Iterator<Item = (u32, f32)>) -> Self {
        let mut merged = [(0, 0.0); 4 * ROW_CAPACITY];
        let mut count = 0;
        for (texel, weight) in entries {
            match merged[..count].iter_mut().find(|entry| entry.0 == texel) {
                Some(entry) => entry.1 += weight,
                None => {
                    merged[count] = (texel, weight);
                    count += 1;
                }
            }
        }
        let merged = &mut merged[..count];
        merged.sort_unstable_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let kept = &merged[..count.min(ROW_CAPACITY)];
        let sum: f32 = kept.iter().map(|entry| entry.1).sum();
        let mut row = Self {
            count: kept.len() as u8,
            ..Self::default()
        };
        for (k, &(texel, weight)) in kept.iter().enumerate() {
            row.texel[k] = texel;
            row.weight[k] = weight / sum;
        }
        row
    }

    fn entries(&self) -> impl Iterator<Item = (u32, f32)> + '_ {
        (0..self.count as usize).map(|k| (self.texel[k], self.weight[k]))
    }

    fn differs_from(&self, other: &Row) -> bool {
        self.count != other.count
            || self
                .entries()
                .zip(other.entries())
                .any(|(a, b)| a.0 != b.0 || (a.1 - b.1).abs() > SETTLED)
    }

    /// Keeps the four heaviest and makes the weights sum to exactly 1, in whatever order they are added.
    fn into_seam(self, texel: u32) -> Seam {
        assert!(self.count > 0, "gutter texel {texel} has no owned texel");
        let count = self.count.min(4) as usize;
        let sum: f64 = self.weight[..count].iter().map(|&w| f64::from(w)).sum();
        let mut source = [self.texel[0]; 4];
        let mut units = [0.0; 4];
        for k in 0..count {
            source[k] = self.texel[k];
            units[k] = (f64::from(self.weight[k]) / sum * WEIGHT_UNITS).round();
        }
        units[0] += WEIGHT_UNITS - units.iter().sum::<f64>();
        Seam {
            texel,
            source,
            weight: units.map(|unit| (unit / WEIGHT_UNITS) as f32),
        }
    }
}

/// What the gutter texels are filled from, in owned texels only.
///
/// Reads that touch no gutter texel are rows already. The others, the *open* ones, have a slot each; a sweep replaces
/// their gutter texels by the rows of the sweep before, so the order of work does not matter.
struct Rows<'a> {
    taps: &'a [Taps],
    /// Per gutter texel: its slot, or [`NONE`].
    slots: Vec<u32>,
    /// Per slot: the gutter texel's index.
    open: Vec<u32>,
    /// Per slot: the row as far as it is resolved.
    rows: Vec<Row>,
}

impl<'a> Rows<'a> {
    fn resolve(taps: &'a [Taps]) -> Self {
        let open: Vec<u32> = (0..taps.len() as u32)
            .filter(|&k| !taps[k as usize].all_owned())
            .collect();
        let mut slots = vec![NONE; taps.len()];
        for (slot, &k) in open.iter().enumerate() {
            slots[k as usize] = slot as u32;
        }
        let rows = open
            .par_iter()
            .map(|&k| Row::of(taps[k as usize].owned()))
            .collect();
        let mut rows = Self {
            taps,
            slots,
            open,
            rows,
        };
        let mut active: Vec<u32> = (0..rows.open.len() as u32).collect();
        for _ in 0..MAX_SWEEPS {
            let changed = rows.sweep(&active);
            active = rows.slots_that_read(&changed);
            if active.is_empty() {
                break;
            }
        }
        rows
    }

    /// Renews the rows in some slots; says for every slot whether its row changed.
    fn sweep(&mut self, active: &[u32]) -> Vec<bool> {
        let renewed: Vec<Row> = active
            .par_iter()
            .map(|&slot| {
                let taps = &self.taps[self.open[slot as usize] as usize];
                let behind = taps.in_gutter().flat_map(|(k, weight)| {
                    let row = self.row(k);
                    (0..row.count as usize).map(move |i| (row.texel[i], row.weight[i] * weight))
                });
                Row::of(taps.owned().chain(behind))
            })
            .collect();
        let mut changed = vec![false; self.open.len()];
        for (&slot, row) in active.iter().zip(renewed) {
            changed[slot as usize] = row.differs_from(&self.rows[slot as usize]);
            self.rows[slot as usize] = row;
        }
        changed
    }

    fn slots_that_read(&self, changed: &[bool]) -> Vec<u32> {
        (0..self.open.len() as u32)
            .into_par_iter()
            .filter(|&slot| {
                let taps = &self.taps[self.open[slot as usize] as usize];
                taps.in_gutter().any(|(k, _)| {
                    let slot = self.slots[k as usize];
                    slot != NONE && changed[slot as usize]
                })
            })
            .collect()
    }

    /// The row of a gutter texel, by its index in the list of them.
    fn row(&self, index: u32) -> Row {
        match self.slots[index as usize] {
            NONE => Row::of(self.taps[index as usize].owned()),
            slot => self.rows[slot as usize],
        }
    }
}
