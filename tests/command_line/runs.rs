//! Runs without a window: the same bits every time, resumed runs, whole files.

use std::io::{BufRead as _, BufReader, Read as _};
use std::path::Path;
use std::process::Stdio;

use crate::program::{
    Folder, TINY, difference_of, done, failed, myxo, no_device, path, program, report, shown_of,
    text,
};
use myxo::scene::Settings;
use myxo::sim::food::MEASURING;
use serde_json::Value;

/// Renders [`TINY`] and returns the report.
#[track_caller]
fn render(folder: &Folder, name: &str, options: &[&str]) -> Value {
    let (picture, file) = (
        folder.file(format!("{name}.png")),
        folder.file(format!("{name}.json")),
    );
    let files = ["--out", path(&picture), "--report", path(&file)];
    let size = ["--size", "64x48"];
    done(&[&["render"], &TINY[..], &files, &size, options].concat());
    report(&file)
}

fn hash(report: &Value) -> &str {
    report["state_hash"].as_str().expect("there is a hash")
}

#[test]
fn networks_are_measured_along_the_way() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let report = render(
        &folder,
        "measured",
        &["--steps", "7", "--measure-every", "3"],
    );
    let measures = report["measures"].as_array().expect("they are listed");
    let steps: Vec<_> = measures.iter().map(|m| m["step"].as_u64()).collect();
    assert_eq!(steps, [Some(3), Some(6), Some(7)], "the last step, too");
    for measure in measures {
        let number = |key: &str| measure[key].as_f64().expect(key);
        assert!(number("mean_trail") > 0.0 && number("length") > 0.0);
        assert!(0.0 < number("covered") && number("covered") < 1.0);
        // Particles have just deposited, so they are on the network.
        assert!(number("on_network") > number("covered"));
        assert!(number("pieces") >= 1.0 && number("regions") >= 1.0);
        let objects = measure["objects"].as_array().expect("they are listed");
        assert_eq!(objects.len(), 1);
        assert_eq!(objects[0]["particles"], report["particles"]);
        assert_eq!(objects[0]["length"], measure["length"]);
    }
    // Measuring changes nothing.
    let plain = render(&folder, "plain", &["--steps", "7"]);
    assert_eq!(hash(&plain), hash(&report));
    assert!(plain.get("measures").is_none());
}

#[test]
fn same_scene_and_seed_same_hash() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let steps = ["--steps", "12", "--hash-every", "4"];
    let run = |name, options: &[&str]| render(&folder, name, &[&steps, options].concat());
    let a = run("a", &[]);
    assert_eq!(hash(&run("b", &[])), hash(&a));
    let others = [
        run("seed", &["--seed", "8"]),
        run("set", &["--set", "trail.decay=0.5"]),
        run("preset", &["--preset", "cells"]),
    ];
    for other in &others {
        assert_ne!(hash(other), hash(&a), "{}", other["command"]);
    }
    assert_eq!(others[0]["seed"], 8);

    let hashes: Vec<_> = a["hashes"]
        .as_array()
        .expect("they are listed")
        .iter()
        .collect();
    let steps: Vec<_> = hashes.iter().map(|hash| hash["step"].as_u64()).collect();
    assert_eq!(steps, [Some(4), Some(8), Some(12)]);
    assert_eq!(hashes[2]["hash"], a["state_hash"]);

    let compare = |other: &str| {
        let [a, b] = ["a", other].map(|name| folder.file(format!("{name}.json")));
        let output = myxo(&["compare", path(&a), path(&b)]);
        (output.status.code(), text(&output.stdout))
    };
    let (code, equal) = compare("b");
    assert!(
        code == Some(0) && equal.starts_with("state      equal"),
        "{equal}"
    );
    let (code, differs) = compare("seed");
    assert!(
        code == Some(1) && differs.starts_with("state      DIFFERS"),
        "{differs}"
    );
    for part in ["from step 4 on", "seed       differs   7 -> 8", "advance"] {
        assert!(differs.contains(part), "{part} in {differs}");
    }
    assert!(!differs.contains("settings "), "{differs}");
    let doubts = differs.contains("note: one run each: ");
    let is_timed = a["gpu_ms_per_step"].is_number();
    assert_eq!(doubts, is_timed, "{differs}");
    let (_, differs) = compare("set");
    let key = "settings   differ    trail.decay = 0.5, which was 0.93\n";
    assert!(differs.contains(key), "{differs}");
    assert_eq!(differs.matches("settings ").count(), 1, "{differs}");
}

#[test]
fn a_report_has_everything_about_a_run() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let report = render(&folder, "x", &["--steps", "5"]);
    for key in [
        "device",
        "driver",
        "state_hash",
        "command",
        "version",
        "processor",
    ] {
        assert!(
            report[key].as_str().is_some_and(|text| !text.is_empty()),
            "{key}"
        );
    }
    assert_eq!(report["scene"], "cube");
    assert_eq!(report["settings"]["particles"]["count"], 2000);
    assert_eq!(report["settings"]["object"][0]["mesh"], "builtin:cube");
    assert_eq!(report["steps"], 5);
    assert_eq!(report["particles"], 2000);
    assert_eq!(report["atlas_size"], 64);
    assert_eq!(report["triangles"], 12);
    assert_eq!(report["interrupted"], false);
    assert_eq!(report["validation"], false);
    assert_eq!(report["counters"]["lost"], 0);
    assert_eq!(report["counters"]["doubled"], 0);
    assert!(report["counters"]["trail_mass"].as_f64() > Some(0.0));
    assert!(
        report["command"]
            .as_str()
            .is_some_and(|words| words.contains(" render cube --set "))
    );
    assert!(report["wall_ms_per_step"].as_f64() > Some(0.0));
    assert!(report.get("host_step").is_none(), "it is not measured");
    assert_eq!(report["load_average"].as_array().map(Vec::len), Some(3));
    assert!(
        report["host_load"]["is_busy"].is_boolean(),
        "{}",
        report["host_load"]
    );
    // A checkout has a commit; an unpacked archive has none.
    let commit = report.get("commit").expect("the key is there");
    assert_eq!(
        commit.as_str().map(str::len),
        myxo::commit().map(|commit| commit.len())
    );

    let kernels = report["kernels"].as_array().expect("they are listed");
    let mut names: Vec<_> = kernels
        .iter()
        .filter_map(|row| row["name"].as_str())
        .collect();
    names.sort_unstable();
    assert_eq!(
        names,
        [
            "advance",
            "diffuse",
            "diffuse_seams",
            "exchange_seams",
            "update",
            "walk_sensors"
        ]
    );
    for row in kernels {
        // The list of walkers is cleared: its length, and the groups of its dispatch.
        let times = if row["name"] == "update" { 2.0 } else { 1.0 };
        assert_eq!(row["dispatches_per_step"], times, "{row}");
    }
    if report["gpu_ms_per_step"].is_number() {
        for row in kernels {
            for key in ["mean_ms", "median_ms", "p95_ms", "share"] {
                assert!(row[key].as_f64() > Some(0.0), "{key} in {row}");
            }
            // The length of the list is known only on the device.
            let lists = row["name"] == "walk_sensors" || row["name"] == "update";
            let per_second = row["throughput"]["per_second"].as_f64();
            assert_eq!(per_second > Some(0.0), !lists, "{row}");
        }
    }
}

/// Particles are sorted in every 16th step; the times of the sort are those of the steps that have it.
#[test]
fn kernels_of_some_steps_have_the_times_of_these() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    // The first step is not measured.
    let report = render(&folder, "x", &["--steps", "33"]);
    if report["gpu_ms_per_step"].is_null() {
        return;
    }
    let number = |value: &Value| value.as_f64().expect("it is measured");
    let kernels = report["kernels"].as_array().expect("they are listed");
    let sort = kernels.iter().find(|row| row["name"] == "sort_scatter");
    let sort = sort.expect("it was sorted");
    assert_eq!(number(&sort["of_steps"]), 2.0 / 32.0, "{sort}");
    let [mean, median, low] = ["mean_ms", "median_ms", "min_ms"].map(|key| number(&sort[key]));
    assert!(mean < low && low <= median, "{sort}");
    let sum: f64 = kernels.iter().map(|row| number(&row["mean_ms"])).sum();
    assert!(sum <= number(&report["gpu_ms_per_step"]), "{report}");
}

/// Odd sizes, and every kind of file at once.
#[test]
fn one_run_writes_files_of_every_kind() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let mut arguments = vec!["render"];
    arguments.extend(TINY);
    arguments.extend(["--steps", "7", "--every", "2", "--size", "333x77"]);
    let names = ["x.png", "x.gif", "x.mp4", "s/x_%03d.png", "folder/"];
    let files = names.map(|name| folder.file(name));
    for file in &files {
        arguments.extend(["--out", path(file)]);
    }
    let messages = done(&arguments);
    assert_eq!(folder.names(), ["folder", "s", "x.gif", "x.mp4", "x.png"]);
    for file in files.iter().take(3) {
        assert!(messages.contains(path(file)), "{messages}");
    }
    // Steps 2, 4 and 6, and the last one.
    let pictures = [
        folder.file("x.png"),
        folder.file("s/x_000.png"),
        folder.file("s/x_003.png"),
        folder.file("folder/frame_00003.png"),
    ];
    let size = |file: &Path| image::open(file).map(|picture| (picture.width(), picture.height()));
    for picture in &pictures {
        assert_eq!(size(picture).expect("it is whole"), (333, 77));
    }
    assert!(!folder.file("s/x_004.png").exists());
    let bytes = |file: &Path| std::fs::read(file).expect("it was written");
    assert_eq!(
        bytes(&pictures[0]),
        bytes(&pictures[2]),
        "the last one is the last one"
    );
    assert_ne!(
        bytes(&pictures[0]),
        bytes(&pictures[1]),
        "something has grown"
    );
    assert_eq!(gif_frames(&files[1]), 4);
    let (_, frames) = shown_of(&files[2]);
    assert_eq!(frames, 4, "every one that was drawn");
    assert_eq!(&bytes(&files[2])[4..8], b"ftyp");
}

#[test]
fn films_begin_at_the_step_of_from() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let film = folder.file("x/");
    let mut arguments = vec!["render"];
    arguments.extend(TINY);
    arguments.extend(["--every", "2", "--out", path(&film)]);
    let from = |steps, from| [&arguments[..], &["--steps", steps, "--from", from]].concat();
    done(&from("8", "3"));
    // Steps 5 and 7, and the last one.
    let names = std::fs::read_dir(&film).expect("it is a folder").count();
    assert_eq!(names, 3);
    let message = failed(&from("3", "3"));
    assert!(
        message.contains("--from 3 leaves out all of the 3 steps"),
        "{message}"
    );
    let picture = folder.file("x.png");
    let mut alone = vec!["render"];
    alone.extend(TINY);
    alone.extend(["--steps", "3", "--from", "1", "--out", path(&picture)]);
    let message = failed(&alone);
    assert!(message.contains("no --out is one"), "{message}");
}

/// The third of four pictures of half a turn is seen from a quarter of it.
#[test]
fn cameras_of_films_go_round_the_scene() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let (film, other_side) = (folder.file("film/"), folder.file("side.png"));
    let azimuth = Settings::default().camera.azimuth;
    let picture = |steps, out: &Path, more: &[&str]| {
        let mut arguments = vec!["render"];
        arguments.extend(TINY);
        arguments.extend(["--set", "camera.distance=4", "--set", "picture.brightest=1"]);
        arguments.extend(["--size", "160x90", "--steps", steps, "--out", path(out)]);
        arguments.extend(more);
        done(&arguments);
    };
    picture("4", &film, &["--every", "1", "--turns", "0.5"]);
    let azimuth = format!("camera.azimuth={}", azimuth + 90.0);
    picture("3", &other_side, &["--set", &azimuth]);
    let difference = |number: u32| {
        let frame = folder.file(format!("film/frame_{number:05}.png"));
        difference_of(&frame, &other_side)
    };
    let differences: Vec<f64> = (0..4).map(difference).collect();
    assert!(differences[2] < 0.2, "{differences:?}");
    assert!(
        differences[1] > 1.0 && differences[3] > 1.0,
        "{differences:?}"
    );

    let with = |more: &[&str]| {
        let mut arguments = vec!["render"];
        arguments.extend(TINY);
        arguments.extend(["--steps", "3", "--turns", "1", "--out"]);
        failed(&[&arguments[..], more].concat())
    };
    let picture = folder.file("x.png");
    let message = with(&[path(&picture)]);
    assert!(
        message.contains("--turns is for sequences and films"),
        "{message}"
    );
    let film = folder.file("x/");
    let message = with(&[path(&film), "--view", "atlas"]);
    assert!(
        message.contains("the view atlas, which is flat"),
        "{message}"
    );
    assert_eq!(folder.names(), ["film", "side.png"]);
}

fn gif_frames(file: &Path) -> usize {
    let file = std::fs::File::open(file).expect("it was written");
    let mut decoder = gif::DecodeOptions::new()
        .read_info(BufReader::new(file))
        .expect("it is a GIF");
    let mut count = 0;
    while decoder.read_next_frame().expect("it is whole").is_some() {
        count += 1;
    }
    count
}

/// Would catch: the time of the set-up as that of a step where there was none.
#[test]
fn no_steps_show_the_start() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let film = folder.file("x.gif");
    let options = ["--steps", "0", "--out", path(&film), "--hash-every", "1"];
    let report = render(&folder, "x", &options);
    assert_eq!(report["steps"], 0);
    assert_eq!(report["counters"]["trail_mass"], 0.0);
    assert!(report["gpu_ms_per_step"].is_null() && report.get("hashes").is_none());
    assert!(report["wall_ms_per_step"].is_null(), "{report}");
    assert_eq!(gif_frames(&film), 1);
    assert_eq!(folder.names(), ["x.gif", "x.json", "x.png"]);
}

/// A lot of food with a large radius takes minutes to measure.
#[cfg(unix)]
#[test]
fn ctrl_c_stops_the_measuring_of_food() {
    use crate::program::{interrupted, logging_its_parts};
    use std::time::Duration;
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let picture = folder.file("fed.png");
    let settings = [
        "particles.count=2000",
        "atlas.size=240",
        "feeding.scattered=256",
        "feeding.radius=10",
    ];
    let mut run = program();
    run.args(["render", "torus", "--steps", "1", "--out", path(&picture)]);
    run.args(settings.iter().flat_map(|set| ["--set", set]));
    let run = logging_its_parts(&mut run)
        .env("XDG_CACHE_HOME", folder.file("cache"))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let output = interrupted(run, MEASURING, Duration::from_secs(10));
    let message = text(&output.stderr);
    assert!(
        message.ends_with("myxo: interrupted while setting up\n"),
        "{message}"
    );
    assert!(!picture.exists());
}

/// Ctrl-C in a long render gives whole files, a checkpoint and exit code 130; the resumed run ends in the same hash as one without
/// interruption.
#[cfg(unix)]
#[test]
fn interrupted_and_resumed_ends_in_the_same_hash() {
    use crate::program::interrupt;
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let names = ["x.png", "x.gif", "x.mp4", "x.json", "x.state"];
    let [picture, gif, film, record, state] = names.map(|name| folder.file(name));
    let mut child = program()
        .arg("render")
        .args(TINY)
        .args(["--steps", "1000000", "--size", "64x48", "--hash-every", "3"])
        .args([
            "--out",
            path(&picture),
            "--out",
            path(&gif),
            "--out",
            path(&film),
        ])
        .args(["--report", path(&record), "--checkpoint", path(&state)])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut messages = BufReader::new(child.stderr.take().expect("it is piped"));
    let mut line = String::new();
    while !line.starts_with("step 6: ") {
        line.clear();
        let length = messages.read_line(&mut line).expect("it is UTF-8");
        assert!(length > 0, "it ends before step 6");
    }
    interrupt(&child);
    let mut rest = String::new();
    messages.read_to_string(&mut rest).expect("it is UTF-8");
    let status = child.wait().expect("it ends");
    assert_eq!(status.code(), Some(130), "{rest}");
    assert!(rest.contains("interrupted: finishing the files"), "{rest}");

    let interrupted = report(&record);
    assert_eq!(interrupted["interrupted"], true);
    let steps = interrupted["steps"].as_u64().expect("it is a number");
    assert!((6..1_000_000).contains(&steps), "{steps}");
    let mut expected = names.to_vec();
    expected.sort_unstable();
    assert_eq!(folder.names(), expected, "nothing else is left behind");
    assert!(image::open(&picture).is_ok());
    assert!(gif_frames(&gif) as u64 >= steps / 2);
    assert_eq!(
        &std::fs::read(&film).expect("it was written")[4..8],
        b"ftyp"
    );

    let resumed = render(
        &folder,
        "resumed",
        &["--resume", path(&state), "--steps", "9"],
    );
    let straight = render(&folder, "straight", &["--steps", &(steps + 9).to_string()]);
    assert_eq!(resumed["steps"], 9);
    assert_eq!(hash(&resumed), hash(&straight));
}

/// Would catch: a run under `nohup`, or in the background of a script, that ends with its terminal or by a Ctrl-C for another program.
#[cfg(unix)]
#[test]
fn signals_that_were_ignored_stay_ignored() {
    use crate::program::signal;
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let picture = folder.file("x.png");
    let mut child = std::process::Command::new("sh")
        .args(["-c", "trap '' HUP INT; exec \"$@\"", "sh"])
        .arg(program().get_program())
        .arg("render")
        .args(TINY)
        .args(["--steps", "1000000", "--size", "64x48", "--hash-every", "3"])
        .args(["--out", path(&picture)])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("there is a shell");
    let messages = BufReader::new(child.stderr.take().expect("it is piped"));
    let mut messages = messages.lines().map(|line| line.expect("it is text"));
    assert!(messages.any(|line| line.starts_with("step 6: ")));
    signal(&child, "HUP");
    signal(&child, "INT");
    let next: Vec<String> = messages.by_ref().take(20).collect();
    assert!(
        next.len() == 20 && next.iter().all(|line| line.starts_with("step ")),
        "{next:?}"
    );
    signal(&child, "TERM");
    let rest: Vec<String> = messages.collect();
    assert_eq!(child.wait().expect("it ends").code(), Some(130), "{rest:?}");
    assert!(picture.exists(), "{rest:?}");
}

#[test]
fn states_that_cannot_be_resumed_are_refused() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let state = folder.file("x.state");
    let profile = |scene: &str, options: &[&str]| {
        let mut arguments = vec!["profile", scene];
        arguments.extend(&TINY[1..]);
        arguments.extend(["--steps", "2", "--warmup", "1"]);
        arguments.extend(options);
        arguments.into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    done(&profile("cube", &["--checkpoint", path(&state)]));

    let resume = ["--resume", path(&state)];
    let with = |options: &[&str]| profile("cube", &[&resume, options].concat());
    let messages = done(&with(&[
        "--set",
        "trail.decay=0.5",
        "--set",
        "camera.azimuth=1",
    ]));
    assert!(
        messages.contains("continues from step 3; trail.decay = 0.5, which was 0.93\n"),
        "{messages}"
    );
    let message = failed(&with(&["--set", "particles.count=1999", "--seed", "8"]));
    for part in [
        "cannot resume from ",
        "x.state: the scene here has seed = 8, which was 7, and particles.count = 1999, which was 2000; resume with",
    ] {
        assert!(message.contains(part), "{part} in {message}");
    }
    let message = failed(&with(&["--set", "trail.diffusion_distance=2"]));
    assert!(
        message.contains("trail.diffusion_distance = 2, which was 1;"),
        "{message}"
    );
    let message = failed(&profile("builtin:icosphere?subdivisions=1", &resume));
    assert!(message.contains("the scene here has "), "{message}");
    // Equally many triangles, and equal settings.
    let object = "[[object]]\nname = \"cube\"\nmesh = \"builtin:cube\"\nscale = 1.5\n";
    let larger = folder.with("larger.toml", format!("radius = 1.7320508\n{object}"));
    let message = failed(&profile(path(&larger), &resume));
    assert!(message.contains("the scene here has "), "{message}");

    let whole = std::fs::read(&state).expect("it was written");
    let damaged = |change: fn(&mut Vec<u8>), expected: &str| {
        let mut bytes = whole.clone();
        change(&mut bytes);
        let file = folder.with("damaged.state", bytes);
        let message = failed(&profile("cube", &["--resume", path(&file)]));
        let says = format!("damaged.state: {expected}");
        assert!(message.contains(&says), "{says} in {message}");
    };
    damaged(|bytes| bytes[5000] ^= 1, "its checksum is wrong");
    damaged(|bytes| bytes.truncate(9000), "its checksum is wrong");
    damaged(|bytes| bytes.truncate(11), "the file is cut short");
    damaged(|bytes| bytes.clear(), "it is not a checkpoint of myxo");
    damaged(
        |bytes| bytes[8] = 77,
        "it has version 77, this program reads versions 6 to 8",
    );
    let message = failed(&profile("cube", &["--resume", path(&folder.file(""))]));
    assert!(message.contains("cannot read "), "{message}");
    if Path::new("/dev/zero").exists() {
        let message = failed(&profile("cube", &["--resume", "/dev/zero"]));
        assert!(message.contains("it is not a regular file"), "{message}");
    }
}

#[test]
fn a_validated_run_is_clean() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let report = render(&folder, "x", &["--steps", "3", "--validate"]);
    assert_eq!(report["validation"], true);
    let plain = render(&folder, "plain", &["--steps", "3"]);
    assert_eq!(hash(&report), hash(&plain));
}
