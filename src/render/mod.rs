//! Draws what `sim` owns, and writes pictures.

pub mod output;
