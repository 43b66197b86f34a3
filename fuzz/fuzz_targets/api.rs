//! Programs that any bytes write (`tests/checkpoint/driver.rs`):
//! `cargo +nightly fuzz run api fuzz/corpus/api tests/corpus/api -- -max_len=128 -timeout=60`.
//!
//! The first folder takes what is found.

#![no_main]

#[path = "../../tests/checkpoint/driver.rs"]
mod driver;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    driver::drive(bytes);
});
