//! Stretches of a ray.

/// Part of a ray on which a field changes at one pace, and keeps within a range.
///
/// # Examples
/// ```
/// use vr_core::field::Stretch;
///
/// let fine = Stretch { from: 1.0, to: 2.0, spacing: 0.5, range: [0.0, 0.25] };
/// let coarse = Stretch { from: 2.0, to: 4.0, spacing: 1.0, ..fine };
/// assert!(fine.touches(&coarse));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// World distance along the ray at which it begins.
    pub from: f64,
    /// World distance at which it ends; above `from`.
    pub to: f64,
    /// World length in which steps are counted here, as [`Field::spacing`](super::Field::spacing) is for the whole field.
    pub spacing: f64,
    /// Two numbers that enclose every value on it.
    pub range: [f32; 2],
}

impl Stretch {
    /// True if another one begins where this one ends, up to rounding: there is no vacuum between them.
    pub fn touches(&self, next: &Self) -> bool {
        next.from - self.to <= 1e-9 * self.spacing.min(next.spacing)
    }
}
