//! The data that panels and tools work on in a frame.

use crate::lab::actions::Action;
use crate::lab::command::Command;
use crate::lab::document::Document;
use crate::lab::facts::Facts;
use crate::lab::layout::Layout;
use crate::lab::notices::Notices;
use crate::lab::opening::Opening;

/// The document, the facts, and the requests to the window.
pub struct Desk<'a> {
    /// The scene with its settings and its look.
    pub document: &'a mut Document,
    /// The layout of the window.
    pub layout: &'a mut Layout,
    /// Facts that the window reports.
    pub facts: &'a Facts,
    /// Lines over the picture.
    pub notices: &'a mut Notices,
    /// The dialog for files.
    pub opening: &'a mut Opening,
    /// Actions that are performed as soon as the frame is shown, in order.
    pub actions: &'a mut Vec<Action>,
    /// Commands to the window, in order.
    pub commands: &'a mut Vec<Command>,
}

/// The desk of an interface: its document, layout, notices and dialog, beside its panels and tools.
macro_rules! desk {
    ($interface:expr, $facts:expr, $actions:expr, $commands:expr) => {
        $crate::lab::desk::Desk {
            document: &mut $interface.document,
            layout: &mut $interface.layout,
            facts: $facts,
            notices: &mut $interface.notices,
            opening: &mut $interface.opening,
            actions: $actions,
            commands: $commands,
        }
    };
}
pub(super) use desk;
