//! Outputs to existing files: links, devices, pipes, permissions, and files that the run reads.

use std::fs::{self, Permissions};
use std::io::Read as _;
use std::os::unix::fs::{FileTypeExt as _, MetadataExt as _, PermissionsExt as _, symlink};
use std::path::Path;
use std::process::Command;

use crate::program::{Folder, done, failed, no_device, path, short_render};

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

fn pipe(at: &Path) {
    let made = Command::new("mkfifo").arg(at).status();
    assert!(made.expect("it is installed").success());
}

/// Would catch: a device that is replaced by a file, which as root destroys `/dev/null` for every program.
#[test]
fn devices_are_written_to_and_never_replaced() {
    let folder = Folder::new();
    let null = folder.file("null.state");
    symlink("/dev/null", &null).unwrap();
    let [out, state] = [folder.file("a.png"), folder.file("b.state")];
    symlink("/dev/null", &state).unwrap();
    for device in ["/dev/null", path(&null), path(&state)] {
        done(&short_render(
            "cube",
            &out,
            &["--checkpoint", device, "--report", device],
        ));
    }
    assert!(
        fs::metadata("/dev/null")
            .unwrap()
            .file_type()
            .is_char_device()
    );
    assert!(null.is_symlink());
    let full = failed(&short_render("cube", &out, &["--checkpoint", "/dev/full"]));
    assert!(
        full.contains("/dev/full") && full.contains("No space left"),
        "{full}"
    );
}

/// Would catch: a pipe that is replaced by a file, a reader that gets nothing, and a run that waits forever for a reader.
#[test]
fn pipes_get_the_whole_output() {
    let folder = Folder::new();
    let [out, to] = [folder.file("a.png"), folder.file("pipe")];
    pipe(&to);
    let message = failed(&short_render("cube", &out, &["--report", path(&to)]));
    assert!(
        message.contains("a pipe that no program reads"),
        "{message}"
    );
    let reader = {
        let to = to.clone();
        std::thread::spawn(move || {
            let mut content = Vec::new();
            fs::File::open(to)
                .unwrap()
                .read_to_end(&mut content)
                .unwrap();
            content
        })
    };
    // Until the reader has opened the pipe, there is none.
    let run = short_render("cube", &out, &["--checkpoint", path(&to)]);
    let mut tries = 0;
    while !crate::program::myxo(&run).status.success() {
        tries += 1;
        assert!(tries < 50, "the reader does not come");
    }
    let content = reader.join().unwrap();
    assert!(content.starts_with(b"MYXOCKPT") && content.len() > 10_000);
    assert!(fs::metadata(&to).unwrap().file_type().is_fifo());
}

/// Would catch: a link that becomes a file, and a private report that other users can read.
#[test]
fn links_stay_and_permissions_are_kept() {
    let folder = Folder::new();
    let other = Folder::new();
    let target = other.with("kept.json", "old");
    fs::set_permissions(&target, Permissions::from_mode(0o600)).unwrap();
    let link = folder.file("report.json");
    symlink(&target, &link).unwrap();
    let dangling = folder.file("state");
    symlink("later.state", &dangling).unwrap();
    let out = folder.file("a.png");
    done(&short_render(
        "cube",
        &out,
        &["--report", path(&link), "--checkpoint", path(&dangling)],
    ));
    assert!(link.is_symlink() && dangling.is_symlink());
    assert!(fs::read_to_string(&target).unwrap().starts_with('{'));
    assert_eq!(fs::metadata(&target).unwrap().mode() & 0o777, 0o600);
    assert!(folder.file("later.state").is_file());

    fs::set_permissions(&target, Permissions::from_mode(0o444)).unwrap();
    let message = failed(&short_render("cube", &out, &["--report", path(&link)]));
    assert!(message.contains("read-only"), "{message}");
}

/// Would catch: two outputs of which the second replaces the first, named by a link, by `..`, or through a linked folder.
#[test]
fn outputs_that_are_one_file_are_refused() {
    let folder = Folder::new();
    let real = folder.with("a.png", "");
    let link = folder.file("b.png");
    symlink(&real, &link).unwrap();
    fs::create_dir(folder.file("below")).unwrap();
    symlink(folder.path(), folder.file("same")).unwrap();
    let round = folder.file("below/../a.png");
    let [new, again] = [folder.file("new.json"), folder.file("same/new.json")];
    // A link to a file that is not there yet.
    let dangling = folder.file("d.json");
    symlink("new.json", &dangling).unwrap();
    for [one, other] in [
        [&real, &link],
        [&real, &round],
        [&new, &again],
        [&new, &dangling],
    ] {
        let out = folder.file("c.png");
        let message = failed(&short_render(
            "cube",
            &out,
            &["--report", path(one), "--checkpoint", path(other)],
        ));
        assert!(message.contains("are one file"), "{message}");
    }
}

/// Would catch: a model, a scene or a checkpoint that is lost because an output had its name.
#[test]
fn what_a_run_reads_is_not_replaced_unless_that_is_allowed() {
    let folder = Folder::new();
    let model = folder.with("a.obj", OBJ);
    let scene = folder.with("a.toml", "[[object]]\nmesh = \"a.obj\"\n");
    let link = folder.file("link.json");
    symlink("a.obj", &link).unwrap();
    let [out, state] = [folder.file("a.png"), folder.file("a.state")];
    done(&short_render(
        path(&scene),
        &out,
        &["--checkpoint", path(&state)],
    ));
    let before = fs::read(&state).unwrap();
    for options in [
        &["--report", path(&scene)][..],
        &["--report", path(&model)],
        &["--report", path(&link)],
        &["--resume", path(&state), "--checkpoint", path(&state)],
    ] {
        let message = failed(&short_render(path(&scene), &out, options));
        assert!(message.contains("is an input of this run"), "{message}");
        assert!(message.contains("--overwrite-input"), "{message}");
    }
    assert_eq!(fs::read_to_string(&model).unwrap(), OBJ);
    assert_eq!(fs::read(&state).unwrap(), before);
    let resume = [
        "--resume",
        path(&state),
        "--checkpoint",
        path(&state),
        "--overwrite-input",
    ];
    done(&short_render(path(&scene), &out, &resume));
    assert_ne!(fs::read(&state).unwrap(), before);

    let walks = folder.with(
        "walks.csv",
        "id,face,b0,b1,b2,dx,dy,dz,length\n0,0,0.4,0.3,0.3,1,0,0,0.1\n",
    );
    let query = [
        "query",
        "geodesic",
        "--mesh",
        path(&model),
        "--in",
        path(&walks),
        "--out",
        path(&walks),
    ];
    let message = failed(&query);
    assert!(message.contains("is an input of this run"), "{message}");
}

/// Would catch: an input that is lost because a frame, a file of a series, or the map beside a scene file had its name.
#[test]
fn numbered_files_and_maps_replace_nothing_that_a_run_reads() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let text =
        "[particles]\ncount = 500\n[atlas]\nsize = 64\n[[object]]\nmesh = \"builtin:cube\"\n";
    let scene = folder.with("o_000002.toml", text);
    let mask = folder.file("mk_00001.png");
    let white = image::GrayImage::from_pixel(4, 4, image::Luma([255]));
    white.save(&mask).unwrap();
    let map = folder.file("own_areas.png");
    let green = image::RgbImage::from_pixel(4, 4, image::Rgb([0, 255, 0]));
    green.save(&map).unwrap();
    // What is exported to it has its areas in the map that it names.
    let own = folder.with("own.toml", "# map = \"own_areas.png\"\n");
    let contents = || {
        let names = folder.names().into_iter();
        let all = names.map(|name| (fs::read(folder.file(&name)).unwrap(), name));
        all.collect::<Vec<_>>()
    };
    let before = contents();

    let (series, frames) = (folder.file("o.toml"), folder.file("mk_%05d.png"));
    let series = ["--steps", "3", "--every", "2", "--out", path(&series)];
    let series = [&["export", path(&scene)], &series[..]].concat();
    let masked = format!("particles.start_mask={}", path(&mask));
    let masked = ["--set", "particles.start=mask", "--set", masked.as_str()];
    let frames = ["--size", "16x12", "--out", path(&frames)];
    let few = ["--steps", "2", "--every", "1"];
    let filmed = [&["render", path(&scene)], &few[..], &masked, &frames].concat();
    let painted = format!("areas.map={}", path(&map));
    let painted = [
        "--set",
        painted.as_str(),
        "--steps",
        "1",
        "--out",
        path(&own),
    ];
    let painted = [&["export", path(&scene)], &painted[..]].concat();
    for (run, input) in [(&series, &scene), (&filmed, &mask), (&painted, &map)] {
        let message = failed(run);
        let says = format!("{} is an input of this run", path(input));
        assert!(message.contains(&says), "{message}");
        assert!(message.contains("--overwrite-input"), "{message}");
        assert!(contents() == before, "{says}");
    }
    done(&[&series[..], &["--overwrite-input"]].concat());
    let after = fs::read_to_string(&scene).unwrap();
    assert!(after.starts_with("# o_000002, as it was at step 2."));
}

/// Would catch: a checkpoint that cannot be resumed, without a warning, because a scene file cannot name the folder of its models.
#[cfg(target_os = "linux")]
#[test]
fn checkpoints_in_folders_that_are_not_unicode_can_be_resumed() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt as _;
    let folder = Folder::new();
    let odd = folder.path().join(OsStr::from_bytes(b"\xff\xfe"));
    fs::create_dir(&odd).unwrap();
    fs::write(odd.join("a.obj"), OBJ).unwrap();
    fs::write(odd.join("a.toml"), "[[object]]\nmesh = \"a.obj\"\n").unwrap();
    let tiny = [
        "--steps",
        "1",
        "--size",
        "16x16",
        "--set",
        "particles.count=100",
        "--set",
        "atlas.size=64",
    ];
    let run = |arguments: &[&OsStr]| {
        let all = [OsStr::new("render")]
            .into_iter()
            .chain(arguments.iter().copied());
        let all: Vec<&OsStr> = all.chain(tiny.iter().map(OsStr::new)).collect();
        let output = crate::program::myxo(&all);
        (
            output.status.success(),
            String::from_utf8_lossy(&output.stderr).into_owned(),
        )
    };
    let (scene, state, out) = (odd.join("a.toml"), odd.join("a.state"), odd.join("a.png"));
    let [out_is, state_is] = ["--out", "--checkpoint"].map(OsStr::new);
    let (is_done, said) = run(&[
        scene.as_os_str(),
        out_is,
        out.as_os_str(),
        state_is,
        state.as_os_str(),
    ]);
    assert!(
        is_done && said.contains("a folder whose name is not Unicode"),
        "{said}"
    );
    let (is_done, said) = run(&[
        OsStr::new("--resume"),
        state.as_os_str(),
        out_is,
        out.as_os_str(),
    ]);
    assert!(is_done && said.contains("step 2"), "{said}");
}
