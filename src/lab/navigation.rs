//! Navigation with the mouse: drags, the wheel and double clicks move the camera, the atlas or the light.

use egui::{Key, PointerButton, Pos2, Response, Ui};
use glam::{Vec2, Vec3};
use myxo::render::Camera;
use myxo::render::view::View;

use crate::lab::easing::Easing;
use crate::lab::flying::{Flying, LONGEST, SPEED, WAYS};
use crate::lab::notices::Notices;
use crate::lab::spin::{Spin, Way};
use crate::lab::wheel::Wheel;

/// How much one point of scrolling magnifies; a notch of a wheel is about 40 points.
const ZOOM_PER_POINT: f32 = 0.0035;
/// How quickly the camera reaches a new centre: the share that is left after a second is `exp(-this)`.
const FLIGHT_SPEED: f32 = 11.0;

/// Moves the view, and remembers a flight to a new centre.
#[derive(Clone, Debug, Default)]
pub struct Navigation {
    flight: Option<Flight>,
    wheel: Wheel,
    /// The camera goes on for a moment after a drag.
    pub glides: bool,
    spin: Spin,
    /// The picture is on its way to where the camera is.
    easing: Option<Easing>,
    /// The time of this frame, seconds.
    now: f64,
    /// While keys fly the camera.
    pub(super) flying: Option<Flying>,
}

/// A way to a new centre.
#[derive(Clone, Copy, Debug)]
struct Flight {
    target: Vec3,
    distance: f32,
}

/// Drags over the picture in one frame, points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Drags {
    /// With the first button.
    pub first: egui::Vec2,
    /// With the others.
    pub others: egui::Vec2,
    /// The last press of the first button.
    pub pressed: Option<Pos2>,
}

impl Drags {
    /// As the frames have it, which is later than it is where they take long.
    pub fn of(response: &Response) -> Self {
        let by = |button| match response.dragged_by(button) {
            true => response.drag_delta(),
            false => egui::Vec2::ZERO,
        };
        Self {
            first: by(PointerButton::Primary),
            others: by(PointerButton::Secondary) + by(PointerButton::Middle),
            pressed: None,
        }
    }
}

/// The user's navigation in one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moved {
    /// The view is being moved, by the user or in flight.
    pub touched: bool,
    /// A double click asks for a new centre: the pixel in the picture.
    pub refocus: Option<Vec2>,
}

impl Navigation {
    /// Moves `view` by the user's input over the picture, which `response` covers.
    pub fn apply(&mut self, ui: &Ui, response: &Response, drags: Drags, view: &mut View) -> Moved {
        let scale = ui.ctx().pixels_per_point();
        let pixels = |v: egui::Vec2| Vec2::new(v.x, v.y) * scale;
        let size = pixels(response.rect.size());
        let scroll = self.wheel.turned(ui, response).y;
        let (shift, pinch, seconds) =
            ui.input(|i| (i.modifiers.shift, i.zoom_delta(), i.stable_dt));
        let pointer = response
            .hover_pos()
            .map(|at| pixels(at - response.rect.min));
        let zoom = pinch * (scroll * ZOOM_PER_POINT).exp();
        let lights = ui.input(|i| i.key_down(Key::L)) && !ui.ctx().text_edit_focused();
        let mut moved = Moved::default();
        let (is_pressed, is_held) = ui.input(|i| (i.pointer.any_pressed(), i.pointer.any_down()));
        let is_met = is_pressed && response.contains_pointer();

        let pans = drags.others != egui::Vec2::ZERO;
        let drag = pixels(if pans { drags.others } else { drags.first });
        if is_met || drag != Vec2::ZERO || (pointer.is_some() && zoom != 1.0) {
            self.stop(view);
        }
        if drag != Vec2::ZERO {
            moved.touched = true;
            self.flight = None;
            if view.show.is_flat() {
                view.atlas.pan(drag, size);
            } else if lights {
                view.light.drag(drag, size);
            } else if self.is_flying() && !pans {
                view.camera.look(drag, size);
            } else {
                let way = if pans || shift { Way::Pan } else { Way::Orbit };
                self.spin.drag(way, drag, seconds, self.now);
                go(view, way, drag, size);
            }
        } else if !self.glides || view.show.is_flat() {
            self.spin.stop();
        } else if let Some((way, by)) = self.spin.go_on(is_held, seconds, self.now) {
            moved.touched = true;
            go(view, way, by, size);
        }
        if let Some(at) = pointer
            && zoom != 1.0
        {
            moved.touched = true;
            match (view.show.is_flat(), &mut self.flying) {
                (true, _) => view.atlas.zoom(zoom, at, size),
                (_, Some(flying)) => flying.change_speed(zoom),
                _ => view.camera.zoom(1.0 / zoom, at, size),
            }
        }
        if response.double_clicked() && !view.show.is_flat() {
            moved.refocus = drags.pressed.map(|at| pixels(at - response.rect.min));
        }
        moved.touched |= self.easing.is_some();
        moved.touched |= self.fly(view, seconds);
        moved.touched |= !view.show.is_flat() && self.travel(ui.ctx(), view, seconds);
        if moved.touched {
            ui.ctx().request_repaint();
        }
        moved
    }

    /// A frame begins, at this time in seconds.
    pub fn tick(&mut self, now: f64) {
        self.now = now;
        self.easing.take_if(|easing| easing.is_over(now));
    }

    /// What the picture shows while it is on its way to this camera.
    pub fn shown(&self, camera: &Camera) -> Camera {
        let easing = self.easing.as_ref();
        easing.map_or(*camera, |easing| easing.shown(camera, self.now))
    }

    /// The camera was moved at once, and the picture follows from what it shows.
    pub fn ease(&mut self, from: Camera) {
        self.spin.stop();
        self.flight = None;
        self.easing = Some(Easing::new(from, self.now));
    }

    /// Does anything move the camera, or the picture, by itself?
    pub fn goes_on(&self) -> bool {
        self.easing.is_some() || self.spin.is_free() || self.flight.is_some()
    }

    /// Everything that goes on by itself stops where the picture shows it.
    pub fn stop(&mut self, view: &mut View) {
        view.camera = self.shown(&view.camera);
        self.easing = None;
        self.spin.stop();
    }

    /// Begins a flight that brings a point to the middle of the picture. The eye moves sideways only, so that nothing
    /// changes its size, and the camera turns about the point from then on.
    pub fn fly_to(&mut self, point: Vec3, view: &View) {
        let camera = &view.camera;
        let depth = (camera.eye() - point).dot(camera.backward());
        self.flight = Some(Flight {
            target: point,
            distance: depth.max(1e-3 * camera.scene_radius),
        });
    }

    fn fly(&mut self, view: &mut View, seconds: f32) -> bool {
        let Some(flight) = self.flight else {
            return false;
        };
        let camera = &mut view.camera;
        let left = (-FLIGHT_SPEED * seconds).exp();
        camera.target = flight.target + (camera.target - flight.target) * left;
        camera.distance = flight.distance + (camera.distance - flight.distance) * left;
        if camera.target.distance(flight.target) < 1e-4 * camera.scene_radius {
            camera.target = flight.target;
            camera.distance = flight.distance;
            self.flight = None;
        }
        true
    }
}

fn go(view: &mut View, way: Way, by: Vec2, size: Vec2) {
    match way {
        Way::Pan => view.camera.pan(by, size),
        Way::Orbit => view.camera.orbit(by, size),
    }
}

impl Navigation {
    /// Do keys fly the camera?
    pub fn is_flying(&self) -> bool {
        self.flying.is_some()
    }

    /// Begins or ends to fly.
    pub fn set_flying(&mut self, flies: bool) {
        self.flying = flies.then_some(Flying { speed: SPEED });
    }

    /// Begins or ends to fly, and says how.
    pub fn toggle_flight(&mut self, ctx: &egui::Context, notices: &mut Notices) {
        let flies = !self.is_flying();
        self.set_flying(flies);
        if flies {
            let text =
                "Flying: W A S D, E up, Q down, drag to look, wheel for the speed. V ends it";
            notices.say(ctx, text, false);
        }
    }

    /// While it flies, its keys mean nothing else.
    pub fn keep_keys(&self, ctx: &egui::Context) {
        if !self.is_flying() || ctx.text_edit_focused() {
            return;
        }
        ctx.input_mut(|input| {
            input.events.retain(|event| {
                !matches!(event, egui::Event::Key { key, modifiers, .. }
                    if !modifiers.command && WAYS.iter().any(|(way, _)| way == key))
            });
        });
    }

    /// Goes where the keys that are held lead; true if it went.
    pub(super) fn travel(&self, ctx: &egui::Context, view: &mut View, seconds: f32) -> bool {
        let Some(flying) = self.flying.filter(|_| !ctx.text_edit_focused()) else {
            return false;
        };
        let (way, modifiers) = ctx.input(|input| {
            let held = WAYS.iter().filter(|(key, _)| input.key_down(*key));
            let way: Vec3 = held.map(|(_, way)| *way).sum();
            let free = if input.modifiers.command {
                Vec3::ZERO
            } else {
                way
            };
            (free, input.modifiers)
        });
        if way == Vec3::ZERO {
            return false;
        }
        let speed = flying.speed_with(modifiers);
        let length = speed * seconds.min(LONGEST) * view.camera.scene_radius;
        view.camera.travel(way.normalize() * length);
        true
    }
}
