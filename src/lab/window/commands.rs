//! What the interface asks the window for, done: settings, scenes, screenshots, the clipboard.

use std::path::{Path, PathBuf};

use glam::Vec2;
use myxo::mesh::atlas::AtlasError;
use myxo::plain_text::Shown as _;
use myxo::scene::presets::is_preset;
use myxo::scene::{Overrides, Scene, Settings};
use myxo::sim::checkpoint::Checkpoint;
use myxo::{Error, Result};

use crate::console;
use crate::lab::command::Command;
use crate::lab::command::Work;
use crate::lab::edits::Coming;
use crate::lab::interface::Interface;
use crate::lab::left::LeftScenes;
use crate::lab::loading::{Loaded, Loading, Opened, Origin};
use crate::lab::lost::is_loss;
use crate::lab::names::unnumbered;
use crate::lab::saving::left_name;
use crate::lab::saving::{SceneFile, chosen, save_scene, whole, write_scene};
use crate::lab::stage::Stage;
use crate::lab::under_way::Left;
use crate::lab::window::areas::CarriedOver;
use crate::lab::window::{Lab, title};

impl Lab {
    /// Does what the interface asks for.
    pub(super) fn obey(
        &mut self,
        context: &egui::Context,
        command: Command,
        picture_size: [u32; 2],
    ) -> Result<()> {
        match command {
            Command::Apply => {
                self.apply(context);
            }
            Command::Restart => self.restart(),
            Command::GoBack => self.go_back(),
            Command::Step => self.single_steps += u32::from(self.stage.is_some()),
            Command::ClearTimes => self.clocks.clear_times(&mut self.frames),
            Command::SaveTimes(times) => self.save_times(context, &times),
            Command::Screenshot => self.picture(context, picture_size),
            Command::TakeOut(out) => self.take_out(context, out, picture_size),
            Command::Refocus(pixel) => {
                let size = Vec2::new(picture_size[0] as f32, picture_size[1] as f32);
                let view = &self.interface.document.view;
                let hit = self.stage.as_ref().and_then(|s| s.pick(view, pixel, size));
                if let Some(hit) = hit {
                    let Interface {
                        navigation,
                        document,
                        ..
                    } = &mut self.interface;
                    navigation.fly_to(hit.position, &document.view);
                }
            }
            Command::Copy => self.copy(context),
            Command::CopyLook => self.copy_look(context),
            Command::SavePreset(name) => self.save_preset(context, &name),
            Command::RemovePreset(name) => self.remove_preset(context, &name),
            Command::Paste(text) if is_preset(&text) => self.take_look(context, "clipboard", &text),
            Command::Paste(text) => self.paste(context, &text),
            Command::Open(name) => self.open_file(name.into()),
            Command::OpenWithLook(name) => self.open_with_look(name),
            Command::OpenLeft(left) => {
                LeftScenes::opened(&left);
                self.open_as(left.name, left.file);
            }
            Command::TakeFile(path) => self.drop_file(path),
            Command::OpenAlone(path) => {
                if let Some(folder) = path.parent() {
                    self.interface.opening.begin_in(folder);
                }
                self.open_file(path);
            }
            Command::CancelLoading => {
                if let Some(loading) = &self.loading {
                    loading.cancel();
                }
            }
            Command::Save => self.save(context),
            Command::AskWhereToSave => self.ask_where_to_save(context),
            Command::AskForFolder => {
                let folder = self.folder_out();
                self.interface.opening.choose_folder(context, &folder);
            }
            Command::SaveAs(file) => self.save_as(context, file),
            Command::FullScreen => {
                let fills = !self.host.is_full_screen();
                self.host.fill_screen(fills);
            }
            Command::Hand(work) => self.obey_hand(context, work, picture_size)?,
            Command::Quit => {
                self.ask_to_close();
            }
        }
        Ok(())
    }

    /// Lets the running simulation take over what can change while it runs. Where it cannot, that is said, and false.
    pub(super) fn apply(&mut self, context: &egui::Context) -> bool {
        let Some(stage) = &mut self.stage else {
            return false;
        };
        let wanted = self.interface.document.live_settings();
        let mut live = wanted.clone();
        // To measure how far texels are from food takes longer than a picture.
        let runs = stage.simulation.settings();
        live.foods.clone_from(&runs.foods);
        live.feeding = runs.feeding.clone();
        // Names change nothing, and so they come first: what names objects need not restart.
        let names: Vec<String> = { live.objects.iter() }
            .map(|object| object.name.clone())
            .collect();
        stage.simulation.rename_objects(&names);
        stage.scene.settings.rename_objects(&names);
        let is_taken = match stage.simulation.apply(&live) {
            Ok(()) => {
                self.interface.document.running = live;
                stage.forget_picture();
                true
            }
            Err(error) => {
                self.interface.notices.say(context, error.to_string(), true);
                false
            }
        };
        self.feeder.want(&stage.simulation, &wanted);
        is_taken
    }

    /// From step 0, with the settings as they are edited.
    pub(super) fn restart(&mut self) {
        self.interface.document.end_morph();
        self.restart_as(self.interface.document.edited.clone());
    }

    /// The same with other settings.
    pub(super) fn restart_as(&mut self, settings: Settings) {
        let (name, folder) = (self.name.clone(), self.folder.clone());
        let meshes = self.meshes_for(&settings);
        self.load(name.clone(), Origin::Shown, move || {
            Ok(match meshes {
                Some(meshes) => Scene::from_meshes(name, settings, meshes, folder)?,
                None => Scene::from_settings(name, settings, folder)?,
            })
        });
    }

    /// Was something painted that stays, besides what the scene's map says?
    pub(super) fn has_painted(&self) -> bool {
        let has_areas = |stage: &Stage| stage.simulation.state().bias.is_some();
        let has_map = |stage: &Stage| !stage.simulation.setup().bias.is_empty();
        let has_strokes = self.interface.document.undo.strokes() > 0;
        (self.stage.as_ref()).is_some_and(|s| has_areas(s) && (!has_map(s) || has_strokes))
    }

    fn copy(&mut self, context: &egui::Context) {
        let (Some(scene), Some(stage)) = (self.scene_text(), &self.stage) else {
            return;
        };
        let as_it_runs = scene.lacking();
        context.copy_text(scene.text);
        let has_all = stage.simulation.areas();
        let has_all = has_all.is_ok_and(|bias| bias == stage.simulation.setup().bias);
        let without = if has_all {
            ""
        } else {
            ", without the areas that were painted: files of scenes have them (Ctrl S)"
        };
        let text = format!("The scene is in the clipboard{without}{as_it_runs}");
        self.interface.notices.say(context, text, false);
    }

    /// Into the file that the scene was saved in before, or else into a numbered one.
    fn save(&mut self, context: &egui::Context) {
        let saved = match self.file.clone().filter(|file| file.may_be_replaced) {
            Some(file) => self.save_by(context, |text| write_scene(&file.path, text)),
            None => {
                let folder = self.folder_out();
                let name = unnumbered(&self.name).to_owned();
                self.save_by(context, |text| save_scene(&folder, &name, text))
            }
        };
        if let Some(file) = saved {
            self.is_saved_in(&file);
        }
    }

    fn ask_where_to_save(&mut self, context: &egui::Context) {
        if self.scene().is_none() {
            return;
        }
        let file = self.file.as_ref().map(|file| file.path.as_path());
        let name = file.and_then(Path::file_name);
        let name = name.map_or_else(
            || format!("{}.toml", unnumbered(&self.name)),
            |name| name.to_string_lossy().into_owned(),
        );
        let folder = file.and_then(Path::parent).map(Path::to_owned);
        let folder = folder.unwrap_or_else(|| self.folder_out());
        self.interface.opening.save(context, &folder, name);
    }

    fn save_as(&mut self, context: &egui::Context, file: PathBuf) {
        let file = match chosen(file) {
            Ok(file) => file,
            Err(error) => return self.interface.notices.say(context, error.to_string(), true),
        };
        if let Some(file) = self.save_by(context, |text| write_scene(&file, text)) {
            let name = file.file_stem().unwrap_or(file.as_os_str());
            self.name = name.to_string_lossy().into_owned();
            self.is_saved_in(&file);
            self.clocks.facts.scene = self.name.clone();
            self.host.set_title(&title(&self.name));
        }
    }

    /// From now on the scene is saved there.
    fn is_saved_in(&mut self, file: &Path) {
        let file = SceneFile::saved(file);
        self.interface.gallery.recent.note(&file.path);
        self.file = Some(file);
        self.back.saved(self.file.as_ref());
    }

    /// Writes the scene, and says so or why not. Gives where it did.
    fn save_by(
        &mut self,
        context: &egui::Context,
        write: impl FnOnce(&mut dyn FnMut(&Path) -> Result<String>) -> Result<PathBuf>,
    ) -> Option<PathBuf> {
        self.scene()?;
        let (mut told, mut has_all) = (String::new(), false);
        let saved = write(&mut |file| {
            let scene = self.scene_text_at(file)?;
            (told, has_all) = (scene.told(), scene.has_all());
            Ok(scene.text)
        });
        match saved {
            Ok(path) => {
                if has_all {
                    self.interface
                        .document
                        .saved(Some(self.interface.document.state_to_save()));
                }
                let text = format!("Saved {}{told}", whole(&path).shown());
                self.interface.notices.say(context, text, false);
                Some(path)
            }
            Err(error) => {
                self.interface.notices.say(context, error.to_string(), true);
                None
            }
        }
    }

    /// Begins to load a scene by name, or from a file: a scene, a model or a checkpoint.
    pub fn open_file(&mut self, path: PathBuf) {
        let name = left_name(&path).unwrap_or_else(|| {
            let name = path.file_stem().unwrap_or(path.as_os_str());
            name.to_string_lossy().into_owned()
        });
        self.open_as(name, path);
    }

    fn open_as(&mut self, name: String, path: PathBuf) {
        self.load(name.clone(), Origin::File, move || {
            if Checkpoint::is_one(&path) {
                return Opened::resumed(path, &Overrides::default());
            }
            let mut scene = Scene::load(&path, &Overrides::default())?;
            scene.name = name;
            let file = SceneFile::opened(&path);
            Ok(Opened {
                file,
                ..scene.into()
            })
        });
    }

    /// Keeps the scene that is about to be left, if something of it has no file. Gives its file, and what it lacks.
    fn keep_left(&mut self) -> Option<Result<(PathBuf, String)>> {
        if !self.interface.document.is_unsaved() || self.scene().is_none() {
            return None;
        }
        Some(self.keep_as_left())
    }

    /// The same, whatever has a file.
    pub(super) fn keep_as_left(&mut self) -> Result<(PathBuf, String)> {
        let mut lacks = String::new();
        let mut left = std::mem::take(&mut self.interface.gallery.left);
        let kept = left.keep(&self.name, |file| {
            let scene = self.scene_text_at(file)?;
            lacks = scene.lacking();
            Ok(scene.text)
        });
        self.interface.gallery.left = left;
        let file = kept?;
        let pictured = self.small_picture().and_then(|picture| match picture {
            Some(picture) => LeftScenes::keep_picture(&file, &picture),
            None => Ok(()),
        });
        if let Err(error) = pictured {
            log::warn!("{} has no picture: {error}", file.shown());
        }
        Ok((file, lacks))
    }

    /// At the end, on the terminal.
    pub(super) fn tell_left(&mut self) {
        let text = match self.keep_left() {
            None => return,
            Some(Ok((file, lacks))) => format!(
                "{} as you left it is kept: `myxo lab {}` opens it, and so does the gallery{lacks}",
                self.name,
                file.shown(),
            ),
            Some(Err(error)) => error.to_string(),
        };
        console::message(&text);
    }

    /// Begins to load a scene; one that is on its way is given up for it.
    pub(super) fn load<T: Into<Opened>>(
        &mut self,
        name: String,
        origin: Origin,
        load: impl FnOnce() -> Result<T> + Send + 'static,
    ) {
        self.make_room(&name, origin);
        self.edits.carry = None;
        self.back.stays();
        let asked = (origin == Origin::Shown).then(|| self.interface.document.edited.clone());
        self.interface.document.asked = asked;
        let (info, atlases) = (self.ctx.info(), self.atlases.clone());
        self.loading = Some(Loading::begin(name, origin, info, atlases, load));
        self.host.request_redraw();
    }

    /// What is on its way is given up. An object that was to come or to go does so afterwards, if it is the same scene; what
    /// is lost is said.
    fn make_room(&mut self, name: &str, origin: Origin) {
        let is_same = origin == Origin::Shown;
        if !is_same {
            self.left.retain(|left| {
                let is_of_an_object = match left {
                    Left::Copy(..) | Left::Removal(_) => true,
                    Left::Command(Command::Hand(work), _) => {
                        matches!(work, Work::Duplicate(..) | Work::Remove(_))
                    }
                    _ => false,
                };
                !is_of_an_object
            });
        }
        let coming = self.edits.coming.take();
        let loading = self.loading.as_ref();
        let Some(loading) = loading.filter(|loading| !loading.told().is_cancelled) else {
            return;
        };
        let lost = match coming {
            Some(Coming {
                again: Some(again), ..
            }) if is_same => {
                self.left.insert(0, again);
                return;
            }
            Some(coming) => {
                if let Some(ticket) = coming.ticket {
                    self.interface.hands.answer(ticket, None);
                }
                coming.what
            }
            None if is_same && loading.origin != Origin::Shown && loading.name != name => {
                loading.name.clone()
            }
            None => return,
        };
        let context = self.host.context().clone();
        let text = format!("{lost} was on its way, and was given up");
        self.interface.notices.say(&context, text, false);
    }

    /// Shows the scene that was loaded, if it is ready. If something was wrong with it, what runs goes on.
    pub(super) fn take_loaded(&mut self) -> Result<()> {
        let Some(result) = self.loading.as_mut().and_then(Loading::take) else {
            return Ok(());
        };
        let Some(loading) = self.loading.take() else {
            return Ok(());
        };
        let shown = result.and_then(|loaded| self.show(loaded, loading.origin));
        let context = self.host.context().clone();
        if shown.is_err() {
            self.interface.not_shown();
        }
        if !matches!(&shown, Err(error) if is_loss(error)) {
            self.has_come(shown.is_ok());
        }
        match shown {
            Ok(()) => {}
            Err(Error::Atlas(AtlasError::Cancelled)) => {
                let text = format!("{} was not loaded", loading.name);
                self.interface.notices.say(&context, text, false);
            }
            Err(error) if is_loss(&error) => {
                // It is given up like any that is on its way then. An object is not asked for again: it may be what the device
                // was lost by.
                self.loading = Some(loading);
                if let Some(coming) = &mut self.edits.coming {
                    coming.again = None;
                }
                return Err(error);
            }
            Err(error) => self
                .interface
                .notices
                .say(&context, error.to_string(), true),
        }
        Ok(())
    }

    fn show(&mut self, loaded: Loaded, origin: Origin) -> Result<()> {
        self.out.leave_stage();
        let file = loaded.file.clone();
        // What runs makes room only when the next one is there.
        let mut stage = Stage::new(&self.ctx, loaded, self.format)?;
        let is_new_scene = origin != Origin::Shown;
        if is_new_scene {
            self.interface.opening.leave_scene();
        } else {
            // It may have got another name meanwhile.
            stage.scene.name.clone_from(&self.name);
        }
        let left = if is_new_scene {
            self.keep_left()
        } else {
            (self.loses_areas_to(&stage)).then(|| self.keep_as_left())
        };
        let carried_over = match is_new_scene {
            true => CarriedOver::default(),
            false => self.carry_over(&mut stage)?,
        };
        let mut is_error = false;
        let mut texts: Vec<String> = left
            .map(|left| match left {
                Ok((_, lacks)) if is_new_scene => {
                    format!("{} as you left it is in the gallery{lacks}", self.name)
                }
                Ok((_, lacks)) => format!(
                    "Another map of areas has taken the place of those that were painted: {} with these is in the gallery{lacks}",
                    self.name
                ),
                Err(error) => {
                    is_error = true;
                    error.to_string()
                }
            })
            .into_iter()
            .collect();
        // What was told of these meshes is not told again.
        let told = self.stage.as_ref().map(|stage| &stage.remarks);
        let told = told.or_else(|| Some(&self.lost.as_ref()?.remarks));
        let told = told.map_or(&[][..], Vec::as_slice);
        let new = stage.remarks.iter().filter(|text| !told.contains(text));
        texts.extend(new.cloned());
        texts.extend(stage.resumed.take());
        let back = self.back.take_coming();
        if !carried_over.state {
            match self.keep_grown(back.is_some()) {
                Ok(()) => {}
                Err(error) if is_loss(&error) => return Err(error),
                Err(error) => {
                    is_error = true;
                    texts.push(format!("There is no way back to what had grown: {error}"));
                }
            }
        }
        if !texts.is_empty() {
            let context = self.host.context().clone();
            self.interface
                .notices
                .say(&context, texts.join("\n"), is_error);
        }
        self.feeder.leave();
        stage.take_canvas(self.stage.take());
        let scene = &stage.scene;
        self.name.clone_from(&scene.name);
        self.folder.clone_from(&scene.folder);
        self.interface.opening.count_from(&self.folder);
        self.host.set_title(&title(&scene.name));
        if is_new_scene {
            if let Some(file) = &file {
                self.interface.gallery.recent.note(&file.path);
            }
            self.file = file;
            self.edits.leave_scene();
            self.interface.open(scene);
            if origin == Origin::NoFile {
                self.interface.document.saved(None);
            }
            self.shows_another(back.as_ref());
        } else {
            self.interface.restarted(scene);
        }
        self.clocks.restart(&mut self.frames, &stage);
        self.stage = Some(stage);
        if !carried_over.strokes {
            self.forget_strokes();
        }
        self.runs_again();
        if let Some(checks) = &mut self.checks {
            checks.restart();
        }
        self.pacer.restart();
        self.moved = self.host.now();
        if self.interface.document.edited != self.interface.document.running {
            self.apply(&self.host.context().clone());
        }
        Ok(())
    }
}
