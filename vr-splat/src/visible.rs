//! Voxels of a grid that have to be splatted: air is never touched.

use vr_core::filter::Lattice;
use vr_core::parallel::collect;
use vr_core::{AnyGrid, Calibration, GridVolume, TransferFunction};
use vr_kernels::ranges::{VisibleLevels, VisibleValues};

use crate::bit_rows::{BitRows, Run};
use crate::cell_range::CellRange;
use crate::ghosts::Vacuum;

/// The voxels that matter, row by row, and the cells in which something can be seen.
pub(crate) struct VisibleVoxels {
    /// Runs of each layer z.
    pub(crate) layers: Vec<Vec<Run>>,
    /// `None`: every cell may show something.
    pub(crate) cells: Option<CellBits>,
    /// Number of voxels before the grid's first, and behind its last, that there are.
    pub(crate) beyond: usize,
}

impl VisibleVoxels {
    /// Number of voxels.
    pub(crate) fn count(&self) -> u64 {
        self.layers.iter().flatten().map(|run| u64::from(run.length)).sum()
    }

    /// All voxels, and all cells but those that are vacuum.
    pub(crate) fn all(vacuum: Vacuum<'_>) -> Self {
        let dims = vacuum.dims.map(|n| n + 2 * vacuum.beyond);
        let row = |y: usize| Run { x: 0, y: y as u16, length: dims[0] as u16 };
        let cells = vacuum.cells.is_some().then(|| CellBits::all_but(dims, vacuum));
        Self { layers: vec![(0..dims[1]).map(row).collect(); dims[2]], cells, beyond: vacuum.beyond }
    }

    /// Voxels that count by themselves, and are there: those whose stored numbers show.
    pub(crate) fn single<T: vr_core::Voxel>(
        lattice: &Lattice<'_, T>,
        missing: &(dyn Fn(usize) -> bool + Sync),
        shows: &(dyn Fn(f64) -> bool + Sync),
    ) -> Self {
        let [nx, ny, nz] = lattice.dims;
        let layer = |z: usize| {
            let mut bits = BitRows::new(nx, ny);
            for y in 0..ny {
                for x in 0..nx {
                    let i = (z * ny + y) * nx + x;
                    let value = f64::from(lattice.samples[i].to_f32());
                    if shows(value) && !missing(i) {
                        bits.set(x, y);
                    }
                }
            }
            bits.runs()
        };
        Self { layers: collect(nz, layer), cells: None, beyond: 0 }
    }

    /// Voxels on which the field depends wherever it can be seen. Kernels reach `reach` voxels, what is asked of the field within a cell may depend
    /// on `beyond` of it on either side, and the field may overshoot its samples by `overshoot` of their range; `fine`, if there is one, bounds it more tightly.
    pub(crate) fn reconstructed<T: vr_core::Voxel>(
        lattice: &Lattice<'_, T>,
        vacuum: Vacuum<'_>,
        levels: &VisibleLevels,
        reach: [f64; 3],
        beyond: f64,
        (overshoot, fine): (f32, Option<&CellRange>),
    ) -> Self {
        let dims @ [nx, ny, nz] = lattice.dims;
        // A place in a cell lies up to a voxel from its farther corners; what reaches farther brings in other voxels.
        let other = reach.map(|r| (r - 1.0 + beyond).ceil().max(0.0) as usize);
        let cells = CellBits::new(lattice, vacuum, levels, other, (overshoot, fine));
        let near = reach.map(|r| (r + beyond).ceil().max(1.0) as usize);
        let spread: Vec<BitRows> = collect(dims[2] - 1, |z| cells.layers[z].to_voxels(near, [nx, ny]));
        let layer = |z: usize| {
            let mut bits = BitRows::new(nx, ny);
            for cell in z.saturating_sub(near[2])..(z + near[2]).min(dims[2] - 1) {
                bits.add(&spread[cell]);
            }
            bits.runs()
        };
        Self { layers: collect(nz, layer), cells: Some(cells), beyond: vacuum.beyond }
    }
}

/// Stored numbers in `range`, and beyond, that a transfer function shows.
pub(crate) fn visible_levels(
    transfer: &TransferFunction,
    calibration: Calibration,
    range: (f64, f64),
) -> VisibleLevels {
    let values = VisibleValues::new(transfer);
    VisibleLevels::new(range, false, |from, to| values.shows(calibration.value(from), calibration.value(to)))
}

/// Test that is true if a voxel is missing, by its index among the voxels.
pub(crate) fn missing(volume: &GridVolume) -> impl Fn(usize) -> bool + Sync + '_ {
    let floats = match volume.values() {
        AnyGrid::F32(grid) if volume.vacuum_cells().is_some() => Some(grid.samples()),
        _ => None,
    };
    move |i| floats.is_some_and(|samples| samples[i].is_nan())
}

/// One bit a cell: whether anything can be seen in it.
pub(crate) struct CellBits {
    layers: Vec<BitRows>,
}

impl CellBits {
    fn all_but([nx, ny, nz]: [usize; 3], vacuum: Vacuum<'_>) -> Self {
        let layer = |z: usize| {
            let mut bits = BitRows::new(nx - 1, ny - 1);
            for y in 0..ny - 1 {
                (0..nx - 1).filter(|&x| !vacuum.is_at([x, y, z])).for_each(|x| bits.set(x, y));
            }
            bits
        };
        Self { layers: collect(nz - 1, layer) }
    }

    fn new<T: vr_core::Voxel>(
        lattice: &Lattice<'_, T>,
        vacuum: Vacuum<'_>,
        levels: &VisibleLevels,
        other: [usize; 3],
        (overshoot, fine): (f32, Option<&CellRange>),
    ) -> Self {
        let [nx, ny, nz] = lattice.dims;
        // True if the field may be visible in a cell of which the range of the voxels is.
        let shows_finely = |cell: [usize; 3], [min, max]: [f32; 2], around: &mut Vec<f32>| {
            let Some((fine, [first, sides])) = fine.and_then(|fine| Some((fine, fine.voxels(cell, lattice.dims)?)))
            else {
                return true;
            };
            if levels.all(f64::from(min), f64::from(max)) {
                return true;
            }
            around.clear();
            for k in first[2]..first[2] + sides[2] {
                for j in first[1]..first[1] + sides[1] {
                    let row = &lattice.samples[(k * ny + j) * nx + first[0]..][..sides[0]];
                    around.extend(row.iter().map(|sample| sample.to_f32()));
                }
            }
            // NaN is no bound.
            let shows = |[from, to]: [f32; 2]| from.is_nan() || levels.any(f64::from(from), f64::from(to));
            fine.bounds(around, max - min).any(shows)
        };
        let layer = |z: usize| {
            let mut within_reach = Vec::new();
            let mut bits = BitRows::new(nx - 1, ny - 1);
            // Of each column of samples around the layer, then of neighbours along y, then along x.
            let (mut low, mut high) = (vec![f32::INFINITY; nx * ny], vec![f32::NEG_INFINITY; nx * ny]);
            for k in z.saturating_sub(other[2])..(z + 2 + other[2]).min(nz) {
                let slice = &lattice.samples[k * nx * ny..][..nx * ny];
                for ((low, high), sample) in low.iter_mut().zip(&mut high).zip(slice) {
                    let value = sample.to_f32();
                    (*low, *high) = (low.min(value), high.max(value));
                }
            }
            let (mut row_low, mut row_high) = (vec![0.0; nx], vec![0.0; nx]);
            for y in 0..ny - 1 {
                row_low.fill(f32::INFINITY);
                row_high.fill(f32::NEG_INFINITY);
                for j in y.saturating_sub(other[1])..(y + 2 + other[1]).min(ny) {
                    for x in 0..nx {
                        row_low[x] = row_low[x].min(low[j * nx + x]);
                        row_high[x] = row_high[x].max(high[j * nx + x]);
                    }
                }
                // Where all of a row is out of sight, no cell of it is looked at.
                let min = row_low.iter().copied().fold(f32::INFINITY, f32::min);
                let max = row_high.iter().copied().fold(f32::NEG_INFINITY, f32::max);
                let more = overshoot * (max - min);
                if !levels.any(f64::from(min - more), f64::from(max + more)) {
                    continue;
                }
                for x in 0..nx - 1 {
                    let around = x.saturating_sub(other[0])..(x + 2 + other[0]).min(nx);
                    let min = row_low[around.clone()].iter().copied().fold(f32::INFINITY, f32::min);
                    let max = row_high[around].iter().copied().fold(f32::NEG_INFINITY, f32::max);
                    let more = overshoot * (max - min);
                    let shows = levels.any(f64::from(min - more), f64::from(max + more)) && !vacuum.is_at([x, y, z]);
                    if shows && shows_finely([x, y, z], [min, max], &mut within_reach) {
                        bits.set(x, y);
                    }
                }
            }
            bits
        };
        Self { layers: collect(nz - 1, layer) }
    }

    /// True if anything can be seen in a cell that there is.
    #[inline(always)]
    pub(crate) fn is_visible(&self, x: usize, y: usize, z: usize) -> bool {
        self.layers[z].is_set(x, y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{ControlPoint, OpacityRule};

    fn transfer(from: f64) -> TransferFunction {
        let points = [(from, 0.0), (from + 0.5, 0.5)].map(|(v, a)| ControlPoint::new(v, [1.0; 3], a)).to_vec();
        TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap()
    }

    fn voxels(visible: &VisibleVoxels) -> Vec<[usize; 3]> {
        let mut all = Vec::new();
        for (z, layer) in visible.layers.iter().enumerate() {
            for run in layer {
                all.extend((0..run.length).map(|i| [usize::from(run.x + i), usize::from(run.y), z]));
            }
        }
        all
    }

    #[test]
    fn one_bright_voxel_brings_in_what_its_cells_depend_on() {
        let dims = [70, 5, 6];
        let mut samples = vec![0u8; 70 * 5 * 6];
        samples[(3 * 5 + 2) * 70 + 64] = 9;
        let lattice = Lattice { samples: &samples, dims };
        let levels = visible_levels(&transfer(4.0), Calibration::default(), (0.0, 9.0));
        let own = VisibleVoxels::single(&lattice, &|_| false, &|value| levels.any(value, value));
        assert_eq!(voxels(&own), [[64, 2, 3]]);
        let whole = Vacuum { cells: None, dims, beyond: 0 };
        let linear = VisibleVoxels::reconstructed(&lattice, whole, &levels, [1.0; 3], 0.0, (0.0, None));
        // Eight cells around it, and their corners.
        let want: Vec<[usize; 3]> =
            (2..5).flat_map(|z| (1..4).flat_map(move |y| (63..66).map(move |x| [x, y, z]))).collect();
        assert_eq!(voxels(&linear), want);
        assert_eq!((linear.count(), own.count()), (27, 1));
        let cells = linear.cells.as_ref().unwrap();
        assert!(cells.is_visible(63, 1, 2) && cells.is_visible(64, 2, 3) && !cells.is_visible(65, 2, 3));
        // Kernels that reach two voxels see it from one cell farther, and these depend on two voxels each way.
        let wide = VisibleVoxels::reconstructed(&lattice, whole, &levels, [2.0; 3], 0.0, (0.0, None));
        assert!(wide.cells.as_ref().unwrap().is_visible(62, 0, 1));
        assert!(voxels(&wide).contains(&[61, 0, 0]) && !voxels(&wide).contains(&[60, 0, 0]));
    }

    #[test]
    fn cells_around_a_missing_voxel_show_nothing() {
        let mut samples = vec![1.0f32; 4 * 3 * 3];
        samples[(3 + 1) * 4 + 2] = f32::NAN;
        let placement = vr_core::Placement::from_spacing([1.0; 3]).unwrap();
        let grid = vr_core::UniformGrid::new([4, 3, 3], samples, placement, Calibration::default()).unwrap();
        let holes = vr_core::VacuumCells::new(&grid);
        let vacuum = Vacuum { cells: Some(&holes), dims: [4, 3, 3], beyond: 0 };
        let all = VisibleVoxels::all(vacuum);
        assert_eq!(all.count(), 36);
        let cells = all.cells.unwrap();
        for (x, seen) in [(0, true), (1, false), (2, false)] {
            assert!((0..2).all(|y| (0..2).all(|z| cells.is_visible(x, y, z) == seen)), "{x}");
        }
        assert!(VisibleVoxels::all(Vacuum { cells: None, ..vacuum }).cells.is_none());
        // With a voxel more at each end, cells have other numbers.
        let cells = VisibleVoxels::all(Vacuum { beyond: 1, ..vacuum }).cells.unwrap();
        assert!(
            cells.is_visible(1, 1, 1)
                && !cells.is_visible(2, 1, 1)
                && cells.is_visible(2, 0, 1)
                && cells.is_visible(4, 1, 1)
        );
    }
}
