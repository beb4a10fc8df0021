//! Edits of the running scene by tools: dabs of brushes, strokes that can be undone, objects that are added or removed.

use crate::lab::command::Ticket;
use crate::lab::stage::Stage;
use crate::lab::strokes::Strokes;
use crate::lab::waiting::Waiting;
use myxo::Result;
use myxo::gpu::{Buffer, Context, Readback, Recorder};
use myxo::sim::paint::Dab;
use std::sync::Arc;

/// Copies of what is probed that may be on their way to the host.
pub const PROBES_UNDER_WAY: usize = 4;
/// Values that are probed.
pub const PROBED: usize = 3;

/// Edits of the running scene by tools.
#[derive(Default)]
pub struct Edits {
    /// Dabs that the next frame records.
    pub dabs: Vec<Dab>,
    /// How many there were.
    pub dab_count: u32,
    /// Strokes that can be undone.
    pub strokes: Strokes,
    pub probe: Option<Probe>,
    /// The objects that the scene on its way takes over: for each of its objects the index of the present one.
    pub carry: Option<Vec<Option<usize>>>,
    /// The object that comes or goes with the scene on its way.
    pub coming: Option<Coming>,
    /// The requested objects that have come, with their names.
    pub come: Vec<(Ticket, String)>,
}

/// An object that comes or goes.
pub struct Coming {
    /// Its name in messages.
    pub what: String,
    /// The request that asks for it again, if there may be one.
    pub again: Option<Waiting>,
    /// The ticket with which a new object was requested.
    pub ticket: Option<Ticket>,
}

impl Edits {
    /// The name of a requested object, once it has come.
    pub fn name_of(&self, ticket: Ticket) -> Option<&str> {
        let found = self.come.iter().find(|(known, _)| *known == ticket);
        found.map(|(_, name)| name.as_str())
    }

    /// Another scene: what has come is not in it.
    pub fn leave_scene(&mut self) {
        self.come.clear();
    }

    /// Is there something to record?
    pub fn has_dabs(&self) -> bool {
        !self.dabs.is_empty()
    }
}

/// Trail and distance at one texel, read some frames later.
pub struct Probe {
    pub values: Buffer<f32>,
    pub readback: Readback<f32>,
    /// The last reading: trail, distance, bias.
    pub last: Option<[f32; PROBED]>,
}

impl Probe {
    pub fn new(ctx: &Arc<Context>) -> Result<Self> {
        Ok(Self {
            values: Buffer::zeroed(ctx, "probe", PROBED)?,
            readback: Readback::new(ctx, "probe", PROBED, PROBES_UNDER_WAY)?,
            last: None,
        })
    }

    pub fn record(&mut self, rec: &mut Recorder, stage: &Stage, texel: usize) {
        let state = stage.simulation.state();
        let mut sources = vec![&state.trail.front];
        // With one object there are no distances, and this value is not read.
        let has_distances = state.near.distances.len() > texel;
        sources.push(if has_distances {
            &state.near.distances
        } else {
            &state.trail.front
        });
        sources.extend(&state.bias);
        for (i, source) in sources.into_iter().enumerate() {
            rec.copy_range(source, texel..texel + 1, &self.values, i);
        }
        self.readback.record(rec, &self.values, texel as u64);
    }
}

impl Edits {
    /// The device goes, and all that is on it.
    pub fn leave_device(&mut self) {
        self.dabs.clear();
        // A stroke in progress holds areas on the device.
        self.strokes = Strokes::default();
        self.probe = None;
        self.carry = None;
    }
}
