//! Blinn-Phong shading with directional lights, and opacity modulated by the gradient's magnitude.

use glam::DVec3;

use crate::error::ParameterError;
use crate::limits::{DIRECTION_LENGTHS, MAX_FACTOR, MAX_LIGHT, MAX_MAGNITUDE, MAX_POWER};
use crate::real::Real;

/// Reflection of light by surfaces in the volume (Blinn 1977), two-sided:
/// c is replaced by c·(ka + kd Σ L|n·l|) + ks Σ L|n·h|^p, n the normalised world gradient. Where the gradient is zero, c stays.
///
/// Emission that is given on its own is light, not a surface: it is not shaded.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::{Light, Shading};
///
/// // Under a headlight, a surface that faces the eye gets all diffuse light, and one seen edge on none.
/// let matte = Shading { specular: 0.0, ..Shading::default() };
/// let along = matte.along::<f64>(&[Light::default()], DVec3::Z);
/// let [facing, edge_on] = [[0.0, 0.0, 5.0], [5.0, 0.0, 0.0]].map(|gradient| along.reflect(gradient).0[0]);
/// assert!((facing - (matte.ambient + matte.diffuse)).abs() < 1e-15);
/// assert_eq!(edge_on, matte.ambient);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Shading {
    /// ka.
    pub ambient: f64,
    /// kd.
    pub diffuse: f64,
    /// ks.
    pub specular: f64,
    /// p.
    pub power: f64,
    /// Source of n.
    pub gradient: GradientMethod,
    /// Multiplies κ by a piecewise linear function of the gradient's magnitude: (value per world unit, factor), sorted.
    /// Empty: no modulation.
    pub gradient_opacity: Vec<(f64, f64)>,
}

impl Default for Shading {
    fn default() -> Self {
        Self {
            ambient: 0.2,
            diffuse: 0.7,
            specular: 0.3,
            power: 20.0,
            gradient: GradientMethod::default(),
            gradient_opacity: Vec::new(),
        }
    }
}

/// A light at infinity.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::Light;
///
/// let sun = Light { direction: Some(DVec3::new(1.0, 1.0, 0.0)), color: [1.0, 0.9, 0.8] };
/// assert!(Light::validate_all(&[Light::default(), sun]).is_ok());
/// let nowhere = Light { direction: Some(DVec3::ZERO), ..sun };
/// assert_eq!(Light::validate_all(&[sun, nowhere]).unwrap_err().field, "shading.lights[1].direction");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// World vector *towards* the light; `None`: a headlight, shining along each ray.
    pub direction: Option<DVec3>,
    /// Linear RGB.
    pub color: [f64; 3],
}

impl Default for Light {
    fn default() -> Self {
        Self { direction: None, color: [1.0; 3] }
    }
}

impl Light {
    /// Checks the lights of a scene.
    ///
    /// # Errors
    /// A light without direction, or one that is negative or brighter than 10⁶.
    pub fn validate_all(lights: &[Self]) -> Result<(), ParameterError> {
        for (i, l) in lights.iter().enumerate() {
            if l.direction.is_some_and(|d| !DIRECTION_LENGTHS.contains(&d.length())) {
                let allowed = "must be finite and not zero, its length 1e-100 to 1e100";
                return Err(ParameterError::new(format!("shading.lights[{i}].direction"), l.direction, allowed));
            }
            if l.color.iter().any(|c| !(0.0..=MAX_LIGHT).contains(c)) {
                let allowed = "must be finite and not negative, 1e6 at most";
                return Err(ParameterError::new(format!("shading.lights[{i}].color"), l.color, allowed));
            }
        }
        Ok(())
    }
}

/// Source of the gradient for shading.
///
/// # Examples
/// ```
/// use vr_core::{GradientMethod, Shading};
///
/// let smooth = Shading { gradient: GradientMethod::Analytic, ..Shading::default() };
/// assert!(smooth.validate().is_ok());
/// assert_eq!(Shading::default().gradient, GradientMethod::CentralDifferences);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum GradientMethod {
    /// Central differences at the voxels (one-sided at the faces of the box), interpolated trilinearly.
    #[default]
    CentralDifferences,
    /// The reconstruction filter's own gradient.
    Analytic,
}

/// The factor at a magnitude of the gradient, by points of (magnitude, factor) in order: linear between them, constant outside, and 1 where there is none.
///
/// # Examples
/// ```
/// use vr_core::factor_at;
///
/// let boundaries = [(1.0, 0.0), (3.0, 0.5)];
/// assert_eq!([0.0, 2.0, 9.0].map(|magnitude| factor_at(&boundaries, magnitude)), [0.0, 0.25, 0.5]);
/// ```
pub fn factor_at(points: &[(f64, f64)], magnitude: f64) -> f64 {
    let i = points.partition_point(|p| p.0 <= magnitude);
    match (i.checked_sub(1).map(|j| points[j]), points.get(i)) {
        (None, None) => 1.0,
        (None, Some(&(_, f))) | (Some((_, f)), None) => f,
        (Some((m0, f0)), Some(&(m1, f1))) => f0 + (magnitude - m0) / (m1 - m0) * (f1 - f0),
    }
}

impl Shading {
    /// Shading that leaves colours as they are: all light is ambient.
    pub fn flat() -> Self {
        Self { ambient: 1.0, diffuse: 0.0, specular: 0.0, ..Self::default() }
    }

    /// True if colours stay as they are, whatever the lights.
    pub fn is_flat(&self) -> bool {
        self.ambient == 1.0 && self.diffuse == 0.0 && self.specular == 0.0
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// Coefficients that are negative or beyond 10³ (the exponent 10⁴), gradient points that are not sorted.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let coefficients =
            [("shading.ambient", self.ambient), ("shading.diffuse", self.diffuse), ("shading.specular", self.specular)];
        for (field, x) in coefficients {
            if !(0.0..=MAX_FACTOR).contains(&x) {
                return Err(ParameterError::new(field, x, "must be finite and not negative, 1000 at most"));
            }
        }
        if !(0.0..=MAX_POWER).contains(&self.power) {
            let allowed = "must be finite and not negative, 10000 at most";
            return Err(ParameterError::new("shading.power", self.power, allowed));
        }
        let points = &self.gradient_opacity;
        let possible = |&(m, f): &(f64, f64)| (0.0..=MAX_MAGNITUDE).contains(&m) && (0.0..=MAX_FACTOR).contains(&f);
        if !points.iter().all(possible) || points.windows(2).any(|w| w[1].0 <= w[0].0) {
            let allowed = "magnitudes must be strictly increasing, 1e60 at most, factors 1000 at most, none negative";
            return Err(ParameterError::new("shading.gradient_opacity", points, allowed));
        }
        Ok(())
    }

    /// The factor on κ at a gradient magnitude: linear between the points, constant outside.
    pub fn modulation(&self, magnitude: f64) -> f64 {
        factor_at(&self.gradient_opacity, magnitude)
    }

    /// The largest factor on κ.
    pub fn largest_modulation(&self) -> f64 {
        let factors = self.gradient_opacity.iter().map(|p| p.1);
        factors.reduce(f64::max).unwrap_or(1.0)
    }

    /// Largest component of shaded colours whose own components are at most `color`: c·max(ka + kd Σ L, 1) + ks Σ L.
    pub fn max_radiance(&self, lights: &[Light], color: f64) -> f64 {
        let light = |c: usize| lights.iter().map(|l| l.color[c]).sum::<f64>();
        let light = light(0).max(light(1)).max(light(2));
        // Where the gradient is zero, the colour stays.
        color * (self.ambient + self.diffuse * light).max(1.0) + self.specular * light
    }

    /// The part of the shading that is constant along one ray: lights at infinity seen along `direction` (the ray's, in the world).
    pub fn along<R: Real>(&self, lights: &[Light], direction: DVec3) -> RayShading<R> {
        let to_eye = -direction;
        let lights = lights.iter().map(|l| {
            let to_light = l.direction.map_or(to_eye, DVec3::normalize);
            // Opposite to the eye, the half vector has no direction: no highlight then.
            let half = (to_light + to_eye).normalize_or_zero();
            RayLight {
                to_light: to_light.to_array().map(R::from_f64),
                half: half.to_array().map(R::from_f64),
                color: l.color.map(R::from_f64),
            }
        });
        RayShading {
            lights: lights.collect(),
            ambient: R::from_f64(self.ambient),
            diffuse: R::from_f64(self.diffuse),
            specular: R::from_f64(self.specular),
            power: R::from_f64(self.power),
        }
    }
}

/// A light relative to one ray.
#[derive(Clone, Copy, Debug)]
pub struct RayLight<R> {
    /// Unit vector towards the light.
    pub to_light: [R; 3],
    /// Unit vector between light and eye; zero where they are opposite.
    pub half: [R; 3],
    /// Linear RGB.
    pub color: [R; 3],
}

/// Shading along one ray.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::{Light, Shading};
///
/// let shading = Shading::default().along::<f64>(&[Light::default()], DVec3::Z);
/// let half_grey = [0.25, 0.25, 0.25, 0.5];
/// assert_eq!(shading.shade(half_grey, [0.0; 3]), half_grey, "no surface, no shading");
/// let [red, .., alpha] = shading.shade(half_grey, [0.0, 0.0, -2.0]);
/// assert!((red - (0.25 * (0.2 + 0.7) + 0.5 * 0.3)).abs() < 1e-15 && alpha == 0.5);
/// ```
#[derive(Clone, Debug)]
pub struct RayShading<R> {
    /// The lights.
    pub lights: Vec<RayLight<R>>,
    /// ka.
    pub ambient: R,
    /// kd.
    pub diffuse: R,
    /// ks.
    pub specular: R,
    /// p.
    pub power: R,
}

impl<R: Real> RayShading<R> {
    /// Reflection at a point with this world gradient: (factor on the colour, light added). Two-sided.
    #[inline]
    pub fn reflect(&self, gradient: [R; 3]) -> ([R; 3], [R; 3]) {
        // Scaled by its largest component, so that the square neither underflows nor overflows.
        let largest = gradient[0].abs().max(gradient[1].abs()).max(gradient[2].abs());
        if largest <= R::ZERO || largest.is_nan() {
            return ([R::ONE; 3], [R::ZERO; 3]);
        }
        let g = gradient.map(|x| x / largest);
        let n = R::ONE / dot(g, g).sqrt();
        let (mut factor, mut added) = ([self.ambient; 3], [R::ZERO; 3]);
        for light in &self.lights {
            let facing = self.diffuse * (dot(g, light.to_light) * n).abs();
            let highlight = self.specular * (dot(g, light.half) * n).abs().pow(self.power);
            for c in 0..3 {
                factor[c] += light.color[c] * facing;
                added[c] += light.color[c] * highlight;
            }
        }
        (factor, added)
    }

    /// Light and opacity of a sample with this world gradient, shaded: c·factor + α·added; opacity stays.
    #[inline]
    pub fn shade(&self, [r, g, b, alpha]: [R; 4], gradient: [R; 3]) -> [R; 4] {
        let (factor, added) = self.reflect(gradient);
        let lit = |light: R, c: usize| light * factor[c] + added[c] * alpha;
        [lit(r, 0), lit(g, 1), lit(b, 2), alpha]
    }
}

#[inline(always)]
fn dot<R: Real>(a: [R; 3], b: [R; 3]) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_sided_headlight() {
        let s = Shading::default().along::<f64>(&[Light::default()], DVec3::NEG_Z);
        for sign in [1e-200, -1.0, 1e200] {
            let (factor, added) = s.reflect([0.0, 0.0, sign]);
            assert!((factor[0] - 0.9).abs() < 1e-15 && (added[0] - 0.3).abs() < 1e-15, "{factor:?} {added:?}");
        }
        assert_eq!(s.reflect([0.0; 3]), ([1.0; 3], [0.0; 3]));
        let (side, _) = s.reflect([1.0, 0.0, 0.0]);
        assert!((side[0] - 0.2).abs() < 1e-15);
        let lit = s.shade([0.5, 0.25, 0.0, 0.5], [0.0, 0.0, 2.0]);
        assert!((lit[0] - 0.6).abs() < 1e-15 && (lit[2] - 0.15).abs() < 1e-15 && lit[3] == 0.5, "{lit:?}");
    }

    #[test]
    fn modulation_is_piecewise_linear() {
        let s = Shading { gradient_opacity: vec![(1.0, 0.0), (3.0, 1.0)], ..Shading::default() };
        assert_eq!([0.0, 1.0, 2.0, 9.0].map(|m| s.modulation(m)), [0.0, 0.0, 0.5, 1.0]);
        assert_eq!(Shading::default().modulation(5.0), 1.0);
    }

    #[test]
    fn refuses_numbers_that_sums_in_f32_cannot_keep() {
        let good = Shading::default();
        let light = |direction: f64, color: f64| {
            vec![Light { direction: Some(DVec3::X * direction), color: [0.0, color, 0.0] }]
        };
        let all = Shading { ambient: 1e3, diffuse: 1e3, specular: 1e3, power: 1e4, ..good.clone() };
        all.validate().unwrap();
        Light::validate_all(&light(1e-100, 1e6)).unwrap();
        for (bad, field) in [
            (Shading { ambient: 1001.0, ..good.clone() }, "shading.ambient"),
            (Shading { diffuse: f64::INFINITY, ..good.clone() }, "shading.diffuse"),
            (Shading { specular: f64::NAN, ..good.clone() }, "shading.specular"),
            (Shading { power: 1e300, ..good.clone() }, "shading.power"),
            (Shading { gradient_opacity: vec![(0.0, 1e4)], ..good.clone() }, "shading.gradient_opacity"),
            (Shading { gradient_opacity: vec![(1e61, 1.0)], ..good.clone() }, "shading.gradient_opacity"),
        ] {
            assert_eq!(bad.validate().unwrap_err().field, field);
        }
        for (bad, field) in [
            (light(1.0, 1e7), "shading.lights[0].color"),
            // Squares of these lengths are 0 and infinite: such lights would light nothing.
            (light(1e-200, 1.0), "shading.lights[0].direction"),
            (light(1e200, 1.0), "shading.lights[0].direction"),
        ] {
            assert_eq!(Light::validate_all(&bad).unwrap_err().field, field);
        }
    }
}
