//! Flying: keys move the camera, drags turn it where it stands, the wheel changes how quickly it goes.

use egui::Key;
use glam::Vec3;
use myxo::render::view::View;

use crate::lab::navigation::Navigation;
use crate::lab::notices::Notices;

/// Scene radii a second, at first, and what the wheel can make of them.
const SPEED: f32 = 0.8;
const SPEEDS: (f32, f32) = (0.02, 20.0);
/// How much faster it goes while Shift is held.
const HURRY: f32 = 4.0;
/// A frame that took longer than this many seconds is no reason to jump.
const LONGEST: f32 = 0.1;

/// Keys, and where they lead: right, up, backward.
const WAYS: &[(Key, Vec3)] = &[
    (Key::W, Vec3::NEG_Z),
    (Key::S, Vec3::Z),
    (Key::A, Vec3::NEG_X),
    (Key::D, Vec3::X),
    (Key::Q, Vec3::NEG_Y),
    (Key::E, Vec3::Y),
];

/// While keys fly the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flying {
    /// Scene radii a second.
    pub speed: f32,
}

impl Flying {
    /// The speed while these keys are held.
    pub fn speed_with(&self, modifiers: egui::Modifiers) -> f32 {
        self.speed * if modifiers.shift { HURRY } else { 1.0 }
    }

    /// Faster or slower.
    pub fn change_speed(&mut self, factor: f32) {
        self.speed = (self.speed * factor).clamp(SPEEDS.0, SPEEDS.1);
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
