//! The gallery beside the picture, and what the picture previews while the pointer rests on it.

use super::*;
use crate::own_presets::OwnPresets;

/// Where the gallery has this text.
#[track_caller]
fn in_gallery(harness: &Harness, name: &str) -> Pos2 {
    let left = harness.screen.x - GALLERY_WIDTHS[1];
    let places = harness.places_of(name);
    let place = places.iter().find(|place| place.x > left);
    *place.unwrap_or_else(|| panic!("{name}: {places:?}"))
}

/// The picture of the card with this name.
#[track_caller]
fn card(harness: &Harness, name: &str) -> Pos2 {
    in_gallery(harness, name) + vec2(0.0, -40.0)
}

#[test]
fn the_gallery_opens_scenes_and_takes_presets() {
    let mut harness = Harness::new();
    harness.press(Key::G);
    (0..20).for_each(|_| drop(harness.frame(vec![])));
    let at = card(&harness, "spots");
    assert_eq!(harness.click(at), [Command::Apply]);
    assert_eq!(harness.interface.document.preset.as_deref(), Some("spots"));
    let to_scenes = in_gallery(&harness, "Scenes");
    harness.click(to_scenes);
    (0..20).for_each(|_| drop(harness.frame(vec![])));
    let at = card(&harness, "torus");
    assert_eq!(harness.click(at), [Command::Open("torus")]);
    assert!(harness.interface.layout.gallery, "others can be tried");
    harness.press(Key::Escape);
    assert!(!harness.interface.layout.gallery);
    assert_eq!(harness.frame(vec![]).picture.right(), SCREEN.x);
}

#[test]
fn looks_are_kept_and_removed_in_the_gallery() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = Harness::new();
    let picture = image::RgbaImage::new(3, 2);
    let mut own = OwnPresets::read(Some(folder.path().to_owned()));
    let text = myxo::scene::presets::to_toml(&harness.interface.document.edited, "Mine.");
    own.save("moss", &text.replace("0.95", "0.5"), &picture)
        .unwrap();
    std::fs::write(folder.path().join("torn.toml"), "[trail").unwrap();
    own.read_again();
    harness.interface.looks.own = own;
    harness.press(Key::G);
    (0..20).for_each(|_| drop(harness.frame(vec![])));
    // One preset is taken, and one cannot be.
    let at = in_gallery(&harness, "moss") + vec2(0.0, -40.0);
    assert_eq!(harness.click(at), [Command::Apply]);
    assert_eq!(harness.interface.document.preset.as_deref(), Some("moss"));
    assert_eq!(harness.interface.document.edited.trail.decay, 0.5);
    let at = in_gallery(&harness, "torn") + vec2(0.0, -40.0);
    assert_eq!(harness.click(at), []);
    let notice = harness.interface.notices.text().expect("it is said");
    assert!(notice.contains("preset torn: line 1"), "{}", notice);
    // It is removed after a question; its notice has ended.
    harness.time += 20.0;
    harness.frame(vec![]);
    let name = in_gallery(&harness, "moss");
    let is_of_card = |place: &Pos2| {
        (place.x - name.x).abs() < 130.0 && (0.0..105.0).contains(&(name.y - place.y))
    };
    let crosses = harness.places_of("✖");
    let cross = *crosses
        .iter()
        .find(|place| is_of_card(place))
        .expect("it is there");
    assert_eq!(harness.click(cross), []);
    harness.frame(vec![]);
    let at = in_gallery(&harness, "Remove");
    let removed = Command::RemovePreset("moss".to_owned());
    assert_eq!(harness.click(at), [removed]);
    // Keys that are all up again at the end of a slow frame.
    let held = |modifiers| Event::ModifiersChanged(modifiers);
    let shift = Modifiers::COMMAND.plus(Modifiers::SHIFT);
    for (modifiers, command) in [
        (shift, Command::CopyLook),
        (Modifiers::COMMAND, Command::Copy),
    ] {
        let events = vec![held(modifiers), Event::Copy, held(Modifiers::NONE)];
        assert_eq!(harness.frame(events).commands, [command]);
    }
    // The steps go round all that can be taken.
    harness.press(Key::Escape);
    harness.interface.document.preset = None;
    harness.press(Key::OpenBracket);
    assert_eq!(harness.interface.document.preset.as_deref(), Some("moss"));
    harness.press(Key::CloseBracket);
    assert_eq!(
        harness.interface.document.preset.as_deref(),
        Some("network")
    );
}

/// Would catch: a preview that changes the document, that comes without a wait or does not end, or that a click leaves behind.
#[test]
fn a_look_under_the_pointer_is_previewed_and_changes_nothing() {
    let mut harness = Harness::new();
    harness.press(Key::G);
    (0..20).for_each(|_| drop(harness.frame(vec![])));
    let document = |harness: &Harness| {
        let document = &harness.interface.document;
        (document.edited.clone(), document.view)
    };
    let before = document(&harness);
    let at = card(&harness, "ribbons");
    harness.frame(vec![Event::PointerMoved(at)]);
    assert_eq!(harness.interface.previewed_look(), None, "it may pass by");
    let delay = harness.delay.as_secs_f64();
    assert!(delay < 0.2, "it is shown though nothing comes in: {delay}");
    harness.time += 0.2;
    assert_eq!(harness.frame(vec![]).commands, []);
    let look = harness.interface.previewed_look().expect("it rests");
    let text = myxo::scene::builtin::preset("ribbons")
        .expect("it is there")
        .text;
    let wanted = with_preset(&before.0, "ribbons", text).expect("it is right");
    assert_eq!(
        (look.name.as_str(), look.settings),
        ("ribbons", wanted.clone())
    );
    let colors = wanted.picture.color_map;
    assert_ne!(colors, before.1.color_map);
    assert_eq!(harness.interface.shown_view().color_map, colors);
    harness.frame(vec![]);
    let comes = "Preview of ribbons: its steps are being computed";
    assert_eq!(harness.places_of(comes).len(), 1);
    harness.facts.steps_of = Some("ribbons".to_owned());
    harness.frame(vec![]);
    assert_eq!(harness.places_of("Preview of ribbons").len(), 1);
    assert_eq!(harness.places_of(comes).len(), 0);
    harness.facts.only_colors = Some("it is large");
    harness.frame(vec![]);
    assert_eq!(
        harness.places_of("Colours of ribbons (it is large)").len(),
        1
    );
    // The next look comes at once.
    let next = card(&harness, "spots");
    harness.frame(vec![Event::PointerMoved(next)]);
    harness.frame(vec![]);
    assert_eq!(harness.interface.preview.look(), Some("spots"));
    // The steps are still those of the one before.
    harness.facts.only_colors = None;
    harness.frame(vec![]);
    let comes = "Preview of spots: its steps are being computed";
    assert_eq!(harness.places_of(comes).len(), 1);
    // The picture alone is looked at.
    harness.frame(vec![Event::PointerMoved(IN_PICTURE)]);
    harness.frame(vec![]);
    assert_eq!(harness.interface.previewed_look(), None);
    assert_eq!(document(&harness), before);
    assert_eq!(harness.interface.shown_view(), before.1);
    // A click takes the look, and the picture shows what is.
    harness.time += 1.0;
    harness.frame(vec![Event::PointerMoved(next)]);
    harness.time += 0.2;
    harness.frame(vec![]);
    assert_eq!(harness.click(next), [Command::Apply]);
    harness.time += 1.0;
    harness.frame(vec![]);
    assert_eq!(harness.interface.previewed_look(), None);
    assert_eq!(harness.interface.document.preset.as_deref(), Some("spots"));
    // What closes the gallery ends a preview.
    harness.frame(vec![Event::PointerMoved(at)]);
    harness.time += 0.2;
    harness.frame(vec![]);
    assert!(harness.interface.previewed_look().is_some());
    harness.press(Key::G);
    assert_eq!(harness.interface.previewed_look(), None);
}

/// Would catch: colours that stay previewed, and a list that takes them over without a click.
#[test]
fn colours_under_the_pointer_are_previewed() {
    let mut harness = Harness::new();
    let before = harness.interface.document.view.color_map;
    // The name of the program stands above.
    let list = harness.places_of(before.word()).pop();
    harness.click(list.expect("it is there"));
    (0..20).for_each(|_| drop(harness.frame(vec![])));
    let [at] = harness.places_of("ice")[..] else {
        panic!("{:?}", harness.places_of("ice"))
    };
    harness.frame(vec![Event::PointerMoved(at)]);
    harness.frame(vec![]);
    assert_eq!(harness.interface.shown_view().color_map, ColorMap::Ice);
    assert_eq!(harness.interface.document.view.color_map, before);
    harness.frame(vec![Event::PointerMoved(IN_PICTURE)]);
    harness.frame(vec![]);
    assert_eq!(harness.interface.shown_view().color_map, before);
    harness.click(at);
    assert_eq!(harness.interface.document.view.color_map, ColorMap::Ice);
    harness.frame(vec![Event::PointerMoved(IN_PICTURE)]);
    harness.frame(vec![]);
    assert_eq!(harness.interface.shown_view().color_map, ColorMap::Ice);
}

/// Would catch: a morph that takes more than one entry, that swallows the entry of the one before, or whose undo comes again half
/// way.
#[test]
fn looks_change_slowly_by_default_and_each_is_one_entry_to_undo() {
    assert_eq!(Looks::default().morph_seconds, 2.0);
    let mut harness = Harness::new();
    harness.interface.looks.morph_seconds = 2.0;
    let start = harness.interface.document.look();
    let names = ["network", "cells"];
    let looks = names.map(|name| {
        let text = myxo::scene::builtin::preset(name)
            .expect("it is there")
            .text;
        with_preset(&start, name, text).expect("it is right")
    });
    harness.press(Key::CloseBracket);
    harness.time += 0.5;
    harness.frame(vec![]);
    assert_ne!(harness.interface.document.look(), looks[0], "on the way");
    // The next one begins before this one is there, and is undone before it is there.
    harness.press(Key::CloseBracket);
    harness.time += 0.5;
    harness.frame(vec![]);
    let mut commands = Vec::new();
    for (again, wanted) in [
        (false, &looks[0]),
        (false, &start),
        (true, &looks[0]),
        (true, &looks[1]),
    ] {
        match again {
            false => harness.interface.undo(&mut commands),
            true => harness.interface.redo(&mut commands),
        }
        assert!(harness.interface.document.morph.is_none());
        let look = harness.interface.document.look();
        assert_eq!(look.physarum, wanted.physarum);
        assert_eq!(look.picture.color_map, wanted.picture.color_map);
    }
    assert!(!harness.interface.document.undo.can_redo());
    assert_eq!(harness.interface.document.preset.as_deref(), Some("cells"));
}
