//! Every reader of `vr-io` under arbitrary bytes: it reads them or refuses them in one line; it never panics, never hangs, and never allocates
//! what a header merely claims.
//!
//! A [`Target`] is a kind of file with the reader that takes it, and small whole files to begin from. `cargo test -p vr-fuzz` replays each
//! target under seeded damage; libFuzzer looks further, guided by what the code does:
//!
//! ```text
//! cargo run --release -p vr-fuzz --example seeds -- corpus      # the seeds, in a folder a target
//! VR_FUZZ=nrrd cargo +nightly fuzz run --features libfuzzer read corpus/nrrd -- -max_len=4096 -timeout=1 -malloc_limit_mb=512
//! ```
//!
//! # Examples
//! ```
//! use vr_fuzz::{Ground, target};
//!
//! let nrrd = Ground::new(target("nrrd").unwrap());
//! assert_eq!(nrrd.run(b"NRRD0005\nsizes: a lot\n\n"), Ok(()));
//! ```

mod ground;
mod readers;
mod seeds;
mod targets;

// Files of the tests of vr-io.
#[path = "../../vr-io/tests/all/small_amr/mod.rs"]
mod small_amr;
#[path = "../../vr-io/tests/all/small_images/mod.rs"]
mod small_images;
#[path = "../../vr-io/tests/all/small_meshes/mod.rs"]
mod small_meshes;
#[path = "../../vr-io/tests/all/small_points/mod.rs"]
mod small_points;
#[path = "../../vr-io/tests/all/tiny/mod.rs"]
mod tiny;

pub use ground::{Ground, MAX_MEMORY, MEMORY_LEFT};
pub use targets::{TARGETS, Target, target};
