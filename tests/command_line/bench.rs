//! `myxo bench`: suites that end in a moment, their tables, files and plots, and what it refuses.

use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::Stdio;

use crate::program::{Folder, failed, myxo, no_device, path, program, refused, report, text};
use serde_json::Value;

/// Scenes that take a moment each.
const SMALL: [&str; 5] = [
    "--quick",
    "--runs=2",
    "--set=atlas.size=64",
    "--set=trail.decay=0.9",
    "--validate",
];
const FEW: &str = "--set=particles.count=500";

/// [`SMALL`], and more options.
fn small<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&SMALL[..], more].concat()
}

/// Runs a suite; returns its results and its table.
fn bench(suite: &str, folder: &Folder, options: &[&str]) -> (Value, String) {
    let out = folder.file("results");
    let arguments = ["bench", suite, "--out", path(&out)];
    let output = myxo(&[&arguments, options].concat());
    let messages = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{messages}");
    let results = report(&out.join(format!("{suite}.json")));
    assert_eq!(results["suite"], suite);
    for plot in results["plots"].as_array().expect("they are listed") {
        let file = out.join(plot.as_str().expect("it is a name"));
        check_plot(&file);
        check_plot(&file.with_extension("png"));
    }
    (results, text(&output.stdout))
}

/// Checks that the picture can be decoded and is not all white.
fn check_plot(file: &Path) {
    let bytes = std::fs::read(file).expect("it was written");
    if file.extension().is_some_and(|ending| ending == "svg") {
        let text = text(&bytes);
        assert!(text.starts_with("<svg ") && text.trim_end().ends_with("</svg>"));
        assert!(
            text.contains("<polyline") && text.contains("<text"),
            "{text}"
        );
        return;
    }
    let picture = image::load_from_memory(&bytes)
        .expect("it is a PNG")
        .to_rgb8();
    let drawn = picture.pixels().filter(|pixel| pixel.0 != [255; 3]).count();
    assert!(drawn > 2000, "{drawn} pixels");
    assert!(bytes.len() < 150_000, "{} bytes", bytes.len());
}

/// Checks that every point has its keys, and that axes ascend along series.
fn check_points(results: &Value) -> Vec<Value> {
    for key in [
        "about",
        "axis",
        "command",
        "version",
        "commit",
        "processor",
        "load_average",
        "host_load",
        "quick",
        "runs",
        "interrupted",
        "method",
        "skipped",
    ] {
        assert!(results.get(key).is_some(), "{key}");
    }
    let points = results["points"].as_array().expect("they are listed");
    let number = |value: &Value| value.as_f64().expect("it is a number");
    for point in points {
        let time = &point["time"];
        let order = [
            "min_ms",
            "median_low_ms",
            "median_ms",
            "median_high_ms",
            "max_ms",
        ];
        let values = order.map(|key| number(&time[key]));
        assert!(values.is_sorted() && values[0] > 0.0, "{time}");
        assert!(number(&time["std_ms"]) >= 0.0);
        let runs = point["runs_ms"].as_array().expect("they are listed");
        assert_eq!(runs.len() as f64, number(&results["runs"]), "{point}");
        for run in runs {
            assert!((values[1]..=values[3]).contains(&number(run)), "{point}");
        }
        let parts = point["parts"].as_array().expect("they are listed");
        assert!(!parts.is_empty(), "{point}");
        for part in parts {
            let [low, median, high] =
                ["median_low_ms", "median_ms", "median_high_ms"].map(|key| &part[key]);
            if low.is_number() {
                assert!([low, median, high].map(number).is_sorted(), "{part}");
            }
        }
        assert!(number(&point["triangles"]) > 0.0 && number(&point["steps"]) >= 2.0);
    }
    for pair in points.windows(2) {
        let is_same = pair[0]["series"] == pair[1]["series"] && pair[0]["also"] == pair[1]["also"];
        assert!(
            !is_same || number(&pair[0]["x"]) < number(&pair[1]["x"]),
            "{pair:?}"
        );
    }
    points.clone()
}

#[test]
fn particles_are_those_of_the_axis() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let (results, table) = bench("particles", &folder, &small(&["--up-to", "3e4"]));
    let points = check_points(&results);
    let of: Vec<(&str, u64)> = points
        .iter()
        .map(|point| {
            let series = point["series"].as_str().expect("it has one");
            (series, point["particles"].as_u64().expect("it is a number"))
        })
        .collect();
    let expected = [
        ("auto", 10_000),
        ("auto", 30_000),
        ("walk", 10_000),
        ("walk", 30_000),
    ];
    assert_eq!(of, expected);
    assert!(
        points.iter().all(|point| point["atlas_size"] == 64),
        "as set"
    );
    assert_eq!(
        results["plots"],
        serde_json::json!(["particles.svg", "particles_each.svg"])
    );
    let steps = points[0]["time"]["median_ms"].as_f64();
    let parts = points[0]["parts"].as_array().expect("they are listed");
    let sum: f64 = parts
        .iter()
        .filter_map(|part| part["mean_ms"].as_f64())
        .sum();
    let mean = points[0]["time"]["mean_ms"].as_f64();
    assert!(
        mean.is_some_and(|mean| sum <= mean && sum > 0.5 * mean),
        "{sum}, {steps:?}"
    );
    // The time between kernels is the rest of the mean step, and has a column.
    let between = points[0]["between_kernels_ms"].as_f64();
    let rest = mean.map(|mean| mean - sum);
    assert!(
        between.zip(rest).is_some_and(|(a, b)| (a - b).abs() < 1e-9),
        "{between:?}, {rest:?}"
    );
    assert!(table.contains(" other  between  memory\n"), "{table}");
    // Small steps are fast, so all positions between two sorts are measured.
    assert!(points.iter().all(|point| point["sort_places"] == 16));
    assert!(!table.contains("places between two sorts only"), "{table}");
    assert!(results["copy_bandwidth"]["gigabytes_per_second"].as_f64() > Some(0.0));
    for words in [
        "device ",
        "processor ",
        "commit ",
        "2 runs of each",
        "30,000",
    ] {
        assert!(table.contains(words), "{words}: {table}");
    }
    let names: Vec<String> = std::fs::read_dir(folder.file("results"))
        .expect("it is there")
        .map(|entry| {
            entry
                .expect("it can be listed")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    assert_eq!(names.len(), 6, "nothing else is left there: {names:?}");
    let file = std::fs::read_to_string(folder.file("results").join("particles.txt"));
    assert_eq!(file.expect("it is written"), table);
}

/// Takes long: every suite runs, with its smallest cases.
#[test]
fn every_suite_of_scenes_ends_with_points_and_plots() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    for (suite, up_to, expected) in [
        ("texture", "512", 2),
        ("edges", "3", 8),
        ("objects", "4", 8),
        ("transfer", "2", 18),
        ("distance", "2000", 6),
    ] {
        let mut options = small(&["--runs=1", "--up-to", up_to, FEW]);
        options.retain(|option| *option != "--runs=2");
        // Its axis is the side of the texture.
        options.retain(|option| suite != "texture" || *option != "--set=atlas.size=64");
        let (results, table) = bench(suite, &folder, &options);
        let points = check_points(&results);
        assert_eq!(points.len(), expected, "{table}");
        assert!(
            results["plots"]
                .as_array()
                .is_some_and(|plots| !plots.is_empty()),
            "{table}"
        );
        let is_set = points.iter().all(|point| point["particles"] == 500);
        assert!(is_set, "{suite}: --set reaches every scene");
        if suite == "transfer" {
            // Distances are computed in every step if objects move, otherwise only once.
            for point in &points {
                let parts = point["parts"].as_array().expect("they are listed");
                let has = parts.iter().any(|part| part["name"] == "distance");
                assert_eq!(has, point["also"]["cycles/s"] != 0.0, "{point}");
            }
            let mut words = table.split_whitespace();
            assert!(words.any(|word| word == "distance_tiles"), "{table}");
            assert!(words.any(|word| word == "other"), "{table}");
        }
    }
}

#[test]
fn suites_without_a_case_small_enough_are_left_out() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let out = folder.file("results");
    let arguments = ["bench", "--out", path(&out), "--up-to", "1"];
    let output = myxo(&[&arguments, &SMALL[..], &[FEW]].concat());
    let messages = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{messages}");
    assert!(
        messages.contains("no case of the suite `particles` is within --up-to 1")
            && messages.contains("it is left out"),
        "{messages}"
    );
    assert!(out.join("edges.json").exists() && out.join("objects.json").exists());
    assert!(!out.join("particles.json").exists() && !out.join("mesh.json").exists());
}

#[test]
fn meshes_need_no_device() {
    let folder = Folder::new();
    let options = ["--quick", "--up-to", "1500"];
    let (results, table) = bench("mesh", &folder, &options);
    let points = check_points(&results);
    let triangles: Vec<u64> = points
        .iter()
        .filter_map(|point| point["triangles"].as_u64())
        .collect();
    assert_eq!(triangles, [320, 1280]);
    assert!(results["device"].is_null());
    let message = failed(&["bench", "mesh", "--device", "0"]);
    assert!(
        message.contains("`--device` would change nothing"),
        "{message}"
    );
    let names: Vec<&Value> = points[0]["parts"]
        .as_array()
        .expect("they are listed")
        .iter()
        .map(|part| &part["name"])
        .collect();
    assert_eq!(names, ["load", "half-edges", "atlas"]);
    assert!(table.contains("by the host's clock"), "{table}");
}

/// A line says which cases are left out.
#[test]
fn cases_that_do_not_fit_are_listed() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    // 140 GB, which few devices have.
    let set = ["--quick", "--runs=1", "--set=particles.count=1_073_741_824"];
    let options = [&set[..], &["--up-to", "512"]].concat();
    let (results, table) = bench("texture", &folder, &options);
    let skipped = results["skipped"].as_array().expect("they are listed");
    assert_eq!(skipped.len() + check_points(&results).len(), 2, "{table}");
    assert!(!skipped.is_empty(), "{table}");
    for case in skipped {
        let [name, why] = ["case", "why"].map(|key| case[key].as_str().expect("it has text"));
        assert!(why.len() > 20, "{why}");
        assert!(
            table.contains(&format!("left out: {name}: {why}")),
            "{table}"
        );
    }
}

#[test]
fn suites_are_listed_and_others_refused() {
    let output = myxo(&["bench", "--list"]);
    let list = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0));
    let names: Vec<&str> = list
        .lines()
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    let expected = [
        "particles",
        "texture",
        "edges",
        "objects",
        "transfer",
        "distance",
        "mesh",
    ];
    assert_eq!(names, expected);
    let message = refused(2, &["bench", "partikles"]);
    assert!(message.contains("'particles'"), "{message}");
    let message = failed(&["bench", "choices"]);
    assert!(
        message.contains("particles, texture,") && message.contains("--example choices"),
        "{message}"
    );
    for wrong in ["0", "-5", "many", "nan"] {
        let message = refused(2, &["bench", "mesh", &format!("--up-to={wrong}")]);
        assert!(message.contains("a positive number"), "{message}");
    }
}

#[test]
fn wrong_folders_and_settings_are_refused_before_the_work() {
    let folder = Folder::new();
    let file = folder.with("file", "not a folder");
    let message = failed(&[
        "bench",
        "mesh",
        "--quick",
        "--out",
        path(&file.join("results")),
    ]);
    assert!(
        message.contains("cannot write") && message.contains("mesh.json"),
        "{message}"
    );
    let out = folder.file("results");
    let set = [
        "bench",
        "texture",
        "--out",
        path(&out),
        "--set",
        "particles.cuont=5",
    ];
    let message = failed(&set);
    assert!(message.contains("particles.count"), "{message}");
    let nothing = ["bench", "texture", "mesh", "--out", path(&out), "--up-to=5"];
    let message = failed(&nothing);
    assert!(
        message.contains("`texture`") && message.contains("begin at 256 texels"),
        "{message}"
    );
    // No suite is named, and none can be measured.
    let output = myxo(&["bench", "--out", path(&out), "--up-to=0.5"]);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(
        message.contains("no case of the suite `particles`")
            && message.ends_with("myxo: no suite has a case within --up-to 0.5: raise it\n"),
        "{message}"
    );
    let no_scenes = ["bench", "mesh", "--out", path(&out), "--set=atlas.size=512"];
    let message = failed(&no_scenes);
    assert!(message.contains("measures no scenes"), "{message}");
    for (suite, set) in [
        ("particles", "particles.count=3"),
        ("texture", "atlas.size=64"),
        ("objects", "object.0.scale=2"),
        ("transfer", "transfer.strategy=none"),
    ] {
        let out = ["--out", path(&out), "--set", set];
        let message = failed(&[&["bench", suite, "--quick"], &out[..]].concat());
        let key = set.split('=').next().expect("there is a key");
        let says = format!(
            "the suite `{suite}` sets {key} itself, so `--set {set}` would change nothing: "
        );
        assert!(message.contains(&says), "{message}");
    }
    if no_device() {
        return;
    }
    let device = [
        "bench",
        "texture",
        "--out",
        path(&out),
        "--device",
        "abacus",
    ];
    let message = failed(&device);
    assert!(message.contains("abacus"), "{message}");
}

/// After Ctrl-C the exit code says so, and the results so far are written.
#[cfg(unix)]
#[test]
fn an_interrupted_suite_keeps_what_it_has() {
    use crate::program::interrupt;
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let out = folder.file("results");
    let mut child = program()
        .args(["bench", "edges", "mesh", "--out", path(&out)])
        .args([
            "--set=particles.count=500",
            "--set=atlas.size=64",
            "--runs=1000",
        ])
        .env("RUST_LOG", "myxo=debug")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    // The program logs how many cases it has measured. After the first one there is something to keep.
    let messages = BufReader::new(child.stderr.take().expect("it is piped"));
    let mut messages = messages.lines().map(|line| line.expect("it is text"));
    assert!(
        messages.any(|line| line.contains("edges") && line.contains("cases")),
        "it ended before it had measured anything"
    );
    interrupt(&child);
    let status = child.wait().expect("it ends");
    assert_eq!(status.code(), Some(130));
    let results = report(&out.join("edges.json"));
    assert_eq!(results["interrupted"], true);
    assert!(
        results["points"]
            .as_array()
            .is_some_and(|points| !points.is_empty())
    );
    assert!(
        !out.join("mesh.json").exists(),
        "what comes after is not begun"
    );
}
