//! Points at which a polynomial takes given values: a ray is cut there.

use vr_core::field::{Bernstein, Poly};

/// Appends every t in (−1, 1) at which `p` takes one of `values` (sorted), in no particular order.
///
/// The interval is halved until the polynomial is monotone (told by its Bernstein coefficients) or no value lies in its hull;
/// there each value is bracketed and found to the last bits. Where the polynomial only touches a value, one point near the
/// touch is given: cutting there is harmless.
pub fn crossings(p: &Poly, values: &[f64], out: &mut Vec<f64>) {
    if p.degree() > 0 && !values.is_empty() {
        isolate(p, &p.bernstein(), -1.0, 1.0, values, out);
    }
}

fn isolate(p: &Poly, hull: &Bernstein, a: f64, b: f64, values: &[f64], out: &mut Vec<f64>) {
    let (low, high) = hull.hull();
    // The change to the Bernstein basis magnifies rounding by up to 4ⁿ: a value just outside may be inside.
    let slack = low.abs().max(high.abs()) * f64::EPSILON * 4f64.powi(p.degree() as i32);
    let first = values.partition_point(|&v| v < low - slack);
    let end = values.partition_point(|&v| v <= high + slack);
    let values = &values[first..end];
    if values.is_empty() {
        return;
    }
    if hull.is_monotone() {
        let (start, end) = (p.at(a), p.at(b));
        for &v in values {
            // A value met at an end of the interval cuts there; ±1 itself is no cut.
            if start == v || end == v {
                let t = if start == v { a } else { b };
                if t.abs() < 1.0 {
                    out.push(t);
                }
            } else if (start < v) != (end < v) {
                out.push(root(p, v, a, b, start < v));
            }
        }
    } else if b - a < 1e-14 {
        out.push(0.5 * (a + b));
    } else {
        let middle = 0.5 * (a + b);
        let (left, right) = hull.halves();
        isolate(p, &left, a, middle, values, out);
        isolate(p, &right, middle, b, values, out);
    }
}

/// The root of p − v in a bracket where p is monotone: Newton's steps, bisection where they leave the bracket.
fn root(p: &Poly, v: f64, mut a: f64, mut b: f64, rising: bool) -> f64 {
    let slope = p.derivative();
    let mut t = 0.5 * (a + b);
    for _ in 0..80 {
        let f = p.at(t) - v;
        if f == 0.0 {
            break;
        }
        if (f < 0.0) == rising {
            a = t;
        } else {
            b = t;
        }
        let newton = t - f / slope.at(t);
        let next = if newton > a && newton < b { newton } else { 0.5 * (a + b) };
        if next == t || b - a <= f64::EPSILON * 0.5 {
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
    fn finds_simple_close_and_touching_roots() {
        // (t − 0.2)(t − 0.2 − 1e-6)(t + 0.5)
        let line = |r: f64| Poly::new(&[-r, 1.0]);
        let p = line(0.2) * line(0.2 + 1e-6) * line(-0.5);
        let mut found = Vec::new();
        crossings(&p, &[0.0], &mut found);
        found.sort_by(f64::total_cmp);
        assert_eq!(found.len(), 3, "{found:?}");
        for (f, r) in found.iter().zip([-0.5, 0.2, 0.2 + 1e-6]) {
            assert!((f - r).abs() < 1e-9, "{f} {r}");
        }
        let touching = line(0.3) * line(0.3);
        found.clear();
        crossings(&touching, &[0.0], &mut found);
        assert!(found.iter().all(|t| (t - 0.3).abs() < 1e-7));
    }

    #[test]
    fn finds_many_values_of_a_wave() {
        // T₉ takes every value in (−1, 1) nine times.
        let t = Poly::new(&[0.0, 1.0]);
        let (mut before, mut now) = (Poly::constant(1.0), t);
        for _ in 1..9 {
            (before, now) = (now, t * now * 2.0 + before * -1.0);
        }
        let mut found = Vec::new();
        crossings(&now, &[-0.9, 0.1, 0.999], &mut found);
        assert_eq!(found.len(), 27);
        assert!(found.iter().all(|&x| [-0.9, 0.1, 0.999].iter().any(|v| (now.at(x) - v).abs() < 1e-12)));
    }
}
