//! A device and small scenes, for tests.

use std::path::Path;
use std::sync::Arc;

use myxo::gpu::{Context, ContextOptions, Format, Frames};
use myxo::mesh::atlas::Control;
use myxo::render::Prepared;
use myxo::scene::{Overrides, Scene};
use myxo::sim::Simulation;

use crate::lab::stage::{Loaded, Stage};

/// The format of pictures.
pub const FORMAT: Format = Format::Rgba8Srgb;
/// Keys of a scene that takes a moment.
pub const SMALL: [&str; 2] = ["particles.count=3000", "atlas.size=128"];

/// A device under the validation layers. None, which is said, where there is none and MYXO_ALLOW_NO_DEVICE is set.
pub fn context() -> Option<Arc<Context>> {
    let options = ContextOptions {
        validation: true,
        ..ContextOptions::default()
    };
    match Context::new(&options) {
        Ok(ctx) => Some(ctx),
        Err(error) if std::env::var_os("MYXO_ALLOW_NO_DEVICE").is_some() => {
            eprintln!("skipped: {error}");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

/// A scene with these keys set.
pub fn scene(name: &str, set: &[&str]) -> Scene {
    let overrides = Overrides {
        set: set.iter().map(|text| (*text).to_owned()).collect(),
        ..Overrides::default()
    };
    Scene::load(Path::new(name), &overrides).unwrap()
}

/// Keys that give scenes of fine meshes coarse ones of the same shapes, which are laid out in a moment.
fn coarse(name: &str) -> &'static [&'static str] {
    const RING: &str = "object.0.mesh=builtin:torus?tube=0.36&major=36&minor=24";
    const BALL: &str = "object.1.mesh=builtin:icosphere?subdivisions=3";
    const BEAM: &str = "object.2.mesh=builtin:capsule?length=2.67&segments=24&rings=6";
    match name {
        "trio" => &[RING, BALL, BEAM],
        "oats" => &[RING, BALL],
        "pair" => &["object.0.mesh=builtin:torus?major=36&minor=24", BALL],
        _ => &[],
    }
}

/// A scene on the device, with coarse meshes and these keys set.
pub fn stage(ctx: &Arc<Context>, name: &str, set: &[&str]) -> Stage {
    let scene = scene(name, &[coarse(name), set].concat());
    let setup = Simulation::set_up(ctx.info(), &scene, &Control::default()).unwrap();
    let prepared = Prepared::for_quick(&setup);
    let loaded = Loaded {
        scene,
        setup,
        prepared,
        from: None,
    };
    Stage::new(ctx, loaded, FORMAT).unwrap()
}

/// Runs so many steps.
pub fn run(frames: &mut Frames, simulation: &mut Simulation, steps: u32) {
    let mut rec = frames.begin().unwrap();
    (0..steps).for_each(|_| simulation.record_step(&mut rec));
    frames.submit(rec).unwrap();
    frames.wait_idle().unwrap();
}
