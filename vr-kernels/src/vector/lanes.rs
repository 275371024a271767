//! Sixteen numbers in memory, one a lane.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

use super::LANES;

/// One `f32` a ray, as vector code wants it in memory: a load that crosses no cache line.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Lanes(
    /// Lane by lane.
    pub [f32; LANES],
);

impl Lanes {
    /// Zeros.
    pub const ZERO: Self = Self([0.0; LANES]);

    /// Loads the vector.
    #[inline(always)]
    pub fn load<S: Simd>(&self, simd: S) -> f32x16<S> {
        f32x16::load_array_ref(simd, &self.0)
    }

    /// The lanes of a vector.
    #[inline(always)]
    pub fn new<S: Simd>(vector: f32x16<S>) -> Self {
        Self(vector.to_array())
    }
}
