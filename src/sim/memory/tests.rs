//! Scenes that are too large are refused in terms of the scene file, with sizes that fit.

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
        max_storage_images: 8,
        max_sampled_images: 64,
        max_push_descriptors: 32,
        max_push_constants: 128,
        max_image_side: 16_384,
        max_samples: 4,
        subgroup_size: 8,
        has_card_forms: true,
        reads_blocks: false,
        has_addresses: false,
        has_pages: false,
        heaps: Vec::new(),
        has_graphics: true,
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
    for elements in [1 << 16, 400_000, 1 << 23] {
        let device = DeviceInfo {
            max_texel_buffer_elements: elements,
            ..device(1 << 20)
        };
        let message = refusal(&device, &scene("builtin:cube", 1 << 30, 64));
        let most = advised(&message);
        assert!(
            message.contains("particles.count = 1,073,741,824 takes 16.0 GiB a table"),
            "{message}"
        );
        assert_eq!(most, elements);
        assert!(check(&device, &scene("builtin:cube", most, 64)).is_ok());
        assert!(check(&device, &scene("builtin:cube", most + 1, 64)).is_err());

        let message = refusal(&device, &scene("builtin:cube", 64, 32_768));
        let most = advised(&message);
        assert!(message.contains("atlas.size = 32,768"), "{message}");
        assert!(check(&device, &scene("builtin:cube", 64, most)).is_ok());
        assert!(check(&device, &scene("builtin:cube", 64, most + 1)).is_err());
        // Two views of single texels.
        assert!(texel_count(most.into()) <= u64::from(2 * elements));
        assert!(texel_count(u64::from(most) + 1) > u64::from(2 * (elements - 64)));
    }
}

#[test]
fn on_a_card_particles_are_limited_by_the_lists_of_them() {
    let card = DeviceInfo {
        reads_blocks: true,
        has_pages: true,
        max_memory_allocation_size: (1 << 32) - (1 << 21),
        ..device((1 << 32) - 1)
    };
    // The limits of NVIDIA's driver.
    assert_eq!(most_particles(&card), (1 << 30) - (1 << 19));
    assert!(most_particles(&card) > 1_000_000_000);
    assert_eq!(tables(&card, 1 << 27), Tables::InOnePiece);
    assert_eq!(tables(&card, (1 << 27) + 1), Tables::InPages);
    let without = DeviceInfo {
        has_pages: false,
        ..card.clone()
    };
    assert_eq!(most_particles(&without), 1 << 27);
    assert_eq!(tables(&without, 1 << 30), Tables::InOnePiece);
    // Pages of 1,024 elements.
    let small = DeviceInfo {
        max_texel_buffer_elements: 1500,
        ..card
    };
    assert_eq!(most_particles(&small), 1 << 20);
    let message = refusal(&small, &scene("builtin:cube", 1 << 22, 64));
    let part = "particles.count = 4,194,304 takes 64 MiB a table, and there is room for 1,048,576 (1,024 pages): use at most 1,048,576";
    assert!(message.contains(part), "{message}");
}

/// Catches a table that is bound as a storage block although it is larger by one particle, which a test with a device does not come near.
#[test]
fn tables_of_particles_are_large_if_a_storage_block_does_not_hold_them() {
    for limit in [1 << 20, (1 << 20) + 15] {
        let device = device(limit);
        assert_eq!(tables(&device, 1 << 16), Tables::InOnePiece);
        assert_eq!(tables(&device, (1 << 16) + 1), Tables::Large);
    }
}

/// Catches a refusal that names another table than the one that is too large.
#[test]
fn meshes_are_refused_by_the_table_that_is_too_large() {
    let scene = scene("builtin:torus", 10, 64);
    let limits = [
        (
            1 << 16,
            1 << 27,
            "one buffer holds 1 MiB (maxStorageBufferRange)",
        ),
        (
            1 << 30,
            1 << 16,
            "one view shows 1 MiB (maxTexelBufferElements)",
        ),
    ];
    for (range, elements, part) in limits {
        let device = DeviceInfo {
            max_texel_buffer_elements: elements,
            ..device(range)
        };
        let message = refusal(&device, &scene);
        assert!(message.contains(part), "{message}");
        let most = most_triangles(&device);
        assert!(
            message.contains(&format!("use at most {}", number(most))),
            "{message}"
        );
    }
}

/// Several objects may have nearly the texture that one has: samples are blocks of 16 bytes per texel.
#[test]
fn on_a_card_several_objects_have_as_large_a_texture_as_one() {
    let card = DeviceInfo {
        reads_blocks: true,
        has_pages: true,
        max_memory_allocation_size: (1 << 32) - (1 << 21),
        ..device((1 << 32) - 1)
    };
    let mut settings = Settings::default();
    settings.objects = vec![settings.objects[0].clone(); 3];
    assert_eq!(largest_atlas(&card), 16_384);
    assert_eq!(largest_atlas_of(&card, &settings), 16_379);
    // The method `raster` reads through views.
    settings.distance.method = DistanceMethod::Raster;
    assert!(largest_atlas_of(&card, &settings) < 11_600);
    assert_eq!(most_triangles(&card), (1 << 31) / STRIP);
    settings.distance.method = DistanceMethod::Bvh;
    let plain = device((1 << 32) - 1);
    assert_eq!(largest_atlas(&plain), 16_384);
    assert!(largest_atlas_of(&plain, &settings) < 11_600);
}

#[test]
fn buffers_are_no_larger_than_the_device_hands_out() {
    let device = DeviceInfo {
        max_memory_allocation_size: 1 << 20,
        ..device(1 << 20)
    };
    let message = refusal(&device, &scene("builtin:cube", 70_000, 513));
    for part in [
        "particles.count = 70,000 takes 2 MiB a table, and there is room for 65,536 (maxMemoryAllocationSize): use at most 65,536",
        "atlas.size = 513 takes 2 MiB a texture, and a texture holds 262,144 texels (maxMemoryAllocationSize): use at most 512",
    ] {
        assert!(message.contains(part), "{part}\nis not in\n{message}");
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
    // Thousands without names are refused as soon as they are loaded.
    let mut settings = scene.settings;
    settings.objects[0].name.clear();
    settings.objects = vec![settings.objects[0].clone(); 5000];
    let scene = Scene::from_settings("test".to_owned(), settings, "".into()).expect("it loads");
    let message = refusal(&device(128 << 20), &scene);
    assert!(message.contains("the scene has 5000 objects"), "{message}");
    assert_eq!(advised(&message), 1448, "{message}");
}

#[test]
fn everything_that_is_too_large_comes_at_once() {
    let message = refusal(
        &device(1 << 20),
        &scene("builtin:torus?major=220&minor=220", 1 << 28, 32_768),
    );
    for part in [
        "too large for abacus: ",
        "\n  particles.count = 268,435,456 takes 4.0 GiB a table, and there is room for 134,217,728 (maxTexelBufferElements): use at most 134,217,728",
        "\n  atlas.size = 32,768 takes 4.0 GiB a texture, and a texture holds 268,435,456 texels (maxTexelBufferElements): use at most 16,384",
        "\n  the meshes have 96,800 triangles",
    ] {
        assert!(message.contains(part), "{part}\nis not in\n{message}");
    }
}

#[test]
fn seams_that_are_too_large_are_reported_once_the_atlas_exists() {
    let scene = scene("builtin:torus?major=24&minor=16", 100, 512);
    let setup = Setup::new(&scene).expect("it has room");
    let exchange = &setup.atlas.exchange;
    let tables = [
        setup.atlas.seams.len() as u64 * SEAM,
        exchange.rows.len() as u64 * ROW,
        exchange.packed_entries() as u64 * ENTRIES,
    ];
    // All are read as texels of four words.
    let elements = tables.map(|bytes| bytes / 16).into_iter().max();
    let elements = elements.expect("there are three");
    let of = |elements: u64| DeviceInfo {
        max_texel_buffer_elements: elements as u32,
        ..device(1 << 20)
    };
    assert!(check_atlas(&of(elements), &setup.atlas, 512).is_ok());
    let error = check_atlas(&of(elements - 1), &setup.atlas, 512).expect_err("it is too large");
    let message = error.to_string();
    assert!(
        message.contains("too large for abacus: atlas.size = 512 with atlas.method = \"charts\"")
            && message.contains("lower atlas.size"),
        "{message}"
    );
}

/// Would alone catch: a size that fits without the gutter that lies round a plane without borders, and advice that does not count it.
#[test]
fn the_gutter_round_a_periodic_plane_counts() {
    // A texture of 255 x 255 texels, in rows of 256.
    let device = DeviceInfo {
        max_memory_allocation_size: 4 * 256 * 255,
        ..device(1 << 20)
    };
    assert_eq!(largest_atlas(&device), 255);
    let checked = |size: u32| {
        let plane = "builtin:plane?columns=2&rows=2&periodic=true";
        let scene = scene(plane, 100, size);
        check(&device, &scene).expect("the size itself fits");
        let setup = Setup::new(&scene).expect("it has room");
        assert_eq!(setup.atlas.size, size + 2);
        check_atlas(&device, &setup.atlas, size)
    };
    checked(253).expect("it fits with its gutter");
    let message = checked(254).expect_err("it is too large").to_string();
    assert_eq!(advised(&message), 253, "{message}");
    assert!(
        message.contains("atlas.size = 254 makes a texture of 256 texels"),
        "{message}"
    );
}

/// Two cubes.
fn pair(size: u32, method: DistanceMethod) -> Scene {
    let mut settings = Settings::default();
    settings.objects[0].mesh = "builtin:cube".to_owned();
    settings.objects = vec![settings.objects[0].clone(); 2];
    settings.particles.count = 64;
    settings.atlas.size = size;
    settings.distance.method = method;
    Scene::from_settings("test".to_owned(), settings, "".into()).expect("it loads")
}

#[test]
fn every_limit_on_distances_between_objects_is_named() {
    let bvh = DistanceMethod::Bvh;
    let blocks = device(1 << 20);
    let elements = DeviceInfo {
        max_texel_buffer_elements: 40_126,
        ..device(1 << 30)
    };
    let allocations = DeviceInfo {
        max_memory_allocation_size: 16 << 16,
        ..device(1 << 30)
    };
    let images = DeviceInfo {
        max_image_side: 200,
        ..device(1 << 20)
    };
    for (device, method, largest, why) in [
        (
            &blocks,
            bvh,
            360,
            "takes 2 MiB for distances between objects, and one buffer holds 1 MiB (maxStorageBufferRange): use",
        ),
        (
            &blocks,
            DistanceMethod::Brute,
            256,
            "takes 2 MiB for distances between objects, and one buffer holds 1 MiB (maxStorageBufferRange): take distance.method = \"bvh\", or use",
        ),
        (
            &blocks,
            DistanceMethod::Raster,
            256,
            "take distance.method = \"bvh\", or use",
        ),
        (
            &elements,
            bvh,
            200,
            "takes 1 MiB for distances between objects, and one buffer holds 40,000 texels (maxTexelBufferElements): use",
        ),
        (
            &allocations,
            bvh,
            256,
            "takes 2 MiB for distances between objects, and one buffer holds 65,536 texels (maxMemoryAllocationSize): use",
        ),
        (&images, bvh, 360, "for distances between objects"),
        (
            &images,
            DistanceMethod::Raster,
            200,
            "is drawn into, and an image has 200 pixels a side at the most: take distance.method = \"bvh\", or use",
        ),
    ] {
        let too_large = pair(largest + 1, method);
        assert_eq!(
            largest_atlas_of(device, &too_large.settings),
            u64::from(largest),
            "{method:?} {why}"
        );
        let message = refusal(device, &too_large);
        assert!(message.contains(why), "{why}\nis not in\n{message}");
        assert_eq!(advised(&message), largest);
        assert!(check(device, &pair(largest, method)).is_ok());
    }
}

#[test]
fn more_vertices_or_normals_than_a_buffer_holds_are_reported() {
    let mut scene = pair(64, DistanceMethod::Bvh);
    let vertex = scene.surface.positions[0];
    scene.surface.positions.resize(5000, vertex);
    let small = device(4999 * VERTEX);
    let message = refusal(&small, &scene);
    assert!(message.contains("the meshes have 5000 vertices, which take 1 MiB, and one buffer holds 1 MiB (maxStorageBufferRange)"), "{message}");
    assert_eq!(advised(&message), 4999);
    assert!(check(&device(5000 * VERTEX), &scene).is_ok());
    let normals = 3 * scene.surface.corners.len() as u32 + 5000;
    let of = |elements| DeviceInfo {
        max_texel_buffer_elements: elements,
        ..device(1 << 20)
    };
    let message = refusal(&of(normals - 1), &scene);
    assert!(
        message.contains("the normals of the edges and vertices"),
        "{message}"
    );
    assert!(check(&of(normals), &scene).is_ok());
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
    let small = device(2_100_000);
    let mut settings = Settings::default();
    settings.objects = vec![settings.objects[0].clone(); 2];
    assert!(
        atlas_error(&small, &settings, no_room(500))
            .to_string()
            .contains("raise atlas.size to 500")
    );
    let message = atlas_error(&small, &settings, no_room(900)).to_string();
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
            (charts, "2,000 charts"),
            (own_uvs, "coordinates of object 3"),
        ] {
            let message = atlas_error(&small, &settings, error).to_string();
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
