//! Fetch and shading in a brick, of segments as well whose middle lies in another brick than their end.

use fearless_simd::Simd;
use fearless_simd::prelude::*;
use vr_kernels::vector::{LANES, Lanes, pick, splat};

use super::chunk::{Chunk, Fetch, Fetcher, SampleSet};
use crate::fragments::Fragments;
use crate::texture::{BrickPart, Lit, Texture};

/// Reflection at the middles of the next segments of sixteen rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reflected {
    /// Factors on the three colours, and the lights that are added to an opaque segment.
    light: [Lanes; 6],
    /// 1 for rays whose middle has been met, else 0.
    met: Lanes,
}

impl Reflected {
    pub(super) const NOTHING: Self = Self { light: [Lanes::ZERO; 6], met: Lanes::ZERO };

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
    /// Reflection at the middle of the segment that ends at a ray's first sample here, if that lay in an earlier brick.
    pub(super) middles: &'a mut Reflected,
}

impl<S: Simd, X: Texture> Fetch<S> for BrickFetcher<'_, '_, X> {
    fn fetch(&mut self, simd: S, rays: &Fragments, which: SampleSet<'_>, chunk: &mut Chunk) {
        self.fetcher.fetch(simd, rays, which, chunk);
    }

    fn shade(
        &mut self,
        simd: S,
        rays: &Fragments,
        which: SampleSet<'_>,
        segments: bool,
        lit: &Lit<'_>,
        chunk: &mut Chunk,
    ) {
        let unlit = chunk.light;
        self.fetcher.shade(simd, rays, which, segments, lit, chunk);
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
                    let alpha = unlit[j][3].load(simd);
                    for c in 0..3 {
                        let [factor, added] = [c, 3 + c].map(|k| self.middles.light[k]);
                        let lit = unlit[j][c].load(simd) * factor.load(simd) + added.load(simd) * alpha;
                        chunk.light[j][c] = Lanes::new(pick(elsewhere, lit, chunk.light[j][c].load(simd)));
                    }
                }
            },
        );
    }
}

impl<X: Texture> BrickFetcher<'_, '_, X> {
    /// Notes what the middles of the rays' next segments reflect, where these lie in the brick: their ends lie in later ones. `next`: the samples at which they
    /// end, a ray's first one standing for the one behind it.
    #[inline(never)]
    pub(super) fn meet_middles<S: Simd>(&mut self, simd: S, rays: &Fragments, next: &Lanes, lit: &Lit<'_>) {
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
                // Reflected light is linear in a segment's colour and in its opacity: two of them tell all.
                let (clear, opaque) = (Lanes::ZERO, Lanes([1.0; LANES]));
                let (mut white, mut black) = ([opaque, opaque, opaque, clear], [clear, clear, clear, opaque]);
                let texture = self.fetcher.texture;
                let at = texture.place_between(simd, middle);
                texture.shade(simd, &at, lit, &mut white, &mut self.fetcher.stages[0]);
                texture.shade(simd, &at, lit, &mut black, &mut self.fetcher.stages[0]);
                let Reflected { light, met } = &mut *self.middles;
                for c in 0..3 {
                    light[c] = Lanes::new(pick(here, white[c].load(simd), light[c].load(simd)));
                    light[3 + c] = Lanes::new(pick(here, black[c].load(simd), light[3 + c].load(simd)));
                }
                *met = Lanes::new(pick(here, splat(simd, 1.0), met.load(simd)));
            },
        );
    }
}
