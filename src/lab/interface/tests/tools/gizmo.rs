//! Handles that are held: given up, in steps, and the camera on what is picked.

use super::*;

fn hold(harness: &mut Harness) -> Pos2 {
    harness.interface.tools.selected = Some(0);
    let from = middle(harness);
    harness.frame(vec![Event::PointerMoved(from)]);
    harness.frame(vec![button(from, true)]);
    from
}

#[test]
fn esc_puts_back_an_object_that_a_handle_has_moved() {
    let mut harness = harness();
    let before = harness.interface.document.edited.clone();
    let camera = harness.interface.document.view.camera;
    let from = hold(&mut harness);
    harness.frame(vec![Event::PointerMoved(from + vec2(60.0, 0.0))]);
    assert_ne!(harness.interface.document.edited, before);
    assert_eq!(harness.press(Key::Escape), [Command::Apply]);
    assert_eq!(harness.interface.document.edited, before);
    // The button is still down: the pointer moves nothing else, and the release is no click.
    let on = from + vec2(90.0, 30.0);
    for event in [Event::PointerMoved(on), button(on, false)] {
        assert_eq!(harness.frame(vec![event]).commands, []);
        assert_eq!(harness.interface.document.edited, before);
        assert_eq!(harness.interface.document.view.camera, camera);
    }
    assert_eq!(harness.interface.tools.selected, Some(0));
    harness.press(Key::Escape);
    assert_eq!(harness.interface.tools.selected, None);
    // Nothing was changed: before that the scene had one object.
    harness.interface.undo(&mut Vec::new());
    assert_eq!(harness.interface.document.edited.objects.len(), 1);
}

#[test]
fn with_ctrl_objects_are_moved_in_steps_and_the_distance_is_shown() {
    let mut harness = harness();
    let from = hold(&mut harness);
    let labels = |harness: &Harness| {
        let words = ["+0.", "-0.", "+1.", "-1."].map(|words| harness.places_of(words).len());
        words.iter().sum::<usize>()
    };
    let to = from + vec2(77.0, -31.0);
    harness.frame(vec![Event::PointerMoved(to)]);
    assert_eq!(labels(&harness), 1);
    let off = |harness: &Harness| {
        let position = harness.interface.document.edited.objects[0].position;
        let off = position.map(|x| (10.0 * x - (10.0 * x).round()).abs());
        off.into_iter().fold(0.0, f64::max)
    };
    assert!(off(&harness) > 0.02, "{}", off(&harness));
    let held = Modifiers::CTRL.plus(Modifiers::COMMAND);
    harness.frame(vec![Event::ModifiersChanged(held)]);
    assert!(off(&harness) < 1e-3, "{}", off(&harness));
    let position = single(harness.interface.document.edited.objects[0].position);
    assert!(position.length() > 0.09, "{position}");
    harness.frame(vec![button(to, false)]);
    harness.frame(vec![]);
    assert_eq!(labels(&harness), 0);
}

#[test]
fn f_frames_the_picked_object() {
    let mut harness = harness();
    let whole = harness.interface.document.view.camera;
    harness.facts.pointer.poses[0] = Affine3A::from_translation(Vec3::new(2.0, 0.0, 0.0));
    harness.interface.tools.selected = Some(0);
    harness.press(Key::F);
    let near = harness.interface.document.view.camera;
    let off = near.target - whole.target - Vec3::new(2.0, 0.0, 0.0);
    assert!(off.length() < 0.05, "{near:?}");
    assert_eq!((near.yaw, near.pitch), (whole.yaw, whole.pitch));
    assert!(!harness.interface.document.is_fitted());
    harness.press(Key::Home);
    assert_eq!(harness.interface.document.view.camera.target, whole.target);
    harness.interface.tools.selected = None;
    harness.interface.document.view.camera = near;
    harness.press(Key::F);
    assert_eq!(harness.interface.document.view.camera.target, whole.target);
}

#[test]
fn undo_says_what_it_does_not_take_back() {
    let mut harness = harness();
    harness.facts.pointer.under = Some(under());
    let before = harness.interface.document.edited.clone();
    let undo = |harness: &mut Harness| {
        let held = Modifiers::CTRL.plus(Modifiers::COMMAND);
        let event = |pressed| Event::Key {
            key: Key::Z,
            physical_key: None,
            pressed,
            repeat: false,
            modifiers: held,
        };
        let commands = harness.frame(vec![event(true)]).commands;
        harness.frame(vec![event(false)]);
        commands
    };
    harness.interface.document.edited.trail.decay = 0.5;
    harness.frame(vec![]);
    let changed = harness.interface.document.edited.clone();
    for tool in [Tool::Trail, Tool::Particles] {
        harness.interface.tools.take(tool);
        dragged(&mut harness, IN_PICTURE, IN_PICTURE + vec2(40.0, 0.0));
        harness.interface.notices = Default::default();
        assert_eq!(undo(&mut harness), []);
        let notice = harness.interface.notices.text();
        assert!(notice.is_some_and(|text| text.contains("once more undoes")));
        assert_eq!(harness.interface.document.edited, changed);
    }
    assert_eq!(undo(&mut harness), [Command::Apply]);
    assert_eq!(harness.interface.document.edited, before);
    // The later change is undone first.
    dragged(&mut harness, IN_PICTURE, IN_PICTURE + vec2(40.0, 0.0));
    harness.interface.document.edited.trail.decay = 0.25;
    harness.frame(vec![]);
    assert_eq!(undo(&mut harness), [Command::Apply]);
    assert_eq!(harness.interface.document.edited, before);
}
