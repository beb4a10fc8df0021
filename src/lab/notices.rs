//! Notices over the picture: news for a while, and errors until they are clicked away.

use std::time::Duration;

use egui::{Align, Align2, Layout, Rect, RichText, Sense, Ui, UiBuilder, vec2};

use crate::lab::places::Marked as _;
use crate::lab::theme;

/// Errors that are shown at once; the oldest go.
const MOST_ERRORS: usize = 4;

/// How the picture alone ends.
pub const HOW_BACK: &str = "Esc brings the panel back";

/// How the autopilot ends.
pub const HOW_DRIFT_ENDS: &str = "Autopilot: any key or movement ends it";

/// All notices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Notices {
    /// The last news, and the time until which it is shown.
    news: Option<(String, f64)>,
    /// Errors, the latest last.
    errors: Vec<String>,
    /// Errors of dropped files, until all of the files have arrived: together they are one error.
    dropped: Option<Vec<String>>,
}

impl Notices {
    /// All of it, as tests and the terminal read it.
    pub fn text(&self) -> Option<String> {
        let news = self.news.iter().map(|(text, _)| text);
        let lines: Vec<&str> = self.errors.iter().chain(news).map(String::as_str).collect();
        (!lines.is_empty()).then(|| lines.join("\n"))
    }

    /// Files are dropped: their errors are shown together.
    pub fn begin_drop(&mut self) {
        self.dropped.get_or_insert_default();
    }

    /// All that were dropped are there, or will never be.
    pub fn end_drop(&mut self) {
        self.dropped = None;
    }

    /// Shows a notice: for a while or, if it is an error, until it is clicked away.
    pub fn say(&mut self, ctx: &egui::Context, text: impl Into<String>, is_error: bool) {
        let text = text.into();
        if is_error {
            self.fail(text);
        } else {
            let until = ctx.input(|i| i.time) + seconds_for(&text);
            self.news = Some((text, until));
        }
    }

    /// Shows them, errors below. If the picture `is_alone`, only errors and the key that ends this state are shown.
    pub fn show(&mut self, ui: &Ui, picture: Rect, is_alone: bool) {
        let now = ui.input(|i| i.time);
        let Notices { news, errors, .. } = self;
        news.take_if(|(_, until)| now > *until);
        let news = news
            .as_ref()
            .filter(|(text, _)| !is_alone || [HOW_BACK, HOW_DRIFT_ENDS].contains(&text.as_str()));
        if news.is_none() && errors.is_empty() {
            return;
        }
        if let Some((_, until)) = news {
            // Nothing else may happen until it goes.
            let left = Duration::from_secs_f64((until - now).max(0.0));
            ui.ctx().request_repaint_after(left);
        }
        let mut gone = None;
        // Panels beside the picture may be of different widths.
        let window = ui.ctx().content_rect();
        let aside = picture.center().x - window.center().x;
        let above = (picture.bottom() - window.bottom() - 14.0).min(-44.0);
        let widest = (picture.width() - 60.0).max(120.0);
        let mut news_above = above;
        if !errors.is_empty() {
            let shown = egui::Area::new("errors".into())
                .anchor(Align2::CENTER_BOTTOM, vec2(aside, above))
                .show(ui.ctx(), |ui| {
                    ui.set_max_width(widest);
                    for (i, error) in errors.iter().enumerate() {
                        if show_error(ui, i, error) {
                            gone = Some(i);
                        }
                    }
                });
            news_above -= shown.response.rect.height() + ui.spacing().item_spacing.y;
        }
        // A message goes by itself: it is above, in an area of its own, so that no error moves from under the pointer then.
        if let Some((text, _)) = news {
            egui::Area::new("news".into())
                .anchor(Align2::CENTER_BOTTOM, vec2(aside, news_above))
                .interactable(false)
                .show(ui.ctx(), |ui| {
                    ui.set_max_width(widest);
                    ui.with_layout(Layout::top_down(Align::Center), |ui| {
                        egui::Frame::popup(ui.style()).show(ui, |ui| {
                            ui.label(RichText::new(&*text).color(theme::accent(ui)));
                        });
                    });
                });
        }
        if let Some(gone) = gone {
            errors.remove(gone);
        }
    }

    fn fail(&mut self, text: String) {
        let text = match &mut self.dropped {
            None => text,
            Some(wrong) => {
                let before = wrong.join("\n");
                if !wrong.contains(&text) {
                    wrong.push(text);
                }
                self.errors.retain(|error| *error != before);
                wrong.join("\n")
            }
        };
        // A repeated error becomes the latest one.
        self.errors.retain(|error| *error != text);
        self.errors.push(text);
        let old = self.errors.len().saturating_sub(MOST_ERRORS);
        self.errors.drain(..old);
    }
}

/// An error on a card of its own; true if it was clicked away.
fn show_error(ui: &mut Ui, place: usize, error: &str) -> bool {
    let card = UiBuilder::new().sense(Sense::click());
    let shown = ui.scope_builder(card, |ui| {
        egui::Frame::popup(ui.style()).show(ui, |ui| {
            ui.with_layout(Layout::right_to_left(Align::Min), |ui| {
                let cross = RichText::new("×").color(theme::weak(ui));
                ui.add(egui::Label::new(cross).selectable(false));
                let copy = RichText::new("🗐").small().color(theme::weak(ui));
                let copy = ui.add(egui::Button::new(copy).frame(false));
                let copy = copy.on_hover_text("Copies what it says");
                if copy.marked(&format!("error.{place}:copy")).clicked() {
                    ui.ctx().copy_text(error.to_owned());
                }
                ui.with_layout(Layout::top_down(Align::Min), |ui| {
                    let text = RichText::new(error).color(theme::error(ui));
                    ui.add(egui::Label::new(text).selectable(false));
                });
            });
        });
    });
    let response = shown.response.on_hover_text("Click it away");
    response.marked(&format!("error.{place}")).clicked()
}

/// How long a line is shown.
fn seconds_for(text: &str) -> f64 {
    3.0 + 0.05 * text.len() as f64
}
