//! The kernels that keep each object's particles together: their parameters, bindings and twins. A window holds one
//! object's particles.
//!
//! **Invariant:** the windows lie one after the other in the ring and share all its slots.
//!
//! **Invariant:** between steps every particle lies in its object's window.

use crate::gpu::{DispatchGroups, Kernel as _};
use crate::mesh::strip::StripTriangle;
use crate::scene::settings::Strategy;
use crate::sim::arrays::Arrays;
use crate::sim::kernels::{
    DefragmentScan, DefragmentScanArgs, DefragmentScanConstants, DefragmentScanParams,
    DefragmentSwap, DefragmentSwapArgs, DefragmentSwapConstants, DefragmentSwapParams, MoveBorders,
    MoveBordersArgs, MoveBordersParams,
};
use crate::sim::loops::ROUNDS;
use crate::sim::plan::Plan;
use crate::sim::state::State;
use crate::sim::transfers::{most_displaced, most_gained};
use crate::sim::types::{Border, Flow, Motion, Particle, Transfer, Window};
use crate::sim::work::{Call, StepKernel};

/// Entries that one invocation processes, each by a round of a loop and one of an inner loop; the other rounds are for windows.
pub const RUN: u32 = ROUNDS / 4;

impl Plan<'_> {
    /// Gives each window as many slots as its object has particles now.
    #[must_use]
    pub fn move_borders(&self) -> Call<MoveBorders> {
        Call {
            on: (),
            constants: (),
            params: MoveBordersParams {
                object_count: self.object_count(),
                particle_count: self.particle_count(),
                scan_group: DefragmentScan::GROUP_SIZE,
                swap_group: DefragmentSwap::GROUP_SIZE,
                whole: u32::from(self.breeds),
            },
        }
    }

    /// Lists particles in wrong windows; one invocation per run of slots that may hold one. If particles were born, any slot may.
    #[must_use]
    pub fn defragment_scan(&self, first: u32) -> Call<DefragmentScan> {
        Call {
            on: (),
            constants: DefragmentScanConstants {
                sequential: self.strategy == Strategy::Sequential,
            },
            params: DefragmentScanParams {
                object_count: self.object_count(),
                particle_count: self.particle_count(),
                first,
                count: self.entries_each(),
                whole: u32::from(self.breeds),
            },
        }
    }

    /// Moves them into the right windows.
    #[must_use]
    pub fn defragment_swap(&self, first: u32) -> Call<DefragmentSwap> {
        Call {
            on: (),
            constants: DefragmentSwapConstants {
                sequential: self.strategy == Strategy::Sequential,
            },
            params: DefragmentSwapParams {
                object_count: self.object_count(),
                particle_count: self.particle_count(),
                first,
                count: self.entries_each(),
            },
        }
    }

    /// The beginnings of runs that together hold so many entries.
    pub fn runs(&self, entries: u32) -> impl Iterator<Item = u32> + use<> {
        (0..entries).step_by(RUN as usize)
    }

    /// Upper bound on the slots that may hold a particle of another object than their window's.
    #[must_use]
    pub fn most_candidates(&self) -> u32 {
        if self.breeds {
            return self.particle_count();
        }
        let gained = most_gained(self.means.capacity, self.object_count());
        let gained = gained.min(self.particle_count().into()) as u32;
        gained.saturating_add(self.means.capacity)
    }

    /// Upper bound on the entries in the lists of slots that do.
    #[must_use]
    pub fn most_entries(&self) -> u32 {
        if self.breeds {
            return self.particle_count();
        }
        let particles = self.particle_count().into();
        most_displaced(self.means.capacity, self.object_count(), particles) as u32
    }

    fn entries_each(&self) -> u32 {
        if self.strategy == Strategy::Sequential {
            RUN
        } else {
            1
        }
    }
}

impl StepKernel for MoveBorders {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> MoveBordersArgs<'s> {
        MoveBordersArgs {
            flow: &s.transfers.flow,
            windows: &s.transfers.windows,
            borders: &s.transfers.borders,
            groups: &s.transfers.groups,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let t = &mut a.transfers;
        move_borders(
            &call.params,
            &mut t.flow[0],
            &mut t.windows,
            &mut t.borders,
            &mut t.groups,
        );
    }
}

impl StepKernel for DefragmentScan {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> DefragmentScanArgs<'s> {
        DefragmentScanArgs {
            flow: &s.transfers.flow,
            windows: &s.transfers.windows,
            borders: &s.transfers.borders,
            particle_indices: &s.transfers.particle_indices,
            transfers: &s.transfers.transfers,
            particles: &s.particles.texels,
            motions: &s.motions.texels,
            strips: &s.surface.strips,
            // Scratch memory that is not in use at this time.
            holes: &s.walkers.slots.texels,
            strays: &s.sorting.particles.texels,
            stray_motions: &s.sorting.motions.texels,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let t = &mut a.transfers;
        defragment_scan(
            &call.constants,
            &call.params,
            &t.flow[0],
            &t.windows,
            &mut t.borders,
            (&t.particle_indices, &t.transfers),
            (&a.particles, &a.motions),
            &a.setup.strips,
            &mut t.holes,
            (&mut a.segment_particles, &mut a.segment_motions),
        );
    }
}

impl StepKernel for DefragmentSwap {
    type On = ();

    fn args<'s>(_call: &Call<Self>, s: &'s State) -> DefragmentSwapArgs<'s> {
        DefragmentSwapArgs {
            flow: &s.transfers.flow,
            windows: &s.transfers.windows,
            borders: &s.transfers.borders,
            holes: &s.walkers.slots.texels,
            strays: &s.sorting.particles.texels,
            stray_motions: &s.sorting.motions.texels,
            particles: &s.particles.texels,
            motions: &s.motions.texels,
        }
    }

    fn twin(call: &Call<Self>, a: &mut Arrays) {
        let t = &mut a.transfers;
        defragment_swap(
            &call.constants,
            &call.params,
            &t.flow[0],
            &t.borders,
            &t.holes,
            (&a.segment_particles, &a.segment_motions),
            (&mut a.particles, &mut a.motions),
        );
    }
}

/// Twin of `shaders/move_borders.comp`.
pub fn move_borders(
    params: &MoveBordersParams,
    flow: &mut Flow,
    windows: &mut [Window],
    borders: &mut [Border],
    groups: &mut [DispatchGroups],
) {
    let ring = i64::from(params.particle_count);
    let objects = i64::from(params.object_count);
    // How far each border would move if the ring's beginning stayed.
    let ways: Vec<i64> = borders
        .iter()
        .scan(0, |way, border| {
            let before = *way;
            *way += i64::from(border.came) - i64::from(border.left);
            Some(before)
        })
        .collect();
    let sum = |of: fn(i64, i64) -> i64| ways.iter().map(|way| of(way + ring, objects)).sum::<i64>();
    let mean = sum(|way, objects| way / objects)
        + (sum(|way, objects| way % objects) + objects / 2) / objects;
    let shift = ring - mean;
    let ring_start = i64::from(windows[0].start);
    let (mut begins, mut gained, mut entries) = (0, 0, 0);
    for ((window, border), way) in windows.iter_mut().zip(borders).zip(ways) {
        let had = i64::from(window.count);
        let count = window.count + border.came - border.left;
        let (old_start, new_start) = (begins, begins + way + shift);
        let common_end = (old_start + had).min(new_start + i64::from(count));
        let common = (common_end - old_start.max(new_start)).max(0) as u32;
        flow.mismatches += u32::from(border.holes != border.strays);
        let got = count - common;
        let most = match params.whole {
            0 => (got + border.left).min(count),
            _ => count,
        };
        *border = Border {
            front: (old_start - new_start).clamp(0, i64::from(got)) as u32,
            gained: got,
            first: gained,
            list: entries,
            ..Border::default()
        };
        gained += got;
        entries += most;
        begins += had;
        *window = Window {
            start: (ring_start + new_start).rem_euclid(ring) as u32,
            count,
        };
    }
    flow.gained = gained;
    flow.entries = entries;
    let candidates = match params.whole {
        0 => flow.leaving + gained,
        _ => params.particle_count,
    };
    groups[3] = DispatchGroups::of(candidates, params.scan_group);
    groups[4] = DispatchGroups::of(entries, params.swap_group);
}

/// Slot number `i` of those that a window has gained.
fn gained_slot(window: &Window, border: &Border, i: u32, ring: u32) -> u32 {
    let offset = if i < border.front {
        i
    } else {
        window.count - (border.gained - i)
    };
    Window::slot(window.start, offset, ring)
}

/// Did a slot belong to a window before, and does it still?
fn has_kept(window: &Window, border: &Border, slot: u32, ring: u32) -> bool {
    let offset = Window::offset(window.start, slot, ring);
    (border.front..window.count - (border.gained - border.front)).contains(&offset)
}

/// Twin of `shaders/defragment_scan.comp`. The kernel may list in another order.
#[expect(clippy::too_many_arguments, reason = "those of the kernel")]
pub fn defragment_scan(
    constants: &DefragmentScanConstants,
    params: &DefragmentScanParams,
    flow: &Flow,
    windows: &[Window],
    borders: &mut [Border],
    (particle_indices, transfers): (&[u32], &[Transfer]),
    (particles, motions): (&[Particle], &[Motion]),
    strips: &[StripTriangle],
    holes: &mut [u32],
    (strays, stray_motions): (&mut [Particle], &mut [Motion]),
) {
    let ring = params.particle_count;
    let is_whole = params.whole != 0;
    let all = match is_whole {
        true => ring,
        false => flow.leaving + flow.gained,
    };
    let (first, end) = if constants.sequential {
        (
            params.first,
            all.min(params.first.saturating_add(params.count)),
        )
    } else {
        (0, all)
    };
    let mut look_at = |borders: &mut [Border], slot: u32, object: usize| {
        let particle = particles[slot as usize];
        let own = strips[particle.triangle as usize].shape.object as usize;
        if own == object {
            return;
        }
        let hole = borders[object].list + borders[object].holes;
        borders[object].holes += 1;
        holes[hole as usize] = slot;
        let place = (borders[own].list + borders[own].strays) as usize;
        borders[own].strays += 1;
        strays[place] = particle;
        stray_motions[place] = motions[slot as usize];
    };
    for i in first..end {
        if is_whole {
            // The parts of the lists are as long as the windows.
            let object = borders.partition_point(|border| border.list <= i) - 1;
            look_at(borders, Window::slot(windows[0].start, i, ring), object);
        } else if i < flow.leaving {
            let slot = particle_indices[i as usize];
            let source = transfers[i as usize].source as usize;
            if has_kept(&windows[source], &borders[source], slot, ring) {
                look_at(borders, slot, source);
            }
        } else {
            let i = i - flow.leaving;
            let object = borders.partition_point(|border| border.first <= i) - 1;
            let border = &borders[object];
            let slot = gained_slot(&windows[object], border, i - border.first, ring);
            look_at(borders, slot, object);
        }
    }
}

/// Twin of `shaders/defragment_swap.comp`.
pub fn defragment_swap(
    constants: &DefragmentSwapConstants,
    params: &DefragmentSwapParams,
    flow: &Flow,
    borders: &[Border],
    holes: &[u32],
    (strays, stray_motions): (&[Particle], &[Motion]),
    (particles, motions): (&mut [Particle], &mut [Motion]),
) {
    let (first, end) = if constants.sequential {
        (params.first, params.first.saturating_add(params.count))
    } else {
        (0, flow.entries)
    };
    for border in borders {
        let part = border.list..border.list + border.holes.min(border.strays);
        for entry in part.filter(|entry| (first..end).contains(entry)) {
            let (entry, slot) = (entry as usize, holes[entry as usize] as usize);
            particles[slot] = strays[entry];
            motions[slot] = stray_motions[entry];
        }
    }
}
