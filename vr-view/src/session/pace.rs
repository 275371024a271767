//! Resolution of the picture while something moves, by measured times.

use std::time::Duration;

/// Time of a frame that keeps thirty a second, with a little left for its way to the screen.
pub const FRAME_TIME: Duration = Duration::from_millis(26);

/// Pixels of the first picture of a scene of which no time is known.
const FIRST_PIXELS: f64 = 96.0 * 96.0;

/// Fewest pixels of a picture: fewer show nothing, and cost little less.
pub(super) const MIN_PIXELS: f64 = 48.0 * 48.0;

/// Share of a new measurement in the running mean of the logarithm of the cost: one frame that was held up by another program does not count much.
const SHARE: f64 = 0.4;

/// Largest factor by which pixels become more from one picture to the next.
const MAX_GROWTH: f64 = 4.0;

/// Size from which pictures are drawn whole: the last step to a full picture is not worth a blur.
const NEARLY_WHOLE: f64 = 0.9;

/// Choice of the pixels of moving pictures: as many as the measured cost of a pixel allows within [`FRAME_TIME`].
///
/// # Examples
/// ```
/// use std::time::Duration;
/// use vr_view::session::Pace;
///
/// let mut pace = Pace::default();
/// for _ in 0..20 {
///     // A microsecond a pixel: 26 000 of them in the time of a frame.
///     let [w, h] = pace.size([800, 600]);
///     pace.measured(u64::from(w * h), Duration::from_micros(u64::from(w * h)));
/// }
/// let [w, h] = pace.size([800, 600]);
/// assert!((24_000..28_000).contains(&(w * h)) && (f64::from(w) / f64::from(h) - 4.0 / 3.0).abs() < 0.02);
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct Pace {
    /// Mean logarithm of the seconds of a pixel.
    cost: Option<f64>,
    /// Pixels of the last picture.
    last: Option<f64>,
}

impl Pace {
    /// Width and height of the next moving picture, where those of the picture at rest are `full`: of the same shape, to a pixel.
    pub fn size(&self, full: [u32; 2]) -> [u32; 2] {
        let affordable = self.cost.map_or(FIRST_PIXELS, |cost| FRAME_TIME.as_secs_f64() / cost.exp());
        let affordable = affordable.min(self.last.map_or(f64::INFINITY, |last| MAX_GROWTH * last));
        sized(affordable.max(MIN_PIXELS), full)
    }

    /// Takes note of the time of a picture.
    pub fn measured(&mut self, pixels: u64, time: Duration) {
        let pixels = pixels.max(1) as f64;
        let cost = (time.as_secs_f64().max(1e-6) / pixels).ln();
        self.cost = Some(self.cost.map_or(cost, |mean| mean + SHARE * (cost - mean)));
        self.last = Some(pixels);
    }
}

/// Width and height of a picture of so many pixels, of the shape of the picture at rest, to a pixel; all of it where that is hardly more.
pub(super) fn sized(pixels: f64, full: [u32; 2]) -> [u32; 2] {
    let [width, height] = full.map(f64::from);
    let share = (pixels / (width * height)).sqrt();
    if share >= NEARLY_WHOLE {
        return full;
    }
    [width, height].map(|n| ((n * share).round() as u32).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_scenes_become_coarse_and_quick_ones_whole() {
        let full = [1280, 800];
        let settle = |seconds_per_pixel: f64| {
            let mut pace = Pace::default();
            for _ in 0..30 {
                let [w, h] = pace.size(full);
                let pixels = u64::from(w) * u64::from(h);
                pace.measured(pixels, Duration::from_secs_f64(pixels as f64 * seconds_per_pixel));
            }
            pace.size(full)
        };
        assert_eq!(settle(1e-9), full);
        let [w, h] = settle(1e-7);
        assert!((f64::from(w * h) * 1e-7 / FRAME_TIME.as_secs_f64() - 1.0).abs() < 0.02);
        let [w, h] = settle(1.0);
        assert!(w * h < 3000 && w > h);
    }

    #[test]
    fn one_slow_frame_changes_little() {
        let mut pace = Pace::default();
        (0..20).for_each(|_| pace.measured(100_000, Duration::from_millis(20)));
        let [w, _] = pace.size([1000, 1000]);
        pace.measured(100_000, Duration::from_millis(40));
        let [after, _] = pace.size([1000, 1000]);
        assert!(after < w && f64::from(after) > 0.85 * f64::from(w), "{w} {after}");
    }

    #[test]
    fn shapes_are_kept_and_never_empty() {
        assert_eq!(Pace::default().size([4000, 1]), [4000, 1]);
        assert_eq!(Pace::default().size([65536, 2]), [17378, 1]);
    }
}
