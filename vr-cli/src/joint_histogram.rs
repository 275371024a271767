//! Histogram of the values and of the gradient's magnitude together.

use vr_core::filter::Lattice;
use vr_core::{GridVolume, LatticeVisitor, Voxel, gradient_at_sample, with_grid};

/// Largest number of voxels that are counted: of larger volumes every second, third or further one along each axis.
const MAX_VOXELS: usize = 1 << 22;
/// Share of the voxels whose gradients may be steeper than the histogram reaches.
const BEYOND: f64 = 5e-4;

/// Counts of voxels by value and by the gradient's magnitude, in equal bins of both.
#[derive(Clone, Debug, PartialEq)]
pub struct JointHistogram {
    /// Calibrated values that the bins lie between.
    pub range: (f64, f64),
    /// Magnitude, in value per world unit, at the upper end of the bins; those begin at 0.
    pub steepest: f64,
    /// Number of bins by value and by magnitude.
    bins: [usize; 2],
    /// Counts, values fastest.
    counts: Vec<u64>,
}

impl JointHistogram {
    /// Counts the voxels of a volume by central differences, the gradient that shading takes by default; `None` where no voxel is finite.
    pub fn of(volume: &GridVolume, bins: [usize; 2]) -> Option<Self> {
        let range = volume.value_range()?;
        let samples = volume.with_lattice(Samples { volume });
        let mut magnitudes: Vec<f32> = samples.iter().map(|s| s.1).collect();
        let last = magnitudes.len().checked_sub(1)?;
        let cut = ((1.0 - BEYOND) * last as f64).ceil() as usize;
        let (_, steepest, _) = magnitudes.select_nth_unstable_by(cut.min(last), f32::total_cmp);
        let mut all = Self { range, steepest: f64::from(*steepest), bins, counts: vec![0; bins[0] * bins[1]] };
        for (value, magnitude) in samples {
            if let Some(bin) = all.bin(f64::from(value), f64::from(magnitude)) {
                all.counts[bin] += 1;
            }
        }
        Some(all)
    }

    /// Returns the number of voxels in the bin of a value and a magnitude; 0 beyond all bins.
    pub fn count(&self, value: f64, magnitude: f64) -> u64 {
        self.bin(value, magnitude).map_or(0, |bin| self.counts[bin])
    }

    /// Returns the number of voxels in the fullest bin.
    pub fn largest(&self) -> u64 {
        self.counts.iter().copied().max().unwrap_or(0)
    }

    fn bin(&self, value: f64, magnitude: f64) -> Option<usize> {
        let place = |x: f64, span: f64, bins: usize| {
            let t = if span > 0.0 { x / span } else { 0.0 };
            (0.0..=1.0).contains(&t).then(|| ((t * bins as f64) as usize).min(bins - 1))
        };
        let column = place(value - self.range.0, self.range.1 - self.range.0, self.bins[0])?;
        Some(place(magnitude, self.steepest, self.bins[1])? * self.bins[0] + column)
    }
}

/// Value and gradient magnitude of voxels spread evenly over a volume, the missing ones left out.
struct Samples<'a> {
    volume: &'a GridVolume,
}

impl LatticeVisitor for Samples<'_> {
    type Output = Vec<(f32, f32)>;

    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> Vec<(f32, f32)> {
        let [nx, ny, nz] = lattice.dims;
        let stride = (1..).find(|s| nx.div_ceil(*s) * ny.div_ceil(*s) * nz.div_ceil(*s) <= MAX_VOXELS).unwrap_or(1);
        let (calibration, placement) = (self.volume.calibration(), self.volume.placement());
        let mut samples = Vec::new();
        for z in (0..nz).step_by(stride) {
            for y in (0..ny).step_by(stride) {
                for x in (0..nx).step_by(stride) {
                    // The lattice has a neighbour's value in the place of a missing one.
                    let index = (z * ny + y) * nx + x;
                    if with_grid!(self.volume.values(), grid => grid.samples()[index].to_f32().is_nan()) {
                        continue;
                    }
                    let value = calibration.value(lattice.at::<f64>(x, y, z));
                    let gradient: [f64; 3] = gradient_at_sample(&lattice, [x, y, z]);
                    let world = placement.gradient_to_world((gradient.map(|g| g * calibration.slope)).into());
                    let magnitude = world.length();
                    if value.is_finite() && magnitude.is_finite() {
                        samples.push((value as f32, magnitude as f32));
                    }
                }
            }
        }
        samples
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{Calibration, Placement, UniformGrid, Volume};

    fn grid(samples: Vec<f32>) -> Volume {
        let placement = Placement::from_spacing([1.0, 2.0, 1.0]).unwrap();
        let calibration = Calibration { slope: -2.0, intercept: 1.0 };
        UniformGrid::new([4, 2, 2], samples, placement, calibration).unwrap().into()
    }

    #[test]
    fn a_ramp_has_one_magnitude_and_all_values() {
        let volume = grid((0..16).map(|i| (i % 4) as f32).collect());
        let joint = JointHistogram::of(volume.grid().unwrap(), [4, 4]).unwrap();
        assert_eq!((joint.range, joint.steepest), ((-5.0, 1.0), 2.0));
        assert_eq!([-5.0, -3.0, -1.0, 1.0].map(|v| joint.count(v, 2.0)), [4; 4]);
        assert_eq!((joint.count(0.0, 0.5), joint.count(0.0, 9.0), joint.largest()), (0, 0, 4));
    }

    #[test]
    fn constants_and_holes_are_counted_too() {
        let joint = JointHistogram::of(grid(vec![3.0; 16]).grid().unwrap(), [8, 8]).unwrap();
        assert_eq!((joint.steepest, joint.count(-5.0, 0.0)), (0.0, 16));
        let mut samples = vec![3.0; 16];
        samples[5] = f32::NAN;
        let joint = JointHistogram::of(grid(samples).grid().unwrap(), [8, 8]).unwrap();
        assert_eq!(joint.count(-5.0, 0.0), 15, "a hole has no value; beside it the gradient is that of the others");
        assert_eq!(JointHistogram::of(grid(vec![f32::NAN; 16]).grid().unwrap(), [8, 8]), None);
    }
}
