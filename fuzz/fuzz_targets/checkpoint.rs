//! The reader of checkpoints, on any bytes (`tests/checkpoint/reader.rs`):
//! `cargo +nightly fuzz run checkpoint fuzz/corpus/checkpoint tests/corpus/checkpoint -- -runs=1000000 -max_len=20000 -malloc_limit_mb=1`.
//!
//! The first folder takes what is found. Memory is at most 32 times the input, less than a megabyte here.

#![no_main]

#[path = "../../tests/checkpoint/reader.rs"]
mod reader;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    reader::read(bytes);
});
