//! Sections of the cubic spline near the rim of its support, to digits of their own.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_core::PointKernel;
use vr_kernels::vector::{pick, splat};

/// Largest section that is taken from here, in radii: a sixteenth of half the kernel's longest chord, which holds ¾ of its middle's value.
///
/// A chord's course is right to some 10⁻⁵ of its whole, so that sections above this are right to 5·10⁻⁴ of themselves. So are sections below it here, though the
/// kernel bends within some of them.
const MAX_SECTION: f32 = 0.75 * 2.546_479 / 16.0;

/// Nodes in (0, 1) and weights of the rule of Gauss and Legendre with six points.
const NODES: [[f32; 2]; 3] = [[0.238_619_2, 0.467_913_93], [0.661_209_4, 0.360_761_58], [0.932_469_5, 0.171_324_5]];

/// Integrals of the cubic spline over sections of sixteen chords.
///
/// Near the rim, at a distance ε from it, the kernel is 2C ε³: the difference of a chord's course at two places loses it beside the whole, though a mean depends on
/// nothing but ratios. Here ε comes of a product, ε (1 + t) = 1 − t² = h² (1 − u) (1 + u), where h is half the chord and u the part of it, and the kernel is
/// summed at six places of the section. Nothing cancels.
#[derive(Clone, Copy)]
pub(crate) struct RimSection<S: Simd> {
    /// ∫ W.
    pub(crate) whole: f32x16<S>,
    /// ∫ W'(t)/t, the factor of the chord's nearest place in the integral of the gradient.
    pub(crate) across: f32x16<S>,
    /// ∫ z W'(t)/t: the integral of the gradient along the chord.
    pub(crate) along: f32x16<S>,
}

impl<S: Simd> RimSection<S> {
    /// The sections between parts u of chords that are 2 `half` long, in radii; both parts within [−1, 1] and in order.
    #[inline(always)]
    pub(crate) fn between(simd: S, half: f32x16<S>, [from, to]: [f32x16<S>; 2]) -> Self {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let (middle, reach) = ((from + to) * 0.5, (to - from) * 0.5);
        let square = half * half;
        let mut sums = [zero; 3];
        for [node, weight] in NODES {
            for side in [-node, node] {
                let u = middle + reach * side;
                let room = square * ((one - u) * (one + u)).max(zero);
                let t = (one - room).max(zero).sqrt();
                let rest = room / (one + t);
                let bend = (splat(simd, 0.5) - t).max(zero);
                let slope = (bend * bend * 24.0 - rest * rest * 6.0) / t.max(splat(simd, 1e-6));
                sums[0] += (rest * rest * rest * 2.0 - bend * bend * bend * 8.0) * weight;
                sums[1] += slope * weight;
                sums[2] += slope * u * weight;
            }
        }
        let length = half * reach * PointKernel::CubicSpline.at(0.0) as f32;
        let [whole, across, along] = sums;
        Self { whole: whole * length, across: across * length, along: along * length * half }
    }

    /// Returns the sections in the place of differences of courses, where these are small; `None` where none is.
    #[inline(always)]
    pub(crate) fn instead_of(simd: S, whole: f32x16<S>, half: f32x16<S>, parts: [f32x16<S>; 2]) -> Option<Self> {
        let max = splat(simd, MAX_SECTION);
        let found = whole.simd_lt(max) & parts[0].simd_lt(parts[1]);
        if found.any_true() { Some(Self::between(simd, half, parts)) } else { None }
    }

    /// Takes a number of these sections where the course's is small, and the other elsewhere.
    #[inline(always)]
    pub(crate) fn pick(simd: S, whole: f32x16<S>, own: f32x16<S>, other: f32x16<S>) -> f32x16<S> {
        pick(whole.simd_lt(splat(simd, MAX_SECTION)), own, other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::Profile;
    use fearless_simd::{Level, dispatch};

    #[test]
    fn sections_near_rims_are_what_quadrature_gives_relative_to_themselves() {
        let Profile::Radial(radial) = Profile::point(PointKernel::CubicSpline) else { unreachable!("it is") };
        let (mut worst, mut small, mut seen) = ([0.0f64; 3], f64::INFINITY, 0);
        // Distances of chords from the rim, and of sections' ends from those of chords, down to a ten-thousandth.
        for i in 0..=40 {
            let room = libm::pow(10.0, -f64::from(i) / 10.0);
            let b = 1.0 - room;
            let half = (room * (1.0 + b)).sqrt() as f32;
            for k in 0..=40 {
                for l in 0..=20 {
                    let from = 1.0 - 2.0 * libm::pow(10.0, -f64::from(k) / 10.0);
                    let [u, v] = [from, from + (1.0 - from) * f64::from(l + 1) / 21.0].map(|x| x as f32);
                    let [from, to] = [u, v].map(|u| f64::from(u) * f64::from(half));
                    let want = radial.section(b, from, to);
                    if want >= f64::from(MAX_SECTION) {
                        continue;
                    }
                    let found = dispatch!(Level::new(), simd => {
                        let found = RimSection::between(simd, splat(simd, half), [splat(simd, u), splat(simd, v)]);
                        [found.whole, found.across, found.along].map(|x| f64::from(x.to_array()[7]))
                    });
                    let turn = radial.slope_section(b, from, to);
                    let rise = radial.at(b.hypot(to)) - radial.at(b.hypot(from));
                    // Slopes by what there is of them, of either sign.
                    let scale = radial.at(b.hypot(from)).max(radial.at(b.hypot(to)));
                    let errors = [
                        (found[0] - want) / want,
                        b * (found[1] - turn) / (b * turn).abs().max(scale),
                        (found[2] - rise) / scale,
                    ];
                    for (worst, error) in worst.iter_mut().zip(errors) {
                        *worst = worst.max(error.abs());
                    }
                    (small, seen) = (small.min(want), seen + 1);
                }
            }
        }
        println!("{worst:?}, down to {small:e}, {seen} sections");
        // The rule leaves 3·10⁻⁴ where the kernel bends within a section; f32 knows the place of a rim to 10⁻⁷, a thousandth of a ten-thousandth. Of a slope
        // along the chord, which is a difference, that leaves six sevenths where the kernel is 10⁻²⁰ or less.
        assert!(
            small < 1e-15 && worst[0] < 2.3e-3 && worst[1] < 1.8e-3 && worst[2] < 0.22,
            "{worst:?}, down to {small:e}"
        );
    }
}
