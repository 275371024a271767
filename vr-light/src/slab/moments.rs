//! Legendre moments of phase functions.

use vr_core::scattering::PhaseFunction;

use super::gauss::{gauss_legendre, legendre};

/// Moments χ₀ … of `count` degrees: χ = ½ ∫ p P dcos θ, so that p = Σ (2l + 1) χₗ Pₗ.
pub(super) fn legendre_moments(phase: &PhaseFunction, count: usize) -> Vec<f64> {
    let powers = |g: f64| std::iter::successors(Some(1.0), move |power| Some(power * g)).take(count);
    match phase {
        PhaseFunction::Isotropic => powers(0.0).collect(),
        PhaseFunction::HenyeyGreenstein(lobe) => powers(lobe.g()).collect(),
        PhaseFunction::DoubleHenyeyGreenstein(lobes) => {
            let ([a, b], share) = (lobes.lobes(), lobes.share());
            powers(a.g()).zip(powers(b.g())).map(|(a, b)| share * a + (1.0 - share) * b).collect()
        }
        PhaseFunction::Rayleigh => (0..count).map(|l| [1.0, 0.0, 0.1].get(l).copied().unwrap_or(0.0)).collect(),
        PhaseFunction::Tabulated(table) => {
            // On each stretch of the table the integrand is a polynomial, for which the rule is exact.
            let rule = gauss_legendre(count / 2 + 1);
            let mut moments = vec![0.0; count];
            for pair in table.points().windows(2) {
                let (middle, half) = (0.5 * (pair[0][0] + pair[1][0]), 0.5 * (pair[1][0] - pair[0][0]));
                for [x, weight] in &rule {
                    let cosine = middle + half * x;
                    let share = 0.5 * half * weight * table.value(cosine);
                    for (moment, p) in moments.iter_mut().zip(legendre(count, cosine)) {
                        *moment += share * p;
                    }
                }
            }
            moments
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fine_table_of_a_lobe_has_its_moments() {
        let lobe = PhaseFunction::double_henyey_greenstein([0.6, -0.3], 0.7).unwrap();
        let n = 4000;
        let points: Vec<[f64; 2]> =
            (0..=n).map(|i| 2.0 * f64::from(i) / f64::from(n) - 1.0).map(|c| [c, lobe.value(c)]).collect();
        let table = PhaseFunction::tabulated(&points).unwrap();
        let (exact, found) = (legendre_moments(&lobe, 20), legendre_moments(&table, 20));
        assert!((found[0] - 1.0).abs() < 1e-14 && (found[1] - table.mean_cosine()).abs() < 1e-14);
        for (a, b) in exact.iter().zip(found) {
            // Linear pieces miss h²/8 of the second derivative, here 40 at most.
            assert!((a - b).abs() < 2e-6, "{a} {b}");
        }
    }
}
