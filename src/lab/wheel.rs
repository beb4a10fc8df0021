//! The wheel over a part of the window. Its motion continues for a moment after the last notch, and belongs to the part in
//! which that was.

use egui::{Event, Response, Ui, Vec2};

/// Does the continuing motion belong here?
#[derive(Clone, Copy, Debug, Default)]
pub struct Wheel {
    is_here: bool,
}

impl Wheel {
    /// How far the wheel has turned over what `response` covers in this frame, points.
    pub fn turned(&mut self, ui: &Ui, response: &Response) -> Vec2 {
        let (has_notch, delta) = ui.input(|input| {
            let mut events = input.events.iter();
            let has_notch = events.any(|event| matches!(event, Event::MouseWheel { .. }));
            (has_notch, input.smooth_scroll_delta())
        });
        if has_notch {
            self.is_here = response.hovered();
        }
        match self.is_here && response.hovered() {
            true => delta,
            false => Vec2::ZERO,
        }
    }
}
