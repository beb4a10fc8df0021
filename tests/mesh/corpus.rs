//! The corpus of the fuzz targets: seeds, and every input that a target once failed on.

use std::panic::catch_unwind;
use std::path::{Path, PathBuf};

#[path = "../fuzz/src/lib.rs"]
mod targets;

use targets::{TARGETS, gone_on, seed_checkpoint};

fn corpus(target: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/fuzz/corpus")
        .join(target)
}

/// Files of a target's corpus whose name begins so.
fn files(target: &str, beginning: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(corpus(target)).expect("every target has seeds");
    let files = entries.map(|entry| entry.expect("it can be listed").path());
    let mut files: Vec<PathBuf> = files
        .filter(|file| {
            file.file_name()
                .is_some_and(|name| name.to_string_lossy().starts_with(beginning))
        })
        .collect();
    files.sort();
    files
}

/// Catches a reader that fails again on an earlier failure, where the fuzz targets are not run.
#[test]
fn no_target_fails_on_its_corpus() {
    for (name, target) in TARGETS {
        let files = files(name, "");
        assert!(files.len() >= 2, "{name} has no seeds");
        for file in files {
            let bytes = std::fs::read(&file).unwrap();
            let result = catch_unwind(|| target(&bytes));
            assert!(result.is_ok(), "{} fails: see above", file.display());
        }
    }
}

/// Catches a change of the format or of the layout after which the target `checkpoint` sees no more than the first check: then
/// run the test below, and keep the new seeds.
#[test]
fn the_seed_checkpoints_are_gone_on_from() {
    let seeds = files("checkpoint", "step");
    assert_eq!(seeds.len(), 2);
    for file in seeds {
        assert!(
            gone_on(&std::fs::read(&file).unwrap()),
            "{}",
            file.display()
        );
    }
}

#[test]
#[ignore = "writes the seeds of the target checkpoint"]
fn write_the_seed_checkpoints() {
    let flies = |steps: &usize| {
        let state = seed_checkpoint(*steps).snapshot;
        state.transfers.flow.arrived > 0
    };
    let flight = (3..200).find(flies).expect("some change objects");
    for steps in [0, flight] {
        let checkpoint = seed_checkpoint(steps);
        let file = corpus("checkpoint").join(format!("step{steps}.state"));
        checkpoint.write(&file).unwrap();
    }
}
