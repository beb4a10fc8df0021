//! Scratch: pictures to look at.
use glam::Vec2;
use myxo::gpu::{Context, ContextOptions, Frames};
use myxo::render::*;
use myxo::scene::{Overrides, Scene};
use myxo::scene::settings::*;
use myxo::sim::Simulation;
use std::time::Instant;

fn cpu() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap();
    let f: Vec<&str> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
    (f[11].parse::<f64>().unwrap() + f[12].parse::<f64>().unwrap()) / 100.0
}

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let scene = &args[1];
    let steps: u32 = args[2].parse().unwrap();
    let out = &args[3];
    let [w, h]: [u32; 2] = [args[4].parse().unwrap(), args[5].parse().unwrap()];
    let set: Vec<String> = args[6..].to_vec();
    let ctx = Context::new(&ContextOptions { validation: std::env::var_os("VALIDATE").is_some(), ..Default::default() }).unwrap();
    let scene = Scene::load(std::path::Path::new(scene), &Overrides { set, ..Default::default() }).unwrap();
    let mut sim = Simulation::new(&ctx, &scene).unwrap();
    let mut renderer = Renderer::new(&ctx, sim.setup(), offscreen::FORMAT).unwrap();
    let off = Offscreen::new(&ctx, [w, h]).unwrap();
    let mut frames = Frames::new(&ctx, 2).unwrap();
    let t = Instant::now();
    for _ in 0..steps {
        let mut rec = frames.begin().unwrap();
        sim.record_step(&mut rec);
        frames.submit(rec).unwrap();
    }
    frames.wait_idle().unwrap();
    eprintln!("{steps} steps {:?}", t.elapsed());
    let mut view = View::of(&scene, Vec2::new(w as f32, h as f32));
    for (show, name) in [(Show::Surface, "surface"), (Show::Particles, "particles"), (Show::Atlas, "atlas")] {
        view.show = show;
        let mut t = Instant::now();
        let mut c = cpu();
        for i in 0..12 {
            if i == 2 { t = Instant::now(); c = cpu(); frames.timings_mut().clear(); }
            let mut rec = frames.begin().unwrap();
            renderer.draw(&mut rec, sim.state(), &view, off.canvas());
            off.record_readback(&mut rec);
            frames.submit(rec).unwrap();
            frames.wait_idle().unwrap();
        }
        eprintln!("{name} {:?}, cpu {:.1} ms (both cores: {:.1})", t.elapsed() / 10, (cpu() - c) * 100.0, (cpu() - c) * 50.0);
        for node in frames.timings().report("frame").tree { eprintln!("   {:indent$}{} {:.2}", "", node.name, node.mean_ms, indent = 2 * node.depth); }
        frames.timings_mut().clear();
        off.image().save(format!("{out}_{name}.png")).unwrap();
    }
    for m in ctx.messages() { eprintln!("VALIDATION {m}"); }
}
