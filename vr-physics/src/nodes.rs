//! Clenshaw-Curtis rules: nodes, weights, and the matrix of running integrals.

use std::sync::OnceLock;

/// A rule of n + 1 Chebyshev points on [−1, 1], from left to right.
#[derive(Debug)]
pub struct Rule {
    /// The points; the first is −1, the last 1.
    pub nodes: Vec<f64>,
    /// Weights of the integral over [−1, 1].
    pub weights: Vec<f64>,
    /// Row i: weights of the integral over \[−1, nodes\[i\]\] of the interpolating polynomial.
    pub running: Vec<Vec<f64>>,
    /// Barycentric weights of the interpolating polynomial.
    barycentric: Vec<f64>,
}

/// The degrees that there are rules for.
pub const DEGREES: [usize; 2] = [8, 16];

/// The rule of degree `DEGREES[which]`.
pub fn rule(which: usize) -> &'static Rule {
    static RULES: [OnceLock<Rule>; 2] = [const { OnceLock::new() }; 2];
    RULES[which].get_or_init(|| Rule::new(DEGREES[which]))
}

impl Rule {
    fn new(n: usize) -> Self {
        let angle = |j: usize| std::f64::consts::PI * (n - j) as f64 / n as f64;
        // The middle one and the ends are exact.
        let nodes: Vec<f64> = (0..=n).map(|j| if 2 * j == n { 0.0 } else { libm::cos(angle(j)) }).collect();
        let halved = |k: usize| if k == 0 || k == n { 0.5 } else { 1.0 };
        // ∫_{−1}^{x} T_k
        let antiderivative = |k: usize, theta: f64| {
            let c = |m: usize| libm::cos(m as f64 * theta);
            let sign = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
            let kf = k as f64;
            match k {
                0 => c(1) + 1.0,
                1 => 0.25 * (c(2) - 1.0),
                _ => 0.5 * (c(k + 1) / (kf + 1.0) - c(k - 1) / (kf - 1.0)) - sign / (kf * kf - 1.0) * 1.0,
            }
        };
        let row = |i: usize| -> Vec<f64> {
            let weight = |j: usize| -> f64 {
                let term = |k: usize| halved(k) * libm::cos(k as f64 * angle(j)) * antiderivative(k, angle(i));
                2.0 / n as f64 * halved(j) * (0..=n).map(term).sum::<f64>()
            };
            (0..=n).map(weight).collect()
        };
        let running: Vec<Vec<f64>> = (0..=n).map(row).collect();
        let barycentric = (0..=n).map(|j| halved(j) * if j % 2 == 0 { 1.0 } else { -1.0 }).collect();
        Self { weights: running[n].clone(), nodes, running, barycentric }
    }

    /// The interpolating polynomial at `t` (Berrut and Trefethen, *Barycentric Lagrange interpolation*, 2004).
    pub fn interpolate(&self, values: &[f64], t: f64) -> f64 {
        let (mut above, mut below) = (0.0, 0.0);
        for j in 0..self.nodes.len() {
            let distance = t - self.nodes[j];
            if distance == 0.0 {
                return values[j];
            }
            let w = self.barycentric[j] / distance;
            above += w * values[j];
            below += w;
        }
        above / below
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrates_powers_exactly() {
        for which in 0..DEGREES.len() {
            let r = rule(which);
            assert_eq!((r.nodes[0], r.nodes[DEGREES[which]]), (-1.0, 1.0));
            for k in 0..=DEGREES[which] as i32 {
                let values: Vec<f64> = r.nodes.iter().map(|x| x.powi(k)).collect();
                for (x, row) in r.nodes.iter().zip(&r.running) {
                    let exact = (x.powi(k + 1) - (-1.0f64).powi(k + 1)) / f64::from(k + 1);
                    let sum: f64 = row.iter().zip(&values).map(|(w, v)| w * v).sum();
                    assert!((sum - exact).abs() < 1e-14, "degree {} power {k}: {sum} {exact}", DEGREES[which]);
                }
                assert!((r.interpolate(&values, 0.37) - 0.37f64.powi(k)).abs() < 1e-13);
            }
        }
    }
}
