//! What sensors see on another object: the kernel against its twin, and against folds that can be worked out.

use glam::{DAffine3, DQuat, DVec3};
use myxo::mesh::surface::NONE;
use myxo::scene::Scene;
use myxo::scene::settings::{Settings, Strategy};
use myxo::sim::field::unpacked_position;
use myxo::sim::ground::Ground;
use myxo::sim::{COVERED, Setup, Simulation, twin};

use super::scene;
use crate::bits::assert_same_bits;
use crate::common::{Gpu, by_id, gpu};

#[test]
fn unfold_agrees_with_its_twin() {
    let Some(gpu) = gpu() else { return };
    let meshes = [
        ("torus?major=12&minor=8", [0.0; 3]),
        ("icosphere?subdivisions=2", [0.5, 0.3, 0.1]),
        ("plane?columns=4&rows=3", [0.1, -0.1, 0.0]),
    ];
    for threshold in [0.0, 0.05] {
        let scene = scene(&meshes, |s| {
            s.physarum.sensor_offset = 0.15;
            s.transfer.threshold = threshold;
        });
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        gpu.run(|rec| simulation.record_step(rec));
        let kernel = places_across(&gpu, &simulation);
        let mut twin = twin::Simulation::new(simulation.setup().clone(), scene.settings.clone());
        twin.step();
        let twin = twin.across();
        let known = twin.iter().filter(|&&place| place != NONE).count();
        assert!(known > 200, "{known}");
        assert_same_bits("across", &kernel, &twin);
    }
    gpu.finish();
}

/// The place across that sensors read at each texel.
fn places_across(gpu: &Gpu, simulation: &Simulation) -> Vec<u32> {
    let across = gpu.ctx.download(&simulation.state().across.places).unwrap();
    let surroundings = gpu
        .ctx
        .download(&simulation.state().across.surroundings)
        .unwrap();
    let surroundings: &[u16] = bytemuck::cast_slice(&surroundings);
    let texels = across.iter().zip(surroundings);
    texels
        .map(|(&place, around)| if around & COVERED == 0 { NONE } else { place })
        .collect()
}

/// The place in the world of the texel that holds an atlas position.
fn place_at(setup: &Setup, poses: &[DAffine3], [x, y]: [f32; 2]) -> Option<(usize, DVec3)> {
    let texel = y as u32 * setup.atlas.pitch + x as u32;
    place_of(setup, poses, texel)
}

fn place_of(setup: &Setup, poses: &[DAffine3], texel: u32) -> Option<(usize, DVec3)> {
    let (triangle, u, v) = setup.atlas.surface_point_of(texel)?;
    let surface = &setup.surface;
    let corners = surface.corners[triangle as usize];
    let [a, b, c] = corners.map(|corner| surface.positions[corner as usize].as_dvec3());
    let object = surface.triangles[triangle as usize].object as usize;
    let place = a + f64::from(u) * (b - a) + f64::from(v) * (c - a);
    Some((object, poses[object].transform_point3(place)))
}

/// Two squares that cross at an angle: what lies behind the line on one is seen as far above it on the other, on the
/// side that the first one's normal points to.
#[test]
fn what_lies_behind_the_line_is_seen_beyond_it() {
    let Some(gpu) = gpu() else { return };
    let meshes = [
        ("plane?columns=3&rows=2", [0.0; 3]),
        ("plane?columns=5&rows=7", [0.0; 3]),
    ];
    let scene = scene(&meshes, |s| {
        s.physarum.sensor_offset = 0.3;
        s.distance.reach = 1.0;
    });
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let anywhere = DAffine3::from_rotation_translation(
        DQuat::from_axis_angle(DVec3::new(1.0, -2.0, 0.5).normalize(), 2.2),
        DVec3::new(0.1, -0.2, 0.3),
    );
    for angle in [30.0_f64, 60.0, 90.0, 120.0] {
        let turn = DQuat::from_axis_angle(DVec3::new(0.8, 0.0, -0.6), angle.to_radians());
        let poses = [anywhere, anywhere * DAffine3::from_quat(turn)];
        for (object, pose) in poses.into_iter().enumerate() {
            simulation.set_pose(object, Some(pose)).unwrap();
        }
        gpu.run(|rec| simulation.record_step(rec));
        let across = places_across(&gpu, &simulation);
        let setup = simulation.setup();
        let line = anywhere.matrix3 * DVec3::new(0.8, 0.0, -0.6);
        let normals = poses.map(|pose| pose.matrix3 * DVec3::Y);
        let texel_size = 2.0 * (2.0 / across.len() as f64).sqrt();
        let (mut seen, mut above) = (0, 0);
        for (texel, &word) in across.iter().enumerate() {
            let Some((own, place)) = place_of(setup, &poses, texel as u32) else {
                assert_eq!(word, NONE, "a gutter texel");
                continue;
            };
            let other = 1 - own;
            let from_line = place - anywhere.translation;
            if from_line.dot(normals[other]) > 1e-3 {
                assert_eq!(word, NONE, "nothing covers it");
                above += 1;
                continue;
            }
            if word == NONE {
                continue;
            }
            let foot = from_line.dot(line) * line;
            let behind = (from_line - foot).length();
            let up = normals[other].cross(line);
            let up = up * up.dot(normals[own]).signum();
            let expected = anywhere.translation + foot + behind * up;
            let Some((object, found)) =
                place_at(setup, &poses, unpacked_position(word, setup.atlas.pitch))
            else {
                continue;
            };
            assert_eq!(object, other);
            let off = found.distance(expected);
            let inside = anywhere.inverse().transform_point3(expected).abs();
            // Beyond the border of the other square walks come back.
            if inside.max_element() < 0.9 {
                seen += 1;
                assert!(
                    off < 2.0 * texel_size,
                    "{angle} degrees: {off} of {texel_size}"
                );
            }
        }
        assert!(
            seen > 100 && above > 1000,
            "{angle} degrees: {seen}, {above}"
        );
    }
    gpu.finish();
}

/// Sensors see other objects where particles change to them, and only there.
#[test]
fn only_objects_with_transfers_see_across() {
    let Some(gpu) = gpu() else { return };
    let meshes = [("cube", [0.0; 3]), ("cube", [1.0, 0.3, 0.2])];
    for &strategy in Strategy::ALL {
        let scene = scene(&meshes, |s| s.transfer.strategy = strategy);
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        gpu.run(|rec| simulation.record_step(rec));
        let across = places_across(&gpu, &simulation);
        let sees = across.iter().any(|&word| word != NONE);
        let changes = !matches!(strategy, Strategy::None | Strategy::Respawn);
        assert_eq!(sees, changes, "{strategy:?}");
    }
    gpu.finish();
}

/// Settings that say what is seen take effect though nothing has moved.
#[test]
fn what_is_seen_follows_changed_settings() {
    let Some(gpu) = gpu() else { return };
    let meshes = [("cube", [0.0; 3]), ("cube", [1.0, 0.3, 0.2])];
    let scene = scene(&meshes, |s| s.physarum.sensor_offset = 0.05);
    let seen = |settings: &Settings, before: Option<&Settings>| {
        let first = before.unwrap_or(settings);
        let scene = Scene::from_settings("test".to_owned(), first.clone(), ".".into()).unwrap();
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        gpu.run(|rec| simulation.record_step(rec));
        simulation.apply(settings).unwrap();
        gpu.run(|rec| simulation.record_step(rec));
        places_across(&gpu, &simulation)
    };
    let fresh = seen(&scene.settings, None);
    let mut others = vec![scene.settings.clone(); 3];
    others[0].transfer.strategy = Strategy::None;
    others[1].physarum.sensor_offset = 0.2;
    others[2].transfer.threshold = -0.01;
    for other in &others {
        assert!(seen(&scene.settings, Some(other)) == fresh);
        assert!(seen(other, None) != fresh);
    }
    gpu.finish();
}

/// A particle that stays on a floor with a wall through it.
struct OnFloor {
    /// How far it is from the wall's front, as part of the sensors' offset; negative behind it.
    before_wall: f32,
    /// Cosine between its heading and the way to the wall: 1 head on, -1 away from it.
    to_wall: f32,
    /// `to_wall` after a step.
    to_wall_after: f32,
    /// Has its heading changed in the step?
    has_turned: bool,
}

/// What is on each texel of the wall.
#[derive(Clone, Copy)]
enum OnWall {
    Nothing,
    /// The count of particles of the last step.
    Crowd(u32),
    /// The trail.
    Trail(f32),
}

/// Those of a floor with a wall through it, in a first step that they hardly move in.
fn on_floor(gpu: &Gpu, wall: OnWall, change: impl FnOnce(&mut Settings)) -> Vec<OnFloor> {
    const SENSOR_OFFSET: f32 = 0.1;
    let meshes = [
        ("plane?columns=4&rows=4", [0.0; 3]),
        ("plane?columns=3&rows=5", [0.0; 3]),
    ];
    let scene = scene(&meshes, |s| {
        s.particles.count = 4000;
        s.physarum.sensor_offset = SENSOR_OFFSET;
        s.physarum.speed = 0.001;
        s.objects[0].rotation = [0.0; 3];
        s.objects[1].rotation = [0.0, 0.0, 90.0];
        change(s);
    });
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let first = simulation.setup().surface.objects[1].triangles.0;
    let mut before = simulation.snapshot().unwrap();
    let mut counts = before.deposits.clone();
    let owners = &simulation.setup().atlas.owner;
    let is_wall = |texel: usize| owners[texel] != NONE && owners[texel] >= first;
    for texel in (0..owners.len()).filter(|texel| is_wall(*texel)) {
        match wall {
            OnWall::Nothing => {}
            OnWall::Crowd(count) => counts[texel] = count,
            OnWall::Trail(amount) => before.trail[texel] = amount,
        }
    }
    simulation.restore(&before).unwrap();
    // More than particles leave, which no state may have.
    let deposits = &simulation.state().deposits.back;
    gpu.ctx.upload(deposits, &counts).unwrap();
    gpu.run(|rec| simulation.record_step(rec));
    let after = simulation.snapshot().unwrap();
    let setup = simulation.setup();
    let ground = Ground::of(setup, &setup.poses);
    let scale = setup.surface.positions[0].abs().max_element();
    let mut found = Vec::new();
    for ((a, a_motion), (b, b_motion)) in by_id(&before).iter().zip(&by_id(&after)) {
        if a.triangle >= first || b.triangle >= first {
            continue;
        }
        let a = ground.flight(a, a_motion);
        let b = ground.flight(b, b_motion);
        // At the floor's border headings turn back.
        if a.position.abs().max_element() < 0.95 * scale {
            // The wall's front looks along -X.
            found.push(OnFloor {
                before_wall: -a.position.x / (SENSOR_OFFSET * setup.radius),
                to_wall: -a.position.x.signum() * a.heading.x,
                to_wall_after: -a.position.x.signum() * b.heading.x,
                has_turned: a.heading.dot(b.heading) < 0.999,
            });
        }
    }
    found
}

/// How many have turned, and how many of these to the wall.
fn turned_to_wall(all: &[OnFloor]) -> (usize, usize) {
    let turned = || all.iter().filter(|particle| particle.has_turned);
    let to_wall = turned().filter(|particle| particle.to_wall_after > particle.to_wall);
    (turned().count(), to_wall.count())
}

/// Particles that want up: on the floor there is no up, but behind the wall sensors read the height on the wall at which
/// they would be. Particles near the wall turn to it, if they can change to it.
#[test]
fn gravity_pulls_up_a_wall_that_is_near() {
    let Some(gpu) = gpu() else { return };
    for strategy in [Strategy::None, Strategy::Direct] {
        let all = on_floor(&gpu, OnWall::Nothing, |s| {
            s.physarum.gravity_weight = 1000.0;
            s.transfer.strategy = strategy;
        });
        let (turned, to_wall) = turned_to_wall(&all);
        if strategy == Strategy::None {
            assert_eq!(turned, 0, "a floor is level");
        } else {
            assert!(
                // Some texels beside seams have no place across.
                turned > 20 && to_wall * 10 > turned * 9,
                "{to_wall} of {turned} to the wall"
            );
        }
    }
    gpu.finish();
}

/// Trail on the wall draws those on the floor to it, if they can change to it; else they do not know of it.
#[test]
fn trail_on_a_wall_draws_others_from_the_floor() {
    let Some(gpu) = gpu() else { return };
    for (strategy, wall) in [
        (Strategy::None, OnWall::Trail(50.0)),
        (Strategy::Direct, OnWall::Nothing),
        (Strategy::Direct, OnWall::Trail(50.0)),
        (Strategy::Parallel, OnWall::Trail(50.0)),
    ] {
        let all = on_floor(&gpu, wall, |s| {
            s.particles.count = 30_000;
            s.atlas.size = 256;
            s.transfer.strategy = strategy;
        });
        let (turned, to_wall) = turned_to_wall(&all);
        if strategy == Strategy::None || matches!(wall, OnWall::Nothing) {
            assert_eq!(turned, 0, "there is no trail on the floor");
        } else {
            assert!(
                // Some texels beside seams have no place across.
                turned > 100 && to_wall * 10 > turned * 9,
                "{strategy:?}: {to_wall} of {turned} to the wall"
            );
        }
    }
    gpu.finish();
}

/// A crowd on the wall keeps those on the floor away from it, if they can change to it; else it is none of their business.
#[test]
fn a_crowd_on_a_wall_keeps_others_on_the_floor() {
    let Some(gpu) = gpu() else { return };
    for (strategy, crowd) in [
        (Strategy::None, 50),
        (Strategy::Direct, 0),
        (Strategy::Direct, 50),
        (Strategy::Parallel, 50),
    ] {
        let all = on_floor(&gpu, OnWall::Crowd(crowd), |s| {
            s.particles.count = 30_000;
            s.atlas.size = 256;
            s.physarum.decrowding_weight = 10.0;
            s.transfer.strategy = strategy;
        });
        let (turned, to_wall) = turned_to_wall(&all);
        if strategy == Strategy::None || crowd == 0 {
            assert_eq!(turned, 0, "no particle is on the floor's texels");
        } else {
            assert!(
                // Counts on gutter texels are not read.
                turned > 100 && to_wall * 4 < turned,
                "{strategy:?}: {to_wall} of {turned} to the wall"
            );
        }
    }
    gpu.finish();
}

/// Particles that keep away from other objects turn round before a wall, since behind it they would be inside of it.
/// Those that can change to it would be on it instead: the farther up, the farther from the floor.
#[test]
fn far_up_a_wall_is_far_from_the_floor() {
    let Some(gpu) = gpu() else { return };
    for strategy in [Strategy::None, Strategy::Direct] {
        let all = on_floor(&gpu, OnWall::Nothing, |s| {
            s.particles.count = 30_000;
            s.atlas.size = 256;
            s.physarum.distance_weight = 1000.0;
            s.transfer.strategy = strategy;
        });
        // All three sensors of these are behind the wall.
        let near: Vec<_> = all
            .into_iter()
            .filter(|particle| {
                (0.05..0.3).contains(&particle.before_wall) && particle.to_wall > 0.9
            })
            .collect();
        let away = near
            .iter()
            .filter(|particle| particle.to_wall_after < particle.to_wall - 1e-3)
            .count();
        let of = near.len();
        assert!(of > 20, "{of} are near");
        if strategy == Strategy::None {
            assert!(away * 10 > of * 9, "{away} of {of} turn away");
        } else {
            assert!(away * 10 < of, "{away} of {of} turn away");
        }
    }
    gpu.finish();
}
