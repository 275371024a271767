//! A grid of values between uneven planes.

use std::sync::{Arc, OnceLock};

use glam::{DMat3, DVec3};

use super::axis::Axis;
use super::bricks::Bricks;
use super::error::RectilinearError;
use crate::any_grid::AnyGrid;
use crate::derived::Derived;
use crate::filter::Filter;
use crate::grid::{Calibration, UniformGrid, sample_count};
use crate::grid_volume::GridVolume;
use crate::lazy::computed;
use crate::placement::Placement;
use crate::shading::GradientMethod;
use crate::volume::Volume;

/// Places of the values of a rectilinear grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Centering {
    /// At the points where planes meet: as many values along an axis as places.
    Points,
    /// In the middles of the cells between planes: one value less along an axis than places.
    Cells,
}

/// Values where axis-parallel planes at uneven distances meet, trilinear in each cell.
///
/// The volume fills the box from the first to the last value on each axis; outside is vacuum, and so is a cell with a missing value (NaN).
/// Values of cells lie in the middles of their cells, as those of uniform grids do.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::rectilinear::{Centering, RectilinearGrid};
/// use vr_core::{Field, Volume};
///
/// let axes = [vec![0.0, 1.0, 10.0], vec![0.0, 1.0], vec![2.0, 0.0]];
/// let values = (0..12u8).map(f32::from).collect();
/// let grid = RectilinearGrid::new(axes, values, Centering::Points)?;
/// assert_eq!(grid.dims(), [3, 2, 2]);
/// // The last axis fell: it is turned round, and its values with it.
/// assert_eq!(grid.value(DVec3::new(5.5, 0.0, 0.0)), Some(7.5));
/// assert_eq!(grid.value(DVec3::new(5.5, 0.0, 2.0)), Some(1.5));
/// assert_eq!(Volume::from(grid).kind(), "rectilinear grid");
/// # Ok::<(), vr_core::rectilinear::RectilinearError>(())
/// ```
#[derive(Clone, Debug)]
pub struct RectilinearGrid {
    axes: Arc<[Axis; 3]>,
    /// The values in index space, trilinear.
    lattice: GridVolume,
    /// The box from the first to the last value, as a grid of one cell.
    extent: Placement,
    gradient: GradientMethod,
    bricks: Arc<OnceLock<Bricks>>,
}

impl RectilinearGrid {
    /// A grid of values, x fastest, where NaN is a missing one, over the places of three axes. An axis that falls is turned round, with its
    /// values.
    ///
    /// # Errors
    /// [`RectilinearError`] for an axis with too few places, one that is not finite, that does not rise or fall all the way, or whose steps are
    /// beyond what arithmetic can keep; for values that do not fill the grid.
    pub fn new(axes: [Vec<f64>; 3], mut values: Vec<f32>, centering: Centering) -> Result<Self, RectilinearError> {
        let least = if centering == Centering::Points { 2 } else { 3 };
        let mut falls = [false; 3];
        for (axis, places) in axes.iter().enumerate() {
            if places.len() < least {
                return Err(RectilinearError::Places { axis, found: places.len(), least });
            }
            falls[axis] = check_order(axis, places)?;
        }
        let dims = axes.each_ref().map(|places| places.len() + 2 - least);
        let expected = sample_count(dims)?;
        if values.len() != expected {
            return Err(RectilinearError::Length { dims, expected, found: values.len() });
        }
        for axis in (0..3).filter(|&a| falls[a]) {
            turn_round(&mut values, dims, axis);
        }
        let mut made = Vec::with_capacity(3);
        for (axis, mut places) in axes.into_iter().enumerate() {
            if falls[axis] {
                places.reverse();
            }
            if centering == Centering::Cells {
                places = places.windows(2).map(|pair| 0.5 * pair[0] + 0.5 * pair[1]).collect();
            }
            made.push(Axis::new(places, axis)?);
        }
        let axes: [Axis; 3] = made.try_into().expect("three were made");
        let [low, high] = corners(&axes);
        let extent = Placement::new(low, DMat3::from_diagonal(high - low))?;
        let placement = Placement::from_spacing([1.0; 3])?;
        let lattice = UniformGrid::new(dims, values, placement, Calibration::default())?;
        let lattice = GridVolume::new(lattice.into(), Filter::Trilinear);
        Ok(Self { axes: Arc::new(axes), lattice, extent, gradient: GradientMethod::default(), bricks: Arc::default() })
    }

    /// The same with another source of the gradient.
    #[must_use]
    pub fn with_gradient(self, gradient: GradientMethod) -> Self {
        Self { gradient, ..self }
    }

    /// Source of the gradient.
    pub fn gradient_method(&self) -> GradientMethod {
        self.gradient
    }

    /// The axes; their places are those of the values.
    pub fn axes(&self) -> &[Axis; 3] {
        &self.axes
    }

    /// The values in index space: a uniform grid of spacing 1 under the trilinear filter.
    pub fn lattice(&self) -> &GridVolume {
        &self.lattice
    }

    /// Values along x, y and z.
    pub fn dims(&self) -> [usize; 3] {
        self.lattice.dims()
    }

    /// Lower and upper corner of the box from the first to the last value.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let [low, high] = corners(&self.axes);
        (low, high)
    }

    /// Smallest and largest finite value; `None` if there is none.
    pub fn value_range(&self) -> Option<(f64, f64)> {
        self.lattice.value_range()
    }

    /// Mean of the mean steps of the axes, in world units.
    pub fn mean_spacing(&self) -> f64 {
        self.axes.iter().map(Axis::mean_step).sum::<f64>() / 3.0
    }

    /// Bricks of cells, and segments of the axes; made at the first call.
    pub fn bricks(&self) -> &Bricks {
        computed(&self.bricks, || Bricks::new(&self.axes, &self.lattice))
    }

    /// Stored numbers, x fastest, with missing ones replaced: those of cells that are vacuum mean nothing.
    pub fn stored(&self) -> &[f32] {
        self.lattice.filled_floats().expect("the values of a rectilinear grid are floats")
    }

    /// Structures that others derive from the grid and keep with it.
    pub fn derived(&self) -> &Derived {
        self.lattice.derived()
    }

    /// True if both are the same values, in memory, on the same axes, with the same gradients.
    pub fn same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.axes, &other.axes) && self.lattice.same(&other.lattice) && self.gradient == other.gradient
    }

    /// The uniform grid of the same values, if all axes are even to within a millionth of a step.
    pub fn to_uniform(&self) -> Option<GridVolume> {
        if !self.axes.iter().all(Axis::is_even) {
            return None;
        }
        let steps = DVec3::from_array(self.axes.each_ref().map(Axis::mean_step));
        let placement = Placement::new(self.bounds().0, DMat3::from_diagonal(steps)).ok()?;
        let AnyGrid::F32(grid) = self.lattice.values() else { return None };
        Some(GridVolume::new(grid.clone().with_placement(placement).into(), Filter::Trilinear))
    }

    /// The volume: a uniform grid if all axes are even, which faster renderers draw, and otherwise the rectilinear one.
    pub fn into_volume(self) -> Volume {
        self.to_uniform().map_or_else(|| Volume::Rectilinear(Arc::new(self)), |grid| Volume::Grid(Arc::new(grid)))
    }

    /// Fractional indices of a world position; `None` outside of the box.
    #[inline]
    pub fn to_index(&self, at: DVec3) -> Option<DVec3> {
        let mut index = [0.0; 3];
        for a in 0..3 {
            let [low, high] = self.axes[a].ends();
            let clamped = at[a].clamp(low, high);
            // Beyond a face of the box by rounding is still in it.
            let beyond = (at[a] - clamped).abs();
            if beyond.is_nan() || beyond > 1e-9 * (high - low) {
                return None;
            }
            index[a] = self.axes[a].to_index(clamped);
        }
        Some(index.into())
    }

    /// The box from the first to the last value, as the placement of a grid of one cell.
    pub(super) fn extent(&self) -> &Placement {
        &self.extent
    }
}

fn corners(axes: &[Axis; 3]) -> [DVec3; 2] {
    let ends = axes.each_ref().map(Axis::ends);
    [0, 1].map(|side| DVec3::from_array(ends.map(|e| e[side])))
}

/// True if an axis falls; an error if it goes neither way.
fn check_order(axis: usize, places: &[f64]) -> Result<bool, RectilinearError> {
    if let Some(place) = places.iter().position(|p| !p.is_finite()) {
        return Err(RectilinearError::NotFinite { axis, place, found: places[place] });
    }
    let ascending = places[0] < places[1];
    let wrong = |pair: &[f64]| if ascending { pair[0] >= pair[1] } else { pair[0] <= pair[1] };
    match places.windows(2).position(wrong) {
        None => Ok(!ascending),
        Some(k) => Err(RectilinearError::Order { axis, place: k + 1, found: [places[k], places[k + 1]], ascending }),
    }
}

/// Reverses the order of values along an axis.
fn turn_round(values: &mut [f32], dims: [usize; 3], axis: usize) {
    let step: usize = dims[..axis].iter().product();
    for block in values.chunks_mut(step * dims[axis]) {
        for k in 0..dims[axis] / 2 {
            let (low, high) = block.split_at_mut((dims[axis] - 1 - k) * step);
            low[k * step..(k + 1) * step].swap_with_slice(&mut high[..step]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Field;

    fn thirds() -> Vec<f64> {
        vec![0.0, 0.25, 1.0, 1.125]
    }

    #[test]
    fn bad_input_is_refused_in_words() {
        let new = |x: Vec<f64>, n: usize, c| {
            RectilinearGrid::new([x, vec![0.0, 1.0], vec![0.0, 1.0]], vec![0.0; n], c).unwrap_err().to_string()
        };
        assert!(new(vec![0.0], 4, Centering::Points).starts_with("axis 0: found 1 places; there must be 2 at least"));
        assert!(new(vec![0.0, 1.0], 0, Centering::Cells).starts_with("axis 0: found 2 places; there must be 3"));
        assert!(new(vec![0.0, f64::NAN], 8, Centering::Points).contains("place 1 is NaN"));
        assert!(new(vec![0.0, 2.0, 1.0], 12, Centering::Points).contains("place 2 is 1 after 2"));
        assert!(new(vec![0.0, 0.0], 8, Centering::Points).contains("place 1 is 0 after 0"));
        assert!(new(vec![0.0, 1e-30], 8, Centering::Points).contains("the step after place 0"));
        assert!(new(vec![1e14, 1e14 + 1.0], 8, Centering::Points).contains("at most 1e12 steps"));
        assert!(new(vec![0.0, 1.0], 7, Centering::Points).contains("found 7 values, must be 8"));
    }

    #[test]
    fn falling_axes_are_turned_with_their_values() {
        let f = |p: [f64; 3]| (p[0] + 10.0 * p[1] + 100.0 * p[2]) as f32;
        let rising = [thirds(), vec![1.0, 2.0, 4.0], vec![-1.0, 0.5]];
        for turned in 0..8 {
            let mut axes = rising.clone();
            (0..3).filter(|a| turned >> a & 1 == 1).for_each(|a| axes[a].reverse());
            let mut values = Vec::new();
            for &z in &axes[2] {
                for &y in &axes[1] {
                    values.extend(axes[0].iter().map(|&x| f([x, y, z])));
                }
            }
            let grid = RectilinearGrid::new(axes, values, Centering::Points).unwrap();
            let at = [0.7, 3.1, 0.2];
            assert!((grid.value(at.into()).unwrap() - f64::from(f(at))).abs() < 1e-4, "{turned}");
        }
    }

    #[test]
    fn values_of_cells_lie_in_their_middles() {
        let axes = [vec![0.0, 1.0, 4.0], vec![0.0, 2.0, 4.0], vec![0.0, 2.0, 4.0]];
        let grid = RectilinearGrid::new(axes, vec![1.0; 8], Centering::Cells).unwrap();
        assert_eq!(grid.axes()[0].places(), [0.5, 2.5]);
        assert_eq!(grid.bounds(), (DVec3::new(0.5, 1.0, 1.0), DVec3::new(2.5, 3.0, 3.0)));
    }

    #[test]
    fn even_axes_make_a_uniform_grid() {
        let even = |n: usize, step: f64| (0..n).map(|k| 1.0 + k as f64 * step).collect::<Vec<_>>();
        let axes = [even(3, 0.1), even(2, 2.0), even(2, 1.0)];
        let values: Vec<f32> = (0..12u8).map(f32::from).collect();
        let grid = RectilinearGrid::new(axes, values.clone(), Centering::Points).unwrap();
        let volume = grid.into_volume();
        let uniform = volume.grid().expect("it is even");
        assert_eq!((uniform.dims(), uniform.value_range()), ([3, 2, 2], Some((0.0, 11.0))));
        assert!((uniform.placement().spacing() - DVec3::new(0.1, 2.0, 1.0)).length() < 1e-15);
        let uneven = [vec![0.0, 0.1, 0.3], even(2, 2.0), even(2, 1.0)];
        let grid = RectilinearGrid::new(uneven, values, Centering::Points).unwrap();
        assert!(grid.into_volume().rectilinear().is_some());
    }
}
