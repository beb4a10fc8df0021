//! See `stl` in `lib.rs`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| myxo_fuzz::stl(bytes));
