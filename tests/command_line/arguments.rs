//! The program as people run it: bad input gives one clear message, a documented exit code, and nothing else.

use std::path::Path;
use std::process::{Command, Stdio};

use crate::program::{closed_pipe, failed, myxo, no_device, path, program, refused, text};
use ::myxo::scene::{Overrides, Scene};

#[test]
fn unknown_scene_names_the_nearest() {
    for command in [
        &["render", "tours", "--out", "x.png"][..],
        &["profile", "tours"],
        &["lab", "tours"],
        &["scenes", "tours"],
    ] {
        let message = failed(command);
        assert!(
            message.contains("`tours`, did you mean `torus`?"),
            "{message}"
        );
    }
    assert!(!Path::new("x.png").exists());
}

#[test]
fn missing_scene_file_is_named() {
    let message = failed(&["render", "no/such.toml", "--out", "x.png"]);
    assert!(
        message.starts_with("myxo: cannot read the scene no/such.toml: "),
        "{message}"
    );
}

#[test]
fn all_errors_of_a_scene_are_reported_at_once() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = folder.path().join("wrong.toml");
    std::fs::write(
        &scene,
        "[trail]\ndecay = 2\ndiffusoin = 0.1\n[particles]\ncount = \"many\"\n",
    )
    .expect("it can be written");
    let message = failed(&[
        "profile",
        path(&scene),
        "--set",
        "atlas.size=1",
        "--set",
        "physarum.sped=1",
    ]);
    for part in [
        "wrong.toml: 5 things are wrong:\n",
        "  line 2: trail.decay = 2 is out of range: 0 to 1\n",
        "  line 3: trail.diffusoin: no such key; did you mean trail.diffusion?\n",
        "  line 5: particles.count: a whole number is expected, not the text \"many\"\n",
        "  --set atlas.size=1: atlas.size = 1 is out of range: whole numbers 16 to 32,768 texels a side\n",
        "  --set physarum.sped=1: physarum.sped: no such key; did you mean physarum.speed?\n",
    ] {
        assert!(message.contains(part), "{part}\nis not in\n{message}");
    }
}

#[test]
fn unknown_preset_names_the_nearest() {
    let message = failed(&["scenes", "torus", "--preset", "netwrok"]);
    assert!(
        message.contains("`netwrok`, did you mean `network`?"),
        "{message}"
    );
}

#[test]
fn seeds_out_of_range_are_refused() {
    let message = failed(&["scenes", "torus", "--seed", "4294967296"]);
    assert!(
        message.contains("whole numbers 0 to 4,294,967,295"),
        "{message}"
    );
    refused(2, &["scenes", "torus", "--seed", "-1"]);
    let message = failed(&["scenes", "torus", "--seed", "3", "--set", "seed=4"]);
    assert!(
        message.contains("--seed 3: --set seed=4 sets the seed, too"),
        "{message}"
    );
}

#[test]
fn output_that_cannot_be_written_is_refused_before_the_work() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("file");
    std::fs::write(&file, "").expect("it can be written");
    let below = file.join("x.png");
    let message = failed(&["render", "cube", "--out", path(&below)]);
    assert!(message.contains(path(&below)), "{message}");
    let report = file.join("x.json");
    let message = failed(&["profile", "cube", "--report", path(&report)]);
    assert!(message.contains(path(&report)), "{message}");
    let checkpoint = file.join("x.state");
    let message = failed(&["profile", "cube", "--checkpoint", path(&checkpoint)]);
    assert!(message.contains(path(&checkpoint)), "{message}");
    assert_eq!(
        std::fs::read_dir(folder.path())
            .expect("it is a folder")
            .count(),
        1,
        "nothing is left behind"
    );
}

#[test]
fn outputs_must_have_different_names() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let jpg = folder.path().join("x.jpg");
    let message = failed(&["render", "cube", "--out", path(&jpg)]);
    assert!(
        message.contains("x.jpg") && message.contains(".mp4"),
        "{message}"
    );
    let png = folder.path().join("x.png");
    let message = failed(&["render", "cube", "--out", path(&png), "--out", path(&png)]);
    assert!(message.contains("is named twice"), "{message}");
    assert_eq!(
        std::fs::read_dir(folder.path())
            .expect("it is a folder")
            .count(),
        0,
        "nothing is left behind"
    );
}

#[test]
fn missing_state_to_resume_is_named() {
    let message = failed(&["profile", "cube", "--resume", "no/such.state"]);
    assert!(
        message.starts_with("myxo: cannot read no/such.state: "),
        "{message}"
    );
}

#[test]
fn models_that_cannot_be_read_are_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = folder.path().join("scene.toml");
    std::fs::write(
        &scene,
        "[[object]]\nname = \"fish\"\nmesh = \"no fish.obj\"\n",
    )
    .expect("it can be written");
    let message = failed(&["profile", path(&scene)]);
    assert!(
        message.contains("object `fish`: ") && message.contains("no fish.obj"),
        "{message}"
    );
    let message = failed(&["profile", "builtin:tours"]);
    assert!(message.contains("torus"), "{message}");
}

#[test]
fn unknown_devices_are_answered_with_those_that_exist() {
    if no_device() {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let table = folder.path().join("in.csv");
    std::fs::write(
        &table,
        "id,face,b0,b1,b2,dx,dy,dz,length\n1,0,1,0,0,1,0,0,1\n",
    )
    .expect("it can be written");
    let query = [
        "query",
        "geodesic",
        "--mesh",
        "builtin:cube",
        "--in",
        path(&table),
        "--device",
        "abacus",
    ];
    for command in [&query[..], &["info", "--device", "abacus"]] {
        let message = failed(command);
        assert!(
            message.contains("no device is called \"abacus\"") && message.contains("\n  0: "),
            "{message}"
        );
    }
}

#[test]
fn info_lists_devices_and_missing_tools() {
    if no_device() {
        return;
    }
    let output = myxo(&["info", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let info: serde_json::Value = serde_json::from_slice(&output.stdout).expect("it is JSON");
    let chosen = info["chosen"].as_u64().expect("a device is chosen") as usize;
    let device = &info["devices"][chosen];
    assert_eq!(device["missing"], serde_json::json!([]));
    let name = device["name"].as_str().expect("it has a name");
    let output = myxo(&["info", "--device", name]);
    let list = text(&output.stdout);
    assert!(
        list.contains(&format!("  {chosen}: {name} ")) && list.contains("<- is used"),
        "{list}"
    );
}

#[test]
fn mistyped_commands_and_options_are_usage_errors() {
    let message = refused(2, &["rendr", "torus"]);
    assert!(message.contains("render"), "{message}");
    let message = refused(2, &["render", "torus", "--out", "x.png", "--stesp", "5"]);
    assert!(message.contains("--steps"), "{message}");
    refused(2, &["render", "torus"]);
    refused(2, &["render", "torus", "--out", "x.png", "--steps", "-5"]);
    refused(
        2,
        &["render", "torus", "--out", "x.png", "--size", "100000x1"],
    );
    refused(2, &["profile", "torus", "--hash-every", "0"]);
    refused(2, &["query"]);
}

#[test]
fn query_tables_that_are_wrong_are_named_with_their_line() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let table = folder.path().join("in.csv");
    let out = folder.path().join("out.csv");
    let ask = |content: &str| {
        std::fs::write(&table, content).expect("it can be written");
        let arguments = [
            "query",
            "geodesic",
            "--mesh",
            "builtin:cube",
            "--in",
            path(&table),
            "--out",
            path(&out),
        ];
        let message = failed(&arguments);
        assert!(!out.exists(), "nothing is left under the final name");
        message
    };
    let message = ask("id,face,b0,b1,b2,dx,dy,dz\n1,0,1,0,0,1,0,0\n");
    assert!(
        message.contains("in.csv: there is no column length"),
        "{message}"
    );
    let message =
        ask("id,face,b0,b1,b2,dx,dy,dz,length\n1,0,1,0,0,1,0,0,1\n2,0,1,0,0,1,zero,0,1\n");
    assert!(
        message.contains("in.csv: line 3: dy is `zero`"),
        "{message}"
    );
    let message = failed(&[
        "query",
        "geodesic",
        "--mesh",
        "no.obj",
        "--in",
        path(&table),
    ]);
    assert!(message.contains("no.obj"), "{message}");
}

/// Reports that `compare` reads, with the keys that it needs.
fn report(state_hash: &str) -> String {
    format!(
        "{{\"device\":\"d\",\"driver\":\"v\",\"scene\":\"cube\",\"seed\":7,\"steps\":9,\"particles\":5,\"atlas_size\":64,\
         \"triangles\":12,\"state_hash\":\"{state_hash}\",\"gpu_ms_per_step\":null,\"wall_ms_per_step\":2.0,\"kernels\":[],\
         \"counters\":{{\"lost\":0,\"doubled\":0,\"trail_mass\":1.0}},\"validation\":false,\"interrupted\":false,\
         \"command\":\"\",\"version\":\"\",\"commit\":null,\"processor\":null,\"load_average\":null}}"
    )
}

/// Would catch: states that differ, and an exit code that says otherwise because the output is closed.
#[test]
fn compare_answers_by_its_exit_code() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, content: &str| {
        let file = folder.path().join(name);
        std::fs::write(&file, content).expect("it can be written");
        file
    };
    let a = write("a.json", &report("00000000000000aa"));
    let same = write("same.json", &report("00000000000000aa"));
    let other = write("other.json", &report("00000000000000bb"));
    let broken = write("broken.json", "{\"device\": 1");

    let output = myxo(&["compare", path(&a), path(&same)]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stdout).starts_with("state      equal"));
    let output = myxo(&["compare", path(&a), path(&other)]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stdout).starts_with("state      DIFFERS"));
    assert_eq!(text(&output.stderr), "");
    let mut unread = program();
    unread.args(["compare", path(&a), path(&other)]);
    let status = unread.stdout(closed_pipe()).status();
    assert_eq!(status.expect("the program starts").code(), Some(1));
    let message = refused(2, &["compare", path(&a), path(&broken)]);
    assert!(message.contains("broken.json"), "{message}");
    refused(2, &["compare", path(&a), "no/such.json"]);
}

#[test]
fn a_printed_scene_is_a_scene() {
    let output = myxo(&[
        "scenes",
        "cube",
        "--preset",
        "cells",
        "--set",
        "trail.decay=0.5",
        "--seed",
        "99",
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let printed = text(&output.stdout);
    assert!(
        printed.contains("seed = 99") && printed.contains("decay = 0.5"),
        "{printed}"
    );
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("again.toml");
    std::fs::write(&file, &printed).expect("it can be written");
    let again = myxo(&["scenes", path(&file)]);
    assert_eq!(text(&again.stdout), printed);
}

/// Would catch: paths that begin at the folder of the scene that is printed, and lead nowhere from the folder of the file.
#[test]
fn a_printed_scene_of_another_folder_loads() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let below = folder.path().join("below");
    std::fs::create_dir(&below).expect("it can be made");
    let model = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    std::fs::write(below.join("one.obj"), model).expect("it can be written");
    let scene = "[areas]\nmap = \"areas.png\"\n[[object]]\nmesh = \"one.obj\"\n";
    std::fs::write(below.join("a.toml"), scene).expect("it can be written");
    let mut run = program();
    run.args(["scenes", "below/a.toml"]);
    let output = run.current_dir(folder.path()).output();
    let output = output.expect("the program starts");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let file = folder.path().join("b.toml");
    std::fs::write(&file, &output.stdout).expect("it can be written");
    let scene = Scene::load(&file, &Overrides::default()).expect("its mesh is found");
    let map = Path::new(&scene.settings.areas.map);
    assert!(map.is_absolute() && map.ends_with("below/areas.png"));
}

#[test]
fn lists_name_everything() {
    let list = text(&myxo(&["scenes"]).stdout);
    for name in ["cube", "torus", "network", "builtin:icosphere"] {
        assert!(list.contains(name), "{name} in {list}");
    }
    let keys = text(&myxo(&["scenes", "--keys"]).stdout);
    assert!(
        keys.contains("trail.decay = 0.95\n    Trail decay: ")
            && keys.contains("object.N.scale = 1\n"),
        "{keys}"
    );
}

/// `myxo scenes --keys | head -1`: the reader closes the pipe, which is no failure.
#[test]
fn a_closed_pipe_is_quiet() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_myxo"))
        .args(["scenes", "--keys"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(text(&output.stderr), "");
    assert_eq!(output.status.code(), Some(0));
}

/// Scripts that save the help or the version must see the error of a full disk.
#[cfg(target_os = "linux")]
#[test]
fn help_that_cannot_be_written_is_an_error() {
    for word in ["--help", "--version", "help"] {
        let full = std::fs::File::options().write(true).open("/dev/full");
        let output = Command::new(env!("CARGO_BIN_EXE_myxo"))
            .arg(word)
            .stdout(full.expect("it is there"))
            .output()
            .expect("the program starts");
        assert_eq!(output.status.code(), Some(1), "{word}");
        let said = text(&output.stderr);
        assert!(
            said.contains("cannot write to the standard output"),
            "{word}: {said}"
        );
    }
}

#[test]
fn help_has_examples_and_exit_codes() {
    let help = text(&myxo(&["--help"]).stdout);
    for part in ["Examples:", "Exit codes:", "130"] {
        assert!(help.contains(part), "{part} in {help}");
    }
    let listed = help.lines().skip_while(|line| *line != "Commands:");
    let listed = listed.skip(1).take_while(|line| !line.is_empty());
    // Continuation lines of a command's description are indented further.
    let commands: Vec<&str> = listed
        .filter_map(|line| line.strip_prefix("  "))
        .filter(|line| !line.starts_with(' '))
        .filter_map(|line| line.split(' ').next())
        .filter(|name| *name != "help")
        .collect();
    assert!(commands.contains(&"render"), "{help}");
    for command in commands {
        let own = text(&myxo(&[command, "--help"]).stdout);
        let usage = format!("Usage: myxo {command} ");
        assert!(own.contains(&usage), "{own}");
    }
    let help = text(&myxo(&["render", "--help"]).stdout);
    for part in [
        "--set <KEY=VALUE>",
        "--preset",
        "--seed",
        "--device",
        "--validate",
        "--checkpoint",
        "--resume",
        "--hash-every",
        "%05d",
    ] {
        assert!(help.contains(part), "{part} in {help}");
    }
}
