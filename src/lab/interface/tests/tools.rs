//! Brushes, picked objects and their handles, by events of a pointer and keys.

mod food;
mod gizmo;
mod objects;
mod outliner;
mod slow;

use glam::{Affine3A, DVec3, Vec3};
use myxo::scene::settings::ObjectSettings;
use myxo::sim::paint::Brush;

use super::*;
use crate::lab::command::Which;
use crate::lab::facts::Under;
use crate::lab::tools::Tool;

const LEFT: PointerButton = PointerButton::Primary;

fn single(place: [f64; 3]) -> Vec3 {
    DVec3::from_array(place).as_vec3()
}

fn button(pos: Pos2, pressed: bool) -> Event {
    Event::PointerButton {
        pos,
        button: LEFT,
        pressed,
        modifiers: Modifiers::NONE,
    }
}

/// With two objects, of which the first is where the pointer will be.
fn harness() -> Harness {
    let mut harness = Harness::new();
    let second = ObjectSettings {
        name: "second".to_owned(),
        ..ObjectSettings::default()
    };
    for settings in [
        &mut harness.interface.document.edited,
        &mut harness.interface.document.running,
    ] {
        settings.objects.push(second.clone());
    }
    harness.facts.pointer.poses = vec![Affine3A::IDENTITY; 2];
    harness.facts.pointer.trail_unit = 10.0;
    harness.facts.pointer.radius = 1.0;
    // The window would have noted these.
    let edited = harness.interface.document.edited.clone();
    let view = harness.interface.document.view;
    harness.interface.document.undo.note(&edited, &view);
    harness
}

fn under() -> Under {
    Under {
        pixel: Vec2::ZERO,
        triangle: 5,
        uv: [0.2, 0.3],
        texel: [7, 9],
        object: 0,
        position: Vec3::ZERO,
        in_object: Vec3::ZERO,
        normal: Vec3::Z,
        trail: Some(1.5),
        distance: None,
        bias: None,
    }
}

/// Drags, and gives every command on the way.
fn dragged(harness: &mut Harness, from: Pos2, to: Pos2) -> Vec<Command> {
    harness.frame(vec![Event::PointerMoved(from)]);
    let mut commands = harness.frame(vec![button(from, true)]).commands;
    for step in 1..=4 {
        let at = from + (to - from) * (step as f32 / 4.0);
        commands.extend(harness.frame(vec![Event::PointerMoved(at)]).commands);
    }
    commands.extend(harness.frame(vec![button(to, false)]).commands);
    commands
}

#[test]
fn a_brush_paints_where_it_is_drawn_and_leaves_the_camera() {
    let mut harness = harness();
    harness.interface.document.playing = false;
    let camera = harness.interface.document.view.camera;
    harness.press(Key::B);
    assert_eq!(harness.interface.tools.tool, Tool::Trail);
    let to = IN_PICTURE + vec2(60.0, 20.0);
    let commands = dragged(&mut harness, IN_PICTURE, to);
    assert_eq!(harness.interface.document.view.camera, camera);
    let strokes: Vec<_> = (commands.iter())
        .map(|command| match command {
            Command::Tool(ToolRequest::Stroke {
                from, to, brush, ..
            }) => (*from, *to, *brush),
            other => panic!("{other:?}"),
        })
        .collect();
    assert!(strokes.len() >= 5, "one a frame, from the press on");
    for pair in strokes.windows(2) {
        assert_eq!(pair[0].1, pair[1].0, "without a gap");
    }
    let drawn = strokes[strokes.len() - 1].1 - strokes[0].0;
    assert!((drawn - Vec2::new(60.0, 20.0)).length() < 1e-3, "{drawn}");
    for (_, _, brush) in strokes {
        assert!(matches!(brush, Brush::Trail { amount } if amount > 0.0));
    }
    // The other button still pans.
    let pans = PointerButton::Secondary;
    harness.drag(pans, Modifiers::NONE, IN_PICTURE, to);
    assert_ne!(harness.interface.document.view.camera.target, camera.target);
    harness.press(Key::Escape);
    assert_eq!(harness.interface.tools.tool, Tool::Look);
}

fn count_of_ends(commands: &[Command]) -> usize {
    let ends = commands.iter();
    ends.filter(|c| **c == Command::Tool(ToolRequest::EndStroke))
        .count()
}

/// Does what the window does at the end of a stroke.
fn end_stroke(harness: &mut Harness, has_changed: bool) {
    let interface = &mut harness.interface;
    interface.tools.pending_ends -= 1;
    if has_changed {
        interface.document.undo.stroke();
    }
}

/// From press to release, wherever the pointer has been, a brush that may leave something makes one stroke.
#[test]
fn a_stroke_is_one_thing_to_undo() {
    let mut harness = harness();
    let to = IN_PICTURE + vec2(60.0, 20.0);
    for (tool, ends, last) in [
        (Tool::Trail, 0, 0),
        (Tool::Particles, 0, 0),
        (Tool::NoGo, 1, 1),
        (Tool::Attract, 1, 2),
        (Tool::Erase, 1, 3),
    ] {
        harness.interface.tools.take(tool);
        let commands = dragged(&mut harness, IN_PICTURE, to);
        assert_eq!(count_of_ends(&commands), ends, "{tool:?}");
        if ends > 0 {
            end_stroke(&mut harness, true);
        }
        assert_eq!(harness.interface.document.undo.strokes(), last, "{tool:?}");
    }
    // A pointer that crosses the panel and comes back continues one stroke, which cannot be undone before it has ended.
    harness.interface.tools.take(Tool::Repel);
    harness.frame(vec![Event::PointerMoved(IN_PICTURE)]);
    let mut commands = harness.frame(vec![button(IN_PICTURE, true)]).commands;
    for at in [IN_PICTURE + vec2(9.0, 0.0), IN_PANEL, IN_PICTURE] {
        commands.extend(harness.frame(vec![Event::PointerMoved(at)]).commands);
    }
    harness.interface.undo(&mut commands);
    let are_strokes = |c: &Command| matches!(c, Command::Tool(ToolRequest::Stroke { .. }));
    assert!(commands.iter().all(are_strokes), "{commands:?}");
    commands.extend(harness.frame(vec![button(IN_PICTURE, false)]).commands);
    assert_eq!(count_of_ends(&commands), 1);
    end_stroke(&mut harness, true);
    for (undoes, last) in [(true, 3), (true, 2), (false, 3)] {
        let mut commands = Vec::new();
        match undoes {
            true => harness.interface.undo(&mut commands),
            false => harness.interface.redo(&mut commands),
        }
        let wanted = [Command::Apply, Command::Tool(ToolRequest::ToStroke(last))];
        assert_eq!(commands, wanted);
    }
    // A stroke that has changed nothing leaves what was undone.
    dragged(&mut harness, IN_PICTURE, to);
    end_stroke(&mut harness, false);
    assert_eq!(harness.interface.document.undo.strokes(), 3);
    harness.interface.redo(&mut Vec::new());
    assert_eq!(harness.interface.document.undo.strokes(), 4);
}

/// While long steps are under way strokes wait for their ends, and undo and redo for their turn.
#[test]
fn undo_comes_after_the_strokes_that_wait_for_their_ends() {
    let mut harness = harness();
    let to = IN_PICTURE + vec2(60.0, 20.0);
    harness.interface.tools.take(Tool::NoGo);
    for _ in 0..2 {
        let commands = dragged(&mut harness, IN_PICTURE, to);
        assert_eq!(count_of_ends(&commands), 1);
    }
    // A change made meanwhile comes after them.
    harness.interface.document.edited.trail.decay = 0.5;
    harness.frame(vec![]);
    let mut commands = Vec::new();
    harness.interface.undo(&mut commands);
    harness.interface.redo(&mut commands);
    let turn = |again: bool| Command::Tool(ToolRequest::Undo { again });
    assert_eq!(commands, [turn(false), turn(true)]);
    assert_eq!(harness.interface.document.undo.strokes(), 0);
    for last in 1..=2 {
        end_stroke(&mut harness, true);
        assert_eq!(harness.interface.document.undo.strokes(), last);
    }
    for last in [2, 1, 0] {
        harness.interface.undo(&mut Vec::new());
        assert_eq!(harness.interface.document.undo.strokes(), last);
        let decay = harness.interface.document.edited.trail.decay;
        assert_eq!(decay, Settings::default().trail.decay, "{last}");
    }
}

#[test]
fn hands_work_in_every_view_of_the_surface() {
    for &show in Show::ALL.iter().filter(|show| !show.is_flat()) {
        let word = show.word();
        let mut harness = harness();
        harness.interface.document.view.show = show;
        let camera = harness.interface.document.view.camera;
        // A brush, and its ring.
        harness.press(Key::B);
        let commands = dragged(&mut harness, IN_PICTURE, IN_PICTURE + vec2(40.0, 0.0));
        let strokes = commands.iter().filter(|c| matches!(c, Command::Tool(_)));
        assert!(strokes.count() >= 5, "{word}: {commands:?}");
        assert_eq!(harness.interface.document.view.camera, camera, "{word}");
        let lines = |harness: &Harness| harness.shapes.len();
        harness.frame(vec![]);
        let without = lines(&harness);
        harness.facts.pointer.under = Some(under());
        harness.frame(vec![]);
        assert!(lines(&harness) > without, "{word}: the ring");
        harness.press(Key::Escape);
        // The probe.
        harness.press(Key::I);
        for _ in 0..3 {
            harness.frame(vec![Event::PointerMoved(IN_PICTURE)]);
        }
        assert_eq!(harness.places_of("1.5000").len(), 1, "{word}: the probe");
        harness.press(Key::I);
        // A click picks, and a handle moves what was picked.
        let beside = IN_PICTURE + vec2(-120.0, 150.0);
        harness.click(beside);
        harness.facts.pointer.looked = harness.interface.tools.pointer;
        harness.frame(vec![]);
        assert_eq!(harness.interface.tools.selected, Some(0), "{word}");
        let from = middle(&mut harness);
        dragged(&mut harness, from, from + vec2(80.0, 0.0));
        let position = single(harness.interface.document.edited.objects[0].position);
        assert!(position.length() > 0.1, "{word}: {position}");
        assert_eq!(harness.interface.document.view.camera, camera, "{word}");
        // Food.
        harness.press(Key::Escape);
        harness.press(Key::O);
        harness.time += 2.0;
        harness.click(IN_PICTURE);
        harness.facts.pointer.looked = harness.interface.tools.pointer;
        harness.frame(vec![]);
        assert_eq!(harness.interface.document.edited.foods.len(), 1, "{word}");
    }
}

#[test]
fn in_the_flat_view_hands_rest_and_it_is_said_why() {
    let mut harness = harness();
    harness.interface.tools.take(Tool::Trail);
    harness.interface.document.view.show = Show::Atlas;
    harness.facts.pointer.under = Some(under());
    let commands = dragged(&mut harness, IN_PICTURE, IN_PICTURE + vec2(40.0, 0.0));
    assert_eq!(commands, []);
    for key in [Key::B, Key::O, Key::I] {
        harness.interface.notices = Default::default();
        harness.press(key);
        let notice = harness.interface.notices.text();
        assert!(
            notice.is_some_and(|text| text.contains("the atlas is flat")),
            "{key:?}"
        );
    }
    assert_eq!(harness.interface.tools.tool, Tool::Trail);
    // The bar has nothing to do there, and makes room.
    harness.frame(vec![]);
    assert_eq!(harness.places_of("✖ erase"), []);
    harness.interface.document.view.show = Show::Surface;
    harness.frame(vec![]);
    assert_eq!(harness.places_of("✖ erase").len(), 1);
}

#[test]
fn shift_and_the_wheel_change_the_brush_and_nothing_else() {
    let mut harness = harness();
    harness.interface.tools.take(Tool::Erase);
    let (camera, radius) = (
        harness.interface.document.view.camera,
        harness.interface.tools.radius,
    );
    harness.frame(vec![Event::PointerMoved(IN_PICTURE)]);
    harness.frame(vec![
        Event::ModifiersChanged(Modifiers::SHIFT),
        Event::MouseWheel {
            unit: MouseWheelUnit::Line,
            delta: vec2(0.0, 2.0),
            modifiers: Modifiers::SHIFT,
            phase: egui::TouchPhase::Move,
        },
    ]);
    for _ in 0..30 {
        harness.frame(vec![]);
    }
    assert!(harness.interface.tools.radius > 1.1 * radius);
    assert_eq!(harness.interface.document.view.camera, camera);
}

#[test]
fn a_click_picks_and_escape_lets_go() {
    let mut harness = harness();
    harness.facts.pointer.under = Some(under());
    // Not on the handles, which stand at the object's middle.
    let beside = IN_PICTURE + vec2(-120.0, 150.0);
    harness.click(beside);
    assert_eq!(
        harness.interface.tools.selected, None,
        "the window has not answered yet"
    );
    let pixel = harness.interface.tools.pointer;
    assert!(pixel.is_some(), "it asks");
    harness.facts.pointer.looked = pixel;
    harness.frame(vec![]);
    assert_eq!(harness.interface.tools.selected, Some(0));
    harness.press(Key::Escape);
    assert_eq!(harness.interface.tools.selected, None);
    harness.click(beside);
    harness.facts.pointer.under = None;
    harness.time += 2.0;
    harness.click(beside);
    assert_eq!(harness.interface.tools.selected, None, "on nothing");
}

/// The middle of the first object on the screen.
fn middle(harness: &mut Harness) -> Pos2 {
    let picture = harness.frame(vec![]).picture;
    let size = Vec2::new(picture.width(), picture.height());
    let at = harness
        .interface
        .document
        .view
        .camera
        .pixel(Vec3::ZERO, size)
        .unwrap();
    picture.min + vec2(at.x, at.y)
}

#[test]
fn a_dragged_object_goes_along_and_undo_brings_it_back() {
    let mut harness = harness();
    harness.interface.tools.selected = Some(0);
    let camera = harness.interface.document.view.camera;
    let from = middle(&mut harness);
    let commands = dragged(&mut harness, from, from + vec2(80.0, 0.0));
    assert!(commands.len() > 2 && commands.iter().all(|command| *command == Command::Apply));
    let position = single(harness.interface.document.edited.objects[0].position);
    assert!(position.dot(camera.right()) > 0.1, "{position}");
    assert!(position.dot(camera.up()).abs() < 1e-3, "{position}");
    assert_eq!(harness.interface.document.view.camera, camera);
    assert_eq!(
        harness.interface.document.edited.objects[1].position,
        [0.0; 3]
    );
    assert!(!{
        harness.interface.document.running = harness.interface.document.edited.clone();
        harness.interface.document.is_pending()
    });
    harness.frame(vec![]);
    let mut commands = Vec::new();
    harness.interface.undo(&mut commands);
    assert_eq!(commands, [Command::Apply]);
    assert_eq!(
        harness.interface.document.edited.objects[0].position,
        [0.0; 3]
    );
}

#[test]
fn the_box_beside_the_middle_scales() {
    let mut harness = harness();
    harness.interface.tools.selected = Some(0);
    let from = middle(&mut harness) + vec2(30.0, -30.0);
    let commands = dragged(&mut harness, from, from + vec2(40.0, -10.0));
    let [Command::Tool(ToolRequest::Scale(0, factor))] = commands[..] else {
        panic!("{commands:?}")
    };
    assert!((factor - 0.5_f32.exp()).abs() < 1e-3, "{factor}");
}

/// From the first move of the handle until the layout for it is there.
#[test]
fn a_scaled_object_is_drawn_as_large_at_once() {
    let mut harness = harness();
    harness.interface.tools.selected = Some(0);
    let from = middle(&mut harness) + vec2(30.0, -30.0);
    let to = from + vec2(40.0, -10.0);
    harness.frame(vec![Event::PointerMoved(from)]);
    harness.frame(vec![button(from, true)]);
    assert_eq!(harness.interface.scales(), [0.0; 0]);
    harness.frame(vec![Event::PointerMoved(to)]);
    let held = harness.interface.scales();
    assert_eq!(held.len(), harness.interface.document.running.objects.len());
    assert!(held[0] > 1.5 && held[1] == 1.0, "{held:?}");
    harness.frame(vec![button(to, false)]);
    // The window asks for the layout.
    harness.interface.document.edited.objects[0].scale *= held[0];
    harness.interface.document.begin_renewal();
    let coming = harness.interface.scales();
    assert!((coming[0] / held[0] - 1.0).abs() < 1e-5, "{coming:?}");
    let document = &mut harness.interface.document;
    assert!(!document.waits_for_restart() && document.is_pending());
    document.running.objects = document.edited.objects.clone();
    assert_eq!(harness.interface.scales(), [0.0; 0]);
}

#[test]
fn objects_that_undo_brings_back_run_at_once_and_pending_edits_wait() {
    let mut harness = harness();
    let undone = |harness: &mut Harness| {
        let mut commands = Vec::new();
        harness.interface.undo(&mut commands);
        commands
    };
    // The user has scaled it, and the window has loaded it.
    harness.interface.document.edited.objects[0].scale = 2.0;
    harness.interface.document.running = harness.interface.document.edited.clone();
    harness.interface.tools.selected = Some(1);
    harness.frame(vec![]);
    let renew = [Command::Tool(ToolRequest::Renew)];
    assert_eq!(undone(&mut harness), renew);
    assert_eq!(harness.interface.document.edited.objects[0].scale, 1.0);
    assert_eq!(harness.interface.tools.selected, Some(1));
    // Brought back before that was there.
    let mut commands = Vec::new();
    harness.interface.redo(&mut commands);
    assert_eq!(commands, renew);

    // Typed and not run yet.
    let mut harness = super::tools::harness();
    harness.interface.document.edited.objects[0].scale = 2.0;
    harness.frame(vec![]);
    assert!(harness.interface.document.is_pending());
    assert_eq!(undone(&mut harness), [Command::Apply]);
    assert!(!harness.interface.document.is_pending());

    // An object is removed: the picked object stays picked at its new index.
    let mut harness = super::tools::harness();
    harness.interface.document.edited.objects.remove(0);
    harness.interface.document.running = harness.interface.document.edited.clone();
    harness.interface.tools.selected = Some(0);
    harness.frame(vec![]);
    assert_eq!(undone(&mut harness), renew);
    assert_eq!(harness.interface.tools.selected, Some(1));
}

#[test]
fn objects_that_do_not_come_back_leave_those_that_run() {
    let mut harness = harness();
    harness.interface.document.edited.objects.remove(0);
    harness.interface.document.running = harness.interface.document.edited.clone();
    harness.frame(vec![]);
    let undone = |harness: &mut Harness| {
        let mut commands = Vec::new();
        harness.interface.undo(&mut commands);
        commands
    };
    let renew = [Command::Tool(ToolRequest::Renew)];
    assert_eq!(undone(&mut harness), renew);
    assert_eq!(harness.interface.document.edited.objects.len(), 2);
    // Until they are there, each that runs keeps its own place.
    let second = harness.interface.document.running.objects[0].clone();
    harness.interface.document.edited.objects[0].position = [9.0; 3];
    assert_eq!(harness.interface.document.live_settings().objects, [second]);
    // The mesh is gone, or the load was cancelled.
    harness.interface.not_shown();
    let Document {
        edited, running, ..
    } = &harness.interface.document;
    assert_eq!(edited.objects, running.objects);
    // A slider is a slider again.
    harness.interface.document.edited.trail.decay = 0.5;
    harness.frame(vec![]);
    assert_eq!(undone(&mut harness), [Command::Apply]);
    // Nothing was on its way: what is typed stays.
    harness.interface.document.edited.objects[0].scale = 3.0;
    harness.interface.not_shown();
    assert_eq!(harness.interface.document.edited.objects[0].scale, 3.0);
}

#[test]
fn every_tool_has_its_button() {
    let mut harness = harness();
    for (words, tool) in [
        ("✏ trail", Tool::Trail),
        ("✖ erase", Tool::Erase),
        ("➕ attract", Tool::Attract),
        ("➖ repel", Tool::Repel),
        ("🚫 no-go", Tool::NoGo),
        ("🎨 blend", Tool::Blend),
        ("✨ particles", Tool::Particles),
        ("◎ pulse", Tool::Pulse),
        ("👁 look", Tool::Look),
    ] {
        let [at] = harness.places_of(words)[..] else {
            panic!("{words}: {:?}", harness.places_of(words))
        };
        harness.click(at);
        assert_eq!(harness.interface.tools.tool, tool);
    }
    harness.press(Key::I);
    assert!(harness.interface.tools.probe);
    harness.facts.pointer.under = Some(under());
    for _ in 0..3 {
        harness.frame(vec![Event::PointerMoved(IN_PICTURE)]);
    }
    assert_eq!(harness.places_of("1.5000").len(), 1, "the trail is shown");
}
