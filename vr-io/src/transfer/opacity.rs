//! Opacities between points with a midpoint and a sharpness, as VTK's piecewise functions have them.

use crate::error::FieldError;

use super::polyline::{Polyline, resample};

/// Opacities over values, from rows of value, opacity, midpoint and sharpness; the last two shape the interval that follows. `field` names
/// a number of a row.
pub(super) fn opacities(
    points: &[[f64; 4]],
    field: impl Fn(usize, usize) -> String,
) -> Result<Polyline<1>, FieldError> {
    if points.is_empty() {
        return Err(FieldError::new(field(0, 0), "nothing", "must have one point at least"));
    }
    for (i, &[value, opacity, midpoint, sharpness]) in points.iter().enumerate() {
        let wrong = |k: usize, x: f64, allowed: &str| Err(FieldError::new(field(i, k), x, allowed));
        if !value.is_finite() || (i > 0 && value < points[i - 1][0]) {
            return wrong(0, value, "values must be finite and in ascending order");
        }
        for (k, x, allowed) in [
            (1, opacity, "opacities must be in [0, 1]"),
            (2, midpoint, "midpoints must be in [0, 1]"),
            (3, sharpness, "sharpness must be in [0, 1]"),
        ] {
            if !(0.0..=1.0).contains(&x) {
                return wrong(k, x, allowed);
            }
        }
    }
    let mut line = vec![(points[0][0], [points[0][1]])];
    for pair in points.windows(2) {
        let ([x0, a, midpoint, sharpness], [x1, b, ..]) = (pair[0], pair[1]);
        let middle = x0 + midpoint * (x1 - x0);
        // The two ends of sharpness are exact: straight lines that meet at the midpoint, and a step there.
        if sharpness > STEP {
            line.extend([(middle, [a]), (middle, [b])]);
        } else if sharpness < STRAIGHT {
            if midpoint != 0.5 {
                line.push((middle, [0.5 * (a + b)]));
            }
        } else {
            let differ = |a: [f64; 1], b: [f64; 1]| (a[0] - b[0]).abs() > 0.5 / 255.0;
            resample(x0, x1, |t| [between(a, b, midpoint, sharpness, t)], differ, &mut line);
            continue;
        }
        line.push((x1, [b]));
    }
    Ok(Polyline(line))
}

/// Sharpness from which on VTK draws a step.
const STEP: f64 = 0.99;
/// Sharpness up to which VTK draws straight lines.
const STRAIGHT: f64 = 0.01;

/// VTK's curve (`vtkPiecewiseFunction`): t is moved so that the midpoint comes to ½, pressed towards ½ by the power
/// 1 + 10·sharpness, and put through a cubic Hermite curve whose end slopes fall with the sharpness.
fn between(a: f64, b: f64, midpoint: f64, sharpness: f64, t: f64) -> f64 {
    let midpoint = midpoint.clamp(1e-5, 1.0 - 1e-5);
    let s = if t < midpoint { 0.5 * t / midpoint } else { 0.5 + 0.5 * (t - midpoint) / (1.0 - midpoint) };
    let power = 1.0 + 10.0 * sharpness;
    let s = if s < 0.5 { 0.5 * libm::pow(2.0 * s, power) } else { 1.0 - 0.5 * libm::pow(2.0 * (1.0 - s), power) };
    let slope = (1.0 - sharpness) * (b - a);
    let (s2, s3) = (s * s, s * s * s);
    let value =
        (2.0 * s3 - 3.0 * s2 + 1.0) * a + (3.0 * s2 - 2.0 * s3) * b + (s3 - 2.0 * s2 + s) * slope + (s3 - s2) * slope;
    value.clamp(a.min(b), a.max(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn opacities(numbers: &[f64]) -> Result<Polyline<1>, FieldError> {
        super::opacities(numbers.as_chunks::<4>().0, |row, number| format!("{row}.{number}"))
    }

    #[test]
    fn straight_lines_are_exact() {
        let p = opacities(&[0.0, 0.0, 0.5, 0.0, 2.0, 1.0, 0.5, 0.0]).unwrap();
        assert_eq!(p.0, [(0.0, [0.0]), (2.0, [1.0])]);
        let p = opacities(&[0.0, 0.0, 0.25, 0.0, 2.0, 1.0, 0.5, 0.0]).unwrap();
        assert_eq!(p.0, [(0.0, [0.0]), (0.5, [0.5]), (2.0, [1.0])]);
    }

    #[test]
    fn full_sharpness_is_a_step_at_the_midpoint() {
        let p = opacities(&[0.0, 0.2, 0.75, 1.0, 4.0, 0.8, 0.5, 0.0]).unwrap();
        assert_eq!((p.below(3.0), p.above(3.0)), ([0.2], [0.8]));
        assert_eq!(p.below(2.9), [0.2]);
    }

    #[test]
    fn in_between_is_followed_closely() {
        let p = opacities(&[0.0, 0.1, 0.3, 0.5, 1.0, 0.9, 0.5, 0.0]).unwrap();
        for k in 0..=1000 {
            let t = f64::from(k) / 1000.0;
            let error = p.below(t)[0] - between(0.1, 0.9, 0.3, 0.5, t);
            assert!(error.abs() < 1.0 / 255.0, "{t}: {error}");
        }
        assert!((between(0.0, 1.0, 0.3, 0.5, 0.3) - 0.5).abs() < 1e-12);
    }
}
