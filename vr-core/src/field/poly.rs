//! Polynomials on [−1, 1]: the form in which an integrator gets a field along a ray.

use std::sync::OnceLock;

use super::chebyshev::polynomials;

/// Largest degree: the square of a gradient of degree 12, as the Gaussian has.
pub const MAX_DEGREE: usize = 24;

/// The Chebyshev point cos(π j/n); 0 for n = 0.
pub fn chebyshev_point(n: usize, j: usize) -> f64 {
    if n == 0 { 0.0 } else { libm::cos(std::f64::consts::PI * j as f64 / n as f64) }
}

/// The polynomials of degree n that are 1 at one of the Chebyshev points and 0 at the others.
fn cardinals(n: usize) -> &'static [Poly] {
    static MADE: [OnceLock<Vec<Poly>>; MAX_DEGREE + 1] = [const { OnceLock::new() }; MAX_DEGREE + 1];
    MADE[n].get_or_init(|| {
        let chebyshev = polynomials();
        let halved = |k: usize| if k == 0 || k == n { 0.5 } else { 1.0 };
        let cardinal = |j: usize| {
            if n == 0 {
                return Poly::constant(1.0);
            }
            // T_k(x_j) by the discrete cosine transform.
            let term = |k: usize| chebyshev[k] * (2.0 / n as f64 * halved(j) * halved(k) * chebyshev_point(n, j * k));
            (1..=n).map(term).fold(term(0), |sum, p| sum + p)
        };
        (0..=n).map(cardinal).collect()
    })
}

/// Polynomial Σ cₖ tᵏ for t in [−1, 1].
///
/// # Examples
/// ```
/// use vr_core::field::Poly;
///
/// let p = Poly::new(&[1.0, 0.0, 3.0]); // 1 + 3t²
/// assert_eq!(p.at(0.5), 1.75);
/// assert_eq!(p.derivative().at(0.5), 3.0);
/// assert!((p.integral() - 4.0).abs() < 1e-15, "over [−1, 1]");
/// assert!((p.restricted(0.0, 1.0).at(0.0) - p.at(0.5)).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Poly {
    coefficients: [f64; MAX_DEGREE + 1],
    degree: usize,
}

impl Poly {
    /// A constant.
    pub fn constant(c: f64) -> Self {
        Self::new(&[c])
    }

    /// The polynomial of given coefficients, the constant first.
    ///
    /// # Panics
    /// Panics if there are none, or more than 25 (degree 24).
    pub fn new(coefficients: &[f64]) -> Self {
        let mut c = [0.0; MAX_DEGREE + 1];
        c[..coefficients.len()].copy_from_slice(coefficients);
        Self { coefficients: c, degree: coefficients.len() - 1 }
    }

    /// The polynomial of degree n = `values.len() − 1` through values at the Chebyshev points cos(π j/n).
    ///
    /// # Panics
    /// Panics if there is no value, or more than 25.
    pub fn through_chebyshev_points(values: &[f64]) -> Self {
        let mut p = Self::constant(0.0);
        p.degree = values.len() - 1;
        for (value, cardinal) in values.iter().zip(cardinals(p.degree)) {
            for (sum, c) in p.coefficients.iter_mut().zip(cardinal.coefficients()) {
                *sum += value * c;
            }
        }
        p
    }

    /// Its degree (leading coefficients may be zero).
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// The coefficients, the constant first.
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients[..=self.degree]
    }

    /// Its value.
    #[inline]
    pub fn at(&self, t: f64) -> f64 {
        self.coefficients().iter().rev().fold(0.0, |sum, c| sum * t + c)
    }

    /// Its derivative.
    pub fn derivative(&self) -> Self {
        let mut d = Self::constant(0.0);
        d.degree = self.degree.saturating_sub(1);
        for k in 1..=self.degree {
            d.coefficients[k - 1] = k as f64 * self.coefficients[k];
        }
        d
    }

    /// Its integral over [−1, 1].
    pub fn integral(&self) -> f64 {
        self.coefficients().iter().enumerate().step_by(2).map(|(k, c)| 2.0 * c / (k + 1) as f64).sum()
    }

    /// The same function on [a, b] ⊂ [−1, 1], stretched to [−1, 1] again.
    pub fn restricted(&self, a: f64, b: f64) -> Self {
        let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
        let mut p = *self;
        // Taylor shift by repeated synthetic division, then scaling.
        for first in 0..p.degree {
            for k in (first..p.degree).rev() {
                p.coefficients[k] += middle * p.coefficients[k + 1];
            }
        }
        let mut power = 1.0;
        for c in &mut p.coefficients[..=p.degree] {
            *c *= power;
            power *= half;
        }
        p
    }

    /// A polynomial of at most the given degree, and a bound of how far this one is from it on [−1, 1] (Lanczos 1938, *Trigonometric interpolation of empirical and
    /// analytical functions*: each power is taken down by the Chebyshev polynomial of its degree, which is nowhere above 1).
    pub fn economized(&self, degree: usize) -> (Self, f64) {
        let (mut p, mut off) = (*self, 0.0);
        while p.degree > degree {
            let n = p.degree;
            let factor = p.coefficients[n] * 0.5f64.powi(n as i32 - 1);
            for (c, t) in p.coefficients[..n].iter_mut().zip(polynomials()[n].coefficients()) {
                *c -= factor * t;
            }
            off += factor.abs();
            p.coefficients[n] = 0.0;
            p.degree -= 1;
        }
        (p, off)
    }

    /// Bounds |p(z) − p(0)| over |z| ≤ `radius`: Σ |cₖ| radiusᵏ, k ≥ 1.
    #[inline]
    pub fn spread(&self, radius: f64) -> f64 {
        self.coefficients()[1..].iter().rev().fold(0.0, |sum, c| (sum + c.abs()) * radius)
    }

    /// True if it is constant to the last bit.
    pub fn is_constant(&self) -> bool {
        self.coefficients()[1..].iter().all(|&c| c == 0.0)
    }

    /// Its coefficients in the Bernstein basis of [−1, 1]: their hull encloses the range.
    pub fn bernstein(&self) -> Bernstein {
        // Two times half: t = 2u − 1 by a Taylor shift, then b_j = Σ_k C(j,k)/C(n,k) a_k.
        let n = self.degree;
        let mut a = self.restricted_to_unit();
        for k in 1..=n {
            a[k] /= binomial(n, k);
        }
        // Multiplying by C(j,k) and summing is repeated addition of neighbours (Pascal's triangle).
        for first in (0..n).rev() {
            for j in first..n {
                a[j + 1] += a[j];
            }
        }
        Bernstein { b: a, degree: n }
    }

    /// Coefficients in u = (t + 1)/2.
    fn restricted_to_unit(&self) -> [f64; MAX_DEGREE + 1] {
        let mut p = *self;
        for first in 0..p.degree {
            for k in (first..p.degree).rev() {
                p.coefficients[k] -= p.coefficients[k + 1];
            }
        }
        let mut power = 1.0;
        for c in &mut p.coefficients[..=p.degree] {
            *c *= power;
            power *= 2.0;
        }
        p.coefficients
    }
}

fn binomial(n: usize, k: usize) -> f64 {
    (1..=k).fold(1.0, |c, i| c * (n + 1 - i) as f64 / i as f64)
}

impl std::ops::Add for Poly {
    type Output = Self;
    fn add(mut self, other: Self) -> Self {
        self.degree = self.degree.max(other.degree);
        for k in 0..=other.degree {
            self.coefficients[k] += other.coefficients[k];
        }
        self
    }
}

impl std::ops::Mul<f64> for Poly {
    type Output = Self;
    fn mul(mut self, factor: f64) -> Self {
        for c in &mut self.coefficients[..=self.degree] {
            *c *= factor;
        }
        self
    }
}

impl std::ops::Mul for Poly {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let mut p = Self::constant(0.0);
        p.degree = self.degree + other.degree;
        for i in 0..=self.degree {
            for j in 0..=other.degree {
                p.coefficients[i + j] += self.coefficients[i] * other.coefficients[j];
            }
        }
        p
    }
}

/// A polynomial in the Bernstein basis of an interval.
///
/// # Examples
/// ```
/// use vr_core::field::Poly;
///
/// let rising = Poly::new(&[1.0, 2.0]).bernstein();
/// assert!(rising.is_monotone());
/// assert_eq!(rising.hull(), (-1.0, 3.0));
/// assert!(!Poly::new(&[0.0, 0.0, 1.0]).bernstein().is_monotone());
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Bernstein {
    b: [f64; MAX_DEGREE + 1],
    degree: usize,
}

impl Bernstein {
    /// The coefficients: the first and the last are the values at the ends.
    pub fn coefficients(&self) -> &[f64] {
        &self.b[..=self.degree]
    }

    /// An interval that encloses the range.
    pub fn hull(&self) -> (f64, f64) {
        self.coefficients().iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &c| (l.min(c), h.max(c)))
    }

    /// True if the coefficients rise or fall throughout: then the polynomial does, too.
    pub fn is_monotone(&self) -> bool {
        let c = self.coefficients();
        c.windows(2).all(|w| w[0] <= w[1]) || c.windows(2).all(|w| w[0] >= w[1])
    }

    /// Both halves (de Casteljau 1959).
    pub fn halves(&self) -> (Self, Self) {
        let (mut left, mut right, mut work) = (*self, *self, self.b);
        let n = self.degree;
        for k in 0..=n {
            left.b[k] = work[0];
            right.b[n - k] = work[n - k];
            for j in 0..n - k {
                work[j] = 0.5 * (work[j] + work[j + 1]);
            }
        }
        (left, right)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wild() -> Poly {
        Poly::new(&[0.3, -2.0, 1.5, 4.0, -3.25, 0.5, 1.0, -0.75, 2.0, -1.0])
    }

    #[test]
    fn restriction_derivative_and_integral_agree_with_values() {
        let p = wild();
        let q = p.restricted(-0.7, 0.4);
        for i in 0..=20 {
            let t = -1.0 + 0.1 * f64::from(i);
            assert!((q.at(t) - p.at(-0.15 + 0.55 * t)).abs() < 1e-13);
            let slope = (p.at(t + 1e-6) - p.at(t - 1e-6)) / 2e-6;
            assert!((p.derivative().at(t) - slope).abs() < 1e-6);
        }
        let n = 20_000;
        let sum: f64 = (0..n).map(|i| p.at(-1.0 + (f64::from(i) + 0.5) * 2.0 / f64::from(n))).sum();
        assert!((p.integral() - sum * 2.0 / f64::from(n)).abs() < 1e-7);
    }

    #[test]
    fn what_is_economized_stays_near() {
        let p = wild();
        for degree in [3, 6, 8] {
            let (q, off) = p.economized(degree);
            let far =
                (0..=200).map(|i| 0.01 * f64::from(i) - 1.0).map(|t| (p.at(t) - q.at(t)).abs()).fold(0.0, f64::max);
            assert!(q.degree() == degree && far <= off && far > 0.1 * off, "{degree}: {far} {off}");
        }
        assert_eq!(p.economized(9), (p, 0.0));
    }

    #[test]
    fn bernstein_hull_encloses_and_halves_join() {
        let p = wild();
        let b = p.bernstein();
        let (low, high) = b.hull();
        let (left, right) = b.halves();
        // The change of basis magnifies rounding by up to 4ⁿ.
        let c = b.coefficients();
        assert!((c[0] - p.at(-1.0)).abs() < 1e-10 && (c[9] - p.at(1.0)).abs() < 1e-10);
        assert!((left.coefficients()[9] - p.at(0.0)).abs() < 1e-10);
        assert_eq!(left.coefficients()[9], right.coefficients()[0]);
        for i in 0..=100 {
            let v = p.at(-1.0 + 0.02 * f64::from(i));
            assert!(low <= v && v <= high);
        }
    }

    #[test]
    fn interpolates_at_chebyshev_points() {
        let p = wild();
        let values: Vec<f64> = (0..=9).map(|j| p.at(libm::cos(std::f64::consts::PI * f64::from(j) / 9.0))).collect();
        let q = Poly::through_chebyshev_points(&values);
        for (a, b) in p.coefficients().iter().zip(q.coefficients()) {
            assert!((a - b).abs() < 1e-11, "{a} {b}");
        }
    }
}
