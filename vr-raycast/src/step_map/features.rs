//! Features of a transfer function so narrow that a step may miss them: peaks and gaps, as thick in space as the field's slope makes them.

/// Peak or gap of extinction, or of emission, over values.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Feature {
    /// Values between which the feature lies.
    from: f64,
    to: f64,
    /// Width of the feature at half its height.
    width: f64,
    /// Height above its surroundings, or depth below them, per world unit.
    height: f64,
}

/// Peaks and gaps of a transfer function.
#[derive(Clone, Debug, Default)]
pub(super) struct Features(Vec<Feature>);

/// Error of a step as long as a feature is thick, as a part of the light that the feature adds: measured on shells of 1 % of the range
/// of blobs (see `docs/wrong-results.md`); it falls with the square of the step.
const MISSED: f64 = 0.04;

impl Features {
    /// Finds the features of extinction and three emissions at values, in ascending order, of each function; two at one value are a jump.
    pub(super) fn new(functions: &[Vec<(f64, [f64; 4])>]) -> Self {
        let of_channel = |points: &[(f64, [f64; 4])], c: usize| {
            of_one(&points.iter().map(|(value, q)| (*value, q[c])).collect::<Vec<_>>())
        };
        let mut all: Vec<Feature> =
            functions.iter().flat_map(|points| (0..4).flat_map(|c| of_channel(points, c))).collect();
        all.sort_by(|a, b| a.width.total_cmp(&b.width));
        Self(all)
    }

    /// Returns the length in voxels of the longest step that misses no more than `error` of a picture in a block of `edge` voxels with values between `low`
    /// and `high`, if steps of `usual` voxels, which know nothing of features, are not short beside all of them. `voxel`: its world length.
    ///
    /// The field is taken to cross its range on the way through the block: a feature of width w is W = e·w/(high − low) voxels
    /// thick, and adds light of min(1, A) with A = height·W. Midpoints at a distance h catch it but for [`MISSED`]·(h/W)² of that.
    pub(super) fn longest_step(&self, [low, high]: [f64; 2], usual: f64, (voxel, edge): (f64, f64), error: f64) -> f64 {
        let mut longest = usual;
        for feature in &self.0 {
            let thick = edge * feature.width / (high - low);
            // They are sorted: no further one is thinner.
            if thick >= 2.0 * usual {
                break;
            }
            if feature.from < high && feature.to > low {
                let light = (feature.height * thick * voxel).min(1.0);
                longest = longest.min(thick * libm::sqrt(error / (MISSED * light)).max(MIN_PART));
            }
        }
        longest
    }
}

/// Part of a feature than which no step need be shorter.
const MIN_PART: f64 = 0.125;

/// Finds the peaks and gaps of one number over values.
fn of_one(points: &[(f64, f64)]) -> Vec<Feature> {
    // Where it turns: runs of equal numbers are one place, from their first value to their last.
    let mut turns: Vec<(f64, f64, f64)> = Vec::new();
    for &(value, x) in points {
        match turns.last_mut() {
            Some(last) if last.2 == x => last.1 = value,
            _ => {
                // Neither higher nor lower than both neighbours: on the way.
                if let [.., a, b] = turns[..]
                    && (a.2 < b.2) == (b.2 < x)
                {
                    turns.pop();
                }
                turns.push((value, value, x));
            }
        }
    }
    // The outermost go on for ever.
    let inner = turns.windows(3).filter_map(|w| {
        let [before, at, after] = [w[0], w[1], w[2]];
        let height = (at.2 - before.2).abs().min((at.2 - after.2).abs());
        if !height.is_finite() {
            let width = at.1 - at.0;
            return (width > 0.0).then_some(Feature { from: at.0, to: at.1, width, height: f64::MAX });
        }
        let level = at.2 + (before.2.clamp(at.2 - height, at.2 + height) - at.2) * 0.5;
        let crossing = |from: f64, to: f64| crossing_of(points, level, from, to);
        let (from, to) = (crossing(before.1, at.0), crossing(at.1, after.0));
        Some(Feature { from: before.1, to: after.0, width: to - from, height })
    });
    inner.filter(|f| f.width > 0.0).collect()
}

/// Returns the value between two others at which a piecewise linear number passes a level; `from` if it does not.
fn crossing_of(points: &[(f64, f64)], level: f64, from: f64, to: f64) -> f64 {
    for pair in points.windows(2) {
        let [(v0, x0), (v1, x1)] = [pair[0], pair[1]];
        let passes = (x0 - level) * (x1 - level) <= 0.0 && x0 != x1;
        if v0 >= from && v1 <= to && passes {
            let t = (level - x0) / (x1 - x0);
            // An infinite end is passed at once.
            return if t.is_finite() { v0 + t * (v1 - v0) } else { v0 };
        }
    }
    from
}

#[cfg(test)]
mod tests {
    use super::*;

    fn features(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
        of_one(points).iter().map(|f| (f.width, f.height)).collect()
    }

    #[test]
    fn peaks_and_gaps_are_found_and_ramps_are_not() {
        assert_eq!(features(&[(0.0, 0.0), (10.0, 2.0)]), []);
        assert_eq!(features(&[(0.0, 0.0), (5.0, 0.5), (10.0, 2.0), (20.0, 2.0)]), []);
        assert_eq!(features(&[(99.0, 0.0), (100.0, 2.0), (101.0, 0.0)]), [(1.0, 2.0)]);
        // A plateau between jumps, and the gap between two of them.
        let two = [
            (0.0, 0.0),
            (1.0, 0.0),
            (1.0, 3.0),
            (2.0, 3.0),
            (2.0, 1.0),
            (4.0, 1.0),
            (4.0, 3.0),
            (9.0, 3.0),
            (9.0, 0.0),
        ];
        assert_eq!(features(&two), [(1.0, 2.0), (2.0, 2.0), (5.0, 2.0)]);
        assert_eq!(
            features(&[(0.0, 1.0), (1.0, 1.0), (1.0, f64::INFINITY), (1.5, f64::INFINITY), (1.5, 0.0)]),
            [(0.5, f64::MAX)]
        );
    }

    #[test]
    fn steps_shorten_where_a_feature_is_thinner_than_they_are() {
        let spike = |value: f64, kappa: f64| (value, [kappa, 0.0, 0.0, 0.0]);
        let features = Features::new(&[vec![spike(99.0, 0.0), spike(100.0, 2.0), spike(101.0, 0.0)]]);
        let step = |low: f64, high: f64, usual: f64| features.longest_step([low, high], usual, (1.0, 4.0), 5e-4);
        assert_eq!(step(0.0, 90.0, 0.25), 0.25, "it lies elsewhere");
        assert_eq!(step(98.0, 102.0, 0.25), 0.25, "it is a voxel thick");
        let short = step(60.0, 140.0, 0.25);
        assert!(short < 0.05 && short > 0.01, "{short}");
        assert!(step(0.0, 200.0, 0.25) < short);
    }
}
