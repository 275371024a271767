//! The field of a filter of four taps per axis in one cell along a ray, interpolated at Chebyshev points, with a bound of what that misses.
//!
//! The B-spline and the Catmull-Rom cubic are polynomials of degree 9 there, which are met to rounding. The Gaussian is none: on the Bernstein ellipse of
//! parameter ρ the coordinates leave the real axis by at most y = b·|half|, b = (ρ − 1/ρ)/2. There a tap is
//! at most e^(y²/2σ²) times its real size, and the taps' sum is bounded from below by Poisson's sum over all of the lattice, less
//! the taps that the filter leaves out. Interpolation misses at most 4 M ρ^(−n)/(ρ − 1) where the field is no larger than M
//! (Trefethen, *Approximation Theory and Approximation Practice*, 2013, theorem 8.2).

use glam::DVec3;

use super::chebyshev::{LEBESGUE, interpolation};
use super::poly::Poly;
use crate::bound::Bound;
use crate::filter::{Filter, GAUSSIAN_RADIUS, GAUSSIAN_SIGMA, Lattice, Taps4};
use crate::voxel::Voxel;

/// Degree of the interpolation of the Gaussian: a gradient's square has twice that, the largest degree that there is.
const DEGREE: usize = 12;
/// Degree of a product of three cubics.
const CUBIC_DEGREE: usize = 9;

/// The field of a filter of four taps on a part of a cell, in stored units, less a base: polynomials of t from −1 to 1.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::field::InterpolatedCell;
/// use vr_core::filter::{CatmullRom, CatmullRomTaps, Lattice, Reconstruction};
///
/// let samples: Vec<f32> = (0..64).map(|i| (i % 7) as f32).collect();
/// let lattice = Lattice { samples: &samples[..], dims: [4; 3] };
/// let (middle, half) = (DVec3::new(1.5, 1.5, 1.5), DVec3::new(0.5, 0.3, -0.4));
/// let part = InterpolatedCell::new::<CatmullRomTaps, _>(&lattice, [1; 3], 3.0, 6.0, [middle, half], 0.0, false);
/// let want: f64 = CatmullRom::value(&lattice, (middle + half * 0.7).to_array());
/// assert!((3.0 + part.field.at(0.7) - want).abs() <= part.error.value());
/// ```
#[derive(Clone, Debug)]
pub struct InterpolatedCell {
    /// The field, less the base.
    pub field: Poly,
    /// Upper bound of what that is off by.
    pub error: Bound,
    /// The gradient per index step, and a bound of what each component is off by.
    pub gradient: Option<([Poly; 3], Bound)>,
}

impl InterpolatedCell {
    /// Interpolates on the part `middle ± half` (index space) of a cell whose samples, under the filter's taps, are within `reach` of `base`; `reach` is not 0. The
    /// last Chebyshev coefficients of the field are left out as long as they are no more than `negligible`.
    pub fn new<K: Taps4, T: Voxel>(
        lattice: &Lattice<'_, T>,
        cell: [usize; 3],
        base: f64,
        reach: f64,
        [middle, half]: [DVec3; 2],
        negligible: f64,
        with_gradient: bool,
    ) -> Self {
        let samples = gather::<K, T>(lattice, cell, base);
        let is_cubic = K::FILTER != Filter::Gaussian;
        let degree = if is_cubic { CUBIC_DEGREE } else { DEGREE };
        let rule = interpolation(degree);
        let (mut values, mut slopes) = ([0.0; DEGREE + 1], [[0.0; DEGREE + 1]; 3]);
        for (j, &node) in rule.nodes.iter().enumerate() {
            let at = (middle + half * node).to_array();
            let place: [f64; 3] = std::array::from_fn(|a| at[a] - cell[a] as f64);
            let weights = place.map(K::weights::<f64>);
            values[j] = sum(&samples, weights.each_ref());
            if with_gradient {
                let derivatives = place.map(K::derivatives::<f64>);
                for a in 0..3 {
                    let taps = std::array::from_fn(|b| if a == b { &derivatives[b] } else { &weights[b] });
                    slopes[a][j] = sum(&samples, taps);
                }
            }
        }
        let noise = f64::EPSILON * reach;
        // Some twenty roundings of each weight, and the sum of 64 products.
        let rounding = 256.0 * LEBESGUE * noise;
        let (field, dropped) = rule.through(&values[..=degree], noise.max(negligible));
        let (missed, slopes_missed) = if is_cubic { (Bound::ZERO, Bound::ZERO) } else { remainder(half) };
        let error = missed * reach + rounding + dropped;
        let gradient = with_gradient.then(|| {
            let mut off = slopes_missed * reach + 8.0 * rounding;
            let gradient = slopes.map(|values| {
                let (slope, dropped) = rule.through(&values[..=degree], noise);
                off += dropped;
                slope
            });
            (gradient, off)
        });
        Self { field, error, gradient }
    }
}

/// The 64 values around a cell, less the base; x fastest.
fn gather<K: Taps4, T: Voxel>(lattice: &Lattice<'_, T>, cell: [usize; 3], base: f64) -> [f64; 64] {
    let index: [[usize; 4]; 3] = std::array::from_fn(|a| K::FILTER.taps(cell[a], lattice.dims[a]));
    std::array::from_fn(|i| {
        let sample: f64 = lattice.at(index[0][i & 3], index[1][i >> 2 & 3], index[2][i >> 4]);
        sample - base
    })
}

fn sum(samples: &[f64; 64], [x, y, z]: [&[f64; 4]; 3]) -> f64 {
    let line = |row: &[f64]| row[0] * x[0] + row[1] * x[1] + row[2] * x[2] + row[3] * x[3];
    let plane = |k: usize| (0..4).map(|j| y[j] * line(&samples[16 * k + 4 * j..][..4])).sum::<f64>();
    (0..4).map(|k| z[k] * plane(k)).sum()
}

/// e^(−x²/2σ²)
fn bell(x: f64) -> f64 {
    libm::exp(-0.5 * (x / GAUSSIAN_SIGMA) * (x / GAUSSIAN_SIGMA))
}

/// Bounds the error of interpolation of the field, and of a component of its gradient, per unit of the voxels' reach.
fn remainder(half: DVec3) -> (Bound, Bound) {
    let mut best = (Bound::UNKNOWN, Bound::UNKNOWN);
    for rho in [2.0f64, 3.0, 4.0, 5.5, 8.0, 11.0, 16.0, 24.0, 40.0, 80.0, 200.0] {
        let (a, b) = (0.5 * (rho + 1.0 / rho), 0.5 * (rho - 1.0 / rho));
        // Beyond the interval's ends the real part moves, too: by (a − 1) h.
        let axes = half.abs().to_array().map(|h| gains(b * h, (a - 1.0) * h));
        let gain = axes[0].0 * axes[1].0 * axes[2].0;
        // No weights' sum is below 1, so that the others may stand for those of all three axes.
        let slope = axes[0].1.max(axes[1].1).max(axes[2].1) * gain;
        let decay = 4.0 * rho.powi(-(DEGREE as i32)) / (rho - 1.0);
        best = (best.0.min(gain * decay), best.1.min(slope * decay));
    }
    best
}

/// Bounds Σ|wᵢ(z)| and Σ|wᵢ'(z)| of the four normalised taps, for real parts up to `beyond` outside the cell and imaginary parts up
/// to `y`.
fn gains(y: f64, beyond: f64) -> (Bound, Bound) {
    // Beyond these the bound below from below is none.
    if y > 1.25 || beyond > 0.75 {
        return (Bound::UNKNOWN, Bound::UNKNOWN);
    }
    let variance = GAUSSIAN_SIGMA * GAUSSIAN_SIGMA;
    let edge = bell(GAUSSIAN_RADIUS);
    // |g(x + iy)| = g(x) e^(y²/2σ²)
    let grow = libm::exp(0.5 * y * y / variance);
    // Poisson: Σ over all of the lattice = σ√(2π) (1 + 2 Σ e^(−2π²σ²m²) cos 2πmz); terms beyond m = 1 are below 10⁻⁹ here.
    let whole = GAUSSIAN_SIGMA * (2.0 * std::f64::consts::PI).sqrt();
    let ripple = 2.01 * libm::exp(-2.0 * std::f64::consts::PI * std::f64::consts::PI * variance);
    // Left out on either side: taps at distances from 2 − beyond on, one step apart.
    let left_out = 2.0 * grow * (bell(2.0 - beyond) + 1.05 * bell(3.0 - beyond));
    let smallest = whole * (1.0 - ripple * libm::cosh(2.0 * std::f64::consts::PI * y)) - left_out - 4.0 * edge;
    if smallest < 0.1 {
        return (Bound::UNKNOWN, Bound::UNKNOWN);
    }
    // Real sums are nowhere above σ√(2π) (1 + ripple) < 1.76; |x| g(x) ≤ σ/√e for each tap.
    let gain = (1.76 * grow + 4.0 * edge) / smallest;
    let raw_slopes = grow * (4.0 * 0.607 * GAUSSIAN_SIGMA + 1.76 * y) / variance;
    (Bound::new(gain.max(1.0)), Bound::new(raw_slopes * (1.0 + gain) / smallest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::{BSplineTaps, CatmullRomTaps, GaussianTaps, Reconstruction, Separable};

    /// Σ|wᵢ| and Σ|wᵢ'| at a complex point, straight from their definition.
    fn sizes(re: f64, im: f64) -> (f64, f64) {
        let variance = GAUSSIAN_SIGMA * GAUSSIAN_SIGMA;
        type C = (f64, f64);
        let mul = |a: C, b: C| (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0);
        let div = |a: C, b: C| {
            let n = b.0 * b.0 + b.1 * b.1;
            ((a.0 * b.0 + a.1 * b.1) / n, (a.1 * b.0 - a.0 * b.1) / n)
        };
        let bells: [C; 4] = std::array::from_fn(|i| {
            let x = re - (i as f64 - 1.0);
            let size = (-(x * x - im * im) / (2.0 * variance)).exp();
            let turn = -x * im / variance;
            (size * turn.cos(), size * turn.sin())
        });
        let raw = bells.map(|b| (b.0 - bell(GAUSSIAN_RADIUS), b.1));
        let slopes: [C; 4] =
            std::array::from_fn(|i| mul((-(re - (i as f64 - 1.0)) / variance, -im / variance), bells[i]));
        let add = |all: [C; 4]| all.iter().fold((0.0, 0.0), |s, x| (s.0 + x.0, s.1 + x.1));
        let (total, total_slope) = (add(raw), add(slopes));
        let size = |x: C| x.0.hypot(x.1);
        let weights = raw.map(|w| div(w, total));
        let of_slopes = (0..4).map(|i| {
            let w = mul(weights[i], total_slope);
            size(div((slopes[i].0 - w.0, slopes[i].1 - w.1), total))
        });
        (weights.iter().map(|&w| size(w)).sum(), of_slopes.sum())
    }

    #[test]
    fn gains_bound_the_weights_in_the_complex_plane() {
        let mut finite = 0;
        for y in [0.0, 0.1, 0.3, 0.6, 0.9, 1.2] {
            for beyond in [0.0, 0.1, 0.3, 0.6] {
                let (gain, slope) = gains(y, beyond);
                finite += usize::from(gain.is_finite());
                for i in 0..=60 {
                    let re = -beyond + (1.0 + 2.0 * beyond) * f64::from(i) / 60.0;
                    for im in [0.0, 0.5 * y, y] {
                        let (w, d) = sizes(re, im);
                        assert!(Bound::new(w - 1e-12).within(gain.value()), "{re} {im}: {w} > {gain:?}");
                        assert!(Bound::new(d).within(slope.value()), "{re} {im}: {d} > {slope:?}");
                    }
                }
            }
        }
        assert!(finite > 15, "{finite}");
    }

    /// Compares with the filter itself, at places along ever shorter parts of a cell.
    fn compare<K: Taps4>(least: f64) {
        let samples: Vec<f32> = (0..125).map(|i| ((i * 37) % 101) as f32).collect();
        let lattice = Lattice { samples: &samples[..], dims: [5; 3] };
        let cell = [1, 2, 1];
        for length in [1.0, 0.5, 0.25, 0.125, 0.0625] {
            let half = DVec3::new(0.5, -0.4, 0.3) * length;
            let middle = DVec3::new(1.5, 2.5, 1.5);
            let part = InterpolatedCell::new::<K, _>(&lattice, cell, 20.0, 101.0, [middle, half], 0.0, true);
            let (gradient, off) = part.gradient.unwrap();
            for i in 0..=40 {
                // Not at the ends: there another cell's gradient begins.
                let t = -0.999 + 0.04995 * f64::from(i);
                let (f, g): (f64, [f64; 3]) =
                    Separable::<K>::value_and_gradient(&lattice, (middle + half * t).to_array());
                assert!((part.field.at(t) - (f - 20.0)).abs() <= part.error.value(), "{length}");
                for a in 0..3 {
                    assert!((gradient[a].at(t) - g[a]).abs() <= off.value(), "{length}");
                }
            }
            if length <= least {
                assert!(part.error.within(1e-9), "{length}: {:?}", part.error);
            }
        }
    }

    #[test]
    fn interpolation_misses_no_more_than_its_bound() {
        compare::<GaussianTaps>(0.25);
        compare::<BSplineTaps>(1.0);
        compare::<CatmullRomTaps>(1.0);
    }
}
