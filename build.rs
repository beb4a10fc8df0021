//! Compiles and reflects the shaders, and generates their typed handles; `src/shader_build` does the work.

#[path = "src/shader_build/mod.rs"]
mod shader_build;

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=src/shader_build");
    println!("cargo::rerun-if-changed=shaders");
    // `tests/shader_build.rs` runs this program on shaders of its own.
    if let Ok(program) = std::env::current_exe() {
        println!("cargo::rustc-env=MYXO_BUILD_SCRIPT={}", program.display());
    }
    tell_commit();
    let out = std::env::var_os("OUT_DIR").expect("cargo sets OUT_DIR");
    match shader_build::build(Path::new("shaders"), Path::new(&out)) {
        Ok(warnings) => {
            for line in warnings {
                println!("cargo::warning={line}");
            }
        }
        Err(message) => {
            for line in message.lines() {
                println!("cargo::error={line}");
            }
            std::process::exit(1);
        }
    }
}

/// Tells the program the last commit of the checkout that it is built from, if this is a checkout. Changes on top of
/// it are not told.
fn tell_commit() {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).output().ok()?;
        let text = String::from_utf8(output.stdout).ok()?;
        output.status.success().then(|| text.trim().to_owned())
    };
    // Unpacked inside of another project's checkout, it is none of that project's commits.
    if git(&["rev-parse", "--show-prefix"]).is_none_or(|prefix| !prefix.is_empty()) {
        return;
    }
    if let Some(commit) = git(&["rev-parse", "--short=12", "HEAD"]) {
        println!("cargo::rustc-env=MYXO_COMMIT={commit}");
    }
    // HEAD names a branch and the branch's file a commit, unless refs are packed; the log grows with every commit.
    let branch = git(&["symbolic-ref", "--quiet", "HEAD"]);
    for name in ["HEAD", "logs/HEAD"].into_iter().chain(branch.as_deref()) {
        let file = git(&["rev-parse", "--git-path", name]).unwrap_or_default();
        if Path::new(&file).is_file() {
            println!("cargo::rerun-if-changed={file}");
        }
    }
}
