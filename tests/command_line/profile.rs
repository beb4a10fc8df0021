//! `myxo profile`: the table, the report, repetitions, traces and comparisons.

use crate::program::{
    self, Folder, TINY, done, failed, myxo, no_device, path, report, small_pair, text,
};
use myxo::sim::FORMS_OF_ADVANCE;
use serde_json::Value;

/// Large enough that gaps between kernels are negligible, and still fast.
const LARGE: [&str; 5] = [
    "torus",
    "--set",
    "particles.count=150000",
    "--set",
    "atlas.size=512",
];

/// The part of a step of several objects that may lie between kernels.
const MOST_BETWEEN: f64 = 0.4;

#[test]
fn kernels_account_for_the_step() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let file = folder.file("x.json");
    let steps = ["--steps", "8", "--warmup", "2", "--report", path(&file)];
    let sum_of = |report: &serde_json::Value| -> f64 {
        let kernels = report["kernels"].as_array().expect("they are listed");
        let means = kernels.iter().filter_map(|row| row["mean_ms"].as_f64());
        means.sum()
    };
    let mut attempts = 0;
    let (table, report, step, sum) = loop {
        let output = myxo(&[&["profile"], &LARGE[..], &steps].concat());
        let table = text(&output.stdout);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let report = report(&file);
        let Some(step) = report["gpu_ms_per_step"].as_f64() else {
            assert!(table.contains("unavailable"), "{table}");
            return;
        };
        let sum = sum_of(&report);
        attempts += 1;
        // Another program may have used the processors between two kernels once, but not every time.
        if sum / step >= 0.9 || attempts == 3 {
            break (table, report, step, sum);
        }
    };
    let kernels = report["kernels"].as_array().expect("they are listed");
    // The time between kernels is less than a tenth; kernels do not overlap.
    assert!((0.9..=1.0 + 1e-9).contains(&(sum / step)), "{table}");
    assert_eq!(report["gpu_step"]["mean_ms"].as_f64(), Some(step));
    let shares: f64 = kernels.iter().filter_map(|row| row["share"].as_f64()).sum();
    assert!((shares - sum / step).abs() < 1e-6);
    let between = report["gpu_ms_between_kernels"].as_f64();
    assert!(between.is_some_and(|between| (sum + between - step).abs() < 1e-9 * step));
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
    // The 9 lines that are no kernels include the clearing of the list of walkers, two about copies, and the host's.
    assert!(of("between kernels ").ends_with(" %"), "{table}");
    // If only some of these steps have a sort, one more line says so.
    let is_in_all = |row: &serde_json::Value| row["of_steps"].as_f64() == Some(1.0);
    let of_some = usize::from(!kernels.iter().all(is_in_all));
    assert_eq!(lines.len(), 9 + kernels.len() + of_some, "{table}");
    let last = lines.last().expect("there are lines");
    assert!(last.starts_with("The host takes "), "{table}");
    assert!(
        lines.iter().all(|line| line.chars().count() <= 128),
        "{table}"
    );

    let advance = kernels
        .iter()
        .find(|row| row["name"] == "advance")
        .expect("it is there");
    let per_second = advance["throughput"]["per_second"]
        .as_f64()
        .expect("it is measured");
    // Particles with walking sensors advance in the second of the two kernels.
    let both: f64 = kernels
        .iter()
        .filter(|row| ["advance", "walk_sensors"].map(|name| row["name"] == name) != [false; 2])
        .map(|row| row["median_ms"].as_f64().expect("it is measured"))
        .sum();
    assert!((per_second * both * 1e-3 - 150_000.0).abs() < 1.0);
    check_statistics(&report);
}

/// Checks that the statistics of every row are in order, and that its bytes follow from the sizes of its inputs and outputs.
fn check_statistics(report: &Value) {
    let copies = &report["copy_bandwidth"];
    let copy = copies["gigabytes_per_second"].as_f64().expect("measured");
    let size = copies["size_in_bytes"].as_f64().expect("it is a number");
    let median = copies["median_ms"].as_f64().expect("it is measured");
    assert!((copy - 2.0 * size / median * 1e-6).abs() < 1e-9 * copy);
    assert!(
        size >= f64::from(1 << 20) && copies["runs"] == 9,
        "{copies}"
    );
    let kernels = report["kernels"].as_array().expect("they are listed");
    for row in kernels.iter().chain([&report["gpu_step"]]) {
        let of = |key: &str| row[format!("{key}_ms")].as_f64().expect("it is measured");
        let order = ["min", "median_low", "median", "median_high", "max"];
        assert!(
            order.windows(2).all(|pair| of(pair[0]) <= of(pair[1])),
            "{row}"
        );
        let part = row["of_steps"].as_f64().unwrap_or(1.0);
        let mean = of("mean") / part;
        let rounding = 1e-9 * mean;
        assert!(
            of("min") - rounding <= mean && mean <= of("max") + rounding,
            "{row}"
        );
        assert!((of("median")..=of("max")).contains(&of("p95")), "{row}");
        let range = of("max") - of("min");
        assert!(
            of("std") <= range && (range == 0.0 || of("std") > 0.0),
            "{row}"
        );
        if let Some(rate) = row["gigabytes_per_second"]
            .as_f64()
            .filter(|_| row["name"] != "advance")
        {
            let bytes = row["bytes_per_step"].as_f64().expect("they are counted");
            let ms = of(if part < 1.0 { "mean" } else { "median" });
            assert!((rate - bytes / ms * 1e-6).abs() < 1e-9 * rate, "{row}");
            let part = row["of_copy_bandwidth"].as_f64().expect("it is known");
            assert!((part - rate / copy).abs() < 1e-9 * part, "{row}");
        }
    }
    // The host begins, records and submits a step; each takes some time, and the device's time is not included.
    let host = |what: &str| {
        let of = |key: &str| {
            report["host_step"][what][key]
                .as_f64()
                .expect("it is measured")
        };
        let [min, median, max] = ["min_ms", "median_ms", "max_ms"].map(of);
        assert!(0.0 < min && min <= median && median <= max, "{what}");
        of("mean_ms")
    };
    let all = host("beginning") + host("recording") + host("submitting");
    assert!((host("all") - all).abs() < 1e-9 * all);
    // Times are read there without waiting.
    let step = report["gpu_ms_per_step"].as_f64().expect("it is measured");
    let least = report["host_step"]["beginning"]["min_ms"].as_f64();
    assert!(least < Some(0.5 * step), "{least:?} of {step}");
    let bytes = |name: &str| {
        let row = kernels.iter().find(|row| row["name"] == name);
        row.expect("it is there")["bytes_per_step"].as_f64()
    };
    // Particles of 32 bytes in and out, three texels read, one count read and written.
    assert_eq!(bytes("advance"), Some(150_000.0 * (64.0 + 12.0 + 8.0)));
    assert_eq!(
        bytes("walk_sensors"),
        None,
        "only the device has the number"
    );
    let texels = bytes("diffuse").expect("it is counted") / 20.0;
    assert!((100_000.0..512.0 * 512.0).contains(&texels), "{texels}");
}

#[test]
fn repetitions_restart_and_count_together() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let [once, thrice] = ["once.json", "thrice.json"].map(|name| folder.file(name));
    let steps = ["--steps", "6", "--warmup", "2", "--report"];
    let first = [&["profile"], &TINY[..], &steps, &[path(&once)]].concat();
    done(&first);
    let repeat = [path(&thrice), "--repeat", "3"];
    let output = myxo(&[&["profile"], &TINY[..], &steps, &repeat].concat());
    let table = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let (one, three) = (report(&once), report(&thrice));
    assert_eq!(one["state_hash"], three["state_hash"]);
    assert!(one["repetitions"].is_null());
    let rounds = three["repetitions"].as_array().expect("they are listed");
    assert_eq!(rounds.len(), 3);
    // Wall time covers all repetitions, too.
    assert_eq!((&one["steps"], &three["steps"]), (&6.into(), &18.into()));
    if three["gpu_step"]["median_ms"].is_null() {
        return;
    }
    assert!(table.contains("GPU time of 18 steps"), "{table}");
    assert_eq!(three["samples"], 18);
    assert!(table.contains("3 repetitions, each from"), "{table}");
    let number = |value: &Value| value.as_f64().expect("it is a number");
    for round in rounds {
        assert_eq!(round["steps"], 6);
        let step = number(&round["step_ms"]);
        let low = number(&three["gpu_step"]["median_low_ms"]);
        let high = number(&three["gpu_step"]["median_high_ms"]);
        assert!((low..=high).contains(&step), "{low} - {high}: {step}");
        assert!(number(&round["kernels_ms"]["advance"]) < step);
    }

    // A report compared with itself has no differences.
    let output = myxo(&["profile", "--compare", path(&thrice), path(&thrice)]);
    let table = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(
        !table.contains("differs") && !table.contains("one run each"),
        "{table}"
    );
    let gpu = table.lines().find(|line| line.starts_with("gpu "));
    let gpu = gpu.expect("it is there");
    assert!(
        gpu.contains(" 1.000 ") && gpu.ends_with("may be equal"),
        "{table}"
    );
}

/// Would catch: repetitions that are lost because Ctrl-C comes while the next one is set up.
#[cfg(unix)]
#[test]
fn repetitions_before_ctrl_c_are_kept() {
    use crate::program::{interrupted_at, logging_its_parts};
    use std::process::Stdio;
    use std::time::Duration;
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let file = folder.file("report.json");
    // Two scenes that take turns are set up one after the other.
    for (against, times) in [(&["--against", "trail.decay=0.8"][..], 3), (&[], 2)] {
        let mut run = program::program();
        run.args(["profile", "builtin:torus?major=100&minor=60"])
            .args(["--set=particles.count=2000", "--set=atlas.size=400"])
            .args(["--set=atlas.method=grid", "--steps=1", "--warmup=0"])
            .args(["--repeat", "1000", "--report", path(&file)])
            .args(against);
        let run = logging_its_parts(&mut run)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        interrupted_at(run, "giving out texels", times, Duration::from_secs(20));
        let kept = report(&file);
        let kept = if against.is_empty() {
            &kept
        } else {
            &kept["first"]
        };
        assert_eq!(kept["interrupted"], true, "{kept}");
        assert!(kept["steps"].as_u64() >= Some(1), "{kept}");
        std::fs::remove_file(&file).expect("it is there");
    }
}

#[test]
fn a_comparison_names_its_doubts() {
    let folder = Folder::new();
    // Reports of earlier versions, without spread.
    let old = |scene: &str, more: &str, ms: f64| {
        format!(
            r#"{{"device": "abacus", "driver": "d", "scene": "{scene}", "seed": 7, "steps": 9, "particles": 5,
            "atlas_size": 64, "triangles": 12, "state_hash": "0", "gpu_ms_per_step": {ms}, "wall_ms_per_step": 9.0,
            "kernels": [{{"name": "advance", "dispatches_per_step": 1.0, "mean_ms": {ms}, "median_ms": {ms},
            "p95_ms": 3.0, "share": 0.5}}], "counters": {{"lost": 0, "doubled": 0, "trail_mass": 0.0}},
            "validation": false, "interrupted": false, {more} "command": "", "version": "", "commit": null,
            "processor": null, "load_average": null}}"#
        )
    };
    let a = folder.with("a.json", old("cube", "", 2.0));
    let b = folder.with("b.json", old("torus", "", 5.0));
    let alone = r#""alone": "advance","#;
    let c = folder.with("c.json", old("cube", alone, 2.0));
    let output = myxo(&["profile", "--compare", path(&a), path(&b)]);
    let table = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    for part in [
        "scene      differs   cube -> torus",
        "warning: the two were not measured under the same conditions",
        "note: one run each",
    ] {
        assert!(table.contains(part), "{part}: {table}");
    }
    let advance = table.lines().find(|line| line.starts_with("advance "));
    assert!(
        advance.is_some_and(|line| line.contains("2.500")),
        "{table}"
    );

    let message = failed(&["profile", "--compare", path(&a), path(&c)]);
    assert!(
        message.contains("whole steps") && message.contains("`advance` alone"),
        "{message}"
    );
    let untimed = old("cube", "", 2.0).replace(r#""mean_ms": 2"#, r#""mean_ms": null, "x": 2"#);
    let d = folder.with("d.json", untimed);
    let message = failed(&["profile", "--compare", path(&a), path(&d)]);
    assert!(message.contains("second report has no times"), "{message}");
    let missing = folder.file("missing.json");
    let message = failed(&["profile", "--compare", path(&a), path(&missing)]);
    assert!(message.contains("cannot read") && message.contains("missing.json"));
    let e = folder.with("e.json", "{\"half\": ");
    let message = failed(&["profile", "--compare", path(&e), path(&a)]);
    assert!(message.contains("not a report"), "{message}");
    for wrong in [
        &["profile"][..],
        &["profile", "--compare", path(&a)],
        &["profile", "cube", "--compare", path(&a), path(&b)],
        &["profile", "cube", "--repeat", "0"],
    ] {
        let message = program::refused(2, wrong);
        assert!(message.contains("--help"), "{message}");
    }
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
    // Without a terminal there are no messages, except that the machine is busy.
    let messages = text(&output.stderr);
    let load = &report["host_load"];
    assert_eq!(load["is_busy"] == true, !messages.is_empty(), "{load}");
    assert!(
        messages.is_empty() || messages.starts_with("the machine was busy: "),
        "{messages}"
    );
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
    // Slices that overlap on one track must nest, up to a nanosecond of rounding.
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

/// Catches kernels without a time: their time would count as between the others. The rounds of two objects are a dozen dispatches each, and
/// the gaps take some time, too.
#[test]
fn kernels_of_several_objects_account_for_most_of_the_step() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let pair = small_pair(&folder);
    for strategy in ["none", "parallel", "direct"] {
        let strategy = format!("transfer.strategy={strategy}");
        let options = ["--set", &strategy, "--set", "particles.count=60000"];
        let steps = ["--steps", "6", "--warmup", "2", "--json"];
        let mut parts = Vec::new();
        // Another program may have used the processors between two kernels once, but not every time.
        while parts.len() < 3 && parts.last().is_none_or(|part| *part > MOST_BETWEEN) {
            let output = myxo(&[&["profile", path(&pair)], &options[..], &steps].concat());
            assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
            let report: Value = serde_json::from_slice(&output.stdout).expect("it is JSON");
            let Some(step) = report["gpu_ms_per_step"].as_f64() else {
                return;
            };
            let between = report["gpu_ms_between_kernels"].as_f64();
            parts.push(between.expect("the step was measured") / step);
        }
        assert!(parts.last() <= Some(&MOST_BETWEEN), "{strategy}: {parts:?}");
    }
}

/// Each particle advances once a step, however many rounds there are.
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
        // However many rounds there are, kernels and the time between them add up to the step, and none overlap.
        if let Some(step) = report["gpu_ms_per_step"].as_f64() {
            let means = rows.iter().filter_map(|row| row["mean_ms"].as_f64());
            let between = report["gpu_ms_between_kernels"].as_f64();
            let between = between.expect("the step was measured");
            assert!(between >= 0.0, "{strategy}: {between}");
            assert!((means.sum::<f64>() + between - step).abs() < 1e-9 * step);
        }
        let of = |name: &str| rows.iter().find(|row| row["name"] == name);
        let advance = of("advance").expect("it is there");
        // Particles that `advance` lists advance in the other three kernels.
        let medians = FORMS_OF_ADVANCE.map(|name| of(name).map(|row| row["median_ms"].as_f64()));
        let Some(all) = medians.into_iter().flatten().sum::<Option<f64>>() else {
            return;
        };
        let per_second = advance["throughput"]["per_second"].as_f64();
        let count = per_second.expect("it is measured") * all * 1e-3;
        assert!((count - 2000.0).abs() < 1.0, "{strategy}: {count}");
    }
}

/// Catches a barrier between kernels that need no order, and a missing one where a kernel reads the output of another. With the validation
/// layers on, as in most tests, kernels that need no order have barriers, too.
#[test]
fn the_list_of_barriers_has_the_kernels_that_may_overlap() {
    if no_device() {
        return;
    }
    let small = ["--set", "particles.count=2000", "--set", "atlas.size=128"];
    let command = ["profile", "trio", "--barriers", "--warmup", "1"];
    let output = myxo(&[&command[..], &small].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let list = text(&output.stdout);
    let lines: Vec<&str> = list.lines().collect();
    let begins = lines
        .iter()
        .position(|line| line.starts_with("    in no order: each has particles of its own"))
        .expect(&list);
    let group = &lines[begins + 1..];
    let ends = group.iter().position(|line| *line == "    in order");
    let (group, behind) = group.split_at(ends.expect(&list));
    let kernels: Vec<&&str> = group.iter().filter(|line| !line.starts_with(' ')).collect();
    assert_eq!(kernels, [&"walk_sensors", &"advance_near", &"walk_near"]);
    let barriers = group.iter().filter(|line| **line == "    barrier");
    assert_eq!((barriers.count(), group[0]), (1, "    barrier"), "{list}");
    assert_eq!(behind[1], "    barrier", "{list}");
}
