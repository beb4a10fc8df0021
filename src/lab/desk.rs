//! What panels and tools work on in a frame.

use super::actions::Action;
use super::command::Command;
use super::document::Document;
use super::facts::Facts;
use super::layout::Layout;
use super::notices::Notices;
use super::opening::Opening;

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
