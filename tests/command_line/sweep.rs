//! `myxo sweep`: the same table however its runs done, and whatever ends it on the way.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use image::RgbImage;
use serde_json::Value;

use crate::program::{
    Folder, done, failed, myxo, no_device, path, program, refused, text, wait_until,
    with_files_up_to,
};

/// For two runs of a moment.
const PATIENCE: Duration = Duration::from_secs(120);

const STUDY: &str = r#"
scene = "cube"
steps = 5
seeds = 2
set."particles.count" = 500
set."atlas.size" = 64
[grid]
"physarum.sensor_angle" = [15.0, 30.0]
"trail.decay" = [0.9, 0.95]
"#;

/// The table without its times: for each run and seed, what it says.
fn table(out: &Path) -> BTreeMap<(String, String), BTreeMap<String, String>> {
    let file = out.join("table.csv");
    let mut reader = csv::Reader::from_path(&file).expect("there is a table");
    let mut rows = BTreeMap::new();
    for row in reader.deserialize() {
        let mut row: BTreeMap<String, String> = row.expect("it is a row");
        row.remove("seconds");
        rows.insert((row["run"].clone(), row["seed"].clone()), row);
    }
    rows
}

fn runs(out: &Path) -> usize {
    let is_row = |name: &str| name.ends_with(".json") && !name.starts_with('.');
    fs::read_dir(out.join("runs")).map_or(0, |files| {
        files
            .filter(|file| is_row(&file.as_ref().unwrap().file_name().to_string_lossy()))
            .count()
    })
}

/// Catches a run whose state is not that of the same scene alone, runs that are done twice, and shards that leave runs out.
#[test]
fn a_study_is_one_table_by_processes_and_by_shards() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let study = folder.with("study.toml", STUDY);
    let [all, parts] = ["all", "parts"].map(|name| folder.file(name));
    let said = done(&["sweep", path(&study), "--out", path(&all), "--workers", "2"]);
    assert!(said.contains("8 of 8 runs to do, by 2 processes"), "{said}");
    assert!(said.contains("8 runs done: "), "{said}");
    let rows = table(&all);
    assert_eq!(rows.len(), 8);
    let row = &rows[&("2".to_owned(), "1".to_owned())];
    assert_eq!(
        (&*row["physarum.sensor_angle"], &*row["trail.decay"]),
        ("30.0", "0.9")
    );
    let report = folder.file("report.json");
    let sets = [
        "particles.count=500",
        "atlas.size=64",
        "physarum.sensor_angle=30",
        "trail.decay=0.9",
    ];
    let mut alone = vec![
        "export",
        "cube",
        "--steps",
        "5",
        "--seed",
        "1",
        "--report",
        path(&report),
    ];
    let scene = folder.file("scene.toml");
    alone.extend(["--out", path(&scene)]);
    sets.iter().for_each(|set| alone.extend(["--set", set]));
    done(&alone);
    let report: Value = serde_json::from_slice(&fs::read(&report).unwrap()).unwrap();
    assert_eq!(report["state_hash"].as_str(), Some(&*row["state_hash"]));
    let commit = report["commit"].as_str().unwrap_or_default();
    assert_eq!((&*row["commit"], &*row["particles"]), (commit, "500"));
    let mut states: Vec<_> = rows.values().map(|row| &row["state_hash"]).collect();
    states.sort_unstable();
    states.dedup();
    assert_eq!(states.len(), 8);

    // Again: nothing is run.
    let said = done(&["sweep", path(&study), "--out", path(&all)]);
    assert!(
        !said.contains("to do") && said.contains("8 runs done"),
        "{said}"
    );
    for shard in ["1/3", "0/3", "2/3"] {
        done(&[
            "sweep",
            path(&study),
            "--out",
            path(&parts),
            "--workers",
            "1",
            "--shard",
            shard,
        ]);
    }
    assert_eq!(table(&parts), rows);
}

/// Catches measures of another graph than that of `myxo network`, and rows without them that count as done.
#[test]
fn a_study_has_measures_of_the_graph() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let [out, series] = ["out", "series.csv"].map(|name| folder.file(name));
    let study = STUDY.replace("seeds = 2", "seeds = 1");
    let plain = folder.with("plain.toml", &study);
    done(&["sweep", path(&plain), "--out", path(&out)]);
    let before = table(&out);
    assert!(before.values().all(|row| !row.contains_key("graph_length")));
    let study = folder.with("study.toml", format!("network = true\n{study}"));
    let said = done(&["sweep", path(&study), "--out", path(&out)]);
    assert!(said.contains("4 of 4 runs to do"), "{said}");
    let mut network = vec!["network", "cube", "--steps", "5", "--seed", "0"];
    network.extend(["--series", path(&series)]);
    let sets = [
        "particles.count=500",
        "atlas.size=64",
        "physarum.sensor_angle=15",
        "trail.decay=0.9",
    ];
    sets.iter().for_each(|set| network.extend(["--set", set]));
    done(&network);
    let run = ("0".to_owned(), "0".to_owned());
    let rows = table(&out);
    let row = &rows[&run];
    assert_eq!(row["state_hash"], before[&run]["state_hash"]);
    let mut reader = csv::Reader::from_path(&series).expect("it was written");
    let names = reader.headers().expect("it has names").clone();
    let values = reader.records().next().expect("it has a row");
    let values = values.expect("it is a row");
    let measures: Vec<_> = names.iter().zip(&values).skip(1).collect();
    assert_eq!(measures.len(), 16);
    for (name, value) in measures {
        assert_eq!(row[&format!("graph_{name}")], value, "{name}");
    }
    assert_eq!(row["graph_foods_reached"], "", "there is no food");
}

/// Catches rows that are lost when the sweep is killed, and a second sweep that writes into the same folder.
#[test]
#[cfg(unix)]
fn a_killed_sweep_goes_on_where_it_was() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let study = folder.with("study.toml", STUDY.replace("steps = 5", "steps = 60"));
    let out = folder.file("out");
    let arguments = ["sweep", path(&study), "--out", path(&out), "--workers", "1"];
    let mut run = program()
        .args(arguments)
        .stderr(Stdio::null())
        .spawn()
        .expect("it starts");
    wait_until("two runs", PATIENCE, || runs(&out) >= 2);
    let busy = failed(&arguments);
    assert!(busy.contains("another sweep writes into"), "{busy}");
    run.kill().expect("it runs");
    run.wait().expect("it ends");
    let before = runs(&out);
    assert!((2..8).contains(&before), "{before}");
    let said = done(&arguments);
    assert!(
        said.contains(&format!("{} of 8 runs to do", 8 - before)),
        "{said}"
    );
    assert_eq!(table(&out).len(), 8);
}

/// Catches a sweep that ends with a run that fails, one that cannot be tried again, and a worker that dies with all that comes after.
#[test]
#[cfg(unix)]
fn a_run_that_fails_is_a_row() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let out = folder.file("out");
    let study = STUDY
        .replace("[0.9, 0.95]", "[0.9, 7.0]")
        .replace("seeds = 2", "seeds = 1");
    let study = folder.with("study.toml", study);
    let arguments = ["sweep", path(&study), "--out", path(&out), "--workers", "1"];
    let output = myxo(&arguments);
    assert_eq!(output.status.code(), Some(1));
    let said = text(&output.stderr);
    assert!(
        said.contains("run 1: ") && said.contains("trail.decay"),
        "{said}"
    );
    assert!(said.contains("4 runs done, 2 failed (--retry)"), "{said}");
    let rows = table(&out);
    let errors: Vec<_> = rows.values().map(|row| !row["error"].is_empty()).collect();
    assert_eq!(errors, [false, true, false, true]);
    let retry = [&arguments[..], &["--retry"]].concat();
    let said = text(&myxo(&retry).stderr);
    assert!(said.contains("2 of 4 runs to do"), "{said}");
}

/// Catches half a row under its name, and a sweep that says that all went well.
#[test]
#[cfg(unix)]
fn a_full_disk_ends_a_sweep_and_loses_nothing() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let study = folder.with("study.toml", STUDY.replace("seeds = 2", "seeds = 1"));
    let out = folder.file("out");
    let arguments = ["sweep", path(&study), "--out", path(&out), "--workers", "1"];
    // Tables have no room; then, with long rows, not even those.
    let output = with_files_up_to(2, &arguments);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("raise the limit of file sizes"), "{said}");
    assert_eq!((runs(&out), out.join("table.parquet").exists()), (4, false));
    let more = [
        "physarum.speed",
        "physarum.deposit",
        "physarum.sensor_offset",
        "physarum.sensor_noise",
        "physarum.gravity_weight",
        "physarum.decrowding_weight",
        "physarum.distance_weight",
        "trail.diffusion",
    ];
    let more: String = more.map(|key| format!("\"{key}\" = [0.01]\n")).concat();
    let long = folder.with("long.toml", STUDY.replace("seeds = 2", "seeds = 1") + &more);
    let lost = folder.file("lost");
    let output = with_files_up_to(1, &["sweep", path(&long), "--out", path(&lost)]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("raise the limit of file sizes"), "{said}");
    assert_eq!(runs(&lost), 0);
    let parts = [out.clone(), out.join("runs"), lost.join("runs")]
        .map(|folder| fs::read_dir(folder).expect("it is there"));
    for file in parts.into_iter().flatten() {
        let name = file.expect("it is listed").file_name();
        assert!(!name.to_string_lossy().contains("myxo-part"), "{name:?}");
    }
    done(&arguments);
    assert_eq!(table(&out).len(), 4);
}

/// Where a picture lies in a larger one.
fn places_of(picture: &RgbImage, sheet: &RgbImage) -> Vec<[u32; 2]> {
    let [width, height] = [picture.width(), picture.height()];
    let is_at = |x: u32, y: u32| {
        picture
            .enumerate_pixels()
            .all(|(i, j, pixel)| sheet.get_pixel(x + i, y + j) == pixel)
    };
    let mut places = Vec::new();
    for y in 0..=sheet.height() - height {
        places.extend(
            (0..=sheet.width() - width)
                .filter(|&x| is_at(x, y))
                .map(|x| [x, y]),
        );
    }
    places
}

/// Catches runs that count as done without their picture, a sheet whose cells are other runs, one that is drawn again and again, and one
/// that stays when its study has another.
#[test]
fn a_grid_has_a_sheet_of_its_pictures() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let out = folder.file("out");
    let study = STUDY
        .replace("seeds = 2", "seeds = 1")
        .replace("steps = 5", "steps = 30");
    let plain = folder.with("plain.toml", &study);
    done(&["sweep", path(&plain), "--out", path(&out)]);
    let before = table(&out);
    assert!(!out.join("pictures").exists() && !out.join("sheet.png").exists());
    // With pictures it is the same study; its runs done again, with the same results.
    let study = folder.with("study.toml", format!("picture = \"40x30\"\n{study}"));
    let arguments = ["sweep", path(&study), "--out", path(&out), "--workers", "2"];
    let said = done(&arguments);
    assert!(
        said.contains("4 of 4 runs to do") && said.contains("a sheet of their pictures: "),
        "{said}"
    );
    let rows = table(&out);
    assert_eq!(rows, before);
    let read = |file: &Path| image::open(file).expect("it is a picture").into_rgb8();
    let file = out.join("sheet.png");
    let sheet = read(&file);
    let pictures: Vec<RgbImage> = rows
        .values()
        .map(|row| read(&out.join("pictures").join(format!("{}.png", row["key"]))))
        .collect();
    // Beside the pictures there is room for the names: `physarum.sensor_angle` for the rows, `trail.decay` for the columns.
    assert_eq!(
        sheet.dimensions(),
        (24 + 2 * 9 + 8 + 11 * 9 + 4, 52 + 21 * 9 + 4)
    );
    let mut first: Option<[u32; 2]> = None;
    for (number, picture) in (0_u32..).zip(&pictures) {
        assert_eq!(picture.dimensions(), (40, 30));
        // Each is once in the sheet.
        let places = places_of(picture, &sheet);
        assert_eq!(places.len(), 1, "picture {number}: {places:?}");
        let [x, y] = *first.get_or_insert(places[0]);
        let expected = [x + 44 * (number % 2), y + 34 * (number / 2)];
        assert_eq!(places[0], expected, "picture {number}");
    }
    // The same command runs nothing, and leaves the sheet.
    let written = || {
        fs::metadata(&file)
            .expect("it is there")
            .modified()
            .expect("it has a time")
    };
    let time = written();
    let said = done(&arguments);
    assert!(
        !said.contains("to do") && said.contains("4 runs done"),
        "{said}"
    );
    assert_eq!(written(), time);
    // A picture that is missing comes back.
    let lost = out.join("pictures").join(format!(
        "{}.png",
        rows[&("2".to_owned(), "0".to_owned())]["key"]
    ));
    fs::remove_file(&lost).expect("it is there");
    let said = done(&arguments);
    assert!(said.contains("1 of 4 runs to do"), "{said}");
    assert_eq!(read(&lost), pictures[2]);
    assert_eq!((table(&out), written()), (rows, time));
    // Pictures of another size are drawn again, and so is the sheet.
    let content = fs::read_to_string(&study).expect("it is there");
    fs::write(&study, content.replace("40x30", "50x30")).expect("there is room");
    let said = done(&arguments);
    assert!(said.contains("4 of 4 runs to do"), "{said}");
    assert_eq!(read(&lost).dimensions(), (50, 30));
    assert_ne!(read(&file).dimensions(), sheet.dimensions());

    // One that would be too large is not drawn, and the last one does not stay.
    let content = fs::read_to_string(&study).expect("it is there");
    fs::write(&study, content.replace("50x30", "5000x4")).expect("there is room");
    for to_do in [true, false] {
        let said = done(&arguments);
        assert_eq!(said.contains("to do"), to_do, "{said}");
        assert!(said.contains("no sheet.png will be drawn"), "{said}");
        assert!(!file.exists());
    }
}

/// Catches a view that a scene cannot show and that ends the sweep or its worker, costs runs their results, or has them done again and
/// again; and an outcome that depends on whether runs were done before.
#[test]
fn a_view_that_cannot_be_shown_costs_no_more_than_the_picture() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let study = STUDY.replace("seeds = 2", "seeds = 1");
    let varied = study.replace("[0.9, 0.95]", "[0.9]").replace(
        "[grid]",
        "[grid]\n\"picture.show\" = [\"atlas\", \"distance\"]",
    );
    let plain = folder.with("plain.toml", &varied);
    let seen = folder.with("seen.toml", format!("picture = \"40x30\"\n{varied}"));
    let [at_once, later] = ["at once", "later"].map(|name| folder.file(name));
    done(&["sweep", path(&plain), "--out", path(&later)]);
    let rows = table(&later);
    assert!(rows.values().all(|row| row["error"].is_empty()));
    for out in [&at_once, &later] {
        let sweep = |more: &[&str]| {
            let arguments = ["sweep", path(&seen), "--out", path(out)];
            let output = myxo(&[&arguments[..], more].concat());
            let said = text(&output.stderr);
            assert_eq!(output.status.code(), Some(1), "{said}");
            assert!(
                said.contains("4 runs done, 2 without a picture (--retry)"),
                "{said}"
            );
            assert_eq!(table(out), rows);
            said
        };
        let said = sweep(&[]);
        assert!(
            said.contains(
                "no picture: the view distance cannot be shown: it needs a second object"
            ),
            "{said}"
        );
        assert!(out.join("sheet.png").exists(), "with grey cells");
        let pictures = fs::read_dir(out.join("pictures")).expect("there are some");
        let is_picture = |name: &str| name.ends_with(".png");
        let count = pictures
            .filter(|file| is_picture(&file.as_ref().unwrap().file_name().to_string_lossy()))
            .count();
        assert_eq!(count, 2);
        let said = sweep(&[]);
        assert!(!said.contains("to do"), "{said}");
        let said = sweep(&["--retry"]);
        assert!(said.contains("2 of 4 runs to do"), "{said}");
    }
    // Where no run could have a picture, none is begun.
    let blind = study.replace("[grid]", "set.\"picture.show\" = \"distance\"\n[grid]");
    let blind = folder.with("blind.toml", format!("picture = \"40x30\"\n{blind}"));
    let out = folder.file("blind");
    let said = failed(&["sweep", path(&blind), "--out", path(&out)]);
    assert!(said.contains("the view distance cannot be shown"), "{said}");
    assert_eq!(runs(&out), 0);
}

#[test]
fn what_is_wrong_with_a_study_is_said_at_once() {
    let folder = Folder::new();
    let out = folder.file("out");
    let sweep = |study: &str| {
        let study = folder.with("study.toml", study);
        let said = failed(&["sweep", path(&study), "--out", path(&out)]);
        assert!(!out.exists(), "{said}");
        said
    };
    let said = sweep("[grid]\nphysarum.sped = [1]\n");
    assert!(
        said.contains("there is no parameter `physarum.sped`; do you mean `physarum.speed`?"),
        "{said}"
    );
    let said = sweep("scene = \"cube\"\nseed = 4\n[grid]\n");
    assert!(
        said.contains("study.toml:2: there is no key `seed` in a study; do you mean `seeds`?"),
        "{said}"
    );
    for picture in ["0x0", "large", "40", "16385x10"] {
        let said = sweep(&format!("picture = \"{picture}\"\n{STUDY}"));
        assert!(
            said.contains("study.toml:1: `picture` is WIDTHxHEIGHT, such as \"240x240\", each side from 1 to 16384")
                && said.contains(&format!("not \"{picture}\"")),
            "{said}"
        );
    }
    for (shard, why) in [
        ("3/3", "there is no shard 3 of 3"),
        ("x", "I/N is expected, such as 0/4"),
        ("1/", "I/N is expected"),
    ] {
        let study = folder.with("study.toml", STUDY);
        let said = refused(
            2,
            &["sweep", path(&study), "--out", path(&out), "--shard", shard],
        );
        assert!(said.contains(why), "{said}");
    }
    let said = failed(&["sweep", "no such study.toml", "--out", path(&out)]);
    assert!(said.contains("cannot read no such study.toml"), "{said}");
}

#[test]
fn another_study_in_the_folder_is_refused() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let out = folder.file("out");
    let study = folder.with("study.toml", STUDY.replace("seeds = 2", "seeds = 1"));
    done(&["sweep", path(&study), "--out", path(&out)]);
    let other = folder.with("other.toml", STUDY.replace("steps = 5", "steps = 6"));
    let said = failed(&["sweep", path(&other), "--out", path(&out)]);
    assert!(
        said.contains("holds another study: its steps is 5, and here it is 6"),
        "{said}"
    );
    // More seeds are the same study.
    let more = folder.with("study.toml", STUDY);
    let said = done(&["sweep", path(&more), "--out", path(&out)]);
    assert!(said.contains("4 of 8 runs to do"), "{said}");
}
