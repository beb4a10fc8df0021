//! `myxo profile --against`: two scenes, or two settings of one, in turn.

use crate::program::{Folder, TINY, failed, myxo, no_device, path, refused, report, text};
use serde_json::Value;

/// Two settings, or two scenes, take their steps in turn: each ends as it would alone, and the ratio is that of pairs of steps.
#[test]
fn what_a_setting_costs_is_measured_in_turn() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let file = folder.file("turns.json");
    let steps = ["--steps", "7", "--warmup", "3"];
    let alone = |more: &[&str]| {
        let all = [&["profile"], &TINY[..], &steps, more, &["--json"]].concat();
        let output = myxo(&all);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let report: Value = serde_json::from_slice(&output.stdout).expect("it is JSON");
        report["state_hash"].clone()
    };
    let walks = "physarum.sensing=walk";
    let against = ["--against", walks, "--report", path(&file)];
    let output = myxo(&[&["profile"], &TINY[..], &steps, &against].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let turns = report(&file);
    assert_eq!(turns["against"][0], walks);
    assert_eq!(turns["first"]["state_hash"], alone(&[]));
    assert_eq!(turns["second"]["state_hash"], alone(&["--set", walks]));
    assert_eq!(turns["second"]["steps"], 7);
    let table = text(&output.stdout);
    assert!(
        table.contains("second  cube with physarum.sensing=walk\n"),
        "{table}"
    );
    let ratio = &turns["ratio"];
    if ratio.is_null() {
        assert!(table.contains("There is no ratio: "), "{table}");
    } else {
        assert_eq!(ratio["pairs"], 7);
        let of = |name: &str| ratio[name].as_f64().expect("it is a number");
        assert!(of("low") <= of("lower_quartile") && of("lower_quartile") <= of("median"));
        assert!(of("median") <= of("upper_quartile") && of("upper_quartile") <= of("high"));
        let mean = |which: &str| turns[which]["gpu_step"]["mean_ms"].as_f64();
        let sums = mean("second").unwrap() / mean("first").unwrap();
        assert!((of("of_sums") - sums).abs() < 1e-6 * sums, "{ratio} {sums}");
        assert!(table.contains("the median of 7 pairs"), "{table}");
    }

    // Another scene, as JSON; `--set` holds for both.
    let against = [
        "--against",
        "torus",
        "--against",
        "trail.decay=0.8",
        "--json",
    ];
    let output = myxo(&[&["profile"], &TINY[..], &steps, &against].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let turns: Value = serde_json::from_slice(&output.stdout).expect("it is JSON");
    assert_eq!(turns["first"]["scene"], "cube");
    assert_eq!(turns["second"]["scene"], "torus");
    assert_eq!(turns["second"]["particles"], 2000);
}

#[test]
fn scenes_that_cannot_take_turns_are_refused() {
    let refused_with = |options: &[&str], expected: &str| {
        let message = failed(&[&["profile"], &TINY[..], options].concat());
        assert!(message.contains(expected), "{message}");
    };
    refused_with(
        &["--against", "torus", "--against", "trio"],
        "--against names two scenes, `torus` and `trio`: one is measured against one",
    );
    refused_with(&["--against", "trail.decya=0.8"], "trail.decya");
    refused_with(&["--against", "trail.decay=8"], "trail.decay");
    refused_with(&["--against", "no_such_scene"], "no_such_scene");
    for other in [
        ["--kernel", "advance"],
        ["--hash-every", "2"],
        ["--measure-every", "2"],
        ["--trace", "x.json"],
    ] {
        let options = [&["profile"], &TINY[..], &["--against", "torus"], &other].concat();
        let message = refused(2, &options);
        assert!(
            message.contains(other[0]) && message.contains("--against"),
            "{message}"
        );
    }
}

/// Would catch: a scene that is lost because the report had its name.
#[test]
fn a_scene_that_takes_turns_is_not_replaced() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let content =
        "[particles]\ncount = 500\n[atlas]\nsize = 64\n[[object]]\nmesh = \"builtin:cube\"\n";
    let scene = folder.with("mine.toml", content);
    let options = ["--against", "seed=8", "--steps", "1", "--warmup", "0"];
    let report = ["--report", path(&scene)];
    let message = failed(&[&["profile", path(&scene)], &options[..], &report].concat());
    assert!(message.contains("is an input of this run"), "{message}");
    assert_eq!(
        std::fs::read_to_string(&scene).expect("it is there"),
        content
    );
}

/// Seeds are applied last, and names of meshes contain equals signs; both can be measured against. A message says if both sides are equal.
#[test]
fn seeds_and_meshes_can_be_measured_against() {
    if no_device() {
        return;
    }
    let turns = |options: &[&str]| {
        let short = ["--steps", "2", "--warmup", "0", "--json", "--validate"];
        let output = myxo(&[&["profile"], &TINY[..], &short, options].concat());
        let messages = text(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{messages}");
        let turns: Value = serde_json::from_slice(&output.stdout).expect("it is JSON");
        (turns, messages)
    };
    let (seeds, messages) = turns(&["--seed", "3", "--against", "seed=5"]);
    assert_eq!(seeds["first"]["seed"], 3);
    assert_eq!(seeds["second"]["seed"], 5);
    assert!(!messages.contains("both are the same"), "{messages}");
    let (meshes, _) = turns(&["--against", "builtin:torus?major=20&minor=10"]);
    assert_eq!(meshes["second"]["triangles"], 400);
    let (same, messages) = turns(&["--against", "cube"]);
    assert_eq!(same["first"]["state_hash"], same["second"]["state_hash"]);
    assert!(messages.contains("both are the same"), "{messages}");
    // Two pairs give no interval.
    if !same["ratio"].is_null() {
        assert_eq!(same["ratio"]["pairs"], 2);
        assert!(same["ratio"]["low"].is_null());
    }
}

/// Differences between repetitions widen the interval.
#[test]
fn repetitions_of_turns_are_put_together() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let file = folder.file("turns.json");
    let options = ["--steps", "4", "--warmup", "1", "--repeat", "3"];
    let against = ["--against", "trail.decay=0.8", "--report", path(&file)];
    let output = myxo(&[&["profile"], &TINY[..], &options, &against].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let turns = report(&file);
    let ratio = &turns["ratio"];
    for which in ["first", "second"] {
        let report = &turns[which];
        assert_eq!(report["steps"], 12);
        // The host's waiting time includes the device's time of all repetitions.
        let [wall, gpu] = ["wall_ms_per_step", "gpu_ms_per_step"].map(|key| report[key].as_f64());
        assert!(gpu.is_none_or(|gpu| wall > Some(gpu)), "{report}");
    }
    if !ratio.is_null() {
        assert_eq!(ratio["pairs"], 12);
        let medians = turns["repetitions"].as_array().expect("they are listed");
        assert_eq!(medians.len(), 3);
        for median in medians.iter().filter_map(Value::as_f64) {
            let [low, high] = ["low", "high"].map(|end| ratio[end].as_f64().expect("it is known"));
            assert!((low..=high).contains(&median), "{turns}");
        }
        let kernels = turns["kernels"].as_array().expect("they are listed");
        let advance = kernels.iter().find(|kernel| kernel["name"] == "advance");
        assert_eq!(advance.expect("it is there")["pairs"], 12);
    }
    let message = failed(&["profile", "--compare", path(&file), path(&file)]);
    assert!(
        message.contains("a report of `myxo profile --against`"),
        "{message}"
    );
}
