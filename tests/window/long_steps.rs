//! Scenes whose steps take longer than a user would wait for an answer.

use serde_json::Value;

use crate::input::Gesture;
use crate::{Lab, can_open};

/// Enough particles with walking sensors to keep any CPU busy.
const SLOW: [&str; 5] = [
    "torus",
    "--set=particles.count=3000000",
    "--set=physarum.sensing=walk",
    "--set=atlas.size=256",
    "--set=trail.decay=0.9",
];

fn number(seen: &Value, name: &str) -> u64 {
    seen["state"][name].as_u64().expect("it is a number")
}

#[test]
fn the_window_answers_within_a_long_step_and_applies_changes_after_it() {
    if !can_open() {
        return;
    }
    let device = myxo::gpu::Context::new(&myxo::gpu::ContextOptions::default());
    let device = device.expect("the lab has one, too");
    let is_slow = device.info().kind == myxo::gpu::DeviceKind::Cpu;
    drop(device);
    let lab = Lab::open(&SLOW);

    // The help comes and goes, and steps continue meanwhile.
    let before = lab.seen().expect("the lab has reported");
    for is_open in [true, false, true, false] {
        lab.key_until("F1", "the help", "help", is_open);
    }
    lab.wait("steps continue", |seen| {
        number(seen, "step") > number(&before, "step") + 2
    });

    // Text arrives letter by letter, and the simulation takes the number over.
    lab.find("trail.decay");
    lab.type_until("trail.decay", 0.9, "0.625", "trail.decay", "0.625");
    assert_eq!(lab.save("torus").trail.decay, 0.625);

    // Another size of the picture, and a pointer that moves all the time.
    lab.key_until("p", "the panel goes", "panel", false);
    let begun = number(&lab.seen().expect("the lab has reported"), "step");
    lab.point("picture", 0.4);
    for _ in 0..60 {
        lab.perform(Gesture::MoveBy(2, 1));
    }
    let seen = lab.wait("steps continue", |seen| number(seen, "step") > begun + 1);
    if is_slow {
        assert!(number(&seen, "answers_within_steps") > 3, "{seen:?}");
    }

    // The lab can be closed in the middle of a step, too.
    lab.quit();
}
