//! Draws what `sim` owns, and writes pictures.
