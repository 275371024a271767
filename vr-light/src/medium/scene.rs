//! The medium of a scene: volume, transfer function and scattering together.

use std::sync::Arc;

use glam::DVec3;
use vr_core::scattering::{Albedo, PhaseFunction, Scattering};
use vr_core::transfer::Optical;
use vr_core::{Clip, ParameterError, Scene, TransferFunction};

use super::extinction_curve::ExtinctionCurve;
use super::scene_field::SceneField;
use super::{Coefficients, Medium};

/// Optical depth of the shortest length of a scene (unit distance or spacing) in a place of opacity 1, whose extinction is infinite.
///
/// It is above the 36.7 of the largest opacity below 1, lets e⁻⁶⁴ = 10⁻²⁸ through, and keeps the free path of light that is scattered in the
/// wall, so that it gets out again after about as many steps as in any dense medium.
pub const WALL_DEPTH: f64 = 64.0;

/// The volume of a scene as a medium, in red, green and blue.
///
/// The extinction of the transfer function is χ; [`Albedo`] says which share of it is scattering: σ = ϖχ, κ = χ − σ. The source q is the emission of
/// the transfer function where that is given on its own; else κ·c under a constant albedo, and 0 where the colour is the albedo. A place of
/// opacity 1 is a wall of [`WALL_DEPTH`]. Missing voxels, and what the clip cuts away, are vacuum.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::phantom::{self, Phantom};
/// use vr_core::scattering::Scattering;
/// use vr_core::{Clip, Scene};
/// use vr_light::{Medium, SceneMedium};
///
/// let scene: Scene = phantom::by_name("fog").unwrap().scene(9)?;
/// let medium = SceneMedium::new(&scene, &Clip::default(), &Scattering::default())?;
/// assert!(medium.is_grey() && medium.bands() == 3);
/// let [min, max] = medium.extinction_range(-DVec3::ONE, DVec3::ONE);
/// assert!((min..=max).contains(&medium.extinction(DVec3::ZERO, DVec3::X, 0)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SceneMedium {
    field: SceneField,
    transfer: Arc<TransferFunction>,
    scattering: Scattering,
    extinction: ExtinctionCurve,
    emits: bool,
}

impl SceneMedium {
    /// The medium of a scene within a clip.
    ///
    /// # Errors
    /// Scattering that is out of range; opacity that follows the gradient's magnitude, which a medium does not know.
    pub fn new(scene: &Scene, clip: &Clip, scattering: &Scattering) -> Result<Self, ParameterError> {
        scattering.validate()?;
        if scene.has_gradient_opacity() {
            let allowed = "opacity by the gradient's magnitude does not go with scattering: take a transfer function of the value alone";
            return Err(ParameterError::new("shading.gradient_opacity", "opacity by gradient", allowed));
        }
        scene.volume.prepare_derived();
        let shortest = scene.transfer.unit_distance().min(scene.volume.mean_spacing());
        Ok(Self {
            field: SceneField::new(&scene.volume, clip),
            transfer: Arc::clone(&scene.transfer),
            scattering: scattering.clone(),
            extinction: ExtinctionCurve::new(&scene.transfer, WALL_DEPTH / shortest),
            emits: emits(&scene.transfer, scattering),
        })
    }

    /// Coefficients in red, green and blue of a place of these optical properties, whose colour is multiplied by that of the voxels.
    fn of_optical(&self, at: &Optical, tint: [f64; 3]) -> [Coefficients; 3] {
        let color: [f64; 3] = std::array::from_fn(|c| at.color[c] * tint[c]);
        let extinction = self.extinction.of_opacity(at.opacity);
        let albedo = self.scattering.albedo.of(color);
        std::array::from_fn(|c| {
            let scattering = albedo[c] * extinction;
            let absorption = extinction - scattering;
            let emission = match self.scattering.albedo {
                _ if self.transfer.has_emission() => at.emission[c] * tint[c],
                Albedo::Constant(_) => absorption * color[c],
                Albedo::Color => 0.0,
            };
            Coefficients { absorption, scattering, emission }
        })
    }

    /// Smallest and largest extinction of the values between two, ends included.
    fn extinction_between(&self, low: f64, high: f64) -> [f64; 2] {
        let points = self.transfer.points();
        let inner = points.partition_point(|p| p.value <= low)..points.partition_point(|p| p.value < high);
        // Opacity is linear between points: its extremes are at these, on either side of a jump, and at both ends.
        let ends = [self.transfer.at(low), self.transfer.at_below(high), self.transfer.at(high)].map(|at| at.opacity);
        let opacities = points.get(inner).unwrap_or_default().iter().map(|p| p.opacity).chain(ends);
        let (min, max) = opacities.fold((1.0f64, 0.0f64), |(min, max), opacity| (min.min(opacity), max.max(opacity)));
        // Slack for the rounding of opacities between points, as far as it is seen through the power rule's logarithm.
        let slack = |opacity: f64, sign: f64| (opacity + sign * 1e-12 * opacity.min(1.0 - opacity)).clamp(0.0, 1.0);
        [slack(min, -1.0), slack(max, 1.0)].map(|opacity| self.extinction.of_opacity(opacity))
    }
}

impl Medium for SceneMedium {
    fn bounds(&self) -> (DVec3, DVec3) {
        self.field.bounds()
    }

    fn coefficients(&self, at: DVec3, _direction: DVec3, first: usize, out: &mut [Coefficients]) {
        let all = match self.field.at(at) {
            Some((value, tint)) => self.of_optical(&self.transfer.at(value), tint),
            None => [Coefficients::default(); 3],
        };
        out.copy_from_slice(&all[first..first + out.len()]);
    }

    fn extinction(&self, at: DVec3, _direction: DVec3, _band: usize) -> f64 {
        self.field.value(at).map_or(0.0, |value| self.extinction.at(value))
    }

    fn extinctions(&self, at: &[DVec3], _direction: DVec3, _band: usize, out: &mut [f64]) {
        self.field.values(at, out);
        for out in out {
            *out = if out.is_nan() { 0.0 } else { self.extinction.at(*out) };
        }
    }

    fn albedo(&self, band: usize) -> Option<f64> {
        match self.scattering.albedo {
            Albedo::Constant(albedo) => Some(albedo[band]),
            Albedo::Color => None,
        }
    }

    fn is_grey(&self) -> bool {
        true
    }

    fn phase(&self) -> &PhaseFunction {
        &self.scattering.phase
    }

    fn extinction_range(&self, low: DVec3, high: DVec3) -> [f64; 2] {
        let values = self.field.range(low, high);
        if values.is_empty() {
            return [0.0; 2];
        }
        let [min, max] = self.extinction_between(values.low, values.high);
        [if values.has_vacuum { 0.0 } else { min }, max]
    }

    fn has_emission(&self) -> bool {
        self.emits
    }

    fn resolution(&self) -> [usize; 3] {
        self.field.resolution()
    }
}

/// True if any value emits.
fn emits(transfer: &TransferFunction, scattering: &Scattering) -> bool {
    match scattering.albedo {
        _ if transfer.has_emission() => transfer.brightest_emission() > 0.0,
        Albedo::Color => false,
        Albedo::Constant(albedo) => albedo != [1.0; 3] && transfer.brightest_color() > 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{Calibration, ControlPoint, OpacityRule, Placement, Plane, UniformGrid};

    fn scene(samples: Vec<f32>, points: Vec<ControlPoint>) -> Scene {
        let calibration = Calibration { slope: 2.0, intercept: -1.0 };
        let grid = UniformGrid::new([17, 9, 9], samples, Placement::from_spacing([0.5; 3]).unwrap(), calibration);
        Scene::new(grid.unwrap().into(), TransferFunction::new(points, OpacityRule::Power, 2.0).unwrap())
    }

    fn points() -> Vec<ControlPoint> {
        vec![
            ControlPoint::new(0.0, [0.2, 0.5, 1.5], 0.0),
            ControlPoint::new(1.0, [0.9, 0.5, 0.1], 0.6),
            ControlPoint::new(1.0, [0.9, 0.5, 0.1], 0.3),
            ControlPoint::new(4.0, [1.0; 3], 1.0),
        ]
    }

    fn samples() -> Vec<f32> {
        (0..17 * 9 * 9).map(|i| ((i * 7919 % 1000) as f32) / 300.0).collect()
    }

    #[test]
    fn extinction_is_shared_and_conserved() {
        let scene = scene(samples(), points());
        for albedo in [Albedo::Color, Albedo::Constant([0.0, 0.5, 1.0])] {
            let scattering = Scattering { albedo, ..Scattering::default() };
            let medium = SceneMedium::new(&scene, &Clip::default(), &scattering).unwrap();
            for i in 0..200 {
                let at = DVec3::new(f64::from(i % 17) * 0.49, f64::from(i % 8) * 0.37, f64::from(i % 5) * 0.91);
                let mut bands = [Coefficients::default(); 3];
                medium.coefficients(at, DVec3::X, 0, &mut bands);
                let whole = medium.extinction(at, DVec3::X, 0);
                for (c, band) in bands.iter().enumerate() {
                    // One product and one difference are rounded.
                    assert!((band.extinction() - whole).abs() <= 2.0 * f64::EPSILON * whole && band.absorption >= 0.0);
                    if let Albedo::Constant(albedo) = albedo {
                        assert!((band.albedo() - albedo[c]).abs() < 1e-14 || whole == 0.0);
                        assert!(band.absorption > 0.0 || band.emission == 0.0);
                    } else {
                        assert_eq!(band.emission, 0.0);
                    }
                }
            }
        }
    }

    #[test]
    fn ranges_enclose_the_extinction() {
        let mut holes = samples();
        holes[300] = f32::NAN;
        for samples in [samples(), holes] {
            for filter in vr_core::Filter::ALL {
                let scene = scene(samples.clone(), points()).with_filter(filter);
                let medium = SceneMedium::new(&scene, &Clip::default(), &Scattering::default()).unwrap();
                let (low, high) = medium.bounds();
                let cells = 5;
                for cell in 0..cells * cells * cells {
                    let index =
                        DVec3::new((cell % cells) as f64, (cell / cells % cells) as f64, (cell / cells / cells) as f64);
                    let size = (high - low) / cells as f64;
                    let corner = low + index * size;
                    let [min, max] = medium.extinction_range(corner, corner + size);
                    for k in 0..64 {
                        let part = DVec3::new(f64::from(k % 4), f64::from(k / 4 % 4), f64::from(k / 16)) / 3.001;
                        let extinction = medium.extinction(corner + part * size, DVec3::X, 0);
                        assert!((min..=max).contains(&extinction), "{filter:?}: {extinction} is not in {min} to {max}");
                    }
                }
            }
        }
    }

    #[test]
    fn clips_and_walls_are_what_they_say() {
        let opaque = vec![ControlPoint::new(0.0, [1.0; 3], 1.0)];
        let clip = Clip {
            crop: Some((DVec3::ZERO, DVec3::splat(3.0))),
            planes: vec![Plane { normal: DVec3::Y, offset: 1.0 }],
        };
        let medium = SceneMedium::new(&scene(samples(), opaque), &clip, &Scattering::default()).unwrap();
        assert_eq!(medium.bounds(), (DVec3::ZERO, DVec3::splat(3.0)));
        let at = |y: f64, z: f64| medium.extinction(DVec3::new(1.0, y, z), DVec3::X, 0);
        assert_eq!([at(2.0, 1.0), at(0.5, 1.0), at(2.0, 3.5)], [WALL_DEPTH / 0.5, 0.0, 0.0]);
        assert_eq!(medium.extinction_range(DVec3::splat(1.5), DVec3::splat(2.0)), [WALL_DEPTH / 0.5; 2]);
        assert_eq!(medium.extinction_range(DVec3::splat(0.5), DVec3::splat(2.0))[0], 0.0, "a part is cut away");
    }
}
