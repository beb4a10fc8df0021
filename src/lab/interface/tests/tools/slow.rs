//! Tools where a frame takes long: what was pressed, dragged and typed in it is done where and in the order in which it was.

use super::*;

/// A press, a way and the release, all in one frame.
fn in_one_frame(harness: &mut Harness, from: Pos2, to: Pos2) -> Vec<Command> {
    let mut events = vec![Event::PointerMoved(from), button(from, true)];
    events.extend((1..=8).map(|i| Event::PointerMoved(from + (to - from) * (i as f32 / 8.0))));
    events.push(button(to, false));
    // The pointer continues elsewhere.
    events.push(Event::PointerMoved(IN_PICTURE + vec2(150.0, 250.0)));
    harness.frame(events).commands
}

fn position(harness: &Harness) -> Vec3 {
    single(harness.interface.document.edited.objects[0].position)
}

#[test]
fn a_handle_is_held_where_it_was_pressed() {
    let way = vec2(80.0, 0.0);
    let mut usual = harness();
    usual.interface.tools.selected = Some(0);
    let from = middle(&mut usual);
    dragged(&mut usual, from, from + way);
    assert!(position(&usual).length() > 0.1);

    // The pointer has left the handle when the window receives the press, or the button is released by then.
    let press_and_go = |harness: &mut Harness| {
        let events = [button(from, true), Event::PointerMoved(from + 0.6 * way)];
        harness.frame(vec![Event::PointerMoved(from - way)]);
        harness.frame(events.to_vec());
        harness.frame(vec![
            Event::PointerMoved(from + way),
            button(from + way, false),
        ]);
    };
    let all = |harness: &mut Harness| {
        in_one_frame(harness, from, from + way);
    };
    for slow in [&press_and_go as &dyn Fn(&mut Harness), &all] {
        let mut harness = harness();
        harness.interface.tools.selected = Some(0);
        middle(&mut harness);
        let camera = harness.interface.document.view.camera;
        slow(&mut harness);
        let apart = (position(&harness) - position(&usual)).length();
        assert!(apart < 1e-4, "{}", position(&harness));
        assert_eq!(harness.interface.document.view.camera, camera);
        assert_eq!(harness.interface.tools.selected, Some(0));
    }
}

#[test]
fn a_quick_stroke_paints_all_its_way() {
    let mut harness = harness();
    harness.interface.tools.take(Tool::NoGo);
    harness.frame(vec![]);
    let camera = harness.interface.document.view.camera;
    let way = vec2(240.0, 60.0);
    let commands = in_one_frame(&mut harness, IN_PICTURE, IN_PICTURE + way);
    assert_eq!(count_of_ends(&commands), 1);
    let strokes = commands.iter().filter_map(|command| match command {
        Command::Tool(ToolRequest::Stroke { from, to, .. }) => Some((*from, *to)),
        _ => None,
    });
    let strokes: Vec<_> = strokes.collect();
    for pair in strokes.windows(2) {
        assert_eq!(pair[0].1, pair[1].0, "without a gap");
    }
    let drawn = strokes[strokes.len() - 1].1 - strokes[0].0;
    assert!((drawn - Vec2::new(way.x, way.y)).length() < 1e-3, "{drawn}");
    assert_eq!(harness.interface.document.view.camera, camera);
    // The interface asks what is under the pointer until the answer is for the pointer's present place.
    harness.facts.pointer.looked = None;
    harness.frame(vec![]);
    assert!(harness.interface.tools.pointer.is_some() && harness.ctx.has_requested_repaint());
}

#[test]
fn the_camera_turns_by_what_was_dragged_and_no_more() {
    let mut slow = harness();
    let mut usual = harness();
    let [from, to] = [IN_PICTURE, IN_PICTURE + vec2(60.0, 20.0)];
    dragged(&mut usual, from, to);
    slow.frame(vec![Event::PointerMoved(from - vec2(200.0, 0.0))]);
    slow.frame(vec![
        button(from, true),
        Event::PointerMoved(from + 0.5 * (to - from)),
    ]);
    slow.frame(vec![
        button(to, false),
        Event::PointerMoved(to + vec2(90.0, 0.0)),
    ]);
    let [slow, usual] = [slow, usual].map(|harness| harness.interface.document.view.camera);
    let off = (slow.yaw - usual.yaw).abs() + (slow.pitch - usual.pitch).abs();
    assert!(
        off < 0.02,
        "{} {}, not {} {}",
        slow.yaw,
        slow.pitch,
        usual.yaw,
        usual.pitch
    );
}

#[test]
fn a_click_means_where_it_was() {
    let mut harness = harness();
    let at = IN_PICTURE + vec2(-120.0, 150.0);
    harness.frame(vec![Event::PointerMoved(at)]);
    let elsewhere = Event::PointerMoved(at + vec2(100.0, -90.0));
    let picture = harness.frame(vec![]).picture;
    harness.frame(vec![button(at, true), button(at, false), elsewhere]);
    let place = at - picture.min;
    assert_eq!(
        harness.interface.tools.pointer,
        Some(Vec2::new(place.x, place.y))
    );
}

#[test]
fn keys_do_what_they_do_in_the_order_in_which_they_were_typed() {
    let mut harness = harness();
    let typed = |keys: &[Key]| {
        let both = |key: &Key| {
            [true, false].map(|pressed| Event::Key {
                key: *key,
                physical_key: None,
                pressed,
                repeat: false,
                modifiers: Modifiers::NONE,
            })
        };
        keys.iter().flat_map(both).collect::<Vec<_>>()
    };
    harness.press(Key::O);
    harness.frame(typed(&[Key::Escape, Key::G]));
    assert_eq!(harness.interface.tools.tool, Tool::Look);
    assert!(harness.interface.layout.gallery);
    harness.frame(typed(&[Key::G, Key::B]));
    assert!(!harness.interface.layout.gallery);
    assert_eq!(harness.interface.tools.tool, Tool::Trail);
    let commands = harness.frame(typed(&[Key::S, Key::R, Key::S])).commands;
    assert_eq!(commands, [Command::Step, Command::Restart, Command::Step]);
}

#[test]
fn a_list_is_closed_by_escape_or_by_a_click_that_does_nothing_else() {
    let mut harness = harness();
    harness.facts.pointer.under = Some(under());
    let is_open = |harness: &Harness| egui::Popup::is_any_open(&harness.ctx);
    let beside = IN_PICTURE + vec2(-120.0, 150.0);
    let open = |harness: &mut Harness| {
        let [at] = harness.places_of("+ object")[..] else {
            panic!("{:?}", harness.places_of("+ object"))
        };
        harness.time += 2.0;
        harness.click(at);
        for _ in 0..3 {
            harness.frame(vec![]);
        }
        assert!(is_open(harness));
    };
    harness.interface.tools.selected = Some(0);
    open(&mut harness);
    harness.press(Key::Escape);
    assert!(!is_open(&harness));
    assert_eq!(
        harness.interface.tools.selected,
        Some(0),
        "that is the next"
    );
    harness.press(Key::Escape);
    assert_eq!(harness.interface.tools.selected, None);
    open(&mut harness);
    harness.click(beside);
    harness.facts.pointer.looked = harness.interface.tools.pointer;
    harness.frame(vec![]);
    assert!(!is_open(&harness));
    assert_eq!(harness.interface.tools.selected, None, "nothing is picked");
    harness.time += 2.0;
    harness.click(beside);
    harness.facts.pointer.looked = harness.interface.tools.pointer;
    harness.frame(vec![]);
    assert_eq!(harness.interface.tools.selected, Some(0));
}

#[test]
fn the_picked_object_has_its_section_in_sight() {
    let mut harness = harness();
    harness.facts.pointer.under = Some(under());
    let is_shown = |harness: &Harness| {
        let name = &harness.interface.document.edited.objects[0].name;
        let title = harness.places_of(&format!("Object: {name}"));
        title.iter().any(|at| at.y < 500.0)
    };
    assert!(!is_shown(&harness));
    harness.click(IN_PICTURE + vec2(-120.0, 150.0));
    harness.facts.pointer.looked = harness.interface.tools.pointer;
    for _ in 0..90 {
        harness.frame(vec![]);
    }
    assert_eq!(harness.interface.tools.selected, Some(0));
    assert!(is_shown(&harness));
    assert_eq!(harness.places_of("Position").len(), 1, "and it is open");
    assert_eq!(harness.interface.tools.reveals, None);

    // The only one there is.
    let mut harness = Harness::new();
    harness.facts.pointer.under = Some(under());
    harness.facts.pointer.poses = vec![Affine3A::IDENTITY];
    harness.click(IN_PICTURE + vec2(-120.0, 150.0));
    harness.facts.pointer.looked = harness.interface.tools.pointer;
    for _ in 0..90 {
        harness.frame(vec![]);
    }
    assert_eq!(harness.interface.tools.selected, Some(0));
    assert!(!is_shown(&harness));
}

#[test]
fn a_selection_does_not_pass_to_the_next_scene() {
    let mut harness = harness();
    let settings = harness.interface.document.edited.clone();
    let scene = Scene::from_settings("pair".to_owned(), settings, ".".into()).unwrap();
    let tools = &mut harness.interface.tools;
    (tools.selected, tools.food) = (Some(1), None);
    harness.interface.restarted(&scene);
    assert_eq!(harness.interface.tools.selected, Some(1), "it is the same");
    // While the one before it goes, it comes to stand in that one's place.
    let mut fewer = harness.interface.document.edited.clone();
    let picked = fewer.objects[1].name.clone();
    fewer.objects.remove(0);
    let fewer = Scene::from_settings("pair".to_owned(), fewer, ".".into()).unwrap();
    harness.interface.restarted(&fewer);
    let tools = &harness.interface.tools;
    assert_eq!(tools.selected, Some(0));
    assert_eq!(harness.interface.document.edited.objects[0].name, picked);
    harness.interface.tools.food = Some(0);
    harness.interface.open(&scene);
    let tools = &harness.interface.tools;
    assert_eq!((tools.selected, tools.food), (None, None));
}

#[test]
fn what_is_changed_while_a_scene_loads_is_kept() {
    let mut harness = harness();
    let interface = &mut harness.interface;
    let asked = interface.document.edited.clone();
    let scene = Scene::from_settings("pair".to_owned(), asked.clone(), ".".into()).unwrap();
    interface.document.asked = Some(asked.clone());
    interface.document.edited.trail.decay = 0.5;
    interface.document.edited.objects[1].position = [0.0, 3.0, 0.0];
    let edited = interface.document.edited.clone();
    interface.restarted(&scene);
    assert_eq!(
        (&interface.document.edited, &interface.document.running),
        (&edited, &asked)
    );
    // Only once, and another scene has what its file says.
    interface.restarted(&scene);
    assert_eq!(interface.document.edited, asked);
    interface.document.asked = Some(edited);
    interface.open(&scene);
    assert_eq!(interface.document.edited, asked);
}

#[test]
fn an_object_that_comes_is_seen_whole() {
    for is_fitted in [true, false] {
        let mut harness = Harness::new();
        let mut settings = harness.interface.document.edited.clone();
        settings.objects.push(ObjectSettings {
            name: "far".to_owned(),
            position: [3.0, 0.0, 0.0],
            ..ObjectSettings::default()
        });
        let scene = Scene::from_settings("two".to_owned(), settings, ".".into()).unwrap();
        if !is_fitted {
            harness.interface.document.view.camera.yaw += 0.2;
        }
        let before = harness.interface.document.view.camera;
        harness.interface.restarted(&scene);
        let picture = harness.frame(vec![]).picture;
        let after = harness.interface.document.view.camera;
        assert_eq!(after.yaw, before.yaw);
        let middle = if is_fitted {
            scene.center
        } else {
            before.target
        };
        assert_eq!(after.target, middle);
        assert!(after.distance > 1.2 * before.distance);
        let size = Vec2::new(picture.width(), picture.height());
        for place in myxo::render::view::points(&scene) {
            let pixel = after.pixel(place, size).unwrap();
            assert!(pixel.cmpge(Vec2::ZERO).all() && pixel.cmple(size).all());
        }
        // Another scene has a view of its own.
        harness.interface.open(&scene);
        assert!(harness.interface.tools.selected.is_none());
    }
}

#[test]
fn a_search_is_left_by_escape_and_by_its_cross() {
    let mut harness = harness();
    harness.press(Key::B);
    let look_for = |harness: &mut Harness| {
        let [at] = harness.places_of("🔍 find a parameter")[..] else {
            panic!("{:?}", harness.places_of("🔍"))
        };
        harness.time += 2.0;
        harness.click(at);
        harness.frame(vec![Event::Text("decay".to_owned())]);
        harness.frame(vec![]);
        assert_eq!(harness.interface.panel.filter, "decay");
    };
    look_for(&mut harness);
    harness.press(Key::Escape);
    assert_eq!(harness.interface.panel.filter, "");
    assert_eq!(
        harness.interface.tools.tool,
        Tool::Trail,
        "that is the next"
    );
    harness.frame(vec![]);
    look_for(&mut harness);
    let crosses = harness.places_of("✖");
    let cross = crosses.iter().find(|at| at.x < 336.0).expect("it is there");
    harness.click(*cross);
    assert_eq!(harness.interface.panel.filter, "");
}
