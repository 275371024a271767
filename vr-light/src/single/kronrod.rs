//! Kronrod's rule of seven points, which holds Gauss's of three.

/// Points on [−1, 1], ascending, with Kronrod's and Gauss's weights (Kronrod 1965; Patterson, "The optimum addition of points to quadrature
/// formulae",
/// 1968).
pub(super) const RULE: [[f64; 3]; 7] = [
    [-0.960_491_268_708_020_3, 0.104_656_226_026_467_27, 0.0],
    [-0.774_596_669_241_483_4, 0.268_488_089_868_333_44, 5.0 / 9.0],
    [-0.434_243_749_346_802_56, 0.401_397_414_775_962_2, 0.0],
    [0.0, 0.450_916_538_658_474_14, 8.0 / 9.0],
    [0.434_243_749_346_802_56, 0.401_397_414_775_962_2, 0.0],
    [0.774_596_669_241_483_4, 0.268_488_089_868_333_44, 5.0 / 9.0],
    [0.960_491_268_708_020_3, 0.104_656_226_026_467_27, 0.0],
];

/// Integral over an interval of this length of a function with these values at the points, and an estimate of its error.
///
/// The estimate is that of QUADPACK (Piessens et al., 1983): the difference of the two rules, much smaller where it is small beside the function's
/// own
/// variation.
pub(super) fn integrate(values: &[[f64; 3]; 7], length: f64) -> ([f64; 3], f64) {
    let half = 0.5 * length;
    let mut error = 0.0f64;
    let integral = std::array::from_fn(|c| {
        let sum = |weight: usize| RULE.iter().zip(values).map(|(r, v)| r[weight] * v[c]).sum::<f64>();
        let (fine, coarse) = (sum(1), sum(2));
        let mean = 0.5 * fine;
        let variation: f64 = RULE.iter().zip(values).map(|(r, v)| r[1] * (v[c] - mean).abs()).sum();
        let difference = (fine - coarse).abs();
        let estimate =
            if variation > 0.0 { variation * (200.0 * difference / variation).powf(1.5).min(1.0) } else { difference };
        error = error.max(half * estimate);
        half * fine
    });
    (integral, error)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kronrods_rule_is_exact_to_degree_11_and_gausss_to_5() {
        for degree in 0..12 {
            let exact = if degree % 2 == 1 { 0.0 } else { 2.0 / f64::from(degree + 1) };
            let sum = |weight: usize| RULE.iter().map(|r| r[weight] * r[0].powi(degree)).sum::<f64>();
            assert!((sum(1) - exact).abs() < 1e-14, "{degree}");
            assert!(degree > 5 || (sum(2) - exact).abs() < 1e-14, "{degree}");
        }
        let values = RULE.map(|r| [r[0].exp(), 1.0, 0.0]);
        let (integral, error) = integrate(&values, 2.0);
        // Kronrod's rule is right to 10⁻¹¹ here; the estimate is that of a much worse one.
        assert!((integral[0] - 2.0 * 1f64.sinh()).abs() < 1e-10 && error < 1e-2);
        assert!((integral[1] - 2.0).abs() < 1e-14);
    }
}
