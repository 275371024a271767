//! Reconstruction filters: from voxels to a field that has a value, and an analytic gradient, everywhere in the box.
//!
//! | filter | support | field | at the voxels |
//! |---|---|---|---|
//! | nearest | 1 | piecewise constant | interpolates |
//! | trilinear | 2³ | continuous, kinks at cell faces | interpolates |
//! | B-spline | 4³ | twice differentiable | interpolates, thanks to a prefilter |
//! | Catmull-Rom | 4³ | once differentiable | interpolates |
//! | Gaussian | 4³ | continuous, kinks at cell faces | smooths |
//!
//! Voxels beyond the box are the mirrored ones for the B-spline (its prefilter assumes so) and the nearest ones for the others.

mod bspline;
mod catmull_rom;
mod gaussian;
mod nearest;
mod separable;
mod trilinear;

pub use bspline::{BSpline, BSplineTaps, interpolation_coefficients};
pub use catmull_rom::{CatmullRom, CatmullRomTaps};
pub use gaussian::{GAUSSIAN_RADIUS, GAUSSIAN_SIGMA, Gaussian, GaussianTaps};
pub use nearest::Nearest;
pub use separable::{Separable, Taps4};
pub use trilinear::Trilinear;

use crate::real::Real;
use crate::voxel::Voxel;

/// Reconstruction filter that makes the field.
///
/// # Examples
/// ```
/// use vr_core::Filter;
///
/// assert_eq!(Filter::default(), Filter::Trilinear);
/// assert_eq!(Filter::from_name("catmull-rom"), Some(Filter::CatmullRom));
/// // The voxels next to the first cell: beyond the box, the nearest one stands in.
/// assert_eq!(Filter::CatmullRom.taps(0, 8), [0, 0, 1, 2]);
/// assert_eq!(Filter::BSpline.taps(0, 8), [1, 0, 1, 2], "mirrored");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Filter {
    /// The nearest voxel.
    Nearest,
    /// Linear along each axis; the default.
    #[default]
    Trilinear,
    /// Cubic B-spline, prefiltered so that it interpolates (Unser 1999).
    #[cfg_attr(feature = "serde", serde(rename = "bspline"))]
    BSpline,
    /// Catmull-Rom cubic (Keys 1981, a = −½).
    CatmullRom,
    /// Gaussian, normalised.
    Gaussian,
}

impl Filter {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Nearest, Self::Trilinear, Self::BSpline, Self::CatmullRom, Self::Gaussian];

    /// Name in scene files and options.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nearest => "nearest",
            Self::Trilinear => "trilinear",
            Self::BSpline => "bspline",
            Self::CatmullRom => "catmull-rom",
            Self::Gaussian => "gaussian",
        }
    }

    /// The filter of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|f| f.name() == name)
    }

    /// False for `nearest` alone, whose field jumps.
    pub fn is_continuous(self) -> bool {
        self != Self::Nearest
    }

    /// Number of voxels to the left and right of a cell (beyond its own two per axis) that the field in it depends on.
    pub fn reach(self) -> usize {
        match self {
            Self::Nearest | Self::Trilinear => 0,
            Self::BSpline | Self::CatmullRom | Self::Gaussian => 1,
        }
    }

    /// The four lattice indices around a cell of an axis of `n` voxels, with those beyond the box replaced: mirrored for the
    /// B-spline, the nearest one inside for the others.
    #[inline(always)]
    pub fn taps(self, cell: usize, n: usize) -> [usize; 4] {
        let inward = usize::from(self == Self::BSpline);
        let below = if cell > 0 { cell - 1 } else { inward };
        let above = if cell + 2 < n { cell + 2 } else { n - 1 - inward };
        [below, cell, cell + 1, above]
    }
}

impl std::fmt::Display for Filter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// Voxels on a lattice in index space, in stored units: the input of a kernel.
///
/// # Examples
/// ```
/// use vr_core::filter::{Lattice, Reconstruction, Trilinear};
///
/// let lattice = Lattice { samples: &[0u8, 10, 20, 30, 40, 50, 60, 70], dims: [2; 3] };
/// assert_eq!(lattice.at::<f32>(1, 0, 1), 50.0);
/// assert_eq!(lattice.cell(0, 0.25), (0, 0.25));
/// assert_eq!(Trilinear::value(&lattice, [0.5, 0.0, 0.0]), 5.0);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Lattice<'a, T> {
    /// The voxels, x fastest.
    pub samples: &'a [T],
    /// Voxels along x, y, z.
    pub dims: [usize; 3],
}

impl<T: Voxel> Lattice<'_, T> {
    /// Position in `samples` of a lattice point.
    #[inline(always)]
    pub fn offset(&self, x: usize, y: usize, z: usize) -> usize {
        (z * self.dims[1] + y) * self.dims[0] + x
    }

    /// The stored number at a lattice point.
    #[inline(always)]
    pub fn at<R: Real>(&self, x: usize, y: usize, z: usize) -> R {
        R::from_f32(self.samples[self.offset(x, y, z)].to_f32())
    }

    /// The cell of a position along one axis, and the fraction in it: `0 ≤ cell ≤ n − 2` and, inside the box, `0 ≤ t ≤ 1`.
    #[inline(always)]
    pub fn cell<R: Real>(&self, axis: usize, x: R) -> (usize, R) {
        let i = x.to_index().min(self.dims[axis] - 2);
        (i, x - R::from_index(i))
    }
}

/// A filter as code: instantiated per voxel type and precision, so that nothing is dispatched per sample.
///
/// # Examples
/// ```
/// use vr_core::filter::{Lattice, Nearest, Reconstruction, Trilinear};
///
/// fn at_middle<F: Reconstruction>(_: F, samples: &[u8]) -> f64 {
///     F::value(&Lattice { samples, dims: [2; 3] }, [0.75, 0.0, 0.0])
/// }
/// let samples = [0, 4, 0, 4, 0, 4, 0, 4];
/// assert_eq!(at_middle(Nearest, &samples), 4.0);
/// assert_eq!(at_middle(Trilinear, &samples), 3.0);
/// ```
pub trait Reconstruction: Copy + Send + Sync + 'static {
    /// The filter that it implements.
    const FILTER: Filter;

    /// The field at an index-space position inside the box, in stored units.
    fn value<T: Voxel, R: Real>(lattice: &Lattice<'_, T>, p: [R; 3]) -> R;

    /// The field and its analytic gradient per index step.
    fn value_and_gradient<T: Voxel, R: Real>(lattice: &Lattice<'_, T>, p: [R; 3]) -> (R, [R; 3]);
}
