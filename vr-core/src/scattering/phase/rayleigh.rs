//! Particles much smaller than the wavelength.

/// p = 3/4 (1 + cos² θ) at the cosine of an angle: unpolarised light scattered by small particles (Rayleigh, 1871).
pub(super) fn value(cosine: f64) -> f64 {
    0.75 * (1.0 + cosine * cosine)
}

/// Cosine of a random angle, of a number uniform in [0, 1): the root of c³ + 3c = 4 − 8u.
pub(super) fn sample_cosine(uniform: f64) -> f64 {
    // Cardano's formula in the form that keeps its digits: c = 2 sinh(asinh(q/2) / 3).
    let q = 4.0 - 8.0 * uniform;
    (2.0 * libm::sinh(libm::asinh(0.5 * q) / 3.0)).clamp(-1.0, 1.0)
}
