//! Range of stored numbers that a table must cover, and tests that tables and precisions resolve it.

use vr_core::filter::Reconstruction;
use vr_core::{Filter, GridVolume, Real, Sampler, SamplerVisitor, Scene, TransferFunction, Voxel};
use vr_kernels::tables::{self, BakedTransfer};

/// Returns a table for steps of one length that resolves a scene's transfer function, if there is one.
pub(crate) fn baked<R: Real>(scene: &Scene, volume: &GridVolume, step: f64) -> Option<BakedTransfer<R>> {
    let range = table_range(volume, &scene.transfer);
    let integer = volume.voxel_type().is_integer();
    let table = BakedTransfer::new(&scene.transfer, volume.calibration(), range, integer, step);
    resolves(&table, volume).then_some(table)
}

/// Returns the range of a volume's field in stored units, overshoot included; `None` if all of it is vacuum.
pub(crate) fn field_range(volume: &GridVolume) -> Option<(f64, f64)> {
    let (low, high) = volume.value_stats().range.map(|(l, h)| (f64::from(l), f64::from(h)))?;
    Some(match volume.filter() {
        // Weights that are not negative and sum to 1 do not leave the range of the samples.
        Filter::Nearest | Filter::Trilinear | Filter::Gaussian => (low, high),
        // Per axis Σ|w| ≤ 5/4 (at the middle of a cell).
        Filter::CatmullRom => {
            let (centre, radius) = (0.5 * (low + high), 0.5 * (high - low) * 1.25f64.powi(3));
            (centre - radius, centre + radius)
        }
        // The same, of the coefficients.
        Filter::BSpline => volume.with_sampler(CoefficientRange),
    })
}

struct CoefficientRange;

impl SamplerVisitor for CoefficientRange {
    type Output = (f64, f64);

    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) -> (f64, f64) {
        let widen = |(low, high): (f32, f32), c: &T| (low.min(c.to_f32()), high.max(c.to_f32()));
        let (low, high) = sampler.lattice().samples.iter().fold((f32::INFINITY, f32::NEG_INFINITY), widen);
        (low.to_f64(), high.to_f64())
    }
}

/// Returns the part of the field's range in which the transfer function is not constant: a table over it can be finer.
pub(crate) fn table_range(volume: &GridVolume, transfer: &TransferFunction) -> (f32, f32) {
    let range = field_range(volume).unwrap_or((0.0, 0.0));
    tables::table_range(range, volume.voxel_type().is_integer(), volume.calibration(), transfer)
}

/// True if a table resolves the transfer function over a field.
pub(crate) fn resolves<R: Real>(table: &BakedTransfer<R>, volume: &GridVolume) -> bool {
    // Entries at all integers are exact for a field of integers.
    let integers = volume.filter() == Filter::Nearest && volume.voxel_type().is_integer();
    table.resolves() || (integers && table.spacing() <= 1.0)
}

/// Largest rounding of a value to f32, in widths of the narrowest ramp, with which kernels in f32 draw: a value that is rounded a few times is known to
/// 10⁻³ of the ramp, and the place of a jump to 10⁻³ of the field.
pub(crate) const MAX_ROUNDING: f64 = 1.0 / 4096.0;

/// True if f32 resolves the transfer function.
pub(crate) fn single_precision_resolves(volume: &GridVolume, transfer: &TransferFunction) -> bool {
    tables::rounding_in_f32(volume, transfer) <= MAX_ROUNDING
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{Calibration, ControlPoint, OpacityRule, Placement, UniformGrid, Volume};

    #[test]
    fn ramps_finer_than_the_table_are_noticed() {
        let samples = vec![0u16, 65535, 0, 0, 0, 0, 0, 0];
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let volume: Volume = UniformGrid::new([2; 3], samples, placement, Calibration::default()).unwrap().into();
        let resolved = |values: &[f64], filter| {
            let volume = volume.with_filter(filter);
            let volume = volume.grid().unwrap();
            let points = values.iter().map(|&v| ControlPoint::new(v, [1.0; 3], 0.5)).collect();
            let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
            let range = table_range(volume, &transfer);
            let table = BakedTransfer::<f32>::new(&transfer, volume.calibration(), range, true, 1.0);
            resolves(&table, volume)
        };
        assert!(resolved(&[0.0, 30000.0, 65535.0], Filter::Trilinear));
        assert!(!resolved(&[0.0, 30000.0, 30001.0, 65535.0], Filter::Trilinear));
        assert!(resolved(&[29990.0, 30000.0, 30010.0], Filter::Trilinear), "the table covers what the points do");
        assert!(resolved(&[29990.0, 30000.0, 30001.0, 30010.0], Filter::Nearest));
    }
}
