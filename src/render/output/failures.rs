//! Every way in which an output can fail: one error that helps, and no file that looks like a result.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use image::{Rgba, RgbaImage};

use super::tests::{RED, names_in, plain, read_gif, read_video};
use super::{Output, OutputError, Writer};

#[test]
fn dropped_output_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["x.png", "x.gif", "x.mp4"] {
        let path = folder.path().join(name);
        std::fs::write(&path, "old").unwrap();
        let mut output = Output::create(&path, (16, 16), 30.0).unwrap();
        output.frame(&plain((16, 16), RED)).unwrap();
        drop(output);
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "old", "{name}");
    }
    assert_eq!(names_in(folder.path()), ["x.gif", "x.mp4", "x.png"]);
}

#[test]
fn output_without_a_frame_is_no_file() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["x.png", "x_%d.png", "x.gif", "x.mp4"] {
        let output = Output::create(&folder.path().join(name), (16, 16), 30.0).unwrap();
        assert_eq!(
            output.finish().unwrap().files,
            Vec::<PathBuf>::new(),
            "{name}"
        );
    }
    assert_eq!(names_in(folder.path()), Vec::<String>::new());
}

#[test]
fn a_folder_that_stays_empty_goes_and_one_that_was_there_stays() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("old")).unwrap();
    for name in ["new/", "old/"] {
        drop(Output::create(&folder.path().join(name), (4, 4), 30.0).unwrap());
    }
    let mut output = Output::create(&folder.path().join("kept/"), (16, 16), 30.0).unwrap();
    output.frame(&plain((16, 16), RED)).unwrap();
    drop(output);
    assert_eq!(names_in(folder.path()), ["kept", "old"]);
}

#[test]
fn folder_that_cannot_be_written_is_an_error_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "").unwrap();
    for name in ["x.png", "x_%d.png", "frames/", "x.gif", "x.mp4"] {
        let error = Output::create(&file.join(name), (4, 4), 30.0).unwrap_err();
        assert!(
            matches!(error, OutputError::File { .. }),
            "{name}: {error:?}"
        );
        assert!(error.to_string().contains("file"), "{error}");
    }
    // No user may write here, root included.
    #[cfg(target_os = "linux")]
    for name in ["x.png", "%d.png", "x.gif", "x.mp4"] {
        let error = Output::create(&Path::new("/proc").join(name), (4, 4), 30.0).unwrap_err();
        assert!(
            matches!(error, OutputError::File { .. }),
            "{name}: {error:?}"
        );
    }
}

#[test]
fn names_sizes_and_speeds_without_sense_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let create = |name: &str, size, speed| Output::create(&folder.path().join(name), size, speed);

    let error = create("x.avi", (4, 4), 30.0).unwrap_err();
    assert!(matches!(error, OutputError::Name(_)), "{error:?}");
    assert!(error.to_string().contains("NAME.mp4"), "{error}");

    for (name, size) in [
        ("x.png", (0, 4)),
        ("x.gif", (4, 65536)),
        ("x.mp4", (16385, 4)),
    ] {
        let error = create(name, size, 30.0).unwrap_err();
        assert!(
            matches!(error, OutputError::Size { .. }),
            "{name}: {error:?}"
        );
    }
    for speed in [0.0, -1.0, 1001.0, f64::NAN, f64::INFINITY] {
        let error = create("x.mp4", (4, 4), speed).unwrap_err();
        assert!(
            matches!(error, OutputError::FrameRate(_)),
            "{speed}: {error:?}"
        );
    }
    assert_eq!(names_in(folder.path()), Vec::<String>::new());
}

#[test]
#[should_panic(expected = "another size")]
fn frame_of_another_size_is_a_mistake() {
    let folder = tempfile::tempdir().unwrap();
    let mut output = Output::create(&folder.path().join("x.png"), (4, 4), 30.0).unwrap();
    let _ = output.frame(&plain((4, 5), RED));
}

#[test]
fn missing_encoder_is_an_error_that_helps() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("torus.mp4");
    let encoder = folder.path().join("no-such-program");
    let error = Output::create_with_encoder(&path, (4, 4), 30.0, &encoder).unwrap_err();
    assert!(matches!(error, OutputError::NoEncoder { .. }), "{error:?}");
    let text = error.to_string();
    for part in [
        "no-such-program",
        "apt-get install ffmpeg",
        "torus_%05d.png",
        "torus.gif",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert_eq!(names_in(folder.path()), Vec::<String>::new());
}

/// A script that replaces the encoder.
#[cfg(unix)]
fn fake_encoder(folder: &Path, script: &str) -> PathBuf {
    let path = folder.join("encoder");
    // Another process writes it: a file that this one has open for writing, even in a child of
    // another test's thread, could not be started.
    let write = "printf '#!/bin/sh\\n%s\\n' \"$1\" > \"$2\" && chmod +x \"$2\"";
    let status = Command::new("sh")
        .args(["-c", write, "sh", script])
        .arg(&path)
        .status()
        .unwrap();
    assert!(status.success());
    path
}

/// The error of a video whose encoder is this script, after as many frames as it takes.
#[cfg(unix)]
fn error_with_encoder(script: &str) -> OutputError {
    let tools = tempfile::tempdir().unwrap();
    let encoder = fake_encoder(tools.path(), script);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mp4");
    let size = (256, 256);
    let mut output = Output::create_with_encoder(&path, size, 30.0, &encoder).unwrap();
    let frame = plain(size, RED);
    let error = (0..20)
        .find_map(|_| output.frame(&frame).err())
        .unwrap_or_else(|| output.finish().unwrap_err());
    assert_eq!(names_in(folder.path()), Vec::<String>::new(), "{script}");
    error
}

#[cfg(unix)]
#[test]
fn encoder_that_gives_up_is_quoted() {
    for (script, status, words) in [
        (
            "echo 'Unknown encoder libx264' >&2; exit 1",
            "exit status: 1",
            "Unknown encoder libx264",
        ),
        (
            "head -c 300000 >/dev/null; echo one >&2; echo 'No space left on device' >&2; exit 228",
            "exit status: 228",
            "one\nNo space left on device",
        ),
        ("kill -9 $$", "signal: 9", ""),
        // It fails only at the end.
        (
            "cat >/dev/null; echo 'cannot close' >&2; exit 5",
            "exit status: 5",
            "cannot close",
        ),
        // It prints more than a pipe holds before it reads anything.
        (
            "head -c 1000000 /dev/zero | tr '\\0' '\\n' >&2; echo end >&2; cat >/dev/null; exit 3",
            "exit status: 3",
            "end",
        ),
        ("cat >/dev/null", "the file is not whole", ""),
        // The disk is full before the index is whole, but the exit status is success, as with ffmpeg.
        (
            "cat >/dev/null; for last; do :; done; \
             printf '\\000\\000\\000\\020ftypisomisom\\000\\000\\001\\000moov' >\"${last#file:}\"; echo full >&2",
            "the file is not whole",
            "full",
        ),
        ("exec sleep 60 <&-", "it did not answer", ""),
    ] {
        let error = error_with_encoder(script);
        let text = error.to_string();
        assert!(
            matches!(error, OutputError::Encoder { .. }),
            "{script}: {error:?}"
        );
        assert!(
            text.contains(status) && text.contains(words),
            "{script}: {text}"
        );
    }
}

/// Catches a missing encoder that is only detected at the first frame, or at the end of a long run.
#[cfg(unix)]
#[test]
fn encoders_are_tried_before_the_first_frame() {
    let tools = tempfile::tempdir().unwrap();
    let tried = |script: &str| super::video::try_encoder(&fake_encoder(tools.path(), script));
    let refused = tried("echo >&2; echo \"Unknown encoder 'libx264'\" >&2; exit 1");
    assert_eq!(
        refused.unwrap_err().to_string(),
        "Unknown encoder 'libx264'"
    );
    assert!(
        tried("kill -9 $$")
            .unwrap_err()
            .to_string()
            .contains("signal: 9")
    );
    tried("cat >/dev/null").unwrap();
    let missing = super::video::try_encoder(&tools.path().join("none"));
    assert_eq!(missing.unwrap_err().kind(), std::io::ErrorKind::NotFound);
}

/// Pixels that cannot be compressed.
fn noise(size: (u32, u32), seed: u32) -> RgbaImage {
    let mut bits = seed.wrapping_mul(0x9e37_79b9) | 1;
    let mut next = move || {
        bits ^= bits << 13;
        bits ^= bits >> 17;
        bits ^= bits << 5;
        bits as u8
    };
    RgbaImage::from_fn(size.0, size.1, |_, _| Rgba([next(), next(), next(), 255]))
}

/// A disk has room for some frames, which are kept as a playable video.
#[cfg(unix)]
#[test]
fn video_that_breaks_off_keeps_its_whole_frames() {
    let tools = tempfile::tempdir().unwrap();
    // Blocks of 512 bytes, as `sh` counts them: the file ends at 1 MiB.
    let script = "trap \"\" XFSZ; ulimit -f 2048; exec ffmpeg \"$@\"";
    let encoder = fake_encoder(tools.path(), script);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mp4");
    let size = (128, 96);
    let mut output = Output::create_with_encoder(&path, size, 30.0, &encoder).unwrap();
    let failed = (0..400).find_map(|i| output.frame(&noise(size, i)).err());
    let error = match failed {
        Some(error) => output.cut(error),
        None => output.finish().unwrap_err(),
    };
    let OutputError::Cut { source, kept } = &error else {
        panic!("{error}");
    };
    assert!(matches!(**source, OutputError::Encoder { .. }), "{error}");
    assert_eq!(kept.files, std::slice::from_ref(&path));
    assert!(kept.frames >= 15, "{error}");
    let says = format!("({} frames, ", kept.frames);
    assert!(error.to_string().contains(&says), "{error}");
    assert_eq!(names_in(folder.path()), ["x.mp4"]);
    let frames = read_video(&path, size);
    assert_eq!(frames.len() as u64, kept.frames);
}

/// The disk is full when a part ends, and the encoder's exit status is success.
#[cfg(unix)]
#[test]
fn video_that_lacks_whole_parts_is_cut() {
    let tools = tempfile::tempdir().unwrap();
    // 64 x 48 pixels are 12288 bytes: ten frames.
    let script = "head -c 122880 | ffmpeg \"$@\"; cat >/dev/null";
    let encoder = fake_encoder(tools.path(), script);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mp4");
    let size = (64, 48);
    let mut output = Output::create_with_encoder(&path, size, 30.0, &encoder).unwrap();
    for i in 0..40 {
        output.frame(&noise(size, i)).unwrap();
    }
    let error = output.finish().unwrap_err();
    let OutputError::Cut { source, kept } = &error else {
        panic!("{error}");
    };
    assert!(source.to_string().contains("not whole"), "{error}");
    assert_eq!(kept.frames, 10);
    assert_eq!(read_video(&path, size).len(), 10);
}

/// The second file, with its index in front, lacks frames: the first one stays.
#[cfg(unix)]
#[test]
fn video_whose_copy_lacks_frames_keeps_them() {
    let tools = tempfile::tempdir().unwrap();
    let script = "case \"$*\" in *faststart*) set -- -t 0.2 \"$@\";; esac; exec ffmpeg \"$@\"";
    let encoder = fake_encoder(tools.path(), script);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mp4");
    let size = (64, 48);
    let mut output = Output::create_with_encoder(&path, size, 30.0, &encoder).unwrap();
    for i in 0..40 {
        output.frame(&noise(size, i)).unwrap();
    }
    assert_eq!(output.finish().unwrap().frames, 40);
    assert_eq!(read_video(&path, size).len(), 40);
    assert_eq!(names_in(folder.path()), ["x.mp4"]);
}

/// The end of the file fits on a full disk, because its space is already taken.
#[test]
fn gif_on_the_disk_ends_behind_each_frame() {
    let folder = tempfile::tempdir().unwrap();
    let size = (16, 12);
    let mut output = Output::create(&folder.path().join("x.gif"), size, 25.0).unwrap();
    output.frame(&noise(size, 0)).unwrap();
    for count in 1..5 {
        output.frame(&noise(size, count)).unwrap();
        let names = names_in(folder.path());
        assert_eq!(names.len(), 1, "{names:?}");
        let hidden = folder.path().join(&names[0]);
        assert_eq!(std::fs::read(&hidden).unwrap().last(), Some(&0x3b));
        // The last frame is pending, because its length is not known yet.
        assert_eq!(read_gif(&hidden).len(), count as usize);
    }
}

#[test]
fn gif_that_breaks_off_keeps_its_whole_frames() {
    let folder = tempfile::tempdir().unwrap();
    let size = (16, 12);
    for count in [1, 5] {
        let path = folder.path().join(format!("{count}.gif"));
        let mut gif = super::gif::Gif::create(&path, size, 25.0).unwrap();
        for i in 0..count {
            gif.frame(&noise(size, i)).unwrap();
        }
        // The last frame is pending, because its length is not known yet.
        gif.write_half();
        let kept = gif.cut();
        if count == 1 {
            assert_eq!(kept, None);
            assert!(!path.exists());
        } else {
            assert_eq!(kept, Some((path.clone(), 4)));
            let frames = read_gif(&path);
            let delays: Vec<u16> = frames.iter().map(|frame| frame.1).collect();
            assert_eq!(delays, [4; 4]);
        }
    }
    assert_eq!(names_in(folder.path()), ["5.gif"]);
}

/// A sequence has its frames in files of their own.
#[test]
fn sequence_that_breaks_off_reports_the_frames_there() {
    let folder = tempfile::tempdir().unwrap();
    let mut output = Output::create(&folder.path().join("s/%d.png"), (16, 12), 25.0).unwrap();
    output.frame(&noise((16, 12), 1)).unwrap();
    output.frame(&noise((16, 12), 2)).unwrap();
    std::fs::create_dir(folder.path().join("s/2.png")).unwrap();
    let error = output.frame(&noise((16, 12), 3)).unwrap_err();
    let OutputError::Cut { kept, .. } = output.cut(error) else {
        panic!("two frames are whole");
    };
    assert_eq!((kept.frames, kept.files.len()), (2, 2));
}

#[cfg(unix)]
#[test]
fn encoder_that_stops_reports_its_last_frame() {
    // 256 x 256 pixels are 262144 bytes: the second frame is cut short.
    let OutputError::Encoder { frames, .. } =
        error_with_encoder("head -c 300000 >/dev/null; exit 1")
    else {
        panic!("an encoder's error");
    };
    assert_eq!(frames, 1);
}

/// Makes a video with this script as its encoder and this limit of inactivity. Returns the error, its time, and the process ids that the
/// script has written to the file `$PIDS`.
#[cfg(target_os = "linux")]
fn impatient(
    script: &str,
    limits: [u64; 2],
    interrupt: Option<&'static AtomicBool>,
) -> (OutputError, Duration, Vec<u32>) {
    let tools = tempfile::tempdir().unwrap();
    let pids = tools.path().join("pids");
    let script = format!("PIDS='{}'\n{script}", pids.display());
    let encoder = fake_encoder(tools.path(), &script);
    let path = tools.path().join("x.mp4");
    let size = (256, 256);
    let mut output = Output::create_with_encoder(&path, size, 30.0, &encoder).unwrap();
    let Writer::Video(video) = &mut output.writer else {
        panic!("it is a video");
    };
    [video.patience().idle, video.patience().hurried] = limits.map(Duration::from_secs);
    interrupt.inspect(|flag| output.set_interrupt(flag));
    let begun = Instant::now();
    let error = match output.frame(&plain(size, RED)) {
        Ok(()) => output.finish().unwrap_err(),
        Err(error) => output.cut(error),
    };
    let pids = std::fs::read_to_string(pids).unwrap();
    let pids = pids.lines().map(|pid| pid.parse().unwrap()).collect();
    (error, begun.elapsed(), pids)
}

/// Zombie processes do not count.
#[cfg(target_os = "linux")]
fn runs(pid: u32) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    status.contains("State:") && !status.contains("State:\tZ")
}

#[cfg(target_os = "linux")]
fn ends_soon(pid: u32) -> bool {
    let begun = Instant::now();
    while runs(pid) && begun.elapsed() < Duration::from_secs(10) {
        std::thread::sleep(Duration::from_millis(10));
    }
    !runs(pid)
}

/// Checks two scripts at once: most of the time they wait.
#[cfg(target_os = "linux")]
fn side_by_side(scripts: [&str; 2], check: impl Fn(&str) + Sync) {
    let check = &check;
    std::thread::scope(|scope| {
        for script in scripts {
            scope.spawn(move || check(script));
        }
    });
}

/// Catches a wait without a limit: for an encoder that takes all frames and never exits, and for one that takes none, both with a child
/// process that runs on.
#[cfg(target_os = "linux")]
#[test]
fn encoder_that_does_nothing_is_ended_with_what_it_has_started() {
    let scripts = [
        "echo $$ >$PIDS; cat >/dev/null; sleep 1000 & echo $! >>$PIDS; wait",
        "echo $$ >$PIDS; trap '' TERM INT; sleep 1000 & echo $! >>$PIDS; wait",
    ];
    side_by_side(scripts, |script| {
        let (error, time, pids) = impatient(script, [2, 1000], None);
        let text = error.to_string();
        assert!(
            text.contains("it did nothing for 2 s and was ended"),
            "{script}: {text}"
        );
        assert!(time < Duration::from_secs(60), "{script}: {time:?}");
        assert_eq!(pids.len(), 2, "{script}");
        assert!(pids.into_iter().all(ends_soon), "{script}");
    });
}

/// Catches a Ctrl-C that does not shorten the wait for an encoder that hangs.
#[cfg(target_os = "linux")]
#[test]
fn first_interrupt_ends_an_encoder_that_does_nothing() {
    let scripts = [
        "echo $$ >$PIDS; cat >/dev/null; exec sleep 1000",
        "echo $$ >$PIDS; exec sleep 1000",
    ];
    side_by_side(scripts, |script| {
        let flag: &'static AtomicBool = Box::leak(Box::new(AtomicBool::new(false)));
        let user = std::thread::spawn(|| {
            std::thread::sleep(Duration::from_millis(300));
            flag.store(true, Ordering::Relaxed);
        });
        let (error, time, pids) = impatient(script, [1000, 1], Some(flag));
        user.join().unwrap();
        assert!(error.to_string().contains("did nothing for 1 s"), "{error}");
        assert!(time < Duration::from_secs(60), "{script}: {time:?}");
        assert!(pids.into_iter().all(ends_soon), "{script}");
    });
}

/// Catches a child process that still writes after the encoder has exited.
#[cfg(target_os = "linux")]
#[test]
fn what_an_encoder_leaves_behind_is_ended() {
    let script = "sleep 1000 & echo $! >$PIDS; cat >/dev/null; exit 3";
    let (error, _, pids) = impatient(script, [1000, 1000], None);
    assert!(error.to_string().contains("exit status: 3"), "{error}");
    assert!(pids.into_iter().all(ends_soon));
}

/// Catches lines of unlimited length, which would fill the memory and the terminal, and control characters in them.
#[cfg(unix)]
#[test]
fn what_an_encoder_prints_is_kept_up_to_a_limit() {
    let error = error_with_encoder(
        "head -c 50000000 /dev/zero | tr '\\0' x >&2; printf '\\n\\033[2Jend\\n' >&2; exit 1",
    );
    let text = error.to_string();
    assert!(text.len() < 1000, "{} bytes", text.len());
    assert!(text.ends_with("xxx\n\\u{1b}[2Jend"), "{text}");
}

#[cfg(unix)]
#[test]
fn encoder_does_not_hear_the_terminals_interrupt() {
    // The encoder has a process group of its own.
    let error =
        error_with_encoder("cat >/dev/null; kill -s 0 -- -$$ && echo 'own group' >&2; exit 1");
    assert!(error.to_string().contains("own group"), "{error}");
}
