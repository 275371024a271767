//! Kernels of scattered points, which spread the value of each around it.

/// A radially symmetric kernel W(t) over t = distance / radius in [0, 1]; 0 beyond. Its integral over the unit ball is 1.
///
/// | kernel | W(t) ∝ |
/// |---|---|
/// | cubic spline | 1 − 6t² + 6t³ up to t = ½, 2(1 − t)³ beyond: M₄ of smoothed particle hydrodynamics (Monaghan & Lattanzio 1985, "A refined particle method for astrophysical problems"), whose smoothing length is half the radius |
/// | Gaussian | e^(−4.5 t²) − e^(−4.5): three standard deviations to a radius, lowered so that it ends in 0 |
/// | cone | 1 − t |
///
/// # Examples
/// ```
/// use vr_core::PointKernel;
///
/// for kernel in PointKernel::ALL {
///     // The integral over the unit ball, 4π ∫ W t² dt, is 1.
///     let shell = |i: i32| { let t = (f64::from(i) + 0.5) / 1000.0; kernel.at(t) * t * t / 1000.0 };
///     let integral = 4.0 * std::f64::consts::PI * (0..1000).map(shell).sum::<f64>();
///     assert!((integral - 1.0).abs() < 1e-5, "{}: {integral}", kernel.name());
/// }
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum PointKernel {
    /// M₄.
    #[default]
    CubicSpline,
    /// Truncated at three standard deviations.
    Gaussian,
    /// Falls linearly.
    Cone,
}

/// −ln of a Gaussian at its radius.
const EDGE: f64 = 4.5;

impl PointKernel {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::CubicSpline, Self::Gaussian, Self::Cone];

    /// Name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::CubicSpline => "cubic-spline",
            Self::Gaussian => "gaussian",
            Self::Cone => "cone",
        }
    }

    /// The kernel of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|k| k.name() == name)
    }

    /// W(t) for t ≥ 0.
    pub fn at(self, t: f64) -> f64 {
        if t >= 1.0 {
            return 0.0;
        }
        let u = 1.0 - t;
        self.factor()
            * match self {
                Self::CubicSpline if t <= 0.5 => 1.0 - 6.0 * t * t * u,
                Self::CubicSpline => 2.0 * u * u * u,
                // (1 − e^(−x)) e^(−4.5) without cancellation near the edge.
                Self::Gaussian => libm::exp(-EDGE) * libm::expm1(EDGE * u * (1.0 + t)),
                Self::Cone => u,
            }
    }

    /// dW/dt; at t = ½ and t = 1, where it may jump in higher derivatives or itself, that of the outer side.
    pub fn slope(self, t: f64) -> f64 {
        if t >= 1.0 {
            return 0.0;
        }
        let u = 1.0 - t;
        self.factor()
            * match self {
                Self::CubicSpline if t <= 0.5 => -12.0 * t + 18.0 * t * t,
                Self::CubicSpline => -6.0 * u * u,
                Self::Gaussian => -2.0 * EDGE * t * libm::exp(-EDGE * t * t),
                Self::Cone => -1.0,
            }
    }

    /// (dW/dt)/t: the factor of the vector from the point, in radii, in the gradient. 0 in the middle of a cone, which has no gradient there.
    pub fn slope_by_distance(self, t: f64) -> f64 {
        if t >= 1.0 {
            return 0.0;
        }
        let u = 1.0 - t;
        self.factor()
            * match self {
                Self::CubicSpline if t <= 0.5 => -12.0 + 18.0 * t,
                Self::CubicSpline => -6.0 * u * u / t,
                Self::Gaussian => -2.0 * EDGE * libm::exp(-EDGE * t * t),
                Self::Cone if t > 0.0 => -1.0 / t,
                Self::Cone => 0.0,
            }
    }

    /// The t > 0 at which W is not smooth.
    pub fn breakpoints(self) -> &'static [f64] {
        match self {
            Self::CubicSpline => &[0.5, 1.0],
            Self::Gaussian | Self::Cone => &[1.0],
        }
    }

    /// One over the integral over the unit ball of the formula in the table above.
    fn factor(self) -> f64 {
        use std::f64::consts::PI;
        match self {
            Self::CubicSpline => 8.0 / PI,
            // 4π ∫ t² (e^(−4.5t²) − e^(−4.5)) dt; ∫ t² e^(−at²) = (√(π/a) erf(√a) − 2 e^(−a)) / 4a.
            Self::Gaussian => {
                let moment = ((PI / EDGE).sqrt() * libm::erf(EDGE.sqrt()) - 2.0 * libm::exp(-EDGE)) / (4.0 * EDGE);
                1.0 / (4.0 * PI * (moment - libm::exp(-EDGE) / 3.0))
            }
            Self::Cone => 3.0 / PI,
        }
    }
}

impl std::fmt::Display for PointKernel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_are_normalised() {
        // The midpoint rule on 4096 parts is off by at most (1/4096)²/24 times the second derivative, below 10³ here.
        let n = 4096;
        for kernel in PointKernel::ALL {
            let shell = |i: i32| {
                let t = (f64::from(i) + 0.5) / f64::from(n);
                4.0 * std::f64::consts::PI * t * t * kernel.at(t) / f64::from(n)
            };
            let total: f64 = (0..n).map(shell).sum();
            assert!((total - 1.0).abs() < 3e-6, "{kernel}: {total}");
        }
    }

    #[test]
    fn slopes_are_those_of_the_values() {
        for kernel in PointKernel::ALL {
            for i in 1..100 {
                let t = f64::from(i) / 100.0 + 1e-3;
                let h = 1e-6;
                let difference = (kernel.at(t + h) - kernel.at(t - h)) / (2.0 * h);
                assert!((difference - kernel.slope(t)).abs() < 1e-6, "{kernel} at {t}");
                assert!((kernel.slope_by_distance(t) * t - kernel.slope(t)).abs() < 1e-13, "{kernel} at {t}");
            }
        }
    }

    #[test]
    fn kernels_end_in_nothing_and_have_names() {
        for kernel in PointKernel::ALL {
            assert_eq!((kernel.at(1.0), kernel.at(2.0)), (0.0, 0.0));
            assert!(kernel.at(0.999_999) > 0.0 && kernel.at(0.999_999) < 1e-4);
            assert_eq!(PointKernel::from_name(kernel.name()), Some(kernel));
        }
    }
}
