//! The list of what a recording does, as it is shown on request.

use std::fmt;

/// An entry of [`Recorder::listed`](super::Recorder::listed).
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Listed {
    /// A kernel, a copy or a pass, by its name.
    Work(String),
    /// A barrier and its reasons; none if it only separates two works, so that each has its own time, or waits for everything after a
    /// dropped recording.
    Barrier(Vec<Reason>),
    /// Kernels that follow do not wait for each other, for this reason.
    Unordered(&'static str),
    /// From here on kernels wait again.
    Ordered,
}

/// One buffer for which a barrier is needed, and the two works that use it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reason {
    /// The buffer's name.
    pub buffer: String,
    /// The name of the work before the barrier, and the word of its access.
    pub earlier: (&'static str, &'static str),
    /// Did the earlier work write, or only read?
    pub earlier_wrote: bool,
    /// The name of the work after it, and the word of its access.
    pub later: (&'static str, &'static str),
    /// Does the later work write?
    pub later_writes: bool,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let did = |writes: bool, past: &'static str| if writes { "wrote" } else { past };
        let Self { earlier, later, .. } = self;
        write!(
            f,
            "{}: {} {} it ({}), {} {} it ({})",
            self.buffer,
            earlier.0,
            did(self.earlier_wrote, "read"),
            earlier.1,
            later.0,
            if self.later_writes { "writes" } else { "reads" },
            later.1
        )
    }
}
