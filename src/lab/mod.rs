//! The lab: a window in which slime mold grows, with every parameter beside it.

mod pacing;
