//! The transfer curve of sRGB (IEC 61966-2-1:1999): how pictures, and most colour maps, encode linear light.

/// Linear light of a channel that is encoded as sRGB; both in [0, 1].
pub fn srgb_to_linear(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

/// The sRGB encoding of a channel of linear light; both in [0, 1].
pub fn linear_to_srgb(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values() {
        assert_eq!((srgb_to_linear(0.0), linear_to_srgb(0.0)), (0.0, 0.0));
        assert!((srgb_to_linear(1.0) - 1.0).abs() < 1e-15 && (linear_to_srgb(1.0) - 1.0).abs() < 1e-15);
        // Middle grey, 8-bit 128.
        assert!((srgb_to_linear(128.0 / 255.0) - 0.215_860_5).abs() < 1e-7);
    }

    #[test]
    fn each_undoes_the_other() {
        // The standard's rounded constants leave a gap of 3e-8 where the two pieces meet.
        for k in 0..=10_000 {
            let x = f64::from(k) / 10_000.0;
            assert!((srgb_to_linear(linear_to_srgb(x)) - x).abs() < 1e-8, "{x}");
            assert!((linear_to_srgb(srgb_to_linear(x)) - x).abs() < 1e-7, "{x}");
        }
    }
}
