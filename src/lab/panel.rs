//! The panel beside the picture: run and reset, what the picture shows, every parameter, times.

use std::sync::LazyLock;

use egui::{Align, Layout, RichText, ScrollArea, Ui, vec2};
use myxo::plain_text::with_commas;
use myxo::scene::builtin::PRESETS;
use myxo::scene::parameters::{OBJECT_PARAMETERS, PARAMETERS, why_idle, why_object_idle};
use myxo::scene::settings::{ObjectSettings, Part, Settings, Show};
use myxo::sim::transfers::count_text;
use myxo::sim::types::{Flow, Population};

use crate::lab::actions::{self, Action};
use crate::lab::command::Command;
use crate::lab::desk::Desk;
use crate::lab::facts::{Check, Facts};
use crate::lab::foods::food_sections;
use crate::lab::layout::Card;
use crate::lab::looks::{LONGEST_MORPH, Looks, NO_EARLIER, NO_LATER};
use crate::lab::navigation::Navigation;
use crate::lab::outliner::Outliner;
use crate::lab::places::{Marked as _, note_value};
use crate::lab::rows::{RowContext, row};
use crate::lab::tools::Tools;
use crate::lab::view_rows::{CAMERA_ROWS, COLOR_ROWS, DETAIL_ROWS, LIGHT_ROWS, found, view_rows};
use crate::lab::views::{camera_section, light_section, views_list};
use crate::lab::widgets::{parse_number, reader, section, section_with};
use crate::lab::{profiling, theme};
use crate::own_presets::summary;

/// Search words of the sections' contents that are no rows of parameters.
static PICTURE_WORDS: LazyLock<String> = LazyLock::new(|| {
    let titles: Vec<String> = { Show::ALL.iter() }
        .map(|show| show.title().to_lowercase())
        .collect();
    let titles = titles.join(" ");
    format!("picture view seams {titles} beside network lines fit colours color map exposure show")
});
const DETAIL_WORDS: &str = "points point size seams markers";
const CAMERA_WORDS: &str = "camera home front back left right top bottom fly flight fov orbit";
const TIMES_WORDS: &str = "times kernel kernels profiling gpu";
const OBJECT_WORDS: &str = "objects outliner hide show lock isolate alone rename name list";
const LIGHT_WORDS: &str = "light shadow";

/// Is what is searched for among the words? Without a search, everything is.
fn is_among(words: &str, filter: &str) -> bool {
    let filter = filter.trim().to_lowercase();
    // The search matches the beginnings of words: `light` must not find `flight`.
    filter.is_empty() || words.starts_with(&filter) || words.contains(&format!(" {filter}"))
}

/// The panel: what it is searched for.
#[derive(Clone, Debug, Default)]
pub struct ParameterPanel {
    pub filter: String,
    /// The keyboard is in the field for it.
    is_searching: bool,
    outliner: Outliner,
}

impl ParameterPanel {
    /// Is the keyboard in the field of the search?
    pub fn is_searching(&self) -> bool {
        self.is_searching
    }

    /// Leaves the search, if the keyboard is in its field.
    pub fn leave_search(&mut self) -> bool {
        let leaves = std::mem::take(&mut self.is_searching);
        if leaves {
            self.filter.clear();
        }
        leaves
    }

    /// Another scene.
    pub fn open_scene(&mut self) {
        self.outliner = Outliner::default();
    }

    /// Fills the panel.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        looks: &mut Looks,
        tools: &mut Tools,
        navigation: &Navigation,
        desk: &mut Desk<'_>,
    ) {
        ui.horizontal(|ui| {
            ui.label(RichText::new("myxo").heading().color(theme::accent(ui)));
            ui.label(RichText::new(&desk.facts.scene).heading());
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                ui.spacing_mut().item_spacing.x = 2.0;
                let help = egui::Button::selectable(desk.layout.shows(Card::Help), "?");
                if ui
                    .add(help)
                    .on_hover_text(Action::Help.hint("Keys and mouse"))
                    .marked("help")
                    .clicked()
                {
                    desk.actions.push(Action::Help);
                }
                let theme = if desk.layout.light { "🌙" } else { "☀" };
                if ui
                    .add(egui::Button::new(theme).frame(false))
                    .on_hover_text(Action::Theme.hint("Light or dark interface"))
                    .marked("theme")
                    .clicked()
                {
                    desk.actions.push(Action::Theme);
                }
                let redo = egui::Button::new("↪").frame(false);
                if ui
                    .add_enabled(desk.document.undo.can_redo(), redo)
                    .on_hover_text(Action::Redo.hint("Redo"))
                    .marked("redo")
                    .clicked()
                {
                    desk.actions.push(Action::Redo);
                }
                let undo = egui::Button::new("↩").frame(false);
                if ui
                    .add_enabled(desk.document.undo.can_undo(), undo)
                    .on_hover_text(Action::Undo.hint("Undo"))
                    .marked("undo")
                    .clicked()
                {
                    desk.actions.push(Action::Undo);
                }
            });
        });
        ui.add_space(4.0);
        transport(ui, looks, desk);
        ui.add_space(4.0);
        looks_row(ui, looks, desk);
        ui.add_space(6.0);
        ui.separator();
        self.search(ui);
        note_value(ui.ctx(), "filter", || self.filter.clone());
        // During a search the panel shows only the results.
        let looks_for = !self.filter.trim().is_empty();
        ScrollArea::vertical()
            .auto_shrink([false, false])
            .show(ui, |ui| {
                // Room for the bar, which floats over the content.
                ui.set_max_width(ui.available_width() - theme::SCROLL_BAR);
                let above = ui.cursor().top();
                if looks_for {
                    let has_picked = tools.picked().is_some() || tools.food.is_some();
                    self.found_actions(ui, has_picked, desk);
                }
                self.view_sections(ui, navigation, looks_for, desk);
                if is_among(OBJECT_WORDS, &self.filter) {
                    let outliner = &mut self.outliner;
                    section(ui, "Objects", false, looks_for, |ui| {
                        outliner.show(ui, tools, desk);
                    });
                }
                self.parameter_sections(ui, tools, desk);
                if is_among(TIMES_WORDS, &self.filter) {
                    section(ui, "Times", true, looks_for, |ui| profiling::show(ui, desk));
                }
                if looks_for && ui.cursor().top() == above {
                    let text = format!("Nothing is called “{}”.", self.filter.trim());
                    ui.label(RichText::new(text).color(theme::weak(ui)));
                }
            });
    }

    /// Actions whose name matches the search, as buttons.
    fn found_actions(&self, ui: &mut Ui, has_picked: bool, desk: &mut Desk<'_>) {
        for (action, keys, what, _) in actions::all() {
            if !is_among(&what.to_lowercase(), &self.filter) {
                continue;
            }
            let why_not = action.why_not(desk.document, has_picked);
            let button = egui::Button::new(&what)
                .shortcut_text(keys)
                .min_size(vec2(ui.available_width(), 0.0));
            let button = ui.add_enabled(why_not.is_none(), button);
            let button = button.on_disabled_hover_text(why_not.unwrap_or_default());
            if button.marked(&format!("do={what}")).clicked() {
                desk.actions.push(action);
            }
        }
    }

    /// The field for what is looked for, and a way out of it.
    fn search(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            let looks_for = !self.filter.is_empty();
            let room = if looks_for { 24.0 } else { 0.0 };
            let field = egui::TextEdit::singleline(&mut self.filter)
                .hint_text("🔍 find a parameter or a command")
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
    fn view_sections(
        &self,
        ui: &mut Ui,
        navigation: &Navigation,
        looks_for: bool,
        desk: &mut Desk<'_>,
    ) {
        type Contents = fn(&mut Ui, &Navigation, &mut Desk<'_>);
        let sections: [(&str, bool, &str, &[&str], Contents); 4] = [
            (
                "Picture",
                true,
                &PICTURE_WORDS,
                COLOR_ROWS,
                |ui, _, desk| picture_section(ui, desk),
            ),
            (
                "Points, charts, food, areas, background",
                false,
                DETAIL_WORDS,
                DETAIL_ROWS,
                |ui, _, desk| view_rows(ui, DETAIL_ROWS, desk),
            ),
            ("Camera", false, CAMERA_WORDS, CAMERA_ROWS, camera_section),
            ("Light", false, LIGHT_WORDS, LIGHT_ROWS, |ui, _, desk| {
                light_section(ui, desk)
            }),
        ];
        for (title, open, words, rows, contents) in sections {
            if is_among(words, &self.filter) {
                section(ui, title, open, looks_for, |ui| {
                    contents(ui, navigation, desk)
                });
                continue;
            }
            let rows = found(rows, &self.filter);
            if !rows.is_empty() {
                section(ui, title, open, looks_for, |ui| view_rows(ui, &rows, desk));
            }
        }
    }

    fn parameter_sections(&self, ui: &mut Ui, tools: &mut Tools, desk: &mut Desk<'_>) {
        let filter = self.filter.trim().to_lowercase();
        let wanted = |name: &str, key: &str| {
            filter.is_empty() || name.to_lowercase().contains(&filter) || key.contains(&filter)
        };
        let mut changed = false;
        let before = desk.document.edited.clone();
        let shared = &before;
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
                    loaded: &desk.document.loaded,
                    default: &default,
                    running: &desk.document.running,
                    shared,
                    objects: &before.objects,
                    prefix: "",
                    idle: &|key| why_idle(key, &before),
                };
                for parameter in parameters {
                    changed |= row(ui, parameter, &mut desk.document.edited, &context);
                }
            });
        }
        for i in 0..desk.document.edited.objects.len() {
            let parameters: Vec<_> = OBJECT_PARAMETERS
                .iter()
                .filter(|p| wanted(p.name, p.key))
                .collect();
            let Some(running) = desk.document.running.objects.get(i) else {
                continue;
            };
            // An object that joined later resets to its running settings.
            let name = &desk.document.edited.objects[i].name;
            let loaded = desk
                .document
                .loaded
                .objects
                .iter()
                .find(|o| o.name == *name);
            let loaded = loaded.unwrap_or(running);
            if parameters.is_empty() {
                continue;
            }
            let title = format!("Object: {}", desk.document.edited.objects[i].name);
            let reveals = tools.reveals == Some(i) && filter.is_empty();
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
                    changed |= row(
                        ui,
                        parameter,
                        &mut desk.document.edited.objects[i],
                        &context,
                    );
                }
            });
            // Also what no click in the picture reaches, because it lies inside or behind of others.
            if shown.header_response.clicked() {
                tools.pick(Some(i));
            }
            if reveals {
                // It opens slowly, and only then is there something to scroll to.
                shown.header_response.scroll_to_me(Some(Align::TOP));
                if shown.openness < 1.0 {
                    ui.ctx().request_repaint();
                } else {
                    tools.reveals = None;
                }
            }
        }
        changed |= food_sections(ui, desk.document, &before, &filter);
        if changed {
            desk.commands.push(Command::Apply);
        }
    }
}

/// Run, step, restart, pictures, and how far it is.
fn transport(ui: &mut Ui, looks: &Looks, desk: &mut Desk<'_>) {
    let facts = desk.facts;
    ui.horizontal(|ui| {
        let (label, hint) = if desk.document.playing {
            ("⏸ Pause", "Hold the simulation (Space)")
        } else {
            ("▶ Run", "Let it grow (Space)")
        };
        let button = egui::Button::new(RichText::new(label).color(theme::on_fill(ui)))
            .fill(theme::accent(ui))
            .min_size(vec2(84.0, 26.0));
        let button = ui.add(button).on_hover_text(hint).marked("run");
        if button.clicked() {
            desk.actions.push(Action::Pause);
        }
        let wide = |label: &'static str| egui::Button::new(label).min_size(vec2(66.0, 26.0));
        if ui
            .add(wide("⏭ Step"))
            .on_hover_text("One step, then hold (S or .)")
            .marked("step")
            .clicked()
        {
            desk.actions.push(Action::SingleStep);
        }
        if ui
            .add(wide("⟲ Reset"))
            .on_hover_text(Action::Restart.hint("Restarts at step 0"))
            .marked("reset")
            .clicked()
        {
            desk.actions.push(Action::Restart);
        }
        if ui
            .add(egui::Button::new("📷").min_size(vec2(30.0, 26.0)))
            .on_hover_text(Action::Screenshot.hint("Save a screenshot"))
            .marked("screenshot")
            .clicked()
        {
            desk.actions.push(Action::Screenshot);
        }
        ui.spacing_mut().item_spacing.x = 4.0;
        let out = egui::Button::new("📤")
            .min_size(vec2(30.0, 26.0))
            .selected(desk.layout.shows(Card::Exports));
        if ui
            .add(out)
            .on_hover_text(Action::Export.hint("Export: pictures, recordings, films, models, data"))
            .marked("out")
            .clicked()
        {
            desk.actions.push(Action::Export);
        }
    });
    ui.horizontal(|ui| {
        ui.label(RichText::new(format!("step {}", with_commas(facts.step as f64))).monospace());
        let speed = if desk.document.playing {
            format!("{:.1} steps/s", facts.steps_per_second)
        } else {
            "paused".to_owned()
        };
        ui.label(RichText::new(speed).monospace().color(theme::weak(ui)));
        if let Some(seconds) = facts.seconds {
            ui.label(RichText::new(format!("t {seconds:.1} s")).monospace())
                .on_hover_text("Time of the objects' motion");
        }
        if let Some(before) = &facts.before {
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if before.button(ui).clicked() {
                    desk.commands.push(Command::GoBack);
                }
            });
        }
    });
    // It has a scope of its own, so that changes in it do not disturb typing below.
    ui.scope(|ui| conditions(ui, looks, desk));
}

/// Conditions that are not always shown: transfers, invariants, pending edits.
fn conditions(ui: &mut Ui, looks: &Looks, desk: &mut Desk<'_>) {
    let facts = desk.facts;
    transfers(ui, facts, desk.document.running.transfer.buffer_size);
    births(ui, facts, desk.document.running.slots());
    if let Some(check) = &facts.check {
        invariants(ui, check);
    }
    if desk.document.waits_for_restart() {
        ui.horizontal(|ui| {
            let button =
                egui::Button::new(RichText::new("⟲ Restart to apply").color(theme::on_fill(ui)))
                    .fill(theme::pending(ui));
            if ui
                .add(button)
                .on_hover_text(
                    Action::Restart
                        .hint("Parameters in orange take effect when the simulation begins again"),
                )
                .marked("restart")
                .clicked()
            {
                desk.actions.push(Action::Restart);
            }
            if ui
                .button("Discard")
                .on_hover_text("Keep what is running.")
                .marked("discard")
                .clicked()
            {
                let live = desk.document.live_settings();
                desk.document.edited = live;
                looks.find_preset(desk.document);
            }
        });
    }
}

/// The gallery and the preset; chance below.
fn looks_row(ui: &mut Ui, looks: &mut Looks, desk: &mut Desk<'_>) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let gallery = egui::Button::selectable(desk.layout.gallery, "🖼 Gallery");
        if ui
            .add(gallery)
            .on_hover_text(Action::Gallery.hint("Looks and scenes, beside the picture"))
            .marked("gallery")
            .clicked()
        {
            desk.actions.push(Action::Gallery);
        }
        let name = match &desk.document.preset {
            Some(name) if looks.is_changed_from(desk.document, name) => format!("{name}*"),
            Some(name) => name.clone(),
            None => "own look".to_owned(),
        };
        let mut chosen = None;
        egui::ComboBox::from_id_salt("preset")
            .width(ui.available_width() - 36.0)
            .height(600.0)
            .truncate()
            .selected_text(name)
            .show_ui(ui, |ui| {
                let names = looks.preset_names();
                for (i, name) in names.iter().enumerate() {
                    if i == PRESETS.len() {
                        ui.separator();
                    }
                    let Some(text) = looks.preset_text(name) else {
                        continue;
                    };
                    let is_taken = desk.document.preset.as_ref() == Some(name);
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
            looks.take_preset(ui.ctx(), &name, &text, desk);
        }
        let drifts = ui.button("🚀").on_hover_text(Action::Autopilot.hint(
            "Autopilot: the picture alone drifts from look to look, and the camera round the scene, until any input",
        ));
        if drifts.marked("autopilot").clicked() {
            desk.actions.push(Action::Autopilot);
        }
    });
    throws_row(ui, looks, desk);
}

/// The dice, the ways through their throws, and how quickly looks change.
fn throws_row(ui: &mut Ui, looks: &mut Looks, desk: &mut Desk<'_>) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let dice = ui.button("🎲").on_hover_text(Action::ByChance.hint(
            "A look by chance. Each is kept until the window closes, and the arrows lead back to it",
        ));
        if dice.marked("chance").clicked() {
            desk.actions.push(Action::ByChance);
        }
        let look = desk.document.coming_look();
        for (forward, sign, action, hint, why_not) in [
            (false, "◀", Action::EarlierThrow, "The look before", NO_EARLIER),
            (true, "▶", Action::LaterThrow, "The look after", NO_LATER),
        ] {
            let button = egui::Button::new(RichText::new(sign).small());
            let button = ui
                .add_enabled(looks.throws.can_go(forward, &look), button)
                .on_hover_text(action.hint(hint))
                .on_disabled_hover_text(why_not);
            let name = if forward { "chance.later" } else { "chance.earlier" };
            if button.marked(name).clicked() {
                desk.actions.push(action);
            }
        }
        if let Some((place, count)) = looks.throws.at() {
            let text = format!("{place} of {count}");
            note_value(ui.ctx(), "chance", || text.clone());
            ui.label(RichText::new(text).small().color(theme::weak(ui)));
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            ui.add(
                egui::DragValue::new(&mut looks.morph_seconds)
                    .range(0.0..=LONGEST_MORPH)
                    .speed(0.1)
                    .custom_parser(reader(ui, parse_number))
                    .update_while_editing(false)
                    .max_decimals(1)
                    .suffix(" s"),
            )
            .on_hover_text("How long the change to another look takes. Drag, or click to type.")
            .marked("morph");
            ui.label(RichText::new("change in").small().color(theme::weak(ui)));
        });
    });
}

/// The section for the picture's view and colours.
fn picture_section(ui: &mut Ui, desk: &mut Desk<'_>) {
    let facts = desk.facts;
    views_list(ui, desk);
    ui.add_space(2.0);
    view_rows(ui, COLOR_ROWS, desk);
    let has_points = desk.document.view.show.has(Part::Points);
    let slots = desk.document.running.slots();
    if has_points && facts.particles_drawn < slots {
        // Every so many slots are drawn, and about as many of them are alive as of all.
        let living = facts.population.map_or(slots, |now| now.living);
        let drawn = f64::from(facts.particles_drawn) * f64::from(living) / f64::from(slots);
        let text = format!("{} are drawn while it runs", with_commas(drawn.round()));
        ui.label(RichText::new(text).small().color(theme::weak(ui)))
            .on_hover_text(
                "All of them would be slow on this device. Paused, and in screenshots, all are.",
            );
    }
}

/// How many particles have changed objects, once some have; and what to do where some could not.
fn transfers(ui: &mut Ui, facts: &Facts, buffer_size: u32) {
    let Flow {
        arrived,
        crossed,
        refused,
        most_wanted,
        left_over,
        ..
    } = facts.flow;
    if left_over > 0 {
        let text = format!(
            "{} left over by claims of cells",
            count_text(left_over.into())
        );
        ui.label(RichText::new(text).monospace().color(theme::weak(ui)))
            .on_hover_text(
                "How many times a particle stayed that would have moved with one more of the occupancy rounds.",
            );
    }
    if arrived > 0 {
        let text = format!("{} transfers", count_text(arrived.into()));
        ui.label(RichText::new(text).monospace().color(theme::weak(ui)))
            .on_hover_text(format!(
                "Particles that have changed objects so far. {} continued from where their walk met the other object; the \
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
            let wanted = with_commas(most_wanted.into());
            format!("raise its size to {wanted}")
        } else {
            "it is large enough now".to_owned()
        };
        let text = format!("{refused} found the transfer buffer full: {advice}");
        ui.label(RichText::new(text).color(theme::pending(ui)))
            .on_hover_text(format!(
                "They stayed on their objects, by chance and the same ones in every run. The transfer buffer has room for {} that \
                 change in a step, and {} would have done so far.",
                with_commas(buffer_size.into()),
                with_commas(most_wanted.into())
            ));
    }
}

/// How many particles were born and died, if their number changes; and what to do where there was no room.
fn births(ui: &mut Ui, facts: &Facts, slots: u32) {
    let Some(Population {
        births,
        deaths,
        refused,
        ..
    }) = facts.population
    else {
        return;
    };
    let [births, deaths] = [births, deaths].map(|count| count_text(count.into()));
    let text = format!("{births} births, {deaths} deaths");
    ui.label(RichText::new(text).monospace().color(theme::weak(ui)))
        .on_hover_text("Particles that have divided, and particles that have died, so far.");
    if refused > 0 {
        let refused = count_text(refused.into());
        let slots = with_commas(slots.into());
        let text =
            format!("{refused} did not divide for want of room: raise the capacity from {slots}");
        ui.label(RichText::new(text).color(theme::pending(ui)));
    }
}

/// Whether the invariants hold, and what it costs to look.
fn invariants(ui: &mut Ui, check: &Check) {
    let cost = format!(
        "The last check was of step {} and took {:.0} ms, in which nothing else happened. Particles are counted, windows \
         and places are looked at.",
        with_commas(check.step as f64),
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

/// The sections of the table, in the panel's order, with their titles and whether they begin open. The parameters of `[camera]`
/// and `[picture]` change with the mouse, too, and stand above them.
pub(super) const SECTIONS: &[(&str, &str, bool)] = &[
    ("physarum", "Physarum", true),
    ("trail", "Trail", true),
    ("feeding", "Feeding", false),
    ("particles", "Particles", false),
    ("population", "Population", false),
    ("areas", "Areas", false),
    ("second_look", "Second look", false),
    ("time", "Time", false),
    ("distance", "Distances", false),
    ("transfer", "Transfer", false),
    ("atlas", "Atlas", false),
    ("", "Scene", false),
];

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
