//! Solutions with more and more directions, until two agree.

use vr_core::ParameterError;

use super::directions::Directions;
use super::illumination::{Illumination, MIN_COSINE};
use super::layer::Slab;
use super::operators::Operators;
use super::solution::{Estimated, Level, Probes, SlabSolution};

/// Directions in a hemisphere to begin with.
const MIN_POINTS: usize = 8;
/// Largest number of directions in a hemisphere.
const MAX_POINTS: usize = 128;
/// Largest number of depths, and of cosines.
const MAX_PROBES: usize = 1000;
/// Smallest tolerance: rounding is below.
const MIN_TOLERANCE: f64 = 1e-12;

impl Slab {
    /// Solves for the light in the slab. The tolerance is absolute, in units of the incident flux or of the flux π·source of the slab's own
    /// sources, whichever is larger.
    ///
    /// There are at most 128 directions in each hemisphere. Lobes sharper than g = 0.95, seen along their axis, need more: the errors told are then
    /// above the tolerance.
    ///
    /// # Errors
    /// An illumination, a depth, a cosine or a tolerance out of range.
    pub fn solve(&self, light: &Illumination, probes: &Probes, tolerance: f64) -> Result<SlabSolution, ParameterError> {
        light.validate()?;
        self.check(probes, tolerance)?;
        let scale = light.flux().max(std::f64::consts::PI * self.max_source());
        let mut points = MIN_POINTS;
        let mut coarse = self.solve_with(light, probes, points);
        loop {
            points *= 2;
            let mut fine = self.solve_with(light, probes, points);
            let mut max_error = 0.0f64;
            fine.compare(&mut coarse, |fine, coarse| {
                fine.error = (fine.value - coarse.value).abs();
                max_error = max_error.max(fine.error);
            });
            if max_error <= tolerance * scale || points >= MAX_POINTS {
                return Ok(fine);
            }
            coarse = fine;
        }
    }

    fn check(&self, probes: &Probes, tolerance: f64) -> Result<(), ParameterError> {
        if probes.depths.len().max(probes.cosines.len()) > MAX_PROBES {
            let found = [probes.depths.len(), probes.cosines.len()];
            return Err(ParameterError::new("probes", found, "must be 1000 depths and 1000 cosines at most"));
        }
        let thickness = self.thickness();
        if let Some(depth) = probes.depths.iter().find(|depth| !(0.0..=thickness).contains(*depth)) {
            return Err(ParameterError::new("probes.depths", depth, "must be 0 to the slab's optical thickness"));
        }
        if let Some(cosine) = probes.cosines.iter().find(|cosine| !(MIN_COSINE..=1.0).contains(*cosine)) {
            return Err(ParameterError::new("probes.cosines", cosine, "must be 1e-6 to 1"));
        }
        if !(MIN_TOLERANCE..=1.0).contains(&tolerance) {
            return Err(ParameterError::new("tolerance", tolerance, "must be 1e-12 to 1"));
        }
        Ok(())
    }

    /// The solution with a number of directions in each hemisphere.
    fn solve_with(&self, light: &Illumination, probes: &Probes, points: usize) -> SlabSolution {
        let mut besides = probes.cosines.clone();
        if let Illumination::Beam { cosine, .. } = *light {
            besides.push(cosine);
        }
        let directions = Directions::new(points, &besides);
        let level = |depth, parts: &[Operators; 2]| level(light, probes, &directions, depth, parts);
        let at_bottom = self.parts(&directions, f64::INFINITY);
        let (bottom, own_bottom) = level(self.thickness(), &at_bottom);
        let [layers, ground] = at_bottom;
        let at_top = [Operators::empty(directions.len()), layers.on_top_of(&ground, &directions.weights)];
        let (top, whole) = level(0.0, &at_top);
        let levels = probes.depths.iter().map(|&depth| level(depth, &self.parts(&directions, depth)).0).collect();
        let exact = |value| Estimated { value, error: 0.0 };
        SlabSolution {
            incident: light.flux(),
            absorbed: exact(incoming_flux(light, &directions, &whole.emissivity)),
            emitted_up: exact(whole.own[1]),
            emitted_down: exact(own_bottom.own[0]),
            top,
            bottom,
            levels,
            points,
        }
    }
}

/// Light between what is above a depth and what is below it.
fn level(
    light: &Illumination,
    probes: &Probes,
    directions: &Directions,
    depth: f64,
    [above, below]: &[Operators; 2],
) -> (Level, OwnLight) {
    let own = above.emission_between(below, &directions.weights, 0);
    let [mut down, mut up] = outside_light(light, directions, above, below);
    let [direct, direct_fluence] = light.direct(directions, depth);
    // A part of the forward peak counts as unscattered for the solver: the diffuse flux is what is left of all.
    let beam = match *light {
        Illumination::Beam { flux, .. } => flux * above.direct[directions.len() - 1],
        _ => 0.0,
    };
    let beam_fluence = match *light {
        Illumination::Beam { cosine, .. } => beam / cosine - direct_fluence,
        _ => -direct_fluence,
    };
    let own_flux = [directions.flux(&own[0]), directions.flux(&own[1])];
    for i in 0..directions.len() {
        down[i] += own[0][i];
        up[i] += own[1][i];
    }
    let exact = |value| Estimated { value, error: 0.0 };
    let asked = |radiance: &[f64]| -> Vec<Estimated> {
        let first = directions.points;
        radiance[first..first + probes.cosines.len()].iter().map(|&i| exact(i)).collect()
    };
    let fluence = directions.fluence(&down) + directions.fluence(&up) + beam_fluence + direct_fluence;
    let level = Level {
        depth,
        direct: exact(direct),
        down: exact(directions.flux(&down) + beam - direct),
        up: exact(directions.flux(&up)),
        fluence: exact(fluence),
        radiance_down: asked(&down),
        radiance_up: asked(&up),
    };
    let emissivity = below.emissions[1].up.clone();
    (level, OwnLight { own: own_flux, emissivity })
}

/// Light of the slab's own sources at a depth.
struct OwnLight {
    /// Flux down and up.
    own: [f64; 2],
    /// Radiance up of a source of 1 in everything below.
    emissivity: Vec<f64>,
}

/// Radiance down and up between two parts of a slab, of light from outside, without what is left of a beam.
fn outside_light(light: &Illumination, directions: &Directions, above: &Operators, below: &Operators) -> [Vec<f64>; 2] {
    let n = directions.len();
    match *light {
        Illumination::Dark => [vec![0.0; n], vec![0.0; n]],
        Illumination::Beam { cosine, flux } => {
            let between = above.between(below, &directions.weights);
            let radiance = flux / (2.0 * std::f64::consts::PI * cosine);
            [between.down, between.up].map(|kernel| (0..n).map(|i| radiance * kernel[(i, n - 1)]).collect())
        }
        Illumination::Diffuse { radiance } => {
            let between = above.between(below, &directions.weights);
            let incoming = vec![radiance; n];
            let [mut down, up] =
                [between.down, between.up].map(|kernel| kernel.weighted_vector(&directions.weights, &incoming));
            down.iter_mut().zip(&above.direct).for_each(|(i, direct)| *i += direct * radiance);
            [down, up]
        }
    }
}

/// Flux of the incoming light, each direction counted by a share.
fn incoming_flux(light: &Illumination, directions: &Directions, share: &[f64]) -> f64 {
    match *light {
        Illumination::Dark => 0.0,
        Illumination::Beam { flux, .. } => flux * share[directions.len() - 1],
        Illumination::Diffuse { radiance } => radiance * directions.flux(share),
    }
}

impl SlabSolution {
    /// Visits all numbers of two solutions of the same slab.
    fn compare(&mut self, other: &mut Self, mut visit: impl FnMut(&mut Estimated, &Estimated)) {
        self.numbers().into_iter().zip(other.numbers()).for_each(|(a, b)| visit(a, b));
    }

    fn numbers(&mut self) -> Vec<&mut Estimated> {
        let mut all = vec![&mut self.absorbed, &mut self.emitted_up, &mut self.emitted_down];
        for level in [&mut self.top, &mut self.bottom].into_iter().chain(&mut self.levels) {
            all.extend([&mut level.direct, &mut level.down, &mut level.up, &mut level.fluence]);
            all.extend(level.radiance_down.iter_mut().chain(&mut level.radiance_up));
        }
        all
    }
}
