//! Compiles and reflects the shaders, and generates their typed handles; `src/shader_build` does the work.

#[path = "src/shader_build/mod.rs"]
mod shader_build;

use std::path::Path;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=src/shader_build");
    println!("cargo::rerun-if-changed=shaders");
    // `tests/project/shader_build.rs` runs this program on shaders of its own.
    if let Ok(program) = std::env::current_exe() {
        println!("cargo::rustc-env=MYXO_BUILD_SCRIPT={}", program.display());
    }
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
