//! Objects that move while particles walk on them: on the GPU and by the twins, from scenes and from outside.

use crate::advance;
use std::path::Path;

use crate::common::{COARSE_TRIO, Gpu, by_id, gpu, set_up};
use crate::places::root;
use glam::{Affine3A, DAffine3, DQuat, DVec3, Vec3};
use myxo::scene::settings::{ObjectSettings, Settings};
use myxo::scene::{Overrides, Scene};
use myxo::sim::checkpoint::Checkpoint;
use myxo::sim::types::Pose;
use myxo::sim::{Setup, Simulation, Snapshot, twin};

/// Two objects that move and feel how high they are, so that poses decide where particles go.
fn moving(change: impl FnOnce(&mut Settings)) -> Scene {
    let mut settings = Settings::default();
    settings.particles.count = 3000;
    settings.atlas.size = 128;
    settings.physarum.gravity_weight = 40.0;
    settings.objects = [
        "builtin:cube?divisions=4",
        "builtin:icosphere?subdivisions=2",
    ]
    .map(|mesh| ObjectSettings {
        mesh: mesh.to_owned(),
        ..ObjectSettings::default()
    })
    .to_vec();
    settings.objects[0].motion.spin = [200.0, 30.0, 0.0];
    settings.objects[1].position = [3.0, 0.0, 0.0];
    settings.objects[1].motion.orbit = [0.0, 90.0, 250.0];
    change(&mut settings);
    Scene::from_settings("moving".to_owned(), settings, ".".into()).unwrap()
}

fn poses_on(gpu: &Gpu, simulation: &Simulation) -> Vec<Pose> {
    gpu.ctx.download(&simulation.state().objects.poses).unwrap()
}

#[test]
fn every_step_has_the_poses_of_its_time() {
    let Some(gpu) = gpu() else { return };
    let scene = moving(|_| ());
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let mut before = poses_on(&gpu, &simulation);
    let dt = f64::from(scene.settings.time.dt);
    for step in 0..6 {
        advance(&gpu, &mut simulation, 1);
        let poses = poses_on(&gpu, &simulation);
        let expected = scene.world_from_object_at(f64::from(step) * dt);
        let expected: Vec<Pose> = expected.into_iter().map(Pose::from).collect();
        assert_eq!(poses, expected, "step {step}");
        assert_eq!(simulation.poses(), poses);
        assert_eq!(
            poses == before,
            step == 0,
            "everything moves from step 1 on"
        );
        assert_eq!(simulation.time(), f64::from(step) * dt);
        before = poses;
    }
    gpu.finish();
}

/// Steps that are recorded and wait keep their poses: many in one go end as one after the other, and as without
/// motion they do not.
#[test]
fn steps_in_flight_keep_their_poses() {
    let Some(gpu) = gpu() else { return };
    let scene = moving(|_| ());
    let run = |together: u32| {
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        for _ in 0..30 / together {
            gpu.run(|rec| (0..together).for_each(|_| simulation.record_step(rec)));
        }
        simulation.snapshot().unwrap()
    };
    let one_by_one = run(1);
    assert_eq!(run(15).hash(), one_by_one.hash());
    let still = moving(|s| s.time.dt = 0.0);
    let mut simulation = Simulation::new(&gpu.ctx, &still).unwrap();
    advance(&gpu, &mut simulation, 30);
    assert_ne!(simulation.snapshot().unwrap().hash(), one_by_one.hash());
    gpu.finish();
}

/// Particles of the two that are on the same triangle, as a share.
fn agreement(a: &Snapshot, b: &Snapshot) -> f64 {
    let same = by_id(a).into_iter().zip(by_id(b));
    let same = same.filter(|((a, _), (b, _))| a.triangle == b.triangle);
    let same = same.count();
    same as f64 / a.particles.len() as f64
}

#[test]
fn the_twin_moves_as_the_device_does() {
    let Some(gpu) = gpu() else { return };
    let scene = moving(|s| {
        s.objects[0].physarum.speed = Some(0.02);
        s.objects[1].physarum.gravity_weight = Some(-80.0);
        s.objects[1].physarum.favourite_density = Some(3.0);
    });
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let mut twin = twin::Simulation::new(Setup::new(&scene).unwrap(), scene.settings.clone());
    for step in 0..4 {
        if step == 2 {
            let pose = DAffine3::from_rotation_translation(
                DQuat::from_rotation_z(1.0),
                DVec3::new(0.0, 2.0, 0.0),
            );
            simulation.set_pose(0, Some(pose)).unwrap();
            twin.set_pose(0, Some(pose)).unwrap();
        }
        advance(&gpu, &mut simulation, 1);
        twin.step();
        let (on_device, on_host) = (simulation.snapshot().unwrap(), twin.snapshot());
        assert_eq!(on_device.movement, on_host.movement);
        let agreement = agreement(&on_device, &on_host);
        assert!(agreement > 0.995, "step {step}: {agreement} of them agree");
    }
    gpu.finish();
}

#[test]
fn an_objects_own_values_hold_on_it_alone() {
    let Some(gpu) = gpu() else { return };
    let scene = moving(|s| s.objects[1].physarum.speed = Some(0.0));
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let first = simulation.snapshot().unwrap();
    advance(&gpu, &mut simulation, 3);
    let count_moved = |before: &Snapshot, after: &Snapshot| {
        let mut moved = [0, 0];
        for ((a, _), (b, _)) in by_id(before).into_iter().zip(by_id(after)) {
            let object = scene.surface.triangles[a.triangle as usize].object;
            moved[object as usize] += u32::from((a.triangle, a.u, a.v) != (b.triangle, b.u, b.v));
        }
        moved
    };
    let then = simulation.snapshot().unwrap();
    let [on_cube, on_ball] = count_moved(&first, &then);
    assert!(
        on_cube > 500 && on_ball == 0,
        "{on_cube} and {on_ball} have moved"
    );
    // While it runs, the other one stops and this one continues.
    let mut settings = scene.settings.clone();
    settings.objects[0].physarum.speed = Some(0.0);
    settings.objects[1].physarum.speed = None;
    simulation.apply(&settings).unwrap();
    advance(&gpu, &mut simulation, 3);
    let [on_cube, on_ball] = count_moved(&then, &simulation.snapshot().unwrap());
    assert!(
        on_cube == 0 && on_ball > 500,
        "{on_cube} and {on_ball} have moved"
    );
    gpu.finish();
}

#[test]
fn a_resumed_run_goes_on_with_its_time_and_its_poses() {
    let Some(gpu) = gpu() else { return };
    let scene = moving(|_| ());
    let mut settings = scene.settings.clone();
    settings.time.dt = 0.031;
    let pose = DAffine3::from_rotation_translation(DQuat::from_rotation_x(0.7), DVec3::Y);
    // The time step changes in step 7 and a pose is set in step 9: both are history that a checkpoint must hold.
    let begin = || {
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        advance(&gpu, &mut simulation, 7);
        simulation.apply(&settings).unwrap();
        advance(&gpu, &mut simulation, 2);
        simulation.set_pose(1, Some(pose)).unwrap();
        advance(&gpu, &mut simulation, 4);
        simulation
    };
    let mut through = begin();
    let mut first = begin();
    let checkpoint = Checkpoint::new(&scene, first.setup(), first.snapshot().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("moving.ckpt");
    checkpoint.write(&path).unwrap();
    let read = Checkpoint::read(&path).unwrap();
    assert_eq!(read, checkpoint);
    let changed = Scene {
        settings: settings.clone(),
        ..scene.clone()
    };
    let mut second = Simulation::new(&gpu.ctx, &changed).unwrap();
    second.restore(&read.snapshot).unwrap();
    assert_eq!(poses_on(&gpu, &second), poses_on(&gpu, &first));
    assert_eq!(second.time(), first.time());
    advance(&gpu, &mut second, 20);
    advance(&gpu, &mut through, 20);
    assert_eq!(
        second.snapshot().unwrap().hash(),
        through.snapshot().unwrap().hash()
    );
    assert_eq!(poses_on(&gpu, &second), poses_on(&gpu, &through));
    // Given back, the object is where its motion has it.
    second.set_pose(1, None).unwrap();
    first = second;
    advance(&gpu, &mut first, 1);
    let expected = changed.world_from_object_at(first.time())[1];
    assert_eq!(poses_on(&gpu, &first)[1], Pose::from(expected));
    gpu.finish();
}

/// Distances that are taken every few steps only are those of the same steps after an interruption between them.
#[test]
fn a_resumed_run_keeps_its_distances_until_they_are_due() {
    let Some(gpu) = gpu() else { return };
    let scene = moving(|s| {
        s.objects[1].position = [1.0, 0.0, 0.0];
        s.distance.interval = 4;
        s.physarum.distance_weight = 50.0;
    });
    let mut through = Simulation::new(&gpu.ctx, &scene).unwrap();
    advance(&gpu, &mut through, 6);
    let mut resumed = Simulation::new(&gpu.ctx, &scene).unwrap();
    resumed.restore(&through.snapshot().unwrap()).unwrap();
    for _ in 0..4 {
        advance(&gpu, &mut through, 1);
        advance(&gpu, &mut resumed, 1);
        let distances = |simulation: &Simulation| {
            let state = simulation.state();
            gpu.ctx.download(&state.near.distances).unwrap()
        };
        assert!(distances(&resumed) == distances(&through));
        let ends = [&resumed, &through].map(|simulation| simulation.snapshot().unwrap().hash());
        assert_eq!(ends[0], ends[1]);
    }
    gpu.finish();
}

/// As above, where poses are set and the time step changes between two steps in which distances are due: the poses at which
/// distances were taken do not follow from either.
#[test]
fn a_resumed_run_keeps_its_distances_whatever_has_moved_objects_since() {
    let Some(gpu) = gpu() else { return };
    let scene = moving(|s| {
        s.objects[1].position = [1.0, 0.0, 0.0];
        s.distance.interval = 5;
        s.physarum.distance_weight = 50.0;
    });
    let mut settings = scene.settings.clone();
    settings.time.dt = 0.3;
    let place = DVec3::new(0.4, 0.9, 0.1);
    let pose = DAffine3::from_rotation_translation(DQuat::from_rotation_x(0.7), place);
    let begin = || {
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        // Steps 0 and 5 take distances.
        advance(&gpu, &mut simulation, 6);
        simulation.set_pose(0, Some(pose)).unwrap();
        simulation.apply(&settings).unwrap();
        advance(&gpu, &mut simulation, 2);
        simulation
    };
    let (mut through, interrupted) = (begin(), begin());
    let half = interrupted.snapshot().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("between.ckpt");
    let checkpoint = Checkpoint::new(&scene, interrupted.setup(), half.clone());
    checkpoint.write(&path).unwrap();
    let read = Checkpoint::read(&path).unwrap();
    assert_eq!(read.snapshot, half);
    assert_ne!(half.distance_poses, poses_on(&gpu, &interrupted));
    // Poses of the last step are not those that are shown, once others have been set.
    let mut set = begin();
    set.set_pose(1, Some(pose)).unwrap();
    gpu.run(|rec| set.record_poses(rec));
    assert_eq!(set.snapshot().unwrap().last_poses, half.last_poses);
    assert_ne!(poses_on(&gpu, &set), half.last_poses);
    let changed = Scene { settings, ..scene };
    let mut resumed = Simulation::new(&gpu.ctx, &changed).unwrap();
    resumed.restore(&read.snapshot).unwrap();
    let mut twin = twin::Simulation::new(Setup::new(&changed).unwrap(), changed.settings.clone());
    twin.restore(&read.snapshot);
    let mut distances = Vec::new();
    for step in 8..12 {
        advance(&gpu, &mut through, 1);
        advance(&gpu, &mut resumed, 1);
        twin.step();
        let states = [&resumed, &through].map(|simulation| simulation.snapshot().unwrap());
        assert_eq!(states[0].hash(), states[1].hash(), "step {step}");
        assert_eq!(states[0].distance_poses, states[1].distance_poses);
        assert_eq!(states[0].last_poses, states[1].last_poses);
        let [before, uninterrupted] = [&resumed, &through].map(|simulation| {
            gpu.ctx
                .download(&simulation.state().objects.poses_before)
                .unwrap()
        });
        assert!(before == uninterrupted, "step {step}");
        assert_eq!(twin.snapshot().distance_poses, states[1].distance_poses);
        let [now, uninterrupted] = [&resumed, &through].map(|simulation| {
            gpu.ctx
                .download(&simulation.state().near.distances)
                .unwrap()
        });
        assert!(now == uninterrupted, "step {step}");
        distances.push(now);
    }
    assert!(distances[0] == distances[1] && distances[1] != distances[2]);

    // A run without them continues differently.
    let mut forgetful = half.clone();
    forgetful.distance_poses.clear();
    resumed.restore(&forgetful).unwrap();
    advance(&gpu, &mut resumed, 4);
    let elsewhere = resumed.snapshot().unwrap().hash();
    assert_ne!(elsewhere, through.snapshot().unwrap().hash());

    // Damaged, or of another scene.
    let mut none_rigid = half.clone();
    none_rigid.distance_poses[1].y.w = f32::NAN;
    let mut too_few = half.clone();
    too_few.distance_poses.pop();
    let mut none_of_the_step = half;
    none_of_the_step.last_poses.clear();
    for (damaged, words) in [
        (none_rigid, "has distances taken with"),
        (too_few, "has distances taken with"),
        (none_of_the_step, "has the poses of"),
    ] {
        let problem = resumed.restore(&damaged).unwrap_err().to_string();
        assert!(problem.contains(words), "{problem}");
        let checkpoint = Checkpoint::new(&changed, resumed.setup(), damaged);
        let problem = checkpoint.check(&changed, resumed.setup()).unwrap_err();
        assert!(problem.contains(words), "{problem}");
    }
    gpu.finish();
}

/// A pose that is set just before an interruption is none that the last step had: particles that the object moves over
/// in the next step change to it where it met them, also in the resumed run.
#[test]
fn a_resumed_run_knows_where_the_last_step_had_objects() {
    let Some(gpu) = gpu() else { return };
    let scene = moving(|s| {
        s.objects[1].position = [1.9, 0.0, 0.0];
        s.objects[1].motion.orbit = [0.0; 3];
        s.distance.reach = 0.5;
        s.physarum.speed = 0.02;
    });
    let closer = DAffine3::from_translation(DVec3::new(1.75, 0.1, 0.0));
    let mut through = Simulation::new(&gpu.ctx, &scene).unwrap();
    let mut twin = twin::Simulation::new(Setup::new(&scene).unwrap(), scene.settings.clone());
    advance(&gpu, &mut through, 5);
    (0..5).for_each(|_| twin.step());
    assert_eq!(
        through.snapshot().unwrap().last_poses,
        twin.snapshot().last_poses
    );
    through.set_pose(1, Some(closer)).unwrap();
    let half = through.snapshot().unwrap();
    assert_eq!(half.last_poses, poses_on(&gpu, &through));
    let mut resumed = Simulation::new(&gpu.ctx, &scene).unwrap();
    resumed.restore(&half).unwrap();
    // As if the last step had had it there already.
    let mut mistaken = half.clone();
    mistaken.last_poses[1] = Pose::from(Affine3A::from_translation(Vec3::new(1.75, 0.1, 0.0)));
    let mut wrong = Simulation::new(&gpu.ctx, &scene).unwrap();
    wrong.restore(&mistaken).unwrap();
    let ends = [&mut through, &mut resumed, &mut wrong].map(|simulation| {
        advance(&gpu, simulation, 3);
        simulation.snapshot().unwrap().hash()
    });
    assert_eq!(ends[1], ends[0]);
    assert_ne!(ends[2], ends[0], "the scene shows the difference");

    let mut damaged = half;
    damaged.last_poses[0].x.x = 2.0;
    let problem = resumed.restore(&damaged).unwrap_err().to_string();
    assert!(problem.contains("or they are damaged"), "{problem}");
    gpu.finish();
}

/// Single precision is spent on what lies between the objects, and none on how far from the origin they are. Would catch: a
/// pose, centre of an orbit, start or pose from outside that is not counted from the scene's origin.
#[test]
fn a_scene_far_away_keeps_its_bits() {
    let Some(gpu) = gpu() else { return };
    // Multiples of what coordinates are counted from here, a power of two; and no decimals that it would round.
    let far = DVec3::new(1e7, -3_200_000.0, 5_412_352.0);
    let together = |by: DVec3| {
        moving(|settings| {
            settings.objects[1].position = (by + DVec3::new(1.75, 0.25, 0.0)).to_array();
            settings.objects[1].motion.orbit_center = by.to_array();
            settings.objects[0].position = by.to_array();
        })
    };
    let run = |by: DVec3| {
        let scene = together(by);
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        advance(&gpu, &mut simulation, 30);
        let turn = DQuat::from_rotation_z(0.3);
        let pose = DAffine3::from_rotation_translation(turn, by + DVec3::new(0.0, 0.5, 0.25));
        simulation.set_pose(0, Some(pose)).unwrap();
        advance(&gpu, &mut simulation, 10);
        let snapshot = simulation.snapshot().unwrap();
        assert!(snapshot.transfers.flow.arrived > 0, "they touch");
        (scene, simulation.world_from_object(), snapshot.hash())
    };
    let (near, poses, hash) = run(DVec3::ZERO);
    assert_eq!(near.origins[0].world, DVec3::ZERO);
    let (afar, poses_afar, hash_afar) = run(far);
    assert_eq!(afar.origins[0].world, far);
    assert_eq!((near.center, near.radius), (afar.center, afar.radius));
    assert_eq!((poses, hash), (poses_afar, hash_afar));
    gpu.finish();
}

/// Between steps, pictures show poses that were set from outside.
#[test]
fn poses_come_without_a_step() {
    let Some(gpu) = gpu() else { return };
    let scene = moving(|_| ());
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let pose = DAffine3::from_translation(DVec3::new(0.0, 5.0, 0.0));
    simulation.set_pose(0, Some(pose)).unwrap();
    gpu.run(|rec| simulation.record_poses(rec));
    assert_eq!(poses_on(&gpu, &simulation)[0].y.w, 5.0);
    assert_eq!(simulation.step(), 0);
    assert_eq!(simulation.world_from_object()[0].translation.y, 5.0);
    assert!(simulation.set_pose(2, None).is_err(), "there are two");
    gpu.finish();
}

/// Identical objects in one place, and one inside the other, are odd and allowed.
#[test]
fn objects_in_one_place_run() {
    let Some(gpu) = gpu() else { return };
    for scale in [1.0, 0.3] {
        let scene = moving(|s| {
            s.objects[1] = s.objects[0].clone();
            s.objects[1].scale = scale;
        });
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        advance(&gpu, &mut simulation, 5);
        simulation
            .snapshot()
            .unwrap()
            .validate(simulation.setup())
            .unwrap();
    }
    gpu.finish();
}

/// A triangle whose node goes from the origin to (2, 0, 0) and turns by 90 degrees about Y in two seconds, under a
/// parent that doubles it.
fn model(folder: &Path, scale_keys: &str, extra_nodes: &str, roots: &str) -> String {
    let mut data = Vec::new();
    let mut put = |values: &[f32]| {
        let offset = data.len();
        data.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        (offset, data.len() - offset)
    };
    let half = 0.5_f32.sqrt();
    let views = [
        put(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]),
        put(&[0.0, 2.0]),
        put(&[0.0, 0.0, 0.0, 2.0, 0.0, 0.0]),
        put(&[0.0, 0.0, 0.0, 1.0, 0.0, half, 0.0, half]),
        put(&[1.0, 1.0, 1.0, 1.0, 2.0, 1.0]),
    ];
    let views: Vec<String> = views
        .iter()
        .map(|(offset, length)| {
            format!("{{\"buffer\":0,\"byteOffset\":{offset},\"byteLength\":{length}}}")
        })
        .collect();
    std::fs::write(folder.join("model.bin"), &data).unwrap();
    format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[{roots}]}}],\
         \"nodes\":[{{\"children\":[1],\"scale\":[2,2,2]}},{{\"mesh\":0}}{extra_nodes}],\
         \"meshes\":[{{\"primitives\":[{{\"attributes\":{{\"POSITION\":0}}}}]}}],\
         \"animations\":[{{\"channels\":[{{\"sampler\":0,\"target\":{{\"node\":1,\"path\":\"translation\"}}}},\
         {{\"sampler\":1,\"target\":{{\"node\":1,\"path\":\"rotation\"}}}}{scale_keys}],\
         \"samplers\":[{{\"input\":1,\"output\":2}},{{\"input\":1,\"output\":3}},{{\"input\":1,\"output\":4}}]}}],\
         \"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,0,1]}},\
         {{\"bufferView\":1,\"componentType\":5126,\"count\":2,\"type\":\"SCALAR\",\"min\":[0],\"max\":[2]}},\
         {{\"bufferView\":2,\"componentType\":5126,\"count\":2,\"type\":\"VEC3\"}},\
         {{\"bufferView\":3,\"componentType\":5126,\"count\":2,\"type\":\"VEC4\"}},\
         {{\"bufferView\":4,\"componentType\":5126,\"count\":2,\"type\":\"VEC3\"}}],\
         \"bufferViews\":[{}],\
         \"buffers\":[{{\"byteLength\":{},\"uri\":\"model.bin\"}}]}}",
        views.join(","),
        data.len()
    )
}

fn follow(folder: &Path, text: &str, mesh: &str) -> Result<Scene, String> {
    std::fs::write(folder.join("model.gltf"), text).unwrap();
    let scene = format!(
        "[[object]]\nmesh = \"{mesh}\"\nposition = [0, 1, 0]\nscale = 0.5\nmotion = {{ model = \"follow\" }}\n"
    );
    let path = folder.join("scene.toml");
    std::fs::write(&path, scene).unwrap();
    Scene::load(&path, &Overrides::default()).map_err(|error| error.to_string())
}

/// If surfaces move into each other, most selected particles have crossed the line in which they meet.
#[test]
fn most_go_over_the_line_in_which_surfaces_meet() {
    let Some(gpu) = gpu() else { return };
    let set = [
        &COARSE_TRIO[..],
        &["particles.count=20000", "atlas.size=512"],
    ]
    .concat();
    let overrides = Overrides {
        set: set.into_iter().map(str::to_owned).collect(),
        ..Overrides::default()
    };
    let scene = Scene::load("trio".as_ref(), &overrides).unwrap();
    let setup = set_up(&gpu.ctx, &scene);
    let mut simulation = Simulation::from_setup(&gpu.ctx, &scene, setup).unwrap();
    let flow = |simulation: &Simulation| simulation.snapshot().unwrap().transfers.flow;
    // Particles that begin at covered places have crossed nothing.
    advance(&gpu, &mut simulation, 20);
    let before = flow(&simulation);
    // The beam tilts on the ball, and its end goes into the ring.
    advance(&gpu, &mut simulation, 130);
    let after = flow(&simulation);
    let selected = after.selected - before.selected;
    let crossed = after.crossed - before.crossed;
    assert!(selected > 1500, "{selected}");
    assert!(
        f64::from(crossed) > 0.85 * f64::from(selected),
        "{crossed} of {selected}"
    );
    gpu.finish();
}

#[test]
fn objects_follow_their_models_animation() {
    let folder = tempfile::tempdir().unwrap();
    let scene = follow(
        folder.path(),
        &model(folder.path(), "", "", "0"),
        "model.gltf",
    )
    .unwrap();
    // The parent doubles the way, the object's scale halves it.
    for (time, x, degrees) in [
        (0.0, 0.0, 0.0),
        (1.0, 1.0, 45.0),
        (1.5, 1.5, 67.5),
        (5.0, 1.0, 45.0),
    ] {
        let pose = scene.world_from_object_at(time)[0];
        let place = pose.translation;
        assert!(
            (place - glam::Vec3A::new(2.0 * 0.5 * x, 1.0, 0.0)).length() < 1e-5,
            "{time}: {place}"
        );
        let turned = pose.transform_vector3(glam::Vec3::X);
        let (sin, cos) = f32::to_radians(degrees).sin_cos();
        assert!(
            turned.distance(glam::Vec3::new(cos, 0.0, -sin)) < 1e-5,
            "{time}: {turned}"
        );
    }
}

#[test]
fn animations_that_are_not_rigid_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let scaling = ",{\"sampler\":2,\"target\":{\"node\":1,\"path\":\"scale\"}}";
    let hand = root().join("assets/hand_animated.glb");
    let hand = hand.to_str().expect("folders of tests are Unicode");
    for (text, mesh, words) in [
        (
            model(folder.path(), scaling, "", "0"),
            "model.gltf",
            "scales or skews the model",
        ),
        (
            model(folder.path(), "", ",{\"mesh\":0}", "0,2"),
            "model.gltf",
            "its parts have moved differently",
        ),
        (
            model(folder.path(), "", "", "0").replace("\"animations\"", "\"other\""),
            "model.gltf",
            "has no animation",
        ),
        (
            model(folder.path(), "", "", "0").replace("\"node\":1,\"path\"", "\"node\":7,\"path\""),
            "model.gltf",
            "node 7",
        ),
        (String::new(), "builtin:torus", "only glTF models"),
        (String::new(), hand, "skinned"),
    ] {
        let error = follow(folder.path(), &text, mesh).unwrap_err();
        assert!(error.contains(words), "{error}");
    }
}
