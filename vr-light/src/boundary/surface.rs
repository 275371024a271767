//! Surfaces: shapes that emit and reflect.

use glam::DVec3;
use vr_core::scattering::{Finish, SimpleSurface};
use vr_core::{FacetHit, ParameterError, Ray};

use super::{Reflection, Shape};
use crate::spectrum::Spectrum;

/// An opaque surface, which emits and reflects on both sides alike.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_light::{Reflection, Shape, Spectrum, Surface};
///
/// let lamp = Surface::emitter(Shape::Sphere { centre: DVec3::Z, radius: 0.1 }, Spectrum::grey(5.0));
/// assert_eq!(lamp.reflection, Reflection::Black);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Its shape.
    pub shape: Shape,
    /// Radiance that it emits in all directions.
    pub emission: Spectrum,
    /// Kernel by which it reflects.
    pub reflection: Reflection,
}

/// Surface that a place is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SurfacePlace {
    /// One of the simple surfaces, by number.
    Simple(usize),
    /// A facet of the traced surfaces.
    Facet(u32),
}

/// Place at which a ray meets a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceHit {
    pub place: SurfacePlace,
    pub distance: f64,
    pub at: DVec3,
    /// Unit normal on the side that the ray comes from.
    pub normal: DVec3,
    /// The same of the facet itself, where `normal` is interpolated.
    pub facet_normal: DVec3,
    /// Lambertian reflectance of a facet; that of a simple surface is its own affair.
    pub reflectance: [f64; 3],
}

impl SurfaceHit {
    /// A facet that a ray meets.
    pub(crate) fn on_facet(ray: &Ray, hit: &FacetHit) -> Self {
        let FacetHit { distance, facet, normal, facet_normal, reflectance } = *hit;
        let at = ray.origin + ray.direction * distance;
        Self { place: SurfacePlace::Facet(facet), distance, at, normal, facet_normal, reflectance }
    }

    /// A simple surface at a place, its normal on this side.
    pub(crate) fn on_simple(index: usize, distance: f64, at: DVec3, normal: DVec3) -> Self {
        let place = SurfacePlace::Simple(index);
        Self { place, distance, at, normal, facet_normal: normal, reflectance: [0.0; 3] }
    }
}

impl Surface {
    /// A surface that emits and reflects nothing.
    pub fn emitter(shape: Shape, emission: Spectrum) -> Self {
        Self { shape, emission, reflection: Reflection::Black }
    }

    /// Checks the numbers for a number of bands.
    pub(crate) fn validate(&self, field: &str, bands: usize) -> Result<(), ParameterError> {
        self.shape.validate(&format!("{field}.shape"))?;
        self.emission.validate(&format!("{field}.emission"), bands, f64::MAX)?;
        self.reflection.validate(&format!("{field}.reflection"), bands)
    }
}

impl From<SimpleSurface> for Surface {
    fn from(surface: SimpleSurface) -> Self {
        let SimpleSurface { shape, emission, reflectance, finish } = surface;
        let reflectance = Spectrum::from(reflectance);
        let reflection = match finish {
            _ if reflectance.is_black() => Reflection::Black,
            Finish::Matte => Reflection::Lambertian(reflectance),
            Finish::Mirror => Reflection::Mirror(reflectance),
            Finish::Gloss { exponent } => Reflection::Phong { reflectance, exponent },
        };
        Self { shape, emission: emission.into(), reflection }
    }
}

/// The first surface that a ray meets; `from` is the one that it starts on.
pub(crate) fn nearest(surfaces: &[Surface], ray: &Ray, from: Option<usize>) -> Option<SurfaceHit> {
    let mut first: Option<(usize, f64)> = None;
    for (index, surface) in surfaces.iter().enumerate() {
        if let Some(distance) = surface.shape.intersect(ray, from == Some(index))
            && first.is_none_or(|(_, nearer)| distance < nearer)
        {
            first = Some((index, distance));
        }
    }
    first.map(|(index, distance)| {
        let at = ray.origin + ray.direction * distance;
        let normal = surfaces[index].shape.normal(at);
        let normal = if normal.dot(ray.direction) > 0.0 { -normal } else { normal };
        SurfaceHit::on_simple(index, distance, at, normal)
    })
}
