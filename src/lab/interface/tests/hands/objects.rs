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
    let key = |harness: &mut Harness| {
        let control = Modifiers::CTRL.plus(Modifiers::COMMAND);
        let event = |pressed| Event::Key {
            key: Key::D,
            physical_key: None,
            pressed,
            repeat: false,
            modifiers: control,
        };
        let commands = harness.frame(vec![event(true)]).commands;
        harness.frame(vec![event(false)]);
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
    let wanted = [Command::Hand(Work::Duplicate(1))];
    assert_eq!(key(&mut harness), wanted);
    assert_eq!(harness.click(at), wanted);
    assert_eq!(harness.interface.edited, edited, "no look by chance");
}
