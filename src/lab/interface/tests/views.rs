//! Tests of views: the picture, the atlas beside it, the light, flight, and standard directions.

use super::*;
use glam::Vec3;

const DRAG: egui::Vec2 = vec2(60.0, -20.0);

impl Harness {
    /// Holds a key for some frames, and lets it go; gives what these asked for.
    fn hold(&mut self, key: Key, frames: usize) -> Vec<Command> {
        let event = |pressed| Event::Key {
            key,
            physical_key: None,
            pressed,
            repeat: false,
            modifiers: Modifiers::NONE,
        };
        let mut commands = self.frame(vec![event(true)]).commands;
        for _ in 1..frames {
            commands.extend(self.frame(vec![]).commands);
        }
        commands.extend(self.frame(vec![event(false)]).commands);
        commands
    }

    /// Clicks the text that begins so; the first of them.
    fn click_text(&mut self, words: &str) {
        let place = *self.places_of(words).first().expect("it is shown");
        self.click(place);
        self.frame(vec![]);
    }

    /// Opens a part of the panel, and waits until it stands still.
    fn open(&mut self, title: &str) {
        self.click_text(title);
        for _ in 0..30 {
            self.frame(vec![]);
        }
    }
}

#[test]
fn keys_and_buttons_choose_views_and_what_a_scene_has_not_is_refused() {
    let mut harness = Harness::new();
    let with_keys = || {
        Show::ALL
            .iter()
            .filter_map(|&show| Some((show, show.key()?.0)))
    };
    let key = |name: &str| Key::from_name(name).expect(name);
    let is_of_two = |show: Show| show.has(Part::Distances);
    for (show, name) in with_keys().filter(|(show, _)| !is_of_two(*show)) {
        harness.press(key(name));
        assert_eq!(harness.interface.document.view.show, show);
    }
    harness.press(Key::Num7);
    for (_, name) in with_keys().filter(|(show, _)| is_of_two(*show)) {
        harness.press(key(name));
        assert_eq!(harness.interface.document.view.show, Show::Wireframe);
        let notice = harness.interface.notices.text().expect("there is a notice");
        assert!(notice.contains("needs a second object"), "{}", notice);
    }
    harness.frame(vec![]);
    harness.click_text("Distance");
    assert_eq!(
        harness.interface.document.view.show,
        Show::Wireframe,
        "it is grey"
    );
    harness.click_text("Glow");
    assert_eq!(harness.interface.document.view.show, Show::Glow);
    let other = harness.interface.document.running.objects[0].clone();
    harness.interface.document.running.objects.push(other);
    harness.press(Key::Num8);
    assert_eq!(harness.interface.document.view.show, Show::Distance);
    harness.frame(vec![]);
    assert!(!harness.places_of("inside of it").is_empty(), "a legend");
}

#[test]
fn a_scene_that_asks_for_what_it_has_not_shows_its_trail() {
    let mut settings = Settings::default();
    settings.picture.show = Show::Nearest;
    let scene = Scene::from_settings("torus".to_owned(), settings, ".".into()).unwrap();
    assert_eq!(Interface::new(&scene).document.view.show, Show::Surface);
}

#[test]
fn the_atlas_beside_the_picture_has_its_own_navigation() {
    let mut harness = Harness::new();
    let whole = harness.frame(vec![]);
    assert_eq!(whole.beside, None);
    harness.press(Key::U);
    for _ in 0..2 {
        harness.frame(vec![]);
    }
    let shown = harness.frame(vec![]);
    let beside = shown.beside.expect("it is there");
    assert_eq!(shown.picture.left_top(), whole.picture.left_top());
    assert_eq!(beside.right_bottom(), whole.picture.right_bottom());
    assert_eq!(shown.picture.right(), beside.left());
    let before = harness.interface.document.view;
    let none = Modifiers::NONE;
    let middle = beside.center();
    harness.interface.document.view.atlas.zoom = 4.0;
    assert!(harness.drag(PointerButton::Primary, none, middle, middle + DRAG));
    let after = harness.interface.document.view;
    assert_eq!(after.camera, before.camera);
    assert!(after.atlas.middle.x < before.atlas.middle.x - 0.01);
    let middle = shown.picture.center();
    harness.drag(PointerButton::Primary, none, middle, middle + DRAG);
    assert_ne!(harness.interface.document.view.camera, before.camera);
    assert_eq!(harness.interface.document.view.atlas, after.atlas);
    // A view of the atlas alone does not show it twice.
    harness.press(Key::Num0);
    assert_eq!(harness.frame(vec![]).beside, None);
}

#[test]
fn the_light_moves_with_its_key_and_nothing_else_does() {
    let mut harness = Harness::new();
    let before = harness.interface.document.view;
    let key = |pressed| Event::Key {
        key: Key::L,
        physical_key: None,
        pressed,
        repeat: false,
        modifiers: Modifiers::NONE,
    };
    harness.frame(vec![key(true)]);
    let none = Modifiers::NONE;
    harness.drag(PointerButton::Primary, none, IN_PICTURE, IN_PICTURE + DRAG);
    harness.frame(vec![key(false)]);
    let after = harness.interface.document.view;
    assert!(after.light.azimuth > before.light.azimuth + 1.0);
    assert!(after.light.elevation > before.light.elevation + 1.0);
    assert_eq!(after.camera, before.camera);
    harness.drag(PointerButton::Primary, none, IN_PICTURE, IN_PICTURE + DRAG);
    assert_eq!(harness.interface.document.view.light, after.light);
    assert_ne!(harness.interface.document.view.camera, before.camera);
    let mut commands = Vec::new();
    harness.interface.undo(&mut commands);
    assert_eq!(harness.interface.document.view.camera, before.camera);
    assert_eq!(harness.interface.document.view.light, after.light);
    harness.interface.undo(&mut commands);
    assert_eq!(harness.interface.document.view.light, before.light);
    assert_eq!(commands, [Command::Apply, Command::Apply]);
}

#[test]
fn flight_has_its_own_keys_drags_and_wheel() {
    let mut harness = Harness::new();
    harness.press(Key::V);
    assert!(harness.interface.navigation.is_flying() && harness.interface.document.playing);
    let start = harness.interface.document.view.camera;
    for (key, way) in [
        (Key::W, -start.backward()),
        (Key::S, start.backward()),
        (Key::D, start.right()),
        (Key::A, -start.right()),
        (Key::E, start.up()),
        (Key::Q, -start.up()),
    ] {
        let before = harness.interface.document.view.camera;
        assert_eq!(harness.hold(key, 6), [], "{key:?} means nothing else");
        let gone = harness.interface.document.view.camera.eye() - before.eye();
        assert!(gone.normalize().dot(way) > 0.999, "{key:?} goes {gone}");
    }
    assert!(harness.interface.document.playing, "S alone would hold it");
    let before = harness.interface.document.view.camera;
    let none = Modifiers::NONE;
    harness.drag(PointerButton::Primary, none, IN_PICTURE, IN_PICTURE + DRAG);
    let turned = harness.interface.document.view.camera;
    assert!(turned.eye().distance(before.eye()) < 1e-4 && turned.yaw != before.yaw);

    let speed = |harness: &Harness| harness.interface.navigation.flying.expect("it flies").speed;
    let slow = speed(&harness);
    harness.frame(vec![Event::MouseWheel {
        unit: MouseWheelUnit::Line,
        delta: vec2(0.0, 2.0),
        modifiers: Modifiers::NONE,
        phase: egui::TouchPhase::Move,
    }]);
    for _ in 0..30 {
        harness.frame(vec![]);
    }
    assert!(speed(&harness) > 1.1 * slow);
    assert_eq!(
        harness.interface.document.view.camera.distance,
        turned.distance
    );

    harness.press(Key::Escape);
    assert!(!harness.interface.navigation.is_flying());
    let there = harness.interface.document.view.camera;
    assert_eq!(harness.hold(Key::S, 2), [Command::Step]);
    assert_eq!(harness.interface.document.view.camera, there);
}

#[test]
fn the_camera_looks_from_sides_and_goes_home() {
    let mut harness = Harness::new();
    let home = harness.interface.document.view.camera;
    harness.open("Camera");
    for (title, towards) in [
        ("Front", Vec3::Z),
        ("Left", Vec3::NEG_X),
        ("Top", Vec3::Y),
        ("Bottom", Vec3::NEG_Y),
    ] {
        harness.click_text(title);
        let backward = harness.interface.document.view.camera.backward();
        assert!(backward.dot(towards) > 0.999, "{title}");
    }
    harness.click_text("Home");
    assert_eq!(harness.interface.document.view.camera, home);
    // A wider view is a change that can be taken back.
    harness
        .interface
        .document
        .view
        .camera
        .set_field_of_view(1.2);
    harness.frame(vec![]);
    let mut commands = Vec::new();
    harness.interface.undo(&mut commands);
    let back = harness.interface.document.view.camera;
    assert!((back.vertical_fov - home.vertical_fov).abs() < 1e-5);
    assert!((back.distance - home.distance).abs() < 1e-3);
}

#[test]
fn the_button_fits_the_scene_in_the_picture_of_its_own_frame() {
    let mut harness = Harness::new();
    harness.frame(vec![]);
    harness.interface.document.view.camera.distance *= 3.0;
    harness.frame(vec![]);
    let far = harness.interface.document.view.camera;
    let fit = *harness.places_of("Fit").first().expect("it is shown");
    harness.click(fit);
    let fitted = harness.interface.document.view.camera;
    assert!(fitted.distance < 0.5 * far.distance, "{fitted:?}");
    harness.frame(vec![]);
    assert_eq!(harness.interface.document.view.camera, fitted);
}

/// Would catch: a scene partly under the tool bar, room for a bar that is not shown, and one that stays where it was in another room.
#[test]
fn the_scene_is_in_the_middle_of_what_the_tools_leave_free() {
    let mut harness = Harness::new();
    for alone in [false, true, false] {
        harness.interface.layout.alone = alone;
        (0..3).for_each(|_| drop(harness.frame(vec![])));
        let picture = harness.frame(vec![]).picture;
        let bar = harness.ctx.memory(|memory| memory.area_rect("tools"));
        let right = match alone {
            true => picture.right(),
            false => bar.expect("it is shown").left(),
        };
        let free = right - picture.left();
        let size = Vec2::new(picture.width(), picture.height());
        let document = &harness.interface.document;
        let (low, high) = (document.outline.1.iter())
            .map(|&point| document.view.camera.pixel(point, size).unwrap().x)
            .fold((f32::MAX, f32::MIN), |(low, high), x| {
                (low.min(x), high.max(x))
            });
        let middle = 0.5 * (low + high);
        assert!(
            (middle - 0.5 * free).abs() < 1.0,
            "{middle} of {free}, alone: {alone}"
        );
        assert!(low > 0.0 && high < free, "{low} to {high} of {free}");
    }
}

/// Would catch: a camera that jumps, a picture that is on its way for ever, and files and tools that get a camera from half way.
#[test]
fn the_picture_follows_the_camera_home_in_a_moment() {
    let mut harness = Harness::new();
    let start = harness.interface.document.view.camera;
    harness.drag(
        PointerButton::Primary,
        Modifiers::NONE,
        IN_PICTURE,
        IN_PICTURE + vec2(120.0, 20.0),
    );
    let away = harness.interface.document.view.camera;
    assert_eq!(harness.interface.shown_view().camera, away);
    harness.press(Key::Home);
    let home = harness.interface.document.view.camera;
    assert_eq!((home.yaw, home.pitch), (start.yaw, start.pitch));
    let shown = harness.interface.shown_view().camera;
    assert!(shown != away && shown != home, "{shown:?}");
    assert!(harness.frame(vec![]).touched, "pictures come first");
    harness.time += 0.3;
    assert!(!harness.frame(vec![]).touched);
    assert_eq!(harness.interface.shown_view().camera, home);
    // A press stops it where it is seen.
    harness.interface.document.view.camera = away;
    harness.press(Key::Home);
    harness.frame(vec![Event::PointerMoved(IN_PICTURE)]);
    harness.frame(vec![Event::PointerButton {
        pos: IN_PICTURE,
        button: PointerButton::Primary,
        pressed: true,
        modifiers: Modifiers::NONE,
    }]);
    let stopped = harness.interface.document.view.camera;
    assert!(stopped != home && stopped != away, "{stopped:?}");
    assert_eq!(harness.interface.shown_view().camera, stopped);
}

/// Would catch: a camera that stops at once, that goes on while it is recorded or though the user does not want it, or that a press
/// does not stop.
#[test]
fn the_camera_goes_on_after_a_drag_until_a_press() {
    let mut harness = Harness::new();
    let mut goes_on = |glides: bool, is_recorded: bool, presses: bool| {
        harness.interface.layout.glides = glides;
        harness.facts.exports.recording = is_recorded.then(Default::default);
        let to = IN_PICTURE + vec2(80.0, 0.0);
        harness.drag(PointerButton::Primary, Modifiers::NONE, IN_PICTURE, to);
        let released = harness.interface.document.view.camera;
        if presses {
            harness.click(to);
        }
        let after = harness.interface.document.view.camera;
        (0..60).for_each(|_| drop(harness.frame(vec![])));
        let rests = harness.interface.document.view.camera;
        (0..60).for_each(|_| drop(harness.frame(vec![])));
        assert_eq!(harness.interface.document.view.camera, rests, "it ends");
        (released != after || after != rests, after != rests)
    };
    assert_eq!(goes_on(true, false, false), (true, true));
    assert_eq!(goes_on(true, false, true), (true, false));
    assert_eq!(goes_on(true, true, false), (false, false));
    assert_eq!(goes_on(false, false, false), (false, false));
}

/// Would catch: an entry for each frame of a drag, a camera that undo of a parameter moves, and one that undo does not bring back.
#[test]
fn a_drag_of_the_camera_is_one_entry_to_undo() {
    let mut harness = Harness::new();
    let camera = |harness: &Harness| harness.interface.document.view.camera;
    let home = camera(&harness);
    let turn = |harness: &mut Harness, by: f32| {
        let to = IN_PICTURE + vec2(by, 10.0);
        harness.drag(PointerButton::Primary, Modifiers::NONE, IN_PICTURE, to);
        // Together with the wheel, before it has rested.
        harness.interface.document.view.camera.distance *= 1.01;
        (0..40).for_each(|_| drop(harness.frame(vec![])));
        camera(harness)
    };
    let first = turn(&mut harness, 60.0);
    harness.interface.document.edited.trail.decay = 0.5;
    harness.frame(vec![]);
    let second = turn(&mut harness, -90.0);
    assert!(!harness.interface.document.is_unsaved() || first != second);
    let mut commands = Vec::new();
    let decay = |harness: &Harness| harness.interface.document.edited.trail.decay;
    let before = Settings::default().trail.decay;
    for wanted in [(first, 0.5), (first, before), (home, before)] {
        harness.interface.undo(&mut commands);
        (0..40).for_each(|_| drop(harness.frame(vec![])));
        assert_eq!(decay(&harness), wanted.1);
        let (is, wanted) = (camera(&harness), wanted.0);
        // A camera that fits the scene is found again.
        let is_near = is.target.distance(wanted.target) < 1e-4;
        assert!(
            is_near && (is.yaw, is.pitch) == (wanted.yaw, wanted.pitch),
            "{is:?}"
        );
    }
    assert!(!harness.interface.document.undo.can_undo());
    for wanted in [(first, before), (first, 0.5), (second, 0.5)] {
        harness.interface.redo(&mut commands);
        assert_eq!((camera(&harness), decay(&harness)), wanted);
    }
    // A wider picture is no entry, and the camera fits it again.
    let mut harness = Harness::new();
    harness.press(Key::P);
    (0..40).for_each(|_| drop(harness.frame(vec![])));
    assert!(!harness.interface.document.undo.can_undo());
    assert!(harness.interface.document.is_fitted());
}

/// Would catch: ends that lead elsewhere, axes that let a press through to the picture, and axes over the picture alone.
#[test]
fn the_axes_turn_the_camera() {
    let mut harness = Harness::new();
    let [at] = harness.places_of("Z")[..] else {
        panic!("{:?}", harness.places_of("Z"))
    };
    let start = harness.interface.document.view.camera;
    harness.click(at);
    (0..30).for_each(|_| drop(harness.frame(vec![])));
    let front = harness.interface.document.view.camera;
    assert_eq!((front.yaw, front.pitch), (0.0, 0.0));
    assert!((start.yaw, start.pitch) != (0.0, 0.0));
    let [x] = harness.places_of("X")[..] else {
        panic!("{:?}", harness.places_of("X"))
    };
    assert!((x.y - at.y).abs() < 40.0 && x.x > at.x);
    let ground = x + vec2(-14.0, 24.0);
    harness.drag(
        PointerButton::Primary,
        Modifiers::NONE,
        ground,
        ground + vec2(9.0, 0.0),
    );
    let turned = harness.interface.document.view.camera;
    assert!(turned.yaw != front.yaw && turned.target == front.target);
    assert!(harness.interface.tools.picked().is_none());
    harness.press(Key::F10);
    harness.frame(vec![]);
    assert!(harness.places_of("Z").is_empty());
}
