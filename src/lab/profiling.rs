//! Profile of the time for steps, kernels, pictures and the rest, measured while the window runs.

use egui::{Align, Layout, RichText, Sense, Ui, vec2};

use crate::lab::command::Command;
use crate::lab::desk::Desk;
use crate::lab::facts::Times;
use crate::lab::places::{Marked as _, note_value};
use crate::lab::plot::{color_of, kernel_plot};
use crate::lab::theme;

/// Descriptions of a step's kernels, by the names of their timers.
const KERNELS: &[(&str, &str)] = &[
    (
        "advance",
        "Each particle reads its sensors, turns, walks and deposits",
    ),
    (
        "walk_sensors",
        "advance or wish, for particles whose sensors cannot go straight ahead in the atlas",
    ),
    (
        "advance_near",
        "advance or wish, for particles near other objects",
    ),
    (
        "walk_near",
        "advance or wish, for particles near other objects whose sensors must walk",
    ),
    (
        "diffuse",
        "The trail spreads, takes up the deposits and decays",
    ),
    (
        "diffuse_seams",
        "The trail spreads over the seams of the atlas",
    ),
    (
        "exchange_seams",
        "Fills the texels outside of charts, so that reads see no seam",
    ),
    (
        "sort_count",
        "Counts the particles in each tile of the atlas, on a graphics card in each sixteenth of a tile",
    ),
    ("sort_sums", "Adds up the counts of many tiles at a time"),
    (
        "sort_scan",
        "Sums the counts, so that each tile has its place",
    ),
    (
        "sort_scatter",
        "Puts particles in the order of tiles, so that neighbours read the same memory",
    ),
    (
        "distance_tiles",
        "Finds tiles of the atlas that may be near other objects, and triangles to begin the search with",
    ),
    (
        "distance",
        "The signed distance of each texel in such tiles to the nearest other object",
    ),
    (
        "distance_brute",
        "The signed distance of each texel to the nearest triangle of all others",
    ),
    (
        "distance_merge",
        "Takes the nearest of the distances that were drawn",
    ),
    (
        "unfold",
        "Finds where walks that another object covers continue, on that object",
    ),
    (
        "wish",
        "Every particle senses, turns, walks and claims the cell that it would come to, with one particle a cell",
    ),
    (
        "arrive",
        "Particles that have won cells move there, and the others stay",
    ),
    (
        "land_claim",
        "Particles that come over from another object claim cells there",
    ),
    (
        "land_settle",
        "Particles that have won no cell there stay on their object",
    ),
    ("count_cells", "Counts the particles in each cell"),
    (
        "divide",
        "Particles die, or claim a free cell to divide into, by how crowded it is round them and how hungry they are",
    ),
    ("divide_settle", "Finds which particles divide"),
    (
        "divide_number",
        "Numbers particles that divide, and ids that are free",
    ),
    ("divide_list", "Lists the particles that divide"),
    ("divide_begin", "Particles are born"),
    (
        "close_list",
        "Prepares the lists of particles that change objects",
    ),
    (
        "limit_count",
        "Counts the particles that wish to change objects, where the transfer buffer is too small",
    ),
    ("limit_pick", "Finds which particles may change objects"),
    ("limit_list", "Lists the particles that may change objects"),
    (
        "transfer_out",
        "Particles that change objects find their places on the other object",
    ),
    (
        "transfer_in",
        "Particles that change objects begin on the other object",
    ),
    (
        "move_borders",
        "Moves the borders between the objects' parts of the buffer",
    ),
    (
        "defragment_scan",
        "Finds particles that lie in another object's part of the buffer",
    ),
    (
        "defragment_swap",
        "Brings particles to their object's part of the buffer",
    ),
    ("respawn", "Particles that went into another object restart"),
    ("digest", "Takes away the food that was eaten"),
    ("scent", "The field by which food and markers attract"),
    (
        "scent_across",
        "The scent that crosses from object to object where they touch",
    ),
    ("project", "Adds to the trail what food projects into it"),
    (
        "trail_across",
        "The trail that spreads from object to object where their surfaces meet",
    ),
    ("paint", "A dab of a brush"),
    ("teleport", "A dab of the brush that brings particles"),
    ("update", "Numbers that the host writes for the step"),
    ("fill", "Counters that begin at zero"),
    ("copy_words", "A copy within the device"),
];

/// A sentence on what a kernel does.
fn kernel_in_words(name: &str) -> Option<&'static str> {
    let found = KERNELS.iter().find(|(kernel, _)| *kernel == name);
    found.map(|(_, what)| *what)
}

/// The section of the panel: plot, sums, table, and what can be done with them.
pub fn show(ui: &mut Ui, desk: &mut Desk<'_>) {
    let facts = desk.facts;
    if !facts.has_timestamps {
        let reason = RichText::new("unavailable on this device");
        ui.label(reason.color(theme::weak(ui)));
        return;
    }
    controls(ui, desk);
    if facts.times.kernels.is_empty() && facts.frozen.is_none() {
        let reason = RichText::new("measured while it runs");
        ui.label(reason.color(theme::weak(ui)));
        return;
    }
    note_value(ui.ctx(), "times.frozen", || {
        facts.frozen.is_some().to_string()
    });
    let times = facts.shown_times();
    kernel_plot(ui, times);
    sums(ui, times);
    table(ui, times);
}

fn controls(ui: &mut Ui, desk: &mut Desk<'_>) {
    let facts = desk.facts;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let is_frozen = facts.frozen.is_some();
        let freeze = egui::Button::selectable(is_frozen, "Freeze");
        let freeze = ui.add(freeze).on_hover_text(
            "Keeps the times that are shown, to read them at leisure; measuring continues",
        );
        if freeze.marked("times.freeze").clicked() {
            desk.commands.push(Command::FreezeTimes(!is_frozen));
        }
        let clear = ui.button("Clear").on_hover_text("Restarts the measurement");
        if clear.marked("times.clear").clicked() {
            desk.commands.push(Command::ClearTimes);
        }
        let copy = ui
            .button("Copy")
            .on_hover_text("Puts the table into the clipboard, with tabs between columns");
        let times = facts.shown_times();
        let export = ui
            .add_enabled(times.step_ms.is_some(), egui::Button::new("Export"))
            .on_hover_text(
                "Writes the times as myxo profile does: a report, and a trace for ui.perfetto.dev, into the folder for exports",
            )
            .on_disabled_hover_text("There are no times yet: they come while it runs");
        if export.marked("times.export").clicked() {
            desk.commands.push(Command::SaveTimes);
        }
        if copy.marked("times.copy").clicked() {
            ui.ctx()
                .copy_text(as_text(&facts.scene, &facts.device, times));
            desk.notices
                .say(ui.ctx(), "The times are in the clipboard", false);
        }
    });
}

/// A line a kind of work.
fn sums(ui: &mut Ui, times: &Times) {
    let kernels: f64 = times.kernels.iter().map(|kernel| kernel.mean_ms).sum();
    let rows = [
        ("step", times.step_ms, "GPU time of a step"),
        ("· kernels", Some(kernels), "Of that, all kernels together"),
        (
            "· between",
            times.step_ms.map(|_| times.between_ms),
            "Of that, what no kernel takes: barriers and timestamps",
        ),
        (
            "picture",
            times.draw_ms,
            "GPU time of a picture with the interface, without steps",
        ),
        (
            "host, waiting",
            times.host_ms,
            "From one picture to the next, less what the GPU takes for both",
        ),
    ];
    egui::Grid::new("sums of times")
        .num_columns(2)
        .spacing(vec2(12.0, 2.0))
        .show(ui, |ui| {
            for (name, ms, hint) in rows {
                let Some(ms) = ms else {
                    continue;
                };
                ui.label(name).on_hover_text(hint);
                number(ui, format!("{} ms", milliseconds(ms)));
                ui.end_row();
            }
        });
    ui.add_space(4.0);
}

/// The table of kernel times.
fn table(ui: &mut Ui, times: &Times) {
    egui::Grid::new("kernels")
        .num_columns(5)
        .spacing(vec2(5.0, 3.0))
        .show(ui, |ui| {
            for (title, hint) in [
                ("kernel", "As the shader is called"),
                ("calls", "In a step"),
                ("a call", "Mean time of one, milliseconds"),
                ("mean ms", "Mean time in a step"),
                ("p95 ms", "95 % of the steps that have any are not longer"),
            ] {
                let title = RichText::new(title).small().color(theme::weak(ui));
                ui.label(title).on_hover_text(hint);
            }
            ui.end_row();
            for (rank, kernel) in times.kernels.iter().enumerate() {
                let name = ui.horizontal(|ui| {
                    ui.spacing_mut().item_spacing.x = 5.0;
                    let (rect, _) = ui.allocate_exact_size(vec2(8.0, 8.0), Sense::hover());
                    ui.painter().rect_filled(rect, 2.0, color_of(rank));
                    ui.label(&kernel.name)
                });
                let what = kernel_in_words(&kernel.name).unwrap_or("Part of a step");
                let share = 100.0 * kernel.share;
                (name.inner).on_hover_text(format!("{what}; {share:.0} % of the step"));
                number(ui, calls(kernel.per_step));
                number(ui, milliseconds(kernel.mean_ms / kernel.per_step.max(1e-9)));
                number(ui, milliseconds(kernel.mean_ms));
                number(ui, milliseconds(kernel.p95_ms));
                ui.end_row();
            }
        });
}

fn number(ui: &mut Ui, text: String) {
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        ui.label(RichText::new(text).monospace())
    });
}

/// How often in a step; what does not run in every one, as sorts, with its decimals.
fn calls(per_step: f64) -> String {
    match per_step {
        1.0.. => format!("{per_step:.0}"),
        _ => format!("{per_step:.2}"),
    }
}

/// With three digits, and never too wide for the table.
fn milliseconds(ms: f64) -> String {
    match ms {
        100.0.. => format!("{ms:.0}"),
        10.0.. => format!("{ms:.1}"),
        1.0.. => format!("{ms:.2}"),
        _ => format!("{ms:.3}"),
    }
}

/// The table as text, a line a kernel, with tabs between columns.
fn as_text(scene: &str, device: &str, times: &Times) -> String {
    let mut text = format!("{scene} on {device}\nkernel\tcalls a step\tmean ms\tp95 ms\tshare\n");
    for kernel in &times.kernels {
        text += &format!(
            "{}\t{:.3}\t{:.4}\t{:.4}\t{:.3}\n",
            kernel.name, kernel.per_step, kernel.mean_ms, kernel.p95_ms, kernel.share
        );
    }
    for (name, ms) in [
        ("whole step", times.step_ms),
        ("between kernels", times.step_ms.map(|_| times.between_ms)),
        ("picture", times.draw_ms),
        ("host and waiting", times.host_ms),
    ] {
        if let Some(ms) = ms {
            text += &format!("{name}\t\t{ms:.4}\n");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::facts::KernelTime;

    /// A kernel of a step without a description would have no tooltip.
    #[test]
    fn every_kernel_of_a_step_is_described() {
        let without = [
            "arithmetic",
            "average",
            "bloom_down",
            "bloom_first",
            "bloom_up",
            "develop",
            "draw_order",
            "expose",
            "smooth_edges",
            "soften",
            "trail_histogram",
        ];
        let shaders = concat!(env!("CARGO_MANIFEST_DIR"), "/shaders");
        for entry in std::fs::read_dir(shaders).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_stem().unwrap().to_str().unwrap();
            let is_kernel = path.extension().is_some_and(|ending| ending == "comp");
            if is_kernel && !without.contains(&name) && !name.ends_with("_queries") {
                assert!(kernel_in_words(name).is_some(), "{name}");
            }
        }
    }

    #[test]
    fn the_table_is_text_with_tabs() {
        let times = Times {
            step_ms: Some(2.5),
            between_ms: 0.5,
            kernels: vec![KernelTime {
                name: "advance".to_owned(),
                per_step: 1.0,
                mean_ms: 2.0,
                p95_ms: 2.25,
                share: 0.8,
            }],
            ..Times::default()
        };
        let text = as_text("torus", "a device", &times);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "torus on a device");
        assert_eq!(lines[2], "advance\t1.000\t2.0000\t2.2500\t0.800");
        assert_eq!(lines[4], "between kernels\t\t0.5000");
        assert_eq!(lines.len(), 5);
    }
}
