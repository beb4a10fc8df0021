//! The interface without a window: events go in, commands and settings come out.

mod back;
mod controls;
mod gallery;
mod network;
mod performing;
mod scale;
mod tools;
mod views;

use egui::{Event, Key, Modifiers, MouseWheelUnit, PointerButton, Pos2, RawInput, pos2, vec2};
use myxo::render::Camera;
use myxo::scene::Scene;
use myxo::scene::settings::{ColorMap, Part, Strategy};

use super::*;
use crate::lab::facts::{Check, KernelTime};
use crate::lab::layout::GALLERY_WIDTHS;
use glam::Vec3;
use myxo::scene::parameters::PARAMETERS;

struct Harness {
    ctx: egui::Context,
    interface: Interface,
    facts: Facts,
    time: f64,
    /// Size of the window, points.
    screen: egui::Vec2,
    /// Pixels of the screen a point.
    scale: f32,
    /// The shapes that the last frame has painted.
    shapes: Vec<egui::epaint::ClippedShape>,
    /// And made of the pointer.
    cursor: egui::CursorIcon,
    /// When the next frame is wanted.
    delay: std::time::Duration,
    /// How often it was shown for that.
    passes: usize,
}

const SCREEN: egui::Vec2 = vec2(1200.0, 800.0);
/// In the picture, right of the panel.
const IN_PICTURE: Pos2 = pos2(800.0, 300.0);
const IN_PANEL: Pos2 = pos2(100.0, 300.0);

impl Harness {
    fn new() -> Self {
        let settings = Settings::default();
        let scene = Scene::from_settings("torus".to_owned(), settings, ".".into()).unwrap();
        let mut harness = Self {
            ctx: egui::Context::default(),
            interface: Interface::new(&scene),
            facts: Facts { ..Facts::default() },
            time: 0.0,
            screen: SCREEN,
            scale: 1.0,
            shapes: Vec::new(),
            cursor: egui::CursorIcon::Default,
            delay: std::time::Duration::ZERO,
            passes: 0,
        };
        theme::apply(&harness.ctx, false);
        // Most tests are about where looks and drags lead.
        harness.interface.looks.morph_seconds = 0.0;
        harness.interface.layout.glides = false;
        for _ in 0..3 {
            harness.frame(vec![]);
        }
        harness
    }

    fn frame(&mut self, events: Vec<Event>) -> Shown {
        self.time += 1.0 / 60.0;
        let screen = egui::ViewportInfo {
            native_pixels_per_point: Some(self.scale),
            ..egui::ViewportInfo::default()
        };
        let input = RawInput {
            viewports: [(egui::ViewportId::ROOT, screen)].into_iter().collect(),
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, self.screen)),
            time: Some(self.time),
            events,
            ..RawInput::default()
        };
        let (shown, mut output) = self.interface.run(&self.ctx, input, &self.facts);
        self.passes = output.platform_output.num_completed_passes;
        self.shapes = std::mem::take(&mut output.shapes);
        self.cursor = output.platform_output.cursor_icon;
        self.delay = output.viewport_output[&egui::ViewportId::ROOT].repaint_delay;
        output.drop_without_applying_deltas();
        shown
    }

    /// The middles of all texts of the last frame that begin so.
    fn places_of(&self, words: &str) -> Vec<Pos2> {
        fn look(shape: &egui::Shape, words: &str, found: &mut Vec<Pos2>) {
            match shape {
                egui::Shape::Vec(shapes) => shapes.iter().for_each(|s| look(s, words, found)),
                egui::Shape::Text(text) if text.galley.text().starts_with(words) => {
                    found.push(text.visual_bounding_rect().center());
                }
                _ => {}
            }
        }
        let mut found = Vec::new();
        let shapes = self.shapes.iter();
        shapes.for_each(|clipped| look(&clipped.shape, words, &mut found));
        found
    }

    fn click(&mut self, pos: Pos2) -> Vec<Command> {
        let event = |pressed| Event::PointerButton {
            pos,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        self.frame(vec![Event::PointerMoved(pos)]);
        let mut commands = self.frame(vec![event(true)]).commands;
        commands.extend(self.frame(vec![event(false)]).commands);
        commands
    }

    fn press(&mut self, key: Key) -> Vec<Command> {
        self.press_with(Modifiers::NONE, key)
    }

    fn press_with(&mut self, modifiers: Modifiers, key: Key) -> Vec<Command> {
        let event = |pressed| Event::Key {
            key,
            physical_key: None,
            pressed,
            repeat: false,
            modifiers,
        };
        let shown = self.frame(vec![event(true)]);
        self.frame(vec![event(false)]);
        shown.commands
    }

    fn drag(&mut self, button: PointerButton, modifiers: Modifiers, from: Pos2, to: Pos2) -> bool {
        let event = |pos, pressed| Event::PointerButton {
            pos,
            button,
            pressed,
            modifiers,
        };
        self.frame(vec![
            Event::ModifiersChanged(modifiers),
            Event::PointerMoved(from),
        ]);
        self.frame(vec![event(from, true)]);
        let mut touched = false;
        for step in 1..=4 {
            let at = from + (to - from) * (step as f32 / 4.0);
            touched |= self.frame(vec![Event::PointerMoved(at)]).touched;
        }
        self.frame(vec![
            event(to, false),
            Event::ModifiersChanged(Modifiers::NONE),
        ]);
        touched
    }
}

#[test]
fn keys_run_step_restart_and_choose() {
    let mut harness = Harness::new();
    assert!(harness.interface.document.playing);
    harness.press(Key::Space);
    assert!(!harness.interface.document.playing);
    assert_eq!(harness.press(Key::S), [Command::Step]);
    assert_eq!(harness.press(Key::Period), [Command::Step]);
    assert_eq!(harness.press(Key::R), [Command::Restart]);
    assert_eq!(harness.press(Key::F12), [Command::Screenshot]);
    for (key, show) in [
        (Key::Num4, Show::Particles),
        (Key::Num0, Show::Atlas),
        (Key::Num1, Show::Surface),
    ] {
        harness.press(key);
        assert_eq!(harness.interface.document.view.show, show);
    }
    for charts in [0.5, 1.0, 0.0] {
        harness.press(Key::X);
        assert_eq!(harness.interface.document.view.charts, charts);
    }
    harness.press(Key::C);
    assert_eq!(
        harness.interface.document.view.color_map,
        ColorMap::default().next()
    );
    harness.press(Key::H);
    assert!(harness.interface.layout.shows(Card::Help));
    harness.press(Key::Escape);
    assert!(!harness.interface.layout.shows(Card::Help));
}

#[test]
fn a_single_step_holds_the_simulation() {
    let mut harness = Harness::new();
    harness.press(Key::S);
    assert!(!harness.interface.document.playing);
}

#[test]
fn hiding_the_panel_gives_its_room_to_the_picture() {
    let mut harness = Harness::new();
    let with = harness.frame(vec![]).picture;
    harness.press(Key::P);
    let without = harness.frame(vec![]).picture;
    assert!(
        without.left() == 0.0 && with.left() > 300.0,
        "{with} {without}"
    );
    assert_eq!(without.bottom(), with.bottom());
}

#[test]
fn drags_in_the_picture_turn_and_pan_and_those_in_the_panel_do_not() {
    let mut harness = Harness::new();
    let start = harness.interface.document.view.camera;
    let orbited = |camera: &Camera| (camera.yaw, camera.pitch) != (start.yaw, start.pitch);
    let panned = |camera: &Camera| camera.target != start.target;

    harness.drag(
        PointerButton::Primary,
        Modifiers::NONE,
        IN_PANEL,
        IN_PANEL + vec2(0.0, 60.0),
    );
    assert_eq!(harness.interface.document.view.camera, start);

    assert!(harness.drag(
        PointerButton::Primary,
        Modifiers::NONE,
        IN_PICTURE,
        IN_PICTURE + vec2(60.0, 20.0)
    ));
    let camera = harness.interface.document.view.camera;
    assert!(orbited(&camera) && !panned(&camera));

    for (button, modifiers) in [
        (PointerButton::Secondary, Modifiers::NONE),
        (PointerButton::Primary, Modifiers::SHIFT),
    ] {
        harness.interface.document.view.camera = start;
        harness.drag(button, modifiers, IN_PICTURE, IN_PICTURE + vec2(60.0, 20.0));
        let camera = harness.interface.document.view.camera;
        assert!(!orbited(&camera) && panned(&camera), "{button:?}");
    }
}

#[test]
fn the_wheel_zooms_to_the_pointer() {
    let mut harness = Harness::new();
    let start = harness.interface.document.view.camera;
    harness.frame(vec![Event::PointerMoved(IN_PICTURE)]);
    let picture = harness.frame(vec![]).picture;
    let wheel = Event::MouseWheel {
        unit: MouseWheelUnit::Line,
        delta: vec2(0.0, 1.0),
        modifiers: Modifiers::NONE,
        phase: egui::TouchPhase::Move,
    };
    let mut touched = harness.frame(vec![wheel]).touched;
    for _ in 0..60 {
        touched |= harness.frame(vec![]).touched;
    }
    let camera = harness.interface.document.view.camera;
    assert!(
        touched
            && camera.distance < 0.95 * start.distance
            && camera.distance > 0.6 * start.distance,
        "{camera:?}"
    );
    // The point under the pointer, at the target's depth, is still under it.
    let size = Vec2::new(picture.width(), picture.height());
    let pointer = Vec2::new(IN_PICTURE.x - picture.left(), IN_PICTURE.y - picture.top());
    let ray = start.ray(pointer, size);
    let along = start.distance / -ray.direction.dot(start.backward());
    let still = camera
        .pixel(ray.origin + along * ray.direction, size)
        .unwrap();
    assert!(still.distance(pointer) < 0.1, "{still}, not {pointer}");
}

#[test]
fn a_double_click_asks_for_the_point_under_it() {
    let mut harness = Harness::new();
    let picture = harness.frame(vec![Event::PointerMoved(IN_PICTURE)]).picture;
    let click = |pressed| Event::PointerButton {
        pos: IN_PICTURE,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    let mut commands = Vec::new();
    for _ in 0..2 {
        commands.extend(harness.frame(vec![click(true)]).commands);
        commands.extend(harness.frame(vec![click(false)]).commands);
    }
    let pixel = Vec2::new(IN_PICTURE.x - picture.left(), IN_PICTURE.y - picture.top());
    assert_eq!(commands, [Command::Refocus(pixel)]);

    let goal = Vec3::new(0.3, 0.1, 0.2);
    let before = harness.interface.document.view.camera;
    let view = harness.interface.document.view;
    harness.interface.navigation.fly_to(goal, &view);
    for _ in 0..120 {
        harness.frame(vec![]);
    }
    let after = harness.interface.document.view.camera;
    assert_eq!(after.target, goal);
    // The eye has moved sideways only.
    assert!((after.eye() - before.eye()).dot(before.backward()).abs() < 1e-4);
    assert!(!harness.frame(vec![]).touched, "it has arrived");
}

#[test]
fn edits_that_need_a_restart_wait_and_others_are_live() {
    let mut harness = Harness::new();
    let interface = &mut harness.interface;
    interface.document.edited.trail.decay = 0.5;
    interface.document.edited.particles.count = 77;
    assert!(interface.document.is_pending());
    let live = interface.document.live_settings();
    assert_eq!(
        (live.trail.decay, live.particles.count),
        (0.5, interface.document.running.particles.count)
    );
    interface.document.edited.particles.count = interface.document.running.particles.count;
    assert!(!interface.document.is_pending());
    interface.document.edited.objects[0].scale = 2.0;
    assert!(interface.document.is_pending());
}

/// Nothing changes for particles when an object gets a value of its own, before that is changed too.
#[test]
fn a_value_of_its_own_begins_as_the_scenes() {
    let mut harness = Harness::new();
    harness.interface.document.edited.physarum.speed = 0.0123;
    harness.interface.panel.filter = "particle speed".to_owned();
    for _ in 0..30 {
        harness.frame(vec![]);
    }
    // The window takes it over at once.
    let toggle = |harness: &mut Harness| {
        let [checkbox] = harness.places_of("of its own")[..] else {
            panic!("{:?}", harness.places_of("of its own"));
        };
        assert_eq!(harness.click(checkbox), [Command::Apply]);
        harness.interface.document.running = harness.interface.document.edited.clone();
        harness.frame(vec![]);
        harness.interface.document.edited.objects[0].physarum.speed
    };
    assert_eq!(toggle(&mut harness), Some(0.0123));
    // The own value is removed again, and a new one begins as the scene's present value.
    assert_eq!(toggle(&mut harness), None);
    harness.interface.document.edited.physarum.speed = 0.25;
    assert_eq!(toggle(&mut harness), Some(0.25));
}

#[test]
fn checks_of_invariants_show_their_cost_and_findings() {
    let mut harness = Harness::new();
    assert!(harness.places_of("invariants hold").is_empty());
    let check = Check {
        step: 1234,
        took: std::time::Duration::from_millis(30),
        share: 0.029,
        problem: None,
    };
    harness.facts.check = Some(check.clone());
    harness.frame(vec![]);
    let lines = harness.places_of("invariants hold; checks take 3 %");
    assert_eq!(lines.len(), 1);
    harness.facts.check = Some(Check {
        problem: Some("after step 1234: 2 particles are lost and 0 doubled".to_owned()),
        ..check
    });
    harness.frame(vec![]);
    let lines = harness.places_of("after step 1234: 2 particles are lost");
    assert_eq!(lines.len(), 1);
}

#[test]
fn every_strategy_is_live() {
    let mut harness = Harness::new();
    let interface = &mut harness.interface;
    for &strategy in Strategy::ALL {
        interface.document.edited.transfer.strategy = strategy;
        interface.document.edited.transfer.buffer_size += 1;
        assert!(!interface.document.is_pending(), "{strategy:?}");
        assert_eq!(
            interface.document.live_settings(),
            interface.document.edited
        );
    }
}

/// A table that is new needs a second pass, to which no input comes.
#[test]
fn keys_count_while_something_new_finds_its_size() {
    let mut harness = Harness::new();
    harness.facts.has_timestamps = true;
    harness.facts.times.kernels = vec![KernelTime {
        name: "walk".to_owned(),
        per_step: 1.0,
        mean_ms: 2.0,
        p95_ms: 3.0,
        share: 1.0,
    }];
    let shown = harness.frame(vec![Event::Key {
        key: Key::S,
        physical_key: None,
        pressed: true,
        repeat: false,
        modifiers: Modifiers::COMMAND,
    }]);
    assert_eq!(harness.passes, 2);
    assert_eq!(shown.commands, [Command::Save]);
}

#[test]
fn copy_and_paste_reach_the_window() {
    let mut harness = Harness::new();
    assert_eq!(harness.frame(vec![Event::Copy]).commands, [Command::Copy]);
    assert_eq!(
        harness.frame(vec![Event::Paste("x".to_owned())]).commands,
        [Command::Paste("x".to_owned())]
    );
}

#[test]
fn every_parameter_has_a_place_in_the_panel() {
    for parameter in PARAMETERS {
        let section = parameter.section();
        let is_shown = super::super::panel::SECTIONS
            .iter()
            .any(|(prefix, ..)| *prefix == section);
        // The camera is moved with the mouse, and the picture has a section of its own.
        assert!(
            is_shown || matches!(section, "camera" | "picture"),
            "{}",
            parameter.key
        );
    }
}

#[test]
fn a_notice_goes_away() {
    let mut harness = Harness::new();
    let ctx = harness.ctx.clone();
    harness.interface.notices.say(&ctx, "saved", false);
    harness.frame(vec![]);
    assert!(harness.interface.notices.text().is_some());
    harness.time += 10.0;
    harness.frame(vec![]);
    assert!(harness.interface.notices.text().is_none());
}

#[test]
fn errors_of_dropped_files_stay_with_later_notices() {
    let mut harness = Harness::new();
    let ctx = harness.ctx.clone();
    let text = |interface: &Interface| interface.notices.text().expect("it is shown");
    let interface = &mut harness.interface;
    interface.notices.begin_drop();
    interface.notices.say(&ctx, "a.obj comes", false);
    assert_eq!(text(interface), "a.obj comes");
    for text in ["b.obj is torn", "b.obj is torn", "c.obj is torn"] {
        interface.notices.begin_drop();
        interface.notices.say(&ctx, text, true);
    }
    assert_eq!(text(interface), "b.obj is torn\nc.obj is torn\na.obj comes");
    interface.notices.say(&ctx, "d.obj comes", false);
    interface.notices.say(&ctx, "e.obj comes", false);
    assert_eq!(text(interface), "b.obj is torn\nc.obj is torn\ne.obj comes");
    interface.notices.end_drop();
    interface.notices.say(&ctx, "saved", false);
    assert_eq!(text(interface), "b.obj is torn\nc.obj is torn\nsaved");
    // They are one error.
    (0..3).for_each(|_| drop(harness.frame(vec![])));
    let at = harness.places_of("b.obj is torn")[0];
    harness.click(at);
    assert_eq!(harness.interface.notices.text().as_deref(), Some("saved"));
}

#[test]
fn a_scene_that_cannot_continue_as_pasted_stays_unchanged() {
    let mut harness = Harness::new();
    let ctx = harness.ctx.clone();
    let interface = &mut harness.interface;
    interface.document.edited.trail.decay = 0.75;
    let (edited, view) = (interface.document.edited.clone(), interface.document.view);
    let mut settings = edited.clone();
    settings.trail.decay = 0.5;
    settings.camera.distance = 9.0;
    let scene = Scene::from_settings("torus".to_owned(), settings, ".".into()).unwrap();
    let before = interface.clone();
    interface.continue_as(&scene);
    assert!(interface.document.edited.trail.decay == 0.5 && interface.document.view != view);
    interface.notices.say(&ctx, "it cannot", true);
    interface.put_back(before);
    assert!(interface.document.edited == edited && interface.document.view == view);
    assert_eq!(interface.notices.text().as_deref(), Some("it cannot"));
}

#[test]
fn the_scene_keeps_fitting_until_the_camera_is_moved() {
    let mut harness = Harness::new();
    let with_panel = harness.interface.document.view.camera.distance;
    harness.press(Key::P);
    harness.frame(vec![]);
    let without_panel = harness.interface.document.view.camera.distance;
    assert!(
        without_panel < 0.95 * with_panel,
        "{without_panel}, {with_panel}"
    );
    harness.drag(
        PointerButton::Primary,
        Modifiers::NONE,
        IN_PICTURE,
        IN_PICTURE + vec2(60.0, 20.0),
    );
    harness.press(Key::P);
    harness.frame(vec![]);
    assert_eq!(
        harness.interface.document.view.camera.distance,
        without_panel
    );
    harness.press(Key::F);
    harness.frame(vec![]);
    assert!(harness.interface.document.view.camera.distance > 1.05 * without_panel);
}
