//! What cannot be done yet: a scene loads, or steps are under way that nothing may come between.

use std::path::PathBuf;

use myxo::scene::settings::ObjectSettings;

use crate::lab::command::{Command, Ticket, Work};

/// Something to do when the steps are over and the scene that loads is there.
pub enum Waiting {
    /// What the interface asked for, and the size of the picture that it meant.
    Command(Command, [u32; 2]),
    /// A file that was dropped onto the window.
    File(PathBuf),
    /// An object that is to come once more, wherever it stands then.
    Copy(Box<ObjectSettings>, Ticket),
    /// An object that is to go, wherever it stands then.
    Removal(Box<ObjectSettings>),
}

impl Waiting {
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
