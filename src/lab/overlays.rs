//! Overlays of the picture: the line of facts, the list of controls, short messages.

use egui::{Align, Align2, LayerId, Layout, Rect, RichText, Ui, vec2};

use myxo::plain_text::with_commas;

use crate::lab::actions::{self, Action, Group, MOUSE};
use crate::lab::command::Command;
use crate::lab::document::Document;
use crate::lab::facts::{ExportFacts, Facts, LoadingFacts};
use crate::lab::job::Progress;
use crate::lab::layout::{self, Card};
use crate::lab::places::{Marked as _, mark_cross, note_value};
use crate::lab::theme;

/// Between the keys and what they do, points.
const BETWEEN: f32 = 20.0;

/// The list of mouse and key controls, under headings, at most this wide.
fn controls(ui: &mut Ui, room: f32) {
    let mouse = MOUSE.iter().map(|(keys, what)| (*keys, (*what).to_owned()));
    let entries = mouse.chain(actions::all().map(|(_, keys, what, _)| (keys, what)));
    let (keys, what): (Vec<&str>, Vec<String>) = entries.unzip();
    let width_of = |texts: Vec<String>, style: egui::TextStyle| {
        let font = style.resolve(ui.style());
        let color = theme::weak(ui);
        let widths = texts.into_iter().map(|text| {
            let laid_out = ui.painter().layout_no_wrap(text, font.clone(), color);
            laid_out.size().x
        });
        widths.fold(0.0, f32::max).ceil()
    };
    let keys = keys.into_iter().map(str::to_owned).collect();
    let keys_width = width_of(keys, egui::TextStyle::Monospace);
    // What they do is wrapped where it has not the room.
    let least = 120.0_f32;
    let most = (room - keys_width - BETWEEN).max(least);
    let what_width = width_of(what, egui::TextStyle::Body).min(most);
    ui.set_width(keys_width + BETWEEN + what_width);
    egui::Grid::new("controls")
        .num_columns(2)
        .spacing(vec2(BETWEEN, 2.0))
        .max_col_width(what_width.max(keys_width))
        .show(ui, |ui| {
            let line = |ui: &mut Ui, keys: &str, what: &str| {
                ui.label(RichText::new(keys).monospace().color(theme::accent(ui)));
                ui.label(what);
                ui.end_row();
            };
            let heading = |ui: &mut Ui, title: &str| {
                ui.label(RichText::new(title).strong());
                ui.end_row();
            };
            heading(ui, "Mouse");
            for (keys, what) in MOUSE {
                line(ui, keys, what);
            }
            for group in Group::ALL {
                heading(ui, group.title());
                for (_, keys, what, _) in actions::all().filter(|(.., own)| *own == group) {
                    line(ui, keys, &what);
                }
            }
        });
    note_value(ui.ctx(), "help.keys", || {
        let keys: Vec<&str> = actions::all().map(|(_, keys, ..)| keys).collect();
        keys.join(", ")
    });
}

/// The line below everything.
pub(super) fn status_line(ui: &mut Ui, document: &Document, facts: &Facts) {
    let frame = egui::Frame::new()
        .fill(theme::panel(ui))
        .inner_margin(egui::Margin::symmetric(12, 4));
    egui::Panel::bottom("status")
        .show_separator_line(false)
        .frame(frame)
        .show(ui, |ui| {
            ui.horizontal(|ui| {
                let fact = |ui: &mut Ui, text: String| {
                    ui.label(RichText::new(text).small().color(theme::weak(ui)))
                };
                fact(ui, format!("{:.0} fps", facts.frames_per_second));
                fact(
                    ui,
                    facts
                        .times
                        .step_ms
                        .map_or("step time unavailable".to_owned(), |ms| {
                            format!("{ms:.2} ms a step")
                        }),
                );
                let begun = document.running.particles.count;
                let living = facts.population.map_or(begun, |now| now.living);
                fact(
                    ui,
                    format!("{} particles", with_commas(f64::from(living))),
                );
                fact(
                    ui,
                    format!("{} triangles", with_commas(facts.triangles as f64)),
                );
                fact(ui, format!("{} texels", with_commas(facts.texels as f64)));
                if let Some(why) = &facts.undeveloped {
                    fact(ui, "no bloom".to_owned()).on_hover_text(why);
                }
                if facts.is_plain {
                    let hint = "Pictures take long on this device: while something moves they have no bloom, and edges are jagged. A smaller window helps.";
                    fact(ui, "plain pictures".to_owned()).on_hover_text(hint);
                }
                if facts.flaws > 0 {
                    let hint = "Pixels whose light was not a number, or without end, because the trail was. They are black.";
                    let text = format!("{} flawed pixels", with_commas(f64::from(facts.flaws)));
                    fact(ui, text).on_hover_text(hint);
                }
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    fact(ui, format!("{} MiB", facts.memory >> 20));
                    ui.add(
                        egui::Label::new(
                            RichText::new(&facts.device).small().color(theme::weak(ui)),
                        )
                        .truncate(),
                    );
                });
            });
        });
}

/// The list of controls, beside the bar of tools if there is one.
pub(super) fn show_help(
    ctx: &egui::Context,
    picture: Rect,
    bar: Option<Rect>,
    layout: &mut layout::Layout,
) {
    if !layout.shows(Card::Help) {
        return;
    }
    let mut open = true;
    let corner = picture.left_top() + vec2(16.0, 16.0);
    let right = bar.map_or(picture.right(), |bar| bar.left()) - 8.0;
    let edges = egui::Frame::window(&ctx.global_style())
        .total_margin()
        .sum();
    let room = right - corner.x - edges.x;
    let shown = egui::Window::new("Controls")
        .id("list of controls".into())
        .open(&mut open)
        .collapsible(false)
        .resizable(false)
        .fixed_pos(corner)
        .max_width(right - corner.x)
        .show(ctx, |ui| {
            // A small window has not room for all of it at once.
            let height = (picture.height() - 84.0).max(80.0);
            egui::ScrollArea::vertical()
                .max_height(height)
                .min_scrolled_height(height)
                .show(ui, |ui| {
                    // Room for the bar, which floats over the content.
                    let margin = egui::Margin {
                        right: 12,
                        ..egui::Margin::ZERO
                    };
                    let frame = egui::Frame::NONE.inner_margin(margin);
                    frame.show(ui, |ui| controls(ui, room - f32::from(margin.right)));
                });
        });
    mark_cross(shown, "help.close");
    if !open {
        layout.close(Card::Help);
    }
}

/// A card in the middle of the picture, over everything else. Gives its layer.
pub(super) fn centred_card(
    ctx: &egui::Context,
    id: &'static str,
    picture: Rect,
    contents: impl FnOnce(&mut Ui),
) -> LayerId {
    let area = egui::Area::new(id.into())
        .order(egui::Order::Foreground)
        .pivot(Align2::CENTER_CENTER)
        .fixed_pos(picture.center());
    let shown = area.show(ctx, |ui| {
        let frame = egui::Frame::popup(ui.style()).inner_margin(16.0);
        frame.show(ui, contents);
    });
    shown.response.layer_id
}

/// A thin bar of what is done, 0 to 1.
pub(super) fn progress_bar(ui: &Ui, done: f32) -> egui::ProgressBar {
    egui::ProgressBar::new(done)
        .fill(theme::accent(ui))
        .desired_height(4.0)
}

/// The name of the look that the picture previews, at its top, and whether it has the steps of the look.
pub(super) fn show_previewed(
    ctx: &egui::Context,
    picture: Rect,
    look: Option<&str>,
    facts: &Facts,
) {
    let Some(name) = look else { return };
    let area = egui::Area::new("previewed".into())
        .pivot(Align2::CENTER_TOP)
        .interactable(false)
        .fixed_pos(picture.center_top() + vec2(0.0, 8.0));
    area.show(ctx, |ui| {
        ui.set_max_width((picture.width() - 40.0).max(80.0));
        egui::Frame::popup(ui.style()).show(ui, |ui| {
            let text = match facts.only_colors {
                Some(why) => format!("Colours of {name} ({why})"),
                None if facts.steps_of.as_deref() == Some(name) => format!("Preview of {name}"),
                None => format!("Preview of {name}: its steps are being computed…"),
            };
            ui.label(RichText::new(text).color(theme::accent(ui)));
        });
    });
}

/// A card over the picture of a window that is to close: what it finishes before that.
pub(super) fn show_ending(ctx: &egui::Context, picture: Rect, out: &ExportFacts) {
    let making = out.making.as_ref();
    let name = making.map_or("the recording", |making| making.name.as_str());
    centred_card(ctx, "ending", picture, |ui| {
        ui.set_width(300.0_f32.min(picture.width() - 64.0));
        ui.label(RichText::new(format!("Finishing {name}")).heading());
        let doing = making.map_or("writing", |making| making.doing.as_str());
        ui.label(RichText::new(doing).color(theme::weak(ui)));
        let done = making.and_then(|making| making.done).unwrap_or(1.0);
        ui.add(progress_bar(ui, done).animate(true));
        ui.add_space(4.0);
        ui.label(if making.is_some() {
            "Then the window closes. Closed once more, it gives that up."
        } else {
            "Then the window closes."
        });
    });
    note_value(ctx, "ending", || name.to_owned());
}

/// The progress of a load with a button to cancel it: a card over the picture, or a line at its top if the scene is the one
/// shown.
pub(super) fn show_loading(
    ctx: &egui::Context,
    picture: Rect,
    loading: &LoadingFacts,
    commands: &mut Vec<Command>,
) {
    let Progress {
        doing,
        done,
        is_cancelled,
    } = loading.progress;
    let doing = if is_cancelled { "ending" } else { doing };
    let mut cancel = |ui: &mut egui::Ui, button: egui::Button<'_>| {
        let clicked = ui
            .add_enabled(!is_cancelled, button)
            .on_hover_text(Action::Back.hint("The scene that runs stays"))
            .marked("cancel")
            .clicked();
        if clicked {
            commands.push(Command::CancelLoading);
        }
    };
    let (pivot, place) = match loading.is_shown {
        true => (Align2::CENTER_TOP, picture.center_top() + vec2(0.0, 8.0)),
        false => (Align2::CENTER_CENTER, picture.center()),
    };
    let area = egui::Area::new("loading".into())
        .pivot(pivot)
        .fixed_pos(place);
    area.show(ctx, |ui| {
        let frame = egui::Frame::popup(ui.style());
        if loading.is_shown {
            frame.show(ui, |ui| {
                ui.horizontal(|ui| {
                    ui.add(progress_bar(ui, done).desired_width(90.0));
                    ui.label(RichText::new(doing).color(theme::weak(ui)));
                    let cross = RichText::new("×").size(16.0);
                    cancel(ui, egui::Button::new(cross).frame(false));
                });
            });
            return;
        }
        frame.inner_margin(16.0).show(ui, |ui| {
            ui.set_width(300.0_f32.min(picture.width() - 64.0));
            ui.label(RichText::new(&loading.name).heading());
            ui.label(RichText::new(doing).color(theme::weak(ui)));
            ui.add(progress_bar(ui, done));
            ui.add_space(4.0);
            cancel(ui, egui::Button::new("Cancel"));
        });
    });
}
