//! Radial kernels of grids evaluated in the middle of sheets parallel to the image, by formula instead of by tables of sections.
//!
//! Along a ray, the squared distance from a voxel is quadratic in the sheet's number. A Gaussian therefore follows from that of the sheet before by a ratio, and the
//! ratio by a constant factor: two multiplications a sheet, where nothing cuts the rays. Where rays are parallel and the kernel is a ball in world space, the
//! Gaussian is a factor for each ray times a factor for each sheet: one multiplication.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_kernels::vector::{LANES, Lanes, exp, pick, splat};

use crate::kernel::{Gaussian, RadialWeight};
use crate::splat::Splat;

use super::Tile;
use super::footprint::{Nearest, parallel_square};
use super::sighted::SightedBlocks;

/// Number of channels of a sheet of values: Σ w f and Σ w.
const CHANNELS: usize = 2;

/// Largest exponent for which a Gaussian is computed from that of the sheet before: rounding of the exponent is a relative error of 40·2⁻²⁴, which grows with
/// each sheet.
const MAX_EXPONENT: f32 = 40.0;

/// Sheets that a splat reaches.
#[derive(Clone, Copy)]
struct Reached {
    /// First and last sheet that the kernel's support overlaps.
    all: [u32; 2],
    /// First sheet whose middle lies in the support where nothing cuts it, and the one behind the last.
    uncut: [u32; 2],
}

impl Tile<'_> {
    /// Adds a splat's weight in the middle of each sheet, and its value times that weight, to those blocks of `takers` that are not dark.
    #[inline(always)]
    pub(super) fn add_middles<S: Simd>(
        &mut self,
        simd: S,
        weight: RadialWeight,
        at: &Splat,
        (mut takers, blocks): (u64, SightedBlocks),
        [first, last]: [u32; 2],
    ) {
        let painter = self.painter;
        let half = painter.view.half_depth() as f32 / at.scale;
        // Sheet k's middle lies k + ½ sheets behind the base. `as` saturates, and rounds down.
        let [from, to] = [at.place[2] - half, at.place[2] + half].map(|z| (z * painter.per_distance + 0.5) as u32);
        let reached = Reached { all: [first, last], uncut: [from.max(first), to.min(last + 1)] };
        let factors = self.sheet_factors(simd, weight, at, reached.uncut);
        let mut touched = 0u64;
        while takers != 0 {
            let number = takers.trailing_zeros() as usize;
            takers &= takers - 1;
            if !self.takes_in_sight(simd, number, blocks, [first, last]) {
                continue;
            }
            if let (RadialWeight::Gaussian(gaussian), Some(factors)) = (weight, &factors)
                && self.is_uncut(number, reached.all)
            {
                touched |= self.add_round(simd, gaussian, number, at, factors, reached.uncut);
                continue;
            }
            let Some(nearest) = Nearest::new(simd, &self.axes, &self.blocks[number], at) else { continue };
            touched |= 1 << number;
            match weight {
                RadialWeight::Gaussian(gaussian) => self.add_gaussian(simd, gaussian, number, at, &nearest, reached),
                RadialWeight::Cone => self.add_cone(simd, number, at, &nearest, reached),
            }
        }
        for sheet in first..=last {
            self.touched[sheet as usize & (painter.ring as usize - 1)] |= touched;
        }
    }

    /// Factors of a Gaussian in the middle of sheets, if they are the same for all rays and fit into one vector.
    #[inline(always)]
    fn sheet_factors<S: Simd>(
        &self,
        simd: S,
        weight: RadialWeight,
        at: &Splat,
        [first, end]: [u32; 2],
    ) -> Option<[f32; LANES]> {
        let (RadialWeight::Gaussian(Gaussian { rate, .. }), Some(square)) = (weight, self.axes.round()) else {
            return None;
        };
        if end > first + LANES as u32 {
            return None;
        }
        let distance = self.painter.distance;
        let number = Lanes(std::array::from_fn(|i| i as f32 + 0.5)).load(simd);
        let ahead = (number + first as f32) * distance - at.place[2];
        let along = rate * square * at.scale * at.scale;
        Some((exp(simd, ahead * ahead * -along) * at.weight).to_array())
    }

    /// Adds a Gaussian as a factor of each ray's distance times a factor of each sheet's depth. Returns the block's bit if any ray passes through the support.
    #[inline(always)]
    fn add_round<S: Simd>(
        &mut self,
        simd: S,
        gaussian: Gaussian,
        number: usize,
        at: &Splat,
        factors: &[f32; LANES],
        [first, end]: [u32; 2],
    ) -> u64 {
        let zero = splat(simd, 0.0);
        let square = self.axes.square()[0] * at.scale * at.scale;
        let square = parallel_square(simd, &self.blocks[number], at, square);
        let inside = square.simd_lt(splat(simd, 1.0));
        if !inside.any_true() {
            return 0;
        }
        let across = pick(inside, exp(simd, square * -gaussian.rate), zero);
        let lowered = gaussian.edge * at.weight;
        for (sheet, factor) in (first..end).zip(factors) {
            self.add_weight(simd, [sheet as usize, number], (across * *factor - lowered).max(zero), at.value);
        }
        1 << number
    }

    /// Adds a Gaussian, from sheet to sheet by a ratio where nothing cuts the rays and exponents are small.
    #[inline(always)]
    fn add_gaussian<S: Simd>(
        &mut self,
        simd: S,
        Gaussian { rate, edge }: Gaussian,
        number: usize,
        at: &Splat,
        nearest: &Nearest<S>,
        reached: Reached,
    ) {
        let zero = splat(simd, 0.0);
        // The exponent is `across`, by the distance of the ray, plus `along` times the squared depth from the ray's nearest point.
        let speed = self.blocks[number].speed.load(simd) * at.scale;
        let (across, along) = (nearest.square * rate, speed * speed * rate);
        let lowered = edge * at.weight;
        let distance = self.painter.distance;
        let [first, end] = reached.uncut;
        if self.is_uncut(number, reached.all) {
            let ahead = splat(simd, (first as f32 + 0.5) * distance) - nearest.depth;
            let exponent = across + along * (ahead * ahead);
            let turn = along * ((ahead * 2.0 + distance) * distance);
            let inside = nearest.square.simd_lt(splat(simd, 1.0));
            let largest = exponent.max(turn.abs());
            if !(inside & largest.simd_gt(splat(simd, MAX_EXPONENT))).any_true() {
                // Rays outside the support start at 0, so that no ratio changes them.
                let mut weight = pick(inside, exp(simd, -exponent) * at.weight, zero);
                let mut ratio = exp(simd, -turn);
                let fall = exp(simd, along * (-2.0 * distance * distance));
                for sheet in first..end {
                    self.add_weight(simd, [sheet as usize, number], (weight - lowered).max(zero), at.value);
                    weight *= ratio;
                    ratio *= fall;
                }
                return;
            }
        }
        for sheet in reached.all[0]..=reached.all[1] {
            let ahead = self.middle(simd, number, sheet) - nearest.depth;
            let weight = exp(simd, -(across + along * (ahead * ahead))) * at.weight;
            self.add_weight(simd, [sheet as usize, number], (weight - lowered).max(zero), at.value);
        }
    }

    /// Adds a cone.
    #[inline(always)]
    fn add_cone<S: Simd>(&mut self, simd: S, number: usize, at: &Splat, nearest: &Nearest<S>, reached: Reached) {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let speed = self.blocks[number].speed.load(simd) * at.scale;
        for sheet in reached.all[0]..=reached.all[1] {
            let ahead = (self.middle(simd, number, sheet) - nearest.depth) * speed;
            // The squared distance of a ray may be rounded to a negative number.
            let distance = (nearest.square + ahead * ahead).max(zero).sqrt();
            let weight = (one - distance).max(zero) * at.weight;
            self.add_weight(simd, [sheet as usize, number], weight, at.value);
        }
    }

    /// True if nothing cuts any ray of a block within some sheets.
    #[inline(always)]
    pub(super) fn is_uncut(&self, number: usize, [first, last]: [u32; 2]) -> bool {
        let [from, to] = self.blocks[number].uncut;
        let distance = self.painter.distance;
        from <= first as f32 * distance && (last + 1) as f32 * distance <= to
    }

    /// Depths of the middle of a sheet, of the part of it that each ray passes through.
    #[inline(always)]
    fn middle<S: Simd>(&self, simd: S, number: usize, sheet: u32) -> f32x16<S> {
        let [start, end] = self.faces(simd, number, sheet);
        (start + end) * 0.5
    }

    /// Adds a weight, and a value times that, to a sheet of a block.
    #[inline(always)]
    fn add_weight<S: Simd>(&mut self, simd: S, [sheet, number]: [usize; 2], weight: f32x16<S>, value: f32) {
        let slot = sheet & (self.painter.ring as usize - 1);
        let place = self.place_of(slot, number);
        if let [sum, weights] = &mut self.sheets[place..place + CHANNELS] {
            *sum = Lanes::new(sum.load(simd) + weight * value);
            *weights = Lanes::new(weights.load(simd) + weight);
        }
    }
}
