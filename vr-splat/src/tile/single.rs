//! Splats without sheets: each composited at once, or summed.

use fearless_simd::Simd;
use fearless_simd::prelude::*;
use vr_kernels::vector::{Lanes, opacity_of_depth, pick, source_weight, splat};

use crate::bins::Keyed;

use super::Tile;
use super::painter::Content;

impl Tile<'_> {
    /// Every splat on its own, nearest first.
    #[inline(always)]
    pub(super) fn samples<S: Simd>(&mut self, simd: S, splats: &[Keyed]) {
        let Content::Light(optics) = self.painter.content else { return };
        for (i, Keyed { splat: at, .. }) in splats.iter().enumerate() {
            if self.done == u64::MAX {
                self.work.skipped += (splats.len() - i) as u64;
                return;
            }
            let Some(covered) = self.covered(at) else { continue };
            let [r, g, b, kappa] = optics.at(at.value);
            for y in covered.y[0]..=covered.y[1] {
                for x in covered.x[0]..=covered.x[1] {
                    let Some(number) = self.take(x, y) else { continue };
                    let Some(weight) = self.weight(simd, number, at) else { continue };
                    let zero = splat(simd, 0.0);
                    let tau = weight * kappa;
                    let alpha = opacity_of_depth(simd, tau.max(zero));
                    let share = pick(tau.simd_lt(zero), zero, source_weight(simd, tau, alpha)) * weight;
                    self.states[number].blend(simd, self.painter.operator, [share * r, share * g, share * b, alpha]);
                    self.retire(simd, number);
                }
            }
        }
    }

    /// Sums of values over whole kernels.
    #[inline(always)]
    pub(super) fn sums<S: Simd>(&mut self, simd: S, splats: &[Keyed]) {
        for Keyed { splat: at, .. } in splats {
            let Some(covered) = self.covered(at) else { continue };
            for y in covered.y[0]..=covered.y[1] {
                for x in covered.x[0]..=covered.x[1] {
                    let Some(number) = self.take(x, y) else { continue };
                    let Some(weight) = self.weight(simd, number, at) else { continue };
                    let state = &mut self.states[number];
                    state.value = Lanes::of(state.value.load(simd) + weight * at.value);
                    state.length = Lanes::of(state.length.load(simd) + weight);
                }
            }
        }
    }
}
