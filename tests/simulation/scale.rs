//! What outgrows a storage block or a texel buffer takes other ways, and ends in the same bits. Limits are lowered for
//! that, so that small scenes are large ones.

use crate::common::{
    Gpu, TRIO, gpu_by_card_forms, gpu_by_card_forms_within, gpu_within, scene, scene_of_several,
};
use glam::Vec2;
use image::RgbaImage;
use myxo::gpu::{Frames, Limits, Tables};
use myxo::mesh::atlas::Atlas;
use myxo::render::{Offscreen, Prepared, Quality, Renderer, View, offscreen};
use myxo::scene::Scene;
use myxo::scene::settings::{
    AtlasMethod, DistanceMethod, Model, Sensing, Settings, Show, Strategy,
};
use myxo::sim::diffusion::Diffusion;
use myxo::sim::paint::{Brush, Dab, Painted};
use myxo::sim::texel_paths::TexelPaths;
use myxo::sim::{Setup, Simulation, Snapshot, atlas_options, memory};

/// The hash after some steps on a device with such limits, and pictures of the state. The invariants hold.
fn run(limits: Option<Limits>, scene: &Scene, steps: u32) -> Option<(u64, Vec<RgbaImage>)> {
    Some(run_on(gpu_within(limits)?, scene, steps))
}

/// As [`run`], on a given device.
fn run_on(gpu: Gpu, scene: &Scene, steps: u32) -> (u64, Vec<RgbaImage>) {
    run_and_draw(gpu, scene, steps, true)
}

/// As [`run_on`], with no pictures if none are wanted.
fn run_and_draw(gpu: Gpu, scene: &Scene, steps: u32, draws: bool) -> (u64, Vec<RgbaImage>) {
    let mut simulation = Simulation::new(&gpu.ctx, scene).unwrap();
    let mut frames = Frames::new(&gpu.ctx, 2).unwrap();
    for _ in 0..steps {
        let mut rec = frames.begin().unwrap();
        simulation.record_step(&mut rec);
        frames.submit(rec).unwrap();
    }
    frames.wait_idle().unwrap();
    let snapshot = simulation.snapshot().unwrap();
    snapshot.validate(simulation.setup()).expect("all is well");
    let pictures = match draws {
        true => pictures(&gpu, scene, &simulation),
        false => Vec::new(),
    };
    // What was saved continues as if nothing had happened.
    simulation.restore(&snapshot).unwrap();
    assert_eq!(simulation.snapshot().unwrap().hash(), snapshot.hash());
    drop((simulation, frames));
    gpu.finish();
    (snapshot.hash(), pictures)
}

/// Pictures of all kinds.
fn pictures(gpu: &Gpu, scene: &Scene, simulation: &Simulation) -> Vec<RgbaImage> {
    let prepared = Prepared::for_quick(simulation.setup());
    let mut renderer =
        Renderer::from_prepared(&gpu.ctx, simulation.setup(), &prepared, offscreen::FORMAT)
            .unwrap();
    let pictures = [
        (Show::Surface, Quality::Smooth),
        (Show::Particles, Quality::Smooth),
        (Show::Atlas, Quality::Smooth),
        (Show::Surface, Quality::Quick),
    ];
    let pictures = pictures.map(|(show, quality)| {
        let mut view = View::of(scene, Vec2::new(96.0, 64.0));
        view.show = show;
        let canvas = Offscreen::with_quality(&gpu.ctx, [96, 64], quality).unwrap();
        gpu.run(|rec| {
            renderer.draw(rec, simulation.state(), &view, canvas.canvas());
            canvas.record_readback(rec);
        });
        canvas.image()
    });
    pictures.to_vec()
}

/// In their form for graphics cards kernels list things in another order, and nothing else is another. Runs every kernel of a step:
/// the forms of `advance`, transfers and what limits them, all ways to distances, food, painted areas, sorts.
#[test]
fn forms_for_graphics_cards_end_in_the_same_bits() {
    let touching = |change: &dyn Fn(&mut Settings)| {
        scene_of_several(&TRIO, |settings| {
            settings.particles.count = 6000;
            settings.atlas.size = 128;
            settings.transfer.buffer_size = 16;
            change(settings);
        })
    };
    let strategies = [
        (Strategy::Parallel, DistanceMethod::Bvh),
        (Strategy::Sequential, DistanceMethod::Brute),
        (Strategy::Direct, DistanceMethod::Raster),
        (Strategy::Respawn, DistanceMethod::Bvh),
    ];
    let mut scenes: Vec<Scene> = strategies
        .iter()
        .map(|&(strategy, method)| {
            touching(&|settings| {
                settings.transfer.strategy = strategy;
                settings.distance.method = method;
            })
        })
        .collect();
    scenes.push(touching(&|settings| {
        settings.feeding.scattered = 5;
        settings.physarum.sensor_noise = 0.1;
        settings.physarum.decrowding_weight = 0.1;
        settings.physarum.gravity_weight = 0.1;
        settings.physarum.distance_weight = 0.1;
        settings.trail.diffusion = 0.9;
    }));
    for (number, scene) in scenes.iter().enumerate() {
        let (Some(gpu), Some(cards)) = (gpu_within(None), gpu_by_card_forms()) else {
            return;
        };
        let expected = snapshot_after(&gpu, scene, 20);
        let found = snapshot_after(&cards, scene, 20);
        assert_eq!(found.hash(), expected.hash(), "scene {number}");
        // Otherwise some lists would have been empty.
        let flow = found.transfers.flow;
        assert!(flow.refused > 0 && flow.selected > flow.refused, "{flow:?}");
        gpu.finish();
        cards.finish();
    }
}

fn snapshot_after(gpu: &Gpu, scene: &Scene, steps: u32) -> Snapshot {
    let mut simulation = Simulation::new(&gpu.ctx, scene).unwrap();
    for _ in 0..steps {
        gpu.run(|rec| simulation.record_step(rec));
    }
    let walkers = gpu.ctx.download(&simulation.state().walkers.count).unwrap();
    assert!(walkers[0] > 0 || scene.settings.physarum.gravity_weight != 0.0);
    simulation.snapshot().unwrap()
}

/// A cube whose particles and texels are more than 64 KiB, and whose seams are short.
fn cube(size: u32, change: impl FnOnce(&mut Settings)) -> Scene {
    scene("builtin:cube?divisions=4", |settings| {
        settings.particles.count = 9001;
        settings.atlas.size = size;
        change(settings);
    })
}

const BLOCK: u64 = 64 << 10;

/// Which of the pictures shows particles.
const PARTICLES: usize = 1;

/// Of all bytes.
fn mean_difference(a: &RgbaImage, b: &RgbaImage) -> f64 {
    let both = a.as_raw().iter().zip(b.as_raw());
    let sum: f64 = both.map(|(a, b)| f64::from(a.abs_diff(*b))).sum();
    sum / a.as_raw().len() as f64
}

/// Asserts that pictures show the same.
#[track_caller]
fn assert_alike(what: &str, found: &[RgbaImage], expected: &[RgbaImage]) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (k, (a, b)) in found.iter().zip(expected).enumerate() {
        // Light adds up in the order in which particles lie in memory, and is rounded each time.
        let bound = if k == PARTICLES { 0.5 } else { 0.0 };
        let off = mean_difference(a, b);
        assert!(off <= bound, "{what}: picture {k} is {off} off");
    }
}

/// Textures of several objects never outgrow a view or a block in the plain form, because lists of distances, which must not, are longer.
#[test]
fn large_textures_end_in_the_same_bits_as_small_ones() {
    let changes: [fn(&mut Settings); 5] = [
        |_| {},
        |s| {
            s.physarum.sensing = Sensing::Walk;
            s.physarum.decrowding_weight = 0.1;
            s.physarum.sensor_noise = 0.2;
        },
        // In two halves of a step.
        |s| s.trail.diffusion = 0.9,
        |s| {
            s.trail.diffusion_distance = 2;
            s.physarum.favourite_density = 1.0;
        },
        // One particle a cell, which particles claim.
        |s| s.physarum.model = Model::Jones,
    ];
    for (size, change) in [201, 203, 204, 428, 204].into_iter().zip(changes) {
        let scene = cube(size, change);
        // Past the sort at the end of the 16th and 32nd step.
        let Some(expected) = run(None, &scene, 34) else {
            return;
        };
        let texels = u64::from(size.next_multiple_of(4) * size);
        // As few elements as two views can do with, and so many that one view does.
        for elements in [(texels / 2).next_multiple_of(64), texels] {
            let limits = Limits {
                storage_buffer_range: BLOCK,
                texel_buffer_elements: elements as u32,
            };
            let found = run(Some(limits), &scene, 34).unwrap();
            let what = format!("{size}, {limits:?}");
            assert_eq!(found.0, expected.0, "{what}");
            assert_alike(&what, &found.1, &expected.1);
        }
    }
}

/// Would catch: copies of painted areas that are to fit a storage block, so that no stroke on a large texture can be undone.
#[test]
fn strokes_on_a_large_texture_are_undone() {
    let limits = Limits {
        storage_buffer_range: BLOCK,
        texel_buffer_elements: 1 << 20,
    };
    let Some(gpu) = gpu_within(Some(limits)) else {
        return;
    };
    let mut simulation = Simulation::new(&gpu.ctx, &cube(203, |_| {})).unwrap();
    let center = simulation.setup().vertices[0].position;
    let dab = |amount| Dab {
        brush: Brush::Attract { amount },
        center,
        radius: 0.3,
        eye: None,
        ring: None,
        number: 1,
    };
    gpu.run(|rec| drop(simulation.paint(rec, &dab(3.0)).unwrap()));
    let first = simulation.areas().unwrap();
    assert!(4 * first.len() as u64 > BLOCK);
    let (mut before, mut painted) = (None, Painted::default());
    gpu.run(|rec| {
        before = Some(simulation.record_areas(rec).unwrap());
        painted = simulation.paint(rec, &dab(2.0)).unwrap();
    });
    assert!(simulation.areas().unwrap() != first);
    let changed = simulation.repainted(&before.unwrap(), painted.span);
    let changed = changed.unwrap();
    gpu.run(|rec| simulation.put_areas(rec, &changed, false).unwrap());
    assert!(simulation.areas().unwrap() == first);
    drop(simulation);
    gpu.finish();
}

#[test]
fn the_ways_are_those_that_limits_ask_for() {
    let Some(gpu) = gpu_within(Some(Limits {
        storage_buffer_range: BLOCK,
        texel_buffer_elements: 20_800,
    })) else {
        return;
    };
    let of = |texels| TexelPaths::of(gpu.ctx.info(), texels);
    assert_eq!(of(BLOCK / 4), TexelPaths::default());
    let beyond_block = TexelPaths {
        outgrows_block: true,
        ..TexelPaths::default()
    };
    assert_eq!(of(BLOCK / 4 + 1), beyond_block);
    assert_eq!(of(20_800), beyond_block);
    let in_quads = TexelPaths {
        in_quads: true,
        band: 20_800,
        outgrows_block: true,
    };
    assert_eq!(of(20_801), in_quads);
    assert_eq!(TexelPaths::most_texels(gpu.ctx.info()), 41_600);
    // The largest atlas works, and one that is larger is refused with it.
    let largest = memory::largest_atlas(gpu.ctx.info()) as u32;
    assert_eq!(largest, 203);
    let refused = memory::check(gpu.ctx.info(), &cube(largest + 1, |_| {})).unwrap_err();
    let message = refused.to_string();
    assert!(
        message
            .contains("atlas.size = 204 takes 1 MiB a texture, and a texture holds 41,600 texels"),
        "{message}"
    );
    assert!(message.ends_with("use at most 203"), "{message}");
    gpu.finish();
}

/// Particles that a storage block does not hold. Kernels that only write some of their tables run in their form for large tables then, in
/// which these are texel buffers, and with the device's own limits in their plain form, in which they are blocks. Every such kernel runs.
/// Would catch one that has another index or value in one of the two forms, or is made in one of them and bound as in the other.
#[test]
fn many_particles_change_objects_as_few_do() {
    for (strategy, model, particles, size) in [
        (Strategy::None, Model::Thesis, 20_000, 96),
        (Strategy::Respawn, Model::Thesis, 20_000, 96),
        (Strategy::Scattered, Model::Thesis, 20_000, 96),
        (Strategy::Sequential, Model::Thesis, 20_000, 96),
        (Strategy::Parallel, Model::Thesis, 20_000, 96),
        (Strategy::Direct, Model::Thesis, 20_000, 96),
        // One particle a cell needs as many cells.
        (Strategy::Parallel, Model::Jones, 17_000, 180),
    ] {
        let scene = scene_of_several(&TRIO, |settings| {
            settings.particles.count = particles;
            settings.atlas.size = size;
            settings.physarum.model = model;
            settings.transfer.strategy = strategy;
            settings.transfer.buffer_size = 4000;
        });
        let Some(gpu) = gpu_within(None) else {
            return;
        };
        let draws = strategy == Strategy::Parallel && model == Model::Thesis;
        let expected = run_and_draw(gpu, &scene, 34, draws);
        let limits = Limits {
            storage_buffer_range: 256 << 10,
            texel_buffer_elements: 1 << 20,
        };
        let gpu = gpu_within(Some(limits)).unwrap();
        let tables = memory::tables(gpu.ctx.info(), particles.into());
        assert_eq!(tables, Tables::Large);
        let found = run_and_draw(gpu, &scene, 34, draws);
        let what = format!("{strategy:?}, {model:?}");
        assert_eq!(found.0, expected.0, "{what}");
        assert_alike(&what, &found.1, &expected.1);
    }
}

/// The hash after a brush has taken particles to a place, copied beside what runs.
fn teleported(gpu: &Gpu, scene: &Scene) -> u64 {
    let mut simulation = Simulation::new(&gpu.ctx, scene).unwrap();
    let dab = Dab {
        brush: Brush::Particles { share: 0.5 },
        center: simulation.setup().vertices[0].position,
        radius: 0.3,
        eye: None,
        ring: None,
        number: 1,
    };
    let mut copy = None;
    gpu.run(|rec| {
        simulation.record_step(rec);
        let painted = simulation.paint(rec, &dab).unwrap();
        assert!(painted.count() > 0);
        copy = Some(simulation.record_snapshot(rec).unwrap());
    });
    let mut copy = copy.unwrap();
    assert!(copy.is_there());
    copy.take().0.hash()
}

/// Particles that outgrow a binding, and textures of several objects that outgrow a view, as a card has them. Every kernel that reads
/// or writes particles does so over the borders of pages; pictures, too.
#[test]
fn particles_in_pages_end_in_the_same_bits() {
    for (strategy, model, particles, size) in [
        (Strategy::None, Model::Thesis, 20_000, 96),
        (Strategy::Respawn, Model::Thesis, 20_000, 96),
        (Strategy::Sequential, Model::Thesis, 20_000, 96),
        (Strategy::Parallel, Model::Thesis, 20_000, 96),
        (Strategy::Direct, Model::Thesis, 20_000, 96),
        // One particle a cell needs as many cells.
        (Strategy::Parallel, Model::Jones, 9_500, 132),
    ] {
        let scene = scene_of_several(&TRIO, |settings| {
            settings.particles.count = particles;
            settings.atlas.size = size;
            settings.physarum.model = model;
            settings.transfer.strategy = strategy;
            settings.transfer.buffer_size = 50;
        });
        let Some(expected) = run(None, &scene, 34) else {
            return;
        };
        let limits = Limits {
            storage_buffer_range: 512 << 10,
            texel_buffer_elements: 9000,
        };
        let Some(gpu) = gpu_by_card_forms_within(Some(limits)) else {
            return;
        };
        assert!(gpu.ctx.info().has_pages, "this device can have pages");
        let most = memory::most_particles(gpu.ctx.info());
        assert_eq!(most, (512 << 10) / 4);
        assert_eq!(memory::tables(gpu.ctx.info(), 8192), Tables::InOnePiece);
        let tables = memory::tables(gpu.ctx.info(), particles.into());
        assert_eq!(tables, Tables::InPages);
        let found = run_on(gpu, &scene, 34);
        assert_eq!(found.0, expected.0, "{strategy:?}");
        let others = [
            gpu_within(None).unwrap(),
            gpu_by_card_forms_within(Some(limits)).unwrap(),
        ];
        let [whole, paged] = others.map(|gpu| teleported(&gpu, &scene));
        assert_eq!(paged, whole, "{strategy:?}");
        assert_alike(strategy.word(), &found.1, &expected.1);
    }
}

/// Two sheets that own nearly all texels of their texture.
fn sheets(size: u32, method: DistanceMethod) -> Scene {
    let sheet = "plane?columns=2&rows=2";
    let places = [(sheet, [0.0; 3]), (sheet, [0.0, 0.0, 0.1])];
    scene_of_several(&places, |settings| {
        settings.particles.count = 500;
        settings.atlas.method = AtlasMethod::Grid;
        settings.atlas.size = size;
        settings.distance.method = method;
    })
}

#[test]
fn distances_between_objects_say_what_texture_fits() {
    let limits = Limits {
        storage_buffer_range: 256 << 10,
        texel_buffer_elements: 1 << 20,
    };
    for (method, largest) in [
        (DistanceMethod::Bvh, 180),
        (DistanceMethod::Brute, 128),
        (DistanceMethod::Raster, 128),
    ] {
        let fits = sheets(largest, method);
        let Some((hash, _)) = run(Some(limits), &fits, 2) else {
            return;
        };
        assert_eq!(hash, run(None, &fits, 2).unwrap().0, "{method:?}");
        let gpu = gpu_within(Some(limits)).unwrap();
        let larger = sheets(largest + 1, method);
        let message = Simulation::new(&gpu.ctx, &larger)
            .err()
            .unwrap()
            .to_string();
        assert!(
            message.contains(&format!("atlas.size = {}", largest + 1))
                && message.ends_with(&format!("use at most {largest}")),
            "{message}"
        );
        gpu.finish();
    }
}

#[test]
fn a_method_that_has_no_room_is_refused_while_the_one_before_goes_on() {
    let limits = Limits {
        storage_buffer_range: 256 << 10,
        texel_buffer_elements: 1 << 20,
    };
    let Some(gpu) = gpu_within(Some(limits)) else {
        return;
    };
    let scene = sheets(180, DistanceMethod::Bvh);
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    for method in [DistanceMethod::Brute, DistanceMethod::Raster] {
        let mut settings = scene.settings.clone();
        settings.distance.method = method;
        let message = simulation.apply(&settings).unwrap_err().to_string();
        let starts = format!("distance.method = \"{}\" takes 1 MiB", method.word());
        assert!(
            message.contains(&starts) && message.contains("use distance.method = \"bvh\""),
            "{message}"
        );
        gpu.run(|rec| simulation.record_step(rec));
    }
    drop(simulation);
    gpu.finish();
}

/// What `myxo query diffuse` answers.
#[test]
fn a_large_trail_spreads_alone_as_a_small_one_does() {
    let scene = cube(203, |_| {});
    let atlas = Atlas::build(&scene.surface, &atlas_options(&scene.settings)).unwrap();
    let trail: Vec<f32> = (0..atlas.texel_count())
        .map(|texel| {
            if atlas.density[texel] > 0.0 {
                (texel % 17) as f32
            } else {
                0.0
            }
        })
        .collect();
    let spread = |limits| {
        let gpu = gpu_within(limits)?;
        let mut diffusion = Diffusion::new(&gpu.ctx, &atlas, 0.5).unwrap();
        diffusion.set(&trail).unwrap();
        diffusion.run(5, |_| true).unwrap();
        let values = diffusion.values().unwrap();
        drop(diffusion);
        gpu.finish();
        Some(values)
    };
    let Some(expected) = spread(None) else { return };
    assert_ne!(expected, trail);
    for texel_buffer_elements in [20_736, 1 << 20] {
        let limits = Limits {
            storage_buffer_range: BLOCK,
            texel_buffer_elements,
        };
        assert!(spread(Some(limits)).unwrap() == expected, "{limits:?}");
    }
}

/// Requests that exceed the device are refused before anything takes time.
#[test]
fn setups_of_any_size_say_what_they_need() {
    let small = cube(203, |_| {});
    let setup = Setup::new(&small).unwrap();
    let exact = memory::size_in_bytes(&setup, &small.settings);
    let needed = memory::needed(&small);
    assert!(needed <= exact && needed * 2 > exact, "{needed} of {exact}");
    let large = cube(16_384, |s| s.particles.count = 64_000_000);
    let gib = memory::needed(&large) as f64 / f64::from(1 << 30);
    // 23 bytes per texel and 38 per particle.
    assert!((gib - 8.0).abs() < 0.1, "{gib}");
}
