//! Kernel times as they run: what a step takes, kernel upon kernel.

use egui::{Color32, Ui};
use egui_plot::{HoverPosition, Line, Plot, PlotPoints};

use crate::lab::facts::Times;
use crate::lab::theme;

/// Kernels with an area of their own, from the longest; the others share one.
pub const SHOWN: usize = 6;

/// Height, points.
const HEIGHT: f32 = 110.0;

/// From the longest kernel on; the last is for all others.
const COLORS: [Color32; SHOWN + 1] = [
    Color32::from_rgb(0xe8, 0xb4, 0x1c),
    Color32::from_rgb(0x3f, 0x8f, 0xc4),
    Color32::from_rgb(0xd9, 0x6b, 0x52),
    Color32::from_rgb(0x7c, 0xc0, 0x9a),
    Color32::from_rgb(0x8e, 0x6c, 0xb5),
    Color32::from_rgb(0xc9, 0xc4, 0xa8),
    Color32::from_rgb(0x5a, 0x5d, 0x66),
];

/// The colour of the kernel with this rank by time.
pub fn color_of(rank: usize) -> Color32 {
    COLORS[rank.min(SHOWN)]
}

/// Plots recent times of steps as stacked kernels, the longest at the bottom. Without measurements it plots nothing.
pub fn kernel_plot(ui: &mut Ui, times: &Times) {
    let len = times.history.len();
    if len < 2 || times.kernels.is_empty() {
        return;
    }
    let ranked: Vec<&str> = times.kernels.iter().map(|k| k.name.as_str()).collect();
    let rank = |name: &str| {
        let place = ranked.iter().position(|other| *other == name);
        place.unwrap_or(SHOWN).min(ranked.len()).min(SHOWN)
    };
    let plot = Plot::new("kernel times")
        .height(HEIGHT)
        .show_x(false)
        .show_axes([false, true])
        .show_grid([false, true])
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .show_background(false)
        .include_y(0.0)
        .include_x(0.0)
        .include_x(len as f64 - 1.0)
        .y_axis_min_width(28.0)
        .y_axis_formatter(|mark, _| format!("{}", mark.value))
        .label_formatter(|hovered| match hovered {
            HoverPosition::NearDataPoint {
                plot_name,
                position,
                ..
            } => Some(format!("{plot_name}\n{:.2} ms", position.y)),
            HoverPosition::Elsewhere { .. } => None,
        });
    let highest = 1.1 * times.history.usual().max(1e-3);
    plot.show(ui, |plot| {
        plot.set_plot_bounds_y(0.0..=highest);
        // Each area reaches down to zero, so the uppermost comes first.
        for top in (0..=ranked.len().min(SHOWN)).rev() {
            let below = |name: &str| rank(name) <= top;
            let sums = times.history.sums(&below);
            let points: PlotPoints<'_> = sums.enumerate().map(|(x, sum)| [x as f64, sum]).collect();
            let name = ranked.get(top).filter(|_| top < SHOWN);
            let name = name.map_or("all others, up to here", |name| *name);
            plot.line(
                Line::new(format!("up to {name}"), points)
                    .color(color_of(top))
                    .width(1.0)
                    .fill(0.0)
                    .fill_alpha(1.0),
            );
        }
    });
    ui.label(
        egui::RichText::new("milliseconds a step in recent frames, kernels stacked")
            .small()
            .color(theme::weak(ui)),
    );
    ui.add_space(4.0);
}
