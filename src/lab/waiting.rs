//! Requests that have to wait while a scene loads, or while steps are under way that must not be interrupted.

use std::path::PathBuf;

use myxo::scene::settings::ObjectSettings;

use crate::lab::command::{Command, Ticket, ToolRequest};

/// Something to do when the steps are over and the scene that loads is there.
pub enum Waiting {
    /// A command of the interface, and the size of the picture that it refers to.
    Command(Command, [u32; 2]),
    /// A file that was dropped onto the window.
    File(PathBuf),
    /// An object to be duplicated, whatever its index is then.
    Copy(Box<ObjectSettings>, Ticket),
    /// An object to be removed, whatever its index is then.
    Removal(Box<ObjectSettings>),
}

impl Waiting {
    /// The ticket of the object that it will add, if any.
    pub fn ticket(&self) -> Option<Ticket> {
        match self {
            Self::Copy(_, ticket)
            | Self::Command(
                Command::Tool(ToolRequest::Duplicate(_, ticket) | ToolRequest::Add(_, ticket)),
                _,
            ) => Some(*ticket),
            _ => None,
        }
    }
}
