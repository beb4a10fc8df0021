//! The picture alone.

use egui::{Event, Key, vec2};

use super::{Harness, IN_PICTURE};
use crate::lab::performing::POINTER_RESTS;

#[test]
fn the_picture_alone_has_no_lines_and_no_pointer_that_rests() {
    let mut harness = Harness::new();
    harness.frame(vec![Event::PointerMoved(IN_PICTURE)]);
    harness.press(Key::F10);
    assert!(!harness.places_of("Esc brings").is_empty());
    let ctx = harness.ctx.clone();
    harness.interface.notice(&ctx, "Saved a picture", false);
    harness.frame(vec![]);
    harness.frame(vec![]);
    assert!(harness.places_of("Saved").is_empty());
    harness.interface.notice(&ctx, "The disk is full", true);
    harness.frame(vec![]);
    harness.frame(vec![]);
    assert!(!harness.places_of("The disk").is_empty());
    let is_seen = |harness: &mut Harness, events| {
        harness.frame(events);
        harness.cursor != egui::CursorIcon::None
    };
    assert!(is_seen(&mut harness, vec![]));
    // Also where nothing else happens.
    assert!(
        harness.delay.as_secs_f64() <= POINTER_RESTS,
        "{:?}",
        harness.delay
    );
    harness.time += POINTER_RESTS;
    assert!(!is_seen(&mut harness, vec![]));
    let moved = Event::PointerMoved(IN_PICTURE + vec2(3.0, 0.0));
    assert!(is_seen(&mut harness, vec![moved]));
    harness.time += POINTER_RESTS;
    harness.press(Key::F10);
    assert!(
        is_seen(&mut harness, vec![]),
        "it rests, but beside a panel"
    );
}
