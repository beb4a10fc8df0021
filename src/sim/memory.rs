//! How much device memory a scene takes, and whether its buffers are such as the device can have, told in the words of
//! the scene file: from the settings and the meshes, before anything takes time; the seams, once there is an atlas.

use super::distance::{DistanceSetup, TILE_CANDIDATES};
use super::raster::{self, Raster};
use super::setup::Setup;
use super::sorting;
use super::transfers::capacity;
use super::types::{
    AtlasMap, DistanceJob, ExchangeEntry, ExchangeRow, HalfEdge, ListedTile, Motion, ObjectPair,
    Particle, Physarum, Pose, Seam, Transfer, Triangle, Vertex,
};
use crate::error::{Error, Result};
use crate::gpu::{DeviceInfo, DispatchGroups};
use crate::mesh::atlas::{Atlas, AtlasError, AtlasMethod, MAX_SIZE};
use crate::mesh::strip::StripTriangle;
use crate::scene::Scene;
use crate::scene::parameters::grouped;
use crate::scene::settings::Settings;

/// Bytes that the buffers of a simulation take on the device. Pictures come on top: some bytes a pixel, and about 4 a
/// texel and 16 a triangle.
#[must_use]
pub fn size_in_bytes(setup: &Setup, settings: &Settings) -> u64 {
    let count = |len: usize| len as u64;
    particle_bytes(count(setup.particles.len()))
        + texel_bytes(count(setup.atlas.texel_count()))
        + count(setup.atlas.blocks.len()) * size_of::<u32>() as u64
        + count(setup.atlas.seams.len()) * SEAM
        + count(setup.atlas.exchange.rows.len()) * ROW
        + count(setup.atlas.exchange.entries.len()) * ENTRY
        + triangle_bytes(count(setup.surface.corners.len()))
        + count(setup.vertices.len()) * size_of::<Vertex>() as u64
        + count(setup.poses.len()) * (2 * size_of::<Pose>() + size_of::<Physarum>()) as u64
        + WALKER_LIST
        + (sorting::bins(&setup.atlas, setup.poses.len()) * size_of::<u32>()) as u64
        + distance_bytes(setup)
        + transfer_bytes(setup, settings)
        + if settings.uses_raster() {
            Raster::size_in_bytes(setup)
        } else {
            0
        }
}

/// What the lists of particles under way take; next to nothing for a single object.
fn transfer_bytes(setup: &Setup, settings: &Settings) -> u64 {
    if setup.poses.len() < 2 {
        return 0;
    }
    // Two lists of transfers, and two of indices.
    let entry = 2 * (size_of::<Transfer>() + size_of::<u32>()) as u64;
    u64::from(capacity(settings, setup, 0)) * entry
}

/// What distances between objects take.
fn distance_bytes(setup: &Setup) -> u64 {
    let DistanceSetup {
        samples,
        owners,
        tiles,
        trees,
        ..
    } = &setup.distance;
    if setup.distance.is_empty() {
        return 0;
    }
    // Distances, nearest triangles, and places and triangles across.
    let fields = 4 * TEXEL * setup.atlas.texel_count() as u64;
    let objects = setup.poses.len() as u64;
    fields
        + size_of_val(&samples[..]) as u64
        + size_of_val(&owners[..]) as u64
        + size_of_val(&tiles[..]) as u64
        + (setup.distance.hints_len() * size_of::<u32>()) as u64
        + setup.distance.tiles_len() as u64
            * (TILE_CANDIDATES as usize * size_of::<u32>() + size_of::<ListedTile>()) as u64
        + ((tiles.len() + setup.distance.margins_len()) * size_of::<u32>()) as u64
        + size_of_val(&trees.faces[..]) as u64
        + size_of_val(&trees.nodes[..]) as u64
        + size_of_val(&trees.dipoles[..]) as u64
        + size_of_val(&trees.pseudonormals[..]) as u64
        + objects * (size_of::<DistanceJob>() + size_of::<u32>()) as u64
        + objects * (objects - 1) * (PAIR + size_of::<f32>() as u64)
}

/// How many particles one buffer of the device holds.
#[must_use]
pub fn most_particles(device: &DeviceInfo) -> u64 {
    largest_buffer(device).0 / PARTICLE
}

/// Texels along the side of the largest atlas that one buffer of the device holds.
#[must_use]
pub fn largest_atlas(device: &DeviceInfo) -> u64 {
    let texels = largest_buffer(device).0 / TEXEL;
    // Diffusion reads them one by one through texel buffers.
    let texels = texels.min(device.max_texel_buffer_elements.into());
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
    // What lies behind edges is the largest table, read as texels of 16 bytes.
    let texels = u64::from(device.max_texel_buffer_elements);
    (bytes / STRIP).min(texels * 16 / STRIP)
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

    let particles = u64::from(scene.settings.particles.count);
    let most = most_particles(device);
    if particles > most {
        problems.push(format!(
            "particles.count = {} takes {}, and {holds}: use at most {}",
            number(particles),
            human(particles * PARTICLE),
            number(most)
        ));
    }
    let size = u64::from(scene.settings.atlas.size);
    let largest = largest_atlas(device);
    if size > largest {
        problems.push(format!(
            "atlas.size = {} takes {} a texture, and {holds}: use at most {}",
            number(size),
            human(texel_count(size) * TEXEL),
            number(largest)
        ));
    }
    let triangles = scene.surface.corners.len() as u64;
    let most = most_triangles(device);
    if triangles > most {
        problems.push(format!(
            "the meshes have {} triangles, which take {}, and {holds}: use at most {}",
            number(triangles),
            human(triangles * STRIP),
            number(most)
        ));
    }
    let objects = scene.surface.objects.len() as u64;
    if objects > 1 {
        let normals = (3 * triangles + scene.surface.positions.len() as u64) * NORMAL;
        let limit = largest_buffer(device).0;
        if normals > limit && triangles <= most {
            problems.push(format!(
                "the normals of the edges and vertices of {} triangles take {}, and {holds}: use at most {} for distances between objects",
                number(triangles),
                human(normals),
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
    match problems.as_slice() {
        [] => Ok(()),
        [only] => Err(too_large(device, only)),
        many => Err(too_large(device, &format!("\n  {}", many.join("\n  ")))),
    }
}

/// Makes sure that the tables of an atlas's seams are no larger than the device allows. How large they are shows only
/// when the atlas is there.
///
/// # Errors
/// Names the table that is too large, the device's limit, and what makes it smaller.
pub fn check_atlas(device: &DeviceInfo, atlas: &Atlas) -> Result<()> {
    let tables = [
        (atlas.seams.len() as u64, SEAM, "gutter texels"),
        (atlas.exchange.rows.len() as u64, ROW, "texels beside seams"),
        (
            atlas.exchange.entries.len() as u64,
            ENTRY,
            "exchanges over seams",
        ),
    ];
    let limit = largest_buffer(device).0;
    let Some((count, size, what)) = tables
        .into_iter()
        .find(|(count, size, _)| count * size > limit)
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
            "atlas.size = {} with atlas.method = \"{}\" makes {} {what}, which take {}, and {}: lower atlas.size{fewer_seams}",
            number(u64::from(atlas.size)),
            atlas.method,
            number(count),
            human(count * size),
            holds(device),
        ),
    ))
}

/// As the atlas says it, but never with a size that this device does not hold.
#[must_use]
pub fn atlas_error(device: &DeviceInfo, error: AtlasError) -> Error {
    let (what, needed, about, advice) = match &error {
        AtlasError::NoRoom {
            triangles, needed, ..
        } => (
            counted(*triangles as u64, "triangle"),
            *needed,
            "",
            "use meshes with fewer triangles",
        ),
        AtlasError::NoRoomForCharts { charts, needed, .. } => (
            counted(*charts as u64, "chart"),
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
            "mend them, or choose atlas.method charts or grid",
        ),
        _ => return Error::Atlas(error),
    };
    let largest = largest_atlas(device);
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

/// The length of that list, and the groups of its dispatch and of none.
const WALKER_LIST: u64 = WALKER + 2 * size_of::<DispatchGroups>() as u64;
/// A place in the list of those whose sensors must walk.
const WALKER: u64 = size_of::<u32>() as u64;
const PARTICLE: u64 = size_of::<Particle>() as u64;
const TEXEL: u64 = size_of::<f32>() as u64;
const SEAM: u64 = size_of::<Seam>() as u64;
const ROW: u64 = size_of::<ExchangeRow>() as u64;
const ENTRY: u64 = size_of::<ExchangeEntry>() as u64;
const PAIR: u64 = size_of::<ObjectPair>() as u64;
const NORMAL: u64 = size_of::<glam::Vec4>() as u64;
const STRIP: u64 = size_of::<StripTriangle>() as u64;
const HALFEDGE: u64 = size_of::<HalfEdge>() as u64;

/// Particles and motions twice, because they are sorted into other buffers.
fn particle_bytes(count: u64) -> u64 {
    count * (2 * (PARTICLE + size_of::<Motion>() as u64) + WALKER)
}

/// Trail and deposits twice, the density, and a byte of clearance.
fn texel_bytes(count: u64) -> u64 {
    count * (5 * TEXEL + 1)
}

fn triangle_bytes(count: u64) -> u64 {
    let corners = 3 * size_of::<u32>();
    let each = size_of::<Triangle>() + size_of::<AtlasMap>() + size_of::<StripTriangle>() + corners;
    count * (each as u64 + 3 * HALFEDGE)
}

fn texel_count(size: u64) -> u64 {
    size.next_multiple_of(4) * size
}

fn holds(device: &DeviceInfo) -> String {
    let (limit, limit_name) = largest_buffer(device);
    format!("one buffer holds {} ({limit_name})", human(limit))
}

/// In bytes, and the limit's name in Vulkan.
fn largest_buffer(device: &DeviceInfo) -> (u64, &'static str) {
    let binding = (device.max_storage_buffer_range, "maxStorageBufferRange");
    let allocation = (device.max_memory_allocation_size, "maxMemoryAllocationSize");
    if allocation.0 < binding.0 {
        allocation
    } else {
        binding
    }
}

/// A number of bytes as people say it: `128 MiB`, `1.5 GiB`.
#[must_use]
pub fn human(bytes: u64) -> String {
    let count = bytes as f64;
    match bytes {
        _ if count >= 1e15 => "no limit".to_owned(),
        _ if bytes >= 1 << 30 => format!("{:.1} GiB", count / f64::from(1 << 30)),
        _ => format!("{:.0} MiB", (count / f64::from(1 << 20)).ceil()),
    }
}

fn counted(count: u64, what: &str) -> String {
    format!(
        "{} {what}{}",
        number(count),
        if count == 1 { "" } else { "s" }
    )
}

fn number(value: u64) -> String {
    grouped(value as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::DeviceKind;

    /// A device whose buffers hold `limit` bytes.
    fn device(limit: u64) -> DeviceInfo {
        DeviceInfo {
            index: 0,
            name: "abacus".to_owned(),
            kind: DeviceKind::Other,
            driver: String::new(),
            driver_version: String::new(),
            api_version: String::new(),
            cache_key: String::new(),
            timestamp_period: 1.0,
            timestamp_valid_bits: 64,
            max_storage_buffer_range: limit,
            max_texel_buffer_elements: 1 << 27,
            max_memory_allocation_size: 1 << 40,
            max_group_count: 65_535,
            max_group_invocations: 1024,
            max_storage_buffers: 16,
            max_push_constants: 128,
            max_image_side: 16_384,
            max_samples: 4,
            subgroup_size: 8,
            heaps: Vec::new(),
            has_dynamic_rendering: true,
            has_calibrated_timestamps: true,
            missing: Vec::new(),
            extensions: Vec::new(),
            queue_family: 0,
            physical: Default::default(),
        }
    }

    fn scene(mesh: &str, particles: u32, size: u32) -> Scene {
        let mut settings = Settings::default();
        settings.objects[0].mesh = mesh.to_owned();
        settings.particles.count = particles;
        settings.atlas.size = size;
        Scene::from_settings("test".to_owned(), settings, ".".into()).expect("it loads")
    }

    fn refusal(device: &DeviceInfo, scene: &Scene) -> String {
        check(device, scene)
            .expect_err("it is too large")
            .to_string()
    }

    /// The number behind the last "use at most".
    fn advised(message: &str) -> u32 {
        let (_, number) = message
            .rsplit_once("use at most ")
            .expect("there is advice");
        number.replace(',', "").parse().expect("it is a number")
    }

    #[test]
    fn what_is_advised_is_the_largest_that_fits() {
        for limit in [1 << 20, 5_000_000, 128 << 20] {
            let device = device(limit);
            let message = refusal(&device, &scene("builtin:cube", 1 << 30, 64));
            let most = advised(&message);
            assert!(
                message.contains("particles.count = 1,073,741,824"),
                "{message}"
            );
            assert!(check(&device, &scene("builtin:cube", most, 64)).is_ok());
            assert!(check(&device, &scene("builtin:cube", most + 1, 64)).is_err());
            assert!(u64::from(most) * 16 <= limit && u64::from(most + 1) * 16 > limit);

            let message = refusal(&device, &scene("builtin:cube", 64, 32_768));
            let most = advised(&message);
            assert!(message.contains("atlas.size = 32,768"), "{message}");
            assert!(check(&device, &scene("builtin:cube", 64, most)).is_ok());
            assert!(check(&device, &scene("builtin:cube", 64, most + 1)).is_err());
        }
    }

    #[test]
    fn the_most_objects_that_are_advised_fit() {
        for limit in [1 << 20, 5_000_000, 128 << 20] {
            let most = most_objects(&device(limit));
            assert!(most * (most - 1) * PAIR <= limit && (most + 1) * most * PAIR > limit);
        }
        let mut settings = Settings::default();
        settings.objects[0].mesh = "builtin:cube".to_owned();
        settings.objects = vec![settings.objects[0].clone(); 130];
        settings.particles.count = 64;
        settings.atlas.size = 64;
        let scene = Scene::from_settings("test".to_owned(), settings, "".into()).expect("it loads");
        let message = refusal(&device(1 << 20), &scene);
        assert_eq!(advised(&message), 128, "{message}");
        assert!(check(&device(2 << 20), &scene).is_ok());
    }

    #[test]
    fn everything_that_is_too_large_comes_at_once() {
        let message = refusal(
            &device(1 << 20),
            &scene("builtin:torus?major=200&minor=200", 70_000, 1024),
        );
        for part in [
            "too large for abacus: ",
            "\n  particles.count = 70,000 takes 2 MiB, and one buffer holds 1 MiB (maxStorageBufferRange): use at most 65,536",
            "\n  atlas.size = 1024 takes 4 MiB a texture",
            "\n  the meshes have 80,000 triangles",
        ] {
            assert!(message.contains(part), "{part}\nis not in\n{message}");
        }
    }

    #[test]
    fn seams_that_are_too_large_are_told_once_the_atlas_is_there() {
        let scene = scene("builtin:torus?major=24&minor=16", 100, 512);
        let setup = Setup::new(&scene).expect("it has room");
        let exchange = &setup.atlas.exchange;
        let tables = [
            setup.atlas.seams.len() as u64 * SEAM,
            exchange.rows.len() as u64 * ROW,
            exchange.entries.len() as u64 * ENTRY,
        ];
        let largest = tables.into_iter().max().expect("there are some");
        assert!(check_atlas(&device(largest), &setup.atlas).is_ok());
        let error = check_atlas(&device(largest - 1), &setup.atlas).expect_err("it is too large");
        let message = error.to_string();
        assert!(
            message
                .contains("too large for abacus: atlas.size = 512 with atlas.method = \"charts\"")
                && message.contains("lower atlas.size"),
            "{message}"
        );
    }

    #[test]
    fn no_size_is_advised_that_the_device_does_not_hold() {
        let no_room = |needed| AtlasError::NoRoom {
            triangles: 100_000,
            cells: 50_000,
            cell_size: 4,
            gutter: 1,
            size: 64,
            needed,
        };
        let small = device(1 << 20);
        assert!(
            atlas_error(&small, no_room(500))
                .to_string()
                .contains("raise atlas.size to 500")
        );
        let message = atlas_error(&small, no_room(900)).to_string();
        assert!(
            message.ends_with("100,000 triangles must have atlas.size = 900, and the largest that it holds is 512: use meshes with fewer triangles"),
            "{message}"
        );
        for needed in [400, 900, 32_769] {
            let charts = AtlasError::NoRoomForCharts {
                charts: 2000,
                gutter: 1,
                size: 64,
                needed,
            };
            let own_uvs = AtlasError::OwnUvsTooDense {
                object: 3,
                gutter: 1,
                size: 64,
                problem: "two islands are too near to each other".to_owned(),
                needed: needed as u32,
                tried: false,
            };
            for (error, what) in [
                (charts, "2000 charts"),
                (own_uvs, "coordinates of object 3"),
            ] {
                let message = atlas_error(&small, error).to_string();
                let is_too_large = message.contains("the largest that it holds is 512: ");
                assert_eq!(is_too_large, needed > 512, "{message}");
                assert!(message.contains(what), "{message}");
                assert_eq!(message.contains("raise"), needed <= 512, "{message}");
            }
        }
    }

    #[test]
    fn bytes_are_said_as_people_say_them() {
        assert_eq!(human(128 << 20), "128 MiB");
        assert_eq!(human((128 << 20) + 1), "129 MiB");
        assert_eq!(human(3 << 29), "1.5 GiB");
        assert_eq!(human(u64::MAX), "no limit");
    }
}
