//! Scenes that are loaded, and shown when they are there.

use myxo::mesh::atlas::AtlasError;
use myxo::{Error, Result};

use crate::lab::command::{Command, ToolRequest};
use crate::lab::edits::Coming;
use crate::lab::loading::{Loading, Opened, Origin, Ready};
use crate::lab::lost::is_loss;
use crate::lab::waiting::Waiting;
use crate::lab::window::areas::CarriedOver;
use crate::lab::window::{Lab, title};

/// What a restart with another map of the second look does to one that was painted.
const OTHER_LOOK: &str =
    "Another map of the second look has replaced what was painted: the gallery leads back to it";

impl Lab {
    /// Begins to load a scene; another load under way is cancelled for it.
    pub(super) fn load<T: Into<Opened>>(
        &mut self,
        name: String,
        origin: Origin,
        load: impl FnOnce() -> Result<T> + Send + 'static,
    ) {
        self.make_room(&name, origin);
        self.edits.carry = None;
        self.runner.back.stays();
        let asked = (origin == Origin::Shown).then(|| self.interface.document.edited.clone());
        self.interface.document.asked = asked;
        let device = (&self.runner.ctx, self.runner.format);
        let loading = Loading::begin((name, origin), device, self.atlases.clone(), load);
        self.jobs.load(loading);
        self.host.request_redraw();
    }

    /// Cancels the load under way. An object that was to come or to go does so afterwards, if the scene stays; a notice names
    /// what is lost.
    fn make_room(&mut self, name: &str, origin: Origin) {
        let is_same = origin == Origin::Shown;
        if !is_same {
            self.waiting.retain(|left| {
                let is_of_an_object = match left {
                    Waiting::Copy(..) | Waiting::Removal(_) => true,
                    Waiting::Command(Command::Tool(work), _) => {
                        matches!(work, ToolRequest::Duplicate(..) | ToolRequest::Remove(_))
                    }
                    _ => false,
                };
                !is_of_an_object
            });
        }
        let coming = self.edits.coming.take();
        let loading = self.jobs.loading.as_ref();
        let Some(loading) = loading.filter(|loading| !loading.is_cancelled()) else {
            return;
        };
        let lost = match coming {
            Some(Coming {
                again: Some(again), ..
            }) if is_same => {
                self.waiting.insert(0, again);
                return;
            }
            Some(coming) => {
                if let Some(ticket) = coming.ticket {
                    self.interface.tools.answer(ticket, None);
                }
                coming.what
            }
            None if is_same && loading.origin != Origin::Shown && loading.name != name => {
                loading.name.clone()
            }
            None => return,
        };
        let text = format!("{lost} was on its way, and was given up");
        self.notify(text, false);
    }

    /// Shows the scene that was loaded. If it has failed, the running scene continues.
    pub(super) fn has_loaded(&mut self, loading: Loading, result: Result<Ready>) -> Result<()> {
        let shown = match result {
            // It had ended before it saw that.
            Ok(_) if loading.is_cancelled() => Err(AtlasError::Cancelled.into()),
            result => result.and_then(|ready| self.show(ready, loading.origin)),
        };
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
                self.notify(text, false);
            }
            Err(error) if is_loss(&error) => {
                // It is cancelled like any load under way then. An object is not requested again, because it may have caused
                // the loss.
                self.jobs.loading = Some(loading);
                if let Some(coming) = &mut self.edits.coming {
                    coming.again = None;
                }
                return Err(error);
            }
            Err(error) => self.notify(error.to_string(), true),
        }
        Ok(())
    }

    fn show(&mut self, ready: Ready, origin: Origin) -> Result<()> {
        self.jobs.exports.leave_stage();
        let Ready { mut stage, file } = ready;
        let is_new_scene = origin != Origin::Shown;
        if is_new_scene {
            self.interface.opening.leave_scene();
        } else {
            // The scene may have got another name meanwhile.
            stage.scene.name.clone_from(&self.interface.document.name);
        }
        let left = if is_new_scene {
            self.keep_left()
        } else {
            (self.loses_areas_to(&stage)).then(|| self.keep_as_left())
        };
        let loses_look = !is_new_scene && self.loses_look_to(&stage);
        let has_no_file = matches!(left, Some(Err(_)));
        let carried_over = match is_new_scene {
            true => CarriedOver::default(),
            false => self.carry_over(&mut stage)?,
        };
        let mut is_error = false;
        let mut texts: Vec<String> = left
            .map(|left| match left {
                Ok((_, lacks)) if is_new_scene => {
                    format!("{} as you left it is in the gallery{lacks}", self.interface.document.name)
                }
                Ok((_, lacks)) => format!(
                    "Another map of areas has taken the place of those that were painted: {} with these is in the gallery{lacks}",
                    self.interface.document.name
                ),
                Err(error) => {
                    is_error = true;
                    error.to_string()
                }
            })
            .into_iter()
            .collect();
        // Remarks on a mesh are shown once.
        let known = self.runner.remarks();
        let new = stage.remarks.iter().filter(|text| !known.contains(text));
        texts.extend(new.cloned());
        texts.extend(stage.resumed.take());
        let back = self.runner.back.take_coming();
        if !carried_over.state {
            // What no file has is kept in memory, however little has grown.
            match self.keep_grown(back.is_some() || has_no_file || loses_look) {
                Ok(()) if has_no_file => texts.push(format!(
                    "{} as you left it is in memory only: the gallery leads back to it",
                    self.interface.document.name
                )),
                Ok(()) if loses_look => texts.push(OTHER_LOOK.to_owned()),
                Ok(()) => {}
                Err(error) if is_loss(&error) => return Err(error),
                Err(error) => {
                    is_error = true;
                    texts.push(format!("There is no way back to what had grown: {error}"));
                }
            }
        }
        if !texts.is_empty() {
            self.notify(texts.join("\n"), is_error);
        }
        self.jobs.food.leave();
        let scene = &stage.scene;
        self.interface.document.name.clone_from(&scene.name);
        self.interface.document.folder.clone_from(&scene.folder);
        self.interface
            .opening
            .count_from(&self.interface.document.folder);
        self.host.set_title(&title(&scene.name));
        if is_new_scene {
            if let Some(file) = &file {
                self.interface.gallery.recent.note(&file.path);
            }
            self.interface.document.file = file;
            self.edits.leave_scene();
            // Frozen times are not of the new scene.
            self.clocks.unfreeze_times();
            self.interface.open(scene);
            if origin == Origin::NoFile {
                self.interface.document.saved(None);
            }
            self.forget_states();
            self.shows_another(back.as_ref());
        } else {
            self.interface.restarted(scene);
        }
        self.runner.take_stage(stage, &mut self.clocks);
        self.forget_network();
        if !carried_over.strokes {
            self.forget_strokes();
        }
        self.moved = self.host.now();
        if self.interface.document.edited != self.interface.document.running {
            self.apply();
        }
        Ok(())
    }
}
