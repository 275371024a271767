//! libFuzzer on the target that the variable VR_FUZZ names.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use vr_core::memory;
use vr_fuzz::{Ground, MEMORY_LEFT, target};

static GROUND: LazyLock<Ground> = LazyLock::new(|| {
    memory::set_meter(|| MEMORY_LEFT);
    let name = std::env::var("VR_FUZZ").unwrap_or_default();
    Ground::new(target(&name).unwrap_or_else(|| panic!("VR_FUZZ: found {name:?}; must be the name of a target")))
});

fuzz_target!(|bytes: &[u8]| {
    if let Err(fault) = GROUND.run(bytes) {
        panic!("{fault}");
    }
});
