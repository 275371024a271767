//! Numbers in notes.

/// A number in a note: three digits.
pub(crate) fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let digits = 2 - libm::floor(libm::log10(value.abs())) as i64;
    if (-4..=6).contains(&digits) {
        let rounded = format!("{value:.*}", digits.clamp(0, 8) as usize);
        if rounded.contains('.') { rounded.trim_end_matches('0').trim_end_matches('.').to_owned() } else { rounded }
    } else {
        format!("{value:.2e}")
    }
}
