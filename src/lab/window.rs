//! The window and its frames: what happens, in order, from an event to a picture on the screen.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::Vec2;
use myxo::gpu::{
    Context, ContextOptions, DepthTest, DeviceKind, Format, Frames, Swapchain, Targets,
};
use myxo::render::View;
use myxo::render::exposure::Exposure;
use myxo::render::gui::Gui;
use myxo::scene::Scene;
use myxo::scene::file::Reader;
use myxo::scene::settings::Settings;
use myxo::{Error, Result};
use raw_window_handle::{HasDisplayHandle, HasWindowHandle};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::window::{Window, WindowId};

use super::LabOptions;
use super::checks::Checks;
use super::clocks::Clocks;
use super::interface::{Command, Interface};
use super::loading::Loading;
use super::pacing::Pacer;
use super::place::Place;
use super::stage::{Stage, save_screenshot};
use super::theme;

/// A picture counts as moving for this long after it last moved; then it may be drawn with all care.
const SETTLES_AFTER: Duration = Duration::from_millis(250);
/// How quickly the exposure follows the trail: a second leaves `exp(-this)` of the difference.
const EXPOSURE_SPEED: f32 = 3.0;
/// How often a window without a size is looked at again.
const HIDDEN_INTERVAL: Duration = Duration::from_millis(100);

/// What winit calls.
pub struct App {
    options: LabOptions,
    scene: Option<Scene>,
    lab: Option<Lab>,
    /// When to draw next, if nothing happens before.
    wake: Option<Instant>,
    /// What ended the lab, if not the user.
    pub error: Option<Error>,
}

impl App {
    /// An app that opens its window when the event loop runs.
    pub fn new(scene: Scene, options: LabOptions) -> Self {
        Self {
            options,
            scene: Some(scene),
            lab: None,
            wake: None,
            error: None,
        }
    }

    fn fail(&mut self, events: &ActiveEventLoop, error: Error) {
        self.error = Some(error);
        events.exit();
    }
}

impl ApplicationHandler for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        let Some(scene) = self.scene.take() else {
            return;
        };
        match Lab::open(events, scene, &self.options) {
            Ok(lab) => self.lab = Some(lab),
            Err(error) => self.fail(events, error),
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(lab) = &mut self.lab else {
            return;
        };
        let response = lab.egui.on_window_event(&lab.window, &event);
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::Resized(size) => {
                lab.swapchain.resize(size.into());
                lab.window.request_redraw();
            }
            WindowEvent::DroppedFile(path) => lab.open_file(&path),
            WindowEvent::RedrawRequested => match lab.frame() {
                Ok(_) if lab.closing => events.exit(),
                Ok(next) => self.wake = next,
                Err(error) => self.fail(events, error),
            },
            _ if response.repaint => lab.window.request_redraw(),
            _ => {}
        }
    }

    fn new_events(&mut self, _: &ActiveEventLoop, cause: StartCause) {
        if let (StartCause::ResumeTimeReached { .. }, Some(lab)) = (cause, &self.lab) {
            lab.window.request_redraw();
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        events.set_control_flow(match self.wake {
            Some(wake) if wake <= Instant::now() => {
                if let Some(lab) = &self.lab {
                    lab.window.request_redraw();
                }
                ControlFlow::Wait
            }
            Some(wake) => ControlFlow::WaitUntil(wake),
            None => ControlFlow::Wait,
        });
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        if let Some(mut lab) = self.lab.take() {
            let _ = lab.frames.wait_idle();
            lab.report_messages();
            let problem = lab.checks.as_ref().and_then(Checks::problem);
            if let (Some(problem), None) = (problem, &self.error) {
                let text = format!("{problem}; this is a bug in myxo");
                self.error = Some(Error::Invalid(text));
            }
            if lab.message_count > 0 && self.error.is_none() {
                let count = lab.message_count;
                let text = format!(
                    "the validation layers said {count} things, listed above: please report them"
                );
                self.error = Some(Error::Invalid(text));
            }
        }
    }
}

/// Everything behind an open window. Fields are dropped in this order: what lies on the device before the device,
/// and the window last.
struct Lab {
    gui: Gui,
    stage: Stage,
    swapchain: Swapchain,
    frames: Frames,
    interface: Interface,
    egui: egui_winit::State,
    clocks: Clocks,
    /// Where the validation layers are on.
    checks: Option<Checks>,
    pacer: Pacer,
    /// Steps that were asked for one by one.
    single_steps: u32,
    /// The user wants to leave.
    closing: bool,
    /// Pictures until the lab closes by itself.
    frames_left: Option<u32>,
    /// When the picture last moved.
    moved: Instant,
    /// What the validation layers said, counted.
    message_count: usize,
    ctx: Arc<Context>,
    window: Arc<Window>,
}

impl Lab {
    fn open(events: &ActiveEventLoop, scene: Scene, options: &LabOptions) -> Result<Self> {
        let size = PhysicalSize::new(options.size[0], options.size[1]);
        let attributes = Window::default_attributes()
            .with_title(title(&scene))
            .with_inner_size(size)
            .with_min_inner_size(PhysicalSize::new(480, 320));
        let window = events
            .create_window(attributes)
            .map_err(|source| no_window(&source))?;
        let window = Arc::new(window);
        let display = window
            .display_handle()
            .map_err(|source| no_window(&source))?
            .as_raw();
        let handle = window
            .window_handle()
            .map_err(|source| no_window(&source))?
            .as_raw();
        let ctx = Context::new(&ContextOptions {
            device: options.device.clone(),
            validation: options.validation,
            window: Some(display),
            cache_folder: myxo::gpu::default_cache_folder(),
            ..ContextOptions::default()
        })?;
        let size: [u32; 2] = window.inner_size().into();
        let mut swapchain = Swapchain::new(&ctx, display, handle, size, true)?;
        // A device that is the CPU gains nothing from working ahead, and the hand would feel the delay.
        let in_flight = if ctx.info().kind == DeviceKind::Cpu {
            1
        } else {
            2
        };
        let mut frames = Frames::new(&ctx, in_flight)?;
        let format = swapchain.format().unwrap_or(Format::Bgra8);
        let mut gui = Gui::new(&ctx, format, in_flight)?;
        let context = egui::Context::default();
        theme::apply(&context);
        let mut egui = egui_winit::State::new(
            context,
            egui::ViewportId::ROOT,
            window.as_ref(),
            Some(window.scale_factor() as f32),
            None,
            Some(ctx.info().max_image_side as usize),
        );
        let name = scene.name.clone();
        let mut loading = Loading {
            name: &name,
            window: &window,
            egui: &mut egui,
            gui: &mut gui,
            swapchain: &mut swapchain,
            frames: &mut frames,
        };
        let stage = Stage::new(
            &ctx,
            scene,
            picture_format(format),
            options.atlases.clone(),
            &mut |doing, done| loading.show(doing, done),
        )?;
        let interface = Interface::new(&stage.scene);
        let mut clocks = Clocks::new(&ctx, &mut frames);
        clocks.restart(&mut frames, &stage);
        window.request_redraw();
        Ok(Self {
            gui,
            stage,
            swapchain,
            frames,
            interface,
            egui,
            clocks,
            checks: options.validation.then(Checks::new),
            pacer: Pacer::default(),
            single_steps: 0,
            closing: false,
            frames_left: options.frames,
            moved: Instant::now(),
            message_count: 0,
            ctx,
            window,
        })
    }

    /// One frame: interface, steps, picture, screen. Says when the next one is due; `None` waits for an event.
    fn frame(&mut self) -> Result<Option<Instant>> {
        let since_last = self.clocks.tick();
        let input = self.egui.take_egui_input(&self.window);
        let context = self.egui.egui_ctx().clone();
        let mut shown = None;
        let output = context.run_ui(input, |ui| {
            shown = Some(self.interface.show(ui, &self.clocks.facts))
        });
        self.egui
            .handle_platform_output(&self.window, output.platform_output);
        self.gui.update_textures(output.textures_delta)?;
        let primitives = context.tessellate(output.shapes, output.pixels_per_point);
        let repaint = output
            .viewport_output
            .get(&egui::ViewportId::ROOT)
            .map(|viewport| viewport.repaint_delay);
        let Some(shown) = shown else {
            return Ok(None);
        };
        let place = Place::of(
            shown.picture,
            output.pixels_per_point,
            self.window.inner_size().into(),
        );
        for command in shown.commands {
            self.obey(&context, command, place.size)?;
        }
        let view = self.present_view(since_last);

        // The image first: without one nothing is recorded, and no step is lost.
        let mut rec = self.frames.begin()?;
        let Some(image) = self.swapchain.acquire()? else {
            return Ok(Some(Instant::now() + HIDDEN_INTERVAL));
        };
        let steps = self.steps(since_last, shown.touched);
        for _ in 0..steps {
            rec.scope("step", |rec| self.stage.simulation.record_step(rec));
        }
        if steps > 0 || shown.touched {
            self.moved = Instant::now();
        }
        let is_moving = self.moved.elapsed() < SETTLES_AFTER;
        let target = self.swapchain.image(&image);
        if !place.is_empty() {
            let picture = self.stage.draw(&mut rec, &view, place.size, is_moving)?;
            rec.copy_image_to(picture, target, place.corner);
        }
        let over = Targets {
            color: target,
            resolve: None,
            depth: None,
            depth_test: DepthTest::Greatest,
            clear: None,
        };
        let gui = &mut self.gui;
        rec.pass("interface", &over, |pass| {
            gui.draw(pass, target.size(), output.pixels_per_point, &primitives)
        })?;
        self.swapchain.present(&mut self.frames, rec, image)?;
        self.clocks
            .shown(steps, &self.ctx, &self.frames, &self.stage, &mut self.pacer);
        self.check()?;
        self.report_messages();
        if let Some(left) = &mut self.frames_left {
            *left = left.saturating_sub(1);
            self.closing |= *left == 0;
        }

        let now = Instant::now();
        if self.interface.playing || self.single_steps > 0 {
            return Ok(Some(now));
        }
        let settles = is_moving.then(|| self.moved + SETTLES_AFTER);
        let repaint = repaint.and_then(|delay| now.checked_add(delay));
        Ok([settles, repaint].into_iter().flatten().min())
    }

    /// How many steps this frame takes.
    fn steps(&mut self, since_last: Duration, touched: bool) -> u32 {
        if self.interface.playing {
            let cap = self.interface.running.time.steps_per_second;
            return self.pacer.steps(since_last, cap, touched);
        }
        self.pacer.restart();
        std::mem::take(&mut self.single_steps)
    }

    /// The view with the exposure's pace for a frame of this length.
    fn present_view(&self, since_last: Duration) -> View {
        let mut view = self.interface.view;
        if let Exposure::Auto { adaptation, .. } = &mut view.exposure {
            *adaptation = 1.0 - (-EXPOSURE_SPEED * since_last.as_secs_f32()).exp();
        }
        view
    }

    fn obey(
        &mut self,
        context: &egui::Context,
        command: Command,
        picture_size: [u32; 2],
    ) -> Result<()> {
        match command {
            Command::Apply => {
                let live = self.interface.live_settings();
                match self.stage.simulation.apply(&live) {
                    Ok(()) => self.interface.running = live,
                    Err(error) => self.interface.notice(context, error.to_string(), true),
                }
            }
            Command::Restart => {
                let settings = self.interface.edited.clone();
                let name = self.stage.scene.name.clone();
                let (stage, mut loading) = self.loading(&name);
                let result = stage.restart(&settings, &mut |doing, done| loading.show(doing, done));
                self.restarted(context, result, false);
            }
            Command::Step => self.single_steps += 1,
            Command::Screenshot => {
                let picture =
                    self.stage
                        .photograph(&mut self.frames, &self.interface.view, picture_size)?;
                match save_screenshot(Path::new(""), &picture) {
                    Ok(path) => {
                        self.interface
                            .notice(context, format!("Saved {}", path.display()), false)
                    }
                    Err(error) => self.interface.notice(context, error.to_string(), true),
                }
            }
            Command::Refocus(pixel) => {
                let size = Vec2::new(picture_size[0] as f32, picture_size[1] as f32);
                if let Some(hit) = self.stage.pick(&self.interface.view, pixel, size) {
                    let Interface {
                        navigation, view, ..
                    } = &mut self.interface;
                    navigation.fly_to(hit.position, view);
                }
            }
            Command::Copy => {
                context.copy_text(self.scene_text());
                self.interface
                    .notice(context, "The scene is in the clipboard", false);
            }
            Command::Quit => self.closing = true,
            Command::Paste(text) => match read_scene(&text, &self.stage.scene) {
                Ok(scene) => self.open_scene(context, scene),
                Err(error) => self.interface.notice(context, error.to_string(), true),
            },
        }
        Ok(())
    }

    /// The scene as it is edited and looked at, as a scene file.
    fn scene_text(&self) -> String {
        let mut scene = self.stage.scene.clone();
        scene.settings = self.interface.edited.clone();
        let view = &self.interface.view;
        scene.settings.camera = view.camera.to_settings(scene.center);
        scene.settings.picture.show = view.show;
        scene.settings.picture.color_map = view.color_map;
        scene.settings.picture.charts = view.charts;
        scene.settings.picture.particle_size = view.particle_size;
        scene.settings.picture.brightest = match view.exposure {
            Exposure::Fixed(brightest) => brightest,
            Exposure::Auto { .. } => 0.0,
        };
        scene.to_toml()
    }

    /// A file that was dropped on the window: a scene or a model.
    fn open_file(&mut self, path: &Path) {
        let context = self.egui.egui_ctx().clone();
        match Scene::load(path, &myxo::scene::Overrides::default()) {
            Ok(scene) => self.open_scene(&context, scene),
            Err(error) => self.interface.notice(&context, error.to_string(), true),
        }
        self.window.request_redraw();
    }

    fn open_scene(&mut self, context: &egui::Context, scene: Scene) {
        self.window.set_title(&title(&scene));
        let name = scene.name.clone();
        let (stage, mut loading) = self.loading(&name);
        let result = stage.show(scene, &mut |doing, done| loading.show(doing, done));
        self.restarted(context, result, true);
    }

    /// The stage, and what shows that it is being set.
    fn loading<'a>(&'a mut self, name: &'a str) -> (&'a mut Stage, Loading<'a>) {
        let loading = Loading {
            name,
            window: &self.window,
            egui: &mut self.egui,
            gui: &mut self.gui,
            swapchain: &mut self.swapchain,
            frames: &mut self.frames,
        };
        (&mut self.stage, loading)
    }

    /// After a restart, or after one that failed.
    fn restarted(&mut self, context: &egui::Context, result: Result<()>, is_new_scene: bool) {
        if let Err(error) = result {
            self.interface.notice(context, error.to_string(), true);
            return;
        }
        let scene = &self.stage.scene;
        if is_new_scene {
            self.interface.open(scene);
        } else {
            self.interface.restarted(scene);
        }
        self.clocks.restart(&mut self.frames, &self.stage);
        if let Some(checks) = &mut self.checks {
            checks.restart();
        }
        self.pacer.restart();
        self.moved = Instant::now();
    }

    /// Checks the invariants, if that is due, and tells the panel.
    fn check(&mut self) -> Result<()> {
        let Some(checks) = &mut self.checks else {
            return Ok(());
        };
        if checks.look(&mut self.frames, &self.stage.simulation)? {
            self.clocks.facts.check.clone_from(&checks.last);
            self.window.request_redraw();
            if let Some(problem) = checks.problem() {
                log::error!("{problem}");
            }
        }
        Ok(())
    }

    /// Passes on what the validation layers say.
    fn report_messages(&mut self) {
        for message in self.ctx.take_messages() {
            self.message_count += 1;
            log::error!("validation: {message}");
        }
        let told = self.ctx.debug_entries();
        if !told.entries.is_empty() || told.overflow > 0 {
            log::warn!("told by debug_value:\n{told}");
        }
    }
}

fn title(scene: &Scene) -> String {
    format!("{} - myxo", scene.name)
}

/// The sRGB format with the same bytes: the picture is drawn in it, and its bytes are copied as they are.
fn picture_format(window: Format) -> Format {
    match window {
        Format::Rgba8 | Format::Rgba8Srgb => Format::Rgba8Srgb,
        _ => Format::Bgra8Srgb,
    }
}

/// A scene from text, such as the clipboard's.
fn read_scene(text: &str, like: &Scene) -> Result<Scene> {
    let mut reader = Reader::new(Settings::default());
    reader.text("clipboard", text);
    let settings = reader
        .finish()
        .map_err(|problems| myxo::scene::SceneError::Problems {
            scene: "clipboard".into(),
            problems,
        })?;
    Ok(Scene::from_settings(
        like.name.clone(),
        settings,
        like.folder.clone(),
    )?)
}

/// What to do where no window opens. The system's reason comes without winit's place in its own source.
pub fn no_window(source: &dyn std::fmt::Display) -> Error {
    let text = source.to_string();
    let reason = text
        .split_once(".rs:")
        .and_then(|(_, rest)| rest.split_once(": "));
    let reason = reason
        .map_or(text.as_str(), |(_, reason)| reason)
        .trim_end_matches('.');
    Error::Invalid(format!(
        "no window can be opened ({reason}): where there is no display, `myxo render` draws without one"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_display_is_said_without_a_place_in_somebody_elses_source() {
        let winit =
            "os error at /home/me/.cargo/winit-0.30/src/linux/mod.rs:765: DISPLAY is not set.";
        let message = no_window(&winit).to_string();
        assert!(
            message.contains("(DISPLAY is not set)") && !message.contains(".rs"),
            "{message}"
        );
        assert!(no_window(&"no memory").to_string().contains("(no memory)"));
    }
}
