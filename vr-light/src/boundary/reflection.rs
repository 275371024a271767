//! Kernels by which surfaces reflect light.

use std::f64::consts::PI;

use glam::DVec3;
use vr_core::ParameterError;

use crate::spectrum::{BandGroup, Lanes, Spectrum};

/// Kernel k of a surface: reflected radiance is ∫ k I_inc cos θ dω. No kernel reflects more light than it gets.
///
/// # Examples
/// ```
/// use vr_light::{Reflection, Spectrum};
///
/// let paper = Reflection::Lambertian(Spectrum::grey(0.8));
/// assert_ne!(paper, Reflection::Black);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Reflection {
    /// Nothing.
    #[default]
    Black,
    /// The same radiance in all directions: k = ρ/π, of the reflectance ρ.
    Lambertian(Spectrum),
    /// The mirrored direction alone, with a share of the light.
    Mirror(Spectrum),
    /// A lobe about the mirrored direction: k = ρ (n + 2)/2π cosⁿ α, α being the angle to it. Light that falls along the normal is reflected by the
    /// share ρ, other light by less (Lafortune & Willems, "Using the modified Phong reflectance model for physically based rendering", 1994).
    Phong {
        /// ρ.
        reflectance: Spectrum,
        /// n.
        exponent: f64,
    },
}

/// A direction in which a path goes on from a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reflected {
    pub direction: DVec3,
    /// k cos θ / density, by band.
    pub weight: Lanes,
    /// Density per solid angle; `None` of a mirror.
    pub density: Option<f64>,
}

impl Reflection {
    /// True if light without size or in a sampled direction can be reflected: all kernels but mirrors.
    pub(crate) fn is_smooth(&self) -> bool {
        matches!(self, Self::Lambertian(_) | Self::Phong { .. })
    }

    /// k cos θ by band, and the density of [`Self::sample`], between the direction `to` in which light leaves, and the one that it comes from. Both point
    /// away from the surface, on the side of the unit normal.
    pub(crate) fn value(&self, normal: DVec3, to: DVec3, from: DVec3, group: BandGroup) -> (Lanes, f64) {
        let cosine = normal.dot(from).max(0.0);
        match self {
            Self::Black | Self::Mirror(_) => ([0.0; 4], 0.0),
            Self::Lambertian(reflectance) => (reflectance.lanes(group).map(|r| r * cosine / PI), cosine / PI),
            Self::Phong { reflectance, exponent } => {
                let lobe = libm::pow(mirrored(to, normal).dot(from).max(0.0), *exponent) / (2.0 * PI);
                let value = lobe * (exponent + 2.0) * cosine;
                (reflectance.lanes(group).map(|r| r * value), if cosine > 0.0 { lobe * (exponent + 1.0) } else { 0.0 })
            }
        }
    }

    /// A random direction from which the light comes that leaves in the direction `to`; `None` where none does.
    pub(crate) fn sample(&self, normal: DVec3, to: DVec3, group: BandGroup, uniform: [f64; 2]) -> Option<Reflected> {
        match self {
            Self::Black => None,
            Self::Mirror(share) => {
                Some(Reflected { direction: mirrored(to, normal), weight: share.lanes(group), density: None })
            }
            Self::Lambertian(reflectance) => {
                let direction = lobe(normal, uniform[0].sqrt(), uniform[1]);
                let density = normal.dot(direction) / PI;
                (density > 0.0).then(|| Reflected {
                    direction,
                    weight: reflectance.lanes(group),
                    density: Some(density),
                })
            }
            Self::Phong { reflectance, exponent } => {
                // 1 − u is never 0, whose power would be a direction of no density.
                let cosine = libm::pow(1.0 - uniform[0], 1.0 / (exponent + 1.0));
                let direction = lobe(mirrored(to, normal), cosine, uniform[1]);
                let to_normal = normal.dot(direction);
                let ratio = (exponent + 2.0) / (exponent + 1.0) * to_normal;
                let density = (exponent + 1.0) / (2.0 * PI) * libm::pow(cosine, *exponent);
                (to_normal > 0.0 && density > 0.0).then(|| Reflected {
                    direction,
                    weight: reflectance.lanes(group).map(|r| r * ratio),
                    density: Some(density),
                })
            }
        }
    }

    /// Checks the numbers for a number of bands.
    pub(crate) fn validate(&self, field: &str, bands: usize) -> Result<(), ParameterError> {
        match self {
            Self::Black => Ok(()),
            Self::Lambertian(share) | Self::Mirror(share) => share.validate(field, bands, 1.0),
            Self::Phong { exponent, .. } if !(0.0..=1e6).contains(exponent) => {
                Err(ParameterError::new(format!("{field}.exponent"), exponent, "must be 0 to 1e6"))
            }
            Self::Phong { reflectance, .. } => reflectance.validate(field, bands, 1.0),
        }
    }
}

/// Mirror image of a direction that points away from a surface.
fn mirrored(to: DVec3, normal: DVec3) -> DVec3 {
    (2.0 * normal.dot(to) * normal - to).normalize()
}

/// The direction at an angle of the given cosine from an axis, a share of a turn about it.
fn lobe(axis: DVec3, cosine: f64, turn: f64) -> DVec3 {
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let (sin, cos) = libm::sincos(2.0 * PI * turn);
    let (a, b) = axis.any_orthonormal_pair();
    (cosine * axis + sine * (cos * a + sin * b)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::RandomStream;

    #[test]
    fn kernels_are_sampled_as_they_are_and_keep_the_light() {
        let (normal, to) = (DVec3::Z, DVec3::new(0.6, 0.0, 0.8));
        let group = BandGroup { first: 0, count: 1 };
        let share = || Spectrum::grey(0.75);
        for kernel in [Reflection::Lambertian(share()), Reflection::Phong { reflectance: share(), exponent: 12.0 }] {
            let count = 40_000;
            // Reflected light of a uniform surround: by the kernel's own directions, and by directions over all of the hemisphere.
            let (mut own, mut plain, mut mass) = (0.0, [0.0; 2], 0.0);
            for i in 0..count {
                let mut random = RandomStream::new(1, 0, i);
                if let Some(reflected) = kernel.sample(normal, to, group, random.pair()) {
                    own += reflected.weight[0];
                    let (value, density) = kernel.value(normal, to, reflected.direction, group);
                    assert!((density / reflected.density.unwrap() - 1.0).abs() < 1e-9);
                    assert!((value[0] / density / reflected.weight[0] - 1.0).abs() < 1e-9);
                }
                let [u, v] = random.pair();
                let (value, density) = kernel.value(normal, to, lobe(normal, u, v), group);
                let value = 2.0 * PI * value[0];
                plain = [plain[0] + value, plain[1] + value * value];
                mass += 2.0 * PI * density;
            }
            let n = count as f64;
            let (own, mean, mass) = (own / n, plain[0] / n, mass / n);
            let error = (plain[1] / n - mean * mean).sqrt() / n.sqrt();
            assert!((own - mean).abs() < 4.0 * error && own <= 0.75 + 1e-12, "{kernel:?}: {own}, {mean} ± {error}");
            assert!(mass <= 1.0 + 6.0 * error, "{mass}");
        }
    }
}
