//! Runs that are killed, interrupted, or find the disk full at random moments. After that each name has the old file or a whole new one,
//! and no temporary file is left.
//!
//! The short test takes a few moments of one command. The long ones take 30 of each command that writes files; `make long` runs
//! them. `MYXO_SEED=N` gives other moments, and a failure names its seed. `.ci/power-cut` is about what reaches the disk.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::os::unix::process::{CommandExt as _, ExitStatusExt as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use std::{fs, io};

use myxo::mesh::Mesh;
use myxo::rng::{Purpose, random, unit};
use myxo::scene::{Overrides, Scene};
use myxo::sim::checkpoint::Checkpoint;

use crate::program::{Folder, TINY, no_device, program, shown_of, text, wait_until};

/// Commands that write every format. In their arguments, words in capitals stand for the files of [`inputs`].
type Job = (&'static str, &'static str);

const JOBS: &[Job] = &[
    (
        "render",
        "render TINY --steps 6 --every 1 --size 200x150 --out a.png --out s/%03d.png --out a.gif --out a.mp4 \
         --report a.json --checkpoint a.state",
    ),
    (
        "export",
        "export TINY --set areas.map=\"MAP\" --steps 2 --out a.glb --out a.ply --out a.npz --out a.toml",
    ),
    (
        "export of a series",
        "export TINY --steps 3 --every 1 --colors vertex --out a.glb --out a.npz --report a.json",
    ),
    (
        "profile",
        "profile TINY --steps 2 --warmup 1 --report a.json --trace b.json",
    ),
    ("atlas", "atlas cube --fresh --size 256 --out a.png"),
    (
        "query atlas",
        "query atlas --mesh builtin:icosphere?subdivisions=3 --atlas-size 256 --out a.csv",
    ),
    (
        "query diffuse",
        "query diffuse --mesh builtin:cube --in SPOTS --steps 9 --atlas-size 128 --out a.csv",
    ),
    (
        "query geodesic",
        "query geodesic --mesh builtin:torus --in WALKS --out a.csv",
    ),
    (
        "query sdf",
        "query sdf --scene PAIR --in PLACES --out a.csv",
    ),
    (
        "query transfer",
        "query transfer --scene PAIR --in WALKS --out a.csv",
    ),
    (
        "bench",
        "bench mesh --quick --runs 1 --up-to 2000 --out results",
    ),
];

/// The first command, smaller and without the encoder, which takes long to start.
const SHORT: Job = (
    "render",
    "render TINY --steps 2 --every 1 --size 64x48 --out a.png --out s/%d.png --out a.gif --report a.json \
     --checkpoint a.state",
);

/// The signals of Ctrl-C and of a shutdown.
const ONCE: [(&str, u32); 2] = [("INT", 1), ("TERM", 1)];

/// How long a command may take to end when it is asked to, on a machine that does other work, too.
const PATIENCE: Duration = Duration::from_secs(30);

/// The input files of the commands.
fn inputs() -> Folder {
    let folder = Folder::new();
    let many = |header: &str, row: &str| {
        let rows = (0..400).map(|id| format!("{id},{row}\n"));
        format!("{header}\n{}", rows.collect::<String>())
    };
    folder.with(
        "WALKS",
        many(
            "id,face,b0,b1,b2,dx,dy,dz,length",
            "0,0.4,0.3,0.3,1,0.2,0,3",
        ),
    );
    folder.with("SPOTS", many("id,face,b0,b1,b2,amount", "0,0.4,0.3,0.3,2"));
    folder.with("PLACES", many("id,px,py,pz", "0.1,0.2,3"));
    let rows = "[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]";
    folder.with(
        "PAIR",
        format!(
            "{{\"mesh_a\": \"builtin:cube\", \"mesh_b\": \"builtin:torus\", \
             \"a_transform_row_major\": {rows}, \"b_transform_row_major\": {rows}}}"
        ),
    );
    let map = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/maps/maze.png");
    fs::copy(map, folder.file("MAP")).expect("it comes with the program");
    folder
}

/// The content of every file before a run.
fn old(name: &Path) -> Vec<u8> {
    format!("the old {}", name.display()).into_bytes()
}

/// How a run is disturbed.
#[derive(Clone, Copy, PartialEq)]
enum Disturbed {
    /// It is killed and cannot clean up.
    Killed,
    /// It is interrupted: it ends with the results so far; asked twice, at once.
    Asked,
    /// The disk is full: films that are cut short are kept beside the old ones.
    Full,
}

/// A command, the files of an undisturbed run, and how long that takes.
struct Trials {
    name: &'static str,
    arguments: Vec<String>,
    inputs: Folder,
    folder: Folder,
    whole: BTreeMap<PathBuf, Vec<u8>>,
    length: Duration,
    seed: u32,
    /// Random numbers so far.
    drawn: u32,
    /// Runs that were still going when their moment came.
    caught: u32,
}

impl Trials {
    fn new((name, arguments): Job) -> Self {
        let inputs = inputs();
        let words = arguments.split(' ').flat_map(|word| match word {
            "TINY" => TINY.map(str::to_owned).to_vec(),
            word => {
                let names = ["MAP", "WALKS", "SPOTS", "PAIR", "PLACES"];
                let path = |name| inputs.file(name).display().to_string();
                let replace = |word: String, name| word.replace(name, &path(name));
                vec![names.into_iter().fold(word.to_owned(), replace)]
            }
        });
        let seed = std::env::var("MYXO_SEED").unwrap_or("1".to_owned());
        let mut trials = Self {
            name,
            arguments: words.collect(),
            inputs,
            folder: Folder::new(),
            whole: BTreeMap::new(),
            length: Duration::MAX,
            seed: seed.parse().expect("MYXO_SEED is a number"),
            drawn: 0,
            caught: 0,
        };
        // The second time caches are warm, as in the trials.
        for _ in 0..2 {
            let begun = Instant::now();
            trials.run_whole();
            trials.length = trials.length.min(begun.elapsed());
            trials.whole = trials.files();
            for name in trials.whole.keys() {
                let path = trials.folder.file(name);
                check_whole(&path)
                    .unwrap_or_else(|problem| panic!("{}: {problem}", name.display()));
            }
            trials.whole.retain(|name, _| !is_map(name));
            trials.remove_maps();
        }
        trials
    }

    /// From 0 to 1.
    fn draw(&mut self) -> f64 {
        self.drawn += 1;
        f64::from(unit(random(self.seed, self.drawn, 0, Purpose::Start)[0]))
    }

    /// A random moment of the run; every second one is in its last quarter, in which most files are written.
    fn moment(&mut self) -> Duration {
        let part = self.draw();
        self.length.mul_f64(match self.drawn % 2 {
            0 => 1.05 * part,
            _ => 0.75 + 0.3 * part,
        })
    }

    /// The command run by another program, which gets it as its last arguments.
    fn command_by(&self, runner: &[String]) -> Command {
        let mut words = runner.iter().cloned();
        let first = words.next();
        let mut command = first.map_or_else(program, |first| {
            let mut command = Command::new(first);
            command.args(words).arg(env!("CARGO_BIN_EXE_myxo"));
            command.env_remove("RUST_LOG").stdin(Stdio::null());
            command
        });
        command
            .args(&self.arguments)
            .current_dir(self.folder.path())
            .env("XDG_CACHE_HOME", self.inputs.file("cache"))
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            // A process group of its own, as shells create.
            .process_group(0);
        command
    }

    fn run_whole(&self) {
        let output = self.command_by(&[]).output().expect("the program starts");
        assert!(output.status.success(), "{}", text(&output.stderr));
    }

    /// All files, including hidden ones.
    fn files(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let mut files = BTreeMap::new();
        let mut folders = vec![PathBuf::new()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(self.folder.file(&folder)).expect("it is a folder") {
                let name = folder.join(entry.expect("it can be listed").file_name());
                let path = self.folder.file(&name);
                if path.is_dir() {
                    folders.push(name);
                } else if let Some(content) = content_of(&path) {
                    files.insert(name, content);
                }
            }
        }
        files
    }

    fn begin_with_old_files(&self) {
        for name in self.whole.keys() {
            fs::write(self.folder.file(name), old(name)).expect("there is room");
        }
    }

    /// Checks every file after a disturbed run. Returns how many are new.
    #[track_caller]
    fn check_files(&self, by: Disturbed, moment: &str) -> usize {
        let at = format!("{}, {moment}, seed {}", self.name, self.seed);
        let mut files = self.files();
        let mut new = 0;
        for (name, whole) in &self.whole {
            let path = name.display();
            let found = files.remove(name);
            let found = found.unwrap_or_else(|| panic!("{at}: {path} is gone"));
            if found == old(name) {
                continue;
            }
            new += 1;
            if let Err(problem) = check_whole(&self.folder.file(name)) {
                panic!("{at}: {path} is not whole: {problem}");
            }
            // An interrupted run has taken fewer steps.
            let has_fewer_steps = by == Disturbed::Asked;
            let is_equal = has_fewer_steps || self.is_as(name, &found, whole);
            assert!(is_equal, "{at}: {path} is neither old nor new");
        }
        for name in files.into_keys() {
            let path = self.folder.file(&name);
            let name = name.display().to_string();
            let is_hidden = name.ends_with(".myxo-part");
            if is_hidden && by == Disturbed::Killed {
                continue;
            }
            let may_be = match by {
                Disturbed::Killed => false,
                // A series ends with the step at which it was interrupted.
                Disturbed::Asked => true,
                Disturbed::Full => name.contains(".cut."),
            };
            let may_be = (may_be || is_map(Path::new(&name))) && !is_hidden;
            assert!(may_be, "{at}: {name} is left");
            check_whole(&path).unwrap_or_else(|problem| panic!("{at}: {name}: {problem}"));
            fs::remove_file(&path).expect("it can be removed");
        }
        new
    }

    /// A scene's map takes a free name, because the old scene names another map.
    fn remove_maps(&self) {
        for name in self.files().into_keys().filter(|name| is_map(name)) {
            fs::remove_file(self.folder.file(name)).expect("it can be removed");
        }
    }

    /// Does a whole file have the right content? Times differ from run to run, and so does the order of particles in files with all
    /// particles; a video has its index at the end if there is no room to move it to the front.
    fn is_as(&self, name: &Path, found: &[u8], whole: &[u8]) -> bool {
        let ending = name.extension().and_then(OsStr::to_str).unwrap_or_default();
        match ending {
            "json" | "state" | "npz" => true,
            "mp4" => {
                let whole = self.inputs.with("whole.mp4", whole);
                shown_of(&self.folder.file(name)) == shown_of(&whole)
            }
            _ => name.starts_with("results") || found == whole,
        }
    }

    /// Runs the command and sends it a signal at a random moment, once or twice. Also returns a description, and how long the run took to
    /// end.
    fn disturb(&mut self, word: &str, times: u32) -> (Output, String, Duration) {
        self.begin_with_old_files();
        let moment = self.moment();
        let begun = Instant::now();
        let mut run = self.command_by(&[]).spawn().expect("the program starts");
        let mut has_ended = false;
        wait_until("the moment", moment + PATIENCE, || {
            has_ended = run.try_wait().expect("it can be asked").is_some();
            has_ended || begun.elapsed() >= moment
        });
        if has_ended {
            // Other programs have slowed down the run that gave the length.
            self.length = self.length.min(begun.elapsed());
        }
        let asked = Instant::now();
        if !has_ended {
            self.caught += 1;
            (0..times).for_each(|_| signal(&run, word));
        }
        let output = run.wait_with_output().expect("it has ended");
        let what = format!("{times} x {word} after {moment:?} of {:?}", self.length);
        (output, what, asked.elapsed())
    }

    /// Kills runs, and checks that the next run cleans up.
    fn kill(&mut self, trials: u32) {
        let mut new = 0;
        for _ in 0..trials {
            let (_, what, _) = self.disturb("KILL", 1);
            new += self.check_files(Disturbed::Killed, &what);
        }
        self.run_whole();
        let left = self.files().into_keys();
        let left: Vec<_> = left
            .filter(|name| !self.whole.contains_key(name) && !is_map(name))
            .collect();
        assert!(
            left.is_empty(),
            "{}: the run after killed ones leaves {left:?}, seed {}",
            self.name,
            self.seed
        );
        self.print_counts("killed", trials, new);
    }

    /// Interrupts runs once, or twice, as a user in a hurry does.
    fn interrupt(&mut self, trials: u32, how: &[(&str, u32)]) {
        let mut new = 0;
        for trial in 0..trials {
            let (word, times) = how[trial as usize % how.len()];
            let (output, what, took) = self.disturb(word, times);
            assert!(took < PATIENCE, "{}: {what}: {took:?}", self.name);
            let status = output.status;
            // Before there is a file, the signal ends the program.
            let is_right = matches!(status.code(), Some(0 | 130)) || status.signal().is_some();
            assert!(
                is_right,
                "{}: {what}: {status}: {}",
                self.name,
                text(&output.stderr)
            );
            new += self.check_files(Disturbed::Asked, &what);
        }
        self.print_counts("interrupted", trials, new);
    }

    /// Limits the length of files, which needs no rights.
    fn fill_up(&mut self, trials: u32) {
        let longest = self.whole.values().map(Vec::len).max();
        let blocks = longest.expect("it writes files").div_ceil(512);
        let mut new = 0;
        for _ in 0..trials {
            let limit = (self.draw() * blocks as f64) as u32;
            let script = format!("ulimit -f {limit}; exec \"$@\"");
            let runner = ["sh", "-c", &script, "sh"].map(str::to_owned);
            let (output, count) = self.run_full(&runner, &format!("files up to {limit} blocks"));
            assert_eq!(output.status.code(), Some(1), "files up to {limit} blocks");
            new += count;
        }
        self.print_counts("at the limit of file sizes", trials, new);
    }

    /// Runs on a memory disk that is too small, if the system allows to create one.
    fn fill_disk(&mut self, trials: u32) {
        let place = Folder::new();
        let place = place.path().display().to_string();
        let on_disk = |size: u64| {
            let script = "mount -t tmpfs -o size=$1k full \"$2\" || exit 99; from=$PWD\n\
                cp -a . \"$2\" && cd \"$2\" || exit 98; shift 2\n\
                \"$@\"; status=$?\n\
                rm -rf \"$from\"/* && cp -a . \"$from\" && exit $status";
            let size = size.to_string();
            ["unshare", "-Urm", "sh", "-c", script, "sh", &size, &place].map(str::to_owned)
        };
        let tried = Command::new("unshare")
            .args(&on_disk(64)[1..])
            .arg("true")
            .current_dir(Folder::new().path())
            .status();
        if !tried.is_ok_and(|status| status.success()) {
            eprintln!("skipped: no disk can be made here");
            return;
        }
        let pages = |bytes: usize| bytes.div_ceil(4096) as u64;
        let before = self.whole.len() as u64;
        let needed: u64 = self
            .whole
            .values()
            .map(|content| pages(content.len()))
            .sum();
        let mut new = 0;
        for _ in 0..trials {
            let size = 4 * (before + (self.draw() * needed as f64) as u64);
            new += self
                .run_full(&on_disk(size), &format!("a disk of {size} kB"))
                .1;
        }
        self.print_counts("on a full disk", trials, new);
    }

    #[track_caller]
    fn run_full(&self, runner: &[String], what: &str) -> (Output, usize) {
        self.begin_with_old_files();
        let output = self.command_by(runner).output().expect("there is a shell");
        let messages = text(&output.stderr);
        let at = format!("{}: {what}, seed {}: {messages}", self.name, self.seed);
        let new = self.check_files(Disturbed::Full, what);
        match output.status.code() {
            Some(0) => assert_eq!(new, self.whole.len(), "{at}"),
            Some(1) => {
                assert!(messages.contains("cannot write "), "{at}");
                let advice = ["free some space", "raise the limit of file sizes"];
                assert!(advice.iter().any(|a| messages.contains(a)), "{at}");
            }
            _ => panic!("{at}"),
        }
        assert!(!messages.contains("panicked"), "{at}");
        (output, new)
    }

    fn print_counts(&self, how: &str, trials: u32, new: usize) {
        let files = self.whole.len() * trials as usize;
        eprintln!(
            "{}: {trials} times {how}: {new} of {files} files new, all others old",
            self.name
        );
        assert!(new < files || trials < 10, "no run was disturbed");
    }
}

/// Is it the map of areas that belongs to a scene file?
fn is_map(name: &Path) -> bool {
    name.to_string_lossy().contains("_areas")
}

/// The content, or `None` if another process has just removed the file.
fn content_of(path: &Path) -> Option<Vec<u8>> {
    match fs::read(path) {
        Ok(content) => Some(content),
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        Err(error) => panic!("{}: {error}", path.display()),
    }
}

/// Sends a signal to the group of a run that was not waited for, as a terminal does.
fn signal(run: &Child, word: &str) {
    let kill = format!("kill -s {word} -- -{}", run.id());
    let killed = Command::new("sh").args(["-c", &kill]).status();
    assert!(killed.expect("there is a shell").success());
}

/// Reads the whole file in the format of its extension.
fn check_whole(path: &Path) -> Result<(), String> {
    let ending = path.extension().unwrap_or_default();
    let ending = ending.to_str().unwrap_or_default();
    let bytes = fs::read(path).map_err(|error| error.to_string())?;
    let ends = |with: &[u8]| match bytes.ends_with(with) {
        true => Ok(()),
        false => Err(format!("its end is missing, after {} bytes", bytes.len())),
    };
    fn said<T>(read: Result<T, impl std::fmt::Display>) -> Result<(), String> {
        read.map(drop).map_err(|error| error.to_string())
    }
    match ending {
        "png" => said(image::open(path)).and_then(|()| ends(b"IEND\xae\x42\x60\x82")),
        "gif" => {
            let mut film = gif::Decoder::new(&bytes[..]).map_err(|error| error.to_string())?;
            while film.read_next_frame().map_err(|e| e.to_string())?.is_some() {}
            ends(b"\x3b")
        }
        "mp4" => match shown_of(path) {
            (_, 0) => Err("no frames".to_owned()),
            _ => Ok(()),
        },
        "json" => said(serde_json::from_slice::<serde_json::Value>(&bytes)),
        "glb" => {
            let length = bytes
                .get(8..12)
                .map(|l| u32::from_le_bytes(l.try_into().unwrap()));
            assert_eq!(length, Some(bytes.len() as u32));
            said(Mesh::load(path))
        }
        "ply" => said(Mesh::load(path)),
        "npz" => {
            let mut archive =
                zip::ZipArchive::new(io::Cursor::new(&bytes)).map_err(|e| e.to_string())?;
            for index in 0..archive.len() {
                let mut array = archive.by_index(index).map_err(|e| e.to_string())?;
                io::copy(&mut array, &mut io::sink()).map_err(|e| e.to_string())?;
            }
            Ok(())
        }
        "toml" => said(Scene::load(path, &Overrides::default())),
        "state" => said(Checkpoint::read(path)),
        "csv" | "txt" => ends(b"\n"),
        "svg" => ends(b"</svg>\n"),
        _ => Err("it is of no kind that is checked here".to_owned()),
    }
}

/// Catches a file that is written in place, one that keeps its hidden name, and an error without advice.
#[test]
fn a_few_moments() {
    if no_device() {
        return;
    }
    let mut trials = Trials::new(SHORT);
    trials.kill(3);
    trials.interrupt(2, &ONCE);
    assert!(trials.caught > 0, "each had ended before its moment");
    trials.fill_up(2);
}

#[test]
#[ignore = "takes minutes: make long"]
fn killed_at_random_moments() {
    JOBS.iter().for_each(|&job| Trials::new(job).kill(30));
}

#[test]
#[ignore = "takes minutes: make long"]
fn interrupted_at_random_moments() {
    JOBS.iter()
        .for_each(|&job| Trials::new(job).interrupt(30, &ONCE));
}

#[test]
#[ignore = "takes minutes: make long"]
fn interrupted_twice_at_random_moments() {
    let twice = [("INT", 2)];
    JOBS.iter()
        .for_each(|&job| Trials::new(job).interrupt(30, &twice));
}

#[test]
#[ignore = "takes minutes: make long"]
fn full_disks_at_random_moments() {
    for &job in JOBS {
        let mut trials = Trials::new(job);
        trials.fill_up(30);
        trials.fill_disk(30);
    }
}
