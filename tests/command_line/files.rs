//! The files and streams that the program writes to: odd names, no rights, no room, closed pipes. No half-written file ever has a final
//! name.

use std::ffi::OsStr;
use std::path::Path;
use std::process::Stdio;

use crate::program::{
    self, Folder, TINY, but_for_load, closed_pipe, failed, failure, no_device, path, program,
    short_render as render, text,
};

/// Names with blanks, and names that are not valid text.
#[cfg(target_os = "linux")]
#[test]
fn paths_are_any_bytes() {
    use std::os::unix::ffi::OsStrExt as _;
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let odd = OsStr::from_bytes(b"\xff \xfe");
    let named = |ending: &str| {
        let mut name = odd.to_owned();
        name.push(ending);
        folder.file(name)
    };
    let scene = named(".toml");
    std::fs::write(&scene, "[[object]]\nmesh = \"builtin:cube\"\n").expect("it can be written");
    let (picture, film) = (named(".png"), named(".gif"));
    let (report, state) = (named(".json"), named(".state"));
    let mut run = program();
    run.args([
        "render".as_ref(),
        scene.as_os_str(),
        "--out".as_ref(),
        picture.as_ref(),
    ]);
    run.args([
        "--out".as_ref(),
        film.as_os_str(),
        "--report".as_ref(),
        report.as_ref(),
    ]);
    run.args(["--checkpoint".as_ref(), state.as_os_str()]);
    run.args(["--steps", "2", "--size", "64x48"])
        .args(&TINY[1..]);
    let output = run.output().expect("the program starts");
    assert_eq!(
        output.status.code(),
        Some(0),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    for file in [&picture, &film, &report, &state] {
        assert!(file.is_file(), "{}", file.display());
    }
    // Meshes are named in scene files, which are text.
    let output = program()
        .arg("profile")
        .arg(named(".obj"))
        .output()
        .expect("the program starts");
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("the path is not Unicode"));
}

#[test]
fn outputs_that_cannot_be_written_are_refused_at_once() {
    let folder = Folder::new();
    let file = folder.with("file", "");
    for name in [
        "file/x.png",
        "file/x.gif",
        "file/x.mp4",
        "file/x_%d.png",
        "file/x/",
    ] {
        let message = failed(&render("cube", &folder.file(name), &[]));
        assert!(
            message.contains("a part of the path is a file and not a folder"),
            "{message}"
        );
    }
    let trace = file.join("x.json");
    let message = failed(&["profile", "cube", "--trace", path(&trace)]);
    assert!(message.contains(path(&trace)), "{message}");
    if cfg!(target_os = "linux") {
        let message = failed(&render("cube", Path::new("/proc/x.png"), &[]));
        assert!(
            message.starts_with("myxo: cannot write /proc/x.png: "),
            "{message}"
        );
    }
    assert_eq!(folder.names(), ["file"]);
}

/// Catches a result that is lost because its file cannot be replaced, as one that a container has as a volume.
#[cfg(target_os = "linux")]
#[test]
fn a_mount_point_takes_the_content() {
    let folder = Folder::new();
    let picture = folder.with("x.png", "old");
    let script = "mount --bind \"$1\" \"$1\" || exit 99; shift; exec \"$@\"";
    let mounted = |program: &OsStr, arguments: &[&str]| {
        std::process::Command::new("unshare")
            .args(["-Urm", "sh", "-c", script, "sh", path(&picture)])
            .arg(program)
            .args(arguments)
            .stdin(Stdio::null())
            .output()
    };
    if !mounted("true".as_ref(), &[]).is_ok_and(|output| output.status.success()) {
        eprintln!("skipped: nothing can be mounted here");
        return;
    }
    let arguments = ["atlas", "cube", "--size", "64", "--out", path(&picture)];
    let output = mounted(program().get_program(), &arguments).expect("there is a shell");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let size = image::image_dimensions(&picture).expect("it is a picture");
    assert_eq!(size, (64, 64));
    assert_eq!(folder.names(), ["x.png"]);
}

#[test]
fn without_ffmpeg_other_formats_are_named() {
    let folder = Folder::new();
    let film = folder.file("x.mp4");
    let output = program()
        .args(render(
            "cube",
            &film,
            &["--out", path(&folder.file("y.png"))],
        ))
        .env("PATH", "/nonexistent")
        .output()
        .expect("the program starts");
    let message = failure(&output);
    for part in ["apt-get install ffmpeg", "x_%05d.png", "x.gif"] {
        assert!(message.contains(part), "{part} in {message}");
    }
    assert!(folder.names().is_empty());
}

/// A full disk: errors are printed, no half-written file is left, and files that fit are written.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_what_is_whole() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let [picture, small, gif, film] =
        ["x.png", "s/%d.png", "x.gif", "x.mp4"].map(|name| folder.file(name));
    let report = folder.file("x.json");
    let mut arguments = render("cube", &picture, &["--report", path(&report)]);
    for file in [&small, &gif, &film] {
        arguments.extend(["--out", path(file)]);
    }
    let position = arguments.iter().position(|argument| *argument == "64x48");
    arguments[position.expect("the size is there")] = "800x600";
    let output = program::with_files_up_to(24, &arguments);
    let messages = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{messages}");
    assert!(!messages.contains("panicked"), "{messages}");
    for file in ["x.png", "s/0.png", "x.gif", "x.mp4"] {
        let says = format!("myxo: cannot write {}: ", path(&folder.file(file)));
        assert_eq!(messages.matches(&says).count(), 1, "{says} in {messages}");
    }
    assert!(
        messages.contains("raise the limit of file sizes (`ulimit -f`), or choose another disk"),
        "{messages}"
    );
    assert_eq!(folder.names(), ["x.json"], "{messages}");
    assert_eq!(program::report(&report)["interrupted"], false);
}

/// If a checkpoint finds no room, all other files are still written.
#[cfg(unix)]
#[test]
fn without_a_checkpoint_all_else_is_written() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let state = folder.file("x.state");
    let keep = ["--checkpoint", path(&state), "--steps", "2"];
    let says = format!("myxo: cannot write {}: ", path(&state));
    let refused = |arguments: &[&str]| {
        let output = program::with_files_up_to(64, arguments);
        let messages = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{messages}");
        assert_eq!(messages.matches(&says).count(), 1, "{messages}");
        messages
    };
    let (picture, report) = (folder.file("x.png"), folder.file("x.json"));
    let render = render(
        "cube",
        &picture,
        &["--report", path(&report), keep[0], keep[1]],
    );
    let messages = refused(&render);
    assert!(
        messages.contains(&format!("{} (", path(&picture))),
        "{messages}"
    );
    let hash = program::report(&report)["state_hash"].clone();
    assert!(
        messages.contains(hash.as_str().expect("a hash")),
        "{messages}"
    );
    let model = folder.file("x.ply");
    let out = ["--out", path(&model)];
    let messages = refused(&[&["export"], &TINY[..], &keep, &out].concat());
    assert!(
        messages.contains(&format!("{} (", path(&model))),
        "{messages}"
    );
    let times = folder.file("times.json");
    let measured = ["--warmup", "1", "--report", path(&times)];
    refused(&[&["profile"], &TINY[..], &keep, &measured].concat());
    assert_eq!(folder.names(), ["times.json", "x.json", "x.ply", "x.png"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_an_error_and_a_closed_one_is_none() {
    if no_device() {
        return;
    }
    let arguments = [
        &["profile"],
        &TINY[..],
        &["--steps", "2", "--warmup", "0", "--json"],
    ]
    .concat();
    let full = || {
        std::fs::File::options()
            .write(true)
            .open("/dev/full")
            .expect("Linux has it")
    };
    let output = program()
        .args(&arguments)
        .stdout(full())
        .output()
        .expect("the program starts");
    let message = failure(&output);
    assert!(
        message.contains("cannot write to the standard output: "),
        "{message}"
    );
    assert!(message.contains("free some space"), "{message}");
    // It fails even if the error cannot be printed.
    let output = program()
        .args(&arguments)
        .stdout(full())
        .stderr(full())
        .output();
    assert_eq!(output.expect("the program starts").status.code(), Some(1));

    let mut child = program()
        .args(&arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(
        (
            output.status.code(),
            but_for_load(&text(&output.stderr)).as_str()
        ),
        (Some(0), "")
    );
}

/// Would catch: a report or a trace that is lost because the standard output is closed.
#[test]
fn files_are_written_if_nothing_can_be_printed() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let [report, trace, turns] = ["a.json", "b.json", "c.json"].map(|name| folder.file(name));
    let steps = ["--steps", "2", "--warmup", "0", "--report"];
    let alone = [path(&report), "--trace", path(&trace)];
    let against = [path(&turns), "--against", "trail.decay=0.8"];
    for options in [alone, against] {
        let output = program()
            .args([&["profile"], &TINY[..], &steps, &options].concat())
            .stdout(closed_pipe())
            .output()
            .expect("the program starts");
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    }
    assert_eq!(folder.names(), ["a.json", "b.json", "c.json"]);
}

/// A preset is built in, in a file, or saved in the window.
#[test]
fn presets_come_from_files_and_from_the_users_folder() {
    let folder = Folder::new();
    let mine = folder.with("mine.toml", "# Mine, all mine.\n[trail]\ndecay = 0.375\n");
    let kept = folder.file("data/myxo/presets");
    std::fs::create_dir_all(&kept).expect("it can be made");
    std::fs::copy(&mine, kept.join("fern.toml")).expect("it can be copied");
    std::fs::write(kept.join("torn.toml"), "[trail").expect("it can be written");
    let scenes = |arguments: &[&str]| {
        let mut run = program();
        run.env("XDG_DATA_HOME", folder.file("data"));
        run.arg("scenes").args(arguments);
        run.output().expect("the program starts")
    };
    for preset in [path(&mine), "fern"] {
        let output = scenes(&["cube", "--preset", preset]);
        let scene = text(&output.stdout);
        assert!(scene.contains("decay = 0.375"), "{preset}: {scene}");
    }
    for (preset, parts) in [
        ("torn", ["torn.toml", "not valid TOML"]),
        ("furn", ["there is no preset `furn`", "a .toml file"]),
        ("nowhere.toml", ["cannot read the preset", "nowhere.toml"]),
    ] {
        let message = failure(&scenes(&["cube", "--preset", preset]));
        for part in parts {
            assert!(message.contains(part), "{part}: {message}");
        }
    }
    let list = text(&scenes(&[]).stdout);
    for part in [
        "Presets of your own",
        "fern       Mine, all mine.",
        "torn       cannot be used",
    ] {
        assert!(list.contains(part), "{part}: {list}");
    }
}
