//! Paths of the project's files, of the program, and of scratch folders for tests: in the checkout that they were built in, or in the
//! unpacked archive of `make bundle`, which `MYXO_ROOT` names.

#![allow(dead_code, reason = "each test program uses its own part")]

use std::path::{Path, PathBuf};

fn unpacked() -> Option<PathBuf> {
    std::env::var_os("MYXO_ROOT").map(PathBuf::from)
}

/// The folder that has `assets/`.
pub fn root() -> PathBuf {
    unpacked().unwrap_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")))
}

/// The program: `built` is where cargo has put it, which only some test programs can name.
pub fn program(built: &str) -> PathBuf {
    unpacked().map_or_else(|| PathBuf::from(built), |root| root.join("bin/myxo"))
}

/// For files that a later run may use. The archive leaves none behind on the machines of others.
pub fn scratch() -> PathBuf {
    match unpacked() {
        Some(_) => std::env::temp_dir(),
        None => Path::new(env!("CARGO_TARGET_TMPDIR")).to_owned(),
    }
}
