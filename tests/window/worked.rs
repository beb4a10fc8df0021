//! Checks that the tests have operated every control that they met, and pressed every key that the help lists.
//!
//! Controls are identified by their names in `--places`; what all rows have, such as a reset button, counts as one control. A control is
//! operated if a pointer button was pressed while the pointer was on it, and a key if it was pressed anywhere; the tests themselves check
//! the effects. Controls that no test meets are found by the tests of the project.
//!
//! If tests run in several processes, the variable `MYXO_WORKED` names a folder in which each process keeps what it has seen
//! and done; the process that runs the check at the end, alone, reads all of it.

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

/// Controls of which there is one for each scene, look, file, map or word: one of them stands for all. Each other control, such as a tool
/// or a view, counts on its own.
const ANY: [&str; 10] = [
    "card", "do", "preset", "recent", "left", "remove", "colors", "section", "kept", "second",
];

/// The beginnings of names whose words after `=` are controls of their own, though a dot is in them.
const OWN_WORDS: [&str; 2] = ["out.", "picture.background"];

/// What all tests have seen and done.
#[derive(Default, Deserialize, Serialize)]
struct Coverage {
    /// The first name of each control that was met.
    met: BTreeMap<String, String>,
    worked: BTreeSet<String>,
    /// Keys that the help lists.
    keys: BTreeSet<String>,
    /// Tests that have ended.
    ended: BTreeSet<String>,
}

impl Coverage {
    /// Adds what another process has seen and done.
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

/// Called when a lab has closed: writes what this process has seen and done so far into the shared folder, if there is one.
pub fn keep() {
    if let Some(folder) = shared_folder() {
        // Process ids are reused.
        static BEGUN: LazyLock<u128> = LazyLock::new(|| {
            let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
            since.expect("it is later than that").as_nanos()
        });
        let file = folder.join(format!("{}-{}.json", std::process::id(), *BEGUN));
        let text = with_coverage(|coverage| serde_json::to_string(coverage).expect("it is plain"));
        std::fs::write(file, text).expect("MYXO_WORKED is a folder that can be written");
    }
}

/// What all processes of the shared folder have seen and done.
fn of_all(folder: &Path) -> Coverage {
    let files = std::fs::read_dir(folder).expect("MYXO_WORKED is a folder");
    let coverage = files.map(|file| {
        let text = std::fs::read(file.expect("it can be listed").path()).expect("it can be read");
        serde_json::from_slice::<Coverage>(&text).expect("a process has written it")
    });
    coverage.fold(Coverage::default(), Coverage::with)
}

static COVERAGE: Mutex<Option<Coverage>> = Mutex::new(None);

fn with_coverage<T>(what: impl FnOnce(&mut Coverage) -> T) -> T {
    let mut coverage = COVERAGE.lock().unwrap_or_else(PoisonError::into_inner);
    what(coverage.get_or_insert_default())
}

/// The name that stands for all controls like this one.
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

/// Records what the lab has reported.
pub fn met(seen: &Value) {
    let Some(places) = seen["places"].as_object() else {
        return;
    };
    with_coverage(|coverage| {
        for name in places.keys() {
            let first = coverage.met.entry(kind_of(name));
            first.or_insert_with(|| name.clone());
        }
        if let Some(keys) = seen["values"]["help.keys"].as_str() {
            coverage.keys.extend(keys_of(keys));
        }
    });
}

/// The pointer is on this control, and one of its buttons has gone down.
pub fn control(name: &str) {
    with_coverage(|coverage| coverage.worked.insert(kind_of(name)));
}

/// These keys were pressed together.
pub fn key(name: &str) {
    with_coverage(|coverage| {
        coverage
            .worked
            .insert(format!("key {}", name.to_lowercase()))
    });
}

/// A test of this program, until its thread ends.
struct Begun {
    name: String,
}

impl Drop for Begun {
    fn drop(&mut self) {
        with_coverage(|coverage| coverage.ended.insert(std::mem::take(&mut self.name)));
    }
}

fn own_name() -> String {
    std::thread::current().name().unwrap_or_default().to_owned()
}

/// Registers the calling test: the check at the end waits for it, whether it passes or fails.
pub fn begins() {
    thread_local!(static BEGUN: Begun = Begun { name: own_name() });
    BEGUN.with(|_| {});
}

/// The keys that the help lists, named as in gestures.
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

/// Its name makes it the last test, so that one thread is enough for all. Tests that need a display may be left out.
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
        return eprintln!("skipped: {name} was not chosen, and the check needs all tests");
    }
    let own = others.pop_last().unwrap_or_default();
    assert!(own.ends_with("every_control_that_was_met_was_worked"));
    let missing = || {
        with_coverage(|coverage| {
            others
                .difference(&coverage.ended)
                .cloned()
                .collect::<Vec<_>>()
        })
    };
    // On a single thread, which is not named after a test, all others have ended.
    if own_name() == own {
        let begun = Instant::now();
        while !missing().is_empty() {
            assert!(begun.elapsed() < PATIENCE, "not ended: {:?}", missing());
            sleep(Duration::from_millis(200));
        }
    }
    with_coverage(|coverage| check(coverage));
}

fn check(coverage: &Coverage) {
    let Coverage {
        met, worked, keys, ..
    } = coverage;
    assert!(met.len() > 150 && keys.len() > 40, "{met:?}, {keys:?}");
    let not_worked: Vec<&String> = (met.iter())
        .filter(|(control, _)| !worked.contains(*control))
        .map(|(_, name)| name)
        .collect();
    let not_pressed: Vec<&String> = keys.difference(worked).collect();
    assert!(
        not_worked.is_empty() && not_pressed.is_empty(),
        "no test has worked {not_worked:?} or pressed {not_pressed:?}"
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
