//! Courses of a radially symmetric kernel along chords: polynomials, and of a cone the closed form.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x8, f32x16, i32x16};
use vr_core::PointKernel;
use vr_kernels::vector::{LANES, ln, pick, splat, transpose};

use crate::kernel::{Radial, quadrature};

/// Number of intervals of the distance b of a line from the middle.
const ACROSS: usize = 512;
/// Number of coefficients of a row.
const TERMS: usize = 8;

/// G(b, u) = ∫ W from the middle of a chord to the part u in [−1, 1] of its half, over the distance b of the chord from the kernel's middle: a polynomial
/// in u, its coefficients linear in b; of a cone the integral itself.
///
/// A splat's chord is looked up once, and sections of it in any number of sheets cost a polynomial each; sections next to each other are differences of
/// the same function, and sum to the whole. Rows of 16 KB stay in the nearest cache.
pub(crate) struct ChordTable {
    /// Rows, one for each b, and two rows of zeros for b = 1; none of a cone.
    rows: Vec<[f32; TERMS]>,
    form: Form,
}

/// Forms of courses.
#[derive(Clone, Copy)]
enum Form {
    /// A polynomial in u.
    Smooth,
    /// A polynomial in |u|, and in the last column the factor of a term for the jump of the third derivative that the cubic spline has at half its radius.
    Bending,
    /// The closed form for a cone, given the value at its tip: its kink is far from any polynomial.
    Cone(f32),
}

/// Largest error of a polynomial, by the largest integral: what the table of sections leaves.
const MAX_ERROR: f64 = 2e-5;

impl ChordTable {
    /// The table of a kernel; `None` for a Gaussian so narrow that no polynomial is near to it.
    pub(crate) fn new(radial: &Radial) -> Option<Self> {
        let form = match radial.point() {
            Some(PointKernel::CubicSpline) => Form::Bending,
            Some(PointKernel::Gaussian) => Form::Smooth,
            _ if radial.is_cone() => return Some(Self { rows: Vec::new(), form: Form::Cone(radial.at(0.0) as f32) }),
            _ if is_smooth(radial) => Form::Smooth,
            _ => return None,
        };
        let row = |i: usize| {
            let b = i as f64 / ACROSS as f64;
            if let Form::Bending = form { bending_row(radial, b) } else { smooth_row(radial, b) }.map(|x| x as f32)
        };
        Some(Self { rows: (0..ACROSS).map(row).chain([[0.0; TERMS]; 2]).collect(), form })
    }

    /// The polynomials of chords.
    #[inline(always)]
    pub(crate) fn at<S: Simd>(&self, simd: S, chord: &Chord<S>) -> ChordCourse<S> {
        let Chord { b, half, per_half } = *chord;
        if let Form::Cone(peak) = self.form {
            let b = b.max(splat(simd, 1e-6));
            return ChordCourse::Cone { half, square: b * b, ln: ln(simd, b), peak };
        }
        let across = b * ACROSS as f32;
        let column: i32x16<S> = across.to_int();
        let t = across - column.to_float::<f32x16<S>>();
        let index = column.to_array();
        let flat = self.rows.as_flattened();
        // Between two rows first, whose terms lie side by side: one row a ray is turned in place of two.
        let t = t.to_array();
        let mut halves = [[f32x4::splat(simd, 0.0); LANES]; 2];
        for i in 0..LANES {
            let both = &flat[TERMS * (index[i] as u32 as usize)..][..2 * TERMS];
            let (row, next) = (f32x8::from_slice(simd, &both[..TERMS]), f32x8::from_slice(simd, &both[TERMS..]));
            (halves[0][i], halves[1][i]) = (row + (next - row) * t[i]).split();
        }
        let (low, high) = (transpose(halves[0]), transpose(halves[1]));
        let terms = [low[0], low[1], low[2], low[3], high[0], high[1], high[2], high[3]];
        if let Form::Smooth = self.form {
            return ChordCourse::Smooth(terms);
        }
        // Where the chord is half a radius from the middle: u² = (¼ − b²) / (1 − b²).
        let inner = (splat(simd, 0.25) - b * b).max(splat(simd, 0.0));
        let at = inner.sqrt() * per_half;
        let whole = terms[TERMS - 1] * (at * at) * (at * at);
        ChordCourse::Bending { terms, at, whole }
    }
}

/// Chords of sixteen rays through the unit ball.
#[derive(Clone, Copy)]
pub(crate) struct Chord<S: Simd> {
    /// Their distances from the middle, b in [0, 1].
    pub(crate) b: f32x16<S>,
    /// Half their lengths.
    pub(crate) half: f32x16<S>,
    /// 1 over that; 0 where there is none.
    pub(crate) per_half: f32x16<S>,
}

impl<S: Simd> Chord<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, b: f32x16<S>) -> Self {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let half = ((one - b) * (one + b)).max(zero).sqrt();
        let there = half.simd_gt(zero);
        Self { b, half, per_half: pick(there, one / pick(there, half, one), zero) }
    }
}

/// Courses of sixteen chords.
pub(crate) enum ChordCourse<S: Simd> {
    Smooth([f32x16<S>; TERMS]),
    /// A polynomial, the place u at which the third derivative jumps, and the constant that the jump adds beyond it.
    Bending {
        terms: [f32x16<S>; TERMS],
        at: f32x16<S>,
        whole: f32x16<S>,
    },
    /// Of a cone: half the chord, b², ln b, and the kernel at its tip.
    Cone {
        half: f32x16<S>,
        square: f32x16<S>,
        ln: f32x16<S>,
        peak: f32,
    },
}

impl<S: Simd> ChordCourse<S> {
    /// G at u in [−1, 1].
    #[inline(always)]
    pub(crate) fn up_to(&self, simd: S, u: f32x16<S>) -> f32x16<S> {
        let size = match *self {
            // In pairs, which do not wait for each other (Estrin 1960, "Organization of computer systems: the fixed plus variable structure computer").
            Self::Smooth([a, b, c, d, e, f, g, h]) => {
                let x = u * u;
                let square = x * x;
                let (low, high) = ((a + x * b) + square * (c + x * d), (e + x * f) + square * (g + x * h));
                return u * (low + square * square * high);
            }
            Self::Bending { terms: [a, b, c, d, e, f, g, h], at, whole } => {
                let x = u.abs();
                let square = x * x;
                let (low, high) = ((a + x * b) + square * (c + x * d), (e + x * f) + square * g);
                let smooth = x * (low + square * square * high);
                let rest = (at - x).max(splat(simd, 0.0));
                let rest = rest * rest;
                smooth - (whole - h * rest * rest)
            }
            // ∫ 1 − √(b² + s²) ds = s − ½ (s r + b² ln((s + r) / b)), r = √(b² + s²).
            Self::Cone { half, square, ln: of_b, peak } => {
                let s = u.abs() * half;
                let r = (square + s * s).sqrt();
                (s - (s * r + square * (ln(simd, s + r) - of_b)) * 0.5) * peak
            }
        };
        pick(u.simd_lt(splat(simd, 0.0)), -size, size)
    }
}

/// Chebyshev's nodes in [0, 1], ascending, which lie closest where a function may bend: at both ends.
fn nodes<const N: usize>() -> [f64; N] {
    std::array::from_fn(|j| 0.5 - 0.5 * libm::cos(std::f64::consts::PI * (j as f64 + 0.5) / N as f64))
}

/// True if polynomials in u² are near enough to a kernel along every chord.
fn is_smooth(radial: &Radial) -> bool {
    let largest = radial.along_line(0.0, 1.0);
    (0..8).all(|i| {
        let b = f64::from(i) / 8.0;
        let (row, half) = (smooth_row(radial, b), ((1.0 - b) * (1.0 + b)).sqrt());
        (1..=16).all(|k| {
            let u = f64::from(k) / 16.0;
            let sum = row.iter().rev().fold(0.0, |sum, term| sum * u * u + term) * u;
            (sum - radial.along_line(b, u * half)).abs() < MAX_ERROR * largest
        })
    })
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
        table.at(simd, &Chord::new(simd, splat(simd, b))).up_to(simd, splat(simd, u)).to_array()[5]
    }

    #[test]
    fn polynomials_are_what_quadrature_gives() {
        let points = PointKernel::ALL.map(|kernel| (kernel.to_string(), Profile::point(kernel)));
        let voxels = [("voxels' Gaussian", Profile::gaussian(2.0 / 0.7)), ("voxels' cone", Profile::cone())];
        let voxels = voxels.map(|(name, profile)| (name.to_owned(), profile));
        for (kernel, profile) in points.into_iter().chain(voxels) {
            let Profile::Radial(radial) = profile else { unreachable!("all of these are") };
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

    #[test]
    fn a_narrow_gaussian_is_no_polynomial() {
        let table = |deviations| {
            let Profile::Radial(radial) = Profile::gaussian(deviations) else { unreachable!("it is") };
            ChordTable::new(&radial)
        };
        assert!(table(2.0).is_some() && table(3.0).is_some() && table(6.0).is_none());
    }
}
