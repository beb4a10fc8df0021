//! The layout round the picture and over it: the panel, the atlas beside it, one card over it, or nothing.

use std::time::Duration;

use egui::{Rangef, Rect, Sense, Stroke, Ui};
use myxo::render::View;
use myxo::scene::settings::Show;

use crate::lab::navigation::{Drags, Navigation};
use crate::lab::places::Marked as _;
use crate::lab::theme;

/// Width of the panel, points: at first, and the range to which it can be dragged.
pub const PANEL_WIDTH: f32 = 336.0;
pub const PANEL_WIDTHS: Rangef = Rangef {
    min: 300.0,
    max: 640.0,
};

/// Width of the gallery with one column of pictures and with two, points.
pub const GALLERY_WIDTHS: [f32; 2] = [186.0, 288.0];
/// A picture of this width is worth more than a second column, points.
const WIDE_PICTURE: f32 = 440.0;

/// The least width that the panel leaves for the picture, points.
const LEAST_PICTURE: f32 = 160.0;

/// Half of what counts as the panel's edge, points.
const GRIP: f32 = 3.0;

/// After this many seconds without a movement the pointer is hidden over the picture alone.
pub const POINTER_RESTS: f64 = 2.0;

/// Cards over the picture. At most one is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Card {
    /// The list of controls.
    Help,
    /// Exports.
    Exports,
}

/// The layout of the window.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Is the panel shown?
    pub panel: bool,
    /// Its width, points.
    pub panel_width: f32,
    /// A light interface; else a dark one.
    pub light: bool,
    /// The picture alone, without anything round it.
    pub alone: bool,
    /// The atlas beside the picture.
    pub split: bool,
    /// The pointer over that.
    pub beside: Navigation,
    /// The network's lines over the picture.
    pub network: bool,
    /// The gallery beside the picture.
    pub gallery: bool,
    /// The strip of kept states is unfolded.
    pub timeline: bool,
    /// The camera goes on for a moment after a drag.
    pub glides: bool,
    card: Option<Card>,
}

impl Default for Layout {
    fn default() -> Self {
        Self {
            panel: true,
            panel_width: PANEL_WIDTH,
            light: false,
            alone: false,
            split: false,
            beside: Navigation::default(),
            network: false,
            gallery: false,
            timeline: false,
            glides: true,
            card: None,
        }
    }
}

impl Layout {
    /// Is it over the picture?
    pub fn shows(&self, card: Card) -> bool {
        self.card == Some(card)
    }

    /// Is anything over the picture?
    pub fn shows_a_card(&self) -> bool {
        self.card.is_some()
    }

    /// Shows a card, or no longer.
    pub fn toggle(&mut self, card: Card) {
        self.card = (self.card != Some(card)).then_some(card);
    }

    /// This card is closed; another one stays.
    pub fn close(&mut self, card: Card) {
        self.card.take_if(|shown| *shown == card);
    }

    /// No card is shown.
    pub fn close_card(&mut self) {
        self.card = None;
    }

    /// A light interface, or a dark one.
    pub fn set_light(&mut self, ctx: &egui::Context, light: bool) {
        self.light = light;
        theme::apply(ctx, light);
    }

    /// Is the gallery shown?
    pub fn shows_gallery(&self) -> bool {
        self.gallery && !self.alone
    }

    /// Is the panel shown in a window of this width? Where there is no room for both, the gallery takes its place.
    pub fn shows_panel(&self, window: f32) -> bool {
        let least = PANEL_WIDTHS.min + GALLERY_WIDTHS[0] + LEAST_PICTURE;
        self.panel && !self.alone && (!self.shows_gallery() || window >= least)
    }

    /// The width of the panel in a window of this width: the picture keeps a part of it.
    pub fn panel_fits(&self, window: f32) -> f32 {
        let gallery = if self.shows_gallery() {
            GALLERY_WIDTHS[0]
        } else {
            0.0
        };
        self.panel_width
            .min(window - gallery - LEAST_PICTURE)
            .max(PANEL_WIDTHS.min)
    }

    /// The width of the gallery beside a picture that has so much room with it: two columns if the picture stays wide.
    pub fn gallery_fits(room: f32) -> f32 {
        let [one, two] = GALLERY_WIDTHS;
        if room - two >= WIDE_PICTURE { two } else { one }
    }

    /// The right edge of the panel, which covers `panel`, can be dragged. The panel's contents do not change its width.
    pub fn drag_edge(&mut self, ui: &Ui, panel: Rect) {
        let edge =
            Rect::from_x_y_ranges(panel.right() - GRIP..=panel.right() + GRIP, panel.y_range());
        let response = ui.interact(edge, ui.id().with("panel edge"), Sense::drag());
        if response.hovered() || response.dragged() {
            ui.ctx().set_cursor_icon(egui::CursorIcon::ResizeHorizontal);
            let line = Stroke::new(2.0, theme::accent(ui));
            ui.painter().vline(panel.right(), panel.y_range(), line);
        }
        if let (true, Some(at)) = (response.dragged(), response.interact_pointer_pos()) {
            self.panel_width = PANEL_WIDTHS.clamp(at.x - panel.left());
        }
    }

    /// A pointer that rests on the picture alone is in the way.
    pub fn hide_resting_pointer(&self, ctx: &egui::Context) {
        if !self.alone || ctx.input(|input| input.pointer.any_down()) {
            return;
        }
        let since = ctx.input(|input| input.pointer.time_since_last_movement());
        match POINTER_RESTS - f64::from(since) {
            // Nothing else may happen until then.
            left if left > 0.0 => ctx.request_repaint_after(Duration::from_secs_f64(left)),
            _ => ctx.set_cursor_icon(egui::CursorIcon::None),
        }
    }

    /// The rectangles of the picture and of the atlas beside it, if it is shown: they meet at a whole pixel.
    pub fn parts(&self, ctx: &egui::Context, whole: Rect, show: Show) -> (Rect, Option<Rect>) {
        if !self.split || show.is_flat() {
            return (whole, None);
        }
        let scale = ctx.pixels_per_point();
        let middle = (whole.center().x * scale).round() / scale;
        let (left, right) = whole.split_left_right_at_x(middle);
        (left, Some(right))
    }
}

/// The pointer on the atlas beside the picture; true if it moves it.
pub fn move_beside(ui: &mut Ui, rect: Rect, navigation: &mut Navigation, view: &mut View) -> bool {
    let response = ui
        .allocate_rect(rect, Sense::click_and_drag())
        .marked("beside");
    response.surrender_focus();
    let mut atlas = *view;
    atlas.show = Show::Atlas;
    let moved = navigation.apply(ui, &response, Drags::of(&response), &mut atlas);
    view.atlas = atlas.atlas;
    let line = Stroke::new(1.0, theme::weak(ui));
    ui.painter().vline(rect.left(), rect.y_range(), line);
    moved.touched || response.dragged()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_card_has_the_place() {
        let mut layout = Layout::default();
        layout.toggle(Card::Help);
        layout.toggle(Card::Exports);
        assert!(layout.shows(Card::Exports) && !layout.shows(Card::Help));
        layout.close(Card::Help);
        assert!(layout.shows_a_card());
        layout.toggle(Card::Exports);
        assert!(!layout.shows_a_card());
    }

    /// Would catch: a gallery and a panel that together leave no picture.
    #[test]
    fn the_picture_keeps_room_beside_panel_and_gallery() {
        let mut layout = Layout {
            panel_width: PANEL_WIDTHS.max,
            gallery: true,
            ..Layout::default()
        };
        for window in [480.0, 640.0, 700.0, 900.0, 1280.0, 2560.0] {
            let panel = match layout.shows_panel(window) {
                true => layout.panel_fits(window),
                false => 0.0,
            };
            let room = window - panel;
            let picture = room - Layout::gallery_fits(room);
            assert!(picture >= LEAST_PICTURE, "{window}: {picture}");
            assert_eq!(panel > 0.0, window >= 646.0, "{window}");
        }
        layout.alone = true;
        assert!(!layout.shows_gallery() && !layout.shows_panel(2560.0));
    }
}
