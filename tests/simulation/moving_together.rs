//! Objects that move together stand to each other as before, whatever rounding makes of their poses: their distances are not
//! taken again, and a run that was interrupted continues with the very same ones.

use crate::common::{Gpu, gpu, scene_of_several};
use glam::{DAffine3, DVec3};
use myxo::gpu::Frames;
use myxo::scene::Scene;
use myxo::scene::settings::Settings;
use myxo::sim::checkpoint::Checkpoint;
use myxo::sim::distance::{DistancePlanner, DistanceUpdate};
use myxo::sim::plan::{Means, Plan};
use myxo::sim::types::Pose;
use myxo::sim::{Setup, Simulation, twin};

const TORUS: &str = "torus?major=24&minor=16";

/// Two tori that touch.
fn tori(change: impl FnOnce(&mut Settings)) -> Scene {
    scene_of_several(&[(TORUS, [0.3, 0.0, 0.0]), (TORUS, [2.9, 0.4, 0.1])], |s| {
        s.particles.count = 2000;
        s.atlas.size = 128;
        change(s);
    })
}

/// They go round together, and a third one that turns touches the second one only.
fn two_and_one(change: impl FnOnce(&mut Settings)) -> Scene {
    let objects = [
        (TORUS, [0.3, 0.0, 0.0]),
        (TORUS, [2.9, 0.4, 0.1]),
        ("cube?divisions=4", [5.0, 0.4, 0.1]),
    ];
    scene_of_several(&objects, |s| {
        s.particles.count = 2000;
        s.atlas.size = 128;
        s.radius = 3.0;
        s.distance.reach = 0.1;
        for object in &mut s.objects {
            object.motion.orbit = [0.0, 40.0, 0.0];
        }
        s.objects[2].motion.spin = [0.0, 60.0, 0.0];
        change(s);
    })
}

/// What the steps of a scene take of its distances.
fn updates(scene: &Scene, steps: u64) -> Vec<DistanceUpdate> {
    let setup = Setup::new(scene).unwrap();
    let mut planner = DistancePlanner::default();
    let settings = &scene.settings;
    (0..steps)
        .map(|step| {
            let mut plan = Plan::new(settings, &setup, step, Means::of_host(false, 1));
            let poses = poses(scene, step);
            plan.update_distances(&mut planner, step, &poses);
            plan.distances
        })
        .collect()
}

fn poses(scene: &Scene, step: u64) -> Vec<Pose> {
    let time = step as f64 * f64::from(scene.settings.time.dt);
    let poses = scene.world_from_object_at(time).into_iter();
    poses.map(Pose::from).collect()
}

/// How the first object of a scene stands to another one.
fn relative(scene: &Scene, other: usize, step: u64) -> DAffine3 {
    let poses: Vec<_> = poses(scene, step).iter().map(DAffine3::from).collect();
    poses[other].inverse() * poses[0]
}

fn advance(gpu: &Gpu, simulation: &mut Simulation, steps: u32) -> Frames {
    let mut frames = Frames::new(&gpu.ctx, 2).unwrap();
    for _ in 0..steps {
        let mut rec = frames.begin().unwrap();
        simulation.record_step(&mut rec);
        frames.submit(rec).unwrap();
    }
    frames.wait_idle().unwrap();
    frames
}

#[test]
fn distances_of_objects_that_move_together_are_taken_once() {
    let ways: [fn(&mut Settings); 5] = [
        |s| s.objects[0].motion.orbit = [0.0, 40.0, 0.0],
        |s| s.objects[0].motion.slide = [1.5, 0.7, -0.2],
        |s| {
            s.objects[0].motion.orbit = [20.0, 40.0, 10.0];
            s.objects[0].motion.orbit_center = [30.0, -20.0, 5.0];
        },
        |s| {
            s.objects[0].motion.orbit = [0.0, 0.0, 75.0];
            s.objects[0].motion.slide = [200.0, 0.0, 0.0];
        },
        // Large objects, and small ones.
        |s| {
            s.objects[0].motion.orbit = [0.0, 40.0, 0.0];
            for object in &mut s.objects {
                object.scale = 100.0;
                object.position = object.position.map(|x| 100.0 * x);
            }
        },
    ];
    for (way, change) in ways.into_iter().enumerate() {
        let scene = tori(|s| {
            change(s);
            s.objects[1].motion = s.objects[0].motion.clone();
        });
        let steps = 600;
        let updates = updates(&scene, steps);
        assert_eq!((updates[0].jobs.len(), updates[0].pairs.len()), (2, 2));
        let again = updates[1..].iter().filter(|u| !u.jobs.is_empty()).count();
        assert_eq!(again, 0, "way {way}");
        // Rounding has made most of them differ.
        let first = relative(&scene, 1, 0);
        let differ = (1..steps).filter(|&step| relative(&scene, 1, step) != first);
        assert!(differ.count() > 400, "way {way}");
    }
}

#[test]
fn those_that_stay_together_are_left_out_while_others_move() {
    let updates = updates(&two_and_one(|_| ()), 200);
    assert_eq!(updates[0].objects, [0, 1, 2]);
    let together = updates[0].pairs[1];
    for update in &updates[1..] {
        assert_eq!(update.objects, [1, 2]);
        assert_eq!(update.pairs.len(), 3);
        assert_eq!(update.pairs[0], together, "the second one's to the first");
    }
}

/// What moves by less than rounding in a step has moved by more after some of them.
#[test]
fn slow_motion_is_taken_up_at_last() {
    let scene = tori(|s| {
        s.objects[1].motion.slide = [0.01, 0.0, 0.0];
        s.objects[1].motion.slide_period = 10_000.0;
    });
    let steps = 400;
    let first = relative(&scene, 1, 0).translation;
    let end = relative(&scene, 1, steps).translation;
    let way = first.distance(end);
    assert!((3e-5..6e-5).contains(&way), "{way}");
    let mut taken = 0;
    let mut last = first;
    for (step, update) in updates(&scene, steps).iter().enumerate() {
        if let Some(pair) = update.pairs.first() {
            taken += 1;
            last = DVec3::new(pair.x.w.into(), pair.y.w.into(), pair.z.w.into());
        }
        // Rounding of a place some lengths from the origin, several times over.
        let off = last.distance(relative(&scene, 1, step as u64).translation);
        assert!(off < 5e-6, "step {step}: {off}");
    }
    assert!((5..40).contains(&taken), "{taken} of {steps} steps");
}

/// A pair of which both move on by themselves is taken in every step, as its poses are.
#[test]
fn what_moves_is_taken_where_it_is() {
    let scene = tori(|s| s.objects[1].motion.swing = [0.0, 0.0, 2.0]);
    for (step, update) in updates(&scene, 30).iter().enumerate() {
        let pair = update.pairs[0];
        let rows = glam::DMat4::from(relative(&scene, 1, step as u64));
        let rows = rows.transpose().as_mat4();
        assert_eq!(
            [pair.x, pair.y, pair.z],
            [rows.x_axis, rows.y_axis, rows.z_axis]
        );
    }
}

#[test]
fn no_kernel_runs_for_them_on_the_device() {
    let Some(gpu) = gpu() else { return };
    let scene = tori(|s| {
        for object in &mut s.objects {
            object.motion.orbit = [0.0, 40.0, 0.0];
        }
    });
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let frames = advance(&gpu, &mut simulation, 30);
    if gpu.ctx.info().has_timestamps() {
        let spans = frames.timings().frames().flatten();
        let names: Vec<&str> = spans.map(|span| span.name.as_str()).collect();
        let count = |kernel: &str| names.iter().filter(|&&name| name == kernel).count();
        let of = ["distance_tiles", "distance", "unfold", "diffuse"].map(count);
        assert_eq!(of, [1, 1, 1, 30]);
    }
    simulation
        .snapshot()
        .unwrap()
        .validate(simulation.setup())
        .unwrap();
    gpu.finish();
}

/// Distances that were kept are those of poses that no object has any more. They are the same after an interruption.
#[test]
fn a_resumed_run_keeps_what_was_kept() {
    let Some(gpu) = gpu() else { return };
    let scene = two_and_one(|s| s.physarum.distance_weight = 50.0);
    let mut through = Simulation::new(&gpu.ctx, &scene).unwrap();
    advance(&gpu, &mut through, 17);
    let half = through.snapshot().unwrap();
    let kept: Vec<_> = half
        .kept_pairs
        .iter()
        .map(|p| (p.object, p.other))
        .collect();
    assert_eq!(kept, [(0, 1), (1, 0)]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("together.ckpt");
    Checkpoint::new(&scene, through.setup(), half.clone())
        .write(&path)
        .unwrap();
    let read = Checkpoint::read(&path).unwrap().snapshot;
    assert_eq!(read, half);
    let mut resumed = Simulation::new(&gpu.ctx, &scene).unwrap();
    resumed.restore(&read).unwrap();
    let mut forgetful = Simulation::new(&gpu.ctx, &scene).unwrap();
    let mut without = half.clone();
    without.kept_pairs.clear();
    forgetful.restore(&without).unwrap();
    let mut by_twin = twin::Simulation::new(through.setup().clone(), scene.settings.clone());
    by_twin.restore(&read);
    let mut settings = scene.settings.clone();
    for step in 17..27 {
        if step == 22 {
            // All are taken again, with the poses that they were taken with.
            settings.distance.reach = 0.12;
            through.apply(&settings).unwrap();
            resumed.apply(&settings).unwrap();
            let state = by_twin.snapshot();
            by_twin = twin::Simulation::new(through.setup().clone(), settings.clone());
            by_twin.restore(&state);
        }
        advance(&gpu, &mut through, 1);
        advance(&gpu, &mut resumed, 1);
        by_twin.step();
        let distances = [&through, &resumed].map(|s| s.distances().unwrap().unwrap());
        assert!(distances[0] == distances[1], "step {step}");
        let [uninterrupted, state] = [&through, &resumed].map(|s| s.snapshot().unwrap());
        assert_eq!(state.hash(), uninterrupted.hash(), "step {step}");
        assert_eq!(state.kept_pairs, uninterrupted.kept_pairs);
        assert_eq!(by_twin.snapshot().kept_pairs, uninterrupted.kept_pairs);
        if step == 17 {
            advance(&gpu, &mut forgetful, 1);
            let elsewhere = forgetful.distances().unwrap().unwrap();
            assert!(elsewhere != distances[0], "they would be others");
        }
    }

    // Damaged, or of another scene.
    let damages: [fn(&mut myxo::sim::Snapshot); 3] = [
        |s| s.kept_pairs[0].other_from_object.y.w = f32::NAN,
        |s| s.kept_pairs[0].object = 3,
        |s| s.kept_pairs[1].other = u32::MAX,
    ];
    for damage in damages {
        let mut damaged = half.clone();
        damage(&mut damaged);
        let problem = resumed.restore(&damaged).unwrap_err().to_string();
        assert!(problem.contains("has distances taken with"), "{problem}");
    }
    gpu.finish();
}
