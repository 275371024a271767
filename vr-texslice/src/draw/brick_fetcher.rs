//! Fetch in a brick; and gradients in the middle of segments, which may lie in another brick than their end.

use fearless_simd::Simd;
use fearless_simd::prelude::*;
use vr_kernels::vector::{LANES, Lanes, pick, splat};

use super::chunk::{Chunk, Fetch, Fetcher, SampleSet};
use crate::fragments::Fragments;
use crate::texture::{BrickPart, Texture};

/// Gradients in the middle of the next segments of sixteen rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Middles {
    gradient: [Lanes; 3],
    /// 1 for rays whose middle has been met, else 0.
    met: Lanes,
}

impl Middles {
    pub(super) const UNKNOWN: Self = Self { gradient: [Lanes::ZERO; 3], met: Lanes::ZERO };

    /// Forgets the segments of rays that have gone on from one sample to another.
    pub(super) fn forget(&mut self, from: &Lanes, to: &Lanes) {
        for i in 0..LANES {
            self.met.0[i] = if from.0[i] == to.0[i] { self.met.0[i] } else { 0.0 };
        }
    }
}

/// A brick's texture for sixteen rays.
pub(super) struct BrickFetcher<'a, 'x, X: Texture> {
    pub(super) fetcher: &'a mut Fetcher<'x, X>,
    pub(super) part: &'a BrickPart,
    /// Gradient in the middle of the segment that ends at a ray's first sample here, if that lay in an earlier brick.
    pub(super) middles: &'a mut Middles,
}

impl<S: Simd, X: Texture> Fetch<S> for BrickFetcher<'_, '_, X> {
    fn fetch(&mut self, simd: S, rays: &Fragments, which: SampleSet<'_>, chunk: &mut Chunk) {
        self.fetcher.fetch(simd, rays, which, chunk);
    }

    fn fetch_across(&mut self, simd: S, samples: &[(&Fragments, &Lanes)], chunk: &mut Chunk) {
        self.fetcher.fetch_across(simd, samples, chunk);
    }

    fn gradients(&mut self, simd: S, rays: &Fragments, which: SampleSet<'_>, segments: bool, chunk: &mut Chunk) {
        self.fetcher.gradients(simd, rays, which, segments, chunk);
        if !segments {
            return;
        }
        simd.vectorize(
            #[inline(always)]
            || {
                for j in 0..chunk.len {
                    let here = self.part.holds(simd, which.middle(simd, rays, j));
                    let elsewhere = !here & self.middles.met.load(simd).simd_gt(splat(simd, 0.0));
                    if elsewhere.all_false() {
                        continue;
                    }
                    // A chunk's other segments begin in this brick, and end in it.
                    for (found, kept) in chunk.gradient[j].iter_mut().zip(&self.middles.gradient) {
                        *found = Lanes::new(pick(elsewhere, kept.load(simd), found.load(simd)));
                    }
                }
            },
        );
    }
}

impl<X: Texture> BrickFetcher<'_, '_, X> {
    /// Notes the gradients in the middle of the rays' next segments, where these lie in the brick: their ends lie in later ones. `next`: the samples at which they
    /// end, a ray's first one standing for the one behind it.
    #[inline(never)]
    pub(super) fn meet_middles<S: Simd>(&mut self, simd: S, rays: &Fragments, next: &Lanes) {
        simd.vectorize(
            #[inline(always)]
            || {
                let (begin, end) = (rays.begin.load(simd), rays.end.load(simd));
                let number = next.load(simd).max(begin);
                let whole = number.simd_lt(end);
                let last = number.simd_eq(end) & rays.has[1].load(simd).simd_gt(splat(simd, 0.0));
                let between = SampleSet::From(&Lanes::new(number)).middle(simd, rays, 0);
                let at_last = SampleSet::Outer(1).middle(simd, rays, 0);
                let middle = [
                    pick(whole, between[0], at_last[0]),
                    pick(whole, between[1], at_last[1]),
                    pick(whole, between[2], at_last[2]),
                ];
                let here = (whole | last) & self.part.holds(simd, middle);
                if here.all_false() {
                    return;
                }
                let texture = self.fetcher.texture;
                let at = texture.place_between(simd, middle);
                let wanted = here.to_bitmask() as u32;
                let found = texture.gradient(simd, &at, wanted, &mut self.fetcher.stages[0]);
                for (kept, found) in self.middles.gradient.iter_mut().zip(found) {
                    *kept = Lanes::new(pick(here, found.load(simd), kept.load(simd)));
                }
                self.middles.met = Lanes::new(pick(here, splat(simd, 1.0), self.middles.met.load(simd)));
            },
        );
    }
}
