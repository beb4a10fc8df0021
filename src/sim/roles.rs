//! Buffers in pairs.

/// Two buffers that change roles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pair {
    /// The trail and the next trail.
    Trail,
    /// This step's deposits and those of the last one.
    Deposits,
}
