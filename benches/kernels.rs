//! Every kernel of a step alone, under criterion: GPU times by timestamps, each run on what the kernel finds in a step.

#![allow(missing_docs, reason = "criterion's macros make a public function")]

use std::time::Duration;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use myxo::gpu::{Context, ContextOptions, Frames, default_cache_folder};
use myxo::scene::{Overrides, Scene};
use myxo::sim::Simulation;

/// Scenes, and with how many particles.
const SCENES: [(&str, u32); 3] = [("torus", 500_000), ("cube", 500_000), ("trio", 100_000)];
/// Steps before: particles have been sorted once.
const WARMUP: u32 = 34;

fn kernels(criterion: &mut Criterion) {
    let ctx = Context::new(&ContextOptions {
        cache_folder: default_cache_folder(),
        ..ContextOptions::default()
    });
    let ctx = ctx.expect("a device is what is measured");
    if !ctx.info().has_timestamps() {
        eprintln!("skipped: {} has no timestamps", ctx.info().name);
        return;
    }
    for (name, particles) in SCENES {
        let overrides = Overrides {
            set: vec![format!("particles.count={particles}")],
            ..Overrides::default()
        };
        let scene = Scene::load(name.as_ref(), &overrides).expect("it is built in");
        let mut simulation = Simulation::new(&ctx, &scene).expect("it fits");
        let mut frames = Frames::new(&ctx, 1).expect("it fits");
        for _ in 0..WARMUP {
            let mut rec = frames.begin().expect("the device works");
            simulation.record_step(&mut rec);
            frames.submit(rec).expect("the device works");
        }
        frames.wait_idle().expect("the device works");
        let state = simulation.snapshot().expect("it fits");
        let mut names = simulation.kernels(&mut frames.begin().expect("the device works"));
        names.sort();
        names.dedup();
        let mut group = criterion.benchmark_group(name);
        group
            .sample_size(10)
            .warm_up_time(Duration::from_millis(500))
            .measurement_time(Duration::from_secs(1));
        for kernel in names {
            simulation.restore(&state).expect("it is of this scene");
            // One more step, because a restored state has no earlier distances, but steps do.
            let mut rec = frames.begin().expect("the device works");
            simulation.record_step(&mut rec);
            frames.submit(rec).expect("the device works");
            let mut rec = frames.begin().expect("the device works");
            let alone = simulation.record_before(&mut rec, &kernel);
            let alone = alone.expect("the step has this kernel");
            frames.submit(rec).expect("the device works");
            group.bench_function(BenchmarkId::from_parameter(&kernel), |bencher| {
                bencher.iter_custom(|runs| {
                    let mut milliseconds = 0.0;
                    for _ in 0..runs {
                        frames.timings_mut().clear();
                        let mut rec = frames.begin().expect("the device works");
                        simulation.record_alone(&mut rec, &alone, "alone");
                        frames.submit(rec).expect("the device works");
                        frames.wait_idle().expect("the device works");
                        milliseconds += frames.timings().report("alone").step.mean_ms;
                    }
                    Duration::from_secs_f64(1e-3 * milliseconds)
                });
            });
        }
        group.finish();
    }
}

criterion_group!(benches, kernels);
criterion_main!(benches);
