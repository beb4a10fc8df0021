//! Starts and steps do not depend on the host's number of threads.

use crate::program::{Folder, TINY, no_device, path, program, report, text};

/// Each start by its settings; all read distances along the surface, a picture, or both.
const STARTS: [(&str, &[&str]); 4] = [
    (
        "ring",
        &["particles.start=ring", "particles.start_radius=0.4"],
    ),
    (
        "disc",
        &["particles.start=disc", "particles.start_radius=0.5"],
    ),
    ("mask", &["particles.start=mask"]),
    (
        "food",
        &[
            "particles.start=food",
            "particles.start_food=1",
            "feeding.scattered=3",
        ],
    ),
];

#[test]
fn starts_are_the_same_with_any_number_of_threads() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let mask = folder.file("mask.png");
    let shade = |x: u32, y: u32| image::Luma([((x * 3) ^ (y * 5)) as u8]);
    image::GrayImage::from_fn(64, 64, shade)
        .save(&mask)
        .expect("it can be written");
    let mask = format!("particles.start_mask={}", path(&mask));
    let mut hashes = Vec::new();
    for (name, keys) in STARTS {
        let of_mask = (name == "mask").then_some(mask.as_str());
        let keys = keys.iter().copied().chain(of_mask);
        let set: Vec<&str> = keys.flat_map(|key| ["--set", key]).collect();
        let of_threads = |threads: &str| -> Vec<String> {
            let out = folder.file(format!("{name}-{threads}.json"));
            let mut run = program();
            run.env("RAYON_NUM_THREADS", threads)
                .arg("render")
                .args(TINY);
            run.args(["--steps", "3", "--hash-every", "1", "--size", "64x48"]);
            run.args(["--report", path(&out), "--out"])
                .arg(folder.file("x.png"));
            run.args(&set);
            let output = run.output().expect("it starts");
            assert!(output.status.success(), "{name}: {}", text(&output.stderr));
            let report = report(&out);
            let along = report["hashes"].as_array().expect("there are hashes");
            let along = along.iter().map(|hash| hash["hash"].to_string());
            along.chain([report["state_hash"].to_string()]).collect()
        };
        let first = of_threads("1");
        assert_eq!(of_threads("4"), first, "{name}");
        assert_eq!(first.len(), 4, "three steps, and the end");
        // Nothing has happened yet.
        let at_start = |threads: &str| {
            let file = folder.file(format!("{name}-{threads}.npz"));
            let mut run = program();
            run.env("RAYON_NUM_THREADS", threads)
                .arg("export")
                .args(TINY);
            run.args(["--steps", "0", "--out", path(&file)]);
            run.args(&set);
            let output = run.output().expect("it starts");
            let said = text(&output.stderr);
            assert!(output.status.success(), "{name}: {said}");
            let (_, hash) = said
                .split_once("at step 0: state hash ")
                .expect("the hash is printed");
            let hash = hash.lines().next().unwrap_or_default().to_owned();
            (hash, std::fs::read(file).expect("it is there"))
        };
        let (one, four) = (at_start("1"), at_start("4"));
        assert_eq!(one.0, four.0, "{name} at step 0");
        assert!(one.1 == four.1, "{name}: the data at step 0");
        hashes.push(one.0);
    }
    hashes.sort();
    hashes.dedup();
    assert_eq!(hashes.len(), STARTS.len(), "each start is another one");
}
