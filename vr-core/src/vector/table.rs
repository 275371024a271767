//! The transfer function's table, looked up for sixteen values at once.

use super::{LANES, opacity_of_depth, pick, splat, transpose};
use crate::grid::Calibration;
use crate::transfer::{BakedTransfer, Optical, TransferFunction};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16, i32x16};

/// Colour and extinction over the field's stored numbers, at the same places as a [`BakedTransfer`]: what a step of any length is made
/// of.
///
/// Colours are linear between control points, and so exact; extinction is off by its curvature over one interval. Each interval has
/// a row of its own for both of its ends: at a jump, neither colour nor extinction of one side shows on the other. Where emission
/// is given on its own, it stands in the place of colour.
#[derive(Clone, Debug)]
pub struct OpticsTable {
    /// (r, g, b, κ) at the start and the end of each interval, κ per step of length 1; the last end once more.
    rows: Vec<[[f32; 4]; 2]>,
    origin: f32,
    per_unit: f32,
    /// Whether the rows hold emission, per step of length 1, and not colour.
    pub emits: bool,
}

/// An extinction that no length of a step brings to infinity, and that is opaque all the same.
const OPAQUE: f64 = 1e30;

impl OpticsTable {
    /// At the places of `table`, for lengths in units of `step` world units.
    pub fn new(table: &BakedTransfer<f32>, transfer: &TransferFunction, calibration: Calibration, step: f64) -> Self {
        let (grid, emits) = (table.grid(), transfer.has_emission());
        let light = |at: &Optical| if emits { at.emission.map(|q| q * step) } else { at.color };
        let rows = (0..=grid.intervals()).map(|i| {
            // The last interval has no length.
            let ends = [i, (i + 1).min(grid.intervals())];
            let optical = ends.map(|entry| grid.optical(transfer, calibration, i, grid.place(entry)));
            let kappa = extinctions(transfer, &optical).map(|kappa| (kappa * step).min(OPAQUE));
            [0, 1].map(|end| {
                let [r, g, b] = light(&optical[end]);
                [r, g, b, kappa[end]].map(|x| x as f32)
            })
        });
        Self { rows: rows.collect(), origin: table.origin(), per_unit: table.per_unit(), emits }
    }

    /// The rows, for look-ups.
    pub fn rows(&self) -> Rows<'_> {
        Rows { rows: &self.rows, origin: self.origin, per_unit: self.per_unit, last: (self.rows.len() - 1) as f32 }
    }
}

/// Extinctions at the ends of an interval.
///
/// Where opacity touches 1 at one end only, extinction has an integrable logarithm there. With w = 1 − α from ω to 0, the mean of
/// −ln w is 1 − ln ω: a line from −ln ω to 2 − ln ω has the same mean, and so the same optical depth.
fn extinctions(transfer: &TransferFunction, ends: &[Optical; 2]) -> [f64; 2] {
    let [a, b] = ends.map(|o| transfer.extinction(o.opacity));
    let peak = |other: f64| other + 2.0 / transfer.unit_distance();
    match (a.is_finite(), b.is_finite()) {
        (true, false) => [a, peak(a)],
        (false, true) => [peak(b), b],
        _ => [a, b],
    }
}

/// Light and opacity of homogeneous steps of any length.
///
/// α = 1 − e^(−κh); light is c·α, or q·h·α/τ where the rows hold emission.
#[inline(always)]
pub fn light_of<S: Simd>(simd: S, optics: [f32x16<S>; 4], length: f32x16<S>, emits: bool) -> [f32x16<S>; 4] {
    let [r, g, b, kappa] = optics;
    let tau = kappa * length;
    let alpha = opacity_of_depth(simd, tau);
    let share = if emits {
        let clear = tau.simd_le(splat(simd, 0.0));
        let one = splat(simd, 1.0);
        length * pick(clear, one, alpha / pick(clear, one, tau))
    } else {
        alpha
    };
    [r * share, g * share, b * share, alpha]
}

/// A table of rows of four numbers over the field's stored numbers, interpolated linearly in each interval.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a> {
    /// Start and end of each interval; the last one has no length.
    rows: &'a [[[f32; 4]; 2]],
    origin: f32,
    per_unit: f32,
    /// The largest index.
    last: f32,
}

impl<'a> Rows<'a> {
    /// Those of a baked table: light and opacity of whole steps.
    pub fn of(table: &'a BakedTransfer<f32>) -> Self {
        let rows = table.rows();
        Self { rows, origin: table.origin(), per_unit: table.per_unit(), last: (rows.len() - 1) as f32 }
    }

    /// The interpolated rows of sixteen values, component by component.
    ///
    /// A row is one load into a register: through memory, a wide load would have to wait for the narrow stores before it.
    #[inline(always)]
    pub fn at<S: Simd>(&self, simd: S, value: f32x16<S>) -> [f32x16<S>; 4] {
        let x = ((value - self.origin) * self.per_unit).max(splat(simd, 0.0)).min(splat(simd, self.last));
        let index: i32x16<S> = x.to_int();
        let t = x - index.to_float::<f32x16<S>>();
        let index = index.to_array();
        let zero = f32x4::splat(simd, 0.0);
        let (mut low, mut high) = ([zero; LANES], [zero; LANES]);
        for j in 0..LANES {
            let ends = &self.rows[index[j] as u32 as usize];
            low[j] = f32x4::load_array_ref(simd, &ends[0]);
            high[j] = f32x4::load_array_ref(simd, &ends[1]);
        }
        let (low, high) = (transpose(low), transpose(high));
        [
            low[0] + t * (high[0] - low[0]),
            low[1] + t * (high[1] - low[1]),
            low[2] + t * (high[2] - low[2]),
            low[3] + t * (high[3] - low[3]),
        ]
    }
}
