//! The picture alone, for those who watch: nothing round it, no news over it, and no pointer that rests.

use super::interface::Interface;

/// What is told as it begins.
pub(super) const HOW_BACK: &str = "Esc brings the panel back";
/// After so many seconds without a movement the pointer rests.
pub(super) const POINTER_RESTS: f64 = 2.0;

impl Interface {
    /// The picture alone, or no longer.
    pub(super) fn perform(&mut self, ctx: &egui::Context) {
        self.performing = !self.performing;
        self.help = false;
        self.out.open = false;
        self.gallery.open = false;
        self.hands.leave_scene();
        if self.performing {
            self.notice(ctx, HOW_BACK, false);
        }
    }

    /// A pointer that rests on the picture alone is in the way.
    pub(super) fn hide_resting_pointer(&self, ctx: &egui::Context) {
        let rests = |input: &egui::InputState| {
            f64::from(input.pointer.time_since_last_movement()) >= POINTER_RESTS
                && !input.pointer.any_down()
        };
        if self.performing && ctx.input(rests) {
            ctx.set_cursor_icon(egui::CursorIcon::None);
        }
    }
}
