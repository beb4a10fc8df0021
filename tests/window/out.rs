//! Exports: pictures, recordings, films, models and data; each file is read and checked.

use std::path::{Path, PathBuf};

use myxo::scene::{Overrides, Scene};
use serde_json::Value;

use crate::program::{path, shown_of};
use crate::{Lab, SMALL, can_open};

/// Waits until nothing is being loaded and a notice contains this text.
#[track_caller]
pub fn hear_once_loaded(lab: &Lab, part: &str) {
    lab.wait(part, |seen| {
        let notice = seen["state"]["notice"].as_str();
        seen["state"]["loading"] == false && notice.is_some_and(|text| text.contains(part))
    });
}

/// Waits until a file is there; nothing has its name before it is whole.
#[track_caller]
pub fn arrived(lab: &Lab, name: &str) -> PathBuf {
    let file = lab.folder.file(name);
    lab.until(name, || file.exists().then_some(()));
    let seen = lab.wait("nothing is being written", |seen| {
        let state = &seen["state"];
        state["making"].is_null() && state["recording"] == false
    });
    assert_eq!(seen["state"]["making"], Value::Null);
    file
}

/// The size of a picture, which must not be all dark.
#[track_caller]
fn lit(file: &Path) -> (u32, u32) {
    let picture = image::open(file).expect("it is a picture").into_rgb8();
    let bright = |pixel: &&image::Rgb<u8>| pixel.0.iter().max() > Some(&60);
    let count = picture.pixels().filter(bright).count();
    let all = picture.pixels().count();
    assert!(20 * count > all, "{}: {count} of {all}", file.display());
    picture.dimensions()
}

/// The number of pixels that are covered in one picture only.
fn outlines_differ(one: &Path, other: &Path) -> usize {
    let [one, other] = [one, other].map(|file| image::open(file).expect("a picture").into_rgba8());
    let pairs = one.pixels().zip(other.pixels());
    pairs.filter(|(a, b)| a.0[3].abs_diff(b.0[3]) > 128).count()
}

/// Frames of a folder, by their names.
pub fn frames_in(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("it is a folder");
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

/// Paths in saved scenes are absolute, so that they can be opened from any folder.
#[track_caller]
pub fn assert_same(found: &str, wanted: &str, key: &str) {
    let is_path = key.ends_with("mask") || ["areas.map", "second_look.map"].contains(&key);
    let is_whole = is_path && found.ends_with(&format!("/{wanted}"));
    assert!(
        found == wanted || is_whole,
        "{key} is {found}, not {wanted}"
    );
}

/// Takes long: it writes every kind of file, films among them.
#[test]
fn every_export_is_whole() {
    if !can_open() {
        return;
    }
    let lab = Lab::open(&SMALL);
    lab.grows_beyond(30);
    lab.click_until("out", "out", true);

    // Pictures.
    lab.click("out.size=1080p");
    lab.click("out.picture");
    let picture = arrived(&lab, "screenshot_000001.png");
    assert_eq!(lit(&picture), (1920, 1080));
    lab.click("out.size=4K");
    lab.click("out.picture");
    let picture = arrived(&lab, "screenshot_000002.png");
    assert_eq!(lit(&picture), (3840, 2160));
    lab.click("out.size=window");
    lab.click("out.picture");
    let picture = arrived(&lab, "screenshot_000003.png");
    let [left, top, right, bottom] = lab.place("picture");
    let window = (right - left, bottom - top);
    let (width, height) = lit(&picture);
    let off = (f64::from(width) - window.0)
        .abs()
        .max((f64::from(height) - window.1).abs());
    assert!(off <= 1.0, "{width} x {height}, and not {window:?}");
    lab.click("out.size=custom");
    lab.type_until("out.width", 0.5, "640", "out.width", "640");
    lab.type_until("out.height", 0.5, "480", "out.height", "480");
    lab.click("out.transparent");
    lab.key("F12");
    let picture = arrived(&lab, "screenshot_000004.png");
    let picture = image::open(picture).expect("it is a picture").into_rgba8();
    assert_eq!(picture.dimensions(), (640, 480));
    assert!(
        picture.get_pixel(0, 0).0[3] < 12,
        "nothing but a little bloom is behind it"
    );
    assert_eq!(picture.get_pixel(320, 240).0[3], 255, "it is there");

    // A recording, by button and by key.
    lab.click("out.kind=PNG");
    lab.type_until("out.fps", 0.5, "10", "out.fps", "10");
    lab.click_until("out.record", "recording", true);
    lab.wait("frames come", |seen| {
        seen["state"]["recorded"].as_u64() >= Some(5)
    });
    lab.key("F9");
    lab.wait("it is written", |seen| seen["state"]["recording"] == false);
    let frames = frames_in(&lab.folder.file("recording_000001"));
    assert!(frames.len() >= 5, "{frames:?}");
    let size = lit(&frames[0]);
    assert!(frames.iter().all(|frame| lit(frame) == size));
    assert_ne!(
        std::fs::read(&frames[0]).unwrap(),
        std::fs::read(frames.last().unwrap()).unwrap(),
        "it has grown meanwhile"
    );

    // A film; GIF needs no other program.
    lab.click("out.kind=GIF");
    lab.click("out.film_size=custom");
    lab.type_until("out.seconds", 0.5, "0.5", "out.seconds", "0.5");
    lab.type_until("out.film_fps", 0.5, "20", "out.film_fps", "20");
    lab.type_until("out.every", 0.2, "3", "out.every", "3");
    lab.hold();
    let before = lab.step();
    lab.click("out.film");
    let film = arrived(&lab, "film_000001.gif");
    assert_eq!(lab.step(), before + 9 * 3);
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let file = std::fs::File::open(film).expect("it is there");
    let mut decoder = options.read_info(file).expect("it is a GIF");
    assert_eq!((decoder.width(), decoder.height()), (640, 480));
    let mut count = 0;
    while decoder.read_next_frame().expect("it is whole").is_some() {
        count += 1;
    }
    assert_eq!(count, 10);
    // A video of other sizes, with every frame.
    lab.click("out.kind=MP4");
    for (number, size, seconds, shown) in [
        (1, "4K", "0.1", ([3840, 2160], 2)),
        (2, "1080p", "0.2", ([1920, 1080], 4)),
    ] {
        lab.click(&format!("out.film_size={size}"));
        lab.type_until("out.seconds", 0.5, seconds, "out.seconds", seconds);
        lab.click("out.film");
        let film = arrived(&lab, &format!("film_{number:06}.mp4"));
        assert_eq!(shown_of(&film), shown);
    }
    lab.click("out.film_size=window");
    lab.click("out.film");
    let film = arrived(&lab, "film_000003.mp4");
    let ([width, height], frames) = shown_of(&film);
    let off = (f64::from(width) - window.0)
        .abs()
        .max((f64::from(height) - window.1).abs());
    // Videos have an even number of pixels.
    assert!(off <= 2.0 && frames == 4, "{width} x {height}, {frames}");
    // The camera goes half round the cube, an eighth of a turn a frame, so every second frame has the same outline. A folder of pictures
    // can be transparent.
    lab.click("out.kind=PNG");
    lab.click("out.film_transparent");
    lab.type_until("out.turns", 0.5, "0,5", "out.turns", "0.5");
    lab.type_until("out.every", 0.2, "1", "out.every", "1");
    lab.click("out.film");
    let frames = frames_in(&arrived(&lab, "film_000001"));
    let [first, between, alike, _] = &frames[..] else {
        panic!("{frames:?}");
    };
    let [between, alike] = [between, alike].map(|other| outlines_differ(first, other));
    assert!(between > 2000 && between > 10 * alike, "{between}, {alike}");
    lab.type_until("out.turns", 0.5, "0", "out.turns", "0");
    lab.click("out.film");
    let frames = frames_in(&arrived(&lab, "film_000002"));
    assert_eq!(frames.len(), 4);
    for frame in frames {
        let picture = image::open(frame).expect("it is a picture").into_rgba8();
        assert!(
            picture.get_pixel(0, 0).0[3] < 12,
            "nothing but bloom is behind it"
        );
        let there = picture.pixels().filter(|pixel| pixel.0[3] == 255);
        assert!(there.count() > 10_000, "it is there");
    }
    // Through a wide lens what is nearer or farther than the middle is out of focus: the outline is softer.
    lab.click("out.size=window");
    let partly_covered = [("5", "0.2"), ("6", "0")].map(|(number, lens)| {
        lab.type_until("out.lens", 0.5, lens, "out.lens", lens);
        lab.click("out.picture");
        let file = arrived(&lab, &format!("screenshot_00000{number}.png"));
        let picture = image::open(file).expect("it is a picture").into_rgba8();
        let partly = |pixel: &&image::Rgba<u8>| (20..236).contains(&pixel.0[3]);
        picture.pixels().filter(partly).count()
    });
    assert!(
        partly_covered[0] > 2 * partly_covered[1] && partly_covered[1] > 50,
        "{partly_covered:?}"
    );
    lab.type_until("out.film_lens", 0.5, "0.1", "out.film_lens", "0.1");
    lab.type_until("out.seconds", 0.5, "0.1", "out.seconds", "0.1");
    lab.click("out.film");
    assert_eq!(frames_in(&arrived(&lab, "film_000003")).len(), 2);
    lab.type_until("out.film_lens", 0.5, "0", "out.film_lens", "0");
    lab.click("out.kind=GIF");
    // A cancelled film leaves no file.
    lab.type_until("out.seconds", 0.5, "600", "out.seconds", "600");
    lab.click("out.film");
    lab.wait("it is begun", |seen| !seen["state"]["making"].is_null());
    lab.click("out.cancel");
    lab.wait("it is given up", |seen| seen["state"]["making"].is_null());
    assert!(!lab.folder.file("film_000002.gif").exists());
    // A film that is ended early is whole.
    lab.click("out.film");
    lab.click("out.finish");
    let film = arrived(&lab, "film_000002.gif");
    lab.wait("it has ended", |seen| seen["state"]["making"].is_null());
    assert!((1..12_000).contains(&shown_of(&film).1));

    // The state.
    for (label, file) in [
        ("GLB", "cube_000001.glb"),
        ("PLY", "cube_000001.ply"),
        ("NPZ", "cube_000001.npz"),
        ("Scene", "cube_000001.toml"),
        ("Checkpoint", "cube_000001.ckpt"),
    ] {
        lab.click(&format!("out.export={label}"));
        let file = arrived(&lab, file);
        assert!(file.metadata().unwrap().len() > 500, "{}", file.display());
    }
    let scene = Scene::read(&lab.folder.file("cube_000001.toml"), &Overrides::default());
    assert_eq!(scene.expect("it is a scene").1.particles.count, 3000);
    let model = gltf::Gltf::open(lab.folder.file("cube_000001.glb")).expect("it is a model");
    assert_eq!(model.meshes().count(), 1);
    // A model with its colours as a texture, and one with vertex colours.
    let colored = |model: &gltf::Gltf| {
        let primitives = model
            .meshes()
            .flat_map(|mesh| mesh.primitives().collect::<Vec<_>>());
        let of_vertices = gltf::Semantic::Colors(0);
        primitives.filter(|p| p.get(&of_vertices).is_some()).count()
    };
    assert_eq!((colored(&model), model.textures().count() > 0), (0, true));
    lab.click("out.colors=vertex colours");
    lab.click("out.export=GLB");
    let model = arrived(&lab, "cube_000002.glb");
    let model = gltf::Gltf::open(model).expect("it is a model");
    assert_eq!((colored(&model), model.textures().count()), (1, 0));
    lab.click("out.colors=texture");
    lab.click("out.export=GLB");
    let model = arrived(&lab, "cube_000003.glb");
    let model = gltf::Gltf::open(model).expect("it is a model");
    assert_eq!(colored(&model), 0);
    let now = lab.step();
    let checkpoint = myxo::sim::checkpoint::Checkpoint::read(&lab.folder.file("cube_000001.ckpt"));
    assert_eq!(checkpoint.expect("it is whole").snapshot.step, now);

    // Another folder, and an error where it cannot be written.
    let file = lab.folder.file("cube_000001.glb");
    lab.type_until("out.folder", 0.5, path(&file), "out.folder", path(&file));
    lab.click("out.export=PLY");
    lab.wait("it is said", |seen| {
        let notice = seen["state"]["notice"].as_str();
        notice.is_some_and(|text| text.contains("cannot write"))
    });
    let below = lab.folder.file("below");
    lab.type_until("out.folder", 0.5, path(&below), "out.folder", path(&below));
    lab.click("out.export=PLY");
    arrived(&lab, "below/cube_000001.ply");

    // The window is closed in the middle of a film: the file is whole.
    lab.click("out.film");
    lab.wait("it is begun", |seen| !seen["state"]["making"].is_null());
    lab.look_at(10);
    let folder = lab.folder.path().to_owned();
    let kept = below.join("film_000001.gif");
    lab.key("Escape");
    let lab = lab.quit_and_keep();
    let file = std::fs::File::open(kept).expect("it is there");
    let decoder = gif::DecodeOptions::new().read_info(file);
    assert!(decoder.expect("it is whole").read_next_frame().is_ok());
    let hidden = |folder: &Path| {
        let names = frames_in(folder).into_iter();
        let hidden =
            names.filter(|file| file.file_name().unwrap().to_string_lossy().starts_with('.'));
        hidden.collect::<Vec<_>>()
    };
    assert!(hidden(&folder).is_empty(), "{:?}", hidden(&folder));
    assert!(hidden(&below).is_empty(), "{:?}", hidden(&below));
    drop(lab);
}
