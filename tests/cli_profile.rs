//! `myxo profile`: the table, the report, traces, and one kernel alone.

mod program;

use program::{Folder, TINY, done, failed, myxo, no_device, path, report, text};
use serde_json::Value;

/// Large enough that gaps between kernels don't count, and still fast.
const LARGE: [&str; 5] = [
    "torus",
    "--set",
    "particles.count=150000",
    "--set",
    "atlas.size=512",
];

#[test]
fn kernels_account_for_the_step() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let file = folder.file("x.json");
    let steps = ["--steps", "8", "--warmup", "2", "--report", path(&file)];
    let output = myxo(&[&["profile"], &LARGE[..], &steps].concat());
    let table = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let report = report(&file);
    let Some(step) = report["gpu_ms_per_step"].as_f64() else {
        assert!(table.contains("unavailable"), "{table}");
        return;
    };
    let kernels = report["kernels"].as_array().expect("they are listed");
    let sum: f64 = kernels
        .iter()
        .filter_map(|row| row["mean_ms"].as_f64())
        .sum();
    assert!((0.9..=1.0 + 1e-9).contains(&(sum / step)), "{table}");
    let shares: f64 = kernels.iter().filter_map(|row| row["share"].as_f64()).sum();
    assert!((shares - sum / step).abs() < 1e-6);
    let wall = report["wall_ms_per_step"].as_f64().expect("it is a number");
    assert!(wall > 0.9 * step, "wall {wall}, GPU {step}");

    let lines: Vec<&str> = table.lines().collect();
    assert!(
        lines[0].starts_with("kernel ") && lines[0].ends_with("throughput"),
        "{table}"
    );
    let of = |name: &str| {
        let line = lines.iter().find(|line| line.starts_with(name));
        line.unwrap_or_else(|| panic!("{name} in\n{table}"))
            .to_string()
    };
    assert!(of("advance ").ends_with(" particles/s"), "{table}");
    assert!(of("diffuse ").ends_with(" texels/s"), "{table}");
    assert!(
        of("exchange_seams ").ends_with(" gutter texels/s"),
        "{table}"
    );
    assert!(of("whole step ").ends_with(" steps/s"), "{table}");
    assert_eq!(
        lines.iter().filter(|line| line.starts_with('─')).count(),
        2,
        "{table}"
    );
    // With the list of those whose sensors walk, which begins anew in each step.
    assert_eq!(lines.len(), 11, "{table}");

    let advance = kernels
        .iter()
        .find(|row| row["name"] == "advance")
        .expect("it is there");
    let per_second = advance["throughput"]["per_second"]
        .as_f64()
        .expect("it is measured");
    let median = advance["median_ms"].as_f64().expect("it is measured");
    assert!((per_second * median * 1e-3 - 150_000.0).abs() < 1.0);
}

#[test]
fn json_is_data_and_nothing_else() {
    if no_device() {
        return;
    }
    let steps = ["--steps", "3", "--warmup", "1", "--json"];
    let output = myxo(&[&["profile"], &TINY[..], &steps].concat());
    let report: Value = serde_json::from_slice(&output.stdout).expect("it is JSON");
    assert_eq!(report["steps"], 3);
    assert_eq!(report["scene"], "cube");
    assert_eq!(text(&output.stderr), "", "no terminal, no chatter");
}

/// A slice of a trace, in nanoseconds.
struct Slice {
    track: u64,
    name: String,
    begin: i64,
    end: i64,
}

fn slices(trace: &Value) -> Vec<Slice> {
    let events = trace["traceEvents"].as_array().expect("there are events");
    let nanoseconds =
        |value: &Value| (value.as_f64().expect("it is a number") * 1e3).round() as i64;
    let slice = |event: &Value| Slice {
        track: event["tid"].as_u64().expect("it has a track"),
        name: event["name"].as_str().expect("it has a name").to_owned(),
        begin: nanoseconds(&event["ts"]),
        end: nanoseconds(&event["ts"]) + nanoseconds(&event["dur"]),
    };
    events
        .iter()
        .filter(|event| event["ph"] == "X")
        .map(slice)
        .collect()
}

#[test]
fn a_trace_has_host_and_device_on_one_clock() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let file = folder.file("x.json");
    let steps = ["--steps", "6", "--warmup", "2", "--trace", path(&file)];
    let messages = done(&[&["profile"], &LARGE[..], &steps].concat());
    let slices = slices(&report(&file));
    let host: Vec<&Slice> = slices.iter().filter(|slice| slice.track == 1).collect();
    let device: Vec<&Slice> = slices.iter().filter(|slice| slice.track == 2).collect();
    let called = |track: &[&Slice], name: &str| -> Vec<(i64, i64)> {
        let named = track.iter().filter(|slice| slice.name == name);
        named.map(|slice| (slice.begin, slice.end)).collect()
    };
    let submits = called(&host, "submit");
    assert_eq!((submits.len(), called(&host, "record").len()), (6, 6));
    if device.is_empty() {
        assert!(messages.contains("no timestamps"), "{messages}");
        return;
    }
    for name in [
        "frame",
        "step",
        "advance",
        "diffuse",
        "diffuse_seams",
        "exchange_seams",
    ] {
        assert_eq!(called(&device, name).len(), 6, "{name}");
    }
    // What overlaps on one track has to nest, up to the nanosecond that rounding may add.
    for track in [&host, &device] {
        for a in track.iter() {
            for b in track.iter().filter(|b| b.begin >= a.begin) {
                let nested = b.end <= a.end + 1 || b.begin >= a.end - 1;
                assert!(
                    nested,
                    "{} and {}: {} to {}",
                    a.name, b.name, b.begin, b.end
                );
            }
        }
    }
    // The device begins a frame after the host has begun to submit it, and ends it before the host has waited for it.
    let last_wait = called(&host, "wait").into_iter().map(|(_, end)| end).max();
    for ((submit, _), (begin, end)) in submits.iter().zip(called(&device, "frame")) {
        assert!(
            begin >= submit - 100_000,
            "begun at {begin}, submitted at {submit}"
        );
        assert!(
            Some(end) <= last_wait.map(|wait| wait + 100_000),
            "ends at {end}"
        );
    }
    assert!(
        messages.contains("on one clock, within ") || messages.contains("first submit"),
        "{messages}"
    );
}

#[test]
fn one_kernel_runs_alone_and_leaves_the_state_alone() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let [alone, picture, straight, state] =
        ["alone.json", "x.png", "straight.json", "x.state"].map(|name| folder.file(name));
    for kernel in [
        "advance",
        "walk_sensors",
        "diffuse",
        "diffuse_seams",
        "exchange_seams",
    ] {
        let options = [
            "--kernel",
            kernel,
            "--steps",
            "4",
            "--warmup",
            "5",
            "--validate",
        ];
        let files = ["--report", path(&alone), "--checkpoint", path(&state)];
        let output = myxo(&[&["profile"], &TINY[..], &options, &files].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let report = report(&alone);
        assert_eq!(report["alone"], kernel);
        assert_eq!(report["steps"], 5);
        let rows = report["kernels"].as_array().expect("they are listed");
        assert!(rows.iter().all(|row| row["name"] == kernel), "{rows:?}");
        if rows.len() == 1 {
            assert!(
                text(&output.stdout).contains("GPU time of 4 runs"),
                "{}",
                text(&output.stdout)
            );
            assert_eq!(rows[0]["dispatches_per_step"], 1.0);
        }
    }
    let files = ["--out", path(&picture), "--report", path(&straight)];
    let size = ["--size", "64x48", "--steps"];
    done(&[&["render"], &TINY[..], &files, &size, &["5"]].concat());
    assert_eq!(
        report(&alone)["state_hash"],
        report(&straight)["state_hash"]
    );
    // The checkpoint is of the same step.
    let resume = ["--resume", path(&state)];
    done(&[&["render"], &TINY[..], &files, &size, &["3"], &resume].concat());
    let resumed = report(&straight);
    done(&[&["render"], &TINY[..], &files, &size, &["8"]].concat());
    assert_eq!(resumed["state_hash"], report(&straight)["state_hash"]);
}

/// Two small objects in one another, so that some particles change.
fn small_pair(folder: &Folder) -> std::path::PathBuf {
    let file = folder.file("pair.toml");
    let text = "[particles]\ncount = 2000\n[physarum]\nspeed = 0.02\n[atlas]\nsize = 64\n\
        [transfer]\nthreshold = 0.01\n[[object]]\nmesh = \"builtin:cube?divisions=3\"\n\
        [[object]]\nmesh = \"builtin:icosphere?subdivisions=2\"\nposition = [0.9, 0.3, 0.2]\n";
    std::fs::write(&file, text).expect("there is room");
    file
}

/// Those that a step of a scene has, as the answer to a wrong name lists them.
fn kernels_of(scene: &[&str]) -> Vec<String> {
    let wrong = ["--kernel", "nothing_like_it", "--warmup", "0"];
    let message = failed(&[&["profile"], scene, &wrong].concat());
    let (_, list) = message.trim_end().split_once(": it has ").expect("a list");
    list.split(", ").map(str::to_owned).collect()
}

#[test]
fn every_kernel_of_a_step_runs_alone() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let pair = small_pair(&folder);
    let spreading = ["diffuse", "diffuse_seams", "exchange_seams"];
    let by_trees = ["distance_tiles", "distance", "exchange_seams", "unfold"];
    for (strategy, method, expected) in [
        (
            "parallel",
            "bvh",
            "transfer_in advance move_border transfer_out defragment_scan defragment_swap",
        ),
        (
            "sequential",
            "brute",
            "distance_brute defragment_sequential",
        ),
        (
            "direct",
            "raster",
            "distance_raster distance_merge transfer_in",
        ),
        ("respawn", "bvh", "advance move_border respawn"),
    ] {
        let settings = [
            format!("transfer.strategy={strategy}"),
            format!("distance.method={method}"),
        ];
        let scene = [path(&pair), "--set", &settings[0], "--set", &settings[1]];
        let kernels = kernels_of(&scene);
        for kernel in expected.split(' ').chain(spreading) {
            assert!(kernels.iter().any(|k| k == kernel), "{kernel}: {kernels:?}");
        }
        if strategy == "parallel" {
            let names = by_trees.iter().chain(&["transfer_in", "advance"]);
            assert!(names.eq(&kernels[..6]), "in their order: {kernels:?}");
        }
        // Each alone; those that all strategies share, once.
        let shared = |kernel: &str| spreading.contains(&kernel) || by_trees.contains(&kernel);
        for kernel in kernels
            .iter()
            .filter(|k| strategy == "parallel" || !shared(k))
        {
            let run = ["--kernel", kernel, "--steps", "3", "--warmup", "4"];
            let json = ["--json", "--validate"];
            let all = [&["profile"], &scene[..], &run, &json].concat();
            let output = myxo(&all);
            assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
            let report: Value = serde_json::from_slice(&output.stdout).expect("it is JSON");
            assert_eq!(report["alone"].as_str(), Some(kernel.as_str()));
            let rows = report["kernels"].as_array().expect("they are listed");
            if rows.iter().any(|row| row["mean_ms"].is_number()) {
                assert_eq!(rows.len(), 1, "{rows:?}");
                assert_eq!(rows[0]["name"].as_str(), Some(kernel.as_str()));
                assert_eq!(rows[0]["dispatches_per_step"], 1.0);
                if kernel == "advance" {
                    // One object's particles are not all of them.
                    let has_turns = ["parallel", "sequential"].contains(&strategy);
                    assert_eq!(rows[0]["throughput"].is_null(), has_turns, "{rows:?}");
                }
            }
        }
    }
}

/// Each particle advances once a step, in however many turns.
#[test]
fn throughput_counts_every_particle_once() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let pair = small_pair(&folder);
    for strategy in ["scattered", "parallel", "direct"] {
        let strategy = format!("transfer.strategy={strategy}");
        let options = [
            "--set", &strategy, "--steps", "4", "--warmup", "2", "--json",
        ];
        let output = myxo(&[&["profile", path(&pair)], &options[..]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let report: Value = serde_json::from_slice(&output.stdout).expect("it is JSON");
        let rows = report["kernels"].as_array().expect("they are listed");
        let advance = rows.iter().find(|row| row["name"] == "advance");
        let advance = advance.expect("it is there");
        let Some(median) = advance["median_ms"].as_f64() else {
            return;
        };
        let per_second = advance["throughput"]["per_second"].as_f64();
        let count = per_second.expect("it is measured") * median * 1e-3;
        assert!((count - 2000.0).abs() < 1.0, "{strategy}: {count}");
    }
}

#[test]
fn unknown_kernels_are_answered_with_those_that_exist() {
    if no_device() {
        return;
    }
    let message = failed(&[&["profile"], &TINY[..], &["--kernel", "difuse"]].concat());
    assert_eq!(
        message,
        "myxo: a step of this scene has no kernel `difuse`, did you mean `diffuse`?: it has advance, walk_sensors, diffuse, diffuse_seams, exchange_seams, sort_count, sort_scan, sort_scatter\n"
    );
    // Another scene has it.
    let options = ["--kernel", "transfer_out"];
    let message = failed(&[&["profile"], &TINY[..], &options].concat());
    assert!(message.contains("no kernel `transfer_out`"), "{message}");
}
