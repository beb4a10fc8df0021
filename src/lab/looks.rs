//! Looks in the window: presets taken at once or slowly, made up by chance, copied, kept and removed again.

use std::path::Path;

use myxo::plain_text::Shown as _;
use myxo::render::exposure::Exposure;
use myxo::scene::builtin::{self, PRESETS};
use myxo::scene::presets;
use myxo::scene::settings::Settings;
use myxo::scene::{Overrides, Scene};
use myxo::{Error, Result};

use super::interface::{Command, Interface};
use super::loading::Origin;
use super::out::{Shot, scaled};
use super::presets::{Morph, by_chance, neighbour, with_preset};
use super::window::Lab;
use crate::own_presets::{check_name, summary};

/// Of the small picture of a preset, pixels.
const PICTURE: [u32; 2] = [300, 200];

/// What looks change by: time that passes, or that of the film that is being made, in which a look takes as long as one who
/// watches it will see.
#[derive(Clone, Debug, Default)]
pub struct LookClock {
    now: f64,
    wall: Option<f64>,
    filmed: Option<f64>,
}

impl LookClock {
    /// Seconds since some beginning.
    fn now(&self) -> f64 {
        self.now
    }

    /// One frame more, at this time, with so many seconds of a film.
    pub fn tick(&mut self, wall: f64, filmed: Option<f64>) {
        let since =
            |before: Option<f64>, now: f64| before.map_or(0.0, |before| (now - before).max(0.0));
        self.now += match filmed {
            Some(filmed) => since(self.filmed.or(Some(0.0)), filmed),
            None => since(self.wall, wall),
        };
        self.wall = Some(wall);
        self.filmed = filmed;
    }
}

impl Interface {
    /// The text of a preset, the program's or the user's.
    pub(super) fn preset_text(&self, name: &str) -> Option<String> {
        match builtin::preset(name) {
            Some(preset) => Some(preset.text.to_owned()),
            None => self.own.find(name).map(|own| own.text.clone()),
        }
    }

    /// Names of all presets that can be taken: the program's first.
    pub(super) fn preset_names(&self) -> Vec<String> {
        let own = self.own.all().iter().filter(|own| own.problem.is_none());
        let names = PRESETS.iter().map(|preset| preset.name.to_owned());
        names.chain(own.map(|own| own.name.clone())).collect()
    }

    /// What is edited, with the colours that the picture has.
    fn look(&self) -> Settings {
        let mut look = self.edited.clone();
        look.picture.color_map = self.view.color_map;
        look
    }

    /// Finds the preset whose look the scene has, if there is one.
    pub(super) fn find_preset(&mut self) {
        let look = self.look();
        let is_taken = |name: &String| {
            let text = self.preset_text(name);
            let with = text.map(|text| with_preset(&look, name, &text));
            with.is_some_and(|with| with.is_ok_and(|with| with == look))
        };
        self.preset = self.preset_names().into_iter().find(is_taken);
    }

    /// The preset after or before the one that was taken last.
    pub(super) fn step_preset(
        &mut self,
        ctx: &egui::Context,
        forward: bool,
        commands: &mut Vec<Command>,
    ) {
        let names = self.preset_names();
        let name = neighbour(&names, self.preset.as_deref(), forward);
        let Some(text) = self.preset_text(name) else {
            return;
        };
        self.take_preset(ctx, name, &text, commands);
    }

    /// Takes over a preset's look, at once or over some seconds. What is wrong with it is said, and changes nothing.
    pub(super) fn take_preset(
        &mut self,
        ctx: &egui::Context,
        name: &str,
        text: &str,
        commands: &mut Vec<Command>,
    ) -> bool {
        match with_preset(&self.look(), name, text) {
            Ok(to) => {
                self.preset = Some(name.to_owned());
                self.change_look(to, commands);
                // It grows out of what is there; from the start it comes to what its small picture shows.
                let text = format!("{name}: {} (R begins anew)", summary(text));
                self.notice(ctx, text, false);
                true
            }
            Err(error) => {
                self.notice(ctx, error.to_string(), true);
                false
            }
        }
    }

    /// Is something different from what the preset says?
    pub(super) fn is_changed_from(&self, name: &str) -> bool {
        let look = self.look();
        let with = |text: String| with_preset(&look, name, &text).ok();
        let with = self.preset_text(name).and_then(with);
        self.morph.is_none() && with.is_some_and(|with| with != look)
    }

    /// A look that nobody has thought of.
    pub(super) fn by_chance(&mut self, ctx: &egui::Context, commands: &mut Vec<Command>) {
        let seed = ctx.input(|i| i.time).to_bits();
        self.preset = None;
        let to = by_chance(&self.look(), seed);
        self.change_look(to, commands);
    }

    fn change_look(&mut self, mut to: Settings, commands: &mut Vec<Command>) {
        self.view.color_map = to.picture.color_map;
        to.picture.color_map = self.edited.picture.color_map;
        if self.morph_seconds > 0.0 {
            let now = self.look_clock.now();
            self.morph = Some(Morph::new(&self.edited, to, now, self.morph_seconds));
        } else {
            self.morph = None;
            self.edited = to;
            commands.push(Command::Apply);
        }
    }

    /// Goes on with a look that changes slowly.
    pub(super) fn advance_morph(&mut self, ctx: &egui::Context, commands: &mut Vec<Command>) {
        let Some(morph) = &mut self.morph else {
            return;
        };
        if morph.advance(&mut self.edited, self.look_clock.now()) {
            self.morph = None;
        }
        ctx.request_repaint();
        commands.push(Command::Apply);
    }

    /// A look on its way is there at once.
    pub(super) fn end_morph(&mut self) {
        if let Some(morph) = self.morph.take() {
            morph.end(&mut self.edited);
        }
    }

    /// The look as it is edited, as the text of a preset.
    fn look_text(&self, scene: &str) -> String {
        presets::to_toml(&self.look(), &format!("A look of one's own, from {scene}."))
    }
}

impl Lab {
    /// Puts the look alone into the clipboard.
    pub(super) fn copy_look(&mut self, context: &egui::Context) {
        context.copy_text(self.interface.look_text(&self.name));
        self.interface
            .notice(context, "The look is in the clipboard", false);
    }

    /// Begins to load a scene that comes with the program, with the look that is here.
    pub(super) fn open_with_look(&mut self, name: &'static str) {
        self.interface.end_morph();
        let look = self.interface.look_text(&self.name);
        self.load(name.to_owned(), Origin::File, move || {
            let (name, settings, folder) = Scene::read(Path::new(name), &Overrides::default())?;
            let settings = with_preset(&settings, "of the window", &look)?;
            Ok(Scene::from_settings(name, settings, folder)?)
        });
    }

    /// Takes over a look that came as text; `name` is what it is called in the gallery, should it be kept.
    pub(super) fn take_look(&mut self, context: &egui::Context, name: &str, text: &str) {
        if self.stage.is_none() {
            let text = "Nothing grows yet that could take the look: wait for the scene";
            return self.interface.notice(context, text, true);
        }
        let mut commands = Vec::new();
        let is_read = self
            .interface
            .take_preset(context, name, text, &mut commands);
        // One that comes slowly asks for nothing yet. What is refused is said.
        if is_read && (commands.is_empty() || self.apply(context)) {
            // So it can be kept by one click.
            self.interface.gallery.name = check_name(name).unwrap_or_default().to_owned();
            let text = format!("The look of {name}: keep it in the gallery (G)");
            self.interface.notice(context, text, false);
        }
        self.host.request_redraw();
    }

    /// Keeps the look under a name, with a picture of what is seen now.
    pub(super) fn save_preset(&mut self, context: &egui::Context, name: &str) {
        match self.try_to_save_preset(name) {
            Ok(text) => self.interface.notice(context, text, false),
            Err(error) => self.interface.notice(context, error.to_string(), true),
        }
        self.interface.gallery.forget_pictures();
    }

    fn try_to_save_preset(&mut self, name: &str) -> Result<String> {
        let name = check_name(name).map_err(Error::Invalid)?.to_owned();
        let Some(stage) = &mut self.stage else {
            return Err(Error::Invalid(
                "nothing grows yet whose look could be kept: wait for the scene".to_owned(),
            ));
        };
        let window = self.host.size();
        let mut view = scaled(&self.interface.view, window, PICTURE);
        if let Exposure::Auto { adaptation, .. } = &mut view.exposure {
            *adaptation = 0.0;
        }
        let mut shot = Shot::new(&self.ctx, PICTURE, self.format)?;
        while !shot.advance(&mut self.frames, stage, &view)? {}
        let picture = shot.take(0, &view).into_picture();
        let text = self.interface.look_text(&self.name);
        let path = self.interface.own.save(&name, &text, &picture)?;
        self.interface.preset = Some(name);
        Ok(format!("Saved {}", path.shown()))
    }

    /// Removes a preset of one's own.
    pub(super) fn remove_preset(&mut self, context: &egui::Context, name: &str) {
        match self.interface.own.remove(name) {
            Ok(()) => {
                if self.interface.preset.as_deref() == Some(name) {
                    self.interface.preset = None;
                }
                let text = format!("{name} is removed");
                self.interface.notice(context, text, false);
            }
            Err(error) => self.interface.notice(context, error.to_string(), true),
        }
        self.interface.gallery.forget_pictures();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looks_take_their_time_and_in_films_that_of_the_film() {
        let mut clock = LookClock::default();
        for (wall, filmed, wanted) in [
            // However long the window has been there.
            (100.0, None, 0.0),
            (100.5, None, 0.5),
            // The first picture is not there yet, however long it takes.
            (101.0, Some(0.0), 0.5),
            (109.0, Some(0.25), 0.75),
            (109.0, Some(0.5), 1.0),
            // It is there, and time passes.
            (110.0, None, 2.0),
            (111.0, None, 3.0),
            // Another film begins.
            (112.0, Some(0.0), 3.0),
            (119.0, Some(0.125), 3.125),
            // And one whose first pictures were there at once.
            (120.0, None, 4.125),
            (121.0, Some(0.25), 4.375),
        ] {
            clock.tick(wall, filmed);
            assert_eq!(clock.now(), wanted, "{wall} {filmed:?}");
        }
    }
}
