//! See `map` in `lib.rs`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| myxo_fuzz::map(bytes));
