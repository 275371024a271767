//! Functions on a step of a ray, as cubics with a bound of what they miss.

/// Function of t ∈ [−1, 1]: c₀ + c₁t + c₂t² + c₃t³, and nowhere further from that than `rest` (a Taylor model; Berz & Makino 1998, *Verified
/// integration of ODEs and flows using differential algebraic methods on high-order Taylor models*).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Series {
    pub(super) c: [f64; 4],
    pub(super) rest: f64,
}

/// Rounding of one operation on numbers that add up to 1, with room.
const ROUNDING: f64 = 16.0 * f64::EPSILON;
/// Largest change, relative to the middle, of what is raised to a power by its binomial series.
const MAX_CHANGE: f64 = 0.5;

impl Series {
    /// Returns a constant.
    pub(super) const fn constant(x: f64) -> Self {
        Self { c: [x, 0.0, 0.0, 0.0], rest: 0.0 }
    }

    /// Returns a function of which only the range is known.
    pub(super) fn between(low: f64, high: f64) -> Self {
        Self { rest: 0.5 * (high - low), ..Self::constant(0.5 * (low + high)) }
    }

    /// Returns a bound of the distance from the value in the middle.
    pub(super) fn spread(&self) -> f64 {
        self.c[1].abs() + self.c[2].abs() + self.c[3].abs() + self.rest
    }

    /// Returns a bound of the magnitude.
    pub(super) fn size(&self) -> f64 {
        self.c[0].abs() + self.spread()
    }

    /// Returns bounds of the values.
    pub(super) fn range(&self) -> [f64; 2] {
        let spread = self.spread();
        [self.c[0] - spread, self.c[0] + spread]
    }

    pub(super) fn plus(&self, other: &Self) -> Self {
        let c = std::array::from_fn(|i| self.c[i] + other.c[i]);
        Self { c, rest: self.rest + other.rest + ROUNDING * (self.size() + other.size()) }
    }

    pub(super) fn times(&self, x: f64) -> Self {
        Self { c: self.c.map(|c| c * x), rest: (self.rest + ROUNDING * self.size()) * x.abs() }
    }

    /// Returns the product, up to t³.
    pub(super) fn product(&self, other: &Self) -> Self {
        let (a, b) = (&self.c, &other.c);
        let c = [
            a[0] * b[0],
            a[0] * b[1] + a[1] * b[0],
            a[0] * b[2] + a[1] * b[1] + a[2] * b[0],
            a[0] * b[3] + a[1] * b[2] + a[2] * b[1] + a[3] * b[0],
        ];
        let left_out = a[1].abs() * b[3].abs()
            + a[2].abs() * (b[2].abs() + b[3].abs())
            + a[3].abs() * (b[1].abs() + b[2].abs() + b[3].abs());
        let (size, other_size) = (self.size(), other.size());
        Self {
            c,
            rest: left_out + self.rest * other_size + other.rest * (size - self.rest) + ROUNDING * size * other_size,
        }
    }

    /// Returns a power of a function that is above 0; `None` where it changes too much for a series.
    pub(super) fn power(&self, p: f64) -> Option<Self> {
        self.changes_little().then(|| self.binomial(p, libm::pow(self.c[0], p))).filter(|power| power.rest.is_finite())
    }

    /// Returns one over the square root of a function that is above 0; `None` where it changes too much for a series.
    pub(super) fn inverse_root(&self) -> Option<Self> {
        self.changes_little().then(|| self.binomial(-0.5, 1.0 / self.c[0].sqrt())).filter(|root| root.rest.is_finite())
    }

    fn changes_little(&self) -> bool {
        self.spread() <= MAX_CHANGE * self.c[0] && self.c[0] > 0.0
    }

    /// Returns a power, that of the middle being given.
    ///
    /// With y = x/x₀ − 1, |y| ≤ ρ, the binomial series of (1 + y)ᵖ up to y³ misses at most |p(p − 1)(p − 2)(p − 3)|/24 · ρ⁴ times the largest
    /// (1 + y)^(p − 4) (Lagrange's remainder), which is at most e^(ρ(p − 4)), or, as −ln(1 − ρ) ≤ ρ/(1 − ρ), e^((4 − p)ρ/(1 − ρ)).
    fn binomial(&self, p: f64, of_middle: f64) -> Self {
        let relative = self.times(1.0 / self.c[0]);
        let y = Self { c: [0.0, relative.c[1], relative.c[2], relative.c[3]], ..relative };
        let rho = y.spread();
        let b2 = 0.5 * p * (p - 1.0);
        let b3 = b2 * (p - 2.0) / 3.0;
        let b4 = 0.25 * b3 * (p - 3.0);
        let plus = |series: Self, x: f64| series.plus(&Self::constant(x));
        let sum = plus(y.product(&plus(y.product(&plus(y.times(b3), b2)), p)), 1.0);
        let steepest = libm::exp(if p >= 4.0 { rho * (p - 4.0) } else { (4.0 - p) * rho / (1.0 - rho) });
        let rest = sum.rest + b4.abs() * rho * rho * rho * rho * steepest * (1.0 + ROUNDING);
        Self { rest, ..sum }.times(of_middle)
    }

    /// Returns the magnitude of a function that is not 0 anywhere; `None` where it may be.
    pub(super) fn magnitude(&self) -> Option<Self> {
        (self.c[0].abs() > self.spread()).then(|| if self.c[0] < 0.0 { self.times(-1.0) } else { *self })
    }

    /// Returns the better known of two descriptions of a function.
    pub(super) fn or(self, other: Self) -> Self {
        if self.rest <= other.rest { self } else { other }
    }

    /// Returns the part over [from, to] ⊂ [0, 1] of a cubic by its powers of a parameter from 0 to 1, with what that is off by.
    pub(super) fn part_of(powers: &[f64; 4], [from, to]: [f64; 2], off: f64) -> Self {
        let (m, h) = (0.5 * (from + to), 0.5 * (to - from));
        let [a, b, c, d] = *powers;
        let c = [
            a + m * (b + m * (c + m * d)),
            h * (b + m * (2.0 * c + 3.0 * m * d)),
            h * h * (c + 3.0 * m * d),
            h * h * h * d,
        ];
        Self { c, rest: off }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn at(s: &Series, t: f64) -> f64 {
        s.c[0] + t * (s.c[1] + t * (s.c[2] + t * s.c[3]))
    }

    proptest! {
        /// Sums, products and powers stay within their rest of the functions that they stand for, whatever those are within their own rests.
        #[test]
        fn operations_keep_their_bounds(
            a in prop::array::uniform4(-1.0f64..1.0), b in prop::array::uniform4(-1.0f64..1.0),
            (p, flat, off) in (-3.0f64..60.0, 0.0f64..1.0, prop::array::uniform2(-1e-3f64..1e-3)),
        ) {
            let flat = flat * flat;
            let [a, b] = [a, b].map(|c| Series { c: [1.5 + c[0], flat * c[1], flat * c[2], flat * c[3]], rest: 1e-3 });
            let power = a.power(p);
            for i in 0..=16 {
                let t = f64::from(i) / 8.0 - 1.0;
                let (x, y) = (at(&a, t) + off[0], at(&b, t) + off[1]);
                prop_assert!((x + y - at(&a.plus(&b), t)).abs() <= a.plus(&b).rest);
                prop_assert!((x * y - at(&a.product(&b), t)).abs() <= a.product(&b).rest);
                if let Some(power) = power {
                    prop_assert!((x.powf(p) - at(&power, t)).abs() <= power.rest, "{x} {p} {power:?}");
                }
                let [low, high] = a.range();
                prop_assert!(low <= x && x <= high);
            }
        }
    }

    #[test]
    fn powers_of_what_hardly_changes_are_known_well() {
        let x = Series { c: [0.9, 0.01, 0.005, -0.002], rest: 0.0 };
        let root = x.inverse_root().unwrap();
        assert!((root.c[1] - x.power(-0.5).unwrap().c[1]).abs() < 1e-15);
        // Squares leave out a few products of the smaller coefficients, beyond t³.
        assert!(root.rest < 5e-5, "{root:?}");
        assert!(Series { c: [0.9, 0.4, 0.1, 0.0], rest: 0.0 }.power(2.0).is_none());
        assert!(Series::between(-0.1, 0.5).magnitude().is_none());
    }

    #[test]
    fn parts_of_a_cubic() {
        let powers = [0.3, -1.0, 2.0, 0.7];
        let part = Series::part_of(&powers, [0.2, 0.6], 0.0);
        for t in [-1.0, -0.3, 0.5, 1.0] {
            let s: f64 = 0.4 + 0.2 * t;
            let want = powers[0] + s * (powers[1] + s * (powers[2] + s * powers[3]));
            assert!((at(&part, t) - want).abs() < 1e-15);
        }
    }
}
