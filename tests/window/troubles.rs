//! Trouble: no room on the disk, no ffmpeg, windows that close in the middle. Each time the lab says what happened, nothing hangs, and no
//! half-written file has its final name.

use std::fs::File;
use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Instant;

use crate::input::Gesture;
use crate::lab::PATIENCE;
use crate::out::{arrived, frames_in};
use crate::program::{Folder, path, program, shown_of};
use crate::{Lab, SMALL, can_open, said};

#[track_caller]
pub fn hear(lab: &Lab, part: &str) {
    lab.wait(part, |seen| {
        let notice = seen["state"]["notice"].as_str();
        notice.is_some_and(|text| text.contains(part))
    });
}

#[track_caller]
pub fn goes_on(lab: &Lab) {
    let before = lab.seen().expect("the lab has reported")["state"]["step"].as_u64();
    lab.wait("the simulation continues", |seen| {
        seen["state"]["step"].as_u64() > before
    });
}

/// The program with a limit on the size of files, in blocks, which acts like a full disk.
pub fn program_with_little_room(blocks: u32) -> Command {
    let mut shell = Command::new("sh");
    let script = format!("ulimit -f {blocks}; exec \"$0\" \"$@\"");
    shell.args(["-c", &script, env!("CARGO_BIN_EXE_myxo")]);
    shell.env_remove("RUST_LOG").stdin(Stdio::null());
    shell
}

#[test]
fn a_full_disk_gives_a_notice_and_the_simulation_goes_on() {
    if !can_open() {
        return;
    }
    let lab = Lab::start(program_with_little_room(64), &SMALL);
    lab.key("F12");
    hear(&lab, "ulimit -f");
    lab.click_until("out", "out", true);
    for (kind, name) in [
        ("GIF", "000001.gif"),
        ("PNG", "frame_00000.png"),
        ("MP4", "000001.mp4"),
    ] {
        lab.click(&format!("out.kind={kind}"));
        lab.key("F9");
        hear(&lab, name);
        lab.wait("the recording ends", |seen| {
            seen["state"]["recording"] == false
        });
        goes_on(&lab);
    }
    lab.click("out.export=NPZ");
    hear(&lab, "ulimit -f");
    goes_on(&lab);
    let folder = lab.folder.path().to_owned();
    let lab = lab.quit_and_keep();
    let left = frames_in(&folder);
    let left: Vec<_> = left
        .iter()
        .filter_map(|file| file.file_name()?.to_str())
        .filter(|name| name.contains("0000") || name.starts_with('.'))
        .collect();
    assert!(left.is_empty(), "{left:?}");
    drop(lab);
}

/// A disk has room for some frames, which are kept.
#[test]
fn a_recording_that_finds_the_disk_full_keeps_its_whole_frames() {
    if !can_open() {
        return;
    }
    // Files end at 768 KiB.
    let lab = Lab::start(program_with_little_room(1536), &SMALL);
    lab.click_until("out", "out", true);
    for (kind, ending) in [("GIF", "gif"), ("MP4", "mp4")] {
        lab.click(&format!("out.kind={kind}"));
        lab.key_until("F9", "it is recorded", "recording", true);
        let name = format!("recording_000001.{ending}");
        hear(&lab, &format!("everything before it is complete: {name}"));
        let notice = lab.seen().expect("the lab has reported")["state"]["notice"].to_string();
        assert!(
            notice.contains(&name) && notice.contains("frames"),
            "{notice}"
        );
        let file = arrived(&lab, &name);
        let part = notice
            .rsplit_once('(')
            .and_then(|(_, rest)| rest.split_once(' '));
        let part: Option<u64> = part.and_then(|(frames, _)| frames.parse().ok());
        // A GIF stores equal frames once.
        let (_, shown) = shown_of(&file);
        assert!(shown >= 1 && Some(shown) <= part, "{shown}: {notice}");
        assert!(ending == "gif" || Some(shown) == part, "{shown}: {notice}");
        goes_on(&lab);
    }
    lab.quit();
}

#[test]
fn without_ffmpeg_films_say_what_else_there_is() {
    if !can_open() {
        return;
    }
    let mut without = program();
    without.env("PATH", "");
    let lab = Lab::start(without, &SMALL);
    lab.key("F9");
    hear(&lab, "ffmpeg");
    assert_eq!(
        lab.seen().expect("the lab has reported")["state"]["recording"],
        false
    );
    goes_on(&lab);
    lab.click_until("out", "out", true);
    lab.click("out.kind=GIF");
    lab.key_until("F9", "it is recorded", "recording", true);
    lab.wait("frames come", |seen| {
        seen["state"]["recorded"].as_u64() >= Some(3)
    });
    lab.key("F9");
    arrived(&lab, "recording_000001.gif");
    lab.quit();
}

#[test]
fn a_window_that_is_closed_in_the_middle_leaves_whole_files() {
    if !can_open() {
        return;
    }
    close_in_the_middle(&Lab::open(&TAKES_LONG), |lab| lab.key("ctrl+q"));
}

/// A scene whose export takes a while.
pub const TAKES_LONG: [&str; 3] = [
    "torus",
    "--set=particles.count=400000",
    "--set=atlas.size=2048",
];

/// Closes a lab in the middle of a recording and an export, both of which become whole.
#[track_caller]
pub fn close_in_the_middle(lab: &Lab, close: impl FnOnce(&Lab)) {
    // Running steps would take longer than the export that is to be interrupted.
    lab.hold();
    lab.click_until("out", "out", true);
    // The card settles its width first.
    lab.wait("it rests", |seen| seen["rests"] == true);
    lab.click("out.kind=PNG");
    lab.key_until("F9", "it is recorded", "recording", true);
    lab.wait("frames come", |seen| {
        seen["state"]["recorded"].as_u64() >= Some(3)
    });
    let export = || lab.click("out.export=NPZ");
    let seen = lab.again_until("it is made", export, |seen| {
        seen["state"]["making"].is_string()
    });
    let name = seen["state"]["making"].as_str().expect("it is a name");
    let begun = Instant::now();
    close(lab);
    let status = lab.ended();
    assert!(status.success(), "{status}");
    assert!(begun.elapsed() < PATIENCE, "it ends");
    for file in frames_in(lab.folder.path()) {
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        assert!(!name.starts_with('.'), "{name}");
    }
    let archive = File::open(lab.folder.file(name)).expect("it was finished");
    let archive = zip::ZipArchive::new(archive);
    assert!(archive.expect("it is whole").len() > 5);
    let frames = frames_in(&lab.folder.file("recording_000001"));
    assert!(frames.len() >= 3, "{frames:?}");
    for frame in &frames {
        image::open(frame).expect("it is whole");
    }
    // The terminal says what was being finished, and where the files are.
    let said = said(&lab.said);
    let saved =
        [&lab.folder.file(name), &frames[0]].map(|file| format!("saved {}", file.display()));
    for line in [&format!("finishing {name} ..."), &saved[0], &saved[1]] {
        assert!(said.contains(line), "{line}: {said}");
    }
}

/// The window shows what it still has to finish, and keeps drawing meanwhile.
#[test]
fn a_window_that_closes_says_what_it_finishes() {
    if !can_open() {
        return;
    }
    // A film may be whole before another frame is drawn.
    assert!((0..8).any(|_| shows_what_it_finishes()), "it is shown");
}

/// Closes a lab in the middle of a film, which becomes whole. Did it show what it finished?
fn shows_what_it_finishes() -> bool {
    let lab = Lab::open(&SMALL);
    lab.click_until("out", "out", true);
    lab.click("out.kind=GIF");
    lab.click("out.film_size=custom");
    lab.click("out.film");
    lab.place("out.finish");
    lab.key("ctrl+q");
    let shown = lab.seen();
    let is_shown = shown.is_some_and(|seen| seen["values"]["ending"] == "film_000001.gif");
    let status = lab.ended();
    assert!(status.success(), "{status}");
    let file = lab.folder.file("film_000001.gif");
    let (size, frames) = shown_of(&file);
    assert_eq!(size, [2048, 2048]);
    assert!(frames >= 1);
    let said = said(&lab.said);
    for part in [
        "finishing film_000001.gif ...".to_owned(),
        format!("saved {}", file.display()),
    ] {
        assert!(said.contains(&part), "{part}: {said}");
    }
    is_shown
}

/// A picture was requested just before.
#[test]
fn a_window_that_is_closed_finishes_its_picture() {
    if !can_open() {
        return;
    }
    let lab = Lab::open(&SMALL);
    lab.hold();
    lab.click_until("out", "out", true);
    lab.click("out.size=1080p");
    lab.perform(Gesture::Keys(&["F12", "ctrl+q"]));
    let status = lab.ended();
    assert!(status.success(), "{status}");
    let file = lab.folder.file("screenshot_000001.png");
    let picture = image::open(&file).expect("it is whole");
    assert_eq!((picture.width(), picture.height()), (1920, 1080));
    let said = said(&lab.said);
    let part = format!("saved {}", file.display());
    assert!(said.contains(&part), "{part}: {said}");
}

/// The terminal lists files and objects that were not loaded yet.
#[test]
fn a_window_that_is_closed_lists_what_was_not_loaded() {
    if !can_open() {
        return;
    }
    let pair = "[particles]\ncount = 3000\nstart = \"mask\"\nstart_mask = \"mask.png\"\n\
                [atlas]\nsize = 128\n[[object]]\nname = \"ball\"\n\
                mesh = \"builtin:icosphere?subdivisions=3\"\n[[object]]\nname = \"box\"\n\
                mesh = \"builtin:cube\"\nscale = 0.3\nposition = [1.5, 0.0, 0.0]\n";
    let folder = Folder::new();
    let file = folder.with("pair.toml", pair);
    let mask = folder.file("mask.png");
    let white = image::GrayImage::from_pixel(16, 16, image::Luma([255]));
    white.save(&mask).expect("it can be written");
    let lab = Lab::open(&[path(&file)]);
    lab.hold();
    lab.pick("ball");
    // Opening a file waits while another process has a lease on it, so this file is not loaded in time.
    let mut leased = leased(&mask);
    let count = "particles.count";
    lab.find(count);
    lab.type_until(count, 0.9, "4000", count, "4000");
    lab.click("restart");
    lab.place("cancel");
    lab.key("Delete");
    let mesh = lab
        .folder
        .with("tip.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    lab.drop_files(&[&mesh]);
    let seen = lab.seen().expect("the lab has reported");
    assert_eq!(seen["state"]["loading"], true, "it is still loading");
    let lab = lab.quit_and_keep();
    let said = said(&lab.said);
    for part in [
        "ball was not taken out of the scene",
        "tip.obj was not opened",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    leased.kill().expect("it waits for its input to end");
    leased.wait().expect("it was killed");
}

/// A process with a lease on a file. By default Linux lets other processes wait for it for 45 s.
fn leased(file: &Path) -> Child {
    let script = "import fcntl, signal, sys\n\
                  signal.signal(signal.SIGIO, signal.SIG_IGN)\n\
                  file = open(sys.argv[1], 'r+b')\n\
                  fcntl.fcntl(file, fcntl.F_SETLEASE, fcntl.F_WRLCK)\n\
                  print('leased', flush=True)\n\
                  sys.stdin.read()\n";
    let mut process = Command::new("python3")
        .args(["-c", script])
        .arg(file)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("python3 is installed");
    let mut part = String::new();
    let output = process.stdout.take().expect("it is piped");
    BufReader::new(output)
        .read_line(&mut part)
        .expect("it is text");
    assert_eq!(part, "leased\n");
    process
}

#[test]
fn a_window_of_any_size_goes_on_and_its_last_object_stays() {
    if !can_open() {
        return;
    }
    let lab = Lab::open(&SMALL);
    // A tiny size, zero as some systems report for hidden windows, and back.
    for (width, height) in [(1, 1), (3000, 1), (0, 0), (900, 760)] {
        let before = lab.step();
        lab.perform(Gesture::Resize(width, height));
        lab.look_at(3);
        assert!(lab.step() >= before, "it has not restarted");
    }
    // On another workspace no picture is wanted: steps go on.
    let before = lab.step();
    lab.perform(Gesture::HideFor(8));
    let after = lab.step();
    assert!(after >= before + 6, "{before}, {after}");
    goes_on(&lab);
    lab.key_until("space", "it answers", "playing", false);
    lab.key_until("space", "it continues", "playing", true);
    lab.pick("cube");
    lab.key("Delete");
    hear(&lab, "last");
    assert_eq!(lab.save("cube").objects.len(), 1);
    lab.quit();
}
