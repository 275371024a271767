//! Compositing of a sheet: its content becomes light, and joins what is before it.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use vr_kernels::vector::{
    LANES, Lanes, Operator, StepOptics, opacity_of_depth, pick, source_weight, splat, step_light,
};

use crate::point_mixture::MixtureChannels;
use crate::shading::{Pieces, Slope};
use crate::sheets::AT_LAYER;

use super::painter::{Classifier, Content, VisibleCells};
use super::{Tile, sloped_mean};

impl Tile<'_> {
    /// Classifies the content of a block in a sheet between two depths, whose channels begin at `at`, and composites it. `sheet` is the sheet's number if it is
    /// parallel to the image.
    #[inline(always)]
    pub(super) fn composite<S: Simd>(
        &mut self,
        simd: S,
        [number, at]: [usize; 2],
        sheet: Option<usize>,
        length: f32x16<S>,
        mut part: [f32x16<S>; 2],
    ) {
        let painter = self.painter;
        let depth = (part[0] + part[1]) * 0.5;
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let operator = painter.operator;
        let light = match &painter.content {
            Content::Values { classifier, normalised, mixture, colors, cells, shader } => {
                // The value: a sum divided by weights, or by the length that supports cover.
                let (sum, weight) = (self.sheets[at].load(simd), self.sheets[at + 1].load(simd));
                let (length, divisor) = if *normalised {
                    (length, weight)
                } else {
                    // From the first front to the back of the sheet, and from its front to the last back: what they have in common.
                    let to_front = self.sheets[at + 2].load(simd);
                    let both = weight + to_front;
                    part = [part[1] - weight, part[0] + to_front];
                    let covered = (both * self.blocks[number].stretch.load(simd) - length).max(zero);
                    (covered, covered)
                };
                // Means are divided by weights.
                let is_mean = mixture.is_some_and(|mixture| mixture.is_mean);
                let channels = MixtureChannels::new(shader.is_some(), is_mean);
                let weights = match mixture {
                    Some(_) => self.sheets[at + channels.weight].load(simd),
                    None => divisor,
                };
                let divisor = if is_mean { weights } else { divisor };
                let mut there = divisor.simd_gt(zero) & length.simd_gt(zero);
                if !there.any_true() {
                    return;
                }
                let divisor = pick(there, divisor, one);
                let mean = match self.sheets[at..at + self.channels].try_into() {
                    Ok(sums) => Some(sloped_mean::of(simd, sums, divisor)),
                    Err(_) => None,
                };
                let value = if let Some(mean) = &mean { mean.value } else { sum / divisor };
                let inside = there;
                // Nothing is taken from cells in which nothing can be seen.
                if let Some(cells) = cells {
                    let known = sheet.and_then(|sheet| self.sighted.rays(sheet, number));
                    let rays = known.unwrap_or_else(|| self.in_visible_cells(simd, number, depth, cells));
                    there &= mask32x16::from_bitmask(simd, rays.into());
                }
                if operator == Operator::Average && colors.is_some() {
                    self.sum_colors(simd, number, depth, pick(there, length, zero));
                }
                if operator.picks() {
                    self.states[number].choose(simd, operator, value, length, [there, inside & !there], part);
                    return;
                }
                if !there.any_true() {
                    return;
                }
                // Light of the value over the length, then the gradient's part in it.
                let length = pick(there, length, zero);
                let per_unit = 1.0 / painter.view.unit as f32;
                let follows = shader.is_some_and(|shader| shader.follows());
                let mut step = None;
                let light = match classifier {
                    Classifier::Table(optics) => {
                        let row = optics.rows().at(simd, value);
                        if follows {
                            let row = [Lanes::new(row[0]), Lanes::new(row[1]), Lanes::new(row[2]), Lanes::new(row[3])];
                            let length = Lanes::new(length * per_unit);
                            step = Some(StepOptics { value: Lanes::new(value), row, length, emits: optics.emits });
                        }
                        step_light(simd, row, length * per_unit, optics.emits)
                    }
                    Classifier::Ramps(ramps) => ramps.step(simd, value, length * per_unit),
                    Classifier::Exact(step) => {
                        let (value, length) = (value.to_array(), length.to_array());
                        let mut light = [Lanes::ZERO; 4];
                        for i in 0..LANES {
                            let one = step(value[i], length[i]);
                            for c in 0..4 {
                                light[c].0[i] = one[c];
                            }
                        }
                        [light[0].load(simd), light[1].load(simd), light[2].load(simd), light[3].load(simd)]
                    }
                };
                let tint = match (mixture, colors) {
                    (Some(mixture), _) if mixture.has_colors => Some(self.tint(simd, at + channels.color, weights)),
                    (_, Some(colors)) => Some(colors.at(simd, &self.place(simd, number, depth))),
                    _ => None,
                };
                match shader {
                    Some(shader) if follows || light[3].simd_gt(zero).any_true() => {
                        let mut lanes =
                            [Lanes::new(light[0]), Lanes::new(light[1]), Lanes::new(light[2]), Lanes::new(light[3])];
                        let slope = if *normalised {
                            Slope::At(self.place(simd, number, depth))
                        } else {
                            // Values per unit of the view.
                            let mut slope = [Lanes::ZERO; 3];
                            for a in 0..3 {
                                let one = match &mean {
                                    Some(mean) => mean.slope[a],
                                    None => self.sheets[at + channels.slope + a].load(simd) / divisor,
                                };
                                slope[a] = Lanes::new(one / per_unit);
                            }
                            Slope::Known(slope)
                        };
                        let (value, length) = (Lanes::new(value), Lanes::new(length));
                        let pieces = Pieces { slope, value, length, optics: step, tint };
                        shader.shade(simd, &self.lights[number], &pieces, &mut lanes);
                        [lanes[0].load(simd), lanes[1].load(simd), lanes[2].load(simd), lanes[3].load(simd)]
                    }
                    _ => match tint {
                        Some([r, g, b]) => {
                            [light[0] * r.load(simd), light[1] * g.load(simd), light[2] * b.load(simd), light[3]]
                        }
                        None => light,
                    },
                }
            }
            Content::Light(_) => {
                let tau = self.sheets[at + 3].load(simd);
                let alpha = opacity_of_depth(simd, tau.max(zero));
                // A sinc's sides may outweigh its middle: less than nothing sends nothing.
                let share = pick(tau.simd_lt(zero), zero, source_weight(simd, tau, alpha));
                let [r, g, b] = [0, 1, 2].map(|c| self.sheets[at + c].0);
                [Lanes(r).load(simd) * share, Lanes(g).load(simd) * share, Lanes(b).load(simd) * share, alpha]
            }
            Content::Sums => return,
        };
        self.states[number].blend(simd, operator, light, part);
        self.retire(simd, number);
    }

    /// Adds the colours of rays at a depth, each over a length, to the sums of those that are averaged.
    #[inline(always)]
    pub(super) fn sum_colors<S: Simd>(&mut self, simd: S, number: usize, depth: f32x16<S>, length: f32x16<S>) {
        let Some(colors) = self.painter.colors() else { return };
        let tint = colors.at(simd, &self.place(simd, number, depth));
        for (sum, tint) in self.states[number].light.iter_mut().zip(tint) {
            *sum = Lanes::new(sum.load(simd) + tint.load(simd) * length);
        }
    }

    /// Returns the mean colour of the points in a sheet, whose sums of colours begin at a channel; white where there are none.
    #[inline(always)]
    fn tint<S: Simd>(&self, simd: S, first: usize, weights: f32x16<S>) -> [Lanes; 3] {
        let (one, there) = (splat(simd, 1.0), weights.simd_gt(splat(simd, 0.0)));
        let divisor = pick(there, weights, one);
        let mut tint = [Lanes::ZERO; 3];
        for c in 0..3 {
            tint[c] = Lanes::new(pick(there, self.sheets[first + c].load(simd) / divisor, one));
        }
        tint
    }

    /// Ends a block that is opaque: it takes no more.
    #[inline(always)]
    pub(super) fn retire<S: Simd>(&mut self, simd: S, number: usize) {
        if let Operator::Under { level } = self.painter.operator {
            let block = &self.blocks[number];
            let clear = self.states[number].clear.load(simd);
            let min_clear = splat(simd, self.painter.negligible.max(1.0 - level));
            let open = clear.simd_gt(min_clear) & block.near.load(simd).simd_lt(block.far.load(simd));
            if !open.any_true() {
                self.done |= 1 << number;
                self.work.opaque += 1;
            }
        }
    }

    /// Rays that are in a visible cell at a depth, a bit each.
    #[inline(always)]
    pub(super) fn in_visible_cells<S: Simd>(
        &self,
        simd: S,
        number: usize,
        depth: f32x16<S>,
        cells: &VisibleCells<'_>,
    ) -> u16 {
        let &VisibleCells { bits, dims, beyond } = cells;
        // A layer lies between two cells: of the volume's own sheets, the one behind it counts, whatever rounding does.
        let ahead = beyond as f32 + if self.painter.layers.is_some() { AT_LAYER as f32 } else { 0.0 };
        let index = self.place(simd, number, depth);
        let mut visible = 0;
        for i in 0..LANES {
            // `as` saturates at 0.
            let cell = |a: usize| ((index[a].0[i] + ahead) as usize).clamp(beyond, dims[a] - 2 - beyond);
            visible |= u16::from(bits.is_visible(cell(0), cell(1), cell(2))) << i;
        }
        visible
    }

    /// Positions of a block's rays in a grid at some depths.
    #[inline(always)]
    pub(super) fn place<S: Simd>(&self, simd: S, number: usize, depth: f32x16<S>) -> [Lanes; 3] {
        let [from, step] = &self.blocks[number].index;
        let mut place = [Lanes::ZERO; 3];
        for a in 0..3 {
            place[a] = Lanes::new(from[a].load(simd) + step[a].load(simd) * depth);
        }
        place
    }
}
