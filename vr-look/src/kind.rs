//! Kinds of data, told by their values.

use crate::lattice::Lattice;
use crate::scale::Scale;

/// Kind of data that a volume holds.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Kind {
    /// Numbers that name regions; the values that occur, ascending.
    Labels(Vec<f64>),
    /// CT in Hounsfield units: air at −1000, water at 0.
    Hounsfield,
    /// Values of both signs about a zero that means nothing.
    Signed,
    /// A density or intensity of which most is orders of magnitude below the largest.
    HeavyTail,
    /// A scan or a microscope's stack: numbers without a unit.
    Scan,
    /// Voxels that have colours of their own.
    Color,
    /// Anything else: a simulation's field, say.
    Field,
}

impl Kind {
    /// The kind in words.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Labels(values) if values.len() <= 2 => "mask",
            Self::Labels(_) => "labels",
            Self::Hounsfield => "CT in Hounsfield units",
            Self::Signed => "values of both signs",
            Self::HeavyTail => "heavy tail",
            Self::Scan => "scan",
            Self::Color => "colours as they are",
            Self::Field => "field",
        }
    }
}

/// Largest number of labels.
const MAX_LABELS: usize = 256;

/// Statistics of a volume's finite samples.
pub(crate) struct Values {
    /// Ascending.
    sorted: Vec<f64>,
}

impl Values {
    pub fn new(lattice: &Lattice) -> Self {
        // Some ten thousands are enough for shares.
        let step = (lattice.values.len() >> 16).max(1);
        let mut sorted: Vec<f64> = lattice.values.iter().copied().step_by(step).filter(|v| !v.is_nan()).collect();
        sorted.sort_unstable_by(f64::total_cmp);
        Self { sorted }
    }

    /// The value below which that share of the samples lies; `None` where there are none.
    pub fn at_share(&self, share: f64) -> Option<f64> {
        quantile(&self.sorted, share)
    }

    /// Share of the samples from `low` to `high`.
    fn share_within(&self, low: f64, high: f64) -> f64 {
        let count = self.sorted.partition_point(|&v| v <= high) - self.sorted.partition_point(|&v| v < low);
        count as f64 / self.sorted.len().max(1) as f64
    }

    fn positive(&self) -> &[f64] {
        &self.sorted[self.sorted.partition_point(|&v| v <= 0.0)..]
    }
}

fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    Some(sorted[(share * last as f64).round() as usize])
}

/// Ratio of the largest values to the median from which a tail is heavy.
const HEAVY: f64 = 100.0;

/// Tells the kind, and the scale on which the values are spread.
pub(crate) fn kind_of(lattice: &Lattice, values: &Values, integer: bool, scan: bool) -> (Kind, Scale) {
    let (Some(low), Some(high)) = (values.at_share(0.0005), values.at_share(0.9995)) else {
        return (Kind::Field, Scale::Linear { low: 0.0, high: 1.0 });
    };
    let linear = widened(low, high, values);
    if let Some(labels) = labels(lattice) {
        return (Kind::Labels(labels), linear);
    }
    // Air about the patient, and something denser than fat: a scan of which only the range is that of CT has none.
    let air = values.share_within(-1100.0, -800.0);
    if (-4096.0..=-800.0).contains(&low) && high <= 32767.0 && air > 0.02 && values.share_within(-200.0, 32767.0) > 0.01
    {
        return (Kind::Hounsfield, linear);
    }
    // A scanner's negative values are an offset or noise.
    let smaller = values.share_within(f64::NEG_INFINITY, 0.05 * low.min(0.0));
    if low < 0.0 && high > 0.0 && smaller > 0.05 && -low > 0.1 * high && !scan && !integer {
        let reach = high.max(-low);
        return (Kind::Signed, Scale::Linear { low: -reach, high: reach });
    }
    let positive = values.positive();
    if let (Some(median), Some(largest)) = (quantile(positive, 0.5), quantile(positive, 0.9995))
        && low >= 0.0
        && largest > HEAVY * median
    {
        let floor = quantile(positive, 0.05).unwrap_or(median).max(1e-6 * largest);
        return (Kind::HeavyTail, Scale::Logarithmic { low: floor, high: largest });
    }
    (if integer || scan { Kind::Scan } else { Kind::Field }, linear)
}

/// The scale of values beside which there are colours: they are no labels, and no unit is known.
pub(crate) fn scale_of_colors(values: &Values) -> Scale {
    match (values.at_share(0.0005), values.at_share(0.9995)) {
        (Some(low), Some(high)) => widened(low, high, values),
        _ => Scale::Linear { low: 0.0, high: 1.0 },
    }
}

/// A scale over a range that is not a single value: rare values, if nothing else differs.
fn widened(low: f64, high: f64, values: &Values) -> Scale {
    if low < high {
        return Scale::Linear { low, high };
    }
    let (first, last) = (values.at_share(0.0).unwrap_or(low), values.at_share(1.0).unwrap_or(high));
    if first < last {
        return Scale::Linear { low: first, high: last };
    }
    let half = f64::max(0.5, 1e-6 * low.abs());
    Scale::Linear { low: low - half, high: low + half }
}

/// Returns the labels, if values are few, neighbours mostly equal, and differences not those of one step of a measured value.
fn labels(lattice: &Lattice) -> Option<Vec<f64>> {
    if lattice.next.is_empty() {
        return None;
    }
    // Of many places every fifth rules out nearly all that is measured.
    let step = if lattice.values.len() > 1 << 17 { 5 } else { 1 };
    let some = distinct(lattice, step)?;
    if some.len() > 2 && !name_regions(&some, lattice, step) {
        return None;
    }
    let values = distinct(lattice, 1)?;
    let are_labels = values.len() == 2 || values.len() > 2 && name_regions(&values, lattice, step);
    are_labels.then_some(values)
}

/// Returns the values of every `step`-th place, ascending, if they are no more than labels may be.
fn distinct(lattice: &Lattice, step: usize) -> Option<Vec<f64>> {
    let mut values: Vec<f64> = Vec::new();
    let mut last = f64::NAN;
    for &value in lattice.values.iter().step_by(step).filter(|v| !v.is_nan()) {
        // Neighbours are mostly equal, where this matters.
        if value == last {
            continue;
        }
        last = value;
        let at = values.partition_point(|&v| v < value);
        if values.get(at) != Some(&value) {
            values.insert(at, value);
            if values.len() > MAX_LABELS {
                return None;
            }
        }
    }
    Some(values)
}

/// True if neighbours are mostly equal, and many of the others more than one level apart.
fn name_regions(values: &[f64], lattice: &Lattice, step: usize) -> bool {
    let rank = |v: f64| values.partition_point(|&x| x < v);
    let mut counts = vec![0usize; values.len() + 1];
    for &value in lattice.values.iter().step_by(step).filter(|v| !v.is_nan()) {
        counts[rank(value)] += 1;
    }
    let background = (0..values.len()).max_by_key(|&i| counts[i]).map(|i| values[i]);
    let (mut pairs, mut equal, mut jumps) = (0usize, 0usize, 0usize);
    for (&a, &b) in lattice.values.iter().zip(&lattice.next).step_by(step).filter(|(a, b)| !a.is_nan() && !b.is_nan()) {
        if a == b && Some(a) == background {
            continue;
        }
        pairs += 1;
        equal += usize::from(a == b);
        jumps += usize::from(rank(a).abs_diff(rank(b)) > 1);
    }
    // What is measured differs from voxel to voxel by noise, and by one level at slopes.
    let unequal = pairs - equal;
    unequal > 0 && equal as f64 > 0.6 * pairs as f64 && jumps as f64 > 0.3 * unequal as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{Calibration, Placement, UniformGrid};

    const SIDE: usize = 24;

    fn kind(value: impl Fn([f64; 3]) -> f64, integer: bool, scan: bool) -> Kind {
        let place = |i: usize| (i as f64 + 0.5) / SIDE as f64 * 2.0 - 1.0;
        let at = |i: usize| [place(i % SIDE), place(i / SIDE % SIDE), place(i / SIDE / SIDE)];
        let values = (0..SIDE * SIDE * SIDE).map(|i| value(at(i)));
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let calibration = Calibration::default();
        let volume: vr_core::Volume = if integer {
            UniformGrid::new([SIDE; 3], values.map(|v| v as i16).collect::<Vec<_>>(), placement, calibration)
                .unwrap()
                .into()
        } else {
            UniformGrid::new([SIDE; 3], values.map(|v| v as f32).collect::<Vec<_>>(), placement, calibration)
                .unwrap()
                .into()
        };
        let lattice = Lattice::new(&volume);
        kind_of(&lattice, &Values::new(&lattice), integer, scan).0
    }

    fn radius([x, y, z]: [f64; 3]) -> f64 {
        (x * x + y * y + z * z).sqrt()
    }

    #[test]
    fn kinds_are_told_apart() {
        let ball = |p| if radius(p) < 0.7 { 257.0 } else { 0.0 };
        assert_eq!(kind(ball, true, false), Kind::Labels(vec![0.0, 257.0]));
        let regions = |p: [f64; 3]| if radius(p) < 0.8 { 2.0 + 5.0 * f64::from(u8::from(p[0] > 0.1)) } else { 0.0 };
        assert_eq!(kind(regions, true, false), Kind::Labels(vec![0.0, 2.0, 7.0]));
        let head = |p| if radius(p) < 0.7 { 40.0 + 60.0 * radius(p) } else { -1000.0 };
        assert_eq!(kind(head, true, true), Kind::Hounsfield);
        // Its range alone would be that of CT.
        assert_eq!(kind(|p| 9000.0 + 9600.0 * (5.0 * p[0]).sin() * (3.0 * p[1]).cos(), true, true), Kind::Scan);
        assert_eq!(kind(|p| p[0] * (-radius(p)).exp(), false, false), Kind::Signed);
        assert_eq!(kind(|p| p[0] * (-radius(p)).exp(), false, true), Kind::Scan);
        assert_eq!(kind(|p| (-20.0 * radius(p)).exp(), false, false), Kind::HeavyTail);
        assert_eq!(kind(|p| 3.0 + p[0] + p[1], false, false), Kind::Field);
        assert_eq!(kind(|p| 100.0 * (1.0 + p[0]) + 10.0 * p[1], true, false), Kind::Scan);
        assert_eq!(kind(|_| 3.0, false, false), Kind::Field);
        assert_eq!(kind(|_| f64::NAN, false, false), Kind::Field);
    }
}
