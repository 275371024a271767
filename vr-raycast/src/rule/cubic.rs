//! Cubics along a step, and the points at which they take given values.

use crate::root::monotone_root;

/// Cubic Σ cₖ uᵏ, where u is the fraction of a step, from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cubic(pub(crate) [f64; 4]);

impl Cubic {
    /// Returns the straight line from one value to another.
    pub(crate) fn line(front: f64, back: f64) -> Self {
        Self([front, back - front, 0.0, 0.0])
    }

    /// Returns the parabola through the values at 0, ½ and 1.
    pub(crate) fn parabola(front: f64, middle: f64, back: f64) -> Self {
        // Twice how far the middle lies above the straight line.
        let bulge = 2.0 * middle - (front + back);
        Self([front, back - front + 2.0 * bulge, -2.0 * bulge, 0.0])
    }

    /// Fractions at which [`Cubic::through`] takes its values: the zeros of the fourth Chebyshev polynomial, between which and
    /// to the ends of the step interpolation magnifies rounding least.
    pub(crate) const NODES: [f64; 4] =
        [0.038_060_233_744_356_63, 0.308_658_283_817_455_1, 0.691_341_716_182_544_9, 0.961_939_766_255_643_4];

    /// Returns the cubic through the values at [`Cubic::NODES`]; a constant to the last bit where they are equal.
    pub(crate) fn through(values: [f64; 4]) -> Self {
        // Newton's divided differences, expanded.
        let x = Self::NODES;
        let mut d = values;
        for level in 1..4 {
            for i in (level..4).rev() {
                d[i] = (d[i] - d[i - 1]) / (x[i] - x[i - level]);
            }
        }
        let mut c = [d[3], 0.0, 0.0, 0.0];
        for i in (0..3).rev() {
            for k in (1..4).rev() {
                c[k] = c[k - 1] - x[i] * c[k];
            }
            c[0] = d[i] - x[i] * c[0];
        }
        Self(c)
    }

    /// Returns the value at a fraction.
    #[inline]
    pub(crate) fn at(&self, u: f64) -> f64 {
        let [a, b, c, d] = self.0;
        a + u * (b + u * (c + u * d))
    }

    fn slope(&self, u: f64) -> f64 {
        let [_, b, c, d] = self.0;
        b + u * (2.0 * c + u * 3.0 * d)
    }

    /// True if the cubic is constant to the last bit.
    pub(crate) fn is_constant(&self) -> bool {
        self.0[1..] == [0.0; 3]
    }

    /// Returns the ends of the parts of [0, 1] on which it rises or falls throughout: 0, up to two turning points, 1.
    fn monotone_parts(&self) -> ([f64; 4], usize) {
        let [_, b, c, d] = self.0;
        let (mut ends, mut count) = ([0.0; 4], 1);
        // 3d u² + 2c u + b = 0. The root of larger magnitude first, the other from the product of both: no digits cancel.
        let discriminant = c * c - 3.0 * b * d;
        if discriminant > 0.0 || c == 0.0 && d == 0.0 {
            let q = -(c + discriminant.max(0.0).sqrt().copysign(c));
            let mut turns = [q / (3.0 * d), b / q];
            if turns[0] > turns[1] {
                turns.swap(0, 1);
            }
            for u in turns {
                // False for NaN.
                if u > ends[count - 1] && u < 1.0 {
                    ends[count] = u;
                    count += 1;
                }
            }
        }
        ends[count] = 1.0;
        (ends, count + 1)
    }

    /// Appends every u in (0, 1) at which it passes one of `values` (ascending), in ascending order.
    pub(crate) fn crossings(&self, values: &[f64], out: &mut Vec<f64>) {
        let (ends, count) = self.monotone_parts();
        for part in ends[..count].windows(2) {
            let (start, end) = (self.at(part[0]), self.at(part[1]));
            let (low, high) = (start.min(end), start.max(end));
            let first = values.partition_point(|&v| v <= low);
            let last = values.partition_point(|&v| v < high).max(first);
            let found = out.len();
            out.extend(values[first..last].iter().map(|&v| self.crossing(v, [part[0], part[1]], start < end)));
            if start > end {
                out[found..].reverse();
            }
            // An extreme may lie on a value.
            if part[1] < 1.0 && values.binary_search_by(|v| v.total_cmp(&end)).is_ok() {
                out.push(part[1]);
            }
        }
    }

    /// Returns the point where it passes `value`, between two ends between which it is monotone.
    fn crossing(&self, value: f64, ends: [f64; 2], rising: bool) -> f64 {
        monotone_root(ends, rising, |u| (self.at(u) - value, self.slope(u)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goes_through_its_values() {
        let p = Cubic([0.3, -1.7, 2.5, -0.9]);
        let q = Cubic::through(Cubic::NODES.map(|u| p.at(u)));
        assert!((0..4).all(|k| (p.0[k] - q.0[k]).abs() < 1e-13), "{q:?}");
        let c = Cubic::through([0.1; 4]);
        assert!(c.is_constant() && c.at(0.7) == 0.1);
        let parabola = Cubic::parabola(1.0, 5.0, 3.0);
        assert_eq!([0.0, 0.5, 1.0].map(|u| parabola.at(u)), [1.0, 5.0, 3.0]);
        assert_eq!(Cubic::line(1.0, 3.0).at(0.5), 2.0);
    }

    #[test]
    fn finds_all_crossings_in_order() {
        // (u − r₀)(u − r₁)(u − r₂)
        let roots = |r: [f64; 3]| {
            Cubic([-r[0] * r[1] * r[2], r[0] * r[1] + r[1] * r[2] + r[0] * r[2], -(r[0] + r[1] + r[2]), 1.0])
        };
        for r in [[0.1, 0.5, 0.9], [0.2, 0.2 + 1e-5, 0.7], [-1.0, 0.4, 3.0], [-2.0, -1.0, 0.25]] {
            for scale in [1.0, -1e6, 1e-9] {
                let p = Cubic(roots(r).0.map(|c| c * scale));
                let mut found = Vec::new();
                p.crossings(&[0.0], &mut found);
                let wanted: Vec<f64> = r.into_iter().filter(|x| (0.0..1.0).contains(x)).collect();
                assert_eq!(found.len(), wanted.len(), "{r:?} {found:?}");
                // Two roots 10⁻⁵ apart are known to 10⁻¹⁶/10⁻⁵.
                assert!(found.iter().zip(&wanted).all(|(f, w)| (f - w).abs() < 1e-10), "{r:?} {found:?}");
            }
        }
    }

    #[test]
    fn many_values_on_lines_parabolas_and_constants() {
        let values = [-0.5, 0.0, 0.25, 0.5, 1.0];
        let found = |p: Cubic| {
            let mut found = Vec::new();
            p.crossings(&values, &mut found);
            found
        };
        assert_eq!(found(Cubic::line(1.0, 0.0)), [0.5, 0.75]);
        assert_eq!(found(Cubic::line(0.5, 0.5)), [0.0; 0]);
        // Touches 0.5 from below and comes back.
        let touch = found(Cubic::parabola(0.1, 0.5, 0.1));
        assert!(touch.contains(&0.5) && touch.len() == 3, "{touch:?}");
        let wave = Cubic::through(Cubic::NODES.map(|u| 1.2 * libm::sin(9.0 * u)));
        let found = found(wave);
        assert!(found.windows(2).all(|w| w[0] <= w[1]), "{found:?}");
        assert!(found.iter().all(|&u| values.iter().any(|v| (wave.at(u) - v).abs() < 1e-13)));
    }
}
