//! What panels and tools work on in a frame.

use crate::lab::actions::Action;
use crate::lab::command::Command;
use crate::lab::document::Document;
use crate::lab::facts::Facts;
use crate::lab::layout::Layout;
use crate::lab::notices::Notices;
use crate::lab::opening::Opening;

/// What is being worked on, what is going on, and what is asked for.
pub struct Desk<'a> {
    /// The scene with its settings and its look.
    pub document: &'a mut Document,
    /// What is shown where.
    pub layout: &'a mut Layout,
    /// What is going on.
    pub facts: &'a Facts,
    /// Lines over the picture.
    pub notices: &'a mut Notices,
    /// The dialog for files.
    pub opening: &'a mut Opening,
    /// What is done as soon as the frame is shown, in order.
    pub actions: &'a mut Vec<Action>,
    /// What the window must do, in order.
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
