//! How the interface looks: quiet, so that the picture is what glows; slime yellow for what is active. Dark or light.

use egui::{
    Color32, CornerRadius, FontFamily, FontId, Margin, Stroke, TextStyle, Ui, Visuals, vec2,
};

/// Width of the bar that scrolls, points.
pub const SCROLL_BAR: f32 = 6.0;

/// The colours of one of the two.
struct Palette {
    /// Marks what is active, changed or under the pointer.
    accent: Color32,
    /// Marks values that wait for a restart, and warnings.
    pending: Color32,
    error: Color32,
    panel: Color32,
    /// Between parts of the panel.
    line: Color32,
    /// Text that is read when it is looked for.
    weak: Color32,
    text: Color32,
    strong: Color32,
    field: Color32,
    faint: Color32,
    button: Color32,
    button_hovered: Color32,
}

/// How much of its colour is left of what is disabled.
const DISABLED: f32 = 0.68;

const DARK: Palette = Palette {
    accent: Color32::from_rgb(0xe8, 0xb4, 0x1c),
    pending: Color32::from_rgb(0xf0, 0x8a, 0x3c),
    error: Color32::from_rgb(0xf2, 0x6d, 0x5f),
    panel: Color32::from_rgb(0x15, 0x16, 0x19),
    line: Color32::from_rgb(0x2a, 0x2c, 0x31),
    weak: Color32::from_rgb(0x8b, 0x8e, 0x96),
    text: Color32::from_rgb(0xd6, 0xd7, 0xda),
    strong: Color32::from_rgb(0xf4, 0xf4, 0xf5),
    field: Color32::from_rgb(0x0d, 0x0e, 0x10),
    faint: Color32::from_rgb(0x1a, 0x1b, 0x1f),
    button: Color32::from_rgb(0x26, 0x28, 0x2d),
    button_hovered: Color32::from_rgb(0x33, 0x36, 0x3d),
};

const LIGHT: Palette = Palette {
    accent: Color32::from_rgb(0x8f, 0x67, 0x00),
    pending: Color32::from_rgb(0xb4, 0x51, 0x00),
    error: Color32::from_rgb(0xb8, 0x2a, 0x1c),
    panel: Color32::from_rgb(0xf3, 0xf2, 0xee),
    line: Color32::from_rgb(0xd6, 0xd4, 0xcd),
    weak: Color32::from_rgb(0x67, 0x66, 0x60),
    text: Color32::from_rgb(0x2b, 0x2a, 0x27),
    strong: Color32::from_rgb(0x0c, 0x0c, 0x0b),
    field: Color32::from_rgb(0xfc, 0xfb, 0xf9),
    faint: Color32::from_rgb(0xea, 0xe9, 0xe4),
    button: Color32::from_rgb(0xe0, 0xde, 0xd7),
    button_hovered: Color32::from_rgb(0xd3, 0xd0, 0xc7),
};

/// Marks what is active, changed or under the pointer.
pub fn accent(ui: &Ui) -> Color32 {
    ui.visuals().hyperlink_color
}

/// Marks values that wait for a restart, and warnings.
pub fn pending(ui: &Ui) -> Color32 {
    ui.visuals().warn_fg_color
}

/// Errors.
pub fn error(ui: &Ui) -> Color32 {
    ui.visuals().error_fg_color
}

/// The panel.
pub fn panel(ui: &Ui) -> Color32 {
    ui.visuals().panel_fill
}

/// Text that is read when it is looked for.
pub fn weak(ui: &Ui) -> Color32 {
    ui.visuals().weak_text_color()
}

/// Text on something that is filled with the colour of what is active or waits.
pub fn on_fill(ui: &Ui) -> Color32 {
    on_accent(ui.visuals())
}

fn on_accent(visuals: &Visuals) -> Color32 {
    if visuals.dark_mode {
        Color32::BLACK
    } else {
        Color32::WHITE
    }
}

/// Fills the selection with the colour of active items, also for text in that colour.
pub fn fill_selection(visuals: &mut Visuals) {
    visuals.selection.bg_fill = visuals.hyperlink_color;
    visuals.selection.stroke.color = on_accent(visuals);
}

/// A box that is ticked or not, with a line round it: its ground alone is hardly another than that which it stands on.
pub fn switch(ui: &mut Ui, is_on: &mut bool, text: &str) -> egui::Response {
    ui.scope(|ui| {
        let line = Stroke::new(1.0, weak(ui));
        let visuals = ui.visuals_mut();
        let widgets = &mut visuals.widgets;
        for widget in [
            &mut widgets.inactive,
            &mut widgets.hovered,
            &mut widgets.active,
        ] {
            widget.bg_fill = visuals.extreme_bg_color;
            widget.bg_stroke = line;
        }
        ui.checkbox(is_on, text)
    })
    .inner
}

/// Gives a context the look.
pub fn apply(ctx: &egui::Context, light: bool) {
    // On a slow device the frame between press and release may be a long one, and the click is one all the same.
    ctx.options_mut(|options| options.input_options.max_click_duration = f64::INFINITY);
    ctx.set_theme(if light {
        egui::Theme::Light
    } else {
        egui::Theme::Dark
    });
    let visuals = visuals(light);
    ctx.all_styles_mut(|style| {
        style.visuals = visuals.clone();
        style.spacing.item_spacing = vec2(8.0, 4.0);
        style.spacing.button_padding = vec2(9.0, 4.0);
        style.spacing.interact_size.y = 22.0;
        style.spacing.slider_rail_height = 4.0;
        style.spacing.indent = 10.0;
        // As wide as the room that the panel leaves for it.
        style.spacing.scroll.bar_width = SCROLL_BAR;
        // Fading is between colours that are not opaque, which come out too bright half way.
        style.spacing.scroll.fade.strength = 0.0;
        style.interaction.tooltip_delay = 0.35;
        // Ctrl C takes the scene, and no text that happens to be selected.
        style.interaction.selectable_labels = false;
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

fn visuals(light: bool) -> Visuals {
    let (mut visuals, palette) = if light {
        (Visuals::light(), LIGHT)
    } else {
        (Visuals::dark(), DARK)
    };
    visuals.panel_fill = palette.panel;
    visuals.window_fill = palette.panel;
    visuals.window_stroke = Stroke::new(1.0, palette.line);
    visuals.extreme_bg_color = palette.field;
    visuals.faint_bg_color = palette.faint;
    visuals.selection.bg_fill = palette.accent.gamma_multiply(0.32);
    // Amber on what is tinted with it is read in the dark only.
    let chosen = if light {
        palette.strong
    } else {
        palette.accent
    };
    visuals.selection.stroke = Stroke::new(1.0, chosen);
    visuals.hyperlink_color = palette.accent;
    visuals.warn_fg_color = palette.pending;
    visuals.error_fg_color = palette.error;
    visuals.weak_text_color = Some(palette.weak);
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
    widgets.noninteractive.bg_stroke = Stroke::new(1.0, palette.line);
    widgets.noninteractive.fg_stroke = Stroke::new(1.0, palette.text);
    let (button, hovered) = (palette.button, palette.button_hovered);
    for (widget, fill, text) in [
        (&mut widgets.inactive, button, palette.text),
        (&mut widgets.hovered, hovered, palette.strong),
        (&mut widgets.active, hovered, palette.strong),
        (&mut widgets.open, button, palette.strong),
    ] {
        widget.bg_fill = fill;
        widget.weak_bg_fill = fill;
        widget.fg_stroke = Stroke::new(1.0, text);
    }
    // Controls that have the keyboard, or are pressed.
    widgets.active.bg_stroke = Stroke::new(1.5, palette.accent);
    // Text that is disabled keeps a contrast of 4.5 to 1 on the panel.
    visuals.disabled_alpha = DISABLED;
    visuals
}

/// The frame of the panel and of the line below it.
pub fn panel_frame(ui: &Ui) -> egui::Frame {
    egui::Frame::new()
        .fill(panel(ui))
        .inner_margin(Margin::symmetric(12, 10))
}
