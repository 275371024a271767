//! Directions in which radiance is followed.

use super::gauss::gauss_legendre;

/// Cosines of directions with the weights of a quadrature over them, the same for light that goes up and down.
pub(super) struct Directions {
    /// Cosines to the slab's normal, above 0.
    pub(super) cosines: Vec<f64>,
    /// Weights of the integral from 0 to 1; 0 for directions that are only looked along.
    pub(super) weights: Vec<f64>,
    /// Number of directions with weight, which come first.
    pub(super) points: usize,
}

impl Directions {
    /// Gauss's points over the root of the cosine, and some directions besides.
    ///
    /// Radiance has a kink like μ ln μ at grazing directions; over the root of μ it is smoother, and the points crowd there. An even polynomial of
    /// the
    /// cosine up to degree n − 1 is still integrated exactly, which conserves the energy of scattered light.
    pub(super) fn new(points: usize, besides: &[f64]) -> Self {
        let (mut cosines, mut weights): (Vec<f64>, Vec<f64>) = gauss_legendre(points)
            .into_iter()
            .map(|[x, weight]| {
                let root = 0.5 * (1.0 + x);
                (root * root, weight * root)
            })
            .unzip();
        cosines.extend_from_slice(besides);
        weights.resize(cosines.len(), 0.0);
        Self { cosines, weights, points }
    }

    pub(super) fn len(&self) -> usize {
        self.cosines.len()
    }

    /// e^(−τ/μ) for each direction.
    pub(super) fn direct(&self, thickness: f64) -> Vec<f64> {
        self.cosines.iter().map(|mu| libm::exp(-thickness / mu)).collect()
    }

    /// Flux of a radiance: 2π ∫ μ I dμ.
    pub(super) fn flux(&self, radiance: &[f64]) -> f64 {
        let terms = self.cosines.iter().zip(&self.weights).zip(radiance).map(|((mu, w), i)| w * mu * i);
        2.0 * std::f64::consts::PI * terms.sum::<f64>()
    }

    /// Fluence of a radiance in one hemisphere: 2π ∫ I dμ.
    pub(super) fn fluence(&self, radiance: &[f64]) -> f64 {
        let terms = self.weights.iter().zip(radiance).map(|(w, i)| w * i);
        2.0 * std::f64::consts::PI * terms.sum::<f64>()
    }
}
