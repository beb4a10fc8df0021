//! The strips of pictures in the guide: a parameter at several values, side by side.
//!
//! `cargo run --release --example guide -- TABLE FOLDER [NAME...]`
//!
//! TABLE is a file like `docs/guide.toml`, which says what it may hold; each of its strips becomes `FOLDER/NAME.png`. Without
//! names all are drawn, which takes a quarter of an hour without a graphics card; `make guide` does that.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use color_quant::NeuQuant;
use glam::Vec2;
use image::{DynamicImage, RgbImage, imageops};
use myxo::gpu::{Context, ContextOptions, Frames, default_cache_folder};
use myxo::render::offscreen::{FORMAT, Offscreen};
use myxo::render::{Renderer, View};
use myxo::scene::parameters::PARAMETERS;
use myxo::scene::settings::{CameraSettings, PictureSettings, Settings};
use myxo::scene::{Overrides, Scene};
use myxo::sim::Simulation;
use myxo::{Error, Result};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use serde::Deserialize;

// Pictures with letters, as in the plots of the program.
#[path = "../src/cli/pixels.rs"]
mod pixels;
use pixels::Pixels;

/// Pixels of one picture, between two, and below each for its label.
const SIZE: [u32; 2] = [280, 210];
const GAP: u32 = 4;
const BAND: u32 = 24;
/// Pictures side by side at the most.
const COLUMNS: u32 = 4;
/// The strips' own colours, and how many each has of all: they are small files.
const GROUND: RGBColor = RGBColor(14, 15, 19);
const INK: RGBColor = RGBColor(222, 224, 228);
const COLORS: usize = 160;
const FONT: &str = "sans-serif";
const LETTERS: i32 = 15;
/// A number with more digits than this behind its point is shown with so many: 1/60 is 0.0167.
const DECIMALS: usize = 4;

/// What is drawn.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    /// What strips have that say nothing else.
    scene: String,
    steps: u32,
    /// `KEY=VALUE`, before those of the strip.
    set: Vec<String>,
    /// Before that, but for scenes whose own look is shown.
    plain: Vec<String>,
    own_looks: Vec<String>,
    strip: Vec<Strip>,
}

impl Table {
    fn plain_on(&self, scene: &String) -> &[String] {
        if self.own_looks.contains(scene) {
            &[]
        } else {
            &self.plain
        }
    }
}

/// One parameter at several values.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Strip {
    /// Of the parameter.
    key: String,
    /// As `--set` takes them.
    values: Vec<String>,
    /// Of the file; else the key.
    name: Option<String>,
    scene: Option<String>,
    steps: Option<u32>,
    #[serde(default)]
    set: Vec<String>,
}

impl Strip {
    fn name(&self) -> &str {
        self.name.as_deref().unwrap_or(&self.key)
    }

    /// What stands below a value's picture.
    fn label(&self, value: &str) -> String {
        let parameter = PARAMETERS
            .iter()
            .find(|parameter| parameter.key == self.key);
        let is_default =
            parameter.is_some_and(|parameter| parameter.value(&Settings::default()) == value);
        let behind = value.split_once('.').map_or("", |(_, behind)| behind);
        let decimals = behind.bytes().take_while(u8::is_ascii_digit).count();
        let shown = match value.parse::<f64>() {
            _ if value.is_empty() => "\"\"".to_owned(),
            Ok(number) if decimals > DECIMALS => format!("{number:.DECIMALS$}"),
            _ => value.to_owned(),
        };
        format!("{shown}{}", if is_default { " (default)" } else { "" })
    }
}

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let (Some(table), Some(folder)) = (arguments.next(), arguments.next()) else {
        return Err(Error::Invalid(
            "which table, and which folder? guide TABLE FOLDER [NAME...]".to_owned(),
        ));
    };
    let (table, folder) = (read(table.as_ref())?, PathBuf::from(folder));
    let names: Vec<String> = arguments.collect();
    let is_known = |name: &&String| table.strip.iter().any(|strip| strip.name() == **name);
    if let Some(unknown) = names.iter().find(|name| !is_known(name)) {
        return Err(Error::Invalid(format!("the table has no strip {unknown}")));
    }
    fs::create_dir_all(&folder).map_err(|source| unwritable(&folder, source))?;
    let ctx = Context::new(&ContextOptions {
        cache_folder: default_cache_folder(),
        ..ContextOptions::default()
    })?;
    let mut artist = Artist {
        ctx,
        grown: None,
        drawn: Vec::new(),
    };
    let is_wanted =
        |strip: &&Strip| names.is_empty() || names.iter().any(|name| name == strip.name());
    for strip in table.strip.iter().filter(is_wanted) {
        let mut pictures = Vec::new();
        for value in &strip.values {
            let picture = artist.picture(&table, strip, value)?;
            pictures.push((strip.label(value), picture));
        }
        let file = folder.join(format!("{}.png", strip.name()));
        let bytes = side_by_side(&pictures)
            .and_then(|sheet| indexed(&sheet))
            .map_err(|problem| Error::Invalid(format!("{}: {problem}", file.display())))?;
        fs::write(&file, bytes).map_err(|source| unwritable(&file, source))?;
        println!("{}", file.display());
    }
    Ok(())
}

fn read(file: &Path) -> Result<Table> {
    let text = fs::read_to_string(file).map_err(|source| Error::Io {
        action: "read",
        path: file.to_owned(),
        source,
    })?;
    toml::from_str(&text)
        .map_err(|problem| Error::Invalid(format!("{}: {problem}", file.display())))
}

/// Grows scenes and takes pictures of them.
struct Artist {
    ctx: Arc<Context>,
    /// What has grown last, from which settings and for how many steps: values that only change what is looked at need
    /// not grow it again.
    grown: Option<(Settings, u32, Simulation)>,
    /// Every picture so far. The usual values come in most strips.
    drawn: Vec<(Settings, u32, RgbImage)>,
}

impl Artist {
    fn picture(&mut self, table: &Table, strip: &Strip, value: &str) -> Result<RgbImage> {
        let name = strip.scene.as_ref().unwrap_or(&table.scene);
        let everywhere = table.plain_on(name).iter().chain(&table.set);
        let overrides = Overrides {
            set: (everywhere.chain(&strip.set).cloned())
                .chain([format!("{}={value}", strip.key)])
                .collect(),
            ..Overrides::default()
        };
        let scene = Scene::load(Path::new(name), &overrides)?;
        let steps = strip.steps.unwrap_or(table.steps);
        let mut drawn = self.drawn.iter();
        if let Some((.., picture)) =
            drawn.find(|(of, after, _)| *of == scene.settings && *after == steps)
        {
            return Ok(picture.clone());
        }
        let ctx = self.ctx.clone();
        let simulation = self.grow(&scene, steps)?;
        let mut renderer = Renderer::new(&ctx, simulation.setup(), FORMAT)?;
        let offscreen = Offscreen::new(&ctx, SIZE)?;
        let view = View::of(&scene, Vec2::new(SIZE[0] as f32, SIZE[1] as f32));
        let mut frames = Frames::new(&ctx, 1)?;
        frames.run(|rec| {
            renderer.draw(rec, simulation.state(), &view, offscreen.canvas());
            offscreen.record_readback(rec);
        })?;
        let picture = DynamicImage::ImageRgba8(offscreen.image()).into_rgb8();
        self.drawn.push((scene.settings, steps, picture.clone()));
        Ok(picture)
    }

    fn grow(&mut self, scene: &Scene, steps: u32) -> Result<&Simulation> {
        let settings = Settings {
            camera: CameraSettings::default(),
            picture: PictureSettings::default(),
            ..scene.settings.clone()
        };
        let has_grown = (self.grown.as_ref())
            .is_some_and(|(from, after, _)| *from == settings && *after == steps);
        if !has_grown {
            let mut simulation = Simulation::new(&self.ctx, scene)?;
            let mut frames = Frames::new(&self.ctx, 2)?;
            for _ in 0..steps {
                let mut rec = frames.begin()?;
                simulation.record_step(&mut rec);
                frames.submit(rec)?;
            }
            frames.wait_idle()?;
            self.grown = Some((settings, steps, simulation));
        }
        let (.., simulation) = self.grown.as_ref().expect("it has grown above");
        Ok(simulation)
    }
}

type Problem = Box<dyn std::error::Error>;

/// From the left to the right and from the top down, each with its label below.
fn side_by_side(pictures: &[(String, RgbImage)]) -> Result<RgbImage, Problem> {
    let count = pictures.len() as u32;
    let columns = COLUMNS.min(count);
    let [across, down] = [SIZE[0] + GAP, SIZE[1] + BAND];
    let size = (columns * across - GAP, count.div_ceil(columns) * down);
    let place = |i: u32| (i % columns * across, i / columns * down);
    let mut sheet = RgbImage::new(size.0, size.1);
    let area = Pixels::new(&mut sheet).into_drawing_area();
    area.fill(&GROUND)?;
    let style = TextStyle::from((FONT, LETTERS).into_font())
        .color(&INK)
        .pos(Pos::new(HPos::Center, VPos::Center));
    for (i, (label, _)) in (0..).zip(pictures) {
        let (x, y) = place(i);
        let middle = ((x + SIZE[0] / 2) as i32, (y + SIZE[1] + BAND / 2) as i32);
        area.draw(&Text::new(label.clone(), middle, style.clone()))?;
    }
    area.present()?;
    drop(area);
    for (i, (_, picture)) in (0..).zip(pictures) {
        let (x, y) = place(i);
        imageops::replace(&mut sheet, picture, x.into(), y.into());
    }
    Ok(sheet)
}

/// As a PNG with a palette.
fn indexed(sheet: &RgbImage) -> Result<Vec<u8>, Problem> {
    let pixels = DynamicImage::ImageRgb8(sheet.clone())
        .into_rgba8()
        .into_raw();
    let palette = NeuQuant::new(10, COLORS, &pixels);
    let indices: Vec<u8> = pixels
        .chunks_exact(4)
        .map(|pixel| palette.index_of(pixel) as u8)
        .collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, sheet.width(), sheet.height());
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(palette.color_map_rgb());
    encoder.set_compression(png::Compression::High);
    encoder.set_filter(png::Filter::NoFilter);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&indices)?;
    writer.finish()?;
    Ok(bytes)
}

fn unwritable(path: &Path, source: std::io::Error) -> Error {
    Error::Io {
        action: "write",
        path: path.to_owned(),
        source,
    }
}
