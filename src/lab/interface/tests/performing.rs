//! The picture alone.

use egui::{Event, Key, vec2};

use crate::lab::interface::tests::{Harness, IN_PICTURE};
use crate::lab::layout::POINTER_RESTS;

#[test]
fn the_picture_alone_has_no_lines_and_no_pointer_that_rests() {
    let mut harness = Harness::new();
    harness.frame(vec![Event::PointerMoved(IN_PICTURE)]);
    harness.press(Key::F10);
    assert!(!harness.places_of("Esc brings").is_empty());
    let ctx = harness.ctx.clone();
    harness
        .interface
        .notices
        .say(&ctx, "Saved a picture", false);
    harness.frame(vec![]);
    harness.frame(vec![]);
    assert!(harness.places_of("Saved").is_empty());
    harness
        .interface
        .notices
        .say(&ctx, "The disk is full", true);
    harness.frame(vec![]);
    harness.frame(vec![]);
    assert!(!harness.places_of("The disk").is_empty());
    let is_seen = |harness: &mut Harness, events| {
        harness.frame(events);
        harness.cursor != egui::CursorIcon::None
    };
    assert!(is_seen(&mut harness, vec![]));
    harness.time += 10.0;
    assert!(!is_seen(&mut harness, vec![]));
    let moved = Event::PointerMoved(IN_PICTURE + vec2(3.0, 0.0));
    assert!(is_seen(&mut harness, vec![moved]));
    // Also where nothing else happens.
    let delay = delay_at_rest(&mut harness);
    assert!((1.0..POINTER_RESTS).contains(&delay), "{delay}");
    harness.time += POINTER_RESTS;
    harness.press(Key::F10);
    assert!(
        is_seen(&mut harness, vec![]),
        "it rests, but beside a panel"
    );
}

#[test]
fn news_go_also_where_nothing_happens() {
    let mut harness = Harness::new();
    let ctx = harness.ctx.clone();
    harness.interface.notices.say(&ctx, "Saved", false);
    let delay = delay_at_rest(&mut harness);
    assert!((2.0..3.3).contains(&delay), "{delay}");
    harness.time += delay + 0.1;
    harness.frame(vec![]);
    assert!(harness.places_of("Saved").is_empty());
}

/// The delay of the next frame after all animations have ended, half a second later.
fn delay_at_rest(harness: &mut Harness) -> f64 {
    (0..30).for_each(|_| drop(harness.frame(vec![])));
    harness.delay.as_secs_f64()
}

/// Would catch: an autopilot that stands still, that leaves entries of the camera to undo, that an input does not end, or whose key
/// begins it again; and one that turns an atlas.
#[test]
fn the_autopilot_drifts_until_any_input() {
    let mut harness = Harness::new();
    harness.interface.document.playing = false;
    let before = harness.interface.document.view.camera;
    harness.press(Key::A);
    assert!(harness.interface.autopilot.is_on() && harness.interface.layout.alone);
    assert!(harness.interface.document.playing);
    let mut looks = std::collections::BTreeSet::new();
    for _ in 0..120 {
        harness.time += 0.5;
        harness.frame(vec![]);
        looks.extend(harness.interface.document.preset.clone());
    }
    assert_eq!(looks.len(), 4, "{looks:?}");
    let after = harness.interface.document.view.camera;
    assert!(after.yaw != before.yaw && after.pitch == before.pitch);
    assert_eq!(harness.interface.looks.morph_seconds, 0.0, "the user's own");
    // Its key ends it, as every input does.
    harness.press(Key::A);
    assert!(!harness.interface.autopilot.is_on() && !harness.interface.layout.alone);
    (0..40).for_each(|_| drop(harness.frame(vec![])));
    let rests = harness.interface.document.view.camera;
    let mut commands = Vec::new();
    harness.interface.undo(&mut commands);
    assert_eq!(harness.interface.document.view.camera, rests, "looks alone");
    // The picture that was alone before stays alone.
    harness.press(Key::F10);
    harness.press(Key::Num0);
    let atlas = harness.interface.document.view;
    harness.press(Key::A);
    (0..10).for_each(|_| drop(harness.frame(vec![])));
    assert!(harness.interface.autopilot.is_on());
    assert_eq!(harness.interface.document.view.camera, atlas.camera);
    harness.frame(vec![Event::PointerMoved(IN_PICTURE)]);
    harness.frame(vec![Event::PointerMoved(IN_PICTURE + vec2(40.0, 0.0))]);
    assert!(!harness.interface.autopilot.is_on() && harness.interface.layout.alone);
}
