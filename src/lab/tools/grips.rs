//! Grips of tools while a button is down: a food, or a handle of an object.

use glam::{Vec2, Vec3};
use myxo::scene::motion::Origins;
use myxo::scene::settings::ObjectSettings;

/// The state of a press with the tool for food.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum FoodDrag {
    /// No food: the press turns the picture, or has ended.
    #[default]
    None,
    /// It was at a pixel for which it is not known yet whether food lies there.
    Asks {
        at: Vec2,
        /// The drag meanwhile, points.
        waits: egui::Vec2,
        /// It has already ended, at this pixel.
        released: Option<Vec2>,
    },
    /// It holds this food.
    Holds(usize),
    /// This food is to lie at a pixel of which it is not known yet what lies there.
    Released(usize, Vec2),
}

/// The motion of a handle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Handle {
    /// Moves along an axis.
    Move(usize),
    /// Moves in the plane of the picture.
    Plane,
    /// Turns about an axis.
    Turn(usize),
    /// Scales.
    Scale,
}

/// A handle that is held.
#[derive(Clone, Debug, PartialEq)]
pub struct Grab {
    pub handle: Handle,
    /// The object as it was.
    pub object: ObjectSettings,
    /// The pivot, as origins of its coordinates.
    pub pivot: Origins,
    /// Its middle at the press, world space.
    pub middle: Vec3,
    /// The pointer at the press, pixels of the picture.
    pub from: Vec2,
    /// Radius of the rings, world length.
    pub ring: f32,
    /// How much larger the object shall become.
    pub scaled: f32,
    /// It was put back where it was, but the button is still down.
    pub is_given_up: bool,
}
