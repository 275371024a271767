//! Reflection and transmission of layers, and how two layers become one.

use super::directions::Directions;
use super::matrix::Matrix;

/// A layer's response to light from above: kernels K of I(μ) = ∫ K(μ, μ′) I₀(μ′) dμ′. What passes unscattered is kept apart.
#[derive(Clone)]
pub(super) struct Response {
    pub(super) reflection: Matrix,
    pub(super) transmission: Matrix,
}

/// Light that a layer emits by itself, for each direction.
#[derive(Clone)]
pub(super) struct Emission {
    pub(super) up: Vec<f64>,
    pub(super) down: Vec<f64>,
}

/// A layer, or several: responses to light from above and from below, and emissions.
#[derive(Clone)]
pub(super) struct Operators {
    /// Share that passes unscattered, for each direction.
    pub(super) direct: Vec<f64>,
    pub(super) above: Response,
    pub(super) below: Response,
    /// Emission of the medium's own source, and of a source of 1 everywhere in the medium, which is by reciprocity what it absorbs.
    pub(super) emissions: [Emission; 2],
}

/// Light between two layers that is sent in from above: the kernels of its diffuse part.
pub(super) struct Between {
    pub(super) down: Matrix,
    pub(super) up: Matrix,
}

impl Operators {
    /// A layer that is not there.
    pub(super) fn empty(size: usize) -> Self {
        let response = Response { reflection: Matrix::zero(size), transmission: Matrix::zero(size) };
        let emission = Emission { up: vec![0.0; size], down: vec![0.0; size] };
        Self {
            direct: vec![1.0; size],
            above: response.clone(),
            below: response,
            emissions: [emission.clone(), emission],
        }
    }

    /// An opaque surface that reflects by Lambert's law, and glows.
    pub(super) fn ground(directions: &Directions, albedo: f64, emission: f64) -> Self {
        let size = directions.len();
        let mut ground = Self::empty(size);
        ground.direct = vec![0.0; size];
        ground.above.reflection = Matrix::from_fn(size, |_, j| 2.0 * albedo * directions.cosines[j]);
        ground.emissions[0].up = vec![emission; size];
        ground
    }

    /// Light between this layer and one below, by the series of reflections between them, summed: (1 − R₁R₂)⁻¹.
    pub(super) fn between(&self, lower: &Self, weights: &[f64]) -> Between {
        let (r1, r2) = (&self.below.reflection, &lower.above.reflection);
        let twice = r1.weighted(weights, r2);
        let right = self.above.transmission.clone().plus(&twice.clone().scaled_columns(&self.direct));
        let down = one_minus(&twice, weights).factorized().solve(&right);
        let up = r2.clone().scaled_columns(&self.direct).plus(&r2.weighted(weights, &down));
        Between { down, up }
    }

    /// Light of the layers' own emission between this layer and one below: radiance down and up.
    pub(super) fn emission_between(&self, lower: &Self, weights: &[f64], source: usize) -> [Vec<f64>; 2] {
        let (r1, r2) = (&self.below.reflection, &lower.above.reflection);
        let returned = r1.weighted_vector(weights, &lower.emissions[source].up);
        let right = sum(&self.emissions[source].down, &returned);
        let down = one_minus(&r1.weighted(weights, r2), weights).factorized().solve_vector(&right);
        let up = sum(&lower.emissions[source].up, &r2.weighted_vector(weights, &down));
        [down, up]
    }

    /// This layer above another (van de Hulst, "Multiple Light Scattering", 1980, chapter 4; Grant & Hunt, "Discrete space theory of radiative
    /// transfer", 1969).
    pub(super) fn on_top_of(&self, lower: &Self, weights: &[f64]) -> Self {
        Self {
            direct: self.direct.iter().zip(&lower.direct).map(|(a, b)| a * b).collect(),
            above: self.combined(lower, weights),
            below: lower.flipped().combined(&self.flipped(), weights),
            emissions: [0, 1].map(|source| self.combined_emission(lower, weights, source)),
        }
    }

    /// Two layers like this one, which is the same from above and from below; `direct` is what passes both.
    pub(super) fn doubled(self, direct: Vec<f64>, weights: &[f64]) -> Self {
        let above = self.combined(&self, weights);
        let emissions = [0, 1].map(|source| self.combined_emission(&self, weights, source));
        Self { direct, below: above.clone(), above, emissions }
    }

    fn combined(&self, lower: &Self, weights: &[f64]) -> Response {
        let Between { down, up } = self.between(lower, weights);
        let escaped = up.clone().scaled_rows(&self.direct).plus(&self.below.transmission.weighted(weights, &up));
        let t2 = &lower.above.transmission;
        let passed = t2.clone().scaled_columns(&self.direct).plus(&t2.weighted(weights, &down));
        Response {
            reflection: self.above.reflection.clone().plus(&escaped),
            transmission: down.scaled_rows(&lower.direct).plus(&passed),
        }
    }

    fn combined_emission(&self, lower: &Self, weights: &[f64], source: usize) -> Emission {
        let [down, up] = self.emission_between(lower, weights, source);
        let through = |direct: &[f64], transmission: &Matrix, light: &[f64], own: &[f64]| {
            let scattered = transmission.weighted_vector(weights, light);
            let terms = direct.iter().zip(light).zip(scattered).zip(own);
            terms.map(|(((d, i), s), o)| d * i + s + o).collect()
        };
        Emission {
            up: through(&self.direct, &self.below.transmission, &up, &self.emissions[source].up),
            down: through(&lower.direct, &lower.above.transmission, &down, &lower.emissions[source].down),
        }
    }

    fn flipped(&self) -> Self {
        let turned = |e: &Emission| Emission { up: e.down.clone(), down: e.up.clone() };
        Self {
            direct: self.direct.clone(),
            above: self.below.clone(),
            below: self.above.clone(),
            emissions: [turned(&self.emissions[0]), turned(&self.emissions[1])],
        }
    }
}

/// 1 − K W.
fn one_minus(kernel: &Matrix, weights: &[f64]) -> Matrix {
    Matrix::from_fn(kernel.size(), |i, j| f64::from(u8::from(i == j)) - kernel[(i, j)] * weights[j])
}

fn sum(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}
