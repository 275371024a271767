//! Numbers for people.

/// Returns a number in six digits at most, without zeros at their end, and with an exponent only where that saves room: what messages and notes
/// tell of numbers that were computed or read. Digits beyond are noise to a reader, and f32 has no more.
///
/// # Examples
/// ```
/// use vr_core::number_text;
///
/// assert_eq!([255.0, 1.0 / 3.0, -2.4e10, 1e-7].map(number_text), ["255", "0.333333", "-2.4e10", "1e-7"]);
/// ```
pub fn number_text(x: f64) -> String {
    let trimmed = |s: &str| match s.contains('.') {
        true => s.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => s.to_owned(),
    };
    if !x.is_finite() {
        x.to_string()
    } else if x == 0.0 || (1e-3..1e6).contains(&x.abs()) {
        let decimals = (5.0 - libm::floor(libm::log10(x.abs().max(1e-300)))).clamp(0.0, 8.0) as usize;
        let s = trimmed(&format!("{x:.decimals$}"));
        if s == "-0" { "0".to_owned() } else { s }
    } else {
        let s = format!("{x:.5e}");
        let (mantissa, exponent) = s.split_once('e').unwrap_or((&s, "0"));
        format!("{}e{exponent}", trimmed(mantissa))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn six_digits_are_enough() {
        let numbers = [0.0, -0.0, 255.0, -1024.0, 0.5, 0.1234567891, 999_999.7, 1e6, -2.4e10, 1.23456789e-7];
        let texts = ["0", "0", "255", "-1024", "0.5", "0.123457", "1000000", "1e6", "-2.4e10", "1.23457e-7"];
        assert_eq!(numbers.map(number_text), texts);
        assert_eq!([f64::NAN, f64::NEG_INFINITY].map(number_text), ["NaN", "-inf"]);
        // Of any magnitude, no more than six digits tell, and they are right to half a unit of the last.
        for exponent in -30..30 {
            let x = 1.234567891 * 10f64.powi(exponent);
            let text = number_text(x);
            let digits = text.split('e').next().unwrap().trim_start_matches(['0', '.']).replace('.', "");
            assert!(digits.len() <= 6, "{text}");
            assert!((text.parse::<f64>().unwrap() - x).abs() <= 0.5000001e-5 * 10f64.powi(exponent), "{text}");
        }
    }
}
