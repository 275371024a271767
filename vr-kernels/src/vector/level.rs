//! Levels of vector instructions that kernels are made for.

use fearless_simd::{Level, Simd};

/// Work that is generic over the vectors of a machine.
pub trait Vectorized {
    /// Result of the work.
    type Output;
    /// Does the work with the vectors of the level; called once. Must be `#[inline(always)]`, and so must all that it calls.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

/// Runs work with a level's instructions.
///
/// On x86-64 there are three instances of each kernel, not the five that the library tells apart: AVX-512, AVX2 and SSE2, which every
/// x86-64 has. What SSE4.2 adds is of no use here, and each instance costs seconds to compile.
#[inline(always)]
pub fn run<W: Vectorized>(level: Level, work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    {
        if let Level::Avx512(simd) = level {
            return simd.vectorize(
                #[inline(always)]
                || work.run(simd),
            );
        }
        if let Level::Avx2(simd) = level {
            return simd.vectorize(
                #[inline(always)]
                || work.run(simd),
            );
        }
        let simd = level.as_sse2().or(Level::baseline().as_sse2()).expect("every x86-64 has SSE2");
        simd.vectorize(
            #[inline(always)]
            || work.run(simd),
        )
    }
    #[cfg(not(target_arch = "x86_64"))]
    fearless_simd::dispatch!(level, simd => work.run(simd))
}
