//! What is round the picture: the panel with every parameter, the line of facts, the help; and what they ask for.
//!
//! The interface changes its own settings and view at once and asks the window for the rest by [`Command`]s, so it
//! runs without a window and without a device, as its tests do.

use std::path::PathBuf;

use egui::{Rect, Sense, Ui};
use glam::{Vec2, Vec3};
use myxo::render::Camera;
use myxo::render::exposure::Exposure;
use myxo::render::view::{self, View};
use myxo::scene::Scene;
use myxo::scene::parameters::{OBJECT_PARAMETERS, PARAMETERS};
use myxo::scene::settings::{Settings, Show};

pub use super::facts::{Facts, KernelTime, Waiting};
use super::gallery::Gallery;
use super::hands::{Hands, Tool, Work, are_built_alike, place_among};
use super::left::{LeftScene, LeftScenes};
use super::looks::LookClock;
use super::navigation::{Moved, Navigation};
use super::notices::Notices;
use super::opening::Opening;
use super::out::{Out, OutPanel};
use super::overlays::{show_ending, show_loading};
use super::places::Marked as _;
use super::presets::Morph;
use super::recent::Recent;
use super::renewal::{take_back, with_changes_since};
use super::rows::{take_refused, take_wanted};
use super::theme;
use super::undo::{self, Undo};
use crate::own_presets::OwnPresets;

/// Something that the window must do.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Settings changed that the running simulation can take over.
    Apply,
    /// Begin again at step 0, with the settings as they are edited.
    Restart,
    /// Go on from what had grown before a reset, or in another scene.
    GoBack,
    /// Take one step.
    Step,
    /// Write the picture to a file.
    Screenshot,
    /// Put the surface point that this pixel of the picture shows in its middle.
    Refocus(Vec2),
    /// Put the scene with its settings and camera into the clipboard.
    Copy,
    /// Put the look alone into the clipboard.
    CopyLook,
    /// Keep the look as a preset of this name.
    SavePreset(String),
    /// Remove a preset of one's own.
    RemovePreset(String),
    /// Close the window.
    Quit,
    /// Take over a scene or a look from the clipboard.
    Paste(String),
    /// Write the scene as it is edited and looked at to a file.
    Save,
    /// Opens the dialog that asks where.
    AskWhereToSave,
    /// Opens the dialog that asks for the folder of what is taken out.
    AskForFolder,
    /// Saves the scene in this file, in the place of what is there.
    SaveAs(PathBuf),
    /// Show another scene that comes with the program.
    Open(&'static str),
    /// The same, with the look that is here.
    OpenWithLook(&'static str),
    /// Show a scene as it was left.
    OpenLeft(LeftScene),
    /// Do with a file what is done with one that is dropped.
    TakeFile(PathBuf),
    /// Give up the scene that is on its way.
    CancelLoading,
    /// The window over the whole screen, or no longer.
    FullScreen,
    /// A hand is on the scene.
    Hand(Work),
    /// Take something out.
    TakeOut(Out),
}

/// The state of everything round the picture.
#[derive(Clone, Debug)]
pub struct Interface {
    /// The scene as it was loaded; resets return to it.
    pub loaded: Settings,
    /// What the simulation runs with.
    pub running: Settings,
    /// What the panel shows.
    pub edited: Settings,
    /// What the picture shows.
    pub view: View,
    /// Does the simulation run by itself?
    pub playing: bool,
    /// What a fit brings into the picture: the scene's centre, and every vertex.
    pub(super) outline: (Vec3, Vec<Vec3>),
    /// The camera of the last fit and its picture's size; while nobody moves it, it keeps fitting.
    pub(super) fitted: Option<(Camera, Vec2)>,
    /// Where the scene's own camera stands.
    pub(super) home: Camera,
    /// Hand and flights.
    pub navigation: Navigation,
    /// The atlas beside the picture.
    pub(super) split: bool,
    /// Brushes, picked objects, the probe.
    pub hands: Hands,
    /// Is the panel shown?
    pub panel: bool,
    /// A light interface; else a dark one.
    pub light: bool,
    /// The picture alone, without anything round it.
    pub(super) performing: bool,
    pub(super) help: bool,
    /// Does anything attract, repel or forbid?
    pub(super) has_areas: bool,
    pub(super) gallery: Gallery,
    pub(super) opening: Opening,
    /// Which of help, gallery and what is taken out lay over the picture in the last frame.
    on_top: [bool; 3],
    pub(super) undo: Undo,
    /// Objects that undo has brought back are on their way.
    renews: bool,
    /// What was edited when this scene was sent for once more, while it is on its way.
    pub(super) asked: Option<Settings>,
    /// The preset that was taken last, or whose look the scene had when it was loaded.
    pub(super) preset: Option<String>,
    /// Those that the user has kept.
    pub own: OwnPresets,
    /// Scenes that were left with changes.
    pub left: LeftScenes,
    /// Seconds that the change to another preset takes.
    pub(super) morph_seconds: f64,
    pub(super) morph: Option<Morph>,
    pub(super) look_clock: LookClock,
    pub(super) recent: Recent,
    pub(super) filter: String,
    /// The hand is in the field for it.
    pub(super) is_searching: bool,
    /// Is the key held?
    shift: bool,
    pub(super) notices: Notices,
    /// What is taken out, and how.
    pub out: OutPanel,
}

/// What one frame of the interface came to.
#[derive(Clone, Debug)]
pub struct Shown {
    /// What the window must do, in order.
    pub commands: Vec<Command>,
    /// Where the picture goes, in points.
    pub picture: Rect,
    /// Where the atlas goes, if it is shown beside the picture.
    pub beside: Option<Rect>,
    /// A hand is on the scene.
    pub touched: bool,
}

const PANEL_WIDTH: f32 = 336.0;

impl Interface {
    /// The interface for a scene that has just been loaded.
    pub fn new(scene: &Scene) -> Self {
        let settings = &scene.settings;
        let mut interface = Self {
            loaded: settings.clone(),
            running: settings.clone(),
            edited: settings.clone(),
            view: View::of(scene, Vec2::ONE),
            playing: true,
            outline: (Vec3::ZERO, Vec::new()),
            fitted: None,
            home: Camera::default(),
            navigation: Navigation::default(),
            split: false,
            hands: Hands::new(),
            panel: true,
            light: false,
            performing: false,
            help: false,
            has_areas: false,
            gallery: Gallery::default(),
            opening: Opening::default(),
            on_top: [false; 3],
            undo: Undo::new(settings, &View::of(scene, Vec2::ONE)),
            renews: false,
            asked: None,
            preset: None,
            own: OwnPresets::default(),
            left: LeftScenes::default(),
            morph_seconds: 0.0,
            morph: None,
            look_clock: LookClock::default(),
            recent: Recent::default(),
            filter: String::new(),
            is_searching: false,
            shift: false,
            notices: Notices::default(),
            out: OutPanel::default(),
        };
        interface.open(scene);
        interface
    }

    /// Another scene has been loaded: its settings and its view.
    pub fn open(&mut self, scene: &Scene) {
        self.loaded = scene.settings.clone();
        self.see_as(scene);
        self.hands.leave_scene();
        self.morph = None;
        self.asked = None;
        self.restarted(scene);
        self.hands.newcomer.clear();
        self.find_preset();
        self.undo = Undo::new(&self.edited, &self.view);
    }

    /// The scene that runs shall have other settings, which it can take over, and another view. That can be undone.
    pub fn go_on_as(&mut self, scene: &Scene) {
        self.morph = None;
        self.edited = scene.settings.clone();
        self.see_as(scene);
        self.find_preset();
    }

    /// It cannot: everything is as it was before, but for what is said of it.
    pub fn put_back(&mut self, before: Self) {
        let notices = std::mem::take(&mut self.notices);
        *self = Self { notices, ..before };
    }

    /// The view that a scene's file asks for.
    fn see_as(&mut self, scene: &Scene) {
        self.view = View::of(scene, Vec2::ONE);
        if matches!(self.view.exposure, Exposure::Auto { .. }) {
            self.view.exposure = Exposure::following();
        }
        if self.view.show.why_not(&scene.settings).is_some() {
            self.view.show = Show::default();
        }
        self.home = self.view.camera;
        // Only the first frame knows the size of the picture.
        let is_free = scene.settings.camera.distance <= 0.0;
        self.fitted = is_free.then_some((self.view.camera, Vec2::ZERO));
    }

    /// The scene runs from step 0, with its settings. What was changed since it was sent for is edited.
    pub fn restarted(&mut self, scene: &Scene) {
        let picked = self.hands.selected.and_then(|i| self.edited.objects.get(i));
        let picked = picked.cloned();
        self.running = scene.settings.clone();
        let asked = self.asked.take();
        let since = asked.map(|asked| with_changes_since(&asked, &self.edited, &self.running));
        self.edited = since.unwrap_or_else(|| self.running.clone());
        self.renews = false;
        // Those that come or go leave the others in other places.
        if let Some(picked) = picked {
            self.hands.selected = place_among(&self.edited.objects, &picked);
        }
        self.hands.restarted(scene, self.edited.foods.len());
        self.outline = (scene.center, view::points(scene).collect());
    }

    /// What was on its way is not shown. Objects that undo was to bring back did not come, so those that run are edited.
    pub fn not_shown(&mut self) {
        self.asked = None;
        let there = self.running.objects.len();
        self.hands.selected = self.hands.selected.filter(|object| *object < there);
        if !std::mem::take(&mut self.renews) {
            return;
        }
        take_back(&mut self.edited, &self.running);
        self.hands.selected = None;
        self.undo.note(&self.edited, &self.view);
    }

    /// Are objects that come, go or grow on their way?
    pub fn is_renewed(&self) -> bool {
        self.renews
    }

    /// The objects that are edited are on their way, at once.
    pub fn begin_renewal(&mut self) {
        self.renews = true;
    }

    /// A frame of the interface. egui shows it once more where something new did not know its size, and what came in comes to the
    /// first of both passes only: what each came to counts.
    pub fn run(
        &mut self,
        ctx: &egui::Context,
        input: egui::RawInput,
        facts: &Facts,
    ) -> (Shown, egui::FullOutput) {
        let mut all: Option<Shown> = None;
        let output = ctx.run_ui(input, |ui| {
            let mut shown = self.show(ui, facts);
            if let Some(first) = all.take() {
                shown.commands.splice(0..0, first.commands);
                shown.touched |= first.touched;
            }
            all = Some(shown);
        });
        (all.expect("it is shown once or more"), output)
    }

    /// Shows everything for one pass.
    fn show(&mut self, ui: &mut Ui, facts: &Facts) -> Shown {
        let mut commands = Vec::new();
        self.has_areas = facts.has_areas;
        (self.look_clock).tick(ui.input(|i| i.time), facts.out.filmed);
        // A press that closes a list does nothing else.
        self.hands.is_covered = self.opening.is_open() || egui::Popup::is_any_open(ui.ctx());
        // A dialog has the keyboard to itself.
        if !self.opening.is_open() {
            self.handle_keys(ui.ctx(), facts, &mut commands);
        }
        self.handle_clipboard(ui.ctx(), &mut commands);
        self.advance_morph(ui.ctx(), &mut commands);
        self.note_view(ui.ctx());
        if !self.performing {
            self.status_line(ui, facts);
        }
        if self.panel && !self.performing {
            egui::Panel::left("panel")
                .exact_size(PANEL_WIDTH)
                .resizable(false)
                .show_separator_line(false)
                .frame(theme::panel_frame(ui))
                .show(ui, |ui| self.panel(ui, facts, &mut commands));
        }
        if let Some(text) = take_refused(ui.ctx()) {
            self.notice(ui.ctx(), text, false);
        }
        if let Some(key) = take_wanted(ui.ctx()) {
            self.begin_to_open_mask(ui.ctx(), key);
        }
        self.keep_one_on_top();
        let (picture, beside) = self.parts(ui, ui.available_rect_before_wrap());
        self.keep_fitting(Vec2::new(picture.width(), picture.height()));
        let response = ui
            .allocate_rect(picture, Sense::click_and_drag())
            .marked("picture");
        let used = self.use_hands(ui, &response, facts, &mut commands);
        // The first click has picked what it met, and handles may now lie under the second; it still asks for a new centre.
        let refocuses = response.double_clicked() && self.hands.tool == Tool::Look;
        let moved = if self.opening.is_open() || used && !refocuses {
            Moved::default()
        } else {
            (self.navigation).apply(ui, &response, self.hands.drags, &mut self.view)
        };
        let beside_touched = beside.is_some_and(|rect| self.move_beside(ui, rect));
        if let Some(pixel) = moved.refocus {
            commands.push(Command::Refocus(pixel));
        }
        self.show_hands(ui, picture, facts);
        let mut bar = None;
        if !self.performing {
            bar = self.show_tools(ui.ctx(), picture, &mut commands);
        }
        if self.help {
            self.show_help(ui.ctx(), picture);
        }
        self.show_gallery(ui.ctx(), picture, facts, &mut commands);
        self.show_out(ui.ctx(), picture, bar, facts, &mut commands);
        if let Some(loading) = &facts.loading {
            show_loading(ui.ctx(), picture, loading, &mut commands);
        }
        if facts.out.ends {
            show_ending(ui.ctx(), picture, &facts.out);
        }
        self.show_notices(ui, picture);
        self.hide_resting_pointer(ui.ctx());
        self.show_opening(ui.ctx(), &mut commands);
        let is_busy = ui.ctx().input(|i| i.pointer.any_down()) || ui.ctx().text_edit_focused();
        if !is_busy && !self.hands.has_food_in_hand() {
            self.note_changes();
        }
        Shown {
            commands,
            picture,
            beside,
            touched: moved.touched || beside_touched || response.dragged(),
        }
    }

    /// The edited settings, but for what would restart the running simulation.
    pub fn live_settings(&self) -> Settings {
        let mut live = self.running.clone();
        for parameter in PARAMETERS {
            if !parameter.restarts(&self.running, &self.edited) {
                parameter.copy(&self.edited, &mut live);
            }
        }
        for (i, live) in live.objects.iter_mut().enumerate() {
            let running = &self.running.objects[i];
            // While others are on their way they stand in other places.
            let edited = &self.edited.objects;
            let place = if edited.len() == self.running.objects.len() {
                Some(i)
            } else {
                place_among(edited, running)
            };
            let Some(edited) = place.map(|place| &edited[place]) else {
                continue;
            };
            for parameter in OBJECT_PARAMETERS {
                if !parameter.restarts(running, edited) {
                    parameter.copy(edited, live);
                }
            }
        }
        live.foods.clone_from(&self.edited.foods);
        live
    }

    /// Does something differ from the file that it was saved in last, or from what was loaded if it was not?
    pub fn is_unsaved(&self) -> bool {
        self.undo.is_unsaved(&self.edited, &self.view)
    }

    /// Everything as it is now, for [`Interface::saved`] once a file has it.
    pub fn state_to_save(&self) -> undo::Entry {
        self.undo.to_save(&self.edited, &self.view)
    }

    /// A file has everything as it was then; with none, no file has anything of it.
    pub fn saved(&mut self, then: Option<undo::Entry>) {
        self.undo.saved(then);
    }

    /// Are there edits that wait for a restart?
    pub fn is_pending(&self) -> bool {
        PARAMETERS
            .iter()
            .any(|p| p.restarts(&self.running, &self.edited))
            || self.running.objects != self.edited.objects
    }

    /// Help, gallery and what is taken out have one place: the one that is opened closes the others.
    fn keep_one_on_top(&mut self) {
        let all = [&mut self.help, &mut self.gallery.open, &mut self.out.open];
        let is_new = all
            .iter()
            .zip(self.on_top)
            .any(|(open, was)| **open && !was);
        for (open, was) in all.into_iter().zip(self.on_top) {
            *open &= !(is_new && was);
        }
        self.on_top = [self.help, self.gallery.open, self.out.open];
    }

    /// A light interface, or a dark one.
    pub(super) fn set_light(&mut self, ctx: &egui::Context, light: bool) {
        self.light = light;
        theme::apply(ctx, light);
    }

    /// Undo may lead back to before what has changed. What changes after a stroke that waits for its end comes after it.
    pub(super) fn note_changes(&mut self) {
        if self.morph.is_none() && self.hands.pending_ends == 0 {
            self.undo.note(&self.edited, &self.view);
        }
    }

    /// Takes back the last change of settings, look or painted areas.
    pub(super) fn undo(&mut self, commands: &mut Vec<Command>) {
        self.undo_in_turn(false, commands);
    }

    /// The same, unless something was painted last that stays: that is said.
    pub(super) fn undo_by_hand(&mut self, ctx: &egui::Context, commands: &mut Vec<Command>) {
        // What has changed since comes first.
        self.note_changes();
        if self.undo.take_lasting() {
            let before = match self.undo.can_undo() {
                true => "; once more undoes what was before",
                false => "",
            };
            let text = format!("Painted trail and particles are not taken back{before}");
            return self.notice(ctx, text, false);
        }
        self.undo(commands);
    }

    /// Brings back what was taken back.
    pub(super) fn redo(&mut self, commands: &mut Vec<Command>) {
        self.undo_in_turn(true, commands);
    }

    fn undo_in_turn(&mut self, again: bool, commands: &mut Vec<Command>) {
        // The stroke that is being painted is the next to be undone; so is one whose end waits, if it changes anything.
        if self.hands.pending_ends > 0 && !self.hands.paints_areas {
            commands.push(Command::Hand(Work::Undo { again }));
        } else if !self.hands.paints_areas {
            self.undo_now(again, commands);
        }
    }

    /// Undo, or redo with `again`, after all strokes that came before it.
    pub(super) fn undo_now(&mut self, again: bool, commands: &mut Vec<Command>) {
        self.morph = None;
        let waited = self.is_pending();
        let fits = self.is_fitted();
        let strokes = self.undo.strokes();
        let lead = if again { Undo::redo } else { Undo::undo };
        if lead(&mut self.undo, &mut self.edited, &mut self.view) {
            self.hands.let_food_go();
            self.fit_again(fits);
            self.find_preset();
            commands.push(self.take_over(waited));
            commands.extend(self.take_strokes(strokes));
        }
    }

    /// What brings painted areas to where undo and redo are now.
    fn take_strokes(&self, before: u64) -> Option<Command> {
        let now = self.undo.strokes();
        (now != before).then_some(Command::Hand(Work::ToStroke(now)))
    }

    /// What lets the simulation take over settings that came back. Objects that came, went or grew did so at once, and go
    /// back at once; what waited for a restart goes on waiting.
    fn take_over(&mut self, waited: bool) -> Command {
        let are_others = !are_built_alike(&self.running.objects, &self.edited.objects);
        // While such objects are on their way, those that run are not what was seen last.
        if !self.renews && (waited || !are_others) {
            return Command::Apply;
        }
        if !std::mem::replace(&mut self.renews, true) {
            let picked = (self.hands.selected).and_then(|object| self.running.objects.get(object));
            let picked = picked.and_then(|object| place_among(&self.edited.objects, object));
            self.hands.selected = picked;
        }
        Command::Hand(Work::Renew)
    }

    fn handle_clipboard(&mut self, ctx: &egui::Context, commands: &mut Vec<Command>) {
        let is_typing = ctx.text_edit_focused() || self.opening.is_open();
        ctx.input(|input| {
            for event in &input.events {
                match event {
                    // In a slow frame the keys may all be up again at its end.
                    egui::Event::ModifiersChanged(modifiers) => self.shift = modifiers.shift,
                    egui::Event::Copy | egui::Event::Paste(_) if is_typing => {}
                    egui::Event::Copy if self.shift => commands.push(Command::CopyLook),
                    egui::Event::Copy => commands.push(Command::Copy),
                    egui::Event::Paste(text) => commands.push(Command::Paste(text.clone())),
                    _ => {}
                }
            }
        });
    }
}

#[cfg(test)]
mod tests;
