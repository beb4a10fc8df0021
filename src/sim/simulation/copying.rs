//! Copies of the whole state, or of the trail, to the host without stopping the simulation: recorded in a frame, read by any thread when the
//! frame has finished.

use super::super::buffers;
use super::super::kept::{BufferCopy, Copies};
use super::super::snapshot::{Distances, Snapshot};
use super::Simulation;
use crate::error::Result;
use crate::gpu::Recorder;

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
