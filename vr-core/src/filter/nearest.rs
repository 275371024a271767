//! The nearest voxel.

use super::{Filter, Lattice, Reconstruction};
use crate::real::Real;
use crate::voxel::Voxel;

/// The nearest voxel; at the middle between two, the one of higher index.
#[derive(Clone, Copy, Debug)]
pub struct Nearest;

impl Reconstruction for Nearest {
    const FILTER: Filter = Filter::Nearest;

    #[inline(always)]
    fn value<T: Voxel, R: Real>(lattice: &Lattice<'_, T>, p: [R; 3]) -> R {
        let half = R::from_f64(0.5);
        let i = |axis: usize| (p[axis] + half).to_index().min(lattice.dims[axis] - 1);
        lattice.at(i(0), i(1), i(2))
    }

    /// The value, and a gradient of zero, which it is where it exists.
    #[inline(always)]
    fn value_and_gradient<T: Voxel, R: Real>(lattice: &Lattice<'_, T>, p: [R; 3]) -> (R, [R; 3]) {
        (Self::value(lattice, p), [R::ZERO; 3])
    }
}
