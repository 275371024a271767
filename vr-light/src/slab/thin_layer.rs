//! Layers of one medium: a thin one by a series, thick ones by doubling it.

use super::directions::Directions;
use super::gauss::legendre;
use super::layer::{Layer, Slab};
use super::matrix::Matrix;
use super::moments::legendre_moments;
use super::operators::{Emission, Operators, Response};

/// Largest norm of the generator times the thickness of the layer that doubling starts with.
const MAX_NORM: f64 = 0.25;
/// Terms of the exponential's series: the next is 0.25¹³/13! = 10⁻¹⁸.
const TERMS: usize = 13;

/// A layer's scattering with the part of the forward peak that the directions cannot tell from unscattered light taken as unscattered
/// (Wiscombe, "The delta-M method", 1977).
pub(super) struct ScaledLayer {
    albedo: f64,
    /// Optical thickness per true optical thickness.
    stretch: f64,
    /// Source of the medium in units of radiance.
    source: f64,
    moments: Vec<f64>,
}

impl ScaledLayer {
    pub(super) fn new(layer: &Layer, points: usize) -> Self {
        // Moments up to degree n − 1 are integrated exactly.
        let mut moments = legendre_moments(&layer.phase, points + 1);
        let peak = moments.pop().unwrap_or(0.0).max(0.0);
        for moment in &mut moments {
            *moment = (*moment - peak) / (1.0 - peak);
        }
        let stretch = (1.0 - layer.albedo) + layer.albedo * (1.0 - peak);
        let albedo = layer.albedo * (1.0 - peak) / stretch;
        Self { albedo, stretch, source: layer.source, moments }
    }

    /// Operators of a part of the layer with this true optical thickness.
    pub(super) fn operators(&self, directions: &Directions, thickness: f64, true_albedo: f64) -> Operators {
        let thickness = thickness * self.stretch;
        if thickness == 0.0 {
            return Operators::empty(directions.len());
        }
        let min = directions.cosines.iter().copied().fold(1.0, f64::min);
        // The albedo adds to the norm as much again as extinction does.
        let doublings = libm::ceil(libm::log2(2.0 * thickness / (min * MAX_NORM))).max(0.0) as i32;
        let thin = thickness / 2f64.powi(doublings);
        let absorbed = (1.0 - true_albedo) / self.stretch;
        let mut operators = self.thin(directions, thin, absorbed);
        for i in 1..=doublings {
            let direct = directions.direct(thin * 2f64.powi(i));
            operators = operators.doubled(direct, &directions.weights);
        }
        operators
    }

    /// A layer so thin that the exponential of its generator is a short series.
    ///
    /// Radiance down and up obeys dI/dτ = (D + B W) I + s, D being −1/μ and 1/μ, B what is scattered, W the weights. Powers of the generator are
    /// Dᵏ + Y W, which keeps the unscattered part apart; so the directions without weight need no care.
    fn thin(&self, directions: &Directions, thickness: f64, absorbed: f64) -> Operators {
        let n = directions.len();
        let decay: Vec<f64> =
            (0..2 * n).map(|i| if i < n { -1.0 } else { 1.0 } * thickness / directions.cosines[i % n]).collect();
        let scattered = self.redistribution(directions);
        let generator = Matrix::from_fn(2 * n, |i, j| {
            let same = (i < n) == (j < n);
            -0.5 * self.albedo * decay[i] * scattered[usize::from(!same)][(i % n, j % n)]
        });
        let weights: Vec<f64> = (0..2 * n).map(|i| directions.weights[i % n]).collect();

        // The exponential's diffuse part, and the integral of the exponential times the source, term by term.
        let mut power = generator.clone();
        let mut decay_power = decay.clone();
        let mut exponential = generator.clone();
        let mut source: Vec<f64> = decay.iter().map(|d| -absorbed * d).collect();
        let mut emitted = source.clone();
        for k in 2..=TERMS {
            let inverse = 1.0 / k as f64;
            let next = power.clone().scaled_rows(&decay).plus(&generator.clone().scaled_columns(&decay_power));
            power = next.plus(&generator.weighted(&weights, &power)).scaled_columns(&vec![inverse; 2 * n]);
            decay_power.iter_mut().zip(&decay).for_each(|(p, d)| *p *= d * inverse);
            exponential = exponential.plus(&power);
            let scattered = generator.weighted_vector(&weights, &source);
            for (i, s) in source.iter_mut().enumerate() {
                *s = (decay[i] * *s + scattered[i]) * inverse;
                emitted[i] += *s;
            }
        }

        // From light at the upper side to light at the lower one, to light that comes in and light that goes out.
        let block = |row: usize, column: usize| exponential.block(row * n, column * n, n);
        let growth: Vec<f64> = decay[n..].iter().map(|d| libm::exp(*d)).collect();
        let upward = block(1, 1);
        let upward =
            Matrix::from_fn(n, |i, j| upward[(i, j)] * directions.weights[j] + if i == j { growth[i] } else { 0.0 });
        let upward = upward.factorized();
        let reflection = upward.solve(&block(1, 0).scaled_rows(&vec![-1.0; n]));
        let down_of_up = block(0, 1);
        let transmission = block(0, 0).plus(&down_of_up.weighted(&directions.weights, &reflection));
        let up = upward.solve_vector(&emitted[n..].iter().map(|e| -e).collect::<Vec<_>>());
        let returned = down_of_up.weighted_vector(&directions.weights, &up);
        let down = emitted[..n].iter().zip(returned).map(|(e, r)| e + r).collect();
        let unit = Emission { up, down };
        let scaled = |values: &[f64]| values.iter().map(|v| v * self.source).collect();
        let own = Emission { up: scaled(&unit.up), down: scaled(&unit.down) };
        let response = Response { reflection, transmission };
        Operators {
            direct: directions.direct(thickness),
            below: response.clone(),
            above: response,
            emissions: [own, unit],
        }
    }

    /// The phase function, averaged over azimuth, for light that stays in its hemisphere and for light that changes it: Σ (2l + 1) χ P(±μ) P(μ′).
    fn redistribution(&self, directions: &Directions) -> [Matrix; 2] {
        let count = self.moments.len();
        let polynomials: Vec<Vec<f64>> = directions.cosines.iter().map(|&mu| legendre(count, mu)).collect();
        let sum = |i: usize, j: usize, odd: f64| -> f64 {
            let terms = self.moments.iter().enumerate().map(|(l, moment)| {
                let sign = if l % 2 == 1 { odd } else { 1.0 };
                sign * (2.0 * l as f64 + 1.0) * moment * polynomials[i][l] * polynomials[j][l]
            });
            terms.sum()
        };
        [1.0, -1.0].map(|odd| Matrix::from_fn(directions.len(), |i, j| sum(i, j, odd)))
    }
}

impl Slab {
    /// Operators of everything above a depth, and of everything below it, with the ground.
    pub(super) fn parts(&self, directions: &Directions, depth: f64) -> [Operators; 2] {
        let weights = &directions.weights;
        let mut above = Operators::empty(directions.len());
        let mut below: Option<Operators> = None;
        let mut top = 0.0;
        for layer in self.layers() {
            let scaled = ScaledLayer::new(layer, directions.points);
            let upper = (depth - top).clamp(0.0, layer.thickness);
            let part = |thickness| scaled.operators(directions, thickness, layer.albedo);
            if upper > 0.0 {
                above = above.on_top_of(&part(upper), weights);
            }
            if upper < layer.thickness {
                let rest = part(layer.thickness - upper);
                below = Some(below.map_or(rest.clone(), |b| b.on_top_of(&rest, weights)));
            }
            top += layer.thickness;
        }
        let ground = Operators::ground(directions, self.ground().albedo, self.ground().emission);
        [above, below.map_or(ground.clone(), |b| b.on_top_of(&ground, weights))]
    }
}
