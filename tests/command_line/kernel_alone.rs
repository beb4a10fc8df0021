//! `myxo profile --kernel`: one kernel of a step alone.

use crate::program::{Folder, TINY, done, failed, myxo, no_device, path, report, small_pair, text};
use myxo::sim::FORMS_OF_ADVANCE;
use serde_json::Value;

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
        // No step was measured.
        for key in ["wall_ms_per_step", "gpu_ms_per_step"] {
            assert!(report[key].is_null(), "{key}");
        }
        let rows = report["kernels"].as_array().expect("they are listed");
        assert!(rows.iter().all(|row| row["name"] == kernel), "{rows:?}");
        if rows.len() == 1 {
            assert!(
                text(&output.stdout).contains("GPU time of 4 runs"),
                "{}",
                text(&output.stdout)
            );
            assert_eq!(rows[0]["dispatches_per_step"], 1.0);
            assert_eq!(report["samples"], 4);
        }
    }
    let files = ["--out", path(&picture), "--report", path(&straight)];
    let size = ["--size", "64x48", "--steps"];
    done(&[&["render"], &TINY[..], &files, &size, &["5"]].concat());
    assert_eq!(
        report(&alone)["state_hash"],
        report(&straight)["state_hash"]
    );
    // The checkpoint has the state of the same step.
    let resume = ["--resume", path(&state)];
    done(&[&["render"], &TINY[..], &files, &size, &["3"], &resume].concat());
    let resumed = report(&straight);
    done(&[&["render"], &TINY[..], &files, &size, &["8"]].concat());
    assert_eq!(resumed["state_hash"], report(&straight)["state_hash"]);
}

/// Comparisons use the number of runs, not the number of warm-up steps.
#[test]
fn comparisons_of_kernels_go_by_their_runs() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let [many, few] = ["many.json", "few.json"].map(|name| folder.file(name));
    let alone = [&["profile"], &TINY[..], &["--kernel", "advance"]].concat();
    let repeated = ["--steps", "4", "--warmup", "2", "--repeat", "2", "--report"];
    done(&[&alone[..], &repeated, &[path(&many)]].concat());
    let once = ["--steps", "3", "--warmup", "9", "--report", path(&few)];
    done(&[&alone[..], &once].concat());
    let reports = [&many, &few].map(|file| report(file));
    if reports[0]["kernels"][0]["mean_ms"].is_null() {
        return;
    }
    assert_eq!(
        (&reports[0]["samples"], &reports[1]["samples"]),
        (&8.into(), &3.into())
    );
    let of = |a: &std::path::Path, b: &std::path::Path| {
        let output = myxo(&["profile", "--compare", path(a), path(b)]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let warning = "warning: of fewer than 6 runs";
    let table = of(&many, &many);
    assert!(
        !table.contains(warning) && !table.contains("wall"),
        "{table}"
    );
    let table = of(&many, &few);
    assert!(table.contains(warning), "{table}");
    assert!(table.contains("runs       differs   8 -> 3"), "{table}");
    assert!(table.contains("warmup     differs   2 -> 9"), "{table}");
}

/// The kernels of a scene's step, from the error about a wrong name.
fn kernels_of(scene: &[&str]) -> Vec<String> {
    let wrong = ["--kernel", "nothing_like_it", "--warmup", "0"];
    let message = failed(&[&["profile"], scene, &wrong].concat());
    let (_, list) = message.trim_end().split_once(": it has ").expect("a list");
    list.split(", ").map(str::to_owned).collect()
}

/// Would catch: kernels of a strategy that the list leaves out or has in another order, and reports of one that name another, count it more
/// than once, or give a form of `advance` the throughput of all particles. That every kernel runs alone is shown by `kernels::alone`.
#[test]
fn kernels_of_strategies_are_listed_and_run_alone() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let pair = small_pair(&folder);
    let spreading = ["diffuse", "diffuse_seams", "exchange_seams"];
    for (strategy, method, own, alone) in [
        (
            "parallel",
            "bvh",
            "transfer_in advance close_list move_borders transfer_out defragment_scan defragment_swap",
            &["advance", "transfer_in", "exchange_seams"][..],
        ),
        (
            "sequential",
            "brute",
            "distance_brute defragment_scan defragment_swap",
            &["defragment_swap"],
        ),
        (
            "direct",
            "raster",
            "distance_raster distance_merge transfer_in",
            &["distance_raster"],
        ),
        ("respawn", "bvh", "advance close_list respawn", &["respawn"]),
    ] {
        let settings = [
            format!("transfer.strategy={strategy}"),
            format!("distance.method={method}"),
        ];
        let scene = [path(&pair), "--set", &settings[0], "--set", &settings[1]];
        let kernels = kernels_of(&scene);
        for kernel in own.split(' ').chain(spreading) {
            assert!(kernels.iter().any(|k| k == kernel), "{kernel}: {kernels:?}");
        }
        if strategy == "parallel" {
            let by_trees = ["distance_tiles", "distance", "exchange_seams", "unfold"];
            let names = by_trees.iter().chain(&["advance", "walk_sensors"]);
            assert!(names.eq(&kernels[..6]), "in their order: {kernels:?}");
        }
        let is_form = |kernel: &String| FORMS_OF_ADVANCE[1..].contains(&kernel.as_str());
        let has_forms = kernels.iter().any(is_form);
        for kernel in alone {
            let run = ["--kernel", kernel, "--steps", "3", "--warmup", "4"];
            let json = ["--json", "--validate"];
            let all = [&["profile"], &scene[..], &run, &json].concat();
            let output = myxo(&all);
            assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
            let report: Value = serde_json::from_slice(&output.stdout).expect("it is JSON");
            assert_eq!(report["alone"].as_str(), Some(*kernel));
            let rows = report["kernels"].as_array().expect("they are listed");
            if rows.iter().any(|row| row["mean_ms"].is_number()) {
                assert_eq!(rows.len(), 1, "{rows:?}");
                assert_eq!(rows[0]["name"].as_str(), Some(*kernel));
                assert_eq!(rows[0]["dispatches_per_step"], 1.0);
                if *kernel == "advance" {
                    // One form of `advance` does not process all particles.
                    assert_eq!(rows[0]["throughput"].is_null(), has_forms, "{rows:?}");
                }
            }
        }
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
        "myxo: a step of this scene has no kernel `difuse`, did you mean `diffuse`?: it has advance, walk_sensors, sort_count, diffuse, sort_sums, diffuse_seams, sort_scan, exchange_seams, sort_scatter\n"
    );
    // Another scene has this kernel.
    let options = ["--kernel", "transfer_out"];
    let message = failed(&[&["profile"], &TINY[..], &options].concat());
    assert!(message.contains("no kernel `transfer_out`"), "{message}");
}
