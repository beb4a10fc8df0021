//! Objects that are removed and duplicated by keys and buttons.

use super::*;

#[test]
fn the_last_object_stays() {
    let mut harness = harness();
    harness.press(Key::Delete);
    let notice = |harness: &Harness| harness.interface.notices.text();
    assert!(notice(&harness).is_some_and(|text| text.contains("Pick an object first")));
    harness.interface.tools.selected = Some(1);
    let commands = harness.press(Key::Delete);
    assert_eq!(
        commands,
        [Command::Tool(ToolRequest::Remove(Which::Object(1)))]
    );
    harness.interface.document.running.objects.pop();
    harness.interface.document.edited.objects.pop();
    harness.interface.tools.selected = Some(0);
    assert_eq!(harness.press(Key::Delete), []);
    assert!(notice(&harness).is_some_and(|text| text.contains("The last object stays")));
    assert_eq!(harness.interface.tools.selected, Some(0));
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
    let edited = harness.interface.document.edited.clone();
    assert_eq!(key(&mut harness), []);
    let notice = harness.interface.notices.text();
    assert!(notice.is_some_and(|text| text.contains("Pick an object first")));
    let [at] = harness.places_of("🗐 duplicate")[..] else {
        panic!("{:?}", harness.places_of("🗐"))
    };
    assert_eq!(harness.click(at), [], "it is grey");
    harness.interface.tools.selected = Some(1);
    harness.frame(vec![]);
    let copy = |commands: Vec<Command>| match commands[..] {
        [Command::Tool(ToolRequest::Duplicate(which, ticket))] => (which, ticket),
        _ => panic!("{commands:?}"),
    };
    let (which, first) = copy(key(&mut harness));
    assert_eq!(which, Which::Object(1));
    // The next actions apply to the copy, and to its copy.
    let (which, second) = copy(harness.click(at));
    assert_eq!(which, Which::Asked(first));
    assert_eq!(
        harness.interface.document.edited, edited,
        "no look by chance"
    );
    // The last one is picked when it comes, and no other.
    harness.interface.tools.answer(first, Some(0));
    assert_eq!(harness.interface.tools.selected, None);
    harness.interface.tools.answer(second, Some(1));
    assert_eq!(harness.interface.tools.selected, Some(1));
    // An object that is picked meanwhile stays picked.
    let (_, third) = copy(key(&mut harness));
    harness.interface.tools.pick(Some(0));
    harness.interface.tools.answer(third, Some(1));
    assert_eq!(harness.interface.tools.selected, Some(0));
    // Esc first deselects the object on its way, and only then cancels the load.
    key(&mut harness);
    assert_eq!(harness.press(Key::Escape), []);
    assert_eq!(harness.press(Key::Escape), [Command::CancelLoading]);

    // Also where a slow frame gets them at once, and of the only object there is.
    harness.interface.document.running.objects.pop();
    harness.interface.document.edited.objects.pop();
    harness.interface.tools.selected = Some(0);
    let presses = [
        event(Key::D, control, true),
        event(Key::D, control, false),
        event(Key::D, control, true),
        event(Key::Delete, Modifiers::NONE, true),
    ];
    let commands = harness.frame(presses.to_vec()).commands;
    let [
        Command::Tool(ToolRequest::Duplicate(Which::Object(0), first)),
        Command::Tool(ToolRequest::Duplicate(Which::Asked(copied), second)),
        Command::Tool(ToolRequest::Remove(Which::Asked(removed))),
    ] = commands[..]
    else {
        panic!("{commands:?}")
    };
    assert_eq!((copied, removed), (first, second));
    assert_eq!(harness.interface.tools.picked(), None);
}
