//! The picture alone, for those who watch: nothing round it, no news over it, and no pointer that rests.

use std::time::Duration;

use super::interface::Interface;
use super::notices::HOW_BACK;

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
            self.notices.say(ctx, HOW_BACK, false);
        }
    }

    /// A pointer that rests on the picture alone is in the way.
    pub(super) fn hide_resting_pointer(&self, ctx: &egui::Context) {
        if !self.performing || ctx.input(|input| input.pointer.any_down()) {
            return;
        }
        let since = ctx.input(|input| input.pointer.time_since_last_movement());
        match POINTER_RESTS - f64::from(since) {
            // Nothing else may happen until then.
            left if left > 0.0 => ctx.request_repaint_after(Duration::from_secs_f64(left)),
            _ => ctx.set_cursor_icon(egui::CursorIcon::None),
        }
    }
}
