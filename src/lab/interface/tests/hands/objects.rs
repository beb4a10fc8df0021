//! Objects that are taken out and duplicated by keys and buttons.

use super::*;

#[test]
fn the_last_object_stays() {
    let mut harness = harness();
    harness.press(Key::Delete);
    let notice = |harness: &Harness| harness.interface.notices.text();
    assert!(notice(&harness).is_some_and(|text| text.contains("Pick an object first")));
    harness.interface.hands.selected = Some(1);
    let commands = harness.press(Key::Delete);
    assert_eq!(commands, [Command::Hand(Work::Remove(1))]);
    harness.interface.running.objects.pop();
    harness.interface.edited.objects.pop();
    harness.interface.hands.selected = Some(0);
    assert_eq!(harness.press(Key::Delete), []);
    assert!(notice(&harness).is_some_and(|text| text.contains("The last object stays")));
    assert_eq!(harness.interface.hands.selected, Some(0));
}

#[test]
fn the_picked_object_is_duplicated_by_its_key_and_its_button() {
    let mut harness = harness();
    let control = Modifiers::CTRL.plus(Modifiers::COMMAND);
    let event = |key, modifiers, pressed| Event::Key {
        key,
        physical_key: None,
        pressed,
        repeat: false,
        modifiers,
    };
    let key = |harness: &mut Harness| {
        let pressed = event(Key::D, control, true);
        let commands = harness.frame(vec![pressed]).commands;
        harness.frame(vec![event(Key::D, control, false)]);
        commands
    };
    let edited = harness.interface.edited.clone();
    assert_eq!(key(&mut harness), []);
    let notice = harness.interface.notices.text();
    assert!(notice.is_some_and(|text| text.contains("Pick an object first")));
    let [at] = harness.places_of("🗐 duplicate")[..] else {
        panic!("{:?}", harness.places_of("🗐"))
    };
    assert_eq!(harness.click(at), [], "it is grey");
    harness.interface.hands.selected = Some(1);
    harness.frame(vec![]);
    let duplicate = |object| Command::Hand(Work::Duplicate(object));
    assert_eq!(key(&mut harness), [duplicate(1)]);
    // What comes next is about the copy, and about its copy.
    assert_eq!(harness.click(at), [duplicate(2)]);
    assert_eq!(harness.interface.hands.selected, Some(3));
    assert_eq!(harness.interface.edited, edited, "no look by chance");

    // Also where a slow frame gets them at once, and of the only object there is.
    harness.interface.running.objects.pop();
    harness.interface.edited.objects.pop();
    harness.interface.hands.selected = Some(0);
    let presses = [
        event(Key::D, control, true),
        event(Key::D, control, false),
        event(Key::D, control, true),
        event(Key::Delete, Modifiers::NONE, true),
    ];
    let wanted = [duplicate(0), duplicate(1), Command::Hand(Work::Remove(2))];
    assert_eq!(harness.frame(presses.to_vec()).commands, wanted);
    assert_eq!(harness.interface.hands.selected, None);
}
