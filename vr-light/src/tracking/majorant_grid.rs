//! Bounds of a medium's extinction in the cells of a grid.

use glam::DVec3;

use crate::medium::Medium;

/// Bounds of the extinction in one cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MajorantCell {
    /// Lower bound of the extinction.
    pub min: f64,
    /// Upper bound of the extinction.
    pub max: f64,
    /// Rate of tentative collisions per world unit: `max`, or more where a medium that emits is so thin that few would see its light.
    pub rate: f64,
}

/// Bounds of a medium's extinction, cell by cell in its box.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::scattering::PhaseFunction;
/// use vr_light::{Coefficients, Homogeneous, MajorantGrid};
///
/// let fog = Coefficients { scattering: 3.0, ..Coefficients::default() };
/// let cube = Homogeneous::new((DVec3::ZERO, DVec3::ONE), vec![fog], PhaseFunction::Isotropic)?;
/// let grid = MajorantGrid::new(&cube);
/// assert_eq!((grid.dims(), grid.cell([0; 3]).max), ([1; 3], 3.0));
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct MajorantGrid {
    bounds: (DVec3, DVec3),
    dims: [usize; 3],
    /// Sides of a cell, and cells per world unit.
    edges: DVec3,
    per_unit: DVec3,
    cells: Vec<MajorantCell>,
}

/// Largest number of cells: their bounds are kept in memory.
const MAX_CELLS: usize = 1 << 22;
/// Tentative collisions that a medium that emits has at least along the shortest side of its box: each adds the light of its place.
const MIN_EMISSION_DEPTH: f64 = 4.0;

impl MajorantGrid {
    /// Bounds of a medium in as many cells as it finds worth telling apart.
    pub fn new(medium: &dyn Medium) -> Self {
        let bounds = medium.bounds();
        let (low, high) = bounds;
        let size = high - low;
        let mut dims = medium.resolution().map(|n| n.max(1));
        // A side without end has one cell; too many cells are made larger.
        (0..3).filter(|&a| !size[a].is_finite()).for_each(|a| dims[a] = 1);
        while dims.iter().map(|&n| n as f64).product::<f64>() > MAX_CELLS as f64 {
            dims = dims.map(|n| n.div_ceil(2));
        }
        let min_rate = if medium.has_emission() { emission_rate(size) } else { 0.0 };
        let faces = |index: [usize; 3]| {
            // The first and the last face are those of the box: ∞ is not a multiple of anything.
            let face = |a: usize, i: usize| match i {
                0 => low[a],
                i if i == dims[a] => high[a],
                i => low[a] + size[a] * (i as f64 / dims[a] as f64),
            };
            DVec3::new(face(0, index[0]), face(1, index[1]), face(2, index[2]))
        };
        let cells = vr_core::parallel::collect(dims.iter().product(), |i| {
            let cell = [i % dims[0], i / dims[0] % dims[1], i / dims[0] / dims[1]];
            let [min, max] = medium.extinction_range(faces(cell), faces(cell.map(|i| i + 1)));
            MajorantCell { min: min.min(max), max, rate: max.max(min_rate) }
        });
        let edges = size / DVec3::from_array(dims.map(|n| n as f64));
        Self { bounds, dims, edges, per_unit: edges.recip(), cells }
    }

    /// Lower and upper corner of the box.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.bounds
    }

    /// Cells along x, y and z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// World lengths of the sides of a cell.
    #[inline]
    pub(super) fn edges(&self) -> DVec3 {
        self.edges
    }

    /// Cells per world unit along x, y and z.
    #[inline]
    pub(super) fn cells_per_unit(&self) -> DVec3 {
        self.per_unit
    }

    /// Bounds in one cell.
    #[inline]
    pub fn cell(&self, [x, y, z]: [usize; 3]) -> MajorantCell {
        self.cells[(z * self.dims[1] + y) * self.dims[0] + x]
    }
}

/// Least rate of tentative collisions in a medium that emits: a few along the shortest side of its box.
fn emission_rate(size: DVec3) -> f64 {
    let shortest = size.min_element();
    if shortest.is_finite() && shortest > 0.0 { MIN_EMISSION_DEPTH / shortest } else { 0.0 }
}
