//! Double-double numbers (Dekker 1971): sums of two f64 with some 31 digits, for the geometry of rays.
//!
//! A camera a million diagonals away, or axes that are nearly parallel, cost f64 the digits that a position in the volume needs. In these
//! numbers it keeps all of them, and what is exact in f64 stays exact.

use std::ops::{Add, Div, Mul, Neg, Sub};

use glam::DVec3;

/// A sum of two f64, the second below half a unit in the last place of the first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Double {
    high: f64,
    low: f64,
}

/// a + b without error (Knuth).
fn two_sum(a: f64, b: f64) -> Double {
    let high = a + b;
    let part = high - a;
    Double { high, low: (a - (high - part)) + (b - part) }
}

/// a b without error, but for underflow.
fn two_product(a: f64, b: f64) -> Double {
    let high = a * b;
    Double { high, low: a.mul_add(b, -high) }
}

impl Double {
    /// The number rounded to f64.
    pub(crate) fn round(self) -> f64 {
        self.high
    }

    /// The distance from the rounded number.
    pub(crate) fn rest(self) -> f64 {
        self.low
    }

    pub(crate) fn sqrt(self) -> Self {
        if self.high <= 0.0 {
            return Self::default();
        }
        // One step of Newton's iteration doubles the digits.
        let root = Self::from(self.high.sqrt());
        root + (self - root * root) / (root + root)
    }

    /// A product with a power of two.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Self { high: self.high * factor, low: self.low * factor }
    }

    /// sin and cos of an angle in [0, π/2], by Taylor's series at a sixteenth of it.
    pub(crate) fn sin_cos(self) -> (Self, Self) {
        let x = self.scaled(1.0 / 16.0);
        let square = x * x;
        let (mut sin, mut versine) = (Self::default(), Self::default());
        // versine = 1 − cos keeps its digits while the angle is doubled.
        for n in (1..=10).rev() {
            let (a, b) = (2.0 * f64::from(n), 2.0 * f64::from(n) + 1.0);
            sin = (Self::from(1.0) + sin) * square * Self::from(-1.0) / Self::from(a * b);
            versine = (Self::from(1.0) + versine) * square * Self::from(-1.0) / Self::from(a * (a - 1.0));
        }
        let mut sin = x * (Self::from(1.0) + sin);
        let mut versine = -versine;
        for _ in 0..4 {
            let cos = Self::from(1.0) - versine;
            (sin, versine) = ((sin * cos).scaled(2.0), (sin * sin).scaled(2.0));
        }
        (sin, Self::from(1.0) - versine)
    }

    /// An angle in degrees, in radians.
    pub(crate) fn radians(degrees: f64) -> Self {
        // π to 32 digits.
        let pi = Self { high: std::f64::consts::PI, low: 1.224_646_799_147_353_2e-16 };
        pi * Self::from(degrees) / Self::from(180.0)
    }
}

impl From<f64> for Double {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Add for Double {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let high = two_sum(self.high, other.high);
        let low = two_sum(self.low, other.low);
        let sum = two_sum(high.high, high.low + low.high);
        two_sum(sum.high, sum.low + low.low)
    }
}

impl Neg for Double {
    type Output = Self;
    fn neg(self) -> Self {
        Self { high: -self.high, low: -self.low }
    }
}

impl Sub for Double {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Double {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let product = two_product(self.high, other.high);
        two_sum(product.high, product.low + (self.high * other.low + self.low * other.high))
    }
}

impl Div for Double {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let first = Self::from(self.high / other.high);
        let rest = self - first * other;
        let second = Self::from(rest.high / other.high);
        let rest = rest - second * other;
        first + second + Self::from(rest.high / other.high)
    }
}

/// A vector of them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Double3(pub(crate) [Double; 3]);

impl Double3 {
    pub(crate) fn dot(self, other: Self) -> Double {
        self.0[0] * other.0[0] + self.0[1] * other.0[1] + self.0[2] * other.0[2]
    }

    pub(crate) fn cross(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([b * z - c * y, c * x - a * z, a * y - b * x])
    }

    pub(crate) fn map(self, f: impl Fn(Double) -> Double) -> Self {
        Self(self.0.map(f))
    }

    /// The vector scaled to length 1. (Scaled by a power of two first, so that squares neither underflow nor overflow.)
    pub(crate) fn normalized(self) -> Self {
        let largest = self.0.iter().fold(0.0f64, |m, x| m.max(x.round().abs()));
        let unit = self.map(|x| x.scaled(power_of_two_below(largest).recip()));
        let length = unit.dot(unit).sqrt();
        unit.map(|x| x / length)
    }

    pub(crate) fn round(self) -> DVec3 {
        DVec3::from_array(self.0.map(Double::round))
    }
}

/// The power of two that a number is 1 to 2 times; 1 for 0.
pub(crate) fn power_of_two_below(x: f64) -> f64 {
    if x > 0.0 && x.is_finite() { libm::exp2(libm::floor(libm::log2(x)).clamp(-1000.0, 1000.0)) } else { 1.0 }
}

impl From<DVec3> for Double3 {
    fn from(v: DVec3) -> Self {
        Self(v.to_array().map(Double::from))
    }
}

impl Add for Double3 {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|a| self.0[a] + other.0[a]))
    }
}

impl Sub for Double3 {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|a| self.0[a] - other.0[a]))
    }
}

impl Mul<Double> for Double3 {
    type Output = Self;
    fn mul(self, factor: Double) -> Self {
        self.map(|x| x * factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn d(x: f64) -> Double {
        Double::from(x)
    }

    fn near(a: Double, b: Double) -> bool {
        (a - b).round().abs() <= 1e-30 * b.round().abs().max(1e-300)
    }

    #[test]
    fn arithmetic_has_thirty_digits() {
        let third = d(1.0) / d(3.0);
        assert!(near(third * d(3.0), d(1.0)));
        let root = d(2.0).sqrt();
        assert!(near(root * root, d(2.0)));
        assert_eq!((d(1e16) + d(1.0) - d(1e16)).round(), 1.0);
        assert_eq!(d(0.75).sqrt().round(), 0.75f64.sqrt());
        assert_eq!((d(6.0) / d(1.5), d(4.0).sqrt().rest()), (d(4.0), 0.0));
    }

    #[test]
    fn sines_are_those_of_known_angles() {
        for (degrees, sin) in [(30.0, d(0.5)), (45.0, d(0.5).sqrt()), (60.0, d(0.75).sqrt()), (90.0, d(1.0))] {
            let (s, c) = Double::radians(degrees).sin_cos();
            assert!(near(s, sin), "{degrees}: {s:?}");
            assert!(near(s * s + c * c, d(1.0)), "{degrees}");
        }
    }

    #[test]
    fn vectors_are_normalized_at_any_scale() {
        for scale in [1e-200, 1.0, 1e200] {
            let v = Double3::from(DVec3::new(3.0, -4.0, 12.0) * scale).normalized();
            assert!(near(v.dot(v), d(1.0)));
        }
        assert_eq!(Double3::from(DVec3::Z * 5.0).normalized(), Double3::from(DVec3::Z));
    }
}
