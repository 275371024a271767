//! Bounds of a field Σ w f / Σ w within a cell, tighter than the range of all voxels whose kernels reach the cell.
//!
//! In each eighth of a cell, the normalized weights pₖ = wₖ / Σ w are expanded about its middle: value, slopes and remainder. The weights sum to 1 everywhere, so
//! the remainders rₖ sum to 0, and Σ rₖ fₖ is at most ½ Σ |rₖ| times the range of the voxels.

use crate::kernel::SplatKernel;

/// Largest number of voxels in reach of a cell for which bounds are computed: more take longer to sum than the bounds save.
const MAX_VOXELS: usize = 216;
/// Number of positions along each edge of an eighth, from corner to corner, at which remainders are evaluated.
const PLACES: i32 = 7;
/// Factor for remainders between these positions. Not proven, but tested: remainders are nearly quadratic, and largest at corners.
const MARGIN: f64 = 1.1;
/// Error of sums by rounding, relative to the range of the voxels.
const ROUNDING: f32 = 1e-5;

/// Weights of the voxels whose kernels reach a cell: the same for every cell of a lattice.
pub(crate) struct CellRange {
    /// Number of voxels in reach along each axis.
    sides: [usize; 3],
    /// Number of voxels in reach before the cell's first corner, along each axis.
    before: [usize; 3],
    /// For each eighth, one entry per voxel, x fastest: the voxel's weight at the middle of the eighth, and the weight's increase from there to the face of
    /// the eighth along x, y and z.
    eighths: [Vec<[f32; 4]>; 8],
    /// Bound of the remainder, ½ Σ |rₖ|.
    remainder: f32,
}

impl CellRange {
    /// `None` for kernels that reach too many voxels, or leave a position of the cell without any.
    pub(crate) fn new(kernel: &SplatKernel) -> Option<Self> {
        let before = kernel.reach().map(|reach| (reach - 1.0).ceil().max(0.0) as usize);
        let sides = before.map(|n| 2 * n + 2);
        if sides.iter().product::<usize>() > MAX_VOXELS {
            return None;
        }
        let weights = |place: [f64; 3]| Weights { kernel, sides, before }.at(place);
        let mut eighths: [Vec<[f32; 4]>; 8] = Default::default();
        let mut remainder = 0.0f64;
        for (i, eighth) in eighths.iter_mut().enumerate() {
            let middle = middle_of(i);
            let beside = |axis: usize, by: f64| {
                let mut place = middle;
                place[axis] += by * QUARTER;
                weights(place)
            };
            let value = weights(middle)?;
            let mut rises: [Vec<f64>; 3] = Default::default();
            for (axis, rise) in rises.iter_mut().enumerate() {
                let (high, low) = (beside(axis, 1.0)?, beside(axis, -1.0)?);
                *rise = high.iter().zip(&low).map(|(high, low)| 0.5 * (high - low)).collect();
            }
            let row = |k: usize| [value[k], rises[0][k], rises[1][k], rises[2][k]].map(|x| x as f32);
            *eighth = (0..value.len()).map(row).collect();
            // Kernels are even, so all eighths have the same remainder.
            if i > 0 {
                continue;
            }
            let at = |k: i32| f64::from(2 * k) / f64::from(PLACES - 1) - 1.0;
            for place in 0..PLACES.pow(3) {
                let t = [place % PLACES, place / PLACES % PLACES, place / (PLACES * PLACES)].map(at);
                let exact = weights(std::array::from_fn(|a| middle[a] + t[a] * QUARTER))?;
                let linear = |k: usize| value[k] + (0..3).map(|a| t[a] * rises[a][k]).sum::<f64>();
                let left: f64 = exact.iter().enumerate().map(|(k, p)| (p - linear(k)).abs()).sum();
                remainder = remainder.max(0.5 * left);
            }
        }
        Some(Self { sides, before, eighths, remainder: (remainder * MARGIN) as f32 })
    }

    /// Index of the first voxel in reach of a cell, and the number of voxels along each axis; `None` if some of them lie outside the lattice.
    pub(crate) fn voxels(&self, cell: [usize; 3], dims: [usize; 3]) -> Option<[[usize; 3]; 2]> {
        let inside = |a: usize| cell[a] >= self.before[a] && cell[a] - self.before[a] + self.sides[a] <= dims[a];
        (0..3).all(inside).then(|| [std::array::from_fn(|a| cell[a] - self.before[a]), self.sides])
    }

    /// Bounds of the field in each eighth of a cell, given the voxels in reach and the size of their range.
    pub(crate) fn bounds<'a>(&'a self, voxels: &'a [f32], range: f32) -> impl Iterator<Item = [f32; 2]> + 'a {
        // Differences from one voxel: they round less than values far from 0.
        let base = voxels.first().copied().unwrap_or(0.0);
        self.eighths.iter().map(move |eighth| {
            let mut sums = [0.0f32; 4];
            for (row, voxel) in eighth.iter().zip(voxels) {
                for (sum, part) in sums.iter_mut().zip(row) {
                    *sum += part * (voxel - base);
                }
            }
            let [value, x, y, z] = sums;
            let beside = x.abs() + y.abs() + z.abs() + (self.remainder + ROUNDING) * range;
            [base + value - beside, base + value + beside]
        })
    }
}

/// From the middle of an eighth of a cell to its faces, in voxels.
const QUARTER: f64 = 0.25;

/// The middle of an eighth of a cell, from the cell's first corner.
fn middle_of(eighth: usize) -> [f64; 3] {
    std::array::from_fn(|a| if eighth >> a & 1 == 0 { QUARTER } else { 3.0 * QUARTER })
}

/// Weights of voxels around a cell.
struct Weights<'a> {
    kernel: &'a SplatKernel,
    sides: [usize; 3],
    before: [usize; 3],
}

impl Weights<'_> {
    /// Normalized weights at a position relative to the cell's first corner; `None` where they sum to 0.
    fn at(&self, place: [f64; 3]) -> Option<Vec<f64>> {
        let [nx, ny, nz] = self.sides;
        let offset = |a: usize, i: usize| place[a] + self.before[a] as f64 - i as f64;
        let mut all = Vec::with_capacity(nx * ny * nz);
        for z in 0..nz {
            for y in 0..ny {
                all.extend((0..nx).map(|x| self.kernel.at([offset(0, x), offset(1, y), offset(2, z)])));
            }
        }
        let sum: f64 = all.iter().sum();
        (sum > 0.0).then(|| all.into_iter().map(|weight| weight / sum).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::Shape;
    use proptest::prelude::*;

    fn kernels() -> Vec<SplatKernel> {
        vec![
            SplatKernel::new(Shape::Gaussian),
            SplatKernel::new(Shape::Cone),
            SplatKernel { radius: 1.3, sigma: 0.5, width: [1.0, 1.4, 0.9], ..SplatKernel::new(Shape::Gaussian) },
        ]
    }

    #[test]
    fn kernels_that_leave_gaps_or_reach_far_have_none() {
        assert!(CellRange::new(&SplatKernel { radius: 0.5, ..SplatKernel::new(Shape::Gaussian) }).is_none());
        assert!(CellRange::new(&SplatKernel { radius: 4.0, ..SplatKernel::new(Shape::Gaussian) }).is_none());
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(23), ..ProptestConfig::default() })]
        #[test]
        fn no_field_lies_beyond_its_bounds(
            voxels in prop::collection::vec(prop_oneof![Just(0.0f32), Just(1.0), 0.0f32..1.0], MAX_VOXELS),
            places in prop::collection::vec([0.0..=1.0f64, 0.0..=1.0, 0.0..=1.0], 64),
            // Steps between two levels are the hardest: all that is near pulls one way.
            plane in [-1.0..1.0f64, -1.0..1.0, -1.0..1.0],
            is_step in any::<bool>(),
        ) {
            for kernel in kernels() {
                let range = CellRange::new(&kernel).unwrap();
                let [nx, ny, nz] = range.sides;
                let of_plane = |i: usize| {
                    let place = [i % nx, i / nx % ny, i / nx / ny];
                    let side: f64 = (0..3).map(|a| plane[a] * (place[a] as f64 - range.before[a] as f64 - 0.5)).sum();
                    if side > 0.0 { 1.0 } else { 0.0 }
                };
                let voxels: Vec<f32> =
                    (0..nx * ny * nz).map(|i| if is_step { of_plane(i) } else { voxels[i] }).collect();
                let (low, high) = voxels.iter().fold((1.0f32, 0.0f32), |(l, h), &v| (l.min(v), h.max(v)));
                let bounds: Vec<[f32; 2]> = range.bounds(&voxels, high - low).collect();
                for &place in &places {
                    let weights = Weights { kernel: &kernel, sides: range.sides, before: range.before }.at(place).unwrap();
                    let field: f64 = weights.iter().zip(&voxels).map(|(w, v)| w * f64::from(*v)).sum();
                    let eighth = (0..3).map(|a| usize::from(place[a] >= 0.5) << a).sum::<usize>();
                    let [from, to] = bounds[eighth].map(f64::from);
                    prop_assert!(from <= field && field <= to, "{kernel:?} {place:?}: {field} not in {from}..{to}");
                }
            }
        }
    }
}
