//! Helpers of tests of the program: running it, and checks of failures.

#![allow(dead_code, reason = "each test program uses its own part")]

use std::ffi::OsStr;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::places;
use ::myxo::signals;

const BUILT: &str = env!("CARGO_BIN_EXE_myxo");

/// A scene that takes a tenth of a second.
pub const TINY: [&str; 5] = [
    "cube",
    "--set",
    "particles.count=2000",
    "--set",
    "atlas.size=64",
];

/// The program, to be given arguments.
pub fn program() -> Command {
    let mut command = Command::new(places::program(BUILT));
    command.env_remove("RUST_LOG").stdin(Stdio::null());
    // Checks all that the program records, also without validation layers.
    command.env("MYXO_CHECK", "1");
    signals::end_by_signals(&mut command);
    command
}

pub fn myxo(arguments: &[impl AsRef<OsStr>]) -> Output {
    program()
        .args(arguments)
        .output()
        .expect("the program starts")
}

/// A standard output that its reader has closed, as `head` does.
pub fn closed_pipe() -> Stdio {
    let (reader, writer) = std::io::pipe().expect("there are free handles");
    drop(reader);
    writer.into()
}

/// Runs it where files end after so many blocks of 512 bytes, as on a disk that is full. The system's signal for that ends programs
/// that do not ignore it.
#[cfg(unix)]
pub fn with_files_up_to(blocks: u32, arguments: &[impl AsRef<OsStr>]) -> Output {
    let limited = format!("ulimit -f {blocks}; exec \"$@\"");
    Command::new("sh")
        .args(["-c", &limited, "sh"])
        .arg(places::program(BUILT))
        .args(arguments)
        .env("MYXO_CHECK", "1")
        .stdin(Stdio::null())
        .output()
        .expect("there is a shell")
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("output is UTF-8")
}

/// Runs what must succeed, and gives what it says on the standard error.
#[track_caller]
pub fn done(arguments: &[impl AsRef<OsStr>]) -> String {
    let output = myxo(arguments);
    let messages = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{messages}");
    messages
}

/// Runs what must fail, and gives the message.
#[track_caller]
pub fn refused(code: i32, arguments: &[impl AsRef<OsStr>]) -> String {
    refusal(code, &myxo(arguments))
}

/// The message of what must have failed.
#[track_caller]
pub fn refusal(code: i32, output: &Output) -> String {
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{message}");
    assert_eq!(text(&output.stdout), "");
    assert!(
        !message.contains("panicked") && !message.contains("RUST_BACKTRACE"),
        "{message}"
    );
    assert!(
        message.ends_with('\n') && message.trim().len() > 20,
        "{message:?}"
    );
    message
}

/// The message without the line about the machine's load, which depends on other processes.
pub fn but_for_load(message: &str) -> String {
    let busy = |line: &&str| line.starts_with("the machine was busy: ");
    message
        .split_inclusive('\n')
        .filter(|line| !busy(line))
        .collect()
}

/// A failure that is reported by the program itself: its name first, one message.
#[track_caller]
pub fn failed(arguments: &[impl AsRef<OsStr>]) -> String {
    failure(&myxo(arguments))
}

/// As [`failed`], of what has run already.
#[track_caller]
pub fn failure(output: &Output) -> String {
    let message = refusal(1, output);
    let message = but_for_load(&message);
    assert!(message.starts_with("myxo: "), "{message}");
    assert_eq!(message.matches("myxo: ").count(), 1, "{message}");
    message
}

pub fn path(path: &Path) -> &str {
    path.to_str().expect("temporary paths are Unicode")
}

/// A short render of `scene` to `out`.
pub fn short_render<'a>(scene: &'a str, out: &'a Path, options: &[&'a str]) -> Vec<&'a str> {
    let mut arguments = vec!["render", scene, "--out", path(out)];
    arguments.extend(["--steps", "2", "--size", "64x48"]);
    arguments.extend(&TINY[1..]);
    arguments.extend(options);
    arguments
}

/// A folder of a test, and the names of its files.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    pub fn file(&self, name: impl AsRef<Path>) -> PathBuf {
        self.0.path().join(name)
    }

    /// A file in it with this content.
    pub fn with(&self, name: impl AsRef<Path>, content: impl AsRef<[u8]>) -> PathBuf {
        let file = self.file(name);
        std::fs::write(&file, content).expect("it can be written");
        file
    }

    /// Everything in it, hidden files too, sorted.
    pub fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).expect("it is a folder");
        let mut names: Vec<String> = entries
            .map(|entry| {
                let name = entry.expect("it can be listed").file_name();
                name.to_string_lossy().into_owned()
            })
            .collect();
        names.sort();
        names
    }
}

/// Makes the program log the parts of its set-up on the standard error, for [`interrupted`].
pub fn logging_its_parts(run: &mut Command) -> &mut Command {
    run.env("RUST_LOG", "myxo=info")
}

/// Waits until what has begun says these words on the standard error, which must be piped, then sends it Ctrl-C, once. It must
/// end within `patience`, as interrupted.
#[cfg(unix)]
#[track_caller]
pub fn interrupted(run: Child, words: &str, patience: Duration) -> Output {
    interrupted_at(run, words, 1, patience)
}

/// As [`interrupted`], when it says these words for the `times`-th time.
#[cfg(unix)]
#[track_caller]
pub fn interrupted_at(mut run: Child, words: &str, times: usize, patience: Duration) -> Output {
    let messages = run.stderr.take().expect("the standard error is piped");
    let mut messages = BufReader::new(messages);
    let mut said = String::new();
    while said.matches(words).count() < times {
        let length = messages.read_line(&mut said).expect("it is UTF-8");
        assert!(length > 0, "it ends without a word of {words:?}: {said}");
    }
    interrupt(&run);
    let asked = Instant::now();
    messages.read_to_string(&mut said).expect("it is UTF-8");
    let output = run.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(asked.elapsed() < patience, "{:?}", asked.elapsed());
    Output {
        stderr: said.into_bytes(),
        ..output
    }
}

/// Sends Ctrl-C.
#[cfg(unix)]
#[track_caller]
pub fn interrupt(run: &Child) {
    signal(run, "INT");
}

/// Sends the signal of this name.
#[cfg(unix)]
#[track_caller]
pub fn signal(run: &Child, name: &str) {
    let kill = format!("kill -{name} {}", run.id());
    let killed = Command::new("sh").args(["-c", &kill]).status();
    assert!(killed.expect("there is a shell").success());
}

/// Waits until a condition holds, and fails the test that calls it when it does not in time. Nothing else in tests sleeps: how
/// long something takes is not the same on any two machines.
#[track_caller]
pub fn wait_until(what: &str, patience: Duration, mut condition: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !condition() {
        let waited = begun.elapsed();
        assert!(waited < patience, "{what}: not within {patience:?}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// A report that `--report` or `--json` has written.
pub fn report(file: &Path) -> serde_json::Value {
    let text = std::fs::read(file).expect("there is a report");
    serde_json::from_slice(&text).expect("it is JSON")
}

/// True where there is no device and `MYXO_ALLOW_NO_DEVICE=1` says that tests may then be skipped.
pub fn no_device() -> bool {
    // To ask for devices takes longer.
    let lacking =
        std::env::var_os("MYXO_ALLOW_NO_DEVICE").is_some() && ::myxo::gpu::devices().is_err();
    if lacking {
        eprintln!("skipped: there is no device");
    }
    lacking
}

/// Width, height and number of the frames that a player gets out of a video.
#[track_caller]
pub fn shown_of(film: &Path) -> ([u32; 2], u64) {
    let output = Command::new("ffprobe")
        .args(["-v", "error", "-count_frames", "-select_streams", "v:0"])
        .args(["-show_entries", "stream=width,height,nb_read_frames"])
        .args(["-of", "csv=p=0"])
        .arg(film)
        .output()
        .expect("ffprobe comes with ffmpeg");
    let size = text(&output.stdout);
    let numbers: Vec<u64> = size.trim().split(',').flat_map(str::parse).collect();
    let [width, height, frames] = numbers[..] else {
        panic!("{}: {size:?} {}", film.display(), text(&output.stderr))
    };
    ([width, height].map(|side| side as u32), frames)
}

/// Two small objects in one another, so that some particles change.
pub fn small_pair(folder: &Folder) -> PathBuf {
    let file = folder.file("pair.toml");
    let text = "[particles]\ncount = 2000\n[physarum]\nspeed = 0.02\n[atlas]\nsize = 64\n\
        [transfer]\nthreshold = 0.01\n[[object]]\nmesh = \"builtin:cube?divisions=3\"\n\
        [[object]]\nmesh = \"builtin:icosphere?subdivisions=2\"\nposition = [0.9, 0.3, 0.2]\n";
    std::fs::write(&file, text).expect("there is room");
    file
}

/// How much the pixels of two pictures differ in the mean, of 255.
pub fn difference_of(one: &Path, other: &Path) -> f64 {
    let [one, other] = [one, other].map(|file| image::open(file).expect("a picture").into_rgb8());
    let pairs = one.as_raw().iter().zip(other.as_raw());
    let sum: u64 = pairs.map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / one.as_raw().len() as f64
}
