//! `myxo atlas`: what it writes and prints, and its errors.

use crate::program::{Folder, done, failed, myxo, path, program, refused, text};
use serde_json::Value;

/// What the program prints as JSON.
#[track_caller]
fn json(arguments: &[&str]) -> Value {
    let output = myxo(arguments);
    let messages = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{messages}");
    assert_eq!(messages, "");
    serde_json::from_slice(&output.stdout).expect("it is JSON")
}

fn count(numbers: &Value, key: &str) -> usize {
    numbers[key].as_u64().expect("it is a count") as usize
}

const CUBE: [&str; 6] = ["atlas", "cube", "--method", "grid", "--size", "61"];

#[test]
fn the_picture_and_the_numbers_are_of_one_layout() {
    let folder = Folder::new();
    let picture = folder.file("atlas.png");
    let numbers = json(&[&CUBE[..], &["--json", "--out", path(&picture)]].concat());
    assert_eq!(numbers["scene"], "cube");
    assert_eq!(numbers["method"], "grid");
    let counts = ["size", "gutter", "triangles", "charts", "unowned_triangles"];
    assert_eq!(counts.map(|key| count(&numbers, key)), [61, 1, 12, 6, 0]);
    let [owned, gutter, empty] =
        ["owned_texels", "gutter_texels", "empty_texels"].map(|key| count(&numbers, key));
    assert_eq!(owned + gutter + empty, 61 * 61);
    let utilisation = numbers["utilisation"].as_f64().expect("it is a number");
    assert!((0.3..0.8).contains(&utilisation), "{numbers}");

    let picture = image::open(picture).expect("it is a picture").into_rgb8();
    assert_eq!(picture.dimensions(), (61, 61));
    let mut colors: Vec<_> = picture.pixels().map(|pixel| pixel.0).collect();
    colors.sort_unstable();
    let mut kinds: Vec<(usize, [u8; 3])> = colors
        .chunk_by(|a, b| a == b)
        .map(|same| (same.len(), same[0]))
        .collect();
    kinds.sort_unstable();
    // The background, and the insides of six charts.
    let large: Vec<usize> = kinds.iter().rev().take(7).map(|kind| kind.0).collect();
    assert_eq!(large[0], empty);
    assert!(large[6] > 100 && large[6] + 40 > large[1], "{large:?}");
}

#[test]
fn no_device_is_needed() {
    let output = program()
        .args(CUBE)
        .env("VK_DRIVER_FILES", "/nonexistent")
        .output()
        .expect("the program starts");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let table = text(&output.stdout);
    for part in [
        "cube: 12 triangles of one object\n",
        "  method             grid\n",
        "  size               61 x 61 texels, gutter 1\n",
        "  charts             6\n",
        "  utilisation        ",
        "  stretch            1.000  1.000  1.000   ",
        "  seconds            0.",
    ] {
        assert!(table.contains(part), "{part}\nis not in\n{table}");
    }
}

#[test]
fn texels_can_be_large() {
    let folder = Folder::new();
    let picture = folder.file("deep/atlas.PNG");
    done(&[&CUBE[..], &["--scale", "5", "--out", path(&picture)]].concat());
    let format = image::ImageFormat::Png;
    let file = std::fs::File::open(picture).expect("it is there");
    let picture = image::load(std::io::BufReader::new(file), format).expect("it is a PNG");
    assert_eq!((picture.width(), picture.height()), (305, 305));
}

#[test]
fn the_picture_may_go_to_the_standard_output() {
    let output = myxo(&[&CUBE[..], &["--out", "-"]].concat());
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stdout.starts_with(b"\x89PNG"));
    assert!(text(&output.stderr).starts_with("cube: 12 triangles"));
}

#[test]
fn several_scenes_make_a_table() {
    let options = ["--method", "grid", "--size", "800"];
    let scenes = ["atlas", "cube", "sphere", "builtin:plane"];
    let output = myxo(&[&scenes[..], &options].concat());
    let table = text(&output.stdout);
    let rows: Vec<&str> = table.lines().filter(|line| line.starts_with('|')).collect();
    assert_eq!(rows.len(), 5, "{table}");
    for (row, name) in rows[2..].iter().zip(["cube", "sphere", "plane"]) {
        assert!(row.starts_with(&format!("| {name} ")), "{table}");
    }
    let list = json(&[&scenes[..], &options, &["--json"]].concat());
    assert_eq!(list[2]["scene"], "plane");
    assert_eq!(list.as_array().map(Vec::len), Some(3));
}

/// Would catch: edges that a scene glues, or a built-in mesh, and the numbers leave out.
#[test]
fn glued_edges_are_counted() {
    let folder = Folder::new();
    let object = "[[object]]\nmesh = \"builtin:plane?columns=2&rows=1\"\n";
    let plain = folder.with("plain.toml", object);
    let band = folder.with("band.toml", format!("{object}glue = [[0, 0, 3, 1]]\n"));
    let periodic = "builtin:plane?columns=2&rows=2&periodic=true";
    for (scene, pairs) in [(path(&plain), 0), (path(&band), 1), (periodic, 4)] {
        let options = ["atlas", scene, "--size", "64"];
        let numbers = json(&[&options[..], &["--json"]].concat());
        assert_eq!(count(&numbers, "glued_pairs"), pairs, "{scene}");
        let table = text(&myxo(&options).stdout);
        assert_eq!(table.contains(" of edges glued\n"), pairs > 0, "{table}");
    }
}

#[test]
fn settings_of_the_scene_count() {
    let set = [
        "--set",
        "atlas.size=70",
        "--set",
        "trail.diffusion_distance=2",
    ];
    let numbers = json(&[&["atlas", "cube", "--json", "--method", "grid"], &set[..]].concat());
    assert_eq!(["size", "gutter"].map(|key| count(&numbers, key)), [70, 2]);
    // Options come before the scene's own values.
    let options = ["--size", "80", "--gutter", "3"];
    let arguments = ["atlas", "cube", "--json", "--method", "grid"];
    let numbers = json(&[&arguments, &set[..], &options].concat());
    assert_eq!(["size", "gutter"].map(|key| count(&numbers, key)), [80, 3]);

    let folder = Folder::new();
    let scene = folder.with(
        "two.toml",
        "[atlas]\nmethod = \"grid\"\n[[object]]\nmesh = \"builtin:cube\"\n[[object]]\nmesh = \"builtin:plane\"\n",
    );
    let numbers = json(&["atlas", path(&scene), "--json"]);
    assert_eq!(count(&numbers, "objects"), 2);
}

/// Would catch: advice that names a key of scenes where an option counts.
#[test]
fn errors_say_what_is_allowed() {
    let folder = Folder::new();
    let picture = folder.file("x.png");
    let jpeg = folder.file("x.jpg");
    let broken = folder.with("broken.obj", "v 0 0 0\nf 1 2 3\n");
    let model = folder.with("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let out = path(&picture);
    for (arguments, says) in [
        (vec!["tours"], "did you mean `torus`"),
        (vec!["nothing.obj"], "nothing.obj"),
        (vec![path(&broken)], "broken.obj"),
        (vec!["builtin:teapot"], "the names are cube, torus"),
        (
            vec!["cube", "torus", "--out", out],
            "--out writes the picture of one scene, and there are 2",
        ),
        (vec!["cube", "--out", path(&jpeg)], "ends in .png"),
        (
            vec!["cube", "--out", "/proc/x.png"],
            "cannot write /proc/x.png",
        ),
        (
            vec!["cube", "--size", "1024", "--scale", "17", "--out", out],
            "use --scale 16 at most",
        ),
        (
            vec!["cube", "--size", "20000", "--out", out],
            "omit --out, or use a smaller --size",
        ),
        (
            vec!["suzanne", "--method", "grid", "--size", "64"],
            "raise --size to 356 or more",
        ),
        (
            vec!["suzanne", "--method", "grid", "--set", "atlas.size=64"],
            "raise atlas.size to 356 or more",
        ),
        (
            vec!["cube", "--set", "object.0.texel_weight=0"],
            "texel_weight = 0 is out of range: 0.01 to 100",
        ),
        (
            vec![path(&model), "--method", "grid", "--size", "1"],
            "raise --size to",
        ),
        (
            vec![path(&model), "--method", "mesh"],
            "choose --method charts or grid",
        ),
    ] {
        let message = failed(&[vec!["atlas"], arguments].concat());
        assert!(message.contains(says), "{says}\nis not in\n{message}");
    }
    assert_eq!(folder.names(), ["broken.obj", "one.obj"]);
    for (arguments, says) in [
        (vec!["atlas"], "<SCENE>"),
        (vec!["atlas", "cube", "--size", "0"], "1..=32768"),
        (vec!["atlas", "cube", "--size", "40000"], "1..=32768"),
        (
            vec!["atlas", "cube", "--method", "chart"],
            "charts, grid, mesh",
        ),
        (vec!["atlas", "cube", "--scale", "0"], "1..=64"),
        (vec!["atlas", "cube", "--gutter", "0"], "1..=64"),
        (vec!["query", "atlas"], "--mesh <FILE>"),
        (
            vec![
                "query",
                "atlas",
                "--mesh",
                "builtin:cube",
                "--atlas-size",
                "0",
            ],
            "1..=32768",
        ),
        (
            vec![
                "query",
                "atlas",
                "--mesh",
                "builtin:cube",
                "--atlas-method",
                "x",
            ],
            "charts, grid, mesh",
        ),
    ] {
        let message = refused(2, &arguments);
        assert!(message.contains(says), "{says}\nis not in\n{message}");
    }
    let query = ["query", "atlas", "--atlas-method", "grid", "--mesh"];
    for (mesh, says) in [
        ("nothing.obj", "nothing.obj"),
        (path(&broken), "broken.obj"),
        ("builtin:teapot", "the names are cube, torus"),
        ("builtin:icosphere", "raise --atlas-size to"),
    ] {
        let out = folder.file("x.csv");
        let options = ["--atlas-size", "16", "--out", path(&out)];
        let arguments = [&query[..], &[mesh], &options].concat();
        let message = failed(&arguments);
        assert!(message.contains(says), "{says}\nis not in\n{message}");
        assert!(!out.exists());
    }
}

#[test]
fn faces_without_a_place_are_counted() {
    let folder = Folder::new();
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 1 2\nf 1 2 3\n";
    let model = folder.with("two.obj", text);
    let out = folder.file("out.csv");
    let arguments = [
        "query",
        "atlas",
        "--atlas-method",
        "grid",
        "--atlas-size",
        "16",
    ];
    let files = ["--mesh", path(&model), "--out", path(&out)];
    let message = done(&[&arguments[..], &files].concat());
    assert_eq!(
        message,
        "two: 1 faces without area, or there twice, have no place, and no row\n"
    );
    let rows = std::fs::read_to_string(out).expect("it is written");
    assert!(
        rows.starts_with("# 16 16\nface,chart,u0,v0,u1,v1,u2,v2\n1,0,"),
        "{rows}"
    );
    assert_eq!(rows.lines().count(), 3);
}

/// Lays suzanne out in charts, with a cache folder of the test's own: the numbers, and the bytes of the picture.
fn charts(cache: &Folder, options: &[&str]) -> (Value, Vec<u8>) {
    let folder = Folder::new();
    let picture = folder.file("atlas.png");
    let output = program()
        .args(["atlas", "suzanne", "--method", "charts", "--size", "256"])
        .args(["--json", "--out", path(&picture)])
        .args(options)
        .env("XDG_CACHE_HOME", cache.file("."))
        .output()
        .expect("the program starts");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let numbers = serde_json::from_slice(&output.stdout).expect("it is JSON");
    (numbers, std::fs::read(picture).expect("it is written"))
}

/// The only layout that is kept in a cache folder.
fn kept(cache: &Folder) -> std::path::PathBuf {
    let folder = cache.file("myxo/atlases");
    let mut files = std::fs::read_dir(folder).expect("layouts are kept");
    let file = files.next().expect("there is one").expect("it is listed");
    assert!(files.next().is_none(), "and no other");
    file.path()
}

fn was_cut((numbers, _): &(Value, Vec<u8>)) -> bool {
    let phases = numbers["phases"].as_object().expect("it is a table");
    phases.contains_key("cutting into charts")
}

#[test]
fn a_layout_is_kept_and_read_again() {
    let cache = Folder::new();
    let first = charts(&cache, &[]);
    assert!(was_cut(&first), "{}", first.0);
    let file = kept(&cache);
    let content = std::fs::read(&file).expect("it can be read");
    let second = charts(&cache, &[]);
    assert!(!was_cut(&second), "{}", second.0);
    assert!(first.1 == second.1, "the same picture");
    assert_eq!(first.0["utilisation"], second.0["utilisation"]);
    // Once more without the cache: the result does not depend on it.
    let fresh = charts(&cache, &["--fresh"]);
    assert!(was_cut(&fresh) && first.1 == fresh.1);

    for damage in [&content[..content.len() / 2], b"", b"MYXOAT01 and nonsense"] {
        std::fs::write(&file, damage).expect("it can be written");
        let rebuilt = charts(&cache, &[]);
        assert!(was_cut(&rebuilt) && first.1 == rebuilt.1);
        assert!(std::fs::read(&file).expect("it is there") == content);
    }
    // A layout of another mesh under this name.
    let other = charts(&cache, &["--gutter", "2"]);
    assert!(was_cut(&other) && first.1 != other.1);
}

#[test]
fn two_processes_may_keep_the_same_layout() {
    let cache = Folder::new();
    let pictures: Vec<Vec<u8>> = std::thread::scope(|scope| {
        let runs: Vec<_> = (0..3)
            .map(|_| scope.spawn(|| charts(&cache, &[]).1))
            .collect();
        let join = |run: std::thread::ScopedJoinHandle<'_, _>| run.join().expect("it runs");
        runs.into_iter().map(join).collect()
    });
    assert!(pictures.windows(2).all(|pair| pair[0] == pair[1]));
    assert!(!was_cut(&charts(&cache, &[])));
    kept(&cache);
}

#[test]
fn without_a_cache_folder_layouts_are_made_all_the_same() {
    let cache = Folder::new();
    cache.with("myxo", "a file where the folder would be");
    assert!(was_cut(&charts(&cache, &[])));
    assert!(was_cut(&charts(&cache, &[])));
}

#[test]
fn charts_do_not_depend_on_the_number_of_threads() {
    let cache = Folder::new();
    let run = |threads: &str| {
        let picture = cache.file(format!("{threads}.png"));
        let output = program()
            .args(["atlas", "suzanne", "--method", "charts", "--size", "256"])
            .args(["--fresh", "--out", path(&picture)])
            .env("RAYON_NUM_THREADS", threads)
            .output()
            .expect("the program starts");
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        std::fs::read(picture).expect("it is written")
    };
    assert!(run("1") == run("2") && run("2") == run("5"));
}

/// A mesh that takes long enough to be interrupted.
const LARGE: &str = "builtin:torus?major=1000&minor=500";

#[cfg(unix)]
#[test]
fn ctrl_c_stops_it() {
    use crate::program::{interrupted, logging_its_parts};
    use std::time::Duration;
    let folder = Folder::new();
    let picture = folder.file("atlas.png");
    let commands = [
        vec!["atlas", LARGE, "--fresh", "--method", "charts"],
        vec![
            "query",
            "atlas",
            "--atlas-method",
            "charts",
            "--mesh",
            LARGE,
        ],
    ];
    for command in commands {
        let mut run = program();
        run.args(&command).args(["--out", path(&picture)]);
        let run = logging_its_parts(&mut run)
            .env("XDG_CACHE_HOME", folder.file("cache"))
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .expect("the program starts");
        let output = interrupted(run, "cutting into charts", Duration::from_secs(20));
        let message = text(&output.stderr);
        assert!(
            message.ends_with("myxo: interrupted while setting up\n"),
            "{message}"
        );
        assert!(
            output.stdout.is_empty() && folder.names().is_empty(),
            "nothing is left"
        );
    }
}

#[test]
fn help_says_that_0_turns_nothing() {
    for command in [&["atlas"][..], &["query", "atlas"], &["query", "diffuse"]] {
        let help = text(&myxo(&[command, &["--help"]].concat()).stdout);
        assert!(help.contains("0 turns none"), "{help}");
    }
}
