//! The examples do what they promise, and the README shows the shortest as it is.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::program::{self, Folder, TINY, done, no_device, path, text};
use image::imageops;
use serde_json::Value;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The path of a built example, beside the folder of the tests.
fn example(name: &str) -> PathBuf {
    let own = std::env::current_exe().expect("the test has a file");
    let built = own.parent().and_then(Path::parent).expect("it is in deps");
    let file = built
        .join("examples")
        .join(name)
        .with_extension(std::env::consts::EXE_EXTENSION);
    assert!(
        file.is_file(),
        "{} is missing: cargo build --release --examples",
        file.display()
    );
    file
}

/// What an example prints.
fn output(name: &str) -> String {
    let output = Command::new(example(name)).output().expect("it starts");
    let messages = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{name}: {messages}");
    text(&output.stdout)
}

/// The numbers of a table below its header.
fn table(csv: &str, header: &str) -> Vec<Vec<f64>> {
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some(header));
    let number = |cell: &str| {
        cell.parse()
            .unwrap_or_else(|_| panic!("{cell} is no number"))
    };
    lines
        .map(|line| line.split(',').map(number).collect())
        .collect()
}

#[test]
fn a_device_of_ones_own_ends_where_the_libraries_own_does() {
    if no_device() {
        return;
    }
    let hash = output("headless");
    assert!(
        hash.trim().len() == 16 && u64::from_str_radix(hash.trim(), 16).is_ok(),
        "{hash}"
    );
    let folder = Folder::new();
    let report = folder.file("x.json");
    let picture = folder.file("x.png");
    done(&[
        "render",
        "cube",
        "--steps",
        "100",
        "--size",
        "64x48",
        "--out",
        path(&picture),
        "--report",
        path(&report),
    ]);
    let report = program::report(&report);
    assert_eq!(report["state_hash"], hash.trim());
    // The host program takes the first device; the library may choose a better one.
    if ::myxo::gpu::devices().is_ok_and(|devices| devices.len() == 1) {
        assert_eq!(output("own_device"), hash);
    } else {
        assert_eq!(output("own_device").trim().len(), 16);
    }
}

#[test]
fn fields_are_read_step_by_step() {
    if no_device() {
        return;
    }
    let csv = output("own_loop");
    let rows = table(
        &csv,
        "step,trail_mass,mean,deviation,greatest,share_above_mean",
    );
    assert_eq!(rows.len(), 60);
    for (i, row) in rows.iter().enumerate() {
        let [step, mass, mean, deviation, greatest, above] = row[..] else {
            panic!("six columns: {row:?}");
        };
        assert_eq!(step, (i + 1) as f64);
        assert!(mass > 0.0 && greatest > mean && mean > 0.0, "{row:?}");
        assert!(above > 0.0 && above < 1.0, "{row:?}");
        assert!(deviation > 0.0, "{row:?}");
    }
    // Deposits come in faster than they decay at first, and patterns sharpen.
    let (first, last) = (&rows[0], &rows[59]);
    assert!(last[1] > 2.0 * first[1], "{first:?} {last:?}");
    assert!(last[3] > 2.0 * first[3], "{first:?} {last:?}");
}

#[test]
fn poses_from_outside_move_objects_and_take_particles_along() {
    if no_device() {
        return;
    }
    let rows = table(&output("poses"), "step,x,y,z,on_ring,on_ball");
    assert_eq!(rows.len(), 12);
    let at = |row: &[f64]| 1.5 * (row[0] / 120.0 * std::f64::consts::TAU).cos();
    for row in &rows {
        assert!(
            (row[1] - 1.0).abs() < 1e-4 && (row[2] - at(row)).abs() < 1e-3,
            "{row:?}"
        );
        assert_eq!(row[4] + row[5], 20_000.0, "no particle is lost: {row:?}");
    }
    let moved = rows.windows(2).any(|pair| pair[0][5] != pair[1][5]);
    assert!(
        moved,
        "particles change objects where these touch: {rows:?}"
    );
}

/// The alternatives: all are timed, and their results are compared.
#[test]
fn choices_are_timed_and_compared() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let out = folder.file("results");
    let output = Command::new(example("choices"))
        .args(["--quick", "--out", path(&out)])
        .args([
            "--set=particles.count=500",
            "--set=atlas.size=64",
            "--set=trail.decay=0.9",
        ])
        .output()
        .expect("it starts");
    let messages = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{messages}");
    let table = text(&output.stdout);
    let results = program::report(&out.join("choices.json"));
    let points = results["points"].as_array().expect("they are listed");
    // Six walks, two ways to count and five to read on each scene; then deposits alone, even and crowded.
    assert_eq!(points.len(), 2 * 13 + 2 * 2, "{table}");
    let found = |series: &str, what: &str| {
        let point = points.iter().find(|point| point["series"] == series);
        let point = point.unwrap_or_else(|| panic!("{series}: {table}"));
        let value = point["found"][what].as_f64();
        value.unwrap_or_else(|| panic!("{series} has no `{what}`: {point}"))
    };
    for point in points {
        let time = &point["time"];
        let order = ["median_low_ms", "median_ms", "median_high_ms"];
        let values = order.map(|key| time[key].as_f64().expect("it is a number"));
        assert!(values.is_sorted() && values[0] > 0.0, "{time}");
        let each = point["found"]["ns a particle"].as_f64();
        assert!(each.is_some_and(|ns| ns > 0.0), "{point}");
    }
    for walk in ["step", "way to a sensor"] {
        let off = |how: &str, what: &str| found(&format!("torus, {walk}: {how}"), what);
        assert!(off("exact edge test", "off: p95") < 1e-4, "{table}");
        assert!(off("exact edge test", "wrong triangle") < 0.01, "{table}");
        let corrected = off("corrected afterwards", "off: p95");
        assert!(corrected > 1e-4 && corrected < 1.0, "{table}");
        let once = off("corrected once", "off: p95");
        assert!(once >= 0.9 * corrected && once < 2.0, "{table}");
    }
    let most = |series: &str| {
        found(
            &format!("{series}, deposits: atomic adds"),
            "most in a texel",
        )
    };
    assert!(most("crowd") > 3.0 * most("even"), "{table}");
    for how in ["texel buffer", "storage block", "storage texels", "image"] {
        assert_eq!(
            found(&format!("torus, readings: {how}"), "differs: most"),
            0.0
        );
    }
    let sampled = found("torus, readings: sampler", "differs: p95");
    assert!(sampled < 0.05, "{table}");
    for name in [
        "choices_walks.svg",
        "choices_deposits.svg",
        "choices_readings.svg",
    ] {
        let svg = fs::read_to_string(out.join(name)).expect("it is written");
        assert!(
            svg.starts_with("<svg") && svg.contains("ns a particle") && svg.ends_with("</svg>\n"),
            "{name}"
        );
    }
    let written = fs::read_to_string(out.join("choices.txt")).expect("it is written");
    assert_eq!(written, table);
}

/// Everything in the file but its header stands in the README.
#[test]
fn the_readme_shows_the_ten_line_start() {
    let file = |name: &str| fs::read_to_string(root().join(name)).expect("it is there");
    let source = file("examples/headless.rs");
    let code: Vec<&str> = source
        .lines()
        .skip_while(|line| line.starts_with("//!") || line.is_empty())
        .collect();
    assert!(code.len() > 10, "{code:?}");
    let block = format!("```rust\n{}\n```", code.join("\n"));
    assert!(
        file("README.md").contains(&block),
        "the README lacks:\n{block}"
    );
}

#[test]
fn examples_say_what_they_are_for() {
    let mut names = Vec::new();
    for entry in fs::read_dir(root().join("examples")).expect("there are examples") {
        let file = entry.expect("it can be listed").path();
        let name = file
            .file_name()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        if name == "notebooks" {
            notebooks_say_what_they_are_for(&file);
        }
        let file = if name == "notebooks" {
            root().join("docs/python.md")
        } else if file.is_dir() {
            file.join("main.rs")
        } else {
            file
        };
        let source = fs::read_to_string(&file).expect("it is text");
        match file.extension().and_then(|ending| ending.to_str()) {
            Some("rs") => assert!(source.starts_with("//! "), "{name}"),
            Some("md") => {}
            Some("toml") => assert!(source.starts_with("# "), "{name}"),
            Some("py") => assert!(source.contains("\n\"\"\""), "{name}"),
            _ => panic!("{name}: what is it?"),
        }
        assert!(
            file_of("README.md").contains(&name),
            "the README does not name examples/{name}"
        );
        names.push(name);
    }
    assert!(names.len() >= 5, "{names:?}");
}

/// Notebooks begin with a heading, lie in the repository without results, and are on the page for Python.
fn notebooks_say_what_they_are_for(folder: &Path) {
    let page = file_of("docs/python.md");
    let entries = fs::read_dir(folder).expect("there are notebooks");
    let files = entries.map(|entry| entry.expect("it can be listed").path());
    let mut count = 0;
    for file in files.filter(|file| file.extension().is_some_and(|ending| ending == "ipynb")) {
        let name = file
            .file_name()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        let text = fs::read_to_string(&file).expect("it is text");
        let notebook: Value = serde_json::from_str(&text).expect("it is JSON");
        let cells = notebook["cells"].as_array().expect("it has cells");
        assert_eq!(cells[0]["cell_type"], "markdown", "{name}");
        let heading = cells[0]["source"][0].as_str().unwrap_or_default();
        assert!(heading.starts_with("# "), "{name}: {heading}");
        for cell in cells.iter().filter(|cell| cell["cell_type"] == "code") {
            assert_eq!(cell["outputs"], Value::Array(Vec::new()), "{name}");
        }
        assert!(page.contains(&name), "docs/python.md does not name {name}");
        count += 1;
    }
    assert!(count >= 5, "{count}");
}

fn file_of(name: &str) -> String {
    fs::read_to_string(root().join(name)).expect("it is there")
}

/// A Python with NumPy and matplotlib.
fn python() -> &'static str {
    let mut known = ["python3", "/usr/bin/python3"].into_iter();
    let found = known.find(|python| {
        let tried = Command::new(python)
            .args(["-c", "import numpy, matplotlib"])
            .output();
        tried.is_ok_and(|output| output.status.success())
    });
    found.expect("python3 with numpy and matplotlib: run .ci/setup test")
}

#[test]
fn python_reads_checks_and_plots_what_export_has_written() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let few = ["--steps", "30"];
    let several = [
        "trio",
        "--set",
        "particles.count=3000",
        "--set",
        "atlas.size=128",
    ];
    let fed = ["--set", "feeding.scattered=3", "--set", "feeding.amount=40"];
    for (scene, more, with_distance) in [
        (&TINY, &[][..], false),
        (&several, &[], true),
        (&TINY, &fed, false),
    ] {
        let (data, picture) = (folder.file("x.npz"), folder.file("x.png"));
        done(&[&["export"], &scene[..], more, &few, &["--out", path(&data)]].concat());
        let output = Command::new(python())
            .arg(root().join("examples/read_npz.py"))
            .args([&data, &picture])
            .output()
            .expect("it starts");
        let (said, messages) = (text(&output.stdout), text(&output.stderr));
        assert_eq!(output.status.code(), Some(0), "{said}{messages}");
        let particles = if with_distance { 3000 } else { 2000 };
        assert!(
            said.contains(&format!("checked: {particles} particles, ")),
            "{said}"
        );
        assert_eq!(said.contains("\ndistance "), with_distance, "{said}");
        let with_food = !more.is_empty();
        assert_eq!(said.contains("\nscent "), with_food, "{said}");
        let is_said = said.contains("food: 3 foods and markers, ") && !said.contains(", 0 meals");
        assert_eq!(is_said, with_food, "{said}");
        let plots = image::open(&picture).expect("it is a picture");
        assert!(plots.width() >= 1000 && plots.height() >= 500);
        // Every array is explained.
        let explained = file_of("docs/npz.md");
        for line in said
            .lines()
            .take_while(|line| !line.starts_with("checked") && !line.starts_with("food:"))
        {
            let name = line.split(' ').next().unwrap_or_default();
            assert!(
                explained.contains(&format!("`{name}`")),
                "{name} in docs/npz.md"
            );
        }
    }
}

/// Would catch: a check by which files are wrong in which particles have stayed, and have left no trail.
#[test]
fn python_checks_files_of_one_particle_a_cell() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let data = folder.file("x.npz");
    let run = ["export", "cube", "--steps", "5", "--out", path(&data)];
    let crowded = [
        "--set=particles.count=400",
        "--set=atlas.size=64",
        "--set=physarum.model=jones",
        "--set=physarum.speed=0.05",
    ];
    for more in [&[][..], &["--set=feeding.scattered=2"]] {
        done(&[&run[..], &crowded, more].concat());
        let output = Command::new(python())
            .arg(root().join("examples/read_npz.py"))
            .arg(&data)
            .output()
            .expect("it starts");
        let (said, messages) = (text(&output.stdout), text(&output.stderr));
        assert_eq!(output.status.code(), Some(0), "{said}{messages}");
        assert!(said.contains("checked: 400 particles, "), "{said}");
    }
}

/// Would catch: another layout of the ball, for which the map that comes with the experiment has walls in wrong places.
#[test]
fn the_walls_round_the_ball_fit_its_layout() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let (data, map) = (folder.file("ball.npz"), folder.file("map.png"));
    let scene = root().join("docs/experiments/ball_maze.toml");
    done(&[
        "export",
        path(&scene),
        "--set",
        "areas.map=",
        "--steps",
        "0",
        "--out",
        path(&data),
    ]);
    let output = Command::new(python())
        .arg(root().join("examples/ball_maze.py"))
        .args([&data, &map])
        .output()
        .expect("it starts");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let pixels = |file: &Path| image::open(file).expect("it is a picture").to_rgb8();
    let (drawn, kept) = (pixels(&map), pixels(&scene.with_extension("png")));
    assert!(drawn == kept, "draw docs/experiments/ball_maze.png again");
    let walls = drawn
        .pixels()
        .filter(|pixel| pixel.0 == [255, 0, 0])
        .count();
    assert!((10_000..30_000).contains(&walls), "{walls}");
}

#[test]
fn the_gallery_draws_what_is_named_and_no_more() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let out = folder.file("pictures");
    let drawn = Command::new(example("gallery"))
        .args([path(&out), "waves"])
        .output()
        .expect("it starts");
    assert!(drawn.status.success(), "{}", text(&drawn.stderr));
    let mut names: Vec<_> = fs::read_dir(&out)
        .expect("it is a folder")
        .map(|entry| entry.expect("it can be listed").file_name())
        .collect();
    names.sort();
    assert_eq!(names, ["presets.png", "waves.png"]);
    let [one, sheet] = ["waves.png", "presets.png"].map(|name| {
        let picture = image::open(out.join(name)).expect("it is a picture");
        picture.into_rgba8()
    });
    let (width, height) = one.dimensions();
    let on_sheet = imageops::crop_imm(&sheet, 0, 0, width, height).to_image();
    assert_eq!(one, on_sheet, "alone on the sheet");
    let below = imageops::crop_imm(&sheet, 0, height, width, sheet.height() - height).to_image();
    let letters = below.pixels().filter(|pixel| pixel.0[0] > 150);
    assert!(letters.count() > 20, "its name stands below");
    assert!(sheet.pixels().all(|pixel| pixel.0[3] == 255), "no gaps");
    let lit = one.pixels().filter(|pixel| pixel.0[0] > 100).count();
    assert!(lit > 5000, "{lit} bright pixels");
    let unknown = Command::new(example("gallery"))
        .args([path(&out), "wavs"])
        .output()
        .expect("it starts");
    assert!(!unknown.status.success());
    assert!(text(&unknown.stderr).contains("wavs"));
}

#[test]
fn the_guide_has_a_strip_for_each_row_of_its_table() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let table = folder.file("table.toml");
    let rows = r#"
scene = "cube"
steps = 2
set = ["particles.count=2000", "atlas.size=64"]
plain = ["trail.decay=0.95"]
own_looks = ["trio"]
[[strip]]
key = "trail.decay"
values = ["0.5", "0.95", "1"]
[[strip]]
key = "picture.show"
name = "views"
values = ["surface", "glow", "particles", "headings", "atlas"]
steps = 1
"#;
    fs::write(&table, rows).expect("it can be written");
    let out = folder.file("strips");
    let draw = |names: &[&str]| {
        let mut run = Command::new(example("guide"));
        let run = run.args([path(&table), path(&out)]).args(names);
        run.output().expect("it starts")
    };
    let drawn = draw(&[]);
    assert!(drawn.status.success(), "{}", text(&drawn.stderr));
    // Three side by side; four and one.
    for (name, columns, rows) in [("trail.decay", 3, 1), ("views", 4, 2)] {
        let strip = image::open(out.join(format!("{name}.png")));
        let strip = strip.expect("it is a picture").into_rgb8();
        assert_eq!(strip.width(), columns * 280 + (columns - 1) * 4, "{name}");
        assert_eq!(strip.height(), rows * (210 + 24), "{name}");
        let lit = strip.pixels().filter(|pixel| pixel.0[0] > 150).count();
        assert!(lit > 500, "{name}: {lit} bright pixels");
    }
    let unknown = draw(&["trail.decoy"]);
    assert!(!unknown.status.success());
    assert!(text(&unknown.stderr).contains("trail.decoy"));
}
