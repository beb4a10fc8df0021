//! Scenes that are opened one after another: each gives back the memory that it takes.

use std::fs::read_to_string;

use crate::{Lab, SMALL, can_open};

/// Small and large in turn: atlas sizes and meshes.
const SCENES: [(u32, &str); 3] = [
    (128, "builtin:cube"),
    (512, "builtin:torus"),
    (256, "builtin:icosphere"),
];
const ROUNDS: usize = 10;
/// Rounds in which pipelines are compiled and memory blocks are filled.
const WARM_UP: usize = 3;
/// Freed memory that the allocator holds varies by less. If no scene gave anything back, it would be ten times as much.
const MOST_GROWTH: u64 = 32 << 20;

/// Bytes of the program that are in memory.
fn resident(lab: &Lab) -> u64 {
    let status = read_to_string(format!("/proc/{}/status", lab.pid())).expect("it runs");
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let number = line.and_then(|line| line.split_whitespace().next());
    let kib: u64 = number
        .and_then(|number| number.parse().ok())
        .expect("the system says it");
    kib << 10
}

#[test]
fn thirty_scenes_take_no_more_memory_than_nine() {
    if !can_open() {
        return;
    }
    let lab = Lab::open(&SMALL);
    let files = SCENES.map(|(size, mesh)| {
        let text = format!(
            "[particles]\ncount = 20000\n[atlas]\nsize = {size}\n[[object]]\nmesh = \"{mesh}\"\n"
        );
        let name = format!("scene{size}");
        (lab.folder.with(format!("{name}.toml"), text), name)
    });
    // The most of each round.
    let mut rounds = Vec::new();
    for _ in 0..ROUNDS {
        let mut most = 0;
        for (file, name) in &files {
            lab.drop_files(&[file]);
            lab.wait("it grows", |seen| {
                let state = &seen["state"];
                state["scene"] == name.as_str()
                    && state["loading"] == false
                    && state["step"].as_u64() > Some(2)
            });
            most = most.max(resident(&lab));
        }
        rounds.push(most);
    }
    let (first, later) = rounds.split_at(WARM_UP);
    let [before, after] = [first, later].map(|part| part.iter().max().expect("there are rounds"));
    assert!(
        *after < before + MOST_GROWTH,
        "bytes in memory, by rounds: {rounds:?}"
    );
    lab.quit();
}
