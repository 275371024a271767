//! Gradients of points' kernels along chords, in closed form.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_core::PointKernel;
use vr_kernels::vector::{ln, opacity_of_depth, pick, splat};

/// The gradient of a kernel of scattered points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PointGradient {
    kernel: PointKernel,
    /// C, the factor of the kernel's formula.
    factor: f32,
}

/// Integrals of a kernel's gradient along chords that pass its middle at distances b, from the place nearest to it to a place z, in radii.
///
/// At z the gradient is (W'(t)/t)·(a + z·d), with t² = b² + z², d the direction of the ray and a the vector, b long, to the ray's nearest place. Along d the
/// integral is W itself; along a it is J(z) = ∫₀ᶻ W'(t)/t ds:
/// - cubic spline, whose factor is C: C (−12 z + 9 A) up to t = ½ and C (−6 L + 12 z − 3 A) beyond, less what that is at ½, where L = ln((z + t)/b) and
///   A = z t + b² L;
/// - Gaussian: W'(t)/t = −9 (W + C e^(−4.5)), so that J = −9 (∫W + C e^(−4.5) z);
/// - cone: −C L.
pub(crate) struct GradientCourse<S: Simd> {
    of: PointGradient,
    b: f32x16<S>,
    square: f32x16<S>,
    ln: f32x16<S>,
    /// Place z at which t is ½, or 0, and ln(z + t) there.
    bend: [f32x16<S>; 2],
}

/// J and W at the place of a chord.
#[derive(Clone, Copy)]
pub(crate) struct GradientSum<S: Simd> {
    pub(crate) across: f32x16<S>,
    pub(crate) along: f32x16<S>,
}

/// e^(−4.5), by which a Gaussian is lowered.
const EDGE: f32 = 0.011_108_997;

impl PointGradient {
    pub(crate) fn new(kernel: PointKernel) -> Self {
        let factor = match kernel {
            PointKernel::CubicSpline | PointKernel::Cone => kernel.at(0.0),
            PointKernel::Gaussian => kernel.slope_by_distance(0.0) / -9.0,
        };
        Self { kernel, factor: factor as f32 }
    }

    /// The gradients along chords at distances b in [0, 1].
    #[inline(always)]
    pub(crate) fn along<S: Simd>(self, simd: S, b: f32x16<S>) -> GradientCourse<S> {
        let zero = splat(simd, 0.0);
        // Nearer to the middle the part across, about b ln b, is as good as none.
        let b = b.max(splat(simd, 1e-6));
        let bend = match self.kernel {
            PointKernel::CubicSpline => {
                let z = ((splat(simd, 0.5) - b) * (b + 0.5)).max(zero).sqrt();
                [z, ln(simd, z + b.max(splat(simd, 0.5)))]
            }
            _ => [zero; 2],
        };
        GradientCourse { of: self, b, square: b * b, ln: ln(simd, b), bend }
    }
}

impl<S: Simd> GradientCourse<S> {
    /// J and W at places up to the kernel's edge; `whole` is ∫ W from the nearest place.
    #[inline(always)]
    pub(crate) fn up_to(&self, simd: S, z: f32x16<S>, whole: f32x16<S>) -> GradientSum<S> {
        let PointGradient { kernel, factor } = self.of;
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let s = z.abs();
        let t = (self.square + s * s).sqrt();
        let [size, along] = match kernel {
            PointKernel::CubicSpline => {
                let of_end = ln(simd, s + t);
                let [bend, of_bend] = self.bend;
                let within = s.simd_lt(bend);
                let (cut, of_cut) = (pick(within, s, bend), pick(within, of_end, of_bend));
                let at_cut = pick(within, t, self.b.max(splat(simd, 0.5)));
                let inner = cut * at_cut + self.square * (of_cut - self.ln);
                let outer = s * t - cut * at_cut + self.square * (of_end - of_cut);
                let across = inner * 9.0 - cut * 12.0 + ((s - cut) * 12.0 - outer * 3.0 - (of_end - of_cut) * 6.0);
                let rest = (one - t).max(zero);
                let near = one - t * t * rest * 6.0;
                let far = rest * rest * rest * 2.0;
                [across, pick(t.simd_le(splat(simd, 0.5)), near, far)]
            }
            PointKernel::Gaussian => {
                let above = one - opacity_of_depth(simd, t * t * 4.5) - EDGE;
                return GradientSum { across: (whole + z * (factor * EDGE)) * -9.0, along: above.max(zero) * factor };
            }
            PointKernel::Cone => [self.ln - ln(simd, s + t), (one - t).max(zero)],
        };
        let across = pick(z.simd_lt(zero), -size, size) * factor;
        GradientSum { across, along: along * factor }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::{Profile, Radial};
    use fearless_simd::{Level, dispatch};

    fn radial(kernel: PointKernel) -> Radial {
        let Profile::Radial(radial) = Profile::point(kernel) else { unreachable!("points' kernels are") };
        radial
    }

    #[test]
    fn closed_forms_are_what_quadrature_gives() {
        for kernel in PointKernel::ALL {
            let (radial, gradient) = (radial(kernel), PointGradient::new(kernel));
            let (mut worst, mut peak) = ([0.0f64; 2], 0.0f64);
            for i in 0..=60 {
                let b = f64::from(i) / 60.0;
                let half = ((1.0 - b) * (1.0 + b)).sqrt();
                for k in -20..=20 {
                    let z = half * f64::from(k) / 20.0;
                    let whole = radial.along_line(b, z);
                    let found = dispatch!(Level::new(), simd => {
                        let course = gradient.along(simd, splat(simd, b as f32));
                        let sum = course.up_to(simd, splat(simd, z as f32), splat(simd, whole as f32));
                        [sum.across.to_array()[3], sum.along.to_array()[3]]
                    });
                    // The part across is b times J.
                    let want = [b * radial.slope_section(b, 0.0, z), kernel.at((b * b + z * z).sqrt())];
                    worst[0] = worst[0].max((b * f64::from(found[0]) - want[0]).abs());
                    worst[1] = worst[1].max((f64::from(found[1]) - want[1]).abs());
                    peak = peak.max(want[1]);
                }
            }
            println!("{kernel}: {worst:?} of {peak:.2}");
            // Rounding of logarithms and roots.
            assert!(worst[0] < 3e-6 * peak && worst[1] < 2e-6 * peak, "{kernel}: {worst:?}");
        }
    }
}
