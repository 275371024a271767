//! Maps from places along an uneven axis to cells, for lanes.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};
use vr_core::rectilinear::{Axis, RectilinearGrid, Segment};
use vr_core::{GradientMethod, cancel};
use vr_kernels::vector::rows_at;

/// Reaches of an axis, of one segment or of several, each with a map that is linear in its cells. Places in a reach are counted in bins of one length, no
/// longer than a cell: a bin holds one boundary of cells at most.
#[derive(Clone, Debug)]
pub(crate) struct AxisTable {
    reaches: Vec<Reach>,
    /// Number of the reach of each segment.
    of_segments: Vec<u32>,
    /// For each bin, boundary k and number a of the cell behind it, slope b before it and its change c: place x is in the cell of number
    /// a + b·(x − k) + c·max(x − k, 0), and so far in it.
    bins: Vec<[f32; 4]>,
    /// For each cell, factors of the rises below and above its first sample in the gradient there, and of those below and above its second.
    slopes: Vec<[f32; 4]>,
}

/// Place of a reach on its axis and in the table.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    pub(super) origin: f64,
    /// Bins per world unit.
    pub(super) rate: f64,
    /// Number of the first cell.
    pub(super) first: i32,
    /// Number of the first bin in the table.
    pub(super) start: i32,
    pub(super) bins: i32,
    /// True if bins are cells: places need no map.
    pub(super) is_even: bool,
}

/// Largest number of bins of a reach of several segments.
const MAX_BINS: f64 = 128.0;

/// Largest distance of a boundary from an even one, in cells, at which bins serve as cells: the rounding of a place among 256 cells in f32.
const EVEN: f64 = 1.0 / 65_536.0;

impl AxisTable {
    /// Makes the tables of the axes of a grid; gradients are those per `unit` of length.
    pub(super) fn all_of(grid: &RectilinearGrid, unit: f64) -> [Self; 3] {
        std::array::from_fn(|a| Self::new(&grid.axes()[a], grid.bricks().segments(a), grid.gradient_method(), unit))
    }

    fn new(axis: &Axis, segments: &[Segment], method: GradientMethod, unit: f64) -> Self {
        let (mut reaches, mut of_segments, mut bins) = (Vec::new(), Vec::with_capacity(segments.len()), Vec::new());
        let mut left = segments;
        while !left.is_empty() {
            let count = joined(axis.places(), left);
            let (first, end) = (left[0].first, left[count - 1].end);
            of_segments.extend(std::iter::repeat_n(reaches.len() as u32, count));
            reaches.push(add_reach(&axis.places()[first..=end], first, &mut bins));
            left = &left[count..];
        }
        let cells = axis.places().len() - 1;
        cancel::claim("the ray caster's slopes along an axis", (cells * size_of::<[f32; 4]>()) as u64);
        let of_cell = |cell: usize| {
            let factors = match method {
                GradientMethod::CentralDifferences => {
                    let [low, high] = [cell, cell + 1].map(|place| axis.slope_factors(place));
                    [low[0], low[1], high[0], high[1]]
                }
                GradientMethod::Analytic => [0.0, 1.0 / axis.width(cell), 1.0 / axis.width(cell), 0.0],
            };
            factors.map(|factor| (factor * unit) as f32)
        };
        Self { reaches, of_segments, bins, slopes: (0..cells).map(of_cell).collect() }
    }

    /// Returns the number of the reach of a segment.
    #[inline]
    pub(super) fn reach_of(&self, segment: usize) -> usize {
        self.of_segments[segment] as usize
    }

    #[inline]
    pub(super) fn reach(&self, number: usize) -> &Reach {
        &self.reaches[number]
    }

    /// Returns the cell and the place in it, as one number, of places in bins; `row` is the number of the bin in the table.
    #[inline(always)]
    pub(super) fn to_cells<S: Simd>(&self, simd: S, x: f32x16<S>, row: i32x16<S>) -> f32x16<S> {
        let [cell, slope, boundary, bend] = rows_at(simd, row.to_array(), |n| &self.bins[n]);
        let beyond = x - boundary;
        cell + slope * beyond + bend * beyond.max(f32x16::splat(simd, 0.0))
    }

    /// Returns the factors of the rises around cells.
    #[inline(always)]
    pub(super) fn slopes_at<S: Simd>(&self, simd: S, cell: i32x16<S>) -> [f32x16<S>; 4] {
        rows_at(simd, cell.to_array(), |n| &self.slopes[n])
    }
}

/// Number of segments, from the first of some on, that are one reach: those of few bins, none of which is even.
fn joined(places: &[f64], segments: &[Segment]) -> usize {
    let (mut narrowest, mut count) = (f64::INFINITY, 0);
    for segment in segments {
        let own = &places[segment.first..=segment.end];
        narrowest = own.windows(2).map(|pair| pair[1] - pair[0]).fold(narrowest, f64::min);
        let bins = (places[segment.end] - places[segments[0].first]) / narrowest;
        if count > 0 && (bins > MAX_BINS || own.len() > LONE + 1 && is_even(own)) {
            break;
        }
        count += 1;
        if own.len() > LONE + 1 && is_even(own) {
            break;
        }
    }
    count
}

/// Largest number of cells of one width that are joined with others.
const LONE: usize = 7;

/// True if the boundaries of some cells are as good as even.
fn is_even(places: &[f64]) -> bool {
    let mean = (places[places.len() - 1] - places[0]) / (places.len() - 1) as f64;
    places.iter().enumerate().all(|(k, place)| ((place - places[0]) / mean - k as f64).abs() <= EVEN)
}

/// Appends the bins of a reach between places, the first cell of which has this number.
fn add_reach(places: &[f64], first: usize, table: &mut Vec<[f32; 4]>) -> Reach {
    let cells = places.len() - 1;
    let (origin, length) = (places[0], places[cells] - places[0]);
    let is_even = is_even(places);
    let narrowest = places.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    // A little narrower than any cell, so that rounding leaves no bin with two boundaries.
    let bins = if is_even { cells } else { (length / narrowest * (1.0 + 1e-6)).ceil() as usize };
    // A list that grows has room for twice as many for a moment.
    cancel::claim("the ray caster's table of an axis", (2 * (table.len() + bins) * size_of::<[f32; 4]>()) as u64);
    let rate = bins as f64 / length;
    let place = Reach { origin, rate, first: first as i32, start: table.len() as i32, bins: bins as i32, is_even };
    // Boundary of a cell in bins, and cells per bin in it.
    let boundary = |cell: usize| if is_even { cell as f64 } else { (places[cell] - origin) * rate };
    let slope = |cell: usize| if is_even { 1.0 } else { 1.0 / ((places[cell + 1] - places[cell]) * rate) };
    let mut cell = 0;
    for bin in 0..bins {
        let (low, own) = (bin as f64, slope(cell));
        let row = if cell + 1 < cells && boundary(cell + 1) < low + 1.0 {
            cell += 1;
            [cell as f64, own, boundary(cell), slope(cell) - own]
        } else {
            [cell as f64 + (low - boundary(cell)) * own, own, low, 0.0]
        };
        table.push(row.map(|x| x as f32));
    }
    place
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};

    use super::*;

    /// Every place finds its index coordinate, to the rounding of f32: in even segments and in graded ones, close to boundaries and far.
    #[test]
    fn bins_lead_to_the_index_coordinates_of_places() {
        let mut places: Vec<f64> = (0..12).map(|k| -3.0 + 0.5 * f64::from(k)).collect();
        for k in 0..30 {
            places.push(places[places.len() - 1] + 0.5 * 1.17f64.powi(k % 17) * if k % 5 == 0 { 1.3 } else { 1.0 });
        }
        let axes = [places.clone(), vec![0.0, 1.0], vec![0.0, 1.0]];
        let values = vec![0.0; 4 * places.len()];
        let grid = RectilinearGrid::new(axes, values, vr_core::rectilinear::Centering::Points).unwrap();
        let [table, ..] = AxisTable::all_of(&grid, 1.0);
        let segments = grid.bricks().segments(0);
        let (even, uneven) = (table.reach_of(0), table.reach_of(1));
        assert!(segments.len() > 4 && table.reaches.len() < segments.len());
        assert!(table.reach(even).is_even && !table.reach(uneven).is_even);
        for (number, segment) in segments.iter().enumerate() {
            let at = table.reach(table.reach_of(number));
            let [low, high] = [segment.first, segment.end].map(|k| places[k]);
            for k in 0..=1000 {
                let place = low + (high - low) * f64::from(k) / 1000.0;
                let x = ((place - at.origin) * at.rate) as f32;
                let row = at.start + (x as i32).min(at.bins - 1);
                let found = dispatch!(Level::new(), simd => {
                    table.to_cells(simd, f32x16::splat(simd, x), i32x16::splat(simd, row)).to_array()[7]
                });
                let want = grid.axes()[0].to_index(place) - f64::from(at.first);
                // Half a unit in the last place of 128, in each of two roundings.
                assert!((f64::from(found) - want).abs() < 1.6e-5, "{place}: {found} for {want}");
                assert!(!at.is_even || found == x);
            }
        }
    }
}
