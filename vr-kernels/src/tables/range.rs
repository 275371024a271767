//! Stored numbers that a table must cover, and tests whether its entries, and single precision, tell apart all that a transfer function does.

use vr_core::transfer::Segment;
use vr_core::{Calibration, GridVolume, OpacityRule, TransferFunction};

/// Part of a table's range by which it goes beyond the first and the last control point: more than the distance of two entries, so that
/// a jump at an end point has its other side in the table.
const MARGIN: f64 = 1.0 / 1024.0;

/// The part of a field's range, in stored numbers (of integers, if `integer`), in which a transfer function is not constant: a table over it can be
/// finer.
pub fn table_range(
    (low, high): (f64, f64),
    integer: bool,
    calibration: Calibration,
    transfer: &TransferFunction,
) -> (f32, f32) {
    let points = transfer.points();
    let ends = [&points[0], &points[points.len() - 1]].map(|p| calibration.stored(p.value));
    let (first, last) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
    // A single point, or several at one value, has no extent of its own.
    let extent = if last > first { last - first } else { high - low };
    let margin = (extent * MARGIN).max(if integer { 1.0 } else { 0.0 });
    // Both stay inside the field's range, in which a table of no extent is one constant, too.
    let (low, high) = ((first - margin).clamp(low, high), (last + margin).clamp(low, high));
    round_outward(if integer { (low.floor(), high.ceil()) } else { (low, high) })
}

/// Rounds a range outward, to the smallest one with f32 ends that holds it. Rounded to the nearest, ends would fall onto the knot between
/// them, or cut a ramp, where the field is only a few f32 numbers wide.
pub fn round_outward((low, high): (f64, f64)) -> (f32, f32) {
    let (below, above) = (low as f32, high as f32);
    (
        if f64::from(below) > low { below.next_down() } else { below },
        if f64::from(above) < high { above.next_up() } else { above },
    )
}

/// Smallest number of entries that the narrowest ramp of a transfer function must span. A ramp to α = 1 has most of its extinction at its
/// end, and a table's chord there is wrong over one entry, which may be an eighth of the ramp.
const ENTRIES_PER_RAMP: f64 = 8.0;

/// Segments of finite width.
fn ramps(transfer: &TransferFunction) -> impl Iterator<Item = &Segment> {
    transfer.segments().iter().filter(|s| s.from.is_finite() && s.to.is_finite())
}

/// True if entries so many stored units apart tell apart all that a transfer function does.
pub(super) fn resolves_ramps(spacing: f64, calibration: Calibration, transfer: &TransferFunction) -> bool {
    let slope = calibration.slope.abs();
    // Spacings of 1/16 and the like come back rounded from f32.
    let min = ENTRIES_PER_RAMP * spacing * (1.0 - 1e-6);
    ramps(transfer).map(|s| (s.to - s.from) / slope).all(|width| width >= min)
}

/// Error of a stored number that is rounded to f32, relative to the narrowest ramp, or to the field's range if that is narrower and
/// something jumps in it.
///
/// A constant is exact under filters that take voxels as they are, and of no rounding; the coefficients and weights of wider ones
/// are rounded there, too, and their fields may leave the range of the voxels. Ramps that no number of the field comes near do not
/// count, nor does how narrow a jump is: no precision has room for it.
pub fn rounding_in_f32(volume: &GridVolume, transfer: &TransferFunction) -> f64 {
    let range = volume.value_stats().range.map(|(low, high)| (f64::from(low), f64::from(high)));
    range.map_or(0.0, |range| rounding_over(range, volume.calibration(), volume.filter().reach() > 0, transfer))
}

/// The same of a field between two stored numbers; `wide` if it may leave their range.
pub fn rounding_over(
    (low, high): (f64, f64),
    calibration: Calibration,
    wide: bool,
    transfer: &TransferFunction,
) -> f64 {
    if low == high && !wide {
        return 0.0;
    }
    let rounding = 0.5 * f64::from(f32::EPSILON) * low.abs().max(high.abs());
    let inside = |at: f64| low <= at && at <= high;
    let jumps = transfer.points().windows(2).filter(|pair| pair[0].value == pair[1].value);
    let jumps = jumps
        .map(|pair| calibration.stored(pair[0].value))
        .any(inside)
        .then_some(high - low)
        .filter(|span| *span > 0.0);
    let ramps = ramps(transfer).map(|s| [s.from, s.to].map(|v| calibration.stored(v)));
    let beyond = if wide { high - low + rounding } else { 0.0 };
    let met =
        ramps.filter(|[a, b]| a.min(*b) <= high + beyond && a.max(*b) >= low - beyond).map(|[a, b]| (b - a).abs());
    let narrowest = met.chain(jumps).fold(f64::INFINITY, f64::min);
    rounding / narrowest
}

/// Largest [`rounding_in_f32`] of a scene that kernels in f32 draw: a ramp is known to a thirtieth then.
const MAX_ROUNDING: f64 = 1.0 / 32.0;

/// The feature that a renderer whose kernels are f32 and whose filter is trilinear must refuse: a transfer function with ramps that
/// f32 does not tell apart.
pub fn beyond_f32(volume: &GridVolume, transfer: &TransferFunction) -> Option<String> {
    let rounding = rounding_in_f32(volume, transfer);
    (rounding > MAX_ROUNDING).then(|| {
        format!("a transfer function that changes within {:.1} roundings of the stored numbers to f32", 1.0 / rounding)
    })
}

/// Largest optical depth over a unit distance by which extinction may be off between two entries of a table.
const MAX_CURVATURE: f64 = 1e-4;

/// True if extinction is as good as linear over values so far apart. Under the power rule it is −ln(1 − α), and bends where α comes near 1: from a line between two
/// values, over which α grows by δ, it is off by ⅛·(δ / (1 − α))².
pub fn resolves_extinction(transfer: &TransferFunction, spacing: f64) -> bool {
    transfer.rule() == OpacityRule::Extinction
        || transfer.segments().iter().all(|segment| {
            let rise = (segment.end.opacity - segment.start.opacity).abs();
            let per_entry = rise * (spacing / (segment.to - segment.from)).min(1.0);
            let clear = 1.0 - segment.end.opacity.max(segment.start.opacity);
            per_entry == 0.0 || 0.125 * (per_entry / clear).powi(2) <= MAX_CURVATURE
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::transfer::{ControlPoint, OpacityRule};
    use vr_core::{Filter, Placement, UniformGrid, Volume};

    #[test]
    fn narrow_ramps_and_jumps_in_narrow_fields_are_rounded() {
        let rounding = |values: [f32; 2], ramp: [f64; 2]| {
            let samples = vec![values[0], values[1], values[0], values[0], values[0], values[0], values[0], values[0]];
            let placement = Placement::from_spacing([1.0; 3]).unwrap();
            let volume: Volume = UniformGrid::new([2; 3], samples, placement, Calibration::default()).unwrap().into();
            let points = [(ramp[0], 0.1), (ramp[1], 0.9)].map(|(v, a)| ControlPoint::new(v, [1.0; 3], a));
            let transfer = TransferFunction::new(points.to_vec(), OpacityRule::Power, 1.0).unwrap();
            [Filter::Trilinear, Filter::BSpline]
                .map(|filter| rounding_in_f32(volume.with_filter(filter).grid().unwrap(), &transfer))
        };
        let unit = 0.5f64.powi(24);
        assert_eq!(rounding([0.0, 1024.0], [100.0, 102.0]), [512.0 * unit; 2]);
        let [inside, beyond] = rounding([0.0, 1024.0], [1500.0, 1500.5]);
        assert!(inside == 0.0 && beyond == 2048.0 * unit, "wider filters overshoot");
        assert_eq!(rounding([0.0, 1024.0], [3000.0, 3000.5]), [0.0; 2], "beyond the field");
        assert_eq!(rounding([0.0, 1024.0], [2.0, 2.0]), [unit; 2], "a jump");
        assert_eq!(rounding([1e9, 1e9], [1e9, 1e9]), [0.0; 2], "a jump at a constant");
        let [exact, coefficients] = rounding([65536.0, 65536.0], [65535.0, 65537.0]);
        assert!(exact == 0.0 && coefficients == 32768.0 * unit, "a constant on a ramp");
        // Carried as distances from the first.
        assert!(rounding([1e6, 1_000_010.0], [1e6, 1_000_001.0])[0] <= 10.0 * unit);
    }

    #[test]
    fn what_f32_cannot_tell_apart_is_a_feature_to_refuse() {
        let samples = vec![0.0f32, 1e6, 5e5, 0.0, 0.0, 0.0, 0.0, 0.0];
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let volume: Volume = UniformGrid::new([2; 3], samples, placement, Calibration::default()).unwrap().into();
        let refused = |width: f64| {
            let points = [(5e5, 0.1), (5e5 + width, 0.9)].map(|(v, a)| ControlPoint::new(v, [1.0; 3], a));
            let transfer = TransferFunction::new(points.to_vec(), OpacityRule::Power, 1.0).unwrap();
            beyond_f32(volume.grid().unwrap(), &transfer)
        };
        assert_eq!(refused(10.0), None);
        assert!(refused(0.5).is_some_and(|feature| feature.contains("8.4 roundings")));
    }

    #[test]
    fn ends_are_rounded_outward() {
        assert_eq!(round_outward((1000.0, 1000.0)), (1000.0, 1000.0));
        let jump = 1_000.000_123;
        let (low, high) = round_outward((jump - 1e-9, jump + 1e-9));
        assert!(f64::from(low) < jump && jump < f64::from(high));
        assert_eq!(low.next_up(), high);
        assert_eq!(round_outward((-f64::from(f32::MAX), f64::from(f32::MAX))), (-f32::MAX, f32::MAX));
    }

    #[test]
    fn extinction_bends_where_it_is_nearly_opaque() {
        let ramp = |rule, top| {
            let points = [(0.0, 0.0), (1.0, top), (1.0, 1.0)].map(|(v, a)| ControlPoint::new(v, [1.0; 3], a));
            resolves_extinction(&TransferFunction::new(points.to_vec(), rule, 1.0).unwrap(), 1e-3)
        };
        assert!(ramp(OpacityRule::Power, 0.9) && !ramp(OpacityRule::Power, 0.98));
        assert!(!ramp(OpacityRule::Power, 1.0) && ramp(OpacityRule::Extinction, 1.0));
    }
}
