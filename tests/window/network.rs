//! The network's lines over the picture: their measures, and the state below them.

use myxo::gpu::{Context, ContextOptions, Frames};
use myxo::scene::Overrides;
use myxo::sim::Simulation;
use myxo::sim::checkpoint::Checkpoint;
use myxo::sim::graph::network_of;
use serde_json::Value;

use crate::out::arrived;
use crate::troubles::hear;
use crate::{Lab, SMALL, can_open, step};

/// A scene that has a network after 60 steps.
pub const GROWN: [&str; 3] = [
    "cube",
    "--set=particles.count=20000",
    "--set=atlas.size=192",
];

/// The step of the network that the lab has found last.
fn found(seen: &Value) -> Option<u64> {
    let numbers = seen["values"]["network"].as_str()?;
    numbers.split(' ').next()?.parse().ok()
}

/// Would catch: lines that are found once only, measures of another step or of another network than the library finds in the same state,
/// and a state that changes because it is looked at.
#[test]
fn the_network_is_that_of_the_state_which_is_the_same_without_it() {
    if !can_open() {
        return;
    }
    let lab = Lab::open(&GROWN);
    lab.click_until("network", "network", true);
    let first = lab.wait("it is found", |seen| found(seen).is_some());
    lab.grows_beyond(60);
    lab.wait("another one is found", |seen| found(seen) > found(&first));
    lab.hold();
    let seen = lab.wait("that of the present state", |seen| {
        found(seen) == Some(step(seen))
    });
    let numbers = seen["values"]["network"].as_str().map(str::to_owned);
    lab.key_until("n", "they go", "network", false);
    lab.wait("nothing is shown", |seen| found(seen).is_none());
    lab.click_until("out", "out", true);
    lab.click("out.export=Checkpoint");
    let file = arrived(&lab, "cube_000001.ckpt");
    let checkpoint = Checkpoint::read(&file).expect("it is whole");
    let state = &checkpoint.snapshot;
    assert_eq!(state.step, step(&seen));
    let scene = checkpoint.own_scene(&file, &Overrides::default());
    let scene = scene.expect("it can be opened");
    let ctx = Context::new(&ContextOptions::default()).expect("the lab has one, too");
    let mut frames = Frames::new(&ctx, 1).expect("there is memory");
    let mut simulation = Simulation::new(&ctx, &scene).expect("it runs in the lab, too");
    for _ in 0..state.step {
        let run = frames.run(|rec| simulation.record_step(rec));
        run.expect("the device is there");
    }
    let plain = simulation.snapshot().expect("the device is there");
    assert_eq!(plain.hash(), state.hash());
    let poses = simulation.world_from_object();
    let (_, measures) = network_of(&state.trail, simulation.setup(), &poses);
    assert!(measures.edges > 0, "there is a network: {measures:?}");
    let expected = format!(
        "{} {} {} {:.4} {}",
        state.step, measures.nodes, measures.edges, measures.length, measures.cycles
    );
    assert_eq!(numbers, Some(expected));
    lab.quit();
}

/// Would catch: a brush after which the lines are those of the trail before it, for as long as no step is taken.
#[test]
fn lines_follow_the_brush() {
    if !can_open() {
        return;
    }
    let lab = Lab::open(&GROWN);
    lab.grows_beyond(60);
    lab.hold();
    lab.key_until("n", "they are asked for", "network", true);
    let before = lab.wait("they are found", |seen| found(seen) == Some(step(seen)));
    lab.paint_with("trail");
    let seen = lab.wait("those of what was painted", |seen| {
        let numbers = |seen: &Value| seen["values"]["network"].as_str().map(str::to_owned);
        numbers(seen).is_some() && numbers(seen) != numbers(&before)
    });
    assert_eq!(step(&seen), step(&before), "it is held");
    lab.quit();
}

/// Would catch: lines of what is no longer there, and lines that do not come again.
#[test]
fn lines_come_again_after_a_reset_and_in_another_scene() {
    if !can_open() {
        return;
    }
    let lab = Lab::open(&SMALL);
    lab.grows_beyond(80);
    lab.key_until("n", "they are asked for", "network", true);
    lab.wait("they are found", |seen| found(seen) > Some(80));
    lab.click("reset");
    lab.wait("those from the beginning", |seen| {
        found(seen).is_some_and(|step| step <= 80)
    });
    lab.click_until("gallery", "gallery", true);
    lab.click("gallery=scenes");
    lab.click("card=sphere");
    lab.wait("those of the sphere", |seen| {
        seen["state"]["scene"] == "sphere" && found(seen).is_some()
    });
    lab.quit();
}

/// Would catch: a thread that holds the lost device, so that no other can take its place, and lines that end with the device.
#[test]
fn lines_come_again_on_another_device() {
    if !can_open() {
        return;
    }
    let lab = Lab::open(&[&["--lose-device=40"], &SMALL[..]].concat());
    lab.key_until("n", "they are asked for", "network", true);
    hear(&lab, "The device was lost");
    lab.wait("those of the other device", |seen| {
        seen["state"]["loading"] == false && found(seen).is_some()
    });
    lab.quit();
}

/// Would catch: a network of the steps of a preview, and lines that are gone after it until another network is found.
#[test]
fn lines_wait_for_the_end_of_a_preview() {
    if !can_open() {
        return;
    }
    let lab = Lab::open(&SMALL);
    lab.key_until("n", "they are asked for", "network", true);
    lab.wait("they are found", |seen| found(seen).is_some());
    lab.key_until("g", "the gallery", "gallery", true);
    lab.point("card=ribbons", 0.5);
    let previewed = lab.wait("the steps of the look", |seen| {
        seen["state"]["previewed"] == "ribbons" && seen["state"]["previewed_steps"] == true
    });
    assert_eq!(found(&previewed), None);
    lab.point("picture", 0.5);
    // In the frame in which it ends no other network can have been found.
    let seen = lab.wait("it ends", |seen| seen["state"]["runs_preview"] == false);
    let kept = seen["state"]["network_step"].as_u64();
    let kept = kept.expect("the network from before is there at once");
    // Steps of a preview do not count: this is the one at which it began.
    let begun = step(&previewed);
    assert!(kept <= begun, "of step {kept}, and it began at {begun}");
    lab.wait("its lines are there again", |seen| found(seen).is_some());
    lab.quit();
}
