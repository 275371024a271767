//! What sixteen rays hold, one number each.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

/// Rays in a packet: as many as the widest vector has lanes.
pub(crate) use vr_core::vector::{LANES, pick, splat};

/// One `f32` a ray, as vector code wants it in memory: a load that crosses no cache line.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Lanes(pub(crate) [f32; LANES]);

impl Lanes {
    pub(crate) const ZERO: Self = Self([0.0; LANES]);

    #[inline(always)]
    pub(crate) fn load<S: Simd>(&self, simd: S) -> f32x16<S> {
        f32x16::load_array_ref(simd, &self.0)
    }

    #[inline(always)]
    pub(crate) fn of<S: Simd>(vector: f32x16<S>) -> Self {
        Self(vector.to_array())
    }
}
