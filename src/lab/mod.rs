//! The lab: a window in which slime mold grows, with every parameter beside it.

mod interface;
mod keys;
mod navigation;
mod pacing;
mod rows;
mod theme;
