//! The lab: a window in which slime mold grows, with every parameter beside it.

mod interface;
mod keys;
mod navigation;
mod overlays;
mod pacing;
mod panel;
mod rows;
mod theme;
mod widgets;
