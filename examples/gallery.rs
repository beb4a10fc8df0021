//! Pictures of every scene and preset that comes with the program, and all presets on one sheet.
//!
//! `cargo run --release --example gallery -- FOLDER [NAME...]`
//!
//! Without names all are drawn, which takes minutes without a graphics card; `make gallery` does that. The sheet,
//! `presets.png`, shows the presets among them from the left to the right and from the top down.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec2;
use image::{Rgba, RgbaImage, imageops};
use myxo::gpu::{Context, ContextOptions, Frames, default_cache_folder};
use myxo::render::offscreen::{FORMAT, Offscreen};
use myxo::render::{Renderer, View};
use myxo::scene::builtin::{PRESETS, SCENES};
use myxo::scene::{Overrides, Scene};
use myxo::sim::Simulation;
use myxo::{Error, Result};

const SIZE: [u32; 2] = [300, 200];
/// Until a scene's own look can be seen.
const SCENE_STEPS: u32 = 90;
/// Until a preset's can.
const PRESET_STEPS: u32 = 160;
/// Pictures in a row of the sheet, and pixels between them.
const COLUMNS: u32 = 4;
const GAP: u32 = 6;

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
        let (scene, distance) = match preset.name {
            "shy" | "meeting" => ("trio", "3.2"),
            _ => ("sphere", "2.4"),
        };
        let overrides = Overrides {
            preset: Some(preset.name.to_owned()),
            set: vec![
                "particles.count=400000".to_owned(),
                format!("camera.distance={distance}"),
            ],
            seed: None,
        };
        let picture = picture(&ctx, scene, &overrides, PRESET_STEPS)?;
        save(&folder, preset.name, &picture)?;
        sheet.push(picture);
    }
    if !sheet.is_empty() {
        save(&folder, "presets", &on_one_sheet(&sheet))?;
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
    let mut rec = frames.begin()?;
    renderer.draw(&mut rec, simulation.state(), &view, offscreen.canvas());
    offscreen.record_readback(&mut rec);
    frames.submit(rec)?;
    frames.wait_idle()?;
    Ok(offscreen.image())
}

fn on_one_sheet(pictures: &[RgbaImage]) -> RgbaImage {
    let columns = COLUMNS.min(pictures.len() as u32);
    let rows = (pictures.len() as u32).div_ceil(columns);
    let [width, height] = SIZE.map(|side| side + GAP);
    let mut sheet = RgbaImage::from_pixel(
        columns * width - GAP,
        rows * height - GAP,
        Rgba([0, 0, 0, 0]),
    );
    for (i, picture) in (0..).zip(pictures) {
        let [x, y] = [i % columns * width, i / columns * height].map(i64::from);
        imageops::replace(&mut sheet, picture, x, y);
    }
    sheet
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
