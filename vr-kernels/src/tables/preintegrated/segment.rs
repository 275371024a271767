//! Light and opacity of a stretch, from means and ends.

use super::{PreIntegrated, TablePlace};
use vr_core::Real;
use vr_core::optics::opacity_of_depth;

impl<R: Real> PreIntegrated<R> {
    /// Light (r, g, b) and opacity of a stretch of `length` world units on which the value goes linearly from `front` to `back`, in stored
    /// units. Nothing if either is NaN.
    ///
    /// α = 1 − e^(−τ) with τ = κ̄·length is exact. The light, ∫ q e^(−τ) ds, is q̄·length·w(τ), exact where the colour is constant, and
    /// corrected by its change with depth: the part of the light that lies further in front is dimmed less. To the third order in
    /// the length the correction is
    ///
    /// e^(−τ/2) (q₀κ₁ − q₁κ₀) length²/12, q₀ and κ₀ being those in front and q₁ and κ₁ those at the back: −Δc·τ²/12·e^(−τ/2) for a colour
    /// that changes by Δc.
    ///
    /// Without it, a rule made of such stretches cannot have an order above 2.
    #[inline(always)]
    pub fn segment(&self, front: R, back: R, length: R) -> [R; 4] {
        if front.is_nan() || back.is_nan() {
            return [R::ZERO; 4];
        }
        self.segment_between(self.place(front), self.place(back), length)
    }

    /// Light and opacity of a stretch on which the value is the parabola through three equidistant samples. Nothing if any is NaN.
    ///
    /// The parabola is walked as two chords, from its begin to its middle and on to its end. A parabola whose middle lies δ above the
    /// straight line from begin to end bulges above each chord by δ/6 in the mean: both chords are raised by that, and the mean of
    /// the value is Simpson's. What the chords still differ from the parabola is of the fourth order, like Simpson's rule, but stays so at
    /// kinks of the transfer function.
    #[inline(always)]
    pub fn segment3(&self, front: R, middle: R, back: R, length: R) -> [R; 4] {
        let delta = middle - R::from_f64(0.5) * (front + back);
        let raise = delta * R::from_f64(1.0 / 6.0);
        if raise.is_nan() {
            return [R::ZERO; 4];
        }
        let samples = [front, middle, back];
        // A parabola may leave the range of the field's values; into a wall it must not.
        let raise = if !self.walls.is_empty() && self.overshoots(samples, raise) { R::ZERO } else { raise };
        let [front, middle, back] = samples.map(|v| self.place(v + raise));
        let half = R::from_f64(0.5) * length;
        behind(self.segment_between(front, middle, half), self.segment_between(middle, back, half))
    }

    /// Light and opacity like [`PreIntegrated::segment`], between places that are already known.
    #[inline(always)]
    pub fn segment_between(&self, front: TablePlace<R>, back: TablePlace<R>, length: R) -> [R; 4] {
        if self.has_walls()
            && let Some(step) = self.segment_to_wall(front, back, length)
        {
            return step;
        }
        self.open_segment(front, back, length)
    }

    /// A stretch without a wall.
    #[inline(always)]
    pub(super) fn open_segment(&self, front: TablePlace<R>, back: TablePlace<R>, length: R) -> [R; 4] {
        let mean = self.mean_between(front, back);
        // Most of a typical scan is air.
        if mean == [R::ZERO; 4] {
            return mean;
        }
        let tau = mean[3] * length;
        let alpha = opacity_of_depth(tau);
        let weight = if tau == R::ZERO { R::ONE } else { alpha / tau };
        let (a, b) = (self.at(front), self.at(back));
        // τ²·/12 e^(−τ/2), by a quotient that follows the projection of the light onto linear colours, 1 − α/2 − α/τ, to 1.5 % up to τ = 4.
        let fade = R::ONE / (R::from_f64(12.0) + tau * (R::from_f64(6.0) + R::from_f64(1.5) * tau));
        // Optical depths, so that worlds of any scale neither overflow nor vanish. Where both ends are denser than the mean, their
        // product counts no more than the mean's square. 0/0 is NaN, which `min` passes over.
        let (tau_a, tau_b) = (a[3] * length, b[3] * length);
        let moment = fade * (tau * tau / (tau_a * tau_b)).min(R::ONE);
        let light = |c: usize| {
            let l = mean[c] * length * weight + moment * (a[c] * length * tau_b - b[c] * length * tau_a);
            let l = l.max(R::ZERO);
            self.brightest.map_or(l, |max| l.min(max[c] * alpha))
        };
        [light(0), light(1), light(2), alpha]
    }
}

/// Light and opacity of two consecutive steps together: the second one is dimmed by the first.
#[inline(always)]
pub(super) fn behind<R: Real>(front: [R; 4], back: [R; 4]) -> [R; 4] {
    let clear = R::ONE - front[3];
    std::array::from_fn(|c| front[c] + clear * back[c])
}
