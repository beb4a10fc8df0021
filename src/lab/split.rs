//! The atlas beside the picture.

use egui::{Rect, Sense, Stroke, Ui};
use myxo::scene::settings::Show;

use super::interface::Interface;
use super::navigation::{Drags, Navigation};
use super::places::Marked as _;
use super::theme;

impl Interface {
    /// Where the picture goes, and where the atlas beside it, if it is shown: they meet at a whole pixel.
    pub(super) fn parts(&self, ui: &Ui, whole: Rect) -> (Rect, Option<Rect>) {
        if !self.split || self.document.view.show.is_flat() {
            return (whole, None);
        }
        let scale = ui.ctx().pixels_per_point();
        let middle = (whole.center().x * scale).round() / scale;
        let (left, right) = whole.split_left_right_at_x(middle);
        (left, Some(right))
    }

    /// The hand on the atlas; true if it moves it.
    pub(super) fn move_beside(&mut self, ui: &mut Ui, rect: Rect) -> bool {
        let response = ui
            .allocate_rect(rect, Sense::click_and_drag())
            .marked("beside");
        let mut view = self.document.view;
        view.show = Show::Atlas;
        let moved = Navigation::default().apply(ui, &response, Drags::of(&response), &mut view);
        self.document.view.atlas = view.atlas;
        let line = Stroke::new(1.0, theme::weak(ui));
        ui.painter().vline(rect.left(), rect.y_range(), line);
        moved.touched || response.dragged()
    }
}
