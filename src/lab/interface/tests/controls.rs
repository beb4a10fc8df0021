//! Undo, looks, the gallery, loading, and numbers that are typed.

use myxo::sim::types::{Flow, Population};

use super::*;
use crate::lab::facts::{LoadingFacts, Times};
use crate::lab::job::Progress;
use crate::lab::tools::Tool;
use crate::own_presets::with_preset;

#[test]
fn changes_are_undone_and_redone_by_keys() {
    let mut harness = Harness::new();
    let first = harness.interface.document.edited.clone();
    for decay in [0.5, 0.6] {
        harness.interface.document.edited.trail.decay = decay;
        harness.frame(vec![]);
    }
    let pressed = |harness: &mut Harness, modifiers, key| {
        let event = |pressed| Event::Key {
            key,
            physical_key: None,
            pressed,
            repeat: false,
            modifiers,
        };
        harness.frame(vec![Event::ModifiersChanged(modifiers)]);
        let commands = harness.frame(vec![event(true)]).commands;
        harness.frame(vec![event(false), Event::ModifiersChanged(Modifiers::NONE)]);
        commands
    };
    let control = Modifiers::CTRL.plus(Modifiers::COMMAND);
    for expected in [0.5, first.trail.decay] {
        assert_eq!(pressed(&mut harness, control, Key::Z), [Command::Apply]);
        assert_eq!(harness.interface.document.edited.trail.decay, expected);
    }
    assert_eq!(
        pressed(&mut harness, control, Key::Z),
        [],
        "nothing is left"
    );
    assert_eq!(harness.interface.document.edited, first);
    let shift = control.plus(Modifiers::SHIFT);
    assert_eq!(pressed(&mut harness, shift, Key::Z), [Command::Apply]);
    assert_eq!(harness.interface.document.edited.trail.decay, 0.5);
    assert_eq!(pressed(&mut harness, control, Key::S), [Command::Save]);
    assert!(harness.interface.document.playing, "S alone would hold it");
}

#[test]
fn a_dialog_that_opens_files_has_the_keys_to_itself() {
    let mut harness = Harness::new();
    let control = Modifiers::CTRL.plus(Modifiers::COMMAND);
    let pressed = |key, modifiers| Event::Key {
        key,
        physical_key: None,
        pressed: true,
        repeat: false,
        modifiers,
    };
    harness.press(Key::B);
    harness.frame(vec![Event::ModifiersChanged(control)]);
    harness.frame(vec![pressed(Key::O, control)]);
    harness.frame(vec![Event::ModifiersChanged(Modifiers::NONE)]);
    assert!(harness.interface.opening.is_open());
    harness.frame(vec![]);
    assert!(!harness.places_of("Open a file").is_empty());
    let view = harness.interface.document.view;
    for key in [Key::F10, Key::F12, Key::Delete] {
        assert_eq!(harness.press(key), [], "{key:?}");
    }
    harness.frame(vec![Event::Paste("[trail]\ndecay = 0.5\n".to_owned())]);
    assert_eq!(harness.click(IN_PICTURE), []);
    assert_eq!(harness.interface.document.view, view);
    assert!(!harness.interface.layout.alone);
    // The dialog closes, and the brush stays selected.
    harness.press(Key::Escape);
    assert!(!harness.interface.opening.is_open());
    assert_ne!(harness.interface.tools.tool, Tool::Look);
    assert_eq!(harness.press(Key::F12), [Command::Screenshot]);
}

#[test]
fn presets_are_taken_by_keys_at_once_or_slowly() {
    let mut harness = Harness::new();
    let first = &myxo::scene::builtin::PRESETS[0];
    let second = &myxo::scene::builtin::PRESETS[1];
    // The scene has the look of none: before comes the last one, and behind that the first.
    assert_eq!(harness.interface.document.preset, None);
    assert_eq!(harness.press(Key::OpenBracket), [Command::Apply]);
    let last = myxo::scene::builtin::PRESETS.last().map(|last| last.name);
    assert_eq!(harness.interface.document.preset.as_deref(), last);
    assert_eq!(harness.press(Key::CloseBracket), [Command::Apply]);
    assert_eq!(
        harness.interface.document.preset.as_deref(),
        Some(first.name)
    );
    harness.interface.looks.morph_seconds = 1.0;
    let to = with_preset(&harness.interface.document.edited, second.name, second.text);
    let mut to = to.expect("it is right");
    // Colours are the picture's, and come at once.
    let colours = std::mem::replace(
        &mut to.picture.color_map,
        harness.interface.document.edited.picture.color_map,
    );
    harness.press(Key::CloseBracket);
    assert_eq!(harness.interface.document.view.color_map, colours);
    assert_ne!(harness.interface.document.edited, to, "on the way");
    harness.time += 0.5;
    assert_eq!(harness.frame(vec![]).commands, [Command::Apply]);
    harness.time += 0.6;
    assert_eq!(harness.frame(vec![]).commands, [Command::Apply]);
    assert_eq!(harness.interface.document.edited, to);
    assert_eq!(harness.frame(vec![]).commands, [], "it has arrived");
    harness.interface.looks.morph_seconds = 0.0;
    assert_eq!(harness.press(Key::OpenBracket), [Command::Apply]);
    assert_eq!(
        harness.interface.document.preset.as_deref(),
        Some(first.name)
    );
    let before = harness.interface.document.edited.clone();
    // With Shift or Alt it is another program's key.
    for modifiers in [Modifiers::SHIFT, Modifiers::ALT] {
        let event = Event::Key {
            key: Key::D,
            physical_key: None,
            pressed: true,
            repeat: false,
            modifiers,
        };
        assert_eq!(harness.frame(vec![event]).commands, []);
        assert_eq!(harness.interface.document.edited, before);
    }
    assert_eq!(harness.press(Key::D), [Command::Apply]);
    assert_ne!(harness.interface.document.edited, before);
    assert_eq!(harness.interface.document.preset, None);
}

#[test]
fn a_scene_that_has_the_look_of_a_preset_is_shown_with_its_name() {
    for preset in &myxo::scene::builtin::PRESETS[..3] {
        let taken = with_preset(&Settings::default(), preset.name, preset.text);
        let mut settings = taken.expect("it is right");
        let of = |settings: &Settings| {
            let settings = settings.clone();
            let scene = Scene::from_settings("torus".to_owned(), settings, ".".into());
            Interface::new(&scene.expect("it is right")).document.preset
        };
        assert_eq!(of(&settings).as_deref(), Some(preset.name));
        settings.particles.count = 1234;
        assert_eq!(of(&settings).as_deref(), Some(preset.name));
        settings.trail.decay = 0.123;
        assert_eq!(of(&settings), None, "{}", preset.name);
    }
}

#[test]
fn things_are_taken_out_by_keys_and_buttons() {
    let mut harness = Harness::new();
    let record = Command::Export(ExportRequest::Record);
    assert_eq!(harness.press(Key::F9), std::slice::from_ref(&record));
    harness.interface.layout.toggle(Card::Exports);
    for _ in 0..3 {
        harness.frame(vec![]);
    }
    let place = |harness: &Harness, words: &str| {
        let places = harness.places_of(words);
        let place = places.iter().find(|place| place.x > 340.0);
        *place.unwrap_or_else(|| panic!("{words}: {places:?}"))
    };
    for (words, command) in [
        ("📷 Save picture", Command::Screenshot),
        ("⏺ Record", record),
        ("🎬 Film 300 frames", Command::Export(ExportRequest::Film)),
        (
            "NPZ",
            Command::Export(ExportRequest::Export(crate::lab::command::Model::Npz)),
        ),
    ] {
        let at = place(&harness, words);
        assert_eq!(harness.click(at), [command], "{words}");
    }
    // The panel shows the work under way, and a second export waits for the first.
    harness.facts.exports.recording = Some(crate::lab::facts::Recorded {
        seconds: 65.0,
        frames: 1950,
        different: 1900,
        dropped: 3,
        is_ending: false,
    });
    harness.facts.exports.making = Some(crate::lab::facts::Making {
        name: "film_000001.mp4".to_owned(),
        doing: "frame 7 of 300".to_owned(),
        done: Some(0.02),
        can_finish: true,
        is_cancelled: false,
    });
    for _ in 0..3 {
        harness.frame(vec![]);
    }
    for words in [
        "1:05  1950 frames",
        "1900 different, 50 repeated",
        "3 dropped",
        "film_000001.mp4",
        "frame 7",
        "■ Stop",
    ] {
        place(&harness, words);
    }
    let at = place(&harness, "🎬 Film 300 frames");
    assert_eq!(harness.click(at), [], "one thing at a time");
    let at = place(&harness, "Cancel");
    assert_eq!(harness.click(at), [Command::Export(ExportRequest::Cancel)]);
    let at = place(&harness, "Finish now");
    assert_eq!(harness.click(at), [Command::Export(ExportRequest::Finish)]);
    harness.press(Key::Escape);
    assert!(!harness.interface.layout.shows(Card::Exports));
}

#[test]
fn the_picture_can_be_alone() {
    let mut harness = Harness::new();
    for tool in [Tool::Look, Tool::Trail, Tool::Food] {
        harness.interface.tools.tool = tool;
        harness.interface.tools.selected = Some(0);
        harness.press(Key::F10);
        let picture = harness.frame(vec![]).picture;
        assert_eq!((picture.min, picture.size()), (Pos2::ZERO, SCREEN));
        let said = harness.interface.notices.text();
        assert_eq!(said.as_deref(), Some("Esc brings the panel back"));
        assert_eq!(harness.interface.tools.selected, None);
        // Esc does so with every tool.
        harness.press(Key::Escape);
        assert!(harness.frame(vec![]).picture.left() > 300.0);
        assert_eq!(harness.interface.tools.tool, tool);
    }
    harness.interface.tools.tool = Tool::Look;
    assert_eq!(harness.press(Key::F11), [Command::FullScreen]);
    let dark = harness.ctx.theme();
    harness.press(Key::T);
    assert!(harness.interface.layout.light && harness.ctx.theme() != dark);
}

#[test]
fn times_are_exported_as_they_are_shown() {
    let mut harness = Harness::new();
    harness.facts.has_timestamps = true;
    harness.interface.panel.filter = "kernels".to_owned();
    (0..3).for_each(|_| drop(harness.frame(vec![])));
    let click = |harness: &mut Harness, name: &str| {
        let place = harness.places_of(name)[0];
        harness.click(place)
    };
    assert!(click(&mut harness, "Export").is_empty(), "there are none");
    harness.facts.times.step_ms = Some(2.0);
    assert_eq!(click(&mut harness, "Export"), [Command::SaveTimes]);
    assert_eq!(click(&mut harness, "Freeze"), [Command::FreezeTimes(true)]);
    // What is frozen has times, whatever comes; and none, if it was frozen before there were any.
    harness.facts.frozen = Some(std::mem::take(&mut harness.facts.times));
    assert_eq!(click(&mut harness, "Export"), [Command::SaveTimes]);
    harness.facts.times.step_ms = Some(2.0);
    harness.facts.frozen = Some(Times::default());
    assert!(click(&mut harness, "Export").is_empty());
    assert_eq!(click(&mut harness, "Freeze"), [Command::FreezeTimes(false)]);
}

#[test]
fn progress_of_a_load_is_shown_and_it_can_be_cancelled() {
    let mut harness = Harness::new();
    let progress = Progress {
        doing: "packing charts",
        done: 0.4,
        is_cancelled: false,
    };
    let loading = |progress| {
        let name = "gears".to_owned();
        Some(LoadingFacts {
            name,
            progress,
            is_shown: false,
        })
    };
    harness.facts.loading = loading(progress);
    for _ in 0..2 {
        harness.frame(vec![]);
    }
    assert_eq!(harness.places_of("packing charts").len(), 1);
    assert_eq!(harness.press(Key::Escape), [Command::CancelLoading]);
    let [cancel] = harness.places_of("Cancel")[..] else {
        panic!("{:?}", harness.places_of("Cancel"));
    };
    assert_eq!(harness.click(cancel), [Command::CancelLoading]);
    harness.facts.loading = loading(Progress {
        is_cancelled: true,
        ..progress
    });
    harness.frame(vec![]);
    assert_eq!(harness.click(cancel), [], "once is enough");
    assert_eq!(harness.places_of("ending").len(), 1);
}

/// With one object, no particle changes objects.
#[test]
fn what_has_no_effect_cannot_be_turned() {
    let mut harness = Harness::new();
    harness.interface.panel.filter = "transfer strategy".to_owned();
    for _ in 0..30 {
        harness.frame(vec![]);
    }
    let direct = |harness: &Harness| match harness.places_of("direct")[..] {
        [place] => place,
        _ => panic!("{:?}", harness.places_of("direct")),
    };
    let at = direct(&harness);
    assert_eq!(harness.click(at), []);
    let object = harness.interface.document.edited.objects[0].clone();
    harness.interface.document.edited.objects.push(object);
    for _ in 0..2 {
        harness.frame(vec![]);
    }
    let at = direct(&harness);
    assert_eq!(harness.click(at), [Command::Apply]);
    let strategy = harness.interface.document.edited.transfer.strategy;
    assert_eq!(strategy, Strategy::Direct);
}

/// By a right click on its name.
#[test]
fn a_row_goes_back_to_the_scene_or_to_the_default() {
    let mut harness = Harness::new();
    harness.interface.document.loaded.trail.decay = 0.75;
    harness.interface.document.edited.trail.decay = 0.5;
    harness.interface.panel.filter = "trail.decay".to_owned();
    let default = Settings::default().trail.decay;
    for (words, decay) in [
        ("As in the scene (0.75)", 0.75),
        (&format!("Default ({default})"), default),
    ] {
        (0..30).for_each(|_| drop(harness.frame(vec![])));
        let at = harness.places_of("Trail decay")[0];
        let event = |pressed| Event::PointerButton {
            pos: at,
            button: PointerButton::Secondary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        harness.frame(vec![Event::PointerMoved(at)]);
        harness.frame(vec![event(true)]);
        harness.frame(vec![event(false)]);
        (0..3).for_each(|_| drop(harness.frame(vec![])));
        let places = harness.places_of(words);
        let at = *places.first().unwrap_or_else(|| panic!("{words}"));
        assert_eq!(harness.click(at), [Command::Apply]);
        assert_eq!(harness.interface.document.edited.trail.decay, decay);
    }
}

/// A row that appears above a number does not take the keyboard from it.
#[test]
fn a_number_that_restarts_can_be_typed_to_its_end() {
    let mut harness = Harness::new();
    harness.interface.panel.filter = "particle count".to_owned();
    for _ in 0..30 {
        harness.frame(vec![]);
    }
    // The line of facts below shows it, too.
    let places = harness.places_of("500,000");
    let number = places.iter().find(|place| place.y < 0.9 * SCREEN.y);
    harness.click(*number.unwrap_or_else(|| panic!("{places:?}")));
    for digit in ["1", "2", "0", "0"] {
        harness.frame(vec![Event::Text(digit.to_owned())]);
        harness.frame(vec![]);
    }
    // Keys that edit text do nothing else meanwhile.
    assert!(harness.press(Key::S).is_empty() && harness.interface.document.playing);
    assert!(matches!(harness.press(Key::F12)[..], [Command::Screenshot]));
    assert_eq!(harness.interface.document.edited.particles.count, 500_000);
    // A save has the number as it stands.
    let held = Modifiers::COMMAND;
    let commands = harness.press_with(held, Key::S);
    assert_eq!(commands[0], Command::Save, "{commands:?}");
    assert_eq!(harness.interface.document.edited.particles.count, 1200);
    assert!(harness.interface.document.is_pending());
    for (key, count) in [(Key::Z, 500_000), (Key::Y, 1200)] {
        harness.press_with(held, key);
        assert_eq!(
            harness.interface.document.edited.particles.count, count,
            "{key:?}"
        );
    }
}

/// Though its first digit alone would be too little.
#[test]
fn a_number_with_a_least_value_can_be_typed() {
    let mut harness = Harness::new();
    harness.interface.panel.filter = "atlas size".to_owned();
    for _ in 0..30 {
        harness.frame(vec![]);
    }
    let [number] = harness.places_of("1024")[..] else {
        panic!("{:?}", harness.places_of("1024"));
    };
    harness.click(number);
    for digit in ["5", "1", "2"] {
        harness.frame(vec![Event::Text(digit.to_owned())]);
        harness.frame(vec![]);
    }
    harness.press(Key::Enter);
    assert_eq!(harness.interface.document.edited.atlas.size, 512);
    // A value below the minimum becomes the minimum.
    harness.frame(vec![]);
    let [number] = harness.places_of("512")[..] else {
        panic!("{:?}", harness.places_of("512"));
    };
    harness.click(number);
    harness.frame(vec![Event::Text("3".to_owned())]);
    harness.press(Key::Enter);
    assert_eq!(harness.interface.document.edited.atlas.size, 16);
}

/// The picture is 336 points narrower than the window.
#[test]
fn the_list_of_controls_is_clear_of_the_bar_of_tools() {
    for width in [1600.0, 1000.0, 960.0, 900.0, 760.0] {
        let mut harness = Harness::new();
        harness.screen = vec2(width, 700.0);
        harness.press(Key::H);
        (0..30).for_each(|_| drop(harness.frame(vec![])));
        let [list, bar] = ["list of controls", "tools"].map(|name| {
            let rect = harness.ctx.memory(|memory| memory.area_rect(name));
            rect.unwrap_or_else(|| panic!("{name} at {width}"))
        });
        let picture = harness.frame(vec![]).picture;
        assert!(picture.contains_rect(list), "{width}: {list}");
        assert!(list.right() < bar.left(), "{width}: {list}, {bar}");
        let has_room = width < 1000.0 || list.width() > 450.0;
        assert!(has_room, "{width}: {list}");
    }
}

#[test]
fn a_card_over_the_picture_closes_the_others() {
    let mut harness = Harness::new();
    let open = |harness: &Harness| {
        let cards = [Card::Help, Card::Exports];
        cards.map(|card| harness.interface.layout.shows(card))
    };
    harness.press(Key::H);
    assert_eq!(open(&harness), [true, false]);
    // The gallery is beside the picture.
    harness.press(Key::G);
    assert_eq!(open(&harness), [true, false]);
    harness.interface.layout.toggle(Card::Exports);
    harness.frame(vec![]);
    assert_eq!(open(&harness), [false, true]);
    harness.press(Key::H);
    assert_eq!(open(&harness), [true, false]);
    harness.press(Key::H);
    assert_eq!(open(&harness), [false; 2]);
}

#[test]
fn unsaved_changes_are_marked_until_they_are_saved() {
    let mut harness = Harness::new();
    assert!(!harness.interface.document.is_unsaved());
    harness.interface.document.edited.trail.decay = 0.5;
    assert!(harness.interface.document.is_unsaved());
    harness.frame(vec![]);
    let now = harness.interface.document.state_to_save();
    harness.interface.document.saved(Some(now));
    assert!(!harness.interface.document.is_unsaved());
    harness.interface.document.view.background = glam::Vec3::X;
    harness.frame(vec![]);
    assert!(
        harness.interface.document.is_unsaved(),
        "a look is one's own, too"
    );
    harness.interface.undo(&mut Vec::new());
    assert!(!harness.interface.document.is_unsaved());
    harness.interface.document.view.camera.yaw += 1.0;
    assert!(
        !harness.interface.document.is_unsaved(),
        "a turn of the camera is no change"
    );
    // A file that was asked for before a change has not that one; what came from the clipboard is in none.
    let before = harness.interface.document.state_to_save();
    harness.interface.document.edited.trail.decay = 0.6;
    harness.interface.document.saved(Some(before));
    assert!(harness.interface.document.is_unsaved());
    harness.interface.document.saved(None);
    harness.interface.undo(&mut Vec::new());
    assert!(harness.interface.document.is_unsaved());
}

/// The advice for a full transfer buffer is shown without hovering.
#[test]
fn the_panel_says_how_large_the_transfer_buffer_must_be() {
    let mut harness = Harness::new();
    harness.interface.document.running.transfer.buffer_size = 16;
    let mut says = |refused, most_wanted, text: &str| {
        harness.facts.flow = Flow {
            refused,
            most_wanted,
            ..Flow::default()
        };
        harness.frame(vec![]);
        harness.frame(vec![]);
        assert_eq!(harness.places_of(text).len(), 1, "{text}");
    };
    says(
        11_812,
        23_456,
        "11,812 found the transfer buffer full: raise its size to 23,456",
    );
    says(
        u32::MAX,
        16,
        "4,294,967,295 or more found the transfer buffer full: it is large enough now",
    );
    harness.facts.flow = Flow::default();
    harness.frame(vec![]);
    harness.frame(vec![]);
    assert_eq!(harness.places_of("0 found"), []);
}

/// A population that changes shows how, and what to do where there is no room.
#[test]
fn the_panel_counts_births_and_deaths() {
    let mut harness = Harness::new();
    harness.frame(vec![]);
    assert_eq!(harness.places_of("0 births, 0 deaths"), []);
    harness.interface.document.running.population.frequency = 5;
    harness.facts.population = Some(Population {
        births: 1234,
        deaths: 56,
        refused: 78,
        ..Population::default()
    });
    harness.frame(vec![]);
    harness.frame(vec![]);
    for text in [
        "1234 births, 56 deaths",
        "78 did not divide for want of room: raise the capacity from 2,000,000",
    ] {
        assert_eq!(harness.places_of(text).len(), 1, "{text}");
    }
}

#[test]
fn errors_stay_until_they_are_clicked_away() {
    let mut harness = Harness::new();
    let ctx = harness.ctx.clone();
    for number in 0..6 {
        (harness.interface.notices).say(&ctx, format!("it {number} is wrong"), true);
        harness.interface.notices.say(&ctx, "something came", false);
    }
    let errors = |numbers: &[u32]| {
        let lines: Vec<_> = numbers.iter().map(|n| format!("it {n} is wrong")).collect();
        Some(lines.join("\n"))
    };
    let news = format!("{}\nsomething came", errors(&[2, 3, 4, 5]).unwrap());
    assert_eq!(harness.interface.notices.text(), Some(news));
    // They stay where they are when the news goes, in each frame.
    (0..3).for_each(|_| drop(harness.frame(vec![])));
    let above = harness.places_of("something came")[0];
    let at = harness.places_of("it 5 is wrong")[0];
    assert!(above.y < harness.places_of("it 2 is wrong")[0].y && above.y > 0.0);
    harness.time += 1000.0;
    for _ in 0..3 {
        harness.frame(vec![]);
        assert_eq!(harness.places_of("it 5 is wrong"), [at]);
    }
    assert_eq!(harness.places_of("something came"), []);
    assert_eq!(harness.interface.notices.text(), errors(&[2, 3, 4, 5]));
    harness.interface.notices.say(&ctx, "it 3 is wrong", true);
    assert_eq!(harness.interface.notices.text(), errors(&[2, 4, 5, 3]));
    for left in [&[2, 5, 3][..], &[2, 3]] {
        // The cards move to where they are.
        (0..3).for_each(|_| drop(harness.frame(vec![])));
        let at = harness.places_of(if left.len() == 3 { "it 4" } else { "it 5" })[0];
        assert_eq!(harness.click(at), []);
        assert_eq!(harness.interface.notices.text(), errors(left));
    }
}

/// Would catch: Esc that takes what was typed, at once or in the next pass, or that puts down a brush besides.
#[test]
fn esc_in_a_field_gives_up_the_number_and_does_no_more() {
    let mut harness = Harness::new();
    harness.press(Key::B);
    let brush = harness.interface.tools.tool;
    harness.interface.panel.filter = "atlas size".to_owned();
    for _ in 0..30 {
        harness.frame(vec![]);
    }
    harness.click(harness.places_of("1024")[0]);
    harness.frame(vec![Event::Text("512".to_owned())]);
    assert!(!harness.places_of("512").is_empty(), "it is typed");
    harness.press(Key::Escape);
    for _ in 0..3 {
        harness.frame(vec![]);
        assert_eq!(harness.interface.document.edited.atlas.size, 1024);
    }
    assert_eq!(harness.interface.tools.tool, brush);
    harness.press(Key::Escape);
    assert_eq!(harness.interface.tools.tool, Tool::Look);
    // The next number is taken.
    harness.time += 1.0;
    harness.click(harness.places_of("1024")[0]);
    harness.frame(vec![Event::Text("256".to_owned())]);
    harness.press(Key::Enter);
    assert_eq!(harness.interface.document.edited.atlas.size, 256);
}

#[test]
fn text_that_is_no_number_is_reported() {
    let mut harness = Harness::new();
    harness.interface.panel.filter = "atlas size".to_owned();
    for _ in 0..30 {
        harness.frame(vec![]);
    }
    harness.click(harness.places_of("1024")[0]);
    harness.frame(vec![Event::Text("wide".to_owned())]);
    harness.press(Key::Enter);
    harness.frame(vec![]);
    let notice = harness.interface.notices.text().expect("it is said");
    assert!(notice.contains("“wide” is no number"), "{notice}");
    assert_eq!(harness.interface.document.edited.atlas.size, 1024);
}

#[test]
fn commands_are_found_by_what_they_do() {
    let mut harness = Harness::new();
    harness.interface.panel.filter = "one step".to_owned();
    harness.frame(vec![]);
    let at = harness.places_of("take one step")[0];
    assert_eq!(harness.click(at), [Command::Step]);
    assert!(!harness.interface.document.playing);
    // An action without effect is grey.
    harness.interface.panel.filter = "selected object".to_owned();
    for _ in 0..3 {
        harness.frame(vec![]);
    }
    let at = harness.places_of("duplicate the selected object")[0];
    assert_eq!(harness.click(at), []);
    harness.interface.panel.filter = "relief".to_owned();
    for _ in 0..3 {
        harness.frame(vec![]);
    }
    let places = harness.places_of("relief");
    // The first one is the field that it is searched in.
    harness.click(places[1]);
    assert_eq!(harness.interface.document.view.show.word(), "relief");
}

/// A button that the tabulator has led to is pressed by Space, and the simulation runs on.
#[test]
fn space_is_for_the_control_with_the_keyboard() {
    let mut harness = Harness::new();
    while harness.ctx.memory(|memory| memory.focused()).is_none() {
        harness.press(Key::Tab);
    }
    harness.press(Key::Space);
    assert!(harness.interface.document.playing);
    harness.press(Key::Escape);
    harness.frame(vec![]);
    assert_eq!(harness.ctx.memory(|memory| memory.focused()), None);
    harness.press(Key::Space);
    assert!(!harness.interface.document.playing);
}

#[test]
fn the_probe_lays_a_brush_down() {
    let mut harness = Harness::new();
    harness.interface.tools.take(Tool::Erase);
    harness.press(Key::I);
    assert!(harness.interface.tools.probe);
    assert_eq!(harness.interface.tools.tool, Tool::Look);
    harness.press(Key::I);
    assert!(!harness.interface.tools.probe);
}

#[test]
fn undo_leads_back_to_the_preset_with_its_name() {
    let mut harness = Harness::new();
    harness.press(Key::CloseBracket);
    let taken = harness
        .interface
        .document
        .preset
        .clone()
        .expect("it has a name");
    harness.frame(vec![]);
    harness.interface.document.edited.trail.decay = 0.5;
    harness.frame(vec![]);
    harness.press(Key::D);
    harness.frame(vec![]);
    assert_eq!(harness.interface.document.preset, None);
    harness.press_with(Modifiers::COMMAND, Key::Z);
    // It was changed, and is still that preset.
    assert_eq!(harness.interface.document.preset, Some(taken));
    assert_eq!(harness.interface.document.edited.trail.decay, 0.5);
}

/// The motion of the wheel continues for a moment, but not over another part of the window.
#[test]
fn a_turn_of_the_wheel_ends_where_it_began() {
    let mut harness = Harness::new();
    let wheel = || Event::MouseWheel {
        unit: MouseWheelUnit::Line,
        delta: vec2(0.0, 3.0),
        phase: egui::TouchPhase::Move,
        modifiers: Modifiers::NONE,
    };
    let distance = |harness: &Harness| harness.interface.document.view.camera.distance;
    harness.frame(vec![Event::PointerMoved(IN_PANEL)]);
    harness.frame(vec![wheel()]);
    let before = distance(&harness);
    harness.frame(vec![Event::PointerMoved(IN_PICTURE)]);
    for _ in 0..20 {
        harness.frame(vec![]);
    }
    assert_eq!(distance(&harness), before);
    harness.frame(vec![wheel()]);
    harness.frame(vec![]);
    assert!(distance(&harness) < before);
}
