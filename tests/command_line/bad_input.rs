//! Bad input and bad environments: each gives one clear message that says what to do, a non-zero exit code, and no half-written file under
//! a final name.

use std::path::Path;

use crate::program::{
    self, Folder, done, failed, failure, myxo, no_device, path, program, refusal, refused,
    short_render as render, text,
};

#[test]
fn without_a_driver_the_package_is_named() {
    let folder = Folder::new();
    let table = folder.with(
        "in.csv",
        "id,face,b0,b1,b2,dx,dy,dz,length\n1,0,1,0,0,1,0,0,1\n",
    );
    let (picture, film) = (folder.file("x.png"), folder.file("x.gif"));
    let report = folder.file("x.json");
    let query = [
        "query",
        "geodesic",
        "--mesh",
        "builtin:cube",
        "--in",
        path(&table),
    ];
    let commands = [
        render(
            "cube",
            &picture,
            &["--out", path(&film), "--report", path(&report)],
        ),
        vec!["profile", "cube", "--trace", path(&report)],
        query.to_vec(),
    ];
    for command in commands {
        for name in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
            let output = program()
                .args(&command)
                .env_remove("VK_DRIVER_FILES")
                .env(name, "/nonexistent")
                .output()
                .expect("the program starts");
            let message = failure(&output);
            let says =
                format!("myxo: no Vulkan: {name} is /nonexistent, and no driver is found there; ");
            assert!(message.starts_with(&says), "{message}");
            assert!(
                message.contains("apt install libvulkan1 mesa-vulkan-drivers"),
                "{message}"
            );
        }
    }
    assert_eq!(folder.names(), ["in.csv"]);
}

/// The error names a driver manifest that is cut short, whether it comes from a variable or from one of the loader's folders, where it
/// hides all other drivers, too. The loader's own error is "a host memory allocation has failed", if it fails at all.
#[test]
#[cfg(target_os = "linux")]
fn a_manifest_of_a_driver_that_is_cut_short_is_named() {
    let folder = Folder::new();
    std::fs::create_dir_all(folder.file("vulkan/icd.d")).expect("it can be made");
    let cut = folder.with(
        "vulkan/icd.d/cut.json",
        "{ \"ICD\": { \"api_version\": \"1.1.2",
    );
    let chosen: (&str, &Path) = ("VK_DRIVER_FILES", &cut);
    for (name, value) in [chosen, ("XDG_DATA_HOME", folder.path())] {
        let output = program()
            .args([
                "render",
                "cube",
                "--steps",
                "1",
                "--out",
                path(&folder.file("cube.png")),
            ])
            .env_remove("VK_DRIVER_FILES")
            .env_remove("VK_ICD_FILENAMES")
            .env(name, value)
            .output()
            .expect("the program starts");
        // Some loaders skip a driver that makes others fail.
        if name == "XDG_DATA_HOME" && output.status.success() {
            continue;
        }
        let message = failure(&output);
        let says = format!(
            "myxo: no Vulkan: the manifest {} is damaged or cut short: ",
            cut.display()
        );
        assert!(message.starts_with(&says), "{message}");
    }
}

/// If the device is the processor, its memory is the machine's, and setting up takes as much again.
#[cfg(target_os = "linux")]
#[test]
fn scenes_larger_than_the_memory_are_refused_before_it_is_taken() {
    if no_device() || !text(&myxo(&["info"]).stdout).contains("llvmpipe") {
        return;
    }
    // 12 GiB for the device, and as much again.
    let large = [
        "--set",
        "particles.count=134_000_000",
        "--set",
        "atlas.size=16384",
        "--set",
        "feeding.scattered=1",
    ];
    let memory = std::fs::read_to_string("/proc/meminfo").expect("it is Linux");
    let kibibytes = |key: &str| -> u64 {
        let line = memory.lines().find(|line| line.starts_with(key));
        let number = line.and_then(|line| line.split_whitespace().nth(1));
        number.and_then(|number| number.parse().ok()).unwrap_or(0)
    };
    if (kibibytes("MemAvailable:") + kibibytes("SwapFree:")) >> 20 >= 25 {
        return;
    }
    let folder = Folder::new();
    let picture = folder.file("x.png");
    for command in [
        render("torus", &picture, &large),
        [&["profile", "torus", "--steps", "1"], &large[..]].concat(),
    ] {
        let message = failed(&command);
        for part in [
            "torus needs 12",
            "about 25",
            " are free",
            "lower particles.count (it is 134,000,000) or atlas.size (it is 16,384)",
        ] {
            assert!(message.contains(part), "{part}: {message}");
        }
        assert_eq!(message.lines().count(), 1, "{message}");
    }
    assert!(folder.names().is_empty());
}

#[test]
fn unknown_devices_leave_nothing_behind() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let picture = folder.file("x.png");
    for name in ["abacus", "99", "-1"] {
        let message = failed(&render("cube", &picture, &[&format!("--device={name}")]));
        assert!(
            message.contains(&format!("no device is called {name:?}; ")),
            "{message}"
        );
        assert!(message.contains("\n  0: "), "{message}");
    }
    assert!(folder.names().is_empty());
}

#[test]
fn errors_about_files_of_other_kinds_list_the_kinds() {
    let folder = Folder::new();
    for name in ["m9.step", "notes.txt"] {
        let file = folder.with(name, "solid m9\nendsolid m9\n");
        let message = failed(&["scenes", path(&file)]);
        let kinds = "models are .obj, .stl, .ply, .glb, .gltf, scenes .toml";
        assert!(
            message.contains(name) && message.contains(kinds),
            "{message}"
        );
    }
    // A file without an extension may be a scene.
    let file = folder.with("m9", "[[object]]\nmesh = \"builtin:cube\"\n");
    program::done(&["scenes", path(&file)]);
}

#[test]
fn broken_models_are_named_with_their_problem() {
    let folder = Folder::new();
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let suzanne = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/suzanne.glb"))
        .expect("the asset is there");
    std::fs::create_dir(folder.file("folder.obj")).expect("it can be made");
    let cases: [(&str, &[u8], &str); 9] = [
        (
            "nan.obj",
            b"v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n",
            "vertex 2 (line 3) is not finite",
        ),
        ("none.obj", corners.as_bytes(), "there are no triangles"),
        ("empty.glb", b"", "cannot be read"),
        (
            "flat.obj",
            b"v 0 0 0\nv 1 0 0\nf 1 2 2\n",
            "none has an area",
        ),
        (
            "range.obj",
            b"v 0 0 0\nv 1 0 0\nf 1 2 9\n",
            "names vertex 9",
        ),
        (
            "cut.glb",
            &suzanne[..3000],
            "buffers[0] should have 179088 bytes, and has 2292",
        ),
        ("noise.glb", &suzanne[7000..9000], "cannot be read"),
        (
            "huge.obj",
            b"v 1e38 0 0\nv 0 1 0\nv -1e38 0 0\nf 1 2 3\n",
            "or scale it down",
        ),
        ("no such.obj", b"", "cannot read "),
    ];
    let picture = folder.file("x.png");
    for (name, content, expected) in cases {
        let model = match name {
            "no such.obj" => folder.file(name),
            _ => folder.with(name, content),
        };
        let message = failed(&render(path(&model), &picture, &[]));
        assert!(
            message.contains(path(&model)) && message.contains(expected),
            "{message}"
        );
    }
    let message = failed(&render(path(&folder.file("folder.obj")), &picture, &[]));
    assert!(message.contains("this is a folder"), "{message}");
    assert!(!picture.exists());
}

#[test]
fn a_texture_that_is_too_small_says_which_size_is_enough() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    for (model, method, part) in [
        ("torus", "grid", "27,648 triangles"),
        ("suzanne", "charts", "charts with a gutter of 1:"),
    ] {
        let picture = folder.file(format!("{model}.png"));
        let method = format!("atlas.method={method}");
        let sized = |size: u32| format!("atlas.size={size}");
        let rendered = |size: u32| {
            let size = sized(size);
            let command = render(model, &picture, &["--set", &method, "--set", &size]);
            command.into_iter().map(str::to_owned).collect::<Vec<_>>()
        };
        let message = failed(&rendered(16));
        assert!(message.contains(part) && !picture.exists(), "{message}");
        let (_, advice) = message
            .rsplit_once("raise atlas.size to ")
            .expect("there is advice");
        let size = advice
            .split(' ')
            .next()
            .and_then(|n| n.parse().ok())
            .expect("a size");
        done(&rendered(size));
        assert!(picture.exists());
        if model == "torus" {
            // Cells are counted, so one texel less is too small.
            failed(&rendered(size - 1));
        }
    }
}

#[test]
fn buffers_beyond_the_device_say_the_largest_that_fits() {
    if no_device() {
        return;
    }
    let info: serde_json::Value =
        serde_json::from_slice(&myxo(&["info", "--json"]).stdout).expect("it is JSON");
    let device = &info["devices"][info["chosen"].as_u64().expect("there is one") as usize];
    let limit = |key: &str| device[key].as_u64().expect("it is a number");
    let grouped = |value: u64| ::myxo::scene::parameters::grouped(value as f64);
    let (particles, atlas) = (limit("most_particles"), limit("largest_atlas"));

    let folder = Folder::new();
    let picture = folder.file("x.png");
    let mut expected = Vec::new();
    let mut set = Vec::new();
    // The device's limits may be larger than the keys' ranges.
    if particles < 1 << 30 {
        set.push(format!("particles.count={}", particles + 1));
        expected.push(format!(
            "particles.count = {} takes ",
            grouped(particles + 1)
        ));
        expected.push(format!("use at most {}", grouped(particles)));
    }
    if atlas < 32_768 {
        set.push(format!("atlas.size={}", atlas + 1));
        expected.push(format!("atlas.size = {} takes ", grouped(atlas + 1)));
        expected.push(format!("use at most {}", grouped(atlas)));
    }
    let options: Vec<&str> = set.iter().flat_map(|set| ["--set", set.as_str()]).collect();
    if options.is_empty() {
        return;
    }
    let started = std::time::Instant::now();
    let message = failed(&render("cube", &picture, &options));
    assert!(
        started.elapsed().as_secs() < 5,
        "it is known before long work"
    );
    for part in expected.iter().map(String::as_str).chain(["max"]) {
        assert!(message.contains(part), "{part} in {message}");
    }
    assert!(folder.names().is_empty());
}

#[test]
fn all_wrong_values_are_reported_at_once() {
    let message = failed(&[
        "profile",
        "cube",
        "--set",
        "particles.count=0",
        "--set",
        "particles.count=-5",
        "--set",
        "atlas.size=1",
        "--set",
        "particles.count=1e99",
        "--set",
        "trail.decay=nan",
        "--set",
        "trail.diffusion=inf",
        "--set",
        "physarum.speed=-1",
        "--set",
        "physarum.border=bounce",
        "--set",
        "seed=18446744073709551616",
        "--set",
        "particle.count=5",
        "--set",
        "=3",
        "--set",
        "camera.target=[1, 2]",
        "--set",
        "trail=3",
    ]);
    assert!(
        message.contains("cube: 13 things are wrong:\n"),
        "{message}"
    );
    assert!(
        message.contains("did you mean particles.count?"),
        "{message}"
    );
    assert!(message.contains("reflect or stop"), "{message}");
}

#[test]
fn the_smallest_scenes_run() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let smallest = [
        "--set",
        "particles.count=1",
        "--set",
        "atlas.size=16",
        "--size",
        "1x1",
    ];
    let mut arguments = vec!["render", "cube", "--steps", "3", "--out"];
    let picture = folder.file("x.png");
    arguments.push(path(&picture));
    arguments.extend(smallest);
    done(&arguments);
    let triangle = folder.with("a triangle.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    done(&render(path(&triangle), &folder.file("a picture.png"), &[]));
}

#[test]
fn options_of_the_wrong_kind_are_usage_errors() {
    for options in [
        ["--steps", "99999999999"],
        ["--steps", "many"],
        ["--size", "0x0"],
        ["--size", "99999999999x2"],
        ["--every", "0"],
        ["--fps", "0"],
        ["--seed", "1.5"],
        ["--hash-every", "0"],
        ["--measure-every", "0"],
    ] {
        let message = refused(
            2,
            &["render", "cube", "--out", "x.png", options[0], options[1]],
        );
        assert!(message.contains(options[0]), "{message}");
    }
    // Both paths name one file.
    let twice = [
        "render",
        "cube",
        "--out",
        "x.png",
        "--checkpoint",
        "./x.png",
    ];
    let message = refusal(1, &myxo(&twice));
    assert!(message.contains("are one file"), "{message}");
}
