//! What is round the picture: the panel with every parameter, the line of facts, the help; and what they ask for.
//!
//! The interface changes its own settings and view at once and asks the window for the rest by [`Command`]s, so it
//! runs without a window and without a device, as its tests do.

use egui::{Rect, Sense, Ui};
use glam::Vec2;
use myxo::scene::Scene;

use super::command::Command;
use super::command::Work;
use super::desk::Desk;
use super::document::Document;
use super::facts::Facts;
use super::gallery::Gallery;
use super::hands::{Hands, Tool};
use super::left::LeftScenes;
use super::looks::Looks;
use super::navigation::{Moved, Navigation};
use super::notices::Notices;
use super::opening::Opening;
use super::out::OutPanel;
use super::overlays::{show_ending, show_loading};
use super::places::Marked as _;
use super::recent::Recent;
use super::renewal::place_among;
use super::rows::{take_refused, take_wanted};
use super::theme;

/// The state of everything round the picture.
#[derive(Clone, Debug)]
pub struct Interface {
    /// What is being worked on.
    pub document: Document,
    /// Does the simulation run by itself?
    pub playing: bool,
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
    /// Those that can be taken, and how they change.
    pub looks: Looks,
    /// Scenes that were left with changes.
    pub left: LeftScenes,
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
        let mut interface = Self {
            document: Document::new(scene),
            playing: true,
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
            looks: Looks::default(),
            left: LeftScenes::default(),
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
        self.document.open(scene);
        self.see_as(scene);
        self.hands.leave_scene();
        self.looks.stop();
        self.restarted(scene);
        self.hands.newcomer.clear();
        self.looks.find_preset(&mut self.document);
        self.document.forget_changes();
    }

    /// The scene that runs shall have other settings, which it can take over, and another view. That can be undone.
    pub fn go_on_as(&mut self, scene: &Scene) {
        self.looks.stop();
        self.document.edited = scene.settings.clone();
        self.see_as(scene);
        self.looks.find_preset(&mut self.document);
    }

    /// It cannot: everything is as it was before, but for what is said of it.
    pub fn put_back(&mut self, before: Self) {
        let notices = std::mem::take(&mut self.notices);
        *self = Self { notices, ..before };
    }

    /// The view that a scene's file asks for.
    fn see_as(&mut self, scene: &Scene) {
        self.document.see_as(scene);
    }

    /// The scene runs from step 0, with its settings. What was changed since it was sent for is edited.
    pub fn restarted(&mut self, scene: &Scene) {
        let objects = &self.document.edited.objects;
        let picked = self.hands.selected.and_then(|i| objects.get(i)).cloned();
        self.document.restarted(scene);
        // Those that come or go leave the others in other places.
        if let Some(picked) = picked {
            self.hands.selected = place_among(&self.document.edited.objects, &picked);
        }
        (self.hands).restarted(scene, self.document.edited.foods.len());
    }

    /// What was on its way is not shown. Objects that undo was to bring back did not come, so those that run are edited.
    pub fn not_shown(&mut self) {
        let there = self.document.running.objects.len();
        self.hands.selected = self.hands.selected.filter(|object| *object < there);
        if self.document.not_shown() {
            self.hands.selected = None;
        }
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
        (self.looks).tick(ui.input(|i| i.time), facts.out.filmed);
        // A press that closes a list does nothing else.
        self.hands.is_covered = self.opening.is_open() || egui::Popup::is_any_open(ui.ctx());
        // A dialog has the keyboard to itself.
        if !self.opening.is_open() {
            self.handle_keys(ui.ctx(), facts, &mut commands);
        }
        self.handle_clipboard(ui.ctx(), &mut commands);
        let (looks, mut desk) = self.looks_at(facts, &mut commands);
        looks.advance(ui.ctx(), &mut desk);
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
            self.notices.say(ui.ctx(), text, false);
        }
        if let Some(key) = take_wanted(ui.ctx()) {
            self.begin_to_open_mask(ui.ctx(), key);
        }
        self.keep_one_on_top();
        let (picture, beside) = self.parts(ui, ui.available_rect_before_wrap());
        let size = Vec2::new(picture.width(), picture.height());
        let newcomer = std::mem::take(&mut self.hands.newcomer);
        (self.document).keep_fitting(size, newcomer, self.navigation.is_flying());
        let framed = std::mem::take(&mut self.hands.framed);
        self.document.frame(framed, size);
        let response = ui
            .allocate_rect(picture, Sense::click_and_drag())
            .marked("picture");
        let used = self.use_hands(ui, &response, facts, &mut commands);
        // The first click has picked what it met, and handles may now lie under the second; it still asks for a new centre.
        let refocuses = response.double_clicked() && self.hands.tool == Tool::Look;
        let moved = if self.opening.is_open() || used && !refocuses {
            Moved::default()
        } else {
            (self.navigation).apply(ui, &response, self.hands.drags, &mut self.document.view)
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
        self.notices.show(ui, picture, self.performing);
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

    /// A look on its way is there at once.
    pub fn end_morph(&mut self) {
        self.looks.end(&mut self.document);
    }

    /// Looks, and what they change.
    pub fn looks_at<'a>(
        &'a mut self,
        facts: &'a Facts,
        commands: &'a mut Vec<Command>,
    ) -> (&'a mut Looks, Desk<'a>) {
        let desk = Desk {
            document: &mut self.document,
            facts,
            notices: &mut self.notices,
            commands,
        };
        (&mut self.looks, desk)
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
        if !self.looks.is_morphing() && self.hands.pending_ends == 0 {
            self.document.note();
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
        if self.document.undo.take_lasting() {
            let before = match self.document.undo.can_undo() {
                true => "; once more undoes what was before",
                false => "",
            };
            let text = format!("Painted trail and particles are not taken back{before}");
            return self.notices.say(ctx, text, false);
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
        self.looks.stop();
        let fits = self.document.is_fitted();
        let Some(change) = self.document.lead(again) else {
            return;
        };
        self.hands.let_food_go();
        self.document.fit_again(fits);
        self.looks.find_preset(&mut self.document);
        if change.begins_renewal {
            let running = &self.document.running.objects;
            let picked = (self.hands.selected).and_then(|object| running.get(object));
            let picked =
                picked.and_then(|object| place_among(&self.document.edited.objects, object));
            self.hands.selected = picked;
        }
        commands.push(match change.renews {
            true => Command::Hand(Work::Renew),
            false => Command::Apply,
        });
        commands.extend((change.stroke).map(|stroke| Command::Hand(Work::ToStroke(stroke))));
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
