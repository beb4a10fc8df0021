//! The list of objects: names, eyes and locks, and their effect on the tools.

use super::*;

const CONTROL: Modifiers = Modifiers::CTRL.plus(Modifiers::COMMAND);

/// With the list in sight.
fn listing() -> Harness {
    let mut harness = harness();
    harness.interface.document.edited.objects[1].distance_to = vec!["torus".to_owned()];
    harness.interface.document.edited.particles.start_object = "torus".to_owned();
    harness.interface.document.running = harness.interface.document.edited.clone();
    harness.interface.panel.filter = "outliner".to_owned();
    (0..30).for_each(|_| drop(harness.frame(vec![])));
    harness
}

fn names(harness: &Harness) -> Vec<String> {
    harness.interface.document.names()
}

/// Clicks on what is written in the row of an object.
fn click(harness: &mut Harness, text: &str, row: usize) -> Vec<Command> {
    let mut places = harness.places_of(text);
    places.retain(|place| place.x < 340.0);
    places.sort_by(|a, b| a.y.total_cmp(&b.y));
    let commands = harness.click(places[row]);
    harness.frame(vec![]);
    commands
}

fn write(harness: &mut Harness, name: &str) -> Vec<Command> {
    harness.press_with(CONTROL, Key::A);
    harness.frame(vec![Event::Text(name.to_owned())]);
    let mut commands = harness.press(Key::Enter);
    commands.extend(harness.frame(vec![]).commands);
    commands
}

#[test]
fn an_object_gets_another_name_which_is_undone() {
    let mut harness = listing();
    assert_eq!(names(&harness), ["torus", "second"]);
    click(&mut harness, "✏", 0);
    assert_eq!(write(&mut harness, "  ring "), [Command::Apply]);
    let edited = &harness.interface.document.edited;
    assert_eq!(names(&harness), ["ring", "second"]);
    assert_eq!(edited.objects[1].distance_to, ["ring"]);
    assert_eq!(edited.particles.start_object, "ring");
    // It needs no restart: the running objects get the names, too.
    let live = harness.interface.document.live_settings();
    assert_eq!(&live, edited);
    harness.interface.document.running = live;
    assert!(!harness.interface.document.is_pending());
    // Its notice of a restart is gone, and everything is back in its place.
    (0..3).for_each(|_| drop(harness.frame(vec![])));

    // A name that is taken or none is not taken; Esc leaves the old one.
    click(&mut harness, "✏", 0);
    assert!(write(&mut harness, "second").is_empty());
    let notice = harness.interface.notices.text().unwrap();
    assert!(
        notice.contains("Another object is called second"),
        "{notice}"
    );
    click(&mut harness, "✏", 1);
    assert!(write(&mut harness, " ").is_empty());
    // By two clicks on the name; sooner they would be the third and the fourth.
    harness.time += 1.0;
    click(&mut harness, "second", 0);
    click(&mut harness, "second", 0);
    harness.press_with(CONTROL, Key::A);
    harness.frame(vec![Event::Text("other".to_owned())]);
    assert!(!harness.places_of("other").is_empty(), "it is typed");
    assert!(harness.press(Key::Escape).is_empty());
    harness.frame(vec![]);
    assert_eq!(names(&harness), ["ring", "second"]);
    assert_eq!(harness.interface.tools.selected, Some(1), "and no more");

    assert_eq!(harness.press_with(CONTROL, Key::Z), [Command::Apply]);
    assert_eq!(names(&harness), ["torus", "second"]);
    let live = harness.interface.document.live_settings();
    assert_eq!(live, harness.interface.document.edited);
}

#[test]
fn objects_are_selected_hidden_and_shown() {
    let mut harness = listing();
    let edited = harness.interface.document.edited.clone();
    let hidden = |harness: &Harness| {
        let marks = &harness.interface.document.marks;
        [0, 1].map(|object| marks.is_hidden(object))
    };
    click(&mut harness, "second", 0);
    assert_eq!(harness.interface.tools.selected, Some(1));
    click(&mut harness, "👁", 1);
    assert_eq!(hidden(&harness), [false, true]);
    assert_eq!(harness.interface.tools.selected, None);
    click(&mut harness, "–", 0);
    assert_eq!(hidden(&harness), [false, false]);
    // Alone, and all again.
    click(&mut harness, "◎", 1);
    assert_eq!(hidden(&harness), [true, false]);
    click(&mut harness, "◎", 1);
    assert_eq!(hidden(&harness), [false, false]);
    // By keys.
    harness.press_with(CONTROL, Key::H);
    assert!(
        harness
            .interface
            .notices
            .text()
            .is_some_and(|text| text.contains("Pick an object"))
    );
    click(&mut harness, "torus", 0);
    harness.press_with(CONTROL, Key::H);
    assert_eq!(hidden(&harness), [true, false]);
    harness.press_with(CONTROL.plus(Modifiers::SHIFT), Key::H);
    assert_eq!(hidden(&harness), [false, false]);
    // Nothing of it is a change of the scene.
    assert_eq!(harness.interface.document.edited, edited);
}

#[test]
fn tools_leave_a_locked_object_alone() {
    let mut harness = listing();
    click(&mut harness, "🔓", 0);
    assert!(harness.interface.document.marks.is_locked(0));
    // A click on it in the picture picks nothing.
    let pick = |harness: &mut Harness| {
        harness.click(IN_PICTURE);
        harness.facts.pointer.looked = harness.interface.tools.pointer;
        harness.facts.pointer.under = Some(under());
        harness.frame(vec![]);
        harness.facts.pointer.looked = None;
        harness.facts.pointer.under = None;
        harness.interface.tools.selected
    };
    assert_eq!(pick(&mut harness), None);
    // One in the list does; it stays where it is, and is not removed.
    click(&mut harness, "torus", 0);
    assert_eq!(harness.interface.tools.selected, Some(0));
    assert!(harness.press(Key::Delete).is_empty());
    assert!(
        harness
            .interface
            .notices
            .text()
            .is_some_and(|text| text.contains("torus is locked"))
    );
    let edited = harness.interface.document.edited.clone();
    let middle = harness.interface.document.view.camera.target;
    let picture = harness.frame(vec![]).picture;
    let size = Vec2::new(picture.width(), picture.height());
    let at = |harness: &Harness| {
        let camera = harness.interface.document.view.camera;
        let pixel = camera.pixel(Vec3::ZERO, size).unwrap();
        picture.min + vec2(pixel.x, pixel.y)
    };
    let from = at(&harness);
    dragged(&mut harness, from, from + vec2(40.0, 0.0));
    assert_eq!(harness.interface.document.edited, edited, "{middle}");

    click(&mut harness, "🔒", 0);
    assert_eq!(pick(&mut harness), Some(0));
    let from = at(&harness);
    dragged(&mut harness, from, from + vec2(40.0, 0.0));
    assert_ne!(harness.interface.document.edited, edited);
    let commands = harness.press(Key::Delete);
    assert_eq!(
        commands,
        [Command::Tool(ToolRequest::Remove(Which::Object(0)))]
    );
}
