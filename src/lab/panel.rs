//! The panel beside the picture: run and reset, what the picture shows, every parameter, kernel times.

use std::sync::LazyLock;

use egui::{Align, Layout, RichText, ScrollArea, Ui, vec2};
use myxo::scene::builtin::PRESETS;
use myxo::scene::parameters::{OBJECT_PARAMETERS, PARAMETERS, why_idle, why_object_idle};
use myxo::scene::settings::{ObjectSettings, Part, Settings, Show};
use myxo::sim::transfers::count_text;
use myxo::sim::types::Flow;

use super::checks::Check;
use super::interface::{Command, Facts, Interface};
use super::looks::summary;
use super::places::{Marked as _, note_value};
use super::plot::kernel_plot;
use super::rows::{RowContext, grouped, row};
use super::theme;
use super::view_rows::{CAMERA_ROWS, COLOR_ROWS, DETAIL_ROWS, LIGHT_ROWS, found};
use super::widgets::{kernel_table, parse_number};

/// What the sections hold that are no rows of parameters, for those who look for it.
static PICTURE_WORDS: LazyLock<String> = LazyLock::new(|| {
    let titles: Vec<String> = { Show::ALL.iter() }
        .map(|show| show.title().to_lowercase())
        .collect();
    let titles = titles.join(" ");
    format!("picture view seams {titles} beside fit colours color map exposure show")
});
const DETAIL_WORDS: &str = "points point size seams markers";
const CAMERA_WORDS: &str = "camera home front back left right top bottom fly flight fov orbit";
const LIGHT_WORDS: &str = "light shadow";

/// Is what somebody looks for among the words, or does nobody look for anything?
fn is_among(words: &str, filter: &str) -> bool {
    let filter = filter.trim().to_lowercase();
    // A beginning of words that follow each other: who looks for a light wants no flight.
    filter.is_empty() || words.starts_with(&filter) || words.contains(&format!(" {filter}"))
}

impl Interface {
    /// Fills the panel.
    pub(super) fn panel(&mut self, ui: &mut Ui, facts: &Facts, commands: &mut Vec<Command>) {
        ui.horizontal(|ui| {
            ui.label(RichText::new("myxo").heading().color(theme::accent(ui)));
            ui.label(RichText::new(&facts.scene).heading());
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                ui.spacing_mut().item_spacing.x = 2.0;
                ui.toggle_value(&mut self.help, "?")
                    .on_hover_text("Keys and mouse (H)")
                    .marked("help");
                let theme = if self.light { "🌙" } else { "☀" };
                if ui
                    .add(egui::Button::new(theme).frame(false))
                    .on_hover_text("Light or dark interface (T)")
                    .marked("theme")
                    .clicked()
                {
                    self.set_light(ui.ctx(), !self.light);
                }
                let redo = egui::Button::new("↪").frame(false);
                if ui
                    .add_enabled(self.undo.can_redo(), redo)
                    .on_hover_text("Redo (Ctrl Shift Z)")
                    .marked("redo")
                    .clicked()
                {
                    self.redo(commands);
                }
                let undo = egui::Button::new("↩").frame(false);
                if ui
                    .add_enabled(self.undo.can_undo(), undo)
                    .on_hover_text("Undo (Ctrl Z)")
                    .marked("undo")
                    .clicked()
                {
                    self.undo_by_hand(ui.ctx(), commands);
                }
            });
        });
        ui.add_space(4.0);
        self.transport(ui, facts, commands);
        ui.add_space(4.0);
        self.looks(ui, commands);
        ui.add_space(6.0);
        ui.separator();
        self.search(ui);
        note_value(ui.ctx(), "filter", || self.filter.clone());
        // What is looked for has the panel to itself.
        let looks_for = !self.filter.trim().is_empty();
        ScrollArea::vertical()
            .auto_shrink([false, false])
            .show(ui, |ui| {
                // Room for the bar, which floats over the content.
                ui.set_max_width(ui.available_width() - theme::SCROLL_BAR);
                let above = ui.cursor().top();
                self.view_sections(ui, facts, looks_for);
                self.parameter_sections(ui, commands);
                if looks_for {
                    if ui.cursor().top() == above {
                        let text = format!("Nothing is called “{}”.", self.filter.trim());
                        ui.label(RichText::new(text).color(theme::weak(ui)));
                    }
                    return;
                }
                section(ui, "Kernel times", true, false, |ui| {
                    kernel_plot(ui, facts);
                    kernel_table(ui, facts)
                });
            });
    }

    /// The field for what is looked for, and a way out of it.
    fn search(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            let looks_for = !self.filter.is_empty();
            let room = if looks_for { 24.0 } else { 0.0 };
            let field = egui::TextEdit::singleline(&mut self.filter)
                .hint_text("🔍 find a parameter")
                .desired_width(ui.available_width() - room);
            self.is_searching = ui.add(field).marked("filter").has_focus();
            if !looks_for {
                return;
            }
            let clear = egui::Button::new("✖").frame(false);
            let clear = (ui.add(clear)).on_hover_text("Shows everything again (Esc in the field)");
            if clear.marked("filter.clear").clicked() {
                self.filter.clear();
            }
        });
    }

    /// Picture, Camera and Light; of those that are not looked for by name, the rows that are.
    fn view_sections(&mut self, ui: &mut Ui, facts: &Facts, looks_for: bool) {
        type Contents = fn(&mut Interface, &mut Ui, &Facts);
        let sections: [(&str, bool, &str, &[&str], Contents); 4] = [
            (
                "Picture",
                true,
                &PICTURE_WORDS,
                COLOR_ROWS,
                |it, ui, facts| {
                    it.picture_section(ui, facts);
                },
            ),
            (
                "Points, charts, food, areas, background",
                false,
                DETAIL_WORDS,
                DETAIL_ROWS,
                |it, ui, _| it.view_rows(ui, DETAIL_ROWS),
            ),
            ("Camera", false, CAMERA_WORDS, CAMERA_ROWS, |it, ui, _| {
                it.camera_section(ui);
            }),
            ("Light", false, LIGHT_WORDS, LIGHT_ROWS, |it, ui, _| {
                it.light_section(ui);
            }),
        ];
        for (title, open, words, rows, contents) in sections {
            if is_among(words, &self.filter) {
                section(ui, title, open, looks_for, |ui| contents(self, ui, facts));
                continue;
            }
            let rows = found(rows, &self.filter);
            if !rows.is_empty() {
                section(ui, title, open, looks_for, |ui| self.view_rows(ui, &rows));
            }
        }
    }

    fn transport(&mut self, ui: &mut Ui, facts: &Facts, commands: &mut Vec<Command>) {
        ui.horizontal(|ui| {
            let (label, hint) = if self.playing {
                ("⏸ Pause", "Hold the simulation (Space)")
            } else {
                ("▶ Run", "Let it grow (Space)")
            };
            let button = egui::Button::new(RichText::new(label).color(theme::on_fill(ui)))
                .fill(theme::accent(ui))
                .min_size(vec2(84.0, 26.0));
            let button = ui.add(button).on_hover_text(hint).marked("run");
            if button.clicked() {
                self.playing = !self.playing;
            }
            let wide = |label: &'static str| egui::Button::new(label).min_size(vec2(66.0, 26.0));
            if ui
                .add(wide("⏭ Step"))
                .on_hover_text("One step, then hold (S or .)")
                .marked("step")
                .clicked()
            {
                self.playing = false;
                commands.push(Command::Step);
            }
            if ui
                .add(wide("⟲ Reset"))
                .on_hover_text("Begin again at step 0 (R)")
                .marked("reset")
                .clicked()
            {
                commands.push(Command::Restart);
            }
            if ui
                .add(egui::Button::new("📷").min_size(vec2(30.0, 26.0)))
                .on_hover_text("Save a screenshot (F12)")
                .marked("screenshot")
                .clicked()
            {
                commands.push(Command::Screenshot);
            }
            ui.spacing_mut().item_spacing.x = 4.0;
            let out = egui::Button::new("📤")
                .min_size(vec2(30.0, 26.0))
                .selected(self.out.open);
            if ui
                .add(out)
                .on_hover_text("Export: pictures, recordings, films, models, data (Ctrl E)")
                .marked("out")
                .clicked()
            {
                self.out.open = !self.out.open;
            }
        });
        ui.horizontal(|ui| {
            ui.label(RichText::new(format!("step {}", grouped(facts.step as f64))).monospace());
            let speed = if self.playing {
                format!("{:.1} steps/s", facts.steps_per_second)
            } else {
                "paused".to_owned()
            };
            ui.label(RichText::new(speed).monospace().color(theme::weak(ui)));
            if let Some(seconds) = facts.seconds {
                ui.label(RichText::new(format!("{seconds:.1} s")).monospace())
                    .on_hover_text("Time of the objects' motion");
            }
            if let Some(before) = &facts.before {
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    if before.button(ui).clicked() {
                        commands.push(Command::GoBack);
                    }
                });
            }
        });
        // A part of its own: what comes and goes in it leaves alone what is being typed below.
        ui.scope(|ui| self.conditions(ui, facts, commands));
    }

    /// What is not always said: transfers, invariants, edits that wait.
    fn conditions(&mut self, ui: &mut Ui, facts: &Facts, commands: &mut Vec<Command>) {
        transfers(ui, facts, self.running.transfer.buffer_size);
        if let Some(check) = &facts.check {
            invariants(ui, check);
        }
        if self.is_pending() {
            ui.horizontal(|ui| {
                let button = egui::Button::new(
                    RichText::new("⟲ Restart to apply").color(theme::on_fill(ui)),
                )
                .fill(theme::pending(ui));
                if ui
                    .add(button)
                    .on_hover_text(
                        "Parameters in orange take effect when the simulation begins again (R).",
                    )
                    .marked("restart")
                    .clicked()
                {
                    commands.push(Command::Restart);
                }
                if ui
                    .button("Discard")
                    .on_hover_text("Keep what is running.")
                    .marked("discard")
                    .clicked()
                {
                    let live = self.live_settings();
                    self.edited = live;
                    self.find_preset();
                }
            });
        }
    }

    /// The gallery, the preset, chance, and how quickly looks change.
    fn looks(&mut self, ui: &mut Ui, commands: &mut Vec<Command>) {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            ui.toggle_value(&mut self.gallery.open, "🖼 Gallery")
                .on_hover_text("Scenes and presets (G)")
                .marked("gallery");
            let name = match &self.preset {
                Some(name) if self.is_changed_from(name) => format!("{name}*"),
                Some(name) => name.clone(),
                None => "own look".to_owned(),
            };
            let mut chosen = None;
            egui::ComboBox::from_id_salt("preset")
                .width(96.0)
                .height(600.0)
                .truncate()
                .selected_text(name)
                .show_ui(ui, |ui| {
                    let names = self.preset_names();
                    for (i, name) in names.iter().enumerate() {
                        if i == PRESETS.len() {
                            ui.separator();
                        }
                        let Some(text) = self.preset_text(name) else {
                            continue;
                        };
                        let is_taken = self.preset.as_ref() == Some(name);
                        let item = ui.selectable_label(is_taken, name);
                        let item = item.on_hover_text(summary(&text));
                        if item.marked(&format!("preset={name}")).clicked() {
                            chosen = Some((name.clone(), text));
                        }
                    }
                })
                .response
                .on_hover_text("A look: values for Physarum, Trail and Feeding ([ and ] for the next); * where it was changed. Looks are kept in the gallery.")
                .marked("preset");
            if let Some((name, text)) = chosen {
                self.take_preset(ui.ctx(), &name, &text, commands);
            }
            if ui
                .button("🎲")
                .on_hover_text("A look by chance (D)")
                .marked("chance")
                .clicked()
            {
                self.by_chance(ui.ctx(), commands);
            }
            ui.add(
                egui::DragValue::new(&mut self.morph_seconds)
                    .range(0.0..=120.0)
                    .speed(0.1)
                    .custom_parser(parse_number)
                    .update_while_editing(false)
                    .max_decimals(1)
                    .suffix(" s"),
            )
            .on_hover_text("How long the change to another look takes. Drag, or click to type.")
            .marked("morph");
        });
    }

    fn picture_section(&mut self, ui: &mut Ui, facts: &Facts) {
        self.views_list(ui, facts);
        ui.add_space(2.0);
        self.view_rows(ui, COLOR_ROWS);
        let has_points = self.view.show.has(Part::Points);
        if has_points && facts.particles_drawn < self.running.particles.count {
            let text = format!(
                "{} are drawn while it runs",
                grouped(f64::from(facts.particles_drawn))
            );
            ui.label(RichText::new(text).small().color(theme::weak(ui)))
                .on_hover_text("All of them would be slow on this device. Paused, and in screenshots, all are.");
        }
    }

    fn parameter_sections(&mut self, ui: &mut Ui, commands: &mut Vec<Command>) {
        let filter = self.filter.trim().to_lowercase();
        let wanted = |name: &str, key: &str| {
            filter.is_empty() || name.to_lowercase().contains(&filter) || key.contains(&filter)
        };
        let mut changed = false;
        let before = self.edited.clone();
        let shared = &before.physarum;
        let default = Settings::default();
        for (prefix, title, open) in SECTIONS {
            let parameters: Vec<_> = PARAMETERS
                .iter()
                .filter(|p| p.section() == *prefix && wanted(p.name, p.key))
                .collect();
            if parameters.is_empty() {
                continue;
            }
            section(ui, title, *open, !filter.is_empty(), |ui| {
                let context = RowContext {
                    loaded: &self.loaded,
                    default: &default,
                    running: &self.running,
                    shared,
                    objects: &before.objects,
                    prefix: "",
                    idle: &|key| why_idle(key, &before),
                };
                for parameter in parameters {
                    changed |= row(ui, parameter, &mut self.edited, &context);
                }
            });
        }
        for i in 0..self.edited.objects.len() {
            let parameters: Vec<_> = OBJECT_PARAMETERS
                .iter()
                .filter(|p| wanted(p.name, p.key))
                .collect();
            let Some(running) = self.running.objects.get(i) else {
                continue;
            };
            // Who joined later has no other beginning than what it is.
            let name = &self.edited.objects[i].name;
            let loaded = self.loaded.objects.iter().find(|o| o.name == *name);
            let loaded = loaded.unwrap_or(running);
            if parameters.is_empty() {
                continue;
            }
            let title = format!("Object: {}", self.edited.objects[i].name);
            let reveals = self.hands.reveals == Some(i) && filter.is_empty();
            let shown = section_with(ui, &title, false, !filter.is_empty(), reveals, |ui| {
                let context = RowContext {
                    loaded,
                    default: &ObjectSettings::default(),
                    running,
                    shared,
                    objects: &before.objects,
                    prefix: &format!("object.{i}."),
                    idle: &|key| why_object_idle(key, &before.objects[i], &before),
                };
                for parameter in parameters {
                    changed |= row(ui, parameter, &mut self.edited.objects[i], &context);
                }
            });
            // Also what no click in the picture reaches, because it lies inside or behind of others.
            if shown.header_response.clicked() {
                self.hands.pick(Some(i));
            }
            if reveals {
                // It opens by and by, and only then is there something to scroll to.
                shown.header_response.scroll_to_me(Some(Align::TOP));
                if shown.openness < 1.0 {
                    ui.ctx().request_repaint();
                } else {
                    self.hands.reveals = None;
                }
            }
        }
        changed |= self.food_sections(ui, &before, &filter);
        if changed {
            commands.push(Command::Apply);
        }
    }
}

/// How many particles have changed objects, once some have; and what to do where some could not.
fn transfers(ui: &mut Ui, facts: &Facts, buffer_size: u32) {
    let Flow {
        arrived,
        crossed,
        refused,
        most_wanted,
        ..
    } = facts.flow;
    if arrived > 0 {
        let text = format!("{} transfers", count_text(arrived.into()));
        ui.label(RichText::new(text).monospace().color(theme::weak(ui)))
            .on_hover_text(format!(
                "Particles that have changed objects so far. {} went on from where their walk met the other object; the \
                 others went to its nearest point, or turned round at a no-go area.",
                count_text(crossed.into())
            ));
    }
    if let Some(mismatch) = facts.flow.mismatch() {
        ui.label(RichText::new(mismatch).color(theme::pending(ui)));
    }
    if refused > 0 {
        let refused = count_text(refused.into());
        let advice = if buffer_size < most_wanted {
            let wanted = grouped(most_wanted.into());
            format!("raise its size to {wanted}")
        } else {
            "it is large enough now".to_owned()
        };
        let text = format!("{refused} found the transfer buffer full: {advice}");
        ui.label(RichText::new(text).color(theme::pending(ui)))
            .on_hover_text(format!(
                "They stayed on their objects, by chance and the same ones in every run. The transfer buffer has room for {} that \
                 change in a step, and {} would have done so far.",
                grouped(buffer_size.into()),
                grouped(most_wanted.into())
            ));
    }
}

/// Whether the invariants hold, and what it costs to look.
fn invariants(ui: &mut Ui, check: &Check) {
    let cost = format!(
        "The last check was of step {} and took {:.0} ms, in which nothing else happened. Particles are counted, windows \
         and places are looked at.",
        grouped(check.step as f64),
        1e3 * check.took.as_secs_f64()
    );
    match &check.problem {
        Some(problem) => {
            let text = format!("{problem}; this is a bug in myxo");
            ui.label(RichText::new(text).color(theme::error(ui)))
        }
        None => {
            let share = 100.0 * check.share;
            let text = format!("invariants hold; checks take {share:.0} %");
            ui.label(RichText::new(text).monospace().color(theme::weak(ui)))
        }
    }
    .on_hover_text(cost);
}

/// The sections of the table, in the panel's order, with their titles and whether they begin open.
/// What `[camera]` and `[picture]` hold is moved by hand, too, and stands above them.
pub(super) const SECTIONS: &[(&str, &str, bool)] = &[
    ("physarum", "Physarum", true),
    ("trail", "Trail", true),
    ("feeding", "Feeding", false),
    ("particles", "Particles", false),
    ("areas", "Areas", false),
    ("time", "Time", false),
    ("distance", "Distances", false),
    ("transfer", "Transfer", false),
    ("atlas", "Atlas", false),
    ("", "Scene", false),
];

/// A part of the panel under a title that opens and closes it; `found` holds it open, because it has what was looked
/// for, and leaves it afterwards as it was before.
pub(super) fn section(
    ui: &mut Ui,
    title: &str,
    open: bool,
    found: bool,
    contents: impl FnOnce(&mut Ui),
) {
    section_with(ui, title, open, found, false, contents);
}

/// The same, which can be opened from elsewhere.
fn section_with(
    ui: &mut Ui,
    title: &str,
    open: bool,
    found: bool,
    opens: bool,
    contents: impl FnOnce(&mut Ui),
) -> egui::CollapsingResponse<()> {
    let mut shown = egui::CollapsingHeader::new(RichText::new(title).strong())
        .id_salt((title, found))
        .default_open(open)
        .open((found || opens).then_some(true))
        .show_unindented(ui, |ui| {
            ui.add_space(2.0);
            contents(ui);
            ui.add_space(6.0);
        });
    shown.header_response = shown.header_response.marked(&format!("section={title}"));
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sections_are_found_by_the_beginnings_of_their_words() {
        assert!(is_among(LIGHT_WORDS, " Light ") && is_among(LIGHT_WORDS, "shad"));
        assert!(is_among(CAMERA_WORDS, "fov") && !is_among(CAMERA_WORDS, "light"));
        assert!(is_among(&PICTURE_WORDS, "") && !is_among(&PICTURE_WORDS, "decay"));
    }
}
