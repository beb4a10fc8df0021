//! Control characters in names and values from files, and limits of the system that kill programs without a message.

use crate::program::{Folder, done, failure, myxo, path, program, text, with_files_up_to};

/// Asserts that there are no control characters and no overrides of direction, except for the program's own line breaks.
#[track_caller]
fn assert_plain(output: &[u8]) {
    let text = text(output);
    let left: Vec<char> = text
        .chars()
        .filter(|&c| c != '\n' && ::myxo::plain_text::is_control(c))
        .collect();
    assert!(left.is_empty(), "{text:?}");
}

/// Catches a message, a table, JSON or a log line that does not go through the one place that makes control characters visible.
/// The name of the file and that of the object hold the clearing of a screen, a bell, C1 and an override of the direction.
#[test]
fn no_control_character_of_a_file_reaches_a_terminal() {
    let folder = Folder::new();
    let odd = "a\u{1b}[2J\u{7}\u{9b}1m\u{202e}";
    let scene = |ending: &str, more: &str| {
        folder.with(
            format!("{odd}{ending}.toml"),
            format!(
                "[[object]]\nmesh = \"builtin:cube\"\nname = \"b\\u001b[31m\\u009b\\u2066\"\n{more}"
            ),
        )
    };
    let (good, bad, lacks) = (
        scene("1", ""),
        scene("2", "\"\\u001b]0;x\\u0007\" = 1\n"),
        scene("3", "distance_to = [\"\\u001b[2J\"]\n"),
    );
    let none = folder.file(format!("{odd}4.obj"));
    let size = ["--size", "64"];
    let mut outputs = 0;
    for (file, code) in [(&good, 0), (&bad, 1), (&lacks, 1), (&none, 1)] {
        let json = [&["atlas", path(file), "--json"], &size[..]].concat();
        let many = [&["atlas", path(file), "cube"], &size[..]].concat();
        let one = [&["atlas", path(file)], &size[..]].concat();
        for command in [json, many, one, vec!["scenes", path(file)]] {
            let output = program()
                .args(&command)
                .env("RUST_LOG", "debug")
                .output()
                .expect("the program starts");
            // `myxo scenes FILE` checks neither the names of objects nor their meshes, so its exit code may differ.
            if command[0] == "atlas" {
                assert_eq!(output.status.code(), Some(code), "{}", text(&output.stderr));
            }
            assert_plain(&output.stdout);
            assert_plain(&output.stderr);
            let said = text(&output.stdout) + &text(&output.stderr);
            outputs += usize::from(said.contains("\\u{1b}") || said.contains("\\u001b"));
        }
    }
    // Control characters are shown in escaped form, not left out.
    assert!(outputs >= 10, "{outputs}");
    // In data for programs the name is unchanged.
    let output = myxo(&[&["atlas", path(&good), "--json"], &size[..]].concat());
    let numbers: serde_json::Value = serde_json::from_slice(&output.stdout).expect("it is JSON");
    assert_eq!(numbers["scene"], format!("{odd}1"));
}

/// Catches a name of a file whose line breaks make it look like a message of its own.
#[test]
fn names_of_files_stay_on_their_line() {
    let folder = Folder::new();
    let text_of_scene =
        "[particles]\ncount = 100\n[atlas]\nsize = 64\n[[object]]\nmesh = \"builtin:cube\"\n";
    let file = folder.with("x\nmyxo: all is well.toml", text_of_scene);
    let picture = folder.file("a\nmyxo: all is well.png");
    let render = ["--steps", "1", "--size", "64x64", "--out", path(&picture)];
    for command in [
        [&["render", path(&file)], &render[..]].concat(),
        vec!["profile", path(&file), "--steps", "1", "--warmup", "0"],
        vec!["profile", path(&file), "--barriers", "--warmup", "0"],
        vec!["atlas", path(&file)],
    ] {
        let output = myxo(&command);
        let said = text(&output.stdout) + &text(&output.stderr);
        assert!(said.contains("x\\nmyxo: all is well"), "{said}");
        let fakes = said.lines().filter(|line| line.starts_with("myxo: all"));
        assert_eq!(fakes.count(), 0, "{said}");
    }
}

/// Catches names that a shell puts on the command line, which clap quotes as they are.
#[test]
fn no_control_character_of_the_command_line_reaches_a_terminal() {
    for command in [
        vec!["\u{1b}[2J"],
        vec!["render", "cube", "--steps", "\u{9b}2J"],
        vec!["atlas", "cube", "--\u{1b}]0;x\u{7}"],
    ] {
        let output = myxo(&command);
        assert_eq!(output.status.code(), Some(2));
        assert_plain(&output.stderr);
        assert!(text(&output.stderr).contains("error: "), "{command:?}");
    }
}

/// Catches the signal by which the system ends a program at the limit of file sizes: no message, and a hidden file is left.
#[cfg(unix)]
#[test]
fn the_limit_of_file_sizes_is_an_error_with_a_sentence() {
    let folder = Folder::new();
    let picture = folder.file("x.png");
    let arguments = [
        "atlas",
        "torus",
        "--size",
        "1024",
        "--fresh",
        "--out",
        path(&picture),
    ];
    let message = failure(&with_files_up_to(4, &arguments));
    let says = format!("myxo: cannot write {}: ", path(&picture));
    assert!(message.starts_with(&says), "{message}");
    assert!(
        message.contains("raise the limit of file sizes (`ulimit -f`)"),
        "{message}"
    );
    assert!(folder.names().is_empty(), "{:?}", folder.names());
    done(&arguments);
}

/// Catches the largest allowed texture on a machine with too little memory, where the system would kill the program.
#[cfg(target_os = "linux")]
#[test]
fn an_atlas_that_memory_does_not_hold_is_refused_at_once() {
    let memory = std::fs::read_to_string("/proc/meminfo").expect("it is Linux");
    let line = memory
        .lines()
        .find(|line| line.starts_with("MemAvailable:"));
    let number = line.and_then(|line| line.split_whitespace().nth(1));
    let kibibytes: u64 = number.and_then(|number| number.parse().ok()).unwrap_or(0);
    if kibibytes >> 20 >= 22 {
        return;
    }
    let begun = std::time::Instant::now();
    for (command, option) in [
        (vec!["atlas", "cube", "--size", "32768"], "--size"),
        (
            vec!["atlas", "cube", "--set", "atlas.size=32768"],
            "atlas.size",
        ),
        (
            vec![
                "query",
                "atlas",
                "--mesh",
                "builtin:cube",
                "--atlas-size",
                "32768",
            ],
            "--atlas-size",
        ),
    ] {
        let message = failure(&myxo(&command));
        let says = format!(
            "myxo: {option} 32768: making an atlas of 32,768 x 32,768 texels takes about 20.0 GiB"
        );
        assert!(message.starts_with(&says), "{message}");
        assert!(message.contains(&format!("use {option} ")), "{message}");
    }
    assert!(begun.elapsed().as_secs() < 20);
}
