//! What panels and tools work on in a frame.

use super::command::Command;
use super::document::Document;
use super::facts::Facts;
use super::notices::Notices;

/// The document, what is going on, what is said, and what is asked of the window.
pub struct Desk<'a> {
    /// What is being worked on.
    pub document: &'a mut Document,
    /// What is going on.
    pub facts: &'a Facts,
    /// Lines over the picture.
    pub notices: &'a mut Notices,
    /// What the window must do, in order.
    pub commands: &'a mut Vec<Command>,
}
