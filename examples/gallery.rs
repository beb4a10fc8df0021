//! Pictures of every scene and preset that comes with the program, and all presets on one sheet.
//!
//! `cargo run --release --example gallery -- FOLDER [NAME...]`
//!
//! Without names all are drawn, which takes minutes without a graphics card; `make gallery` does that. The sheet,
//! `presets.png`, shows the presets among them from the left to the right and from the top down, each with its name.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec2;
use image::{DynamicImage, RgbImage, RgbaImage, imageops};
use myxo::gpu::{Context, ContextOptions, Frames, default_cache_folder};
use myxo::render::offscreen::{FORMAT, Offscreen};
use myxo::render::{Renderer, View};
use myxo::scene::builtin::{PRESETS, SCENES};
use myxo::scene::{Overrides, Scene};
use myxo::sim::Simulation;
use myxo::{Error, Result};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

// Pictures with letters, as in the plots of the program.
#[path = "../src/cli/pixels.rs"]
mod pixels;
use pixels::Pixels;

const SIZE: [u32; 2] = [300, 200];
/// Until a scene's own look can be seen.
const SCENE_STEPS: u32 = 90;
/// Until a preset's can.
const PRESET_STEPS: u32 = 160;
/// Pictures in a row of the sheet, and pixels between them and below each for its name.
const COLUMNS: u32 = 4;
const GAP: u32 = 6;
const BAND: u32 = 30;
/// The sheet's own colours and letters.
const GROUND: RGBColor = RGBColor(14, 15, 19);
const INK: RGBColor = RGBColor(222, 224, 228);
const FONT: &str = "sans-serif";
const LETTERS: i32 = 20;

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let Some(folder) = arguments.next().map(PathBuf::from) else {
        return Err(Error::Invalid(
            "which folder? gallery FOLDER [NAME...]".to_owned(),
        ));
    };
    let names: Vec<String> = arguments.collect();
    let is_wanted = |name: &str| names.is_empty() || names.iter().any(|wanted| wanted == name);
    let known = |name: &String| SCENES.iter().chain(PRESETS).any(|known| known.name == name);
    if let Some(unknown) = names.iter().find(|name| !known(name)) {
        let text = format!("{unknown} is neither a scene nor a preset: `myxo scenes` lists them");
        return Err(Error::Invalid(text));
    }
    std::fs::create_dir_all(&folder).map_err(|source| unwritable(&folder, source))?;
    let ctx = Context::new(&ContextOptions {
        cache_folder: default_cache_folder(),
        ..ContextOptions::default()
    })?;
    for scene in SCENES.iter().filter(|scene| is_wanted(scene.name)) {
        let picture = picture(&ctx, scene.name, &Overrides::default(), SCENE_STEPS)?;
        save(&folder, scene.name, &picture)?;
    }
    let mut sheet = Vec::new();
    for preset in PRESETS.iter().filter(|preset| is_wanted(preset.name)) {
        // Those that are about several objects are shown on some.
        let scene = match preset.name {
            "shy" | "meeting" => "trio",
            _ => "sphere",
        };
        let overrides = Overrides {
            preset: Some(preset.name.to_owned()),
            set: vec!["particles.count=400000".to_owned()],
            seed: None,
        };
        let picture = picture(&ctx, scene, &overrides, PRESET_STEPS)?;
        save(&folder, preset.name, &picture)?;
        sheet.push((preset.name, picture));
    }
    if !sheet.is_empty() {
        let sheet = on_one_sheet(&sheet)
            .map_err(|problem| Error::Invalid(format!("the sheet of presets: {problem}")))?;
        save(&folder, "presets", &sheet)?;
    }
    Ok(())
}

/// A scene after so many steps.
fn picture(
    ctx: &Arc<Context>,
    scene: &str,
    overrides: &Overrides,
    steps: u32,
) -> Result<RgbaImage> {
    let scene = Scene::load(Path::new(scene), overrides)?;
    let mut simulation = Simulation::new(ctx, &scene)?;
    let mut renderer = Renderer::new(ctx, simulation.setup(), FORMAT)?;
    let offscreen = Offscreen::new(ctx, SIZE)?;
    let view = View::of(&scene, Vec2::new(SIZE[0] as f32, SIZE[1] as f32));
    let mut frames = Frames::new(ctx, 2)?;
    for _ in 0..steps {
        let mut rec = frames.begin()?;
        simulation.record_step(&mut rec);
        frames.submit(rec)?;
    }
    frames.run(|rec| {
        renderer.draw(rec, simulation.state(), &view, offscreen.canvas());
        offscreen.record_readback(rec);
    })?;
    Ok(offscreen.image())
}

type Problem = Box<dyn std::error::Error>;

/// Each with its name below.
fn on_one_sheet(pictures: &[(&str, RgbaImage)]) -> Result<RgbaImage, Problem> {
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
    for (i, (name, _)) in (0..).zip(pictures) {
        let (x, y) = place(i);
        let middle = ((x + SIZE[0] / 2) as i32, (y + SIZE[1] + BAND / 2) as i32);
        area.draw(&Text::new((*name).to_owned(), middle, style.clone()))?;
    }
    area.present()?;
    drop(area);
    let mut sheet = DynamicImage::ImageRgb8(sheet).into_rgba8();
    for (i, (_, picture)) in (0..).zip(pictures) {
        let (x, y) = place(i);
        imageops::replace(&mut sheet, picture, x.into(), y.into());
    }
    Ok(sheet)
}

fn save(folder: &Path, name: &str, picture: &RgbaImage) -> Result<()> {
    let file = folder.join(format!("{name}.png"));
    println!("{}", file.display());
    picture
        .save(&file)
        .map_err(|source| unwritable(&file, std::io::Error::other(source)))
}

fn unwritable(path: &Path, source: std::io::Error) -> Error {
    Error::Io {
        action: "write",
        path: path.to_owned(),
        source,
    }
}
