//! Rounding down, where a machine has no instruction for it.

/// Largest whole number that is not above another: several times as fast as the standard library's where there is no instruction for it. Saturates.
#[inline]
pub(crate) fn floor(x: f64) -> i64 {
    let cut = x as i64;
    cut.saturating_sub(i64::from(cut as f64 > x))
}

#[cfg(test)]
mod tests {
    use super::floor;

    #[test]
    fn is_that_of_the_standard_library() {
        for x in [0.0, -0.0, 0.5, -0.5, 1.0, -1.0, 2.999, -2.001, 4e15, -4e15, 1e300, -1e300] {
            assert_eq!(floor(x), x.floor() as i64, "{x}");
        }
    }
}
