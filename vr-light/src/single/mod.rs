//! Single scattering, without random numbers: light goes from a light to a place in the medium, is scattered there once, and goes on to the eye. It
//! is what makes shadows.
//!
//! Along a ray, I = ∫ T (q + σ Σ L p/4 Tₗ + σ E T̄) ds: T is the transmittance from the eye, q the medium's own emission, L the colour of a
//! light and Tₗ the transmittance towards it, E the environment's radiance and T̄ the mean transmittance to the outside, weighted by the phase
//! function.
//! A light of colour L has the irradiance πL, so that a white surface that faces it shows L. A headlight shines along each ray, and its light
//! comes in
//! by the same transmittance T.
//!
//! # How
//! Ray and light rays are solved by the reference ([`vr_physics::Reference`]), with bounds. The ray is cut at every face of a cell and at every
//! knot of
//! the transfer function; between them the integrand is smooth but for the shadows of edges. It is integrated by Kronrod's rule of seven
//! points, and intervals are halved until the estimated error fits the tolerance.
//!
//! Most of the time goes to light rays: [`SingleScattering::with_tabulated_shadows`] solves them beforehand, on a lattice.
//!
//! An opacity of 1 under the power rule, a wall, is taken as 1 − 10⁻⁶: a medium so dense that light comes back from its first fourteenth of a unit
//! distance.
//!
//! Opaque surfaces end rays, reflect the light of lamps and surround once, and cast shadows.

mod incoming;
mod kronrod;
mod medium;
mod ray_light;
mod shadow_volume;
mod surface_light;

use vr_core::cancel;
use vr_core::scattering::Scattering;
use vr_core::{Camera, Clip, Feature, Light, ParameterError, Ray, RenderError, Scene, Unsupported, View};
use vr_physics::{MIN_TOLERANCE, Reference};

use crate::boundary::TracedSurfaces;
use crate::renderer::LightRenderer;

pub use ray_light::RayLight;
use shadow_volume::ShadowVolume;

/// A scene under single scattering.
///
/// # Examples
/// Uniform fog of optical thickness 2, lit along the rays. All that is scattered at the depth τ comes back by e^(−2τ).
/// ```
/// use glam::DVec3;
/// use vr_core::scattering::{Albedo, PhaseFunction, Scattering};
/// use vr_core::*;
/// use vr_light::single::SingleScattering;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let grid = UniformGrid::new([2, 2, 2], vec![1u8; 8], Placement::from_spacing([2.0; 3])?, Calibration::default())?;
/// let fog = ControlPoint::new(1.0, [0.5; 3], 1.0); // extinction 1
/// let scene = Scene::new(grid.into(), TransferFunction::new(vec![fog], OpacityRule::Extinction, 1.0)?);
/// let scattering = Scattering { albedo: Albedo::Color, phase: PhaseFunction::Isotropic, ..Scattering::default() };
///
/// let single = SingleScattering::new(&scene, &scattering, &Clip::default(), 1e-6)?;
/// let ray = Ray { origin: DVec3::new(1.0, 1.0, -9.0), direction: DVec3::Z };
/// let light = single.ray(&ray, f64::INFINITY)?;
/// let depth = light.depth;
/// assert!((light.radiance[0] - 0.5 / 4.0 * (1.0 - (-2.0 * depth).exp()) / 2.0).abs() <= 1e-6);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct SingleScattering {
    scene: Scene,
    lights: Vec<Light>,
    scattering: Scattering,
    surfaces: Option<TracedSurfaces>,
    view: View,
    tolerance: f64,
    reference: Reference,
    /// Tables of the lights with a direction, in their order; none: each light ray is solved.
    shadows: Vec<ShadowVolume>,
}

/// Refuses lights that only random paths sample: the inverse square law near a point light needs samples of its own, and an environment map has as many
/// directions as pixels. So do simple surfaces, which light each other in every order.
///
/// # Errors
/// [`Unsupported`] with [`Feature::Scattering`].
pub(crate) fn refuse_sampled_lights(scattering: &Scattering) -> Result<(), Unsupported> {
    let refuse = |what: &str| {
        let what = format!("{what} without chance: model=full samples them");
        Err(Unsupported { renderer: LightRenderer::NAME, feature: Feature::Scattering, what })
    };
    if !scattering.point_lights.is_empty() || scattering.environment_map.is_some() {
        return refuse("point lights and environment maps");
    }
    if !scattering.surfaces.is_empty() { refuse("surfaces that emit, mirror and light each other") } else { Ok(()) }
}

impl SingleScattering {
    /// Prepares a scene. The tolerance is the error aimed at, in radiance, 10⁻¹⁰ at least.
    ///
    /// # Errors
    /// Numbers out of range; point lights, an environment map or simple surfaces; a compositing operator that picks values; volumes with colours of their own; opacity that follows the gradient;
    /// surfaces that rays cannot be traced against.
    pub fn new(scene: &Scene, scattering: &Scattering, clip: &Clip, tolerance: f64) -> Result<Self, RenderError> {
        scattering.validate()?;
        refuse_sampled_lights(scattering)?;
        let unlit = medium::unlit(scene)?;
        let tolerance = if tolerance.is_nan() { 1e-10 } else { tolerance.max(1e-10) };
        let mut view = View::new(Camera::framing(scene.volume.bounds(), 0.0, 0.0, None), [1, 1]);
        view.clip = clip.clone();
        view.validate()?;
        let reference = Reference::new((1e-2 * tolerance).clamp(MIN_TOLERANCE, 1e-3));
        let lights = scene.lights.clone();
        Ok(Self {
            scene: unlit,
            lights,
            scattering: scattering.clone(),
            surfaces: TracedSurfaces::of(scene, clip)?,
            view,
            tolerance,
            reference,
            shadows: Vec::new(),
        })
    }

    /// Tabulates the optical depth towards each light with a direction, at this many nodes along each axis: rays are solved several times as fast
    /// then.
    /// Shadows are interpolated between the nodes, of which there should be two for each voxel along the diagonal. The error told holds an
    /// estimate of what that misses, good for the mean of a picture; it may be above the tolerance.
    ///
    /// # Errors
    /// A number of nodes that is not odd, or not 3 to 257; also as for [`Reference::solve`].
    pub fn with_tabulated_shadows(mut self, nodes: usize) -> Result<Self, RenderError> {
        if !(3..=257).contains(&nodes) || nodes.is_multiple_of(2) {
            return Err(ParameterError::new("light.shadow_nodes", nodes, "must be odd, 3 to 257").into());
        }
        let suns = incoming::suns(&self.lights);
        let table = |(towards, _)| ShadowVolume::new(&self.reference, &self.scene, &self.view, towards, nodes);
        self.shadows = suns.map(table).collect::<Result<_, _>>()?;
        Ok(self)
    }

    /// Share of the light of one of the lights with a direction that reaches the origin of a ray towards it, and the share's error.
    /// The ray may leave a facet.
    fn sun_transmittance(&self, sun: usize, towards: &Ray, leaving: Option<u32>) -> Result<[f64; 2], RenderError> {
        match self.shadows.get(sun) {
            Some(_) if self.is_hidden(towards, leaving) => Ok([0.0; 2]),
            Some(table) => Ok(table.transmittance(towards.origin)),
            None => self.transmittance(towards, leaving),
        }
    }

    /// True if an opaque surface is in the way of light from infinity to the origin of a ray.
    fn is_hidden(&self, towards: &Ray, leaving: Option<u32>) -> bool {
        self.surfaces.as_ref().is_some_and(|surfaces| surfaces.hide(towards, leaving))
    }

    /// Share of the light from a direction that reaches the origin of a ray towards it, and the share's error. The ray may leave a facet.
    fn transmittance(&self, towards: &Ray, leaving: Option<u32>) -> Result<[f64; 2], RenderError> {
        // A ray from the eye takes thousands of these.
        cancel::poll();
        if self.is_hidden(towards, leaving) {
            return Ok([0.0; 2]);
        }
        let found = self.reference.transport(&self.scene, &self.view, towards)?;
        Ok(found.map_or([1.0, 0.0], |t| [t.transmittance(), t.certainty.value()]))
    }
}
