//! What tiles remember from update to update: it saves searches and changes nothing.

use myxo::gpu::Listed;
use myxo::scene::settings::SignRule;
use myxo::sim::{Setup, Simulation, twin};

use crate::common::{TRIO, gpu, scene_of_several};

/// Objects that come and go: in every step the distances are those of a run without remembered margins.
#[test]
fn tiles_remember_how_far_they_are_and_nothing_changes() {
    let Some(gpu) = gpu() else { return };
    for sign in [SignRule::Pseudonormal, SignRule::Winding] {
        let scene = scene_of_several(&TRIO, |s| {
            s.particles.count = 100;
            s.atlas.size = 160;
            s.distance.reach = 0.08;
            s.distance.sign = sign;
            s.objects[0].motion.spin = [10.0, 40.0, 0.0];
            s.objects[1].motion.swing = [0.0, 0.0, 20.0];
            s.objects[1].motion.swing_period = 1.0;
            s.objects[2].motion.slide = [0.8, 0.3, 0.0];
            s.objects[2].motion.slide_period = 1.2;
        });
        let mut remembers = Simulation::new(&gpu.ctx, &scene).unwrap();
        let mut forgets = Simulation::new(&gpu.ctx, &scene).unwrap();
        let setup = Setup::new(&scene).unwrap();
        let mut twin = twin::Simulation::new(setup, scene.settings.clone());
        let (mut kept, mut near) = (0, 0);
        // By winding numbers nothing is kept, which a few steps show.
        let steps = if sign == SignRule::Winding { 12 } else { 48 };
        for step in 0..steps {
            let state = remembers.snapshot().unwrap();
            gpu.run(|rec| remembers.record_step(rec));
            twin.step();
            let margins = gpu.ctx.download(&remembers.state().near.margins).unwrap();
            let states = gpu
                .ctx
                .download(&remembers.state().near.tile_states)
                .unwrap();
            let (states_by_twin, margins_by_twin) = twin.tiles();
            assert!(states == states_by_twin, "{sign:?}, step {step}");
            let bits = |list: &[f32]| list.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert!(
                bits(&margins) == bits(margins_by_twin),
                "{sign:?}, step {step}"
            );
            kept += margins.iter().filter(|margin| **margin != 0.0).count();
            near += margins.iter().filter(|margin| **margin == 0.0).count();
            if step % 5 != 4 {
                continue;
            }
            forgets.restore(&state).unwrap();
            gpu.run(|rec| forgets.record_step(rec));
            let fields = |simulation: &Simulation| {
                let state = simulation.state();
                let distances: Vec<f32> = gpu.ctx.download(&state.near.distances).unwrap();
                (distances, gpu.ctx.download(&state.near.nearest).unwrap())
            };
            let (distances, nearest) = fields(&remembers);
            assert!(
                fields(&forgets) == (distances.clone(), nearest),
                "{sign:?}, step {step}"
            );
            assert!(
                bits(&distances) == bits(twin.distances().0),
                "{sign:?}, step {step}"
            );
        }
        // By the other rules sides of closed objects may change where there is no surface: nothing is kept of them.
        let keeps = sign == SignRule::Pseudonormal;
        assert!(
            near > 100 && (kept > 1000) == keeps && (kept == 0) != keeps,
            "{sign:?}: {kept}, {near}"
        );
    }
    gpu.finish();
}

/// Catches a return to a state, as previews of looks do, after which all distances are computed again: that takes longer than a step.
#[test]
fn distances_of_a_state_that_are_known_are_not_computed_again() {
    let Some(gpu) = gpu() else { return };
    let scene = scene_of_several(&TRIO, |s| {
        s.particles.count = 500;
        s.atlas.size = 160;
    });
    let mut returns = Simulation::new(&gpu.ctx, &scene).unwrap();
    let step = |simulation: &mut Simulation| {
        let mut listed = Vec::new();
        gpu.run(|rec| {
            rec.list();
            simulation.record_step(rec);
            listed = rec.listed();
        });
        let is_distance =
            |work: &Listed| matches!(work, Listed::Work(name) if name.starts_with("distance"));
        listed.iter().any(is_distance)
    };
    assert!(step(&mut returns), "the first step computes them");
    assert!(!step(&mut returns), "objects rest");
    let state = returns.snapshot().unwrap();
    let next = (0..3).map(|_| step(&mut returns)).collect::<Vec<_>>();
    let hash = returns.snapshot().unwrap().hash();
    returns.restore(&state).unwrap();
    assert_eq!((0..3).map(|_| step(&mut returns)).collect::<Vec<_>>(), next);
    assert_eq!(returns.snapshot().unwrap().hash(), hash);
    // Another simulation does not know them.
    let mut other = Simulation::new(&gpu.ctx, &scene).unwrap();
    other.restore(&state).unwrap();
    assert!(step(&mut other));
    assert_eq!(other.snapshot().unwrap().step, 3);
    // Those of other poses are unknown.
    returns
        .set_pose(1, Some(glam::DAffine3::from_translation(glam::DVec3::X)))
        .unwrap();
    assert!(step(&mut returns));
    returns.restore(&state).unwrap();
    assert!(step(&mut returns));
    gpu.finish();
}
