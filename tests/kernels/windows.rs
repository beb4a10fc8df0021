//! Windows under random moves: the kernels against their twins, each particle in its object's window after every step, by many
//! invocations and by one.

use std::sync::Arc;

use bytemuck::Zeroable;
use myxo::gpu::{Buffer, Context, DispatchGroups, Pipeline, Texels, Threads};
use myxo::mesh::strip::StripTriangle;
use myxo::rng::{Purpose, random, unit};
use myxo::sim::kernels::{
    DefragmentScan, DefragmentScanArgs, DefragmentScanConstants, DefragmentScanParams,
    DefragmentSwap, DefragmentSwapArgs, DefragmentSwapConstants, DefragmentSwapParams, MoveBorders,
    MoveBordersArgs, MoveBordersParams,
};
use myxo::sim::transfers::{most_displaced, most_gained};
use myxo::sim::twin::windows::{self, defragment_scan, defragment_swap, move_borders};
use myxo::sim::types::{Border, Flow, Motion, Particle, Transfer, Window};

use crate::common::{Gpu, gpu};

/// What an experiment begins with.
#[derive(Clone, Copy, Debug)]
struct Case {
    particles: u32,
    objects: u32,
    /// How many particles change objects in a step.
    share: f32,
    /// All begin on this object; else everywhere.
    all_on: Option<u32>,
    /// All that change go there; else anywhere.
    all_to: Option<u32>,
    seed: u32,
}

/// Many objects, of which one particle changes to another.
const ONE_OF_MANY: Case = Case {
    particles: 6400,
    objects: 64,
    share: 0.0,
    all_on: None,
    all_to: None,
    seed: 3,
};

/// Particles on objects of one triangle each, and all that keeps them in windows.
#[derive(Clone)]
struct Ring {
    case: Case,
    /// Are particles born? Then any slot may hold a wrong one.
    breeds: bool,
    strips: Vec<StripTriangle>,
    particles: Vec<Particle>,
    motions: Vec<Motion>,
    windows: Vec<Window>,
    borders: Vec<Border>,
    flow: Flow,
    groups: Vec<DispatchGroups>,
    particle_indices: Vec<u32>,
    transfers: Vec<Transfer>,
    holes: Vec<u32>,
    strays: Vec<Particle>,
    stray_motions: Vec<Motion>,
}

impl Ring {
    fn new(case: Case) -> Self {
        let Case {
            particles, objects, ..
        } = case;
        let object_of = |id: u32| {
            let [word, ..] = random(case.seed, id, 0, Purpose::Start);
            case.all_on.unwrap_or(word % objects)
        };
        let mut ids: Vec<u32> = (0..particles).collect();
        ids.sort_by_key(|&id| object_of(id));
        // The ring begins somewhere, so that windows wrap.
        let mut start = case.seed % particles;
        let mut in_order = vec![Particle::zeroed(); ids.len()];
        let mut motions = vec![Motion::zeroed(); ids.len()];
        for (i, &id) in (0..).zip(&ids) {
            let slot = Window::slot(start, i, particles) as usize;
            in_order[slot] = Particle {
                triangle: object_of(id),
                u: 0.25,
                v: 0.5,
                id,
            };
            // Distinct values, to check that it moves with the particle.
            motions[slot].pending = id as f32;
        }
        let mut windows = Vec::new();
        for object in 0..objects {
            let count = ids.iter().filter(|&&id| object_of(id) == object).count() as u32;
            windows.push(Window { start, count });
            start = (start + count) % particles;
        }
        let strip = |object| {
            let mut strip = StripTriangle::zeroed();
            strip.shape.object = object;
            strip
        };
        let lists = particles as usize;
        Self {
            case,
            breeds: false,
            strips: (0..objects).map(strip).collect(),
            particles: in_order.clone(),
            motions: motions.clone(),
            windows,
            borders: vec![Border::default(); objects as usize],
            flow: Flow::default(),
            groups: vec![DispatchGroups::of(0, 64); 5],
            particle_indices: vec![0; lists],
            transfers: vec![Transfer::default(); lists],
            holes: vec![0; lists],
            strays: in_order,
            stray_motions: motions,
        }
    }

    /// Particles change objects: all of a step before `move_borders`. Some come back to where they were.
    fn change_objects(&mut self, step: u32) {
        let Case {
            share,
            objects,
            all_to,
            seed,
            ..
        } = self.case;
        self.flow.leaving = 0;
        for (slot, particle) in (0..).zip(&mut self.particles) {
            let [a, b, ..] = random(seed, particle.id, step, Purpose::SensorNoise);
            if unit(a) >= share {
                continue;
            }
            let place = self.flow.leaving as usize;
            let (source, target) = (particle.triangle, all_to.unwrap_or(b % objects));
            particle.triangle = target;
            self.particle_indices[place] = slot;
            self.transfers[place] = Transfer {
                particle: slot,
                source,
                target,
                ..Transfer::default()
            };
            if source != target {
                self.borders[source as usize].left += 1;
                self.borders[target as usize].came += 1;
            }
            self.flow.leaving += 1;
        }
    }

    /// Particles come to other objects without being listed, as those do that are born where others have died.
    fn bear(&mut self, step: u32) {
        let Case { objects, seed, .. } = self.case;
        self.breeds = true;
        for particle in &mut self.particles {
            let [a, b, ..] = random(seed, particle.id, step, Purpose::Population);
            let (source, target) = (particle.triangle, b % objects);
            if unit(a) < 0.3 && source != target {
                particle.triangle = target;
                self.borders[source as usize].left += 1;
                self.borders[target as usize].came += 1;
            }
        }
    }

    /// How many slots are looked at.
    fn candidates(&self) -> u32 {
        match self.breeds {
            true => self.case.particles,
            false => self.flow.leaving + self.flow.gained,
        }
    }

    /// One particle changes objects.
    fn change_one(&mut self, source: u32, target: u32) {
        let slot = self.windows[source as usize].start;
        self.particles[slot as usize].triangle = target;
        self.particle_indices[0] = slot;
        self.transfers[0] = Transfer {
            particle: slot,
            source,
            target,
            ..Transfer::default()
        };
        self.flow.leaving = 1;
        self.borders[source as usize].left = 1;
        self.borders[target as usize].came = 1;
    }

    fn border_params(&self) -> MoveBordersParams {
        MoveBordersParams {
            object_count: self.case.objects,
            particle_count: self.case.particles,
            scan_group: 64,
            swap_group: 64,
            whole: u32::from(self.breeds),
        }
    }

    fn move_borders(&mut self) {
        let params = self.border_params();
        let Self {
            flow,
            windows,
            borders,
            groups,
            ..
        } = self;
        move_borders(&params, flow, windows, borders, groups);
    }

    /// The runs of one invocation, or one for all.
    fn runs(&self, sequential: bool, entries: u32) -> Vec<(u32, u32)> {
        // Runs that end within short lists, too.
        let run = if self.case.particles > 10_000 {
            windows::RUN
        } else {
            50
        };
        let runs = (0..entries + 1).step_by(run as usize);
        if sequential {
            runs.map(|first| (first, run)).collect()
        } else {
            vec![(0, 1)]
        }
    }

    fn scan_params(&self, (first, count): (u32, u32)) -> DefragmentScanParams {
        DefragmentScanParams {
            object_count: self.case.objects,
            particle_count: self.case.particles,
            first,
            count,
            whole: u32::from(self.breeds),
        }
    }

    fn scan(&mut self, sequential: bool) {
        let constants = DefragmentScanConstants { sequential };
        for run in self.runs(sequential, self.candidates()) {
            let params = self.scan_params(run);
            defragment_scan(
                &constants,
                &params,
                &self.flow,
                &self.windows,
                &mut self.borders,
                (&self.particle_indices, &self.transfers),
                (&self.particles, &self.motions),
                &self.strips,
                &mut self.holes,
                (&mut self.strays, &mut self.stray_motions),
            );
        }
    }

    fn swap(&mut self, sequential: bool) {
        let constants = DefragmentSwapConstants { sequential };
        for (first, count) in self.runs(sequential, self.flow.entries) {
            let params = DefragmentSwapParams {
                object_count: self.case.objects,
                particle_count: self.case.particles,
                first,
                count,
            };
            defragment_swap(
                &constants,
                &params,
                &self.flow,
                &self.borders,
                &self.holes,
                (&self.strays, &self.stray_motions),
                (&mut self.particles, &mut self.motions),
            );
        }
    }

    /// What must hold after a step.
    fn check(&self) {
        let Self { case, .. } = self;
        let mut ids: Vec<u32> = self.particles.iter().map(|p| p.id).collect();
        ids.sort_unstable();
        assert!(ids.into_iter().eq(0..case.particles), "{case:?}");
        let mut all = 0;
        let mut start = self.windows[0].start;
        for (object, window) in (0..).zip(&self.windows) {
            assert_eq!(window.start, start, "windows follow: {case:?}");
            for i in 0..window.count {
                let slot = Window::slot(window.start, i, case.particles) as usize;
                assert_eq!(self.particles[slot].triangle, object, "{case:?}");
                let id = self.particles[slot].id as f32;
                assert_eq!(self.motions[slot].pending, id, "motions go along: {case:?}");
            }
            start = Window::slot(start, window.count, case.particles);
            all += window.count;
        }
        assert_eq!(all, case.particles, "{case:?}");
        for border in &self.borders {
            assert_eq!(border.holes, border.strays, "{case:?}");
        }
        assert_eq!(self.flow.mismatches, 0, "{case:?}");
        if self.breeds {
            return;
        }
        // The room for lists is no larger than this.
        let Flow {
            leaving,
            gained,
            entries,
            ..
        } = self.flow;
        assert!(
            u64::from(gained) <= most_gained(leaving, case.objects),
            "{case:?}"
        );
        let most = most_displaced(leaving, case.objects, case.particles.into());
        assert!(u64::from(entries) <= most, "{case:?}");
    }

    /// What each window's part of the lists has, in no order.
    fn listed(&self) -> Vec<(Vec<u32>, Vec<u32>)> {
        let sorted = |mut list: Vec<u32>| {
            list.sort_unstable();
            list
        };
        let parts = self.borders.iter().map(|border| {
            let part = |count| border.list as usize..(border.list + count) as usize;
            let strays = self.strays[part(border.strays)].iter();
            (
                sorted(self.holes[part(border.holes)].to_vec()),
                sorted(strays.map(|particle| particle.id).collect()),
            )
        });
        parts.collect()
    }
}

/// Awkward ones: no particle changes, all do, empty windows, more objects than particles, more objects than a group has
/// invocations.
fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (k, particles) in (0..).zip([1, 2, 3, 63, 65, 199, 1021]) {
        for objects in [2, 3, 7, 300] {
            for share in [0.0, 0.1, 1.0] {
                for (all_on, all_to) in [
                    (None, None),
                    (Some(objects - 1), None),
                    (None, Some(0)),
                    (Some(0), Some(objects / 2)),
                ] {
                    cases.push(Case {
                        particles,
                        objects,
                        share,
                        all_on,
                        all_to,
                        seed: 17 * k + 5,
                    });
                }
            }
        }
    }
    cases
}

/// Catches a particle that is lost or ends in another window, whatever changes at once.
#[test]
fn every_particle_ends_in_its_window() {
    for case in cases() {
        for sequential in [false, true] {
            let mut ring = Ring::new(case);
            for step in 0..6 {
                if step > 2 {
                    ring.bear(step);
                }
                ring.change_objects(step);
                ring.move_borders();
                ring.scan(sequential);
                ring.swap(sequential);
                ring.check();
            }
        }
    }
}

/// Catches borders that move more than they have to: the ring's beginning is free.
#[test]
fn borders_move_as_little_as_they_can() {
    for (source, target, most) in [(0, 32, 32), (0, 1, 1), (63, 0, 1), (0, 63, 1), (60, 4, 8)] {
        let mut ring = Ring::new(ONE_OF_MANY);
        ring.change_one(source, target);
        ring.move_borders();
        assert_eq!(ring.flow.gained, most, "{source} to {target}");
        ring.scan(false);
        ring.swap(false);
        ring.check();
    }
}

fn buffer<T: bytemuck::Pod>(ctx: &Arc<Context>, name: &str, data: &[T]) -> Buffer<T> {
    Buffer::from_slice(ctx, name, data).unwrap()
}

fn texels<T: bytemuck::Pod>(buffer: &Buffer<T>, components: usize) -> Texels<u32> {
    Texels::new(buffer, components).unwrap()
}

/// Catches kernels that do other than their twins, which the tests above hold to what must be.
#[test]
fn the_kernels_of_windows_agree_with_their_twins() {
    let Some(gpu) = gpu() else { return };
    // As many candidates as several runs of one invocation take.
    let large = Case {
        particles: 90_001,
        objects: 5,
        share: 0.9,
        all_on: None,
        all_to: None,
        seed: 9,
    };
    let some = cases().into_iter().filter(|case| case.share > 0.0);
    for (k, case) in some.step_by(5).chain([large]).enumerate() {
        for sequential in [false, true] {
            let mut ring = Ring::new(case);
            for step in 0..3 {
                if step == 2 {
                    ring.bear(step);
                }
                ring.change_objects(step);
                step_by_kernels(&gpu, &mut ring, sequential);
                ring.check();
            }
        }
        assert!(k < 60, "these take a while");
    }
    gpu.finish();
}

/// One particle goes half round the ring, with lists of 16: each border between moves, and lists of particles that are displaced
/// have room for more than transfers.
#[test]
fn a_transfer_between_far_objects_displaces_one_particle_at_each_border() {
    let Some(gpu) = gpu() else { return };
    for sequential in [false, true] {
        let mut ring = Ring::new(ONE_OF_MANY);
        ring.particle_indices.truncate(16);
        ring.transfers.truncate(16);
        ring.change_one(0, 32);
        step_by_kernels(&gpu, &mut ring, sequential);
        ring.check();
        let strays: u32 = ring.borders.iter().map(|border| border.strays).sum();
        assert_eq!(strays, 33);
    }
    gpu.finish();
}

/// Catches sums that leave 32 bits: with as many particles as any device could hold, and more objects than a group has invocations.
#[test]
fn borders_of_the_largest_rings_move_as_those_of_the_twin() {
    let Some(gpu) = gpu() else { return };
    let ctx = &gpu.ctx;
    let pipeline = Pipeline::<MoveBorders>::new(ctx, &()).unwrap();
    let ring = 1_u32 << 30;
    for objects in [2, 3, 64, 1000] {
        for (seed, most) in [(1, 5), (2, ring / objects), (3, ring / objects)] {
            let draw = |i: u32, k: usize| random(seed, i, objects, Purpose::Start)[k];
            let each = ring / objects;
            let mut windows: Vec<Window> = (0..objects)
                .map(|i| Window {
                    start: 0,
                    count: each + u32::from(i < ring % objects),
                })
                .collect();
            let mut start = ring - 7;
            for window in &mut windows {
                window.start = start;
                start = Window::slot(start, window.count, ring);
            }
            let mut borders = vec![Border::default(); objects as usize];
            // As many come as leave.
            let mut leaving = 0;
            for i in 0..objects {
                let left = draw(i, 0) % (most + 1);
                leaving += left;
                borders[i as usize].left = left;
                borders[(draw(i, 1) % objects) as usize].came += left;
            }
            let mut flow = Flow::default();
            let mut groups = vec![DispatchGroups::of(0, 64); 5];
            let params = MoveBordersParams {
                object_count: objects,
                particle_count: ring,
                scan_group: 64,
                swap_group: 64,
                whole: 0,
            };
            let flow_buffer = buffer(ctx, "flow", &[flow]);
            let windows_buffer = buffer(ctx, "windows", &windows);
            let borders_buffer = buffer(ctx, "borders", &borders);
            let groups_buffer = buffer(ctx, "groups", &groups);
            gpu.run(|rec| {
                let args = MoveBordersArgs {
                    flow: &flow_buffer,
                    windows: &windows_buffer,
                    borders: &borders_buffer,
                    groups: &groups_buffer,
                };
                rec.dispatch(&pipeline, Threads(1), args, params);
            });
            move_borders(&params, &mut flow, &mut windows, &mut borders, &mut groups);
            let what = format!("{objects} objects, seed {seed}");
            assert_eq!(ctx.download(&flow_buffer).unwrap(), [flow], "{what}");
            assert_eq!(ctx.download(&windows_buffer).unwrap(), windows, "{what}");
            assert_eq!(ctx.download(&borders_buffer).unwrap(), borders, "{what}");
            assert!(
                u64::from(flow.gained) <= most_gained(leaving, objects),
                "{what}"
            );
            let all: u64 = windows.iter().map(|w| u64::from(w.count)).sum();
            assert_eq!(all, u64::from(ring), "{what}");
        }
    }
    gpu.finish();
}

/// Lets the kernels do a step, compares them with the twins one by one, and continues from what they have done.
fn step_by_kernels(gpu: &Gpu, ring: &mut Ring, sequential: bool) {
    let ctx = &gpu.ctx;
    let case = ring.case;
    let borders = Pipeline::<MoveBorders>::new(ctx, &()).unwrap();
    let constants = DefragmentScanConstants { sequential };
    let scan = Pipeline::<DefragmentScan>::new(ctx, &constants).unwrap();
    let constants = DefragmentSwapConstants { sequential };
    let swap = Pipeline::<DefragmentSwap>::new(ctx, &constants).unwrap();
    let flow_buffer = buffer(ctx, "flow", &[ring.flow]);
    let windows_buffer = buffer(ctx, "windows", &ring.windows);
    let borders_buffer = buffer(ctx, "borders", &ring.borders);
    let groups_buffer = buffer(ctx, "groups", &ring.groups);
    gpu.run(|rec| {
        let args = MoveBordersArgs {
            flow: &flow_buffer,
            windows: &windows_buffer,
            borders: &borders_buffer,
            groups: &groups_buffer,
        };
        rec.dispatch(&borders, Threads(1), args, ring.border_params());
    });
    ring.move_borders();
    assert_eq!(ctx.download(&flow_buffer).unwrap(), [ring.flow], "{case:?}");
    assert_eq!(
        ctx.download(&windows_buffer).unwrap(),
        ring.windows,
        "{case:?}"
    );
    assert_eq!(
        ctx.download(&borders_buffer).unwrap(),
        ring.borders,
        "{case:?}"
    );
    assert_eq!(
        ctx.download(&groups_buffer).unwrap()[3..],
        ring.groups[3..],
        "{case:?}"
    );

    let particles = buffer(ctx, "particles", &ring.particles);
    let motions = buffer(ctx, "motions", &ring.motions);
    let holes = buffer(ctx, "holes", &ring.holes);
    let strays = buffer(ctx, "strays", &ring.strays);
    let stray_motions = buffer(ctx, "stray_motions", &ring.stray_motions);
    let indices = buffer(ctx, "particle_indices", &ring.particle_indices);
    let transfers = buffer(ctx, "transfers", &ring.transfers);
    let strips = buffer(ctx, "strips", &ring.strips);
    let candidates = ring.candidates();
    for run in ring.runs(sequential, candidates) {
        let params = ring.scan_params(run);
        gpu.run(|rec| {
            let args = DefragmentScanArgs {
                flow: &flow_buffer,
                windows: &windows_buffer,
                borders: &borders_buffer,
                particle_indices: &indices,
                transfers: &transfers,
                particles: &texels(&particles, 4),
                motions: &texels(&motions, 4),
                strips: &texels(&strips, 4),
                holes: &texels(&holes, 1),
                strays: &texels(&strays, 4),
                stray_motions: &texels(&stray_motions, 4),
            };
            let threads = if sequential { 1 } else { candidates.max(1) };
            rec.dispatch(&scan, Threads(threads), args, params);
        });
    }
    ring.scan(sequential);
    let by_twin = ring.listed();
    assert_eq!(
        ctx.download(&borders_buffer).unwrap(),
        ring.borders,
        "{case:?}"
    );
    // Both list equal entries in any order; the twin continues with the kernel's order.
    ring.holes = ctx.download(&holes).unwrap();
    ring.strays = ctx.download(&strays).unwrap();
    ring.stray_motions = ctx.download(&stray_motions).unwrap();
    assert!(ring.listed() == by_twin, "{case:?}");

    for (first, count) in ring.runs(sequential, ring.flow.entries) {
        let params = DefragmentSwapParams {
            object_count: case.objects,
            particle_count: case.particles,
            first,
            count,
        };
        gpu.run(|rec| {
            let args = DefragmentSwapArgs {
                flow: &flow_buffer,
                windows: &windows_buffer,
                borders: &borders_buffer,
                holes: &texels(&holes, 1),
                strays: &texels(&strays, 4),
                stray_motions: &texels(&stray_motions, 4),
                particles: &texels(&particles, 4),
                motions: &texels(&motions, 4),
            };
            let threads = if sequential {
                1
            } else {
                ring.flow.entries.max(1)
            };
            rec.dispatch(&swap, Threads(threads), args, params);
        });
    }
    ring.swap(sequential);
    assert!(
        ctx.download(&particles).unwrap() == ring.particles,
        "{case:?}"
    );
    assert!(ctx.download(&motions).unwrap() == ring.motions, "{case:?}");
}
