//! Steps from a loop of one's own, with the trail read back after each: its statistics as CSV on the standard output.
//!
//! `cargo run --release --example own_loop > trail.csv`
//!
//! Reading back waits for the device. If fields are read only now and then, it runs on in between: `submit` does not wait.

use myxo::gpu::{Context, ContextOptions, Frames};
use myxo::scene::{Overrides, Scene};
use myxo::sim::Simulation;

const STEPS: u64 = 60;

fn main() -> myxo::Result<()> {
    let ctx = Context::new(&ContextOptions::default())?;
    let overrides = Overrides {
        preset: Some("cells".to_owned()),
        set: vec![
            "particles.count=20000".to_owned(),
            "atlas.size=256".to_owned(),
        ],
        seed: Some(3),
    };
    let scene = Scene::load("torus".as_ref(), &overrides)?;
    let mut simulation = Simulation::new(&ctx, &scene)?;
    let mut frames = Frames::new(&ctx, 2)?;

    println!("step,trail_mass,mean,deviation,greatest,share_above_mean");
    for step in 1..=STEPS {
        frames.run(|rec| simulation.record_step(rec))?;

        // Any buffer of `simulation.state()` can be read so; `simulation.snapshot()` reads all that makes up the state.
        let trail = ctx.download(&simulation.state().trail.front)?;
        let area = &simulation.setup().atlas.area;
        // What lies beside the surface has no area, so it does not count.
        let sum = |value: &dyn Fn(f64) -> f64| -> f64 {
            let texels = trail.iter().zip(area);
            texels
                .map(|(&trail, &area)| f64::from(area) * value(f64::from(trail)))
                .sum()
        };
        let surface = sum(&|_| 1.0);
        let mass = sum(&|trail| trail);
        let mean = mass / surface;
        let deviation = (sum(&|trail| (trail - mean).powi(2)) / surface).sqrt();
        let above = sum(&|trail| f64::from(u8::from(trail > mean))) / surface;
        let greatest = trail.iter().fold(0.0, |most: f32, &trail| most.max(trail));
        println!("{step},{mass:.6},{mean:.6},{deviation:.6},{greatest:.6},{above:.6}");
    }
    Ok(())
}
