//! Cubic B-spline, and the prefilter that makes it interpolate.

use super::{Filter, Lattice, Separable, Taps4};
use crate::parallel::{collect, each_part};
use crate::real::Real;
use crate::voxel::Voxel;

/// The one-dimensional kernel of the uniform cubic B-spline.
#[derive(Clone, Copy, Debug)]
pub struct BSplineTaps;

/// Cubic B-spline along each axis, over [`interpolation_coefficients`] rather than over the voxels themselves.
pub type BSpline = Separable<BSplineTaps>;

impl Taps4 for BSplineTaps {
    const FILTER: Filter = Filter::BSpline;

    #[inline(always)]
    fn weights<R: Real>(t: R) -> [R; 4] {
        let sixth = R::from_f64(1.0 / 6.0);
        let c = R::from_f64;
        let u = R::ONE - t;
        [
            sixth * u * u * u,
            sixth * (t * t * (c(3.0) * t - c(6.0)) + c(4.0)),
            sixth * (u * u * (c(3.0) * u - c(6.0)) + c(4.0)),
            sixth * t * t * t,
        ]
    }

    #[inline(always)]
    fn derivatives<R: Real>(t: R) -> [R; 4] {
        let half = R::from_f64(0.5);
        let c = R::from_f64;
        let u = R::ONE - t;
        [-half * u * u, half * t * (c(3.0) * t - c(4.0)), half * u * (c(4.0) - c(3.0) * u), half * t * t]
    }
}

/// The pole of the inverse filter: √3 − 2.
const POLE: f64 = -0.267_949_192_431_122_7;

/// The coefficients c with Σ c β³ = values at the lattice points (Unser, *Splines: a perfect fit for signal and image
/// processing*, 1999, box 2), mirrored at the faces of the box.
///
/// Every line is filtered in f64; the coefficients are kept as f32, and the field of *these* is what the reference and all renderers take.
pub fn interpolation_coefficients<T: Voxel>(lattice: &Lattice<'_, T>) -> Vec<f32> {
    let mut c: Vec<f32> = lattice.samples.iter().map(|s| s.to_f32()).collect();
    invert(&mut c, lattice.dims);
    c
}

/// Turns values into coefficients, in place.
fn invert(c: &mut [f32], [nx, ny, nz]: [usize; 3]) {
    // x and y within a slice, slices in parallel; then z, in parallel over rows of x.
    each_part(c.chunks_mut(nx * ny), |_, slice| {
        let mut line = vec![0.0; nx.max(ny)];
        for row in slice.chunks_mut(nx) {
            filter_line(row, 0, 1, &mut line[..nx]);
        }
        for x in 0..nx {
            filter_line(slice, x, nx, &mut line[..ny]);
        }
    });
    // Transposed access: gather columns of z for one y at a time, filter, and scatter. The gather is read-only.
    let columns: Vec<Vec<f32>> = collect(ny, |y| {
        let mut out = vec![0.0f32; nx * nz];
        let mut line = vec![0.0; nz];
        for x in 0..nx {
            for (z, v) in line.iter_mut().enumerate() {
                *v = f64::from(c[(z * ny + y) * nx + x]);
            }
            prefilter(&mut line);
            for (z, v) in line.iter().enumerate() {
                out[z * nx + x] = *v as f32;
            }
        }
        out
    });
    each_part(c.chunks_mut(nx * ny), |z, slice| {
        for (y, row) in slice.chunks_mut(nx).enumerate() {
            row.copy_from_slice(&columns[y][z * nx..(z + 1) * nx]);
        }
    });
}

fn filter_line(data: &mut [f32], start: usize, stride: usize, line: &mut [f64]) {
    for (i, v) in line.iter_mut().enumerate() {
        *v = f64::from(data[start + i * stride]);
    }
    prefilter(line);
    for (i, v) in line.iter().enumerate() {
        data[start + i * stride] = *v as f32;
    }
}

/// Inverts the filter (1/6, 4/6, 1/6) along a line mirrored at both ends: a causal and an anticausal recursion.
fn prefilter(s: &mut [f64]) {
    let n = s.len();
    // Exact start of the causal sum over the period 2(n − 1) of the mirrored line.
    let last = n - 1;
    let mut sum = s[0] + POLE.powi(last as i32) * s[last];
    for (i, v) in s.iter().enumerate().take(last).skip(1) {
        // |POLE|^k is below 2^-60 for k > 32: what follows adds nothing, and powi of large exponents is not free.
        if i > 64 && 2 * last - i > 64 {
            break;
        }
        sum += (POLE.powi(i as i32) + POLE.powi((2 * last - i) as i32)) * v;
    }
    sum /= 1.0 - POLE.powi(2 * last as i32);
    let mut c = sum;
    s[0] = c;
    for v in s.iter_mut().skip(1) {
        c = *v + POLE * c;
        *v = c;
    }
    c = POLE / (POLE * POLE - 1.0) * (s[last] + POLE * s[last - 1]);
    s[last] = 6.0 * c;
    for v in s.iter_mut().rev().skip(1) {
        c = POLE * (c - *v);
        *v = 6.0 * c;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::Reconstruction;

    #[test]
    fn interpolates_the_samples() {
        for dims in [[2, 2, 2], [2, 3, 5], [7, 4, 90]] {
            let n = dims.iter().product();
            let samples: Vec<f32> = (0..n).map(|i: usize| ((i * 7919) % 251) as f32).collect();
            let c = interpolation_coefficients(&Lattice { samples: &samples, dims });
            let lattice = Lattice { samples: &c[..], dims };
            let given = Lattice { samples: &samples[..], dims };
            for z in 0..dims[2] {
                for y in 0..dims[1] {
                    for x in 0..dims[0] {
                        let f: f64 = BSpline::value(&lattice, [x as f64, y as f64, z as f64]);
                        let s: f64 = given.at(x, y, z);
                        // Coefficients up to 27 times the samples, rounded to f32.
                        assert!((f - s).abs() < 251.0 * 27.0 * 1.2e-7, "{dims:?} {x} {y} {z}: {f} for {s}");
                    }
                }
            }
        }
    }
}
