//! The whole state copied to the host beside what runs: recorded in a frame, read by any thread when that is done.

use bytemuck::Pod;

use super::super::snapshot::{Distances, FoodState, Snapshot};
use super::super::transfers::TransferState;
use super::super::types::{Flow, Meal, Motion, Particle, Transfer, Window};
use super::Simulation;
use crate::error::Result;
use crate::gpu::{Buffer, Readback, Recorder};
use crate::scene::settings::Strategy;

/// One buffer on its way.
struct Part<T> {
    readback: Readback<T>,
    values: Option<Vec<T>>,
}

impl<T: Pod> Part<T> {
    fn record(rec: &mut Recorder, source: &Buffer<T>) -> Result<Self> {
        let name = format!("{}.copy", source.name());
        let mut readback = Readback::new(rec.ctx(), &name, source.len(), 1)?;
        readback.record(rec, source, 0);
        Ok(Self {
            readback,
            values: None,
        })
    }

    fn is_there(&mut self) -> bool {
        if self.values.is_none() {
            self.values = self.readback.poll().map(|(_, values)| values);
        }
        self.values.is_some()
    }

    fn take(self) -> Vec<T> {
        self.values.unwrap_or_default()
    }
}

/// The parts of [`TransferState`]; none with a single object.
struct TransferParts {
    windows: Option<Part<Window>>,
    /// All places of the list; `flow` says how many are in use.
    arriving: Part<Transfer>,
    flow: Part<Flow>,
    flux: Part<u32>,
    strategy: Strategy,
}

/// A state on its way to the host.
pub struct SnapshotCopy {
    /// What the host knows of it.
    known: Snapshot,
    particles: Part<Particle>,
    motions: Part<Motion>,
    trail: Part<f32>,
    deposits: Part<u32>,
    transfers: Option<TransferParts>,
    bias: Option<Part<f32>>,
    meals: Option<Part<Meal>>,
    distances: Option<(Part<f32>, Part<u32>)>,
}

impl Simulation {
    /// Records a copy of the state as all that was recorded so far leaves it: what [`snapshot`](Self::snapshot) and
    /// [`distances`](Self::distances) wait for, without waiting.
    ///
    /// # Errors
    /// No memory.
    pub fn record_snapshot(&self, rec: &mut Recorder) -> Result<SnapshotCopy> {
        let state = &self.state;
        let transfers = &state.transfers;
        let strategy = self.settings().strategy();
        let several = self.setup().poses.len() > 1;
        Ok(SnapshotCopy {
            known: self.course.snapshot(),
            particles: Part::record(rec, &state.particles)?,
            motions: Part::record(rec, &state.motions)?,
            trail: Part::record(rec, &state.trail.front)?,
            deposits: Part::record(rec, &state.deposits.back)?,
            transfers: several
                .then(|| -> Result<_> {
                    Ok(TransferParts {
                        windows: (strategy.has_windows())
                            .then(|| Part::record(rec, &transfers.windows))
                            .transpose()?,
                        arriving: Part::record(rec, &transfers.arriving)?,
                        flow: Part::record(rec, &transfers.flow)?,
                        flux: Part::record(rec, &transfers.flux)?,
                        strategy,
                    })
                })
                .transpose()?,
            bias: (state.bias.as_ref())
                .map(|bias| Part::record(rec, bias))
                .transpose()?,
            meals: (state.food.as_ref())
                .map(|food| Part::record(rec, &food.meals))
                .transpose()?,
            distances: (self.course.has_distances())
                .then(|| -> Result<_> {
                    Ok((
                        Part::record(rec, &state.near.distances)?,
                        Part::record(rec, &state.near.nearest)?,
                    ))
                })
                .transpose()?,
        })
    }
}

impl SnapshotCopy {
    /// Has the frame finished? Does not wait. What is there is kept, and stays.
    pub fn is_there(&mut self) -> bool {
        let Self {
            particles,
            motions,
            trail,
            deposits,
            transfers,
            bias,
            meals,
            distances,
            ..
        } = self;
        particles.is_there()
            && motions.is_there()
            && trail.is_there()
            && deposits.is_there()
            && transfers.as_mut().is_none_or(|parts| {
                parts.windows.as_mut().is_none_or(Part::is_there)
                    && parts.arriving.is_there()
                    && parts.flow.is_there()
                    && parts.flux.is_there()
            })
            && bias.as_mut().is_none_or(Part::is_there)
            && meals.as_mut().is_none_or(Part::is_there)
            && distances
                .as_mut()
                .is_none_or(|(signed, nearest)| signed.is_there() && nearest.is_there())
    }

    /// What has arrived, once [`is_there`](Self::is_there) has said so.
    ///
    /// # Panics
    /// If it has not.
    #[must_use]
    pub fn take(mut self) -> (Snapshot, Option<Distances>) {
        assert!(self.is_there(), "the state is still on its way");
        let snapshot = Snapshot {
            particles: self.particles.take(),
            motions: self.motions.take(),
            trail: self.trail.take(),
            deposits: self.deposits.take(),
            transfers: self.transfers.map_or_else(TransferState::default, |parts| {
                let flow = parts.flow.take().first().copied().unwrap_or_default();
                let mut in_flight = parts.arriving.take();
                // Without turns everybody has landed.
                in_flight.truncate(if parts.strategy.has_turns() {
                    flow.leaving as usize
                } else {
                    0
                });
                TransferState {
                    windows: parts.windows.map(Part::take).unwrap_or_default(),
                    in_flight,
                    flow,
                    flux: parts.flux.take(),
                }
            }),
            bias: self.bias.map(Part::take).unwrap_or_default(),
            food: FoodState {
                remaining: (self.meals.map(Part::take).unwrap_or_default().iter())
                    .map(|meal| meal.remaining)
                    .collect(),
                ..self.known.food
            },
            ..self.known
        };
        let distances = self.distances.map(|(signed, nearest)| Distances {
            signed: signed.take(),
            nearest: nearest.take(),
        });
        (snapshot, distances)
    }
}
