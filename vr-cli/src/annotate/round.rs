//! Round numbers: 1, 2 and 5 times powers of ten.

/// Returns the largest round number that is not above `x`, which is positive and finite.
pub fn below(x: f64) -> f64 {
    let power = power_of_ten(x.log10().floor() as i32);
    // A logarithm may be off by a bit: at powers of ten either neighbour of the true one may come out.
    let candidates = [10.0, 5.0, 2.0, 1.0, 0.5].map(|k| k * power);
    candidates.into_iter().find(|&c| c <= x * (1.0 + 1e-12)).unwrap_or(power)
}

/// Returns the smallest round number that is not below `x`, which is positive and finite.
pub fn above(x: f64) -> f64 {
    let power = power_of_ten(x.log10().floor() as i32);
    let candidates = [1.0, 2.0, 5.0, 10.0, 20.0].map(|k| k * power);
    candidates.into_iter().find(|&c| c >= x * (1.0 - 1e-12)).unwrap_or(10.0 * power)
}

/// Returns a power of ten as literals are rounded.
pub fn power_of_ten(exponent: i32) -> f64 {
    format!("1e{exponent}").parse().unwrap_or(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_numbers_enclose_every_number() {
        assert_eq!([below(1.0), below(1.9), below(4.99), below(70.0), below(0.001)], [1.0, 1.0, 2.0, 50.0, 0.001]);
        assert_eq!([above(1.0), above(1.1), above(4.99), above(70.0), above(0.001)], [1.0, 2.0, 5.0, 100.0, 0.001]);
        for exponent in -30..30 {
            for k in [1.0, 1.3, 2.0, 3.7, 5.0, 9.99] {
                let x = k * power_of_ten(exponent);
                let (low, high) = (below(x), above(x));
                assert!(low <= x * 1.000001 && x <= high * 1.000001 && high / low < 2.6, "{x}: {low} {high}");
            }
        }
    }
}
