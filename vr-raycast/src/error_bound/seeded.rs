//! Runs of property tests that draw the same cases each time.

use proptest::test_runner::{Config, RngAlgorithm, RngSeed, TestRunner};

/// Returns a runner of so many cases, which are the same each time.
pub(super) fn runner(cases: u32, seed: u64) -> TestRunner {
    TestRunner::new(Config {
        cases,
        rng_algorithm: RngAlgorithm::ChaCha,
        rng_seed: RngSeed::Fixed(seed),
        failure_persistence: None,
        ..Config::default()
    })
}
