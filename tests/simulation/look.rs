//! The second look: both engines, where it takes effect and how much, and what is kept of it.

use crate::advance;
use crate::common::{Gpu, TRIO, by_id, gpu, scene, scene_of_several};
use glam::Vec3;
use myxo::gpu::{Context, Frames};
use myxo::scene::Scene;
use myxo::scene::settings::{Sensing, Settings, Strategy};
use myxo::sim::behaviour::physarums;
use myxo::sim::carry::carried;
use myxo::sim::checkpoint::Checkpoint;
use myxo::sim::ground::Ground;
use myxo::sim::paint::{Brush, Dab, Painted};
use myxo::sim::{Setup, Simulation, twin};

fn trio(change: impl FnOnce(&mut Settings)) -> Scene {
    scene_of_several(&TRIO, |s| {
        s.particles.count = 3000;
        s.atlas.size = 192;
        "cells".clone_into(&mut s.second_look.preset);
        s.objects[1].motion.spin = [0.0, 50.0, 0.0];
        change(s);
    })
}

fn dab(brush: Brush, center: Vec3, radius: f32) -> Dab {
    Dab {
        brush,
        center,
        radius,
        eye: None,
        ring: None,
        number: 1,
    }
}

fn paint(gpu: &Gpu, simulation: &mut Simulation, dab: &Dab) -> Painted {
    let mut painted = Painted::default();
    gpu.run(|rec| painted = simulation.paint(rec, dab).unwrap());
    painted
}

/// Painted, painted over and partly erased between steps, on three objects and over their seams: states have equal hashes on the device
/// and by the twins. Without a preset, the weights change nothing that grows.
///
/// Would catch: kernels that mix otherwise than their twins in any form of sensing, gutters without weights, a second look that is used
/// by one engine only, and one that takes effect though there is none.
#[test]
fn both_engines_mix_alike() {
    let Some(gpu) = gpu() else { return };
    for (preset, strategy, sensing) in [
        ("cells", Strategy::Parallel, Sensing::Auto),
        ("streams", Strategy::Direct, Sensing::Auto),
        ("mist", Strategy::None, Sensing::Walk),
        ("none", Strategy::Parallel, Sensing::Auto),
    ] {
        let scene = trio(|s| {
            preset.clone_into(&mut s.second_look.preset);
            s.transfer.strategy = strategy;
            s.physarum.sensing = sensing;
            // Attempts stay those of the object, whatever the weight.
            s.objects[0].physarum.edge_crossing_attempts = Some(1);
        });
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let setup = simulation.setup().clone();
        let new = || twin::Simulation::new(setup.clone(), scene.settings.clone());
        let (mut host, mut plain) = (new(), new());
        let at = Vec3::new(0.3, 0.5, 0.3);
        for step in 0..14 {
            let brush = match step {
                2 => Some(Brush::Look { amount: 0.7 }),
                4 => Some(Brush::Look { amount: 1.0 }),
                8 => Some(Brush::Erase { share: 0.6 }),
                _ => None,
            };
            if let Some(brush) = brush {
                let dab = dab(brush, at + 0.03 * step as f32, 0.9);
                let painted = paint(&gpu, &mut simulation, &dab);
                assert!(painted.texels.iter().filter(|count| **count > 0).count() >= 2);
                assert_eq!(host.paint(&dab).unwrap(), painted);
                if matches!(brush, Brush::Erase { .. }) {
                    plain.paint(&dab).unwrap();
                }
            }
            gpu.run(|rec| simulation.record_step(rec));
            host.step();
            plain.step();
            let state = simulation.snapshot().unwrap();
            state.validate(&setup).unwrap();
            state.check_ranges(&setup).unwrap();
            assert_eq!(
                state.hash(),
                host.snapshot().hash(),
                "{preset}, step {step}"
            );
            let grows_alike = state.trail == plain.snapshot().trail;
            assert_eq!(
                grows_alike,
                step < 2 || preset == "none",
                "{preset}, step {step}"
            );
            assert_eq!(state.looks.iter().any(|weight| *weight > 0.0), step >= 2);
        }
    }
    gpu.finish();
}

/// On a plane with three fields of weights, particles in each walk as far in a step as its look says: the first, the mean, the second.
///
/// Would catch: weights of other texels, and rows of the table that are exchanged.
#[test]
fn each_place_has_the_speed_of_its_look() {
    let scene = scene("builtin:plane?columns=4&rows=4", |s| {
        s.particles.count = 4000;
        s.physarum.speed = 0.01;
        "streams".clone_into(&mut s.second_look.preset);
        s.physarum.edge_crossing_attempts = 100;
    });
    let setup = Setup::new(&scene).unwrap();
    let rows = physarums(&scene.settings, &setup);
    let [one, other] = [rows[0].speed, rows[1].speed];
    assert!(
        rows.len() == 2 && (one - other).abs() > 0.1 * one,
        "{one}, {other}"
    );
    let third = setup.atlas.size / 3;
    let weight = |texel: u32| (texel % setup.atlas.pitch / third).min(2) as f32 * 0.5;
    let mut simulation = twin::Simulation::new(setup.clone(), scene.settings.clone());
    let mut before = simulation.snapshot();
    before.looks = (0..setup.atlas.texel_count() as u32).map(weight).collect();
    simulation.restore(&before);
    simulation.step();
    let after = simulation.snapshot();
    let ground = Ground::of(&setup, &setup.poses);
    let mut counts = [0; 3];
    for ((was, before), (is, motion)) in by_id(&before).iter().zip(by_id(&after)) {
        let texel = setup.atlas.texel_of(was.triangle, was.u, was.v);
        let [from, to] = [ground.flight(was, before), ground.flight(&is, &motion)];
        let walked = from.position.distance(to.position);
        // Those that are reflected at the border are nearer.
        let expected = one + weight(texel) * (other - one);
        assert!(walked < 1.001 * expected, "{walked}, not {expected}");
        counts[(2.0 * weight(texel)) as usize] += usize::from(walked > 0.999 * expected);
    }
    assert!(counts.iter().all(|count| *count > 1000), "{counts:?}");
}

fn undo(ctx: &Context, frames: &mut Frames, simulation: &mut Simulation, dab: &Dab) {
    let mut before = None;
    let mut painted = Painted::default();
    let mut rec = frames.begin().unwrap();
    before.replace(simulation.record_areas(&mut rec).unwrap());
    painted.clone_from(&simulation.paint(&mut rec, dab).unwrap());
    frames.submit(rec).unwrap();
    ctx.wait_idle().unwrap();
    let (bias, looks) = (simulation.areas().unwrap(), simulation.looks().unwrap());
    let changed = simulation
        .repainted(&before.unwrap(), painted.span)
        .unwrap();
    assert!(!changed.is_empty());
    let mut put = |again: bool| {
        let mut rec = frames.begin().unwrap();
        simulation.put_areas(&mut rec, &changed, again).unwrap();
        frames.submit(rec).unwrap();
        ctx.wait_idle().unwrap();
        (simulation.areas().unwrap(), simulation.looks().unwrap())
    };
    let undone = put(false);
    assert!(undone != (bias.clone(), looks.clone()));
    assert!(put(true) == (bias, looks), "what was undone comes again");
    put(false);
}

/// A checkpoint with painted weights goes on to the same hash; they are carried to another layout; a stroke that blends, and one of the
/// eraser over both kinds of areas, is undone and comes again.
///
/// Would catch: weights that one of these loses, undo that mixes them up with attraction, and a resumed simulation without kernels for them.
#[test]
fn a_painted_look_is_kept_carried_and_undone() {
    let Some(gpu) = gpu() else { return };
    let scene = trio(|_| ());
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let at = Vec3::new(0.3, 0.5, 0.3);
    paint(
        &gpu,
        &mut simulation,
        &dab(Brush::Attract { amount: 2.0 }, at, 0.8),
    );
    paint(
        &gpu,
        &mut simulation,
        &dab(Brush::Look { amount: 0.9 }, at, 0.9),
    );
    let kept = |simulation: &Simulation| (simulation.areas().unwrap(), simulation.looks().unwrap());
    let before = kept(&simulation);
    let mut frames = Frames::new(&gpu.ctx, 1).unwrap();
    for brush in [Brush::Look { amount: 0.5 }, Brush::Erase { share: 0.7 }] {
        let dab = dab(brush, at + Vec3::new(0.2, 0.1, 0.0), 0.6);
        undo(&gpu.ctx, &mut frames, &mut simulation, &dab);
        assert!(kept(&simulation) == before, "{brush:?}");
    }
    frames.wait_idle().unwrap();
    drop(frames);
    advance(&gpu, &mut simulation, 4);
    let half = simulation.snapshot().unwrap();
    advance(&gpu, &mut simulation, 6);
    let whole = simulation.snapshot().unwrap().hash();

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("half.ckpt");
    let checkpoint = Checkpoint::new(&scene, simulation.setup(), half.clone());
    checkpoint.write(&path).unwrap();
    let read = Checkpoint::read(&path).unwrap();
    let mut resumed = Simulation::new(&gpu.ctx, &scene).unwrap();
    resumed.restore(&read.snapshot).unwrap();
    advance(&gpu, &mut resumed, 6);
    assert_eq!(resumed.snapshot().unwrap().hash(), whole);
    let mut without = read.snapshot;
    without.looks.clear();
    resumed.restore(&without).unwrap();
    advance(&gpu, &mut resumed, 6);
    assert_ne!(resumed.snapshot().unwrap().hash(), whole);

    let larger = Setup::new(&trio(|s| s.atlas.size = 256)).unwrap();
    let from = [Some(0), Some(1), Some(2)];
    let there = carried(&half, simulation.setup(), &larger, &from).unwrap();
    there.validate(&larger).unwrap();
    let mean = |looks: &[f32], setup: &Setup| {
        let owners = setup.atlas.owner.iter().zip(looks);
        let own = owners.filter(|(owner, _)| **owner != u32::MAX);
        let own: Vec<f64> = own.map(|(_, weight)| f64::from(*weight)).collect();
        own.iter().sum::<f64>() / own.len() as f64
    };
    let [here, there] = [
        mean(&half.looks, simulation.setup()),
        mean(&there.looks, &larger),
    ];
    assert!(
        here > 0.02 && (there / here - 1.0).abs() < 0.1,
        "{here}, {there}"
    );
    gpu.finish();
}
