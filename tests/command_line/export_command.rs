//! `myxo export`: every file, checkpoints, bad names, a full disk; and pictures without a background.

use crate::program::{
    self, Folder, TINY, done, failed, no_device, path, refused, report, short_render, text,
};

const ENDINGS: [&str; 4] = ["glb", "ply", "npz", "toml"];

#[test]
fn a_run_and_its_checkpoint_export_the_same() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let state = folder.file("x.state");
    let scene = [&["export"], &TINY[..]].concat();
    let run = |name: &str, options: &[&str]| -> Vec<Vec<u8>> {
        let files = ENDINGS.map(|ending| folder.file(format!("{name}.{ending}")));
        let mut arguments = [&scene, options].concat();
        files
            .iter()
            .for_each(|file| arguments.extend(["--out", path(file)]));
        let messages = done(&arguments);
        for file in &files {
            let part = format!("{} (", path(file));
            assert!(messages.contains(&part), "{part} in {messages}");
        }
        assert!(
            messages.contains("texels apart, and the trail is finer"),
            "{messages}"
        );
        assert!(
            messages.contains("cube at step 15: state hash "),
            "{messages}"
        );
        files
            .iter()
            .map(|file| std::fs::read(file).expect("it is there"))
            .collect()
    };
    let json = folder.file("a.json");
    let kept = ["--checkpoint", path(&state), "--report", path(&json)];
    let first = run("a", &[&["--steps", "15"], &kept[..]].concat());
    let whole = report(&json);
    assert_eq!(
        (&whole["steps"], &whole["interrupted"]),
        (&15.into(), &false.into())
    );
    let hash = whole["state_hash"].as_str().expect("there is a hash");
    let utf32: Vec<u8> = hash
        .chars()
        .flat_map(|c| u32::from(c).to_le_bytes())
        .collect();
    let is_hash = |bytes: &[u8]| bytes == utf32;
    assert!(
        first[2].windows(utf32.len()).any(is_hash),
        "it is in the .npz"
    );
    assert!(first[0].starts_with(b"glTF\x02\0\0\0") && first[1].starts_with(b"ply\n"));
    assert!(first[2].starts_with(b"PK") && first[3].starts_with(b"# cube, as it was at step 15"));
    assert_eq!(run("b", &["--steps", "0", "--resume", path(&state)]), first);
    // Its settings are kept, with those of the command line over them.
    let own = |set: &[&str]| {
        let [scene, again] = ["own.toml", "own.json"].map(|name| folder.file(name));
        let run = ["export", "--steps", "0", "--resume", path(&state)];
        let files = ["--out", path(&scene), "--report", path(&again)];
        let messages = done(&[&run[..], &files, set].concat());
        (report(&again), messages)
    };
    let (resumed, messages) = own(&[]);
    assert_eq!(resumed["settings"], whole["settings"]);
    assert_eq!(resumed["state_hash"], whole["state_hash"]);
    assert!(messages.contains("continues from step 15\n"), "{messages}");
    let (resumed, messages) = own(&["--set", "trail.decay=0.5"]);
    assert_eq!(resumed["settings"]["trail"]["decay"], 0.5);
    let says = "continues from step 15; trail.decay = 0.5, which was 0.93\n";
    assert!(messages.contains(says), "{messages}");
    let picture = folder.file("x.png");
    let resume = ["--resume", path(&state), "--out", path(&picture)];
    let message = failed(&[&["render", "--seed", "8"], &resume[..]].concat());
    assert!(message.contains("seed = 8, which was 7"), "{message}");

    // The model is a scene again, and so is the scene file.
    for name in ["a.glb", "a.toml"] {
        let (scene, picture) = (folder.file(name), folder.file("again.png"));
        done(&[
            "render",
            path(&scene),
            "--steps",
            "2",
            "--size",
            "64x48",
            "--out",
            path(&picture),
            "--set",
            "particles.count=2000",
            "--set",
            "atlas.size=64",
            "--set",
            "atlas.method=charts",
        ]);
    }
    let vertex = folder.file("v.glb");
    done(
        &[
            &scene,
            &["--steps", "3", "--colors", "vertex", "--out", path(&vertex)][..],
        ]
        .concat(),
    );
    let model = std::fs::read(vertex).expect("it is there");
    let holds = |words: &str| {
        model
            .windows(words.len())
            .any(|window| window == words.as_bytes())
    };
    assert!(holds("COLOR_0") && !holds("image/png"));
}

#[test]
fn outputs_that_cannot_be_written_are_refused_at_once() {
    let folder = Folder::new();
    let file = folder.with("file", "");
    for (name, words) in [
        ("x.stl", "unknown output format; call it NAME.glb"),
        ("x", "unknown output format"),
        ("file/x.glb", "cannot write"),
        ("", "unknown output format"),
    ] {
        let out = folder.file(name);
        let begun = std::time::Instant::now();
        let message = failed(&["export", "torus", "--out", path(&out)]);
        assert!(message.contains(words), "{message}");
        assert!(begun.elapsed().as_secs() < 5, "before the scene is set up");
    }
    std::fs::create_dir(folder.file("x.npz")).expect("it can be made");
    let out = folder.file("x.npz");
    assert!(failed(&["export", "torus", "--out", path(&out)]).contains("folder"));
    let out = folder.file("x.glb");
    let twice = ["export", "torus", "--out", path(&out), "--out", path(&out)];
    assert!(failed(&twice).contains("is named twice"));
    refused(2, &["export", "torus"]);
    refused(
        2,
        &["export", "torus", "--out", path(&out), "--colors", "red"],
    );
    assert_eq!(folder.names(), ["file", "x.npz"]);
    assert_eq!(std::fs::read(file).expect("it is there"), b"");
}

/// A series has the states of its steps, as a run to each of them exports it, and continues where a checkpoint ended.
#[test]
fn a_series_has_each_step_in_a_file_of_its_own() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let (series, state) = (folder.file("x.npz"), folder.file("x.state"));
    let scene = [&["export"], &TINY[..]].concat();
    let run = |options: &[&str]| done(&[&scene, options].concat());
    let kept = ["--checkpoint", path(&state)];
    let every = ["--every", "3", "--out", path(&series)];
    let messages = run(&[&["--steps", "7"], &every[..], &kept].concat());
    let name = |step: u32| format!("x_{step:06}.npz");
    for step in [3, 6, 7] {
        let part = path(&folder.file(name(step))).to_owned();
        assert!(messages.contains(&part), "{part} in {messages}");
    }
    let names = [3, 6, 7].map(name);
    let wanted: Vec<&str> = ["x.state"]
        .into_iter()
        .chain(names.iter().map(String::as_str))
        .collect();
    assert_eq!(folder.names(), wanted, "and nothing of another name");
    for step in [3, 7] {
        let alone = folder.file("alone.npz");
        run(&["--steps", &step.to_string(), "--out", path(&alone)]);
        let [found, wanted] = [&folder.file(name(step)), &alone]
            .map(|file| std::fs::read(file).expect("it is there"));
        assert!(found == wanted, "step {step}");
    }
    // Steps are numbered over all runs.
    run(&[&["--steps", "3", "--resume", path(&state)], &every[..]].concat());
    for step in [9, 10] {
        assert!(folder.file(name(step)).exists(), "{step}");
    }
    assert!(!folder.file(name(8)).exists());
    refused(
        2,
        &[&scene[..], &["--every", "0", "--out", "x.npz"]].concat(),
    );
}

/// Errors are printed, no half-written file is left, files from before stay, and files that fit are written.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_what_is_whole() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    folder.with("x.npz", "old");
    let mut arguments = [&["export"], &TINY[..], &["--steps", "2"]].concat();
    let files = ENDINGS.map(|ending| folder.file(format!("x.{ending}")));
    files
        .iter()
        .for_each(|file| arguments.extend(["--out", path(file)]));
    let output = program::with_files_up_to(64, &arguments);
    let messages = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{messages}");
    let says = format!("myxo: cannot write {}: ", path(&folder.file("x.npz")));
    assert_eq!(messages.matches(&says).count(), 1, "{messages}");
    assert!(messages.contains("`ulimit -f`"), "{messages}");
    assert!(!messages.contains("ZipWriter"), "{messages}");
    assert_eq!(folder.names(), ["x.glb", "x.npz", "x.ply", "x.toml"]);
    let old = std::fs::read(folder.file("x.npz")).expect("it is there");
    assert_eq!(old, b"old");
    // In a series each error is printed, and the other files are written.
    let out = [folder.file("y.npz"), folder.file("y.toml")];
    let mut arguments = [&["export"], &TINY[..], &["--steps", "2", "--every", "1"]].concat();
    out.iter()
        .for_each(|file| arguments.extend(["--out", path(file)]));
    let output = program::with_files_up_to(64, &arguments);
    let messages = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{messages}");
    for step in [1, 2] {
        let lacks = format!(
            "cannot write {}",
            path(&folder.file(format!("y_{step:06}.npz")))
        );
        assert_eq!(messages.matches(&lacks).count(), 1, "{messages}");
        assert!(folder.file(format!("y_{step:06}.toml")).exists());
    }
    assert!(
        !folder
            .names()
            .iter()
            .any(|name| name.starts_with("y_") && name.ends_with("npz"))
    );
}

#[test]
fn pictures_without_a_background_have_alpha() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let (clear, opaque) = (folder.file("clear.png"), folder.file("opaque.png"));
    let plain = "--set=picture.bloom=0";
    done(&short_render("cube", &clear, &["--transparent", plain]));
    done(&short_render("cube", &opaque, &[plain]));
    let [clear, opaque] = [clear, opaque].map(|file| image::open(file).expect("a picture"));
    assert!(clear.color().has_alpha() && !opaque.color().has_alpha());
    let [clear, opaque] = [clear, opaque].map(|picture| picture.to_rgba8());
    assert_eq!(clear.get_pixel(0, 0).0, [0; 4], "nothing is there");
    let (mut inside, mut rim) = (0, 0);
    for (clear, opaque) in clear.pixels().zip(opaque.pixels()) {
        match clear.0[3] {
            255 => {
                inside += 1;
                assert_eq!(clear, opaque, "the object is as it was");
            }
            0 => {}
            // Divided by alpha: the colour of the object and not of half of it.
            _ => {
                rim += 1;
                assert!(
                    clear.0[..3].iter().any(|&channel| channel > 20),
                    "{clear:?}"
                );
            }
        }
    }
    assert!(
        inside > 300 && rim > 20,
        "{inside} pixels, and {rim} along the rim"
    );

    for name in ["x.gif", "x.mp4"] {
        let film = folder.file(name);
        let message = failed(&short_render("cube", &film, &["--transparent"]));
        assert!(message.contains("cannot be transparent"), "{message}");
    }
    // The report equals that of a run without transparency.
    let json = folder.file("x.json");
    let out = folder.file("%d.png");
    done(&short_render(
        "cube",
        &out,
        &["--transparent", "--report", path(&json)],
    ));
    assert_eq!(report(&json)["steps"], 2);
    assert!(folder.names().contains(&"0.png".to_owned()));
}

#[test]
fn reports_have_the_remaining_food() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let report_of = |more: &[&str]| {
        let (out, file) = (folder.file("x.png"), folder.file("x.json"));
        let run = ["--steps", "40", "--size", "64x48", "--out", path(&out)];
        let output = ["--report", path(&file)];
        done(&[&["render"], &TINY[..], &run, &output, more].concat());
        report(&file)
    };
    assert!(report_of(&[]).get("foods").is_none(), "there is none");
    let set = [
        "--set",
        "feeding.scattered=2",
        "--set",
        "feeding.amount=300",
    ];
    let foods = report_of(&set)["foods"]
        .as_array()
        .cloned()
        .unwrap_or_default();
    assert_eq!(foods.len(), 2, "{foods:?}");
    let mut left = 0;
    for food in &foods {
        assert_eq!(food["object"], "cube", "{food}");
        assert_eq!(
            (&food["amount"], &food["strength"]),
            (&300.into(), &20.0.into())
        );
        left += food["remaining"].as_u64().expect("there is an end of it");
        let place: Vec<f64> = (food["position"].as_array().into_iter().flatten())
            .filter_map(serde_json::Value::as_f64)
            .collect();
        let far = place.iter().fold(0.0_f64, |far, x| far.max(x.abs()));
        assert!(place.len() == 3 && far > 0.1, "{food}");
        let (radius, size) = (food["radius"].as_f64(), food["size"].as_f64());
        assert!(radius > size && size > Some(0.0), "{food}");
    }
    assert!(left < 600, "particles have eaten: {foods:?}");
    let endless = ["--set", "feeding.scattered=1"];
    let foods = report_of(&endless)["foods"].clone();
    assert!(
        foods[0]["remaining"].is_null() && foods[0]["amount"] == 0,
        "{foods}"
    );
}
