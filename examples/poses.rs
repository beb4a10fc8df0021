//! Objects that are moved from outside: a ball is led through a ring, as a hand, a robot or a physics engine would lead
//! it, and takes slime along. Prints as CSV where the ball is and how many particles are on which object.
//!
//! `cargo run --release --example poses > poses.csv`

use glam::{DAffine3, DQuat, DVec3};
use myxo::gpu::{Context, ContextOptions, Frames};
use myxo::scene::Scene;
use myxo::scene::settings::{ObjectSettings, Settings};
use myxo::sim::Simulation;

const STEPS: u32 = 120;
const BALL: usize = 1;

fn main() -> myxo::Result<()> {
    let ctx = Context::new(&ContextOptions::default())?;
    let scene = scene()?;
    let mut simulation = Simulation::new(&ctx, &scene)?;
    let mut frames = Frames::new(&ctx, 2)?;

    println!("step,x,y,z,on_ring,on_ball");
    for step in 1..=STEPS {
        // Poses may be set before any step, as often as one likes. They must be rigid: only then do particles keep
        // the lengths that they walk.
        let turns = f64::from(step) / f64::from(STEPS);
        let place = DVec3::new(1.0, 1.5 * (turns * std::f64::consts::TAU).cos(), 0.0);
        let pose = DAffine3::from_rotation_translation(DQuat::from_rotation_y(turns), place);
        simulation.set_pose(BALL, Some(pose))?;

        let mut rec = frames.begin()?;
        simulation.record_step(&mut rec);
        frames.submit(rec)?;

        if step % 10 == 0 {
            frames.wait_idle()?;
            let [x, y, z] = simulation.world_from_object()[BALL].translation.to_array();
            let [ring, ball] = population(&ctx, &simulation)?;
            println!("{step},{x:.4},{y:.4},{z:.4},{ring},{ball}");
        }
    }
    Ok(())
}

/// A ring, and a ball above it that is a little thicker than the ring's tube.
fn scene() -> myxo::Result<Scene> {
    let object = |name: &str, mesh: &str| ObjectSettings {
        name: name.to_owned(),
        mesh: mesh.to_owned(),
        ..ObjectSettings::default()
    };
    let mut settings = Settings {
        objects: vec![
            object("ring", "builtin:torus?major=48&minor=24"),
            object("ball", "builtin:icosphere?subdivisions=4"),
        ],
        ..Settings::default()
    };
    settings.objects[BALL].scale = 0.5;
    settings.objects[BALL].position = [1.0, 1.5, 0.0];
    settings.particles.count = 20_000;
    settings.atlas.size = 256;
    Ok(Scene::from_settings(
        "poses".to_owned(),
        settings,
        ".".into(),
    )?)
}

/// How many particles are on each object.
fn population(ctx: &Context, simulation: &Simulation) -> myxo::Result<[u32; 2]> {
    let mut counts = [0; 2];
    for particle in ctx.download(&simulation.state().particles)? {
        let triangle = simulation.setup().surface.triangles[particle.triangle as usize];
        counts[triangle.object as usize] += 1;
    }
    Ok(counts)
}
