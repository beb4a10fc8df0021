//! Copies without stopping the simulation: of the whole state or of the trail to the host, recorded in a frame and read by any thread when
//! the frame has finished; and of the state on the device, for the way back.

use super::super::buffers;
use super::super::kept::{Aside, BufferCopy, Copies, put_aside};
use super::super::snapshot::{Distances, Snapshot};
use super::Simulation;
use crate::error::{Error, Result};
use crate::gpu::{Buffer, Recorder};

/// A state being copied to the host.
pub struct SnapshotCopy {
    /// The parts on the host.
    host: Snapshot,
    parts: Copies,
    /// None before the first were computed.
    distances: Option<(BufferCopy<f32>, BufferCopy<u32>)>,
}

impl Simulation {
    /// Records a copy of the state after everything recorded so far, as [`snapshot`](Self::snapshot) and [`distances`](Self::distances)
    /// return it, but without waiting.
    ///
    /// # Errors
    /// No memory.
    pub fn record_snapshot(&self, rec: &mut Recorder) -> Result<SnapshotCopy> {
        let near = &self.state.near;
        Ok(SnapshotCopy {
            host: self.course.snapshot(),
            parts: Copies::record(rec, &self.state)?,
            distances: if self.course.has_distances() {
                Some((
                    BufferCopy::record(rec, &buffers::DISTANCES, &near.distances)?,
                    BufferCopy::record(rec, &buffers::NEAREST, &near.nearest)?,
                ))
            } else {
                None
            },
        })
    }
}

/// A trail being copied to the host.
pub struct TrailCopy(BufferCopy<f32>);

impl Simulation {
    /// Records a copy of the trail after everything recorded so far, gutters included, without waiting.
    ///
    /// # Errors
    /// No memory.
    pub fn record_trail(&self, rec: &mut Recorder) -> Result<TrailCopy> {
        let trail = &self.state.trail.front;
        let copy = BufferCopy::record(rec, &buffers::TRAIL_FRONT, trail)?;
        Ok(TrailCopy(copy))
    }
}

impl TrailCopy {
    /// Has the frame finished? Does not wait.
    pub fn is_there(&mut self) -> bool {
        self.0.is_there()
    }

    /// The trail of each texel, once [`is_there`](Self::is_there) has returned true.
    ///
    /// # Panics
    /// If it has not.
    #[must_use]
    pub fn take(mut self) -> Vec<f32> {
        assert!(self.is_there(), "the trail is still on its way");
        self.0.take()
    }
}

/// A state that was copied on the device, and to which its simulation can go back.
pub struct StateAside {
    /// The parts on the host.
    host: Snapshot,
    parts: Aside,
    /// The sum of all scents, if there is food. It follows from the amounts that are left, and takes long to find on the host.
    scent: Option<Buffer<f32>>,
}

impl Simulation {
    /// Records a copy of the state after everything recorded so far, for [`record_back`](Self::record_back). It stays on the device, so
    /// nothing waits for it.
    ///
    /// # Errors
    /// No memory.
    pub fn record_aside(&self, rec: &mut Recorder) -> Result<StateAside> {
        let food = self.state.food.as_ref();
        let scent = food.map(|food| put_aside(rec, &food.scent)).transpose()?;
        Ok(StateAside {
            host: self.course.snapshot(),
            parts: Aside::record(rec, &self.state)?,
            scent,
        })
    }

    /// Records the way back to a state of this simulation. All recorded steps must have been submitted, and the settings of that time
    /// be [applied](Self::apply); steps then continue as they would have from there. Areas and a second look that were painted for the
    /// first time since then stay.
    ///
    /// # Errors
    /// When buffers have changed since then: with the strategy of transfers, or with food. Then nothing has changed. When the device cannot
    /// run a kernel.
    pub fn record_back(&mut self, rec: &mut Recorder, aside: &StateAside) -> Result<()> {
        let scent = self.state.food.as_ref().map(|food| &*food.scent);
        let scent_fits = scent.map(Buffer::len) == aside.scent.as_ref().map(Buffer::len);
        if !scent_fits || !aside.parts.fits(&self.state) {
            return Err(Error::Invalid(
                "the simulation cannot go back to the state that was copied on the device: the strategy of transfers or the food has \
                 changed since then; apply the settings of that time first"
                    .to_owned(),
            ));
        }
        let mut course = self.course.clone();
        let are_distances_known = course.restore(&aside.host).map_err(Error::Invalid)?;
        // Pulses may be live again.
        let every = course.of_every_kernel(self.settings(), self.means());
        every.prepare(&mut self.pipelines)?;
        self.course = course;
        if !are_distances_known {
            self.state.near.reach = 0.0;
        }
        aside.parts.record_back(rec, &self.state);
        if let (Some(before), Some(food)) = (&aside.scent, &self.state.food) {
            rec.copy(before, &food.scent);
        }
        self.record_poses(rec);
        Ok(())
    }
}

impl SnapshotCopy {
    /// Has the frame finished? Does not wait. Copied parts are kept.
    pub fn is_there(&mut self) -> bool {
        self.parts.are_there()
            && (self.distances.as_mut())
                .is_none_or(|(signed, nearest)| signed.is_there() && nearest.is_there())
    }

    /// The copy, once [`is_there`](Self::is_there) has returned true.
    ///
    /// # Panics
    /// If it has not.
    #[must_use]
    pub fn take(mut self) -> (Snapshot, Option<Distances>) {
        assert!(self.is_there(), "the state is still on its way");
        let mut snapshot = self.host;
        self.parts.take(&mut snapshot);
        let distances = self.distances.map(|(signed, nearest)| Distances {
            signed: signed.take(),
            nearest: nearest.take(),
        });
        (snapshot, distances)
    }
}
