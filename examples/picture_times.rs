//! The GPU time of pictures, part by part, with and without development, taken in turns.
//!
//! `cargo run --release --example picture_times -- [SCENE [WIDTH HEIGHT]]`
//!
//! `quick` pictures are those of a window on a CPU while something moves; `smooth` ones have four samples a pixel.

use std::collections::BTreeMap;

use glam::Vec2;
use myxo::gpu::{Context, ContextOptions, Frames, SpanKind};
use myxo::render::offscreen::{FORMAT, Offscreen};
use myxo::render::{Prepared, Quality, Renderer, View};
use myxo::scene::{Overrides, Scene};
use myxo::sim::Simulation;
use myxo::{Error, Result};

const STEPS: u32 = 200;
const PICTURES: usize = 30;

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().unwrap_or_else(|| "torus".to_owned());
    let mut side = |usual: u32| match arguments.next() {
        Some(text) => (text.parse()).map_err(|_| Error::Invalid(format!("{text} is no side"))),
        None => Ok(usual),
    };
    let size = [side(1280)?, side(800)?];
    let ctx = Context::new(&ContextOptions::default())?;
    let overrides = Overrides {
        set: vec!["particles.count=200000".to_owned()],
        ..Overrides::default()
    };
    let scene = Scene::load(name.as_ref(), &overrides)?;
    let mut simulation = Simulation::new(&ctx, &scene)?;
    let mut frames = Frames::new(&ctx, 1)?;
    for _ in 0..STEPS {
        frames.run(|rec| simulation.record_step(rec))?;
    }
    let prepared = Prepared::for_quick(simulation.setup());
    let mut renderer = Renderer::from_prepared(&ctx, simulation.setup(), &prepared, FORMAT)?;
    let shown = View::of(&scene, Vec2::new(size[0] as f32, size[1] as f32));
    let plain = View {
        bloom: 0.0,
        ..shown
    };
    println!("{} on {}, {} x {}", name, ctx.info().name, size[0], size[1]);
    for quality in [Quality::Quick, Quality::Smooth] {
        let offscreen = Offscreen::with_quality(&ctx, size, quality)?;
        let mut parts: [BTreeMap<String, Vec<f64>>; 2] = Default::default();
        for _ in 0..PICTURES {
            for (view, parts) in [shown, plain].iter().zip(&mut parts) {
                frames.timings_mut().clear();
                let state = simulation.state();
                frames.run(|rec| renderer.draw(rec, state, view, offscreen.canvas()))?;
                frames.wait_idle()?;
                let last = frames.timings().frames().next_back().unwrap_or_default();
                let mut sums = BTreeMap::<String, f64>::new();
                for span in last {
                    let is_part = span.kind != SpanKind::Scope || span.name == "picture";
                    if is_part && span.kind != SpanKind::Frame {
                        *sums.entry(span.name.to_string()).or_default() += span.ms();
                    }
                }
                for (name, ms) in sums {
                    parts.entry(name).or_default().push(ms);
                }
            }
        }
        for (parts, what) in parts.iter_mut().zip(["with bloom", "without"]) {
            println!("{quality:?}, {what}: median, least and most ms");
            for (name, times) in parts {
                times.sort_by(f64::total_cmp);
                let (low, high) = (times[0], times[times.len() - 1]);
                println!(
                    "  {name:<18}{:8.3}{low:8.3}{high:8.3}",
                    times[times.len() / 2]
                );
            }
        }
    }
    Ok(())
}
