//! Sections of the cubic spline along parallel rays, as sums of products: a factor of the ray's distance times a factor of the place along it.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x8, f32x16};
use vr_core::PointKernel;
use vr_kernels::vector::splat;

use crate::kernel::{Radial, quadrature};

/// Number of products in a sum.
const TERMS: usize = 10;
/// Length of a row of Bᵣ: a vector of eight and one of four.
const ROW: usize = 12;
/// Number of intervals of z.
const ALONG: usize = 512;
/// Number of distances b to which factors of z are fitted.
const FITTED: usize = 96;
/// Number of iterations of the fit: more change its largest error by a few per cent.
const ITERATIONS: usize = 12;

/// Bᵣ, or differences of them.
pub(crate) type Row = [f32; ROW];

/// G(b, z) = ∫₀ᶻ W along a line that passes the middle of a cubic spline at a distance b, as Σᵣ Aᵣ(b) Bᵣ(z).
///
/// All parallel rays cross a face of a sheet at the same z, so the differences of Bᵣ are computed only once per sheet. Evaluating a section then costs little more than
/// evaluating a polynomial. The sections of all sheets add up to the difference of G between the ends, as they do with any table of G.
///
/// Aᵣ are (1 − b)³ to (1 − b)⁷ and (1 − b²)^(7/2), and for the kernel's core (1 − 2b)³ to (1 − 2b)⁵ and (1 − 4b²)^(7/2); each is 0 where its base is negative. The powers of 7/2
/// describe how G falls towards the rim once z is beyond the chord. The largest error is 6·10⁻⁶ of the longest chord's integral, a fourth of that of a chord's polynomial.
pub(crate) struct SectionFactors {
    /// Bᵣ, a row for each z, the last one twice.
    along: Vec<Row>,
}

/// Factors of sixteen rays. For the kernel and for its core: the base of the powers, its third power, and the power of 7/2.
#[derive(Clone, Copy)]
pub(crate) struct RayFactors<S: Simd> {
    outer: [f32x16<S>; 3],
    core: [f32x16<S>; 3],
}

impl SectionFactors {
    /// The factors of a kernel; `None` if it is no cubic spline.
    pub(crate) fn new(radial: &Radial) -> Option<Self> {
        if radial.point() != Some(PointKernel::CubicSpline) {
            return None;
        }
        // Nodes lie closest at both ends, where polynomials stray first (Chebyshev).
        let node = |i: usize| 0.5 - 0.5 * libm::cos(std::f64::consts::PI * (i as f64 + 0.5) / FITTED as f64);
        let powers: Vec<[f64; TERMS]> = (0..FITTED).map(|i| powers_of(node(i))).collect();
        let integrals: Vec<Vec<f64>> = (0..FITTED).map(|i| integrals_along(radial, node(i))).collect();
        let rows = fit(&powers, &integrals);
        let row = |terms: &[f64; TERMS]| std::array::from_fn(|r| terms.get(r).map_or(0.0, |&x| x as f32));
        Some(Self { along: rows.iter().chain(rows.last()).map(row).collect() })
    }

    /// Bᵣ for z in [−1, 1].
    #[inline(always)]
    pub(crate) fn along<S: Simd>(&self, simd: S, z: f32) -> SheetFactors<S> {
        let along = z.abs() * ALONG as f32;
        // Through i32: a conversion to 64 bits is many instructions.
        let index = along as i32;
        let t = along - index as f32;
        let both = &self.along.as_flattened()[ROW * index as u32 as usize..][..2 * ROW];
        let (row, next) = (f32x8::from_slice(simd, &both[..8]), f32x8::from_slice(simd, &both[ROW..][..8]));
        let (rest, next_rest) = (f32x4::from_slice(simd, &both[8..ROW]), f32x4::from_slice(simd, &both[ROW + 8..]));
        let sign = 1f32.copysign(z);
        SheetFactors { eight: (row + (next - row) * t) * sign, four: (rest + (next_rest - rest) * t) * sign }
    }
}

/// A row in vectors.
#[derive(Clone, Copy)]
pub(crate) struct SheetFactors<S: Simd> {
    eight: f32x8<S>,
    four: f32x4<S>,
}

impl<S: Simd> SheetFactors<S> {
    /// Differences from those of a place before, times a factor.
    #[inline(always)]
    pub(crate) fn since(&self, before: &Self, factor: f32) -> Row {
        let mut row = [0.0; ROW];
        row[..8].copy_from_slice(&((self.eight - before.eight) * factor).to_array());
        row[8..].copy_from_slice(&((self.four - before.four) * factor).to_array());
        row
    }
}

impl<S: Simd> RayFactors<S> {
    /// Factors of rays at squared distances b² ≥ 0.
    #[inline(always)]
    pub(crate) fn new(simd: S, square: f32x16<S>) -> Self {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let b = square.sqrt();
        let (outer, core) = ((one - b).max(zero), (one - b * 2.0).max(zero));
        let (room, core_room) = ((one - square).max(zero), (one - square * 4.0).max(zero));
        Self {
            outer: [outer, outer * outer * outer, room * room * room * room.sqrt()],
            core: [core, core * core * core, core_room * core_room * core_room * core_room.sqrt()],
        }
    }

    /// True if a ray passes through the core.
    #[inline(always)]
    pub(crate) fn is_in_core(&self, simd: S) -> bool {
        self.core[0].simd_gt(splat(simd, 0.0)).any_true()
    }

    /// Σᵣ Aᵣ rowᵣ; `CORE`: whether any ray passes through the core.
    #[inline(always)]
    pub(crate) fn sum<const CORE: bool>(&self, row: &Row) -> f32x16<S> {
        let ([u, cube, root], [v, core_cube, core_root]) = (self.outer, self.core);
        let sum = ((((u * row[4] + row[3]) * u + row[2]) * u + row[1]) * u + row[0]) * cube + root * row[8];
        if CORE { sum + (((v * row[7] + row[6]) * v + row[5]) * core_cube + core_root * row[9]) } else { sum }
    }
}

/// Aᵣ(b).
fn powers_of(b: f64) -> [f64; TERMS] {
    let (u, v) = ((1.0 - b).max(0.0), (1.0 - 2.0 * b).max(0.0));
    std::array::from_fn(|r| match r {
        0..5 => u.powi(r as i32 + 3),
        5..8 => v.powi(r as i32 - 2),
        8 => ((1.0 - b) * (1.0 + b)).max(0.0).sqrt().powi(7),
        _ => ((1.0 - 2.0 * b) * (1.0 + 2.0 * b)).max(0.0).sqrt().powi(7),
    })
}

/// G(b, z) for all rows z.
fn integrals_along(radial: &Radial, b: f64) -> Vec<f64> {
    let at = |k: usize| k as f64 / ALONG as f64;
    let value = |z: f64| radial.at((b * b + z * z).sqrt());
    let mut sum = 0.0;
    let up_to = |k: usize| {
        if k > 0 {
            sum += quadrature(at(k - 1), at(k), 1, value);
        }
        sum
    };
    (0..=ALONG).map(up_to).collect()
}

/// Returns, for each z, the Bᵣ for which Σᵣ Aᵣ Bᵣ approximates G at all nodes: by least squares, with weights that grow where errors are large until the largest errors
/// are about equal (Lawson 1961, "Contributions to the theory of linear least maximum approximation").
fn fit(powers: &[[f64; TERMS]], integrals: &[Vec<f64>]) -> Vec<[f64; TERMS]> {
    let mut weights = [1.0; FITTED];
    let mut best = (f64::INFINITY, Vec::new());
    for _ in 0..ITERATIONS {
        let rows = least_squares(powers, integrals, &weights);
        let error = |i: usize| {
            let at = |row: &[f64; TERMS]| (0..TERMS).map(|r| powers[i][r] * row[r]).sum::<f64>();
            rows.iter().zip(&integrals[i]).fold(0.0f64, |max, (row, want)| max.max((at(row) - want).abs()))
        };
        let errors: [f64; FITTED] = std::array::from_fn(error);
        let largest = errors.iter().copied().fold(0.0, f64::max);
        if largest < best.0 {
            best = (largest, rows);
        }
        // A twentieth more keeps nodes from dropping out.
        weights.iter_mut().zip(errors).for_each(|(weight, error)| *weight *= error / largest + 0.05);
    }
    best.1
}

/// Weighted least squares by orthonormal columns, Gram and Schmidt's method done twice for rounding (Giraud, Langou & Rozložník 2005, "The loss of orthogonality
/// in the Gram-Schmidt orthogonalization process").
fn least_squares(powers: &[[f64; TERMS]], integrals: &[Vec<f64>], weights: &[f64; FITTED]) -> Vec<[f64; TERMS]> {
    let dot = |a: &[f64; FITTED], b: &[f64; FITTED]| (0..FITTED).map(|i| weights[i] * a[i] * b[i]).sum::<f64>();
    // Column r of the powers is Σ columns[k] upper[k][r].
    let mut columns = [[0.0; FITTED]; TERMS];
    let mut upper = [[0.0; TERMS]; TERMS];
    for r in 0..TERMS {
        let mut column: [f64; FITTED] = std::array::from_fn(|i| powers[i][r]);
        for _ in 0..2 {
            for k in 0..r {
                let part = dot(&columns[k], &column);
                upper[k][r] += part;
                (0..FITTED).for_each(|i| column[i] -= part * columns[k][i]);
            }
        }
        upper[r][r] = dot(&column, &column).sqrt();
        columns[r] = column.map(|x| x / upper[r][r]);
    }
    let solve = |k: usize| {
        let values: [f64; FITTED] = std::array::from_fn(|i| integrals[i][k]);
        let mut row = columns.each_ref().map(|column| dot(column, &values));
        for r in (0..TERMS).rev() {
            let rest: f64 = (r + 1..TERMS).map(|k| upper[r][k] * row[k]).sum();
            row[r] = (row[r] - rest) / upper[r][r];
        }
        row
    };
    (0..=ALONG).map(solve).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::Profile;
    use fearless_simd::{Level, dispatch};

    fn spline() -> (Radial, SectionFactors) {
        let Profile::Radial(radial) = Profile::point(PointKernel::CubicSpline) else { unreachable!("it is") };
        (radial, SectionFactors::new(&radial).expect("a spline"))
    }

    #[inline(always)]
    fn look_up<S: Simd>(simd: S, factors: &SectionFactors, b: f32, z: f32) -> f32 {
        let rays = RayFactors::new(simd, splat(simd, b * b));
        let row = factors.along(simd, z).since(&factors.along(simd, 0.0), 1.0);
        let sum = if rays.is_in_core(simd) { rays.sum::<true>(&row) } else { rays.sum::<false>(&row) };
        sum.to_array()[5]
    }

    #[test]
    fn sums_of_products_are_what_quadrature_gives() {
        let (radial, factors) = spline();
        let peak = 2.0 * radial.along_line(0.0, 1.0);
        let mut worst = 0.0f64;
        for i in 0..=600 {
            for k in -200..=200 {
                let (b, z) = (f64::from(i) / 600.0, f64::from(k) / 200.0);
                let got = dispatch!(Level::new(), simd => look_up(simd, &factors, b as f32, z as f32));
                worst = worst.max((f64::from(got) - radial.along_line(b, z)).abs());
            }
        }
        println!("{:.1e} of the peak", worst / peak);
        // What is fitted leaves 5·10⁻⁶, and between rows of z another millionth.
        assert!(worst < 8e-6 * peak, "{:e} of the peak", worst / peak);
    }

    #[test]
    fn beyond_the_support_there_is_nothing() {
        let (_, factors) = spline();
        for z in [-1.0, -0.3, 0.0, 0.7, 1.0] {
            let got =
                dispatch!(Level::new(), simd => [look_up(simd, &factors, 1.0, z), look_up(simd, &factors, 1e9, z)]);
            assert_eq!(got, [0.0; 2]);
        }
    }
}
