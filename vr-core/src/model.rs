//! Models of what a renderer integrates, in a form that the reference in `vr-physics` can solve.

use std::sync::Arc;

use crate::filter::Filter;
use crate::ray::Ray;

/// Model of what a renderer integrates.
///
/// # Examples
/// ```
/// use vr_core::{Filter, Model};
///
/// fn describe(model: &Model) -> String {
///     match model {
///         Model::Canonical => "the scene as it is".into(),
///         Model::Filtered(filter) => format!("the scene under the filter {filter}"),
///         _ => "a model of the renderer's own".into(),
///     }
/// }
/// assert_eq!(describe(&Model::Filtered(Filter::BSpline)), "the scene under the filter bspline");
/// ```
#[derive(Clone)]
#[non_exhaustive]
pub enum Model {
    /// The scene as it is.
    Canonical,
    /// The scene with another reconstruction filter.
    Filtered(Filter),
    /// Extinction and emission of its own, continuous along each ray.
    Continuous(Arc<dyn ContinuousModel>),
    /// A sum over segments of each ray.
    Discrete(Arc<dyn DiscreteModel>),
}

impl std::fmt::Debug for Model {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Canonical => f.write_str("Canonical"),
            Self::Filtered(filter) => write!(f, "Filtered({filter})"),
            Self::Continuous(_) => f.write_str("Continuous"),
            Self::Discrete(_) => f.write_str("Discrete"),
        }
    }
}

/// Extinction and emission along a ray: smooth between breakpoints.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::{ContinuousModel, Medium, MediumBounds, Ray};
///
/// // Fog that begins three units from the eye and gets denser with the distance.
/// struct Fog;
/// impl ContinuousModel for Fog {
///     fn breakpoints(&self, _: &Ray) -> Vec<f64> {
///         vec![3.0, 5.0]
///     }
///     fn medium(&self, _: &Ray, s: f64) -> Medium {
///         let extinction = 0.1 * (s - 3.0);
///         Medium { extinction, emission: [extinction; 3] }
///     }
///     fn bounds(&self, _: &Ray, _from: f64, _to: f64) -> Option<MediumBounds> {
///         Some(MediumBounds { extinction_slope: 0.1, emission_slope: 0.1 })
///     }
/// }
///
/// let ray = Ray { origin: DVec3::ZERO, direction: DVec3::Z };
/// assert_eq!(Fog.medium(&ray, 4.0), Medium { extinction: 0.1, emission: [0.1; 3] });
/// ```
pub trait ContinuousModel: Send + Sync {
    /// World distances along the ray, ascending, between which the medium is smooth. The first and the last enclose all of it.
    fn breakpoints(&self, ray: &Ray) -> Vec<f64>;

    /// Extinction per world unit (may be +∞) and emission per world unit at a distance along the ray.
    fn medium(&self, ray: &Ray, s: f64) -> Medium;

    /// Bounds between two distances that no breakpoint separates; `None` if it has none, and the result is an estimate then.
    fn bounds(&self, ray: &Ray, from: f64, to: f64) -> Option<MediumBounds>;
}

/// Extinction and emission at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Medium {
    /// κ per world unit.
    pub extinction: f64,
    /// q per world unit.
    pub emission: [f64; 3],
}

/// Bounds of a medium over an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MediumBounds {
    /// Upper bound of |dκ/ds|.
    pub extinction_slope: f64,
    /// Upper bound of |dq/ds| of every component.
    pub emission_slope: f64,
}

/// A sum over segments: I = Σ_k b_k Π_{j<k} θ_j, front to back.
///
/// # Examples
/// ```
/// use vr_core::{DiscreteModel, SegmentTerm};
///
/// // Two slices, whatever the ray: a grey one before a bright one.
/// struct TwoSlices;
/// impl DiscreteModel for TwoSlices {
///     fn segments(&self, _x: f64, _y: f64) -> Vec<SegmentTerm> {
///         vec![SegmentTerm { transparency: 0.5, light: [0.2; 3] }, SegmentTerm { transparency: 0.0, light: [0.8; 3] }]
///     }
/// }
///
/// let add = |(sum, clear): (f64, f64), term: SegmentTerm| (sum + clear * term.light[0], clear * term.transparency);
/// let (red, transparency) = TwoSlices.segments(0.5, 0.5).into_iter().fold((0.0, 1.0), add);
/// assert!((red - 0.6).abs() < 1e-15 && transparency == 0.0);
/// ```
pub trait DiscreteModel: Send + Sync {
    /// The segments of the ray through a point of the image (in pixels from the top left corner), front to back.
    fn segments(&self, x: f64, y: f64) -> Vec<SegmentTerm>;
}

/// One term of a discrete model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentTerm {
    /// Transparency θ in [0, 1].
    pub transparency: f64,
    /// Light b that the segment sends out at its front.
    pub light: [f64; 3],
}
