//! Reflection of a step in which the normal turns.
//!
//! A normal is a gradient without its length. Where the gradient is small, on a plateau or between noisy voxels, it turns far within a fraction of a
//! voxel, and the normal in the middle of a step says little about the rest of it. So the gradient is followed along its tangent over the step, and
//! what it reflects is summed by the rule of Gauss and Legendre of three points, which takes no more samples of the field than the middle alone:
//!
//! ```text
//! F = (5/18 + e)·F(g − x·turn) + 8/18·F(g) + (5/18 − e)·F(g + x·turn),   x = ½·√(3/5)
//! ```
//!
//! The front of a step hides its back, so that `e` shifts weight to the front: as much as in the light of a homogeneous step.

use crate::real::Real;
use crate::shading::RayShading;

/// Distance of the outer points from the middle, in steps: ½·√(3/5).
pub const NODE: f64 = 0.387_298_334_620_741_7;
/// Weight of each outer point in a clear step.
pub const SIDE: f64 = 5.0 / 18.0;
/// Weight of the middle.
pub const MIDDLE: f64 = 8.0 / 18.0;
/// Turn, as a part of the gradient's largest component, up to which the middle stands for all of the step. From there to twice as much, the mean takes
/// its place by and by, so that pictures have no seams.
pub const SMALLEST: f64 = 0.25;

/// The weight that moves from the far point to the near one in a step of an opacity: τ/(24·x) with the first terms of τ = −ln(1 − α).
pub fn lean<R: Real>(alpha: R) -> R {
    let series = R::ONE + alpha * (R::from_f64(1.0 / 2.0) + alpha * R::from_f64(1.0 / 3.0));
    alpha * series * R::from_f64(1.0 / (24.0 * NODE))
}

impl<R: Real> RayShading<R> {
    /// Reflection of a step of opacity `alpha` over which the world gradient changes by `turn`, from half of it before the middle to half behind: (factor on
    /// the colour, light added). Where the gradient in the middle is zero, nothing is shaded.
    ///
    /// # Examples
    /// ```
    /// use glam::DVec3;
    /// use vr_core::{Light, Shading};
    ///
    /// let along = Shading::default().along::<f64>(&[Light::default()], DVec3::Z);
    /// let (still, turning) = (along.reflect([0.0, 0.0, 1.0]), along.reflect_turning([0.0, 0.0, 1.0], [3.0, 0.0, 0.0], 0.1));
    /// assert_eq!(along.reflect_turning([0.0, 0.0, 1.0], [0.2, 0.0, 0.0], 0.1), still, "a turn too small to be seen");
    /// assert!(turning.0[0] < still.0[0], "it faces the eye only in the middle");
    /// ```
    #[inline]
    pub fn reflect_turning(&self, gradient: [R; 3], turn: [R; 3], alpha: R) -> ([R; 3], [R; 3]) {
        let middle = self.reflect(gradient);
        let size = |v: [R; 3]| v[0].abs().max(v[1].abs()).max(v[2].abs());
        let (length, smallest) = (size(gradient), R::from_f64(SMALLEST));
        let share = (size(turn) / (length * smallest) - R::ONE).min(R::ONE);
        // False for NaN, of no turn or no gradient.
        if !(share > R::ZERO && length > R::ZERO) {
            return middle;
        }
        let at = |x: f64| self.reflect(std::array::from_fn(|a| gradient[a] + turn[a] * R::from_f64(x)));
        let (near, far, lean) = (at(-NODE), at(NODE), lean(alpha));
        let (side, own) = (R::from_f64(SIDE), R::from_f64(MIDDLE));
        let mean = |near: R, middle: R, far: R| {
            let mean = near * (side + lean) + middle * own + far * (side - lean);
            middle + (mean - middle) * share
        };
        let of = |near: [R; 3], middle: [R; 3], far: [R; 3]| std::array::from_fn(|c| mean(near[c], middle[c], far[c]));
        (of(near.0, middle.0, far.0), of(near.1, middle.1, far.1))
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::{Light, Shading};

    /// Mean over the step, by many points, weighted with what comes through.
    fn mean(along: &RayShading<f64>, g: [f64; 3], turn: [f64; 3], alpha: f64) -> f64 {
        let (n, tau) = (4000, -(1.0 - alpha).ln());
        let (mut sum, mut all) = (0.0, 0.0);
        for i in 0..n {
            let t = (f64::from(i) + 0.5) / f64::from(n) - 0.5;
            let weight = (-tau * t).exp();
            sum += weight * along.reflect(std::array::from_fn(|a| g[a] + turn[a] * t)).0[0];
            all += weight;
        }
        sum / all
    }

    #[test]
    fn turning_normals_are_followed() {
        let light = Light { direction: Some(DVec3::new(0.3, 0.5, -1.0)), ..Light::default() };
        let along = Shading::default().along::<f64>(&[Light::default(), light], DVec3::Z);
        let mut worst = [0.0f64; 2];
        for k in 0..200 {
            let random = |i: u32| f64::from((k * 7 + i).wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 23) - 1.0;
            let (g, turn) = ([random(0), random(1), random(2)], [random(3), random(4), random(5)]);
            let alpha = 0.2 * (random(6) + 1.0);
            let exact = mean(&along, g, turn, alpha);
            let error = |found: f64| (found - exact).abs();
            worst[0] = worst[0].max(error(along.reflect(g).0[0]));
            worst[1] = worst[1].max(error(along.reflect_turning(g, turn, alpha).0[0]));
        }
        // Measured: 0.41 and 0.09.
        assert!(worst[1] < 0.15 && worst[1] < 0.3 * worst[0], "{worst:?}");
    }

    #[test]
    fn the_mean_leans_to_the_front_as_light_does() {
        let along = Shading::default().along::<f64>(&[Light::default()], DVec3::Z);
        let (g, turn) = ([0.5, 0.0, 1.0], [0.5, 0.0, 0.0]);
        for alpha in [0.0, 0.2, 0.6] {
            let (found, exact) = (along.reflect_turning(g, turn, alpha).0[0], mean(&along, g, turn, alpha));
            assert!((found - exact).abs() < 5e-4, "{alpha}: {found} {exact}");
        }
    }

    #[test]
    fn no_gradient_and_no_turn_are_as_they_are() {
        let along = Shading::default().along::<f64>(&[Light::default()], DVec3::Z);
        assert_eq!(along.reflect_turning([0.0; 3], [1.0; 3], 0.5), ([1.0; 3], [0.0; 3]));
        assert_eq!(along.reflect_turning([0.0; 3], [0.0; 3], 0.5), ([1.0; 3], [0.0; 3]));
        let tiny = [1e-300, 0.0, 1e-300];
        assert_eq!(along.reflect_turning(tiny, [0.0; 3], 0.5), along.reflect(tiny));
        let (factor, added) = along.reflect_turning(tiny, [1e300; 3], 0.5);
        assert!(factor.iter().chain(&added).all(|x| x.is_finite()));
    }
}
