//! The way back to an earlier state: a button and the gallery offer it if there is one.

use super::*;
use crate::lab::facts::Before;
use crate::lab::layout::PANEL_WIDTH;

#[test]
fn an_earlier_state_comes_back_by_a_button_and_in_the_gallery() {
    let mut harness = Harness::new();
    assert_eq!(harness.places_of("↶").len(), 0, "there is nothing yet");
    harness.facts.before = Some(Before {
        name: "cube".to_owned(),
        step: 1234,
    });
    harness.frame(vec![]);
    let [at] = harness.places_of("step 1,234")[..] else {
        panic!("{:?}", harness.places_of("↶"))
    };
    assert_eq!(harness.click(at), [Command::GoBack]);
    // Also where no scene was left with changes.
    assert!(harness.interface.gallery.kept.all().is_empty());
    harness.press(Key::G);
    harness.frame(vec![]);
    let at = harness.places_of("Files")[0];
    harness.click(at);
    (0..20).for_each(|_| drop(harness.frame(vec![])));
    let [at] = harness.places_of("cube · step 1,234")[..] else {
        panic!("{:?}", harness.places_of("↶"))
    };
    assert_eq!(harness.click(at), [Command::GoBack]);
}

#[test]
fn the_way_back_keeps_to_the_panel() {
    let mut harness = Harness::new();
    harness.facts.before = Some(Before {
        name: "cube".to_owned(),
        step: 1_234_567,
    });
    harness.facts.step = 12_345_678;
    harness.facts.steps_per_second = 1234.5;
    harness.facts.seconds = Some(12_345.6);
    harness.frame(vec![]);
    let [at] = harness.places_of("↶")[..] else {
        panic!("{:?}", harness.places_of("↶"))
    };
    assert!(at.x < PANEL_WIDTH - 12.0, "{at}");
    assert_eq!(harness.click(at), [Command::GoBack]);
}
