//! Interpolation of values at Chebyshev points by a polynomial, by way of Chebyshev coefficients.
//!
//! Straight to powers of t, rounding grows as (1 + √2)ⁿ. Chebyshev coefficients are found without any growth, and those of a smooth
//! function fall so fast that their powers do no harm.

use std::sync::OnceLock;

use super::poly::{MAX_DEGREE, Poly, chebyshev_point};

/// Interpolation of one degree: its nodes, and the matrix from values to coefficients.
///
/// # Examples
/// ```
/// use vr_core::field::interpolation;
///
/// let cubic = interpolation(3);
/// let values: Vec<f64> = cubic.nodes.iter().map(|t| t * t).collect();
/// // The coefficient of degree 3 is noise.
/// let (p, dropped) = cubic.through(&values, 1e-12);
/// assert_eq!(p.degree(), 2);
/// assert!((p.at(0.3) - 0.09).abs() < 1e-12 && dropped <= 1e-12);
/// ```
#[derive(Debug)]
pub struct Interpolation {
    /// The Chebyshev points cos(π j/n).
    pub nodes: Vec<f64>,
    /// Row k: weights of the values in the coefficient of T_k.
    rows: Vec<Vec<f64>>,
}

/// Bounds Σ |cardinal polynomial| of up to 25 Chebyshev points (Trefethen, *Approximation Theory and Approximation Practice*, 2013,
/// theorem 15.2: 1 + (2/π) ln(n + 1)).
pub const LEBESGUE: f64 = 3.1;

/// The interpolation of a degree from 1 to 24.
pub fn interpolation(degree: usize) -> &'static Interpolation {
    static MADE: [OnceLock<Interpolation>; MAX_DEGREE + 1] = [const { OnceLock::new() }; MAX_DEGREE + 1];
    MADE[degree].get_or_init(|| {
        let n = degree;
        let halved = |k: usize| if k == 0 || k == n { 0.5 } else { 1.0 };
        // Of a small multiple of π/n: cos of a large one would not be as exact.
        let cos = |jk: usize| chebyshev_point(n, jk % (2 * n));
        let entry = |k: usize, j: usize| 2.0 / n as f64 * halved(k) * halved(j) * cos(j * k);
        Interpolation {
            nodes: (0..=n).map(|j| chebyshev_point(n, j)).collect(),
            rows: (0..=n).map(|k| (0..=n).map(|j| entry(k, j)).collect()).collect(),
        }
    })
}

impl Interpolation {
    /// Chebyshev coefficients of the polynomial through values at the nodes.
    fn coefficients(&self, values: &[f64]) -> [f64; MAX_DEGREE + 1] {
        let mut c = [0.0; MAX_DEGREE + 1];
        for (c, row) in c.iter_mut().zip(&self.rows) {
            *c = row.iter().zip(values).map(|(w, v)| w * v).sum();
        }
        c
    }

    /// The constant of the polynomial through values at the nodes, and the sum of its other Chebyshev coefficients' sizes, which bounds its distance
    /// from that on [−1, 1].
    pub(super) fn constant_and_spread(&self, values: &[f64]) -> (f64, f64) {
        let c = self.coefficients(values);
        (c[0], c[1..].iter().map(|c| c.abs()).sum())
    }

    /// The polynomial through values at the nodes, less its last coefficients as long as they are no more than `noise`; and an upper bound
    /// of the sum of those that were dropped.
    pub fn through(&self, values: &[f64], noise: f64) -> (Poly, f64) {
        // Chebyshev coefficients, less the last ones that are noise.
        let c = self.coefficients(values);
        let (mut degree, mut dropped) = (self.nodes.len() - 1, 0.0);
        while degree > 0 && c[degree].abs() <= noise {
            dropped += c[degree].abs();
            degree -= 1;
        }
        // Powers of t.
        let mut powers = [0.0; MAX_DEGREE + 1];
        for (c, t) in c[..=degree].iter().zip(polynomials()) {
            for (sum, a) in powers.iter_mut().zip(t.coefficients()) {
                *sum += c * a;
            }
        }
        (Poly::new(&powers[..=degree]), dropped)
    }
}

/// The Chebyshev polynomials T₀, T₁, …
pub(super) fn polynomials() -> &'static [Poly] {
    static MADE: OnceLock<Vec<Poly>> = OnceLock::new();
    MADE.get_or_init(|| {
        let t = Poly::new(&[0.0, 1.0]);
        let mut all = vec![Poly::constant(1.0), t];
        for k in 2..=MAX_DEGREE {
            all.push(t * all[k - 1] * 2.0 + all[k - 2] * -1.0);
        }
        all
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smooth_functions_are_met_to_rounding() {
        // Singular at ±3: coefficients fall as 5.83⁻ᵏ.
        let f = |t: f64| 1.0 / (3.0 - t);
        let rule = interpolation(20);
        let values: Vec<f64> = rule.nodes.iter().map(|&t| f(t)).collect();
        let (p, dropped) = rule.through(&values, 1e-15);
        assert!(p.degree() < 20 && dropped < 2e-15 && dropped > 0.0, "{} {dropped}", p.degree());
        for i in 0..=100 {
            let t = -1.0 + 0.02 * f64::from(i);
            assert!((p.at(t) - f(t)).abs() < 4e-15, "{t}: {}", p.at(t) - f(t));
        }
    }

    #[test]
    fn polynomials_come_back_with_their_degree() {
        let p = Poly::new(&[0.5, -1.0, 2.0, 0.25]);
        for degree in [3, 8, 20] {
            let rule = interpolation(degree);
            let values: Vec<f64> = rule.nodes.iter().map(|&t| p.at(t)).collect();
            let (q, _) = rule.through(&values, 1e-14);
            assert_eq!(q.degree(), 3);
            assert!(p.coefficients().iter().zip(q.coefficients()).all(|(a, b)| (a - b).abs() < 2e-14));
        }
    }
}
