//! Colours of voxels along steps, each inside a cell, with a bound of what they are off by.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};
use vr_core::ColorGrid;
use vr_kernels::vector::{Cells, Field, Lanes, Stage, splat};

use super::cell::{Along, CUBIC};
use super::color_change::{ColorChange, Places, U, load};

/// Colours of the voxels of a grid, by which those of the transfer function are multiplied.
#[derive(Clone, Copy, Debug)]
pub(super) struct VoxelTints<'a> {
    channels: [Field<'a, u16>; 3],
    /// Largest component of a colour of the transfer function.
    brightest: f32,
}

/// Error of an interpolated channel: some 16 roundings, and twelve of the place, as it changes by 1 along each axis of a cell at most.
const NOISE: f32 = 28.0 * U;
/// Bound of a channel's error outside its cell, per margin: twice its largest change along three axes, over the four margins that a step may reach beyond a face.
const BEYOND: f32 = 24.0;

impl<'a> VoxelTints<'a> {
    pub(super) fn new(colors: &'a ColorGrid, brightest: f64) -> Self {
        let channels = colors.channels().each_ref().map(Field::new);
        Self { channels, brightest: brightest as f32 * (1.0 + 1e-6) }
    }

    /// Multiplies colours by those of the places along steps, before they reflect light. The product of two parabolas is one but for two terms: see the README beside the folder.
    ///
    /// Its own function: most volumes have no colours.
    #[inline(never)]
    pub(super) fn multiply<S: Simd>(&self, simd: S, places: &Places, change: &mut ColorChange) {
        simd.vectorize(
            #[inline(always)]
            || self.multiply_inlined(simd, places, change, &mut Stage::default()),
        );
    }

    #[inline(always)]
    fn multiply_inlined<S: Simd>(&self, simd: S, places: &Places, change: &mut ColorChange, stage: &mut Stage<u16>) {
        let zero = splat(simd, 0.0);
        let (cell, middle, delta) = (load(simd, &places.cell), load(simd, &places.middle), load(simd, &places.delta));
        let length = places.length.load(simd);
        let half = [delta[0] * length * 0.5, delta[1] * length * 0.5, delta[2] * length * 0.5];
        let first = [middle[0] - half[0], middle[1] - half[1], middle[2] - half[2]];
        let last = [middle[0] + half[0], middle[1] + half[1], middle[2] + half[2]];
        let volume = (half[0] * half[1] * half[2]).abs() * 8.0;
        let share = 1.0 / f32::from(ColorGrid::WHITE);
        let cells = Cells {
            cell: [cell[0].to_int::<i32x16<S>>(), cell[1].to_int::<i32x16<S>>(), cell[2].to_int::<i32x16<S>>()],
            fraction: middle,
        };
        let factor_off = change.factor_off.load(simd);
        let (mut off, mut largest) = (zero, zero);
        for c in 0..3 {
            self.channels[c].fetch(simd, &cells, stage);
            let Along { begin, middle, end, third } =
                Along::new(simd, &self.channels[c], stage, [&first, &middle, &last]);
            let tint = [begin * share, middle * share, end * share];
            let factor = load(simd, &change.factor[c]);
            let size = factor[0].abs().max(factor[1].abs()).max(factor[2].abs());
            let (turned, faded) = ((factor[2] - factor[0]).abs(), (tint[2] - tint[0]).abs());
            let (turned_bulge, faded_bulge) = (bulge(factor), bulge(tint));
            let product = (turned * faded_bulge + turned_bulge * faded) * 0.2 + turned_bulge * faded_bulge * 0.25;
            // A parabola is nowhere larger than its places and its bulge.
            let (most, tint_most) = (size + turned_bulge, tint[0].max(tint[1]).max(tint[2]) + faded_bulge);
            let missed = third.abs() * share * volume * CUBIC;
            off = off.max(most * missed + factor_off * (tint_most + missed) + product);
            largest = largest.max(most + factor_off);
            for i in 0..3 {
                change.factor[c][i] = Lanes::new(factor[i] * tint[i]);
            }
        }
        change.factor_off = Lanes::new(off);
        let light = largest * self.brightest;
        change.blurred = Lanes::new(change.blurred.load(simd) + light * NOISE);
        change.beyond = Lanes::new(change.beyond.load(simd) + light * places.margin.load(simd) * BEYOND);
    }
}

/// Returns how far a parabola is from the line through its ends, in its middle.
#[inline(always)]
fn bulge<S: Simd>([begin, middle, end]: [f32x16<S>; 3]) -> f32x16<S> {
    (middle - (begin + end) * 0.5).abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error_bound::seeded::runner;
    use proptest::prelude::*;
    use vr_core::{Calibration, Filter, GridVolume, Placement, UniformGrid};
    use vr_kernels::vector::{LANES, baseline};

    /// Returns the largest share of the bound that colours are off by along a step through a cell, of 2³ voxels, that change by a parabola besides.
    fn share(voxels: &[[u16; 3]], [from, to]: [[f64; 3]; 2], factor: [f64; 3]) -> f64 {
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let values = UniformGrid::new([2; 3], vec![1u8; 8], placement, Calibration::default()).unwrap();
        let values = GridVolume::new(values.into(), Filter::Trilinear);
        let colors = ColorGrid::new(values, [0, 1, 2].map(|c| voxels.iter().map(|v| v[c]).collect())).unwrap();
        let lanes = |x: f64| Lanes([x as f32; LANES]);
        let places = Places {
            cell: [Lanes::ZERO; 3],
            middle: std::array::from_fn(|a| lanes(0.5 * (from[a] + to[a]))),
            length: lanes(1.0),
            margin: Lanes::ZERO,
            delta: std::array::from_fn(|a| lanes(to[a] - from[a])),
            whole: lanes(1e6),
        };
        let mut change = ColorChange { factor: [factor.map(lanes); 3], ..ColorChange::NONE };
        VoxelTints::new(&colors, 1.0).multiply(baseline(), &places, &mut change);
        let parabola = |[a, b, c]: [f64; 3], t: f64| a + (c - a) * t + (b - 0.5 * (a + c)) * 4.0 * t * (1.0 - t);
        let bound = f64::from(change.factor_off.0[3] + change.blurred.0[3]);
        let mut worst = 0.0f64;
        for k in 0..=40 {
            let t = f64::from(k) / 40.0;
            let tint = colors.color::<f64>(std::array::from_fn(|a| from[a] + t * (to[a] - from[a])));
            for c in 0..3 {
                let got = parabola(change.factor[c].map(|lanes| f64::from(lanes.0[3])), t);
                let off = (got - tint[c] * parabola(factor, t)).abs();
                // The parabola that is given and its product are rounded to f32.
                worst = worst.max((off - 4e-7).max(0.0) / bound);
            }
        }
        worst
    }

    #[test]
    fn colours_keep_their_bound() {
        let voxels = prop::collection::vec(prop::array::uniform3(any::<u16>()), 8);
        let place = || prop::array::uniform3(0.0f64..1.0);
        let factor = prop_oneof![Just([1.0; 3]), prop::array::uniform3(0.0f64..1.2)];
        let found = std::cell::RefCell::new(Vec::new());
        runner(4000, 33)
            .run(&(voxels, place(), place(), factor), |(voxels, from, to, factor)| {
                let share = share(&voxels, [from, to], factor);
                found.borrow_mut().push(share);
                prop_assert!(share <= 1.0, "{share}");
                Ok(())
            })
            .unwrap();
        // The bound is not far above the errors.
        let half = found.into_inner().iter().filter(|&&share| share > 0.3).count();
        assert!(half > 100, "{half}");
    }
}
