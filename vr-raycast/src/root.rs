//! Roots of functions that are monotone between two ends.

use vr_core::Real;

/// Returns the zero of a function that rises or falls from `a` to `b`, to the last bits: Newton's steps, halving where they leave the bracket.
/// `at` returns its value and its slope.
pub(crate) fn monotone_root<R: Real>([mut a, mut b]: [R; 2], rising: bool, at: impl Fn(R) -> (R, R)) -> R {
    let half = R::from_f64(0.5);
    let mut t = half * (a + b);
    for _ in 0..80 {
        let (value, slope) = at(t);
        if value == R::ZERO {
            break;
        }
        if (value < R::ZERO) == rising {
            a = t;
        } else {
            b = t;
        }
        let newton = t - value / slope;
        let next = if newton > a && newton < b { newton } else { half * (a + b) };
        if next == t || b - a <= R::from_f64(R::ROUNDOFF) {
            break;
        }
        t = next;
    }
    t
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_roots_that_newton_alone_misses() {
        let cube = |x: f64| (x * x * x - 0.001, 3.0 * x * x);
        assert!((monotone_root([0.0, 1.0], true, cube) - 0.1).abs() < 1e-15);
        // Flat at the bracket's middle.
        let flat = |x: f32| (0.4 - (x - 0.5) * (x - 0.5) * (x - 0.5) * 8.0, -24.0 * (x - 0.5) * (x - 0.5));
        let root = monotone_root([0.0, 1.0], false, flat);
        assert!(flat(root).0.abs() < 1e-6, "{root}");
    }
}
