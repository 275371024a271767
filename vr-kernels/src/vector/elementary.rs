//! Logarithm, exponential and what is made of them, of sixteen numbers, by our own polynomials: the same bits on every machine.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};

use super::{pick, splat};

/// ln 2 in two parts, the first with so few bits that a small whole multiple of it is exact (Cody & Waite 1980).
const LN2_HIGH: f32 = 0.693_359_4;
const LN2_LOW: f32 = -2.121_944_4e-4;

/// ln x for normal positive x, to 10⁻⁷ relative to max(1, |ln x|).
///
/// x = 2^e·m with m in [√½, √2); ln m by the polynomial of Cephes' `logf` (Moshier 1989).
#[inline(always)]
pub fn ln<S: Simd>(simd: S, x: f32x16<S>) -> f32x16<S> {
    // Exponent and mantissa, split at √½ rather than at 1.
    let bits: i32x16<S> = x.bitcast();
    let shifted = bits - 0x3f35_04f3;
    let e = shifted >> 23;
    let m: f32x16<S> = (bits - (e << 23)).bitcast();
    let e: f32x16<S> = e.to_float();
    let f = m - 1.0;
    let z = f * f;
    let mut p = splat(simd, 7.037_683_6e-2);
    for c in [
        -1.151_461e-1,
        1.167_699_9e-1,
        -1.242_014_1e-1,
        1.424_932_3e-1,
        -1.666_805_8e-1,
        2.000_071_5e-1,
        -2.499_999_4e-1,
        0.333_333_3,
    ] {
        p = p * f + c;
    }
    let y = p * f * z + e * LN2_LOW - z * 0.5;
    (f + y) + e * LN2_HIGH
}

/// −ln(1 − α) for α in [0, 1): the optical depth of an opacity, to a few units in the last place down to the smallest.
///
/// 1 − α is rounded; the quotient makes up for that (Kahan's method).
#[inline(always)]
pub fn depth_of_opacity<S: Simd>(simd: S, alpha: f32x16<S>) -> f32x16<S> {
    let one = splat(simd, 1.0);
    let clear = one - alpha;
    let rounded = one - clear;
    let tiny = rounded.simd_eq(splat(simd, 0.0));
    let divisor = pick(tiny, one, rounded);
    let tau = -ln(simd, clear.max(splat(simd, f32::MIN_POSITIVE))) * (alpha / divisor);
    pick(tiny, alpha, tau)
}

/// 1 − e^(−τ) for τ ≥ 0: the opacity of an optical depth, to a few units in the last place down to the smallest.
///
/// e^(−τ) = 2^n·e^f with |f| ≤ ½ ln 2, and e^f − 1 by a polynomial: so nothing cancels where τ is small.
#[inline(always)]
pub fn opacity_of_depth<S: Simd>(simd: S, tau: f32x16<S>) -> f32x16<S> {
    // Beyond 2⁻²⁵ nothing of the exponential is left.
    let tau = tau.min(splat(simd, 20.0));
    let n = (tau * std::f32::consts::LOG2_E + 0.5).to_int::<i32x16<S>>();
    let whole: f32x16<S> = n.to_float();
    // f = n ln 2 − τ
    let f = (whole * LN2_HIGH - tau) + whole * LN2_LOW;
    let scale: f32x16<S> = ((i32x16::splat(simd, 127) - n) << 23).bitcast();
    (splat(simd, 1.0) - scale) - scale * exp_minus_one(simd, f)
}

/// e^f − 1 for |f| ≤ ½ ln 2.
#[inline(always)]
fn exp_minus_one<S: Simd>(simd: S, f: f32x16<S>) -> f32x16<S> {
    let mut p = splat(simd, 1.987_569_1e-4);
    for c in [1.398_199_9e-3, 8.333_452e-3, 4.166_579_6e-2, 1.666_666_5e-1, 0.5] {
        p = p * f + c;
    }
    p * (f * f) + f
}

/// e^x, with a relative error of at most 1.2·10⁻⁷. x is clamped to [−87, 87], where the result is a normal number.
///
/// e^x = 2^n·e^f with |f| ≤ ½ ln 2, and e^f − 1 by a polynomial.
#[inline(always)]
pub fn exp<S: Simd>(simd: S, x: f32x16<S>) -> f32x16<S> {
    // 1.5·2²³: a number added to it is rounded to an integer, which the last bits of the sum hold.
    const ROUNDER: f32 = 12_582_912.0;
    let x = x.max(splat(simd, -87.0)).min(splat(simd, 87.0));
    let rounded = x * std::f32::consts::LOG2_E + ROUNDER;
    let whole = rounded - ROUNDER;
    let f = (x - whole * LN2_HIGH) - whole * LN2_LOW;
    // The last bits of `rounded` are n; the shift drops all bits before them.
    let n: i32x16<S> = rounded.bitcast();
    let scale: f32x16<S> = ((n + 127) << 23).bitcast();
    scale + scale * exp_minus_one(simd, f)
}

/// The source weight (1 − e^(−τ))/τ of optical depths τ ≥ 0 whose opacities are known: the part of the light of a homogeneous step that
/// leaves it; 1 where nothing absorbs.
#[inline(always)]
pub fn source_weight<S: Simd>(simd: S, tau: f32x16<S>, alpha: f32x16<S>) -> f32x16<S> {
    let one = splat(simd, 1.0);
    let clear = tau.simd_le(splat(simd, 0.0));
    pick(clear, one, alpha / pick(clear, one, tau))
}

/// Largest optical depth at which six terms of a series are good to the last bits: the next is τ⁶/5040.
const THIN: f32 = 0.25;

/// The source weight and the opacity of optical depths τ ≥ 0, without an exponential where all of them are thin.
#[inline(always)]
pub fn source_weight_and_opacity<S: Simd>(simd: S, tau: f32x16<S>) -> (f32x16<S>, f32x16<S>) {
    if !tau.simd_gt(splat(simd, THIN)).any_true() {
        let mut weight = splat(simd, -1.0 / 720.0);
        for c in [1.0 / 120.0, -1.0 / 24.0, 1.0 / 6.0, -0.5, 1.0] {
            weight = weight * tau + c;
        }
        return (weight, tau * weight);
    }
    let alpha = opacity_of_depth(simd, tau);
    (source_weight(simd, tau, alpha), alpha)
}

/// Light and opacity of homogeneous steps `ratio` times as long: light grows with opacity and, where nothing absorbs, with the length.
#[inline(always)]
pub fn step_of_thickness<S: Simd>(simd: S, [r, g, b, alpha]: [f32x16<S>; 4], ratio: f32x16<S>) -> [f32x16<S>; 4] {
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let part = opacity_of_depth(simd, depth_of_opacity(simd, alpha) * ratio);
    // A wall is opaque however thin.
    let part = pick(alpha.simd_ge(one) & ratio.simd_gt(zero), one, part);
    let clear = alpha.simd_le(zero);
    let grown = pick(clear, ratio, part / pick(clear, one, alpha));
    [r * grown, g * grown, b * grown, part]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::LANES;
    use fearless_simd::{Level, dispatch};

    #[test]
    fn opacity_and_depth_are_good_to_the_last_bits() {
        let (mut worst_opacity, mut worst_depth) = (0.0f64, 0.0f64);
        for i in 0..40_000 {
            let tau = libm::exp(f64::from(i) * 1e-3 - 36.0) as f32;
            let [alpha, back] = dispatch!(Level::new(), simd => {
                let tau = splat(simd, tau);
                let alpha = opacity_of_depth(simd, tau);
                [alpha[3], depth_of_opacity(simd, alpha)[5]]
            });
            let exact = -libm::expm1(-f64::from(tau));
            worst_opacity = worst_opacity.max((f64::from(alpha) - exact).abs() / exact);
            if alpha < 0.9 {
                let exact = -libm::log1p(-f64::from(alpha));
                worst_depth = worst_depth.max((f64::from(back) - exact).abs() / exact);
            }
        }
        // Four units in the last place.
        assert!(worst_opacity < 2.5e-7 && worst_depth < 2.5e-7, "{worst_opacity:e} {worst_depth:e}");
        let none = dispatch!(Level::new(), simd => [
            opacity_of_depth(simd, splat(simd, 0.0))[0], depth_of_opacity(simd, splat(simd, 0.0))[0],
        ]);
        assert_eq!(none, [0.0, 0.0]);
    }

    #[test]
    fn exponentials_are_good_to_the_last_bit() {
        let mut worst = 0.0f64;
        for i in -87_000..=87_000 {
            let x = i as f32 / 1000.0;
            let exact = libm::exp(f64::from(x));
            let got = dispatch!(Level::new(), simd => exp(simd, splat(simd, x)).to_array()[7]);
            worst = worst.max((f64::from(got) / exact - 1.0).abs());
        }
        // One unit in the last place; the largest error found is 8·10⁻⁸.
        assert!(worst < 1.2e-7, "{worst:e}");
    }

    #[test]
    fn source_weights_are_good_to_the_last_bits_thin_or_thick() {
        let mut worst = 0.0f64;
        for i in 0..30_000 {
            let tau = libm::exp(f64::from(i) * 1e-3 - 26.0) as f32;
            let exact = f64::from(tau);
            let exact = [vr_core::optics::source_weight(exact), vr_core::optics::opacity_of_depth(exact)];
            // The series and the exponential: one lane decides for all.
            for thick in [0.0, 1.0] {
                let mut all = [tau; LANES];
                all[3] = thick;
                let got = dispatch!(Level::new(), simd => {
                    let tau = f32x16::load_array_ref(simd, &all);
                    let (weight, alpha) = source_weight_and_opacity(simd, tau);
                    [weight[5], alpha[5], source_weight(simd, tau, opacity_of_depth(simd, tau))[5]]
                });
                for (got, exact) in got.into_iter().zip([exact[0], exact[1], exact[0]]) {
                    worst = worst.max((f64::from(got) / exact - 1.0).abs());
                }
            }
        }
        // Five units in the last place: four of the exponential, one of the quotient.
        assert!(worst < 3e-7, "{worst:e}");
        let none = dispatch!(Level::new(), simd => {
            let zero = splat(simd, 0.0);
            [source_weight_and_opacity(simd, zero).0, source_weight(simd, zero, zero)].map(|w| w.to_array())
        });
        assert_eq!(none, [[1.0; LANES]; 2]);
    }

    #[test]
    fn steps_of_other_lengths_are_those_of_the_definition() {
        for alpha in [0.0f32, 1e-6, 0.25, 0.9, 1.0] {
            for ratio in [0.0f32, 1e-3, 0.5, 1.0, 3.0] {
                let step = [0.5 * alpha, 1.0, 2.0, alpha];
                let got = dispatch!(Level::new(), simd => {
                    step_of_thickness(simd, step.map(|x| splat(simd, x)), splat(simd, ratio)).map(|x| x[9])
                });
                let want = vr_core::optics::step_of_thickness(step.map(f64::from), ratio.into());
                for (got, want) in got.into_iter().zip(want) {
                    assert!((f64::from(got) - want).abs() <= 8e-7 * want, "{alpha} {ratio}: {got}, not {want}");
                }
            }
        }
    }
}
