//! Scattered points: a volume without a grid.

use std::sync::{Arc, OnceLock};

use glam::DVec3;

use crate::box_tree::{Bounds, BoxTree};
use crate::derived::Derived;
use crate::error::PointError;
use crate::limits::MAX_COORDINATE;
use crate::point_kernel::PointKernel;
use crate::point_mixing::PointMixing;

/// Points that each carry a value, spread around them by a kernel.
///
/// The field is f(x) = Σ wₖ vₖ W(|x − xₖ| / Rₖ) / Rₖ³ over all points k, in world units; where no support reaches, there is vacuum.
/// Its gradient, by which it is shaded, is the sum of the kernels' own: Σ wₖ vₖ W'(|x − xₖ| / Rₖ) (x − xₖ) / (|x − xₖ| Rₖ⁴).
///
/// With wₖ = the volume that a point stands for (its mass by its density) this is the interpolation of smoothed particle hydrodynamics:
/// f follows the values. With wₖ = its mass and all vₖ = 1 it is the density. [`PointSet::with_mixing`] divides the sum by that of the weights.
///
/// Points may have colours besides ([`PointSet::with_colors`]), by which the transfer function's is multiplied.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::{PointKernel, PointSet, Volume};
///
/// let positions = vec![DVec3::ZERO, DVec3::new(3.0, 0.0, 0.0)];
/// let points = PointSet::new(positions, vec![1.0; 2], vec![1.0; 2], vec![2.0, 5.0], PointKernel::CubicSpline)?;
/// assert_eq!(points.field(DVec3::ZERO), Some(2.0 * PointKernel::CubicSpline.at(0.0)));
/// assert_eq!(points.field(DVec3::new(1.5, 0.0, 0.0)), None, "vacuum between the supports");
/// assert_eq!(Volume::from(points).bounds(), (DVec3::NEG_ONE, DVec3::new(4.0, 1.0, 1.0)));
/// # Ok::<(), vr_core::PointError>(())
/// ```
#[derive(Clone, Debug)]
pub struct PointSet {
    positions: Vec<DVec3>,
    radii: Vec<f32>,
    weights: Vec<f32>,
    values: Vec<f32>,
    kernel: PointKernel,
    mixing: PointMixing,
    colors: Option<Vec<[f32; 3]>>,
    bounds: (DVec3, DVec3),
    /// Tree of the supports, made when first asked for, then kept.
    index: OnceLock<BoxTree>,
    range: OnceLock<(f64, f64)>,
    derived: Arc<Derived>,
}

impl PointSet {
    /// Points at world positions: `radii` are those of their kernels, in world units; `weights` and `values` are w and v above.
    ///
    /// # Errors
    /// [`PointError`] for no point, lists of different lengths, a position that is not finite or beyond 10³⁰, a radius that is not positive or
    /// beyond 10⁻³⁰ to 10³⁰, a weight or value that is not finite.
    pub fn new(
        positions: Vec<DVec3>,
        radii: Vec<f32>,
        weights: Vec<f32>,
        values: Vec<f32>,
        kernel: PointKernel,
    ) -> Result<Self, PointError> {
        if positions.is_empty() {
            return Err(PointError::Empty);
        }
        if u32::try_from(positions.len()).is_err() {
            return Err(PointError::TooMany { found: positions.len() });
        }
        for (what, found) in [("radii", radii.len()), ("weights", weights.len()), ("values", values.len())] {
            if found != positions.len() {
                return Err(PointError::Length { what, found, points: positions.len() });
            }
        }
        if let Some(point) = positions.iter().position(|p| !p.abs().cmplt(DVec3::splat(MAX_COORDINATE)).all()) {
            return Err(PointError::Position { point, found: positions[point].to_array() });
        }
        if let Some(point) = radii.iter().position(|&r| !(r > 1e-30 && r < 1e30)) {
            return Err(PointError::Radius { point, found: radii[point] });
        }
        for (what, numbers) in [("weight", &weights), ("value", &values)] {
            if let Some(point) = numbers.iter().position(|v| !v.is_finite()) {
                return Err(PointError::Number { what, point, found: numbers[point] });
            }
        }
        let reach = |k: usize| DVec3::splat(f64::from(radii[k]));
        let low = (0..positions.len()).map(|k| positions[k] - reach(k)).reduce(DVec3::min);
        let high = (0..positions.len()).map(|k| positions[k] + reach(k)).reduce(DVec3::max);
        let bounds = (low.unwrap_or_default(), high.unwrap_or_default());
        let (index, range, derived) = (OnceLock::new(), OnceLock::new(), Arc::default());
        let (mixing, colors) = (PointMixing::default(), None);
        Ok(Self { positions, radii, weights, values, kernel, mixing, colors, bounds, index, range, derived })
    }

    /// The same points, whose values are mixed like this where supports overlap.
    ///
    /// # Errors
    /// [`PointError::Weight`] for a mean by weights that are not all positive.
    pub fn with_mixing(self, mixing: PointMixing) -> Result<Self, PointError> {
        if mixing == PointMixing::Mean {
            self.check_weights()?;
        }
        Ok(Self { mixing, range: OnceLock::new(), derived: Arc::default(), ..self })
    }

    /// The same points with a colour each, in linear light, by which that of the transfer function is multiplied. Where supports overlap, colours are
    /// mixed by their weighted mean, Σ wₖ cₖ Wₖ / Σ wₖ Wₖ, however values are.
    ///
    /// # Errors
    /// [`PointError`] for a list of another length than the points, a colour beyond 0 and 1, weights that are not all positive.
    pub fn with_colors(self, colors: Vec<[f32; 3]>) -> Result<Self, PointError> {
        if colors.len() != self.count() {
            return Err(PointError::Length { what: "colours", found: colors.len(), points: self.count() });
        }
        let is_light = |color: &[f32; 3]| color.iter().all(|c| (0.0..=1.0).contains(c));
        if let Some(point) = colors.iter().position(|color| !is_light(color)) {
            return Err(PointError::Color { point, found: colors[point] });
        }
        self.check_weights()?;
        Ok(Self { colors: Some(colors), derived: Arc::default(), ..self })
    }

    fn check_weights(&self) -> Result<(), PointError> {
        match self.weights.iter().position(|&w| w <= 0.0) {
            Some(point) => Err(PointError::Weight { point, found: self.weights[point] }),
            None => Ok(()),
        }
    }

    /// Number of points; at least one.
    pub fn count(&self) -> usize {
        self.positions.len()
    }

    /// World positions.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// The radius of each point's kernel, in world units.
    pub fn radii(&self) -> &[f32] {
        &self.radii
    }

    /// The weight of each.
    pub fn weights(&self) -> &[f32] {
        &self.weights
    }

    /// The value of each.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// The kernel that spreads each.
    pub fn kernel(&self) -> PointKernel {
        self.kernel
    }

    /// Combination of the values where supports overlap.
    pub fn mixing(&self) -> PointMixing {
        self.mixing
    }

    /// The colour of each in linear light, where they have any.
    pub fn colors(&self) -> Option<&[[f32; 3]]> {
        self.colors.as_deref()
    }

    /// Opposite corners of the smallest axis-parallel box around all supports.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.bounds
    }

    /// Index of the supports.
    pub(crate) fn index(&self) -> &BoxTree {
        self.index.get_or_init(|| {
            let radius = |k: usize| f64::from(self.radii[k]);
            let around = |k: usize| {
                let (at, reach) = (self.positions[k], DVec3::splat(radius(k)));
                Bounds { low: at - reach, high: at + reach }
            };
            BoxTree::new(self.positions.len(), self.bounds, |k| (self.positions[k], radius(k)), around)
        })
    }

    /// The range of the field, once it is known.
    pub(crate) fn range(&self) -> &OnceLock<(f64, f64)> {
        &self.range
    }

    /// Structures that others derive from the points and keep with them.
    pub fn derived(&self) -> &Derived {
        &self.derived
    }

    /// Makes the structures that queries of the field need beyond the points, so that the first frame does not pay for them.
    pub fn prepare_derived(&self) {
        self.index();
    }

    /// Half the mean radius: in smoothed particle hydrodynamics about the distance between points.
    pub fn mean_spacing(&self) -> f64 {
        0.5 * self.radii.iter().map(|&r| f64::from(r)).sum::<f64>() / self.count() as f64
    }

    /// Contribution of point k to the sum of values at a world position.
    pub fn contribution(&self, k: usize, at: DVec3) -> f64 {
        self.amplitude(k) * self.kernel_at(k, at)
    }

    /// Gradient per world unit of the contribution of point k at a world position; 0 in the middle of a cone, which has none there.
    pub fn contributed_gradient(&self, k: usize, at: DVec3) -> DVec3 {
        self.kernel_gradient(k, at) * self.amplitude(k)
    }

    /// W of point k at a world position.
    pub(crate) fn kernel_at(&self, k: usize, at: DVec3) -> f64 {
        self.kernel.at(at.distance(self.positions[k]) / f64::from(self.radii[k]))
    }

    /// Gradient of that per world unit.
    pub(crate) fn kernel_gradient(&self, k: usize, at: DVec3) -> DVec3 {
        let radius = f64::from(self.radii[k]);
        let from = (at - self.positions[k]) / radius;
        from * (self.kernel.slope_by_distance(from.length()) / radius)
    }

    /// wₖ vₖ / Rₖ³.
    pub fn amplitude(&self, k: usize) -> f64 {
        let radius = f64::from(self.radii[k]);
        f64::from(self.weights[k]) * f64::from(self.values[k]) / (radius * radius * radius)
    }

    /// wₖ / Rₖ³.
    pub fn weight_density(&self, k: usize) -> f64 {
        let radius = f64::from(self.radii[k]);
        f64::from(self.weights[k]) / (radius * radius * radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(positions: &[[f64; 3]], radii: &[f32], values: &[f32]) -> Result<PointSet, PointError> {
        let positions: Vec<DVec3> = positions.iter().map(|&p| p.into()).collect();
        PointSet::new(positions, radii.to_vec(), vec![1.0; values.len()], values.to_vec(), PointKernel::default())
    }

    #[test]
    fn bounds_hold_all_supports() {
        let points = set(&[[0.0; 3], [4.0, 0.0, -2.0]], &[1.0, 0.5], &[1.0, 2.0]).unwrap();
        assert_eq!(points.bounds(), (DVec3::new(-1.0, -1.0, -2.5), DVec3::new(4.5, 1.0, 1.0)));
        assert_eq!(points.mean_spacing(), 0.375);
    }

    #[test]
    fn a_point_adds_what_its_kernel_says() {
        let points = set(&[[1.0, 2.0, 3.0]], &[2.0], &[5.0]).unwrap();
        assert_eq!(points.contribution(0, DVec3::new(1.0, 2.0, 3.0)), 5.0 / 8.0 * PointKernel::CubicSpline.at(0.0));
        assert_eq!(points.contribution(0, DVec3::new(3.0, 2.0, 3.0)), 0.0);
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let none = PointSet::new(vec![], vec![], vec![], vec![], PointKernel::default());
        assert_eq!(none.unwrap_err(), PointError::Empty);
        for radius in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(matches!(set(&[[0.0; 3]], &[radius], &[1.0]), Err(PointError::Radius { point: 0, .. })));
        }
        for x in [f64::NAN, f64::INFINITY, 1e30] {
            assert!(matches!(set(&[[0.0, x, 0.0]], &[1.0], &[1.0]), Err(PointError::Position { .. })));
        }
        assert!(matches!(set(&[[0.0; 3]], &[1.0], &[f32::NAN]), Err(PointError::Number { what: "value", .. })));
        assert!(matches!(set(&[[0.0; 3]], &[1.0, 1.0], &[1.0]), Err(PointError::Length { what: "radii", .. })));
        let weighing = |weight: f32| {
            PointSet::new(vec![DVec3::ZERO], vec![1.0], vec![weight], vec![1.0], PointKernel::default()).unwrap()
        };
        for weight in [0.0, -1.0] {
            let refused = Err(PointError::Weight { point: 0, found: weight });
            assert_eq!(weighing(weight).with_mixing(PointMixing::Mean).map(|_| ()), refused);
            assert_eq!(weighing(weight).with_colors(vec![[1.0; 3]]).map(|_| ()), refused);
            assert!(weighing(weight).with_mixing(PointMixing::Sum).is_ok());
        }
        assert!(matches!(weighing(1.0).with_colors(vec![]), Err(PointError::Length { what: "colours", .. })));
        for light in [-0.1, 1.1, f32::NAN] {
            let found = weighing(1.0).with_colors(vec![[0.0, light, 0.0]]);
            assert!(matches!(found, Err(PointError::Color { point: 0, .. })), "{light}");
        }
    }
}
