//! The simulation as a whole: what must hold over many steps, whatever a scene has.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/places.rs"]
mod places;
#[path = "../program/mod.rs"]
mod program;

use common::Gpu;
use myxo::gpu::Frames;
use myxo::sim::Simulation;

mod altered;
mod areas;
mod diffusion;
mod food;
mod host_work;
mod invariants;
mod jones;
mod long;
mod look;
mod meeting;
mod memory;
mod moving;
mod moving_together;
mod networks;
mod occupancy;
mod own_trail;
mod paint;
mod periodic;
mod population;
mod pulse;
mod scale;
mod sensing;
mod starts;
mod step;
mod transfers;

/// Runs so many steps.
fn advance(gpu: &Gpu, simulation: &mut Simulation, steps: u32) {
    let mut frames = Frames::new(&gpu.ctx, 2).unwrap();
    for _ in 0..steps {
        let mut rec = frames.begin().unwrap();
        simulation.record_step(&mut rec);
        frames.submit(rec).unwrap();
    }
    frames.wait_idle().unwrap();
}
