//! One kernel of a step alone, again and again: each time it finds the same and does the same, whatever it changes.

use crate::common::{Gpu, TRIO, gpu, scene_of_several};
use myxo::gpu::Recorder;
use myxo::scene::Scene;
use myxo::scene::settings::{DistanceMethod, Strategy};
use myxo::sim::distance::UNKNOWN_MOVE;
use myxo::sim::types::{Border, Flow, Motion, Particle, Window};
use myxo::sim::{FORMS_OF_ADVANCE, Simulation};

fn trio(strategy: Strategy, method: DistanceMethod) -> Scene {
    scene_of_several(&TRIO, |s| {
        s.particles.count = 3000;
        s.atlas.size = 128;
        s.physarum.speed = 0.02;
        s.transfer.strategy = strategy;
        s.transfer.threshold = 0.01;
        s.distance.method = method;
    })
}

/// All that a kernel of the step may change, lists in order.
#[derive(Debug, PartialEq)]
struct Everything {
    particles: Vec<Particle>,
    motions: Vec<Motion>,
    flow: Vec<Flow>,
    windows: Vec<Window>,
    flux: Vec<u32>,
    borders: Vec<Border>,
    list: Vec<u32>,
    transfers: Vec<u32>,
    trails: [Vec<f32>; 2],
    deposits: [Vec<u32>; 2],
    distances: Vec<f32>,
    nearest: Vec<u32>,
    across: Vec<u32>,
    surroundings: Vec<u32>,
    covered: Vec<u32>,
}

fn everything(gpu: &Gpu, simulation: &Simulation) -> Everything {
    let (ctx, s) = (&gpu.ctx, simulation.state());
    let sorted = |mut list: Vec<u32>| {
        list.sort_unstable();
        list
    };
    let t = &s.transfers;
    Everything {
        particles: ctx.download(&s.particles).unwrap(),
        motions: ctx.download(&s.motions).unwrap(),
        flow: ctx.download(&t.flow).unwrap(),
        windows: ctx.download(&t.windows).unwrap(),
        flux: ctx.download(&t.flux).unwrap(),
        borders: ctx.download(&t.borders).unwrap(),
        list: sorted(ctx.download(&t.particle_indices).unwrap()),
        transfers: bytemuck::cast_slice(&ctx.download(&t.transfers).unwrap()).to_vec(),
        trails: [&s.trail.front, &s.trail.back].map(|buffer| ctx.download(buffer).unwrap()),
        deposits: [&s.deposits.front, &s.deposits.back].map(|buffer| ctx.download(buffer).unwrap()),
        distances: ctx.download(&s.near.distances).unwrap(),
        nearest: ctx.download(&s.near.nearest).unwrap(),
        across: ctx.download(&s.across.places).unwrap(),
        surroundings: ctx.download(&s.across.surroundings).unwrap(),
        covered: sorted(ctx.download(&s.near.covered).unwrap()),
    }
}

/// As [`everything`], for one kernel. Particles of a bin are put in one order, because it may differ each time they are sorted.
fn everything_of(gpu: &Gpu, simulation: &Simulation, kernel: &str) -> Everything {
    let mut all = everything(gpu, simulation);
    if kernel == "sort_scatter" {
        let both = all.particles.iter().zip(&all.motions);
        let mut both: Vec<_> = both
            .map(|(&particle, &motion)| (particle, motion))
            .collect();
        both.sort_by_key(|(particle, _)| particle.id);
        (all.particles, all.motions) = both.into_iter().unzip();
    }
    all
}

/// Repeated as they are, what advances would advance twice, and what appends would append twice.
#[test]
fn kernels_do_the_same_each_time_they_run_alone() {
    let Some(gpu) = gpu() else { return };
    let mut changing = Vec::new();
    for (strategy, method) in [
        (Strategy::Parallel, DistanceMethod::Bvh),
        (Strategy::Sequential, DistanceMethod::Brute),
        (Strategy::Direct, DistanceMethod::Raster),
        (Strategy::Respawn, DistanceMethod::Bvh),
    ] {
        let mut simulation = Simulation::new(&gpu.ctx, &trio(strategy, method)).unwrap();
        for _ in 0..8 {
            gpu.run(|rec| simulation.record_step(rec));
        }
        let state = simulation.snapshot().unwrap();
        let mut kernels = Vec::new();
        gpu.run(|rec| kernels = simulation.kernels(rec));
        assert!(kernels.len() > 5, "{kernels:?}");
        kernels.sort();
        kernels.dedup();
        for kernel in kernels {
            simulation.restore(&state).unwrap();
            let mut alone = None;
            gpu.run(|rec| alone = Some(simulation.record_before(rec, &kernel).unwrap()));
            let alone = alone.unwrap();
            let found = everything_of(&gpu, &simulation, &kernel);
            let once = |rec: &mut Recorder| simulation.record_alone(rec, &alone, "step");
            gpu.run(once);
            let after = everything_of(&gpu, &simulation, &kernel);
            for times in 1..4 {
                gpu.run(|rec| {
                    (0..times).for_each(|_| simulation.record_alone(rec, &alone, "step"))
                });
                let again = everything_of(&gpu, &simulation, &kernel);
                assert!(again == after, "{strategy:?}: {kernel}, {times} times");
            }
            if after != found {
                changing.push(kernel);
            }
        }
        // The way back.
        simulation.restore(&state).unwrap();
        assert_eq!(simulation.snapshot().unwrap().hash(), state.hash());
        // Past the next sort, as if nothing had been between.
        let mut untouched = Simulation::new(&gpu.ctx, &trio(strategy, method)).unwrap();
        untouched.restore(&state).unwrap();
        let continued = [&mut simulation, &mut untouched].map(|simulation| {
            for _ in 0..12 {
                gpu.run(|rec| simulation.record_step(rec));
            }
            let state = simulation.snapshot().unwrap();
            state.validate(simulation.setup()).unwrap();
            state.hash()
        });
        assert_eq!(continued[0], continued[1], "{strategy:?}");
    }
    let others = [
        "transfer_in",
        "close_list",
        "transfer_out",
        "move_borders",
        "defragment_scan",
        "defragment_swap",
        "respawn",
        "diffuse",
    ];
    for kernel in FORMS_OF_ADVANCE.into_iter().chain(others) {
        let known = changing.iter().any(|name| name == kernel);
        assert!(known, "{kernel} changes something: {changing:?}");
    }
    gpu.finish();
}

/// Two that touch, one of which moves.
fn moving_pair(method: DistanceMethod) -> Scene {
    scene_of_several(&TRIO[..2], |s| {
        s.particles.count = 500;
        s.atlas.size = 128;
        s.distance.method = method;
        s.objects[1].motion.spin = [0.0, 60.0, 0.0];
    })
}

/// What the tiles of distances leave: how far they are from others, and how many must be looked at.
fn tiles(gpu: &Gpu, simulation: &Simulation) -> (Vec<f32>, Vec<u32>) {
    let (ctx, s) = (&gpu.ctx, simulation.state());
    let groups = ctx.download(&s.near.tile_groups).unwrap();
    (
        ctx.download(&s.near.margins).unwrap(),
        bytemuck::cast_slice(&groups).to_vec(),
    )
}

/// With results of the step before, most tiles need no search. Alone, the kernels find no more and no fewer.
#[test]
fn distances_alone_use_results_of_the_step_before() {
    let Some(gpu) = gpu() else { return };
    let scene = moving_pair(DistanceMethod::Bvh);
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let before = |simulation: &mut Simulation, kernel: &str| {
        let mut alone = None;
        gpu.run(|rec| alone = Some(simulation.record_before(rec, kernel).unwrap()));
        alone.unwrap()
    };
    // In the first step nothing is known.
    assert!(before(&mut simulation, "distance").distances().is_first);
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    for _ in 0..6 {
        gpu.run(|rec| simulation.record_step(rec));
    }
    let cold = tiles(&gpu, &simulation);
    let alone = before(&mut simulation, "distance_tiles");
    let update = alone.distances();
    assert!(!update.is_first && !update.jobs.is_empty());
    assert!(update.moves.iter().all(|way| *way < UNKNOWN_MOVE));
    gpu.run(|rec| simulation.record_alone(rec, &alone, "step"));
    let found = tiles(&gpu, &simulation);
    assert!(found != cold);

    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    for _ in 0..7 {
        gpu.run(|rec| simulation.record_step(rec));
    }
    assert!(tiles(&gpu, &simulation) == found, "as in the step");
    gpu.finish();
}

/// If nothing moves, only the first step computes distances; they can still be measured.
#[test]
fn distances_of_what_stands_still_are_those_of_the_first_step() {
    let Some(gpu) = gpu() else { return };
    let scene = trio(Strategy::Parallel, DistanceMethod::Bvh);
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    for _ in 0..3 {
        gpu.run(|rec| simulation.record_step(rec));
    }
    let mut alone = None;
    gpu.run(|rec| alone = Some(simulation.record_before(rec, "unfold").unwrap()));
    let alone = alone.unwrap();
    assert!(alone.distances().is_first && alone.distances().jobs.len() == 3);
    gpu.finish();
}
