//! The order of convergence that errors show.

/// The order p of errors C·hᵖ: the slope of the straight line through (ln h, ln error), by least squares.
///
/// # Panics
/// Panics if there are not as many errors as steps, fewer than two, or one that is not positive and finite.
pub fn fit_order(steps: &[f64], errors: &[f64]) -> f64 {
    assert!(steps.len() == errors.len() && steps.len() >= 2, "one error per step, at least two");
    assert!(steps.iter().chain(errors).all(|&x| x > 0.0 && x.is_finite()), "logarithms of {steps:?}, {errors:?}");
    let log = |xs: &[f64]| xs.iter().map(|&x| libm::log(x)).collect::<Vec<_>>();
    let (x, y) = (log(steps), log(errors));
    let n = x.len() as f64;
    let (mean_x, mean_y) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let covariance: f64 = x.iter().zip(&y).map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    let variance: f64 = x.iter().map(|x| (x - mean_x) * (x - mean_x)).sum();
    covariance / variance
}

/// The order fitted to the leading errors above a floor, from the largest step on; `None` if there are fewer than `min_count` (two at least).
///
/// # Panics
/// Panics under the same conditions as [`fit_order`].
pub fn fit_order_above(floor: f64, min_count: usize, steps: &[f64], errors: &[f64]) -> Option<f64> {
    let n = errors.iter().take_while(|&&e| e > floor && e.is_finite()).count();
    (n >= min_count.max(2)).then(|| fit_order(&steps[..n], &errors[..n]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fits_the_order_of_a_power() {
        let steps = [1.0, 0.5, 0.25, 0.125];
        for p in [0.5, 1.0, 2.0, 3.98] {
            let errors = steps.map(|h: f64| 7e-3 * h.powf(p));
            assert!((fit_order(&steps, &errors) - p).abs() < 1e-12);
        }
        // By hand: x = 0, 1, 2 (in ln 2), y = 0, 1, 3: slope = ((−1)(−4/3) + 0 + 1·(5/3)) / 2 = 3/2.
        assert!((fit_order(&[1.0, 2.0, 4.0], &[1.0, 2.0, 8.0]) - 1.5).abs() < 1e-12);
    }

    #[test]
    fn errors_at_the_floor_are_not_fitted() {
        let steps = [1.0, 0.5, 0.25, 0.125, 0.0625, 0.03125];
        let errors = [1e-2, 2.5e-3, 6.25e-4, 1.5625e-4, 3.90625e-5, 3e-5];
        assert!((fit_order_above(3.5e-5, 5, &steps, &errors).unwrap() - 2.0).abs() < 1e-12);
        assert!(fit_order_above(1e-6, 5, &steps, &errors).unwrap() < 1.9);
        assert_eq!(fit_order_above(5e-5, 5, &steps, &errors), None);
    }
}
