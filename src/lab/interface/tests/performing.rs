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
