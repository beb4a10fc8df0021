//! The window and its frames: what happens, in order, from input to a picture on the screen.

mod areas;
mod back;
mod between;
mod closing;
mod commands;
mod depths;
mod exports;
mod jobs;
mod kept_states;
mod loading;
mod looks;
mod lost;
mod networks;
mod objects;
mod pasting;
mod previews;
mod scene_text;
mod show;
mod strokes;
mod work;

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use myxo::gpu::{DeviceKind, Recorder};
use myxo::plain_text::Shown as _;
use myxo::render::View;
use myxo::render::exposure::Exposure;
use myxo::render::gui::Gui;
use myxo::{Error, Result};
use winit::event::WindowEvent;

use crate::lab::answers::Answers;
use crate::lab::checks::Checks;
use crate::lab::clocks::Clocks;
use crate::lab::command::{Command, ExportRequest};
use crate::lab::edits::Edits;
use crate::lab::export::Exports;
use crate::lab::host::Host;
use crate::lab::interface::Interface;
use crate::lab::jobs::Jobs;
use crate::lab::kept_scenes::KeptScenes;
use crate::lab::loading::{Opened, Origin};
use crate::lab::network_overlay::NetworkOverlay;
use crate::lab::options::LabOptions;
use crate::lab::order::{Asked, Task};
use crate::lab::places::Places;
use crate::lab::preferences::Preferences;
use crate::lab::runner::Runner;
use crate::lab::saving::kept_folder;
use crate::lab::screen::{Front, FrontImage, Screen};
use crate::lab::show::{Seen, Shot};
use crate::lab::stage::Stage;
use crate::lab::theme;
use crate::lab::timeline::Timeline;
use crate::lab::waiting::Waiting;
use crate::own_presets::OwnPresets;

/// A picture counts as moving for this long after it last moved; then it may be drawn with all care.
const SETTLES_AFTER: Duration = Duration::from_millis(250);
/// How quickly the exposure follows the trail: a second leaves `exp(-this)` of the difference.
const EXPOSURE_SPEED: f32 = 3.0;
/// How often a window without a size is looked at again.
const HIDDEN_INTERVAL: Duration = Duration::from_millis(100);
/// A picture is refined once nothing has moved, and no input has come, for this long.
const REFINES_AFTER: Duration = Duration::from_millis(600);
/// The places in the report are final if no frame is due for this long.
const RESTS_FOR: Duration = Duration::from_millis(250);
/// How often it is shown how far a scene is that loads, and asked for food that is on its way.
const LOADING_INTERVAL: Duration = Duration::from_millis(50);

/// Everything behind an open window. Fields are dropped in this order: what lies on the device before the device,
/// and the window last.
pub struct Lab {
    /// Draws the interface.
    pub(super) gui: Gui,
    /// Jobs on other threads.
    pub(super) jobs: Jobs,
    /// Data of tools on the device.
    pub(super) edits: Edits,
    /// The images that are shown.
    pub(super) front: Front,
    /// The network's lines over the picture.
    pub(super) lines: NetworkOverlay,
    /// The running simulation.
    pub(super) runner: Runner,
    /// The document, and everything round the picture.
    pub(super) interface: Interface,
    /// Measurements, and the facts that the interface shows.
    pub(super) clocks: Clocks,
    /// States that are kept.
    pub(super) timeline: Timeline,
    /// Requests that wait until steps have ended and the scene has loaded.
    pub(super) waiting: Vec<Waiting>,
    /// When the window answers while steps are under way.
    pub(super) answers: Answers,
    /// The window is to close.
    pub closing: bool,
    /// Test actions after a number of pictures.
    pub(super) countdown: Countdown,
    /// When input last came.
    last_input: Instant,
    /// When the picture last moved.
    pub(super) moved: Instant,
    /// The number of messages of the validation layers.
    pub(super) message_count: usize,
    /// The folder for atlas layouts, which take long to compute.
    pub(super) atlases: Option<PathBuf>,
    /// Preferences kept for the next window.
    pub(super) kept: KeptPreferences,
    /// The report of the window for tests.
    pub(super) places: Option<Places>,
    pub host: Host,
}

/// Test actions after a number of pictures of the scene.
pub(super) struct Countdown {
    /// The lab closes.
    closes: Option<u32>,
    /// The device is treated as lost after this many pictures while the lab is busy; then its replacement, and so on.
    loses_device: VecDeque<u32>,
}

/// Preferences, and the file that they are kept in.
pub(super) struct KeptPreferences {
    file: Option<PathBuf>,
    /// As they were when the window opened.
    opened_with: Preferences,
}

impl Lab {
    /// Opens the lab in a window, which `host` makes for a title and for the size that the last one had, and begins to load the
    /// scene.
    pub fn open(
        host: impl FnOnce(&str, [u32; 2]) -> Result<Host>,
        opened: Opened,
        options: &LabOptions,
    ) -> Result<Self> {
        let scene = &opened.scene;
        let preferences = options.preferences.as_deref();
        let preferences = preferences.map(Preferences::read).unwrap_or_default();
        let mut host = host(&title(&scene.name), preferences.size)?;
        let screen = Screen::open(&host, options)?;
        let Screen {
            gui,
            front,
            mut frames,
            answers,
            format,
            ctx,
        } = screen;
        let context = host.context();
        theme::apply(context, preferences.light);
        context.set_zoom_factor(preferences.zoom);
        let places = options.places.clone();
        let is_watched = options.windowless || places.is_some();
        let places = is_watched.then(|| Places::new(places, context));
        host.set_max_texture_side(ctx.info().max_image_side as usize);
        let mut interface = Interface::new(scene);
        interface.layout.panel = preferences.panel;
        interface.layout.panel_width = preferences.panel_width;
        interface.layout.light = preferences.light;
        interface.exports = preferences.out.clone();
        interface.layout.glides = preferences.glides;
        interface.layout.timeline = preferences.timeline;
        interface.looks.morph_seconds = preferences.morph_seconds;
        interface.gallery.recent = preferences.recent.clone();
        interface.looks.own = OwnPresets::read(OwnPresets::folder());
        interface.looks.find_preset(&mut interface.document);
        interface.gallery.kept = KeptScenes::read(kept_folder());
        let file = opened.from.as_ref().map(|(path, _)| path.as_path());
        let folder = file.map_or(Some(scene.folder.as_path()), Path::parent);
        interface.opening.begin_in(folder.unwrap_or(Path::new("")));
        interface.opening.count_from(&scene.folder);
        let clocks = Clocks::new(&ctx, &mut frames);
        host.request_redraw();
        let name = scene.name.clone();
        let mut lab = Self {
            gui,
            jobs: Jobs::new(Exports::new(options.interrupt)),
            edits: Edits::default(),
            front,
            lines: NetworkOverlay::default(),
            runner: Runner::new(ctx, format, [frames, answers], options.validation),
            interface,
            clocks,
            timeline: Timeline::default(),
            waiting: Vec::new(),
            answers: Answers::begin(false, None),
            closing: false,
            countdown: Countdown {
                closes: options.frames,
                loses_device: options.lose_device.iter().copied().collect(),
            },
            last_input: host.now(),
            moved: host.now(),
            message_count: 0,
            atlases: options.atlases.clone(),
            kept: KeptPreferences {
                file: options.preferences.clone(),
                opened_with: preferences,
            },
            places,
            host,
        };
        lab.load(name, Origin::File, move || Ok(opened));
        Ok(lab)
    }

    /// An event of the system that the interface may want. Does the window have to be drawn again?
    pub fn take_in(&mut self, event: &WindowEvent) -> bool {
        // The report changes at once, because egui may take long, as with the clipboard of another program. The next frame
        // reports a failure.
        let is_frame = matches!(event, WindowEvent::RedrawRequested);
        let is_stirred = !is_frame && self.stir_places().unwrap_or(true);
        self.host.take_in(event) || is_stirred
    }

    /// The window has another size, in pixels.
    pub fn resize(&mut self, size: [u32; 2]) {
        self.front.resize(size);
        self.host.request_redraw();
    }

    /// One frame: what has ended on other threads, interface, steps, picture, screen. Says when the next one is due; `None`
    /// waits for an event.
    pub fn frame(&mut self) -> Result<Option<Instant>> {
        if self.advance_slices()? {
            return Ok(Some(self.host.now()));
        }
        self.stir_places()?;
        let since_last = self.host.pace(self.clocks.tick());
        if self.waiting.is_empty() && self.jobs.loading.is_none() {
            self.interface.notices.end_drop();
        }
        self.poll_jobs()?;
        self.clocks.facts.full_screen = self.host.is_full_screen();
        let mut seen = self.run_interface()?;
        self.obey_all(&seen)?;
        self.follow_preview()?;
        self.look_under_pointer(seen.picture.size);
        self.step_and_show(&mut seen, since_last)
    }

    /// Does what the interface asks for, in order.
    fn obey_all(&mut self, seen: &Seen) -> Result<()> {
        let size = seen.picture.size;
        // A window that closes begins nothing more.
        let ends = |command: &Command| {
            [Command::Export(ExportRequest::Cancel), Command::Quit].contains(command)
        };
        let mut commands = seen.shown.commands.clone();
        commands.retain(|command| !self.closing || ends(command));
        let mut commands = commands.into_iter();
        while let Some(command) = commands.next() {
            if let Err(error) = self.obey(command, size) {
                // Later commands may still be done with another device.
                let rest = commands.map(|command| Waiting::Command(command, size));
                self.waiting.extend(rest);
                return Err(error);
            }
        }
        Ok(())
    }

    /// Records and submits a frame: what tools do, steps, the picture.
    fn step_and_show(&mut self, seen: &mut Seen, since_last: Duration) -> Result<Option<Instant>> {
        let view = self.present_view(since_last);
        let is_cpu = self.runner.ctx.info().kind == DeviceKind::Cpu;
        let has_others = |stage: &Stage| stage.has_other_colors(view.color_map);
        let owes_colors = self.runner.stage.as_ref().is_some_and(has_others);
        let asked = self.asked(seen, owes_colors);
        let (runs, holds) = (self.runs(), self.jobs.exports.holds());
        let can_split = is_cpu && !seen.picture.is_empty() && !self.host.is_unseen();
        let mut task = (self.runner).next_task((runs, holds), can_split, since_last, asked);
        task.only_steps |= self.host.is_unseen();
        if runs {
            task.steps = task.steps.min(self.host.most_steps());
        }
        let may_be_sliced = runs && can_split && task.may_be_sliced(asked);
        if may_be_sliced && self.draw_in_slices(seen, &view)? {
            return Ok(Some(self.host.now()));
        }
        let mut rec = self.runner.frames.begin()?;
        let image = match task.only_steps {
            true => None,
            false => self.next_image()?,
        };
        if image.is_none() && !task.only_steps {
            // Nothing was recorded, and no step that was asked for is lost.
            self.runner.single_steps += if runs { 0 } else { task.steps };
            self.forget_places();
            return Ok(Some(self.host.now() + HIDDEN_INTERVAL));
        }
        self.note_motion(seen, task.steps > 0 || holds || owes_colors);
        let is_moving = self.is_moving();
        let refines = (self.refines_at(seen)).is_some_and(|at| at <= self.host.now());
        let in_slices = self.record_frame(&mut rec, task)?;
        if in_slices {
            self.begin_slices(rec, task.steps, false, seen);
            return Ok(Some(self.host.now()));
        }
        if let Some(image) = image {
            let shot = Shot {
                view,
                answers: task.answers || can_split && asked.soon,
                is_between: false,
                picture: seen.picture,
                beside: seen.beside,
                is_moving,
                refines,
                primitives: std::mem::take(&mut seen.primitives),
                pixels_per_point: seen.pixels_per_point,
            };
            self.draw(rec, image, shot)?;
        } else {
            self.runner.frames.submit(rec)?;
        }
        if is_cpu {
            // Input that comes meanwhile belongs to the next frame, which therefore does not begin before.
            self.runner.frames.wait_idle()?;
        }
        self.finish_frame(seen, task, is_moving)
    }

    /// The next image of the window; `None` skips the picture.
    fn next_image(&mut self) -> Result<Option<FrontImage>> {
        match self.host.is_unseen() {
            true => Ok(None),
            false => Ok(self.front.acquire()?),
        }
    }

    /// Was a picture not shown, since this was last asked?
    pub fn take_missed(&mut self) -> bool {
        self.front.take_missed()
    }

    /// What the user asks of a frame. Other colours are an answer, also to a pointer that rests.
    fn asked(&self, seen: &Seen, owes_colors: bool) -> Asked {
        // Steps go on where no picture can be seen.
        let soon = (self.interface.preview.is_coming() || owes_colors) && !self.host.is_hidden();
        Asked {
            is_asked: seen.is_asked || owes_colors,
            touched: seen.shown.touched || soon,
            soon,
        }
    }

    /// Notes when the picture last moved, and when input last came. A picture that is touched or gets another size moves, too.
    fn note_motion(&mut self, seen: &Seen, moves: bool) {
        let stage = self.runner.stage.as_ref();
        let is_resized = stage.is_some_and(|stage| stage.is_resized(seen.sizes()));
        if moves || seen.shown.touched || is_resized {
            self.moved = self.host.now();
        }
        if seen.is_asked {
            self.last_input = self.host.now();
        }
    }

    /// Records what comes before the picture: tools, exports, the network and steps. Returns true if it is in slices.
    fn record_frame(&mut self, rec: &mut Recorder, task: Task) -> Result<bool> {
        self.record_tools(rec)?;
        self.record_export(rec);
        self.record_network(rec)?;
        // An export may wait for what this frame copies.
        let is_long = task.only_steps && self.runner.pacer.are_long(task.steps);
        let in_slices = is_long && !self.jobs.exports.is_busy();
        if in_slices {
            self.runner.divide(rec);
        }
        self.runner.record_steps(rec, task.steps);
        Ok(in_slices)
    }

    /// Counts and reports a frame that has been submitted. Says when the next one is due.
    fn finish_frame(
        &mut self,
        seen: &Seen,
        task: Task,
        is_moving: bool,
    ) -> Result<Option<Instant>> {
        if (self.runner).have_stepped(task.steps, &mut self.clocks)? {
            self.host.request_redraw();
        }
        if self.runner.stage.is_some() && !task.only_steps {
            self.count_picture();
        }
        self.report_messages();
        self.keep_when_due()?;
        let mut next = self.next_frame(is_moving, seen.repaint);
        if self.host.is_unseen() && task.steps == 0 {
            // Nothing was drawn, so nothing waits for the screen.
            let soonest = self.host.now() + HIDDEN_INTERVAL;
            next = next.map(|next| next.max(soonest));
        }
        if task.only_steps {
            self.forget_places();
        } else {
            let rests = next.is_none_or(|next| next > self.host.now() + RESTS_FOR);
            self.report_places(seen.pixels_per_point, rests)?;
        }
        Ok([next, self.refines_at(seen)].into_iter().flatten().min())
    }

    /// Begins to draw the picture in slices, if another one is to be shown.
    fn draw_in_slices(&mut self, seen: &Seen, view: &View) -> Result<bool> {
        let is_moving = self.is_moving();
        let Some(stage) = &mut self.runner.stage else {
            return Ok(false);
        };
        stage.scales = self.interface.scales();
        if self.jobs.exports.is_busy() || stage.has_picture(view, seen.sizes(), is_moving) {
            return Ok(false);
        }
        let mut rec = self.runner.frames.begin()?;
        self.runner.divide(&mut rec);
        self.record_tools(&mut rec)?;
        self.record_network(&mut rec)?;
        if let Some(stage) = &mut self.runner.stage {
            stage.draw_in_slices(&mut rec, view, seen.sizes(), is_moving)?;
        }
        self.begin_slices(rec, 0, true, seen);
        Ok(true)
    }

    /// Has something in the picture moved a moment ago?
    fn is_moving(&self) -> bool {
        self.host.now() < self.moved + SETTLES_AFTER
    }

    /// Counts down to the test actions after a number of pictures.
    pub(super) fn count_picture(&mut self) {
        if let Some(pictures) = &mut self.countdown.closes {
            *pictures = pictures.saturating_sub(1);
            self.closing |= *pictures == 0;
        }
        // The count pauses while a test prepares something.
        let advances = self.runs() || self.jobs.exports.is_busy();
        let loses_device = &mut self.countdown.loses_device;
        if let Some(pictures) = loses_device.front_mut().filter(|_| advances) {
            *pictures = pictures.saturating_sub(1);
            if *pictures == 0 {
                loses_device.pop_front();
                self.runner.ctx.pretend_lost();
            }
        }
    }

    /// Shows a notice: for a while or, if it is an error, until it is clicked away.
    pub(super) fn notify(&mut self, text: impl Into<String>, is_error: bool) {
        (self.interface.notices).say(self.host.context(), text, is_error);
    }

    /// When the next frame is due; `None` waits for an event.
    fn next_frame(&self, is_moving: bool, repaint: Option<Duration>) -> Option<Instant> {
        let now = self.host.now();
        if self.runs() || self.runner.single_steps > 0 || self.jobs.exports.is_busy() {
            return Some(now);
        }
        let settles = is_moving.then(|| self.moved + SETTLES_AFTER);
        let waits = self.jobs.are_waited_for() || !self.waiting.is_empty();
        let loading = waits.then(|| now + LOADING_INTERVAL);
        let repaint = repaint.and_then(|delay| now.checked_add(delay));
        let due = [settles, loading, repaint, self.network_due()];
        due.into_iter().flatten().min()
    }

    /// When the picture is drawn once more to be smoother, if it still is to be. Until then the window rests.
    fn refines_at(&self, seen: &Seen) -> Option<Instant> {
        let is_busy = self.runs()
            || seen.picture.is_empty()
            || self.runner.single_steps > 0
            || self.jobs.exports.is_busy()
            || self.jobs.are_waited_for()
            || self.runner.previewing.is_some()
            || self.host.is_unseen();
        let stage = self.runner.stage.as_ref().filter(|_| !is_busy)?;
        (stage.can_refine()).then(|| self.moved.max(self.last_input) + REFINES_AFTER)
    }

    /// Does the simulation run without single steps? It waits for a load if both would use the same processors.
    pub(super) fn runs(&self) -> bool {
        let waits = self.jobs.loading.is_some() && self.runner.ctx.info().kind == DeviceKind::Cpu;
        let plays = self.interface.document.playing && !self.closing;
        self.runner.stage.is_some() && plays && !waits && !self.jobs.exports.holds()
    }

    /// The view with the exposure's pace for a frame of this length.
    fn present_view(&self, since_last: Duration) -> View {
        let mut view = self.interface.shown_view();
        if let Exposure::Auto { adaptation, .. } = &mut view.exposure {
            *adaptation = 1.0 - (-EXPOSURE_SPEED * since_last.as_secs_f32()).exp();
            // The exposure follows the film's pictures then, not the clock.
            if self.jobs.exports.holds() {
                *adaptation = 0.0;
            }
        }
        view
    }

    /// Passes on what the validation layers say.
    pub(super) fn report_messages(&mut self) {
        self.pass_on_messages(&self.runner.ctx.take_messages());
        let debug = self.runner.ctx.debug_entries();
        if !debug.entries.is_empty() || debug.overflow > 0 {
            log::warn!("debug_value wrote:\n{debug}");
        }
    }

    /// Passes on messages of the validation layers.
    pub(super) fn pass_on_messages(&mut self, messages: &[String]) {
        self.message_count += messages.len();
        log_messages(messages);
    }

    /// Keeps preferences, which are equal in every scene, for the next session.
    pub(super) fn keep_preferences(&self) {
        let Some(file) = &self.kept.file else {
            return;
        };
        let preferences = Preferences {
            light: self.interface.layout.light,
            panel: self.interface.layout.panel,
            panel_width: self.interface.layout.panel_width,
            zoom: self.host.context().zoom_factor(),
            morph_seconds: self.interface.looks.morph_seconds,
            glides: self.interface.layout.glides,
            timeline: self.interface.layout.timeline,
            recent: self.interface.gallery.recent.clone(),
            out: self.interface.exports.kept(),
            // The whole screen is not the size of a window.
            size: match self.host.is_full_screen() {
                true => Preferences::read(file).size,
                false => self.host.size(),
            },
        };
        let preferences = preferences.over(&self.kept.opened_with, &Preferences::read(file));
        if let Err(error) = preferences.write(file) {
            log::warn!("preferences are not kept in {}: {error}", file.shown());
        }
    }

    /// Ends all work and keeps what is to be kept. A problem that was found while the lab ran is an error.
    pub fn close(mut self) -> Result<()> {
        if let Err(error) = self.end_preview() {
            log::warn!("a preview is not ended: {error}");
        }
        self.obey_what_writes();
        // The scene that is kept has a picture, which needs whole steps.
        if self.interface.document.is_unsaved()
            && let Err(error) = self.finish_steps()
        {
            log::warn!("the last steps are not finished: {error}");
        }
        self.runner.give_up_slices();
        let _ = self.runner.frames.wait_idle();
        self.end_exports();
        self.jobs.food.close();
        self.jobs.ahead.close();
        if let Some(loading) = &self.jobs.loading {
            loading.cancel();
        }
        self.jobs.leave_device();
        self.report_messages();
        self.report_kept();
        self.keep_preferences();
        if let Some(problem) = self.runner.checks.as_ref().and_then(Checks::problem) {
            return Err(Error::Invalid(format!("{problem}; this is a bug in myxo")));
        }
        if self.message_count > 0 {
            return Err(Error::Invalid(format!(
                "the validation layers said {} things, listed above: please report them",
                self.message_count
            )));
        }
        Ok(())
    }
}

/// Logs messages of the validation layers.
pub(super) fn log_messages(messages: &[String]) {
    for message in messages {
        log::error!("validation: {message}");
    }
}

/// The title of the window that shows a scene.
pub fn title(scene: &str) -> String {
    format!("{scene} - myxo")
}
