//! Values of a volume of any kind at places in the world.

use glam::DVec3;
use vr_core::filter::Reconstruction;
use vr_core::{GridVolume, Sampler, SamplerVisitor, Volume, Voxel};

/// Part of the index range by which rounding may carry a place past a face of a grid.
const ROUNDING: f64 = 1e-9;

/// Fills the values at world positions, NaN in vacuum: those of the grid's filter, or of the field.
///
/// # Panics
/// May panic if the lists are not of one length.
pub fn fill_values(volume: &Volume, at: &[DVec3], out: &mut [f64]) {
    match (volume.value_grid(), volume.field()) {
        (Some(grid), _) => grid.with_sampler(AtPlaces { grid, at, out }),
        (None, Some(field)) => field.values(at, out),
        (None, None) => out.fill(f64::NAN),
    }
}

/// The value at a world position; `None` in vacuum.
pub fn value_at(volume: &Volume, at: DVec3) -> Option<f64> {
    let mut value = [f64::NAN];
    fill_values(volume, &[at], &mut value);
    Some(value[0]).filter(|value| !value.is_nan())
}

/// Places in the world where the sampler of a grid is asked.
struct AtPlaces<'a> {
    grid: &'a GridVolume,
    at: &'a [DVec3],
    out: &'a mut [f64],
}

impl SamplerVisitor for AtPlaces<'_> {
    type Output = ();

    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) {
        let (placement, calibration) = (self.grid.placement(), self.grid.calibration());
        let last = DVec3::from_array(self.grid.dims().map(|n| (n - 1) as f64));
        for (value, &at) in self.out.iter_mut().zip(self.at) {
            let index = placement.to_index(at);
            let inside = index.clamp(DVec3::ZERO, last);
            let is_inside = (index - inside).abs().max_element() <= ROUNDING * last.max_element().max(1.0);
            *value = if is_inside { calibration.value(sampler.value(inside.to_array())) } else { f64::NAN };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat3;
    use vr_core::field::FunctionField;
    use vr_core::{Calibration, Filter, Placement, UniformGrid};

    #[test]
    fn values_are_those_of_the_grid_and_of_the_field() {
        // A plane is reproduced by the filter, whatever the spacing, the direction and the calibration.
        let direction = DMat3::from_rotation_z(0.4);
        let placement = Placement::oriented(DVec3::new(1.0, -2.0, 0.5), [0.5, 2.0, 3.0], direction).unwrap();
        let voxels: Vec<f32> =
            (0..4 * 3 * 5).map(|i| (i % 4) as f32 + 10.0 * ((i / 4) % 3) as f32 - (i / 12) as f32).collect();
        let calibration = Calibration { slope: 2.0, intercept: 7.0 };
        let grid = UniformGrid::new([4, 3, 5], voxels, placement, calibration).unwrap();
        let volume = Volume::Grid(std::sync::Arc::new(GridVolume::new(grid.into(), Filter::Trilinear)));
        let index = DVec3::new(1.25, 0.5, 3.75);
        let placement = volume.grid().unwrap().placement();
        let value = value_at(&volume, placement.to_world(index)).unwrap();
        assert!((value - (2.0 * (1.25 + 5.0 - 3.75) + 7.0)).abs() < 1e-12, "{value}");
        // Corners are inside, in spite of rounding; half a voxel further is vacuum.
        for corner in [DVec3::ZERO, DVec3::new(3.0, 2.0, 4.0)] {
            assert!(value_at(&volume, placement.to_world(corner)).is_some());
        }
        assert_eq!(value_at(&volume, placement.to_world(DVec3::new(3.5, 1.0, 1.0))), None);
        let field = FunctionField::new((DVec3::NEG_ONE, DVec3::ONE), |p| p.x * p.y).unwrap();
        let volume = Volume::from(field);
        assert_eq!(value_at(&volume, DVec3::new(0.5, 0.25, 0.9)), Some(0.125));
        assert_eq!(value_at(&volume, DVec3::new(0.5, 0.25, 1.1)), None);
    }
}
