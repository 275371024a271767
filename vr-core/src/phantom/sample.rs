//! A phantom, sampled onto a grid.

use glam::{DMat3, DVec3};

use super::{Phantom, TRANSFER_UNIT_DISTANCE};
use crate::any_grid::AnyGrid;
use crate::error::GridError;
use crate::grid::{Calibration, UniformGrid, sample_count};
use crate::parallel::each_part;
use crate::placement::Placement;
use crate::scene::Scene;
use crate::transfer::{OpacityRule, TransferFunction};
use crate::voxel::Voxel;

/// A voxel type that a number can be rounded to.
///
/// # Examples
/// ```
/// use vr_core::phantom::{Quantize, Shells, sample};
///
/// assert_eq!(u8::quantize(41.6), 42);
/// assert_eq!(u8::quantize(300.0), 255);
///
/// // The calibration turns stored numbers back into the phantom's values.
/// let grid = sample::<u8>(&Shells, [5; 3])?;
/// let (first, last) = u8::STORED_RANGE.unwrap();
/// assert!(grid.calibration().value(first) < grid.calibration().value(last));
/// # Ok::<(), vr_core::GridError>(())
/// ```
pub trait Quantize: Voxel {
    /// The stored numbers that stand for a range of values: the whole range of an integer type; `None` for floats, which
    /// hold values as they are.
    const STORED_RANGE: Option<(f64, f64)>;
    /// The nearest stored number; the last one beyond either end.
    fn quantize(stored: f64) -> Self;
}

macro_rules! quantize_integer {
    ($($t:ty),*) => {$(
        impl Quantize for $t {
            const STORED_RANGE: Option<(f64, f64)> = Some((<$t>::MIN as f64, <$t>::MAX as f64));
            fn quantize(stored: f64) -> Self {
                // `as` saturates.
                stored.round() as $t
            }
        }
    )*};
}
quantize_integer!(u8, i8, u16, i16);

impl Quantize for f32 {
    const STORED_RANGE: Option<(f64, f64)> = None;
    fn quantize(stored: f64) -> Self {
        stored as f32
    }
}

/// Samples a phantom onto a grid; the first and the last voxel of each axis lie on the faces of its domain.
///
/// Integer types use their whole range for the phantom's [`value_range`](Phantom::value_range), and the calibration turns it
/// back: calibrated values are off by half a quantisation step at most. Floats hold the values as they are. In parallel over
/// slices; the result does not depend on the number of threads.
///
/// # Errors
/// [`GridError::Dims`] for an axis with fewer than two voxels, or a product that overflows.
pub fn sample<T: Quantize>(phantom: &(impl Phantom + ?Sized), dims: [usize; 3]) -> Result<UniformGrid<T>, GridError> {
    let count = sample_count(dims)?;
    let (low, high) = phantom.domain();
    let spacing = (high - low) / DVec3::from_array(dims.map(|n| (n - 1) as f64));
    let placement = Placement::oriented(low, spacing.to_array(), DMat3::IDENTITY)?;
    let calibration = calibration::<T>(phantom.value_range());

    let mut samples = vec![T::default(); count];
    each_part(samples.chunks_mut(dims[0] * dims[1]), |z, slice| {
        for (i, sample) in slice.iter_mut().enumerate() {
            let index = DVec3::new((i % dims[0]) as f64, (i / dims[0]) as f64, z as f64);
            *sample = T::quantize(calibration.stored(phantom.value(placement.to_world(index))));
        }
    });
    UniformGrid::new(dims, samples, placement, calibration)
}

/// The calibration under which the stored range stands for a range of values.
fn calibration<T: Quantize>((low, high): (f64, f64)) -> Calibration {
    T::STORED_RANGE.map_or_else(Calibration::default, |(first, last)| {
        let slope = (high - low) / (last - first);
        Calibration { slope, intercept: low - slope * first }
    })
}

/// An unshaded scene of `n`³ samples of a phantom, under its own transfer function with opacities times `opacity` (1 at the most).
///
/// # Errors
/// Same as for [`sample`].
pub fn sampled_scene<T: Quantize>(phantom: &(impl Phantom + ?Sized), n: usize, opacity: f64) -> Result<Scene, GridError>
where
    AnyGrid: From<UniformGrid<T>>,
{
    let grid = sample::<T>(phantom, [n; 3])?;
    let mut points = phantom.transfer_points();
    points.iter_mut().for_each(|p| p.opacity *= opacity);
    let transfer = TransferFunction::new(points, OpacityRule::Power, TRANSFER_UNIT_DISTANCE);
    Ok(Scene::new(grid.into(), transfer.expect("the points of phantoms ascend, and opacities stay below 1")))
}

#[cfg(test)]
mod tests {
    use super::super::{NAMES, by_name};
    use super::*;

    fn check<T: Quantize>() {
        let dims = [9, 6, 7];
        for name in NAMES {
            let phantom = by_name(name).unwrap();
            let grid = sample::<T>(&*phantom, dims).unwrap();
            let calibration = grid.calibration();
            let (low, high) = phantom.value_range();
            let tolerance = match T::STORED_RANGE {
                Some(_) => 0.5 * calibration.slope * (1.0 + 1e-9),
                None => f64::from(f32::EPSILON) * low.abs().max(high.abs()),
            };
            for (i, s) in grid.samples().iter().enumerate() {
                let index = [i % dims[0], i / dims[0] % dims[1], i / dims[0] / dims[1]];
                let p = grid.placement().to_world(DVec3::from_array(index.map(|k| k as f64)));
                let error = calibration.value(s.to_f32().into()) - phantom.value(p);
                assert!(error.abs() <= tolerance, "{name} {index:?} as {}: off by {error}", T::TYPE);
            }
        }
    }

    #[test]
    fn samples_are_values_within_half_a_quantisation_step() {
        check::<u8>();
        check::<i8>();
        check::<u16>();
        check::<i16>();
        check::<f32>();
    }

    #[test]
    fn the_grid_fills_the_domain() {
        let phantom = by_name("fog").unwrap();
        let grid = sample::<u8>(&*phantom, [5, 2, 11]).unwrap();
        assert_eq!(grid.placement().origin(), DVec3::NEG_ONE);
        assert!(grid.placement().to_world(DVec3::new(4.0, 1.0, 10.0)).distance(DVec3::ONE) < 1e-15);
        assert!(matches!(sample::<u8>(&*phantom, [1, 2, 2]), Err(GridError::Dims { .. })));
    }

    #[test]
    fn samples_do_not_depend_on_the_number_of_threads() {
        let phantom = by_name("hydrogen").unwrap();
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let alone = one.install(|| sample::<f32>(&*phantom, [12, 13, 14]).unwrap());
        let together = sample::<f32>(&*phantom, [12, 13, 14]).unwrap();
        assert_eq!(alone.samples(), together.samples());
    }
}
