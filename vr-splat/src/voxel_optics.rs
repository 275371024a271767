//! Emission and absorption of a voxel or point, by its stored number.

use vr_core::{Calibration, TransferFunction};

/// Emission and extinction per world unit, over stored numbers.
pub(crate) struct VoxelOptics {
    /// (q, κ): of each integer, or at equal distances.
    rows: Vec<[f32; 4]>,
    origin: f32,
    per_unit: f32,
}

/// Intervals over numbers that are no integers.
const INTERVALS: usize = 8192;
/// Integers that have a row each.
const MAX_ROWS: f64 = 65536.0;
/// Extinction times unit distance of what is opaque: nothing is seen through a thousandth of a kernel. More would make something of what rounding
/// leaves at a kernel's edge.
pub(crate) const OPAQUE: f64 = 1e4;

impl VoxelOptics {
    pub(crate) fn new(transfer: &TransferFunction, calibration: Calibration, range: (f32, f32), integer: bool) -> Self {
        let (low, high) = (f64::from(range.0), f64::from(range.1));
        let intervals = if integer && high - low < MAX_ROWS { (high - low).max(1.0) as usize } else { INTERVALS };
        let spacing = if high > low { (high - low) / intervals as f64 } else { 1.0 };
        let row = |i: usize| optics_of(transfer, calibration.value(low + i as f64 * spacing)).map(|x| x as f32);
        Self {
            rows: (0..=intervals).chain([intervals]).map(row).collect(),
            origin: range.0,
            per_unit: (1.0 / spacing) as f32,
        }
    }

    /// (q, κ) of a stored number.
    #[inline(always)]
    pub(crate) fn at(&self, stored: f32) -> [f32; 4] {
        let x = ((stored - self.origin) * self.per_unit).max(0.0).min((self.rows.len() - 2) as f32);
        let i = x as usize;
        let t = x - i as f32;
        let (a, b) = (self.rows[i], self.rows[i + 1]);
        [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2]), a[3] + t * (b[3] - a[3])]
    }
}

/// (q, κ) of a value, per world unit; an opaque one's κ is large, not infinite.
pub(crate) fn optics_of(transfer: &TransferFunction, value: f64) -> [f64; 4] {
    let at = transfer.at(value);
    let kappa = transfer.extinction(at.opacity).min(OPAQUE / transfer.unit_distance());
    let [r, g, b] = if transfer.has_emission() { at.emission } else { at.color.map(|c| c * kappa) };
    [r, g, b, kappa]
}
