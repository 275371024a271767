//! The transfer function's table, looked up for sixteen values at once.

use super::{opacity_of_depth, pick, rows_at, source_weight, splat};
use crate::tables::{BakedTransfer, lone_walls};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};
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
        let row = |at: &Optical| row_of(transfer, at, step);
        let rows = grid.rows(transfer, calibration, row);
        let walls = lone_walls(transfer, calibration).into_iter().map(|(at, wall)| (at, row(&wall)));
        Self { rows, walls: walls.collect(), origin: table.origin(), per_unit: table.per_unit(), emits }
    }

    /// A table of what a transfer function is at one value, for lengths in units of `step` world units: all numbers have that row.
    pub fn of_value(transfer: &TransferFunction, value: f64, step: f64) -> Self {
        let row = row_of(transfer, &transfer.at(value), step);
        Self { rows: vec![[row; 2]], walls: Vec::new(), origin: 0.0, per_unit: 0.0, emits: transfer.has_emission() }
    }

    /// The rows of several tables in one, in which numbers are looked up by their places; and for each table, the places of its numbers.
    ///
    /// # Panics
    /// Panics if some of them hold emission, and some colours.
    pub fn joined(tables: &[Self]) -> (Self, Vec<TablePlaces>) {
        let emits = tables.first().is_some_and(|table| table.emits);
        let mut joined = Self { rows: Vec::new(), walls: Vec::new(), origin: 0.0, per_unit: 1.0, emits };
        let mut places = Vec::new();
        for table in tables {
            assert_eq!(table.emits, emits, "tables of emission, or of colours");
            let (first, last) = (joined.rows.len() as f32, (table.rows.len() - 1) as f32);
            let of_table = TablePlaces { origin: table.origin, per_unit: table.per_unit, first, last };
            joined.walls.extend(table.walls.iter().map(|&(at, row)| (of_table.of(at), row)));
            joined.rows.extend_from_slice(&table.rows);
            places.push(of_table);
        }
        (joined, places)
    }

    /// The rows, for look-ups.
    pub fn rows(&self) -> Rows<'_> {
        let last = (self.rows.len() - 1) as f32;
        Rows { rows: &self.rows, walls: &self.walls, origin: self.origin, per_unit: self.per_unit, last }
    }
}

/// Colour or emission, and extinction, of steps of `step` world units.
fn row_of(transfer: &TransferFunction, at: &Optical, step: f64) -> [f32; 4] {
    let [r, g, b] = if transfer.has_emission() { at.emission.map(|q| q * step) } else { at.color };
    [r, g, b, (transfer.extinction(at.opacity) * step).min(OPAQUE)].map(|x| x as f32)
}

/// Places of the numbers of one table among the rows of [several](OpticsTable::joined).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TablePlaces {
    /// The number whose place is the first.
    pub origin: f32,
    /// Places per unit of the numbers.
    pub per_unit: f32,
    /// The first place.
    pub first: f32,
    /// Distance of the last place from the first.
    pub last: f32,
}

impl TablePlaces {
    /// Place of a number that is not NaN; of one beyond an end, that end.
    pub fn of(&self, number: f32) -> f32 {
        ((number - self.origin) * self.per_unit).max(0.0).min(self.last) + self.first
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
        let low = rows_at(simd, index, |n| &self.rows[n][0]);
        let high = rows_at(simd, index, |n| &self.rows[n][1]);
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
    use super::super::LANES;
    use super::*;
    use fearless_simd::{Level, dispatch};
    use vr_core::transfer::{ControlPoint, OpacityRule};

    #[test]
    fn joined_tables_have_the_rows_of_each() {
        let point = |value, opacity| ControlPoint::new(value, [0.25, 0.5, 1.0], opacity);
        let of = |points: Vec<ControlPoint>| TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
        let calibration = Calibration { slope: 0.5, intercept: -1.0 };
        let table = |transfer: &TransferFunction| {
            let baked = BakedTransfer::<f32>::new(transfer, calibration, (0.0, 8.0), false, 0.1);
            OpticsTable::new(&baked, transfer, calibration, 0.1)
        };
        let (ramp, wall) =
            (of(vec![point(-1.0, 0.1), point(3.0, 0.8)]), of(vec![point(0.0, 0.0), point(1.0, 1.0), point(2.0, 0.2)]));
        let tables = [table(&ramp), OpticsTable::of_value(&ramp, 1.5, 0.1), table(&wall)];
        let (joined, places) = OpticsTable::joined(&tables);
        // Beyond the ends, too; 4 is stored for 1, a wall by itself.
        let numbers: [f32; LANES] = std::array::from_fn(|i| [-3.0, 0.0, 1.3, 4.0, 4.01, 7.99, 8.0, 20.0][i % 8]);
        let at = |rows: Rows<'_>, numbers: [f32; LANES]| dispatch!(Level::new(), simd => rows.at(simd, f32x16::load_array_ref(simd, &numbers)).map(|c| c.to_array()));
        for (table, places) in tables.iter().zip(&places) {
            let (want, found) = (at(table.rows(), numbers), at(joined.rows(), numbers.map(|x| places.of(x))));
            for (want, found) in want.as_flattened().iter().zip(found.as_flattened()) {
                // A place is known to 2⁻¹¹ of an interval here, and extinction of the wall rises by far within one.
                assert!((want - found).abs() <= 1e-3 * want.abs().max(1.0), "{found} for {want}");
            }
        }
        let constant = at(tables[1].rows(), numbers)[3];
        assert!(constant.iter().all(|kappa| (f64::from(*kappa) - 0.1 * ramp.extinction_at(1.5)).abs() < 1e-6));
    }

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
