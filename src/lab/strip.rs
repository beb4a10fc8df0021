//! The strip below the picture: the states that are kept, each with a small picture, and a button to keep one now.

use std::collections::BTreeMap;

use egui::{Align2, Area, Rect, RichText, Sense, TextureHandle, TextureOptions, Ui, vec2};
use indicatif::HumanDuration;
use myxo::plain_text::with_commas;

use crate::lab::command::Command;
use crate::lab::desk::Desk;
use crate::lab::facts::KeptFacts;
use crate::lab::places::{Marked as _, note_value};
use crate::lab::theme;
use crate::lab::timeline::{INTERVAL, MOST, MOST_BYTES};

/// The size of a picture, and the height of the strip, points.
const PICTURE: egui::Vec2 = vec2(84.0, 56.0);
const HEIGHT: f32 = 92.0;
/// A window lower than this has no room for it, points.
const LEAST: f32 = 330.0;

/// The strip, with the pictures that were shown.
#[derive(Clone, Default)]
pub struct Strip {
    pictures: BTreeMap<u64, TextureHandle>,
}

impl std::fmt::Debug for Strip {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Strip").finish_non_exhaustive()
    }
}

impl Strip {
    /// All pictures are uploaded again.
    pub fn forget_pictures(&mut self) {
        self.pictures.clear();
    }

    /// Shows it at the lower edge, if it is unfolded and there is room.
    pub fn show(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        if !desk.layout.timeline || desk.layout.alone || ui.available_height() < LEAST {
            return;
        }
        let kept = &desk.facts.kept;
        self.pictures
            .retain(|number, _| kept.iter().any(|kept| kept.number == *number));
        egui::Panel::bottom("timeline")
            .exact_size(HEIGHT)
            .resizable(false)
            .show_separator_line(false)
            .frame(theme::panel_frame(ui).inner_margin(egui::Margin::symmetric(10, 8)))
            .show(ui, |ui| {
                ui.horizontal_top(|ui| {
                    ui.vertical(|ui| {
                        ui.set_width(66.0);
                        fold_button(ui, desk, "⏷ fold");
                        let keep = ui.button("+ keep");
                        let keep = keep.on_hover_text("Keeps the state as it is now");
                        if keep.marked("timeline.keep").clicked() {
                            desk.commands.push(Command::KeepState);
                        }
                    });
                    let area = egui::ScrollArea::horizontal().auto_shrink([false, false]);
                    area.stick_to_right(true).show(ui, |ui| {
                        ui.horizontal_top(|ui| {
                            ui.spacing_mut().item_spacing.x = 6.0;
                            for (i, kept) in desk.facts.kept.iter().enumerate() {
                                if self.card(ui, i, kept) {
                                    desk.commands.push(Command::ToState(kept.number));
                                }
                            }
                            if desk.facts.kept.is_empty() {
                                let text = RichText::new("Nothing is kept yet.");
                                ui.label(text.color(theme::weak(ui)));
                            }
                        });
                    });
                });
            });
        note_value(ui.ctx(), "kept", || desk.facts.kept.len().to_string());
    }

    /// Shows one; true if it was clicked.
    fn card(&mut self, ui: &mut Ui, place: usize, kept: &KeptFacts) -> bool {
        let texture = self.pictures.entry(kept.number).or_insert_with(|| {
            let image = kept.picture.as_ref().clone();
            let name = format!("kept {}", kept.number);
            ui.ctx().load_texture(name, image, TextureOptions::LINEAR)
        });
        let texture = texture.id();
        let (rect, response) = ui.allocate_exact_size(PICTURE + vec2(0.0, 15.0), Sense::click());
        let step = format!("step {}", with_commas(kept.step as f64));
        response.widget_info(|| {
            egui::WidgetInfo::labeled(egui::WidgetType::Button, true, step.clone())
        });
        let image = Rect::from_min_size(rect.min, PICTURE);
        let whole = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
        let painter = ui.painter();
        painter.image(texture, image, whole, egui::Color32::WHITE);
        let is_pointed_at = response.hovered() || response.has_focus();
        let line = match (is_pointed_at, kept.by_user) {
            (true, _) => egui::Stroke::new(2.0, theme::accent(ui)),
            (_, true) => egui::Stroke::new(1.0, theme::accent(ui)),
            _ => egui::Stroke::new(1.0, theme::weak(ui).gamma_multiply(0.4)),
        };
        painter.rect_stroke(image, 3.0, line, egui::StrokeKind::Inside);
        painter.text(
            rect.left_bottom(),
            Align2::LEFT_BOTTOM,
            &step,
            egui::TextStyle::Small.resolve(ui.style()),
            if is_pointed_at {
                ui.visuals().strong_text_color()
            } else {
                theme::weak(ui)
            },
        );
        let kept_by = if kept.by_user { "Kept by you" } else { "Kept" };
        let age = HumanDuration(kept.since.elapsed());
        let hint = format!(
            "{kept_by} {age} ago at {step}. A click brings back particles, trail and settings; the present state is kept, and Ctrl Z \
             returns to it"
        );
        response
            .on_hover_text(hint)
            .marked(&format!("kept={place}"))
            .clicked()
    }
}

/// The button that unfolds the strip, in the corner of the picture.
pub fn show_folded(ctx: &egui::Context, picture: Rect, desk: &mut Desk<'_>) {
    let is_small = picture.width() < 260.0 || picture.height() < LEAST;
    if desk.layout.timeline || desk.layout.alone || is_small {
        return;
    }
    let area = Area::new("timeline folded".into())
        .pivot(Align2::LEFT_BOTTOM)
        .fixed_pos(picture.left_bottom() + vec2(8.0, -8.0));
    area.show(ctx, |ui| {
        let count = desk.facts.kept.len();
        fold_button(ui, desk, &format!("🕘 {count}"));
    });
}

fn fold_button(ui: &mut Ui, desk: &mut Desk<'_>, text: &str) {
    let hint = format!(
        "States of this scene: every {} s one is kept in memory, at most {MOST} and {} MiB; of older ones fewer stay. A click on \
         one goes back to it",
        INTERVAL.as_secs(),
        MOST_BYTES >> 20
    );
    let button = ui.button(RichText::new(text).small()).on_hover_text(hint);
    if button.marked("timeline").clicked() {
        desk.layout.timeline = !desk.layout.timeline;
    }
}
