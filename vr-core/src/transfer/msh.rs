//! Diverging colour maps: interpolation in Msh, the polar form of CIELAB.
//!
//! Moreland, "Diverging color maps for scientific visualization", International Symposium on Visual Computing 2009, LNCS
//! 5876, and its expanded version, whose pseudocode this follows; so do VTK and ParaView (colour space `Diverging`).

use std::f64::consts::{FRAC_PI_3, PI};

use super::lab::Lab;

/// Below this saturation a colour counts as grey: its hue means nothing.
const GREY: f64 = 0.05;
/// Magnitude of the white in the middle, or more if an end is brighter.
const WHITE: f64 = 88.0;

/// A colour as magnitude, saturation and hue: spherical coordinates of Lab.
///
/// # Examples
/// ```
/// use vr_core::transfer::{Lab, Msh};
///
/// let red = Lab::from_linear_rgb([0.5, 0.0, 0.0]);
/// let polar = Msh::from(red);
/// assert!(polar.s > 0.05, "no grey");
/// assert!((Lab::from(polar).a - red.a).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Msh {
    /// Distance from black in Lab.
    pub m: f64,
    /// Angle from the lightness axis, in radians; 0 is grey.
    pub s: f64,
    /// Angle in the a*b* plane, in radians, −π to π.
    pub h: f64,
}

impl From<Lab> for Msh {
    fn from(Lab { l, a, b }: Lab) -> Self {
        let m = (l * l + a * a + b * b).sqrt();
        // Black has every saturation and hue: take none. Rounding may take l past m.
        let s = if m > 1e-3 { libm::acos((l / m).min(1.0)) } else { 0.0 };
        let h = if s > 1e-3 { libm::atan2(b, a) } else { 0.0 };
        Self { m, s, h }
    }
}

impl From<Msh> for Lab {
    fn from(Msh { m, s, h }: Msh) -> Self {
        let chroma = m * libm::sin(s);
        Self { l: m * libm::cos(s), a: chroma * libm::cos(h), b: chroma * libm::sin(h) }
    }
}

impl Msh {
    fn is_grey(self) -> bool {
        self.s < GREY
    }

    /// The hue to give a grey of magnitude `grey` next to this colour, spun so that the path between them is of even
    /// perceptual speed; away from purple, which looks out of place in a map of blue or red.
    fn hue_towards(self, grey: f64) -> f64 {
        if self.m >= grey - 0.1 {
            // The spin is for a magnitude that grows; here it would turn the wrong way.
            return self.h;
        }
        let spin = self.s * (grey * grey - self.m * self.m).sqrt() / (self.m * libm::sin(self.s));
        if self.h > -0.3 * PI { self.h + spin } else { self.h - spin }
    }
}

/// The colour at t in [0, 1] between two linear-light RGB colours, through white in the middle if both are saturated and
/// their hues differ by more than 60°.
pub fn diverging(from: [f64; 3], to: [f64; 3], t: f64) -> [f64; 3] {
    let mut low = Msh::from(Lab::from_linear_rgb(from));
    let mut high = Msh::from(Lab::from_linear_rgb(to));
    let mut t = t;

    if !low.is_grey() && !high.is_grey() && angle_between(low.h, high.h) > FRAC_PI_3 {
        let white = Msh { m: low.m.max(high.m).max(WHITE), s: 0.0, h: 0.0 };
        if t < 0.5 {
            (high, t) = (white, 2.0 * t);
        } else {
            (low, t) = (white, 2.0 * t - 1.0);
        }
    }
    if low.is_grey() && !high.is_grey() {
        low.h = high.hue_towards(low.m);
    } else if high.is_grey() && !low.is_grey() {
        high.h = low.hue_towards(high.m);
    }

    let mix = |a: f64, b: f64| a + t * (b - a);
    let mixed = Msh { m: mix(low.m, high.m), s: mix(low.s, high.s), h: mix(low.h, high.h) };
    Lab::from(mixed).to_linear_rgb()
}

fn angle_between(a: f64, b: f64) -> f64 {
    let d = (a - b).abs();
    d.min(2.0 * PI - d)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::{linear_to_srgb, srgb_to_linear};

    fn linear(rgb: [u8; 3]) -> [f64; 3] {
        rgb.map(|c| srgb_to_linear(f64::from(c) / 255.0))
    }

    #[test]
    fn lab_there_and_back() {
        for rgb in [[59, 76, 192], [180, 4, 38], [1, 2, 3], [221, 221, 221], [0, 255, 0], [0, 0, 0]].map(linear) {
            let lab = Lab::from_linear_rgb(rgb);
            let back = Lab::from(Msh::from(lab));
            let error = (back.l - lab.l).abs() + (back.a - lab.a).abs() + (back.b - lab.b).abs();
            assert!(error < 0.1, "{lab:?} {back:?}");
        }
    }

    #[test]
    fn ends_are_kept_and_similar_hues_go_straight() {
        let (a, b) = (linear([200, 40, 40]), linear([230, 150, 60]));
        for (t, expected) in [(0.0, a), (1.0, b)] {
            let found = diverging(a, b, t);
            assert!((0..3).all(|i| (found[i] - expected[i]).abs() < 1e-12), "{found:?} {expected:?}");
        }
        let middle = Msh::from(Lab::from_linear_rgb(diverging(a, b, 0.5)));
        assert!(middle.s > 0.5, "{middle:?} is not a saturated colour");
    }

    #[test]
    fn grey_takes_a_hue_that_means_something() {
        // From white to blue: never over to the red side.
        let (white, blue) = (linear([255; 3]), linear([59, 76, 192]));
        for k in 0..=20 {
            let [r, _, b] = diverging(white, blue, f64::from(k) / 20.0).map(linear_to_srgb);
            assert!(b >= r, "{k}: red {r} over blue {b}");
        }
    }
}
