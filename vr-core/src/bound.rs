//! Upper bound of an error: a number that is never NaN and never negative.
//!
//! A comparison with NaN is false and `f64::max` drops it, so an error that became NaN (∞·0, ∞ − ∞) passes every test for being
//! small. Here it becomes +∞ where it arises: nothing is known then, and that is what a bound of +∞ says.

use std::ops::{Add, AddAssign, Div, Mul};

/// Upper bound of an error, in [0, +∞].
///
/// # Examples
/// ```
/// use vr_core::bound::Bound;
///
/// let error = Bound::new(1e-3) + Bound::new(-2e-3);
/// assert!(error.within(0.01) && error.value() >= 3e-3);
/// // An error that cannot be computed is unbounded, not small.
/// assert_eq!(Bound::new(f64::INFINITY - f64::INFINITY), Bound::UNKNOWN);
/// assert!(!(error + f64::NAN).within(0.01));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Bound(f64);

impl Bound {
    /// No error at all.
    pub const ZERO: Self = Self(0.0);
    /// The bound of an error of which nothing is known.
    pub const UNKNOWN: Self = Self(f64::INFINITY);

    /// The bound of a size, whatever its sign; +∞ for NaN.
    pub fn new(size: f64) -> Self {
        if size.is_nan() { Self::UNKNOWN } else { Self(size.abs()) }
    }

    /// The number; never NaN.
    pub fn value(self) -> f64 {
        self.0
    }

    /// True if something is known.
    pub fn is_finite(self) -> bool {
        self.0.is_finite()
    }

    /// True if it is no more than a limit; false for a limit of NaN.
    pub fn within(self, limit: f64) -> bool {
        self.0 <= limit
    }

    /// The larger one.
    pub fn max(self, other: impl Into<Self>) -> Self {
        Self(self.0.max(other.into().0))
    }

    /// The smaller one: both hold.
    pub fn min(self, other: impl Into<Self>) -> Self {
        Self(self.0.min(other.into().0))
    }
}

impl From<f64> for Bound {
    fn from(size: f64) -> Self {
        Self::new(size)
    }
}

impl<B: Into<Self>> Add<B> for Bound {
    type Output = Self;
    fn add(self, other: B) -> Self {
        Self(self.0 + other.into().0)
    }
}

impl<B: Into<Self>> AddAssign<B> for Bound {
    fn add_assign(&mut self, other: B) {
        *self = *self + other;
    }
}

/// Product in which 0·∞ = ∞: a factor of which nothing is known may hide anything. A caller for whom a factor of 0 means that there is
/// no error says so before.
impl<B: Into<Self>> Mul<B> for Bound {
    type Output = Self;
    fn mul(self, other: B) -> Self {
        Self::new(self.0 * other.into().0)
    }
}

/// Quotient in which 0/0 = ∞, as x/0.
impl<B: Into<Self>> Div<B> for Bound {
    type Output = Self;
    fn div(self, other: B) -> Self {
        Self::new(self.0 / other.into().0)
    }
}

impl std::iter::Sum for Bound {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::ZERO, Self::add)
    }
}

/// The largest of some sizes: +∞ if one of them is NaN. (`fold(0.0, f64::max)` would leave it out.)
pub fn largest(sizes: impl IntoIterator<Item = f64>) -> f64 {
    sizes.into_iter().fold(Bound::ZERO, |max, x| max.max(Bound::new(x))).value()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nan_is_never_small() {
        let bad = Bound::new(f64::NAN);
        assert_eq!(bad, Bound::UNKNOWN);
        assert!(!bad.within(1e300) && !bad.is_finite() && bad.within(f64::INFINITY));
        assert!(!Bound::ZERO.within(f64::NAN));
        assert_eq!(Bound::ZERO.max(f64::NAN), Bound::UNKNOWN);
        assert_eq!(Bound::new(1.0) + f64::NAN, Bound::UNKNOWN);
        assert_eq!(Bound::new(1.0).min(f64::NAN).value(), 1.0);
        assert_eq!(largest([0.5, f64::NAN, 0.25]), f64::INFINITY);
        assert_eq!(largest([0.5, -2.0]), 2.0);
    }

    #[test]
    fn nothing_times_the_unknown_is_unknown() {
        assert_eq!(Bound::ZERO * Bound::UNKNOWN, Bound::UNKNOWN);
        assert_eq!(Bound::UNKNOWN * 0.0, Bound::UNKNOWN);
        assert_eq!(Bound::ZERO / 0.0, Bound::UNKNOWN);
        assert_eq!(Bound::UNKNOWN / Bound::UNKNOWN, Bound::UNKNOWN);
        assert_eq!((Bound::new(-2.0) * 3.0).value(), 6.0);
        assert_eq!([1.0, 2.0].map(Bound::new).into_iter().sum::<Bound>().value(), 3.0);
    }
}
