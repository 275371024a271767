//! Voxels of another type.

use vr_core::{AnyGrid, Calibration, GridVolume, UniformGrid, Voxel, VoxelType, parallel, with_grid};

use crate::error::FieldError;

/// Counts of voxels that another type does not hold as they were.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rounding {
    /// Voxels within the range of the type that were rounded.
    pub rounded: usize,
    /// Voxels beyond the range of the type that became its nearest end.
    pub clamped: usize,
    /// Missing voxels (NaN) that became 0.
    pub missing: usize,
}

/// Returns the calibrated values as voxels of a type, rounded to the nearest and clamped to its range; slope and intercept are 1 and 0 then.
/// With `rescale`, its two values become the ends of the integer type's range, and what is between them lies between. A grid that is of
/// the type already, without a calibration, stays as it is.
///
/// # Errors
/// Two values to rescale that are equal or not finite, or a type that is no integer's.
pub fn convert_grid(
    grid: &GridVolume,
    to: VoxelType,
    rescale: Option<[f64; 2]>,
) -> Result<(GridVolume, Rounding), FieldError> {
    if let Some([low, high]) = rescale {
        if !to.is_integer() {
            return Err(FieldError::new("rescale", to, "must be an integer type: u8, i8, u16 or i16"));
        }
        if low == high || !(high - low).is_finite() {
            let found = format!("{low} and {high}");
            return Err(FieldError::new("rescale", found, "must be two different finite values"));
        }
    } else if grid.voxel_type() == to && grid.calibration() == Calibration::default() {
        return Ok((grid.clone(), Rounding::default()));
    }
    match to {
        VoxelType::U8 => converted(grid, rescale, [0.0, 255.0], |x| x as u8),
        VoxelType::I8 => converted(grid, rescale, [-128.0, 127.0], |x| x as i8),
        VoxelType::U16 => converted(grid, rescale, [0.0, 65535.0], |x| x as u16),
        VoxelType::I16 => converted(grid, rescale, [-32768.0, 32767.0], |x| x as i16),
        VoxelType::F32 => converted(grid, None, [f32::MIN.into(), f32::MAX.into()], |x| x as f32),
    }
}

fn converted<T: Voxel>(
    grid: &GridVolume,
    rescale: Option<[f64; 2]>,
    [min, max]: [f64; 2],
    to: impl Fn(f64) -> T + Sync,
) -> Result<(GridVolume, Rounding), FieldError>
where
    AnyGrid: From<UniformGrid<T>>,
{
    const PART: usize = 1 << 16;
    let calibration = grid.calibration();
    let [low, high] = rescale.unwrap_or([min, max]);
    let value = |stored: f32| {
        let value = calibration.value(stored.into());
        if rescale.is_some() { min + (value - low) / (high - low) * (max - min) } else { value }
    };
    let convert = |stored: f32, counts: &mut Rounding| {
        let value = value(stored);
        let nearest = if T::TYPE.is_integer() { value.round() } else { value };
        if nearest.is_nan() && T::TYPE.is_integer() {
            counts.missing += 1;
        } else if nearest < min || nearest > max {
            counts.clamped += 1;
        } else if !nearest.is_nan() && f64::from(to(nearest).to_f32()) != value {
            counts.rounded += 1;
        }
        // NaN becomes 0 where it is no number of the type.
        to(nearest.clamp(min, max))
    };
    let count = grid.dims().iter().product();
    let mut out = vec![T::default(); count];
    let mut counts = vec![Rounding::default(); count.div_ceil(PART)];
    parallel::each_part(out.chunks_mut(PART).zip(&mut counts), |part, (out, counts)| {
        let stored = floats(grid.values(), part * PART, out.len());
        for (out, stored) in out.iter_mut().zip(stored) {
            *out = convert(stored, counts);
        }
    });
    let counts = counts.iter().fold(Rounding::default(), |a, b| Rounding {
        rounded: a.rounded + b.rounded,
        clamped: a.clamped + b.clamped,
        missing: a.missing + b.missing,
    });
    let made = UniformGrid::new(grid.dims(), out, *grid.placement(), Calibration::default())
        .map_err(|e| FieldError::new("grid", "another one", e.to_string()))?;
    Ok((GridVolume::new(made.into(), grid.filter()), counts))
}

/// Some of the stored numbers as floats: one loop for each type that is read, and one for each that is made, instead of one for each pair.
fn floats(values: &AnyGrid, first: usize, count: usize) -> Vec<f32> {
    with_grid!(values, grid => grid.samples()[first..][..count].iter().map(|stored| stored.to_f32()).collect())
}

#[cfg(test)]
mod tests {
    use super::super::tests::{numbered, samples};
    use super::*;
    use vr_core::{Filter, Placement};

    #[test]
    fn values_are_rounded_and_clamped_and_counted() {
        // Values −10 to 19.5 in steps of ½.
        let (bytes, counts) = convert_grid(&numbered(), VoxelType::U8, None).unwrap();
        assert_eq!((bytes.voxel_type(), bytes.calibration()), (VoxelType::U8, Calibration::default()));
        // −0.5 is −1 when rounded.
        assert_eq!(counts, Rounding { rounded: 20, clamped: 20, missing: 0 });
        assert_eq!(samples(&bytes)[19..24], [0., 0., 1., 1., 2.]);
        assert_eq!(bytes.placement(), numbered().placement());
        let (floats, counts) = convert_grid(&numbered(), VoxelType::F32, None).unwrap();
        assert_eq!((samples(&floats)[1], counts), (-9.5, Rounding::default()));
    }

    #[test]
    fn two_values_become_the_ends_of_the_range() {
        let (bytes, counts) = convert_grid(&numbered(), VoxelType::U8, Some([-10.0, 19.5])).unwrap();
        let found = samples(&bytes);
        assert_eq!((found[0], found[59], counts.clamped), (0.0, 255.0, 0));
        let (turned, _) = convert_grid(&numbered(), VoxelType::I16, Some([19.5, -10.0])).unwrap();
        assert_eq!((samples(&turned)[0], samples(&turned)[59]), (32767.0, -32768.0));
        assert!(convert_grid(&numbered(), VoxelType::U8, Some([1.0, 1.0])).is_err());
        assert!(convert_grid(&numbered(), VoxelType::F32, Some([0.0, 1.0])).is_err());
    }

    #[test]
    fn missing_voxels_are_counted() {
        let voxels = vec![1.0, f32::NAN, 3.0, 4.0, 5.0, 6.0, 7.0, 300.0];
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let grid = UniformGrid::new([2; 3], voxels, placement, Calibration::default()).unwrap();
        let grid = GridVolume::new(grid.into(), Filter::default());
        let (bytes, counts) = convert_grid(&grid, VoxelType::U8, None).unwrap();
        assert_eq!(samples(&bytes), [1., 0., 3., 4., 5., 6., 7., 255.]);
        assert_eq!(counts, Rounding { rounded: 0, clamped: 1, missing: 1 });
        let same = convert_grid(&grid, VoxelType::F32, None).unwrap().0;
        assert!(same.same(&grid));
    }
}
