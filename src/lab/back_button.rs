//! The buttons that lead back to a state that was left.

use egui::{Button, Response, RichText, Ui};

use myxo::plain_text::with_commas;

use crate::lab::facts::Before;
use crate::lab::places::Marked as _;

/// A button with the step's number takes so much room, points.
const HAS_ROOM: f32 = 96.0;

impl Before {
    /// As the panel has it, where the room may be short.
    pub fn button(&self, ui: &mut Ui) -> Response {
        let button = match ui.available_width() < HAS_ROOM {
            true => Button::new(sign()),
            false => Button::new((sign(), RichText::new(self.at()).small())),
        };
        let button = ui.add(button.small()).on_hover_text(self.hint());
        button.marked("back")
    }

    /// As the gallery lists it.
    pub fn entry(&self, ui: &mut Ui) -> Response {
        let button = ui
            .button((sign(), self.listed()))
            .on_hover_text(self.hint());
        button.marked("left.grown")
    }

    fn listed(&self) -> String {
        format!("{} · {}", self.name, self.at())
    }

    /// Describes the effect of a click.
    fn hint(&self) -> String {
        format!(
            "Back to what had grown: {} at {}. What runs now is kept in its place",
            self.name,
            self.at()
        )
    }

    fn at(&self) -> String {
        format!("step {}", with_commas(self.step as f64))
    }
}

/// The letters of other texts have no such sign.
fn sign() -> RichText {
    RichText::new("↶").monospace().size(16.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn its_step_is_named() {
        let before = Before {
            name: "cube".to_owned(),
            step: 12_345,
        };
        assert_eq!(before.listed(), "cube · step 12,345");
        assert!(before.hint().contains("cube at step 12,345"));
    }
}
