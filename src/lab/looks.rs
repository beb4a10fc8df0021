//! Looks: presets taken at once or slowly, and made up by chance.

use myxo::scene::builtin::{self, PRESETS};
use myxo::scene::settings::Settings;

use crate::lab::autopilot::another;
use crate::lab::command::Command;
use crate::lab::desk::Desk;
use crate::lab::document::Document;
use crate::lab::presets::{Morph, by_chance, neighbour};
use crate::lab::throws::Throws;
use crate::own_presets::{OwnPresets, summary, with_preset};

/// The clock by which looks change: wall time, or the time of the film that is being made, so that a change lasts as long in
/// the film as in the window.
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

    /// One frame more, at this time, with this many seconds of a film.
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

/// Why there is no way back or forward through looks made up by chance.
pub const NO_EARLIER: &str = "No earlier look was made up by chance: D makes one up";
pub const NO_LATER: &str = "No later look was made up by chance: D makes one up";

/// Looks: the available ones, and the one that the present look changes into.
#[derive(Clone, Debug)]
pub struct Looks {
    /// Looks that the user has kept.
    pub own: OwnPresets,
    /// Seconds that the change to another look takes.
    pub morph_seconds: f64,
    /// Looks made up by chance.
    pub throws: Throws,
    clock: LookClock,
}

/// The change to another look takes so many seconds, unless the user has chosen another time.
pub const MORPH_SECONDS: f64 = 2.0;
/// The longest change, seconds.
pub const LONGEST_MORPH: f64 = 120.0;

impl Default for Looks {
    fn default() -> Self {
        Self {
            own: OwnPresets::default(),
            morph_seconds: MORPH_SECONDS,
            throws: Throws::default(),
            clock: LookClock::default(),
        }
    }
}

impl Looks {
    /// A frame begins, at this time, with this many seconds of a film.
    pub fn tick(&mut self, wall: f64, filmed: Option<f64>) {
        self.clock.tick(wall, filmed);
    }

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

    /// Finds the preset whose look the scene has, if there is one.
    pub(super) fn find_preset(&self, document: &mut Document) {
        let look = document.look();
        let is_taken = |name: &String| {
            let text = self.preset_text(name);
            let with = text.map(|text| with_preset(&look, name, &text));
            with.is_some_and(|with| with.is_ok_and(|with| with == look))
        };
        document.preset = self.preset_names().into_iter().find(is_taken);
    }

    /// The preset after or before the one that was taken last.
    pub(super) fn step_preset(&mut self, ctx: &egui::Context, forward: bool, desk: &mut Desk<'_>) {
        let names = self.preset_names();
        let name = neighbour(&names, desk.document.preset.as_deref(), forward);
        let Some(text) = self.preset_text(name) else {
            return;
        };
        self.take_preset(ctx, name, &text, desk);
    }

    /// Takes over a preset's look, at once or over some seconds. An error in it is shown in a notice and changes nothing.
    pub(super) fn take_preset(
        &mut self,
        ctx: &egui::Context,
        name: &str,
        text: &str,
        desk: &mut Desk<'_>,
    ) -> bool {
        match with_preset(&desk.document.look(), name, text) {
            Ok(to) => {
                desk.document.note_morph();
                desk.document.preset = Some(name.to_owned());
                self.change_look(to, desk);
                // It grows out of the present state; only from the start does it become like its small picture.
                let text = format!("{name}: {} (R restarts)", summary(text));
                desk.notices.say(ctx, text, false);
                true
            }
            Err(error) => {
                desk.notices.say(ctx, error.to_string(), true);
                false
            }
        }
    }

    /// Takes another look slowly, by a number: one that needs no other food, which would have to be measured.
    pub(super) fn drift(
        &mut self,
        ctx: &egui::Context,
        (number, seconds): (u64, f64),
        desk: &mut Desk<'_>,
    ) {
        let look = desk.document.coming_look();
        let names: Vec<(String, String)> = (self.preset_names().into_iter())
            .filter_map(|name| {
                let text = self.preset_text(&name)?;
                let with = with_preset(&look, &name, &text).ok()?;
                (with.feeding == look.feeding).then_some((name, text))
            })
            .collect();
        let present = desk.document.preset.as_deref();
        let place = names
            .iter()
            .position(|(name, _)| Some(name.as_str()) == present);
        if let Some(next) = another(names.len(), place, number) {
            let (name, text) = &names[next];
            let before = std::mem::replace(&mut self.morph_seconds, seconds);
            self.take_preset(ctx, name, text, desk);
            self.morph_seconds = before;
        }
    }

    /// Is something different from what the preset says?
    pub(super) fn is_changed_from(&self, document: &Document, name: &str) -> bool {
        let look = document.look();
        let with = |text: String| with_preset(&look, name, &text).ok();
        let with = self.preset_text(name).and_then(with);
        document.morph.is_none() && with.is_some_and(|with| with != look)
    }

    /// A look made up by chance.
    pub(super) fn by_chance(&mut self, ctx: &egui::Context, desk: &mut Desk<'_>) {
        let seed = ctx.input(|i| i.time).to_bits();
        let to = by_chance(&desk.document.look(), seed);
        self.throws.keep(&to);
        self.take_thrown(ctx, to, desk);
    }

    /// The look that was made up before or after the one taken last, if there is one.
    pub(super) fn step_throw(&mut self, ctx: &egui::Context, forward: bool, desk: &mut Desk<'_>) {
        match self.throws.go(forward, &desk.document.coming_look()) {
            Some(to) => self.take_thrown(ctx, to, desk),
            None => {
                let text = if forward { NO_LATER } else { NO_EARLIER };
                desk.notices.say(ctx, text, false);
            }
        }
    }

    fn take_thrown(&mut self, ctx: &egui::Context, to: Settings, desk: &mut Desk<'_>) {
        desk.document.note_morph();
        desk.document.preset = None;
        self.change_look(to, desk);
        if let Some((place, count)) = self.throws.at() {
            let text = format!("Look {place} of {count} made up by chance");
            desk.notices.say(ctx, text, false);
        }
    }

    fn change_look(&mut self, mut to: Settings, desk: &mut Desk<'_>) {
        let document = &mut *desk.document;
        document.view.color_map = to.picture.color_map;
        to.picture.color_map = document.edited.picture.color_map;
        if self.morph_seconds > 0.0 {
            let (from, now) = (&document.edited, self.clock.now());
            document.morph = Some(Morph::new(from, to, now, self.morph_seconds));
        } else {
            document.morph = None;
            document.edited = to;
            desk.commands.push(Command::Apply);
        }
    }

    /// Advances a look that changes slowly.
    pub(super) fn advance(&self, ctx: &egui::Context, desk: &mut Desk<'_>) {
        let Document { morph, edited, .. } = &mut *desk.document;
        let Some(changing) = morph else {
            return;
        };
        if changing.advance(edited, self.clock.now()) {
            *morph = None;
        }
        ctx.request_repaint();
        desk.commands.push(Command::Apply);
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
