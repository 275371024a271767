//! A uniform grid: voxels at lattice points, x fastest, with a placement and a calibration.

use std::sync::{Arc, OnceLock};

use crate::error::GridError;
use crate::lazy::computed;
use crate::parallel::each_part;
use crate::placement::Placement;
use crate::voxel::Voxel;

/// Map from stored numbers to values: `value = slope · stored + intercept` (as in NIfTI and DICOM).
///
/// # Examples
/// ```
/// use vr_core::Calibration;
///
/// // A CT scanner stores Hounsfield units above −1024.
/// let hounsfield = Calibration { slope: 1.0, intercept: -1024.0 };
/// assert_eq!(hounsfield.value(1024.0), 0.0, "water");
/// assert_eq!(hounsfield.stored(-1000.0), 24.0, "air");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// Value per stored unit; not zero.
    pub slope: f64,
    /// Value of the stored number 0.
    pub intercept: f64,
}

impl Default for Calibration {
    fn default() -> Self {
        Self { slope: 1.0, intercept: 0.0 }
    }
}

impl Calibration {
    /// The calibrated value of a stored number.
    #[inline]
    pub fn value(&self, stored: f64) -> f64 {
        self.slope * stored + self.intercept
    }

    /// The stored number of a calibrated value.
    #[inline]
    pub fn stored(&self, value: f64) -> f64 {
        (value - self.intercept) / self.slope
    }
}

/// Range of the stored numbers of a grid, and counts of those that are not finite.
///
/// # Examples
/// ```
/// use vr_core::{Calibration, Placement, UniformGrid};
///
/// let values = vec![1.0, f32::NAN, 3.0, -2.0, f32::INFINITY, 0.0, 0.0, 0.5];
/// let grid = UniformGrid::new([2; 3], values, Placement::from_spacing([1.0; 3])?, Calibration::default())?;
/// let stats = grid.value_stats();
/// assert_eq!((stats.range, stats.nan, stats.infinite), (Some((-2.0, 3.0)), 1, 1));
/// assert!(stats.has_missing());
/// # Ok::<(), vr_core::GridError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValueStats {
    /// Smallest and largest finite stored number; `None` if there is none.
    pub range: Option<(f32, f32)>,
    /// Number of voxels that were NaN.
    pub nan: usize,
    /// Number of voxels that were +∞ or −∞; they are NaN now.
    pub infinite: usize,
}

impl ValueStats {
    /// True if some voxels have no finite number: they are vacuum.
    pub fn has_missing(&self) -> bool {
        self.nan + self.infinite > 0
    }
}

/// Voxels at the points of a regular lattice.
///
/// The volume fills the box from the first to the last voxel on each axis; outside is vacuum. Cloning is cheap: the voxels
/// are shared. No voxel is looked at before it is asked for: a grid over a mapped file of gigabytes is made at once.
///
/// # Examples
/// ```
/// use vr_core::{Calibration, Placement, UniformGrid, Volume};
///
/// // Two slices of 3 × 2 voxels, twice as far apart as the voxels in them.
/// let voxels: Vec<u8> = (0..12).collect();
/// let grid = UniformGrid::new([3, 2, 2], voxels, Placement::from_spacing([1.0, 1.0, 2.0])?, Calibration::default())?;
/// assert_eq!(grid.samples()[1], 1, "x is fastest");
/// assert_eq!(grid.value_stats().range, Some((0.0, 11.0)));
/// let (low, high) = Volume::from(grid).bounds();
/// assert_eq!((high - low).to_array(), [2.0, 1.0, 2.0]);
/// # Ok::<(), vr_core::GridError>(())
/// ```
#[derive(Clone)]
pub struct UniformGrid<T> {
    dims: [usize; 3],
    voxels: Arc<Voxels<T>>,
    placement: Placement,
    calibration: Calibration,
}

/// The stored numbers, and what they are found to be when it is first asked for.
struct Voxels<T> {
    given: Box<dyn AsRef<[T]> + Send + Sync>,
    stats: OnceLock<ValueStats>,
    /// The same with NaN for what is infinite; `None` where nothing is.
    replaced: OnceLock<Option<Vec<T>>>,
}

impl<T: Voxel> Voxels<T> {
    fn stats(&self) -> &ValueStats {
        computed(&self.stats, || stats((*self.given).as_ref()))
    }

    fn samples(&self) -> &[T] {
        let given = (*self.given).as_ref();
        // No integer is infinite.
        if T::TYPE.is_integer() {
            return given;
        }
        let replace = || (self.stats().infinite > 0).then(|| T::infinite_to_nan(given));
        computed(&self.replaced, replace).as_deref().unwrap_or(given)
    }
}

impl<T> std::fmt::Debug for UniformGrid<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("UniformGrid")
            .field("dims", &self.dims)
            .field("placement", &self.placement)
            .field("calibration", &self.calibration)
            .field("stats", &self.voxels.stats)
            .finish_non_exhaustive()
    }
}

impl<T: Voxel> UniformGrid<T> {
    /// A grid over stored numbers in a `Vec`, a mapped file, or any other memory. None is read yet.
    ///
    /// Infinite ones become NaN when they are first asked for (all are then copied).
    ///
    /// # Errors
    /// [`GridError::Dims`] for an axis with fewer than two voxels or a product that overflows, [`GridError::Length`] where
    /// the number of voxels is not the product of `dims`, [`GridError::Calibration`] for a slope that is 0 or not finite, or an intercept
    /// that is not finite.
    pub fn new(
        dims: [usize; 3],
        samples: impl AsRef<[T]> + Send + Sync + 'static,
        placement: Placement,
        calibration: Calibration,
    ) -> Result<Self, GridError> {
        let expected = sample_count(dims)?;
        let found = samples.as_ref().len();
        if found != expected {
            return Err(GridError::Length { dims, expected, found });
        }
        let Calibration { slope, intercept } = calibration;
        if slope == 0.0 || !slope.is_finite() || !intercept.is_finite() {
            return Err(GridError::Calibration { slope, intercept });
        }
        let voxels = Voxels { given: Box::new(samples), stats: OnceLock::new(), replaced: OnceLock::new() };
        Ok(Self { dims, voxels: Arc::new(voxels), placement, calibration })
    }

    /// Voxels along x, y and z; at least two each.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// The stored numbers, x fastest. Of floats, all are read at the first call, for those that are infinite.
    pub fn samples(&self) -> &[T] {
        self.voxels.samples()
    }

    /// Placement of the grid in the world.
    pub fn placement(&self) -> &Placement {
        &self.placement
    }

    /// The same voxels, shared, at another place.
    #[must_use]
    pub fn with_placement(self, placement: Placement) -> Self {
        Self { placement, ..self }
    }

    /// Map from stored numbers to values.
    pub fn calibration(&self) -> Calibration {
        self.calibration
    }

    /// Range of the stored numbers, and counts of the missing ones. All voxels are read at the first call.
    pub fn value_stats(&self) -> &ValueStats {
        self.voxels.stats()
    }
}

/// The number of voxels of a grid, checked.
///
/// # Errors
/// [`GridError::Dims`] for an axis with fewer than two voxels, or where the product is beyond `isize::MAX` bytes of `f32`.
pub fn sample_count(dims: [usize; 3]) -> Result<usize, GridError> {
    if dims.iter().any(|&n| n < 2 || n > i32::MAX as usize) {
        return Err(GridError::Dims { dims });
    }
    dims.iter()
        .try_fold(1usize, |product, &n| product.checked_mul(n))
        .filter(|&n| n <= isize::MAX as usize / 4)
        .ok_or(GridError::Dims { dims })
}

fn stats<T: Voxel>(samples: &[T]) -> ValueStats {
    const CHUNK: usize = 1 << 16;
    let nothing = ValueStats { range: None, nan: 0, infinite: 0 };
    let mut counted = vec![nothing; samples.len().div_ceil(CHUNK)];
    each_part(samples.chunks(CHUNK).zip(&mut counted), |_, (chunk, c)| {
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for &s in *chunk {
            let x = s.to_f32();
            if s.is_missing() {
                if x.is_nan() {
                    c.nan += 1;
                } else {
                    c.infinite += 1;
                }
            } else {
                low = low.min(x);
                high = high.max(x);
            }
        }
        if low <= high {
            c.range = Some((low, high));
        }
    });
    counted.into_iter().fold(nothing, |a, b| ValueStats {
        range: match (a.range, b.range) {
            (Some(x), Some(y)) => Some((x.0.min(y.0), x.1.max(y.1))),
            (x, y) => x.or(y),
        },
        nan: a.nan + b.nan,
        infinite: a.infinite + b.infinite,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit() -> Placement {
        Placement::from_spacing([1.0; 3]).unwrap()
    }

    #[test]
    fn counts_and_replaces_infinite_samples() {
        let data = vec![1.0f32, f32::NAN, f32::INFINITY, -2.0, f32::NEG_INFINITY, 3.0, 0.0, 0.5];
        let g = UniformGrid::new([2, 2, 2], data, unit(), Calibration::default()).unwrap();
        assert_eq!(*g.value_stats(), ValueStats { range: Some((-2.0, 3.0)), nan: 1, infinite: 2 });
        assert!(g.samples()[2].is_nan() && g.samples()[4].is_nan());
    }

    #[test]
    fn refuses_what_is_no_grid() {
        let new = |dims, n| UniformGrid::new(dims, vec![0u8; n], unit(), Calibration::default());
        assert!(matches!(new([1, 2, 2], 4), Err(GridError::Dims { .. })));
        assert!(matches!(new([usize::MAX, 2, 2], 4), Err(GridError::Dims { .. })));
        assert!(matches!(new([2, 2, 2], 7), Err(GridError::Length { expected: 8, found: 7, .. })));
        let zero = Calibration { slope: 0.0, intercept: 1.0 };
        assert!(UniformGrid::new([2, 2, 2], vec![0u8; 8], unit(), zero).is_err());
    }
}
