//! Colours of errors: a logarithmic scale, so that one scale serves renderers that are orders of magnitude apart.

use vr_core::transfer::inferno;

/// Exponents of ten at the ends of the scale: below is black, above the brightest colour.
pub const DECADES: (i32, i32) = (-7, -1);

/// Linear colour of an error hidden by noise.
pub const HIDDEN: [f32; 3] = [0.18; 3];

/// Returns the linear colour of an error; [`HIDDEN`] of NaN.
pub fn color(error: f64) -> [f32; 3] {
    if error.is_nan() {
        return HIDDEN;
    }
    let (low, high) = (f64::from(DECADES.0), f64::from(DECADES.1));
    at((error.max(f64::MIN_POSITIVE).log10() - low) / (high - low))
}

/// Returns the linear colour of a place on the scale, 0 to 1.
pub fn at(place: f64) -> [f32; 3] {
    inferno(place.clamp(0.0, 1.0)).map(|c| c as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_from_none_to_infinite_have_colours() {
        assert_eq!(color(0.0), at(0.0));
        assert_eq!(color(f64::INFINITY), at(1.0));
        assert_eq!(color(1e-4), at(0.5));
        assert_eq!(color(f64::NAN), HIDDEN);
    }
}
