//! Texts and assignments become settings, or messages.

use std::path::Path;

use crate::scene::builtin::PRESETS;
use crate::scene::file::Reader;
use crate::scene::parameters::{
    Kind, OBJECT_PARAMETERS, PARAMETERS, PULSE_PARAMETERS, Parameter, out_of_range,
};
use crate::scene::settings::{Border, ObjectSettings, Settings, Show, Start};

fn read(text: &str) -> Result<Settings, Vec<String>> {
    let mut reader = Reader::new(Settings::default());
    reader.text("", text);
    finish(reader)
}

fn set(assignments: &[&str]) -> Result<Settings, Vec<String>> {
    let mut reader = Reader::new(Settings::default());
    for assignment in assignments {
        reader.assignment(assignment);
    }
    finish(reader)
}

fn finish(reader: Reader) -> Result<Settings, Vec<String>> {
    reader
        .finish()
        .map_err(|problems| problems.iter().map(ToString::to_string).collect())
}

fn only_problem(result: Result<Settings, Vec<String>>) -> String {
    let problems = result.expect_err("something is wrong");
    assert_eq!(problems.len(), 1, "{problems:#?}");
    problems.into_iter().next().expect("there is one")
}

/// Moves a value away from where it is, staying in its range.
fn nudge<T>(parameter: &Parameter<T>, target: &mut T) {
    match &parameter.kind {
        Kind::Number(number) => {
            let (low, high) = number.slider;
            let middle = if number.integer {
                ((low + high) / 2.0).floor()
            } else {
                low * 0.375 + high * 0.625
            };
            let value = if (number.get)(target) == middle {
                high
            } else {
                middle
            };
            (number.set)(target, value);
        }
        Kind::Choice { words, get, set } => set(target, (get(target) + 1) % words.len()),
        Kind::Own(own) => {
            let middle = own.slider.0 * 0.375 + own.slider.1 * 0.625;
            (own.set)(target, (own.get)(target).is_none().then_some(middle));
        }
        Kind::Text { get, set, .. } => {
            let text = format!("{} ä\"b", get(target));
            set(target, text);
        }
        Kind::Vector {
            range, get, set, ..
        } => {
            set(
                target,
                get(target).map(|c| (c + 0.125).clamp(range.0, range.1)),
            );
        }
    }
}

#[test]
fn every_parameter_round_trips_through_a_file() {
    let mut settings = Settings::default();
    settings.objects.push(ObjectSettings {
        name: "a \"quoted\" name".into(),
        mesh: "models/ä b.glb".into(),
        ..ObjectSettings::default()
    });
    for parameter in PARAMETERS {
        nudge(parameter, &mut settings);
    }
    for parameter in OBJECT_PARAMETERS {
        nudge(parameter, &mut settings.objects[1]);
    }
    // Every word has another one to change to.
    let defaults = Settings::default();
    let unchanged: Vec<_> = PARAMETERS
        .iter()
        .filter(|p| !p.differs(&settings, &defaults))
        .map(|p| p.key)
        .collect();
    assert_eq!(unchanged, [""; 0]);

    assert_eq!(read(&settings.to_toml()), Ok(settings));
}

/// Would catch: late times in single precision, which are 8 ms apart there.
#[test]
fn a_late_time_keeps_its_digits() {
    let settings = set(&["time.start=100000.0123"]).unwrap();
    assert_eq!(settings.time.start, 100_000.012_3);
    let start = (PARAMETERS.iter()).find(|parameter| parameter.key == "time.start");
    assert_eq!(start.unwrap().value(&settings), "100000.0123");
    assert_eq!(read(&settings.to_toml()), Ok(settings));
}

#[test]
fn files_show_numbers_as_people_write_them() {
    let text = Settings::default().to_toml();
    for line in [
        "speed = 0.004",
        "decay = 0.95",
        "count = 500000",
        "position = [0.0, 0.0, 0.0]",
        "[[object]]",
    ] {
        assert!(text.lines().any(|l| l == line), "{line} in\n{text}");
    }
}

/// Every leaf of the written file is in the table, and every row of the table is in the file.
#[test]
fn the_table_and_the_file_have_the_same_keys() {
    fn leaves(prefix: &str, table: &toml::Table, found: &mut Vec<String>) {
        for (key, value) in table {
            match value {
                toml::Value::Table(inner) => leaves(&format!("{prefix}{key}."), inner, found),
                _ if key == "object" => {
                    let first = value[0].as_table().expect("objects are tables");
                    leaves("object.", first, found);
                }
                _ => found.push(format!("{prefix}{key}")),
            }
        }
    }
    // Files have only the set values of motion and of an object's own parameters.
    let mut settings = Settings::default();
    for parameter in OBJECT_PARAMETERS {
        nudge(parameter, &mut settings.objects[0]);
    }
    let table: toml::Table = settings
        .to_toml()
        .parse()
        .expect("what is written can be read");
    let mut in_file = Vec::new();
    leaves("", &table, &mut in_file);
    let mut in_table: Vec<String> = PARAMETERS.iter().map(|p| p.key.to_owned()).collect();
    in_table.extend(
        OBJECT_PARAMETERS
            .iter()
            .map(|p| format!("object.{}", p.key)),
    );
    let others = ["name", "mesh", "distance_to", "motion.keyframes"];
    in_table.extend(others.map(|key| format!("object.{key}")));
    in_file.sort();
    in_table.sort();
    assert_eq!(in_file, in_table);
}

#[test]
fn defaults_are_in_range_and_documented() {
    assert_eq!(out_of_range(&Settings::default()), []);
    for parameter in PARAMETERS {
        assert!(parameter.help.ends_with('.'), "{}", parameter.key);
        if let Kind::Number(number) = &parameter.kind {
            assert!(
                number.allows(number.slider.0) && number.allows(number.slider.1),
                "{}",
                parameter.key
            );
            assert!(number.slider.0 < number.slider.1, "{}", parameter.key);
        }
    }
}

/// Catches sliders that do not cover a built-in value: dragging would lose it.
#[test]
fn sliders_have_what_presets_say() {
    for preset in PRESETS {
        let mut reader = Reader::new(Settings::default());
        reader.preset("", preset.text);
        let settings = finish(reader).expect("it is right");
        for parameter in PARAMETERS {
            if let Kind::Number(number) = &parameter.kind {
                let value = (number.get)(&settings);
                let (low, high) = number.slider;
                let setting = format!("{}: {} = {value}", preset.name, parameter.key);
                assert!(low <= value && value <= high, "{setting}");
            }
        }
    }
    // Objects' own values are checked in the same files.
    for own in OBJECT_PARAMETERS {
        let shared = PARAMETERS.iter().find(|shared| shared.key == own.key);
        if let (Kind::Own(own_kind), Some(Kind::Number(shared))) =
            (&own.kind, shared.map(|shared| &shared.kind))
        {
            assert_eq!(own_kind.slider, shared.slider, "{}", own.key);
        }
    }
}

#[test]
fn an_empty_file_is_the_default_scene() {
    assert_eq!(read(""), Ok(Settings::default()));
}

#[test]
fn mistyped_keys_are_named_with_their_line_and_the_nearest_right_one() {
    let problem = only_problem(read("seed = 1\n\n[trail]\ndecya = 0.9\n"));
    assert_eq!(
        problem,
        "line 4: trail.decya: no such key; did you mean trail.decay?"
    );
    let problem = only_problem(read("[[objct]]\n"));
    assert!(problem.contains("did you mean object?"), "{problem}");
    let problem = only_problem(read("[physarun]\nspeed = 1\n"));
    assert_eq!(
        problem,
        "line 1: [physarun]: no such section; did you mean [physarum]?"
    );
    let problem = only_problem(read("[objekt]\nmesh = \"builtin:cube\"\n"));
    assert_eq!(
        problem,
        "line 1: [objekt]: no such section; did you mean [[object]]?"
    );
    let problem = only_problem(read(
        "[[object]]\nposition = [0, 0, 0]\n[[object]]\nmehs = \"x\"\n",
    ));
    assert_eq!(
        problem,
        "line 4: object.1.mehs: no such key; did you mean object.1.mesh?"
    );
    // The right word in the wrong section.
    let problem = only_problem(read("[trail]\nspeed = 0.1\n"));
    assert_eq!(
        problem,
        "line 2: trail.speed: no such key; did you mean physarum.speed?"
    );
    // No key is similar.
    let problem = only_problem(read("[trail]\nxyzzyq = 0.1\n"));
    assert_eq!(
        problem,
        "line 2: trail.xyzzyq: no such key; `myxo scenes --keys` lists all of them"
    );
}

#[test]
fn wrong_types_are_named_with_their_line() {
    let cases = [
        (
            "seed = \"a\"",
            "line 1: seed: a whole number is expected, not the text \"a\"",
        ),
        (
            "seed = 1.5",
            "line 1: seed: a whole number is expected, not 1.5",
        ),
        (
            "[particles]\ncount = true",
            "line 2: particles.count: a whole number is expected, not true",
        ),
        (
            "[trail]\ndecay = [1]",
            "line 2: trail.decay: a number is expected, not a list of 1",
        ),
        (
            "[physarum]\nborder = 3",
            "line 2: physarum.border: a word (reflect or stop) is expected, not 3",
        ),
        (
            "[physarum]\nborder = \"relfect\"",
            "line 2: physarum.border = \"relfect\": it can be reflect or stop; did you mean reflect?",
        ),
        (
            "[picture]\ncolor_map = \"virids\"",
            "line 2: picture.color_map = \"virids\": it can be myxo, viridis, magma, inferno, plasma, ice, moss or grayscale; did you mean viridis?",
        ),
        (
            "[[object]]\nposition = [0, 1]",
            "line 2: object.0.position: a list of three numbers is expected, not a list of 2",
        ),
        (
            "[[object]]\nmesh = 7",
            "line 2: object.0.mesh: a text is expected, not 7",
        ),
        (
            "[object]\nmesh = \"x\"",
            "line 1: object: [[object]] is expected, once for each object",
        ),
        (
            "trail = 3",
            "line 1: trail is a section, with keys such as trail.diffusion",
        ),
        (
            "seed = 1979-05-27",
            "line 1: seed: a whole number is expected, not a date",
        ),
    ];
    for (text, expected) in cases {
        assert_eq!(only_problem(read(text)), expected, "{text}");
    }
}

#[test]
fn broken_toml_is_named_with_its_line() {
    let problem = only_problem(read("seed = 1\n[trail\ndecay = 1\n"));
    assert!(problem.starts_with("line 2: not valid TOML: "), "{problem}");
    assert!(!problem.contains('\n'), "{problem}");
    let problem = only_problem(read("seed = 1\nseed = 2\n"));
    assert!(
        problem.starts_with("line 2: not valid TOML: ") && problem.contains("duplicate"),
        "{problem}"
    );
}

#[test]
fn everything_wrong_is_in_one_error() {
    let text = "seed = 4294967296\n[particles]\ncount = -5\n[trail]\ndecay = 1.5\ndiffusion = nan\n\
        diffusion_distance = 5\ncolour = 1\n[[object]]\nscale = 0\nposition = [1e30, 0, 0]\n";
    let problems = read(text).expect_err("much is wrong");
    assert_eq!(
        problems,
        [
            "line 1: seed = 4294967296 is out of range: whole numbers 0 to 4,294,967,295",
            "line 3: particles.count = -5 is out of range: whole numbers 1 to 1,073,741,824 particles",
            "line 5: trail.decay = 1.5 is out of range: 0 to 1",
            "line 6: trail.diffusion = nan is out of range: 0 to 1",
            "line 7: trail.diffusion_distance = 5 is out of range: whole numbers 1 to 4 texels",
            "line 8: trail.colour: no such key; `myxo scenes --keys` lists all of them",
            "line 10: object.0.scale = 0 is out of range: 0.000001 to 1,000,000",
            "line 11: object.0.position = [1e30, 0, 0] is out of range: three numbers from -1,000,000,000,000 to 1,000,000,000,000 world units",
        ]
    );
}

#[test]
fn the_ends_of_every_range_are_allowed_and_what_lies_beyond_is_not() {
    for parameter in PARAMETERS {
        let Kind::Number(number) = &parameter.kind else {
            continue;
        };
        for end in [number.range.0, number.range.1] {
            let result = set(&[&format!("{}={end}", parameter.key)]);
            assert!(result.is_ok(), "{} = {end}: {result:?}", parameter.key);
        }
        let beyond = [number.range.0 - 1.0, number.range.1 * 1.01 + 1.0];
        for value in beyond {
            let value = if number.integer { value.floor() } else { value };
            assert!(
                set(&[&format!("{}={value}", parameter.key)]).is_err(),
                "{} = {value}",
                parameter.key
            );
        }
    }
}

#[test]
fn assignments_take_every_kind_of_value() {
    let settings = set(&[
        "particles.count=1_000_000",
        "trail.decay = 0.9",
        "physarum.border=stop",
        "particles.start=ring",
        "picture.show=atlas",
        "object.0.mesh=builtin:cube",
        "object.0.position=[1, 2.5, -3]",
        "object.0.rotation.1=90",
        "seed=0x1F",
        "atlas={size=2048, cell_size=7}",
    ])
    .expect("all are right");
    assert_eq!(settings.particles.count, 1_000_000);
    assert_eq!(settings.trail.decay, 0.9);
    assert_eq!(settings.physarum.border, Border::Stop);
    assert_eq!(settings.particles.start, Start::Ring);
    assert_eq!(settings.picture.show, Show::Atlas);
    assert_eq!(settings.objects[0].mesh, "builtin:cube");
    assert_eq!(settings.objects[0].position, [1.0, 2.5, -3.0]);
    assert_eq!(settings.objects[0].rotation, [0.0, 90.0, 0.0]);
    assert_eq!(settings.seed, 31);
    assert_eq!((settings.atlas.size, settings.atlas.cell_size), (2048, 7));
    // Whole numbers may be written as floats, and floats as whole numbers.
    assert_eq!(
        set(&["particles.count=2e6"]).map(|s| s.particles.count),
        Ok(2_000_000)
    );
    assert_eq!(set(&["trail.decay=1"]).map(|s| s.trail.decay), Ok(1.0));
    // Later assignments win.
    assert_eq!(set(&["seed=1", "seed=2"]).map(|s| s.seed), Ok(2));
}

#[test]
fn assignments_that_are_wrong_say_so_as_they_were_typed() {
    let cases = [
        (
            "trail.decya=0.9",
            "--set trail.decya=0.9: trail.decya: no such key; did you mean trail.decay?",
        ),
        (
            "trail.decay",
            "--set trail.decay: KEY=VALUE is expected, such as trail.decay=0.9",
        ),
        (
            "trail.decay=0,9",
            "--set trail.decay=0,9: trail.decay: a number is expected, not the text \"0,9\"",
        ),
        (
            "trail.decay=",
            "--set trail.decay=: trail.decay: a number is expected, not the text \"\"",
        ),
        (
            "object.1.scale=2",
            "--set object.1.scale=2: object.1.scale: the scene has one object, object.0",
        ),
        (
            "object.0.position.3=2",
            "--set object.0.position.3=2: object.0.position.3: no such key; did you mean object.0.position?",
        ),
        (
            "object.0.position.0=x",
            "--set object.0.position.0=x: object.0.position.0: a number is expected, not the text \"x\"",
        ),
    ];
    for (assignment, expected) in cases {
        assert_eq!(only_problem(set(&[assignment])), expected, "{assignment}");
    }
}

#[test]
fn mesh_paths_on_the_command_line_begin_where_it_was_typed() {
    let settings = set(&["object.0.mesh=models/fish.obj"]).expect("a path is a text");
    assert!(Path::new(&settings.objects[0].mesh).is_absolute());
    assert!(settings.objects[0].mesh.ends_with("models/fish.obj"));
    let settings = read("[[object]]\nmesh = \"models/fish.obj\"").expect("a path is a text");
    assert_eq!(settings.objects[0].mesh, "models/fish.obj");
}

/// Any input gives settings or a message, and no panic.
#[test]
fn nothing_that_can_be_typed_panics() {
    let values = [
        "",
        "=",
        "[]",
        "{}",
        "[[]]",
        "nan",
        "-inf",
        "1e999",
        "0x",
        "0xffffffffffffffffffff",
        "-1",
        "'",
        "\"",
        "[1,2,3,4]",
        "[nan,0,0]",
        "{a=1}",
        "1979-05-27T07:32:00Z",
        "\u{0}",
        "ä",
    ];
    let others = [
        "object",
        "object.",
        "object.0",
        "object.0.",
        "object.99999999999999999999.scale",
        "trail",
        ".",
        "..",
        "",
    ];
    let keys = PARAMETERS.iter().map(|p| p.key.to_owned());
    let keys = keys.chain(
        OBJECT_PARAMETERS
            .iter()
            .map(|p| format!("object.0.{}", p.key)),
    );
    for key in keys.chain(others.map(str::to_owned)) {
        for value in values {
            let assignment = format!("{key}={value}");
            let _ = set(&["object=[]", &assignment]);
            if let Ok(settings) = set(&[&assignment]) {
                assert_eq!(read(&settings.to_toml()), Ok(settings), "{assignment}");
            }
        }
    }
}

/// Catches searches for suggestions for words of any length, and building texts of problems that are not shown: the
/// first took 16 s, the second 20 s.
#[test]
fn a_hundred_thousand_mistakes_are_reported_together() {
    let long = format!("{0} = 1\n[b{0}]\nx = 1\n", "a".repeat(1_000_000));
    let many = |key: fn(usize) -> String| (0..100_000).map(key).collect::<String>();
    let unknown = many(|i| format!("physarum_speeed_{i} = 1\n"));
    let sections = many(|i| format!("[physarun_{i}]\nspeed = 1\n"));
    let word = "x".repeat(60);
    let objects = format!("[[object]]\n\"{word}\" = 1\nname = 3\n").repeat(4_000);
    for (text, count) in [
        (long, 2),
        (unknown, 100_000),
        (sections, 100_000),
        (objects, 8_000),
    ] {
        let begun = std::time::Instant::now();
        let mut reader = Reader::new(Settings::default());
        reader.text("", &text);
        let problems = reader.finish().expect_err("all of it is wrong");
        let seconds = begun.elapsed().as_secs_f64();
        assert!(seconds < 5.0, "{seconds} s for {}", &text[..30]);
        assert_eq!(problems.len(), count);
        assert_eq!(problems.iter().count(), count.min(20));
        let bytes: usize = problems
            .iter()
            .map(|problem| problem.to_string().len())
            .sum();
        assert!(bytes < 10_000, "{bytes} bytes");
    }
}

/// Catches keys, values and names that break out of their line or reach a terminal as they are.
#[test]
fn control_characters_in_messages_are_visible() {
    for text in [
        "\"a\\u001b[2J\\nmyxo: all is well\\u202e\" = 1",
        "[\"a\\u009b2J\\u0007\"]\nx = 1",
        "[physarum]\nborder = \"\\u001b]0;x\\u0007\\n\"",
        "seed = \"\\u007f\\r\\n\"",
    ] {
        let problem = only_problem(read(text));
        let left: Vec<char> = problem
            .chars()
            .filter(|&c| crate::plain_text::is_control(c))
            .collect();
        assert!(left.is_empty(), "{problem:?}");
        assert!(problem.contains("\\u{"), "{problem}");
    }
}

/// Would catch: keys of pulses that are not read, written or ranged, and mistakes that are passed over.
#[test]
fn pulses_are_read_written_and_checked() {
    let text = "[[pulse]]\nat = [0, 0.5, 0]\nstep = 30\nevery = 100\n[[pulse]]\nspeed = 0.02\nwidth = 0.4\nreach = 1\nstrength = 0.9\n";
    let text = format!("[[object]]\n{text}");
    let settings = read(&text).unwrap();
    let [one, other] = &settings.pulses[..] else {
        panic!("{:?}", settings.pulses)
    };
    assert_eq!((one.at, one.step, one.every), ([0.0, 0.5, 0.0], 30, 100));
    assert_eq!(
        (other.speed, other.width, other.reach, other.strength),
        (0.02, 0.4, 1.0, 0.9)
    );
    assert_eq!(read(&settings.to_toml()).unwrap().pulses, settings.pulses);
    for parameter in PULSE_PARAMETERS {
        let mut changed = settings.clone();
        nudge(parameter, &mut changed.pulses[1]);
        assert!(
            parameter.differs(&changed.pulses[1], other),
            "{}",
            parameter.key
        );
        assert_eq!(
            read(&changed.to_toml()).unwrap().pulses,
            changed.pulses,
            "{}",
            parameter.key
        );
    }
    assert!(!Settings::default().to_toml().contains("pulse"));
    for (wrong, words) in [
        (
            "[[pulse]]\nspeed = 0\n",
            "pulse.0.speed = 0 is out of range",
        ),
        (
            "[[pulse]]\nstrength = 2\n",
            "pulse.0.strength = 2 is out of range",
        ),
        (
            "[[pulse]]\nstep = 1.5\n",
            "pulse.0.step: a whole number is expected, not 1.5",
        ),
        (
            "[[pulse]]\nat = 3\n",
            "pulse.0.at: a list of three numbers is expected",
        ),
        (
            "[[pulse]]\nspede = 1\n",
            "pulse.0.spede: no such key; did you mean pulse.0.speed?",
        ),
        (
            "[pulse]\nspeed = 1\n",
            "pulse: [[pulse]] is expected, once for each pulse",
        ),
        (
            "[pulze]\nspeed = 1\n",
            "[pulze]: no such section; did you mean [[pulse]]?",
        ),
    ] {
        let problem = only_problem(read(wrong));
        assert!(problem.contains(words), "{problem}");
    }
    let many = format!("[[object]]\n{}", "[[pulse]]\n".repeat(257));
    let problem = only_problem(read(&many));
    assert!(
        problem.contains("has 257 pulses, and there may be 256"),
        "{problem}"
    );
    let problem = only_problem(set(&["pulse.0.speed=1"]));
    assert!(
        problem.contains("the scene has no pulse: add a [[pulse]]"),
        "{problem}"
    );
}

/// Catches lists so long that planning between their objects takes all time and memory, and a second problem that only follows from the
/// first.
#[test]
fn more_objects_and_foods_than_there_may_be_are_one_problem() {
    let many = "[[object]]\nmesh = 'builtin:cube'\n".repeat(4097);
    assert_eq!(
        only_problem(read(&many)),
        "line 1: object: the scene has 4097 objects, and there may be 4096: join those that move together into one model"
    );
    let many = format!(
        "[[object]]\nmesh = 'builtin:cube'\n{}",
        "[[food]]\n".repeat(257)
    );
    assert_eq!(
        only_problem(read(&many)),
        "line 3: food: the scene has 257 foods and markers, and there may be 256"
    );
}
