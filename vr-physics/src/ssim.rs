//! Structural similarity: Wang, Bovik, Sheikh and Simoncelli, "Image quality assessment: from error visibility to structural
//! similarity", IEEE Transactions on Image Processing 13(4), 2004; with the windows and constants of section III-C.
//!
//! Written here because the crate at hand (`image-compare` 0.5) takes sums where the formula has variances, on 8×8 blocks of 8
//! bits: its numbers cannot be compared with those of other programs.

/// Width of the window; the weights are those of a Gaussian with a deviation of 1.5 pixels.
const TAPS: usize = 11;
const DEVIATION: f64 = 1.5;
/// (K₁L)² and (K₂L)² with L = 1: what keeps dark and flat windows from dividing by nothing.
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// Mean of (2 μₐ μᵦ + C₁)(2 σₐᵦ + C₂) / ((μₐ² + μᵦ² + C₁)(σₐ² + σᵦ² + C₂)) over all windows that lie inside the picture; the values
/// are in [0, 1].
///
/// `a` and `b` are pictures of one number per pixel (luma, say), row by row. `None` where no window fits.
///
/// # Panics
/// Panics if either has fewer values than the size has pixels.
pub fn ssim(size: [u32; 2], a: &[f64], b: &[f64]) -> Option<f64> {
    let [w, h] = size.map(|side| side as usize);
    if w < TAPS || h < TAPS {
        return None;
    }
    let weights = weights();
    let mut sum = 0.0;
    // The window is a product: weighted sums down the columns first, then along the row of them.
    let mut columns = vec![[0.0; 5]; w];
    for top in 0..=h - TAPS {
        for (x, column) in columns.iter_mut().enumerate() {
            *column = weighted(&weights, |k| {
                let i = (top + k) * w + x;
                let (a, b) = (a[i], b[i]);
                [a, b, a * a, b * b, a * b]
            });
        }
        sum += columns.windows(TAPS).map(|window| similarity(weighted(&weights, |k| window[k]))).sum::<f64>();
    }
    Some(sum / ((w - TAPS + 1) * (h - TAPS + 1)) as f64)
}

/// The similarity of a window from its means of a, b, a², b² and ab.
fn similarity([mean_a, mean_b, aa, bb, ab]: [f64; 5]) -> f64 {
    let (variance_a, variance_b) = (aa - mean_a * mean_a, bb - mean_b * mean_b);
    let covariance = ab - mean_a * mean_b;
    (2.0 * mean_a * mean_b + C1) * (2.0 * covariance + C2)
        / ((mean_a * mean_a + mean_b * mean_b + C1) * (variance_a + variance_b + C2))
}

fn weighted(weights: &[f64; TAPS], values: impl Fn(usize) -> [f64; 5]) -> [f64; 5] {
    let mut sums = [0.0; 5];
    for (k, weight) in weights.iter().enumerate() {
        for (sum, value) in sums.iter_mut().zip(values(k)) {
            *sum += weight * value;
        }
    }
    sums
}

fn weights() -> [f64; TAPS] {
    let middle = (TAPS / 2) as f64;
    let weights: [f64; TAPS] = std::array::from_fn(|k| libm::exp(-0.5 * ((k as f64 - middle) / DEVIATION).powi(2)));
    let sum: f64 = weights.iter().sum();
    weights.map(|w| w / sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn waves(size: [u32; 2], phase: f64) -> Vec<f64> {
        let value =
            |x: u32, y: u32| 0.5 + 0.4 * (0.7 * f64::from(x) + phase).sin() * (0.3 * f64::from(y * y) - phase).cos();
        (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| value(x, y))).collect()
    }

    #[test]
    fn closed_forms() {
        let size = [20, 13];
        let wave = waves(size, 0.0);
        assert!((ssim(size, &wave, &wave).unwrap() - 1.0).abs() < 1e-12);
        // Flat pictures have means only.
        let flat = |v: f64| vec![v; 260];
        let expected = (2.0 * 0.2 * 0.6 + C1) / (0.2 * 0.2 + 0.6 * 0.6 + C1);
        assert!((ssim(size, &flat(0.2), &flat(0.6)).unwrap() - expected).abs() < 1e-12);
        // The negative has the opposite structure.
        let negative: Vec<f64> = wave.iter().map(|v| 1.0 - v).collect();
        assert!(ssim(size, &wave, &negative).unwrap() < -0.5);
        assert_eq!(ssim([10, 30], &[0.0; 300], &[0.0; 300]), None);
    }

    #[test]
    fn agrees_with_scikit_image() {
        // structural_similarity(a, b, gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1.0), version 0.26.
        let size = [31, 23];
        let found = ssim(size, &waves(size, 0.0), &waves(size, 0.4)).unwrap();
        assert!((found - 0.753_883_690_373_972_8).abs() < 1e-12, "{found}");
    }

    #[test]
    fn one_window_by_its_definition() {
        // A window that fits once: means, variances and covariance as the paper writes them, in two dimensions.
        let size = [11, 11];
        let (a, b) = (waves(size, 0.0), waves(size, 0.4));
        let weight = |i: usize| {
            let [x, y] = [i % 11, i / 11].map(|k| k as f64 - 5.0);
            (-(x * x + y * y) / (2.0 * 1.5 * 1.5)).exp()
        };
        let total: f64 = (0..121).map(weight).sum();
        let mean = |f: &dyn Fn(usize) -> f64| (0..121).map(|i| weight(i) * f(i)).sum::<f64>() / total;
        let (ma, mb) = (mean(&|i| a[i]), mean(&|i| b[i]));
        let (va, vb) = (mean(&|i| (a[i] - ma).powi(2)), mean(&|i| (b[i] - mb).powi(2)));
        let cov = mean(&|i| (a[i] - ma) * (b[i] - mb));
        let expected = (2.0 * ma * mb + 1e-4) * (2.0 * cov + 9e-4) / ((ma * ma + mb * mb + 1e-4) * (va + vb + 9e-4));
        assert!((ssim(size, &a, &b).unwrap() - expected).abs() < 1e-12);
        assert!(expected < 0.95);
    }
}
