//! The ten-line start: a hundred steps on a cube without a window, and the hash of where they end.
//!
//! `cargo run --release --example headless`

use myxo::{gpu, scene, sim};

fn main() -> myxo::Result<()> {
    let ctx = gpu::Context::new(&gpu::ContextOptions::default())?;
    let scene = scene::Scene::load("cube".as_ref(), &scene::Overrides::default())?;
    let mut simulation = sim::Simulation::new(&ctx, &scene)?;
    let mut frames = gpu::Frames::new(&ctx, 2)?;
    for _ in 0..100 {
        let mut rec = frames.begin()?;
        simulation.record_step(&mut rec);
        frames.submit(rec)?;
    }
    frames.wait_idle()?;
    let state = simulation.snapshot()?; // particles, headings, trail
    println!("{:016x}", state.hash());
    Ok(())
}
