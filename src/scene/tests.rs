//! Tests of scenes as their users meet them: files, overrides, messages.

use std::path::Path;

use super::file::Reader;
use super::parameters::{
    Kind, OBJECT_PARAMETERS, PARAMETERS, Parameter, find, out_of_range, restarting,
};
use super::settings::{Border, ObjectSettings, Sensing, Settings, Show, Start};
use super::{Overrides, Scene, builtin};

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
        Kind::Vector { range, get, set } => {
            set(
                target,
                get(target).map(|c| (c + 0.125).clamp(range.0 as f32, range.1 as f32)),
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
    // Every word has another one to change to, except the only atlas method.
    let defaults = Settings::default();
    let unchanged: Vec<_> = PARAMETERS
        .iter()
        .filter(|p| !p.differs(&settings, &defaults))
        .map(|p| p.key)
        .collect();
    assert_eq!(unchanged, ["atlas.method"]);

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
    let table: toml::Table = Settings::default()
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
    in_table.extend(["object.name".to_owned(), "object.mesh".to_owned()]);
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
    let problem = only_problem(read("[physarun]\nspeed = 1\n"));
    assert_eq!(
        problem,
        "line 1: [physarun]: no such section; did you mean [physarum]?"
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
    // Nothing is near.
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
            "line 1: trail is a section: keys such as trail.diffusion stand in it",
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
            "line 11: object.0.position = [1e30, 0, 0] is out of range: three numbers from -1,000,000,000 to 1,000,000,000 world units",
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
        "physarum.sensing=\"walk\"",
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
    assert_eq!(settings.physarum.sensing, Sensing::Walk);
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
    // Later ones win.
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

#[test]
fn changes_that_restart_are_told_from_those_that_do_not() {
    let old = Settings::default();
    let keys = |change: fn(&mut Settings)| {
        let mut new = old.clone();
        change(&mut new);
        restarting(&old, &new, 2)
            .iter()
            .map(|p| p.key)
            .collect::<Vec<_>>()
    };
    assert_eq!(keys(|_| {}), [""; 0]);
    assert_eq!(keys(|s| s.trail.decay = 0.5), [""; 0]);
    assert_eq!(keys(|s| s.trail.diffusion_distance = 2), [""; 0]);
    assert_eq!(
        keys(|s| s.trail.diffusion_distance = 3),
        ["trail.diffusion_distance"]
    );
    assert_eq!(
        keys(|s| (s.seed, s.atlas.size) = (8, 512)),
        ["seed", "atlas.size"]
    );
}

#[test]
fn every_builtin_scene_and_preset_is_right() {
    for scene in builtin::SCENES {
        assert!(scene.summary().ends_with('.'), "{}", scene.name);
        for preset in builtin::PRESETS {
            let overrides = Overrides {
                preset: Some(preset.name.to_owned()),
                ..Overrides::default()
            };
            let (name, settings, _) =
                Scene::read(Path::new(scene.name), &overrides).expect("it is built in");
            assert_eq!(name, scene.name);
            assert!(
                settings
                    .objects
                    .iter()
                    .all(|object| object.mesh.starts_with("builtin:")),
                "{}",
                scene.name
            );
        }
    }
    for preset in builtin::PRESETS {
        assert!(preset.summary().ends_with('.'), "{}", preset.name);
        // A preset is a whole look: what it does not mention would be left over from the one before.
        let table: toml::Table = preset.text.parse().expect("presets are TOML");
        for parameter in PARAMETERS {
            let (section, key) = parameter
                .key
                .rsplit_once('.')
                .unwrap_or(("", parameter.key));
            let how = ["border", "edge_crossing_attempts", "sensing"].contains(&key);
            let mentioned = table
                .get(section)
                .is_some_and(|section| section.get(key).is_some());
            assert_eq!(
                mentioned,
                ["physarum", "trail"].contains(&section) && !how,
                "{}: {}",
                preset.name,
                parameter.key
            );
        }
    }
}

#[test]
fn every_builtin_scene_loads_with_room_in_its_atlas() {
    for builtin in builtin::SCENES {
        let scene =
            Scene::load(Path::new(builtin.name), &Overrides::default()).expect("it is built in");
        assert_eq!(scene.surface.objects.len(), scene.settings.objects.len());
        scene.surface.validate().expect("the surface is sound");
        assert!(
            scene.radius > 0.1 && scene.radius < 1000.0,
            "{}: {}",
            builtin.name,
            scene.radius
        );
        // A grid's cell holds two triangles, a gutter round each, and texels that are worth it.
        let cells = scene.surface.triangles.len().div_ceil(2);
        let across = (cells as f64).sqrt().ceil();
        assert!(
            f64::from(scene.settings.atlas.size) / across >= 8.0,
            "{}",
            builtin.name
        );
    }
}

#[test]
fn the_reference_scenes_have_their_sizes() {
    for (name, triangles) in [("cube", 12), ("torus", 2 * 144 * 96)] {
        let scene = Scene::load(Path::new(name), &Overrides::default()).expect("it is built in");
        assert_eq!(scene.surface.triangles.len(), triangles);
        assert_eq!(scene.settings.particles.count, 500_000);
        assert_eq!(scene.settings.atlas.size, 1024);
    }
}

#[test]
fn overrides_come_in_order() {
    let overrides = Overrides {
        preset: Some("rings".to_owned()),
        set: vec!["physarum.sensor_angle=12".to_owned(), "seed=1".to_owned()],
        seed: Some(9),
    };
    let (_, settings, _) = Scene::read(Path::new("torus"), &overrides).expect("all are right");
    assert_eq!(settings.physarum.sensor_angle, 12.0);
    let rotation = find("physarum.rotation_angle").expect("it is in the table");
    assert!(
        rotation.differs(&settings, &Settings::default()),
        "the preset was applied"
    );
    assert_eq!(settings.seed, 9);
}

#[test]
fn unknown_names_are_answered_with_the_nearest() {
    let message = Scene::load(Path::new("tours"), &Overrides::default())
        .expect_err("no such scene")
        .to_string();
    assert!(
        message.starts_with("there is no scene `tours`, did you mean `torus`?"),
        "{message}"
    );
    let overrides = Overrides {
        preset: Some("ringz".to_owned()),
        ..Overrides::default()
    };
    let message = Scene::load(Path::new("torus"), &overrides)
        .expect_err("no such preset")
        .to_string();
    assert!(
        message.starts_with("there is no preset `ringz`, did you mean `rings`?"),
        "{message}"
    );
}

#[test]
fn the_radius_reaches_from_the_box_to_the_farthest_vertex() {
    let load = |set: &[&str]| {
        let set = set.iter().map(|s| (*s).to_owned()).collect();
        Scene::load(
            Path::new("cube"),
            &Overrides {
                set,
                ..Overrides::default()
            },
        )
        .expect("all are right")
    };
    let near = |a: f32, b: f32| assert!((a - b).abs() < 1e-5 * b.abs().max(1.0), "{a} is not {b}");
    let cube = load(&[]);
    near(cube.radius, 3.0_f32.sqrt());
    assert_eq!(cube.settings.radius, cube.radius);
    let moved = load(&["object.0.position=[10, 0, 0]", "object.0.scale=2"]);
    near(moved.radius, 2.0 * 3.0_f32.sqrt());
    near(moved.center.x, 10.0);
    // Turned by 45 degrees about Y, the box is wider but no vertex is farther away.
    near(load(&["object.0.rotation.1=45"]).radius, 3.0_f32.sqrt());
    assert_eq!(load(&["radius=2.5"]).radius, 2.5);
}

#[test]
fn rotations_go_about_x_then_y_then_z() {
    let object = ObjectSettings {
        rotation: [90.0, 90.0, 0.0],
        position: [1.0, 0.0, 0.0],
        ..ObjectSettings::default()
    };
    // X takes +Y to +Z; then Y takes +Z to +X; then it is moved.
    let moved = object.world_from_object().transform_point3(glam::Vec3::Y);
    assert!(
        moved.distance(glam::Vec3::new(2.0, 0.0, 0.0)) < 1e-6,
        "{moved}"
    );
}

#[test]
fn a_saved_scene_loads_as_the_same() {
    let overrides = Overrides {
        set: vec!["object.0.rotation=[10, 20, 30]".to_owned()],
        seed: Some(3),
        preset: None,
    };
    let scene = Scene::load(Path::new("pair"), &overrides).expect("it is built in");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("saved.toml");
    std::fs::write(&path, scene.to_toml()).expect("it can be written");
    let again = Scene::load(&path, &Overrides::default()).expect("what was saved is right");
    assert_eq!(again.settings, scene.settings);
    assert_eq!(again.radius.to_bits(), scene.radius.to_bits());
}

#[test]
fn objects_are_named_after_their_meshes_and_kept_apart() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("three.toml");
    let text = "[[object]]\nmesh = \"builtin:cube\"\n[[object]]\nmesh = \"builtin:cube\"\n[[object]]\nname = \"cube\"\nmesh = \"builtin:plane\"\n";
    std::fs::write(&path, text).expect("it can be written");
    let scene = Scene::load(&path, &Overrides::default()).expect("it is right");
    let names: Vec<_> = scene
        .settings
        .objects
        .iter()
        .map(|object| object.name.as_str())
        .collect();
    assert_eq!(names, ["cube", "cube 2", "cube 3"]);
    assert_eq!(scene.name, "three");
}

#[test]
fn a_bare_builtin_mesh_is_a_scene() {
    let scene =
        Scene::load(Path::new("builtin:capsule"), &Overrides::default()).expect("it is built in");
    assert_eq!((scene.name.as_str(), scene.meshes.len()), ("capsule", 1));
}
