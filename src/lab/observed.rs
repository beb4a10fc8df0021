//! Observed of the interface that is reported to programs that drive the window, such as tests.

use myxo::scene::settings::ColorMap;
use serde::Serialize;

use crate::lab::facts::Facts;
use crate::lab::interface::Interface;
use crate::lab::layout::Card;

/// The state of the lab, for tests.
#[derive(Debug, PartialEq, Serialize)]
pub struct Observed<'a> {
    scene: String,
    step: u64,
    answers_within_steps: u64,
    loading: bool,
    playing: bool,
    /// Has a text the keyboard?
    typing: bool,
    pending: bool,
    unsaved: bool,
    panel: bool,
    light: bool,
    performing: bool,
    autopilot: bool,
    full_screen: bool,
    help: bool,
    gallery: bool,
    out: bool,
    /// Is a file being chosen?
    opening: bool,
    recording: bool,
    recorded: u64,
    making: Option<String>,
    preset: Option<&'a str>,
    /// The look that the picture previews.
    previewed: Option<&'a str>,
    /// Has the picture its steps, besides its colours?
    previewed_steps: bool,
    /// Does the scene run with a look that is previewed?
    runs_preview: bool,
    /// Presets that the user has kept.
    own: Vec<&'a str>,
    morphing: bool,
    show: &'a str,
    split: bool,
    network: bool,
    /// The step of the network that is there, in the picture or from the next frame on.
    network_step: Option<u64>,
    flying: bool,
    color_map: &'a str,
    /// The colours that the picture has, which follow a moment later.
    drawn_colors: Option<&'a str>,
    notice: Option<String>,
}

impl Interface {
    /// The state of the lab, for tests.
    pub fn state(&self, facts: &Facts, typing: bool) -> Observed<'_> {
        Observed {
            scene: facts.scene.clone(),
            step: facts.step,
            answers_within_steps: facts.answers_within_steps,
            loading: facts.loading.is_some(),
            playing: self.document.playing,
            typing,
            pending: self.document.is_pending(),
            unsaved: self.document.is_unsaved(),
            panel: self.layout.panel && !self.layout.alone,
            light: self.layout.light,
            performing: self.layout.alone,
            autopilot: self.autopilot.is_on(),
            full_screen: facts.full_screen,
            help: self.layout.shows(Card::Help),
            gallery: self.layout.shows_gallery(),
            out: self.layout.shows(Card::Exports),
            opening: self.opening.is_open(),
            recording: facts.exports.recording.is_some(),
            recorded: facts
                .exports
                .recording
                .map_or(0, |recording| recording.frames),
            making: facts
                .exports
                .making
                .as_ref()
                .map(|making| making.name.clone()),
            preset: self.document.preset.as_deref(),
            previewed: self.preview.look(),
            previewed_steps: self.preview.look().is_some()
                && facts.steps_of.as_deref() == self.preview.look(),
            runs_preview: facts.runs_preview,
            own: self
                .looks
                .own
                .all()
                .iter()
                .map(|own| own.name.as_str())
                .collect(),
            morphing: self.document.morph.is_some(),
            show: self.document.view.show.word(),
            split: self.layout.split,
            network: self.layout.network,
            network_step: facts.network.as_ref().map(|found| found.step),
            flying: self.navigation.is_flying(),
            color_map: self.document.view.color_map.word(),
            drawn_colors: facts.drawn_colors.map(ColorMap::word),
            notice: self.notices.text(),
        }
    }
}
