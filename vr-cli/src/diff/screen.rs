//! Pictures in the colours of a screen, from which measures of visibility start.

use vr_core::Frame;
use vr_core::transfer::linear_to_srgb;

/// Returns sRGB-encoded RGB before a linear background, in [0, 1]; NaN counts as 0, as it does in a PNG.
pub fn shown(frame: &Frame, background: [f32; 3]) -> Vec<[f64; 3]> {
    let encode = |c: f32| if c.is_nan() { 0.0 } else { linear_to_srgb(f64::from(c).clamp(0.0, 1.0)) };
    frame.over_background(background).into_iter().map(|p| p.map(encode)).collect()
}

/// Returns the luma of encoded colours with the weights of ITU-R BT.709, whose primaries sRGB has.
pub fn luma(shown: &[[f64; 3]]) -> Vec<f64> {
    shown.iter().map(|[r, g, b]| 0.2126 * r + 0.7152 * g + 0.0722 * b).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grey_is_its_own_luma() {
        let frame = Frame::new([3, 1], vec![[0.0; 4], [0.215_860_5, 0.215_860_5, 0.215_860_5, 1.0], [9.0; 4]], None);
        let luma = luma(&shown(&frame, [1.0; 3]));
        for (found, expected) in luma.iter().zip([1.0, 128.0 / 255.0, 1.0]) {
            assert!((found - expected).abs() < 1e-6, "{luma:?}");
        }
        assert_eq!(shown(&Frame::new([1, 1], vec![[f32::NAN, -1.0, 0.0, 1.0]], None), [0.0; 3]), [[0.0; 3]]);
    }
}
