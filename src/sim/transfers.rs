//! Particles that change objects, and the windows that objects have of the particle buffer: on the host, as
//! snapshots hold them, and on the device.

use std::sync::Arc;

use glam::{UVec2, UVec4, Vec3};

use super::buffers::{self, Counts};
use super::movement::FARTHEST;
use super::restarts::Restarts;
use super::setup::Setup;
use super::types::{Border, Flow, Motion, Particle, Transfer, Window};
use crate::gpu::{Buffer, Context, DispatchGroups, GpuError, Readback, Recorder};
use crate::mesh::surface::Surface;
use crate::scene::parameters::grouped;
use crate::scene::settings::{Settings, Strategy};

/// The transfers' part of a snapshot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TransferState {
    /// One per object, if the strategy has windows; otherwise none.
    pub windows: Vec<Window>,
    /// Particles that have left their object and not arrived, in checkpoints of earlier versions; otherwise none.
    pub in_flight: Vec<Transfer>,
    /// Counters.
    pub flow: Flow,
    /// How many particles have left each object (rows) for each; empty with a single object.
    pub flux: Vec<u32>,
    /// Where particles restart, if they may do so by the rule of their start; otherwise none.
    pub restarts: Restarts,
}

impl TransferState {
    /// Checks what must hold after every step: windows share all slots, in the order of objects, and every particle lies in
    /// its object's window. In checkpoints of earlier versions some are in flight instead: they have a transfer and lie before the first
    /// window.
    ///
    /// # Errors
    /// Names the first thing that breaks a rule, and the rule.
    pub fn validate(
        &self,
        particles: &[Particle],
        motions: &[Motion],
        setup: &Setup,
    ) -> Result<(), String> {
        if let Some(mismatch) = self.flow.mismatch() {
            return Err(mismatch);
        }
        let objects = setup.poses.len() as u32;
        self.validate_counts()?;
        self.restarts.validate(&setup.surface)?;
        let mut flying = vec![false; particles.len()];
        for transfer in &self.in_flight {
            let Transfer {
                particle,
                target,
                triangle,
                ..
            } = *transfer;
            let fits = (particle as usize) < particles.len()
                && (triangle as usize) < setup.surface.triangles.len()
                && setup.surface.triangles[triangle as usize].object == target;
            if !fits {
                return Err(format!(
                    "a transfer of slot {particle} to triangle {triangle} of object {target}"
                ));
            }
            if std::mem::replace(&mut flying[particle as usize], true) {
                return Err(format!("two transfers of slot {particle}"));
            }
            let Particle { id, triangle, .. } = particles[particle as usize];
            let own = setup.surface.triangles[triangle as usize].object;
            if transfer.source != own {
                return Err(format!(
                    "particle {id} of object {own} has a transfer from object {}",
                    transfer.source
                ));
            }
            let Transfer {
                position,
                heading,
                normal,
                ..
            } = transfer;
            let is_unit = |direction: &Vec3| (direction.length() - 1.0).abs() < 1e-4;
            if !(position.is_finite() && is_unit(heading) && is_unit(normal)) {
                return Err(format!(
                    "particle {id} is in flight at {position}, heading {heading} from a plane with normal {normal}"
                ));
            }
        }
        if let Some(slot) = (0..particles.len()).find(|&s| motions[s].is_selected() != flying[s]) {
            return Err(format!(
                "particle {} is {}in flight and {} transfer",
                particles[slot].id,
                if flying[slot] { "not " } else { "" },
                if flying[slot] { "has a" } else { "has no" },
            ));
        }
        if self.windows.is_empty() {
            return Ok(());
        }
        self.validate_windows(particles, &flying, setup, objects)
    }

    /// Checks that arithmetic with the numbers of particles in flight stays in the range of single precision.
    ///
    /// # Errors
    /// Names the first number that is out of its range.
    pub(super) fn check_ranges(
        &self,
        particles: &[Particle],
        most_rest: f32,
    ) -> Result<(), String> {
        let is_possible = |transfer: &&Transfer| {
            f64::from(transfer.position.abs().max_element()) <= FARTHEST
                && (0.0..=most_rest).contains(&transfer.rest)
        };
        match self
            .in_flight
            .iter()
            .find(|transfer| !is_possible(transfer))
        {
            None => Ok(()),
            Some(Transfer {
                particle,
                position,
                rest,
                ..
            }) => Err(format!(
                "particle {} is in flight at {position} with {rest} to walk: coordinates up to {FARTHEST:e}, and 0 to \
                 {most_rest} to walk, are possible",
                particles[*particle as usize].id
            )),
        }
    }

    /// All selected particles were refused, have arrived or are in flight, unless a counter is at its largest value.
    fn validate_counts(&self) -> Result<(), String> {
        let Flow {
            selected,
            refused,
            arrived,
            ..
        } = self.flow;
        let in_flight = self.in_flight.len() as u64;
        let all = u64::from(refused) + u64::from(arrived) + in_flight;
        if selected < u32::MAX && u64::from(selected) != all {
            return Err(format!(
                "{selected} times a particle was selected, and {refused} were refused, {arrived} have arrived, \
                 {in_flight} are in flight"
            ));
        }
        Ok(())
    }

    fn validate_windows(
        &self,
        particles: &[Particle],
        flying: &[bool],
        setup: &Setup,
        objects: u32,
    ) -> Result<(), String> {
        let ring = particles.len() as u32;
        if self.windows.len() != objects as usize {
            return Err(format!(
                "{} windows for {objects} objects",
                self.windows.len()
            ));
        }
        let mut start = self.windows[0].start;
        let mut all = 0;
        for (object, window) in self.windows.iter().enumerate() {
            if window.start != start || start >= ring || window.count > ring - all {
                return Err(format!(
                    "the window of object {object} has {} slots from {} on, and the one before it ends at {start}",
                    window.count, window.start
                ));
            }
            all += window.count;
            for i in 0..window.count {
                let slot = Window::slot(window.start, i, ring) as usize;
                let Particle { triangle, id, .. } = particles[slot];
                let its_object = setup.surface.triangles[triangle as usize].object as usize;
                if flying[slot] {
                    if object > 0 || i as usize >= self.in_flight.len() {
                        return Err(format!(
                            "particle {id} is in flight and lies at {i} in the window of object {object}"
                        ));
                    }
                } else if its_object != object {
                    return Err(format!(
                        "particle {id} of object {its_object} lies in the window of object {object}"
                    ));
                }
            }
            start = Window::slot(window.start, window.count, ring);
        }
        if all != ring {
            return Err(format!("the windows have {all} slots of {ring}"));
        }
        Ok(())
    }
}

/// A count of transfers as text. A count at its largest value reads "or more", because counters stop there.
#[must_use]
pub fn count_text(count: u64) -> String {
    let more = if count < u32::MAX.into() {
        ""
    } else {
        " or more"
    };
    format!("{}{more}", grouped(count as f64))
}

/// The capacity of the lists: that of the settings, and at most the number of particles.
#[must_use]
pub fn capacity(settings: &Settings, setup: &Setup) -> u32 {
    if settings.strategy() == Strategy::None {
        return 1;
    }
    let particles = setup.particles.len() as u32;
    settings.transfer.buffer_size.min(particles).max(1)
}

/// Upper bound on the slots that windows gain in a step in which so many particles leave. With a fixed beginning of the ring, each border
/// would move by up to this number of slots, in either direction. The beginning moves by their mean, from which they differ by half of that
/// on average, but for rounding; each border gives slots to one window.
#[must_use]
pub fn most_gained(leaving: u32, objects: u32) -> u64 {
    u64::from(objects) * (u64::from(leaving / 2) + 2)
}

/// Upper bound on the particles outside of their objects' windows then: those in slots that windows have gained, and those that leave.
#[must_use]
pub fn most_displaced(leaving: u32, objects: u32, particles: u64) -> u64 {
    (most_gained(leaving, objects) + u64::from(leaving)).min(particles)
}

/// For each triangle, its cumulative share of its object's area, in units of 2^-32; that of the last one is 1.
#[must_use]
pub fn area_shares(surface: &Surface) -> Vec<u32> {
    let mut shares = Vec::with_capacity(surface.triangles.len());
    for object in &surface.objects {
        let (first, end) = object.triangles;
        let triangles = &surface.triangles[first as usize..end as usize];
        let area = |sum: &mut f64, ab: f32, ch: f32| {
            *sum += f64::from(ab) * f64::from(ch);
            Some(*sum)
        };
        let sums: Vec<f64> = triangles
            .iter()
            .scan(0.0, |sum, shape| area(sum, shape.ab, shape.ch))
            .collect();
        let whole = sums.last().copied().unwrap_or(1.0);
        let units = f64::from(u32::MAX) + 1.0;
        shares.extend(sums.iter().map(|sum| (sum / whole * units) as u32));
    }
    shares
}

/// First triangle of each object, and the one behind its last.
#[must_use]
pub fn object_triangles(surface: &Surface) -> Vec<UVec2> {
    let ranges = surface.objects.iter().map(|object| object.triangles);
    ranges.map(|(first, end)| UVec2::new(first, end)).collect()
}

/// The device's buffers for transfers; of length 1 where no particle changes objects.
pub struct Transfers {
    /// One per object: its particles' slots, if there are windows.
    pub windows: Buffer<Window>,
    /// One per object: the changes of its window.
    pub borders: Buffer<Border>,
    /// One: lengths of the lists, and counters.
    pub flow: Buffer<Flow>,
    /// Groups of the kernels that work on transfers, as [`Counter`](super::work::Counter) has them.
    pub groups: Buffer<DispatchGroups>,
    /// Slots of selected particles.
    pub particle_indices: Buffer<u32>,
    /// Their transfers.
    pub transfers: Buffer<Transfer>,
    /// Selected particles by half of their keys, if more are selected than the lists hold.
    pub limit_bins: Buffer<u32>,
    /// Particles that left each object (rows) for each, so far.
    pub flux: Buffer<u32>,
    /// One per triangle, see [`area_shares`].
    pub area_shares: Buffer<u32>,
    /// One per object, see [`object_triangles`].
    pub object_triangles: Buffer<UVec2>,
    /// Places that particles restart at, see [`Restarts`].
    pub restarts: Buffer<UVec4>,
    /// One per object: its part of them.
    pub restart_ranges: Buffer<UVec2>,
    capacity: u32,
    strategy: Strategy,
}

impl Transfers {
    /// Takes the memory and uploads the counters. The state is [arranged](super::arranged) for the settings' strategy.
    ///
    /// # Errors
    /// No memory.
    pub fn new(
        ctx: &Arc<Context>,
        counts: &Counts,
        settings: &Settings,
        setup: &Setup,
        state: &TransferState,
    ) -> Result<Self, GpuError> {
        let TransferState {
            windows,
            flow,
            flux,
            restarts,
            ..
        } = state;
        let capacity = capacity(settings, setup);
        let restarts = Restarts::of_state(restarts, setup, settings);
        let counts = &Counts {
            transfers: capacity.into(),
            restarts: (restarts.places.len() as u64, restarts.ranges.len() as u64),
            ..*counts
        };
        // Buffers have at least one element.
        let windows: &[Window] = if windows.is_empty() {
            &[Window::default()]
        } else {
            windows
        };
        let flux: &[u32] = if flux.is_empty() { &[0] } else { flux };
        let respawns = settings.strategy().respawns();
        let (shares, ranges) = if respawns {
            (
                area_shares(&setup.surface),
                object_triangles(&setup.surface),
            )
        } else {
            (vec![0], vec![UVec2::ZERO])
        };
        Ok(Self {
            windows: buffers::WINDOWS.of(ctx, counts, windows)?,
            borders: buffers::BORDERS.zeroed(ctx, counts)?,
            flow: buffers::FLOW.of(ctx, counts, &[*flow])?,
            groups: buffers::GROUPS.zeroed(ctx, counts)?,
            particle_indices: buffers::PARTICLE_INDICES.zeroed(ctx, counts)?,
            transfers: buffers::TRANSFERS.zeroed(ctx, counts)?,
            limit_bins: buffers::LIMIT_BINS.zeroed(ctx, counts)?,
            flux: buffers::FLUX.of(ctx, counts, flux)?,
            area_shares: buffers::AREA_SHARES.of(ctx, counts, &shares)?,
            object_triangles: buffers::OBJECT_TRIANGLES.of(ctx, counts, &ranges)?,
            restarts: buffers::RESTARTS.of(ctx, counts, &restarts.places)?,
            restart_ranges: buffers::RESTART_RANGES.of(ctx, counts, &restarts.ranges)?,
            capacity,
            strategy: settings.strategy(),
        })
    }

    /// The number of transfers that the lists hold.
    #[must_use]
    pub fn capacity(&self) -> u32 {
        self.capacity
    }

    /// Copies the counters to where the host reads them some frames later.
    pub fn record_readback(&self, rec: &mut Recorder, counters: &mut Readback<Flow>, step: u64) {
        counters.record(rec, &self.flow, step);
    }

    /// The windows; none if the strategy has none.
    pub(super) fn kept_windows(&self) -> Option<&Buffer<Window>> {
        self.strategy.has_windows().then_some(&self.windows)
    }

    /// Where particles restart, and the part of each object; none if they never do so by the rule of their start.
    pub(super) fn kept_restarts(&self) -> Option<(&Buffer<UVec4>, &Buffer<UVec2>)> {
        (self.restart_ranges.len() > 1).then_some((&self.restarts, &self.restart_ranges))
    }

    /// The flux; none with a single object.
    pub(super) fn kept_flux(&self) -> Option<&Buffer<u32>> {
        (self.flux.len() > 1).then_some(&self.flux)
    }
}
