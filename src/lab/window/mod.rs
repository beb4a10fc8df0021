//! The window and its frames: what happens, in order, from input to a picture on the screen.

mod areas;
mod back;
mod closing;
mod commands;
mod depths;
mod exports;
mod feeding;
mod looks;
mod lost;
mod objects;
mod pasting;
mod scene_text;
mod show;
mod strokes;
mod under_way;
mod work;

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use myxo::gpu::{Context, DeviceKind, Format, Frames};
use myxo::plain_text::Shown as _;
use myxo::render::View;
use myxo::render::exposure::Exposure;
use myxo::render::gui::Gui;
use myxo::{Error, Result};
use winit::event::WindowEvent;

use crate::lab::back::Back;
use crate::lab::checks::Checks;
use crate::lab::clocks::Clocks;
use crate::lab::command::Command;
use crate::lab::command::Out;
use crate::lab::edits::Edits;
use crate::lab::feeding::Feeder;
use crate::lab::host::Host;
use crate::lab::interface::Interface;
use crate::lab::left::LeftScenes;
use crate::lab::loading::{Loading, Opened, Origin};
use crate::lab::lost::Lost;
use crate::lab::options::LabOptions;
use crate::lab::order::{Asked, Order, Task};
use crate::lab::out::TakeOut;
use crate::lab::pacing::Pacer;
use crate::lab::places::Places;
use crate::lab::preferences::Preferences;
use crate::lab::saving::SceneFile;
use crate::lab::saving::left_folder;
use crate::lab::screen::{Front, Screen};
use crate::lab::show::Shot;
use crate::lab::stage::Stage;
use crate::lab::theme;
use crate::lab::under_way::{LONGEST_SLICE, Left, UnderWay};
use crate::own_presets::OwnPresets;

/// A picture counts as moving for this long after it last moved; then it may be drawn with all care.
const SETTLES_AFTER: Duration = Duration::from_millis(250);
/// How quickly the exposure follows the trail: a second leaves `exp(-this)` of the difference.
const EXPOSURE_SPEED: f32 = 3.0;
/// How often a window without a size is looked at again.
const HIDDEN_INTERVAL: Duration = Duration::from_millis(100);
/// Who looks at places may take them as they are, where no frame is due for so long.
const RESTS_FOR: Duration = Duration::from_millis(250);
/// How often it is shown how far a scene is that loads, and asked for food that is on its way.
const LOADING_INTERVAL: Duration = Duration::from_millis(50);

/// Everything behind an open window. Fields are dropped in this order: what lies on the device before the device,
/// and the window last.
pub struct Lab {
    pub(super) gui: Gui,
    /// What runs; none before the first scene is ready.
    pub(super) stage: Option<Stage>,
    /// What is on its way.
    pub(super) loading: Option<Loading>,
    /// What is shown.
    pub(super) front: Front,
    /// Steps that are not over yet.
    pub(super) under_way: Option<UnderWay>,
    /// What was left to do when they are.
    pub(super) left: Vec<Left>,
    pub(super) frames: Frames,
    /// For what is shown while steps are under way.
    pub(super) answers: Frames,
    pub(super) interface: Interface,
    pub(super) clocks: Clocks,
    /// What is being taken out.
    pub(super) out: TakeOut,
    /// Where the validation layers are on.
    pub(super) checks: Option<Checks>,
    pub(super) pacer: Pacer,
    pub(super) order: Order,
    /// Steps that were asked for one by one.
    pub(super) single_steps: u32,
    /// What had grown before.
    pub(super) back: Back,
    /// What the hands have on the device.
    pub(super) edits: Edits,
    /// Food that was changed and is not there yet.
    pub(super) feeder: Feeder,
    /// The user wants to leave.
    pub closing: bool,
    /// Pictures of the scene until the lab closes by itself.
    pub(super) frames_left: Option<u32>,
    /// Pictures until the device is taken for lost, of those while something goes on; then of the one that takes its place,
    /// and so on.
    pub(super) lose_device: VecDeque<u32>,
    /// A device was lost.
    pub(super) lost: Option<Lost>,
    /// When the picture last moved.
    pub(super) moved: Instant,
    /// What the validation layers said, counted.
    pub(super) message_count: usize,
    /// The format of pictures.
    pub(super) format: Format,
    /// Where layouts are kept that take long to make.
    pub(super) atlases: Option<PathBuf>,
    pub(super) preferences: Option<PathBuf>,
    /// What was kept when the window opened.
    pub(super) opened_with: Preferences,
    pub(super) places: Option<Places>,
    /// The scene that is shown or, before there is one, on its way: its name, and where its paths begin.
    pub(super) name: String,
    pub(super) folder: PathBuf,
    /// Where it is saved again.
    pub(super) file: Option<SceneFile>,
    pub(super) ctx: Arc<Context>,
    pub host: Host,
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
        let tells = options.windowless || places.is_some();
        let places = tells.then(|| Places::new(places, context));
        host.set_max_texture_side(ctx.info().max_image_side as usize);
        let mut interface = Interface::new(scene);
        interface.layout.panel = preferences.panel;
        interface.layout.panel_width = preferences.panel_width;
        interface.layout.light = preferences.light;
        interface.out = preferences.out.clone();
        interface.gallery.recent = preferences.recent.clone();
        interface.looks.own = OwnPresets::read(OwnPresets::folder());
        interface.looks.find_preset(&mut interface.document);
        interface.gallery.left = LeftScenes::read(left_folder());
        let file = opened.from.as_ref().map(|(path, _)| path.as_path());
        let folder = file.map_or(Some(scene.folder.as_path()), Path::parent);
        interface.opening.begin_in(folder.unwrap_or(Path::new("")));
        interface.opening.count_from(&scene.folder);
        let clocks = Clocks::new(&ctx, &mut frames);
        host.request_redraw();
        let mut lab = Self {
            gui,
            stage: None,
            loading: None,
            front,
            under_way: None,
            left: Vec::new(),
            frames,
            answers,
            interface,
            clocks,
            out: TakeOut::new(options.interrupt),
            checks: options.validation.then(Checks::new),
            pacer: Pacer::default(),
            order: Order::default(),
            single_steps: 0,
            back: Back::default(),
            edits: Edits::default(),
            feeder: Feeder::default(),
            closing: false,
            frames_left: options.frames,
            lose_device: options.lose_device.iter().copied().collect(),
            lost: None,
            moved: host.now(),
            message_count: 0,
            format,
            atlases: options.atlases.clone(),
            preferences: options.preferences.clone(),
            opened_with: preferences,
            places,
            name: scene.name.clone(),
            folder: scene.folder.clone(),
            file: None,
            ctx,
            host,
        };
        lab.load(lab.name.clone(), Origin::File, move || Ok(opened));
        Ok(lab)
    }

    /// An event of the system that the interface may want. Does the window have to be drawn again?
    pub fn take_in(&mut self, event: &WindowEvent) -> bool {
        // At once: egui may take its time, as with what others have copied. What fails is told by the frame that follows.
        let is_frame = matches!(event, WindowEvent::RedrawRequested);
        let is_stirred = !is_frame && self.stir_places().unwrap_or(true);
        self.host.take_in(event) || is_stirred
    }

    /// The window has another size, in pixels.
    pub fn resize(&mut self, size: [u32; 2]) {
        self.front.resize(size);
        self.host.request_redraw();
    }

    /// One frame: interface, steps, picture, screen. Says when the next one is due; `None` waits for an event.
    pub fn frame(&mut self) -> Result<Option<Instant>> {
        if self.go_on()? {
            return Ok(Some(self.host.now()));
        }
        self.stir_places()?;
        let since_last = self.host.pace(self.clocks.tick());
        if self.left.is_empty() && self.loading.is_none() {
            self.interface.notices.end_drop();
        }
        if self.closing {
            self.begin_to_end();
        } else {
            self.do_what_was_left()?;
            self.take_loaded()?;
            // What had to wait for that: nobody acts on what is in between.
            self.do_what_was_left()?;
        }
        self.clocks.facts.loading = self.loading.as_ref().map(Loading::told);
        self.take_food(&self.host.context().clone())?;
        self.make(&self.host.context().clone())?;
        self.clocks.facts.out = self.out.told();
        self.clocks.facts.full_screen = self.host.is_full_screen();
        let mut seen = self.run_interface()?;
        let place = seen.picture;
        let mut commands = std::mem::take(&mut seen.shown.commands);
        // Whoever leaves begins nothing more.
        let ends =
            |command: &Command| [Command::TakeOut(Out::Cancel), Command::Quit].contains(command);
        commands.retain(|command| !self.closing || ends(command));
        let mut commands = commands.into_iter();
        while let Some(command) = commands.next() {
            if let Err(error) = self.obey(&seen.context, command, place.size) {
                // What was asked for after it may still be done with another device.
                self.left
                    .extend(commands.map(|command| Left::Command(command, place.size)));
                return Err(error);
            }
        }
        self.look_under_hand(place.size);
        let view = self.present_view(since_last);

        let runs = self.runs();
        let is_cpu = self.ctx.info().kind == DeviceKind::Cpu;
        let asked = Asked {
            is_asked: seen.is_asked,
            touched: seen.shown.touched,
        };
        let task = self.task(since_last, is_cpu && !place.is_empty(), asked);
        let mut rec = self.frames.begin()?;
        let image = if task.only_steps {
            None
        } else {
            let image = self.front.acquire()?;
            if image.is_none() {
                // Nothing was recorded, and no step that was asked for is lost.
                self.single_steps += if runs { 0 } else { task.steps };
                self.forget_places();
                return Ok(Some(self.host.now() + HIDDEN_INTERVAL));
            }
            image
        };
        if task.steps > 0 || seen.shown.touched || self.out.holds() {
            self.moved = self.host.now();
        }
        let is_moving = self.host.now() < self.moved + SETTLES_AFTER;
        self.record_hands(&mut rec, &seen.context)?;
        self.record_export(&mut rec, &seen.context);
        // What is taken out may wait for what this frame copies.
        let in_slices = task.only_steps && self.pacer.are_long(task.steps) && !self.out.is_busy();
        if in_slices {
            rec.slice(LONGEST_SLICE, self.frames.timings());
        }
        if let Some(stage) = &mut self.stage {
            for _ in 0..task.steps {
                rec.scope("step", |rec| stage.simulation.record_step(rec));
            }
        }
        if in_slices {
            self.set_out(rec, task.steps, &seen);
            return Ok(Some(self.host.now()));
        }
        if let Some(image) = image {
            let shot = Shot {
                view,
                answers: task.answers,
                is_between: false,
                picture: place,
                beside: seen.beside,
                is_moving,
                primitives: &seen.primitives,
                pixels_per_point: seen.pixels_per_point,
            };
            self.draw(rec, image, &shot)?;
        } else {
            self.frames.submit(rec)?;
        }
        if is_cpu {
            // What the hand does meanwhile belongs into the next frame, which therefore does not begin before.
            self.frames.wait_idle()?;
        }
        self.have_stepped(task.steps)?;
        if self.stage.is_some() && !task.only_steps {
            self.count_picture();
        }
        self.report_messages();
        let next = self.next_frame(is_moving, seen.repaint);
        if task.only_steps {
            self.forget_places();
        } else {
            let rests = next.is_none_or(|next| next > self.host.now() + RESTS_FOR);
            self.tell_places(&seen.context, seen.pixels_per_point, rests)?;
        }
        Ok(next)
    }

    /// So many steps have been submitted.
    pub(super) fn have_stepped(&mut self, steps: u32) -> Result<()> {
        let Some(stage) = &self.stage else {
            return Ok(());
        };
        self.clocks
            .submitted(steps, &self.ctx, &self.frames, stage, &mut self.pacer);
        self.check()
    }

    /// Counts down to what was asked for after so many pictures.
    fn count_picture(&mut self) {
        if let Some(left) = &mut self.frames_left {
            *left = left.saturating_sub(1);
            self.closing |= *left == 0;
        }
        // Not while the hand of a test prepares something.
        let goes_on = self.runs() || self.out.is_busy();
        if let Some(left) = self.lose_device.front_mut().filter(|_| goes_on) {
            *left = left.saturating_sub(1);
            if *left == 0 {
                self.lose_device.pop_front();
                self.ctx.pretend_lost();
            }
        }
    }

    /// When the next frame is due; `None` waits for an event.
    fn next_frame(&self, is_moving: bool, repaint: Option<Duration>) -> Option<Instant> {
        let now = self.host.now();
        if self.runs() || self.single_steps > 0 || self.out.is_busy() {
            return Some(now);
        }
        let settles = is_moving.then(|| self.moved + SETTLES_AFTER);
        let waits = self.loading.is_some() || self.feeder.is_busy() || !self.left.is_empty();
        let loading = waits.then(|| now + LOADING_INTERVAL);
        let repaint = repaint.and_then(|delay| now.checked_add(delay));
        [settles, loading, repaint].into_iter().flatten().min()
    }

    /// Does the simulation go on by itself? Where it would take the processors that are needed to load, it waits.
    pub(super) fn runs(&self) -> bool {
        let waits = self.loading.is_some() && self.ctx.info().kind == DeviceKind::Cpu;
        let goes_on = self.interface.document.playing && !self.closing;
        self.stage.is_some() && goes_on && !waits && !self.out.holds()
    }

    /// What this frame does; where it `can_split`, steps, answers and pictures have frames of their own.
    fn task(&mut self, since_last: Duration, can_split: bool, asked: Asked) -> Task {
        if self.runs() {
            let cap = self.interface.document.running.time.steps_per_second;
            return (self.order).next(&mut self.pacer, can_split, since_last, cap, asked);
        }
        self.order.rest();
        self.pacer.restart();
        let steps = if self.out.holds() {
            0
        } else {
            std::mem::take(&mut self.single_steps)
        };
        Task {
            steps,
            // The window shows them in the frame after.
            only_steps: can_split && self.pacer.are_long(steps),
            ..Task::default()
        }
    }

    /// The view with the exposure's pace for a frame of this length.
    fn present_view(&self, since_last: Duration) -> View {
        let mut view = self.interface.document.view;
        if let Exposure::Auto { adaptation, .. } = &mut view.exposure {
            *adaptation = 1.0 - (-EXPOSURE_SPEED * since_last.as_secs_f32()).exp();
            // It is the film's, which goes by pictures and not by the clock.
            if self.out.holds() {
                *adaptation = 0.0;
            }
        }
        view
    }

    /// Checks the invariants, if that is due, and tells the panel.
    fn check(&mut self) -> Result<()> {
        let (Some(checks), Some(stage)) = (&mut self.checks, &self.stage) else {
            return Ok(());
        };
        if checks.look(&mut self.frames, &stage.simulation)? {
            self.clocks.facts.check.clone_from(&checks.last);
            self.host.request_redraw();
            if let Some(problem) = checks.problem() {
                log::error!("{problem}");
            }
        }
        Ok(())
    }

    /// Passes on what the validation layers say.
    pub(super) fn report_messages(&mut self) {
        self.tell_messages(&self.ctx.take_messages());
        let told = self.ctx.debug_entries();
        if !told.entries.is_empty() || told.overflow > 0 {
            log::warn!("told by debug_value:\n{told}");
        }
    }

    /// Passes on messages of the validation layers.
    pub(super) fn tell_messages(&mut self, messages: &[String]) {
        self.message_count += messages.len();
        log_messages(messages);
    }

    /// Keeps what is the same in every scene for the next time.
    pub(super) fn keep_preferences(&self) {
        let Some(file) = &self.preferences else {
            return;
        };
        let preferences = Preferences {
            light: self.interface.layout.light,
            panel: self.interface.layout.panel,
            panel_width: self.interface.layout.panel_width,
            zoom: self.host.context().zoom_factor(),
            recent: self.interface.gallery.recent.clone(),
            out: self.interface.out.kept(),
            // The whole screen is not the size of a window.
            size: match self.host.is_full_screen() {
                true => Preferences::read(file).size,
                false => self.host.size(),
            },
        };
        let preferences = preferences.over(&self.opened_with, &Preferences::read(file));
        if let Err(error) = preferences.write(file) {
            log::warn!("preferences are not kept in {}: {error}", file.shown());
        }
    }

    /// Ends everything, and keeps what is to be kept. What was found to be wrong on the way is an error.
    pub fn close(mut self) -> Result<()> {
        self.obey_what_writes();
        // What was not begun of a step is left.
        self.under_way = None;
        let _ = self.frames.wait_idle();
        self.end_taking_out();
        self.feeder.close();
        self.report_messages();
        self.tell_left();
        self.keep_preferences();
        if let Some(problem) = self.checks.as_ref().and_then(Checks::problem) {
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

/// Of the window that shows a scene.
pub fn title(scene: &str) -> String {
    format!("{scene} - myxo")
}
