//! The field of a grid at a point: voxels, filter and vacuum together.

use crate::filter::{Filter, Lattice, Reconstruction};
use crate::missing::VacuumCells;
use crate::real::Real;
use crate::voxel::Voxel;

/// Evaluates the reconstructed field, in stored units, at index-space positions inside the box.
///
/// [`GridVolume::with_sampler`](crate::GridVolume::with_sampler) makes it. The value in vacuum (a cell with a missing corner) is NaN.
///
/// # Examples
/// ```
/// use vr_core::Sampler;
/// use vr_core::filter::{Lattice, Trilinear};
///
/// let lattice = Lattice { samples: &[0u8, 1, 2, 3, 4, 5, 6, 7], dims: [2; 3] };
/// let sampler = Sampler::<u8, Trilinear>::new(lattice, None);
/// let (value, gradient) = sampler.value_and_gradient([0.5f64, 0.5, 0.0]);
/// assert_eq!((value, gradient), (1.5, [1.0, 2.0, 4.0]));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Sampler<'a, T, F> {
    lattice: Lattice<'a, T>,
    vacuum: Option<&'a VacuumCells>,
    filter: std::marker::PhantomData<F>,
}

impl<'a, T: Voxel, F: Reconstruction> Sampler<'a, T, F> {
    /// A filter over voxels (for the B-spline: over coefficients), none of which is missing.
    pub fn new(lattice: Lattice<'a, T>, vacuum: Option<&'a VacuumCells>) -> Self {
        Self { lattice, vacuum, filter: std::marker::PhantomData }
    }

    /// The filter.
    pub fn filter(&self) -> Filter {
        F::FILTER
    }

    /// The numbers under the filter: voxels, or coefficients for the B-spline.
    pub fn lattice(&self) -> &Lattice<'a, T> {
        &self.lattice
    }

    /// The vacuum cells, if any.
    pub fn vacuum(&self) -> Option<&'a VacuumCells> {
        self.vacuum
    }

    /// The field; NaN in vacuum.
    #[inline(always)]
    pub fn value<R: Real>(&self, p: [R; 3]) -> R {
        match self.vacuum {
            Some(v) if v.contains(p) => R::NAN,
            _ => F::value(&self.lattice, p),
        }
    }

    /// The field and its analytic gradient per index step; NaN and zero in vacuum.
    #[inline(always)]
    pub fn value_and_gradient<R: Real>(&self, p: [R; 3]) -> (R, [R; 3]) {
        match self.vacuum {
            Some(v) if v.contains(p) => (R::NAN, [R::ZERO; 3]),
            _ => F::value_and_gradient(&self.lattice, p),
        }
    }
}
