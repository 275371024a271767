//! Integrals of fields over their volumes.

use crate::cells::{CellMesh, CellValues};
use crate::filter::{Filter, Lattice};
use crate::grid::Calibration;
use crate::grid_volume::{GridVolume, LatticeVisitor};
use crate::missing::VacuumCells;
use crate::parallel;
use crate::point_mixing::PointMixing;
use crate::point_set::PointSet;
use crate::rectilinear::RectilinearGrid;
use crate::volume::Volume;
use crate::voxel::Voxel;

/// Integral of a field, ∫ f dV, and the volume that it covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Integral {
    /// ∫ f dV, in values times cubic world units.
    pub value: f64,
    /// Cubic world units that are not vacuum; NaN where that is not known, of points.
    pub volume: f64,
    /// True if it is exact but for rounding; false for an estimate.
    pub is_exact: bool,
}

impl Integral {
    /// The exact integral of a volume, trilinear in the cells of grids; `None` for kinds, and filters of grids, of which none is known.
    ///
    /// # Examples
    /// ```
    /// use vr_core::resample::Integral;
    /// use vr_core::{Calibration, Placement, UniformGrid, Volume};
    ///
    /// let placement = Placement::from_spacing([2.0; 3])?;
    /// let grid = UniformGrid::new([2; 3], (0..8u8).collect::<Vec<_>>(), placement, Calibration::default())?;
    /// let integral = Integral::of(&Volume::from(grid)).expect("grids have one");
    /// assert_eq!((integral.value, integral.volume), (28.0, 8.0));
    /// # Ok::<(), vr_core::GridError>(())
    /// ```
    pub fn of(volume: &Volume) -> Option<Self> {
        match volume {
            Volume::Grid(grid) if grid.filter() == Filter::Trilinear => Some(of_grid(grid)),
            Volume::Cells(mesh) => Some(of_cells(mesh)),
            Volume::Rectilinear(grid) => Some(of_rectilinear(grid)),
            Volume::Points(points) if points.mixing() == PointMixing::Sum => Some(of_points(points)),
            _ => None,
        }
    }
}

/// Sums of numbers of which there are many: in blocks, so that rounding does not add up.
fn summed(count: usize, term: impl Fn(usize) -> [f64; 2] + Sync) -> [f64; 2] {
    const BLOCK: usize = 1 << 12;
    let blocks = parallel::collect(count.div_ceil(BLOCK), |block| {
        let terms = (block * BLOCK..((block + 1) * BLOCK).min(count)).map(&term);
        terms.fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d])
    });
    blocks.into_iter().fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d])
}

fn of_cells(mesh: &CellMesh) -> Integral {
    let [value, volume] = summed(mesh.cells().len(), |cell| {
        let [a, b, c, d] = mesh.corners(cell);
        let volume = (b - a).cross(c - a).dot(d - a) / 6.0;
        let mean = match mesh.values() {
            CellValues::Cells(values) => values[cell],
            CellValues::Vertices(_) => 0.25 * mesh.corner_values(cell).iter().sum::<f64>(),
        };
        [mean * volume, volume]
    });
    Integral { value, volume, is_exact: true }
}

/// A kernel's integral is 1, whatever its radius.
fn of_points(points: &PointSet) -> Integral {
    let [value, _] = summed(points.count(), |k| [f64::from(points.weights()[k]) * f64::from(points.values()[k]), 0.0]);
    Integral { value, volume: f64::NAN, is_exact: true }
}

fn of_grid(grid: &GridVolume) -> Integral {
    let widths = grid.dims().map(|n| vec![1.0; n - 1]);
    let cells = TrilinearCells {
        widths: widths.each_ref().map(Vec::as_slice),
        vacuum: grid.vacuum_cells(),
        calibration: grid.calibration(),
    };
    let [value, volume] = grid.with_lattice(cells);
    let voxel = grid.placement().axes().determinant().abs();
    Integral { value: value * voxel, volume: volume * voxel, is_exact: true }
}

fn of_rectilinear(grid: &RectilinearGrid) -> Integral {
    let widths = grid.axes().each_ref().map(|axis| axis.places().windows(2).map(|w| w[1] - w[0]).collect::<Vec<_>>());
    let cells = TrilinearCells {
        widths: widths.each_ref().map(Vec::as_slice),
        vacuum: grid.lattice().vacuum_cells(),
        calibration: grid.lattice().calibration(),
    };
    let [value, volume] = grid.lattice().with_lattice(cells);
    Integral { value, volume, is_exact: true }
}

/// Integral and volume over the cells of a lattice that are not vacuum: a cell's mean is that of its eight corners.
struct TrilinearCells<'a> {
    /// Widths of the cells along each axis.
    widths: [&'a [f64]; 3],
    vacuum: Option<&'a VacuumCells>,
    calibration: Calibration,
}

impl LatticeVisitor for TrilinearCells<'_> {
    type Output = [f64; 2];

    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> [f64; 2] {
        let [nx, ny, nz] = self.widths.map(<[f64]>::len);
        // Row by row of cells.
        summed(ny * nz, |row| {
            let (y, z) = (row % ny, row / ny);
            let across = self.widths[1][y] * self.widths[2][z];
            let edge = |x: usize| {
                let at = |dy: usize, dz: usize| lattice.at::<f64>(x, y + dy, z + dz);
                at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)
            };
            let (mut sums, mut before) = ([0.0; 2], edge(0));
            for x in 0..nx {
                let after = edge(x + 1);
                if !self.vacuum.is_some_and(|vacuum| vacuum.is_vacuum([x, y, z])) {
                    let volume = self.widths[0][x] * across;
                    sums[0] += self.calibration.value(0.125 * (before + after)) * volume;
                    sums[1] += volume;
                }
                before = after;
            }
            sums
        })
    }
}
