//! Steps that take longer than a hand waits: they go to the device in slices, and between these the window answers over the
//! picture that is there.

use std::time::{Duration, Instant};

use myxo::gpu::Recorder;
use myxo::scene::settings::ObjectSettings;

use crate::lab::command::Command;
use crate::lab::command::{Ticket, Work};

/// Kernels that take longer are divided.
pub const LONGEST_SLICE: Duration = Duration::from_millis(12);
/// Steps that the device has been given a part of. Until it has all of them nobody else may touch the simulation.
pub struct UnderWay {
    pub rec: Recorder,
    pub steps: u32,
    /// There was input that the window does not show yet.
    pub owes_answer: bool,
    /// When the interface wants to be shown again.
    pub repaint: Option<Instant>,
    /// Before that there is no answer.
    pub rests_until: Instant,
}

impl UnderWay {
    pub fn wants(&mut self, repaint: Option<Duration>) {
        self.repaint = repaint.and_then(|delay| Instant::now().checked_add(delay));
    }
}

/// Something to do when the steps are over, and what loads is there.
pub enum Left {
    /// What the interface asked for, and the size of the picture that it meant.
    Command(Command, [u32; 2]),
    /// A file that was dropped onto the window.
    File(std::path::PathBuf),
    /// An object that is to come once more, wherever it stands then.
    Copy(Box<ObjectSettings>, Ticket),
    /// An object that is to go, likewise.
    Removal(Box<ObjectSettings>),
}

impl Left {
    /// What the object was asked for by that is to come by it.
    pub fn ticket(&self) -> Option<Ticket> {
        match self {
            Self::Copy(_, ticket)
            | Self::Command(Command::Hand(Work::Duplicate(_, ticket) | Work::Add(_, ticket)), _) => {
                Some(*ticket)
            }
            _ => None,
        }
    }
}
