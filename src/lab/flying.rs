//! Flying: keys move the camera, drags turn it where it stands, the wheel changes how quickly it goes.

use egui::Key;
use glam::Vec3;

/// Scene radii a second, at first, and what the wheel can make of them.
pub const SPEED: f32 = 0.8;
const SPEEDS: (f32, f32) = (0.02, 20.0);
/// How much faster it goes while Shift is held.
const HURRY: f32 = 4.0;
/// A frame that took longer than this many seconds is no reason to jump.
pub const LONGEST: f32 = 0.1;

/// Keys, and where they lead: right, up, backward.
pub const WAYS: &[(Key, Vec3)] = &[
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
