//! Altered checkpoints with a corrected checksum: each is refused with a reason, or steps can continue
//! from it, and no particle is lost.

mod kinds;
mod parts;

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

use crate::common::{Gpu, gpu};
use crate::program::Folder;
use myxo::gpu::Frames;
use myxo::scene::{Overrides, Scene};
use myxo::sim::checkpoint::Checkpoint;
use myxo::sim::network::Network;
use myxo::sim::paint::{Brush, Dab};
use myxo::sim::{Setup, Simulation};
use serde_json::json;

use kinds::ALTERATIONS;
use parts::{LISTS, Parts};

/// Two objects move together, so that pairs are kept; the third turns. There is food, and there are areas.
const SCENE: &str = r#"
radius = 3.0
[particles]
count = 900
[physarum]
speed = 0.02
[atlas]
size = 96
[areas]
map = "builtin:maze"
strength = 2.0
[second_look]
preset = "cells"
[transfer]
strategy = "STRATEGY"
[[object]]
name = "ring"
mesh = "builtin:torus?major=24&minor=16"
[object.motion]
orbit = [0.0, 40.0, 0.0]
[[object]]
name = "box"
mesh = "builtin:cube"
position = [0.9, 0.1, 0.0]
rotation = [10.0, 20.0, 30.0]
[object.motion]
orbit = [0.0, 40.0, 0.0]
[[object]]
name = "ball"
mesh = "builtin:icosphere?subdivisions=2"
position = [0.2, 1.0, 0.3]
[object.motion]
spin = [0.0, 60.0, 0.0]
[[food]]
object = "ring"
at = [1.4, 0.0, 0.0]
radius = 0.5
amount = 900
[[food]]
object = "ball"
at = [0.0, 1.0, 0.0]
radius = 0.2
amount = 0
[[pulse]]
at = [0.2, 0.5, 0.0]
step = 10
speed = 0.03
"#;

const STEPS_BEFORE: u32 = 15;
const STEPS_AFTER: u32 = 3;
/// A step of these scenes takes milliseconds.
const PATIENCE: Duration = Duration::from_secs(20);

/// A scene, its state after some steps, and a simulation that continues from what is read.
struct Trial {
    gpu: Gpu,
    scene: Scene,
    setup: Setup,
    simulation: Simulation,
    frames: Frames,
    whole: Parts,
    folder: Folder,
}

impl Trial {
    fn of(strategy: &str) -> Option<Self> {
        let gpu = gpu()?;
        let folder = Folder::new();
        let file = folder.with("three.toml", SCENE.replace("STRATEGY", strategy));
        let scene = Scene::load(&file, &Overrides::default()).unwrap();
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let mut frames = Frames::new(&gpu.ctx, 2).unwrap();
        let blend = Dab {
            brush: Brush::Look { amount: 0.6 },
            center: scene.center,
            radius: scene.radius,
            eye: None,
            ring: None,
            number: 0,
        };
        let mut rec = frames.begin().unwrap();
        simulation.paint(&mut rec, &blend).unwrap();
        frames.submit(rec).unwrap();
        run(&mut simulation, &mut frames, STEPS_BEFORE);
        let state = simulation.snapshot().unwrap();
        let setup = simulation.setup().clone();
        let checkpoint = Checkpoint::new(&scene, &setup, state);
        let file = folder.file("whole.state");
        checkpoint.write(&file).unwrap();
        Some(Self {
            whole: Parts::of(&std::fs::read(file).unwrap()),
            gpu,
            scene,
            setup,
            simulation,
            frames,
            folder,
        })
    }

    /// The reason for which it is refused, if it is. Steps continue from all others.
    fn refusal(&mut self, parts: &Parts) -> Option<String> {
        let file = self.folder.with("altered.state", parts.bytes());
        let checkpoint = match Checkpoint::read(&file) {
            Ok(checkpoint) => checkpoint,
            Err(error) => return Some(error.to_string()),
        };
        if let Err(reason) = checkpoint.check(&self.scene, &self.setup) {
            return Some(reason);
        }
        self.simulation.restore(&checkpoint.snapshot).unwrap();
        run(&mut self.simulation, &mut self.frames, STEPS_AFTER);
        let state = self.simulation.snapshot().unwrap();
        state.validate(&self.setup).unwrap();
        state.check_ranges(&self.setup).unwrap();
        // What reports say of it.
        assert!(state.trail_mass(&self.setup).is_finite());
        let _ = (state.hash(), Network::of(&state, &self.setup));
        None
    }

    /// As [`refusal`](Self::refusal). Panics and long runs fail the test, with the name of the alteration.
    #[track_caller]
    fn tried(&mut self, what: &str, parts: &Parts) -> Option<String> {
        let begun = Instant::now();
        let refusal = catch_unwind(AssertUnwindSafe(|| self.refusal(parts)));
        let refusal = refusal.unwrap_or_else(|panic| panic!("{what}: {}", text_of(&*panic)));
        let took = begun.elapsed();
        assert!(took < PATIENCE, "{what}: {took:?}");
        if let Some(reason) = &refusal {
            assert!(
                (20..500).contains(&reason.len()) && !reason.contains("bug"),
                "{what}: {reason}"
            );
        }
        refusal
    }

    /// Alters states at random, and gives how many of them were continued from.
    fn alter_at_random(&mut self, seed: u64, cases: u64) -> u64 {
        let mut accepted = 0;
        for case in 0..cases {
            let mut draws = Draws(seed ^ case << 20);
            let mut parts = self.whole.clone();
            let mut what = format!("seed {seed} case {case}");
            for _ in 0..=draws.below(2) {
                what += ", ";
                what += &alter(&mut parts, &mut draws);
            }
            accepted += u64::from(self.tried(&what, &parts).is_none());
        }
        accepted
    }

    fn finish(self) {
        drop((self.simulation, self.frames));
        self.gpu.finish();
    }
}

fn run(simulation: &mut Simulation, frames: &mut Frames, steps: u32) {
    for _ in 0..steps {
        let mut rec = frames.begin().unwrap();
        simulation.record_step(&mut rec);
        frames.submit(rec).unwrap();
    }
    frames.wait_idle().unwrap();
}

fn text_of(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied())
        .unwrap_or_default()
}

/// Random words (SplitMix64, Steele et al. 2014).
struct Draws(u64);

impl Draws {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut word = self.0;
        word = (word ^ word >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        word = (word ^ word >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        word ^ word >> 31
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }

    /// A number that arithmetic or indices may not like, or any.
    fn word(&mut self) -> u32 {
        const FLOATS: [f32; 18] = [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            3e38,
            -3e38,
            1e30,
            1e20,
            1e15,
            1e9,
            1e6,
            2.0,
            1.0,
            0.5,
            1e-20,
            1e-44,
            -0.0,
            -1e-3,
            -1.0,
        ];
        const INTEGERS: [u32; 12] = [
            0,
            1,
            2,
            3,
            600,
            899,
            900,
            65_535,
            1 << 16,
            1 << 31,
            u32::MAX - 1,
            u32::MAX,
        ];
        match self.below(5) {
            0 | 1 => FLOATS[self.below(FLOATS.len())].to_bits(),
            2 | 3 => INTEGERS[self.below(INTEGERS.len())],
            _ => self.next() as u32,
        }
    }

    fn double(&mut self) -> f64 {
        const DOUBLES: [f64; 10] = [
            f64::NAN,
            f64::INFINITY,
            f64::MAX,
            -1.0,
            0.0,
            1e-300,
            1e13,
            1e14,
            1e15,
            3600.0,
        ];
        DOUBLES[self.below(DOUBLES.len())]
    }
}

/// Alters one thing, and says which.
fn alter(parts: &mut Parts, draws: &mut Draws) -> String {
    if draws.below(6) == 0 {
        return alter_header(parts, draws);
    }
    let list = draws.below(LISTS.len());
    let size = LISTS[list].1;
    let length = parts.lists[list].len();
    let elements = length / size;
    if length == 0 {
        parts.lists[list] = (0..size).map(|_| draws.word()).collect();
        parts.count();
        return format!("list {list} has an element");
    }
    let (at, other) = (draws.below(elements), draws.below(elements));
    let with = draws.word();
    match draws.below(8) {
        0 => {
            let kept = [elements - 1, elements / 2, 0][draws.below(3)];
            parts.lists[list].truncate(kept * size);
            parts.count();
            format!("list {list} cut to {kept}")
        }
        1 => {
            let copied = parts.lists[list][at * size..(at + 1) * size].to_vec();
            parts.lists[list].extend(copied);
            parts.count();
            format!("list {list} with element {at} again")
        }
        2 => {
            for word in 0..size {
                parts.lists[list].swap(at * size + word, other * size + word);
            }
            format!("list {list} elements {at} and {other} exchanged")
        }
        3 => {
            let word = draws.below(size);
            for element in 0..elements {
                parts.lists[list][element * size + word] = with;
            }
            format!("list {list} words {word} all {with:#x}")
        }
        4 => {
            let word = draws.below(length);
            let bit = draws.below(32);
            parts.lists[list][word] ^= 1 << bit;
            format!("list {list} word {word} bit {bit}")
        }
        5 => {
            let word = draws.below(length);
            let by = [1, u32::MAX][draws.below(2)];
            let before = parts.lists[list][word];
            parts.lists[list][word] = before.wrapping_add(by);
            format!("list {list} word {word} {before:#x} plus {by:#x}")
        }
        _ => {
            let word = draws.below(length);
            parts.lists[list][word] = with;
            format!("list {list} word {word} {with:#x}")
        }
    }
}

fn alter_header(parts: &mut Parts, draws: &mut Draws) -> String {
    let numbers = [
        0,
        1,
        2,
        3,
        4,
        899,
        900,
        1 << 31,
        1 << 32,
        1 << 53,
        1 << 62,
        u64::MAX,
    ];
    let number = numbers[draws.below(numbers.len())];
    let header = &mut parts.header;
    match draws.below(4) {
        0 => {
            let double = draws.double();
            let key = ["time", "dt"][draws.below(2)];
            header["movement"][key] = json!(double.to_bits());
            format!("movement.{key} {double:e}")
        }
        1 => {
            header["movement"]["step"] = json!(number);
            format!("movement.step {number}")
        }
        2 => {
            let object = draws.below(3);
            let mut pose = [
                1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0_f64,
            ];
            let at = draws.below(12);
            pose[at] = draws.double();
            header["movement"]["outside"][object] = json!(pose.map(f64::to_bits));
            format!("pose of object {object} has {:e} at {at}", pose[at])
        }
        _ => {
            let keys = header.as_object().unwrap().keys();
            let keys: Vec<String> = keys.filter(|key| *key != "movement").cloned().collect();
            let key = &keys[draws.below(keys.len())];
            header[key] = json!(number);
            format!("{key} {number}")
        }
    }
}

/// Finds states that pass the checks of a checkpoint although steps cannot continue from them. Tests of single checks cover only
/// foreseen alterations.
#[test]
fn altered_checkpoints_are_refused_or_gone_on_from() {
    let Some(mut trial) = Trial::of("parallel") else {
        return;
    };
    for (list, (key, _)) in LISTS.iter().enumerate() {
        // Of particles in flight only earlier versions had any.
        let has_some = !trial.whole.lists[list].is_empty();
        assert_eq!(has_some, *key != "in_flight", "{key}");
    }
    let mut wrong = Vec::new();
    for (what, alteration, expected) in ALTERATIONS {
        let mut parts = trial.whole.clone();
        alteration(&mut parts);
        let refusal = trial.tried(what, &parts);
        match (expected, &refusal) {
            (None, None) => (),
            (Some(words), Some(reason)) if reason.contains(words) => (),
            _ => wrong.push(format!(
                "{what}: {expected:?} is expected, and it is {refusal:?}"
            )),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let accepted = trial.alter_at_random(1, 60);
    assert!((5..50).contains(&accepted), "{accepted} of 60");
    trial.finish();
}

/// As above, with random alterations, and with particles in any order and without any in flight.
#[test]
#[ignore = "takes minutes; make long runs it"]
fn many_altered_checkpoints_are_refused_or_gone_on_from() {
    for (seed, strategy) in (2..).zip(["parallel", "sequential", "scattered", "respawn", "none"]) {
        let Some(mut trial) = Trial::of(strategy) else {
            return;
        };
        let begun = Instant::now();
        let accepted = trial.alter_at_random(seed, 1000);
        println!(
            "{strategy}: {accepted} of 1000 altered checkpoints were accepted, {:?}",
            begun.elapsed()
        );
        trial.finish();
    }
}

/// The scene in a checkpoint may name any file as its map of areas. Without the check of what is read, this one takes all
/// memory there is, and does not end.
#[test]
#[cfg(target_os = "linux")]
fn the_scene_of_a_checkpoint_reads_no_device() {
    let folder = Folder::new();
    let scene = SCENE.replace("STRATEGY", "parallel");
    let file = folder.with("three.toml", scene.replace("builtin:maze", "/dev/zero"));
    let scene = Scene::load(&file, &Overrides::default()).unwrap();
    let whole = folder.with("whole.toml", SCENE.replace("STRATEGY", "parallel"));
    let whole = Scene::load(&whole, &Overrides::default()).unwrap();
    let setup = Setup::new(&whole).unwrap();
    let state = myxo::sim::Snapshot::start(&setup);
    let checkpoint = Checkpoint::new(&scene, &setup, state);
    let own = checkpoint.own_scene(Path::new("a.state"), &Overrides::default());
    let error = Setup::new(&own.unwrap()).unwrap_err().to_string();
    assert!(
        error.contains("cannot read /dev/zero: it is not a regular file"),
        "{error}"
    );
}
