//! Light that reaches a place unscattered, and how much of it goes on along the ray to the eye.

use glam::DVec3;
use vr_core::scattering::Scattering;
use vr_core::{Light, Ray};

/// Cosines and azimuths of the directions of the environment: a coarse rule, and the finer one that counts.
pub(super) const ENVIRONMENT: [[usize; 2]; 2] = [[4, 8], [8, 16]];

/// Lights as one ray meets them.
pub(super) struct Incoming<'a> {
    scattering: &'a Scattering,
    direction: DVec3,
    /// Unit vector towards each light, and radiance that it sends on along the ray per scattering.
    suns: Vec<(DVec3, [f64; 3])>,
    /// The same of all headlights together.
    headlight: [f64; 3],
}

/// Lights that shine and have a direction, each with the unit vector towards it.
pub(super) fn suns(lights: &[Light]) -> impl Iterator<Item = (DVec3, &Light)> {
    let shining = lights.iter().filter(|light| light.color != [0.0; 3]);
    shining.filter_map(|light| Some((light.direction?.normalize(), light)))
}

/// Radiance per scattering coefficient, and an estimate of its error.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct InScattered {
    pub(super) radiance: [f64; 3],
    pub(super) error: f64,
}

impl<'a> Incoming<'a> {
    /// Lights as a ray from the eye in this direction meets them.
    ///
    /// A light of colour L lights a white surface that faces it to the radiance L: its irradiance is πL, of which p/4π is scattered per solid angle.
    pub(super) fn new(lights: &[Light], scattering: &'a Scattering, direction: DVec3) -> Self {
        let sent = |light: &Light, cosine: f64| light.color.map(|l| 0.25 * scattering.phase.value(cosine) * l);
        // Light travels from the light, then to the eye: both are opposite to the vectors at hand.
        let of_sun =
            |(towards, light): (DVec3, &Light)| (towards, sent(light, towards.dot(direction).clamp(-1.0, 1.0)));
        let mut headlight = [0.0; 3];
        for light in lights.iter().filter(|light| light.direction.is_none()) {
            let back = sent(light, -1.0);
            (0..3).for_each(|c| headlight[c] += back[c]);
        }
        Self { scattering, direction, suns: suns(lights).map(of_sun).collect(), headlight }
    }

    /// Largest radiance per scattering coefficient at any place.
    pub(super) fn max(&self) -> f64 {
        let sum = |c: usize| {
            let suns: f64 = self.suns.iter().map(|sun| sun.1[c]).sum();
            suns + self.headlight[c] + self.scattering.environment[c]
        };
        (0..3).map(sum).fold(0.0, f64::max)
    }

    /// Light scattered into the ray at a place where a headlight's light comes in by `front`; `transmittance` tells, with its error, the share of the
    /// light that reaches the origin of a ray towards it: of the light with this number, or of the environment.
    pub(super) fn at(
        &self,
        at: DVec3,
        front: f64,
        transmittance: impl Fn(Option<usize>, &Ray) -> [f64; 2],
    ) -> InScattered {
        let mut sum = InScattered { radiance: self.headlight.map(|l| l * front), error: 0.0 };
        for (sun, (towards, radiance)) in self.suns.iter().enumerate() {
            let [passed, error] = transmittance(Some(sun), &Ray { origin: at, direction: *towards });
            (0..3).for_each(|c| sum.radiance[c] += passed * radiance[c]);
            sum.error += error * radiance.iter().copied().fold(0.0, f64::max);
        }
        let environment = self.scattering.environment;
        if environment != [0.0; 3] {
            let [coarse, fine] = ENVIRONMENT.map(|counts| self.environment(at, counts, &transmittance));
            (0..3).for_each(|c| sum.radiance[c] += fine * environment[c]);
            sum.error += (fine - coarse).abs() * environment.iter().copied().fold(0.0, f64::max);
        }
        sum
    }

    /// Mean transmittance from outside over all directions, weighted by the phase function: directions are those that it samples, at regular numbers.
    fn environment(
        &self,
        at: DVec3,
        [cosines, azimuths]: [usize; 2],
        transmittance: &impl Fn(Option<usize>, &Ray) -> [f64; 2],
    ) -> f64 {
        let mut sum = 0.0;
        for i in 0..cosines {
            for j in 0..azimuths {
                // Azimuths of neighbouring cosines lie between each other.
                let azimuth = (j as f64 + 0.5 * (i % 2) as f64) / azimuths as f64;
                let uniform = [(i as f64 + 0.5) / cosines as f64, azimuth];
                let direction = self.scattering.phase.sample(self.direction, uniform);
                sum += transmittance(None, &Ray { origin: at, direction })[0];
            }
        }
        sum / (cosines * azimuths) as f64
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn an_isotropic_place_shows_a_quarter_of_a_light_and_all_of_an_environment() {
        let scattering = Scattering { environment: [0.5, 0.0, 0.0], ..Scattering::default() };
        let lights = [Light { direction: Some(DVec3::X), color: [2.0; 3] }, Light::default()];
        let incoming = Incoming::new(&lights, &scattering, DVec3::Z);
        let light = incoming.at(DVec3::ZERO, 0.5, |_, _| [1.0, 0.0]);
        let sun = 2.0 * PI / (4.0 * PI);
        assert!((light.radiance[0] - (sun + 0.125 + 0.5)).abs() < 1e-14);
        assert!((light.radiance[1] - (sun + 0.125)).abs() < 1e-14);
        assert!((incoming.max() - (sun + 0.25 + 0.5)).abs() < 1e-14);
    }
}
