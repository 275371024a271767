//! Facts of a scene that tell how much of the equation of transfer it needs.

use glam::DVec3;
use vr_core::Scene;
use vr_core::scattering::{Albedo, Scattering};

use super::thickness::{thickness_along, thickness_bound};
use crate::medium::Medium;

/// Facts of a scene that tell how much of the equation of transfer it needs. Bounds are upper bounds, in the band where they are largest.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneFacts {
    /// Bound of χ, per world unit.
    pub extinction: f64,
    /// Bound of the optical thickness of any straight path through the volume.
    pub thickness_bound: f64,
    /// Largest optical thickness of the straight paths through the middle along x, y and z: an example, no bound.
    pub thickness: f64,
    /// Bound of the length of any straight path through the volume, in world units.
    pub length: f64,
    /// Bound of the albedo ϖ.
    pub albedo: f64,
    /// Bound of q/χ, the radiance that the medium would have in the dark if nothing were scattered; +∞ where transparent places emit.
    pub glow: f64,
    /// Bound of q/κ, the radiance of the medium in equilibrium with its own light; +∞ where places emit that do not absorb.
    pub thermal: f64,
    /// Bound of q, per world unit.
    pub emission: f64,
    /// Bound of the source function j/χ of light from lamps and from all sides, scattered once.
    pub lit: f64,
    /// Bound of the radiance of light from all sides; +∞ where there are lamps, whose light is a beam.
    pub incoming: f64,
    /// True if light meets opaque surfaces, too, of whose light no bound is known.
    pub has_surfaces: bool,
}

impl SceneFacts {
    /// Facts of a scene whose medium is this.
    pub fn of(scene: &Scene, medium: &dyn Medium) -> Self {
        let (low, high) = medium.bounds();
        let transfer = &scene.transfer;
        let color = transfer.brightest_color_by_channel();
        let scattering = scene.scattering.as_deref();
        let albedo = scattering.map_or([0.0; 3], |s| s.albedo.of(color));
        let largest = |channels: [f64; 3]| channels.into_iter().fold(0.0, f64::max);
        let [glow, thermal] = match scattering.map(|s| s.albedo) {
            _ if transfer.has_emission() && transfer.brightest_emission() > 0.0 => [f64::INFINITY; 2],
            _ if transfer.has_emission() => [0.0; 2],
            Some(Albedo::Color) => [0.0; 2],
            Some(Albedo::Constant(albedo)) => {
                let absorbed = |c: usize| (1.0 - albedo[c]) * color[c];
                let equilibrium = |c: usize| if albedo[c] < 1.0 { color[c] } else { 0.0 };
                [largest(std::array::from_fn(absorbed)), largest(std::array::from_fn(equilibrium))]
            }
            None => [largest(color); 2],
        };
        let extinction = medium.extinction_range(low, high)[1];
        // A medium of colours emits κ·c.
        let emission = if transfer.has_emission() { transfer.brightest_emission() } else { extinction * glow };
        let points = scattering.into_iter().flat_map(|s| &s.point_lights).map(|light| light.color);
        let lamps = scattering.is_some()
            && scene.lights.iter().map(|light| light.color).chain(points).any(|color| largest(color) > 0.0);
        Self {
            extinction,
            thickness_bound: thickness_bound(medium),
            thickness: thickness_along(medium),
            length: (high - low).length(),
            albedo: largest(albedo),
            glow,
            thermal,
            emission,
            lit: scattering.map_or(0.0, |s| lit(s, scene, albedo, (low, high))),
            has_surfaces: scattering.is_some_and(|s| scene.surfaces.is_some() || !s.surfaces.is_empty()),
            incoming: if lamps { f64::INFINITY } else { scattering.map_or(0.0, |s| largest(brightest(s))) },
        }
    }

    /// Bound of the share of a source function that any straight path meets: 1 − e^(−τ).
    pub fn cover(&self) -> f64 {
        -libm::expm1(-self.thickness_bound)
    }

    /// Bound of the radiance that the medium itself sends along a straight path.
    pub fn glow_seen(&self) -> f64 {
        let by_source = if self.glow == f64::INFINITY { f64::INFINITY } else { self.glow * self.cover() };
        by_source.min(self.emission * self.length)
    }
}

/// Largest radiance of the light from all sides.
fn brightest(scattering: &Scattering) -> [f64; 3] {
    let map = scattering.environment_map.as_ref().map_or([0.0; 3], |map| map.brightest());
    std::array::from_fn(|c| scattering.environment[c] + map[c])
}

/// Bound of the source function of lamps and of light from all sides, scattered once: a lamp of colour L sheds π L, of which p/4π goes into a direction.
/// +∞ for a point light within the box of the medium.
fn lit(scattering: &Scattering, scene: &Scene, albedo: [f64; 3], (low, high): (DVec3, DVec3)) -> f64 {
    let peak = scattering.phase.max_value();
    let environment = brightest(scattering);
    let of_band = |c: usize| {
        let far: f64 = scene.lights.iter().map(|light| light.color[c]).sum();
        let near = scattering.point_lights.iter().filter(|light| light.color[c] > 0.0);
        let near: f64 =
            near.map(|light| light.color[c] / light.position.distance_squared(light.position.clamp(low, high))).sum();
        if albedo[c] > 0.0 { albedo[c] * (environment[c] + 0.25 * peak * (far + near)) } else { 0.0 }
    };
    (0..3).map(of_band).fold(0.0, f64::max)
}
