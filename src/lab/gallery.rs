//! The gallery: scenes and presets that come with the program, and presets of one's own, each with a small picture.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use egui::{ColorImage, Rect, Response, RichText, Sense, TextureHandle, TextureOptions, Ui, vec2};
use indicatif::HumanDuration;
use myxo::scene::builtin::{Builtin, PRESETS, SCENES};

use crate::lab::command::Command;
use crate::lab::desk::Desk;
use crate::lab::kept_scenes::{KeptScenes, picture_beside};
use crate::lab::layout::Card;
use crate::lab::looks::Looks;
use crate::lab::opening::{EVERYTHING, open_hint};
use crate::lab::places::{Marked as _, mark_cross, note_value};
use crate::lab::recent::Recent;
use crate::lab::theme;
use crate::own_presets::{check_name, summary};

/// The least width of a small picture, points.
const LEAST: f32 = 150.0;
/// Between cards.
const BETWEEN: egui::Vec2 = vec2(10.0, 8.0);

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
    "oats", "crowd", "maze", "network", "cells", "ribbons", "spots", "felt", "sparse", "rings",
    "pores", "lace", "bands", "waves", "mist", "streams", "feeding", "shy", "meeting",
);

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
    /// Shows it over the picture, if it is open.
    pub fn show(
        &mut self,
        ctx: &egui::Context,
        picture: Rect,
        looks: &mut Looks,
        desk: &mut Desk<'_>,
    ) {
        if !desk.layout.shows(Card::Gallery) {
            self.was_open = false;
            return;
        }
        let has_come = !self.was_open;
        if has_come {
            self.was_open = true;
            self.forget_pictures();
            looks.own.read_again();
            self.kept.read_again();
        }
        let mut open = true;
        let margin = 24.0;
        let size =
            (picture.size() - vec2(2.0 * margin, 2.0 * margin + 30.0)).max(vec2(170.0, 80.0));
        let shown = egui::Window::new("Gallery")
            .open(&mut open)
            .collapsible(false)
            .resizable(false)
            .fixed_pos(picture.left_top() + vec2(margin, margin))
            .fixed_size(size)
            .show(ctx, |ui| {
                let mut area = egui::ScrollArea::vertical().auto_shrink([false, true]);
                if has_come {
                    area = area.vertical_scroll_offset(0.0);
                }
                area.show(ui, |ui| {
                    // Room for the bar, which floats over the content.
                    ui.set_max_width(ui.available_width() - theme::SCROLL_BAR - 4.0);
                    self.left_scenes(ui, desk);
                    ui.horizontal(|ui| {
                        ui.label(RichText::new("Scenes").strong());
                        let open = ui.button("Open…").on_hover_text(open_hint());
                        if open.marked("open").clicked() {
                            desk.opening.begin(ui.ctx(), EVERYTHING);
                        }
                        if let Some(file) = self.recent.menu(ui) {
                            desk.commands.push(Command::TakeFile(file));
                            desk.layout.close(Card::Gallery);
                        }
                        theme::switch(ui, &mut self.keeps_look, "with my look")
                            .on_hover_text(
                                "A scene that you click below gets the look that you see now, instead of its own",
                            )
                            .marked("scenes.look");
                    });
                    let is_shown = |scene: &Builtin| desk.facts.scene == scene.name;
                    if let Some(scene) = self.cards(ui, SCENES, is_shown) {
                        desk.commands.push(match self.keeps_look {
                            true => Command::OpenWithLook(scene.name),
                            false => Command::Open(scene.name),
                        });
                        desk.layout.close(Card::Gallery);
                    }
                    ui.add_space(8.0);
                    ui.label(RichText::new("Presets").strong());
                    self.keeping(ui, looks, desk);
                    self.own_cards(ui, looks, desk);
                    let taken = desk.document.preset.clone();
                    let is_taken = |preset: &Builtin| taken.as_deref() == Some(preset.name);
                    if let Some(preset) = self.cards(ui, PRESETS, is_taken) {
                        looks.take_preset(ui.ctx(), preset.name, preset.text, desk);
                    }
                });
            });
        mark_cross(shown, "gallery.close");
        if !open {
            desk.layout.close(Card::Gallery);
        }
    }

    /// Shows a card for each; returns the one that was clicked.
    fn cards(
        &mut self,
        ui: &mut Ui,
        all: &'static [Builtin],
        is_chosen: impl Fn(&Builtin) -> bool,
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
                let card = card(ui, size, builtin.name, hint, texture, is_chosen);
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
        if self.kept.all().is_empty() && before.is_none() {
            return;
        }
        ui.label(RichText::new("As you left them").strong())
            .on_hover_text(
                "Scenes that you left with changes that you had not saved; the oldest go first. ↶ is what had grown before the \
                 last reset or scene, until the window closes or the device is lost",
            );
        if before.is_some_and(|before| before.entry(ui).clicked()) {
            desk.commands.push(Command::GoBack);
            desk.layout.close(Card::Gallery);
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
                let hint = left.file.display().to_string();
                let card = card(ui, size, &label, &hint, texture, false);
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
                    desk.layout.close(Card::Gallery);
                }
            }
        });
        ui.add_space(8.0);
    }

    /// A name for the look as it is, and what can be done with it.
    fn keeping(&mut self, ui: &mut Ui, looks: &Looks, desk: &mut Desk<'_>) {
        ui.horizontal(|ui| {
            let name = egui::TextEdit::singleline(&mut self.name)
                .hint_text("name of this look")
                .desired_width(150.0);
            let edit = ui.add(name).marked("preset.name");
            note_value(ui.ctx(), "preset.name", || self.name.clone());
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
    fn own_cards(&mut self, ui: &mut Ui, looks: &mut Looks, desk: &mut Desk<'_>) {
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
                    None => summary(&own.text).to_owned(),
                };
                let is_chosen = desk.document.preset.as_deref() == Some(name);
                let card = card(ui, size, name, &hint, texture, is_chosen);
                let card = card.marked(&format!("card={name}"));
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
            looks.take_preset(ui.ctx(), &name, &text, desk);
        }
        ui.add_space(8.0);
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

/// A picture with a name below.
fn card(
    ui: &mut Ui,
    size: egui::Vec2,
    name: &str,
    hint: &str,
    texture: Option<egui::TextureId>,
    is_chosen: bool,
) -> Response {
    let (rect, response) = ui.allocate_exact_size(size + vec2(0.0, 20.0), Sense::click());
    let response = response.on_hover_text(hint);
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
    let painter = painter.with_clip_rect(rect.intersect(painter.clip_rect()));
    painter.text(
        rect.left_bottom() + vec2(2.0, -2.0),
        egui::Align2::LEFT_BOTTOM,
        name,
        egui::TextStyle::Body.resolve(ui.style()),
        color,
    );
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cards_fill_the_width() {
        for room in [100.0, 150.0, 309.0, 310.0, 880.0, 1283.7] {
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
