//! Light that is aimed at from each scattering: next-event estimation.

use std::f64::consts::PI;

use glam::DVec3;
use vr_core::Ray;
use vr_core::scattering::PhaseFunction;

use super::path::{Path, PathSampler};
use crate::boundary::{LightSource, Reflection, SurfaceHit, SurfacePlace};
use crate::random::RandomStream;
use crate::spectrum::{LANES, Lanes};
use crate::tracking::{TrackedMedium, TransmittanceEstimator};

/// Scatterer of light: the medium or a surface.
pub(super) enum Scatterer<'a> {
    /// The medium.
    Phase(&'a PhaseFunction),
    /// A surface.
    Surface {
        reflection: &'a Reflection,
        hit: &'a SurfaceHit,
        /// Direction in which the light leaves.
        to: DVec3,
    },
}

/// Smallest probability of a connection to a light.
const MIN_CONNECTION: f64 = 0.25;

/// Share of a place by which two ways of sampling find it, of one whose density is `own` (the power heuristic of Veach & Guibas, "Optimally combining
/// sampling techniques for Monte Carlo rendering", 1995).
pub(super) fn competing_weight(own: f64, other: f64) -> f64 {
    if other == 0.0 {
        return 1.0;
    }
    // Densities may be infinite, their squares as well.
    let ratio = other / own;
    if ratio.is_nan() { 0.5 } else { 1.0 / (1.0 + ratio * ratio) }
}

impl Scatterer<'_> {
    /// Light scattered per incoming radiance and solid angle, by band, and the density by which a path would go that way.
    fn value(&self, path: &Path, towards: DVec3) -> (Lanes, f64) {
        match self {
            Self::Phase(phase) => {
                let density = phase.value(path.ray.direction.dot(towards)) / (4.0 * PI);
                ([density; LANES], density)
            }
            Self::Surface { hit, .. } if hit.facet_normal.dot(towards) <= 0.0 => ([0.0; LANES], 0.0),
            Self::Surface { reflection, hit, to } => reflection.value(hit.normal, *to, towards, path.group),
        }
    }
}

/// Russian roulette over the connection to a light: its transmittance costs the same time however little light is scattered towards the eye. Returns
/// the weight of the connection, the inverse of its probability; `None` if it is not made.
///
/// The first scattering always connects, since most of the light of a thin medium comes from there.
fn connection_weight(path: &Path, value: &Lanes, random: &mut RandomStream) -> Option<f64> {
    if path.scatterings <= 1 {
        return Some(1.0);
    }
    let scattered = path.weight.iter().zip(value).fold(0.0, |max: f64, (weight, value)| max.max(weight * value));
    // Relative to isotropic scattering at the weight of the first: a path that scatters as much light as that always connects.
    let isotropic = path.first_weight / (4.0 * PI);
    let probability = (scattered / isotropic).clamp(MIN_CONNECTION, 1.0);
    (probability == 1.0 || random.uniform() < probability).then(|| 1.0 / probability)
}

impl PathSampler<'_> {
    /// Adds the light that comes to a place from lights, from emitters, and from the bright parts of an environment.
    pub(super) fn add_direct_light(
        &self,
        path: &mut Path,
        at: DVec3,
        scatterer: &Scatterer<'_>,
        random: &mut RandomStream,
    ) {
        for light in self.scene.lights() {
            if let Some(from) = light.illuminate(at, path.primary) {
                let (value, _) = scatterer.value(path, from.towards);
                let Some(factor) = connection_weight(path, &value, random) else { continue };
                let color = light.color().lanes(path.group).map(|c| c * from.irradiance * factor);
                self.add_unless_hidden(path, at, from.towards, from.distance, None, |i| value[i] * color[i], random);
            }
        }
        self.add_emitter(path, at, scatterer, random);
        if let Some((towards, density)) = self.scene.environment().map().and_then(|map| map.sample(random.pair())) {
            let light = self.scene.environment().lanes(towards, path.group);
            let (value, own) = scatterer.value(path, towards);
            let Some(factor) = connection_weight(path, &value, random) else { return };
            let share = competing_weight(density, own) / density * factor;
            let added = |i: usize| share * value[i] * light[i];
            self.add_unless_hidden(path, at, towards, f64::INFINITY, None, added, random);
        }
    }

    /// Light that comes to a place from lights without size and without scattering on its way, times a weight of the direction towards each: no ray
    /// ever meets them. Headlights are left out, for there is no eye.
    pub(crate) fn unscattered_light(
        &self,
        at: DVec3,
        band: usize,
        weight: &dyn Fn(DVec3) -> f64,
        random: &mut RandomStream,
    ) -> f64 {
        let mut sum = 0.0;
        for light in self.scene.lights().iter().filter(|light| !matches!(light, LightSource::Headlight { .. })) {
            let Some(from) = light.illuminate(at, DVec3::X) else { continue };
            let ray = Ray { origin: at, direction: from.towards };
            let weight = weight(from.towards);
            let hidden = || self.scene.nearest(&ray, None).is_some_and(|hit| hit.distance < from.distance);
            if weight > 0.0 && !hidden() {
                let through = |medium: &TrackedMedium| {
                    medium.transmittance(&ray, from.distance, band, TransmittanceEstimator::default(), random)
                };
                sum += weight * light.color().at(band) * from.irradiance * self.scene.medium().map_or(1.0, through);
            }
        }
        sum
    }

    /// Adds the light of one point of one emitter.
    fn add_emitter(&self, path: &mut Path, at: DVec3, scatterer: &Scatterer<'_>, random: &mut RandomStream) {
        let emitters = self.scene.emitters();
        if emitters.is_empty() {
            return;
        }
        let chosen = ((random.uniform() * emitters.len() as f64) as usize).min(emitters.len() - 1);
        let index = emitters[chosen];
        let surface = &self.scene.surfaces()[index];
        let point = surface.shape.sample(random.pair());
        let to = point - at;
        let distance = to.length();
        let towards = to / distance;
        let normal = surface.shape.normal(point);
        let density = self.emitter_density(&SurfaceHit::on_simple(index, distance, point, normal), towards);
        // A point of the emitter that the path itself is on, or one seen edge on.
        if !(density > 0.0 && density.is_finite()) {
            return;
        }
        let light = surface.emission.lanes(path.group);
        let (value, own) = scatterer.value(path, towards);
        let share = competing_weight(density, own) / density;
        self.add_unless_hidden(path, at, towards, distance, Some(index), |i| share * value[i] * light[i], random);
    }

    /// Density per solid angle by which [`Self::add_emitter`] aims at a place of a surface; 0 if it never does.
    pub(super) fn emitter_density(&self, hit: &SurfaceHit, direction: DVec3) -> f64 {
        let emitters = self.scene.emitters();
        let SurfacePlace::Simple(index) = hit.place else { return 0.0 };
        if !emitters.contains(&index) {
            return 0.0;
        }
        let facing = hit.normal.dot(direction).abs() * self.scene.surfaces()[index].shape.area();
        hit.distance * hit.distance / (facing * emitters.len() as f64)
    }

    /// Adds light that comes from a direction, as far as it is not zero, nor absorbed on its way, nor hidden by a surface other than its `source`.
    #[expect(clippy::too_many_arguments, reason = "a connection has two ends")]
    fn add_unless_hidden(
        &self,
        path: &mut Path,
        at: DVec3,
        towards: DVec3,
        distance: f64,
        source: Option<usize>,
        light: impl Fn(usize) -> f64,
        random: &mut RandomStream,
    ) {
        let count = path.group.count;
        let mut added = [0.0; LANES];
        (0..count).for_each(|i| added[i] = path.weight[i] * light(i));
        if added.iter().all(|&a| a == 0.0) {
            return;
        }
        let ray = Ray { origin: at, direction: towards };
        if let Some(hit) = self.scene.nearest(&ray, path.from) {
            // The source itself is met at its own distance, but for rounding.
            let before = hit.distance < distance * (1.0 - 1e-9);
            if before && (source.map(SurfacePlace::Simple) != Some(hit.place) || hit.distance < distance * (1.0 - 1e-6))
            {
                return;
            }
        }
        let estimator = TransmittanceEstimator::default();
        let through = self
            .scene
            .medium()
            .map_or(1.0, |medium| medium.transmittance(&ray, distance, path.group.first, estimator, random));
        (0..count).for_each(|i| path.radiance[i] += added[i] * through);
    }
}
