//! Looks that the window copies, opens scenes with, keeps and removes.

use std::path::Path;

use image::RgbaImage;
use myxo::plain_text::Shown as _;
use myxo::render::exposure::Exposure;
use myxo::scene::{Overrides, Scene};
use myxo::{Error, Result};

use crate::lab::export::{Care, Shot, scaled};
use crate::lab::loading::Origin;
use crate::lab::window::Lab;
use crate::own_presets::{check_name, with_preset};

/// Size of the small picture of a preset or of a scene that is left, pixels.
const PICTURE: [u32; 2] = [300, 200];

impl Lab {
    /// Puts the look alone into the clipboard.
    pub(crate) fn copy_look(&mut self) {
        self.host.context().copy_text(
            self.interface
                .document
                .look_text(&self.interface.document.name),
        );
        self.notify("The look is in the clipboard", false);
    }

    /// Begins to load a scene that comes with the program, with the look that is here.
    pub(crate) fn open_with_look(&mut self, name: &'static str) {
        self.interface.document.end_morph();
        let look = self
            .interface
            .document
            .look_text(&self.interface.document.name);
        self.load(name.to_owned(), Origin::File, move || {
            let (name, settings, folder) = Scene::read(Path::new(name), &Overrides::default())?;
            let settings = with_preset(&settings, "of the window", &look)?;
            Ok(Scene::from_settings(name, settings, folder)?)
        });
    }

    /// Takes over a look that came as text; `name` is what it is called in the gallery, should it be kept.
    pub(crate) fn take_look(&mut self, name: &str, text: &str) {
        if self.runner.stage.is_none() {
            let text = "Nothing grows yet that could take the look: wait for the scene";
            return self.notify(text, true);
        }
        let mut commands = Vec::new();
        let facts = &self.clocks.facts;
        let context = self.host.context();
        let is_read = (self.interface).take_look(context, (name, text), facts, &mut commands);
        // A slow change has no commands yet. A refusal is shown in a notice.
        if is_read && (commands.is_empty() || self.apply()) {
            // Then it can be kept by one click.
            self.interface.gallery.name = check_name(name).unwrap_or_default().to_owned();
            let text = format!("The look of {name}: keep it in the gallery (G)");
            self.notify(text, false);
        }
        self.host.request_redraw();
    }

    /// Keeps the look under a name, with a picture of what is seen now.
    pub(crate) fn save_preset(&mut self, name: &str) {
        match self.try_to_save_preset(name) {
            Ok(text) => self.notify(text, false),
            Err(error) => self.notify(error.to_string(), true),
        }
        self.interface.gallery.forget_pictures();
    }

    fn try_to_save_preset(&mut self, name: &str) -> Result<String> {
        let name = check_name(name).map_err(Error::Invalid)?.to_owned();
        let Some(picture) = self.small_picture()? else {
            return Err(Error::Invalid(
                "nothing grows yet whose look could be kept: wait for the scene".to_owned(),
            ));
        };
        let text = self
            .interface
            .document
            .look_text(&self.interface.document.name);
        let path = self.interface.looks.own.save(&name, &text, &picture)?;
        self.interface.document.preset = Some(name);
        Ok(format!("Saved {}", path.shown()))
    }

    /// A small copy of the present picture, if there is a scene and no step is half done.
    pub(super) fn small_picture(&mut self) -> Result<Option<RgbaImage>> {
        if !self.runner.can_draw() {
            return Ok(None);
        }
        let Some(stage) = &mut self.runner.stage else {
            return Ok(None);
        };
        let window = self.host.size();
        let mut view = scaled(&self.interface.document.view, window, PICTURE);
        if let Exposure::Auto { adaptation, .. } = &mut view.exposure {
            *adaptation = 0.0;
        }
        let mut shot = Shot::new(&self.runner.ctx, PICTURE, self.runner.format, Care::Once)?;
        while !shot.advance(&mut self.runner.frames, stage, &view)? {}
        Ok(Some(shot.take(0, &view).into_picture()))
    }

    /// Removes a preset of one's own.
    pub(crate) fn remove_preset(&mut self, name: &str) {
        match self.interface.looks.own.remove(name) {
            Ok(()) => {
                if self.interface.document.preset.as_deref() == Some(name) {
                    self.interface.document.preset = None;
                }
                let text = format!("{name} is removed");
                self.notify(text, false);
            }
            Err(error) => self.notify(error.to_string(), true),
        }
        self.interface.gallery.forget_pictures();
    }
}
