//! Food that is put, picked, dragged, changed, taken away and refused.

use myxo::scene::settings::FoodSettings;

use super::*;

#[test]
fn food_is_put_picked_changed_and_taken_away() {
    let mut harness = harness();
    harness.interface.document.edited.objects[0].scale = 2.0;
    harness.interface.document.running.objects[0].scale = 2.0;
    harness.press(Key::O);
    assert_eq!(harness.interface.tools.tool, Tool::Food);
    let click = |harness: &mut Harness, position: Vec3| {
        harness.facts.pointer.under = Some(Under {
            position,
            in_object: position,
            ..under()
        });
        let pressed = vec![Event::PointerMoved(IN_PICTURE), button(IN_PICTURE, true)];
        let mut commands = harness.frame(pressed).commands;
        commands.extend(harness.frame(vec![button(IN_PICTURE, false)]).commands);
        harness.facts.pointer.looked = harness.interface.tools.pointer;
        commands.extend(harness.frame(Vec::new()).commands);
        commands
    };
    let camera = harness.interface.document.view.camera;
    let commands = click(&mut harness, Vec3::new(1.0, 2.0, 3.0));
    assert!(commands.contains(&Command::Apply), "{commands:?}");
    let food = harness.interface.document.edited.foods[0].clone();
    assert_eq!(
        food.object,
        harness.interface.document.edited.objects[0].name
    );
    assert_eq!(food.at, [0.5, 1.0, 1.5], "in the mesh's own coordinates");
    assert_eq!(harness.interface.tools.food, Some(0));
    assert_eq!(harness.interface.document.view.camera, camera);
    // The window reports its position; a click on it picks it, and a click beside it puts another one.
    harness.facts.pointer.foods = vec![(Vec3::new(1.0, 2.0, 3.0), 0.1)];
    harness.interface.tools.food = None;
    click(&mut harness, Vec3::new(1.05, 2.0, 3.0));
    assert_eq!(harness.interface.tools.food, Some(0));
    click(&mut harness, Vec3::new(3.0, 2.0, 3.0));
    assert_eq!(harness.interface.document.edited.foods.len(), 2);
    assert_eq!(harness.interface.tools.food, Some(1));
    // Taken away, brought back.
    let commands = harness.press(Key::Delete);
    assert!(commands.contains(&Command::Apply), "{commands:?}");
    assert_eq!(harness.interface.document.edited.foods, [food]);
    harness.press(Key::Delete);
    assert_eq!(
        harness.interface.document.edited.foods.len(),
        1,
        "none is picked"
    );
    harness.interface.undo(&mut Vec::new());
    assert_eq!(harness.interface.document.edited.foods.len(), 2);
    harness.interface.undo(&mut Vec::new());
    assert_eq!(harness.interface.document.edited.foods.len(), 1);
    // Objects take theirs along.
    let name = harness.interface.document.edited.objects[0].name.clone();
    let without = crate::lab::objects::without_object(&harness.interface.document.edited, 0);
    assert!(without.foods.is_empty(), "{name}");
    harness.press(Key::Escape);
    harness.press(Key::Escape);
    assert_eq!(harness.interface.tools.tool, Tool::Look);
}

/// Would catch: undo and redo of food before the picked one in the list, after which another one is picked and changed.
#[test]
fn picked_food_stays_picked_when_undo_changes_the_list() {
    let mut harness = harness();
    harness.press(Key::O);
    let food = |x: f32| FoodSettings {
        at: [x.into(), 0.0, 0.0],
        ..FoodSettings::default()
    };
    let picked = |harness: &Harness| harness.interface.tools.food;
    harness.interface.document.edited.foods = vec![food(1.0), food(2.0)];
    harness.frame(vec![]);
    harness.interface.document.edited.foods.remove(0);
    harness.interface.tools.food = Some(0);
    harness.frame(vec![]);
    harness.interface.undo(&mut Vec::new());
    assert_eq!(harness.interface.document.edited.foods.len(), 2);
    assert_eq!(picked(&harness), Some(1));
    harness.interface.redo(&mut Vec::new());
    assert_eq!(picked(&harness), Some(0));
    harness.interface.undo(&mut Vec::new());
    harness.interface.tools.food = Some(0);
    harness.interface.redo(&mut Vec::new());
    assert_eq!(picked(&harness), None, "it is gone");
    // One that was moved stays picked.
    harness.interface.tools.food = Some(0);
    harness.interface.document.edited.foods[0].at[0] = 3.0;
    harness.frame(vec![]);
    harness.interface.undo(&mut Vec::new());
    assert_eq!(harness.interface.document.edited.foods, [food(2.0)]);
    assert_eq!(picked(&harness), Some(0));
}

#[test]
fn food_that_is_refused_is_gone_and_undo_leads_past_it() {
    let mut harness = harness();
    harness.press(Key::O);
    let food = |x: f32| FoodSettings {
        at: [x.into(), 0.0, 0.0],
        ..FoodSettings::default()
    };
    let interface = &mut harness.interface;
    interface.document.edited.foods = vec![food(1.0)];
    interface.document.running.foods = vec![food(1.0)];
    harness.frame(vec![]);
    harness.interface.document.edited.foods.push(food(2.0));
    harness.interface.tools.food = Some(1);
    harness.frame(vec![]);
    let refused = harness.interface.document.edited.clone();
    harness.interface.food_is_refused(&refused);
    harness.frame(vec![]);
    assert_eq!(harness.interface.document.edited.foods, [food(1.0)]);
    assert_eq!(harness.interface.tools.food, None, "nothing is picked");
    // The one entry before is that there was none.
    harness.interface.undo(&mut Vec::new());
    assert!(harness.interface.document.edited.foods.is_empty());
    harness.interface.redo(&mut Vec::new());
    assert_eq!(harness.interface.document.edited.foods, [food(1.0)]);
    // A change that is refused gives back what was, also to the next food.
    harness.interface.tools.food = Some(0);
    harness.interface.document.edited.foods[0].radius = 3.0;
    harness.interface.tools.next_food.radius = 3.0;
    let refused = harness.interface.document.edited.clone();
    harness.interface.food_is_refused(&refused);
    assert_eq!(harness.interface.tools.food, Some(0));
    assert_eq!(harness.interface.tools.next_food, food(1.0));
    // Food that the user has put since then stays.
    harness.interface.document.edited.foods.push(food(5.0));
    harness.interface.food_is_refused(&refused);
    assert_eq!(
        harness.interface.document.edited.foods,
        [food(1.0), food(5.0)]
    );
}

/// The position that the window reports for a pixel: on a plane, one pixel is a hundredth of a unit.
fn place_of(harness: &Harness, pixel: Vec2) -> Vec3 {
    let size = harness.ctx.content_rect().size();
    0.01 * (pixel - 0.5 * Vec2::new(size.x, size.y)).extend(0.0)
}

/// A frame, and then the window looks where it was asked to; right of `border` is the second object.
fn seen(harness: &mut Harness, events: Vec<Event>, border: f32) -> Vec<Command> {
    let commands = harness.frame(events).commands;
    let pixel = harness.interface.tools.pointer;
    let place = pixel.map(|pixel| place_of(harness, pixel));
    let pointer = &mut harness.facts.pointer;
    pointer.looked = pixel;
    pointer.under = place.map(|position| Under {
        position,
        in_object: position,
        object: usize::from(position.x > border),
        ..under()
    });
    let foods = harness.interface.document.edited.foods.iter();
    pointer.foods = foods.map(|food| (single(food.at), 0.1)).collect();
    commands
}

/// One food where the pointer will be pressed.
fn with_food() -> Harness {
    let mut harness = harness();
    harness.press(Key::O);
    seen(&mut harness, vec![Event::PointerMoved(IN_PICTURE)], 99.0);
    let at = harness.facts.pointer.under.as_ref().expect("it has looked");
    let food = FoodSettings {
        object: harness.interface.document.edited.objects[0].name.clone(),
        at: at.position.as_dvec3().to_array(),
        ..FoodSettings::default()
    };
    for settings in [
        &mut harness.interface.document.edited,
        &mut harness.interface.document.running,
    ] {
        settings.foods.push(food.clone());
    }
    seen(&mut harness, vec![], 99.0);
    harness
}

/// The food's distance from the place of the press, points.
fn way_of(harness: &Harness, from: [f64; 3]) -> Vec2 {
    let at = single(harness.interface.document.edited.foods[0].at);
    100.0 * (at - single(from)).truncate()
}

#[test]
fn food_is_dragged_over_the_surface_and_to_another_object() {
    let mut harness = with_food();
    let first = harness.interface.document.edited.foods[0].clone();
    let border = first.at[0] as f32 + 0.5;
    let camera = harness.interface.document.view.camera;
    let way = vec2(80.0, 30.0);
    let mut commands = seen(&mut harness, vec![button(IN_PICTURE, true)], border);
    for step in 1..=4 {
        let at = IN_PICTURE + way * (step as f32 / 4.0);
        commands.extend(seen(&mut harness, vec![Event::PointerMoved(at)], border));
    }
    let end = IN_PICTURE + way;
    commands.extend(seen(&mut harness, vec![button(end, false)], border));
    for _ in 0..3 {
        commands.extend(seen(&mut harness, vec![], border));
    }
    assert!(!commands.is_empty() && commands.iter().all(|c| *c == Command::Apply));
    let moved = harness.interface.document.edited.foods[0].clone();
    assert_eq!(moved.object, "second");
    let off = way_of(&harness, first.at) - Vec2::new(way.x, way.y);
    assert!(off.length() < 0.1, "{off}");
    assert_eq!(harness.interface.document.edited.foods.len(), 1);
    assert_eq!(harness.interface.tools.food, Some(0), "it is picked");
    assert_eq!(harness.interface.document.view.camera, camera);
    // All of the way at once.
    harness.interface.undo(&mut Vec::new());
    assert_eq!(harness.interface.document.edited.foods, [first]);
    harness.interface.redo(&mut Vec::new());
    assert_eq!(harness.interface.document.edited.foods, [moved]);
    harness.interface.undo(&mut Vec::new());
    harness.interface.undo(&mut Vec::new());
    assert!(
        harness.interface.document.edited.foods.is_empty(),
        "it was put there"
    );
}

#[test]
fn where_there_is_no_food_a_drag_turns_the_picture() {
    let (from, way) = (IN_PICTURE + vec2(-120.0, 90.0), vec2(60.0, 20.0));
    let turned = |mut harness: Harness, is_slow: bool| {
        let begun = harness.interface.document.view.camera;
        // The window has not looked yet at the place that is pressed.
        let mut events = vec![button(from, true)];
        events.extend((1..=4).map(|i| Event::PointerMoved(from + way * (i as f32 / 4.0))));
        events.push(button(from + way, false));
        if is_slow {
            seen(&mut harness, events, 99.0);
        } else {
            for event in events {
                seen(&mut harness, vec![event], 99.0);
            }
        }
        (0..3).for_each(|_| drop(seen(&mut harness, vec![], 99.0)));
        let camera = harness.interface.document.view.camera;
        [camera.yaw - begun.yaw, camera.pitch - begun.pitch]
    };
    let usual = turned(harness(), false);
    assert!(usual[0].abs() > 0.01, "{usual:?}");
    for is_slow in [false, true] {
        let with_tool = turned(with_food(), is_slow);
        for (a, b) in with_tool.into_iter().zip(usual) {
            assert!((a - b).abs() < 1e-4, "{with_tool:?}, not {usual:?}");
        }
    }
    // Nor does one with Shift take food along: it pans.
    let mut harness = with_food();
    let foods = harness.interface.document.edited.foods.clone();
    harness.drag(LEFT, Modifiers::SHIFT, IN_PICTURE, IN_PICTURE + way);
    assert_eq!(harness.interface.document.edited.foods, foods);
}

#[test]
fn food_comes_to_where_it_was_released_also_where_a_frame_takes_long() {
    let mut harness = with_food();
    let first = harness.interface.document.edited.foods[0].at;
    let camera = harness.interface.document.view.camera;
    let elsewhere = IN_PICTURE + vec2(30.0, 200.0);
    seen(&mut harness, vec![Event::PointerMoved(elsewhere)], 99.0);
    let end = IN_PICTURE + vec2(50.0, -20.0);
    let events = vec![
        button(IN_PICTURE, true),
        Event::PointerMoved(IN_PICTURE + vec2(20.0, 0.0)),
        Event::PointerMoved(end),
        button(end, false),
        Event::PointerMoved(elsewhere),
    ];
    seen(&mut harness, events, 99.0);
    (0..4).for_each(|_| drop(seen(&mut harness, vec![], 99.0)));
    let off = way_of(&harness, first) - Vec2::new(50.0, -20.0);
    assert!(off.length() < 0.1, "{off}");
    assert_eq!(harness.interface.document.view.camera, camera);
    // A press that does not move is a click, and picks it where it lies.
    let at = harness.interface.document.edited.foods[0].at;
    harness.interface.tools.food = None;
    harness.time += 2.0;
    for events in [
        vec![Event::PointerMoved(end)],
        vec![button(end, true)],
        vec![button(end, false)],
        vec![],
        vec![],
    ] {
        seen(&mut harness, events, 99.0);
    }
    assert_eq!(harness.interface.tools.food, Some(0));
    assert_eq!(harness.interface.document.edited.foods[0].at, at);
    assert_eq!(harness.interface.document.edited.foods.len(), 1);
    // A food that is removed while it is held is gone, and the food that takes its index stays where it is.
    let other = FoodSettings {
        at: [9.0, 9.0, 9.0],
        ..harness.interface.document.edited.foods[0].clone()
    };
    harness.interface.document.edited.foods.push(other.clone());
    harness.time += 2.0;
    seen(&mut harness, vec![button(end, true)], 99.0);
    seen(
        &mut harness,
        vec![Event::PointerMoved(end + vec2(9.0, 0.0))],
        99.0,
    );
    harness.press(Key::Delete);
    seen(
        &mut harness,
        vec![Event::PointerMoved(end + vec2(30.0, 0.0))],
        99.0,
    );
    seen(&mut harness, vec![button(IN_PANEL, false)], 99.0);
    assert_eq!(harness.interface.document.edited.foods, [other]);
    assert!(!harness.interface.tools.holds_food());
}
