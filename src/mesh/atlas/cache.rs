//! Layouts on disk, so that the next start does not have to cut and pack again.
//!
//! A file holds the places of triangles and nothing that follows from them. Its name is a hash of everything that the layout depends on. A
//! file is ignored and replaced if it is damaged or not of this format, or if its checksum is right but its triangles overlap or lie too
//! near to those of other charts. Errors here never make the program fail.

use std::path::Path;

use bytemuck::{Pod, pod_read_unaligned};
use glam::{IVec2, Vec2};

use super::super::surface::{AtlasMap, Surface};
use super::fixed::{Fixed, twice_area};
use super::owners::{self, Conflict};
use super::{AtlasError, AtlasOptions, Control, overlap, surface_area};
use crate::kept_files::{Hash, KeptFile, LAYOUTS};

/// Raise it whenever the layout of the same surface and options changes.
const VERSION: u32 = 5;
/// Charts nearly keep areas: a triangle whose area is that of so many texels must have an area in the texture.
const SEVERAL_TEXELS: f64 = 4.0;

/// The result of a layout method: the map and the chart of each triangle, and the number of charts.
pub(super) type Places = (Vec<AtlasMap>, Vec<u32>, u32);

/// Returns the cached layout of this surface and these options, or makes and caches it. Without a folder it is always made.
pub(super) fn kept(
    surface: &Surface,
    options: &AtlasOptions,
    control: &Control<'_>,
    make: impl FnOnce() -> Result<Places, AtlasError>,
) -> Result<Places, AtlasError> {
    let slot = control
        .cache
        .map(|folder| Slot::new(folder, surface, options));
    if let Some((slot, placement)) = slot.as_ref().and_then(|slot| Some((slot, slot.load()?))) {
        match placement.problem(surface, options, control)? {
            None => return Ok((placement.maps, placement.chart, placement.chart_count)),
            Some(problem) => log::warn!(
                "the atlas kept in {} does not belong to this surface: {problem}; a new one is made",
                slot.file.path().display()
            ),
        }
    }
    let (maps, chart, chart_count) = make()?;
    let placement = Placement {
        maps,
        chart,
        chart_count,
    };
    if let Some(slot) = slot {
        slot.store(&placement);
    }
    Ok((placement.maps, placement.chart, placement.chart_count))
}

/// The places of triangles.
#[derive(Clone, Debug, PartialEq)]
struct Placement {
    maps: Vec<AtlasMap>,
    /// Per triangle.
    chart: Vec<u32>,
    chart_count: u32,
}

impl Placement {
    /// Why it is no layout of the surface, although its file is whole; `None` if it is one.
    fn problem(
        &self,
        surface: &Surface,
        options: &AtlasOptions,
        control: &Control<'_>,
    ) -> Result<Option<String>, AtlasError> {
        let fixed = Fixed::new(options.size, options.gutter);
        let corners: Vec<[IVec2; 3]> = self.maps.iter().map(|map| fixed.corners_of(map)).collect();
        let is_on_grid = |(map, corners): (&AtlasMap, &[IVec2; 3])| fixed.map_of(*corners) == *map;
        if let Some(t) = self
            .maps
            .iter()
            .zip(&corners)
            .position(|both| !is_on_grid(both))
        {
            return Ok(Some(format!("triangle {t} does not lie on the grid")));
        }
        let mut has_triangles = vec![false; self.chart_count as usize];
        for &chart in &self.chart {
            has_triangles[chart as usize] = true;
        }
        if let Some(chart) = has_triangles.iter().position(|has| !has) {
            return Ok(Some(format!("chart {chart} has no triangles")));
        }
        if let Some(t) = flattened(surface, options, &corners, fixed) {
            return Ok(Some(format!("triangle {t} has no area")));
        }
        if let Some((a, b)) = overlap::first(&corners, fixed, control)? {
            return Ok(Some(format!("triangles {a} and {b} lie on each other")));
        }
        let conflict = owners::conflict(surface, &self.maps, &self.chart, options);
        Ok(conflict.map(
            |Conflict {
                 triangles: [a, b], ..
             }| { format!("the charts of triangles {a} and {b} want the same texel") },
        ))
    }
}

/// A triangle without area in the texture whose area on the surface would fill several texels. Thin triangles may have no area.
fn flattened(
    surface: &Surface,
    options: &AtlasOptions,
    corners: &[[IVec2; 3]],
    fixed: Fixed,
) -> Option<usize> {
    let texel = f64::from(fixed.texel) * f64::from(fixed.texel);
    let texels = |corners: &[IVec2; 3]| twice_area(*corners).unsigned_abs() as f64 / (2.0 * texel);
    let whole: f64 = corners.iter().map(texels).sum();
    let density = whole / surface_area(surface);
    let weights = options.weights.iter().copied();
    let (least, most) = weights.fold((1.0, 1.0), |(least, most): (f32, f32), weight| {
        (least.min(weight), most.max(weight))
    });
    let enough = SEVERAL_TEXELS * f64::from(most / least);
    let is_flattened = |(t, corners): (usize, &[IVec2; 3])| {
        twice_area(*corners) == 0 && density * surface.area(t as u32) > enough
    };
    corners.iter().enumerate().position(is_flattened)
}

/// The file of one layout.
struct Slot {
    file: KeptFile,
    triangle_count: usize,
    size: u32,
}

impl Slot {
    /// The file for the layout of a surface.
    fn new(folder: &Path, surface: &Surface, options: &AtlasOptions) -> Self {
        Self {
            file: KeptFile::new(folder, key(surface, options), &LAYOUTS),
            triangle_count: surface.corners.len(),
            size: options.size,
        }
    }

    /// The cached layout, if it is whole and could be one of the surface.
    fn load(&self) -> Option<Placement> {
        self.file
            .load(|content| unpack(content, self.triangle_count, self.size))
    }

    /// Stores a layout.
    fn store(&self, placement: &Placement) {
        self.file.store(&pack(placement));
    }
}

/// A hash of everything that the layout depends on: 128 bits, so that collisions are practically impossible.
fn key(surface: &Surface, options: &AtlasOptions) -> u128 {
    let AtlasOptions {
        method,
        size,
        cell_size,
        gutter,
        // Nothing of a layout depends on it.
        taps: _,
        weights,
        turn,
    } = options;
    let mut hash = Hash::new();
    hash.slice(&[VERSION, *method as u32, *size, *cell_size, *gutter]);
    hash.slice(weights);
    hash.slice(&[*turn]);
    hash.slice(&surface.positions);
    hash.slice(&surface.corners);
    // Lengths come from positions before rounding, and twins from the loader's choice at odd edges.
    hash.slice(&surface.triangles);
    hash.slice(&surface.halfedges);
    for object in &surface.objects {
        hash.slice(&[
            object.triangles.0,
            object.triangles.1,
            object.vertices.0,
            object.vertices.1,
        ]);
    }
    for uvs in &surface.uvs {
        hash.slice(uvs.as_deref().unwrap_or_default());
    }
    hash.finish()
}

/// Counts, maps, charts.
fn pack(placement: &Placement) -> Vec<u8> {
    let mut content = Vec::new();
    content.extend((placement.maps.len() as u32).to_le_bytes());
    content.extend(placement.chart_count.to_le_bytes());
    content.extend(bytemuck::cast_slice::<_, u8>(&placement.maps));
    content.extend(bytemuck::cast_slice::<_, u8>(&placement.chart));
    content
}

/// The layout of so many triangles in a texture of this size, if the content of a whole file is one.
fn unpack(content: &[u8], triangle_count: usize, size: u32) -> Option<Placement> {
    let (count, rest) = content.split_first_chunk::<4>()?;
    let (chart_count, rest) = rest.split_first_chunk::<4>()?;
    let chart_count = u32::from_le_bytes(*chart_count);
    let maps_len = triangle_count * size_of::<AtlasMap>();
    if u32::from_le_bytes(*count) as usize != triangle_count
        || rest.len() != maps_len + triangle_count * size_of::<u32>()
    {
        return None;
    }
    let (maps, chart) = rest.split_at(maps_len);
    let placement = Placement {
        maps: items(maps),
        chart: items(chart),
        chart_count,
    };
    is_possible(&placement, size).then_some(placement)
}

/// Does every triangle lie in the texture and in an existing chart?
fn is_possible(placement: &Placement, size: u32) -> bool {
    // False for NaN.
    let in_texture = |p: Vec2| (p.cmpge(Vec2::ZERO) & p.cmple(Vec2::splat(size as f32))).all();
    let inside = |map: &AtlasMap| {
        let corners = [map.origin, map.origin + map.du, map.origin + map.dv];
        corners.into_iter().all(in_texture)
    };
    placement.maps.iter().all(inside)
        && placement.chart.iter().all(|&c| c < placement.chart_count)
        && placement.chart_count as usize <= placement.maps.len()
}

fn items<T: Pod>(bytes: &[u8]) -> Vec<T> {
    // The file's bytes lie at any address.
    bytes
        .chunks_exact(size_of::<T>())
        .map(pod_read_unaligned)
        .collect()
}

#[cfg(test)]
mod tests;
