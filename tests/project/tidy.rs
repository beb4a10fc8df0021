//! The shape of the project, checked: layers, files that use each other one way, file headers, the programs of tests, a twin for
//! every kernel, and which files use twins.

use std::fs;
use std::path::{Path, PathBuf};

use super::uses::cycles;

fn files(folder: &str, endings: &[&str]) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path
                .extension()
                .is_some_and(|e| endings.iter().any(|ending| e == *ending))
            {
                let text = fs::read_to_string(&path).unwrap();
                found.push((
                    path.strip_prefix(env!("CARGO_MANIFEST_DIR"))
                        .unwrap()
                        .to_owned(),
                    text,
                ));
            }
        }
    }
    assert!(!found.is_empty(), "no files in {folder}");
    found.sort();
    found
}

/// The layers, lowest first; a layer uses only those in earlier rows. `mesh` and `gpu` share a row: neither uses
/// the other.
const LAYERS: &[&[&str]] = &[
    &[
        "choice",
        "commit",
        "error",
        "kept_files",
        "portable",
        "regular_file",
        "rng",
        "whole_file",
    ],
    &["mesh", "gpu"],
    &["scene"],
    &["sim"],
    &["render"],
    &["export"],
    &["sweep"],
    &["python"],
];

fn rank(layer: &str) -> Option<usize> {
    LAYERS.iter().position(|row| row.contains(&layer))
}

#[test]
fn layers_use_only_those_below() {
    let mut wrong = Vec::new();
    for (path, text) in files("src", &["rs"]) {
        let mut parts = path
            .components()
            .skip(1)
            .map(|c| c.as_os_str().to_str().unwrap());
        let layer = parts.next().unwrap().trim_end_matches(".rs").to_owned();
        // The error gathers what every layer reports; the executable's parts use everything.
        let Some(own) = rank(&layer).filter(|_| layer != "error") else {
            continue;
        };
        for (number, line) in text
            .lines()
            .enumerate()
            .filter(|(_, line)| !line.trim_start().starts_with("//"))
        {
            for used in line.split("crate::").skip(1) {
                let used = used
                    .split(|c: char| !c.is_alphanumeric() && c != '_')
                    .next()
                    .unwrap();
                if rank(used)
                    .is_some_and(|rank| rank > own || (rank == own && used != layer && own > 0))
                {
                    wrong.push(format!(
                        "{}:{}: {layer} uses {used}",
                        path.display(),
                        number + 1
                    ));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// What the command line and the window both need stands beside them.
#[test]
fn only_one_command_uses_the_window_which_uses_no_command() {
    let uses = |folder: &str, what: &str| -> Vec<String> {
        let all = files(folder, &["rs"]).into_iter();
        all.filter(|(_, text)| text.contains(what))
            .map(|(path, _)| path.display().to_string())
            .collect()
    };
    assert_eq!(uses("src/cli", "crate::lab"), ["src/cli/lab.rs"]);
    assert_eq!(uses("src/lab", "crate::cli"), [""; 0]);
}

#[test]
fn files_say_what_they_are_for() {
    for (path, text) in files("src", &["rs"])
        .into_iter()
        .chain(files("tests", &["rs"]))
        .chain(files("benches", &["rs"]))
        .chain(files("examples", &["rs"]))
    {
        assert!(
            text.starts_with("//! "),
            "{} does not begin with what it is for",
            path.display()
        );
    }
    for (path, text) in files("shaders", &["comp", "vert", "frag", "glsl"]) {
        let name = path.file_stem().unwrap().to_str().unwrap();
        assert!(
            text.starts_with(&format!("// {name}: ")),
            "{} does not begin with `// {name}: `",
            path.display()
        );
    }
}

/// Such a file would not be found anywhere else.
#[test]
fn files_name_no_place_of_one_machine() {
    for (folder, endings) in [
        ("src", &["rs"][..]),
        ("tests", &["rs"]),
        ("benches", &["rs"]),
        ("examples", &["rs"]),
        ("shaders", &["comp", "vert", "frag", "glsl"]),
    ] {
        for (path, text) in files(folder, endings) {
            for place in ["work", "root"].map(|folder| format!("/{folder}/")) {
                assert!(!text.contains(&place), "{} names {place}", path.display());
            }
        }
    }
}

/// Folders whose files use each other one way only.
const ONE_WAY: &[&str] = &["src/gpu", "src/sim", "src/lab"];

/// A file can be read, tested and changed with those below it in mind, and without those above.
#[test]
fn files_use_each_other_one_way() {
    let mut wrong = Vec::new();
    for folder in ONE_WAY {
        wrong.extend(cycles(folder, &files(folder, &["rs"])));
    }
    assert!(
        wrong.is_empty(),
        "these files use each other in a circle: move what both need into a file below both\n{}",
        wrong.join("\n")
    );
}

/// The programs that tests are built into, and what belongs there. Each is linked separately, so there are few.
const PROGRAMS: &[(&str, &str)] = &[
    ("kernels", "kernels against their twins"),
    ("simulation", "what holds over many steps"),
    ("mesh", "meshes without Vulkan"),
    ("command_line", "the program as people run it"),
    ("pictures", "what pictures show"),
    ("project", "the project's shape, documents and build"),
    ("window", "the window, with a hand on it"),
];

#[test]
fn tests_belong_to_one_of_the_few_programs() {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let cargo = fs::read_to_string(tests.with_file_name("Cargo.toml")).unwrap();
    assert!(
        !cargo.contains("[[test]]"),
        "Cargo.toml names a test program of its own: make it a module of one in tests/"
    );
    let mut wrong = Vec::new();
    for entry in fs::read_dir(&tests).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        let is_known = PROGRAMS.iter().any(|(program, _)| *program == name);
        if name.ends_with(".rs") || (path.join("main.rs").is_file() && !is_known) {
            wrong.push(name);
        }
    }
    let places: Vec<_> = PROGRAMS
        .iter()
        .map(|(program, what)| format!("  tests/{program}/: {what}"))
        .collect();
    assert!(
        wrong.is_empty(),
        "tests/ has {wrong:?}, each a program of its own: make it a module of one of these, and name it in its main.rs\n{}",
        places.join("\n")
    );
    for (program, _) in PROGRAMS {
        let is_there = tests.join(program).join("main.rs").is_file();
        assert!(
            is_there,
            "tests/{program} is no program any more: take it out of the list"
        );
    }
}

/// A list of words in a shell script: `NAME=(WORD WORD)`.
fn list_of(script: &str, name: &str) -> Vec<String> {
    let begin = format!("\n{name}=(");
    let rest = script.split(&begin).nth(1).expect(name);
    let words = rest.split(')').next().unwrap_or_default();
    words.split_whitespace().map(str::to_owned).collect()
}

/// Elsewhere a test would look for its files in a folder that is not there, and fail as if the device were at fault.
#[test]
fn tests_that_are_packed_find_what_is_packed_with_them() {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join(".ci/bundle");
    let script = fs::read_to_string(script).unwrap();
    let (programs, packed) = (list_of(&script, "programs"), list_of(&script, "files"));
    let mut sources = files("src/gpu", &["rs"]);
    for folder in programs
        .iter()
        .map(String::as_str)
        .chain(["common", "program"])
    {
        sources.extend(files(&format!("tests/{folder}"), &["rs"]));
    }
    let mut named = 0;
    for (path, text) in sources {
        for (number, line) in (1..).zip(text.lines()) {
            let place = format!("{}:{number}", path.display());
            let may = path.ends_with("common/places.rs") || line.starts_with("const BUILT: ");
            assert!(
                may || !line.contains("env!(\"CARGO"),
                "{place}: use tests/common/places.rs, which also finds the files of an unpacked archive"
            );
            let Some(rest) = line.split("root().join(\"").nth(1) else {
                continue;
            };
            let file = rest.split('"').next().unwrap_or_default().to_owned();
            assert!(
                packed.contains(&file),
                "{place}: .ci/bundle does not pack {file}"
            );
            named += 1;
        }
    }
    assert!(named >= 2, "files that tests read are found");
}

/// Lines that sleep for a fixed time: in no loop, which could look at what is waited for.
fn fixed_sleeps(text: &str) -> Vec<usize> {
    let call = ["sl", "eep("].concat();
    let lines: Vec<&str> = text.lines().collect();
    let indent = |line: &str| line.len() - line.trim_start().len();
    let is_in_a_loop = |number: usize| {
        let mut outer = indent(lines[number]);
        for line in lines[..number].iter().rev() {
            let word = line.trim_start();
            if word.is_empty() || indent(line) >= outer {
                continue;
            }
            outer = indent(line);
            let is_loop = ["while ", "loop {"]
                .iter()
                .any(|begin| word.contains(begin));
            if is_loop || word.contains("fn ") {
                return is_loop;
            }
        }
        false
    };
    let sleeps = |number: &usize| {
        let line = lines[*number].trim_start();
        !line.starts_with("//") && !line.starts_with("use ") && line.contains(&call)
    };
    let numbers = (0..lines.len()).filter(sleeps);
    numbers
        .filter(|number| !is_in_a_loop(*number))
        .map(|number| number + 1)
        .collect()
}

/// The offset of a file's tests; its length if it has none.
fn first_of_tests(path: &Path, text: &str) -> usize {
    if path.ends_with("tests.rs") || path.iter().any(|part| part == "tests") {
        return 0;
    }
    let begin = text.find("#[cfg(test)]\nmod tests {");
    begin.unwrap_or(text.len())
}

/// A fixed time is too short on one machine and too long on all others.
#[test]
fn tests_wait_for_conditions_and_not_for_times() {
    // What waits in a loop in the caller, and what measures how long a window takes at any time of a step.
    const MAY: [&str; 2] = [
        "tests/window/real/display.rs",
        "tests/window/real/window_times.rs",
    ];
    let mut wrong = Vec::new();
    let mut look = |path: &Path, text: &str, first_line: usize| {
        for line in fixed_sleeps(text) {
            wrong.push(format!("{}:{}", path.display(), first_line + line));
        }
    };
    for (path, text) in files("tests", &["rs"]) {
        if !MAY.iter().any(|may| path.ends_with(may)) {
            look(&path, &text, 0);
        }
    }
    for (path, text) in files("src", &["rs"]) {
        let tests = first_of_tests(&path, &text);
        let before = text[..tests].lines().count();
        look(&path, &text[tests..], before);
    }
    assert!(
        wrong.is_empty(),
        "these sleep for a fixed time; `wait_until` of tests/program/mod.rs waits for a condition instead:\n{}",
        wrong.join("\n")
    );
    let text = "fn a() {\n    while b() {\n        if c() {\n            CALL(D);\n        }\n    }\n    CALL(D);\n}\n";
    let text = text.replace("CALL", &["sl", "eep"].concat());
    assert_eq!(fixed_sleeps(&text), [7]);
}

/// Calls whose last bits are those of the system's library, or of the processor's instructions.
const NOT_PORTABLE: &[&str] = &[
    ".sin(",
    ".cos(",
    ".tan(",
    ".sin_cos(",
    ".asin(",
    ".acos(",
    ".atan(",
    ".atan2(",
    ".sinh(",
    ".cosh(",
    ".tanh(",
    ".exp(",
    ".exp2(",
    ".exp_m1(",
    ".ln(",
    ".ln_1p(",
    ".log(",
    ".log2(",
    ".log10(",
    ".powf(",
    ".powi(",
    ".hypot(",
    ".cbrt(",
    ".mul_add(",
    "from_angle",
    "angle_between",
    "angle_to",
    "to_angle",
    "from_axis_angle",
    "from_scaled_axis",
    "from_euler",
    "from_rotation_x",
    "from_rotation_y",
    "from_rotation_z",
    "slerp",
];

/// Lines of code that call what is not portable. A function of `portable` may have the name of one.
fn calls_that_differ(text: &str) -> Vec<usize> {
    let mut found = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let code = line.split("//").next().unwrap_or_default();
        let is_use = code.trim_start().starts_with("use crate::portable::");
        let calls = |name: &&&str| {
            code.match_indices(**name).any(|(at, _)| {
                name.starts_with('.') || code[..at].ends_with("::") || code[..at].ends_with('.')
            })
        };
        if !is_use && NOT_PORTABLE.iter().any(|name| calls(&name)) {
            found.push(number);
        }
    }
    found
}

/// What decides a state has the same bits on every machine.
#[test]
fn what_decides_a_state_is_portable() {
    let mut wrong = Vec::new();
    for folder in ["src/sim", "src/mesh", "src/scene"] {
        for (path, text) in files(folder, &["rs"]) {
            // Such a file is a module of tests by what its parent says.
            let name = path.file_stem().unwrap().to_str().unwrap();
            let parent = path.with_file_name("mod.rs");
            let parent = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(parent));
            let is_of_tests = format!("#[cfg(test)]\nmod {name};");
            if parent.is_ok_and(|parent| parent.contains(&is_of_tests)) {
                continue;
            }
            let calls = calls_that_differ(&text[..first_of_tests(&path, &text)]);
            wrong.extend((calls.iter()).map(|line| format!("{}:{line}", path.display())));
        }
    }
    assert!(
        wrong.is_empty(),
        "take the functions of src/portable.rs, or products and roots:\n{}",
        wrong.join("\n")
    );
    let text = "let a = x.sin();\n// x.sin()\nlet b = sin(x);\nuse crate::portable::{angle_between};\nangle_between(a, b)\n\
        a.angle_between(b)\nDVec2::from_angle(a)\nx.sinking()\n";
    assert_eq!(calls_that_differ(text), [1, 6, 7]);
}

#[test]
fn every_kernel_has_a_twin_and_a_mutant() {
    let mut sources = files("src", &["rs"]);
    sources.extend(files("examples", &["rs"]));
    let mutants =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/mutants.tsv"))
            .unwrap();
    for line in mutants.lines().filter(|line| !line.starts_with('#')) {
        let [path, original, replacement] = line.split('\t').collect::<Vec<_>>()[..] else {
            panic!("not three columns: {line}");
        };
        let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap();
        let times = text.matches(original).count();
        assert_eq!(times, 1, "{path} has `{original}` {times} times");
        assert_ne!(original, replacement);
    }
    for (path, text) in files("shaders", &["comp"]) {
        let path = path.to_str().unwrap();
        // Those test the gpu layer, not the other way round.
        if path.contains("selftest") {
            continue;
        }
        let twin = format!("Twin of `{path}`");
        assert!(
            sources.iter().any(|(_, text)| text.contains(&twin)),
            "nothing is the \"{twin}\""
        );
        assert!(
            mutants.lines().any(|line| line.starts_with(path)),
            "{path} has no line in tests/mutants.tsv"
        );
        assert!(
            text.lines()
                .any(|line| line.starts_with("layout(") && line.contains("local_size_x")),
            "{path} states no group size"
        );
        // What is counted on the device bounds some.
        let bounds = [
            ">= params.",
            ">= gl_WorkGroupSize",
            ">= flow[0].",
            ">= groups[1].",
            // `slot_of` has bounds.
            "if (i == NONE",
        ];
        assert!(
            bounds.iter().any(|bound| text.contains(bound)) && text.contains("return;"),
            "{path} does not begin with its bounds"
        );
    }
}

/// Lines of code that name the module of twins: in a path, or anywhere in a `use`, which may have several lines. The twin of a
/// half-edge is a field or a variable, and no path.
fn uses_of_twins(text: &str) -> Vec<usize> {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let mut found = Vec::new();
    let mut is_use = false;
    for (number, line) in (1..).zip(text.lines()) {
        let code = line.split("//").next().unwrap_or_default().trim_start();
        is_use |= code.starts_with("use ") || (code.starts_with("pub") && code.contains(" use "));
        let names = code.match_indices("twin").any(|(at, word)| {
            let (before, after) = (&code[..at], &code[at + word.len()..]);
            let is_word = !before.ends_with(is_part) && !after.starts_with(is_part);
            is_word && (is_use || after.starts_with("::"))
        });
        if names {
            found.push(number);
        }
        is_use &= !code.contains(';');
    }
    found
}

/// Lines that name a function in the file of a kernel of the step: beside types and constants these are twins.
fn functions_of_kernels(text: &str) -> Vec<usize> {
    let lines: Vec<&str> = text.lines().collect();
    let code_of = |line: &str| line.split("//").next().unwrap_or_default().to_owned();
    let mut found = Vec::new();
    for (i, line) in lines.iter().enumerate() {
        let mut code = code_of(line);
        let is_use = code.contains("use ");
        // A `use` may continue.
        let mut rest = lines[i + 1..].iter();
        while is_use && !code.contains(';') {
            let Some(line) = rest.next() else { break };
            code += code_of(line).trim();
        }
        let Some(path) = code.split("step::").nth(1) else {
            continue;
        };
        let names = match path.split_once("::") {
            // A whole module: its functions could be called by its name.
            None => is_use && path.trim_end_matches(';') != "step",
            Some((_, items)) => {
                let mut items = items.trim_start_matches('{').split(',').map(str::trim);
                items.any(|item| item.starts_with(char::is_lowercase))
            }
        };
        if names {
            found.push(i + 1);
        }
    }
    found
}

/// Twins are what tests compare the program with. If the program took an answer from a twin, that test would compare the twin
/// with itself and pass whatever the answer is; only this test fails.
#[test]
fn no_production_file_uses_a_twin() {
    let mut wrong = Vec::new();
    for (path, text) in files("src", &["rs"]) {
        // What compares the two engines runs both.
        let compares = ["src/sim/beside.rs", "src/cli/selftest.rs"];
        if path.starts_with("src/sim/twin") || compares.iter().any(|file| path == Path::new(file)) {
            continue;
        }
        let production = &text[..first_of_tests(&path, &text)];
        // An engine calls them by the trait that all kernels of a step have, and by no path.
        let by_trait = path == Path::new("src/sim/work.rs");
        for line in uses_of_twins(production) {
            let line_of_code = production.lines().nth(line - 1).unwrap_or_default();
            if !(by_trait && line_of_code.contains("K::twin(")) {
                wrong.push(format!("{}:{line}", path.display()));
            }
        }
        if !path.starts_with("src/sim/step") {
            for line in functions_of_kernels(production) {
                wrong.push(format!("{}:{line}", path.display()));
            }
        }
    }
    assert!(
        wrong.is_empty(),
        "these use twins; what the program needs of them goes into a module outside of src/sim/twin, which both use:\n{}",
        wrong.join("\n")
    );
    let text = "use crate::sim::twin;\nuse super::{\n    setup, // twin\n    twin,\n};\nlet twin = edge.twin;\n// twin::walk\n\
        super::twin::walk(twin);\nlet twins = between::a;\npub use crate::sim::twin::paint;\n";
    assert_eq!(uses_of_twins(text), [1, 4, 8, 10]);
    let text = "use super::step::advance::{Form, FORMS_OF_ADVANCE};\nuse crate::sim::step::digest::digest;\n\
        use crate::sim::step::advance::{Form, advance};\nlet a = step::step(plan);\nuse super::step::step;\n\
        use super::step::sort;\nuse super::step::advance::{\n    Form,\n    advance,\n};\n";
    assert_eq!(functions_of_kernels(text), [2, 3, 6, 7]);
}

/// What `make atlases` has written last is what the README shows.
#[test]
fn the_readme_quotes_the_table_of_layouts() {
    let file = |name: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
        fs::read_to_string(path).unwrap()
    };
    let table = file("benches/results/atlases.md");
    assert!(table.lines().count() > 8, "it has a line for each mesh");
    assert!(
        file("README.md").contains(table.trim_end()),
        "copy benches/results/atlases.md into the README's chapter on the world atlas"
    );
}

/// The README names every view of the program, and no other.
#[test]
fn the_readme_names_the_views_of_the_program() {
    use myxo::scene::settings::Show;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md");
    let readme = fs::read_to_string(path).unwrap();
    let table = readme.split("| view | shows |").nth(1).unwrap();
    let rows = table
        .lines()
        .skip(2)
        .take_while(|line| line.starts_with('|'));
    let mut named: Vec<&str> = rows
        .flat_map(|row| row.split('|').nth(1).unwrap().split(','))
        .map(|name| name.trim().trim_matches('`'))
        .collect();
    let mut known = Show::WORDS.to_vec();
    named.sort_unstable();
    known.sort_unstable();
    assert_eq!(named, known, "the README's table of views");
    for preset in myxo::scene::builtin::PRESETS {
        let name = format!("`{}`", preset.name);
        assert!(readme.contains(&name), "the README lacks the preset {name}");
    }
}

/// What a control is called for tests: a literal, or the literal beginning of a name that is put together.
fn names_of_controls() -> Vec<(PathBuf, String)> {
    let mut names = Vec::new();
    for (path, text) in files("src/lab", &["rs"]) {
        let text = text.replace("mark_cross(shown, ", ".marked(");
        for part in text.split(".marked(").skip(1) {
            let Some(literal) = part.trim_start_matches("&format!(").strip_prefix('"') else {
                continue;
            };
            let name = literal.split(['"', '{']).next().unwrap_or_default();
            if !name.is_empty() {
                names.push((path.clone(), name.to_owned()));
            }
        }
    }
    names
}

/// A control that is new has a step in a test of the window, in which a hand operates it.
#[test]
fn no_control_is_left_out_by_the_tests_of_the_window() {
    let steps: String = files("tests/window", &["rs"])
        .into_iter()
        // This names controls and operates none.
        .filter(|(path, _)| !path.ends_with("worked.rs"))
        .map(|(_, text)| text)
        .collect();
    let names = names_of_controls();
    assert!(names.len() > 40, "they are found: {names:?}");
    let left_out: Vec<_> = names
        .iter()
        .filter(|(_, name)| !steps.contains(&format!("\"{name}")))
        .collect();
    assert!(
        left_out.is_empty(),
        "no step of tests/window operates {left_out:?}"
    );
}

/// Years that the comments of a file cite with a name, `Name 1985`, `Name (1985)` or `Name, "Title", 1985`: the year, and the names in the
/// words before it.
fn citations(text: &str) -> Vec<(String, Vec<String>)> {
    let is_name = |word: &str| {
        let mut letters = word.chars();
        word.chars().count() > 2
            && letters.next().is_some_and(char::is_uppercase)
            && letters.all(char::is_lowercase)
    };
    let is_year = |word: &str| {
        word.len() == 4
            && word.bytes().all(|b| b.is_ascii_digit())
            && ["19", "20"].contains(&&word[..2])
    };
    let of_comment = |line: &str| {
        let comment = line.trim().strip_prefix("//")?;
        Some(comment.trim_start_matches(['/', '!']).to_owned())
    };
    let of_line = |line: &str| of_comment(line).unwrap_or_else(|| "|".to_owned());
    let lines: Vec<String> = text.lines().map(of_line).collect();
    let lines = lines.join(" ");
    let words: Vec<&str> = lines.split_whitespace().collect();
    let mut found = Vec::new();
    for (i, word) in words.iter().enumerate() {
        let word = word.trim_matches(['(', ')', '.', ',', ';', ':']);
        if i == 0 || !is_year(word) {
            continue;
        }
        let before = &words[i.saturating_sub(15)..i];
        let start = before.iter().rposition(|word| *word == "|");
        let before = &before[start.map_or(0, |start| start + 1)..];
        let Some(last) = before.last() else { continue };
        let last = last.trim_start_matches('(').trim_end_matches(',');
        if !(is_name(last) || last == "al." || last.ends_with('"')) {
            continue;
        }
        let bare = before
            .iter()
            .map(|word| word.trim_matches(['(', ')', ',', '"']));
        let names = bare.filter(|word| is_name(word)).map(str::to_owned);
        found.push((word.to_owned(), names.collect()));
    }
    found
}

/// Would catch: a formula whose source the code names, and the documents do not.
#[test]
fn sources_that_comments_cite_are_in_the_table() {
    let table = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/code.md"));
    let table = table.unwrap();
    let (_, table) = table.split_once("## References").unwrap();
    let rows: Vec<&str> = table
        .lines()
        .filter(|line| line.starts_with("| "))
        .collect();
    let has = |year: &str, names: &[String]| {
        let mut of_year = rows.iter().filter(|row| row.contains(year));
        of_year.any(|row| names.iter().any(|name| row.contains(name.as_str())))
    };
    let mut count = 0;
    let mut missing = Vec::new();
    let sources = files("src", &["rs"]).into_iter();
    for (path, text) in sources.chain(files("shaders", &["comp", "glsl", "vert", "frag"])) {
        for (year, names) in citations(&text) {
            count += 1;
            if !has(&year, &names) {
                missing.push((path.clone(), year, names));
            }
        }
    }
    assert!(count > 40, "they are found: {count}");
    assert!(missing.is_empty(), "docs/code.md has no row of {missing:?}");
    // The forms in which they are cited.
    let text = "/// One (Shoemake 1985), as Jones\n/// (2010) and Serra, \"On it\", 1982.\nlet x = 1982;\n// In 1999.\n";
    let years: Vec<String> = citations(text).into_iter().map(|(year, _)| year).collect();
    assert_eq!(years, ["1985", "2010", "1982"]);
}
