//! Values of 64 bits as the 32-bit floats that memory holds, with an account of what that changes.

/// Count of values that could not be kept as they are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Narrowed {
    /// All values.
    pub count: usize,
    /// Values that are rounded.
    pub rounded: usize,
    /// Values that are NaN.
    pub nan: usize,
    /// Values that are infinite, or too large for 32 bits: they become NaN.
    pub infinite: usize,
}

impl Narrowed {
    /// Converts values; infinite ones become NaN, as every volume counts them.
    pub fn take(&mut self, values: &[f64]) -> Vec<f32> {
        self.count += values.len();
        let narrow = |&value: &f64| {
            let narrow = value as f32;
            if narrow.is_finite() {
                self.rounded += usize::from(f64::from(narrow) != value);
                return narrow;
            }
            *if value.is_nan() { &mut self.nan } else { &mut self.infinite } += 1;
            f32::NAN
        };
        values.iter().map(narrow).collect()
    }

    /// Notes on what was changed, and on what is missing.
    pub fn notes(&self) -> Vec<String> {
        let Self { count, rounded, nan, infinite } = *self;
        let all = [
            (rounded, "are rounded to 32-bit floats"),
            (nan, "are NaN: there is vacuum around them"),
            (infinite, "are infinite, or beyond f32, and count as NaN"),
        ];
        all.into_iter().filter(|&(n, _)| n > 0).map(|(n, what)| format!("{n} of {count} values {what}")).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_changes_is_counted() {
        let mut narrowed = Narrowed::default();
        let values = narrowed.take(&[0.5, 0.1, f64::NAN, f64::INFINITY, 1e300]);
        assert_eq!((values[0], values[1]), (0.5, 0.1));
        assert!(values[2..].iter().all(|x| x.is_nan()));
        assert_eq!(narrowed, Narrowed { count: 5, rounded: 1, nan: 1, infinite: 2 });
        assert_eq!(narrowed.notes().len(), 3);
    }
}
