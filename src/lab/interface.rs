//! What is round the picture: the panel with every parameter, the line of facts, the help; and what they ask for.
//!
//! The interface changes its own settings and view at once and asks the window for the rest by [`Command`]s, so it
//! runs without a window and without a device, as its tests do.

use egui::{Rect, Sense, Ui};
use glam::{Vec2, Vec3};
use myxo::render::Camera;
use myxo::render::exposure::Exposure;
use myxo::render::view::{self, AtlasWindow, View};
use myxo::scene::Scene;
use myxo::scene::parameters::{OBJECT_PARAMETERS, PARAMETERS};
use myxo::scene::settings::{Settings, Show};
use myxo::sim::types::Flow;

use super::checks::Check;
use super::history::History;
use super::keys::{self, KeyAction};
use super::navigation::Navigation;
use super::theme;

/// Something that the window must do.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Settings changed that the running simulation can take over.
    Apply,
    /// Begin again at step 0, with the settings as they are edited.
    Restart,
    /// Take one step.
    Step,
    /// Write the picture to a file.
    Screenshot,
    /// Put the surface point that this pixel of the picture shows in its middle.
    Refocus(Vec2),
    /// Put the scene with its settings and camera into the clipboard.
    Copy,
    /// Close the window.
    Quit,
    /// Take over a scene from the clipboard.
    Paste(String),
}

/// One kernel's time.
#[derive(Clone, Debug, PartialEq)]
pub struct KernelTime {
    /// As the shader is called.
    pub name: String,
    /// Dispatches in a step.
    pub per_step: f64,
    /// Mean time in a step, milliseconds.
    pub mean_ms: f64,
    /// 95 % are not longer.
    pub p95_ms: f64,
    /// Of the step's time, 0 to 1.
    pub share: f64,
}

/// What the interface shows and cannot change.
#[derive(Clone, Debug, Default)]
pub struct Facts {
    /// The scene's name.
    pub scene: String,
    /// Steps taken.
    pub step: u64,
    /// Seconds of the objects' motion, if any moves.
    pub seconds: Option<f64>,
    /// Steps a second, lately.
    pub steps_per_second: f64,
    /// Pictures a second, lately.
    pub frames_per_second: f64,
    /// GPU time of a step; `None` where the device has no timestamps.
    pub step_ms: Option<f64>,
    /// GPU time of each kernel.
    pub kernels: Vec<KernelTime>,
    /// The same for the last pictures, one by one.
    pub history: History,
    /// The device's name and driver.
    pub device: String,
    /// Device memory that the program has taken, bytes.
    pub memory: u64,
    /// Particles that the picture shows, in the view of particles.
    pub particles_drawn: u32,
    /// Transfers between objects.
    pub flow: Flow,
    /// What the last check of the invariants has found, where they are checked.
    pub check: Option<Check>,
    /// Triangles of all objects.
    pub triangles: usize,
    /// Texels that triangles own.
    pub texels: usize,
}

/// A line that stays for a while.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Notice {
    pub(super) text: String,
    pub(super) is_error: bool,
    pub(super) until: f64,
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
    outline: (Vec3, Vec<Vec3>),
    /// The camera of the last fit and its picture's size; while nobody moves it, it keeps fitting.
    fitted: Option<(Camera, Vec2)>,
    /// Hand and flights.
    pub navigation: Navigation,
    pub(super) panel: bool,
    pub(super) help: bool,
    pub(super) filter: String,
    pub(super) notice: Option<Notice>,
}

/// What one frame of the interface came to.
#[derive(Clone, Debug)]
pub struct Shown {
    /// What the window must do, in order.
    pub commands: Vec<Command>,
    /// Where the picture goes, in points.
    pub picture: Rect,
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
            navigation: Navigation::default(),
            panel: true,
            help: false,
            filter: String::new(),
            notice: None,
        };
        interface.open(scene);
        interface
    }

    /// Another scene has been loaded: its settings and its view.
    pub fn open(&mut self, scene: &Scene) {
        self.loaded = scene.settings.clone();
        self.view = View::of(scene, Vec2::ONE);
        if matches!(self.view.exposure, Exposure::Auto { .. }) {
            self.view.exposure = Exposure::following();
        }
        // Only the first frame knows the size of the picture.
        let is_free = scene.settings.camera.distance <= 0.0;
        self.fitted = is_free.then_some((self.view.camera, Vec2::ZERO));
        self.restarted(scene);
    }

    /// The scene runs from step 0, with its settings.
    pub fn restarted(&mut self, scene: &Scene) {
        self.running = scene.settings.clone();
        self.edited = scene.settings.clone();
        self.outline = (scene.center, view::points(scene).collect());
    }

    /// Shows a line for a while.
    pub fn notice(&mut self, ctx: &egui::Context, text: impl Into<String>, is_error: bool) {
        let text = text.into();
        let seconds = 3.0 + 0.05 * text.len() as f64;
        self.notice = Some(Notice {
            text,
            is_error,
            until: ctx.input(|i| i.time) + if is_error { 3.0 * seconds } else { seconds },
        });
    }

    /// Shows everything for one frame.
    pub fn show(&mut self, ui: &mut Ui, facts: &Facts) -> Shown {
        let mut commands = Vec::new();
        self.handle_keys(ui.ctx(), &mut commands);
        self.handle_clipboard(ui.ctx(), &mut commands);
        self.status_line(ui, facts);
        if self.panel {
            egui::Panel::left("panel")
                .exact_size(PANEL_WIDTH)
                .resizable(false)
                .show_separator_line(false)
                .frame(theme::panel_frame())
                .show(ui, |ui| self.panel(ui, facts, &mut commands));
        }
        let picture = ui.available_rect_before_wrap();
        self.keep_fitting(Vec2::new(picture.width(), picture.height()));
        let response = ui.allocate_rect(picture, Sense::click_and_drag());
        let moved = self.navigation.apply(ui, &response, &mut self.view);
        if let Some(pixel) = moved.refocus {
            commands.push(Command::Refocus(pixel));
        }
        if self.help {
            self.show_help(ui.ctx(), picture);
        }
        self.show_notice(ui, picture);
        Shown {
            commands,
            picture,
            touched: moved.touched || response.dragged(),
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
            let (Some(running), Some(edited)) =
                (self.running.objects.get(i), self.edited.objects.get(i))
            else {
                continue;
            };
            for parameter in OBJECT_PARAMETERS {
                if !parameter.restarts(running, edited) {
                    parameter.copy(edited, live);
                }
            }
        }
        live
    }

    /// Are there edits that wait for a restart?
    pub fn is_pending(&self) -> bool {
        PARAMETERS
            .iter()
            .any(|p| p.restarts(&self.running, &self.edited))
            || self.running.objects != self.edited.objects
    }

    fn handle_keys(&mut self, ctx: &egui::Context, commands: &mut Vec<Command>) {
        for action in keys::pressed(ctx) {
            match action {
                KeyAction::Pause => self.playing = !self.playing,
                KeyAction::SingleStep => {
                    self.playing = false;
                    commands.push(Command::Step);
                }
                KeyAction::Reset => commands.push(Command::Restart),
                KeyAction::ShowSurface => self.view.show = Show::Surface,
                KeyAction::ShowParticles => self.view.show = Show::Particles,
                KeyAction::ShowAtlas => self.view.show = Show::Atlas,
                KeyAction::NextCharts => self.view.charts = next_charts(self.view.charts),
                KeyAction::NextColors => self.view.color_map = self.view.color_map.next(),
                KeyAction::Fit => self.fit(),
                KeyAction::Screenshot => commands.push(Command::Screenshot),
                KeyAction::Panel => self.panel = !self.panel,
                KeyAction::Help => self.help = !self.help,
                KeyAction::Quit => commands.push(Command::Quit),
            }
        }
        if self.help && ctx.input(|i| i.key_pressed(egui::Key::Escape)) {
            self.help = false;
        }
    }

    fn handle_clipboard(&mut self, ctx: &egui::Context, commands: &mut Vec<Command>) {
        if ctx.text_edit_focused() {
            return;
        }
        ctx.input(|input| {
            for event in &input.events {
                match event {
                    egui::Event::Copy => commands.push(Command::Copy),
                    egui::Event::Paste(text) => commands.push(Command::Paste(text.clone())),
                    _ => {}
                }
            }
        });
    }

    /// Looks at the whole scene, or at the whole atlas.
    pub(super) fn fit(&mut self) {
        if self.view.show == Show::Atlas {
            self.view.atlas = AtlasWindow::default();
        } else {
            self.view.camera.target = self.outline.0;
            self.fitted = Some((self.view.camera, Vec2::ZERO));
        }
    }

    /// Fits the scene into a picture of another size, if the camera still is where the last fit has put it.
    fn keep_fitting(&mut self, size: Vec2) {
        let camera = &mut self.view.camera;
        if self
            .fitted
            .is_some_and(|(fitted, fitted_size)| fitted == *camera && fitted_size != size)
        {
            camera.fit_points(self.outline.1.iter().copied(), size);
            self.fitted = Some((*camera, size));
        }
    }
}

/// Nothing, under the trail, nothing else, and so on.
fn next_charts(charts: f32) -> f32 {
    match charts {
        charts if charts < 0.5 => 0.5,
        charts if charts < 1.0 => 1.0,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests;
