//! The end of it all: every control that a test has met, and every key that the help lists, was worked by one.
//!
//! Controls are known by their names in `--places`; what all rows have, such as a way back, is one control. Worked is one onto
//! which the pointer was brought before one of its buttons went down, and a key that was pressed anywhere; what came of it is
//! for the tests themselves to see. Controls that no test meets are for the tests of the project to find.
//!
//! Where tests run in several processes, the variable `MYXO_WORKED` names a folder in which each process keeps what it has seen
//! and done; the process that runs the check in the end, by itself, reads all of it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{LazyLock, Mutex, PoisonError};
use std::thread::sleep;
use std::time::{Duration, Instant, SystemTime};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::can_open;

/// All tests together may take so long on a slow machine.
const PATIENCE: Duration = Duration::from_secs(3600);

/// Of which there are as many as there are scenes, looks, files, maps or words: one of them stands for all. Of others, such as
/// tools and views, each is a control of its own.
const ANY: [&str; 8] = [
    "card", "do", "preset", "recent", "left", "remove", "colors", "section",
];

/// The beginnings of names whose words after `=` are controls of their own, though a dot is in them.
const OWN_WORDS: [&str; 2] = ["out.", "picture.background"];

/// What all tests have seen and done.
#[derive(Default, Deserialize, Serialize)]
struct Told {
    /// The first name of each control that was met.
    met: BTreeMap<String, String>,
    worked: BTreeSet<String>,
    /// Those of the help.
    keys: BTreeSet<String>,
    /// Tests that have ended.
    ended: BTreeSet<String>,
}

impl Told {
    /// With what another process has seen and done.
    fn with(mut self, other: Self) -> Self {
        self.met.extend(other.met);
        self.worked.extend(other.worked);
        self.keys.extend(other.keys);
        self
    }
}

/// The folder that `MYXO_WORKED` names.
fn shared_folder() -> Option<PathBuf> {
    std::env::var_os("MYXO_WORKED").map(PathBuf::from)
}

/// A lab has closed: keeps what this process has seen and done so far, where other processes are to know it.
pub fn keep() {
    if let Some(folder) = shared_folder() {
        // Numbers of processes come again.
        static BEGUN: LazyLock<u128> = LazyLock::new(|| {
            let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
            since.expect("it is later than that").as_nanos()
        });
        let file = folder.join(format!("{}-{}.json", std::process::id(), *BEGUN));
        let text = told(|told| serde_json::to_string(told).expect("it is plain"));
        std::fs::write(file, text).expect("MYXO_WORKED is a folder that can be written");
    }
}

/// All that the processes of the shared folder have seen and done.
fn of_all(folder: &Path) -> Told {
    let files = std::fs::read_dir(folder).expect("MYXO_WORKED is a folder");
    let told = files.map(|file| {
        let text = std::fs::read(file.expect("it can be listed").path()).expect("it can be read");
        serde_json::from_slice::<Told>(&text).expect("a process has written it")
    });
    told.fold(Told::default(), Told::with)
}

static TOLD: Mutex<Option<Told>> = Mutex::new(None);

fn told<T>(what: impl FnOnce(&mut Told) -> T) -> T {
    let mut told = TOLD.lock().unwrap_or_else(PoisonError::into_inner);
    what(told.get_or_insert_default())
}

/// What stands for the control of this name.
fn kind_of(name: &str) -> String {
    let parts = name.split_inclusive(['.', ':']).map(|part| {
        let (word, end) = part.split_at(part.trim_end_matches(['.', ':']).len());
        let is_number = !word.is_empty() && word.bytes().all(|b| b.is_ascii_digit());
        [if is_number { "0" } else { word }, end].concat()
    });
    let name: String = parts.collect();
    let way = name.rsplit_once(':').map(|(_, way)| way);
    // What every row has: its name with its menu, its reset, a dialog.
    if let Some(way @ ("name" | "reset" | "scene" | "default" | "open")) = way {
        return format!("a row's {way}");
    }
    if let Some((list, _)) = name.split_once('=')
        && ANY.contains(&list)
    {
        let way = way.filter(|way| matches!(*way, "yes" | "no"));
        return format!("{list} {}", way.unwrap_or_default());
    }
    // A parameter's words.
    if let Some((key, _)) = name.split_once('=')
        && key.contains('.')
        && !OWN_WORDS.iter().any(|own| key.starts_with(own))
    {
        return format!("{key}=");
    }
    name
}

/// The lab has told this.
pub fn met(seen: &Value) {
    let Some(places) = seen["places"].as_object() else {
        return;
    };
    told(|told| {
        for name in places.keys() {
            let first = told.met.entry(kind_of(name));
            first.or_insert_with(|| name.clone());
        }
        if let Some(keys) = seen["values"]["help.keys"].as_str() {
            told.keys.extend(keys_of(keys));
        }
    });
}

/// The pointer is on this control, and one of its buttons has gone down.
pub fn control(name: &str) {
    told(|told| told.worked.insert(kind_of(name)));
}

/// These keys were pressed together.
pub fn key(name: &str) {
    told(|told| told.worked.insert(format!("key {}", name.to_lowercase())));
}

/// A test of this program, until its thread ends.
struct Begun {
    name: String,
}

impl Drop for Begun {
    fn drop(&mut self) {
        told(|told| told.ended.insert(std::mem::take(&mut self.name)));
    }
}

fn own_name() -> String {
    std::thread::current().name().unwrap_or_default().to_owned()
}

/// The test that calls it is waited for, whatever comes of it.
pub fn begins() {
    thread_local!(static BEGUN: Begun = Begun { name: own_name() });
    BEGUN.with(|_| {});
}

/// The keys that the help lists, as the hand names them.
fn keys_of(list: &str) -> Vec<String> {
    let keys = list.split(", ").flat_map(|some| some.split("  "));
    let key = |key: &str| {
        let words = key.split(' ').map(|word| match word {
            "]" => "bracketright".to_owned(),
            "[" => "bracketleft".to_owned(),
            "." => "period".to_owned(),
            "Esc" => "escape".to_owned(),
            word => word.to_lowercase(),
        });
        words.collect::<Vec<_>>().join("+")
    };
    keys.map(|one| format!("key {}", key(one))).collect()
}

/// The tests of this program, as far as these words choose them.
fn tests(words: &[String]) -> BTreeSet<String> {
    let program = std::env::current_exe().expect("it is running");
    let list = Command::new(program).arg("--list").args(words).output();
    let list = String::from_utf8(list.expect("it lists its tests").stdout);
    let list = list.expect("they are words");
    let names = list.lines().filter_map(|line| line.strip_suffix(": test"));
    names.map(str::to_owned).collect()
}

/// Comes last by its name, so that one thread is enough for all. Those that need a display may be left out.
#[test]
fn every_control_that_was_met_was_worked() {
    if !can_open() {
        return;
    }
    if let Some(folder) = shared_folder() {
        return check(&of_all(&folder));
    }
    let words: Vec<String> = std::env::args().skip(1).collect();
    let ignored = tests(&["--ignored".to_owned()]);
    let mut others = &tests(&words) - &ignored;
    let all = &tests(&[]) - &ignored;
    let left_out = all
        .difference(&others)
        .find(|name| !name.starts_with("real::"));
    if let Some(name) = left_out {
        return eprintln!("skipped: {name} was not chosen, and only all of them together can tell");
    }
    let own = others.pop_last().unwrap_or_default();
    assert!(own.ends_with("every_control_that_was_met_was_worked"));
    let missing = || told(|told| others.difference(&told.ended).cloned().collect::<Vec<_>>());
    // A single thread, which has no name of a test then, has all of them behind it.
    if own_name() == own {
        let begun = Instant::now();
        while !missing().is_empty() {
            assert!(begun.elapsed() < PATIENCE, "not ended: {:?}", missing());
            sleep(Duration::from_millis(200));
        }
    }
    told(|told| check(told));
}

fn check(told: &Told) {
    let Told {
        met, worked, keys, ..
    } = told;
    assert!(met.len() > 150 && keys.len() > 40, "{met:?}, {keys:?}");
    let left: Vec<&String> = (met.iter())
        .filter(|(control, _)| !worked.contains(*control))
        .map(|(_, name)| name)
        .collect();
    let not_pressed: Vec<&String> = keys.difference(worked).collect();
    assert!(
        left.is_empty() && not_pressed.is_empty(),
        "nobody has worked {left:?}, nor pressed {not_pressed:?}"
    );
}

#[test]
fn controls_of_a_kind_are_one() {
    begins();
    for (name, is) in [
        ("undo", "undo"),
        ("object.12.scale", "object.0.scale"),
        ("object.1.motion.model=follow", "object.0.motion.model="),
        ("trail.decay:reset", "a row's reset"),
        ("card=trio", "card "),
        ("section=Object: box", "section "),
        ("error.2:copy", "error.0:copy"),
        ("preset.keep", "preset.keep"),
        ("remove=mine:yes", "remove yes"),
        ("out.kind=GIF", "out.kind=GIF"),
        ("tool=erase", "tool=erase"),
        ("do=take one step", "do "),
    ] {
        assert_eq!(kind_of(name), is);
    }
    assert_eq!(keys_of("H, F1"), ["key h", "key f1"]);
    assert_eq!(keys_of("S  ."), ["key s", "key period"]);
    assert_eq!(keys_of("Ctrl Shift Z"), ["key ctrl+shift+z"]);
}
