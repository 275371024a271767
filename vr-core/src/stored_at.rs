//! The field of a grid at one place, for callers that need no more than that.

use crate::central_differences::{gradient_at_sample, gradient_between_samples};
use crate::filter::{Lattice, Reconstruction};
use crate::grid_volume::{GridVolume, LatticeVisitor, SamplerVisitor};
use crate::sampler::Sampler;
use crate::voxel::Voxel;

struct StoredAt([f64; 3]);

impl SamplerVisitor for StoredAt {
    type Output = f64;
    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) -> f64 {
        sampler.value(self.0)
    }
}

struct StoredAndGradientAt([f64; 3]);

impl SamplerVisitor for StoredAndGradientAt {
    type Output = (f64, [f64; 3]);
    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) -> (f64, [f64; 3]) {
        sampler.value_and_gradient(self.0)
    }
}

struct CentralDifferencesAt([f64; 3]);

impl LatticeVisitor for CentralDifferencesAt {
    type Output = [f64; 3];
    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> [f64; 3] {
        gradient_between_samples(&lattice, self.0)
    }
}

struct CentralDifferencesAtSample([usize; 3]);

impl LatticeVisitor for CentralDifferencesAtSample {
    type Output = [f64; 3];
    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> [f64; 3] {
        gradient_at_sample(&lattice, self.0)
    }
}

impl GridVolume {
    /// Stored number that the filter makes at a place in index space; NaN in vacuum. Each call finds the sampler anew: code that asks often takes it
    /// from [`GridVolume::with_sampler`].
    ///
    /// # Examples
    /// ```
    /// use vr_core::{Calibration, Filter, GridVolume, Placement, UniformGrid};
    ///
    /// let voxels: Vec<u8> = (0..8).collect();
    /// let grid = UniformGrid::new([2; 3], voxels, Placement::from_spacing([1.0; 3])?, Calibration::default())?;
    /// let volume = GridVolume::new(grid.into(), Filter::Trilinear);
    /// assert_eq!(volume.stored_at([0.5; 3]), 3.5);
    /// assert_eq!(volume.stored_and_gradient_at([0.5; 3]), (3.5, [1.0, 2.0, 4.0]));
    /// # Ok::<(), vr_core::GridError>(())
    /// ```
    pub fn stored_at(&self, index: [f64; 3]) -> f64 {
        self.with_sampler(StoredAt(index))
    }

    /// Stored number at a place in index space, and the filter's gradient of it per index step; NaN in vacuum.
    pub fn stored_and_gradient_at(&self, index: [f64; 3]) -> (f64, [f64; 3]) {
        self.with_sampler(StoredAndGradientAt(index))
    }

    /// Central differences of the stored numbers per index step, linear between the samples, at a place in index space.
    pub fn central_differences_at(&self, index: [f64; 3]) -> [f64; 3] {
        self.with_lattice(CentralDifferencesAt(index))
    }

    /// Central differences of the stored numbers per index step at a sample.
    pub fn central_differences_at_sample(&self, index: [usize; 3]) -> [f64; 3] {
        self.with_lattice(CentralDifferencesAtSample(index))
    }
}
