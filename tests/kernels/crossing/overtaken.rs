//! Whole scenes: how many particles are inside another object, for whatever reason.

use myxo::scene::{Overrides, Scene};
use myxo::sim::Simulation;
use myxo::sim::types::Particle;

use crate::common::{COARSE_TRIO, coarse_crowd, gpu};

/// Enough for particles that began inside other objects to come out.
const STEPS: u32 = 80;

/// Particles that get into another object transfer to it, whichever of the two moves: hardly any particle is inside another object,
/// while a good part of the surface is. Takes long: eighty steps, by each way of moving.
#[test]
fn hardly_any_particle_stays_inside_objects_that_move() {
    let Some(gpu) = gpu() else { return };
    let scenes = [
        ("trio", COARSE_TRIO.map(str::to_owned).to_vec()),
        ("crowd", coarse_crowd(2)),
    ];
    for (name, coarse) in scenes {
        let mut set = coarse;
        set.extend(["particles.count=4000", "atlas.size=512"].map(str::to_owned));
        let overrides = Overrides {
            set,
            ..Overrides::default()
        };
        let scene = Scene::load(name.as_ref(), &overrides).unwrap();
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        for _ in 0..STEPS {
            gpu.run(|rec| simulation.record_step(rec));
        }
        let state = simulation.snapshot().unwrap();
        let distances = gpu
            .ctx
            .download(&simulation.state().near.distances)
            .unwrap();
        let atlas = &simulation.setup().atlas;
        let share = |inside: usize, all: usize| inside as f64 / all as f64;
        let owned = |texel: &usize| atlas.density[*texel] > 0.0;
        let inside = |texel: usize| distances[texel] < 0.0;
        let texels: Vec<usize> = (0..distances.len()).filter(owned).collect();
        let covered = texels.iter().filter(|texel| inside(**texel)).count();
        let buried = state.particles.iter().filter(|particle| {
            let Particle { triangle, u, v, .. } = **particle;
            inside(atlas.texel_of(triangle, u, v) as usize)
        });
        let [covered, buried] = [
            share(covered, texels.len()),
            share(buried.count(), state.particles.len()),
        ];
        assert!(covered > 0.02, "{name}: {covered}");
        assert!(buried < 0.2 * covered, "{name}: {buried} of {covered}");
    }
    gpu.finish();
}
