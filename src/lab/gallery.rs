//! The gallery, a drawer beside the picture: looks and scenes that come with the program, looks of one's own, recent files and scenes
//! as they were left, most of them with a small picture. The picture previews the look under the pointer.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use egui::text::{LayoutJob, TextWrapping};
use egui::{
    Align, ColorImage, FontSelection, Layout, Rect, Response, RichText, Sense, TextureHandle,
    TextureOptions, Ui, vec2,
};
use indicatif::HumanDuration;
use myxo::scene::builtin::{Builtin, PRESETS, SCENES};

use crate::lab::command::Command;
use crate::lab::desk::Desk;
use crate::lab::kept_scenes::{KeptScenes, picture_beside};
use crate::lab::layout;
use crate::lab::looks::Looks;
use crate::lab::opening::{EVERYTHING, open_hint};
use crate::lab::places::{Marked as _, note_value};
use crate::lab::preview::Preview;
use crate::lab::recent::Recent;
use crate::lab::theme;
use crate::lab::widgets::{beside, hint_beside, section_with};
use crate::own_presets::{check_name, summary};

/// The least width of a small picture, points.
const LEAST: f32 = 110.0;
/// Between cards.
const BETWEEN: egui::Vec2 = vec2(8.0, 6.0);
/// The picture that enlarges the one of a card, points.
const LARGE: egui::Vec2 = vec2(300.0, 200.0);

/// In the place of a picture that there is not.
const NO_PICTURE: &str = "no picture";

macro_rules! pictures {
    ($($name:literal),+ $(,)?) => {
        &[$(($name, include_bytes!(concat!("../../assets/thumbnails/", $name, ".png")))),+]
    };
}

/// The small pictures, as `make gallery` draws them.
static PICTURES: &[(&str, &[u8])] = pictures!(
    "torus", "cube", "sphere", "plane", "pair", "suzanne", "trefoil", "gyroid", "trio", "gears",
    "oats", "crowd", "maze", "jones", "steiner", "globe", "colony", "network", "cells", "ribbons",
    "spots", "felt", "sparse", "rings", "pores", "lace", "bands", "waves", "mist", "streams",
    "feeding", "shy", "meeting", "bone", "cords", "haze",
);

/// The parts of the drawer that a click at its top leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    Looks,
    Scenes,
    Files,
}

impl Part {
    const ALL: [(Self, &'static str, &'static str); 3] = [
        (Self::Looks, "Looks", "Your looks, and those of the program"),
        (Self::Scenes, "Scenes", "Scenes of the program"),
        (
            Self::Files,
            "Files",
            "Recent files, and scenes as you left them",
        ),
    ];
}

/// The presets and scenes that it lists, and their pictures once they were shown.
#[derive(Clone, Default)]
pub struct Gallery {
    /// Was it shown in the last frame?
    was_open: bool,
    pictures: Vec<(&'static str, TextureHandle)>,
    /// Pictures of the user's presets, by name; some have none.
    own_pictures: BTreeMap<String, Option<TextureHandle>>,
    /// Pictures of scenes as they were left, by their files; some have none.
    left_pictures: BTreeMap<PathBuf, Option<TextureHandle>>,
    /// The name under which the look will be kept.
    pub name: String,
    /// The preset of which it is asked whether it may be removed.
    removing: Option<String>,
    /// Scenes are opened with the look that is here.
    keeps_look: bool,
    /// The part that is scrolled to.
    wanted: Option<Part>,
    /// The look under the pointer in this frame.
    pointed: Option<String>,
    /// Scenes that were left with changes.
    pub kept: KeptScenes,
    /// Files that were opened or saved last.
    pub recent: Recent,
}

impl std::fmt::Debug for Gallery {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Gallery")
            .field("name", &self.name)
            .finish_non_exhaustive()
    }
}

impl Gallery {
    /// Pictures of the user's presets are read again.
    pub fn forget_pictures(&mut self) {
        self.own_pictures.clear();
        self.left_pictures.clear();
        self.removing = None;
    }

    /// All pictures are read again.
    pub fn forget_all_pictures(&mut self) {
        self.pictures.clear();
        self.forget_pictures();
    }

    fn picture(&mut self, ctx: &egui::Context, name: &str) -> Option<&TextureHandle> {
        if self.pictures.is_empty() {
            let decoded = PICTURES.iter().filter_map(|&(name, bytes)| {
                let image = image::load_from_memory(bytes).ok()?.into_rgb8();
                let size = [image.width() as usize, image.height() as usize];
                let image = ColorImage::from_rgb(size, image.as_raw());
                Some((name, ctx.load_texture(name, image, TextureOptions::LINEAR)))
            });
            self.pictures = decoded.collect();
        }
        let found = self.pictures.iter().find(|(known, _)| *known == name);
        found.map(|(_, texture)| texture)
    }
}

impl Gallery {
    /// Shows it at the right edge, if it is open, and lets `preview` follow the pointer.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        looks: &mut Looks,
        preview: &mut Preview,
        desk: &mut Desk<'_>,
    ) {
        let has_come = !self.was_open;
        self.was_open = desk.layout.shows_gallery();
        if !self.was_open {
            return preview.end();
        }
        if has_come {
            self.forget_pictures();
            looks.own.read_again();
            self.kept.read_again();
        }
        self.pointed = None;
        let shown = egui::Panel::right("gallery")
            .exact_size(layout::Layout::gallery_fits(ui.available_width()))
            .resizable(false)
            .show_separator_line(false)
            .frame(theme::panel_frame(ui))
            .show(ui, |ui| {
                self.top(ui, desk);
                let mut area = egui::ScrollArea::vertical().auto_shrink([false, false]);
                if has_come {
                    area = area.vertical_scroll_offset(0.0);
                }
                area.show(ui, |ui| {
                    // Room for the bar, which floats over the content.
                    ui.set_max_width(ui.available_width() - theme::SCROLL_BAR - 4.0);
                    self.looks(ui, looks, preview, desk);
                    self.scenes(ui, desk);
                    self.files(ui, desk);
                });
            });
        self.wanted = None;
        let (now, at, is_pressed) =
            ui.input(|i| (i.time, i.pointer.hover_pos(), i.pointer.any_down()));
        let is_among = at.is_some_and(|at| shown.response.rect.contains(at));
        let pointed = self.pointed.as_deref().filter(|_| !is_pressed);
        if let Some(seconds) = preview.follow(now, pointed, is_among) {
            let delay = std::time::Duration::from_secs_f64(seconds.max(0.0));
            ui.ctx().request_repaint_after(delay);
        }
    }

    /// Its title with a cross, and the ways to its parts.
    fn top(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        ui.horizontal(|ui| {
            ui.label(RichText::new("Gallery").heading());
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                let cross = ui.add(egui::Button::new("✖").frame(false));
                if cross
                    .on_hover_text("Closes it (G)")
                    .marked("gallery.close")
                    .clicked()
                {
                    desk.layout.gallery = false;
                }
            });
        });
        ui.horizontal(|ui| {
            ui.spacing_mut().button_padding.x = 5.0;
            ui.spacing_mut().item_spacing.x = 4.0;
            for (part, title, hint) in Part::ALL {
                let button = ui.button(title).on_hover_text(hint);
                let name = format!("gallery={}", title.to_lowercase());
                if button.marked(&name).clicked() {
                    self.wanted = Some(part);
                }
            }
        });
        ui.add_space(2.0);
        ui.separator();
    }

    /// A part begins here, and is scrolled to if it is wanted.
    fn begin(&self, ui: &mut Ui, part: Part) {
        if self.wanted == Some(part) {
            let at = Rect::from_min_size(ui.cursor().min, vec2(1.0, 1.0));
            ui.scroll_to_rect_animation(at, Some(Align::TOP), egui::style::ScrollAnimation::none());
        }
    }

    fn looks(
        &mut self,
        ui: &mut Ui,
        looks: &mut Looks,
        preview: &mut Preview,
        desk: &mut Desk<'_>,
    ) {
        self.begin(ui, Part::Looks);
        let opens = self.wanted == Some(Part::Looks);
        section_with(ui, "Your looks", true, false, opens, |ui| {
            self.keeping(ui, looks, desk);
            self.own_cards(ui, looks, preview, desk);
        });
        section_with(ui, "Looks", true, false, opens, |ui| {
            let taken = desk.document.preset.clone();
            let is_taken = |preset: &Builtin| taken.as_deref() == Some(preset.name);
            let only = desk.facts.only_colors;
            if let Some(preset) = self.cards(ui, PRESETS, is_taken, Some(only)) {
                preview.end_on(preset.name);
                looks.take_preset(ui.ctx(), preset.name, preset.text, desk);
            }
        });
    }

    fn scenes(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        self.begin(ui, Part::Scenes);
        let opens = self.wanted == Some(Part::Scenes);
        section_with(ui, "Scenes", true, false, opens, |ui| {
            theme::switch(ui, &mut self.keeps_look, "with my look")
                .on_hover_text(
                    "A scene that you click below gets the look that you see now, instead of its own",
                )
                .marked("scenes.look");
            let is_shown = |scene: &Builtin| desk.facts.scene == scene.name;
            if let Some(scene) = self.cards(ui, SCENES, is_shown, None) {
                desk.commands.push(match self.keeps_look {
                    true => Command::OpenWithLook(scene.name),
                    false => Command::Open(scene.name),
                });
            }
        });
    }

    /// Files: one is chosen, those that were opened or saved last, scenes as they were left.
    fn files(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        self.begin(ui, Part::Files);
        let opens = self.wanted == Some(Part::Files);
        section_with(ui, "Recent files", true, false, opens, |ui| {
            let open = ui.button("Open…").on_hover_text(open_hint());
            if open.marked("open").clicked() {
                desk.opening.begin(ui.ctx(), EVERYTHING);
            }
            if let Some(file) = self.recent.list(ui) {
                desk.commands.push(Command::TakeFile(file));
            }
        });
        if !self.kept.all().is_empty() || desk.facts.before.is_some() {
            section_with(ui, "As you left them", true, false, opens, |ui| {
                self.left_scenes(ui, desk);
            });
        }
    }

    /// Shows a card for each; returns the one that was clicked. Those of looks are previewed, and say why if `only` their colours
    /// are.
    fn cards(
        &mut self,
        ui: &mut Ui,
        all: &'static [Builtin],
        is_chosen: impl Fn(&Builtin) -> bool,
        only: Option<Option<&str>>,
    ) -> Option<&'static Builtin> {
        let mut clicked = None;
        let size = card_size(ui.available_width());
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing = BETWEEN;
            for builtin in all {
                let texture = self.picture(ui.ctx(), builtin.name);
                let texture = texture.map(TextureHandle::id);
                let is_chosen = is_chosen(builtin);
                let hint = builtin.summary();
                let card = card(ui, size, builtin.name, texture, is_chosen);
                let card = match only {
                    Some(only) => {
                        if card.contains_pointer() {
                            self.pointed = Some(builtin.name.to_owned());
                        }
                        hint_beside(card, &with_reason(hint, only), "")
                    }
                    None => enlarged(card, texture, hint),
                };
                if card.marked(&format!("card={}", builtin.name)).clicked() {
                    clicked = Some(builtin);
                }
            }
        });
        clicked
    }

    /// Scenes as they were left, the last one first; before them the earlier state that can be continued.
    fn left_scenes(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        let before = desk.facts.before.as_ref();
        if before.is_some_and(|before| before.entry(ui).clicked()) {
            desk.commands.push(Command::GoBack);
        }
        let size = card_size(ui.available_width());
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing = BETWEEN;
            for (i, left) in self.kept.all().iter().enumerate() {
                let age = left.since.elapsed().unwrap_or_default();
                let label = format!("{} · {} ago", left.name, HumanDuration(age));
                let pictures = &mut self.left_pictures;
                let texture = pictures
                    .entry(left.file.clone())
                    .or_insert_with(|| read_picture(ui.ctx(), &picture_beside(&left.file)));
                let texture = texture.as_ref().map(TextureHandle::id);
                let hint = format!(
                    "{label}\nLeft with changes that were not saved; the oldest go first\n{}",
                    left.file.display()
                );
                let card = enlarged(card(ui, size, &label, texture, false), texture, &hint);
                if texture.is_none() {
                    ui.painter().text(
                        card.rect.center() - vec2(0.0, 10.0),
                        egui::Align2::CENTER_CENTER,
                        NO_PICTURE,
                        egui::TextStyle::Small.resolve(ui.style()),
                        theme::weak(ui),
                    );
                }
                if card.marked(&format!("left={i}")).clicked() {
                    desk.commands.push(Command::OpenKept(left.clone()));
                }
            }
        });
    }

    /// A name for the look as it is, and what can be done with it.
    fn keeping(&mut self, ui: &mut Ui, looks: &Looks, desk: &mut Desk<'_>) {
        let name = egui::TextEdit::singleline(&mut self.name)
            .hint_text("name of this look")
            .desired_width(ui.available_width() - 8.0);
        let edit = ui.add(name).marked("preset.name");
        note_value(ui.ctx(), "preset.name", || self.name.clone());
        ui.horizontal(|ui| {
            let checked = check_name(&self.name);
            let is_known = checked.clone().is_ok_and(|name| looks.own.find(name).is_some());
            let label = if is_known { "Replace" } else { "Keep" };
            let reason = checked.clone().err().unwrap_or_default();
            let button = ui
                .add_enabled(checked.is_ok(), egui::Button::new(label))
                .on_hover_text("Keeps the look, with a picture of it as it is now, as a preset of your own")
                .on_disabled_hover_text(reason)
                .marked("preset.keep");
            let entered = edit.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
            if let Ok(name) = checked
                && (button.clicked() || entered)
            {
                desk.commands.push(Command::SavePreset(name.to_owned()));
                self.name.clear();
            }
            if ui
                .button("Copy")
                .on_hover_text("Puts the look into the clipboard as text (Ctrl Shift C), for Ctrl V here or elsewhere")
                .marked("preset.copy")
                .clicked()
            {
                desk.commands.push(Command::CopyLook);
            }
        });
        ui.add_space(2.0);
    }

    /// The user's own presets, each with a way to remove it.
    fn own_cards(
        &mut self,
        ui: &mut Ui,
        looks: &mut Looks,
        preview: &mut Preview,
        desk: &mut Desk<'_>,
    ) {
        if looks.own.all().is_empty() {
            return;
        }
        let mut taken = None;
        let size = card_size(ui.available_width());
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing = BETWEEN;
            for own in looks.own.all() {
                let name = own.name.as_str();
                let pictures = &mut self.own_pictures;
                let texture = pictures
                    .entry(own.name.clone())
                    .or_insert_with(|| read_picture(ui.ctx(), &looks.own.picture(name)?));
                let texture = texture.as_ref().map(TextureHandle::id);
                let hint = match &own.problem {
                    Some(problem) => format!("⚠ {problem}"),
                    None => with_reason(summary(&own.text), desk.facts.only_colors),
                };
                let is_chosen = desk.document.preset.as_deref() == Some(name);
                let card = hint_beside(card(ui, size, name, texture, is_chosen), &hint, "");
                let card = card.marked(&format!("card={name}"));
                if card.contains_pointer() && own.problem.is_none() {
                    self.pointed = Some(own.name.clone());
                }
                if own.problem.is_some() {
                    ui.painter().text(
                        card.rect.center(),
                        egui::Align2::CENTER_CENTER,
                        "⚠",
                        egui::TextStyle::Heading.resolve(ui.style()),
                        theme::error(ui),
                    );
                }
                let asked = self.removing.as_deref() == Some(name);
                match remove_button(ui, &card, size, name, asked) {
                    Some(Removing::Ask) => self.removing = Some(name.to_owned()),
                    Some(Removing::Keep) => self.removing = None,
                    Some(Removing::Remove) => {
                        desk.commands.push(Command::RemovePreset(name.to_owned()));
                    }
                    None if card.clicked() => taken = Some((own.name.clone(), own.text.clone())),
                    None => {}
                }
            }
        });
        if let Some((name, text)) = taken {
            preview.end_on(&name);
            looks.take_preset(ui.ctx(), &name, &text, desk);
        }
    }
}

/// The user's request on a card that can be removed.
enum Removing {
    Ask,
    Keep,
    Remove,
}

/// A cross in the corner of a card; once it was clicked, a question in the middle.
fn remove_button(
    ui: &mut Ui,
    card: &Response,
    size: egui::Vec2,
    name: &str,
    asked: bool,
) -> Option<Removing> {
    let image = Rect::from_min_size(card.rect.min, size);
    // Beside what is laid out, so that the next card stays where it is.
    let mut over = ui.new_child(egui::UiBuilder::new().max_rect(image));
    let ui = &mut over;
    if asked {
        ui.painter()
            .rect_filled(image, 4.0, egui::Color32::from_black_alpha(170));
        let size = vec2(66.0, 24.0);
        let place = |x: f32| Rect::from_center_size(image.center() + vec2(x, 0.0), size);
        let remove = egui::Button::new(RichText::new("Remove").color(theme::error(ui)));
        let remove = ui.put(place(-36.0), remove).on_hover_text("For good");
        let keep = ui.put(place(36.0), egui::Button::new("Keep"));
        if remove.marked(&format!("remove={name}:yes")).clicked() {
            return Some(Removing::Remove);
        }
        let kept = keep.marked(&format!("remove={name}:no")).clicked();
        return kept.then_some(Removing::Keep);
    }
    let corner = Rect::from_min_size(image.right_top() + vec2(-24.0, 4.0), vec2(20.0, 20.0));
    let cross = ui
        .put(corner, egui::Button::new("✖").small())
        .on_hover_text("Remove it");
    let clicked = cross.marked(&format!("remove={name}")).clicked();
    clicked.then_some(Removing::Ask)
}

/// The size of a card's picture where as many as fit stand side by side and fill the room.
fn card_size(room: f32) -> egui::Vec2 {
    let count = ((room + BETWEEN.x) / (LEAST + BETWEEN.x)).floor().max(1.0);
    // Whole points, or rounding would send the last one to the next line.
    let width = ((room - (count - 1.0) * BETWEEN.x) / count - 0.5).floor();
    let width = width.max(LEAST);
    vec2(width, (width / 1.5).round())
}

/// A small picture from a file, if it can be read.
fn read_picture(ctx: &egui::Context, file: &Path) -> Option<TextureHandle> {
    let image = image::open(file).ok()?.into_rgb8();
    let size = [image.width() as usize, image.height() as usize];
    let image = ColorImage::from_rgb(size, image.as_raw());
    let name = file.display().to_string();
    Some(ctx.load_texture(name, image, TextureOptions::LINEAR))
}

/// A hint on a look, with the reason why only its colours are previewed, if there is one.
fn with_reason(hint: &str, only: Option<&str>) -> String {
    match only {
        Some(why) => format!("{hint}\nOnly its colours are previewed: {why}"),
        None => hint.to_owned(),
    }
}

/// A card whose picture and text are shown larger while the pointer rests on it.
fn enlarged(card: Response, texture: Option<egui::TextureId>, hint: &str) -> Response {
    beside(card, |ui| {
        ui.set_max_width(LARGE.x);
        if let Some(texture) = texture {
            ui.image((texture, LARGE));
        }
        ui.label(hint);
    })
}

/// A picture with a name below, which is cut where it is too long.
fn card(
    ui: &mut Ui,
    size: egui::Vec2,
    name: &str,
    texture: Option<egui::TextureId>,
    is_chosen: bool,
) -> Response {
    let (rect, response) = ui.allocate_exact_size(size + vec2(0.0, 19.0), Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, true, name));
    let image = Rect::from_min_size(rect.min, size);
    let painter = ui.painter();
    painter.rect_filled(image, 4.0, ui.visuals().extreme_bg_color);
    if let Some(texture) = texture {
        let whole = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
        painter.image(texture, image, whole, egui::Color32::WHITE);
    }
    // The card under the pointer is not the chosen card.
    let is_pointed_at = response.hovered() || response.has_focus();
    let (line, color) = match (is_chosen, is_pointed_at) {
        (true, _) => (egui::Stroke::new(2.5, theme::accent(ui)), theme::accent(ui)),
        (false, true) => (
            egui::Stroke::new(1.0, theme::weak(ui)),
            ui.visuals().strong_text_color(),
        ),
        (false, false) => (egui::Stroke::NONE, ui.visuals().text_color()),
    };
    painter.rect_stroke(image, 4.0, line, egui::StrokeKind::Inside);
    let font = FontSelection::Style(egui::TextStyle::Body).resolve(ui.style());
    let mut job = LayoutJob::simple_singleline(name.to_owned(), font, color);
    job.wrap = TextWrapping::truncate_at_width(size.x - 4.0);
    let text = painter.layout_job(job);
    let at = rect.left_bottom() + vec2(2.0, -1.0 - text.size().y);
    painter.galley(at, text, color);
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cards_fill_the_width() {
        for room in [100.0, 150.0, 152.0, 254.0, 309.0, 880.0, 1283.7] {
            let width = card_size(room).x;
            let count = ((room + BETWEEN.x) / (width + BETWEEN.x)).floor().max(1.0);
            let left = room - count * (width + BETWEEN.x) + BETWEEN.x;
            assert!(
                width >= LEAST && left < 2.0 * count,
                "{room}: {left} are left"
            );
        }
    }

    #[test]
    fn every_scene_and_preset_has_a_picture() {
        let names: Vec<&str> = SCENES.iter().chain(PRESETS).map(|b| b.name).collect();
        let pictures: Vec<&str> = PICTURES.iter().map(|(name, _)| *name).collect();
        assert_eq!(names, pictures);
        for (name, bytes) in PICTURES {
            let image = image::load_from_memory(bytes).unwrap().into_rgb8();
            assert_eq!((image.width(), image.height()), (300, 200), "{name}");
            let lit = image.pixels().filter(|p| p.0.iter().max() > Some(&100));
            assert!(lit.count() > 500, "{name} shows something");
        }
    }
}
