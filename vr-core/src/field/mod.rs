//! Scalar fields: look-up of a volume at a point and along a ray.
//!
//! A kind of volume is described once, as a [`Field`]: its value and gradient at a point, and its course along a ray ([`FieldLine`]),
//! smooth between breakpoints and known there as a polynomial with a bound on its error. A renderer of fields draws every kind of volume,
//! also one of the caller's own; the reference and the plain engine of the ray caster are such. Grids have faster ways besides
//! ([`GridVolume::with_sampler`](crate::GridVolume::with_sampler)).
//!
//! [`FunctionField`] makes a field of any function; scattered points are one ([`PointSet`](crate::PointSet)).

mod chebyshev;
mod function;
mod function_line;
mod interpolated_cell;
mod kernel_shape;
mod kernel_slope;
mod line;
mod point_line;
mod point_mean;
mod point_sums;
mod point_supports;
mod points;
mod poly;
mod stretch;

pub use chebyshev::{Interpolation, LEBESGUE, interpolation};
pub use function::FunctionField;
pub use function_line::FunctionLine;
pub use interpolated_cell::InterpolatedCell;
pub use line::{Chord, Cut, FieldLine, LineColor, LineModel, distinct_places};
pub use point_line::PointLine;
pub use poly::{Bernstein, MAX_DEGREE, Poly, chebyshev_point};
pub use stretch::Stretch;

use std::fmt;

use glam::DVec3;

use crate::labels::LabelledGrid;
use crate::ray::Ray;
use crate::view::Clip;

/// A scalar field in the world, vacuum where it has no value.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::field::{Field, FunctionField};
/// use vr_core::{Clip, Ray};
///
/// let bounds = (DVec3::NEG_ONE, DVec3::ONE);
/// let field = FunctionField::new(bounds, |p| p.x * p.x)?;
/// assert_eq!(field.value(DVec3::new(0.5, 0.0, 0.0)), Some(0.25));
/// assert_eq!(field.value(2.0 * DVec3::X), None, "vacuum outside the box");
///
/// let ray = Ray { origin: -3.0 * DVec3::X, direction: DVec3::X };
/// let line = field.along(&ray, &Clip::default(), f64::INFINITY, false).expect("it meets the box");
/// assert!((line.chord().length() - 2.0).abs() < 1e-12);
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
pub trait Field: Send + Sync + fmt::Debug {
    /// Kind of volume in messages: `function`.
    fn kind(&self) -> &'static str;

    /// Lower and upper corner of a world box, outside of which is vacuum.
    fn bounds(&self) -> (DVec3, DVec3);

    /// World length in which steps are counted, and the default `unit_distance` of a transfer function: about the distance over which the
    /// field changes.
    fn spacing(&self) -> f64;

    /// Smallest and largest value, as far as they are known: for choosing transfer functions, not a bound.
    fn value_range(&self) -> Option<(f64, f64)>;

    /// The value at a world position; `None` in vacuum.
    fn value(&self, at: DVec3) -> Option<f64>;

    /// Fills the values at world positions, NaN in vacuum. Neighbours along a ray may share what is looked up.
    ///
    /// # Panics
    /// May panic if the lists are not of one length.
    fn values(&self, at: &[DVec3], out: &mut [f64]) {
        for (value, &at) in out.iter_mut().zip(at) {
            *value = self.value(at).unwrap_or(f64::NAN);
        }
    }

    /// True if the field has gradients, so that it can be shaded.
    fn has_gradient(&self) -> bool {
        false
    }

    /// The gradient per world unit at a world position; `None` in vacuum, and for a field that has none.
    fn gradient(&self, _at: DVec3) -> Option<DVec3> {
        None
    }

    /// True if places have colours, by which that of the transfer function is multiplied.
    fn has_colors(&self) -> bool {
        false
    }

    /// The colour of a world position, linear light between 0 and 1, by which that of the transfer function is multiplied; `None` in vacuum, and for a
    /// field that has none.
    fn color(&self, _at: DVec3) -> Option<[f64; 3]> {
        None
    }

    /// True if the values are codes, each with an entry of its own in the transfer function, that mean nothing beside each other: operators that
    /// compare or average values are refused then ([`Scene::validate`](crate::Scene::validate)).
    fn values_are_codes(&self) -> bool {
        false
    }

    /// Appends the world distances along a ray, between two and ascending, at which the value jumps: a renderer in steps ends one there. None by
    /// default.
    fn jumps(&self, _ray: &Ray, _part: [f64; 2], _out: &mut Vec<f64>) {}

    /// Appends the stretches of a ray between two world distances that are not vacuum, ascending, and returns true; false for a field that does not know
    /// them, and appends none. A renderer in steps takes them as long as each stretch allows, leaves out what cannot be seen, and ends one
    /// where vacuum begins.
    fn stretches(&self, _ray: &Ray, _part: [f64; 2], _out: &mut Vec<Stretch>) -> bool {
        false
    }

    /// The field along a ray, within the clip and up to the world distance `far`, with gradients if they are asked for; `None` where the ray
    /// does not meet the field there.
    fn along<'a>(&'a self, ray: &Ray, clip: &Clip, far: f64, gradients: bool) -> Option<Box<dyn FieldLine + 'a>>;

    /// This field as a grid with labels, if it is one: renderers may have kernels for it.
    fn as_labelled_grid(&self) -> Option<&LabelledGrid> {
        None
    }

    /// Makes the structures that queries need beyond the data, so that the first frame does not pay for them.
    fn prepare_derived(&self) {}
}
