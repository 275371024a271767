//! The frame in which stored numbers are carried: an offset and a scale, so that single precision keeps the digits that matter.

use crate::grid::{Calibration, UniformGrid};

/// An offset and a power of two: `stored = (number − base) · scale`.
///
/// Kernels compute in f32, whose numbers are spaced by 10⁻⁷ of their size, and end at 3·10³⁸. Numbers that lie far from 0, beside
/// how far they lie apart, are carried as distances from one of them; very large and very small ones, scaled to a range in which
/// neither sums overflow nor differences vanish. Both are exact for numbers that are f32 already. The calibration takes them back:
/// calibrated values stay what they are.
///
/// # Examples
/// ```
/// use vr_core::{Calibration, ValueFrame};
///
/// // Pressures in pascals that differ by little: carried as distances from the lowest one.
/// let frame = ValueFrame::of_range(101_300.0, 101_310.0).expect("far from 0, beside its width");
/// assert!(frame.has_offset());
/// assert_eq!(frame.stored(101_302.5), 2.5);
/// let calibration = frame.calibration(Calibration::default()).unwrap();
/// assert_eq!(calibration.value(2.5), 101_302.5);
/// assert_eq!(ValueFrame::of_range(0.0, 255.0), None, "best as it is");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValueFrame {
    base: f64,
    scale: f64,
}

/// Largest distance of numbers from 0, relative to their distance from each other. At 16, f32 tells 10⁶ of them apart.
const MAX_RATIO: f64 = 16.0;
/// Largest and smallest magnitude that is left as it is: sums of thousands and products of three stay far from the ends of f32.
const MAGNITUDES: std::ops::RangeInclusive<f64> = 1e-12..=1e12;

impl ValueFrame {
    /// The frame for numbers between two ends; `None` where they are best carried as they are.
    pub fn of_range(low: f64, high: f64) -> Option<Self> {
        let (span, largest) = (high - low, low.abs().max(high.abs()));
        let base = if span > 0.0 && largest > MAX_RATIO * span { if low > 0.0 { low } else { high } } else { 0.0 };
        // Of a constant, 0 is the size of what it is carried as.
        let size = if base == 0.0 { largest } else { span };
        let scale = if size == 0.0 || MAGNITUDES.contains(&size) {
            1.0
        } else {
            // To [1, 2): a power of two changes no digit.
            let exponent = -libm::floor(libm::log2(size)) as i32;
            libm::ldexp(1.0, exponent)
        };
        (base != 0.0 || scale != 1.0).then_some(Self { base, scale })
    }

    /// True if numbers are carried as distances from one of them, which keeps digits that f32 would lose.
    pub fn has_offset(&self) -> bool {
        self.base != 0.0
    }

    /// A number as it is carried.
    pub fn stored(&self, number: f64) -> f32 {
        ((number - self.base) * self.scale) as f32
    }

    /// The calibration of what is carried, from that of the numbers themselves; `None` if it is beyond f64.
    pub fn calibration(&self, of_numbers: Calibration) -> Option<Calibration> {
        let slope = of_numbers.slope / self.scale;
        let intercept = of_numbers.value(self.base);
        (slope != 0.0 && slope.is_finite() && intercept.is_finite()).then_some(Calibration { slope, intercept })
    }
}

/// The same volume in the frame that suits its range; `None` where it is best left as it is.
pub(crate) fn framed(grid: &UniformGrid<f32>) -> Option<UniformGrid<f32>> {
    let (low, high) = grid.value_stats().range?;
    let frame = ValueFrame::of_range(low.into(), high.into())?;
    let calibration = frame.calibration(grid.calibration())?;
    let samples: Vec<f32> = grid.samples().iter().map(|&s| frame.stored(s.into())).collect();
    UniformGrid::new(grid.dims(), samples, *grid.placement(), calibration).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::placement::Placement;

    fn grid(samples: [f32; 8]) -> UniformGrid<f32> {
        let calibration = Calibration { slope: -2.0, intercept: 5.0 };
        UniformGrid::new([2; 3], samples.to_vec(), Placement::from_spacing([1.0; 3]).unwrap(), calibration).unwrap()
    }

    #[test]
    fn values_stay_and_numbers_come_near() {
        let ends = [
            [1e6f32, 1_000_010.0],
            [-1e6, -999_990.0],
            [-3e38, 3e38],
            [1e-41, 9e-41],
            [3e38f32.next_down(), 3e38],
            [2e-38, 2.000_001e-38],
        ];
        for [low, high] in ends {
            let middle = low / 2.0 + high / 2.0;
            let samples = [low, high, middle, f32::NAN, low, high, low, middle];
            let given = grid(samples);
            let carried = framed(&given).unwrap();
            let (from, to) = carried.value_stats().range.unwrap();
            let size = from.abs().max(to.abs());
            assert!((1e-12..=1e12).contains(&size) && size <= 16.0 * (to - from), "{low} {high}: {from} {to}");
            for (a, b) in given.samples().iter().zip(carried.samples()) {
                let [a, b] = [given.calibration().value(f64::from(*a)), carried.calibration().value(f64::from(*b))];
                assert!(a == b || a.is_nan() && b.is_nan(), "{a} {b}");
            }
        }
    }

    #[test]
    fn ordinary_numbers_are_left_alone() {
        for [low, high] in [[-1024.0, 3071.0], [0.0, 1.0], [280.0, 320.0], [0.0, 0.0], [7.0, 7.0], [-1e9, 2.0]] {
            assert_eq!(ValueFrame::of_range(low, high), None, "{low} {high}");
        }
        assert!(framed(&grid([f32::NAN; 8])).is_none());
        assert!(ValueFrame::of_range(1e-300, 1e300).is_some(), "what f64 holds");
    }
}
