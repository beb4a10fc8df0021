//! `myxo query diffuse`: its sums, and its errors.

use crate::program::{Folder, done, failed, myxo, no_device, path, program, refused, text};

const SPOTS: &str = "id,face,b0,b1,b2,amount\na,0,0.3,0.3,0.4,2\nb,9,0,0.5,0.5,0.5\n";

/// Rows of a table of numbers.
fn rows(table: &str) -> Vec<Vec<f64>> {
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some("face,b0,b1,b2,area,value,chart"));
    lines
        .map(|line| {
            line.split(',')
                .map(|field| field.parse().expect("a number"))
                .collect()
        })
        .collect()
}

#[test]
fn amounts_and_areas_sum_to_what_they_were() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let spots = folder.with("in.csv", SPOTS);
    let out = folder.file("out.csv");
    for (mesh, area, steps) in [("builtin:cube", 24.0, "0"), ("builtin:cube", 24.0, "300")] {
        let messages = done(&[
            "query",
            "diffuse",
            "--mesh",
            mesh,
            "--in",
            path(&spots),
            "--steps",
            steps,
            "--atlas-size",
            "97",
            "--atlas-method",
            "grid",
            "--validate",
            "--out",
            path(&out),
        ]);
        assert!(messages.contains("deposited 2.5, and 2.5"), "{messages}");
        let rows = rows(&std::fs::read_to_string(&out).expect("it was written"));
        let sum = |value: fn(&[f64]) -> f64| rows.iter().map(|row| value(row)).sum::<f64>();
        assert!((sum(|row| row[4]) / area - 1.0).abs() < 1e-6);
        assert!((sum(|row| row[4] * row[5]) / 2.5 - 1.0).abs() < 1e-5);
        assert!(
            rows.iter()
                .all(|row| (row[1] + row[2] + row[3] - 1.0).abs() < 1e-6)
        );
        let touched = rows.iter().filter(|row| row[5] > 0.0).count();
        assert_eq!(
            touched == 2,
            steps == "0",
            "{touched} texels after {steps} steps"
        );
    }
}

#[test]
fn the_answer_goes_to_the_standard_output() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let spots = folder.with("in.csv", SPOTS);
    let query = [
        "query",
        "diffuse",
        "--mesh",
        "builtin:cube",
        "--in",
        path(&spots),
        "--steps",
        "7",
        "--atlas-size",
        "64",
        "--atlas-method",
        "grid",
    ];
    let first = text(&myxo(&query).stdout);
    assert_eq!(rows(&first).len(), first.lines().count() - 1);
    assert_eq!(text(&myxo(&query).stdout), first, "the same every time");
}

#[test]
fn errors_say_what_is_wrong_with_the_input() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let out = folder.file("out.csv");
    let good = folder.with("good.csv", SPOTS);
    let column = folder.with("column.csv", "id,face,b0,b1,b2\na,0,1,0,0\n");
    let face = folder.with("face.csv", "id,face,b0,b1,b2,amount\na,12,1,0,0,1\n");
    let negative = folder.with("negative.csv", "id,face,b0,b1,b2,amount\na,0,1,0,0,-1\n");
    let cases = [
        (
            "cube",
            &column,
            "64",
            "column.csv: there is no column amount",
        ),
        (
            "cube",
            &face,
            "64",
            "face.csv: line 2: the mesh has no face 12 to deposit on",
        ),
        (
            "cube",
            &negative,
            "64",
            "negative.csv: line 2: the amount is negative",
        ),
        ("cube", &good, "0", "atlas size 0 is out of range"),
        ("torus", &good, "64", "raise --atlas-size to"),
        (
            "cube",
            &good,
            "4000000000",
            "--atlas-size 4000000000 is too large for ",
        ),
    ];
    for (mesh, spots, size, expected) in cases {
        let message = failed(&[
            "query",
            "diffuse",
            "--mesh",
            &format!("builtin:{mesh}"),
            "--in",
            path(spots),
            "--steps",
            "3",
            "--atlas-size",
            size,
            "--atlas-method",
            "grid",
            "--out",
            path(&out),
        ]);
        assert!(message.contains(expected), "{expected} in {message}");
        assert!(!out.exists(), "nothing is left under the final name");
    }
    for wrong in [
        ["--steps", "-1"],
        ["--steps", "1000000000"],
        ["--atlas-method", "paper"],
        ["--turn", "left"],
    ] {
        refused(
            2,
            &[
                "query",
                "diffuse",
                "--mesh",
                "builtin:cube",
                "--in",
                path(&good),
                "--atlas-size",
                "64",
                wrong[0],
                wrong[1],
            ],
        );
    }
}

#[test]
fn help_lists_the_ways_to_lay_triangles_out() {
    for query in ["diffuse", "atlas"] {
        let help = text(&myxo(&["query", query, "--help"]).stdout);
        assert!(help.contains("charts, grid, mesh"), "{help}");
    }
}

#[cfg(unix)]
#[test]
fn an_interrupted_question_leaves_nothing_behind() {
    use crate::program::{interrupt, wait_until};
    use std::time::Duration;
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let spots = folder.with("in.csv", SPOTS);
    let out = folder.file("deep/out.csv");
    // The atlas alone takes seconds.
    let mut child = program()
        .args([
            "query",
            "diffuse",
            "--mesh",
            "builtin:torus?major=300&minor=300",
        ])
        .args(["--in", path(&spots), "--steps", "1000000"])
        .args(["--atlas-size", "2048", "--out", path(&out)])
        .env("XDG_CACHE_HOME", folder.file("cache"))
        .stderr(std::process::Stdio::null())
        .spawn()
        .expect("the program starts");
    let deep = folder.file("deep");
    let is_begun = || std::fs::read_dir(&deep).is_ok_and(|mut files| files.next().is_some());
    wait_until("its file is begun", Duration::from_secs(60), || {
        let ended = child.try_wait().expect("it can be asked");
        assert!(ended.is_none(), "it ends before: {ended:?}");
        is_begun()
    });
    interrupt(&child);
    assert_eq!(child.wait().expect("it ends").code(), Some(130));
    assert_eq!(std::fs::read_dir(&deep).expect("it was made").count(), 0);
}
