//! What is round the picture: the panel with every parameter, the line of facts, the help; and what they ask for.
//!
//! The interface changes its own settings and view at once and asks the window for the rest by [`Command`]s, so it
//! runs without a window and without a device, as its tests do.

use egui::{Align, Align2, Color32, Layout, Rect, RichText, ScrollArea, Sense, Ui, vec2};
use glam::{Vec2, Vec3};
use myxo::render::exposure::Exposure;
use myxo::render::view::View;
use myxo::scene::parameters::{OBJECT_PARAMETERS, PARAMETERS};
use myxo::scene::settings::{ColorMap, Settings, Show};

use super::keys::{self, KEYS, KeyAction, MOUSE};
use super::navigation::Navigation;
use super::rows::{RowContext, grouped, row};
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
    /// Steps a second, lately.
    pub steps_per_second: f64,
    /// Pictures a second, lately.
    pub frames_per_second: f64,
    /// GPU time of a step; `None` where the device has no timestamps.
    pub step_ms: Option<f64>,
    /// GPU time of each kernel.
    pub kernels: Vec<KernelTime>,
    /// The device's name and driver.
    pub device: String,
    /// Device memory that the program has taken, bytes.
    pub memory: u64,
    /// Triangles of all objects.
    pub triangles: usize,
    /// Texels that triangles own.
    pub texels: usize,
    /// The running atlas's gutter, texels.
    pub gutter: u32,
}

/// A line that stays for a while.
#[derive(Clone, Debug, PartialEq)]
struct Notice {
    text: String,
    is_error: bool,
    until: f64,
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
    /// The scene's centre and radius, which a fit looks at.
    pub bounds: (Vec3, f32),
    /// Hand and flights.
    pub navigation: Navigation,
    panel: bool,
    help: bool,
    filter: String,
    notice: Option<Notice>,
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
    pub fn new(settings: &Settings, view: View, bounds: (Vec3, f32)) -> Self {
        Self {
            loaded: settings.clone(),
            running: settings.clone(),
            edited: settings.clone(),
            view,
            playing: true,
            bounds,
            navigation: Navigation::default(),
            panel: true,
            help: false,
            filter: String::new(),
            notice: None,
        }
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
        let response = ui.allocate_rect(picture, Sense::click_and_drag());
        let moved = self.navigation.apply(ui, &response, &mut self.view);
        if let Some(pixel) = moved.refocus {
            commands.push(Command::Refocus(pixel));
        }
        if self.help {
            self.help(ui.ctx(), picture);
        }
        self.show_notice(ui, picture);
        Shown {
            commands,
            picture,
            touched: moved.touched || response.dragged(),
        }
    }

    /// The edited settings, but for what would restart the running simulation.
    pub fn live_settings(&self, gutter: u32) -> Settings {
        let mut live = self.running.clone();
        for parameter in PARAMETERS {
            if !parameter.restarts(&self.running, &self.edited, gutter) {
                parameter.copy(&self.edited, &mut live);
            }
        }
        live
    }

    /// Are there edits that wait for a restart?
    pub fn is_pending(&self, gutter: u32) -> bool {
        PARAMETERS.iter().any(|p| {
            p.restarts(&self.running, &self.edited, gutter)
                && p.differs(&self.running, &self.edited)
        }) || self.running.objects != self.edited.objects
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
                KeyAction::NextColors => self.view.color_map = self.view.color_map.next(),
                KeyAction::Fit => self.fit(ctx),
                KeyAction::Screenshot => commands.push(Command::Screenshot),
                KeyAction::Panel => self.panel = !self.panel,
                KeyAction::Help => self.help = !self.help,
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
    fn fit(&mut self, ctx: &egui::Context) {
        if self.view.show == Show::Atlas {
            self.view.atlas = myxo::render::view::AtlasWindow {
                chart_share: self.view.atlas.chart_share,
                ..Default::default()
            };
            return;
        }
        let size = ctx.content_rect().size();
        let width = if self.panel {
            size.x - PANEL_WIDTH
        } else {
            size.x
        };
        let (center, radius) = self.bounds;
        self.view
            .camera
            .fit(center, radius, Vec2::new(width, size.y));
    }

    fn panel(&mut self, ui: &mut Ui, facts: &Facts, commands: &mut Vec<Command>) {
        ui.horizontal(|ui| {
            ui.label(RichText::new("myxo").heading().color(theme::ACCENT));
            ui.label(RichText::new(&facts.scene).heading());
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                ui.toggle_value(&mut self.help, "?")
                    .on_hover_text("Keys and mouse (H)");
            });
        });
        ui.add_space(4.0);
        self.transport(ui, facts, commands);
        ui.add_space(6.0);
        ui.separator();
        ScrollArea::vertical()
            .auto_shrink([false, false])
            .show(ui, |ui| {
                // Room for the bar, which floats over the content.
                ui.set_max_width(ui.available_width() - 6.0);
                section(ui, "Picture", true, |ui| self.picture_section(ui, commands));
                self.parameter_sections(ui, facts, commands);
                section(ui, "Kernel times", true, |ui| kernel_table(ui, facts));
            });
    }

    fn transport(&mut self, ui: &mut Ui, facts: &Facts, commands: &mut Vec<Command>) {
        ui.horizontal(|ui| {
            let (label, hint) = if self.playing {
                ("⏸ Pause", "Hold the simulation (Space)")
            } else {
                ("▶ Run", "Let it grow (Space)")
            };
            let button = egui::Button::new(RichText::new(label).color(Color32::BLACK))
                .fill(theme::ACCENT)
                .min_size(vec2(84.0, 26.0));
            if ui.add(button).on_hover_text(hint).clicked() {
                self.playing = !self.playing;
            }
            let wide = |label: &'static str| egui::Button::new(label).min_size(vec2(66.0, 26.0));
            if ui
                .add(wide("⏭ Step"))
                .on_hover_text("One step, then hold (S or .)")
                .clicked()
            {
                self.playing = false;
                commands.push(Command::Step);
            }
            if ui
                .add(wide("⟲ Reset"))
                .on_hover_text("Begin again at step 0 (R)")
                .clicked()
            {
                commands.push(Command::Restart);
            }
            if ui
                .add(egui::Button::new("📷").min_size(vec2(30.0, 26.0)))
                .on_hover_text("Save a screenshot (F12)")
                .clicked()
            {
                commands.push(Command::Screenshot);
            }
        });
        ui.horizontal(|ui| {
            ui.label(RichText::new(format!("step {}", grouped(facts.step as f64))).monospace());
            let speed = if self.playing {
                format!("{:.1} steps/s", facts.steps_per_second)
            } else {
                "paused".to_owned()
            };
            ui.label(RichText::new(speed).monospace().color(theme::WEAK));
        });
        if self.is_pending(facts.gutter) {
            ui.horizontal(|ui| {
                let button =
                    egui::Button::new(RichText::new("⟲ Restart to apply").color(Color32::BLACK))
                        .fill(theme::PENDING);
                if ui
                    .add(button)
                    .on_hover_text(
                        "Parameters in orange take effect when the simulation begins again (R).",
                    )
                    .clicked()
                {
                    commands.push(Command::Restart);
                }
                if ui
                    .button("Discard")
                    .on_hover_text("Keep what is running.")
                    .clicked()
                {
                    let live = self.live_settings(facts.gutter);
                    self.edited = live;
                }
            });
        }
    }

    fn picture_section(&mut self, ui: &mut Ui, commands: &mut Vec<Command>) {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 3.0;
            for (show, label, hint) in [
                (
                    Show::Surface,
                    "Surface",
                    "The lit surface in the trail's colours (1)",
                ),
                (
                    Show::Particles,
                    "Particles",
                    "Every particle as a point (2)",
                ),
                (Show::Atlas, "Atlas", "The texture, unwrapped (3)"),
            ] {
                ui.selectable_value(&mut self.view.show, show, label)
                    .on_hover_text(hint);
            }
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if ui
                    .button("Fit")
                    .on_hover_text("The whole scene into the picture (F)")
                    .clicked()
                {
                    self.fit(ui.ctx());
                }
            });
        });
        ui.add_space(2.0);
        color_map_picker(ui, &mut self.view.color_map);
        self.brightness(ui);
        match self.view.show {
            Show::Particles => {
                ui.horizontal(|ui| {
                    ui.label("Point size");
                    ui.label(RichText::new("pixels").small().color(theme::WEAK));
                });
                let width = ui.available_width() - 82.0;
                ui.spacing_mut().slider_width = width;
                ui.add(egui::Slider::new(&mut self.view.particle_size, 1.0..=8.0).max_decimals(1));
            }
            Show::Atlas => {
                let mut tinted = self.view.atlas.chart_share > 0.0;
                ui.checkbox(&mut tinted, "Tint charts")
                    .on_hover_text("Give each chart of the atlas a colour of its own.");
                self.view.atlas.chart_share = if tinted { 0.8 } else { 0.0 };
            }
            Show::Surface => {}
        }
        let _ = commands;
    }

    fn brightness(&mut self, ui: &mut Ui) {
        let mut automatic = matches!(self.view.exposure, Exposure::Auto { .. });
        ui.horizontal(|ui| {
            ui.label("Brightest trail")
                .on_hover_text("The trail value that gets the brightest colour.");
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                let hint = "Follow the picture's own range";
                if ui
                    .selectable_label(automatic, "auto")
                    .on_hover_text(hint)
                    .clicked()
                {
                    automatic = !automatic;
                    self.view.exposure = if automatic {
                        Exposure::following()
                    } else {
                        Exposure::Fixed(50.0)
                    };
                }
            });
        });
        if let Exposure::Fixed(brightest) = &mut self.view.exposure {
            let width = ui.available_width() - 82.0;
            ui.spacing_mut().slider_width = width;
            ui.add(
                egui::Slider::new(brightest, 0.01..=10_000.0)
                    .logarithmic(true)
                    .max_decimals(2),
            );
        }
    }

    fn parameter_sections(&mut self, ui: &mut Ui, facts: &Facts, commands: &mut Vec<Command>) {
        ui.add_space(4.0);
        ui.add(
            egui::TextEdit::singleline(&mut self.filter)
                .hint_text("🔍 find a parameter")
                .desired_width(f32::INFINITY),
        );
        let filter = self.filter.trim().to_lowercase();
        let wanted = |name: &str, key: &str| {
            filter.is_empty() || name.to_lowercase().contains(&filter) || key.contains(&filter)
        };
        let mut changed = false;
        for (prefix, title, open) in SECTIONS {
            let parameters: Vec<_> = PARAMETERS
                .iter()
                .filter(|p| p.section() == *prefix && wanted(p.name, p.key))
                .collect();
            if parameters.is_empty() {
                continue;
            }
            section(ui, title, *open || !filter.is_empty(), |ui| {
                let context = RowContext {
                    loaded: &self.loaded,
                    running: &self.running,
                    gutter: facts.gutter,
                };
                for parameter in parameters {
                    changed |= row(ui, parameter, &mut self.edited, &context);
                }
            });
        }
        for i in 0..self.edited.objects.len() {
            let parameters: Vec<_> = OBJECT_PARAMETERS
                .iter()
                .filter(|p| wanted(p.name, p.key))
                .collect();
            let (Some(loaded), Some(running)) =
                (self.loaded.objects.get(i), self.running.objects.get(i))
            else {
                continue;
            };
            if parameters.is_empty() {
                continue;
            }
            let title = format!("Object: {}", self.edited.objects[i].name);
            section(ui, &title, false, |ui| {
                let context = RowContext {
                    loaded,
                    running,
                    gutter: facts.gutter,
                };
                for parameter in parameters {
                    row(ui, parameter, &mut self.edited.objects[i], &context);
                }
            });
        }
        if changed {
            commands.push(Command::Apply);
        }
    }

    fn status_line(&self, ui: &mut Ui, facts: &Facts) {
        let frame = egui::Frame::new()
            .fill(theme::PANEL)
            .inner_margin(egui::Margin::symmetric(12, 4));
        egui::Panel::bottom("status")
            .show_separator_line(false)
            .frame(frame)
            .show(ui, |ui| {
                ui.horizontal(|ui| {
                    let fact = |ui: &mut Ui, text: String| {
                        ui.label(RichText::new(text).small().color(theme::WEAK));
                    };
                    fact(ui, format!("{:.0} fps", facts.frames_per_second));
                    fact(
                        ui,
                        facts
                            .step_ms
                            .map_or("step time unavailable".to_owned(), |ms| {
                                format!("{ms:.2} ms a step")
                            }),
                    );
                    fact(
                        ui,
                        format!(
                            "{} particles",
                            grouped(f64::from(self.running.particles.count))
                        ),
                    );
                    fact(ui, format!("{} triangles", grouped(facts.triangles as f64)));
                    fact(ui, format!("{} texels", grouped(facts.texels as f64)));
                    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                        fact(ui, format!("{} MiB", facts.memory >> 20));
                        ui.add(
                            egui::Label::new(
                                RichText::new(&facts.device).small().color(theme::WEAK),
                            )
                            .truncate(),
                        );
                    });
                });
            });
    }

    fn help(&mut self, ctx: &egui::Context, picture: Rect) {
        let mut open = true;
        egui::Window::new("Controls")
            .open(&mut open)
            .collapsible(false)
            .resizable(false)
            .fixed_pos(picture.left_top() + vec2(16.0, 16.0))
            .show(ctx, |ui| {
                egui::Grid::new("controls")
                    .num_columns(2)
                    .spacing(vec2(20.0, 4.0))
                    .show(ui, |ui| {
                        let mut line = |keys: &str, what: &str| {
                            ui.label(RichText::new(keys).monospace().color(theme::ACCENT));
                            ui.label(what);
                            ui.end_row();
                        };
                        for (keys, what) in MOUSE {
                            line(keys, what);
                        }
                        for (_, keys, _, what) in KEYS {
                            line(keys, what);
                        }
                    });
            });
        self.help &= open;
    }

    fn show_notice(&mut self, ui: &Ui, picture: Rect) {
        let now = ui.input(|i| i.time);
        if self
            .notice
            .as_ref()
            .is_some_and(|notice| now > notice.until)
        {
            self.notice = None;
        }
        let Some(notice) = &self.notice else {
            return;
        };
        egui::Area::new("notice".into())
            .anchor(Align2::CENTER_BOTTOM, vec2(0.5 * picture.left(), -44.0))
            .interactable(false)
            .show(ui.ctx(), |ui| {
                egui::Frame::popup(ui.style()).show(ui, |ui| {
                    ui.set_max_width((picture.width() - 60.0).max(120.0));
                    let color = if notice.is_error {
                        theme::ERROR
                    } else {
                        theme::ACCENT
                    };
                    ui.label(RichText::new(&notice.text).color(color));
                });
            });
    }
}

/// The sections of the table, in the panel's order, with their titles and whether they begin open.
/// What `[camera]` and `[picture]` hold is moved by hand and stands in the section Picture.
const SECTIONS: &[(&str, &str, bool)] = &[
    ("physarum", "Physarum", true),
    ("trail", "Trail", true),
    ("particles", "Particles", false),
    ("time", "Time", false),
    ("atlas", "Atlas", false),
    ("", "Scene", false),
];

fn section(ui: &mut Ui, title: &str, open: bool, contents: impl FnOnce(&mut Ui)) {
    egui::CollapsingHeader::new(RichText::new(title).strong())
        .default_open(open)
        .show_unindented(ui, |ui| {
            ui.add_space(2.0);
            contents(ui);
            ui.add_space(6.0);
        });
}

/// Every colour map as a strip of its colours.
fn color_map_picker(ui: &mut Ui, chosen: &mut ColorMap) {
    egui::ComboBox::from_id_salt("color map")
        .width(ui.available_width())
        .selected_text(chosen.word())
        .show_ui(ui, |ui| {
            for map in ColorMap::ALL {
                ui.selectable_value(chosen, *map, map.word());
            }
        })
        .response
        .on_hover_text("Colours of the trail (C for the next)");
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 6.0), Sense::hover());
    color_strip(ui, rect, *chosen);
}

fn color_strip(ui: &Ui, rect: Rect, map: ColorMap) {
    let parts = 48;
    let mut mesh = egui::Mesh::default();
    for i in 0..=parts {
        let share = i as f32 / parts as f32;
        let [r, g, b] = map
            .color(share)
            .to_array()
            .map(|c| (255.0 * myxo::render::colormap::srgb_from_linear(c)).round() as u8);
        let x = rect.left() + share * rect.width();
        for y in [rect.top(), rect.bottom()] {
            mesh.colored_vertex(egui::pos2(x, y), Color32::from_rgb(r, g, b));
        }
        if i > 0 {
            let k = 2 * i;
            mesh.add_triangle(k - 2, k - 1, k);
            mesh.add_triangle(k - 1, k, k + 1);
        }
    }
    ui.painter().add(mesh);
}

fn kernel_table(ui: &mut Ui, facts: &Facts) {
    if facts.kernels.is_empty() {
        let reason = if facts.step_ms.is_none() && facts.step > 0 {
            "unavailable on this device"
        } else {
            "measured while it runs"
        };
        ui.label(RichText::new(reason).color(theme::WEAK));
        return;
    }
    egui::Grid::new("kernels")
        .num_columns(5)
        .spacing(vec2(12.0, 3.0))
        .show(ui, |ui| {
            for title in ["kernel", "a step", "mean ms", "p95 ms", "share"] {
                ui.label(RichText::new(title).small().color(theme::WEAK));
            }
            ui.end_row();
            for kernel in &facts.kernels {
                ui.label(RichText::new(&kernel.name).monospace());
                let number = |ui: &mut Ui, text: String| {
                    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                        ui.label(RichText::new(text).monospace())
                    });
                };
                number(ui, format!("{:.0}", kernel.per_step));
                number(ui, format!("{:.3}", kernel.mean_ms));
                number(ui, format!("{:.3}", kernel.p95_ms));
                number(ui, format!("{:.0} %", 100.0 * kernel.share));
                ui.end_row();
            }
        });
}
