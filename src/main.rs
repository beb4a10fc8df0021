//! The `myxo` executable.
fn main() {}
