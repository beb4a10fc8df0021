//! The interface of exports: the card with its choices, the red dot of recordings, and progress.

use std::path::Path;

use egui::{Align2, DragValue, Rect, RichText, Ui, vec2};
use myxo::export::Colors;
use myxo::plain_text::Shown as _;
use myxo::render::lens;
use serde::{Deserialize, Serialize};

use crate::lab::actions::Action;
use crate::lab::command::{Command, ExportRequest, Model};
use crate::lab::desk::Desk;
use crate::lab::facts::{Facts, Making, Recorded};
use crate::lab::layout::Card;
use crate::lab::overlays::progress_bar;
use crate::lab::places::{Marked as _, mark_cross, note_value};
use crate::lab::recent::merged;
use crate::lab::theme;
use crate::lab::widgets::{parse_number, parse_whole, reader};

/// The size of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Size {
    /// As the window shows it.
    Window,
    /// 1920 x 1080.
    Hd,
    /// 3840 x 2160.
    Uhd,
    /// As it is typed.
    Custom,
}

impl Size {
    const ALL: [(Self, &'static str, &'static str); 4] = [
        (
            Self::Window,
            "window",
            "As large as the picture is in the window",
        ),
        (Self::Hd, "1080p", "1920 x 1080 pixels"),
        (Self::Uhd, "4K", "3840 x 2160 pixels"),
        (Self::Custom, "custom", "Width and height as you type them"),
    ];

    /// Width and height.
    pub fn pixels(self, window: [u32; 2], custom: [u32; 2]) -> [u32; 2] {
        match self {
            Self::Window => window,
            Self::Hd => [1920, 1080],
            Self::Uhd => [3840, 2160],
            Self::Custom => custom,
        }
    }
}

/// The format of a film.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kind {
    /// A video, by ffmpeg.
    Mp4,
    /// An animated picture.
    Gif,
    /// A folder of pictures.
    Png,
}

impl Kind {
    const ALL: [(Self, &'static str, &'static str); 3] = [
        (Self::Mp4, "MP4", "A video; needs the program ffmpeg"),
        (
            Self::Gif,
            "GIF",
            "An animated picture of 256 colours, at most 50 frames a second",
        ),
        (Self::Png, "PNG", "A folder with a picture for each frame"),
    ];

    /// The ending of its files; none for a folder.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Mp4 => "mp4",
            Self::Gif => "gif",
            Self::Png => "",
        }
    }
}

/// The range of typed sides of pictures, pixels.
const CUSTOM: (u32, u32) = (16, 16_384);
/// Seconds that a film takes.
const SECONDS: (f64, f64) = (0.1, 3600.0);
/// How often its camera goes round.
const TURNS: (f64, f64) = (-100.0, 100.0);
/// Diameters of lenses, scene radii.
const LENS: (f64, f64) = (0.0, lens::WIDEST as f64);
/// Steps from one of its frames to the next.
const EVERY: (u32, u32) = (1, 1000);
/// Frames a second of films.
const FILM_FPS: (u32, u32) = (1, 120);
/// Frames a second of recordings.
const RECORDING_FPS: (u32, u32) = (1, 60);

/// The choices, which are kept from one time to the next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ExportPanel {
    /// The folder for exports; empty for the folder in which the program was started.
    pub folder: String,
    /// The size of pictures.
    pub size: Size,
    /// The size of films.
    pub film_size: Size,
    /// Width and height where they are typed.
    pub custom: [u32; 2],
    /// Pictures without their background.
    pub transparent: bool,
    /// Are films that are folders of pictures written with transparency?
    pub film_transparent: bool,
    /// The diameter of the lens of pictures, scene radii; 0 has all in focus.
    pub lens: f64,
    /// That of films.
    pub film_lens: f64,
    /// The format of recordings and films.
    pub kind: Kind,
    /// Frames a second of recordings.
    pub fps: u32,
    /// Frames a second of films.
    pub film_fps: u32,
    /// The length of films.
    pub seconds: f64,
    /// Steps from one frame of a film to the next.
    pub every: u32,
    /// How often the camera of a film goes round the scene.
    pub turns: f64,
    /// The part of a model that carries its colours.
    pub colors: Colors,
}

impl Default for ExportPanel {
    fn default() -> Self {
        Self {
            folder: String::new(),
            size: Size::Window,
            film_size: Size::Hd,
            custom: [2048, 2048],
            transparent: false,
            film_transparent: false,
            lens: 0.0,
            film_lens: 0.0,
            kind: Kind::Mp4,
            fps: 30,
            film_fps: 30,
            seconds: 10.0,
            every: 2,
            turns: 0.0,
            colors: Colors::Texture,
        }
    }
}

impl ExportPanel {
    /// How many frames a film has.
    pub fn film_frames(&self) -> u64 {
        (self.seconds * f64::from(self.film_fps)).round().max(1.0) as u64
    }

    /// The choices that another window has kept since this one opened, except those that were changed in this one.
    pub fn over(&self, opened: &Self, kept: &Self) -> Self {
        merged! { self, opened, kept: [
            folder, size, film_size, custom, transparent, film_transparent, lens, film_lens, kind, fps, film_fps, seconds, every, turns, colors
        ] }
    }

    /// The choices to keep: those that the card allows.
    pub fn kept(&self) -> Self {
        let within = |value: f64, (least, most): (f64, f64), usual| match value.is_finite() {
            true => value.clamp(least, most),
            false => usual,
        };
        let usual = Self::default();
        Self {
            custom: self.custom.map(|pixels| pixels.clamp(CUSTOM.0, CUSTOM.1)),
            fps: self.fps.clamp(RECORDING_FPS.0, RECORDING_FPS.1),
            film_fps: self.film_fps.clamp(FILM_FPS.0, FILM_FPS.1),
            seconds: within(self.seconds, SECONDS, usual.seconds),
            every: self.every.clamp(EVERY.0, EVERY.1),
            turns: within(self.turns, TURNS, usual.turns),
            lens: within(self.lens, LENS, usual.lens),
            film_lens: within(self.film_lens, LENS, usual.film_lens),
            ..self.clone()
        }
    }
}

impl ExportPanel {
    /// Takes a folder as if its path had been typed; else says why not.
    pub fn take_folder(&mut self, folder: &Path) -> Result<(), String> {
        match folder.to_str().filter(|text| text.trim() == *text) {
            Some(text) => {
                self.folder = text.to_owned();
                Ok(())
            }
            None => Err(format!(
                "cannot take the folder {}: its name is not plain text, or begins or ends with a space; rename it or choose another",
                folder.shown()
            )),
        }
    }

    /// The card, the red dot and how far things are, these two beside the bar of tools if there is one.
    pub fn show(
        &mut self,
        ctx: &egui::Context,
        picture: Rect,
        bar: Option<Rect>,
        desk: &mut Desk<'_>,
    ) {
        let facts = desk.facts;
        let is_flat = desk.document.view.show.is_flat();
        if desk.layout.shows(Card::Exports) {
            let mut open = true;
            let shown = egui::Window::new("Export")
                .open(&mut open)
                .collapsible(false)
                .resizable(false)
                .fixed_pos(picture.left_top() + vec2(16.0, 16.0))
                .show(ctx, |ui| {
                    ui.set_width(330.0);
                    let room = (picture.height() - 80.0).max(120.0);
                    egui::ScrollArea::vertical()
                        .max_height(room)
                        .min_scrolled_height(room)
                        .show(ui, |ui| self.card(ui, facts, is_flat, desk.commands));
                });
            mark_cross(shown, "out.close");
            if !open {
                desk.layout.close(Card::Exports);
            }
        }
        let right = bar.map_or(picture.right() - 14.0, |bar| bar.left() - 8.0);
        let corner = egui::pos2(right, picture.top() + 10.0);
        if let Some(recording) = &facts.exports.recording {
            show_dot(ctx, corner, recording);
        }
        if let Some(making) = &facts.exports.making {
            let corner = match facts.exports.recording {
                Some(_) => corner + vec2(0.0, 44.0),
                None => corner,
            };
            let room = (corner.x - picture.left() - 40.0).max(60.0);
            show_making(ctx, corner, room, making, desk.commands);
        }
    }

    fn card(&mut self, ui: &mut Ui, facts: &Facts, is_flat: bool, commands: &mut Vec<Command>) {
        self.folder_controls(ui, commands);
        self.picture_controls(ui, facts, is_flat, commands);
        self.format_controls(ui);
        self.recording_controls(ui, facts, commands);
        self.film_controls(ui, facts, is_flat, commands);
        self.state_controls(ui, facts, commands);
    }

    /// Chooses the folder that all files go to.
    fn folder_controls(&mut self, ui: &mut Ui, commands: &mut Vec<Command>) {
        title(
            ui,
            "Folder",
            "Where all files go. Names are numbered; nothing is overwritten.",
        );
        let here = std::env::current_dir().unwrap_or_default();
        ui.horizontal(|ui| {
            let choose = ui.button("🗁").on_hover_text("Chooses the folder");
            if choose.marked("out.folder:choose").clicked() {
                commands.push(Command::AskForFolder);
            }
            ui.add(
                egui::TextEdit::singleline(&mut self.folder)
                    .hint_text(here.to_string_lossy().into_owned())
                    .desired_width(f32::INFINITY),
            )
            .on_hover_text("Where files go; empty for the folder that the program was started in. Kept for next time.")
            .marked("out.folder");
        });
        note_value(ui.ctx(), "out.folder", || self.folder.clone());
    }

    /// Saves a picture.
    fn picture_controls(
        &mut self,
        ui: &mut Ui,
        facts: &Facts,
        is_flat: bool,
        commands: &mut Vec<Command>,
    ) {
        title(
            ui,
            "Picture",
            "A PNG without the interface, with smooth edges and every particle.",
        );
        sizes(ui, "out.size", &mut self.size);
        if self.size == Size::Custom {
            custom(ui, &mut self.custom);
        }
        ui.horizontal(|ui| {
            if ui
                .add_enabled(is_free(facts), egui::Button::new("📷 Save picture"))
                .on_hover_text(Action::Screenshot.hint("Writes it"))
                .on_disabled_hover_text("One thing at a time")
                .marked("out.picture")
                .clicked()
            {
                commands.push(Command::Screenshot);
            }
            theme::switch(ui, &mut self.transparent, "transparent")
                .on_hover_text("Leaves out the background")
                .marked("out.transparent");
            lens_width(ui, "out.lens", &mut self.lens, is_flat);
        });
    }

    /// Chooses the format of recordings and films.
    fn format_controls(&mut self, ui: &mut Ui) {
        title(ui, "Recording and film", "What they are written as.");
        ui.horizontal(|ui| {
            for (kind, label, hint) in Kind::ALL {
                ui.selectable_value(&mut self.kind, kind, label)
                    .on_hover_text(hint)
                    .marked(&format!("out.kind={label}"));
            }
        });
    }

    /// Begins or ends a recording of the window.
    fn recording_controls(&mut self, ui: &mut Ui, facts: &Facts, commands: &mut Vec<Command>) {
        title(
            ui,
            "Record the window",
            "The picture as it is shown, at the pace of the clock.",
        );
        ui.horizontal(|ui| {
            let is_on = facts
                .exports
                .recording
                .is_some_and(|recording| !recording.is_ending);
            let label = if is_on { "■ Stop" } else { "⏺ Record" };
            if ui
                .button(label)
                .on_hover_text(Action::Record.hint("Begins to record the picture as it is shown, without the atlas beside it, or ends it"))
                .marked("out.record")
                .clicked()
            {
                commands.push(Command::Export(ExportRequest::Record));
            }
            number(
                ui,
                "out.fps",
                &mut self.fps,
                RECORDING_FPS.0..=RECORDING_FPS.1,
                " fps",
            )
            .on_hover_text(
                "Frames a second. Where the window is slower, pictures stay for longer.",
            );
        });
    }

    /// Makes a film at a fixed step.
    fn film_controls(
        &mut self,
        ui: &mut Ui,
        facts: &Facts,
        is_flat: bool,
        commands: &mut Vec<Command>,
    ) {
        title(
            ui,
            "Film at a fixed step",
            "Continues from here by so many steps a frame, however long each takes; no frame is left out. The camera \
             is where it is now, or turns from there; if it shows the whole scene, from as far as that takes.",
        );
        sizes(ui, "out.film_size", &mut self.film_size);
        if self.film_size == Size::Custom && self.size != Size::Custom {
            custom(ui, &mut self.custom);
        }
        self.film_times(ui);
        let turns = DragValue::new(&mut self.turns)
            .range(TURNS.0..=TURNS.1)
            .speed(0.05)
            .max_decimals(2)
            .custom_parser(reader(ui, parse_number))
            .update_while_editing(false)
            .prefix("camera turns ");
        ui.horizontal(|ui| {
            ui.add_enabled(!is_flat, turns)
                .on_hover_text(
                    "How often the camera goes round the scene while the film plays; below 0 the other way round. \
                     After whole turns it can be played round and round.",
                )
                .on_disabled_hover_text("This view is flat")
                .marked("out.turns");
            ui.add_enabled_ui(self.kind == Kind::Png, |ui| {
                theme::switch(ui, &mut self.film_transparent, "transparent")
                    .on_hover_text("Leaves out the background")
                    .on_disabled_hover_text("Only folders of PNGs can be transparent")
                    .marked("out.film_transparent");
            });
        });
        note_value(ui.ctx(), "out.turns", || format!("{}", self.turns));
        lens_width(ui, "out.film_lens", &mut self.film_lens, is_flat);
        let label = format!("🎬 Film {} frames", self.film_frames());
        if ui
            .add_enabled(is_free(facts), egui::Button::new(label))
            .on_hover_text("Makes the film; the window shows how far it is")
            .on_disabled_hover_text("One thing at a time")
            .marked("out.film")
            .clicked()
        {
            commands.push(Command::Export(ExportRequest::Film));
        }
    }

    /// Sets how long a film plays, and how many steps lie between its frames.
    fn film_times(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            ui.add(
                DragValue::new(&mut self.seconds)
                    .range(SECONDS.0..=SECONDS.1)
                    .speed(0.1)
                    .max_decimals(1)
                    .custom_parser(reader(ui, parse_number))
                    .update_while_editing(false)
                    .suffix(" s"),
            )
            .on_hover_text("How long the film plays")
            .marked("out.seconds");
            number(
                ui,
                "out.film_fps",
                &mut self.film_fps,
                FILM_FPS.0..=FILM_FPS.1,
                " fps",
            )
            .on_hover_text("Frames a second when it plays");
            number(
                ui,
                "out.every",
                &mut self.every,
                EVERY.0..=EVERY.1,
                " steps a frame",
            )
            .on_hover_text("Steps from one frame to the next");
        });
        note_value(ui.ctx(), "out.seconds", || format!("{}", self.seconds));
    }

    /// Writes the present state to files.
    fn state_controls(&mut self, ui: &mut Ui, facts: &Facts, commands: &mut Vec<Command>) {
        title(
            ui,
            "Export the state",
            "Models, data and files to continue from; all but checkpoints as `myxo export` writes them.",
        );
        ui.horizontal(|ui| {
            for model in Model::ALL {
                let (label, hint) = words(model);
                if ui
                    .add_enabled(is_free(facts), egui::Button::new(label))
                    .on_hover_text(hint)
                    .on_disabled_hover_text("One thing at a time")
                    .marked(&format!("out.export={label}"))
                    .clicked()
                {
                    commands.push(Command::Export(ExportRequest::Export(model)));
                }
            }
        });
        ui.horizontal(|ui| {
            for (colors, label, hint) in [
                (
                    Colors::Texture,
                    "texture",
                    "A GLB has the trail as texture, as fine as it is",
                ),
                (
                    Colors::Vertex,
                    "vertex colours",
                    "A GLB has colours of vertices, as fine as its mesh",
                ),
            ] {
                ui.selectable_value(&mut self.colors, colors, label)
                    .on_hover_text(hint)
                    .marked(&format!("out.colors={label}"));
            }
        });
    }
}

/// Can a picture, a film or a file of the state be made? One is made at a time.
fn is_free(facts: &Facts) -> bool {
    facts.exports.making.is_none()
}

fn words(model: Model) -> (&'static str, &'static str) {
    match model {
        Model::Glb => (
            "GLB",
            "A model with the trail on it, for Blender, the web and engines",
        ),
        Model::Ply => ("PLY", "A mesh with the trail at its vertices"),
        Model::Npz => ("NPZ", "Particles, trail and all fields as arrays for NumPy"),
        Model::Scene => (
            "Scene",
            "A scene file that begins where the objects are now, seen as now",
        ),
        Model::Checkpoint => (
            "Checkpoint",
            "The whole state, to continue from: opened here, or by `myxo render --resume FILE`",
        ),
    }
}

fn title(ui: &mut Ui, text: &str, hint: &str) {
    ui.add_space(6.0);
    ui.label(RichText::new(text).strong()).on_hover_text(hint);
}

fn sizes(ui: &mut Ui, key: &str, size: &mut Size) {
    ui.horizontal(|ui| {
        for (choice, label, hint) in Size::ALL {
            ui.selectable_value(size, choice, label)
                .on_hover_text(hint)
                .marked(&format!("{key}={label}"));
        }
    });
}

fn custom(ui: &mut Ui, size: &mut [u32; 2]) {
    ui.horizontal(|ui| {
        let [width, height] = size;
        number(ui, "out.width", width, CUSTOM.0..=CUSTOM.1, " wide")
            .on_hover_text("Width in pixels");
        number(ui, "out.height", height, CUSTOM.0..=CUSTOM.1, " high")
            .on_hover_text("Height in pixels");
    });
}

fn number(
    ui: &mut Ui,
    key: &str,
    value: &mut u32,
    range: std::ops::RangeInclusive<u32>,
    suffix: &str,
) -> egui::Response {
    let response = ui.add(
        DragValue::new(value)
            .range(range)
            .custom_parser(reader(ui, parse_whole))
            .update_while_editing(false)
            .suffix(suffix),
    );
    note_value(ui.ctx(), key, || format!("{value}"));
    response.marked(key)
}

/// The width of the lens.
fn lens_width(ui: &mut Ui, key: &str, lens: &mut f64, is_flat: bool) {
    let width = DragValue::new(lens)
        .range(LENS.0..=LENS.1)
        .speed(0.002)
        .max_decimals(3)
        .custom_parser(reader(ui, parse_number))
        .update_while_editing(false)
        .prefix("lens ");
    ui.add_enabled(!is_flat, width)
        .on_hover_text(format!(
            "Depth of field: the diameter of the lens, in scene radii. What is nearer or farther than the middle of the picture is out \
             of focus; 0.05 shows it well, 0 has all in focus. Each picture is the mean of {}, and takes long.",
            lens::PLACES
        ))
        .on_disabled_hover_text("This view is flat")
        .marked(key);
    note_value(ui.ctx(), key, || format!("{lens}"));
}

/// The red dot, with time and frames; over the picture and not in it.
fn show_dot(ctx: &egui::Context, corner: egui::Pos2, recording: &Recorded) {
    egui::Area::new("recording".into())
        .pivot(Align2::RIGHT_TOP)
        .fixed_pos(corner)
        .interactable(false)
        .show(ctx, |ui| {
            egui::Frame::popup(ui.style()).show(ui, |ui| {
                ui.horizontal(|ui| {
                    let red = egui::Color32::from_rgb(0xe5, 0x3e, 0x3e);
                    let (rect, _) = ui.allocate_exact_size(vec2(12.0, 12.0), egui::Sense::hover());
                    ui.painter().circle_filled(rect.center(), 5.5, red);
                    let seconds = recording.seconds as u64;
                    let text = format!(
                        "{}:{:02}  {} frames",
                        seconds / 60,
                        seconds % 60,
                        recording.frames
                    );
                    ui.label(RichText::new(text).monospace());
                    let repeated = recording.repeated();
                    if recording.is_mostly_repeated() && recording.seconds > 1.0 {
                        let text = format!("{repeated} repeated: Film leaves none out");
                        ui.label(RichText::new(text).color(theme::pending(ui)));
                    } else if repeated > 0 {
                        let text =
                            format!("{} different, {repeated} repeated", recording.different);
                        ui.label(RichText::new(text).color(theme::weak(ui)));
                    }
                    if recording.dropped > 0 {
                        let text = format!("{} dropped", recording.dropped);
                        ui.label(RichText::new(text).color(theme::pending(ui)));
                    }
                    if recording.is_ending {
                        ui.label(RichText::new("writing").color(theme::weak(ui)));
                    }
                });
            });
        });
}

/// A card below the dot: what is being made, how far it is, and a way out.
fn show_making(
    ctx: &egui::Context,
    corner: egui::Pos2,
    room: f32,
    making: &Making,
    commands: &mut Vec<Command>,
) {
    egui::Area::new("making".into())
        .pivot(Align2::RIGHT_TOP)
        .fixed_pos(corner)
        .show(ctx, |ui| {
            egui::Frame::popup(ui.style())
                .inner_margin(12.0)
                .show(ui, |ui| {
                    ui.set_width(room.min(230.0));
                    ui.label(RichText::new(&making.name).strong());
                    let doing = if making.is_cancelled {
                        "ending"
                    } else {
                        &making.doing
                    };
                    ui.label(RichText::new(doing).color(theme::weak(ui)));
                    if let Some(done) = making.done {
                        ui.add(progress_bar(ui, done));
                    }
                    ui.horizontal(|ui| {
                        let cancel = egui::Button::new("Cancel");
                        if ui
                            .add_enabled(!making.is_cancelled, cancel)
                            .on_hover_text("Give it up; it leaves no file")
                            .marked("out.cancel")
                            .clicked()
                        {
                            commands.push(Command::Export(ExportRequest::Cancel));
                        }
                        if making.can_finish
                            && ui
                                .button("Finish now")
                                .on_hover_text("End it here, and keep what is filmed so far")
                                .marked("out.finish")
                                .clicked()
                        {
                            commands.push(Command::Export(ExportRequest::Finish));
                        }
                    });
                });
        });
}
