//! Axis of values: linear or logarithmic, with round ticks.

use super::round;
use crate::number;

/// Values from `low` to `high`, `low` below `high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    low: f64,
    high: f64,
    logarithmic: bool,
}

impl Axis {
    /// Makes an axis between two finite values, the smaller one first. It is logarithmic where all is positive and most of the given values would
    /// crowd at its lower end else.
    pub fn new(low: f64, high: f64, values: &[f64]) -> Self {
        /// Place on a linear axis below which half of the values are crowded.
        const CROWDED: f64 = 0.08;
        let linear = Self { low, high, logarithmic: false };
        let mut places: Vec<f64> =
            values.iter().map(|&v| linear.place(v)).filter(|p| (0.0..=1.0).contains(p)).collect();
        places.sort_by(f64::total_cmp);
        let crowded = places.len() > 4 && places[places.len() / 2] < CROWDED;
        Self { logarithmic: crowded && low > 0.0, ..linear }
    }

    /// Returns the place of a value, 0 at the low end and 1 at the high one.
    pub fn place(self, value: f64) -> f64 {
        match self.logarithmic {
            true => (value / self.low).ln() / (self.high / self.low).ln(),
            // Halves, for the largest values have no finite difference.
            false => (0.5 * value - 0.5 * self.low) / (0.5 * self.high - 0.5 * self.low),
        }
    }

    /// Returns the value at a place.
    pub fn value(self, place: f64) -> f64 {
        match self.logarithmic {
            true => self.low * (place * (self.high / self.low).ln()).exp(),
            false => (1.0 - place) * self.low + place * self.high,
        }
    }

    /// Returns round values on the axis, `max` of them at most (and two where there is room for no more), with their labels. An axis too short for
    /// six digits has its ends, or one of them.
    pub fn ticks(self, max: usize) -> Vec<(f64, String)> {
        let max = max.max(2);
        let ticks = if self.logarithmic { self.powers(max) } else { Vec::new() };
        let ticks = if ticks.len() < 2 { self.steps(max) } else { ticks };
        let mut ticks: Vec<_> = ticks.into_iter().map(|v| (v, number::value(v).replace('-', "−"))).collect();
        ticks.dedup_by(|a, b| a.1 == b.1);
        ticks
    }

    /// Even steps of a round number.
    fn steps(self, max: usize) -> Vec<f64> {
        let span = 0.5 * self.high - 0.5 * self.low;
        // Six digits do not tell ticks apart on a shorter axis, and sums overflow on a longer one.
        let size = self.low.abs().max(self.high.abs());
        if !(span.is_normal() && span > 1e-6 * size && span < 1e300) {
            return vec![self.low, self.high];
        }
        let mut step = round::above(2.0 * span / max as f64);
        loop {
            // A hair beyond the ends, for 0.3 is not three tenths.
            let (first, last) = ((self.low / step - 1e-9).ceil(), (self.high / step + 1e-9).floor());
            if last - first < max as f64 {
                let count = (last - first).max(0.0) as usize + 1;
                // The decimal digits that the step has.
                let exact = |k: usize| {
                    let digits = (-step.log10().floor()).clamp(0.0, 300.0) as usize;
                    let value = (first + k as f64) * step;
                    if (1e-6..1e6).contains(&step) {
                        format!("{value:.digits$}").parse().unwrap_or(value)
                    } else {
                        value
                    }
                };
                let ticks: Vec<f64> = (0..count).map(exact).map(|v| if v == 0.0 { 0.0 } else { v }).collect();
                return if ticks.len() < 2 { vec![self.low, self.high] } else { ticks };
            }
            step = round::above(1.5 * step);
        }
    }

    /// Powers of ten, each or each second, third, … of them; or 1, 2 and 5 times powers, where there are few.
    fn powers(self, max: usize) -> Vec<f64> {
        let (first, last) = (self.low.log10().floor() as i32, self.high.log10().ceil() as i32);
        let on_axis = |v: &f64| (self.low * (1.0 - 1e-9)..=self.high * (1.0 + 1e-9)).contains(v);
        let fine = |e: i32| [1.0, 2.0, 5.0].map(|k| k * round::power_of_ten(e));
        let fine: Vec<f64> = (first..=last).flat_map(fine).filter(on_axis).collect();
        if fine.len() <= max {
            return fine;
        }
        let decades: Vec<f64> = (first..=last).map(round::power_of_ten).filter(on_axis).collect();
        let stride = decades.len().div_ceil(max).max(1);
        decades.into_iter().rev().step_by(stride).collect::<Vec<_>>().into_iter().rev().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: Axis, max: usize) -> Vec<String> {
        axis.ticks(max).into_iter().map(|t| t.1).collect()
    }

    #[test]
    fn ticks_are_round_and_few() {
        assert_eq!(labels(Axis::new(-980.0, 3071.0, &[]), 6), ["0", "1000", "2000", "3000"]);
        assert_eq!(labels(Axis::new(-0.34, 0.31, &[]), 6), ["−0.2", "0", "0.2"]);
        assert_eq!(labels(Axis::new(0.1, 0.4, &[]), 5), ["0.1", "0.2", "0.3", "0.4"]);
        assert_eq!(labels(Axis::new(0.0, 1e12, &[]), 3), ["0", "5e11", "1e12"]);
        assert_eq!(labels(Axis::new(-f64::MAX, f64::MAX, &[]), 5).len(), 2);
        assert_eq!(labels(Axis::new(1.0, f64::from_bits(1.0f64.to_bits() + 1), &[]), 5), ["1"]);
        for max in 2..9 {
            for (low, high) in [(0.013, 0.0131), (-7.0, 1e6), (3.0, 4.0), (1e-9, 2e-9), (999_999.0, 1_000_001.0)] {
                let ticks = Axis::new(low, high, &[]).ticks(max);
                assert!((2..=max).contains(&ticks.len()), "{low} {high} {max}: {ticks:?}");
            }
        }
    }

    #[test]
    fn crowded_values_make_a_logarithmic_axis() {
        let values: Vec<f64> = (0..9).map(|k| 10f64.powi(k - 6)).collect();
        let axis = Axis::new(1e-6, 100.0, &values);
        assert_eq!(labels(axis, 5), ["1e−6", "1e−4", "0.01", "1", "100"]);
        assert!((axis.place(1e-2) - 0.5).abs() < 1e-12 && (axis.value(0.5) - 1e-2).abs() < 1e-12);
        assert_eq!(Axis::new(0.0, 100.0, &values), Axis { low: 0.0, high: 100.0, logarithmic: false });
    }
}
