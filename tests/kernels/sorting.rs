//! Segments of the particles are put in the order in which they lie together in the atlas: the kernels against their twins, how
//! segments and bins are cut, and what a sort leaves as it was.

use crate::common::{Gpu, TRIO, awkward_sizes, gpu, scene, scene_of_several};
use bytemuck::Zeroable;
use myxo::gpu::{Buffer, Pipeline, Texels, Threads};
use myxo::scene::Scene;
use myxo::scene::settings::Strategy;
use myxo::sim::kernels::{
    SortCount, SortCountArgs, SortScan, SortScanArgs, SortScanParams, SortScatter, SortScatterArgs,
    SortSums, SortSumsArgs, SortSumsParams,
};
use myxo::sim::plan::{Means, Plan};
use myxo::sim::sorting::{
    Bins, SORT_INTERVAL, STRETCH, Segment, Segments, most_parts, part_bits, stretches,
};
use myxo::sim::twin::sort::{RUN, sort_count, sort_scan, sort_scatter, sort_sums};
use myxo::sim::types::{Motion, Particle, Window};
use myxo::sim::{Setup, Simulation, Snapshot};

fn trio(count: u32, size: u32, strategy: Strategy) -> Scene {
    scene_of_several(&TRIO, |s| {
        s.particles.count = count;
        s.atlas.size = size;
        s.physarum.speed = 0.02;
        s.transfer.strategy = strategy;
        s.transfer.threshold = 0.01;
    })
}

fn bin_of(setup: &Setup, part_bits: u32, particle: &Particle) -> u32 {
    Bins::part_of((setup.bins.tile_shift, part_bits), &setup.strips, particle)
}

/// The parts of bins that particles lie in, in the order of the ring.
fn bins_of(setup: &Setup, bits: u32, windows: &[Window], particles: &[Particle]) -> Vec<u32> {
    let start = windows.first().map_or(0, |window| window.start);
    let ring = particles.len() as u32;
    let slots = (0..ring).map(|i| Window::slot(start, i, ring) as usize);
    slots
        .map(|slot| bin_of(setup, bits, &particles[slot]))
        .collect()
}

/// What the kernels work on.
struct Case {
    scene: Scene,
    setup: Setup,
    particles: Vec<Particle>,
    motions: Vec<Motion>,
    /// None where objects have none.
    windows: Vec<Window>,
    /// log2 of the parts of a bin along a side.
    part_bits: u32,
}

/// What they leave.
#[derive(Clone, PartialEq)]
struct Sorted {
    counted: Vec<u32>,
    sums: Vec<u32>,
    scanned: Vec<u32>,
    cleared: Vec<u32>,
    particles: Vec<Particle>,
    motions: Vec<Motion>,
}

impl Case {
    /// Particles in no order; with windows each object's in its window, of which the first begins in the middle of the ring.
    fn new(count: u32, size: u32, windows: bool, part_bits: u32) -> Self {
        let scene = trio(count, size, Strategy::Parallel);
        let setup = Setup::new(&scene).unwrap();
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
        let mut particles = setup.particles.clone();
        let mut motions = vec![Motion::zeroed(); count as usize];
        if windows {
            for (i, particle) in (0..).zip(in_order) {
                particles[Window::slot(rings[0].start, i, count) as usize] = particle;
            }
        }
        // Distinct values, to check that motions move with their particles.
        for (particle, motion) in particles.iter().zip(&mut motions) {
            motion.pending = particle.id as f32;
        }
        Self {
            scene,
            setup,
            particles,
            motions,
            windows: if windows { rings } else { Vec::new() },
            part_bits,
        }
    }

    fn plan(&self) -> Plan<'_> {
        let means = Means {
            part_bits: self.part_bits,
            ..Means::of_host(false, 1)
        };
        Plan::new(&self.scene.settings, &self.setup, 0, means)
    }

    fn by_kernels(&self, gpu: &Gpu, segment: Segment) -> Sorted {
        let ctx = &gpu.ctx;
        let plan = self.plan();
        let buffer = |name: &str, words: &[u32]| Buffer::from_slice(ctx, name, words).unwrap();
        let texels = |buffer: &Buffer<u32>| Texels::new(buffer, 4).unwrap();
        let particles = buffer("particles", bytemuck::cast_slice(&self.particles));
        let motions = buffer("motions", bytemuck::cast_slice(&self.motions));
        let strips = buffer("strips", bytemuck::cast_slice(&self.setup.strips));
        let room = vec![0; 4 * segment.count as usize];
        let room = ["segment_particles", "segment_motions"].map(|name| buffer(name, &room));
        let most = most_parts(self.setup.bins.count);
        let zeros = |count: u32| vec![0; count as usize];
        let bins = buffer("bins", &zeros(most));
        let sums = buffer("sums", &zeros(stretches(most)));
        let places = buffer("places", &zeros(most));
        let none = [Window::default()];
        let windows = if self.windows.is_empty() {
            &none[..]
        } else {
            &self.windows
        };
        let windows = Buffer::from_slice(ctx, "windows", windows).unwrap();
        let count = Pipeline::<SortCount>::new(ctx, &()).unwrap();
        let add = Pipeline::<SortSums>::new(ctx, &()).unwrap();
        let scan = Pipeline::<SortScan>::new(ctx, &()).unwrap();
        let scatter = Pipeline::<SortScatter>::new(ctx, &()).unwrap();
        let threads = Threads(segment.count);
        gpu.run(|rec| {
            let args = SortCountArgs {
                particles: &texels(&particles),
                motions: &texels(&motions),
                strips: &texels(&strips),
                bins: &bins,
                segment_particles: &texels(&room[0]),
                segment_motions: &texels(&room[1]),
                windows: &windows,
            };
            rec.dispatch(&count, threads, args, plan.sort_count(segment).params);
        });
        let counted = ctx.download(&bins).unwrap();
        gpu.run(|rec| {
            let args = SortSumsArgs {
                bins: &bins,
                sums: &sums,
            };
            rec.dispatch(&add, plan.bin_runs(), args, plan.sort_sums().params);
        });
        gpu.run(|rec| {
            let args = SortScanArgs {
                bins: &bins,
                sums: &sums,
                places: &places,
            };
            rec.dispatch(&scan, plan.bin_runs(), args, plan.sort_scan().params);
        });
        let [sums, scanned, cleared] =
            [&sums, &places, &bins].map(|buffer| ctx.download(buffer).unwrap());
        gpu.run(|rec| {
            let args = SortScatterArgs {
                segment_particles: &texels(&room[0]),
                segment_motions: &texels(&room[1]),
                strips: &texels(&strips),
                places: &places,
                particles: &texels(&particles),
                motions: &texels(&motions),
                windows: &windows,
            };
            rec.dispatch(&scatter, threads, args, plan.sort_scatter(segment).params);
        });
        let words = |buffer| ctx.download::<u32>(buffer).unwrap();
        Sorted {
            counted,
            sums,
            scanned,
            cleared,
            particles: bytemuck::pod_collect_to_vec(&words(&particles)),
            motions: bytemuck::pod_collect_to_vec(&words(&motions)),
        }
    }

    fn by_twins(&self, segment: Segment) -> Sorted {
        let plan = self.plan();
        let (strips, windows) = (&self.setup.strips, &self.windows);
        let most = most_parts(self.setup.bins.count);
        let mut bins = vec![0; most as usize];
        let mut sums = vec![0; stretches(most) as usize];
        let mut places = bins.clone();
        let (mut particles, mut motions) = (self.particles.clone(), self.motions.clone());
        let mut segment_particles = vec![Particle::zeroed(); segment.count as usize];
        let mut segment_motions = vec![Motion::zeroed(); segment.count as usize];
        sort_count(
            &plan.sort_count(segment).params,
            strips,
            &mut bins,
            windows,
            (&particles, &motions),
            (&mut segment_particles, &mut segment_motions),
        );
        let counted = bins.clone();
        sort_sums(&plan.sort_sums().params, &bins, &mut sums);
        sort_scan(&plan.sort_scan().params, &mut bins, &sums, &mut places);
        let scanned = places.clone();
        sort_scatter(
            &plan.sort_scatter(segment).params,
            strips,
            &mut places,
            windows,
            (&segment_particles, &segment_motions),
            (&mut particles, &mut motions),
        );
        Sorted {
            counted,
            sums,
            scanned,
            cleared: bins,
            particles,
            motions,
        }
    }

    /// Checks what holds after a segment was sorted.
    fn check(&self, segment: Segment, sorted: &Sorted, what: &str) {
        let Sorted {
            particles, motions, ..
        } = sorted;
        let bins = bins_of(&self.setup, self.part_bits, &self.windows, particles);
        let [first, end] = [segment.first, segment.first + segment.count].map(|i| i as usize);
        assert!(bins[first..end].is_sorted(), "bins come in order: {what}");
        let start = self.windows.first().map_or(0, |window| window.start);
        let ring = particles.len() as u32;
        for i in (0..ring).filter(|i| !(first..end).contains(&(*i as usize))) {
            let slot = Window::slot(start, i, ring) as usize;
            assert_eq!(particles[slot], self.particles[slot], "others stay: {what}");
        }
        let mut ids: Vec<u32> = particles.iter().map(|particle| particle.id).collect();
        ids.sort_unstable();
        assert!(ids.into_iter().eq(0..ring), "none is lost: {what}");
        for (particle, motion) in particles.iter().zip(motions) {
            assert_eq!(
                motion.pending, particle.id as f32,
                "motions go along: {what}"
            );
        }
        for (object, window) in (0..).zip(&self.windows) {
            for i in 0..window.count {
                let slot = Window::slot(window.start, i, ring) as usize;
                let triangle = particles[slot].triangle as usize;
                let own = self.setup.surface.triangles[triangle].object;
                assert_eq!(own, object, "windows stay: {what}");
            }
        }
    }
}

/// Catches kernels that do other than their twins, a segment that reaches beyond itself, and a segment that tears windows apart: with
/// segments of every kind, within windows and across them, and where the ring begins in the middle of one.
#[test]
fn kernels_that_sort_agree_with_their_twins() {
    let Some(gpu) = gpu() else { return };
    for count in awkward_sizes(64).into_iter().filter(|&count| count > 0) {
        for (size, windows, part_bits) in [(97, true, 2), (203, false, 1), (128, true, 0)] {
            let mut case = Case::new(count, size, windows, part_bits);
            for (segments, step) in [(1, 0), (2, 8), (4, 16 + 4), (16, 16 + 15), (16, 0), (4, 12)] {
                let Some(segment) = Segments::new(count, segments).due(step) else {
                    continue;
                };
                let what = format!("{count} in {size}, {segment:?} of {segments}");
                let sorted = case.by_kernels(&gpu, segment);
                let by_twins = case.by_twins(segment);
                assert_eq!(sorted.counted, by_twins.counted, "{what}");
                assert_eq!(sorted.sums, by_twins.sums, "{what}");
                assert_eq!(sorted.scanned, by_twins.scanned, "{what}");
                assert_eq!(sorted.cleared, by_twins.cleared, "{what}");
                case.check(segment, &sorted, &what);
                case.check(segment, &by_twins, &what);
                (case.particles, case.motions) = (sorted.particles, sorted.motions);
            }
        }
    }
    gpu.finish();
}

/// Catches sums of bins that are lost between the groups, of which there are more than a group has invocations, and bins that are not cleared.
#[test]
fn any_number_of_bins_is_added_up() {
    let Some(gpu) = gpu() else { return };
    let ctx = &gpu.ctx;
    let add = Pipeline::<SortSums>::new(ctx, &()).unwrap();
    let scan = Pipeline::<SortScan>::new(ctx, &()).unwrap();
    for bin_count in [
        1,
        15,
        16,
        17,
        STRETCH - 1,
        STRETCH,
        STRETCH + 1,
        5000,
        1 << 20,
    ] {
        let counts: Vec<u32> = (0..bin_count).map(|i: u32| i % 1021 * 7919 % 13).collect();
        let zeros = |count: u32| vec![0; count as usize];
        let bins = Buffer::from_slice(ctx, "bins", &counts).unwrap();
        let sums = Buffer::from_slice(ctx, "sums", &zeros(stretches(bin_count))).unwrap();
        let places = Buffer::from_slice(ctx, "places", &zeros(bin_count)).unwrap();
        let threads = Threads(bin_count.div_ceil(RUN));
        gpu.run(|rec| {
            let args = SortSumsArgs {
                bins: &bins,
                sums: &sums,
            };
            rec.dispatch(&add, threads, args, SortSumsParams { bin_count });
        });
        gpu.run(|rec| {
            let args = SortScanArgs {
                bins: &bins,
                sums: &sums,
                places: &places,
            };
            rec.dispatch(&scan, threads, args, SortScanParams { bin_count });
        });
        let mut before = 0;
        let expected: Vec<u32> = counts
            .iter()
            .map(|count| {
                before += count;
                before - count
            })
            .collect();
        assert!(ctx.download(&places).unwrap() == expected, "{bin_count}");
        assert!(
            ctx.download(&bins).unwrap() == zeros(bin_count),
            "{bin_count}"
        );
    }
    gpu.finish();
}

/// Catches segments that leave particles out, or that are longer than the room for them.
#[test]
fn segments_of_a_round_share_all_particles() {
    for particles in [1, 2, 3, 16, 31, 32, 63, 1021, 100_000, u32::MAX >> 2] {
        for count in [1, 2, 4, 8, 16] {
            let segments = Segments::new(particles, count);
            let mut rounds = [0, 1].map(|round| {
                let steps = round * SORT_INTERVAL..(round + 1) * SORT_INTERVAL;
                let due: Vec<Segment> = steps.filter_map(|step| segments.due(step)).collect();
                let mut end = 0;
                for segment in &due {
                    assert_eq!(segment.first, end, "{particles} in {count}");
                    assert!(
                        segment.count <= segments.longest(),
                        "{particles} in {count}"
                    );
                    end += segment.count;
                }
                assert_eq!(end, particles, "{particles} in {count}");
                due
            });
            // Fewer end before the last segment begins, because half a segment is rounded up.
            let is_large = particles > 4 * count * count;
            if count == 1 {
                assert_eq!(rounds[0], rounds[1]);
            } else if is_large {
                assert_eq!(rounds[0].len(), count as usize);
                // Borders of one round lie in the middle of segments of the other.
                let border = rounds[0].pop().map(|segment| segment.first);
                assert!(
                    rounds[1]
                        .iter()
                        .all(|segment| Some(segment.first) != border)
                );
            }
        }
    }
    // Few particles are not cut, and on a CPU more are few.
    for on_cpu in [true, false] {
        assert_eq!(Segments::of(5000, on_cpu).count(), 1);
        assert_eq!(Segments::of(1 << 19, on_cpu).count(), 1);
        assert_eq!(Segments::of(10_000_000, on_cpu).count(), 16);
    }
    assert!(Segments::of(1 << 22, true).count() < Segments::of(1 << 22, false).count());
    // With many particles, there is only room for some of them.
    assert!(Segments::room(10_000_000) < 700_000);
    for particles in [1, 20_000, 1 << 19, 1 << 22, 1 << 24] {
        let room = Segments::room(particles);
        for on_cpu in [true, false] {
            assert!(
                Segments::of(particles, on_cpu).longest() <= room,
                "{particles}"
            );
        }
    }
}

/// Every segment is in order of bins at the end of its step, and the whole is, once every particle had time to come to its segment: at
/// most as many rounds as there are half segments.
#[test]
fn rounds_of_segments_put_all_in_order() {
    for (count, windows, part_bits) in [(1021, false, 0), (1021, true, 2), (199, true, 1)] {
        for segments in [1, 2, 8, 16] {
            let mut case = Case::new(count, 128, windows, part_bits);
            let segments = Segments::new(count, segments);
            for step in 0..2 * u64::from(segments.count()) * SORT_INTERVAL {
                if let Some(segment) = segments.due(step) {
                    let sorted = case.by_twins(segment);
                    case.check(segment, &sorted, "by twins");
                    (case.particles, case.motions) = (sorted.particles, sorted.motions);
                }
            }
            let bins = bins_of(&case.setup, part_bits, &case.windows, &case.particles);
            assert!(bins.is_sorted(), "{count} in {}", segments.count());
        }
    }
}

/// Neighbours in memory that lie in ascending bins: their share.
fn order(setup: &Setup, part_bits: u32, state: &Snapshot) -> f64 {
    let bins = bins_of(setup, part_bits, &state.transfers.windows, &state.particles);
    let ascending = bins.windows(2).filter(|pair| pair[0] <= pair[1]).count();
    ascending as f64 / (bins.len() - 1) as f64
}

/// Particles lie in order from the start, and after a step in which all are sorted, whatever the strategy, but where they change
/// objects in place.
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
        let at_start = order(
            simulation.setup(),
            simulation.part_bits(),
            &simulation.snapshot().unwrap(),
        );
        if strategy == Strategy::Scattered {
            let state = simulation.snapshot().unwrap();
            assert!((0..).zip(&state.particles).all(|(slot, p)| p.id == slot));
            continue;
        }
        assert_eq!(at_start, 1.0, "{strategy:?}");
        assert_eq!(simulation.segments().count(), 1);
        let mut runs = Vec::new();
        for _ in 0..SORT_INTERVAL + 2 {
            gpu.run(|rec| simulation.record_step(rec));
            let state = simulation.snapshot().unwrap();
            state.validate(simulation.setup()).unwrap();
            runs.push(order(simulation.setup(), simulation.part_bits(), &state));
        }
        let share = |step: u64| runs[step as usize];
        for sorted in [0, SORT_INTERVAL] {
            assert_eq!(share(sorted), 1.0, "{strategy:?}: {runs:?}");
        }
        assert!(share(SORT_INTERVAL - 1) < 0.9, "{strategy:?}: {runs:?}");
    }
    gpu.finish();
}

/// If steps sort segments, all particles are nearly as well ordered as if they were sorted at once, also from a checkpoint in the middle of
/// a round, and end in the same state.
#[test]
fn segments_keep_all_in_order() {
    let Some(gpu) = gpu() else { return };
    let mut scene = trio(20_000, 256, Strategy::Parallel);
    scene.settings.physarum.speed = 0.001;
    let mut hashes = Vec::new();
    for (segments, part_bits) in [(1, 0), (4, 1), (16, 2)] {
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        simulation.sort_in(segments, part_bits);
        assert_eq!(simulation.segments().count(), segments);
        let mut least = 1.0_f64;
        for step in 0..2 * SORT_INTERVAL + 5 {
            gpu.run(|rec| simulation.record_step(rec));
            let state = simulation.snapshot().unwrap();
            if step == SORT_INTERVAL + 3 {
                simulation.restore(&state).unwrap();
            }
            least = least.min(order(simulation.setup(), part_bits, &state));
        }
        // In no order it would be half.
        assert!(least > 0.8, "{least} in {segments}");
        let state = simulation.snapshot().unwrap();
        state.validate(simulation.setup()).unwrap();
        hashes.push(state.hash());
    }
    assert!(hashes.iter().all(|hash| *hash == hashes[0]), "{hashes:?}");
    gpu.finish();
}

/// Few bins where triangles are small, never more than can be added up, those of an object one after the other; and every particle
/// that can be finds one of its triangle's.
#[test]
fn bins_are_few_and_those_of_objects_lie_together() {
    let large = scene("builtin:plane?columns=1&rows=1", |s| s.atlas.size = 1024);
    let fine = scene("builtin:torus?major=200&minor=100", |s| s.atlas.size = 1024);
    let several = trio(10, 203, Strategy::Parallel);
    for (scene, least, most) in [(large, 200, 1024), (fine, 500, 1024), (several, 40, 1024)] {
        let setup = Setup::new(&scene).unwrap();
        let Bins { tile_shift, count } = setup.bins;
        assert!((least..=most).contains(&count), "{:?}", setup.bins);
        let mut ranges = vec![(u32::MAX, 0); setup.poses.len()];
        for triangle in 0..setup.strips.len() as u32 {
            let object = setup.strips[triangle as usize].shape.object as usize;
            for (u, v) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.5), (0.3, 0.3)] {
                let particle = Particle {
                    triangle,
                    u,
                    v,
                    id: 0,
                };
                let bin = Bins::part_of((tile_shift, 0), &setup.strips, &particle);
                assert!(bin < count, "{bin} of {count}");
                for bits in [1, 2] {
                    let part = Bins::part_of((tile_shift, bits), &setup.strips, &particle);
                    assert_eq!(part >> (2 * bits), bin, "parts of a bin lie together");
                }
                let range = &mut ranges[object];
                *range = (range.0.min(bin), range.1.max(bin));
            }
        }
        assert!(
            ranges.windows(2).all(|pair| pair[0].1 < pair[1].0),
            "{ranges:?}"
        );
        assert!(ranges.iter().all(|range| range.0 <= range.1), "{ranges:?}");
    }
    // More particles are sorted more finely.
    let mut setup = Setup::new(&trio(10, 1024, Strategy::Direct)).unwrap();
    let few = setup.bins;
    let many = Bins::number(&mut setup.strips, 1_000_000);
    assert!(
        many.count > 2 * few.count && many.tile_shift < few.tile_shift,
        "{few:?}, {many:?}"
    );
    let most = Bins::number(&mut setup.strips, 1 << 30);
    assert!(most.count <= 1 << 16);
    // Only cards sort more finely than by tiles, and no more finely than bins can be added up.
    assert_eq!([part_bits(5000, true), part_bits(5000, false)], [0, 2]);
    assert_eq!([most_parts(1 << 16), most_parts(1 << 18)], [1 << 20; 2]);
    assert_eq!(most_parts((1 << 20) + 1), (1 << 20) + 1);
}
