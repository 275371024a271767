//! Courses of a radially symmetric kernel along chords, as polynomials.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16, i32x16};
use vr_core::PointKernel;
use vr_kernels::vector::{LANES, pick, splat, transpose};

use crate::kernel::{Radial, quadrature};

/// Number of intervals of the distance b of a line from the middle.
const ACROSS: usize = 512;
/// Number of coefficients of a row.
const TERMS: usize = 8;

/// G(b, u) = ∫ W from the middle of a chord to the part u in [−1, 1] of its half, over the distance b of the chord from the kernel's middle: a polynomial
/// in u, its coefficients linear in b.
///
/// A splat's chord is looked up once, and sections of it in any number of sheets cost a polynomial each; sections next to each other are differences of
/// the same function, and sum to the whole. Rows of 16 KB stay in the nearest cache.
pub(crate) struct ChordTable {
    /// Rows, one for each b, and two rows of zeros for b = 1.
    rows: Vec<[f32; TERMS]>,
    /// True for the cubic spline, whose third derivative jumps at half its radius: its rows hold a polynomial in |u|, and last the factor of the jump's term.
    bends: bool,
}

impl ChordTable {
    /// The table of a kernel; `None` for a cone, whose kink no polynomial is near to.
    pub(crate) fn new(radial: &Radial) -> Option<Self> {
        let bends = match radial.point()? {
            PointKernel::CubicSpline => true,
            PointKernel::Gaussian => false,
            PointKernel::Cone => return None,
        };
        let row = |i: usize| {
            let b = i as f64 / ACROSS as f64;
            if bends { bending_row(radial, b) } else { smooth_row(radial, b) }.map(|x| x as f32)
        };
        Some(Self { rows: (0..ACROSS).map(row).chain([[0.0; TERMS]; 2]).collect(), bends })
    }

    /// The polynomials of chords at these distances from the middle, b in [0, 1].
    #[inline(always)]
    pub(crate) fn at<S: Simd>(&self, simd: S, b: f32x16<S>) -> ChordCourse<S> {
        let across = b * ACROSS as f32;
        let column: i32x16<S> = across.to_int();
        let t = across - column.to_float::<f32x16<S>>();
        let index = column.to_array();
        let flat = self.rows.as_flattened();
        let zero = f32x4::splat(simd, 0.0);
        let mut parts = [[zero; LANES]; 4];
        for i in 0..LANES {
            let both = &flat[TERMS * (index[i] as u32 as usize)..][..2 * TERMS];
            for (p, part) in parts.iter_mut().enumerate() {
                part[i] = f32x4::from_slice(simd, &both[4 * p..4 * p + 4]);
            }
        }
        let [low, mid, next_low, next_mid] =
            [transpose(parts[0]), transpose(parts[1]), transpose(parts[2]), transpose(parts[3])];
        let mut terms = [splat(simd, 0.0); TERMS];
        for k in 0..4 {
            terms[k] = low[k] + t * (next_low[k] - low[k]);
            terms[k + 4] = mid[k] + t * (next_mid[k] - mid[k]);
        }
        if !self.bends {
            return ChordCourse { terms, bend: None };
        }
        // Where the chord is half a radius from the middle: u² = (¼ − b²) / (1 − b²).
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let square = (one - b) * (one + b);
        let inner = (splat(simd, 0.25) - b * b).max(zero);
        let at = (inner / pick(square.simd_gt(zero), square, one)).sqrt();
        let whole = terms[TERMS - 1] * (at * at) * (at * at);
        ChordCourse { terms, bend: Some([at, whole]) }
    }
}

/// Polynomials of sixteen chords.
pub(crate) struct ChordCourse<S: Simd> {
    terms: [f32x16<S>; TERMS],
    /// For the cubic spline: the place u of the jump in its third derivative, and the constant that the jump adds beyond it.
    bend: Option<[f32x16<S>; 2]>,
}

impl<S: Simd> ChordCourse<S> {
    /// G at u in [−1, 1].
    #[inline(always)]
    pub(crate) fn up_to(&self, simd: S, u: f32x16<S>) -> f32x16<S> {
        let [a, b, c, d, e, f, g, h] = self.terms;
        // In two halves, which do not wait for each other.
        let Some([at, whole]) = self.bend else {
            let x = u * u;
            let square = x * x;
            return u * (a + x * (b + x * (c + x * d)) + square * square * (e + x * (f + x * (g + x * h))));
        };
        let x = u.abs();
        let square = x * x;
        let smooth = x * (a + x * (b + x * (c + x * d)) + square * square * (e + x * (f + x * g)));
        let rest = (at - x).max(splat(simd, 0.0));
        let rest = rest * rest;
        let size = smooth - (whole - h * rest * rest);
        pick(u.simd_lt(splat(simd, 0.0)), -size, size)
    }
}

/// Chebyshev's nodes in [0, 1], ascending, which lie closest where a function may bend: at both ends.
fn nodes<const N: usize>() -> [f64; N] {
    std::array::from_fn(|j| 0.5 - 0.5 * libm::cos(std::f64::consts::PI * (j as f64 + 0.5) / N as f64))
}

/// ∫ of the polynomial in u² through the kernel's values: coefficients of u, u³, …
fn smooth_row(radial: &Radial, b: f64) -> [f64; TERMS] {
    let square = (1.0 - b) * (1.0 + b);
    let nodes = nodes::<TERMS>();
    let powers = interpolated(nodes, nodes.map(|x| radial.at((b * b + square * x).sqrt())));
    std::array::from_fn(|k| powers[k] * square.sqrt() / (2 * k + 1) as f64)
}

/// The cubic spline's G without the jump's term, divided by u: coefficients of u, u², …, and the factor of (at − |u|)⁴.
///
/// W bends by −8 (½ − t)³, and t as a function of u has the slope 2·(1 − b²)·u where t = ½.
fn bending_row(radial: &Radial, b: f64) -> [f64; TERMS] {
    const SMOOTH: usize = TERMS - 1;
    let square = (1.0 - b) * (1.0 + b);
    let at = ((0.25 - b * b).max(0.0) / square).sqrt();
    let slope = 2.0 * square * at;
    let jump = 8.0 / std::f64::consts::PI * 8.0 * slope * slope * slope;
    let value = |u: f64| radial.at((b * b + square * u * u).sqrt());
    // Nodes reach to the end itself, and lie closer to the middle than Chebyshev's, which halves the error.
    let chebyshev = nodes::<SMOOTH>();
    let nodes = chebyshev.map(|x| libm::pow(x / chebyshev[SMOOTH - 1], 0.8));
    let (mut sum, mut from) = (0.0, 0.0);
    let values = nodes.map(|node| {
        let cut = at.clamp(from, node);
        sum += quadrature(from, cut, 2, value) + quadrature(cut, node, 2, value);
        from = node;
        let bend = 0.25 * jump * (libm::pow(at, 4.0) - libm::pow((at - node).max(0.0), 4.0));
        (sum + bend) / node
    });
    let powers = interpolated(nodes, values);
    let mut row = [0.25 * jump; TERMS];
    row[..SMOOTH].copy_from_slice(&powers);
    row.map(|x| x * square.sqrt())
}

/// Coefficients of powers of the polynomial through some values (Newton's divided differences).
fn interpolated<const N: usize>(nodes: [f64; N], mut values: [f64; N]) -> [f64; N] {
    for order in 1..N {
        for j in (order..N).rev() {
            values[j] = (values[j] - values[j - 1]) / (nodes[j] - nodes[j - order]);
        }
    }
    let mut powers = [0.0; N];
    for j in (0..N).rev() {
        // powers ← powers · (x − node) + value.
        for k in (0..N).rev() {
            powers[k] = if k > 0 { powers[k - 1] } else { 0.0 } - nodes[j] * powers[k];
        }
        powers[0] += values[j];
    }
    powers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::Profile;
    use fearless_simd::{Level, dispatch};

    #[inline(always)]
    fn look_up<S: Simd>(simd: S, table: &ChordTable, b: f32, u: f32) -> f32 {
        table.at(simd, splat(simd, b)).up_to(simd, splat(simd, u)).to_array()[5]
    }

    #[test]
    fn polynomials_are_what_quadrature_gives() {
        for kernel in [PointKernel::CubicSpline, PointKernel::Gaussian] {
            let Profile::Radial(radial) = Profile::point(kernel) else { unreachable!("all of these are") };
            let table = ChordTable::new(&radial).expect("one of those");
            let peak = 2.0 * radial.along_line(0.0, 1.0);
            let mut worst = 0.0f64;
            for i in 0..=150 {
                for k in -50..=50 {
                    let (b, u) = (f64::from(i) / 150.0, f64::from(k) / 50.0);
                    let got = dispatch!(Level::new(), simd => look_up(simd, &table, b as f32, u as f32));
                    let z = u * ((1.0 - b) * (1.0 + b)).sqrt();
                    worst = worst.max((f64::from(got) - radial.along_line(b, z)).abs());
                }
            }
            println!("{kernel}: {:.1e} of the peak", worst / peak);
            // The bound of the table of sections is 5·10⁻⁵.
            assert!(worst < 3e-5 * peak, "{kernel}: {worst:e} of {peak}");
        }
    }
}
