//! Scenes load by name and by file, with their overrides.

use std::path::Path;

use crate::mesh::Mesh;
use crate::scene::parameters::{PARAMETERS, find, restarting};
use crate::scene::presets::is_look;
use crate::scene::settings::{ObjectSettings, Settings};
use crate::scene::{Overrides, Scene, builtin, name_objects};

#[test]
fn changes_that_restart_differ_from_those_that_do_not() {
    let old = Settings::default();
    let keys = |change: fn(&mut Settings)| {
        let mut new = old.clone();
        change(&mut new);
        restarting(&old, &new)
            .iter()
            .map(|p| p.key)
            .collect::<Vec<_>>()
    };
    assert_eq!(keys(|_| {}), [""; 0]);
    assert_eq!(keys(|s| s.trail.decay = 0.5), [""; 0]);
    assert_eq!(
        keys(|s| s.trail.diffusion_distance = 2),
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
        // A preset is a whole look: keys that it lacked would keep values of an earlier preset.
        let table: toml::Table = preset.text.parse().expect("presets are TOML");
        for parameter in PARAMETERS {
            let (section, key) = parameter
                .key
                .rsplit_once('.')
                .unwrap_or(("", parameter.key));
            let how = !is_look(parameter);
            let mentioned = table
                .get(section)
                .is_some_and(|section| section.get(key).is_some());
            assert_eq!(
                mentioned,
                // A look without scattered food has none.
                ["physarum", "trail"].contains(&section) && !how
                    || parameter.key == "picture.color_map"
                    || section == "feeding" && !how && preset.name == "feeding",
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
        // Enough texels for the gutters.
        let texels = u64::from(scene.settings.atlas.size).pow(2);
        let per_triangle = texels / scene.surface.triangles.len() as u64;
        assert!(per_triangle >= 8, "{}: {per_triangle}", builtin.name);
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
    let mut overrides = Overrides {
        preset: Some("spots".to_owned()),
        set: vec!["physarum.sensor_angle=12".to_owned()],
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
    // Two values of one key: it is unknown which one is meant.
    overrides.set.push("seed=1".to_owned());
    let message = Scene::read(Path::new("torus"), &overrides)
        .expect_err("it is set twice")
        .to_string();
    assert_eq!(
        message,
        "torus: --seed 9: --set seed=1 sets the seed, too: leave one of the two away"
    );
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
        preset: Some("spotz".to_owned()),
        ..Overrides::default()
    };
    let message = Scene::load(Path::new("torus"), &overrides)
        .expect_err("no such preset")
        .to_string();
    assert!(
        message.starts_with("there is no preset `spotz`, did you mean `spots`?"),
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

/// Would catch: a name that an object without one takes from the object to which it is given, and with it the food there.
#[test]
fn objects_are_named_after_their_meshes_and_kept_apart() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("three.toml");
    let text = "[[object]]\nmesh = \"builtin:cube\"\n[[object]]\nmesh = \"builtin:cube\"\n[[object]]\nname = \"cube\"\nmesh = \"builtin:plane\"\n";
    let named = |text: &str| {
        std::fs::write(&path, text).expect("it can be written");
        let scene = Scene::load(&path, &Overrides::default()).expect("it is right");
        assert_eq!(scene.name, "three");
        let names = scene.settings.objects.iter().map(|o| o.name.clone());
        (names.collect::<Vec<_>>(), scene.settings)
    };
    assert_eq!(named(text).0, ["cube 2", "cube 3", "cube"]);
    let text = text.replace("\"cube\"", "\"cube 2\"");
    let (names, settings) = named(&(text + "[[food]]\nobject = \"cube 2\"\n"));
    assert_eq!(names, ["cube", "cube 3", "cube 2"]);
    assert_eq!(settings.object_of(&settings.foods[0]), Some(2));
}

/// Thousands of objects, many of them without a name or with a repeated one: each gets the same name as by a search through all given
/// names and all earlier ones.
#[test]
fn many_objects_get_the_names_that_few_do() {
    let cube = Mesh::open("builtin:cube", Path::new("")).expect("it is built in");
    let given = [
        "", "", "cube 2", "", "ball", " ball ", "cube 2", "cube 2 2", "ball 3", "cube",
    ];
    let names = |count: usize| {
        let object = |i: usize| ObjectSettings {
            // Finally only objects without a name.
            name: if i < 200 { given[i * 7 % 10] } else { "" }.to_owned(),
            ..ObjectSettings::default()
        };
        let mut objects: Vec<_> = (0..count).map(object).collect();
        let wanted: Vec<String> = objects.iter().map(|o| o.name.trim().to_owned()).collect();
        name_objects(&mut objects, &vec![cube.clone(); count]);
        let names: Vec<String> = objects.into_iter().map(|object| object.name).collect();
        (wanted, names)
    };
    let (wanted, few) = names(300);
    for (i, name) in few.iter().enumerate() {
        let is_free = |name: &String| !few[..i].contains(name) && !wanted.contains(name);
        let expected = match wanted[i].as_str() {
            given if !given.is_empty() && !wanted[..i].contains(&wanted[i]) => given.to_owned(),
            given => {
                let given = if given.is_empty() { "cube" } else { given };
                let numbered = (2..).map(|n| format!("{given} {n}"));
                let mut all = std::iter::once(given.to_owned()).chain(numbered);
                all.find(is_free).expect("there is one")
            }
        };
        assert_eq!(*name, expected, "object {i}");
    }
    let (_, many) = names(20_000);
    assert_eq!(many[..300], few);
    let different: std::collections::HashSet<_> = many.iter().collect();
    assert_eq!(different.len(), 20_000);
}

#[test]
fn objects_that_cannot_follow_their_model_are_named_by_place() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("two.toml");
    let object = |more: &str| format!("[[object]]\nmesh = \"builtin:cube\"\n{more}\n");
    let follow = "motion = { model = \"follow\" }";
    let text = object("") + &object(follow) + &object(&format!("name = \"last\"\n{follow}"));
    std::fs::write(&path, text).expect("it can be written");
    let error = Scene::load(&path, &Overrides::default()).expect_err("cubes are not animated");
    let text = error.to_string();
    assert!(text.starts_with("two: 2 things are wrong:"), "{text}");
    for place in ["\n  object.1.motion.model: ", "\n  object.2.motion.model: "] {
        assert!(text.contains(place), "{text}");
    }
    assert!(text.contains("only glTF models"), "{text}");
}

/// Would catch: options that are cut off at a point, as if an ending began there.
#[test]
fn a_bare_builtin_mesh_is_a_scene() {
    let scene =
        Scene::load(Path::new("builtin:capsule"), &Overrides::default()).expect("it is built in");
    assert_eq!((scene.name.as_str(), scene.meshes.len()), ("capsule", 1));
    let mesh = Path::new("builtin:torus?tube=0.25");
    let read = Scene::read(mesh, &Overrides::default()).expect("it is built in");
    assert_eq!(read.0, "torus?tube=0.25");
}

/// A torus of 20 million triangles takes half a minute and gigabytes to be made and joined; without the check it would be refused only
/// after that, or laid out in a texture in which many of them share each texel.
#[test]
fn more_triangles_than_the_atlas_has_room_for_are_refused_before_they_are_made() {
    let load = |size: u32, meshes: &[&str]| {
        let mut settings = Settings::default();
        settings.atlas.size = size;
        let objects = meshes.iter().map(|&mesh| ObjectSettings {
            mesh: mesh.to_owned(),
            ..ObjectSettings::default()
        });
        settings.objects = objects.collect();
        Scene::from_settings("many".to_owned(), settings, "".into())
    };
    let begun = std::time::Instant::now();
    for (size, meshes, words) in [
        (
            1024,
            &["builtin:torus?major=3163&minor=3163"][..],
            "20009138 triangles, and the atlas has room for 16777216 more: raise atlas.size",
        ),
        (
            16,
            &["builtin:cube", "builtin:icosphere?subdivisions=8"],
            "1310720 triangles, and the atlas has room for 1048564 more",
        ),
    ] {
        let error = load(size, meshes).expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
    }
    assert!(begun.elapsed().as_secs() < 5, "{:?}", begun.elapsed());
    load(16, &["builtin:icosphere"]).expect("few triangles are left to the atlas");
}

/// As above, for files: the header of a binary STL file has the count, and other files are refused as soon as they are read.
#[test]
fn a_file_of_more_triangles_than_the_atlas_has_room_for_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let count = 1_048_577_u32;
    let mut stl = vec![0; 80];
    stl.extend(count.to_le_bytes());
    // Facets without numbers, because none of them is read.
    stl.resize(84 + 50 * count as usize, 0xff);
    let mut obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_owned();
    obj += &"f 1 2 3\n".repeat(count as usize);
    for (name, bytes) in [("many.stl", stl.as_slice()), ("many.obj", obj.as_bytes())] {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let overrides = Overrides {
            set: vec!["atlas.size=16".to_owned()],
            ..Overrides::default()
        };
        let error = Scene::load(&path, &overrides).expect_err(name).to_string();
        let words = "1048577 triangles, and the atlas has room for 1048576 more: raise atlas.size";
        assert!(error.contains(words), "{error}");
    }
}

/// Catches rods and needles that are accepted although particles on them lose their headings after some steps.
#[test]
fn rods_too_thin_for_directions_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("rod.obj");
    let load = |length: f64, width: f64| {
        let corners = (0..8).map(|i| {
            let [x, y, z] = [i >> 2, i >> 1 & 1, i & 1].map(f64::from);
            format!("v {:e} {:e} {:e}\n", x * length, y * width, z * width)
        });
        let faces = "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n";
        std::fs::write(&file, corners.collect::<String>() + faces).unwrap();
        Scene::load(&file, &Overrides::default())
    };
    for (length, width) in [(1.0, 1e-7), (1e5, 1e-3), (1e-3, 1e-11)] {
        let message = load(length, width).expect_err("it is too thin").to_string();
        assert!(
            message.starts_with("object `rod`: most of its surface"),
            "{message}"
        );
        assert!(message.contains("make the object thicker"), "{message}");
    }
    for (length, width) in [(1.0, 5e-7), (1e5, 1.0), (1.0, 1.0)] {
        load(length, width).expect("it can be walked on");
    }
}
