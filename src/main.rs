//! The `myxo` executable.
mod lab;

fn main() {}
