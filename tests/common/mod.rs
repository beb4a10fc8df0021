//! Helpers of GPU tests: a device with validation on, small scenes, and comparisons.

#![allow(dead_code, reason = "each test program uses its own part")]

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};
use std::time::UNIX_EPOCH;

use crate::places;
use myxo::gpu::{Context, ContextOptions, Frames, Limits, Recorder};
use myxo::mesh::Mesh;
use myxo::mesh::atlas::Control;
use myxo::scene::Scene;
use myxo::scene::settings::{ObjectSettings, Settings};
use myxo::sim::types::{Motion, Particle};
use myxo::sim::{Setup, Simulation, Snapshot};

/// A device with the validation layers on, which a test has for itself. Call [`Gpu::finish`] at the end of the test.
///
/// Opening one takes longer than many a test, so the next test takes it over, with its pipelines. A context is reused unless a test
/// failed with it, lost it, or got a validation message.
pub struct Gpu {
    pub ctx: Arc<Context>,
    means: Means,
}

/// The options of a test's device.
#[derive(Clone, Copy, Default, PartialEq)]
struct Means {
    limits: Option<Limits>,
    card_forms: Option<bool>,
}

/// Contexts that no test has, with the means that they were made with.
static FREE: Mutex<Vec<(Means, Arc<Context>)>> = Mutex::new(Vec::new());

/// The device, or `None` where there is none and `MYXO_ALLOW_NO_DEVICE=1` says that tests may then be skipped.
///
/// # Panics
/// When there is no device and nothing allows that.
pub fn gpu() -> Option<Gpu> {
    gpu_within(None)
}

/// As [`gpu`], with lowered limits.
///
/// # Panics
/// As for [`gpu`].
pub fn gpu_within(limits: Option<Limits>) -> Option<Gpu> {
    gpu_by(Means {
        limits,
        ..Means::default()
    })
}

/// A device that runs kernels in their form for graphics cards, which CPUs do not run by themselves.
///
/// # Panics
/// As for [`gpu`], and also where the device cannot run them.
pub fn gpu_by_card_forms() -> Option<Gpu> {
    gpu_by_card_forms_within(None)
}

/// As [`gpu_by_card_forms`], with lowered limits.
///
/// # Panics
/// As for [`gpu`].
pub fn gpu_by_card_forms_within(limits: Option<Limits>) -> Option<Gpu> {
    let gpu = gpu_by(Means {
        limits,
        card_forms: Some(true),
    })?;
    if gpu.ctx.info().has_card_forms {
        return Some(gpu);
    }
    assert!(
        std::env::var_os("MYXO_ALLOW_NO_DEVICE").is_some(),
        "the device cannot run the forms for graphics cards\n(MYXO_ALLOW_NO_DEVICE=1 skips the tests that need them)"
    );
    eprintln!("skipped: the device cannot run the forms for graphics cards");
    None
}

fn gpu_by(means: Means) -> Option<Gpu> {
    if let Some(ctx) = free_context(means) {
        return Some(Gpu { ctx, means });
    }
    match Context::new(&ContextOptions {
        // The archive of `make bundle` also runs where no layer works.
        validation: std::env::var_os("MYXO_WITHOUT_LAYERS").is_none(),
        limits: means.limits,
        card_forms: means.card_forms,
        ..ContextOptions::default()
    }) {
        Ok(ctx) => Some(Gpu { ctx, means }),
        Err(error) if std::env::var_os("MYXO_ALLOW_NO_DEVICE").is_some() => {
            eprintln!("skipped: {error}");
            None
        }
        Err(error) => {
            panic!("{error}\n(MYXO_ALLOW_NO_DEVICE=1 skips the tests that need a device)")
        }
    }
}

/// One that an earlier test has left as it found it.
fn free_context(means: Means) -> Option<Arc<Context>> {
    let mut free = FREE.lock().unwrap_or_else(PoisonError::into_inner);
    // Objects that a test drops after giving back its context still use the context, possibly on another thread.
    let index = (free.iter()).position(|(of, ctx)| *of == means && Arc::strong_count(ctx) == 1)?;
    let (_, ctx) = free.swap_remove(index);
    drop(free);
    ctx.wait_idle().expect("it was not lost when it was left");
    let _ = ctx.debug_entries();
    let late = ctx.take_messages();
    assert!(
        late.is_empty(),
        "an earlier test has left these validation messages, when it had ended:\n{}",
        late.join("\n")
    );
    Some(ctx)
}

impl Gpu {
    /// Records, submits and waits.
    pub fn run(&self, record: impl FnOnce(&mut Recorder)) {
        Frames::new(&self.ctx, 1)
            .unwrap()
            .run(|rec| record(rec))
            .unwrap();
    }

    /// Fails the test if the validation layers said anything.
    pub fn finish(self) {}
}

impl Drop for Gpu {
    fn drop(&mut self) {
        if std::thread::panicking() {
            return;
        }
        let messages = self.ctx.messages();
        assert!(
            messages.is_empty(),
            "validation messages:\n{}",
            messages.join("\n")
        );
        if !self.ctx.is_lost() {
            let mut free = FREE.lock().unwrap_or_else(PoisonError::into_inner);
            free.push((self.means, Arc::clone(&self.ctx)));
        }
    }
}

/// Sets a scene up with a layout that an earlier test of the same program may have made: to lay a fine mesh out takes longer than
/// many a test.
pub fn set_up(ctx: &Context, scene: &Scene) -> Setup {
    let control = Control {
        cache: Some(layouts()),
        ..Control::default()
    };
    Simulation::set_up(ctx.info(), scene, &control).unwrap()
}

/// The folder of layouts that this build of the test program has made; those of other builds go, as they may lie otherwise.
fn layouts() -> &'static Path {
    static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
        let program = std::env::current_exe().expect("it has a name");
        let built = fs::metadata(&program).and_then(|file| file.modified());
        let built = built.expect("it can be read").duration_since(UNIX_EPOCH);
        let name = program
            .file_stem()
            .expect("it has a name")
            .to_string_lossy();
        // Cargo adds to the name what differs between profiles.
        let of_all = places::scratch().join("layouts").join(&*name);
        let own = of_all.join(built.expect("it is no older").as_nanos().to_string());
        for other in fs::read_dir(&of_all).into_iter().flatten().flatten() {
            if other.path() != own {
                // Another process of this program may be at it, too.
                let _ = fs::remove_dir_all(other.path());
            }
        }
        own
    });
    &FOLDER
}

/// A scene of one mesh.
pub fn scene(mesh: &str, change: impl FnOnce(&mut Settings)) -> Scene {
    let mut settings = Settings::default();
    settings.objects[0].mesh = mesh.to_owned();
    settings.particles.count = 5000;
    settings.atlas.size = 256;
    change(&mut settings);
    Scene::from_settings("test".to_owned(), settings, ".".into()).unwrap()
}

/// A scene of a mesh in memory.
pub fn scene_of(mesh: Mesh, change: impl FnOnce(&mut Settings)) -> Scene {
    let mut settings = Settings::default();
    settings.particles.count = 5000;
    settings.atlas.size = 256;
    change(&mut settings);
    Scene::from_meshes("test".to_owned(), settings, vec![mesh], ".".into()).unwrap()
}

/// A scene of built-in meshes at these places, all turned alike.
pub fn scene_of_several(meshes: &[(&str, [f32; 3])], change: impl FnOnce(&mut Settings)) -> Scene {
    let objects = meshes
        .iter()
        .map(|&(mesh, position)| ObjectSettings {
            mesh: format!("builtin:{mesh}"),
            position: position.map(f64::from),
            rotation: [10.0, 20.0, 30.0],
            ..ObjectSettings::default()
        })
        .collect();
    let mut settings = Settings {
        objects,
        ..Settings::default()
    };
    change(&mut settings);
    Scene::from_settings("test".to_owned(), settings, ".".into()).unwrap()
}

/// Three that touch one another, each with the place that it stands at.
pub const TRIO: [(&str, [f32; 3]); 3] = [
    ("torus?major=24&minor=16", [0.0; 3]),
    ("cube", [0.9, 0.1, 0.0]),
    ("icosphere?subdivisions=2", [0.2, 1.0, 0.3]),
];

/// Keys of the scene `trio` with meshes of the same shapes that are laid out at once.
pub const COARSE_TRIO: [&str; 3] = [
    "object.0.mesh=builtin:torus?tube=0.36&major=36&minor=24",
    "object.1.mesh=builtin:icosphere?subdivisions=3",
    "object.2.mesh=builtin:capsule?length=2.67&segments=24&rings=6",
];

/// Keys of the scene `crowd` with beads of so many subdivisions.
pub fn coarse_crowd(subdivisions: u32) -> Vec<String> {
    let key = |i| format!("object.{i}.mesh=builtin:icosphere?subdivisions={subdivisions}");
    (0..64).map(key).collect()
}

/// Sizes at which kernels break: nothing, one, about a group, about several.
pub fn awkward_sizes(group: u32) -> Vec<u32> {
    vec![0, 1, group - 1, group, group + 1, 3 * group + 7, 1021]
}

/// Particles and motions in the order of ids: steps may put them in another one.
pub fn by_id(state: &Snapshot) -> Vec<(Particle, Motion)> {
    let both = state.particles.iter().copied();
    let mut both: Vec<_> = both.zip(state.motions.iter().copied()).collect();
    both.sort_by_key(|(particle, _)| particle.id);
    both
}
