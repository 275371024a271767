//! Formats of the figures that this command prints.

/// Formats a number to four digits; `-` for NaN, `inf` for infinity.
pub fn short(x: f64) -> String {
    digits(x, 4)
}

/// Formats a number to six digits.
pub fn long(x: f64) -> String {
    digits(x, 6)
}

fn digits(x: f64, n: i32) -> String {
    if x.is_nan() {
        return "-".to_owned();
    }
    if x.is_infinite() {
        return if x > 0.0 { "inf" } else { "-inf" }.to_owned();
    }
    if x == 0.0 {
        return "0".to_owned();
    }
    if !(1e-3..1e6).contains(&x.abs()) {
        return format!("{x:.*e}", n as usize - 2);
    }
    let decimals = (n - 1 - x.abs().log10().floor() as i32).max(0) as usize;
    let text = format!("{x:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    text.to_owned()
}

/// Formats an error with its sign: `+1.24e-3`; exactly none is `0`.
pub fn signed(x: f64) -> String {
    if x == 0.0 { "0".to_owned() } else { format!("{x:+.2e}") }
}

/// Formats a colour: three components, or one where they are the same throughout (`gray`).
pub fn color(c: [f64; 3], gray: bool, figure: impl Fn(f64) -> String) -> String {
    if gray { figure(c[0]) } else { c.map(figure).join(" ") }
}

/// Lists the faces that are crossed, axis and index: `x12 y3`.
pub fn faces(faces: &[(usize, f64)]) -> String {
    shortened(faces.iter().map(|&(axis, at)| format!("{}{at}", ["x", "y", "z"][axis.min(2)])))
}

/// Lists the knots that are crossed.
pub fn knots(knots: &[f64]) -> String {
    shortened(knots.iter().map(|&v| short(v)))
}

/// Lists the first few items, and the number of the others.
fn shortened(items: impl ExactSizeIterator<Item = String>) -> String {
    const MAX_ITEMS: usize = 3;
    let more = items.len().saturating_sub(MAX_ITEMS);
    let mut text = items.take(MAX_ITEMS).collect::<Vec<_>>().join(" ");
    if more > 0 {
        text += &format!(" +{more}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_digits_and_no_zeros() {
        for (x, text) in [(0.25, "0.25"), (-12.0, "-12"), (1234.56, "1235"), (1e-5, "1.00e-5"), (f64::NAN, "-")] {
            assert_eq!(short(x), text);
        }
        assert_eq!((long(1.0 / 3.0), signed(0.00124), signed(0.0)), ("0.333333".into(), "+1.24e-3".into(), "0".into()));
        assert_eq!(color([0.5, 0.5, 0.5], true, short), "0.5");
        assert_eq!(faces(&[(0, 3.0), (2, 4.5), (1, 1.0), (0, 2.0)]), "x3 z4.5 y1 +1");
        assert_eq!(knots(&[]), "");
    }
}
