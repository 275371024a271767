//! Light that is reflected along a ray, with a bound of what it is off by.

use std::sync::Arc;

use glam::DVec3;
use vr_core::{Light, RayShading, Scene, Shading};

use super::cone::Cone;
use super::normals::{Normals, Slopes};
use super::series::Series;

/// Largest rest of 1/|g|, relative to it, at which nothing else is asked.
const MAX_REST: f64 = 0.01;

/// Reflection in a scene: what holds for all rays.
#[derive(Clone, Debug)]
pub(super) struct Reflection {
    pub(super) shading: Arc<Shading>,
    pub(super) lights: Vec<Light>,
    /// True if no light has a colour, so that all channels change alike.
    is_grey: bool,
    /// Largest component of reflected light, for colours of at most the largest.
    pub(super) brightest: f64,
}

/// Reflection along one ray.
#[derive(Clone, Debug)]
pub(super) struct RayReflection<'a> {
    reflection: &'a Reflection,
    ray: RayShading<f64>,
}

/// Change of colours on a part of a cell, by the colour of the place and by reflection: each channel c becomes c · `factor` + `added`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ColorChange {
    pub(super) factor: [Series; 3],
    pub(super) added: [Series; 3],
}

impl ColorChange {
    /// No change: a factor of 1, and nothing added.
    pub(super) const UNCHANGED: Self = Self { factor: [Series::constant(1.0); 3], added: [Series::constant(0.0); 3] };

    /// Returns the same change behind a multiplication by the colours of the places, which comes before reflection.
    pub(super) fn of_tinted(&self, tint: &[Series; 3]) -> Self {
        Self { factor: std::array::from_fn(|c| self.factor[c].product(&tint[c])), ..*self }
    }

    /// Returns the light of a colour's channel.
    pub(super) fn of(&self, color: &Series, channel: usize) -> Series {
        color.product(&self.factor[channel]).plus(&self.added[channel])
    }
}

impl Reflection {
    /// Returns the reflection of a scene; `None` where its colours stay as they are.
    pub(super) fn new(scene: &Scene, brightest: f64) -> Option<Self> {
        let shading = scene.reflection().filter(|shading| !shading.is_flat()).cloned()?;
        let brightest = shading.max_radiance(&scene.lights, brightest);
        let is_grey = scene.lights.iter().all(|light| light.color.iter().all(|c| *c == light.color[0]));
        Some(Self { shading, lights: scene.lights.clone(), is_grey, brightest })
    }

    pub(super) fn along(&self, direction: DVec3) -> RayReflection<'_> {
        RayReflection { reflection: self, ray: self.shading.along(&self.lights, direction) }
    }
}

impl RayReflection<'_> {
    /// Returns the change of colours on the part [from, to] of a cell, 0 to 1.
    pub(super) fn on(&self, normals: &Normals, part: [f64; 2]) -> ColorChange {
        let ray = &self.ray;
        let corners = match normals {
            Normals::Absent => return ColorChange::UNCHANGED,
            Normals::Along { corners, .. } => corners.as_ref(),
            Normals::Unknown => None,
        };
        let Some(Slopes { gradient, square, .. }) = normals.on(part) else { return self.anything() };
        let inverse = square.inverse_root();
        // Where it changes much, the directions at the samples say more.
        let is_known = inverse.is_some_and(|inverse| inverse.rest <= MAX_REST * inverse.c[0]);
        let cone = if is_known { None } else { corners.and_then(|corners| corners.cone(part)) };
        if inverse.is_none() && cone.is_none() {
            return self.anything();
        }
        let cosine = |v: &[f64; 3]| cosine(&gradient, v, inverse.as_ref(), cone.as_ref());
        let mut reflected =
            ColorChange { factor: [Series::constant(ray.ambient); 3], added: [Series::constant(0.0); 3] };
        for light in &ray.lights {
            let to_light = cosine(&light.to_light);
            // A headlight's half vector is the direction to it.
            let half = if light.half == light.to_light { to_light } else { cosine(&light.half) };
            let (facing, highlight) = (to_light.times(ray.diffuse), raised(&half, ray.power).times(ray.specular));
            for c in 0..if self.reflection.is_grey { 1 } else { 3 } {
                reflected.factor[c] = reflected.factor[c].plus(&facing.times(light.color[c]));
                reflected.added[c] = reflected.added[c].plus(&highlight.times(light.color[c]));
            }
        }
        if self.reflection.is_grey {
            reflected = ColorChange { factor: [reflected.factor[0]; 3], added: [reflected.added[0]; 3] };
        }
        reflected
    }

    /// Returns all that reflection may make of colours.
    fn anything(&self) -> ColorChange {
        let ray = &self.ray;
        let total = |c: usize| ray.lights.iter().map(|l| l.color[c]).sum::<f64>();
        let factor = |c: usize| (ray.ambient.min(1.0), (ray.ambient + ray.diffuse * total(c)).max(1.0));
        ColorChange {
            factor: std::array::from_fn(|c| Series::between(factor(c).0, factor(c).1)),
            added: std::array::from_fn(|c| Series::between(0.0, ray.specular * total(c))),
        }
    }
}

/// Returns the cosine |g·v|/|g|, 0 to 1, between a gradient and a unit vector: as a series by 1/|g|, if that says more than the gradient's cone.
fn cosine(gradient: &[Series; 3], v: &[f64; 3], inverse: Option<&Series>, cone: Option<&Cone>) -> Series {
    let mut range = cone.map_or([0.0, 1.0], |cone| cone.cosine(v));
    let Some(inverse) = inverse else { return Series::between(range[0], range[1]) };
    let [x, y, z] = std::array::from_fn(|a| gradient[a].times(v[a]));
    let towards = x.plus(&y).plus(&z);
    let [low, high] = inverse.range();
    let (middle, spread) = (towards.c[0].abs(), towards.spread());
    range[1] = range[1].min((middle + spread) * high);
    range[0] = range[0].max((middle - spread).max(0.0) * low.max(0.0)).min(range[1]);
    let range = Series::between(range[0], range[1]);
    towards.magnitude().map_or(range, |m| m.product(inverse).or(range))
}

/// Returns a power of a cosine.
fn raised(cosine: &Series, power: f64) -> Series {
    let range = || {
        let [low, high] = cosine.range().map(|x| libm::pow(x.clamp(0.0, 1.0), power));
        Series::between(low, high)
    };
    match cosine.power(power) {
        // So little that its range need not be looked at.
        Some(series) if series.rest <= 1e-3 => series,
        Some(series) => series.or(range()),
        None => range(),
    }
}
