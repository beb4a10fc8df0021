//! Shader modules from a folder in place of the built-in ones: `MYXO_SPIRV`.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use crate::program::{Folder, failure, no_device, path, program, report, short_render, text};
use serde_json::Value;

/// The modules that the build left.
const BUILT: &str = env!("OUT_DIR");

#[test]
fn modules_of_a_folder_run_and_are_listed() {
    if no_device() {
        return;
    }
    let modules = Folder::new();
    for entry in fs::read_dir(BUILT).expect("it is a folder") {
        let file = entry.expect("it can be listed").path();
        if file.extension().is_some_and(|ending| ending == "spv") {
            let name = file.file_name().expect("it is a file");
            fs::copy(&file, modules.file(name)).expect("there is room");
        }
    }
    let all = modules.names();
    let folder = Folder::new();
    let hash = |name: &str, modules: Option<&Path>| -> Value {
        let (picture, file) = (folder.file("picture.png"), folder.file(name));
        let mut run = program();
        run.args(short_render("cube", &picture, &["--report", path(&file)]));
        run.envs(modules.map(|folder| ("MYXO_SPIRV", folder)));
        let output = run.output().expect("the program starts");
        assert!(output.status.success(), "{}", text(&output.stderr));
        report(&file)["state_hash"].clone()
    };
    let plain = hash("plain.json", None);
    assert!(plain.is_string());
    assert_eq!(plain, hash("replaced.json", Some(modules.path())));
    let list = fs::read_to_string(modules.file("used")).expect("something was used");
    let used: BTreeSet<_> = list.lines().collect();
    assert_eq!(used.len(), list.lines().count(), "each once: {list}");
    for kernel in ["advance.comp.spv", "diffuse.comp.spv", "surface.frag.spv"] {
        assert!(used.contains(kernel), "{kernel}: {list}");
    }
    // A pipeline that is created but never recorded is not used.
    assert!(!used.contains("transfer_out.comp.spv"), "{list}");
    assert!(used.iter().all(|&file| all.iter().any(|name| name == file)));
}

#[test]
fn a_file_that_is_no_module_is_an_error_with_its_path() {
    if no_device() {
        return;
    }
    let modules = Folder::new();
    let file = modules.with("advance.comp.spv", "#version 460\n");
    let mut run = program();
    run.args(short_render("cube", &modules.file("picture.png"), &[]));
    run.env("MYXO_SPIRV", modules.path());
    let output = run.output().expect("the program starts");
    let message = failure(&output);
    assert!(message.contains(path(&file)), "{message}");
    assert!(message.contains("it is not SPIR-V"), "{message}");
}
