//! Obeys the commands of the interface: settings, scenes, screenshots, the clipboard.

use std::path::{Path, PathBuf};

use glam::Vec2;
use myxo::Result;
use myxo::plain_text::Shown as _;
use myxo::scene::presets::is_preset;
use myxo::scene::{Overrides, Scene, Settings};
use myxo::sim::checkpoint::Checkpoint;

use crate::console;
use crate::lab::command::Command;
use crate::lab::interface::Interface;
use crate::lab::kept_scenes::KeptScenes;
use crate::lab::loading::{Opened, Origin};
use crate::lab::names::unnumbered;
use crate::lab::saving::{SceneFile, chosen, kept_name, save_scene, whole, write_scene};
use crate::lab::stage::Stage;
use crate::lab::window::scene_text::{WITHOUT_LOOK, has_painted_look};
use crate::lab::window::{Lab, title};

impl Lab {
    /// Does what the interface asks for.
    pub(super) fn obey(&mut self, command: Command, picture_size: [u32; 2]) -> Result<()> {
        // Commands are about the scene as it is without a preview.
        self.end_preview()?;
        if command.writes_the_look() {
            self.end_morph();
        }
        match command {
            Command::Apply => {
                if !self.waits_for_kernels() {
                    self.apply();
                }
            }
            Command::Restart => self.restart(),
            Command::GoBack => self.go_back(),
            Command::KeepState => self.keep_state_now()?,
            Command::ToState(number) => self.go_to_state(number)?,
            Command::ReturnToState(number) => self.return_to_state(number)?,
            Command::Step => self.runner.single_steps += u32::from(self.runner.stage.is_some()),
            Command::ClearTimes => self.clocks.clear_times(&mut self.runner.frames),
            Command::FreezeTimes(true) => {
                if let Some(stage) = &self.runner.stage {
                    let (ctx, frames) = (&self.runner.ctx, &self.runner.frames);
                    self.clocks.freeze_times(ctx, frames, stage);
                }
            }
            Command::FreezeTimes(false) => self.clocks.unfreeze_times(),
            Command::SaveTimes => self.save_times(),
            Command::Screenshot => self.picture(picture_size),
            Command::Export(out) => self.obey_export(out, picture_size),
            Command::Refocus(pixel) => {
                let size = Vec2::new(picture_size[0] as f32, picture_size[1] as f32);
                let view = &self.interface.document.view;
                let hit = self
                    .runner
                    .stage
                    .as_ref()
                    .and_then(|s| s.pick(view, pixel, size));
                if let Some(hit) = hit {
                    let Interface {
                        navigation,
                        document,
                        ..
                    } = &mut self.interface;
                    navigation.fly_to(hit.position, &document.view);
                }
            }
            Command::Copy => self.copy(),
            Command::CopyLook => self.copy_look(),
            Command::SavePreset(name) => self.save_preset(&name),
            Command::RemovePreset(name) => self.remove_preset(&name),
            Command::Paste(text) if is_preset(&text) => self.take_look("clipboard", &text),
            Command::Paste(text) => self.paste(&text),
            Command::Open(name) => self.open_file(name.into()),
            Command::OpenWithLook(name) => self.open_with_look(name),
            Command::OpenKept(left) => {
                KeptScenes::opened(&left);
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
                if let Some(loading) = &self.jobs.loading {
                    loading.cancel();
                }
            }
            Command::Save => self.save(),
            Command::AskWhereToSave => self.ask_where_to_save(),
            Command::AskForFolder => {
                let folder = self.export_folder();
                (self.interface.opening).choose_folder(self.host.context(), &folder);
            }
            Command::SaveAs(file) => self.save_as(file),
            Command::FullScreen => {
                let fills = !self.host.is_full_screen();
                self.host.fill_screen(fills);
            }
            Command::Tool(work) => self.obey_tool(work, picture_size)?,
            Command::Quit => {
                self.ask_to_close();
            }
        }
        Ok(())
    }

    /// A look that changes slowly begins once its kernels are there: compiling them takes longer than a frame. In a film it
    /// begins with a picture that does not depend on that.
    fn waits_for_kernels(&mut self) -> bool {
        if self.jobs.exports.is_busy() {
            return false;
        }
        let document = &mut self.interface.document;
        let live = document.live_settings();
        let (Some(morph), Some(stage)) = (&mut document.morph, &self.runner.stage) else {
            return false;
        };
        while let Some(settings) = morph.needs_kernels(&live) {
            if !self.jobs.ahead.are_made(&stage.simulation, settings) {
                return true;
            }
            morph.has_kernels();
        }
        false
    }

    /// Applies the settings that can change while the simulation runs. If this fails, a notice says so and it returns false.
    pub(super) fn apply(&mut self) -> bool {
        let wanted = self.interface.document.live_settings();
        let is_taken = match self.runner.apply(&wanted) {
            Ok(None) => return false,
            Ok(Some(live)) => {
                self.interface.document.running = live;
                true
            }
            Err(error) => {
                self.notify(error.to_string(), true);
                false
            }
        };
        if let Some(stage) = &self.runner.stage {
            // Names are taken over, whatever is refused.
            let runs = stage.simulation.settings().objects.iter();
            for (running, runs) in self.interface.document.running.objects.iter_mut().zip(runs) {
                running.name.clone_from(&runs.name);
            }
            self.jobs.food.want(&stage.simulation, &wanted);
        }
        is_taken
    }

    /// From step 0, with the settings as they are edited.
    pub(super) fn restart(&mut self) {
        self.interface.document.end_morph();
        self.restart_as(self.interface.document.edited.clone());
    }

    /// Restarts from step 0, with other settings.
    pub(super) fn restart_as(&mut self, settings: Settings) {
        let (name, folder) = self.interface.document.name_and_folder();
        let meshes = self.meshes_for(&settings);
        self.load(name.clone(), Origin::Shown, move || {
            Ok(match meshes {
                Some(meshes) => Scene::from_meshes(name, settings, meshes, folder)?,
                None => Scene::from_settings(name, settings, folder)?,
            })
        });
    }

    /// Was something painted that stays, besides what the scene's maps say?
    pub(super) fn has_painted(&self) -> bool {
        let has_strokes = self.interface.document.undo.strokes() > 0;
        let has_painted = |stage: &Stage| {
            let (state, setup) = (stage.simulation.state(), stage.simulation.setup());
            let areas = state.bias.is_some() && (setup.bias.is_empty() || has_strokes);
            let looks = state.looks.is_some() && (setup.looks.is_empty() || has_strokes);
            areas || looks
        };
        self.runner.stage.as_ref().is_some_and(has_painted)
    }

    fn copy(&mut self) {
        let (Some(scene), Some(stage)) = (self.scene_text(), &self.runner.stage) else {
            return;
        };
        let as_it_runs = scene.lacking();
        self.host.context().copy_text(scene.text);
        let has_all = stage.simulation.areas();
        let has_all = has_all.is_ok_and(|bias| bias == stage.simulation.setup().bias);
        let without = if has_all {
            ""
        } else {
            ", without the areas that were painted: files of scenes have them (Ctrl S)"
        };
        let look = match has_painted_look(&stage.simulation) {
            true => WITHOUT_LOOK,
            false => "",
        };
        let text = format!("The scene is in the clipboard{without}{look}{as_it_runs}");
        self.notify(text, false);
    }

    /// Saves the scene into its file, or if it has none, into a numbered one.
    fn save(&mut self) {
        let saved = match self
            .interface
            .document
            .file
            .clone()
            .filter(|file| file.may_be_replaced)
        {
            Some(file) => self.save_by(|text| write_scene(&file.path, text)),
            None => {
                let folder = self.export_folder();
                let name = unnumbered(&self.interface.document.name).to_owned();
                self.save_by(|text| save_scene(&folder, &name, text))
            }
        };
        if let Some(file) = saved {
            self.is_saved_in(&file);
        }
    }

    fn ask_where_to_save(&mut self) {
        if self.runner.scene().is_none() {
            return;
        }
        let file = self
            .interface
            .document
            .file
            .as_ref()
            .map(|file| file.path.as_path());
        let name = file.and_then(Path::file_name);
        let name = name.map_or_else(
            || format!("{}.toml", unnumbered(&self.interface.document.name)),
            |name| name.to_string_lossy().into_owned(),
        );
        let folder = file.and_then(Path::parent).map(Path::to_owned);
        let folder = folder.unwrap_or_else(|| self.export_folder());
        (self.interface.opening).save(self.host.context(), &folder, name);
    }

    fn save_as(&mut self, file: PathBuf) {
        let file = match chosen(file) {
            Ok(file) => file,
            Err(error) => return self.notify(error.to_string(), true),
        };
        if let Some(file) = self.save_by(|text| write_scene(&file, text)) {
            let name = file.file_stem().unwrap_or(file.as_os_str());
            self.interface.document.name = name.to_string_lossy().into_owned();
            self.is_saved_in(&file);
            self.clocks.facts.scene = self.interface.document.name.clone();
            self.host.set_title(&title(&self.interface.document.name));
        }
    }

    /// From now on the scene is saved there.
    fn is_saved_in(&mut self, file: &Path) {
        let file = SceneFile::saved(file);
        self.interface.gallery.recent.note(&file.path);
        self.interface.document.file = Some(file);
        self.runner
            .back
            .saved(self.interface.document.file.as_ref());
    }

    /// Writes the scene, and says so or why not. Gives where it did.
    fn save_by(
        &mut self,
        write: impl FnOnce(&mut dyn FnMut(&Path) -> Result<String>) -> Result<PathBuf>,
    ) -> Option<PathBuf> {
        self.runner.scene()?;
        let (mut remark, mut has_all) = (String::new(), false);
        let saved = write(&mut |file| {
            let scene = self.scene_text_at(file)?;
            (remark, has_all) = (scene.remark(), scene.has_all());
            Ok(scene.text)
        });
        match saved {
            Ok(path) => {
                if has_all {
                    self.interface
                        .document
                        .saved(Some(self.interface.document.state_to_save()));
                }
                let text = format!("Saved {}{remark}", whole(&path).shown());
                self.notify(text, false);
                Some(path)
            }
            Err(error) => {
                self.notify(error.to_string(), true);
                None
            }
        }
    }

    /// Begins to load a scene by name, or from a file: a scene, a model or a checkpoint.
    pub fn open_file(&mut self, path: PathBuf) {
        let name = kept_name(&path).unwrap_or_else(|| {
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

    /// A look on its way is there at once, so that what is written has all of it.
    pub(super) fn end_morph(&mut self) {
        if self.interface.document.morph.is_some() {
            self.interface.document.end_morph();
            self.interface.document.note();
            self.apply();
        }
    }

    /// Keeps the scene that is about to be left, if something of it has no file. Gives its file, and what it lacks.
    pub(super) fn keep_left(&mut self) -> Option<Result<(PathBuf, String)>> {
        if !self.interface.document.is_unsaved() || self.runner.scene().is_none() {
            return None;
        }
        self.end_morph();
        Some(self.keep_as_left())
    }

    /// Keeps the scene as it was left, whether a file has it or not.
    pub(super) fn keep_as_left(&mut self) -> Result<(PathBuf, String)> {
        let mut lacks = String::new();
        let mut left = std::mem::take(&mut self.interface.gallery.kept);
        let kept = left.keep(&self.interface.document.name, |file| {
            let scene = self.scene_text_at(file)?;
            lacks = scene.lacking();
            Ok(scene.text)
        });
        self.interface.gallery.kept = left;
        let file = kept?;
        let pictured = self.small_picture().and_then(|picture| match picture {
            Some(picture) => KeptScenes::keep_picture(&file, &picture),
            None => Ok(()),
        });
        if let Err(error) = pictured {
            log::warn!("{} has no picture: {error}", file.shown());
        }
        Ok((file, lacks))
    }

    /// Reports on the terminal at the end that the scene was kept.
    pub(super) fn report_kept(&mut self) {
        let text = match self.keep_left() {
            None => return,
            Some(Ok((file, lacks))) => format!(
                "{} as you left it is kept: `myxo lab {}` opens it, and so does the gallery{lacks}",
                self.interface.document.name,
                file.shown(),
            ),
            Some(Err(error)) => error.to_string(),
        };
        console::message(&text);
    }
}
