//! Buffers in pairs.

/// Two buffers that change roles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pair {
    /// The trail and what it becomes.
    Trail,
    /// This step's deposits and those of the last one.
    Deposits,
}
