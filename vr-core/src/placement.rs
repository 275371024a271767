//! Placement of a grid in the world: an affine map from index to world.

use glam::{DMat3, DVec3};

use crate::error::GridError;
use crate::limits::{MAX_STEPS_AWAY, is_length};

/// The affine placement of a grid: `world = origin + axes · index`.
///
/// The columns of `axes` are the world vectors from one voxel to the next along x, y and z, spacing folded in. Shear is
/// allowed; a singular matrix is not.
///
/// # Examples
/// ```
/// use glam::{DMat3, DVec3};
/// use vr_core::Placement;
///
/// let origin = DVec3::new(-10.0, 0.0, 5.0);
/// let placement = Placement::oriented(origin, [0.5, 0.5, 2.0], DMat3::IDENTITY)?;
/// let world = placement.to_world(DVec3::new(2.0, 4.0, 1.5));
/// assert_eq!(world, DVec3::new(-9.0, 2.0, 8.0));
/// assert_eq!(placement.to_index(world), DVec3::new(2.0, 4.0, 1.5));
/// assert!(Placement::from_spacing([1.0, 0.0, 1.0]).is_err());
/// # Ok::<(), vr_core::GridError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    origin: DVec3,
    axes: DMat3,
    inverse: DMat3,
}

impl Placement {
    /// A placement from the world position of voxel (0, 0, 0) and the three step vectors.
    ///
    /// # Errors
    /// [`GridError::Origin`] where the origin is not finite, or more than 10¹² of the shortest steps away; [`GridError::Spacing`] where a step
    /// is not finite, or shorter or longer than kernels in f32 can keep, 10⁻²⁴ to 10²⁴; [`GridError::Direction`] where the axes are (nearly)
    /// linearly dependent.
    pub fn new(origin: DVec3, axes: DMat3) -> Result<Self, GridError> {
        let misplaced = GridError::Origin { found: origin.to_array() };
        if !origin.is_finite() {
            return Err(misplaced);
        }
        let columns = [axes.x_axis, axes.y_axis, axes.z_axis];
        for (axis, column) in columns.iter().enumerate() {
            let length = column.length();
            if !is_length(length) {
                return Err(GridError::Spacing { axis, found: length });
            }
        }
        let smallest = columns.iter().map(|c| c.length()).fold(f64::INFINITY, f64::min);
        if origin.abs().max_element() > MAX_STEPS_AWAY * smallest {
            return Err(misplaced);
        }
        // The volume of the parallelepiped of the *unit* steps: 1 when orthogonal, 0 when flat, whatever the spacing.
        let unit = columns.map(DVec3::normalize);
        let skew = unit[0].dot(unit[1].cross(unit[2])).abs();
        if skew < 1e-9 || !skew.is_finite() {
            return Err(GridError::Direction { axes: columns.map(|c| c.to_array()) });
        }
        // Inverted per unit axes, then scaled, so that products of three small or large spacings neither underflow nor overflow.
        let inverse_unit = DMat3::from_cols(unit[0], unit[1], unit[2]).inverse();
        let scale = DVec3::from_array(columns.map(|c| 1.0 / c.length()));
        let inverse = DMat3::from_diagonal(scale) * inverse_unit;
        if !inverse.is_finite() {
            return Err(GridError::Direction { axes: columns.map(|c| c.to_array()) });
        }
        Ok(Self { origin, axes, inverse })
    }

    /// An axis-parallel placement, with voxel (0, 0, 0) at the world's origin.
    ///
    /// # Errors
    /// [`GridError::Spacing`] where a spacing is not 10⁻²⁴ to 10²⁴.
    pub fn from_spacing(spacing: [f64; 3]) -> Result<Self, GridError> {
        Self::oriented(DVec3::ZERO, spacing, DMat3::IDENTITY)
    }

    /// A placement from spacing (world units between voxels) and a direction matrix whose columns are the directions of the index axes;
    /// they are normalised here.
    ///
    /// # Errors
    /// Same as for [`Placement::new`].
    pub fn oriented(origin: DVec3, spacing: [f64; 3], direction: DMat3) -> Result<Self, GridError> {
        for (axis, &s) in spacing.iter().enumerate() {
            if !is_length(s) {
                return Err(GridError::Spacing { axis, found: s });
            }
        }
        let columns = [direction.x_axis, direction.y_axis, direction.z_axis];
        if columns.iter().any(|c| !(c.length() > 0.0 && c.is_finite())) {
            return Err(GridError::Direction { axes: columns.map(|c| c.to_array()) });
        }
        let d = columns.map(DVec3::normalize);
        Self::new(origin, DMat3::from_cols(d[0] * spacing[0], d[1] * spacing[1], d[2] * spacing[2]))
    }

    /// World position of voxel (0, 0, 0).
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// The matrix from index steps to world vectors.
    pub fn axes(&self) -> DMat3 {
        self.axes
    }

    /// The matrix from world vectors to index steps.
    pub fn inverse_axes(&self) -> DMat3 {
        self.inverse
    }

    /// World length of one step along each index axis.
    pub fn spacing(&self) -> DVec3 {
        DVec3::new(self.axes.x_axis.length(), self.axes.y_axis.length(), self.axes.z_axis.length())
    }

    /// World position of a (fractional) index.
    pub fn to_world(&self, index: DVec3) -> DVec3 {
        self.origin + self.axes * index
    }

    /// Fractional index of a world position.
    pub fn to_index(&self, world: DVec3) -> DVec3 {
        self.inverse * (world - self.origin)
    }

    /// Turns a gradient per index step into one per world unit (multiplication by the transposed inverse).
    pub fn gradient_to_world(&self, per_index: DVec3) -> DVec3 {
        self.inverse.transpose() * per_index
    }

    /// The matrix of [`Self::gradient_to_world`], for fields times `slope`, divided by a power of two, and that power: so that gradients of
    /// worlds of any size fit into f32, and no bit is lost.
    pub fn scaled_gradient_matrix(&self, slope: f64) -> (DMat3, f64) {
        let matrix = self.inverse.transpose() * DMat3::from_diagonal(DVec3::splat(slope));
        let largest = matrix.to_cols_array().into_iter().map(f64::abs).fold(0.0, f64::max);
        let scale = libm::exp2(libm::floor(libm::log2(largest)));
        (DMat3::from_cols_array(&matrix.to_cols_array().map(|x| x / scale)), scale)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn index_and_world_are_inverse_at_any_scale() {
        for scale in [1e-14, 1e-3, 1.0, 1e14] {
            let axes = DMat3::from_cols(
                DVec3::new(1.0, 0.1, 0.0) * scale,
                DVec3::new(-0.2, 2.0, 0.3) * scale,
                DVec3::new(0.0, 0.5, 5.0) * scale,
            );
            let p = Placement::new(DVec3::new(3.0, -1.0, 2.0) * scale, axes).unwrap();
            let i = DVec3::new(7.25, 3.5, 11.0);
            assert!((p.to_index(p.to_world(i)) - i).length() < 1e-12, "scale {scale}");
        }
    }

    #[test]
    fn scaled_gradients_lose_nothing() {
        for (spacing, slope) in [(1e-20, 1.0), (0.3, -2.5), (1e20, 1e10)] {
            let p = Placement::from_spacing([spacing, 2.0 * spacing, 3.0 * spacing]).unwrap();
            let (matrix, scale) = p.scaled_gradient_matrix(slope);
            let g = DVec3::new(1.0, -2.0, 0.5);
            let (got, want) = (matrix * g * scale, p.gradient_to_world(g * slope));
            assert!((got - want).length() <= 1e-15 * want.length(), "{spacing}: {got}, not {want}");
            let largest = matrix.to_cols_array().into_iter().fold(0.0f64, |m, x| m.max(x.abs()));
            assert!((1.0..2.0).contains(&largest), "{largest}");
        }
    }

    #[test]
    fn refuses_flat_axes_and_bad_spacing() {
        let flat = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::X + DVec3::Y);
        assert!(matches!(Placement::new(DVec3::ZERO, flat), Err(GridError::Direction { .. })));
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-46, 9e-25, 1.1e24, 1e200] {
            assert!(
                matches!(Placement::from_spacing([1.0, bad, 1.0]), Err(GridError::Spacing { axis: 1, .. })),
                "{bad}"
            );
        }
    }

    #[test]
    fn refuses_origins_where_positions_cannot_be_told_apart() {
        let at =
            |x: f64, spacing: f64| Placement::oriented(DVec3::new(0.0, x, 0.0), [1.0, spacing, 1.0], DMat3::IDENTITY);
        for (x, spacing) in [(1e6, 1e-3), (-1e6, 1e-3), (1e15, 1e3), (0.0, 1e-15), (1e-3, 1e-15)] {
            let placed = at(x, spacing);
            assert_eq!(placed.is_ok(), x.abs() <= 1e12 * spacing.min(1.0), "{x} {spacing}: {placed:?}");
        }
        let refused = at(1e13, 1.0).unwrap_err().to_string();
        assert!(refused.contains("10000000000000") && refused.contains("1e12 steps"), "{refused}");
    }
}
