//! Splats whose whole kernel is added at once: to the volume's own sheets, or straight to the pixels.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_kernels::vector::{Lanes, Operator, opacity_of_depth, pick, source_weight, splat};

use crate::bins::Keyed;
use crate::splat::Splat;
use crate::splatter::Buffers;

use super::Tile;
use super::footprint::whole;
use super::painter::Content;
use super::sheets::add;

impl Tile<'_> {
    /// Adds splats in their order. Sheets of the volume are composited one after another; without sheets, every splat is composited on its
    /// own, or sums of values are all that is wanted.
    #[inline(always)]
    pub(super) fn whole_splats<S: Simd>(&mut self, simd: S, splats: &[Keyed]) {
        let painter = self.painter;
        let channels = self.channels;
        let sums = matches!(painter.content, Content::Sums);
        let in_sheets = !sums && painter.buffers == Buffers::Axis;
        for (i, Keyed { key, splat: at }) in splats.iter().enumerate() {
            let in_last_sheet = in_sheets && i > 0 && splats[i - 1].key == *key;
            if !in_last_sheet && !sums {
                if in_sheets && i > 0 {
                    self.finish_sheet(simd, splats[i - 1].key);
                }
                if self.done == u64::MAX {
                    self.work.skipped += (splats.len() - i) as u64;
                    return;
                }
            }
            let Some(covered) = self.covered(at) else { continue };
            let optics = match &painter.content {
                Content::Light(optics) => optics.at(at.value),
                _ => [0.0; 4],
            };
            for y in covered.y[0]..=covered.y[1] {
                for x in covered.x[0]..=covered.x[1] {
                    let Some(number) = self.take(x, y) else { continue };
                    let Some(weight) = self.weight(simd, number, at) else { continue };
                    if sums {
                        let state = &mut self.states[number];
                        state.value = Lanes::new(state.value.load(simd) + weight * at.value);
                        state.length = Lanes::new(state.length.load(simd) + weight);
                    } else if in_sheets {
                        let place = self.place_of(0, number);
                        add(simd, &mut self.sheets[place..place + channels], weight, at.value, optics);
                        self.touched[0] |= 1 << number;
                    } else if painter.operator.picks() {
                        // On its own, a sample has its own value wherever its kernel is met.
                        let (depth, met) = (splat(simd, at.place[2]), weight.simd_gt(splat(simd, painter.min_met)));
                        let none = weight.simd_lt(weight);
                        let value = splat(simd, at.value);
                        if painter.operator == Operator::Average {
                            self.sum_colors(simd, number, depth, pick(met, weight, splat(simd, 0.0)));
                        }
                        self.states[number].choose(simd, painter.operator, value, weight, [met, none], [depth; 2]);
                    } else {
                        let [r, g, b, kappa] = optics;
                        let zero = splat(simd, 0.0);
                        let tau = weight * kappa;
                        let alpha = opacity_of_depth(simd, tau.max(zero));
                        let share = pick(tau.simd_lt(zero), zero, source_weight(simd, tau, alpha)) * weight;
                        let depth = splat(simd, at.place[2]);
                        let light = [share * r, share * g, share * b, alpha];
                        self.states[number].blend(simd, painter.operator, light, [depth; 2]);
                        self.retire(simd, number);
                    }
                }
            }
        }
        if let Some(last) = splats.last().filter(|_| in_sheets) {
            self.finish_sheet(simd, last.key);
        }
    }

    /// ∫ of a splat's kernel along the rays of a block, in world units; `None` if none meets it.
    #[inline(always)]
    fn weight<S: Simd>(&self, simd: S, number: usize, splat: &Splat) -> Option<f32x16<S>> {
        let block = &self.blocks[number];
        let ends = [block.near.load(simd), block.far.load(simd)];
        let sum = whole(simd, self.painter.kernel, &self.axes, block, splat, ends)?;
        Some(sum * block.stretch.load(simd) * splat.weight)
    }
}
