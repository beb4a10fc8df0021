//! `myxo selftest`: states of built-in scenes by both engines, compared with the built-in table.

use std::fs;

use crate::program::{Folder, closed_pipe, failed, myxo, no_device, path, program, refused, text};
use serde_json::Value;

fn json(file: &std::path::Path) -> Value {
    serde_json::from_slice(&fs::read(file).expect("it was written")).expect("it is JSON")
}

/// A module in which the first float addition is replaced by a subtraction.
fn subtracting(built: &str) -> Vec<u8> {
    const ADD: u32 = 5 << 16 | 129;
    const SUBTRACT: u32 = 5 << 16 | 131;
    let module = fs::read(built).expect("the build left it");
    let words = module.chunks_exact(4);
    let mut words: Vec<u32> = words
        .map(|word| u32::from_le_bytes(word.try_into().expect("four bytes")))
        .collect();
    let mut at = 5;
    while words[at] != ADD {
        at += (words[at] >> 16) as usize;
    }
    words[at] = SUBTRACT;
    words.into_iter().flat_map(u32::to_le_bytes).collect()
}

/// Twenty steps of every scene by every strategy, on the device and by twins: the states are equal to the bit, and equal to the table's.
///
/// Takes long: it alone compares all scenes and strategies with the table of hashes.
#[test]
fn every_scene_ends_in_the_states_of_the_table_by_both_engines() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let file = folder.file("selftest.json");
    let output = myxo(&["selftest", "--json", path(&file)]);
    let printed = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{printed}");
    assert!(
        printed.contains("its arithmetic is the processor's"),
        "{printed}"
    );
    let report = json(&file);
    assert_eq!(report["broken_rules"], serde_json::json!([]));
    let runs = report["runs"].as_array().expect("they are listed");
    // 17 scenes, five of them with six strategies, and some runs of other settings.
    assert!(runs.len() > 40, "{}", runs.len());
    for run in runs {
        assert!(run["expected"].is_string(), "the table lacks {run}");
        assert_eq!(run["processor"], run["expected"], "{run}");
        if run["run"] != "layout" {
            assert_eq!(run["device"], run["expected"], "{run}");
        }
    }
    let strategies = |scene: &str| {
        let own = runs.iter().filter(|run| run["scene"] == scene);
        own.map(|run| run["device"].clone()).collect::<Vec<_>>()
    };
    let of = |scene: &str, name: &str| {
        let run = runs
            .iter()
            .find(|run| run["scene"] == scene && run["run"] == name);
        run.unwrap_or_else(|| panic!("{scene} has no run {name}"))
    };
    // Rules that built-in scenes do not use change the state.
    for (scene, plain, other) in [
        ("torus", "steps", "avoiding"),
        ("pair", "respawn", "restarts"),
    ] {
        let [plain, other] = [plain, other].map(|name| &of(scene, name)["device"]);
        assert_ne!(plain, other, "{scene}");
    }
    // Painting changes the state.
    for (scene, plain) in [("cube", "steps"), ("trio", "parallel")] {
        let painted = of(scene, "painted");
        assert_eq!(painted["painted"], true, "{painted}");
        let plain = of(scene, plain);
        assert_eq!(plain["painted"], false, "{painted}");
        assert_ne!(painted["device"], plain["device"], "{scene}");
    }
    // Strategies that keep every particle end in equal states, and particles do change objects.
    for scene in ["pair", "trio", "gears", "oats", "crowd"] {
        let own = strategies(scene);
        let (none, kept) = (&own[1], &own[3]);
        assert!(
            own[3..7].iter().all(|hash| hash == kept),
            "{scene}: {own:?}"
        );
        assert_ne!(none, kept, "{scene}");
    }
}

/// Would catch: a report of a difference without the kernel, or with a wrong one.
#[test]
fn a_kernel_that_calculates_otherwise_is_named() {
    if no_device() {
        return;
    }
    let modules = Folder::new();
    let built = concat!(env!("OUT_DIR"), "/diffuse.comp.spv");
    let mut module = fs::read(built).expect("the build left it");
    // The constant 1/9, one unit in the last place larger.
    let ninth = (1.0_f32 / 9.0).to_le_bytes();
    let at = module.windows(4).position(|word| word == ninth);
    let at = at.expect("the mean of nine texels is in it");
    module[at] += 1;
    modules.with("diffuse.comp.spv", module);
    let folder = Folder::new();
    let file = folder.file("selftest.json");
    let output = program()
        .args(["selftest", "--scene", "cube", "--json", path(&file)])
        .env("MYXO_SPIRV", modules.path())
        .env("MYXO_CARD_FORMS", "0")
        .output()
        .expect("the program starts");
    let printed = text(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{printed}");
    assert!(printed.contains("DIFFERS"), "{printed}");
    let report = json(&file);
    let runs = report["runs"].as_array().expect("they are listed");
    let differing: Vec<_> = runs.iter().filter(|run| run["agrees"] == false).collect();
    let names: Vec<_> = differing.iter().map(|run| &run["run"]).collect();
    assert_eq!(names, ["steps", "painted", "jones"], "{report}");
    for run in differing {
        let difference = &run["difference"];
        assert_eq!(difference["kernel"], "diffuse", "{difference}");
        assert_eq!(difference["field"], "next trail", "{difference}");
        assert!(difference["elements"].as_u64() > Some(0), "{difference}");
        // The processor is right.
        assert_eq!(run["processor"], run["expected"]);
    }
}

/// Would catch: a scene file whose run is that of a built-in scene or of other settings, and one whose engines differ and that passes.
#[test]
fn a_scene_file_is_compared_between_the_engines() {
    let folder = Folder::new();
    let text_of_scene =
        "[[object]]\nmesh = \"builtin:cube\"\n[particles]\ncount = 300\n[atlas]\nsize = 64\n";
    let scene = folder.with("own.toml", text_of_scene);
    let alone = ["selftest", "--scene", path(&scene)];
    for engine in ["cpu", "gpu"] {
        let message = failed(&[&alone[..], &["--engine", engine]].concat());
        assert!(message.contains("omit --engine"), "{message}");
    }
    let table = folder.file("hashes.tsv");
    let message = failed(&[&alone[..], &["--table", path(&table)]].concat());
    assert!(message.contains("omit --scene"), "{message}");
    let message = failed(&[&alone[..], &["--json", path(&scene)]].concat());
    assert!(message.contains("is an input of this run"), "{message}");
    let drawn =
        "[[object]]\nmesh = \"builtin:torus\"\n[distance]\nmethod = \"raster\"\n[particles]";
    let drawn = text_of_scene.replace("[particles]", drawn);
    let drawn = folder.with("drawn.toml", drawn);
    let message = failed(&["selftest", "--scene", path(&drawn)]);
    assert!(message.contains("choose bvh or brute"), "{message}");
    if no_device() {
        return;
    }
    let file = folder.file("selftest.json");
    let output = myxo(&[&alone[..], &["--json", path(&file)]].concat());
    let printed = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{printed}");
    assert!(printed.contains(" equal, no reference"), "{printed}");
    let report = json(&file);
    let [run] = &report["runs"].as_array().expect("they are listed")[..] else {
        panic!("it is one run: {report}");
    };
    assert_eq!(run["expected"], Value::Null);
    assert_eq!(run["agrees"], true);
    assert_eq!(run["device"], run["processor"]);
    // Its state is that of any other run of it.
    let ended = folder.file("report.json");
    let picture = folder.file("picture.png");
    let mut render = vec!["render", path(&scene), "--steps", "20", "--size", "32x32"];
    render.extend(["--out", path(&picture), "--report", path(&ended)]);
    assert_eq!(myxo(&render).status.code(), Some(0));
    assert_eq!(json(&ended)["state_hash"], run["device"]);

    let modules = Folder::new();
    let built = concat!(env!("OUT_DIR"), "/diffuse.comp.spv");
    modules.with("diffuse.comp.spv", subtracting(built));
    let output = program()
        .args(alone)
        .env("MYXO_SPIRV", modules.path())
        .env("MYXO_CARD_FORMS", "0")
        .output()
        .expect("the program starts");
    let printed = text(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{printed}");
    assert!(
        printed.contains(" DIFFERS, no reference") && printed.contains("diffuse"),
        "{printed}"
    );
}

/// Would catch: a painted run whose dabs are not compared one by one, so that the kernels of the step after them are blamed.
#[test]
fn a_brush_that_paints_otherwise_is_named() {
    if no_device() {
        return;
    }
    let modules = Folder::new();
    let built = concat!(env!("OUT_DIR"), "/paint.comp.spv");
    modules.with("paint.comp.spv", subtracting(built));
    let folder = Folder::new();
    let file = folder.file("selftest.json");
    let output = program()
        .args(["selftest", "--scene", "cube", "--json", path(&file)])
        .env("MYXO_SPIRV", modules.path())
        .env("MYXO_CARD_FORMS", "0")
        .output()
        .expect("the program starts");
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stdout));
    let report = json(&file);
    let runs = report["runs"].as_array().expect("they are listed");
    let differing: Vec<_> = runs.iter().filter(|run| run["agrees"] == false).collect();
    assert_eq!(differing.len(), 1, "{report}");
    assert_eq!(differing[0]["painted"], true);
    let difference = &differing[0]["difference"];
    assert_eq!(difference["kernel"], "paint", "{difference}");
    assert_eq!(difference["field"], "trail", "{difference}");
    assert_eq!(difference["step"], 11, "{difference}");
}

/// Would catch: a report that calls a hash portable although this device calculates differently, or distances are rasterized.
#[test]
fn reports_say_whether_a_hash_is_that_of_every_device() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let modules = Folder::new();
    let built = concat!(env!("OUT_DIR"), "/arithmetic.comp.spv");
    modules.with("arithmetic.comp.spv", subtracting(built));
    let run = |scene: &str, method: &str, is_odd: bool| {
        let file = folder.file("report.json");
        let picture = folder.file("picture.png");
        let mut run = program();
        run.args(["render", scene, "--steps", "1", "--out", path(&picture)]);
        run.args(["--set", "particles.count=100", "--set", "atlas.size=128"]);
        run.args(["--set", method, "--size", "64x64"]);
        if is_odd {
            run.env("MYXO_SPIRV", modules.path());
            run.env("MYXO_CARD_FORMS", "0");
        }
        let output = run.args(["--report", path(&file)]).output();
        let output = output.expect("the program starts");
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{said}");
        assert_eq!(
            said.contains("its state hashes differ from those of other devices"),
            is_odd,
            "{said}"
        );
        let report = json(&file);
        assert_eq!(report["arithmetic"], myxo::sim::arithmetic::VERSION);
        report["hash_is_portable"].clone()
    };
    assert_eq!(run("cube", "distance.method=bvh", false), true);
    assert_eq!(run("cube", "distance.method=bvh", true), false);
    // With one object there are no distances.
    assert_eq!(run("cube", "distance.method=raster", false), true);
    assert_eq!(run("pair", "distance.method=raster", false), false);
}

/// Would catch: a self-test that stops, and writes no file, because its standard output is closed.
#[test]
fn the_processor_alone_needs_no_device_and_makes_the_table() {
    let folder = Folder::new();
    let [file, facts] = ["hashes.tsv", "selftest.json"].map(|name| folder.file(name));
    let mut run = program();
    run.args(["selftest", "--engine", "cpu", "--scene", "plane"]);
    // No driver is asked.
    run.env("VK_DRIVER_FILES", "none.json")
        .env("VK_ICD_FILENAMES", "none.json");
    let output = run
        .args(["--table", path(&file), "--json", path(&facts)])
        .stdout(closed_pipe())
        .output()
        .expect("the program starts");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(json(&facts)["runs"].as_array().map(Vec::len), Some(6));
    let kept = include_str!("../../assets/hashes.tsv");
    let table = fs::read_to_string(&file).expect("it was written");
    let own = |table: &str| -> Vec<String> {
        let lines = table.lines().filter(|line| line.starts_with("plane\t"));
        lines.map(str::to_owned).collect()
    };
    assert_eq!(own(&table).len(), 6, "{table}");
    assert_eq!(own(&table), own(kept));
}

/// Would catch: results that are lost because Ctrl-C comes while the next runs are set up, which takes most of the time of a fine mesh.
#[cfg(unix)]
#[test]
fn an_interrupted_self_test_keeps_what_it_has() {
    use crate::program::interrupt;
    use std::io::{BufRead as _, BufReader};
    use std::process::Stdio;
    let folder = Folder::new();
    let file = folder.file("selftest.json");
    let mut child = program()
        .args(["selftest", "--engine", "cpu", "--json", path(&file)])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts");
    let printed = BufReader::new(child.stdout.take().expect("it is piped"));
    let mut printed = printed.lines().map(|line| line.expect("it is text"));
    assert!(printed.any(|line| line.starts_with("torus     steps ")));
    interrupt(&child);
    let rest: Vec<String> = printed.collect();
    assert_eq!(child.wait().expect("it ends").code(), Some(130), "{rest:?}");
    assert!(rest.iter().any(|line| line.starts_with("ended early, ")));
    let report = json(&file);
    let runs = report["runs"].as_array().expect("they are listed");
    assert_eq!(runs[1]["run"], "steps", "{report}");
}

#[test]
fn arguments_that_cannot_be_tested_are_refused() {
    let message = refused(2, &["selftest", "--scene", "torsu"]);
    assert!(message.contains("no such built-in scene"), "{message}");
    let folder = Folder::new();
    let file = folder.file("hashes.tsv");
    let message = failed(&["selftest", "--engine", "gpu", "--table", path(&file)]);
    assert!(message.contains("omit --engine gpu"), "{message}");
    let nowhere = folder.with("file", "no folder").join("report.json");
    let message = failed(&["selftest", "--engine", "cpu", "--json", path(&nowhere)]);
    assert!(message.contains("report.json"), "{message}");
}
