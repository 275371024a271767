//! Weights of filters of four taps along an axis, at sixteen places.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};
use vr_core::Filter;
use vr_core::filter::{GAUSSIAN_RADIUS, GAUSSIAN_SIGMA};

use super::{Cells, Lanes, opacity_of_depth, pick, splat};

/// Weights along each axis of the four voxels that the taps of sixteen places lie on.
pub type AxisWeights = [[Lanes; 4]; 3];

/// Writes the weights of a filter of four taps at places in a lattice with these last cells.
///
/// Its own function: there is one for all types of voxels.
///
/// # Panics
/// Panics under a filter of fewer taps: a bug in the caller.
#[inline(never)]
pub(super) fn tap_weights<S: Simd>(simd: S, filter: Filter, last_cell: [i32; 3], at: &Cells<S>, all: &mut AxisWeights) {
    simd.vectorize(
        #[inline(always)]
        || {
            for a in 0..3 {
                let w = weights(simd, filter, at.fraction[a]);
                all[a] = folded(simd, filter, at.cell[a], last_cell[a], w);
            }
        },
    );
}

/// Writes the derivatives, by the fractions, of the weights of a filter of four taps at places in a lattice with these last cells.
///
/// # Panics
/// Panics under a filter of fewer taps: a bug in the caller.
#[inline(never)]
pub(super) fn tap_slopes<S: Simd>(simd: S, filter: Filter, last_cell: [i32; 3], at: &Cells<S>, all: &mut AxisWeights) {
    simd.vectorize(
        #[inline(always)]
        || {
            for a in 0..3 {
                let d = derivatives(simd, filter, at.fraction[a]);
                all[a] = folded(simd, filter, at.cell[a], last_cell[a], d);
            }
        },
    );
}

/// Weights of the taps i − 1, i, i + 1, i + 2 at fractions of the cells [i, i + 1]: those of [`vr_core::filter::Taps4`], operation by operation (but
/// for the exponential of the Gaussian, which is good to 10⁻⁷).
///
/// # Panics
/// Panics under a filter of fewer taps: a bug in the caller.
#[inline(always)]
fn weights<S: Simd>(simd: S, filter: Filter, t: f32x16<S>) -> [f32x16<S>; 4] {
    let one = splat(simd, 1.0);
    match filter {
        Filter::BSpline => {
            let (sixth, u) = (splat(simd, 1.0 / 6.0), one - t);
            [
                sixth * u * u * u,
                sixth * (t * t * (t * 3.0 - 6.0) + 4.0),
                sixth * (u * u * (u * 3.0 - 6.0) + 4.0),
                sixth * t * t * t,
            ]
        }
        Filter::CatmullRom => {
            let half = t * 0.5;
            [
                half * (t * (splat(simd, 2.0) - t) - one),
                (t * t * (t * 3.0 - 5.0) + 2.0) * 0.5,
                half * (t * (splat(simd, 4.0) - t * 3.0) + one),
                half * t * (t - one),
            ]
        }
        Filter::Gaussian => {
            let ([a, b, c, d], _) = gaussian(simd, t);
            let norm = one / ((a + b) + (c + d));
            [a * norm, b * norm, c * norm, d * norm]
        }
        Filter::Nearest | Filter::Trilinear => unreachable!("filters of one or two taps have kernels of their own"),
    }
}

/// Derivatives of the weights by the fraction.
///
/// # Panics
/// Panics under a filter of fewer taps: a bug in the caller.
#[inline(always)]
fn derivatives<S: Simd>(simd: S, filter: Filter, t: f32x16<S>) -> [f32x16<S>; 4] {
    let one = splat(simd, 1.0);
    match filter {
        Filter::BSpline => {
            let (half, u) = (splat(simd, 0.5), one - t);
            [-half * u * u, half * t * (t * 3.0 - 4.0), half * u * (splat(simd, 4.0) - u * 3.0), half * t * t]
        }
        Filter::CatmullRom => {
            let half = splat(simd, 0.5);
            [
                half * (t * (splat(simd, 4.0) - t * 3.0) - one),
                half * t * (t * 9.0 - 10.0),
                half * (t * (splat(simd, 8.0) - t * 9.0) + one),
                half * t * (t * 3.0 - 2.0),
            ]
        }
        Filter::Gaussian => {
            // (w / S)' = (w' − (w / S) S') / S
            let (w, d) = gaussian(simd, t);
            let norm = one / ((w[0] + w[1]) + (w[2] + w[3]));
            let rise = (d[0] + d[1]) + (d[2] + d[3]);
            [
                (d[0] - w[0] * norm * rise) * norm,
                (d[1] - w[1] * norm * rise) * norm,
                (d[2] - w[2] * norm * rise) * norm,
                (d[3] - w[3] * norm * rise) * norm,
            ]
        }
        Filter::Nearest | Filter::Trilinear => unreachable!("filters of one or two taps have kernels of their own"),
    }
}

/// Weights of the Gaussian's taps before they are normalised, and their derivatives.
#[inline(always)]
fn gaussian<S: Simd>(simd: S, t: f32x16<S>) -> ([f32x16<S>; 4], [f32x16<S>; 4]) {
    const SCALE: f64 = 0.5 / (GAUSSIAN_SIGMA * GAUSSIAN_SIGMA);
    let (one, scale) = (splat(simd, 1.0), SCALE as f32);
    let edge = libm::exp(-SCALE * GAUSSIAN_RADIUS * GAUSSIAN_RADIUS) as f32;
    let (mut w, mut d) = ([one; 4], [one; 4]);
    for i in 0..4 {
        let x = t - (i as f32 - 1.0);
        let e = one - opacity_of_depth(simd, x * x * scale);
        w[i] = e - edge;
        d[i] = x * e * (-2.0 * scale);
    }
    (w, d)
}

/// First of the four voxels that the taps of each cell lie on; they are all of an axis of fewer than four.
#[inline(always)]
pub(super) fn base<S: Simd>(simd: S, cell: i32x16<S>, last_cell: i32) -> i32x16<S> {
    (cell - 1).max(i32x16::splat(simd, 0)).min(i32x16::splat(simd, (last_cell - 2).max(0)))
}

/// Weights of the four voxels from [`base`] on: taps beyond the box lie on the voxels in it that [`Filter::taps`] names.
#[inline(always)]
fn folded<S: Simd>(simd: S, filter: Filter, cell: i32x16<S>, last_cell: i32, w: [f32x16<S>; 4]) -> [Lanes; 4] {
    let at = |i: i32| i32x16::splat(simd, i);
    let (first, last) = (cell.simd_le(at(0)), cell.simd_ge(at(last_cell)));
    if (first | last).all_false() {
        return [Lanes::new(w[0]), Lanes::new(w[1]), Lanes::new(w[2]), Lanes::new(w[3])];
    }
    let inward = i32::from(filter == Filter::BSpline);
    let base = base(simd, cell, last_cell);
    let below = first.select(at(inward), cell - 1) - base;
    let above = last.select(at(last_cell + 1 - inward), cell + 2) - base;
    let taps = [below, cell - base, cell + 1 - base, above];
    let zero = splat(simd, 0.0);
    let mut folded = [Lanes::ZERO; 4];
    for p in 0..4 {
        let mut sum = zero;
        for i in 0..4 {
            sum += pick(taps[i].simd_eq(at(p as i32)), w[i], zero);
        }
        folded[p] = Lanes::new(sum);
    }
    folded
}
