//! Distance of a coarse picture, spread over the screen, from a fine one.

use vr_core::Frame;
use vr_core::parallel::collect;

/// RMSE of a coarse frame, interpolated bilinearly between the centres of its pixels as a screen shows it, against a fine one: of all
/// components in premultiplied linear light, in units of max(1, the fine picture's largest magnitude).
pub fn rmse_upsampled(coarse: &Frame, fine: &Frame) -> f64 {
    let [width, height] = fine.size();
    let [cw, ch] = coarse.size();
    let taps = |i: u32, fine: u32, coarse: u32| {
        let at = ((f64::from(i) + 0.5) * f64::from(coarse) / f64::from(fine) - 0.5).clamp(0.0, f64::from(coarse - 1));
        let first = at as u32;
        (first, (first + 1).min(coarse - 1), (at - f64::from(first)) as f32)
    };
    let across: Vec<_> = (0..width).map(|x| taps(x, width, cw)).collect();
    let rows = collect(height as usize, |y| {
        let (top, bottom, down) = taps(y as u32, height, ch);
        let mut sum = (0.0, 1f32);
        for x in 0..width {
            let (left, right, along) = across[x as usize];
            let exact = fine.pixel(x, y as u32);
            let [a, b, c, d] =
                [(left, top), (right, top), (left, bottom), (right, bottom)].map(|(x, y)| coarse.pixel(x, y));
            for k in 0..4 {
                let upper = a[k] + along * (b[k] - a[k]);
                let lower = c[k] + along * (d[k] - c[k]);
                let error = f64::from(upper + down * (lower - upper) - exact[k]);
                sum.0 += error * error;
                sum.1 = sum.1.max(exact[k].abs());
            }
        }
        sum
    });
    let (squares, peak) = rows.into_iter().fold((0.0, 1f32), |(s, p), (s2, p2)| (s + s2, p.max(p2)));
    (squares / (4.0 * f64::from(width) * f64::from(height))).sqrt() / f64::from(peak)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_is_kept_and_a_shift_is_seen() {
        let ramp = |size: [u32; 2], shift: f32| {
            let place = |i: u32, n: u32| (i as f32 + 0.5) / n as f32;
            let pixel = |i: u32| [place(i % size[0], size[0]) + shift, place(i / size[0], size[1]), 0.0, 1.0];
            Frame::new(size, (0..size[0] * size[1]).map(pixel).collect(), None)
        };
        let fine = ramp([64, 48], 0.0);
        assert_eq!(rmse_upsampled(&fine, &fine), 0.0);
        // Linear in between; at the rim, half a coarse pixel is constant.
        assert!(rmse_upsampled(&ramp([16, 12], 0.0), &fine) < 5e-3);
        // One component of four is off by 0.1.
        let shifted = rmse_upsampled(&ramp([64, 48], 0.1), &fine);
        assert!((shifted - 0.05).abs() < 1e-6, "{shifted}");
        let bright = Frame::new([1, 1], vec![[4.0, 0.0, 0.0, 1.0]], None);
        let dark = Frame::new([1, 1], vec![[2.0, 0.0, 0.0, 1.0]], None);
        assert_eq!(rmse_upsampled(&dark, &bright), 0.25);
    }
}
