//! Layouts on disk, so that the next start does not have to cut and pack again.
//!
//! A file holds the places of triangles and nothing that follows from them. Its name is a hash of everything that the layout depends on. A
//! file is ignored and replaced if it is damaged or not of this format, or if its checksum is right but its triangles overlap or lie too
//! near to those of other charts. Errors here never make the program fail.

use std::fs;
use std::hash::{DefaultHasher, Hasher};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use bytemuck::{Pod, pod_read_unaligned};
use glam::{IVec2, Vec2};

use super::super::surface::{AtlasMap, Surface};
use super::fixed::{Fixed, twice_area};
use super::raster::{self, Conflict};
use super::{AtlasError, AtlasOptions, Control, overlap, surface_area, triangle_area};
use crate::whole_file::WholeFile;

const MAGIC: &[u8; 8] = b"MYXOAT01";
/// Raise it whenever the layout of the same surface and options changes.
const VERSION: u32 = 5;
/// Beyond so many bytes, or files, the least recently used files are removed.
const MOST_BYTES: u64 = 256 << 20;
const MOST_FILES: usize = 64;
/// Another process may still be writing a temporary file that is younger.
const ABANDONED_AFTER: Duration = Duration::from_secs(3600);
/// Charts nearly keep areas: a triangle whose area is that of so many texels must have an area in the texture.
const SEVERAL_TEXELS: f64 = 4.0;
const ENDING: &str = "atlas";

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
                slot.file.display()
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
        let conflict = raster::conflict(surface, &self.maps, &self.chart, options);
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
        twice_area(*corners) == 0 && density * triangle_area(surface, t as u32) > enough
    };
    corners.iter().enumerate().position(is_flattened)
}

/// The file of one layout.
struct Slot {
    folder: PathBuf,
    file: PathBuf,
    triangle_count: usize,
    size: u32,
}

impl Slot {
    /// The file for the layout of a surface.
    fn new(folder: &Path, surface: &Surface, options: &AtlasOptions) -> Self {
        Self {
            folder: folder.to_owned(),
            file: folder.join(format!("{:032x}.{ENDING}", key(surface, options))),
            triangle_count: surface.corners.len(),
            size: options.size,
        }
    }

    /// The cached layout, if it is whole and could be one of the surface.
    fn load(&self) -> Option<Placement> {
        let bytes = fs::read(&self.file).ok()?;
        let placement = unpack(&bytes, self.triangle_count, self.size);
        match &placement {
            // Updates the time of use, by which old files are removed. If the system refuses, the time of creation counts.
            Some(_) => drop(
                fs::File::open(&self.file).and_then(|file| file.set_modified(SystemTime::now())),
            ),
            None => log::debug!("{} is not a whole layout", self.file.display()),
        }
        placement
    }

    /// Stores a layout. Its file is complete or absent at every moment, even if other processes write it, too.
    fn store(&self, placement: &Placement) {
        let written = WholeFile::create(&self.file).and_then(|mut file| {
            file.write_all(&pack(placement))?;
            file.finish()
        });
        if let Err(error) = written {
            log::warn!(
                "cannot keep the atlas in {}: {error}; the next start takes as long",
                self.file.display()
            );
        }
        if let Err(error) = tidy(&self.folder, MOST_BYTES, MOST_FILES) {
            log::debug!("cannot tidy {}: {error}", self.folder.display());
        }
    }
}

/// A hash of everything that the layout depends on: 128 bits, so that collisions are practically impossible.
fn key(surface: &Surface, options: &AtlasOptions) -> u128 {
    let AtlasOptions {
        method,
        size,
        cell_size,
        gutter,
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

/// Two hashes of 64 bits with different initial values.
struct Hash([DefaultHasher; 2]);

impl Hash {
    fn new() -> Self {
        let mut second = DefaultHasher::new();
        second.write_u64(0x9E37_79B9_7F4A_7C15);
        Self([DefaultHasher::new(), second])
    }

    /// Hashes the length, too, so that moving items from one slice to the next changes the hash.
    fn slice<T: Pod>(&mut self, items: &[T]) {
        for hasher in &mut self.0 {
            hasher.write_u64(items.len() as u64);
            hasher.write(bytemuck::cast_slice(items));
        }
    }

    fn finish(self) -> u128 {
        let [first, second] = self.0.map(|hasher| u128::from(hasher.finish()));
        first << 64 | second
    }
}

/// Magic, checksum of the rest, counts, maps, charts.
fn pack(placement: &Placement) -> Vec<u8> {
    let mut content = Vec::new();
    content.extend((placement.maps.len() as u32).to_le_bytes());
    content.extend(placement.chart_count.to_le_bytes());
    content.extend(bytemuck::cast_slice::<_, u8>(&placement.maps));
    content.extend(bytemuck::cast_slice::<_, u8>(&placement.chart));
    let mut bytes = MAGIC.to_vec();
    bytes.extend(crc32fast::hash(&content).to_le_bytes());
    bytes.extend(content);
    bytes
}

/// The layout of so many triangles in a texture of this size, if the bytes are one.
fn unpack(bytes: &[u8], triangle_count: usize, size: u32) -> Option<Placement> {
    let (magic, rest) = bytes.split_first_chunk::<8>()?;
    let (sum, content) = rest.split_first_chunk::<4>()?;
    if magic != MAGIC || u32::from_le_bytes(*sum) != crc32fast::hash(content) {
        return None;
    }
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

/// Removes the least recently used layouts until the rest is small enough, and unfinished files of ended processes.
fn tidy(folder: &Path, most_bytes: u64, most_files: usize) -> io::Result<()> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let Ok(metadata) = entry.metadata() else {
            continue; // Another process has just removed it.
        };
        let modified = metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH);
        let path = entry.path();
        let ending = path.extension().and_then(|ending| ending.to_str());
        let name = entry.file_name().to_string_lossy().into_owned();
        if ending == Some(ENDING) && metadata.is_file() {
            files.push((modified, metadata.len(), path));
        } else if name.starts_with('.')
            && name.contains(ENDING)
            && modified.elapsed().is_ok_and(|age| age > ABANDONED_AFTER)
        {
            let _ = fs::remove_file(path);
        }
    }
    // The latest first; names decide where times are equal.
    files.sort_by(|a, b| b.cmp(a));
    let mut bytes = 0;
    for (i, (_, len, path)) in files.iter().enumerate() {
        bytes += len;
        // The latest stays, however large: it was needed just now.
        if i > 0 && (bytes > most_bytes || i >= most_files) {
            let _ = fs::remove_file(path);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
