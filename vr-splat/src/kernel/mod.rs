//! Reconstruction kernels: how a sample is spread over the space around it.

mod partition;
mod profile;

pub(crate) use profile::{Gaussian, Profile, Radial, RadialWeight, quadrature};

use vr_core::Filter;

/// A kernel of voxels.
///
/// | kernel | w, over x in voxels | reach |
/// |---|---|---|
/// | bilinear | Π (1 − abs xᵢ): linear along each axis | 1 |
/// | B-spline | Π of cubic B-splines, which smooth (no prefilter) | 2 |
/// | Gaussian | e^(−½ (x/σ)²) inside a ball, lowered so that it ends in 0 | 2, σ = 0.7 |
/// | cone | 1 − abs x / radius | 1.6 |
/// | sinc | Π sinc(xᵢ)·sinc(xᵢ / radius): windowed as by Lanczos | 3 |
/// | box | 1 in the voxel's own cube | ½ |
/// | Catmull-Rom | Π of Keys' cubics, a = −½, which interpolate | 2 |
/// | product Gaussian | Π of Gaussians, lowered so that each ends in 0 | 2, σ = 0.7 |
///
/// Gaussian and cone are radially symmetric, the others are products along the axes. All have an integral of one voxel; bilinear weights, B-splines,
/// boxes and Catmull-Rom cubics sum to 1 everywhere, and by how much the others' do not, [`SplatKernel::partition_error`] says.
///
/// Each [`Filter`] of a scene is one of them, where weights are divided out: see [`Shape::of_filter`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shape {
    /// Linear along each axis: with it, what is classified after reconstruction is the canonical field.
    #[default]
    Bilinear,
    /// Cubic B-spline along each axis.
    BSpline,
    /// Gaussian, as Westover (1990) has it.
    Gaussian,
    /// Falls linearly with the distance.
    Cone,
    /// Windowed sinc.
    Sinc,
    /// The voxel's own cube.
    Box,
    /// Catmull-Rom cubic along each axis (Keys 1981).
    CatmullRom,
    /// Gaussian along each axis.
    ProductGaussian,
}

impl Shape {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Bilinear,
        Self::BSpline,
        Self::Gaussian,
        Self::Cone,
        Self::Sinc,
        Self::Box,
        Self::CatmullRom,
        Self::ProductGaussian,
    ];

    /// The shape whose sum over voxels, divided by that of the weights, is the field of a filter: of the B-spline's with its coefficients in the place of
    /// voxels.
    pub fn of_filter(filter: Filter) -> Self {
        match filter {
            Filter::Nearest => Self::Box,
            Filter::Trilinear => Self::Bilinear,
            Filter::BSpline => Self::BSpline,
            Filter::CatmullRom => Self::CatmullRom,
            Filter::Gaussian => Self::ProductGaussian,
        }
    }

    /// The reach that belongs to it, in voxels.
    pub fn own_radius(self) -> f64 {
        match self {
            Self::Bilinear => 1.0,
            Self::BSpline | Self::Gaussian | Self::CatmullRom | Self::ProductGaussian => 2.0,
            Self::Box => 0.5,
            Self::Cone => 1.6,
            Self::Sinc => 3.0,
        }
    }

    /// True if it is a product along the axes.
    pub fn is_separable(self) -> bool {
        !matches!(self, Self::Gaussian | Self::Cone)
    }
}

/// A kernel with its widths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplatKernel {
    /// Its shape.
    pub shape: Shape,
    /// Reach in voxels; 0: its shape's own.
    pub radius: f64,
    /// Standard deviation of Gaussians, in voxels.
    pub sigma: f64,
    /// Factors on the widths along the volume's x, y and z.
    pub width: [f64; 3],
}

impl Default for SplatKernel {
    fn default() -> Self {
        Self { shape: Shape::default(), radius: 0.0, sigma: 0.7, width: [1.0; 3] }
    }
}

impl SplatKernel {
    /// A kernel of a shape, with all that is its own.
    pub fn new(shape: Shape) -> Self {
        Self { shape, ..Self::default() }
    }

    /// Reach along each axis, in voxels.
    pub fn reach(&self) -> [f64; 3] {
        let radius = if self.radius > 0.0 { self.radius } else { self.shape.own_radius() };
        self.width.map(|w| w * radius)
    }

    /// The weight at an offset in voxels.
    pub fn at(&self, offset: [f64; 3]) -> f64 {
        let reach = self.reach();
        let t: [f64; 3] = std::array::from_fn(|a| offset[a] / reach[a]);
        let volume = reach[0] * reach[1] * reach[2];
        self.profile().at(t) / volume
    }

    /// The kernel stretched to the unit ball, or the cube [−1, 1]³.
    pub(crate) fn profile(&self) -> Profile {
        let radius = self.reach()[0] / self.width[0];
        match self.shape {
            Shape::Bilinear => Profile::Bilinear,
            Shape::BSpline => Profile::BSpline,
            Shape::Gaussian => Profile::gaussian(radius / self.sigma),
            Shape::Cone => Profile::cone(),
            Shape::Sinc => Profile::sinc(radius),
            Shape::Box => Profile::Box,
            Shape::CatmullRom => Profile::CatmullRom,
            Shape::ProductGaussian => Profile::product_gaussian(radius / self.sigma),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_have_an_integral_of_one_voxel() {
        // The midpoint rule converges fast for kernels that end smoothly; the cone's tip and edge leave the most.
        for shape in Shape::ALL {
            let kernel = SplatKernel { width: [1.0, 1.25, 0.8], ..SplatKernel::new(shape) };
            let reach = kernel.reach();
            let n = 40;
            let place = |i: usize, a: usize| ((i as f64 + 0.5) / n as f64 * 2.0 - 1.0) * reach[a];
            let mut total = 0.0;
            for z in 0..n {
                for y in 0..n {
                    for x in 0..n {
                        total += kernel.at([place(x, 0), place(y, 1), place(z, 2)]);
                    }
                }
            }
            let total = total * reach.iter().map(|r| 2.0 * r / n as f64).product::<f64>();
            assert!((total - 1.0).abs() < 1e-3, "{shape:?}: {total}");
        }
    }
}
