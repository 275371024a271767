//! Levels of vector instructions that kernels are made for.

use fearless_simd::{Level, Simd};

/// Work that is generic over the vectors of a machine.
pub trait Vectorized {
    /// Result of the work.
    type Output;
    /// True if the work is compiled for AVX2 alone on x86-64, whatever the level is.
    ///
    /// Large kernels set it to `cfg!(test)`: the instances of a kernel, that for SSE2 above all, take most of the time of building the unit tests of its crate.
    /// Tests from outside of the crate use the instances of the library, and compare the levels.
    const AVX2_ALONE: bool = false;
    /// Does the work with the vectors of the level; called once. Must be `#[inline(always)]`, and so must all that it calls.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

/// Runs work with a level's instructions.
///
/// On x86-64 there are three instances of each kernel, not the five that the library tells apart: AVX-512, AVX2 and SSE2, which every
/// x86-64 has. What SSE4.2 adds is of no use here, and each instance costs seconds to compile.
///
/// # Panics
/// Panics if the work is compiled for AVX2 alone, and the machine does not have it.
#[inline(always)]
pub fn run<W: Vectorized>(level: Level, work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    match level {
        _ if W::AVX2_ALONE => run_on(level.as_avx2().expect("unit tests of kernels need a processor with AVX2"), work),
        Level::Avx512(simd) => run_on(simd, work),
        Level::Avx2(simd) => run_on(simd, work),
        _ => run_on(baseline(), work),
    }
    #[cfg(not(target_arch = "x86_64"))]
    fearless_simd::dispatch!(level, simd => work.run(simd))
}

#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn run_on<S: Simd, W: Vectorized>(simd: S, work: W) -> W::Output {
    simd.vectorize(
        #[inline(always)]
        || work.run(simd),
    )
}

/// Returns the vectors that every machine of the target has: SSE2 on x86-64, Neon on 64-bit ARM, those of 128 bits in WebAssembly where they
/// are enabled; elsewhere numbers one by one, which is slow.
#[inline(always)]
pub fn baseline() -> impl Simd {
    #[cfg(any(target_arch = "x86_64", target_arch = "x86"))]
    return Level::baseline().as_sse2().expect("SSE2 is part of the target");
    #[cfg(target_arch = "aarch64")]
    return Level::baseline().as_neon().expect("Neon is part of the target");
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    return Level::baseline().as_wasm_simd128().expect("vectors are enabled in the target");
    #[cfg(not(any(
        target_arch = "x86_64",
        target_arch = "x86",
        target_arch = "aarch64",
        all(target_arch = "wasm32", target_feature = "simd128")
    )))]
    fearless_simd::Fallback::new()
}
