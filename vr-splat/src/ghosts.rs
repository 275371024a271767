//! Voxels beyond the box of a grid, which its filter takes from those inside.

use vr_core::cancel;
use vr_core::filter::{Lattice, Reconstruction};
use vr_core::parallel::collect;
use vr_core::{Sampler, SamplerVisitor, VacuumCells, Voxel};

use crate::input::SplatInput;
use crate::splatter::{Buffers, Splatter};

/// Number of voxels beyond the box on each side of every axis.
pub(crate) const BEYOND: usize = 1;

/// The voxels that the filter of a grid weighs, those beyond the box among them: of the B-spline, its coefficients.
pub(crate) struct Ghosts {
    samples: Vec<f32>,
    dims: [usize; 3],
}

impl Ghosts {
    /// The voxels of a grid whose filter looks beyond its box, and whose values are splatted into sheets that the box bounds; `None` of others.
    pub(crate) fn new(renderer: &Splatter, input: &SplatInput) -> Option<Self> {
        let SplatInput::Grid(grid) = input else { return None };
        let boxed = renderer.buffers == Buffers::Image && !renderer.splats_light();
        (boxed && grid.filter().reach() > 0).then(|| grid.with_sampler(Padded))
    }

    /// The lattice whose first voxel lies [`BEYOND`] voxels before the grid's.
    pub(crate) fn lattice(&self) -> Lattice<'_, f32> {
        Lattice { samples: &self.samples, dims: self.dims }
    }

    /// Smallest and largest of the voxels.
    pub(crate) fn range(&self) -> (f32, f32) {
        self.samples.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), &v| (low.min(v), high.max(v)))
    }
}

struct Padded;

impl SamplerVisitor for Padded {
    type Output = Ghosts;

    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) -> Ghosts {
        let lattice = sampler.lattice();
        let dims = lattice.dims;
        // The voxel inside that stands for one at an index from −1 to n, counted from 0.
        let inside = |axis: usize, i: usize| {
            let n = dims[axis];
            match i.checked_sub(BEYOND) {
                None => F::FILTER.taps(0, n)[0],
                Some(i) if i >= n => F::FILTER.taps(n - 2, n)[3],
                Some(i) => i,
            }
        };
        let padded = dims.map(|n| n + 2 * BEYOND);
        // Layers are joined once they are all there.
        let bytes = 2 * size_of::<f32>() * padded.iter().product::<usize>();
        cancel::claim("the voxels with those beyond the box", bytes as u64);
        let layer = |z: usize| {
            let z = inside(2, z);
            let row = |y: usize| {
                let y = inside(1, y);
                (0..padded[0]).map(move |x| lattice.at::<f32>(inside(0, x), y, z))
            };
            (0..padded[1]).flat_map(row).collect::<Vec<f32>>()
        };
        Ghosts { samples: collect(padded[2], layer).concat(), dims: padded }
    }
}

/// Cells that are missing, numbered from so many before the grid's first.
#[derive(Clone, Copy)]
pub(crate) struct Vacuum<'a> {
    pub(crate) cells: Option<&'a VacuumCells>,
    /// Voxels of the grid along its axes.
    pub(crate) dims: [usize; 3],
    pub(crate) beyond: usize,
}

impl Vacuum<'_> {
    /// True if a cell is missing; of those beyond the grid none is.
    pub(crate) fn is_at(self, cell: [usize; 3]) -> bool {
        let Some(cells) = self.cells else { return false };
        let own = cell.map(|i| i.wrapping_sub(self.beyond));
        (0..3).all(|a| own[a] < self.dims[a] - 1) && cells.is_vacuum(own)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use vr_core::{Calibration, Filter, GridVolume, Placement, UniformGrid};

    #[test]
    fn voxels_beyond_the_box_are_those_of_the_filter() {
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let samples: Vec<u8> = (0..24).collect();
        let grid = UniformGrid::new([4, 3, 2], samples, placement, Calibration::default()).unwrap();
        let linear = GridVolume::new(grid.into(), Filter::Trilinear);
        let of = |filter| Ghosts::new(&Splatter::default(), &SplatInput::Grid(Arc::new(linear.with_filter(filter))));
        assert!(of(Filter::Trilinear).is_none() && of(Filter::Nearest).is_none());
        let nearest = of(Filter::CatmullRom).unwrap();
        let lattice = nearest.lattice();
        assert_eq!(lattice.dims, [6, 5, 4]);
        let at = |[x, y, z]: [usize; 3]| lattice.at::<f32>(x, y, z);
        assert_eq!(
            [at([1, 1, 1]), at([0, 0, 0]), at([5, 4, 3]), at([0, 2, 1]), at([3, 4, 2])],
            [0.0, 0.0, 23.0, 4.0, 22.0]
        );
        assert_eq!(nearest.range(), (0.0, 23.0));
        // Mirrored coefficients.
        let spline = of(Filter::BSpline).unwrap();
        let at = |x: usize| spline.lattice().at::<f32>(x, 1, 1);
        assert!(at(0) == at(2) && at(5) == at(3) && at(1) != at(2));
    }
}
