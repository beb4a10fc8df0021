//! What a fuzz target does with its input. A panic is a find. `tests/mesh/corpus.rs` runs the same functions on the corpus.

use std::path::Path;
use std::sync::OnceLock;

use myxo::mesh::surface::Surface;
use myxo::mesh::{Mesh, MeshError, MeshProblem, RigidTrack};
use myxo::scene::settings::{FoodSettings, ObjectSettings, Settings};
use myxo::scene::{Overrides, Scene};
use myxo::sim::areas::AreaMap;
use myxo::sim::checkpoint::Checkpoint;
use myxo::sim::start::{Mask, MaskTable};
use myxo::sim::{Setup, Snapshot, twin};

/// A target: its name, which is that of its folder in the corpus, and what it does.
pub type Target = (&'static str, fn(&[u8]));

/// All of them.
pub const TARGETS: [Target; 7] = [
    ("obj", obj),
    ("gltf", gltf),
    ("ply", ply),
    ("stl", stl),
    ("scene", scene),
    ("checkpoint", checkpoint),
    ("map", map),
];

/// A model in OBJ.
pub fn obj(bytes: &[u8]) {
    model("a.obj", bytes);
}

/// A model in PLY.
pub fn ply(bytes: &[u8]) {
    model("a.ply", bytes);
}

/// A model in STL.
pub fn stl(bytes: &[u8]) {
    model("a.stl", bytes);
}

/// A model in glTF or GLB, and the animation in it.
pub fn gltf(bytes: &[u8]) {
    model("a.gltf", bytes);
    if let Err(MeshProblem::Panicked(panic)) = RigidTrack::from_bytes(Path::new("a.gltf"), bytes) {
        panic!("{panic}");
    }
}

fn model(path: &str, bytes: &[u8]) {
    match Mesh::from_bytes(Path::new(path), bytes) {
        Ok(mesh) => Surface::build(&[(&mesh, 1.0)])
            .validate()
            .expect("what is read can be walked on"),
        // The readers turn panics into this.
        Err(MeshError::Bad {
            problem: MeshProblem::Panicked(panic),
            ..
        }) => panic!("{panic}"),
        Err(error) => is_short(&error.to_string()),
    }
}

/// Messages quote the beginning of what is long.
fn is_short(message: &str) {
    assert!(message.len() < 10_000, "{message}");
}

/// A scene file: what is read is written, and read again the same. With other meshes and no files it is set up.
pub fn scene(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    let read = |text| Scene::read_text(Path::new("a.toml"), text, &Overrides::default());
    let mut settings = match read(text) {
        Ok(settings) => settings,
        Err(error) => return is_short(&error.to_string()),
    };
    let again = read(&settings.to_toml()).expect("what is written can be read");
    assert_eq!(again, settings);
    // What takes long by its size alone, and files of this machine.
    if settings.objects.len() > 4 || settings.food_count() > 8 {
        return;
    }
    for object in &mut settings.objects {
        "builtin:cube".clone_into(&mut object.mesh);
        object.start.mask.clear();
    }
    settings.particles.start_mask.clear();
    settings.areas.map.clear();
    settings.atlas.size = 32;
    settings.particles.count = settings.particles.count.min(100);
    match Scene::from_settings("a".to_owned(), settings, "".into()) {
        Ok(scene) => {
            if let Err(error) = Setup::new(&scene) {
                is_short(&error.to_string());
            }
        }
        Err(error) => is_short(&error.to_string()),
    }
}

/// Two objects with food, whose states are those of the target `checkpoint`.
pub fn scene_of_checkpoints() -> Scene {
    let mut settings = Settings::default();
    settings.particles.count = 24;
    settings.atlas.size = 24;
    settings.physarum.speed = 0.05;
    settings.objects = [[0.0; 3], [0.9, 0.1, 0.0]]
        .map(|position| ObjectSettings {
            mesh: "builtin:cube".to_owned(),
            position,
            ..ObjectSettings::default()
        })
        .to_vec();
    settings.objects[0].motion.spin = [0.0, 60.0, 0.0];
    settings.objects[0].name = "a".to_owned();
    settings.foods.push(FoodSettings {
        object: "a".to_owned(),
        at: [0.0, 1.0, 0.0],
        amount: 50,
        size: 0.2,
        ..FoodSettings::default()
    });
    Scene::from_settings("two".to_owned(), settings, "".into()).expect("it is right")
}

/// The scene of checkpoints, set up.
fn trial() -> &'static (Scene, Setup) {
    static TRIAL: OnceLock<(Scene, Setup)> = OnceLock::new();
    TRIAL.get_or_init(|| {
        let scene = scene_of_checkpoints();
        let setup = Setup::new(&scene).expect("it is right");
        (scene, setup)
    })
}

/// A checkpoint of that scene as a seed: the whole file.
#[must_use]
pub fn seed_checkpoint(steps: usize) -> Checkpoint {
    let (scene, setup) = trial();
    let mut simulation = twin::Simulation::new(setup.clone(), scene.settings.clone());
    for _ in 0..steps {
        simulation.step();
    }
    Checkpoint {
        // What the target puts there.
        scene: String::new(),
        ..Checkpoint::new(scene, setup, simulation.snapshot())
    }
}

/// A checkpoint with a corrected checksum, of the scene of checkpoints: steps must be possible from every state that is not refused.
pub fn checkpoint(bytes: &[u8]) {
    gone_on(bytes);
}

/// The same; returns whether it was accepted.
pub fn gone_on(bytes: &[u8]) -> bool {
    let Some(body) = bytes.len().checked_sub(4) else {
        let _ = Checkpoint::from_bytes(bytes);
        return false;
    };
    let mut corrected = bytes[..body].to_vec();
    corrected.extend(crc32fast::hash(&bytes[..body]).to_le_bytes());
    let read = match Checkpoint::from_bytes(&corrected) {
        Ok(read) => read,
        Err(reason) => {
            is_short(&reason);
            return false;
        }
    };
    let (scene, setup) = trial();
    let own = Checkpoint::new(scene, setup, Snapshot::default());
    let checkpoint = Checkpoint {
        snapshot: read.snapshot,
        ..own
    };
    if let Err(reason) = checkpoint.check(scene, setup) {
        is_short(&reason);
        return false;
    }
    let mut simulation = twin::Simulation::new(setup.clone(), scene.settings.clone());
    simulation.restore(&checkpoint.snapshot);
    for _ in 0..2 {
        simulation.step();
        let state = simulation.snapshot();
        state.validate(setup).expect("steps can continue from here");
    }
    true
}

/// A PNG as a map of areas and as a mask.
pub fn map(bytes: &[u8]) {
    let (scene, setup) = trial();
    let (path, size) = (Path::new("a.png"), scene.settings.atlas.size);
    match AreaMap::from_bytes(path, bytes, size) {
        Ok(map) => {
            if let Ok(bias) = map.bias(&setup.atlas, 5.0) {
                assert!(bias.iter().all(|value| value.is_finite()));
            }
        }
        Err(error) => is_short(&error.to_string()),
    }
    if let Ok(mask) = Mask::from_bytes(path, bytes, size) {
        let _ = MaskTable::new(&mask, &setup.surface, &setup.atlas, None);
    }
}
