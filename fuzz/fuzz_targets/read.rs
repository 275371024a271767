//! libFuzzer on the target that the variable VR_FUZZ names.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use peak_alloc::PeakAlloc;
use vr_core::memory;
use vr_fuzz::{Ground, MAX_MEMORY, MEMORY_LEFT, target};

// Counts memory without AddressSanitizer, which takes most of the time and finds little in safe Rust.
#[global_allocator]
static HEAP: PeakAlloc = PeakAlloc;

static GROUND: LazyLock<Ground> = LazyLock::new(|| {
    memory::set_meter(|| MEMORY_LEFT);
    let name = std::env::var("VR_FUZZ").unwrap_or_default();
    Ground::new(target(&name).unwrap_or_else(|| panic!("VR_FUZZ: found {name:?}; must be the name of a target")))
});

fuzz_target!(|bytes: &[u8]| {
    HEAP.reset_peak_usage();
    if let Err(fault) = GROUND.run(bytes) {
        panic!("{fault}");
    }
    let peak = HEAP.peak_usage();
    assert!(peak < MAX_MEMORY, "took {peak} bytes");
});
