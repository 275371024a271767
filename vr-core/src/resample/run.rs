//! The resampling itself.

use std::sync::Mutex;

use glam::DVec3;

use super::error::ResampleError;
use super::integral::Integral;
use super::lattice::SampleLattice;
use super::options::{ResampleFilter, Resampling, Resolution};
use super::source::{Planes, Source};
use crate::control::Control;
use crate::grid::{Calibration, UniformGrid, sample_count};
use crate::parallel::{locked, try_each};
use crate::volume::Volume;

/// Largest number of samples in a plane: each thread holds two, of eight bytes a sample.
const MAX_PLANE: usize = 1 << 27;

/// A volume that was resampled, and an account of it.
#[derive(Clone, Debug)]
pub struct Resampled {
    /// The voxels; NaN in vacuum.
    pub grid: UniformGrid<f32>,
    /// Kind of the volume that it was.
    pub kind: &'static str,
    /// Choices that it was made by.
    pub choices: Resampling,
    /// Number of voxels that are vacuum.
    pub vacuum: usize,
    /// Voxels along each axis that the finest cells would have taken, where they were too many.
    pub wanted: Option<[usize; 3]>,
    /// Integral of the volume.
    pub before: Integral,
    /// Integral of the grid, corrected.
    pub after: Integral,
    /// Correction that keeps the integral, if it was asked for.
    pub correction: Option<Correction>,
}

/// Correction of all voxels that keeps the integral.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Correction {
    /// A factor: for values of one sign, such as densities.
    Factor(f64),
    /// An addend: for values of both signs.
    Shift(f64),
}

impl Resampled {
    /// Difference of the integrals after and before, relative to that before; 0 if both are 0, infinite if that before alone is.
    pub fn integral_error(&self) -> f64 {
        let difference = (self.after.value - self.before.value).abs();
        if difference == 0.0 { 0.0 } else { difference / self.before.value.abs() }
    }

    /// Part of the voxels that is vacuum.
    pub fn vacuum_share(&self) -> f64 {
        self.vacuum as f64 / self.grid.samples().len() as f64
    }
}

/// Resamples a volume to a uniform grid over its box: for a uniform grid its own box, whatever its orientation, and else the axis-parallel one.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::cells::{CellMesh, CellValues};
/// use vr_core::resample::{Resampling, Resolution, resample};
/// use vr_core::{Control, Volume};
///
/// let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
/// let mesh = CellMesh::new(vertices, vec![[0, 1, 2, 3]], CellValues::Vertices(vec![0.0, 1.0, 2.0, 3.0]))?;
/// let options = Resampling { resolution: Resolution::Dims([5; 3]), ..Resampling::default() };
/// let resampled = resample(&Volume::from(mesh), &options, &Control::default())?;
/// assert_eq!(resampled.grid.samples()[1], 0.25);
/// assert!(resampled.grid.samples()[124].is_nan(), "far beyond the slanted face");
/// assert!((resampled.before.value - 0.25).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ResampleError`] for a volume whose values are colours or codes, a resolution that is no grid or too large, no voxel that is not vacuum,
/// and where `control` cancels.
pub fn resample(volume: &Volume, options: &Resampling, control: &Control) -> Result<Resampled, ResampleError> {
    let source = Source::new(volume)?;
    let (dims, wanted) = dims_of(&source, options)?;
    let placement = source.placement(dims)?;
    let mut values = control.run(|| sampled(&source, dims, options.filter, control))?;
    let vacuum = values.iter().filter(|value| value.is_nan()).count();
    if vacuum == values.len() {
        return Err(ResampleError::Empty { dims });
    }
    let grid_of = |values: Vec<f32>| UniformGrid::new(dims, values, placement, Calibration::default());
    let integral_of = |grid: &UniformGrid<f32>| Integral::of(&Volume::from(grid.clone())).expect("grids have one");
    let before = match Integral::of(source.volume()) {
        Some(exact) => exact,
        None => estimated(&source, dims, control)?,
    };
    let mut correction = None;
    if options.conserve {
        let (after, low) = {
            let grid = grid_of(values.clone())?;
            (integral_of(&grid), grid.value_stats().range)
        };
        let one_sign = low.is_some_and(|(low, high)| low >= 0.0 || high <= 0.0);
        let factor = before.value / after.value;
        if one_sign && factor.is_finite() && factor > 0.0 {
            values.iter_mut().for_each(|v| *v = (f64::from(*v) * factor) as f32);
            correction = Some(Correction::Factor(factor));
        } else if after.volume > 0.0 {
            let shift = (before.value - after.value) / after.volume;
            values.iter_mut().for_each(|v| *v = (f64::from(*v) + shift) as f32);
            correction = Some(Correction::Shift(shift));
        }
    }
    let grid = grid_of(values)?;
    let after = integral_of(&grid);
    Ok(Resampled { grid, kind: volume.kind(), choices: *options, vacuum, wanted, before, after, correction })
}

/// Voxels along each axis and, where the finest cells would take too many, how many those are.
fn dims_of(source: &Source<'_>, options: &Resampling) -> Result<([usize; 3], Option<[usize; 3]>), ResampleError> {
    let extent = (source.bounds.1 - source.bounds.0).to_array();
    // `as` saturates. A hair below a whole number of steps is that number.
    let fitted =
        |steps: [f64; 3]| [0, 1, 2].map(|a| ((extent[a] / steps[a] - 1e-9).ceil().max(1.0) as usize).saturating_add(1));
    let count = |dims: [usize; 3]| dims.iter().map(|&n| n as u128).fold(1u128, u128::saturating_mul);
    let (dims, wanted) = match options.resolution {
        Resolution::Dims(dims) => (dims, None),
        Resolution::Spacing(found) if !(found.is_finite() && found > 0.0) => {
            return Err(ResampleError::Spacing { found });
        }
        Resolution::Spacing(spacing) => (fitted((spacing / source.world_steps()).to_array()), None),
        Resolution::Finest => {
            let most = options.max_finest.clamp(8, options.max_voxels) as u128;
            let coarsened = |factor: f64| fitted((source.finest * factor).to_array());
            let wanted = coarsened(1.0);
            if count(wanted) <= most {
                (wanted, None)
            } else {
                // The smallest factor at which the voxels are few enough, by halving.
                let (mut low, mut high) = (1.0, 2.0);
                while count(coarsened(high)) > most {
                    (low, high) = (high, 2.0 * high);
                }
                for _ in 0..40 {
                    let middle = 0.5 * (low + high);
                    if count(coarsened(middle)) > most { low = middle } else { high = middle }
                }
                (coarsened(high), Some(wanted))
            }
        }
    };
    let voxels = count(dims);
    if voxels > options.max_voxels as u128 {
        return Err(ResampleError::TooLarge { dims, voxels, most: options.max_voxels });
    }
    sample_count(dims)?;
    let parts = options.filter.samples();
    let plane = [dims[0] * parts, dims[1] * parts, 1];
    if count(plane) > MAX_PLANE as u128 {
        return Err(ResampleError::TooLarge { dims: plane, voxels: count(plane), most: MAX_PLANE });
    }
    Ok((dims, wanted))
}

/// The values of all voxels, slice by slice.
fn sampled(
    source: &Source<'_>,
    dims: [usize; 3],
    filter: ResampleFilter,
    control: &Control,
) -> Result<Vec<f32>, ResampleError> {
    let parts = filter.samples();
    let lattice = SampleLattice::new(source.bounds, dims, parts);
    let planes = source.planes(&lattice, parts);
    let mut values = vec![0f32; sample_count(dims)?];
    let slice = dims[0] * dims[1];
    each_slice(values.chunks_mut(slice), control, |z, values: &mut [f32]| {
        for (value, mean) in values.iter_mut().zip(means(&planes, &lattice, dims, z, parts)) {
            *value = mean as f32;
        }
    })?;
    Ok(values)
}

/// Calls `work` for each slice, on all threads.
fn each_slice<'a, T: Send + 'a>(
    slices: impl Iterator<Item = &'a mut [T]>,
    control: &Control,
    work: impl Fn(usize, &mut [T]) + Sync,
) -> Result<(), ResampleError> {
    let slices: Vec<Mutex<&mut [T]>> = slices.map(Mutex::new).collect();
    let done = Mutex::new(0usize);
    try_each(slices.len(), &|z| {
        control.check()?;
        work(z, *locked(&slices[z]));
        let mut done = locked(&done);
        *done += 1;
        control.report(*done as f64 / slices.len() as f64);
        Ok(())
    })?;
    Ok(())
}

/// Means of the samples of each voxel of a slice that are not vacuum; NaN where all are.
fn means(planes: &Planes<'_>, lattice: &SampleLattice, dims: [usize; 3], z: usize, parts: usize) -> Vec<f64> {
    let mut plane = vec![0.0; lattice.plane()];
    if parts == 1 {
        planes.fill(z, &mut plane);
        return plane;
    }
    let mut sums = vec![(0.0, 0u32); dims[0] * dims[1]];
    for part in 0..parts {
        planes.fill(z * parts + part, &mut plane);
        for (y, row) in plane.chunks(dims[0] * parts).enumerate() {
            let sums = &mut sums[y / parts * dims[0]..][..dims[0]];
            for (samples, sum) in row.chunks(parts).zip(sums) {
                for &sample in samples.iter().filter(|sample| !sample.is_nan()) {
                    *sum = (sum.0 + sample, sum.1 + 1);
                }
            }
        }
    }
    // 0/0 is NaN.
    sums.into_iter().map(|(sum, count)| sum / f64::from(count)).collect()
}

/// Integral of a field by samples in the middles of the cells of a lattice that is twice as fine as the grid, or as much as fits.
fn estimated(source: &Source<'_>, dims: [usize; 3], control: &Control) -> Result<Integral, ResampleError> {
    let (low, high) = source.bounds;
    let cells = dims.map(|n| (2 * n).min(512));
    let edge = (high - low) / DVec3::from_array(cells.map(|n| n as f64));
    let middles = (low + 0.5 * edge, high - 0.5 * edge);
    let lattice = SampleLattice::new(middles, cells, 1);
    let planes = source.planes(&lattice, 1);
    let mut sums = vec![[0.0f64; 2]; cells[2]];
    control.run(|| {
        each_slice(sums.chunks_mut(1), control, |z, sum| {
            let mut plane = vec![0.0; lattice.plane()];
            planes.fill(z, &mut plane);
            let seen = plane.into_iter().filter(|v| !v.is_nan());
            sum[0] = seen.fold([0.0; 2], |[value, count], v| [value + v, count + 1.0]);
        })
    })?;
    let [value, count] = sums.into_iter().fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d]);
    let cell = edge.element_product() * source.world_steps().element_product();
    Ok(Integral { value: value * cell, volume: count * cell, is_exact: false })
}
