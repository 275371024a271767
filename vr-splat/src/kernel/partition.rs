//! Deviation of the sum of a kernel's weights from 1.

use super::SplatKernel;

/// Places along the edge of a cell at which sums are looked at.
const PLACES: usize = 16;

impl SplatKernel {
    /// The largest deviation of Σ w(x − k) over all lattice points k from 1, at the places x of a lattice of 16³ to a cell. It is what a constant
    /// field is off by where weights are not divided out.
    pub fn partition_error(&self) -> f64 {
        let size = self.reach();
        let reach = size.map(|r| r.ceil() as i32);
        let (profile, volume) = (self.profile(), size.into_iter().product::<f64>());
        let mut worst = 0.0f64;
        // Kernels are even: half a cell is all there is.
        let place = |i: usize| i as f64 / PLACES as f64;
        for z in 0..=PLACES / 2 {
            for y in 0..=PLACES / 2 {
                for x in 0..=PLACES / 2 {
                    let at = [place(x), place(y), place(z)];
                    let mut sum = 0.0;
                    for k in -reach[2]..=reach[2] + 1 {
                        for j in -reach[1]..=reach[1] + 1 {
                            for i in -reach[0]..=reach[0] + 1 {
                                let index = [i, j, k].map(f64::from);
                                let t = std::array::from_fn(|a| (at[a] - index[a]) / size[a]);
                                sum += profile.at(t) / volume;
                            }
                        }
                    }
                    worst = worst.max((sum - 1.0).abs());
                }
            }
        }
        worst
    }
}

#[cfg(test)]
mod tests {
    use crate::kernel::{Shape, SplatKernel};

    #[test]
    fn products_sum_to_one_and_the_others_nearly() {
        // The documentation's numbers.
        for (shape, min, max) in [
            (Shape::Bilinear, 0.0, 1e-12),
            (Shape::BSpline, 0.0, 1e-12),
            (Shape::Gaussian, 0.005, 0.01),
            (Shape::Cone, 0.1, 0.15),
            (Shape::Sinc, 0.005, 0.01),
            (Shape::Box, 0.0, 1e-12),
            (Shape::CatmullRom, 0.0, 1e-12),
            (Shape::ProductGaussian, 0.001, 0.05),
        ] {
            let error = SplatKernel::new(shape).partition_error();
            println!("{shape:?}: {error:.2e}");
            assert!((min..=max).contains(&error), "{shape:?}: {error}");
        }
        let wide = SplatKernel { radius: 4.0, sigma: 1.2, ..SplatKernel::new(Shape::Gaussian) };
        assert!(wide.partition_error() < 1e-3, "{}", wide.partition_error());
    }
}
