//! Weighted means of points and their gradients, ray by ray, as a sheet sums them.
//!
//! The gradient of a mean m = Σwv / Σw is Σ∇w (v − m) / Σw. Beside the middle of a point another one that has only begun weighs next to nothing, and moves the mean
//! by as little: Σv∇w and m Σ∇w then share their first six digits. So values are differences from the one that weighs most so far (Chan, Golub & LeVeque 1983, *Algorithms
//! for computing the sample variance: analysis and recommendations*: shifted data), and all sums are as small as what they tell. Where one point reaches alone,
//! they are 0.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_kernels::vector::{Lanes, pick, splat};

use crate::point_mixture::MixtureChannels;

/// A mean and its gradient, along the view's axes.
pub(super) struct SlopedMean<S: Simd> {
    pub(super) value: f32x16<S>,
    pub(super) slope: [f32x16<S>; 3],
}

/// Adds a point's weight, its gradient and the point's value to the channels of a sheet; the sum of weights is not added here.
#[inline(always)]
pub(super) fn add<S: Simd>(
    simd: S,
    channels: &mut [Lanes; MixtureChannels::SLOPED_MEAN],
    weight: f32x16<S>,
    gradient: [f32x16<S>; 3],
    value: f32,
) {
    const AT: MixtureChannels = MixtureChannels::new(true, true);
    let (last, heaviest) = (channels[AT.base].load(simd), channels[AT.base + 1].load(simd));
    let heavier = weight.simd_gt(heaviest);
    let value = splat(simd, value);
    let base = pick(heavier, value, last);
    // Sums so far are differences from the last base.
    let (moved, off) = (last - base, value - base);
    let weights = channels[AT.weight].load(simd);
    channels[0] = Lanes::new(channels[0].load(simd) + (weights * moved + weight * off));
    for a in 0..3 {
        let thinning = channels[AT.thinning + a].load(simd);
        let slope = channels[AT.slope + a].load(simd);
        channels[AT.slope + a] = Lanes::new(slope + (thinning * moved + gradient[a] * off));
        channels[AT.thinning + a] = Lanes::new(thinning + gradient[a]);
    }
    channels[AT.base] = Lanes::new(base);
    channels[AT.base + 1] = Lanes::new(pick(heavier, weight, heaviest));
}

/// Mean and gradient of what the channels of a sheet hold, given the sum of weights, or 1 where that is 0.
#[inline(always)]
pub(super) fn of<S: Simd>(
    simd: S,
    channels: &[Lanes; MixtureChannels::SLOPED_MEAN],
    weights: f32x16<S>,
) -> SlopedMean<S> {
    const AT: MixtureChannels = MixtureChannels::new(true, true);
    let off = channels[0].load(simd) / weights;
    let mut slope = [off; 3];
    for a in 0..3 {
        let turn = channels[AT.slope + a].load(simd) - off * channels[AT.thinning + a].load(simd);
        slope[a] = turn / weights;
    }
    SlopedMean { value: channels[AT.base].load(simd) + off, slope }
}
