//! The gallery: scenes and presets that come with the program, each with a small picture.

use egui::{ColorImage, Rect, RichText, Sense, TextureHandle, TextureOptions, Ui, vec2};
use myxo::scene::builtin::{Builtin, PRESETS, SCENES};

use super::interface::{Command, Facts, Interface};
use super::places::Marked as _;
use super::theme;

/// Of a small picture, points.
const SIZE: egui::Vec2 = vec2(150.0, 100.0);

macro_rules! pictures {
    ($($name:literal),+ $(,)?) => {
        &[$(($name, include_bytes!(concat!("../../assets/thumbnails/", $name, ".png")))),+]
    };
}

/// The small pictures, as `make gallery` draws them.
static PICTURES: &[(&str, &[u8])] = pictures!(
    "torus", "cube", "sphere", "plane", "pair", "suzanne", "trefoil", "gyroid", "trio", "gears",
    "oats", "crowd", "network", "cells", "ribbons", "spots", "felt", "sparse", "rings", "pores",
    "lace", "waves", "mist", "streams", "feeding", "shy", "meeting",
);

/// Whether it is open, and its pictures once they have been shown.
#[derive(Clone, Default)]
pub struct Gallery {
    /// Is it shown?
    pub open: bool,
    pictures: Vec<(&'static str, TextureHandle)>,
}

impl std::fmt::Debug for Gallery {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Gallery").field("open", &self.open).finish()
    }
}

impl Gallery {
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

impl Interface {
    /// Shows it over the picture, if it is open.
    pub(super) fn show_gallery(
        &mut self,
        ctx: &egui::Context,
        picture: Rect,
        facts: &Facts,
        commands: &mut Vec<Command>,
    ) {
        if !self.gallery.open {
            return;
        }
        let mut open = true;
        let margin = 24.0;
        let size =
            (picture.size() - vec2(2.0 * margin, 2.0 * margin + 30.0)).max(vec2(170.0, 80.0));
        egui::Window::new("Gallery")
            .open(&mut open)
            .collapsible(false)
            .resizable(false)
            .fixed_pos(picture.left_top() + vec2(margin, margin))
            .fixed_size(size)
            .show(ctx, |ui| {
                egui::ScrollArea::vertical()
                    .auto_shrink([false, true])
                    .show(ui, |ui| {
                        ui.set_max_width(size.x - 20.0);
                        ui.label(RichText::new("Scenes").strong());
                        let is_shown = |scene: &Builtin| facts.scene == scene.name;
                        if let Some(scene) = self.cards(ui, SCENES, is_shown) {
                            commands.push(Command::Open(scene.name));
                            self.gallery.open = false;
                        }
                        ui.add_space(8.0);
                        ui.label(RichText::new("Presets").strong());
                        let taken = self.preset;
                        let is_taken = |preset: &Builtin| taken == Some(preset.name);
                        if let Some(preset) = self.cards(ui, PRESETS, is_taken) {
                            self.take_preset(ui.ctx(), preset, commands);
                        }
                    });
            });
        self.gallery.open &= open;
    }

    /// A card for each; gives the one that was clicked.
    fn cards(
        &mut self,
        ui: &mut Ui,
        all: &'static [Builtin],
        is_chosen: impl Fn(&Builtin) -> bool,
    ) -> Option<&'static Builtin> {
        let mut clicked = None;
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing = vec2(10.0, 8.0);
            for builtin in all {
                let texture = self.gallery.picture(ui.ctx(), builtin.name);
                let texture = texture.map(TextureHandle::id);
                if card(ui, builtin, texture, is_chosen(builtin)) {
                    clicked = Some(builtin);
                }
            }
        });
        clicked
    }
}

/// A picture with a name below; true where it was clicked.
fn card(
    ui: &mut Ui,
    builtin: &'static Builtin,
    texture: Option<egui::TextureId>,
    is_chosen: bool,
) -> bool {
    let (rect, response) = ui.allocate_exact_size(SIZE + vec2(0.0, 20.0), Sense::click());
    let response = response
        .on_hover_text(builtin.summary())
        .marked(&format!("card={}", builtin.name));
    response
        .widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, true, builtin.name));
    let image = Rect::from_min_size(rect.min, SIZE);
    let painter = ui.painter();
    painter.rect_filled(image, 4.0, ui.visuals().extreme_bg_color);
    if let Some(texture) = texture {
        let whole = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
        painter.image(texture, image, whole, egui::Color32::WHITE);
    }
    let highlight = is_chosen || response.hovered() || response.has_focus();
    if highlight {
        let stroke = egui::Stroke::new(2.0, theme::accent(ui));
        painter.rect_stroke(image, 4.0, stroke, egui::StrokeKind::Inside);
    }
    let color = if highlight {
        theme::accent(ui)
    } else {
        ui.visuals().text_color()
    };
    painter.text(
        rect.left_bottom() + vec2(2.0, -2.0),
        egui::Align2::LEFT_BOTTOM,
        builtin.name,
        egui::TextStyle::Body.resolve(ui.style()),
        color,
    );
    response.clicked()
}

#[cfg(test)]
mod tests {
    use super::*;

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
