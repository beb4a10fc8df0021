//! What a scene is said to take on the device is what its buffers take.

use std::collections::{BTreeMap, BTreeSet};

use crate::common;
use myxo::scene::Scene;
use myxo::scene::settings::{DistanceMethod, Model};
use myxo::sim::buffers::{Counts, TABLE};
use myxo::sim::raster::RasterLayout;
use myxo::sim::{Setup, Simulation, memory};

/// Catches a buffer that is in no row of the table, one that is larger or smaller than its row says, and a row of none.
#[test]
fn the_table_has_every_buffer() {
    let Some(gpu) = common::gpu() else { return };
    let one = common::scene("builtin:torus?major=31&minor=17", |s| {
        s.atlas.size = 259;
        s.feeding.scattered = 3;
    });
    let one_a_cell = common::scene("builtin:torus?major=31&minor=17", |s| {
        s.atlas.size = 128;
        s.particles.count = 1000;
        s.physarum.model = Model::Jones;
    });
    let growing = common::scene("builtin:torus?major=31&minor=17", |s| {
        s.atlas.size = 128;
        s.particles.count = 1000;
        s.population.frequency = 5;
        s.population.capacity = 3000;
    });
    let several = |method| {
        common::scene_of_several(&common::TRIO, |s| {
            s.atlas.size = 128;
            s.particles.count = 5000;
            s.distance.method = method;
            s.objects[1].trail.decay = Some(0.5);
            s.feeding.scattered = 3;
            s.feeding.scent_across = 0.5;
        })
    };
    let (mut names, mut kept) = (BTreeSet::new(), Vec::new());
    for scene in [
        one,
        several(DistanceMethod::Bvh),
        several(DistanceMethod::Raster),
        one_a_cell,
        growing,
    ] {
        let before = gpu.ctx.allocated();
        let simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let after = gpu.ctx.allocated();
        let counts = Counts::of(simulation.setup(), &scene.settings);
        let mut rows = BTreeMap::new();
        for row in TABLE {
            rows.insert(row.name(), row.bytes(&counts));
        }
        for (name, size) in after {
            let size = size - before.get(&name).copied().unwrap_or_default();
            // What the context keeps to copy through grows with the largest copy.
            let is_staging = ["transfer.upload", "transfer.download"].contains(&&name[..]);
            if size == 0 || is_staging {
                continue;
            }
            let row = rows.remove(&name[..]);
            let row = row.unwrap_or_else(|| panic!("no row has `{name}`"));
            // Memory is handed out by the alignment of a device.
            assert!(
                row <= size && size < row + 4096,
                "{name}: {size}, not {row}"
            );
            names.insert(name);
        }
        let missing: Vec<_> = rows.iter().filter(|(_, bytes)| **bytes > 0).collect();
        assert!(missing.is_empty(), "{missing:?}");
        // None is freed meanwhile.
        kept.push(simulation);
    }
    // The bias and the weights of a second look are there once something is painted.
    assert_eq!(names.len() + 2, TABLE.len(), "{names:?}");
    gpu.finish();
}

/// Before there is an atlas, all but its seams is known.
#[test]
fn what_one_object_takes_is_known_before() {
    let scene = common::scene("builtin:torus?major=31&minor=17", |s| s.atlas.size = 259);
    let setup = Setup::new(&scene).unwrap();
    let whole = memory::size_in_bytes(&setup, &scene.settings);
    let known = memory::needed(&scene);
    assert!(known <= whole && known * 2 > whole, "{known} of {whole}");
}

/// What distances between several objects take is most of it, and known as well.
#[test]
fn several_objects_take_memory() {
    let Some(gpu) = common::gpu() else { return };
    for size in [256, 512] {
        let scene = common::scene_of_several(&common::TRIO, |s| {
            s.atlas.size = size;
            s.particles.count = 5000;
        });
        let simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let whole = memory::size_in_bytes(simulation.setup(), &scene.settings);
        let known = memory::needed(&scene);
        assert!(
            known * 10 > whole * 8 && known * 2 < whole * 3,
            "{known} of {whole}"
        );
    }
    gpu.finish();
}

/// Food takes memory, too.
#[test]
fn food_takes_memory() {
    let Some(gpu) = common::gpu() else { return };
    let sizes = [0, 3].map(|scattered| {
        let scene = common::scene("builtin:torus?major=31&minor=17", |s| {
            s.atlas.size = 131;
            s.feeding.scattered = scattered;
        });
        let simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let food = simulation.state().food.as_ref().map_or(0, |food| {
            food.meals.size_in_bytes()
                + food.marks.size_in_bytes()
                + food.scent.size_in_bytes()
                + food.plates.size_in_bytes()
                + food.scented.size_in_bytes()
                + food.falloffs.size_in_bytes()
                + food.projected.size_in_bytes()
                + food.groups.size_in_bytes()
        });
        let all = memory::size_in_bytes(simulation.setup(), &scene.settings);
        (all, food, memory::needed(&scene))
    });
    let [(without, none, needed_without), (with, food, needed)] = sizes;
    assert_eq!((none, with - without), (0, food));
    // Before there is an atlas, only the size of the lists of reached texels is unknown.
    let fields = 2 * 4 * 132 * 131;
    assert!(
        fields < needed - needed_without && needed - needed_without <= food,
        "{fields}, {needed}, {needed_without}, {food}"
    );
    gpu.finish();
}

/// And what a checkpoint brings of what was painted.
#[test]
fn what_is_painted_takes_memory() {
    let Some(gpu) = common::gpu() else { return };
    let scene = common::scene("builtin:torus?major=31&minor=17", |s| s.atlas.size = 131);
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let mut snapshot = simulation.snapshot().unwrap();
    assert!(simulation.state().bias.is_none());
    snapshot.bias = vec![1.0; snapshot.trail.len()];
    simulation.restore(&snapshot).unwrap();
    let painted = simulation.state().bias.as_ref().unwrap();
    let size = painted.size_in_bytes();
    assert_eq!(memory::needed_for_painted(&scene), size);
    assert_eq!(
        memory::painted_bytes(simulation.setup().atlas.texel_count() as u64),
        size
    );
    gpu.finish();
}

/// What the graphics pipeline draws, and draws into, counts where it takes the distances.
#[test]
fn drawing_distances_takes_memory() {
    let mut settings =
        common::scene("builtin:torus?major=31&minor=17", |s| s.atlas.size = 131).settings;
    settings.objects.push(settings.objects[0].clone());
    settings.objects[1].position = [1.0, 0.0, 0.0];
    let scene = Scene::from_settings("test".to_owned(), settings.clone(), ".".into()).unwrap();
    let setup = Setup::new(&scene).unwrap();
    let without = memory::size_in_bytes(&setup, &settings);
    settings.distance.method = DistanceMethod::Raster;
    let layout = RasterLayout::new(&setup);
    let tables = size_of_val(&layout.outlines[..])
        + size_of_val(&layout.bounds[..])
        + size_of_val(&layout.slots[..])
        + size_of_val(&layout.places[..]);
    let targets = 3 * 4 * setup.atlas.texel_count();
    assert_eq!(
        memory::size_in_bytes(&setup, &settings) - without,
        (tables + targets) as u64
    );
}

/// Room for particles that leave counts.
#[test]
fn lists_of_transfers_take_memory() {
    let mut settings = common::scene("builtin:cube", |s| s.atlas.size = 131).settings;
    settings.objects.push(settings.objects[0].clone());
    settings.objects[1].position = [1.0, 0.0, 0.0];
    settings.particles.count = 5000;
    let scene = Scene::from_settings("test".to_owned(), settings.clone(), ".".into()).unwrap();
    let setup = Setup::new(&scene).unwrap();
    let mut size = |buffer_size: u32| {
        settings.transfer.buffer_size = buffer_size;
        memory::size_in_bytes(&setup, &settings)
    };
    assert_eq!(size(3000) - size(1000), 2000 * (64 + 4));
}
