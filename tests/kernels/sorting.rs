//! Particles are put in the order in which they lie together in the atlas: the kernels against their twins, and what a
//! sort leaves as it was.

use crate::common::{Gpu, TRIO, awkward_sizes, gpu, scene_of_several};
use myxo::gpu::{Buffer, Pipeline, Texels, Threads};
use myxo::scene::Scene;
use myxo::scene::settings::Strategy;
use myxo::sim::kernels::{
    SortCount, SortCountArgs, SortCountConstants, SortCountParams, SortScan, SortScanArgs,
    SortScanParams, SortScatter, SortScatterArgs, SortScatterConstants, SortScatterParams,
};
use myxo::sim::plan::{Means, Plan};
use myxo::sim::sorting::{SORT_INTERVAL, Tiles};
use myxo::sim::twin::sort::{bin_of, sort_count, sort_scan, sort_scatter};
use myxo::sim::types::{Motion, Particle, Window};
use myxo::sim::{Setup, Simulation};

fn trio(count: u32, size: u32, strategy: Strategy) -> Scene {
    scene_of_several(&TRIO, |s| {
        s.particles.count = count;
        s.atlas.size = size;
        s.physarum.speed = 0.02;
        s.transfer.strategy = strategy;
        s.transfer.threshold = 0.01;
    })
}

/// What the kernels take.
struct SortParams {
    count: SortCountParams,
    scan: SortScanParams,
    scatter: SortScatterParams,
}

impl SortParams {
    fn of(scene: &Scene, setup: &Setup) -> Self {
        let plan = Plan::new(&scene.settings, setup, 0, Means::of_host(false, 1));
        Self {
            count: plan.sort_count().params,
            scan: plan.sort_scan().params,
            scatter: plan.sort_scatter().params,
        }
    }
}

/// What the kernels work on: each object's particles in its window, which begins anywhere in the ring.
struct Case {
    setup: Setup,
    params: SortParams,
    particles: Vec<Particle>,
    motions: Vec<Motion>,
    windows: Option<Vec<Window>>,
}

impl Case {
    fn new(count: u32, size: u32, windows: bool) -> Self {
        let scene = trio(count, size, Strategy::Parallel);
        let setup = Setup::new(&scene).unwrap();
        let params = SortParams::of(&scene, &setup);
        let object = |p: &Particle| setup.surface.triangles[p.triangle as usize].object;
        let mut in_order = setup.particles.clone();
        in_order.sort_by_key(object);
        let counts = (0..3).map(|k| in_order.iter().filter(|p| object(p) == k).count() as u32);
        let mut start = count / 3;
        let counted = counts.map(|count_of| {
            let window = Window {
                start,
                count: count_of,
            };
            start = (start + count_of) % count;
            window
        });
        let rings: Vec<Window> = counted.collect();
        let mut particles = in_order.clone();
        let mut motions = setup.motions.clone();
        if windows {
            for (i, particle) in in_order.into_iter().enumerate() {
                let slot = Window::slot(rings[0].start, i as u32, count) as usize;
                particles[slot] = particle;
                motions[slot].flags = 8 << Motion::FED_SHIFT;
            }
        }
        Self {
            setup,
            params,
            particles,
            motions,
            windows: windows.then_some(rings),
        }
    }

    /// The bins as counted, as added up, and what is sorted.
    fn by_kernels(&self, gpu: &Gpu) -> (Vec<u32>, Vec<u32>, Vec<Particle>, Vec<Motion>) {
        let ctx = &gpu.ctx;
        let windows = self.windows.is_some();
        let count = Pipeline::<SortCount>::new(ctx, &SortCountConstants { windows }).unwrap();
        let scan = Pipeline::<SortScan>::new(ctx, &()).unwrap();
        let scatter = Pipeline::<SortScatter>::new(ctx, &SortScatterConstants { windows }).unwrap();
        let texels = |name: &str, words: &[u32]| {
            Texels::new(&Buffer::from_slice(ctx, name, words).unwrap(), 4).unwrap()
        };
        let particles = texels("particles", bytemuck::cast_slice(&self.particles));
        let motions = texels("motions", bytemuck::cast_slice(&self.motions));
        let strips = texels("strips", bytemuck::cast_slice(&self.setup.strips));
        let bins = Buffer::<u32>::zeroed(ctx, "bins", self.params.scan.bin_count as usize).unwrap();
        gpu.run(|rec| {
            let args = SortCountArgs {
                particles: &particles,
                strips: &strips,
                bins: &bins,
            };
            let threads = Threads(self.params.count.particle_count);
            rec.dispatch(&count, threads, args, self.params.count);
        });
        let counted = ctx.download(&bins).unwrap();
        gpu.run(|rec| {
            rec.dispatch(
                &scan,
                Threads(1),
                SortScanArgs { bins: &bins },
                self.params.scan,
            );
        });
        let scanned = ctx.download(&bins).unwrap();
        let none = [Window { start: 0, count: 0 }];
        let windows = self.windows.as_deref().unwrap_or(&none);
        let windows = Buffer::from_slice(ctx, "windows", windows).unwrap();
        let sorted_particles =
            Buffer::zeroed(ctx, "sorted_particles", self.particles.len()).unwrap();
        let sorted_motions = Buffer::zeroed(ctx, "sorted_motions", self.particles.len()).unwrap();
        gpu.run(|rec| {
            let args = SortScatterArgs {
                particles: &particles,
                motions: &motions,
                strips: &strips,
                bins: &bins,
                sorted_particles: &Texels::new(&sorted_particles, 4).unwrap(),
                sorted_motions: &Texels::new(&sorted_motions, 4).unwrap(),
                windows: &windows,
            };
            let threads = Threads(self.params.scatter.particle_count);
            rec.dispatch(&scatter, threads, args, self.params.scatter);
        });
        let particles = ctx.download(&sorted_particles).unwrap();
        (
            counted,
            scanned,
            particles,
            ctx.download(&sorted_motions).unwrap(),
        )
    }

    fn by_twins(&self) -> (Vec<u32>, Vec<u32>, Vec<Particle>, Vec<Motion>) {
        let strips = &self.setup.strips;
        let params = &self.params.count;
        let windows = self.windows.as_deref();
        let mut bins = vec![0; self.params.scan.bin_count as usize];
        let both = (&self.particles[..], &self.motions[..]);
        sort_count(windows.is_some(), params, strips, both.0, &mut bins);
        let counted = bins.clone();
        sort_scan(&mut bins);
        let scanned = bins.clone();
        let (mut particles, mut motions) = (self.particles.clone(), self.motions.clone());
        let sorted = (&mut particles[..], &mut motions[..]);
        sort_scatter(windows, params, strips, &mut bins, both, sorted);
        (counted, scanned, particles, motions)
    }

    /// Particles and motions by bin, those of a bin by id.
    fn in_order(&self, particles: &[Particle], motions: &[Motion]) -> Vec<(u32, u32, [u32; 4])> {
        let strips = &self.setup.strips;
        let windows = self.windows.as_deref();
        let start = windows.map_or(0, |windows| windows[0].start);
        let count = particles.len() as u32;
        let rows = (0..count).map(|i| {
            let slot = Window::slot(start, i, count) as usize;
            let (particle, motion) = (particles[slot], motions[slot]);
            let bin = bin_of(windows.is_some(), &self.params.count, strips, &particle);
            (bin, particle.id, bytemuck::cast(motion))
        });
        let mut rows: Vec<_> = rows.collect();
        assert!(rows.is_sorted_by_key(|row| row.0), "bins come in order");
        rows.sort_by_key(|row| (row.0, row.1));
        rows
    }
}

#[test]
fn kernels_that_sort_agree_with_their_twins() {
    let Some(gpu) = gpu() else { return };
    for count in awkward_sizes(64).into_iter().filter(|&count| count > 0) {
        for (size, windows) in [(97, true), (203, false), (128, true)] {
            let case = Case::new(count, size, windows);
            let (counted, scanned, particles, motions) = case.by_kernels(&gpu);
            let (twin_counted, twin_scanned, twin_particles, twin_motions) = case.by_twins();
            assert_eq!(counted, twin_counted, "{count} in {size}");
            assert_eq!(scanned, twin_scanned, "{count} in {size}");
            let sorted = case.in_order(&particles, &motions);
            assert!(
                sorted == case.in_order(&twin_particles, &twin_motions),
                "{count} in {size}"
            );
            let mut ids: Vec<u32> = sorted.iter().map(|row| row.1).collect();
            ids.sort_unstable();
            assert!(ids.into_iter().eq(0..count), "nobody is lost");
        }
    }
    gpu.finish();
}

/// After the step in which it is due particles lie in order, whatever the strategy, but where they change objects in place.
#[test]
fn steps_sort_every_so_often() {
    let Some(gpu) = gpu() else { return };
    for strategy in [
        Strategy::None,
        Strategy::Direct,
        Strategy::Parallel,
        Strategy::Sequential,
        Strategy::Scattered,
    ] {
        let scene = trio(2000, 128, strategy);
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let mut runs = Vec::new();
        for step in 0..SORT_INTERVAL + 2 {
            gpu.run(|rec| simulation.record_step(rec));
            let state = simulation.snapshot().unwrap();
            state.validate(simulation.setup()).unwrap();
            let setup = simulation.setup();
            let tiles = Tiles::of(&setup.atlas, 3);
            let windows = strategy.has_windows();
            if !scene.settings.strategy().may_sort() {
                continue;
            }
            let params = SortParams::of(&scene, setup);
            assert_eq!(params.count.tile_count, tiles.count);
            let start = state
                .transfers
                .windows
                .first()
                .map_or(0, |window| window.start);
            let slots = (0..2000).map(|i| Window::slot(start, i, 2000) as usize);
            let strips = &setup.strips;
            let bins: Vec<u32> = slots
                .map(|slot| bin_of(windows, &params.count, strips, &state.particles[slot]))
                .collect();
            // Neighbours in memory that lie in ascending bins.
            let ascending = bins.windows(2).filter(|pair| pair[0] <= pair[1]).count();
            runs.push((step, ascending as f64 / (bins.len() - 1) as f64));
        }
        let share = |step: u64| runs[step as usize].1;
        if strategy == Strategy::Scattered {
            assert!(runs.is_empty());
            continue;
        }
        for sorted in [0, SORT_INTERVAL] {
            assert_eq!(share(sorted), 1.0, "{strategy:?}: {runs:?}");
        }
        assert!(share(SORT_INTERVAL - 1) < 0.9, "{strategy:?}: {runs:?}");
    }
    gpu.finish();
}

/// Few tiles for small atlases, never more bins than can be added up.
#[test]
fn tiles_grow_with_the_atlas_and_the_objects() {
    let mut setup = Setup::new(&trio(10, 128, Strategy::Direct)).unwrap();
    assert_eq!(
        Tiles::of(&setup.atlas, 3),
        Tiles {
            shift: 4,
            a_row: 8,
            count: 64
        }
    );
    setup.atlas.size = 16_384;
    let tiles = Tiles::of(&setup.atlas, 1);
    assert_eq!((tiles.shift, tiles.count), (5, 512 * 512));
    let tiles = Tiles::of(&setup.atlas, 64);
    assert!(
        tiles.count * 64 <= 1 << 18 && tiles.a_row << tiles.shift >= 16_384,
        "{tiles:?}"
    );
}
