//! "Open…": a dialog in the window itself that chooses a file, for systems where files cannot be dropped onto it, such as
//! Wayland. The file is opened like a dropped one; a picture to begin on goes into the row that asks for it. The same dialog
//! asks where to save, and for the folder of exports.

use std::cell::RefCell;
use std::mem::discriminant;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use egui::layers::ShapeIdx;
use egui::{Align2, Color32, Rect, RichText, Shape, Vec2, vec2};
use egui_file_dialog::{DialogState, FileDialog, Filter, OpeningMode};
use myxo::scene::settings::Settings;

use crate::lab::actions::Action;
use crate::lab::command::Command;
use crate::lab::overlays::centred_card;
use crate::lab::places::Marked as _;
use crate::lab::saving::{MESHES, ends_so, is_mesh, whole};
use crate::lab::theme;

/// The hint of a control that opens the dialog.
pub fn open_hint() -> String {
    let hint = "Opens a file: scene, preset, mesh or checkpoint. Files can be dropped onto the window, too";
    Action::Open.hint(hint)
}

/// The hint of a control that adds an object.
pub const OPEN_MESH: &str = "Adds the mesh of a file: .obj, .stl, .ply, .glb or .gltf. Files can be dropped onto the window, too";

/// The hint of a control that asks for a picture to begin on.
pub const OPEN_MASK: &str = "Chooses the picture: a PNG laid over the whole texture";

/// The kinds of files that the dialog shows at first.
pub const EVERYTHING: &str = "what opens here";
pub const ONLY_MESHES: &str = "meshes";

/// Size of the dialog if the window has room for it, points.
const SIZE: Vec2 = vec2(740.0, 460.0);
/// The part of the window's width and height outside the dialog's contents, including its title.
const ROUND_IT: Vec2 = vec2(24.0, 40.0);
/// A dialog narrower than this needs it for names of files, not for places.
const HAS_ROOM: f32 = 600.0;
/// Kinds of files offered in a folder: a name, and the endings of the files.
type Kinds = &'static [(&'static str, &'static [&'static [&'static str]])];
const KINDS: Kinds = &[
    (EVERYTHING, &[&["toml", "ckpt"], MESHES]),
    ("scenes and presets", &[&["toml"]]),
    (ONLY_MESHES, &[MESHES]),
    ("checkpoints", &[&["ckpt"]]),
];
/// The ending of scene files, by its name.
const SCENES: (&str, &str) = ("scenes", "toml");
const MASKS: Kinds = &[("PNG pictures", &[&["png"]])];

/// The purpose of the dialog.
#[derive(Clone, Debug, Default, PartialEq)]
enum Purpose {
    /// A file of any kind that opens.
    #[default]
    Open,
    /// A mesh that joins the scene.
    Join,
    /// A picture for the row with this key.
    Mask(String),
    /// A file in which the scene is saved.
    Save,
    /// The folder for exports.
    Folder,
}

/// The dialog, once it was opened. A copy shows the same dialog.
#[derive(Clone, Debug, Default)]
pub struct Opening {
    dialog: Option<Rc<RefCell<FileDialog>>>,
    purpose: Purpose,
    /// The folder in which it opens; empty for the folder in which the program was started.
    folder: PathBuf,
    /// The folder of the scene's file; empty for the folder in which the program was started.
    scene: PathBuf,
    /// A mesh that was chosen, of which it is asked whether it joins the scene.
    mesh: Option<PathBuf>,
}

impl Opening {
    /// Is it shown? Then keys are its own.
    pub fn is_open(&self) -> bool {
        if self.mesh.is_some() {
            return true;
        }
        let dialog = self.dialog.as_ref();
        dialog.is_some_and(|dialog| *dialog.borrow().state() == DialogState::Open)
    }

    /// The next time it begins in this folder.
    pub fn begin_in(&mut self, folder: &Path) {
        self.folder = folder.to_owned();
    }

    /// Another scene comes, so a question where to save the old one is withdrawn.
    pub fn leave_scene(&mut self) {
        self.mesh = None;
        if self.purpose == Purpose::Save {
            self.purpose = Purpose::Open;
            self.dialog = None;
        }
    }

    /// Paths of pictures count from this folder.
    pub fn count_from(&mut self, scene: &Path) {
        self.scene = scene.to_owned();
        // The row that a picture was to be chosen for is another scene's.
        if matches!(self.purpose, Purpose::Mask(_)) {
            self.purpose = Purpose::Open;
            self.dialog = None;
        }
    }

    /// Shows the dialog over everything else, with the files of that kind at first.
    pub fn begin(&mut self, ctx: &egui::Context, kind: &str) {
        let joins = kind == ONLY_MESHES;
        let purpose = if joins { Purpose::Join } else { Purpose::Open };
        self.open(ctx, kind, purpose);
    }

    /// Opens the dialog for the picture of the row with this key.
    pub fn begin_mask(&mut self, ctx: &egui::Context, key: String) {
        let (kind, _) = MASKS[0];
        self.open(ctx, kind, Purpose::Mask(key));
    }

    fn open(&mut self, ctx: &egui::Context, kind: &str, purpose: Purpose) {
        let folder = self.folder.clone();
        let dialog = self.prepared(ctx, purpose, &folder);
        let mut dialog = dialog.borrow_mut();
        dialog.config_mut().default_file_filter = Some(kind.to_owned());
        dialog.pick_file();
    }

    /// Asks where to save, in this folder and by this name at first.
    pub fn save(&mut self, ctx: &egui::Context, folder: &Path, name: String) {
        let dialog = self.prepared(ctx, Purpose::Save, folder);
        let mut dialog = dialog.borrow_mut();
        dialog.config_mut().default_file_name = name;
        dialog.save_file();
    }

    /// Asks for a folder; at first it is this one.
    pub fn choose_folder(&mut self, ctx: &egui::Context, folder: &Path) {
        let dialog = self.prepared(ctx, Purpose::Folder, folder);
        dialog.borrow_mut().pick_directory();
    }

    /// The dialog for a purpose, which begins in this folder.
    fn prepared(
        &mut self,
        ctx: &egui::Context,
        purpose: Purpose,
        folder: &Path,
    ) -> Rc<RefCell<FileDialog>> {
        if discriminant(&self.purpose) != discriminant(&purpose) {
            self.dialog = None;
        }
        let made = || match &purpose {
            Purpose::Open | Purpose::Join => dialog("Open a file", KINDS),
            Purpose::Mask(_) => dialog("Open a picture of the texture", MASKS),
            Purpose::Save => dialog("Save the scene", &[])
                .add_save_extension(SCENES.0, SCENES.1)
                .default_save_extension(SCENES.0)
                .show_new_folder_button(true),
            Purpose::Folder => {
                let mut dialog = dialog("Where files go", &[]).show_new_folder_button(true);
                let labels = dialog.labels_mut();
                labels.open_button = "Choose".to_owned();
                labels.selected_directory = "This folder:".to_owned();
                dialog
            }
        };
        let dialog = (self.dialog).get_or_insert_with(|| Rc::new(made().into()));
        let dialog = Rc::clone(dialog);
        self.purpose = purpose;
        let mut shown = dialog.borrow_mut();
        let config = shown.config_mut();
        let folder = match std::path::absolute(folder) {
            Ok(folder) if folder.is_dir() => Ok(folder),
            _ => std::env::current_dir(),
        };
        config.initial_directory = folder.unwrap_or_default();
        let room = ctx.content_rect().size() - ROUND_IT;
        config.default_size = SIZE.min(room);
        config.min_size = vec2(400.0, 200.0).min(room);
        config.max_size = Some(room);
        config.show_left_panel = room.x >= HAS_ROOM;
        drop(shown);
        // A text that has the keyboard would keep it.
        ctx.memory_mut(egui::Memory::stop_text_input);
        dialog
    }

    /// Shows it for one frame, if it is open. Gives the folder for exports that was chosen in it.
    pub fn show(
        &mut self,
        ctx: &egui::Context,
        edited: &mut Settings,
        commands: &mut Vec<Command>,
    ) -> Option<PathBuf> {
        let path = self.chosen(ctx)?;
        match &self.purpose {
            Purpose::Open if is_mesh(&path) => self.mesh = Some(path),
            Purpose::Open | Purpose::Join => commands.push(Command::TakeFile(path)),
            Purpose::Save => commands.push(Command::SaveAs(path)),
            Purpose::Folder => return Some(whole(&path)),
            Purpose::Mask(key) => {
                if let Some(mask) = mask_of(edited, key) {
                    *mask = as_written(&path, &self.scene);
                    commands.push(Command::Apply);
                }
            }
        }
        None
    }

    /// Asks what to do with a chosen mesh, if there is one: add it to the scene, or open it alone.
    pub fn ask_about_mesh(
        &mut self,
        ctx: &egui::Context,
        picture: Rect,
        commands: &mut Vec<Command>,
    ) {
        let Some(mesh) = &self.mesh else {
            return;
        };
        let name = mesh
            .file_name()
            .unwrap_or(mesh.as_os_str())
            .to_string_lossy();
        let mut command = None;
        let mut gives_up = ctx.input(|input| input.key_pressed(egui::Key::Escape));
        let layer = centred_card(ctx, "mesh", picture, |ui| {
            ui.label(RichText::new(name).heading());
            ui.horizontal(|ui| {
                let add = ui
                    .button("Add to the scene")
                    .on_hover_text("It becomes one more object; what has grown stays");
                if add.marked("mesh.add").clicked() {
                    command = Some(Command::TakeFile(mesh.clone()));
                }
                let alone = ui
                    .button("Open alone")
                    .on_hover_text("A new scene with this mesh as its only object");
                if alone.marked("mesh.alone").clicked() {
                    command = Some(Command::OpenAlone(mesh.clone()));
                }
                gives_up |= ui.button("Cancel").marked("mesh.cancel").clicked();
            });
        });
        // Nothing else is pressed meanwhile.
        ctx.memory_mut(|memory| memory.set_modal_layer(layer));
        if gives_up || command.is_some() {
            self.mesh = None;
        }
        commands.extend(command);
    }

    /// Shows it for one frame, and gives what was chosen in it.
    fn chosen(&self, ctx: &egui::Context) -> Option<PathBuf> {
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

/// A dialog with the lab's labels, without the parts that only saving needs.
fn dialog(title: &str, kinds: Kinds) -> FileDialog {
    let mut dialog = FileDialog::new()
        .title(title)
        .anchor(Align2::CENTER_CENTER, Vec2::ZERO)
        .movable(false)
        .opening_mode(OpeningMode::AlwaysInitialDir)
        // A scene is called as the file that was chosen, also where that is a link.
        .canonicalize_paths(false)
        .show_new_folder_button(false)
        // Pinned folders would be forgotten at the end.
        .show_pinned_folders(false);
    for (name, endings) in kinds {
        dialog = dialog.add_file_filter(name, Filter::new(|path: &Path| ends_so(path, endings)));
    }
    dialog.config_mut().keybindings.new_folder.clear();
    let labels = dialog.labels_mut();
    labels.file_filter_all_files = "all files".to_owned();
    labels.open_button = "Open".to_owned();
    labels.save_button = "Save".to_owned();
    labels.overwrite = "Replace".to_owned();
    labels.overwrite_file_modal_text = "is there already. Replace it?".to_owned();
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

/// The picture that a row names.
fn mask_of<'a>(settings: &'a mut Settings, key: &str) -> Option<&'a mut String> {
    match key {
        "particles.start_mask" => return Some(&mut settings.particles.start_mask),
        "areas.map" => return Some(&mut settings.areas.map),
        "second_look.map" => return Some(&mut settings.second_look.map),
        _ => {}
    }
    let object = key.strip_prefix("object.")?.strip_suffix(".start.mask")?;
    let object = settings.objects.get_mut(object.parse::<usize>().ok()?)?;
    Some(&mut object.start.mask)
}

/// A path as a scene file in this folder has it.
fn as_written(path: &Path, folder: &Path) -> String {
    // An empty path is no folder to the system.
    let folder = std::path::absolute(Path::new(".").join(folder)).unwrap_or_default();
    let path = whole(path);
    let within = path.strip_prefix(&folder).unwrap_or(&path);
    within.to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use myxo::scene::settings::ObjectSettings;

    #[test]
    fn pictures_go_into_the_row_that_asked_for_them() {
        let mut settings = Settings {
            objects: vec![ObjectSettings::default(); 2],
            ..Settings::default()
        };
        for key in ["particles.start_mask", "object.1.start.mask", "areas.map"] {
            *mask_of(&mut settings, key).unwrap() = key.to_owned();
        }
        assert_eq!(settings.particles.start_mask, "particles.start_mask");
        assert_eq!(settings.areas.map, "areas.map");
        assert_eq!(settings.objects[0].start.mask, "");
        assert_eq!(settings.objects[1].start.mask, "object.1.start.mask");
        for gone in ["object.2.start.mask", "object.1.mesh"] {
            assert_eq!(mask_of(&mut settings, gone), None, "{gone}");
        }
    }

    #[test]
    fn paths_count_from_the_scene_where_they_lie_below_it() {
        let here = std::env::current_dir().unwrap();
        let folder = here.join("scenes");
        let inside = folder.join("masks").join("a.png");
        let below = Path::new("masks").join("a.png").display().to_string();
        assert_eq!(as_written(&inside, &folder), below);
        assert_eq!(as_written(&inside, Path::new("scenes")), below);
        let outside = here.join("scenes of others").join("a.png");
        let whole = outside.display().to_string();
        assert_eq!(as_written(&outside, &folder), whole);
        assert_eq!(as_written(&here.join("a.png"), Path::new("")), "a.png");
    }

    #[test]
    fn files_that_can_be_dropped_are_listed_first() {
        let is_shown = |name: &str| ends_so(Path::new(name), KINDS[0].1);
        for name in [
            "a.toml", "b.OBJ", "c.glb", "d.gltf", "e.ckpt", "f.STL", "g.ply",
        ] {
            assert!(is_shown(name), "{name}");
        }
        for name in ["letter.txt", "obj", ".toml", "film.mp4"] {
            assert!(!is_shown(name), "{name}");
        }
    }
}
