//! Splines through keys.

use super::Interpolation;

/// A course through values at certain times, each component by itself.
///
/// [`Interpolation::Smooth`] is the cubic of Fritsch and Butland (1984) between keys: its slope is continuous, and it stays between the
/// values on both sides, so that nothing overshoots a key, and a value that two keys share is kept between them.
#[derive(Clone, Debug)]
pub(super) struct Spline {
    times: Vec<f64>,
    values: Vec<Vec<f64>>,
    /// Change per second at each key.
    slopes: Vec<Vec<f64>>,
    interpolation: Interpolation,
}

impl Spline {
    /// A spline through values of equal length at one or more rising times.
    pub fn new(times: Vec<f64>, values: Vec<Vec<f64>>, interpolation: Interpolation) -> Self {
        let component = |c: usize| values.iter().map(|v| v[c]).collect::<Vec<f64>>();
        let by_component: Vec<Vec<f64>> = (0..values[0].len()).map(|c| slopes(&times, &component(c))).collect();
        let slopes = (0..times.len()).map(|k| by_component.iter().map(|slopes| slopes[k]).collect()).collect();
        Self { times, values, slopes, interpolation }
    }

    /// Returns the values at a time; before the first and after the last key, theirs.
    pub fn at(&self, time: f64) -> Vec<f64> {
        let (k, u) = place(&self.times, time);
        let Some(next) = self.values.get(k + 1).filter(|_| u > 0.0) else { return self.values[k].clone() };
        let length = self.times[k + 1] - self.times[k];
        let between = |c: usize| {
            let (a, b) = (self.values[k][c], next[c]);
            match self.interpolation {
                Interpolation::Smooth => {
                    // Hermite's cubic.
                    let (from, to) = (self.slopes[k][c] * length, self.slopes[k + 1][c] * length);
                    a + (b - a) * ease(u) + u * (1.0 - u) * ((1.0 - u) * from - u * to)
                }
                Interpolation::Linear => a + (b - a) * u,
                Interpolation::Ease => a + (b - a) * ease(u),
            }
        };
        (0..next.len()).map(between).collect()
    }
}

/// Returns the key at or before a time, and the fraction of the way to the next one, 0 at the last.
pub(super) fn place(times: &[f64], time: f64) -> (usize, f64) {
    let k = times.partition_point(|&t| t <= time).saturating_sub(1);
    match times.get(k + 1) {
        Some(next) => (k, ((time - times[k]) / (next - times[k])).clamp(0.0, 1.0)),
        None => (k, 0.0),
    }
}

/// Fraction of the way that one who starts and ends at rest has come.
pub(super) fn ease(u: f64) -> f64 {
    u * u * (3.0 - 2.0 * u)
}

/// Change per second at each key.
fn slopes(times: &[f64], values: &[f64]) -> Vec<f64> {
    let lengths: Vec<f64> = times.windows(2).map(|t| t[1] - t[0]).collect();
    let changes: Vec<f64> = values.windows(2).zip(&lengths).map(|(v, length)| (v[1] - v[0]) / length).collect();
    let inner = |k: usize| {
        let (before, after) = (changes[k - 1], changes[k]);
        if before * after <= 0.0 {
            return 0.0;
        }
        // The harmonic mean, by lengths.
        let (first, second) = (2.0 * lengths[k] + lengths[k - 1], lengths[k] + 2.0 * lengths[k - 1]);
        (first + second) / (first / before + second / after)
    };
    // At the ends, the parabola through three keys, as far as it does not overshoot.
    let end = |near: usize, far: usize| {
        let (Some(&own), Some(&other)) = (changes.get(near), changes.get(far)) else {
            return changes.get(near).copied().unwrap_or(0.0);
        };
        let slope =
            ((2.0 * lengths[near] + lengths[far]) * own - lengths[near] * other) / (lengths[near] + lengths[far]);
        if slope * own <= 0.0 {
            0.0
        } else if own * other <= 0.0 && slope.abs() > 3.0 * own.abs() {
            3.0 * own
        } else {
            slope
        }
    };
    let last = times.len() - 1;
    (0..=last)
        .map(|k| match k {
            0 => end(0, 1),
            k if k == last => end(last - 1, last.wrapping_sub(2)),
            k => inner(k),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spline(values: &[f64], interpolation: Interpolation) -> Spline {
        let times = [0.0, 1.0, 3.0, 4.0, 5.5, 6.0];
        Spline::new(times[..values.len()].to_vec(), values.iter().map(|&v| vec![v]).collect(), interpolation)
    }

    #[test]
    fn keys_are_hit_and_not_overshot() {
        let values = [0.0, 10.0, 10.0, 4.0, 90.0, 91.0];
        for interpolation in [Interpolation::Smooth, Interpolation::Linear, Interpolation::Ease] {
            let spline = spline(&values, interpolation);
            for (k, &time) in spline.times.iter().enumerate() {
                assert_eq!(spline.at(time), [values[k]]);
            }
            for i in 0..=600 {
                let time = f64::from(i) * 0.01;
                let (k, _) = place(&spline.times, time);
                let (a, b) = (values[k], values[(k + 1).min(5)]);
                let [v] = spline.at(time)[..] else { panic!("one component") };
                assert!((a.min(b) - 1e-9..=a.max(b) + 1e-9).contains(&v), "{interpolation:?} {time}: {v}");
            }
            assert_eq!((spline.at(-1.0), spline.at(9.0)), (vec![0.0], vec![91.0]));
            assert_eq!(spline.at(2.0), [10.0], "rests");
        }
    }

    #[test]
    fn smooth_courses_have_no_jerk_and_keep_straight_lines() {
        let smooth = spline(&[0.0, 10.0, 12.0, 40.0, 90.0, 91.0], Interpolation::Smooth);
        for &time in &smooth.times[1..5] {
            let slope = |t: f64| (smooth.at(t + 1e-6)[0] - smooth.at(t)[0]) / 1e-6;
            assert!((slope(time - 1e-6) - slope(time)).abs() < 1e-3, "{time}");
        }
        let straight = spline(&[0.0, 2.0, 6.0, 8.0, 11.0, 12.0], Interpolation::Smooth);
        let two = spline(&[0.0, 2.0], Interpolation::Smooth);
        for i in 0..=60 {
            let time = f64::from(i) * 0.1;
            assert!((straight.at(time)[0] - 2.0 * time).abs() < 1e-12);
            assert!((two.at(time)[0] - (2.0 * time).min(2.0)).abs() < 1e-12);
        }
        assert_eq!(spline(&[7.0], Interpolation::Smooth).at(3.0), [7.0]);
    }

    #[test]
    fn easing_rests_at_keys() {
        let ease = spline(&[0.0, 10.0, 30.0], Interpolation::Ease);
        for time in [0.0, 1.0, 3.0 - 2e-4] {
            assert!((ease.at(time + 1e-4)[0] - ease.at(time)[0]).abs() < 1e-5);
        }
        assert_eq!(ease.at(0.5), [5.0]);
    }
}
