//! Cubic along a piece of a ray, by its Bernstein coefficients.

use vr_core::Real;

/// Cubic over t ∈ [0, 1] in the Bernstein basis: the coefficients' hull holds the curve, and the first and the last are its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cubic<R>(pub(super) [R; 4]);

impl<R: Real> Cubic<R> {
    /// Returns a trilinear function on the straight way from one corner of a box to the opposite one.
    ///
    /// `corners` are its values at the box's corners, x fastest, seen from the point where the way begins. The blossom of the cubic
    /// is the mean of the trilinear function over the orders of its three arguments (Ramshaw 1989, *Blossoms are polar forms*); so
    /// the coefficients are means of corners, and no rounding is magnified.
    fn of_trilinear(corners: &[R; 8]) -> Self {
        let third = R::from_f64(1.0 / 3.0);
        Self([
            corners[0],
            (corners[1] + corners[2] + corners[4]) * third,
            (corners[6] + corners[5] + corners[3]) * third,
            corners[7],
        ])
    }

    /// Returns a trilinear function, by its values at a cell's corners (x fastest), on a straight way through the cell: from the first to the second fraction of
    /// the cell along each axis.
    pub(super) fn across_box(mut corners: [R; 8], part: &[[R; 2]; 3]) -> Self {
        // The same function, seen from the box between the two ends.
        for (axis, t) in part.iter().enumerate() {
            for i in (0..8).filter(|i| i >> axis & 1 == 0) {
                let j = i | 1 << axis;
                let (a, b) = (corners[i], corners[j]);
                corners[i] = a + t[0] * (b - a);
                corners[j] = a + t[1] * (b - a);
            }
        }
        Self::of_trilinear(&corners)
    }

    /// Returns bounds of the values.
    pub(super) fn hull(&self) -> (f64, f64) {
        let [a, b, c, d] = self.0;
        (a.min(b).min(c.min(d)).to_f64(), a.max(b).max(c.max(d)).to_f64())
    }

    /// True if the coefficients rise or fall throughout: the curve does, too, then.
    pub(super) fn is_monotone(&self) -> bool {
        let [a, b, c, d] = self.0;
        (a <= b && b <= c && c <= d) || (a >= b && b >= c && c >= d)
    }

    /// Returns the parts before and behind a parameter (de Casteljau 1959).
    pub(super) fn split(&self, t: R) -> (Self, Self) {
        let mix = |a: R, b: R| a + t * (b - a);
        let [a, b, c, d] = self.0;
        let (ab, bc, cd) = (mix(a, b), mix(b, c), mix(c, d));
        let (abc, bcd) = (mix(ab, bc), mix(bc, cd));
        let middle = mix(abc, bcd);
        (Self([a, ab, abc, middle]), Self([middle, bcd, cd, d]))
    }

    /// Returns the value at a parameter.
    pub(super) fn at(&self, t: R) -> R {
        self.split(t).0.0[3]
    }

    /// Returns the derivative by t.
    pub(super) fn slope(&self, t: R) -> R {
        let [a, b, c, d] = self.0;
        let (p, q, r) = (b - a, c - b, d - c);
        let mix = |a: R, b: R| a + t * (b - a);
        R::from_f64(3.0) * mix(mix(p, q), mix(q, r))
    }

    /// Returns the coefficients of the powers of t, the constant first.
    pub(super) fn powers(&self) -> [R; 4] {
        let [a, b, c, d] = self.0;
        let three = R::from_f64(3.0);
        let (ab, bc) = (b - a, c - b);
        [a, three * ab, three * (bc - ab), (d - a) - three * bc]
    }

    /// Returns the coefficients of the powers of x = 2t − 1 ∈ [−1, 1], the constant first.
    pub(super) fn about_middle(&self) -> [R; 4] {
        let [a, b, c, d] = self.0;
        let (three, eighth) = (R::from_f64(3.0), R::from_f64(0.125));
        let (outer, inner) = (d - a, c - b);
        [
            ((a + d) + three * (b + c)) * eighth,
            three * (outer + inner) * eighth,
            three * ((a - b) + (d - c)) * eighth,
            (outer - three * inner) * eighth,
        ]
    }
}

impl Cubic<f64> {
    /// Returns the cubic of coefficients of the powers of x = 2t − 1 ∈ [−1, 1], the constant first.
    pub(super) fn of_powers_about_middle([a, b, c, d]: [f64; 4]) -> Self {
        let (even, odd, third) = (a + c, b + d, 1.0 / 3.0);
        Self([even - odd, a - c * third - (b * third - d), a - c * third + (b * third - d), even + odd])
    }

    /// Returns the parameters between 0 and 1 at which the slope is 0, as far as there are any.
    pub(super) fn turns(&self) -> [Option<f64>; 2] {
        let [a, b, c, d] = self.0;
        let (p, q, r) = (b - a, c - b, d - c);
        // The slope is 3 (p (1 − t)² + 2 q t (1 − t) + r t²): a quadratic, solved without cancellation.
        let (second, first) = (p - 2.0 * q + r, q - p);
        let root = (first * first - second * p).max(0.0).sqrt();
        let sum = -(first + root.copysign(first));
        [sum / second, p / sum].map(|t| (t > 0.0 && t < 1.0).then_some(t))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_where_the_slope_is_0() {
        for cubic in
            [[0.0, 1.0, -1.0, 0.0], [0.0, 1.0, 1.0, 0.0], [0.0, 1.0, 2.0, 3.0], [1.0; 4], [0.0, 3e8, -1.0, 2.0]]
        {
            let cubic = Cubic(cubic);
            let turns: Vec<f64> = cubic.turns().into_iter().flatten().collect();
            let size = cubic.0.iter().fold(1.0f64, |m, c| m.max(c.abs()));
            assert!(turns.iter().all(|&t| cubic.slope(t).abs() < 1e-13 * size), "{turns:?}");
            let extremes = [0.0, 1.0].into_iter().chain(turns).map(|t| cubic.at(t));
            let (low, high) = extremes.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
            assert!(
                (0..=64).map(|i| cubic.at(f64::from(i) / 64.0)).all(|x| low - 1e-12 <= x && x <= high + 1e-12 * size)
            );
        }
    }

    #[test]
    fn follows_a_trilinear_function() {
        let corner = [0.3, -1.0, 2.0, 0.7, 1.1, -0.4, 0.2, 5.0];
        let f = |x: f64, y: f64, z: f64| {
            let w = |i: usize, a: usize, x: f64| if i >> a & 1 == 1 { x } else { 1.0 - x };
            (0..8).map(|i| corner[i] * w(i, 0, x) * w(i, 1, y) * w(i, 2, z)).sum::<f64>()
        };
        let cubic = Cubic::of_trilinear(&corner);
        let (left, right) = cubic.split(0.3);
        let powers = cubic.about_middle();
        let plain = cubic.powers();
        let (low, high) = cubic.hull();
        for i in 0..=20 {
            let t = f64::from(i) / 20.0;
            let want = f(t, t, t);
            assert!((cubic.at(t) - want).abs() < 1e-14);
            assert!(low <= want && want <= high);
            let x = 2.0 * t - 1.0;
            let sum = powers[0] + x * (powers[1] + x * (powers[2] + x * powers[3]));
            assert!((sum - want).abs() < 1e-14);
            let sum = plain[0] + t * (plain[1] + t * (plain[2] + t * plain[3]));
            assert!((sum - want).abs() < 1e-14);
            let part = if t <= 0.3 { left.at(t / 0.3) } else { right.at((t - 0.3) / 0.7) };
            assert!((part - want).abs() < 1e-14);
            let slope = (f(t + 1e-6, t + 1e-6, t + 1e-6) - f(t - 1e-6, t - 1e-6, t - 1e-6)) / 2e-6;
            assert!((cubic.slope(t) - slope).abs() < 1e-8);
        }
    }
}
