//! Light that an opaque surface reflects once.

use vr_core::{FacetHit, Ray, RenderError};
use vr_physics::Certainty;

use super::incoming::{ENVIRONMENT, suns};
use super::{RayLight, SingleScattering};
use crate::boundary::Reflection;
use crate::spectrum::BandGroup;

impl SingleScattering {
    /// The light of a ray that ends on a facet: that of the medium before it, and the part of the facet's own that gets through.
    ///
    /// A Lambertian facet of reflectance ρ under a lamp of colour L, whose irradiance is π L cos θ, has the radiance ρ L cos θ; in a surround of
    /// radiance E that is seen by a share T̄ of the cosine-weighted directions, ρ E T̄.
    pub(super) fn with_surface(&self, ray: &Ray, hit: &FacetHit, mut light: RayLight) -> Result<RayLight, RenderError> {
        let at = ray.origin + ray.direction * hit.distance;
        let through = libm::exp(-light.depth);
        let (mut arriving, mut error) = ([0.0; 3], 0.0);
        let mut add = |color: [f64; 3], [share, wrong]: [f64; 2]| {
            (0..3).for_each(|c| arriving[c] += share * color[c]);
            error += wrong * color.into_iter().fold(0.0, f64::max);
        };
        for lamp in self.lights.iter().filter(|light| light.direction.is_none()) {
            add(lamp.color, [hit.cosine(-ray.direction) * through, 0.0]);
        }
        for (sun, (towards, lamp)) in suns(&self.lights).enumerate() {
            let cosine = hit.cosine(towards);
            if cosine > 0.0 {
                let towards = Ray { origin: at, direction: towards };
                let found = self.sun_transmittance(sun, &towards, Some(hit.facet))?;
                add(lamp.color, found.map(|share| cosine * share));
                light.samples += 1;
            }
        }
        if self.scattering.environment != [0.0; 3] {
            let [coarse, fine] = ENVIRONMENT.map(|counts| self.surround(ray, at, hit, counts));
            let (coarse, fine) = (coarse?, fine?);
            add(self.scattering.environment, [fine, (fine - coarse).abs()]);
        }
        (0..3).for_each(|c| light.radiance[c] += through * hit.reflectance[c] * arriving[c]);
        light.half_way = light.half_way.min(hit.distance);
        light.surface = hit.distance;
        light.certainty = Certainty::Estimate(light.certainty.value() + through * error);
        Ok(light)
    }

    /// Mean transmittance to the outside over the directions above a facet, weighted by their cosines.
    fn surround(
        &self,
        ray: &Ray,
        at: glam::DVec3,
        hit: &FacetHit,
        [cosines, azimuths]: [usize; 2],
    ) -> Result<f64, RenderError> {
        let matt = Reflection::Lambertian(crate::Spectrum::grey(1.0));
        let one = BandGroup { first: 0, count: 1 };
        let mut sum = 0.0;
        for i in 0..cosines {
            for j in 0..azimuths {
                let azimuth = (j as f64 + 0.5 * (i % 2) as f64) / azimuths as f64;
                let uniform = [(i as f64 + 0.5) / cosines as f64, azimuth];
                let reflected = matt.sample(hit.normal, -ray.direction, one, uniform);
                let above = reflected.filter(|r| hit.facet_normal.dot(r.direction) > 0.0);
                if let Some(reflected) = above {
                    let towards = Ray { origin: at, direction: reflected.direction };
                    sum += self.transmittance(&towards, Some(hit.facet))?[0];
                }
            }
        }
        Ok(sum / (cosines * azimuths) as f64)
    }
}
