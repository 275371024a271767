//! FLIP: visibility of a difference to an observer who flips between two pictures (Andersson et al., "FLIP: A Difference
//! Evaluator for Alternating Images", Proceedings of the ACM on Computer Graphics 3(2), 2020). NVIDIA's own code, which needs a C++
//! compiler: hence behind a feature.

use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8, FlipPool, flip};

/// Returns the mean of the error map of two pictures that are sRGB-encoded in [0, 1], after rounding to 8 bits; 0 for equal pictures, at
/// most 1. The observer sees 67 pixels per degree: a screen 0.7 m away that is 0.7 m and 3840 pixels wide.
pub fn mean(size: [u32; 2], reference: &[[f64; 3]], picture: &[[f64; 3]]) -> f64 {
    let image = |shown: &[[f64; 3]]| {
        let bytes: Vec<u8> = shown.iter().flatten().map(|c| (c * 255.0).round() as u8).collect();
        FlipImageRgb8::with_data(size[0], size[1], &bytes)
    };
    let map = flip(image(reference), image(picture), DEFAULT_PIXELS_PER_DEGREE);
    FlipPool::from_image(&map).mean().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_and_opposite_pictures() {
        let size = [16, 16];
        let flat = |v: f64| vec![[v; 3]; 256];
        assert_eq!(mean(size, &flat(0.5), &flat(0.5)), 0.0);
        let opposite = mean(size, &flat(0.0), &flat(1.0));
        assert!((0.8..=1.0).contains(&opposite), "{opposite}");
    }
}
