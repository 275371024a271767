//! Uniform grid whose voxels have a value and a colour of their own.

mod components;

pub use components::ColorValue;

use std::sync::Arc;

use crate::error::GridError;
use crate::filter::{Filter, Lattice, Nearest, Reconstruction, Trilinear};
use crate::grid::sample_count;
use crate::grid_volume::GridVolume;
use crate::real::Real;

/// Values on a uniform grid, and a colour at each voxel: an RGB or RGBA image in three dimensions.
///
/// The value decides how opaque a place is, as in any grid. The colour of the place multiplies the colour (or the emission) that the transfer
/// function gives the value, before light is reflected: under a white transfer function the volume is drawn as it is. Where an
/// operator picks one value of a ray, the colour is that of the place where it was picked; an average has the mean colour of the ray.
///
/// Colours are linear light between 0 and 1. Between voxels they are interpolated in linear light: from the nearest voxel where the values'
/// filter is the nearest one, trilinearly under all others, so that they never leave that range.
///
/// # Examples
/// ```
/// use vr_core::{ColorGrid, Placement};
///
/// // Two slices: red, and blue.
/// let voxels: Vec<u8> = [[255, 0, 0]; 4].into_iter().chain([[0, 0, 255]; 4]).flatten().collect();
/// let colors = ColorGrid::from_components([2; 3], &voxels, 3, Placement::from_spacing([1.0; 3])?)?;
/// assert_eq!(colors.color([0.5, 0.5, 0.0]), [1.0, 0.0, 0.0]);
/// assert_eq!(colors.color([0.5, 0.5, 0.5]), [0.5, 0.0, 0.5], "of light, not of sRGB");
/// # Ok::<(), vr_core::GridError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ColorGrid {
    values: Arc<GridVolume>,
    channels: Arc<[Vec<u16>; 3]>,
    value: ColorValue,
}

impl ColorGrid {
    /// Stored number of full light.
    pub const WHITE: u16 = u16::MAX;

    /// Values, and for each voxel the linear light of red, green and blue, of which [`WHITE`](Self::WHITE) is all.
    ///
    /// # Errors
    /// [`GridError::Length`] where a channel does not have one number for each voxel.
    pub fn new(values: GridVolume, channels: [Vec<u16>; 3]) -> Result<Self, GridError> {
        let dims = values.dims();
        let expected = sample_count(dims)?;
        match channels.iter().find(|channel| channel.len() != expected) {
            Some(wrong) => Err(GridError::Length { dims, expected, found: wrong.len() }),
            None => Ok(Self { values: Arc::new(values), channels: Arc::new(channels), value: ColorValue::OfItsOwn }),
        }
    }

    /// The values, under the volume's filter.
    pub fn values(&self) -> &Arc<GridVolume> {
        &self.values
    }

    /// Source of the values.
    pub fn value_source(&self) -> ColorValue {
        self.value
    }

    /// The same values and colours under another filter.
    #[must_use]
    pub fn with_filter(&self, filter: Filter) -> Self {
        Self { values: Arc::new(self.values.with_filter(filter)), ..self.clone() }
    }

    /// The filter between the voxels' colours.
    pub fn color_filter(&self) -> Filter {
        match self.values.filter() {
            Filter::Nearest => Filter::Nearest,
            _ => Filter::Trilinear,
        }
    }

    /// Stored light of red, green and blue.
    pub fn channels(&self) -> [Lattice<'_, u16>; 3] {
        self.channels.each_ref().map(|samples| Lattice { samples, dims: self.values.dims() })
    }

    /// The colour at an index-space position inside the box.
    #[inline]
    pub fn color<R: Real>(&self, position: [R; 3]) -> [R; 3] {
        let share = R::from_f64(1.0 / f64::from(Self::WHITE));
        let nearest = self.values.filter() == Filter::Nearest;
        self.channels().map(|channel| {
            let stored =
                if nearest { Nearest::value(&channel, position) } else { Trilinear::value(&channel, position) };
            stored * share
        })
    }

    /// Memory of values and colours in bytes.
    pub fn sample_bytes(&self) -> usize {
        self.values.sample_bytes() + self.channels.iter().map(|channel| size_of_val(&channel[..])).sum::<usize>()
    }

    /// True if both are the same values and colours, in memory, under the same filter.
    pub fn same(&self, other: &Self) -> bool {
        self.values.same(&other.values) && Arc::ptr_eq(&self.channels, &other.channels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Calibration, Placement, UniformGrid};

    #[test]
    fn channels_must_fill_the_grid() {
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let grid = UniformGrid::new([2; 3], vec![1u8; 8], placement, Calibration::default()).unwrap();
        let values = GridVolume::new(grid.into(), Filter::Trilinear);
        let wrong = ColorGrid::new(values, [vec![0; 8], vec![0; 7], vec![0; 8]]);
        assert!(matches!(wrong, Err(GridError::Length { expected: 8, found: 7, .. })));
    }

    #[test]
    fn colours_follow_the_filter_and_stay_in_range() {
        let voxels: Vec<u8> = (0..8u8).flat_map(|i| if i % 2 == 0 { [0, 255, 255] } else { [255, 0, 0] }).collect();
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let grid = ColorGrid::from_components([2; 3], &voxels, 3, placement).unwrap();
        assert_eq!(grid.color([0.25f64, 0.0, 0.0]), [0.25, 0.75, 0.75]);
        for filter in Filter::ALL {
            let grid = grid.with_filter(filter);
            let red = grid.color([0.25f64, 0.0, 0.0])[0];
            assert_eq!(red, if filter == Filter::Nearest { 0.0 } else { 0.25 }, "{filter}");
        }
        assert!(grid.same(&grid.with_filter(Filter::Nearest).with_filter(Filter::Trilinear)));
        assert_eq!(grid.sample_bytes(), 8 * 7);
    }
}
