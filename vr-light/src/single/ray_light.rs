//! The light of one ray.

use std::cell::RefCell;

use vr_core::{Ray, RenderError, cancel};
use vr_physics::{Certainty, RaySegment};

use super::SingleScattering;
use super::incoming::Incoming;
use super::kronrod::{RULE, integrate};
use super::medium::coefficients;

/// Largest number of intervals of one ray.
const MAX_INTERVALS: usize = 1 << 14;
/// Largest number of times that intervals are halved.
const MAX_ROUNDS: usize = 24;
/// Share of the tolerance that may be left out altogether.
const NEGLIGIBLE: f64 = 0.1;

/// Light that leaves a ray at its front.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayLight {
    /// Radiance of emission and of light scattered once.
    pub radiance: [f64; 3],
    /// Optical depth.
    pub depth: f64,
    /// World distance along the ray at which opacity reaches ½; +∞ if it does not. To a part of a cell.
    pub half_way: f64,
    /// World distance of the opaque surface at which the ray ends; +∞ without one.
    pub surface: f64,
    /// Error of the radiance: an estimate, but for a ray that meets nothing.
    pub certainty: Certainty,
    /// Number of places at which the lights were looked for.
    pub samples: u64,
}

impl RayLight {
    const NOTHING: Self = Self {
        radiance: [0.0; 3],
        depth: 0.0,
        half_way: f64::INFINITY,
        surface: f64::INFINITY,
        certainty: Certainty::Bound(0.0),
        samples: 0,
    };

    /// Opacity: 1 − e^(−τ), and 1 before a surface.
    pub fn opacity(&self) -> f64 {
        if self.surface < f64::INFINITY { 1.0 } else { -libm::expm1(-self.depth) }
    }
}

/// A smooth part of a ray, with its integral once it is known.
#[derive(Clone, Copy)]
struct Interval {
    from: f64,
    to: f64,
    light: [f64; 3],
    /// Estimate of the rule's error, which smaller intervals have less of.
    error: f64,
    /// Error that the samples bring.
    of_samples: f64,
    solved: bool,
}

/// The integrand at a place.
#[derive(Clone, Copy, Default)]
struct Sample {
    source: [f64; 3],
    error: f64,
}

impl SingleScattering {
    /// Light and optical depth along a ray, up to a world distance or the first opaque surface.
    ///
    /// # Errors
    /// Same as for [`Reference::solve`](vr_physics::Reference::solve).
    pub fn ray(&self, ray: &Ray, far: f64) -> Result<RayLight, RenderError> {
        let hit = self.surfaces.as_ref().and_then(|surfaces| surfaces.nearest(ray, None));
        match hit.filter(|hit| hit.distance <= far) {
            Some(hit) => self.with_surface(ray, &hit, self.medium_light(ray, hit.distance)?),
            None => self.medium_light(ray, far),
        }
    }

    /// Light and optical depth of the medium along a ray, up to a world distance.
    fn medium_light(&self, ray: &Ray, far: f64) -> Result<RayLight, RenderError> {
        cancel::poll();
        let ends: &[f64] = if far.is_finite() { &[far] } else { &[] };
        let mut segments = self.reference.segments(&self.scene, &self.view, ray, ends)?;
        segments.retain(|segment| segment.to <= far + 1e-9 * (segment.to - segment.from));
        let Some(last) = segments.last().and_then(|segment| segment.light) else { return Ok(RayLight::NOTHING) };

        let incoming = Incoming::new(&self.lights, &self.scattering, ray.direction);
        let (mut intervals, mut left_out) = self.intervals(&segments, incoming.max());
        let mut samples = 0;
        for _ in 0..MAX_ROUNDS {
            samples += self.integrate(ray, &incoming, &mut intervals)?;
            // Halves the intervals whose error is more than their part of what is allowed.
            let total: f64 = intervals.iter().map(|interval| interval.error).sum();
            if total <= self.tolerance || intervals.len() > MAX_INTERVALS {
                break;
            }
            let share = 0.5 * self.tolerance / intervals.len() as f64;
            intervals = intervals.iter().flat_map(|interval| halves(interval, share)).collect();
        }
        let mut radiance = [0.0; 3];
        for interval in &intervals {
            (0..3).for_each(|c| radiance[c] += interval.light[c]);
            left_out += interval.error + interval.of_samples;
        }
        Ok(RayLight {
            radiance,
            depth: last.depth,
            half_way: half_way(&segments),
            surface: f64::INFINITY,
            certainty: Certainty::Estimate(left_out),
            samples,
        })
    }

    /// Parts of the ray where there is something to see, and a bound on the light of the others.
    fn intervals(&self, segments: &[RaySegment], incoming: f64) -> (Vec<Interval>, f64) {
        let length = segments.last().map_or(0.0, |s| s.to) - segments.first().map_or(0.0, |s| s.from);
        let brightest = incoming + self.scene.transfer.brightest_color();
        let mut left_out = 0.0;
        let mut in_front = 1.0;
        let mut intervals = Vec::new();
        for segment in segments {
            let Some(light) = segment.light else { continue };
            let emitted =
                if self.scene.transfer.has_emission() { light.light.into_iter().fold(0.0, f64::max) } else { 0.0 };
            let most = in_front * ((1.0 - light.transparency) * brightest + emitted);
            in_front = libm::exp(-light.depth);
            let sliver = segment.to - segment.from < 1e-9 * length;
            if most == 0.0 {
                continue;
            }
            if sliver || left_out + most < NEGLIGIBLE * self.tolerance {
                left_out += most;
                continue;
            }
            intervals.push(Interval {
                from: segment.from,
                to: segment.to,
                light: [0.0; 3],
                error: 0.0,
                of_samples: 0.0,
                solved: false,
            });
        }
        (intervals, left_out)
    }

    /// Integrates the intervals that are not solved yet; returns the number of places looked at.
    fn integrate(&self, ray: &Ray, incoming: &Incoming<'_>, intervals: &mut [Interval]) -> Result<u64, RenderError> {
        let mut places = Vec::new();
        for interval in intervals.iter().filter(|interval| !interval.solved) {
            let (middle, half) = (0.5 * (interval.from + interval.to), 0.5 * (interval.to - interval.from));
            places.extend(RULE.iter().map(|point| middle + half * point[0]));
        }
        // One account of the ray, cut at all places: it tells value and depth of each.
        let segments = self.reference.segments(&self.scene, &self.view, ray, &places)?;
        let sample = |s: f64| self.sample(ray, incoming, &segments, s);
        let samples: Vec<Sample> = places.iter().map(|&s| sample(s)).collect::<Result<_, _>>()?;
        let unsolved = intervals.iter_mut().filter(|interval| !interval.solved);
        for (interval, samples) in unsolved.zip(samples.chunks_exact(RULE.len())) {
            let values: [[f64; 3]; 7] = std::array::from_fn(|i| samples[i].source);
            let length = interval.to - interval.from;
            let (light, error) = integrate(&values, length);
            let of_samples: f64 = RULE.iter().zip(samples).map(|(point, s)| point[1] * s.error).sum();
            *interval = Interval { light, error, of_samples: 0.5 * length * of_samples, solved: true, ..*interval };
        }
        Ok(places.len() as u64)
    }

    /// The integrand at a distance along the ray.
    fn sample(
        &self,
        ray: &Ray,
        incoming: &Incoming<'_>,
        segments: &[RaySegment],
        s: f64,
    ) -> Result<Sample, RenderError> {
        // The segment that begins here: rounding may have put its beginning a little before or behind.
        let after = segments.partition_point(|segment| segment.from < s);
        let nearer = |i: usize| segments.get(i).map_or(f64::INFINITY, |segment| (segment.from - s).abs());
        let i = if after > 0 && nearer(after - 1) < nearer(after) { after - 1 } else { after };
        let Some(segment) = segments.get(i) else { return Ok(Sample::default()) };
        let value = segment.values[0];
        let front = i.checked_sub(1).and_then(|before| segments[before].light);
        let (depth, front_error) = front.map_or((0.0, 0.0), |light| (light.depth, light.running.value()));
        let front = libm::exp(-depth);
        if !value.is_finite() || front == 0.0 {
            return Ok(Sample::default());
        }
        let medium = coefficients(&self.scene.transfer, &self.scattering, value);
        if medium.scattering == [0.0; 3] {
            let source = medium.emission.map(|q| front * q);
            let error = front_error * medium.emission.into_iter().fold(0.0, f64::max);
            return Ok(Sample { source, error });
        }
        let failed = RefCell::new(None);
        let scattered = incoming.at(ray.origin + s * ray.direction, front, |sun, towards| {
            let found = match sun {
                Some(sun) => self.sun_transmittance(sun, towards, None),
                None => self.transmittance(towards, None),
            };
            found.unwrap_or_else(|error| {
                failed.borrow_mut().get_or_insert(error);
                [0.0, 1.0]
            })
        });
        if let Some(error) = failed.into_inner() {
            return Err(error);
        }
        let source: [f64; 3] =
            std::array::from_fn(|c| medium.emission[c] + medium.scattering[c] * scattered.radiance[c]);
        let max = |values: [f64; 3]| values.into_iter().fold(0.0, f64::max);
        let error = front * max(medium.scattering) * scattered.error + front_error * max(source);
        Ok(Sample { source: source.map(|j| front * j), error })
    }
}

/// The interval, or its halves if its error is above a share.
fn halves(interval: &Interval, share: f64) -> Vec<Interval> {
    let middle = 0.5 * (interval.from + interval.to);
    let small = interval.to - interval.from <= 1e-9 * interval.to.abs();
    if interval.error <= share || small {
        return vec![*interval];
    }
    let open = Interval { light: [0.0; 3], error: 0.0, of_samples: 0.0, solved: false, ..*interval };
    vec![Interval { to: middle, ..open }, Interval { from: middle, ..open }]
}

/// Distance at which opacity reaches ½, the extinction of the segment in which it does taken as constant.
fn half_way(segments: &[RaySegment]) -> f64 {
    let mut before = 0.0;
    for segment in segments {
        let depth = segment.light.map_or(before, |light| light.depth);
        if depth >= std::f64::consts::LN_2 {
            let share = ((std::f64::consts::LN_2 - before) / (depth - before)).clamp(0.0, 1.0);
            return segment.from + share * (segment.to - segment.from);
        }
        before = depth;
    }
    f64::INFINITY
}
