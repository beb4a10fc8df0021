//! What a scene is said to take on the device is what its buffers take.

use crate::common;
use myxo::mesh::atlas::{PackedEntries, PackedRow};
use myxo::scene::Scene;
use myxo::scene::settings::DistanceMethod;
use myxo::sim::raster::RasterLayout;
use myxo::sim::{Setup, Simulation, memory};

#[test]
fn the_sum_is_that_of_the_buffers() {
    let Some(gpu) = common::gpu() else { return };
    let scene = common::scene("builtin:torus?major=31&minor=17", |s| s.atlas.size = 259);
    let simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let s = simulation.state();
    let setup = simulation.setup();
    let buffers = s.particles.size_in_bytes()
        + s.motions.size_in_bytes()
        + s.sorting.particles.size_in_bytes()
        + s.sorting.motions.size_in_bytes()
        + s.sorting.bins.size_in_bytes()
        + s.trail.front.size_in_bytes()
        + s.trail.back.size_in_bytes()
        + s.deposits.front.size_in_bytes()
        + s.deposits.back.size_in_bytes()
        + s.density.size_in_bytes()
        + s.walkers.size_in_bytes()
        + s.walker_count.size_in_bytes()
        + s.unused.size_in_bytes()
        + s.walker_groups.size_in_bytes()
        + s.no_groups.size_in_bytes()
        + s.no_meals.size_in_bytes()
        + s.poses.size_in_bytes()
        + s.poses_before.size_in_bytes()
        + s.physarums.size_in_bytes();
    let tables = size_of_val(&setup.surface.triangles[..])
        + size_of_val(&setup.surface.halfedges[..])
        + size_of_val(&setup.strips[..])
        + size_of_val(&setup.corners[..])
        + size_of_val(&setup.vertices[..])
        + size_of_val(&setup.atlas.blocks[..])
        + size_of_val(&setup.atlas.seams[..])
        + size_of_val(&setup.clearance[..])
        + size_of_val(&setup.surroundings[..])
        + setup.atlas.exchange.rows.len() * size_of::<PackedRow>()
        + setup.atlas.exchange.packed_entries() * size_of::<PackedEntries>();
    assert_eq!(
        memory::size_in_bytes(setup, &scene.settings),
        buffers + tables as u64
    );
    // Before there is an atlas, all but its seams is known.
    let (whole, known) = (buffers + tables as u64, memory::needed(&scene));
    assert!(known <= whole && known * 2 > whole, "{known} of {whole}");
    gpu.finish();
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

/// So does food, where there is any.
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
                + food.whiffs.size_in_bytes()
                + food.groups.size_in_bytes()
        });
        let all = memory::size_in_bytes(simulation.setup(), &scene.settings);
        (all, food, memory::needed(&scene))
    });
    let [(without, none, needed_without), (with, food, needed)] = sizes;
    assert_eq!((none, with - without), (0, food));
    // Before there is an atlas, all but the lists of whom they reach is known.
    let fields = 2 * 4 * 132 * 131;
    assert_eq!(needed - needed_without, fields);
    assert!(fields <= food, "{fields} of {food}");
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
    let size = painted.field.size_in_bytes();
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

/// Room for those who are under way counts.
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
    assert_eq!(size(3000) - size(1000), 2000 * 2 * (64 + 4));
}
