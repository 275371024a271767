//! Formats of numbers for people.

use std::time::Duration;

/// A value of the volume, in six digits.
pub use vr_core::number_text as value;

/// Formats a small number, such as an error: `1.24e-3`; exact zero is `0`.
pub fn small(x: f64) -> String {
    if x == 0.0 { "0".to_owned() } else { format!("{x:.2e}") }
}

/// Formats a time: `340 us`, `12.3 ms`, `1.52 s`, `125 s`.
pub fn time(duration: Duration) -> String {
    let s = duration.as_secs_f64();
    match s {
        _ if s < 1e-3 => format!("{:.0} us", s * 1e6),
        _ if s < 1.0 => format!("{:.1} ms", s * 1e3),
        _ if s < 100.0 => format!("{s:.2} s"),
        _ => format!("{s:.0} s"),
    }
}

/// Formats a count: `950`, `12.3 k`, `4.56 M`, `1.20 G`.
pub fn count(n: u64) -> String {
    let scaled = |unit: f64, letter: char| {
        let x = n as f64 / unit;
        if x < 10.0 { format!("{x:.2} {letter}") } else { format!("{x:.1} {letter}") }
    };
    match n {
        0..10_000 => n.to_string(),
        10_000..1_000_000 => scaled(1e3, 'k'),
        1_000_000..1_000_000_000 => scaled(1e6, 'M'),
        _ => scaled(1e9, 'G'),
    }
}

/// Formats a number of bytes: `68.9 kB`, `16.8 MB`.
pub fn bytes(n: u64) -> String {
    match n {
        0..1_000 => format!("{n} B"),
        1_000..1_000_000 => format!("{:.1} kB", n as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", n as f64 / 1e6),
        _ => format!("{:.2} GB", n as f64 / 1e9),
    }
}

/// Formats three numbers with a separator, the shortest digits that give each of them back.
pub fn triple<T: std::fmt::Display>(v: [T; 3], separator: &str) -> String {
    let [x, y, z] = v;
    format!("{x}{separator}{y}{separator}{z}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_well() {
        assert_eq!(small(0.00124), "1.24e-3");
        assert_eq!(small(0.0), "0");
        assert_eq!(time(Duration::from_micros(12_345)), "12.3 ms");
        assert_eq!(count(12_345_678), "12.3 M");
        assert_eq!(bytes(68_921), "68.9 kB");
        assert_eq!(triple([1, 2, 3], "×"), "1×2×3");
    }
}
