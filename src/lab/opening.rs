//! "Open…": a file that is chosen in the window itself, for whoever cannot drop one onto it, as on Wayland. It goes the way
//! of a file that was dropped.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use egui::layers::ShapeIdx;
use egui::{Align2, Color32, Shape, Vec2, vec2};
use egui_file_dialog::{DialogState, FileDialog, Filter, OpeningMode};

use super::hands::{MESHES, ends_so};
use super::interface::{Command, Interface};
use super::theme;

/// What a control says that leads to it.
pub const OPEN: &str = "Opens a file: scene, preset, mesh or checkpoint (Ctrl O). Files can be dropped onto the window, too";

/// The same where an object is wanted.
pub const OPEN_MESH: &str =
    "Adds the mesh of a file: .obj, .glb or .gltf. Files can be dropped onto the window, too";

/// The kinds of files that the dialog shows at first.
pub const EVERYTHING: &str = "what opens here";
pub const ONLY_MESHES: &str = "meshes";

/// Of the dialog where the window has room for it, points.
const SIZE: Vec2 = vec2(740.0, 460.0);
/// What stays free of the window's width and height: the dialog's title counts, too.
const ROUND_IT: Vec2 = vec2(24.0, 40.0);
/// A dialog narrower than this needs it for names of files, not for places.
const HAS_ROOM: f32 = 600.0;
/// What a folder's files are chosen from: a name, and how those files end.
const KINDS: &[(&str, &[&[&str]])] = &[
    (EVERYTHING, &[&["toml", "ckpt"], MESHES]),
    ("scenes and presets", &[&["toml"]]),
    (ONLY_MESHES, &[MESHES]),
    ("checkpoints", &[&["ckpt"]]),
];

/// The dialog, once somebody has asked for it. A copy shows the same one.
#[derive(Clone, Debug, Default)]
pub struct Opening {
    dialog: Option<Rc<RefCell<FileDialog>>>,
    /// Where it begins; empty for where the program is started.
    folder: PathBuf,
}

impl Opening {
    /// Is it shown? Then keys are its own.
    pub fn is_open(&self) -> bool {
        let dialog = self.dialog.as_ref();
        dialog.is_some_and(|dialog| *dialog.borrow().state() == DialogState::Open)
    }

    /// The next time it begins in this folder.
    pub fn begin_in(&mut self, folder: &Path) {
        self.folder = folder.to_owned();
    }

    fn open(&mut self, ctx: &egui::Context, kind: &str) {
        let dialog = self.dialog.get_or_insert_with(|| Rc::new(dialog().into()));
        let mut dialog = dialog.borrow_mut();
        let config = dialog.config_mut();
        let folder = match std::path::absolute(&self.folder) {
            Ok(folder) if folder.is_dir() => Ok(folder),
            _ => std::env::current_dir(),
        };
        config.initial_directory = folder.unwrap_or_default();
        config.default_file_filter = Some(kind.to_owned());
        let room = ctx.content_rect().size() - ROUND_IT;
        config.default_size = SIZE.min(room);
        config.min_size = vec2(400.0, 200.0).min(room);
        config.max_size = Some(room);
        config.show_left_panel = room.x >= HAS_ROOM;
        // A text that has the keyboard would keep it.
        ctx.memory_mut(egui::Memory::stop_text_input);
        dialog.pick_file();
    }

    /// Shows it for one frame, and gives what was chosen in it.
    fn show(&self, ctx: &egui::Context) -> Option<PathBuf> {
        let mut dialog = self.dialog.as_ref()?.borrow_mut();
        if *dialog.state() != DialogState::Open {
            return None;
        }
        let layer = egui::LayerId::new(egui::Order::Middle, dialog.get_window_id());
        // The tabulator does not lead out of it.
        ctx.memory_mut(|memory| memory.set_modal_layer(layer));
        let style = ctx.global_style();
        ctx.global_style_mut(|style| theme::fill_selection(&mut style.visuals));
        dialog.update(ctx);
        ctx.set_global_style(Arc::clone(&style));
        lighten_fields(ctx, layer, style.visuals.extreme_bg_color);
        dialog.take_picked()
    }
}

/// A dialog in the words of the lab, without what only those need who save.
fn dialog() -> FileDialog {
    let mut dialog = FileDialog::new()
        .title("Open a file")
        .anchor(Align2::CENTER_CENTER, Vec2::ZERO)
        .movable(false)
        .opening_mode(OpeningMode::AlwaysInitialDir)
        // A scene is called as the file that was chosen, also where that is a link.
        .canonicalize_paths(false)
        .show_new_folder_button(false)
        // They would be forgotten at the end.
        .show_pinned_folders(false);
    for (name, endings) in KINDS {
        dialog = dialog.add_file_filter(name, Filter::new(|path: &Path| ends_so(path, endings)));
    }
    dialog.config_mut().keybindings.new_folder.clear();
    let labels = dialog.labels_mut();
    labels.file_filter_all_files = "all files".to_owned();
    labels.open_button = "Open".to_owned();
    labels.cancel_button = "Cancel".to_owned();
    dialog
}

/// The dialog draws its fields black, also where letters are black, too; this gives them the theme's colour.
fn lighten_fields(ctx: &egui::Context, layer: egui::LayerId, color: Color32) {
    fn lighten(shape: &mut Shape, color: Color32) {
        match shape {
            Shape::Rect(rect) if rect.fill == Color32::from_black_alpha(250) => rect.fill = color,
            Shape::Vec(shapes) => shapes.iter_mut().for_each(|shape| lighten(shape, color)),
            _ => {}
        }
    }
    ctx.graphics_mut(|graphics| {
        let painted = graphics.entry(layer);
        let count = painted.all_entries().len();
        for i in 0..count {
            painted.mutate_shape(ShapeIdx(i), |entry| lighten(&mut entry.shape, color));
        }
    });
}

impl Interface {
    /// Shows the dialog over everything else, with the files of that kind at first.
    pub(super) fn begin_to_open(&mut self, ctx: &egui::Context, kind: &str) {
        self.gallery.open = false;
        self.opening.open(ctx, kind);
    }

    /// Shows it for one frame, if it is open.
    pub(super) fn show_opening(&mut self, ctx: &egui::Context, commands: &mut Vec<Command>) {
        commands.extend(self.opening.show(ctx).map(Command::TakeFile));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_can_be_dropped_is_shown_at_first() {
        let is_shown = |name: &str| ends_so(Path::new(name), KINDS[0].1);
        for name in ["a.toml", "b.OBJ", "c.glb", "d.gltf", "e.ckpt"] {
            assert!(is_shown(name), "{name}");
        }
        for name in ["letter.txt", "obj", ".toml", "film.mp4"] {
            assert!(!is_shown(name), "{name}");
        }
    }
}
