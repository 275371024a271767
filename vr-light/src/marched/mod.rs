//! Single scattering in steps: for pictures, where [`crate::single`] is for the truth.
//!
//! A ray is sampled at the middle of equal steps, of which each counts as homogeneous. The light of a lamp that gets to a sample is looked up in a
//! [`ShadowMap`], made once for each lamp; that of a headlight comes along the ray itself, and is dimmed as the ray is. The error falls with the square
//! of the step and of the map's spacing, with the step itself where the transfer function jumps.
//!
//! Opaque surfaces end rays, reflect the light of lamps and headlights once, and hide lamps: a ray towards the lamp from each sample tells.

mod shadow_map;

pub use shadow_map::ShadowMap;
pub(crate) use shadow_map::is_beside;

use std::sync::Arc;

use glam::DVec3;
use vr_core::cancel::{self, SparsePoll};
use vr_core::{Clip, Control, FacetHit, Ray, RenderError, Scene};

use crate::boundary::TracedSurfaces;
use crate::medium::{Coefficients, Medium, SceneMedium};
use crate::single::refuse_sampled_lights;
use crate::tracking::{TrackedMedium, Walk};

/// Optical depth at which a ray ends: what is behind it adds less than 10⁻⁶ of a source function.
const DEEPEST: f64 = 14.0;

/// Light that is scattered once, or emitted, along a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarchedLight {
    /// Radiance of red, green and blue.
    pub radiance: [f64; 3],
    /// Optical depth.
    pub depth: f64,
    /// World distance at which half of the light behind is gone; +∞ where less is.
    pub half_way: f64,
    /// World distance of the opaque surface at which the ray ends; +∞ without one.
    pub surface: f64,
    /// Samples of the medium.
    pub samples: u64,
}

impl MarchedLight {
    /// Opacity: 1 − e^(−τ), and 1 before a surface.
    pub fn opacity(&self) -> f64 {
        if self.surface < f64::INFINITY { 1.0 } else { -libm::expm1(-self.depth) }
    }
}

/// Lamp at infinity as the medium sees it.
#[derive(Clone, Debug)]
struct Lamp {
    /// Unit vector towards it.
    towards: DVec3,
    color: [f64; 3],
    map: ShadowMap,
}

/// A scene whose light is scattered once, ready to be sampled in steps.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::scattering::Scattering;
/// use vr_core::{Clip, Control, Ray, Scene, phantom};
/// use vr_light::marched::MarchedScattering;
///
/// let mut scene: Scene = phantom::by_name("fog").unwrap().scene(9)?;
/// scene.scattering = Some(Scattering::default().into());
/// let light = MarchedScattering::new(&scene, &Clip::default(), 0.5, &Control::default())?;
/// let ray = Ray { origin: -5.0 * DVec3::Z, direction: DVec3::Z };
/// let seen = light.along(&ray);
/// assert!(seen.depth > 1.0 && seen.radiance[0] > 0.0 && seen.radiance[0] < 0.25);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct MarchedScattering {
    medium: TrackedMedium,
    surfaces: Option<TracedSurfaces>,
    lamps: Vec<Lamp>,
    /// Colour of all headlights together.
    headlight: [f64; 3],
    step: f64,
}

impl MarchedScattering {
    /// Prepares what a clip leaves of a scene, in steps of so many spacings of the volume. Light from all sides is left to [`crate::single`].
    ///
    /// # Errors
    /// A scene whose medium makes no sense, point lights, an environment map or simple surfaces, surfaces that rays cannot be traced against, or [`RenderError::Cancelled`].
    pub fn new(scene: &Scene, clip: &Clip, step: f64, control: &Control) -> Result<Self, RenderError> {
        let scattering = scene.scattering.as_deref().cloned().unwrap_or_default();
        refuse_sampled_lights(&scattering)?;
        let medium: Arc<dyn Medium> = Arc::new(SceneMedium::new(scene, clip, &scattering)?);
        let spacing = scene.volume.mean_spacing();
        let lamp = |(towards, color): (DVec3, [f64; 3])| {
            let towards = towards.normalize();
            ShadowMap::new(&*medium, towards, spacing, control).map(|map| Lamp { towards, color, map })
        };
        // A lamp without light needs no map.
        let of_lamp = |light: &vr_core::Light| {
            light.direction.map(|towards| (towards, light.color)).filter(|lamp| lamp.1 != [0.0; 3])
        };
        let lamps = scene.lights.iter().filter_map(of_lamp).map(lamp).collect::<Result<_, _>>()?;
        let headlights = scene.lights.iter().filter(|light| light.direction.is_none());
        let headlight = headlights.fold([0.0; 3], |sum, light| std::array::from_fn(|c| sum[c] + light.color[c]));
        let surfaces = TracedSurfaces::of(scene, clip)?;
        Ok(Self { medium: TrackedMedium::new(medium), surfaces, lamps, headlight, step: step * spacing })
    }

    /// Light along a ray, front to back.
    pub fn along(&self, ray: &Ray) -> MarchedLight {
        cancel::poll();
        let hit = self.surfaces.as_ref().and_then(|surfaces| surfaces.nearest(ray, None));
        let surface = hit.map_or(f64::INFINITY, |hit| hit.distance);
        let mut light = MarchedLight { radiance: [0.0; 3], depth: 0.0, half_way: f64::INFINITY, surface, samples: 0 };
        let phase = self.medium.medium().phase();
        // Light travels against the ray on its way to the eye. Of a lamp of colour L, L p/4 of what is scattered goes there.
        let shares: Vec<f64> =
            self.lamps.iter().map(|lamp| 0.25 * phase.value(ray.direction.dot(lamp.towards))).collect();
        let back = 0.25 * phase.value(-1.0);
        let mut poll = SparsePoll::default();
        for stretch in Walk::new(self.medium.grid(), ray, surface).filter(|s| s.cell.rate > 0.0 && s.end > s.start) {
            let steps = ((stretch.end - stretch.start) / self.step).ceil().max(1.0);
            let length = (stretch.end - stretch.start) / steps;
            for i in 0..steps as u64 {
                poll.turn();
                let distance = stretch.start + (i as f64 + 0.5) * length;
                self.step(ray, distance, length, &shares, back, &mut light);
                if light.depth > DEEPEST {
                    return light;
                }
            }
        }
        if let Some(hit) = hit {
            self.reflect(ray, &hit, &mut light);
        }
        light
    }

    /// Adds the light that the surface at the end of a ray reflects: of a lamp of colour L, ρ L cos θ as far as it gets there.
    fn reflect(&self, ray: &Ray, hit: &FacetHit, light: &mut MarchedLight) {
        let at = ray.origin + ray.direction * hit.distance;
        let through = libm::exp(-light.depth);
        let mut arriving = self.headlight.map(|l| l * hit.cosine(-ray.direction) * through);
        for lamp in &self.lamps {
            let reaching = hit.cosine(lamp.towards) * self.reaching(lamp, at, Some(hit.facet));
            (0..3).for_each(|c| arriving[c] += reaching * lamp.color[c]);
        }
        (0..3).for_each(|c| light.radiance[c] += through * hit.reflectance[c] * arriving[c]);
        light.half_way = light.half_way.min(hit.distance);
    }

    /// Share of a lamp's light that gets to a place, which may be on a facet.
    fn reaching(&self, lamp: &Lamp, at: DVec3, leaving: Option<u32>) -> f64 {
        let towards = Ray { origin: at, direction: lamp.towards };
        if self.surfaces.as_ref().is_some_and(|surfaces| surfaces.hide(&towards, leaving)) {
            return 0.0;
        }
        libm::exp(-lamp.map.depth(at))
    }

    /// Adds a step of a ray around a distance.
    fn step(&self, ray: &Ray, distance: f64, length: f64, shares: &[f64], back: f64, light: &mut MarchedLight) {
        let at = ray.origin + ray.direction * distance;
        let mut bands = [Coefficients::default(); 3];
        self.medium.medium().coefficients(at, -ray.direction, 0, &mut bands);
        light.samples += 1;
        let extinction = bands[0].extinction();
        let thickness = extinction * length;
        // Shares of the source function that are seen: once dimmed, and, of a headlight, dimmed on both ways. Vacuum that emits has no source function.
        let through = libm::exp(-light.depth);
        let weight =
            |ways: f64| if thickness > 0.0 { -libm::expm1(-ways * thickness) / (ways * extinction) } else { length };
        let (once, twice) = (through * weight(1.0), through * through * weight(2.0));
        let mut lit = [0.0; 3];
        if bands.iter().any(|band| band.scattering > 0.0) {
            for (lamp, share) in self.lamps.iter().zip(shares) {
                let reaching = share * self.reaching(lamp, at, None);
                for c in 0..3 {
                    lit[c] += reaching * lamp.color[c];
                }
            }
        }
        for c in 0..3 {
            let own = bands[c].emission + bands[c].scattering * lit[c];
            light.radiance[c] += own * once + bands[c].scattering * back * self.headlight[c] * twice;
        }
        let before = light.depth;
        light.depth += thickness;
        let half = std::f64::consts::LN_2;
        if before < half && light.depth >= half {
            light.half_way = distance - 0.5 * length + (half - before) / extinction;
        }
    }
}
