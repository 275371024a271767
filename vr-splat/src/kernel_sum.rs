//! Gradient of a sum of kernels over a grid, divided by the sum of their weights.

use vr_core::filter::Lattice;
use vr_core::{GridVolume, LatticeVisitor, Voxel};

use crate::kernel::{Profile, SplatKernel};

/// The field Σ f w / Σ w of a kernel that is not the grid's filter.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KernelSum {
    profile: Profile,
    reach: [f64; 3],
}

impl KernelSum {
    pub(crate) fn new(kernel: &SplatKernel) -> Self {
        Self { profile: kernel.profile(), reach: kernel.reach() }
    }

    /// Gradient per index step at a place in a grid, in stored units; zero where no kernel reaches.
    pub(crate) fn gradient_at(&self, volume: &GridVolume, place: [f64; 3]) -> [f64; 3] {
        volume.with_lattice(Gather { sum: self, place }).1
    }
}

/// Sums over the kernels that reach a place.
struct Gather<'a> {
    sum: &'a KernelSum,
    place: [f64; 3],
}

impl LatticeVisitor for Gather<'_> {
    /// The field and its gradient.
    type Output = (f64, [f64; 3]);

    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> Self::Output {
        let Self { sum: KernelSum { profile, reach }, place } = self;
        let range = |a: usize| {
            let (first, last) = ((place[a] - reach[a]).ceil().max(0.0), (place[a] + reach[a]).floor());
            first as usize..if last < 0.0 { 0 } else { (last as usize + 1).min(lattice.dims[a]) }
        };
        // Differences from the nearest voxel, so that where the field is constant its gradient is zero to the last bit.
        let nearest: [usize; 3] =
            std::array::from_fn(|a| (place[a].max(0.0) + 0.5).min((lattice.dims[a] - 1) as f64) as usize);
        let base: f64 = lattice.at(nearest[0], nearest[1], nearest[2]);
        let (mut weight, mut value) = (0.0, 0.0);
        let (mut slope, mut rise) = ([0.0; 3], [0.0; 3]);
        for z in range(2) {
            for y in range(1) {
                for x in range(0) {
                    let index = [x, y, z].map(|i| i as f64);
                    let (w, slopes) = profile.with_slope(std::array::from_fn(|a| (place[a] - index[a]) / reach[a]));
                    let f = lattice.at::<f64>(x, y, z) - base;
                    weight += w;
                    value += w * f;
                    for a in 0..3 {
                        slope[a] += slopes[a];
                        rise[a] += slopes[a] * f;
                    }
                }
            }
        }
        if weight <= 0.0 {
            return (base, [0.0; 3]);
        }
        let mean = value / weight;
        let gradient = std::array::from_fn(|a| (rise[a] - mean * slope[a]) / (weight * reach[a]));
        (base + mean, gradient)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::Shape;
    use vr_core::{Calibration, Filter, Placement, UniformGrid};

    #[test]
    fn slopes_are_the_differences_of_values() {
        let samples: Vec<f32> = (0..7 * 6 * 8).map(|i| ((i * 7919) % 251) as f32 * 0.01).collect();
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let grid: UniformGrid<f32> = UniformGrid::new([7, 6, 8], samples, placement, Calibration::default()).unwrap();
        let volume = GridVolume::new(grid.into(), Filter::Trilinear);
        for shape in Shape::ALL {
            let kernel = SplatKernel { width: [1.0, 1.25, 1.5], ..SplatKernel::new(shape) };
            let sum = KernelSum::new(&kernel);
            let field = |place| volume.with_lattice(Gather { sum: &sum, place }).0;
            for place in [[2.23, 3.41, 4.34], [0.12, 4.88, 6.57], [5.93, 0.04, 1.61]] {
                let found = sum.gradient_at(&volume, place);
                for a in 0..3 {
                    let step = 1e-5;
                    let at = |by: f64| field(std::array::from_fn(|b| place[b] + if a == b { by } else { 0.0 }));
                    let want = (at(step) - at(-step)) / (2.0 * step);
                    // The square of the step, and rounding by the step.
                    assert!((found[a] - want).abs() < 1e-6, "{shape:?} {place:?} {a}: {} for {want}", found[a]);
                }
            }
        }
        let flat: UniformGrid<u8> = UniformGrid::new([5; 3], vec![77; 125], placement, Calibration::default()).unwrap();
        let flat = GridVolume::new(flat.into(), Filter::Trilinear);
        for shape in Shape::ALL {
            assert_eq!(KernelSum::new(&SplatKernel::new(shape)).gradient_at(&flat, [1.3, 2.2, 3.9]), [0.0; 3]);
        }
    }
}
