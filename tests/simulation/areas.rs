//! Areas of a scene's map: they act from the first step on, in kernels as in twins, and come back from where they are kept.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::common::{Gpu, TRIO, gpu, scene_of_several};
use crate::program::{Folder, path, program, text};
use image::{Rgb, RgbImage};
use myxo::export::{Colors, Export, ExportFile};
use myxo::gpu::{Context, Frames};
use myxo::mesh::surface::Triangle;
use myxo::scene::settings::Strategy;
use myxo::scene::{Overrides, Scene};
use myxo::sim::areas::map_beside;
use myxo::sim::paint::{Brush, Dab, NO_GO, NO_GO_BELOW};
use myxo::sim::types::Particle;
use myxo::sim::{Setup, Simulation, Snapshot, twin};

const STEPS: u32 = 12;

/// Stripes of every kind over the whole texture, narrower than charts.
fn stripes(folder: &Folder) -> PathBuf {
    let map = folder.file("map.png");
    let color = |x: u32, y: u32| match ((x + y) / 9) % 4 {
        0 => Rgb([0, 200, 0]),
        1 => Rgb([0, 0, 0]),
        2 => Rgb([0, 0, 120]),
        _ => Rgb([255, 0, 0]),
    };
    RgbImage::from_fn(128, 128, color).save(&map).unwrap();
    map
}

fn load(text: &str, folder: &Folder) -> Scene {
    let file = folder.file("scene.toml");
    std::fs::write(&file, text).unwrap();
    Scene::load(&file, &Overrides::default()).unwrap()
}

fn striped(folder: &Folder) -> Scene {
    stripes(folder);
    let text = "[particles]\ncount = 4001\n[atlas]\nsize = 128\n[areas]\nmap = \"map.png\"\nstrength = 30.0\n\
        [[object]]\nmesh = \"builtin:cube\"\n";
    load(text, folder)
}

fn run(ctx: &Arc<Context>, simulation: &mut Simulation, steps: u32) -> Snapshot {
    let mut frames = Frames::new(ctx, 2).unwrap();
    for _ in 0..steps {
        let mut rec = frames.begin().unwrap();
        simulation.record_step(&mut rec);
        frames.submit(rec).unwrap();
    }
    frames.wait_idle().unwrap();
    simulation.snapshot().unwrap()
}

/// The ids of particles in no-go areas.
fn in_no_go(state: &Snapshot, setup: &Setup) -> BTreeSet<u32> {
    let is_in = |p: &&Particle| {
        let texel = setup.atlas.texel_of(p.triangle, p.u, p.v);
        state.bias[texel as usize] < NO_GO_BELOW
    };
    let inside = state.particles.iter().filter(is_in);
    inside.map(|particle| particle.id).collect()
}

#[test]
fn a_map_acts_from_the_first_step_on_as_in_the_twin() {
    let Some(gpu) = gpu() else { return };
    let folder = Folder::new();
    let scene = striped(&folder);
    let setup = Setup::new(&scene).unwrap();
    let start = Snapshot::start(&setup);
    assert_eq!(start.bias.len(), setup.atlas.texel_count());
    let inside = in_no_go(&start, &setup);
    assert!(inside.len() > 500, "a quarter begins there");
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    assert_eq!(simulation.areas().unwrap(), start.bias);
    let state = run(&gpu.ctx, &mut simulation, STEPS);
    let mut twin = twin::Simulation::new(setup, scene.settings.clone());
    for _ in 0..STEPS {
        twin.step();
    }
    let of_twin = twin.snapshot();
    assert_eq!(state.bias, of_twin.bias);
    let [state, of_twin] = [state, of_twin].map(|mut state| {
        state.particles.sort_by_key(|particle| particle.id);
        state
    });
    let both = state.particles.iter().zip(&of_twin.particles);
    let alike = both.filter(|(a, b)| {
        a.triangle == b.triangle && (a.u - b.u).abs() < 1e-3 && (a.v - b.v).abs() < 1e-3
    });
    // Particles between two equal readings may turn differently, by rounding.
    assert!(alike.count() > 3900, "they walk alike");
    // Particles inside may leave, and none comes in.
    let after = in_no_go(&state, twin.setup());
    assert!(after.len() < inside.len(), "some have left");
    assert!(after.is_subset(&inside), "and none has come in");
    // Without the map they walk differently.
    let mut without = scene.clone();
    without.settings.areas.map.clear();
    let mut free = Simulation::new(&gpu.ctx, &without).unwrap();
    let free_state = run(&gpu.ctx, &mut free, STEPS);
    assert!(free_state.bias.is_empty());
    assert_ne!(free_state.hash(), state.hash());
    drop((simulation, free));
    gpu.finish();
}

/// Every texel of an object, gutters too.
fn no_go_on(setup: &Setup, object: u32) -> Vec<f32> {
    let atlas = &setup.atlas;
    let mut bias = vec![0.0; atlas.texel_count()];
    let owned = (0..).zip(atlas.owner.iter().copied());
    let gutters = atlas.gutter_texels.iter().map(|g| (g.texel, g.triangle));
    for (texel, triangle) in owned.chain(gutters) {
        let triangles = &setup.surface.triangles;
        let is_on = |shape: &Triangle| shape.object == object;
        if triangles.get(triangle as usize).is_some_and(is_on) {
            bias[texel as usize] = NO_GO;
        }
    }
    bias
}

/// Particles do not transfer into a no-go area of another object.
#[test]
fn no_particle_transfers_into_a_no_go_area() {
    let Some(gpu) = gpu() else { return };
    // Twins of the strategies that transfer do the same.
    for (strategy, by_twin) in [
        (Strategy::Parallel, true),
        (Strategy::Scattered, false),
        (Strategy::Direct, true),
    ] {
        let scene = scene_of_several(&TRIO, |settings| {
            settings.particles.count = 3000;
            settings.atlas.size = 256;
            settings.physarum.speed = 0.02;
            settings.transfer.strategy = strategy;
        });
        let setup = Setup::new(&scene).unwrap();
        let mut free = Simulation::from_setup(&gpu.ctx, &scene, setup.clone()).unwrap();
        let mut simulation = Simulation::from_setup(&gpu.ctx, &scene, setup).unwrap();
        let bias = no_go_on(free.setup(), 1);
        simulation.set_areas(&bias).unwrap();
        let start = simulation.snapshot().unwrap();
        let mut twin = twin::Simulation::new(simulation.setup().clone(), scene.settings.clone());
        twin.restore(&start);
        let on_first = |state: &Snapshot, setup: &Setup| -> BTreeSet<u32> {
            let triangles = &setup.surface.triangles;
            let on = |p: &&Particle| triangles[p.triangle as usize].object == 1;
            state.particles.iter().filter(on).map(|p| p.id).collect()
        };
        let began = on_first(&start, simulation.setup());
        let freely = run(&gpu.ctx, &mut free, STEPS);
        let came = on_first(&freely, free.setup());
        assert!(came.difference(&began).count() > 20, "without, some come");
        for _ in 0..STEPS {
            let state = run(&gpu.ctx, &mut simulation, 1);
            state.validate(simulation.setup()).unwrap();
            assert!(on_first(&state, simulation.setup()).is_subset(&began));
            let flux = &state.transfers.flux;
            assert_eq!((flux[1], flux[7]), (0, 0), "{flux:?}");
            if by_twin {
                twin.step();
            }
        }
        let state = simulation.snapshot().unwrap();
        assert!(state.transfers.flux[0] > 20, "they turn round");
        if !by_twin {
            continue;
        }
        let of_twin = twin.snapshot().transfers.flux;
        let both = state.transfers.flux.iter().zip(&of_twin);
        let differ: u32 = both.map(|(a, b)| a.abs_diff(*b)).sum();
        assert!(differ < 20, "{:?}, {of_twin:?}", state.transfers.flux);
    }
    gpu.finish();
}

fn exported(gpu: &Gpu, scene: &Scene, simulation: &Simulation, file: &Path) -> Scene {
    let snapshot = simulation.snapshot().unwrap();
    let export = Export::of(scene, simulation, &snapshot).unwrap();
    let written = ExportFile::create(file).unwrap();
    let written = written.write(&export, Colors::Texture).unwrap();
    assert!(written.files.iter().all(|file| file.exists()));
    drop(export);
    assert_eq!(gpu.ctx.messages(), [""; 0]);
    Scene::load(file, &Overrides::default()).unwrap()
}

#[test]
fn what_was_painted_comes_back_from_a_scene_file() {
    let Some(gpu) = gpu() else { return };
    let folder = Folder::new();
    let scene = striped(&folder);
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let center = scene.center + glam::Vec3::Y * scene.radius;
    for brush in [Brush::Attract { amount: 55.5 }, Brush::NoGo] {
        let mut frames = Frames::new(&gpu.ctx, 1).unwrap();
        let mut rec = frames.begin().unwrap();
        let painted = simulation.paint(
            &mut rec,
            &Dab {
                brush,
                center: center * [0.6, 0.9][usize::from(brush == Brush::NoGo)],
                radius: 0.7 * scene.radius,
                eye: None,
                ring: None,
                number: 0,
            },
        );
        assert!(painted.unwrap().count() > 100);
        frames.submit(rec).unwrap();
        frames.wait_idle().unwrap();
    }
    let painted = simulation.areas().unwrap();
    let elsewhere = Folder::new();
    let file = elsewhere.file("painted.toml");
    let again = exported(&gpu, &scene, &simulation, &file);
    assert_eq!(Path::new(&again.settings.areas.map), map_beside(&file));
    let bias = Simulation::new(&gpu.ctx, &again).unwrap().areas().unwrap();
    let off = bias.iter().zip(&painted).map(|(a, b)| (a - b).abs());
    assert!(off.fold(0.0, f32::max) <= 2e-5 * again.settings.areas.strength);

    // If everything is erased, the file has no areas.
    simulation.forget_areas().unwrap();
    let bare = folder.file("bare.toml");
    let again = exported(&gpu, &scene, &simulation, &bare);
    assert_eq!(again.settings.areas.map, "");
    assert!(!map_beside(&bare).exists());
    drop(simulation);
    gpu.finish();
}

/// Would catch: an exported scene that names another map than the one beside it.
#[cfg(target_os = "linux")]
#[test]
fn a_painted_scene_gets_no_name_that_its_map_cannot_have() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt as _;

    let Some(gpu) = gpu() else { return };
    let folder = Folder::new();
    let scene = striped(&folder);
    let simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let snapshot = simulation.snapshot().unwrap();
    let export = Export::of(&scene, &simulation, &snapshot).unwrap();
    let elsewhere = Folder::new();
    let odd = elsewhere.file(OsStr::from_bytes(b"\xff.toml"));
    let file = ExportFile::create(&odd).unwrap();
    let refused = file.write(&export, Colors::Texture).unwrap_err();
    let refused = refused.to_string();
    assert!(refused.contains("is not Unicode"), "{refused}");
    assert_eq!(elsewhere.names(), [""; 0], "neither a scene nor a map");
    drop((export, simulation));
    gpu.finish();
}

#[test]
fn a_checkpoint_has_what_is_there_and_not_what_the_map_says() {
    let Some(gpu) = gpu() else { return };
    let folder = Folder::new();
    let scene = striped(&folder);
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    simulation.forget_areas().unwrap();
    let state = run(&gpu.ctx, &mut simulation, 3);
    assert!(state.bias.is_empty());
    let mut other = Simulation::new(&gpu.ctx, &scene).unwrap();
    other.restore(&state).unwrap();
    assert_eq!(other.snapshot().unwrap().hash(), state.hash());
    let refused = other.set_areas(&[1.0; 7]).unwrap_err().to_string();
    assert!(refused.contains("7 texels"), "{refused}");
    drop((simulation, other));
    gpu.finish();
}

#[test]
fn the_program_says_what_is_wrong_with_a_map() {
    let folder = Folder::new();
    let black = folder.file("black.png");
    RgbImage::new(32, 32).save(&black).unwrap();
    let words = folder.file("words.png");
    std::fs::write(&words, "green").unwrap();
    let none = folder.file("none.png");
    for (map, said) in [
        (&black, "black.png: the area map says nothing wherever"),
        (&words, "words.png: the area map must be a PNG"),
        (&none, "none.png"),
    ] {
        let set = format!("areas.map={}", path(map));
        let out = folder.file("x.png");
        let mut run = program();
        run.args(["render", "cube", "--steps", "1", "--size", "64x48"]);
        run.args(["--set", "particles.count=100", "--set", "atlas.size=64"]);
        run.args(["--set", &set, "--out", path(&out)]);
        let output = run.output().unwrap();
        let message = text(&output.stderr);
        assert!(
            !output.status.success() && message.contains(said),
            "{message}"
        );
        assert!(!message.contains("panicked") && !out.exists(), "{message}");
    }
}
