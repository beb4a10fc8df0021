//! Shows a frame: the interface, and under it a picture, a new one or the last one.

use std::time::Duration;

use myxo::render::View;

use crate::lab::interface::Shown;
use crate::lab::place::Place;
use crate::lab::stage::Sizes;

/// The contents that a frame draws into the window.
pub struct Shot {
    pub view: View,
    /// The picture that is there will do.
    pub answers: bool,
    /// There is no other, for steps are under way.
    pub is_between: bool,
    /// The place of the picture, and of the atlas beside it.
    pub picture: Place,
    pub beside: Option<Place>,
    pub is_moving: bool,
    /// Is the picture refined if it is there already?
    pub refines: bool,
    /// The interface over both.
    pub primitives: Vec<egui::ClippedPrimitive>,
    pub pixels_per_point: f32,
}

fn sizes(picture: &Place, beside: Option<&Place>) -> Sizes {
    (picture.size, beside.map(|place| place.size))
}

impl Shot {
    pub fn sizes(&self) -> Sizes {
        sizes(&self.picture, self.beside.as_ref())
    }
}

impl Seen {
    pub fn sizes(&self) -> Sizes {
        sizes(&self.picture, self.beside.as_ref())
    }
}

/// The result of the interface in a frame.
pub struct Seen {
    pub shown: Shown,
    pub primitives: Vec<egui::ClippedPrimitive>,
    pub pixels_per_point: f32,
    /// The place of the picture, and of the atlas beside it, if they have a size.
    pub picture: Place,
    pub beside: Option<Place>,
    /// When the interface wants to be shown again.
    pub repaint: Option<Duration>,
    /// There was input.
    pub is_asked: bool,
}
