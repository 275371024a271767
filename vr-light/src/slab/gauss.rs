//! Gauss's points.

/// Points and weights of Gauss's rule on [−1, 1]: exact for polynomials up to degree 2n − 1.
pub(super) fn gauss_legendre(n: usize) -> Vec<[f64; 2]> {
    let mut rule = vec![[0.0; 2]; n];
    for i in 0..n.div_ceil(2) {
        // Newton's iteration from an asymptotic root; it settles within five steps.
        let mut x = libm::cos(std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5));
        let mut slope = 1.0;
        for _ in 0..10 {
            let [last, before] = legendre_pair(n, x);
            slope = n as f64 * (before - x * last) / ((1.0 - x) * (1.0 + x));
            let step = last / slope;
            x -= step;
            if step.abs() < 1e-16 {
                break;
            }
        }
        let weight = 2.0 / ((1.0 - x) * (1.0 + x) * slope * slope);
        rule[i] = [-x, weight];
        rule[n - 1 - i] = [x, weight];
    }
    if n % 2 == 1 {
        rule[n / 2][0] = 0.0;
    }
    rule
}

/// Legendre's polynomials Pₙ and Pₙ₋₁ at x, n ≥ 1.
fn legendre_pair(n: usize, x: f64) -> [f64; 2] {
    let (mut last, mut before) = (x, 1.0);
    for l in 1..n {
        (last, before) = (next_legendre(l, x, last, before), last);
    }
    [last, before]
}

/// P of degree l + 1 from those of degree l and l − 1.
fn next_legendre(l: usize, x: f64, last: f64, before: f64) -> f64 {
    let l = l as f64;
    ((2.0 * l + 1.0) * x * last - l * before) / (l + 1.0)
}

/// Legendre's polynomials P₀ … of `count` degrees at x.
pub(super) fn legendre(count: usize, x: f64) -> Vec<f64> {
    let mut values = Vec::with_capacity(count);
    for l in 0..count {
        values.push(match l {
            0 => 1.0,
            1 => x,
            _ => next_legendre(l - 1, x, values[l - 1], values[l - 2]),
        });
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_exact_for_polynomials() {
        for n in [1, 2, 3, 8, 31, 128] {
            let rule = gauss_legendre(n);
            for degree in [0, 1, 2, 5, 2 * n - 1, 2 * n - 2] {
                let sum: f64 = rule.iter().map(|[x, w]| w * x.powi(degree as i32)).sum();
                let exact = if degree % 2 == 1 { 0.0 } else { 2.0 / (degree as f64 + 1.0) };
                if degree < 2 * n {
                    assert!((sum - exact).abs() < 1e-13, "{n} points, degree {degree}: {sum} for {exact}");
                }
            }
        }
    }
}
