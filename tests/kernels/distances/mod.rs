//! Signed distances between objects: kernels against twins, and both against what can be worked out.

mod depths;
mod margins;
mod raster;
mod reference;
mod trees;

use crate::bits::assert_same_bits;
use crate::common::{Gpu, gpu};
use myxo::mesh::surface::NONE;
use myxo::scene::Scene;
use myxo::scene::file::Reader;
use myxo::scene::settings::{DistanceMethod, ObjectSettings, Settings, SignRule, Strategy};
use myxo::sim::distance::DistancePlanner;
use myxo::sim::plan::{Means, Plan};
use myxo::sim::types::Pose;
use myxo::sim::{Setup, Simulation, twin};

/// A scene of several meshes at places, turned about X, Y and Z.
fn scene(objects: &[(&str, [f32; 3], [f32; 3])], change: impl FnOnce(&mut Settings)) -> Scene {
    let mut settings = Settings::default();
    settings.particles.count = 500;
    settings.atlas.size = 128;
    settings.objects = objects
        .iter()
        .map(|&(mesh, position, rotation)| ObjectSettings {
            mesh: mesh.to_owned(),
            position: position.map(f64::from),
            rotation,
            ..ObjectSettings::default()
        })
        .collect();
    change(&mut settings);
    Scene::from_settings("test".to_owned(), settings, ".".into()).unwrap()
}

const TORUS: &str = "builtin:torus?major=24&minor=16";

/// Scenes that touch, lie in one another, are open, and are far apart.
fn scenes() -> Vec<(&'static str, Scene)> {
    vec![
        (
            "two tori",
            scene(
                &[
                    (TORUS, [0.0; 3], [0.0; 3]),
                    (TORUS, [1.1, 0.2, 0.1], [70.0, 10.0, 5.0]),
                ],
                |_| (),
            ),
        ),
        (
            "a cube in a ball, over a plane",
            scene(
                &[
                    ("builtin:icosphere?subdivisions=3", [0.0; 3], [0.0; 3]),
                    (
                        "builtin:cube?divisions=3",
                        [0.1, 0.5, 0.0],
                        [10.0, 20.0, 30.0],
                    ),
                    (
                        "builtin:plane?columns=5&rows=4",
                        [0.0, -0.9, 0.0],
                        [0.0, 0.0, 8.0],
                    ),
                ],
                |s| s.distance.reach = 0.4,
            ),
        ),
        (
            "far apart",
            scene(
                &[
                    ("builtin:cube", [0.0; 3], [0.0; 3]),
                    ("builtin:cube", [9.0, 0.0, 0.0], [0.0; 3]),
                ],
                |s| s.distance.reach = 0.1,
            ),
        ),
    ]
}

type Fields = (Vec<f32>, Vec<u32>);

/// The distances after one step by the kernels, and by the twins, of what is set up: methods and signs differ in nothing there.
fn both(gpu: &Gpu, scene: &Scene, setup: &Setup) -> (Fields, Fields) {
    let mut simulation = Simulation::from_setup(&gpu.ctx, scene, setup.clone()).unwrap();
    gpu.run(|rec| simulation.record_step(rec));
    let kernel = (
        gpu.ctx
            .download(&simulation.state().near.distances)
            .unwrap(),
        gpu.ctx.download(&simulation.state().near.nearest).unwrap(),
    );
    let mut twin = twin::Simulation::new(simulation.setup().clone(), scene.settings.clone());
    twin.step();
    let (distances, nearest) = twin.distances();
    (kernel, (distances.to_vec(), nearest.to_vec()))
}

/// Asserts equal bits for every texel.
fn assert_equal(name: &str, kernel: &Fields, twin: &Fields) {
    assert_eq!(kernel.0.len(), twin.0.len());
    for texel in 0..kernel.0.len() {
        let of = |fields: &Fields| (fields.0[texel].to_bits(), fields.1[texel]);
        assert_eq!(
            of(kernel),
            of(twin),
            "{name}: texel {texel}, {} and {}",
            kernel.0[texel],
            twin.0[texel]
        );
    }
}

/// Each against its twin, and one against the other, which find the same to the bit.
#[test]
fn distance_kernels_agree_with_their_twins() {
    let Some(gpu) = gpu() else { return };
    for (name, mut scene) in scenes() {
        let setup = Setup::new(&scene).unwrap();
        let (kernel, twin) = both(&gpu, &scene, &setup);
        scene.settings.distance.method = DistanceMethod::Brute;
        let by_brute = both(&gpu, &scene, &setup);
        assert!(kernel == by_brute.0 && twin == by_brute.1, "{name}");
        assert_equal(name, &kernel, &twin);
        let reach = scene.settings.distance.reach * scene.radius;
        let near = kernel.0.iter().zip(&kernel.1);
        let within = near
            .filter(|&(distance, &triangle)| distance.abs() < reach && triangle != NONE)
            .count();
        assert_eq!(
            within > 0,
            name != "far apart",
            "{name}: {within} within reach"
        );
    }
    gpu.finish();
}

/// The poses of the objects of a scene, changed.
fn moved(scene: &Scene, object: usize, by: [f32; 3]) -> Settings {
    let mut settings = scene.settings.clone();
    for (place, by) in settings.objects[object].position.iter_mut().zip(by) {
        *place += f64::from(by);
    }
    settings
}

/// Distances are taken when something has moved, for what it concerns and for nothing else.
#[test]
fn distances_are_taken_only_where_something_has_moved() {
    let cube = |x: f32| ("builtin:cube", [x, 0.0, 0.0], [0.0; 3]);
    let scene = scene(&[cube(0.0), cube(2.1), cube(9.0)], |s| {
        s.radius = 1.0;
        s.distance.reach = 0.5;
        s.distance.interval = 4;
    });
    let mut setup = Setup::new(&scene).unwrap();
    let mut planner = DistancePlanner::default();
    let mut take = |setup: &Setup, settings: &Settings, step| {
        let mut plan = Plan::new(settings, setup, step, Means::of_host(false, 1));
        plan.update_distances(&mut planner, step, &setup.poses);
        let update = plan.distances;
        (update.jobs.len(), update.pairs.len())
    };
    let settings = &scene.settings;
    assert_eq!(
        take(&setup, settings, 1),
        (3, 2),
        "all at first; only two are near"
    );
    assert_eq!(take(&setup, settings, 2), (0, 0));
    assert_eq!(take(&setup, settings, 4), (0, 0), "nothing has moved");
    // The second comes nearer; that waits until step 8.
    let poses = |settings: &Settings| -> Vec<Pose> {
        let objects = settings.objects.iter();
        objects.map(|o| Pose::from(o.world_from_object())).collect()
    };
    setup.poses = poses(&moved(&scene, 1, [-0.2, 0.0, 0.0]));
    assert_eq!(take(&setup, settings, 5), (0, 0));
    assert_eq!(take(&setup, settings, 8), (2, 2));
    // The second leaves, so that both are taken once more, with no object near.
    setup.poses = poses(&moved(&scene, 1, [3.0, 0.0, 0.0]));
    assert_eq!(take(&setup, settings, 12), (2, 0));
    assert_eq!(take(&setup, settings, 16), (0, 0));
    // The third is far from everything and may move as it likes.
    setup.poses[2] = poses(&moved(&scene, 2, [5.0, 0.0, 0.0]))[2];
    assert_eq!(take(&setup, settings, 20), (0, 0));
    let mut other = settings.clone();
    other.distance.reach = 2.0;
    assert_eq!(
        take(&setup, &other, 21).0,
        3,
        "a changed rule takes all at once"
    );
}

/// While one object passes another, kernels and twins keep agreeing, and what it has passed forgets it.
#[test]
fn distances_follow_objects_that_move() {
    let Some(gpu) = gpu() else { return };
    let at = scene(
        &[
            ("builtin:icosphere?subdivisions=3", [0.0; 3], [0.0; 3]),
            (
                "builtin:cube?divisions=4",
                [-5.0, 1.2, 0.0],
                [10.0, 20.0, 0.0],
            ),
        ],
        |s| {
            s.radius = 1.0;
            s.distance.reach = 0.4;
            s.physarum.distance_weight = 3.0;
        },
    );
    let mut simulation = Simulation::new(&gpu.ctx, &at).unwrap();
    let mut settings = at.settings.clone();
    let mut seen = Vec::new();
    for _ in 0..6 {
        simulation.apply(&settings).unwrap();
        gpu.run(|rec| simulation.record_step(rec));
        let distances = gpu
            .ctx
            .download(&simulation.state().near.distances)
            .unwrap();
        let nearest = gpu.ctx.download(&simulation.state().near.nearest).unwrap();
        let mut twin = twin::Simulation::new(simulation.setup().clone(), settings.clone());
        twin.step();
        seen.push(nearest.iter().filter(|&&t| t != NONE).count());
        let (distances_by_twin, nearest_by_twin) = twin.distances();
        assert_equal(
            "one passes another",
            &(distances, nearest),
            &(distances_by_twin.to_vec(), nearest_by_twin.to_vec()),
        );
        settings.objects[1].position[0] += 2.0;
    }
    assert!(seen[0] == 0 && seen[2] > 100 && seen[5] == 0, "{seen:?}");
    gpu.finish();
}

/// `distance_to` names the other objects that count.
#[test]
fn only_those_count_that_distance_to_names() {
    let Some(gpu) = gpu() else { return };
    let objects = [
        ("builtin:cube", [0.0; 3], [0.0; 3]),
        ("builtin:cube", [1.1, 0.0, 0.0], [0.0; 3]),
        ("builtin:cube", [0.0, 1.1, 0.0], [0.0; 3]),
    ];
    let named = scene(&objects, |s| {
        for (object, name) in s.objects.iter_mut().zip(["a", "b", "c"]) {
            object.name = name.to_owned();
        }
        s.objects[0].distance_to = vec!["c".to_owned()];
    });
    let setup = Setup::new(&named).unwrap();
    let (kernel, twin) = both(&gpu, &named, &setup);
    assert_equal("by name", &kernel, &twin);
    let object_of = |triangle: u32| setup.surface.triangles[triangle as usize].object;
    let mut counted = [[0; 3]; 3];
    for (texel, &triangle) in kernel.1.iter().enumerate() {
        if triangle != NONE {
            let own = object_of(setup.atlas.owner[texel]);
            counted[own as usize][object_of(triangle) as usize] += 1;
        }
    }
    let [a, b, _] = counted;
    assert!(a[1] == 0 && a[2] > 0 && b[0] > 0, "{counted:?}");
    gpu.finish();

    let refused = |names: &[&str]| {
        let mut settings = named.settings.clone();
        settings.objects[1].distance_to = names.iter().map(|&name| name.to_owned()).collect();
        let scene = Scene::from_settings("test".to_owned(), settings, ".".into());
        scene.unwrap_err().to_string()
    };
    assert!(refused(&["d"]).contains("there is no object \"d\"; the others are a, c"));
    assert!(refused(&["a", "b"]).contains("object.1.distance_to names the object itself"));
}

/// By every rule of signs, the two methods and the twins agree.
#[test]
fn rules_of_signs_are_those_of_the_twins() {
    let Some(gpu) = gpu() else { return };
    for (name, mut scene) in scenes() {
        let setup = Setup::new(&scene).unwrap();
        for sign in [SignRule::Winding, SignRule::Facing] {
            scene.settings.distance.sign = sign;
            let (kernel, twin) = both(&gpu, &scene, &setup);
            assert_equal(&format!("{name}, {sign:?}"), &kernel, &twin);
        }
    }
    gpu.finish();
}

/// Two objects in one place: neither covers the other.
#[test]
fn objects_in_one_place_do_not_cover_each_other() {
    let Some(gpu) = gpu() else { return };
    let twice = [(TORUS, [0.3, -0.2, 0.1], [20.0, 30.0, 40.0]); 2];
    let scene = scene(&twice, |_| ());
    let setup = Setup::new(&scene).unwrap();
    let (kernel, twin) = both(&gpu, &scene, &setup);
    assert_equal("in one place", &kernel, &twin);
    for sample in &setup.distance.samples {
        let distance = kernel.0[sample.texel as usize];
        assert!((0.0..1e-5).contains(&distance), "{distance}");
        let nearest = kernel.1[sample.texel as usize];
        assert_ne!(setup.atlas.owner[sample.texel as usize], nearest);
    }
    gpu.finish();
}

/// Sensors add the weighted distance, by kernel and twin alike, and with a negative weight particles stay away from other objects.
#[test]
fn particles_mind_distances() {
    let Some(gpu) = gpu() else { return };
    let mean = |weight: f32| {
        let scene = scene(
            &[
                ("builtin:icosphere?subdivisions=3", [0.0; 3], [0.0; 3]),
                ("builtin:cube", [0.0, 1.6, 0.0], [0.0; 3]),
            ],
            |s| {
                s.radius = 1.0;
                s.particles.count = 4000;
                s.distance.reach = 1.0;
                s.physarum.sensor_noise = 0.3;
                s.physarum.sensor_offset = 0.1;
                s.physarum.speed = 0.02;
                s.physarum.distance_weight = weight;
                // Every particle keeps its slot.
                s.transfer.strategy = Strategy::None;
            },
        );
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let mut twin = twin::Simulation::new(simulation.setup().clone(), scene.settings.clone());
        gpu.run(|rec| simulation.record_step(rec));
        twin.step();
        let (mut after, mut by_twin) = (simulation.snapshot().unwrap(), twin.snapshot());
        // Some have changed objects, and slots with others, in any order.
        after.particles.sort_unstable_by_key(|p| p.id);
        by_twin.particles.sort_unstable_by_key(|p| p.id);
        assert_same_bits("particles", &after.particles, &by_twin.particles);
        for _ in 0..40 {
            gpu.run(|rec| simulation.record_step(rec));
        }
        let setup = simulation.setup();
        let distances = gpu
            .ctx
            .download(&simulation.state().near.distances)
            .unwrap();
        let snapshot = simulation.snapshot().unwrap();
        let particles = snapshot.particles.iter();
        let at = particles.map(|p| distances[setup.atlas.texel_of(p.triangle, p.u, p.v) as usize]);
        at.sum::<f32>() / 4000.0
    };
    let (seek, none, avoid) = (mean(-5.0), mean(0.0), mean(5.0));
    assert!(
        seek + 0.05 < none && none + 0.05 < avoid,
        "{seek}, {none}, {avoid}"
    );
    gpu.finish();
}

/// Names of other objects come from scene files and from the command line.
#[test]
fn distance_to_is_a_list_of_names() {
    let read = |text: &str, assignment: &str| {
        let mut reader = Reader::new(Settings::default());
        reader.text("", text);
        reader.assignment(assignment);
        reader.finish()
    };
    let text = "[[object]]\ndistance_to = [\"b\"]\n[[object]]\nname = \"b\"\n";
    let settings = read(text, "object.1.distance_to=[\"x\", \"y\"]").unwrap();
    assert_eq!(settings.objects[0].distance_to, ["b"]);
    assert_eq!(settings.objects[1].distance_to, ["x", "y"]);
    assert_eq!(read(&settings.to_toml(), "seed=7").unwrap(), settings);
    for wrong in ["object.0.distance_to=b", "object.0.distance_to=[1]"] {
        let problems = read(text, wrong).unwrap_err();
        assert!(
            problems
                .iter()
                .next()
                .expect("there is one")
                .message
                .contains("a list of names is expected"),
            "{problems:?}"
        );
    }
}

/// A small object far within reach of a large one: rounding of the long way must not hide it.
#[test]
fn small_objects_are_found_from_afar() {
    let Some(gpu) = gpu() else { return };
    let mut scene = scene(
        &[
            ("builtin:icosphere?subdivisions=3", [0.0; 3], [0.0; 3]),
            ("builtin:cube", [1.3, 0.0, 0.0], [10.0, 20.0, 30.0]),
        ],
        |s| {
            s.objects[1].scale = 0.002;
            s.distance.reach = 3.0;
            s.atlas.size = 96;
        },
    );
    let setup = Setup::new(&scene).unwrap();
    let kernel = both(&gpu, &scene, &setup).0;
    scene.settings.distance.method = DistanceMethod::Brute;
    let by_brute = both(&gpu, &scene, &setup).0;
    let found = by_brute
        .1
        .iter()
        .filter(|&&triangle| triangle != NONE)
        .count();
    assert!(found > 1000, "{found}");
    assert!(kernel == by_brute);
    gpu.finish();
}

/// In the middle of a fine ball all its faces are about as near, and devices that end long loops leave the search for the
/// nearest one early. What lies there is deep inside all the same.
#[test]
fn the_middle_of_a_fine_ball_is_inside() {
    let Some(gpu) = gpu() else { return };
    let mut scene = scene(
        &[
            ("builtin:icosphere?subdivisions=6", [0.0; 3], [0.0; 3]),
            (
                "builtin:icosphere?subdivisions=2",
                [0.002, 0.0, 0.0],
                [0.0; 3],
            ),
            ("builtin:cube", [0.06, 0.0, 0.0], [10.0, 20.0, 30.0]),
        ],
        |s| {
            s.atlas.size = 384;
            for object in &mut s.objects[1..] {
                object.scale = 0.05;
                object.texel_weight = 4.0;
            }
        },
    );
    let setup = Setup::new(&scene).unwrap();
    let reach = scene.settings.distance.reach * scene.radius;
    let (first, _) = setup.surface.objects[1].triangles;
    for sign in [SignRule::Pseudonormal, SignRule::Winding] {
        scene.settings.distance.sign = sign;
        let mut simulation = Simulation::from_setup(&gpu.ctx, &scene, setup.clone()).unwrap();
        gpu.run(|rec| simulation.record_step(rec));
        let distances = gpu
            .ctx
            .download(&simulation.state().near.distances)
            .unwrap();
        let nearest = gpu.ctx.download(&simulation.state().near.nearest).unwrap();
        let mut deep = 0;
        for sample in &setup.distance.samples {
            let texel = sample.texel as usize;
            if setup.atlas.owner[texel] >= first {
                assert_eq!(distances[texel], -reach, "{sign:?}, texel {texel}");
                assert_eq!(nearest[texel], NONE, "{sign:?}, texel {texel}");
                deep += 1;
            }
        }
        assert!(deep > 100, "{deep}");
    }
    gpu.finish();
}

/// A reference that looks at some of the triangles only would be none.
#[test]
fn brute_force_is_refused_where_a_device_would_not_look_at_all() {
    let Some(gpu) = gpu() else { return };
    let scene = scene(
        &[
            ("builtin:icosphere?subdivisions=7", [0.0; 3], [0.0; 3]),
            ("builtin:cube", [1.0, 0.0, 0.0], [0.0; 3]),
        ],
        |s| s.distance.method = DistanceMethod::Brute,
    );
    let refused = myxo::sim::memory::check(gpu.ctx.info(), &scene);
    if gpu.ctx.info().kind == myxo::gpu::DeviceKind::Cpu {
        let message = refused.expect_err("too many").to_string();
        assert!(message.contains("327,680 triangles"), "{message}");
        assert!(message.contains("`cube`"), "{message}");
    } else {
        refused.expect("it is no loop's end there");
    }
    gpu.finish();
}
