//! How the interface looks: dark and quiet, so that the picture is what glows; slime yellow for what is active.

use egui::{Color32, CornerRadius, FontFamily, FontId, Margin, Stroke, TextStyle, Visuals, vec2};

/// What is active, changed or under the hand.
pub const ACCENT: Color32 = Color32::from_rgb(0xe8, 0xb4, 0x1c);
/// What waits for a restart, and warnings.
pub const PENDING: Color32 = Color32::from_rgb(0xf0, 0x8a, 0x3c);
/// Errors.
pub const ERROR: Color32 = Color32::from_rgb(0xf2, 0x6d, 0x5f);
/// The panel.
pub const PANEL: Color32 = Color32::from_rgb(0x15, 0x16, 0x19);
/// Lines between parts of the panel.
pub const LINE: Color32 = Color32::from_rgb(0x2a, 0x2c, 0x31);
/// Text that is read when it is looked for.
pub const WEAK: Color32 = Color32::from_rgb(0x8b, 0x8e, 0x96);
const TEXT: Color32 = Color32::from_rgb(0xd6, 0xd7, 0xda);
const STRONG: Color32 = Color32::from_rgb(0xf4, 0xf4, 0xf5);
const FIELD: Color32 = Color32::from_rgb(0x0d, 0x0e, 0x10);
const BUTTON: Color32 = Color32::from_rgb(0x26, 0x28, 0x2d);
const BUTTON_HOVERED: Color32 = Color32::from_rgb(0x33, 0x36, 0x3d);

/// Gives a context the look.
pub fn apply(ctx: &egui::Context) {
    ctx.set_theme(egui::Theme::Dark);
    ctx.all_styles_mut(|style| {
        style.visuals = visuals();
        style.spacing.item_spacing = vec2(8.0, 4.0);
        style.spacing.button_padding = vec2(9.0, 4.0);
        style.spacing.interact_size.y = 22.0;
        style.spacing.slider_rail_height = 4.0;
        style.spacing.indent = 10.0;
        style.interaction.tooltip_delay = 0.35;
        style.text_styles = [
            (TextStyle::Heading, 17.0),
            (TextStyle::Body, 13.5),
            (TextStyle::Button, 13.5),
            (TextStyle::Small, 11.5),
        ]
        .into_iter()
        .map(|(text, size)| (text, FontId::new(size, FontFamily::Proportional)))
        .chain([(
            TextStyle::Monospace,
            FontId::new(12.5, FontFamily::Monospace),
        )])
        .collect();
    });
}

fn visuals() -> Visuals {
    let mut visuals = Visuals::dark();
    visuals.panel_fill = PANEL;
    visuals.window_fill = PANEL;
    visuals.window_stroke = Stroke::new(1.0, LINE);
    visuals.extreme_bg_color = FIELD;
    visuals.faint_bg_color = Color32::from_rgb(0x1a, 0x1b, 0x1f);
    visuals.selection.bg_fill = ACCENT.gamma_multiply(0.32);
    visuals.selection.stroke = Stroke::new(1.0, ACCENT);
    visuals.hyperlink_color = ACCENT;
    visuals.warn_fg_color = PENDING;
    visuals.error_fg_color = ERROR;
    visuals.slider_trailing_fill = true;
    visuals.striped = false;
    let widgets = &mut visuals.widgets;
    for widget in [
        &mut widgets.noninteractive,
        &mut widgets.inactive,
        &mut widgets.hovered,
        &mut widgets.active,
        &mut widgets.open,
    ] {
        widget.corner_radius = CornerRadius::same(4);
        widget.expansion = 0.0;
        widget.bg_stroke = Stroke::NONE;
    }
    widgets.noninteractive.bg_stroke = Stroke::new(1.0, LINE);
    widgets.noninteractive.fg_stroke = Stroke::new(1.0, TEXT);
    for (widget, fill, text) in [
        (&mut widgets.inactive, BUTTON, TEXT),
        (&mut widgets.hovered, BUTTON_HOVERED, STRONG),
        (&mut widgets.active, BUTTON_HOVERED, STRONG),
        (&mut widgets.open, BUTTON, STRONG),
    ] {
        widget.bg_fill = fill;
        widget.weak_bg_fill = fill;
        widget.fg_stroke = Stroke::new(1.0, text);
    }
    visuals
}

/// The frame of the panel and of the line below it.
pub fn panel_frame() -> egui::Frame {
    egui::Frame::new()
        .fill(PANEL)
        .inner_margin(Margin::symmetric(12, 10))
}
