//! The transfer function's table, looked up for sixteen values at once.

use super::{LANES, opacity_of_depth, pick, source_weight, splat, transpose};
use crate::tables::{BakedTransfer, lone_walls};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16, i32x16};
use vr_core::Calibration;
use vr_core::transfer::{Optical, TransferFunction};

/// Colour and extinction over the field's stored numbers, at the same places as a [`BakedTransfer`]: for steps of any length.
///
/// Colours are linear between control points, and so exact; extinction is off by its curvature over one interval. Each interval has
/// a row of its own for both of its ends: at a jump, neither colour nor extinction of one side shows on the other. Where emission
/// is given on its own, it stands in the place of colour.
#[derive(Clone, Debug)]
pub struct OpticsTable {
    /// (r, g, b, κ) at the start and the end of each interval, κ per step of length 1; the last end once more.
    rows: Vec<[[f32; 4]; 2]>,
    /// Isolated values of opacity 1: the stored number of each, and its row.
    walls: Vec<(f32, [f32; 4])>,
    origin: f32,
    per_unit: f32,
    /// True if the rows hold emission, per step of length 1, and not colour.
    pub emits: bool,
}

/// An extinction that no length of a step brings to infinity, and that is opaque all the same.
const OPAQUE: f64 = 1e30;

impl OpticsTable {
    /// A table at the places of `table`, for lengths in units of `step` world units.
    pub fn new(table: &BakedTransfer<f32>, transfer: &TransferFunction, calibration: Calibration, step: f64) -> Self {
        let (grid, emits) = (table.grid(), transfer.has_emission());
        let light = |at: &Optical| if emits { at.emission.map(|q| q * step) } else { at.color };
        let row = |at: &Optical| {
            let [r, g, b] = light(at);
            [r, g, b, (transfer.extinction(at.opacity) * step).min(OPAQUE)].map(|x| x as f32)
        };
        let rows = grid.rows(transfer, calibration, row);
        let walls = lone_walls(transfer, calibration).into_iter().map(|(at, wall)| (at, row(&wall)));
        Self { rows, walls: walls.collect(), origin: table.origin(), per_unit: table.per_unit(), emits }
    }

    /// The rows, for look-ups.
    pub fn rows(&self) -> Rows<'_> {
        let last = (self.rows.len() - 1) as f32;
        Rows { rows: &self.rows, walls: &self.walls, origin: self.origin, per_unit: self.per_unit, last }
    }
}

/// Light and opacity of homogeneous steps of any length.
///
/// α = 1 − e^(−κh); light is c·α, or q·h·α/τ where the rows hold emission.
#[inline(always)]
pub fn step_light<S: Simd>(simd: S, optics: [f32x16<S>; 4], length: f32x16<S>, emits: bool) -> [f32x16<S>; 4] {
    let [r, g, b, kappa] = optics;
    let tau = kappa * length;
    let alpha = opacity_of_depth(simd, tau);
    let share = if emits { length * source_weight(simd, tau, alpha) } else { alpha };
    [r * share, g * share, b * share, alpha]
}

/// A table of rows of four numbers over the field's stored numbers, interpolated linearly in each interval.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a> {
    /// Start and end of each interval; the last one has no length.
    rows: &'a [[[f32; 4]; 2]],
    walls: &'a [(f32, [f32; 4])],
    origin: f32,
    per_unit: f32,
    /// The largest index.
    last: f32,
}

impl<'a> Rows<'a> {
    /// The rows of a baked table: light and opacity of whole steps.
    pub fn new(table: &'a BakedTransfer<f32>) -> Self {
        let rows = table.rows();
        let last = (rows.len() - 1) as f32;
        Self { rows, walls: table.walls(), origin: table.origin(), per_unit: table.per_unit(), last }
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
        let found = [
            low[0] + t * (high[0] - low[0]),
            low[1] + t * (high[1] - low[1]),
            low[2] + t * (high[2] - low[2]),
            low[3] + t * (high[3] - low[3]),
        ];
        if self.walls.is_empty() { found } else { self.with_walls(simd, value, found) }
    }

    /// The rows, but for values that are walls by themselves.
    #[inline(always)]
    fn with_walls<S: Simd>(&self, simd: S, value: f32x16<S>, mut found: [f32x16<S>; 4]) -> [f32x16<S>; 4] {
        for (wall, row) in self.walls {
            let here = value.simd_eq(splat(simd, *wall));
            for (c, found) in found.iter_mut().enumerate() {
                *found = pick(here, splat(simd, row[c]), *found);
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};
    use vr_core::transfer::{ControlPoint, OpacityRule};

    #[test]
    fn a_single_value_is_a_wall_and_its_neighbours_are_not() {
        let point = |value, opacity| ControlPoint::new(value, [0.25, 0.5, 1.0], opacity);
        let transfer =
            TransferFunction::new(vec![point(1.0, 0.0), point(2.0, 1.0), point(3.0, 0.0)], OpacityRule::Power, 1.0)
                .unwrap();
        let calibration = Calibration::default();
        let baked = BakedTransfer::<f32>::new(&transfer, calibration, (0.0, 4.0), true, 0.01);
        let optics = OpticsTable::new(&baked, &transfer, calibration, 0.01);
        let mut values = [0.5; LANES];
        (values[3], values[7], values[11]) = (2.0, 2.0f32.next_up(), 2.0f32.next_down());
        let at = |rows: Rows<'_>| dispatch!(Level::new(), simd => rows.at(simd, f32x16::load_array_ref(simd, &values)).map(|c| c.to_array()));
        let (steps, kappas) = (at(Rows::new(&baked)), at(optics.rows()));
        assert_eq!([0, 1, 2, 3].map(|c| steps[c][3]), [0.25, 0.5, 1.0, 1.0]);
        assert_eq!([0, 1, 2, 3].map(|c| kappas[c][3]), [0.25, 0.5, 1.0, OPAQUE as f32]);
        for (i, value) in values.iter().enumerate() {
            assert_eq!(steps[3][i], baked.step(*value)[3]);
            // e⁻⁹ is left over of one voxel at the peak of a table of 1024 entries to a number.
            assert!(i == 3 || (steps[3][i] < 0.1 && kappas[3][i] < 0.1), "{} {}", steps[3][i], kappas[3][i]);
        }
    }
}
