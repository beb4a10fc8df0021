//! The interface round the picture: the panel with every parameter, the line of facts and the help, and their requests to the
//! window.
//!
//! The interface changes its own settings and view at once and asks the window for the rest by [`Command`]s, so it
//! runs without a window and without a device, as its tests do.

use std::time::Duration;

use egui::{Rect, Response, Sense, Ui};
use glam::Vec2;
use myxo::scene::Scene;

use crate::lab::actions::{Action, FLAT, NO_LINES, pressed};
use crate::lab::autopilot::{Autopilot, MORPH};
use crate::lab::axes::{Turned, show_axes};
use crate::lab::command::{Command, ExportRequest, ToolRequest};
use crate::lab::desk::{Desk, desk};
use crate::lab::document::{Document, Room};
use crate::lab::export_panel::ExportPanel;
use crate::lab::facts::Facts;
use crate::lab::gallery::Gallery;
use crate::lab::layout::{Card, Layout, move_beside};
use crate::lab::looks::Looks;
use crate::lab::marks::Marks;
use crate::lab::navigation::{Moved, Navigation};
use crate::lab::notices::{HOW_BACK, HOW_DRIFT_ENDS, Notices};
use crate::lab::opening::{EVERYTHING, Opening};
use crate::lab::overlays::{show_ending, show_help, show_loading, show_previewed, status_line};
use crate::lab::panel::ParameterPanel;
use crate::lab::places::{Marked as _, note_value};
use crate::lab::preview::{Preview, PreviewedLook};
use crate::lab::renewal::place_among;
use crate::lab::rows::take_wanted;
use crate::lab::strip::{Strip, show_folded};
use crate::lab::theme;
use crate::lab::tools::{self, Tool, Tools};
use crate::lab::views::{choose_view, note_view};
use crate::lab::widgets::{give_up_number, take_pointed, take_refused};
use crate::own_presets::with_preset;
use myxo::render::{Camera, View};
use myxo::scene::settings::{Settings, Show};

/// A camera that has been in its place for so long is an entry to undo, seconds.
const CAMERA_RESTS: f64 = 0.4;

/// The state of everything round the picture.
#[derive(Clone, Debug)]
pub struct Interface {
    /// The document.
    pub document: Document,
    /// The layout of the window.
    pub layout: Layout,
    /// Pointer and flights.
    pub navigation: Navigation,
    /// Brushes, picked objects, the probe.
    pub tools: Tools,
    /// Presets that can be taken, and how looks change.
    pub looks: Looks,
    /// The parameters.
    pub panel: ParameterPanel,
    /// Scenes and presets.
    pub gallery: Gallery,
    /// States that are kept.
    pub strip: Strip,
    /// What the picture shows because the pointer rests on it.
    pub preview: Preview,
    /// The dialog for files.
    pub opening: Opening,
    /// Exports.
    pub exports: ExportPanel,
    /// Lines over the picture.
    pub notices: Notices,
    /// Drifts from look to look.
    pub autopilot: Autopilot,
    /// Is the key held?
    shift: bool,
    /// The field for text or a number that had the keyboard when the last pass was shown.
    field: Option<egui::Id>,
    /// The camera of the last frame, and since when it has been there.
    camera: (Camera, f64),
}

/// The result of one frame of the interface.
#[derive(Clone, Debug)]
pub struct Shown {
    /// Commands to the window, in order.
    pub commands: Vec<Command>,
    /// The rectangle of the picture, in points.
    pub picture: Rect,
    /// The rectangle of the atlas, if it is shown beside the picture.
    pub beside: Option<Rect>,
    /// The user is moving something in the scene.
    pub touched: bool,
}

impl Interface {
    /// The interface for a scene that has just been loaded.
    pub fn new(scene: &Scene) -> Self {
        let mut interface = Self {
            document: Document::new(scene),
            layout: Layout::default(),
            navigation: Navigation::default(),
            tools: Tools::new(),
            looks: Looks::default(),
            panel: ParameterPanel::default(),
            gallery: Gallery::default(),
            strip: Strip::default(),
            preview: Preview::default(),
            opening: Opening::default(),
            exports: ExportPanel::default(),
            notices: Notices::default(),
            autopilot: Autopilot::default(),
            shift: false,
            field: None,
            camera: (Camera::default(), 0.0),
        };
        interface.open(scene);
        interface
    }

    /// Another scene has been loaded: its settings and its view.
    pub fn open(&mut self, scene: &Scene) {
        self.document.open(scene);
        self.see_as(scene);
        self.tools.leave_scene();
        self.document.marks = Marks::default();
        self.panel.open_scene();
        self.document.morph = None;
        self.restarted(scene);
        self.tools.newcomer.clear();
        self.looks.find_preset(&mut self.document);
        self.document.forget_changes();
    }

    /// Gives the running scene other settings, which it can take over, and another view. This can be undone.
    pub fn continue_as(&mut self, scene: &Scene) {
        self.document.morph = None;
        self.document.note_camera();
        self.document.edited = scene.settings.clone();
        self.see_as(scene);
        self.document.undo.bring_camera();
        self.looks.find_preset(&mut self.document);
    }

    /// Restores everything as it was before, except the notices, if the scene could not take them over.
    pub fn put_back(&mut self, before: Self) {
        let notices = std::mem::take(&mut self.notices);
        *self = Self { notices, ..before };
    }

    /// The view that a scene's file asks for.
    fn see_as(&mut self, scene: &Scene) {
        self.document.see_as(scene);
    }

    /// The scene runs from step 0, with its settings. Changes made while it was being loaded are kept as edits.
    pub fn restarted(&mut self, scene: &Scene) {
        let objects = &self.document.edited.objects;
        let picked = self.tools.selected.and_then(|i| objects.get(i)).cloned();
        self.document.restarted(scene);
        // Added or removed objects change the indices of the others.
        if let Some(picked) = picked {
            self.tools.selected = place_among(&self.document.edited.objects, &picked);
        }
        (self.tools).restarted(scene, self.document.edited.foods.len());
    }

    /// The scene on its way is not shown. Objects that undo was to bring back did not come, so the running objects are edited
    /// again.
    pub fn not_shown(&mut self) {
        let there = self.document.running.objects.len();
        self.tools.selected = self.tools.selected.filter(|object| *object < there);
        if self.document.not_shown() {
            self.tools.selected = None;
        }
    }

    /// A frame of the interface. egui repeats the pass if a new element did not have its size yet, and only the first pass
    /// receives the input: the results of both passes count.
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
        let ctx = ui.ctx().clone();
        let (mut actions, mut commands) = (Vec::new(), Vec::new());
        let now = ui.input(|i| i.time);
        self.begin_frame(&ctx, now, facts);
        let shown_before = self.navigation.shown(&self.document.view.camera);
        self.perform_keys(&ctx, facts, (&mut actions, &mut commands));
        self.handle_clipboard(&ctx, &mut commands);
        self.drift(&ctx, now, facts, (&mut actions, &mut commands));
        let panel = self.show_round(ui, facts, (&mut actions, &mut commands));
        let whole = ui.available_rect_before_wrap();
        let (picture, beside) = self.layout.parts(&ctx, whole, self.document.view.show);
        let room = self.room_in(&ctx, picture);
        self.keep_in_picture(room);
        let response = ui
            .allocate_rect(picture, Sense::click_and_drag())
            .marked("picture");
        // Keys are for the whole window there.
        response.surrender_focus();
        // After the picture, so that it lies over its edge.
        if let Some(panel) = panel {
            self.layout.drag_edge(ui, panel);
        }
        let requests = (&mut actions, &mut commands);
        let touched = self.use_pointer(ui, &response, beside, facts, requests);
        if let Some(found) = facts.network.as_ref().filter(|_| self.shows_network()) {
            note_value(&ctx, "network", || found.numbers());
        }
        self.show_over(ui, picture, facts, (&mut actions, &mut commands));
        self.show_dialog(&ctx, picture, &mut commands);
        self.perform_asked(&ctx, room, facts, (&mut actions, &mut commands));
        if std::mem::take(&mut self.document.eases) && shown_before != self.document.view.camera {
            self.navigation.ease(shown_before);
            ctx.request_repaint();
        }
        self.note_at_rest(&ctx, now);
        let focused = ctx.memory(|memory| memory.focused());
        self.field = focused.filter(|_| ctx.text_edit_focused());
        Shown {
            commands,
            picture,
            beside,
            touched,
        }
    }

    /// Are the network's lines shown over the picture?
    pub fn shows_network(&self) -> bool {
        self.layout.network && !self.document.view.show.is_flat()
    }

    /// A frame begins, at this time in seconds.
    fn begin_frame(&mut self, ctx: &egui::Context, now: f64, facts: &Facts) {
        let document = &mut self.document;
        document.marks.follow(&document.edited.objects);
        self.looks.tick(now, facts.exports.filmed);
        self.navigation.tick(now);
        self.navigation.glides = self.layout.glides && facts.exports.recording.is_none();
        // A press that closes a list does nothing else.
        self.tools.is_covered = self.opening.is_open() || egui::Popup::is_any_open(ctx);
    }

    /// Performs the actions of keys that were pressed. A dialog has the keyboard to itself.
    fn perform_keys(
        &mut self,
        ctx: &egui::Context,
        facts: &Facts,
        (actions, commands): (&mut Vec<Action>, &mut Vec<Command>),
    ) {
        let has_ended = self.end_autopilot(ctx);
        if self.opening.is_open() {
            return;
        }
        self.navigation.keep_keys(ctx);
        let leaves_field = self.leaves_field(ctx);
        if leaves_field {
            give_up_number(ctx);
        }
        // A key that ends it does no more.
        let ends =
            |action: &Action| has_ended && matches!(action, Action::Autopilot | Action::Back);
        let pressed = pressed(ctx, leaves_field).into_iter();
        for action in pressed.filter(|action| !ends(action)) {
            self.perform(ctx, action, facts, (&mut *actions, &mut *commands));
        }
    }

    /// Has Escape left a field? egui has taken the keyboard from it already. The search is left by an action.
    fn leaves_field(&self, ctx: &egui::Context) -> bool {
        let is_left = |field| {
            ctx.memory(|memory| memory.had_focus_last_frame(field) && !memory.has_focus(field))
        };
        let is_pressed = ctx.input(|i| i.key_pressed(egui::Key::Escape));
        is_pressed && self.field.is_some_and(is_left) && !self.panel.is_searching()
    }

    /// Shows what lies round the picture: the line of facts, the panel, the gallery and the kept states. Returns the rectangle of
    /// the panel, if it is shown.
    fn show_round(
        &mut self,
        ui: &mut Ui,
        facts: &Facts,
        (actions, commands): (&mut Vec<Action>, &mut Vec<Command>),
    ) -> Option<Rect> {
        let mut desk = desk!(self, facts, actions, commands);
        self.looks.advance(ui.ctx(), &mut desk);
        note_view(ui.ctx(), desk.document, &self.navigation);
        if !desk.layout.alone {
            status_line(ui, desk.document, facts);
        }
        let mut panel_rect = None;
        if desk.layout.shows_panel(ui.available_width()) {
            let shown = egui::Panel::left("panel")
                .exact_size(desk.layout.panel_fits(ui.available_width()))
                .resizable(false)
                .show_separator_line(false)
                .frame(theme::panel_frame(ui))
                .show(ui, |ui| {
                    self.panel.show(
                        ui,
                        &mut self.looks,
                        &mut self.tools,
                        &self.navigation,
                        &mut desk,
                    )
                });
            panel_rect = Some(shown.response.rect);
        }
        self.preview.point_at(take_pointed(ui.ctx()));
        self.gallery
            .show(ui, &mut self.looks, &mut self.preview, &mut desk);
        self.strip.show(ui, &mut desk);
        if let Some(text) = take_refused(ui.ctx()) {
            desk.notices.say(ui.ctx(), text, false);
        }
        if let Some(key) = take_wanted(ui.ctx()) {
            desk.opening.begin_mask(ui.ctx(), key);
        }
        panel_rect
    }

    /// The size of a picture, and how much of it the tools cover.
    fn room_in(&self, ctx: &egui::Context, picture: Rect) -> Room {
        let covered = match self.layout.alone {
            true => 0.0,
            false => tools::covered(ctx, picture, self.document.view.show),
        };
        let size = Vec2::new(picture.width(), picture.height());
        Room { size, covered }
    }

    /// Lets the pointer use tools or move the view over the picture, and move the atlas beside it. Returns true if the user is
    /// moving something.
    fn use_pointer(
        &mut self,
        ui: &mut Ui,
        response: &Response,
        beside: Option<Rect>,
        facts: &Facts,
        (actions, commands): (&mut Vec<Action>, &mut Vec<Command>),
    ) -> bool {
        let mut desk = desk!(self, facts, actions, commands);
        let used = self.tools.use_tools(ui, response, &mut desk);
        // The first click has picked what it met, and handles may now lie under the second; it still asks for a new centre.
        let refocuses = response.double_clicked() && self.tools.tool == Tool::Look;
        let moved = if desk.opening.is_open() || used && !refocuses {
            Moved::default()
        } else {
            self.navigation
                .apply(ui, response, self.tools.drags, &mut desk.document.view)
        };
        let beside_touched = beside.is_some_and(|rect| {
            move_beside(ui, rect, &mut desk.layout.beside, &mut desk.document.view)
        });
        if let Some(pixel) = moved.refocus {
            desk.commands.push(Command::Refocus(pixel));
        }
        moved.touched || beside_touched || response.dragged()
    }

    /// Shows what lies over the picture: tools, axes, cards and notices.
    fn show_over(
        &mut self,
        ui: &Ui,
        picture: Rect,
        facts: &Facts,
        (actions, commands): (&mut Vec<Action>, &mut Vec<Command>),
    ) {
        let ctx = ui.ctx();
        let desk = desk!(self, facts, &mut *actions, &mut *commands);
        self.tools.show(ui, picture, &desk);
        if !desk.layout.alone {
            let camera = self.navigation.shown(&desk.document.view.camera);
            let turned = show_axes(ui, picture, &camera, &desk);
            self.turn(turned, Vec2::new(picture.width(), picture.height()));
        }
        let mut desk = desk!(self, facts, actions, commands);
        let mut bar = None;
        if !desk.layout.alone {
            bar = self.tools.show_tools(ctx, picture, &mut desk);
        }
        show_folded(ctx, picture, &mut desk);
        show_help(ctx, picture, bar, desk.layout);
        show_previewed(ctx, picture, self.preview.look(), facts);
        self.exports.show(ctx, picture, bar, &mut desk);
        if let Some(loading) = &facts.loading {
            show_loading(ctx, picture, loading, desk.commands);
        }
        if facts.exports.ends {
            show_ending(ctx, picture, &facts.exports);
        }
        desk.notices.show(ui, picture, desk.layout.alone);
        desk.layout.hide_resting_pointer(ctx);
    }

    /// Shows the dialog for files over everything else, and takes what was chosen in it. An open dialog ends a preview.
    fn show_dialog(&mut self, ctx: &egui::Context, picture: Rect, commands: &mut Vec<Command>) {
        if let Some(folder) = self.opening.show(ctx, &mut self.document.edited, commands)
            && let Err(refusal) = self.exports.take_folder(&folder)
        {
            self.notices.say(ctx, refusal, true);
        }
        self.opening.ask_about_mesh(ctx, picture, commands);
        if self.opening.is_open() {
            self.preview.end();
        }
    }

    /// Performs the actions that panels and tools have asked for in this frame, in order.
    fn perform_asked(
        &mut self,
        ctx: &egui::Context,
        room: Room,
        facts: &Facts,
        (actions, commands): (&mut Vec<Action>, &mut Vec<Command>),
    ) {
        let mut next = 0;
        while let Some(action) = actions.get(next).copied() {
            next += 1;
            self.perform(ctx, action, facts, (&mut *actions, &mut *commands));
        }
        if next > 0 {
            // Their changes of the camera are in the picture of this frame.
            self.keep_in_picture(room);
        }
    }

    /// Notes changes and the camera for undo, unless something is held or typed.
    fn note_at_rest(&mut self, ctx: &egui::Context, now: f64) {
        let is_busy = ctx.input(|i| i.pointer.any_down()) || ctx.text_edit_focused();
        if !is_busy && !self.tools.holds_food() {
            self.note_changes();
            self.note_camera(ctx, now);
        }
    }

    /// The axes were dragged or clicked, beside a picture of this size.
    fn turn(&mut self, turned: Turned, size: Vec2) {
        if turned.drag != Vec2::ZERO {
            self.navigation.stop(&mut self.document.view);
        }
        let camera = &mut self.document.view.camera;
        if turned.drag != Vec2::ZERO {
            camera.orbit(turned.drag, size);
        }
        if let Some(side) = turned.side {
            camera.look_from(side);
            self.document.eases = true;
        }
    }

    /// Notes where the camera is, once it has been there for a moment: a drag, a turn of the wheel or a flight is one entry to undo.
    fn note_camera(&mut self, ctx: &egui::Context, now: f64) {
        let camera = self.document.view.camera;
        if self.camera.0 != camera {
            self.camera = (camera, now);
        }
        let left = self.camera.1 + CAMERA_RESTS - now;
        if left <= 0.0 && !self.navigation.goes_on() {
            self.document.note_camera();
        } else {
            ctx.request_repaint_after(Duration::from_secs_f64(left.max(0.0)));
        }
    }

    /// Turns the camera to what it is to show. That is no entry to undo.
    fn keep_in_picture(&mut self, room: Room) {
        let before = self.document.view.camera;
        self.fit_into_picture(room);
        let document = &mut self.document;
        let (after, fits) = (document.view.camera, document.is_fitted());
        if after != before {
            document.undo.follow_camera(&before, &after, fits);
        }
    }

    fn fit_into_picture(&mut self, room: Room) {
        let newcomer = std::mem::take(&mut self.tools.newcomer);
        let is_flying = self.navigation.is_flying();
        self.document.keep_fitting(room, newcomer, is_flying);
        let framed = std::mem::take(&mut self.tools.framed);
        self.document.frame(framed, room);
    }

    /// Performs the action of a key, a button or the search; its commands are done in the same frame.
    fn perform(
        &mut self,
        ctx: &egui::Context,
        action: Action,
        facts: &Facts,
        (actions, commands): (&mut Vec<Action>, &mut Vec<Command>),
    ) {
        if action.keeps_the_scene() {
            take_what_is_typed(ctx);
        }
        let mut desk = desk!(self, facts, &mut *actions, &mut *commands);
        match action {
            Action::Pause => desk.document.playing = !desk.document.playing,
            Action::SingleStep => {
                desk.document.playing = false;
                desk.commands.push(Command::Step);
            }
            Action::Restart => desk.commands.push(Command::Restart),
            Action::Show(show) => choose_view(ctx, show, &mut desk),
            Action::Split => desk.layout.split = !desk.layout.split,
            Action::Network if desk.document.view.show.is_flat() => {
                desk.notices.say(ctx, NO_LINES, false);
            }
            Action::Network => desk.layout.network = !desk.layout.network,
            Action::Fly => self.navigation.toggle_flight(ctx, desk.notices),
            Action::NextCharts => next_charts(ctx, &mut desk),
            Action::NextColors => {
                let view = &mut desk.document.view;
                view.color_map = view.color_map.next();
            }
            Action::NextPreset => self.looks.step_preset(ctx, true, &mut desk),
            Action::PreviousPreset => self.looks.step_preset(ctx, false, &mut desk),
            Action::ByChance => self.looks.by_chance(ctx, &mut desk),
            Action::LaterThrow => self.looks.step_throw(ctx, true, &mut desk),
            Action::EarlierThrow => self.looks.step_throw(ctx, false, &mut desk),
            Action::Home if desk.document.view.show.is_flat() => desk.document.fit(),
            Action::Home => {
                desk.document.eases = true;
                desk.document.go_home();
            }
            Action::Fit => {
                desk.document.eases = true;
                let is_flat = desk.document.view.show.is_flat();
                if is_flat || !self.tools.frame_picked(&facts.pointer.poses) {
                    desk.document.fit();
                }
            }
            Action::Screenshot => desk.commands.push(Command::Screenshot),
            Action::Record => desk.commands.push(Command::Export(ExportRequest::Record)),
            Action::Export => desk.layout.toggle(Card::Exports),
            Action::Open => desk.opening.begin(ctx, EVERYTHING),
            Action::Save => desk.commands.push(Command::Save),
            Action::SaveAs => desk.commands.push(Command::AskWhereToSave),
            Action::Undo => self.undo_by_user(ctx, commands),
            Action::Redo => self.redo(commands),
            Action::Panel => desk.layout.panel = !desk.layout.panel,
            Action::PictureAlone => self.show_alone(ctx),
            // While it is on, its key is held.
            Action::Autopilot if self.autopilot.is_on() => {}
            Action::Autopilot => self.begin_autopilot(ctx),
            Action::FullScreen => desk.commands.push(Command::FullScreen),
            Action::Theme => desk.layout.set_light(ctx, !desk.layout.light),
            Action::Gallery => desk.layout.gallery = !desk.layout.gallery,
            Action::Help => desk.layout.toggle(Card::Help),
            Action::Brush | Action::Food | Action::Pulse | Action::Probe
                if desk.document.view.show.is_flat() =>
            {
                desk.notices.say(ctx, FLAT, false);
            }
            Action::Brush => self.tools.toggle_brush(),
            Action::Food => self.tools.toggle_food(),
            Action::Pulse => self.tools.toggle_pulse(),
            Action::Probe => self.tools.toggle_probe(),
            Action::Duplicate => self.tools.duplicate_selected(ctx, &mut desk),
            Action::Remove => self.tools.remove_selected(ctx, &mut desk),
            Action::Hide => self.tools.hide_selected(ctx, &mut desk),
            Action::ShowAll => desk.document.marks.show_all(),
            Action::Back => self.back(ctx, facts, (actions, commands)),
            Action::Quit => desk.commands.push(Command::Quit),
        }
    }

    /// Leaves what lies on top: a list, the search, a card, the picture alone, the gallery, a tool, a scene that is awaited.
    fn back(
        &mut self,
        ctx: &egui::Context,
        facts: &Facts,
        (actions, commands): (&mut Vec<Action>, &mut Vec<Command>),
    ) {
        let mut desk = desk!(self, facts, &mut *actions, &mut *commands);
        if egui::Popup::is_any_open(ctx) {
            egui::Popup::close_all(ctx);
        } else if self.panel.leave_search() {
            // Everything is shown again.
        } else if desk.layout.shows_a_card() {
            desk.layout.close_card();
        } else if desk.layout.alone {
            self.show_alone(ctx);
        } else if desk.layout.gallery {
            desk.layout.gallery = false;
        } else if self.tools.give_up_grab(&mut desk) {
            // The moved object is back in its place.
        } else if self.tools.back() {
            // A tool was left, or an object.
        } else if self.navigation.is_flying() {
            self.navigation.toggle_flight(ctx, desk.notices);
        } else {
            desk.commands.push(Command::CancelLoading);
        }
    }

    /// The picture alone, or no longer.
    fn show_alone(&mut self, ctx: &egui::Context) {
        self.layout.alone = !self.layout.alone;
        self.layout.close_card();
        self.tools.leave_scene();
        if self.layout.alone {
            self.notices.say(ctx, HOW_BACK, false);
        }
    }

    /// The picture alone drifts from look to look, and the camera round the scene.
    fn begin_autopilot(&mut self, ctx: &egui::Context) {
        let was_alone = self.layout.alone;
        if !was_alone {
            self.show_alone(ctx);
        }
        self.notices.say(ctx, HOW_DRIFT_ENDS, false);
        self.navigation.set_flying(false);
        self.preview.end();
        self.document.playing = true;
        self.autopilot.begin(ctx.input(|i| i.time), was_alone);
    }

    /// Any input ends the autopilot. Returns true if it has.
    fn end_autopilot(&mut self, ctx: &egui::Context) -> bool {
        let pilot = &mut self.autopilot;
        let by_input = ctx.input(|i| pilot.end_by(&i.events, i.pointer.latest_pos()));
        // A file that was dropped opens a dialog.
        let by_dialog = self.opening.is_open().then(|| pilot.end()).flatten();
        let ended = by_input.or(by_dialog);
        if ended == Some(false) && self.layout.alone {
            self.show_alone(ctx);
        }
        ended.is_some()
    }

    /// A frame of the autopilot.
    fn drift(
        &mut self,
        ctx: &egui::Context,
        now: f64,
        facts: &Facts,
        (actions, commands): (&mut Vec<Action>, &mut Vec<Command>),
    ) {
        let Some(drifted) = self.autopilot.advance(now) else {
            return;
        };
        ctx.request_repaint();
        let document = &mut self.document;
        if !document.view.show.is_flat() {
            let before = document.view.camera;
            document.view.camera = before.turned(drifted.turns);
            let after = document.view.camera;
            document.undo.follow_camera(&before, &after, false);
        }
        if let Some(number) = drifted.look.filter(|_| facts.loading.is_none()) {
            let mut desk = desk!(self, facts, actions, commands);
            self.looks.drift(ctx, (number, MORPH), &mut desk);
        }
    }

    /// Returns the factor by which each object is drawn larger than it runs: by a handle that is held, and by a scale whose layout is
    /// under way. Empty if all factors are 1.
    pub fn scales(&self) -> Vec<f32> {
        let held = |object| match self.tools.selected == Some(object) {
            true => self.tools.scaled(),
            false => 1.0,
        };
        let objects = 0..self.document.running.objects.len();
        let scales: Vec<f32> = objects
            .map(|object| held(object) * self.document.pending_scale(object))
            .collect();
        match scales.iter().all(|scale| *scale == 1.0) {
            true => Vec::new(),
            false => scales,
        }
    }

    /// The view that the picture shows: the document's, with what is previewed.
    pub fn shown_view(&self) -> View {
        let mut view = self.document.view;
        view.camera = self.navigation.shown(&view.camera);
        let look = self
            .previewed_look()
            .map(|look| look.settings.picture.color_map);
        if let Some(colors) = self.preview.colors().or(look) {
            view.color_map = colors;
        }
        view
    }

    /// The look that is previewed, if any.
    pub fn previewed_look(&self) -> Option<PreviewedLook> {
        let name = self.preview.look()?;
        let text = self.looks.preset_text(name)?;
        let settings = with_preset(&self.document.look(), name, &text).ok()?;
        let name = name.to_owned();
        Some(PreviewedLook { name, settings })
    }

    /// Food that was asked for cannot be there; what there was stays.
    pub fn food_is_refused(&mut self, refused: &Settings) {
        self.tools.take_food_back(refused, &mut self.document);
    }

    /// Takes over a look that came as text under this `name`. Returns false if it has an error, which a notice shows.
    pub fn take_look(
        &mut self,
        ctx: &egui::Context,
        (name, text): (&str, &str),
        facts: &Facts,
        commands: &mut Vec<Command>,
    ) -> bool {
        let mut actions = Vec::new();
        let mut desk = desk!(self, facts, &mut actions, commands);
        self.looks.take_preset(ctx, name, text, &mut desk)
    }

    /// Notes changes, so that undo can lead back to the state before them. Changes after a stroke that waits for its end are
    /// noted after it.
    pub(super) fn note_changes(&mut self) {
        self.tools.note_changes(&mut self.document);
    }

    /// Takes back the last change of settings, look or painted areas.
    pub(super) fn undo(&mut self, commands: &mut Vec<Command>) {
        self.undo_in_turn(false, commands);
    }

    /// Undoes the last change, unless it was painting that cannot be undone: then a notice says so.
    pub(super) fn undo_by_user(&mut self, ctx: &egui::Context, commands: &mut Vec<Command>) {
        // Later changes are noted first.
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
        self.note_changes();
        self.undo_in_turn(true, commands);
    }

    fn undo_in_turn(&mut self, again: bool, commands: &mut Vec<Command>) {
        // The stroke that is being painted is the next to be undone; so is one whose end waits, if it changes anything.
        if self.tools.pending_ends > 0 && !self.tools.paints_areas {
            commands.push(Command::Tool(ToolRequest::Undo { again }));
        } else if !self.tools.paints_areas {
            self.undo_now(again, commands);
        }
    }

    /// Undo, or redo with `again`, after all strokes that came before it.
    pub(super) fn undo_now(&mut self, again: bool, commands: &mut Vec<Command>) {
        // The entry to come back to has all of a look that was on its way.
        self.document.end_morph();
        let fits = self.document.is_fitted();
        let foods = self.document.edited.foods.clone();
        let Some(change) = self.document.lead(again) else {
            return;
        };
        self.tools.let_food_go();
        (self.tools).follow_food(&foods, &self.document.edited.foods);
        self.document.fit_again(fits);
        let preset = self.document.preset.as_deref();
        let is_there = preset.is_some_and(|name| self.looks.preset_text(name).is_some());
        if !is_there {
            self.looks.find_preset(&mut self.document);
        }
        if change.begins_renewal {
            let running = &self.document.running.objects;
            let picked = (self.tools.selected).and_then(|object| running.get(object));
            let picked =
                picked.and_then(|object| place_among(&self.document.edited.objects, object));
            self.tools.selected = picked;
        }
        commands.extend(change.state.map(Command::ReturnToState));
        commands.push(match change.renews {
            true => Command::Tool(ToolRequest::Renew),
            false => Command::Apply,
        });
        commands.extend((change.stroke).map(|stroke| Command::Tool(ToolRequest::ToStroke(stroke))));
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

/// A number that is being typed counts as it stands: its field takes it when it loses the keyboard.
fn take_what_is_typed(ctx: &egui::Context) {
    ctx.memory_mut(|memory| {
        if let Some(field) = memory.focused() {
            memory.surrender_focus(field);
        }
    });
}

/// Charts: none, under the trail, alone, and so on; if the picture has none, a notice says so.
fn next_charts(ctx: &egui::Context, desk: &mut Desk<'_>) {
    let show = desk.document.view.show;
    if !show.has_charts() {
        let text = format!(
            "{} has no charts of X: {} show them",
            show.title(),
            Show::titles(Show::has_charts)
        );
        return desk.notices.say(ctx, text, false);
    }
    desk.document.view.charts = match desk.document.view.charts {
        charts if charts < 0.5 => 0.5,
        charts if charts < 1.0 => 1.0,
        _ => 0.0,
    };
}

#[cfg(test)]
mod tests;
