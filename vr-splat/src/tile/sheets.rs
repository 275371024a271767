//! Splats are added to sheets parallel to the image, and sheets of either kind are finished.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_kernels::vector::{Lanes, pick, splat};

use crate::bins::Keyed;
use crate::point_mixture::MixtureChannels;
use crate::splat::Splat;
use crate::splatter::Buffers;

use super::footprint::{Crossing, FootprintKernel, Passing};
use super::fragments::{self, Fragments};
use super::products::SheetProducts;
use super::{Tile, sloped_mean};

/// The part of a splat in a sheet, for sixteen rays.
pub(super) struct Section<S: Simd> {
    /// ∫ of its kernel, in world units; in the middle of the sheet the kernel itself, where weights are divided out.
    pub(super) whole: f32x16<S>,
    /// The depths of the sheet's faces, and of the support's ends, where what is covered matters.
    pub(super) reach: Option<[[f32x16<S>; 2]; 2]>,
    /// ∫ of the kernel's gradient, along the view's axes, where light depends on it.
    pub(super) gradient: Option<[f32x16<S>; 3]>,
}

impl Tile<'_> {
    /// Sheets parallel to the image: a ring of those that splats are still added to.
    #[inline(always)]
    pub(super) fn image_sheets<S: Simd>(&mut self, simd: S, splats: &[Keyed]) {
        let painter = self.painter;
        let half = painter.view.half_depth() as f32;
        // Sheets from `next` to `open` may hold something.
        let (mut next, mut open) = (0, 0);
        // Rays of small kernels, where sheets hold what these can be added to.
        let takes_apart = match painter.kernel {
            FootprintKernel::Smooth(_, chords, _) if self.channels == fragments::CHANNELS => Some(chords),
            _ => None,
        };
        let mut fragments = Fragments::NONE;
        // Factors, where rays are parallel; not where values are picked, since sums of products may be slightly negative near a rim.
        let factors = match painter.kernel {
            FootprintKernel::Smooth(_, _, factors) if takes_apart.is_some() && !painter.operator.picks() => {
                factors.as_ref().zip(self.axes.round())
            }
            _ => None,
        };
        let mut products = SheetProducts::NONE;
        for (i, Keyed { key, splat }) in splats.iter().enumerate() {
            if let Some(chords) = takes_apart.filter(|_| next < *key && next < open) {
                self.add_fragments(simd, chords, &mut fragments);
            }
            while next < *key && next < open {
                self.finish_sheet(simd, next);
                next += 1;
            }
            next = *key;
            if self.done == u64::MAX {
                self.work.skipped += (splats.len() - i) as u64;
                return;
            }
            let Some(covered) = self.covered(splat) else { continue };
            let back = (splat.place[2] + half / splat.scale) / painter.distance;
            // `as` saturates; rounding must not take more sheets than the ring has.
            let last = (back as u32).clamp(*key, key + painter.ring - 1).min(painter.sheets - 1);
            open = open.max(last + 1);
            if let Some(chords) = takes_apart.filter(|_| covered.pixels() <= fragments::MAX_PIXELS) {
                self.take_apart(simd, chords, &mut fragments, splat, &covered, [*key, last]);
                continue;
            }
            let blocks = self.sighted.blocks(*key..=last);
            let mut takers = covered.blocks() & !self.done & !blocks.dark;
            if takers == 0 {
                continue;
            }
            if let Some(weight) = painter.in_middle {
                self.add_middles(simd, weight, splat, (takers, blocks), [*key, last]);
                continue;
            }
            if let Some(factors) = factors {
                self.set_products(simd, factors, &mut products, splat, [*key, last]);
            }
            while takers != 0 {
                let number = takers.trailing_zeros() as usize;
                takers &= takers - 1;
                if !self.takes_in_sight(simd, number, blocks, [*key, last]) {
                    continue;
                }
                if factors.is_some() && self.is_uncut(number, [*key, last]) {
                    self.add_products(simd, &products, splat, number);
                } else {
                    self.add_sections(simd, number, splat, *key, last);
                }
            }
        }
        if let Some(chords) = takes_apart {
            self.add_fragments(simd, chords, &mut fragments);
        }
        for sheet in next..open {
            self.finish_sheet(simd, sheet);
        }
    }

    /// Adds what lies in each of some sheets of a splat.
    #[inline(always)]
    pub(super) fn add_sections<S: Simd>(&mut self, simd: S, number: usize, splat_: &Splat, first: u32, last: u32) {
        let painter = self.painter;
        let block = &self.blocks[number];
        let (near, far) = (block.near.load(simd), block.far.load(simd));
        let carried = painter.carried(splat_);
        let channels = self.channels;
        match painter.kernel {
            FootprintKernel::Smooth(_, chords, _) if painter.summed_gradient().is_some() => {
                self.add_chords::<true, S>(simd, chords, number, splat_, carried, [first, last]);
            }
            FootprintKernel::Smooth(_, chords, _) => {
                self.add_chords::<false, S>(simd, chords, number, splat_, carried, [first, last]);
            }
            // Differences of partial integrals from one sheet's face to the next.
            FootprintKernel::Radial(table) => {
                let Some(passing) = Passing::new(simd, &self.axes, block, splat_) else { return };
                let factor = block.stretch.load(simd) * splat_.weight / passing.speed;
                let [enter, leave] = passing.chord(simd);
                let mut start = splat(simd, first as f32 * painter.distance).max(near).min(far);
                let mut before = passing.up_to(simd, table, start);
                for sheet in first..=last {
                    let end = splat(simd, (sheet + 1) as f32 * painter.distance).max(near).min(far);
                    let after = passing.up_to(simd, table, end);
                    // Radial kernels are nowhere negative; tables and rounding might be.
                    let whole = (after - before).max(splat(simd, 0.0)) * factor;
                    before = after;
                    let section = Section { whole, reach: Some([[start, end], [enter, leave]]), gradient: None };
                    self.add_section(simd, [sheet as usize, number], section, carried);
                    start = end;
                }
            }
            // Products along the axes, in the middle of each sheet.
            kernel => {
                let crossing = Crossing::new(simd, &self.axes, block, splat_);
                let factor = block.stretch.load(simd) * splat_.weight;
                let mut start = splat(simd, first as f32 * painter.distance).max(near).min(far);
                for sheet in first..=last {
                    let end = splat(simd, (sheet + 1) as f32 * painter.distance).max(near).min(far);
                    let middle = (start + end) * 0.5;
                    let weight = match kernel {
                        FootprintKernel::Bilinear => crossing.bilinear(simd, middle),
                        other => crossing.weight(simd, other, middle),
                    };
                    // Values are divided by weights: lengths, which may be 0, must not be in both.
                    let whole = if channels == 2 { weight } else { weight * factor * (end - start) };
                    start = end;
                    let section = Section { whole, reach: None, gradient: None };
                    self.add_section(simd, [sheet as usize, number], section, carried);
                }
            }
        }
    }

    /// Depths between which the rays of a block pass through a sheet parallel to the image, clamped to the rays' ends.
    #[inline(always)]
    pub(super) fn faces<S: Simd>(&self, simd: S, number: usize, sheet: u32) -> [f32x16<S>; 2] {
        let block = &self.blocks[number];
        let (near, far) = (block.near.load(simd), block.far.load(simd));
        let face = self.painter.distance;
        let start = splat(simd, sheet as f32 * face).max(near).min(far);
        let end = splat(simd, (sheet + 1) as f32 * face).max(near).min(far);
        [start, end]
    }

    /// Adds a section to a sheet of a block.
    #[inline(always)]
    pub(super) fn add_section<S: Simd>(
        &mut self,
        simd: S,
        [sheet, number]: [usize; 2],
        section: Section<S>,
        (value, optics): (f32, [f32; 4]),
    ) {
        let slot = sheet & (self.painter.ring as usize - 1);
        let at = self.place_of(slot, number);
        let channels = &mut self.sheets[at..at + self.channels];
        if self.channels != MixtureChannels::SLOPED_MEAN {
            add(simd, channels, section.whole, value, optics);
        }
        match (channels, section.reach) {
            ([_, to_back, to_front], Some(reach)) => {
                // A sheet that is covered all through cannot be covered any further.
                let is_open = self.filled[slot] >> number & 1 == 0;
                if is_open && covers_all(simd, [to_back, to_front], reach) {
                    self.filled[slot] |= 1 << number;
                }
            }
            ([_, to_back, to_front, x, y, z], Some(reach)) => {
                cover(simd, [to_back, to_front], reach);
                add_slope(simd, [x, y, z], &section, value);
            }
            ([_, to_back, to_front, mixture @ ..], Some(reach)) if mixture.len() > 3 => {
                cover(simd, [to_back, to_front], reach);
                let channels = &mut self.sheets[at..at + self.channels];
                mix(simd, channels, &section, (value, optics));
            }
            _ => {}
        }
        self.touched[slot] |= 1 << number;
    }

    /// Composites a sheet, and clears it. A function of its own: a call is for a sheet, and it is compiled once.
    #[inline(never)]
    pub(super) fn finish_sheet<S: Simd>(&mut self, simd: S, sheet: u32) {
        simd.vectorize(
            #[inline(always)]
            || self.finish_here(simd, sheet),
        );
    }

    #[inline(always)]
    fn finish_here<S: Simd>(&mut self, simd: S, sheet: u32) {
        let painter = self.painter;
        let of_image = painter.buffers == Buffers::Image;
        let slot = if of_image { (sheet & (painter.ring - 1)) as usize } else { 0 };
        let mut touched = std::mem::take(&mut self.touched[slot]);
        self.filled[slot] = 0;
        let channels = self.channels;
        while touched != 0 {
            let number = touched.trailing_zeros() as usize;
            touched &= touched - 1;
            let at = self.place_of(slot, number);
            let block = &self.blocks[number];
            let (length, part) = if of_image {
                let [from, to] = self.faces(simd, number, sheet);
                ((to - from) * block.stretch.load(simd), [from, to])
            } else {
                let mut depth = splat(simd, 0.0);
                if let Some((axis, layers)) = painter.layers {
                    let [from, step] = block.index.map(|v| v[axis].load(simd));
                    let flat = step.abs().simd_lt(splat(simd, 1e-12));
                    depth = (splat(simd, layers[sheet as usize] as f32) - from) / pick(flat, splat(simd, 1e-12), step);
                }
                // Weights of a sheet sum to its length along the ray.
                (if channels == 2 { self.sheets[at + 1].load(simd) } else { splat(simd, 1.0) }, [depth; 2])
            };
            let sheet = of_image.then_some(sheet as usize);
            self.composite(simd, [number, at], sheet, length, part);
            self.sheets[at..at + channels].fill(Lanes::ZERO);
        }
        self.sighted.clear(slot);
    }
}

/// Takes note of what a support covers of a sheet: how far its front is from the sheet's back, and its back from the sheet's front.
#[inline(always)]
fn cover<S: Simd>(simd: S, [to_back, to_front]: [&mut Lanes; 2], [[start, end], [enter, leave]]: [[f32x16<S>; 2]; 2]) {
    let zero = splat(simd, 0.0);
    let (front, back) = (enter.max(start), leave.min(end));
    let covered = front.simd_lt(back);
    *to_back = Lanes::new(to_back.load(simd).max(pick(covered, end - front, zero)));
    *to_front = Lanes::new(to_front.load(simd).max(pick(covered, back - start, zero)));
}

/// Takes note of what a support covers of a sheet, and returns true if nothing of it is left uncovered on any of the rays.
#[inline(always)]
pub(super) fn covers_all<S: Simd>(simd: S, [to_back, to_front]: [&mut Lanes; 2], reach: [[f32x16<S>; 2]; 2]) -> bool {
    cover(simd, [to_back, to_front], reach);
    let [[start, end], _] = reach;
    let all = end - start;
    (to_back.load(simd).simd_ge(all) & to_front.load(simd).simd_ge(all)).all_true()
}

/// Adds the gradient of a value.
#[inline(always)]
fn add_slope<S: Simd>(simd: S, sums: [&mut Lanes; 3], section: &Section<S>, value: f32) {
    let Some(gradient) = section.gradient else { return };
    for (sum, slope) in sums.into_iter().zip(gradient) {
        *sum = Lanes::new(sum.load(simd) + slope * value);
    }
}

/// Adds a section to the channels of a mixture, but for what is covered, and of a sum but for its value: the gradient of the sum, or a mean and its gradient, and weights
/// and colours.
#[inline(always)]
fn mix<S: Simd>(simd: S, channels: &mut [Lanes], section: &Section<S>, (value, color): (f32, [f32; 4])) {
    let is_plain = channels.len() == MixtureChannels::PLAIN;
    match (<&mut [Lanes; MixtureChannels::SLOPED_MEAN]>::try_from(&mut *channels), section.gradient) {
        (Ok(mean), Some(gradient)) => sloped_mean::add(simd, mean, section.whole, gradient, value),
        (Err(_), Some(_)) => {
            if let [_, _, _, x, y, z, ..] = &mut *channels {
                add_slope(simd, [x, y, z], section, value);
            }
        }
        _ => {}
    }
    let sums = &mut channels[if is_plain { 3 } else { 6 }..];
    if let [weight, r, g, b, ..] = sums {
        *weight = Lanes::new(weight.load(simd) + section.whole);
        for (sum, light) in [r, g, b].into_iter().zip(color) {
            *sum = Lanes::new(sum.load(simd) + section.whole * light);
        }
    }
}

/// Adds a section of a kernel to a sheet: a value, and its weight where that is divided out, or emission and optical depth.
#[inline(always)]
pub(super) fn add<S: Simd>(simd: S, sheet: &mut [Lanes], section: f32x16<S>, value: f32, optics: [f32; 4]) {
    if let [sum, weight] = sheet {
        *sum = Lanes::new(sum.load(simd) + section * value);
        *weight = Lanes::new(weight.load(simd) + section);
    } else if let [r, g, b, tau] = sheet {
        *r = Lanes::new(r.load(simd) + section * optics[0]);
        *g = Lanes::new(g.load(simd) + section * optics[1]);
        *b = Lanes::new(b.load(simd) + section * optics[2]);
        *tau = Lanes::new(tau.load(simd) + section * optics[3]);
    } else if let [sum, ..] = sheet {
        *sum = Lanes::new(sum.load(simd) + section * value);
    }
}
