//! Whose turn it is.

/// Objects have turns, one after the other in a step, where particles that change objects keep the windows of these in order;
/// elsewhere all have theirs at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// All objects at once.
    All,
    /// One object.
    Of(u32),
}

impl Turn {
    /// The object; 0 where all have their turn.
    pub(super) fn object(self) -> u32 {
        match self {
            Self::All => 0,
            Self::Of(object) => object,
        }
    }

    /// The object that comes next.
    pub(super) fn next(self, count: u32) -> u32 {
        (self.object() + 1) % count
    }
}
