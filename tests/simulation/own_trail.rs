//! Objects with trails of their own: deposit, diffusion and decay of each, and the edge-crossing attempts of the particles on it.

use std::collections::BTreeMap;

use crate::advance;
use crate::common::{Gpu, gpu, scene_of_several, set_up};
use myxo::mesh::surface::NONE;
use myxo::scene::Scene;
use myxo::scene::settings::{ObjectSettings, Settings, Strategy};
use myxo::sim::checkpoint::Checkpoint;
use myxo::sim::{Setup, Simulation, Snapshot, twin};

const STEPS: u32 = 10;

/// Two objects far from each other.
const APART: [(&str, [f32; 3]); 2] = [
    ("torus?major=24&minor=16", [0.0; 3]),
    ("cube", [9.0, 0.0, 0.0]),
];

fn scene(change: impl FnOnce(&mut Settings)) -> Scene {
    scene_of_several(&APART, |s| {
        s.radius = 1.5;
        s.atlas.size = 203;
        s.particles.count = 3001;
        s.transfer.strategy = Strategy::None;
        change(s);
    })
}

type Change = fn(&mut ObjectSettings);

/// The state after some steps with changes of both objects. Where the two differ, the twin's has the same bits.
fn grown(gpu: &Gpu, changes: [Change; 2], differ: bool) -> (Snapshot, Setup) {
    let scene = scene(|s| {
        for (object, change) in s.objects.iter_mut().zip(changes) {
            change(object);
        }
    });
    let setup = set_up(&gpu.ctx, &scene);
    let mut simulation = Simulation::from_setup(&gpu.ctx, &scene, setup.clone()).unwrap();
    advance(gpu, &mut simulation, STEPS);
    let state = simulation.snapshot().unwrap();
    if differ {
        let mut by_twin = twin::Simulation::new(setup.clone(), scene.settings);
        (0..STEPS).for_each(|_| by_twin.step());
        assert_eq!(state.hash(), by_twin.snapshot().hash());
    }
    (state, setup)
}

fn object_of(setup: &Setup, triangle: u32) -> usize {
    setup.surface.triangles[triangle as usize].object as usize
}

/// The trail on an object, and the places of the particles on it by their ids, as bits.
fn on_object(
    state: &Snapshot,
    setup: &Setup,
    object: usize,
) -> (Vec<u32>, BTreeMap<u32, [u32; 3]>) {
    let texels = state.trail.iter().zip(&setup.atlas.owner);
    let own = texels.filter(|&(_, &owner)| owner != NONE && object_of(setup, owner) == object);
    let trail = own.map(|(value, _)| value.to_bits()).collect();
    let particles = state.particles.iter();
    let own = particles.filter(|particle| object_of(setup, particle.triangle) == object);
    let places = own.map(|p| (p.id, [p.triangle, p.u.to_bits(), p.v.to_bits()]));
    (trail, places.collect())
}

/// What objects have that never meet is what each has in a scene in which both have its values, bit for bit; and it is something else than
/// with the values of the other one.
///
/// Would catch: values of the other object anywhere, above all at seams and in quads of texels of which two objects have some; keys that
/// are read and have no effect; several passes with unequal parts.
#[test]
fn each_object_grows_as_it_does_among_its_like() {
    let Some(gpu) = gpu() else { return };
    let cases: [(&str, [Change; 2]); 8] = [
        (
            "decay",
            [|o| o.trail.decay = Some(0.5), |o| o.trail.decay = Some(0.9)],
        ),
        (
            "half-life",
            [
                |o| o.trail.half_life = Some(2.0),
                |o| o.trail.half_life = Some(50.0),
            ],
        ),
        (
            "diffusion",
            [
                |o| o.trail.diffusion = Some(0.0),
                |o| o.trail.diffusion = Some(0.6),
            ],
        ),
        (
            "diffusion in two passes",
            [
                |o| o.trail.diffusion = Some(0.7),
                |o| o.trail.diffusion = Some(1.0),
            ],
        ),
        (
            "diffusion length",
            [
                |o| o.trail.diffusion_length = Some(0.002),
                |o| o.trail.diffusion_length = Some(0.006),
            ],
        ),
        (
            "deposit",
            [
                |o| o.physarum.deposit = Some(0.25),
                |o| o.physarum.deposit = Some(7.0),
            ],
        ),
        (
            "edge-crossing attempts",
            [
                |o| o.physarum.edge_crossing_attempts = Some(0),
                |o| o.physarum.edge_crossing_attempts = Some(40),
            ],
        ),
        (
            "one has the scene's",
            [|_| (), |o| o.trail.decay = Some(0.5)],
        ),
    ];
    for (name, [one, other]) in cases {
        let (mixed, setup) = grown(&gpu, [one, other], true);
        let like_one = grown(&gpu, [one; 2], false).0;
        let like_other = grown(&gpu, [other; 2], false).0;
        let [mixed, like_one, like_other] = [mixed, like_one, like_other]
            .map(|state| [0, 1].map(|object| on_object(&state, &setup, object)));
        for (object, (like, unlike)) in [(&like_one, &like_other), (&like_other, &like_one)]
            .into_iter()
            .enumerate()
        {
            assert!(mixed[object] == like[object], "{name}, object {object}");
            assert!(
                mixed[object].0 != unlike[object].0,
                "{name}, object {object}"
            );
        }
    }
    gpu.finish();
}

/// Diffusion keeps the trail of each object, also if one takes two passes and the other one would take one; deposits are each object's own.
///
/// Would catch: deposits or decay in each of two passes, and a number of passes by another object than the one that spreads the most, which
/// the tables of seams do not hold.
#[test]
fn particles_leave_what_their_object_says() {
    let Some(gpu) = gpu() else { return };
    let (amounts, diffusions) = ([0.5, 3.0], [0.1, 1.0]);
    let scene = scene(|s| {
        s.trail.decay = 1.0;
        for (k, object) in s.objects.iter_mut().enumerate() {
            object.physarum.deposit = Some(amounts[k]);
            object.trail.diffusion = Some(diffusions[k]);
        }
    });
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let setup = simulation.setup().clone();
    let mut by_twin = twin::Simulation::new(setup.clone(), scene.settings.clone());
    advance(&gpu, &mut simulation, STEPS);
    (0..STEPS).for_each(|_| by_twin.step());
    let state = simulation.snapshot().unwrap();
    assert_eq!(state.hash(), by_twin.snapshot().hash());
    for (object, amount) in amounts.into_iter().enumerate() {
        let particles = state.particles.iter();
        let own = particles.filter(|particle| object_of(&setup, particle.triangle) == object);
        let left = f64::from(amount) * f64::from(STEPS) * own.count() as f64;
        assert!(left > 0.0, "particles on object {object}");
        let texels = (0..state.trail.len()).filter(|&texel| {
            let owner = setup.atlas.owner[texel];
            owner != NONE && object_of(&setup, owner) == object
        });
        let mass: f64 = texels
            .map(|texel| f64::from(state.trail[texel]) * f64::from(setup.atlas.area[texel]))
            .sum();
        let share = mass / (left * setup.atlas.mean_texel_area);
        assert!((share - 1.0).abs() < 1e-5, "object {object}: {share}");
    }
    gpu.finish();
}

/// Objects that agree at first, then differ, agree once more and differ again, each time while steps are done, end as a new simulation does
/// that continues from a checkpoint with the last settings.
///
/// Would catch: tables that are missing or old after a change, and anything of them that a checkpoint would have to keep.
#[test]
fn own_trails_change_while_it_runs() {
    let Some(gpu) = gpu() else { return };
    let plain = scene(|_| ());
    let with = |decay: [Option<f32>; 2]| {
        let mut settings = plain.settings.clone();
        for (object, decay) in settings.objects.iter_mut().zip(decay) {
            object.trail.decay = decay;
        }
        settings
    };
    let mut simulation = Simulation::new(&gpu.ctx, &plain).unwrap();
    assert!(simulation.state().trail_objects.is_none());
    advance(&gpu, &mut simulation, 3);
    for decay in [
        [None, Some(0.5)],
        [Some(0.8), Some(0.8)],
        [None, Some(0.5)],
        [Some(0.25), Some(0.5)],
    ] {
        let before = simulation.snapshot().unwrap();
        let mut scene = plain.clone();
        scene.settings = with(decay);
        let mut unchanged = Simulation::new(&gpu.ctx, &plain).unwrap();
        unchanged.restore(&before).unwrap();
        let mut resumed = Simulation::new(&gpu.ctx, &scene).unwrap();
        let written = Checkpoint::new(&plain, resumed.setup(), before);
        written.check(&scene, resumed.setup()).unwrap();
        resumed.restore(&written.snapshot).unwrap();
        simulation.apply(&scene.settings).unwrap();
        for running in [&mut simulation, &mut unchanged, &mut resumed] {
            advance(&gpu, running, 3);
        }
        let [live, unchanged, resumed] =
            [&simulation, &unchanged, &resumed].map(|running| running.snapshot().unwrap().hash());
        assert_eq!(live, resumed, "{decay:?}");
        assert_ne!(live, unchanged, "{decay:?}");
    }
    gpu.finish();
}

/// Would catch: a length of an object that takes hundreds of passes, and a message without its key.
#[test]
fn a_length_of_an_object_that_is_too_long_is_refused() {
    let far = scene(|s| s.objects[1].trail.diffusion_length = Some(0.9));
    let problem = Setup::new(&far)
        .map(|_| ())
        .expect_err("it is too long")
        .to_string();
    assert!(
        problem.starts_with("object.1.trail.diffusion_length = 0.9: that is "),
        "{problem}"
    );
    let (_, greatest) = problem.split_once("use ").expect("there is advice");
    let (greatest, _) = greatest.split_once(" or less").expect("with a number");
    let greatest: f32 = greatest.parse().expect("it is one");
    for (length, fits) in [(greatest, true), (1.01 * greatest, false)] {
        let scene = scene(|s| s.objects[1].trail.diffusion_length = Some(length));
        assert_eq!(Setup::new(&scene).is_ok(), fits, "{length}");
    }
}
