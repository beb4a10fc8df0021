//! The device memory that a scene takes, and whether the device supports its buffers. Messages use the terms of the scene file.
//! The check needs only settings and meshes, so it runs before anything takes time; that of the seams needs the atlas.

use super::buffers::{Counts, bytes};
use super::counts::texel_count;
use super::distance::{GROUP, TILE_CANDIDATES, TILE_SAMPLES};
use super::setup::Setup;
use super::texel_paths::TexelPaths;
use super::types::{ObjectPair, Particle, Seam, SurfaceSample, Vertex};
use super::{brute, raster};
use crate::error::{Error, Result};
use crate::gpu::{DeviceInfo, DeviceKind, Tables, most_in_pages};
use crate::mesh::atlas::{Atlas, AtlasError, AtlasMethod, MAX_SIZE, PackedEntries, PackedRow};
use crate::mesh::strip::StripTriangle;
use crate::plain_text::counted;
use crate::scene::Scene;
use crate::scene::parameters::grouped;
use crate::scene::settings::{DistanceMethod, Settings};

/// Bytes that the buffers of a simulation take on the device, without areas that are painted later. Pictures need more: some bytes a pixel,
/// about 4 a texel and 20 a triangle, and for quick pictures on a CPU device another 28 to 108 a triangle.
#[must_use]
pub fn size_in_bytes(setup: &Setup, settings: &Settings) -> u64 {
    bytes(&Counts::of(setup, settings))
}

/// About how many bytes a scene takes on the device, from its settings and meshes, before there is an atlas. Not included are the tables of
/// seams, the inputs of the raster method, the lists of transfers, those of the texels within reach of food, and the bins that particles
/// are sorted by (up to 8 MiB). With several objects, every texel counts as owned.
#[must_use]
pub fn needed(scene: &Scene) -> u64 {
    bytes(&Counts::about(scene))
}

/// About how many bytes a scene takes in all, given those on the device: on a driver that computes on the processor twice as many, because
/// setting up and reading back take as much again.
#[must_use]
pub fn in_all(on_device: u64, kind: DeviceKind) -> u64 {
    let times = if kind == DeviceKind::Cpu { 2 } else { 1 };
    times * on_device
}

/// Bytes of a painted bias, before there is an atlas.
#[must_use]
pub fn needed_for_painted(scene: &Scene) -> u64 {
    painted_bytes(texel_count(scene.settings.atlas.size.into()))
}

/// Additional bytes for a painted bias on `texels` texels.
#[must_use]
pub fn painted_bytes(texels: u64) -> u64 {
    texels * TEXEL
}

/// How the tables of so many particles are stored.
#[must_use]
pub fn tables(device: &DeviceInfo, particles: u64) -> Tables {
    Tables::of_size(device, particles * PARTICLE)
}

/// How many particles the device's buffers hold: kernels access each as a texel, or with pages by its place in a list.
#[must_use]
pub fn most_particles(device: &DeviceInfo) -> u64 {
    particle_limit(device).0
}

/// Texels along the side of the largest atlas of a single object.
#[must_use]
pub fn largest_atlas(device: &DeviceInfo) -> u64 {
    side_of(texel_limit(device).0)
}

/// Texels along the side of the largest atlas of a scene's objects. With several objects, the buffers of distances limit it, too.
#[must_use]
pub fn largest_atlas_of(device: &DeviceInfo, settings: &Settings) -> u64 {
    let objects = settings.objects.len() as u64;
    if objects < 2 {
        return largest_atlas(device);
    }
    let block = largest_buffer(device).0;
    let samples = sample_limit(device, settings).0;
    let mut size = side_of(texel_limit(device).0.min(samples));
    if settings.uses_raster() {
        size = size.min(device.max_image_side.into());
    }
    while largest_block(settings, texel_count(size)) > block && size > 0 {
        size -= 1;
    }
    size
}

/// The largest number of owned texels with distances between several objects, and the name of the limit.
fn sample_limit(device: &DeviceInfo, settings: &Settings) -> (u64, &'static str) {
    let (single, limit_name) = single_elements(device);
    let padding = settings.objects.len() as u64 * PADDING;
    let single = (single.saturating_sub(padding), limit_name);
    let in_quads = (quad_bytes(device) / SAMPLE, limit_name);
    let allocated = (device.max_memory_allocation_size / SAMPLE, ALLOCATION);
    let least = single.min(in_quads).min(allocated);
    match settings.uses_raster() {
        // Drawn distances are read through texel views, one place per texel.
        true => least.min((device.max_texel_buffer_elements.into(), TEXEL_ELEMENTS)),
        false => least,
    }
}

/// Bytes of the largest storage block that distances between objects are taken from, if all texels are owned.
fn largest_block(settings: &Settings, texels: u64) -> u64 {
    // The largest of all lists of tiles, and larger than arrays with one word per texel.
    let candidates = (texels + settings.objects.len() as u64 * PADDING) * CANDIDATES;
    match settings.distance.method {
        DistanceMethod::Bvh => candidates,
        DistanceMethod::Brute | DistanceMethod::Raster => candidates.max(texels * SAMPLE),
    }
}

/// The message that an atlas of the scene's size is too large, with the largest size that fits.
fn too_large_an_atlas(device: &DeviceInfo, settings: &Settings) -> String {
    let size = u64::from(settings.atlas.size);
    let texels = texel_count(size);
    let objects = settings.objects.len() as u64;
    let method = settings.distance.method;
    let of = |(texels, limit_name): (u64, &str), what| {
        format!("{what} holds {} texels ({limit_name})", number(texels))
    };
    let block = largest_block(settings, texels);
    let why = if texels > texel_limit(device).0 {
        let texture = human(texels * TEXEL);
        format!(
            "takes {texture} a texture, and {}",
            of(texel_limit(device), "a texture")
        )
    } else if block > largest_buffer(device).0 {
        format!(
            "takes {} for distances between objects, and {}",
            human(block),
            holds(device)
        )
    } else if settings.uses_raster() && size > device.max_image_side.into() {
        let most = number(device.max_image_side.into());
        format!("is drawn into, and an image has {most} pixels a side at the most")
    } else {
        let samples = human(texels * SAMPLE);
        let held = of(sample_limit(device, settings), "one buffer");
        format!("takes {samples} for distances between objects, and {held}")
    };
    let mut by_trees = settings.clone();
    by_trees.distance.method = DistanceMethod::Bvh;
    let other_way = if objects > 1 && size <= largest_atlas_of(device, &by_trees) {
        "take distance.method = \"bvh\", or "
    } else {
        ""
    };
    let with = if other_way.is_empty() {
        String::new()
    } else {
        format!(" with distance.method = \"{}\"", method.word())
    };
    format!(
        "atlas.size = {}{with} {why}: {other_way}use at most {}",
        number(size),
        number(largest_atlas_of(device, settings))
    )
}

/// The largest number of particles, and the name of the limit.
fn particle_limit(device: &DeviceInfo) -> (u64, &'static str) {
    if device.has_pages {
        let (bytes, limit_name) = largest_buffer(device);
        let pages = (most_in_pages(device) / PARTICLE, "1,024 pages");
        return pages.min((bytes / LISTED, limit_name));
    }
    let texels = (device.max_texel_buffer_elements.into(), TEXEL_ELEMENTS);
    texels.min((device.max_memory_allocation_size / PARTICLE, ALLOCATION))
}

/// Most texels of a texture, and the name of the limit.
fn texel_limit(device: &DeviceInfo) -> (u64, &'static str) {
    let texels = (TexelPaths::most_texels(device), TEXEL_ELEMENTS);
    texels.min((device.max_memory_allocation_size / TEXEL, ALLOCATION))
}

/// The side of the largest texture with at most so many texels.
fn side_of(texels: u64) -> u64 {
    let mut size = texels.isqrt();
    // Rows are padded to whole quads of texels.
    while texel_count(size) > texels {
        size -= 1;
    }
    size
}

/// How many triangles one buffer of the device holds.
#[must_use]
pub fn most_triangles(device: &DeviceInfo) -> u64 {
    let bytes = largest_buffer(device).0;
    // The table that is a storage block, and the largest that is read as texels of 16 bytes.
    (bytes / CORNERS).min(viewed_bytes(device).0 / STRIP)
}

/// How many bytes pictures reach of a buffer that they read as texels of 16 bytes: through a view, on every device.
fn viewed_bytes(device: &DeviceInfo) -> (u64, &'static str) {
    let view = 16 * u64::from(device.max_texel_buffer_elements);
    let allocation = device.max_memory_allocation_size;
    if allocation < view {
        (allocation, ALLOCATION)
    } else {
        (view, TEXEL_ELEMENTS)
    }
}

/// How many bytes kernels reach of a buffer that they alone read as texels of 16 bytes.
fn quad_bytes(device: &DeviceInfo) -> u64 {
    let bytes = match device.reads_blocks {
        true => device.max_storage_buffer_range,
        false => viewed_bytes(device).0,
    };
    bytes.min(device.max_memory_allocation_size)
}

/// How many elements kernels reach of a buffer that they read as texels of four bytes.
fn single_elements(device: &DeviceInfo) -> (u64, &'static str) {
    match device.reads_blocks {
        true => (
            device.max_storage_buffer_range / TEXEL,
            "maxStorageBufferRange",
        ),
        false => (device.max_texel_buffer_elements.into(), TEXEL_ELEMENTS),
    }
}

/// How many objects there may be so that one buffer of the device holds all pairs of them.
#[must_use]
pub fn most_objects(device: &DeviceInfo) -> u64 {
    let pairs = largest_buffer(device).0 / PAIR;
    // n (n - 1) pairs.
    let mut most = pairs.isqrt() + 1;
    while most * (most - 1) > pairs {
        most -= 1;
    }
    most
}

/// Makes sure that no buffer of the scene is larger than the device allows.
///
/// # Errors
/// Names every setting that is too large, the device's limit, and the largest value that fits.
pub fn check(device: &DeviceInfo, scene: &Scene) -> Result<()> {
    let holds = holds(device);
    let mut problems = Vec::new();

    let particles = u64::from(scene.settings.slots());
    let key = match particles > u64::from(scene.settings.particles.count) {
        true => "population.capacity",
        false => "particles.count",
    };
    let (most, limit_name) = particle_limit(device);
    if particles > most {
        let most = number(most);
        problems.push(format!(
            "{key} = {} takes {} a table, and there is room for {most} ({limit_name}): use at most {most}",
            number(particles),
            human(particles * PARTICLE),
        ));
    }
    let size = u64::from(scene.settings.atlas.size);
    if size > largest_atlas_of(device, &scene.settings) {
        problems.push(too_large_an_atlas(device, &scene.settings));
    }
    let triangles = scene.surface.corners.len() as u64;
    let most = most_triangles(device);
    if triangles > most {
        // Either table may be the one that is too large.
        let corners = triangles * CORNERS;
        let (table, takes, room) = if corners > largest_buffer(device).0 {
            ("corners", corners, holds.clone())
        } else {
            let (bytes, limit) = viewed_bytes(device);
            let room = format!("one view shows {} ({limit})", human(bytes));
            ("edges and shapes", triangles * STRIP, room)
        };
        problems.push(format!(
            "the meshes have {} triangles, whose {table} take {}, and {room}: use at most {}",
            number(triangles),
            human(takes),
            number(most)
        ));
    }
    let vertices = scene.surface.positions.len() as u64 * VERTEX;
    let limit = largest_buffer(device).0.min(viewed_bytes(device).0);
    if vertices > limit && triangles <= most {
        problems.push(format!(
            "the meshes have {} vertices, which take {}, and {holds}: use at most {}",
            number(vertices / VERTEX),
            human(vertices),
            number(limit / VERTEX)
        ));
    }
    let objects = scene.surface.objects.len() as u64;
    if objects > 1 {
        let normals = (3 * triangles + scene.surface.positions.len() as u64) * NORMAL;
        let limit = quad_bytes(device);
        if normals > limit && triangles <= most {
            problems.push(format!(
                "the normals of the edges and vertices of {} triangles take {}, and one buffer holds {}: use at most {} for distances between objects",
                number(triangles),
                human(normals),
                human(limit),
                number(limit / (4 * NORMAL))
            ));
        }
        let most = most_objects(device);
        if objects > most {
            problems.push(format!(
                "the scene has {} objects, whose pairs take {}, and {holds}: use at most {}",
                number(objects),
                human(objects * (objects - 1) * PAIR),
                number(most)
            ));
        }
    }
    problems.extend(raster::check(&scene.surface, &scene.settings).err());
    problems.extend(brute::check(device, &scene.surface, &scene.settings).err());
    match problems.as_slice() {
        [] => Ok(()),
        [only] => Err(too_large(device, only)),
        many => Err(too_large(device, &format!("\n  {}", many.join("\n  ")))),
    }
}

/// Makes sure that an atlas that is larger than the `asked` side, by its gutters, and the tables of its seams are no larger than the device
/// allows. Their size is known only once the atlas exists.
///
/// # Errors
/// Names what is too large, the device's limit, and how to make it smaller.
pub fn check_atlas(device: &DeviceInfo, atlas: &Atlas, asked: u32) -> Result<()> {
    let largest = largest_atlas(device);
    if atlas.size != asked && u64::from(atlas.size) > largest {
        let gutters = 2 * u64::from(atlas.gutter);
        return Err(too_large(
            device,
            &format!(
                "atlas.size = {} makes a texture of {} texels a side, because a gutter of {} lies round it, and the largest has {}: use at \
                 most {}",
                number(asked.into()),
                number(atlas.size.into()),
                number(atlas.gutter.into()),
                number(largest),
                number(largest.saturating_sub(gutters)),
            ),
        ));
    }
    let quads = quad_bytes(device);
    let tables = [
        (atlas.seams.len() as u64, SEAM, quads, "gutter texels"),
        (
            atlas.exchange.rows.len() as u64,
            ROW,
            quads,
            "texels beside seams",
        ),
        (
            atlas.exchange.packed_entries() as u64,
            ENTRIES,
            quads,
            "pairs of exchanges over seams",
        ),
    ];
    let Some((count, size, limit, what)) = tables
        .into_iter()
        .find(|(count, size, limit, _)| count * size > *limit)
    else {
        return Ok(());
    };
    let fewer_seams = match atlas.method {
        AtlasMethod::Grid => ", or take atlas.method = \"charts\", which has fewer seams",
        AtlasMethod::Charts | AtlasMethod::Mesh => "",
    };
    Err(too_large(
        device,
        &format!(
            "atlas.size = {} with atlas.method = \"{}\" makes {} {what}, which take {}, and one buffer holds {}: lower atlas.size{fewer_seams}",
            number(asked.into()),
            atlas.method.word(),
            number(count),
            human(count * size),
            human(limit),
        ),
    ))
}

/// Makes sure that a running simulation can compute distances by the settings' method.
///
/// # Errors
/// Names the method, the device's limit, and the method that works.
pub fn check_method(device: &DeviceInfo, setup: &Setup, settings: &Settings) -> Result<()> {
    let method = settings.distance.method;
    let samples = size_of_val(&setup.distance.samples[..]) as u64;
    let is_drawn = settings.uses_raster();
    let texels = setup.atlas.texel_count() as u64;
    let (what, limit) = if method != DistanceMethod::Bvh && samples > largest_buffer(device).0 {
        (format!("takes {}", human(samples)), holds(device))
    } else if is_drawn && texels > device.max_texel_buffer_elements.into() {
        let limit = format!(
            "a texel buffer holds {}",
            number(device.max_texel_buffer_elements.into())
        );
        (format!("draws into {} texels", number(texels)), limit)
    } else if is_drawn && setup.atlas.pitch.max(setup.atlas.size) > device.max_image_side {
        let most = number(device.max_image_side.into());
        let size = number(setup.atlas.size.into());
        let limit = format!("an image has {most} at the most");
        (format!("draws into {size} texels a side"), limit)
    } else {
        return Ok(());
    };
    Err(too_large(
        device,
        &format!(
            "distance.method = \"{}\" {what}, and {limit}: use distance.method = \"bvh\", or restart with a smaller atlas.size",
            method.word()
        ),
    ))
}

/// The error of the atlas, but never with advice of a size that this device does not hold.
#[must_use]
pub fn atlas_error(device: &DeviceInfo, settings: &Settings, error: AtlasError) -> Error {
    let (what, needed, about, advice) = match &error {
        AtlasError::NoRoom {
            triangles, needed, ..
        } => (
            counted(*triangles, "triangle", "triangles"),
            *needed,
            "",
            "use meshes with fewer triangles",
        ),
        AtlasError::NoRoomForCharts { charts, needed, .. } => (
            counted(*charts, "chart", "charts"),
            *needed,
            "",
            "use meshes with fewer parts and triangles, or a smaller gutter",
        ),
        AtlasError::OwnUvsTooDense {
            object,
            needed,
            tried,
            ..
        } => (
            format!("the texture coordinates of object {object}"),
            u64::from(*needed),
            if *tried { "" } else { "about " },
            "repair them, or choose atlas.method charts or grid",
        ),
        _ => return Error::Atlas(error),
    };
    let largest = largest_atlas_of(device, settings);
    if needed <= largest {
        return Error::Atlas(error);
    }
    let needed = if needed > u64::from(MAX_SIZE) {
        format!("> {}", number(MAX_SIZE.into()))
    } else {
        format!("= {about}{}", number(needed))
    };
    too_large(
        device,
        &format!(
            "{what} must have atlas.size {needed}, and the largest that it holds is {}: {advice}",
            number(largest)
        ),
    )
}

fn too_large(device: &DeviceInfo, problem: &str) -> Error {
    Error::Invalid(format!("too large for {}: {problem}", device.name))
}

/// Limits' names in Vulkan.
const TEXEL_ELEMENTS: &str = "maxTexelBufferElements";
const ALLOCATION: &str = "maxMemoryAllocationSize";
const PARTICLE: u64 = size_of::<Particle>() as u64;
/// Bytes of a particle in a list.
const LISTED: u64 = size_of::<u32>() as u64;
const TEXEL: u64 = size_of::<f32>() as u64;
const SEAM: u64 = size_of::<Seam>() as u64;
const ROW: u64 = size_of::<PackedRow>() as u64;
const ENTRIES: u64 = size_of::<PackedEntries>() as u64;
const PAIR: u64 = size_of::<ObjectPair>() as u64;
const NORMAL: u64 = size_of::<glam::Vec4>() as u64;
const CORNERS: u64 = 3 * size_of::<u32>() as u64;
const STRIP: u64 = size_of::<StripTriangle>() as u64;
const VERTEX: u64 = size_of::<Vertex>() as u64;
const SAMPLE: u64 = size_of::<SurfaceSample>() as u64;
/// Bytes of the faces that may be nearest to a tile, for each of its samples.
const CANDIDATES: u64 = (TILE_CANDIDATES / TILE_SAMPLES) as u64 * size_of::<u32>() as u64;
/// The most samples of padding in an object's job of distances.
const PADDING: u64 = GROUP as u64 - 1;

fn holds(device: &DeviceInfo) -> String {
    let (limit, limit_name) = largest_buffer(device);
    format!("one buffer holds {} ({limit_name})", human(limit))
}

/// In bytes, and the limit's name in Vulkan.
fn largest_buffer(device: &DeviceInfo) -> (u64, &'static str) {
    let binding = (device.max_storage_buffer_range, "maxStorageBufferRange");
    let allocation = (device.max_memory_allocation_size, ALLOCATION);
    if allocation.0 < binding.0 {
        allocation
    } else {
        binding
    }
}

/// A number of bytes for people: `128 MiB`, `1.5 GiB`.
#[must_use]
pub fn human(bytes: u64) -> String {
    let count = bytes as f64;
    match bytes {
        _ if count >= 1e15 => "no limit".to_owned(),
        _ if bytes >= 1 << 30 => format!("{:.1} GiB", count / f64::from(1 << 30)),
        _ => format!("{:.0} MiB", (count / f64::from(1 << 20)).ceil()),
    }
}

fn number(value: u64) -> String {
    grouped(value as f64)
}

#[cfg(test)]
mod tests;
