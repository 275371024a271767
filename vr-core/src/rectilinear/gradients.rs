//! Gradients at the places of a rectilinear grid.

use super::axis::Axis;
use crate::filter::Lattice;
use crate::grid_volume::LatticeVisitor;
use crate::voxel::Voxel;

/// Gradients at the eight corners of a cell, per world unit, of the stored numbers: those of parabolas through three places along each axis.
/// They are the central differences of a uniform grid where steps are equal.
pub(super) struct CornerGradients<'a> {
    pub axes: &'a [Axis; 3],
    pub cell: [usize; 3],
}

impl LatticeVisitor for CornerGradients<'_> {
    type Output = [[f64; 3]; 8];

    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> [[f64; 3]; 8] {
        let at = |p: [usize; 3]| lattice.at::<f64>(p[0], p[1], p[2]);
        std::array::from_fn(|corner| {
            let here: [usize; 3] = std::array::from_fn(|a| self.cell[a] + (corner >> a & 1));
            let own = at(here);
            std::array::from_fn(|a| {
                let (mut low, mut high) = (here, here);
                low[a] = here[a].saturating_sub(1);
                high[a] = (here[a] + 1).min(lattice.dims[a] - 1);
                let [below, above] = self.axes[a].slope_factors(here[a]);
                below * (own - at(low)) + above * (at(high) - own)
            })
        })
    }
}
