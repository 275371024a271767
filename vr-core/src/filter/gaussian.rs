//! A Gaussian of compact support, normalised.

use super::{Filter, Separable, Taps4};
use crate::real::Real;

/// Standard deviation in voxels: wide enough that the weights' sum is nearly constant, narrow enough for four taps.
pub const GAUSSIAN_SIGMA: f64 = 0.7;
/// Radius of the support in voxels.
pub const GAUSSIAN_RADIUS: f64 = 2.0;

/// The one-dimensional kernel: g(x) = e^(−x²/2σ²) − e^(−r²/2σ²) for |x| < r, divided by the sum of the four taps.
///
/// The subtrahend lets a tap fade to exactly zero where it leaves, so that the field is continuous; the division lets a
/// constant stay one.
#[derive(Clone, Copy, Debug)]
pub struct GaussianTaps;

/// Gaussian along each axis: smooths, never overshoots.
pub type Gaussian = Separable<GaussianTaps>;

/// The taps before normalisation, and their derivatives by `t`.
#[inline(always)]
fn raw<R: Real>(t: R) -> ([R; 4], [R; 4]) {
    let scale = R::from_f64(-0.5 / (GAUSSIAN_SIGMA * GAUSSIAN_SIGMA));
    let edge = R::from_f64(libm::exp(-0.5 * (GAUSSIAN_RADIUS / GAUSSIAN_SIGMA) * (GAUSSIAN_RADIUS / GAUSSIAN_SIGMA)));
    let x: [R; 4] = std::array::from_fn(|i| t - R::from_f64(i as f64 - 1.0));
    let e = x.map(|x| (scale * x * x).exp());
    let two_scale = scale + scale;
    (e.map(|e| e - edge), std::array::from_fn(|i| two_scale * x[i] * e[i]))
}

#[inline(always)]
fn sum<R: Real>(w: [R; 4]) -> R {
    (w[0] + w[1]) + (w[2] + w[3])
}

impl Taps4 for GaussianTaps {
    const FILTER: Filter = Filter::Gaussian;

    #[inline(always)]
    fn weights<R: Real>(t: R) -> [R; 4] {
        let (w, _) = raw(t);
        let norm = R::ONE / sum(w);
        w.map(|w| w * norm)
    }

    #[inline(always)]
    fn derivatives<R: Real>(t: R) -> [R; 4] {
        // (w / S)' = (w' − (w / S) S') / S
        let (w, d) = raw(t);
        let norm = R::ONE / sum(w);
        let ds = sum(d);
        std::array::from_fn(|i| (d[i] - w[i] * norm * ds) * norm)
    }
}
