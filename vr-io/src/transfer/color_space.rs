//! The colour spaces in which ParaView interpolates.

use vr_core::transfer::{Lab, diverging, linear_to_srgb, srgb_to_linear};

use crate::error::FieldError;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ColorSpace {
    Rgb,
    Hsv,
    Lab,
    Diverging,
    Step,
}

impl ColorSpace {
    pub fn from_name(name: &str, notes: &mut Vec<String>) -> Result<Self, FieldError> {
        Ok(match name.to_lowercase().as_str() {
            "rgb" => Self::Rgb,
            "hsv" => Self::Hsv,
            "lab" | "cielab" => Self::Lab,
            // A path of even CIEDE2000 steps; between neighbouring points hardly anything else.
            "lab/ciede2000" | "labciede2000" | "ciede2000" => {
                notes.push(format!("colour space {name} is followed along straight lines in Lab"));
                Self::Lab
            }
            "diverging" => Self::Diverging,
            "step" => Self::Step,
            _ => return Err(FieldError::new("ColorSpace", name, "must be RGB, HSV, Lab, Diverging or Step")),
        })
    }

    /// The linear-light colour at a fraction t of the way between two sRGB-encoded ones.
    pub fn between(self, from: [f64; 3], to: [f64; 3], t: f64) -> [f64; 3] {
        let linear = |c: [f64; 3]| c.map(srgb_to_linear);
        match self {
            Self::Rgb => linear(std::array::from_fn(|i| from[i] + t * (to[i] - from[i]))),
            Self::Hsv => linear(hsv_between(from, to, t)),
            Self::Lab => Lab::from_linear_rgb(linear(from)).lerp(Lab::from_linear_rgb(linear(to)), t).to_linear_rgb(),
            Self::Diverging => diverging(linear(from), linear(to), t),
            Self::Step => linear(to),
        }
    }
}

/// True if two linear-light colours differ so much that 8 bits on a screen would show it.
pub(super) fn differ(a: [f64; 3], b: [f64; 3]) -> bool {
    (0..3).any(|i| (linear_to_srgb(a[i]) - linear_to_srgb(b[i])).abs() > 1.0 / 255.0)
}

/// Hue the shorter way round, saturation and value, all linear.
fn hsv_between(from: [f64; 3], to: [f64; 3], t: f64) -> [f64; 3] {
    let (mut a, mut b) = (hsv_of_rgb(from), hsv_of_rgb(to));
    if (a[0] - b[0]).abs() > 0.5 {
        let larger = if a[0] > b[0] { &mut a } else { &mut b };
        larger[0] -= 1.0;
    }
    let [h, s, v] = std::array::from_fn(|i| a[i] + t * (b[i] - a[i]));
    rgb_of_hsv([h.rem_euclid(1.0), s, v])
}

/// Smith, "Color gamut transform pairs", SIGGRAPH 1978: the hexcone model. Hue in [0, 1).
fn hsv_of_rgb([r, g, b]: [f64; 3]) -> [f64; 3] {
    let (value, min) = (r.max(g).max(b), r.min(g).min(b));
    let chroma = value - min;
    if chroma == 0.0 {
        return [0.0, 0.0, value];
    }
    let sixths = if value == r {
        (g - b) / chroma
    } else if value == g {
        2.0 + (b - r) / chroma
    } else {
        4.0 + (r - g) / chroma
    };
    [(sixths / 6.0).rem_euclid(1.0), chroma / value, value]
}

fn rgb_of_hsv([hue, saturation, value]: [f64; 3]) -> [f64; 3] {
    // How far each primary is from its maximum, around the circle.
    [5.0, 3.0, 1.0].map(|n: f64| {
        let k = (n + 6.0 * hue).rem_euclid(6.0);
        value - value * saturation * k.min(4.0 - k).clamp(0.0, 1.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hsv_there_and_back() {
        for rgb in
            [[1.0, 0.0, 0.0], [0.2, 0.9, 0.4], [0.3, 0.1, 0.8], [0.5, 0.5, 0.5], [0.0, 1.0, 1.0], [0.9, 0.8, 0.0]]
        {
            let back = rgb_of_hsv(hsv_of_rgb(rgb));
            assert!((0..3).all(|i| (back[i] - rgb[i]).abs() < 1e-12), "{rgb:?} {back:?}");
        }
    }

    #[test]
    fn hue_takes_the_shorter_way() {
        // From hue 350° to 10°: over red, not over cyan.
        let middle = hsv_between(rgb_of_hsv([350.0 / 360.0, 1.0, 1.0]), rgb_of_hsv([10.0 / 360.0, 1.0, 1.0]), 0.5);
        assert!((middle[0] - 1.0).abs() < 1e-12 && middle[1].abs() < 1e-9 && middle[2].abs() < 1e-9, "{middle:?}");
    }

    #[test]
    fn ends_are_kept() {
        let (a, b) = ([0.1, 0.7, 0.3], [0.9, 0.2, 0.4]);
        for space in [ColorSpace::Rgb, ColorSpace::Hsv, ColorSpace::Lab, ColorSpace::Diverging] {
            for (t, end) in [(0.0, a), (1.0, b)] {
                let c = space.between(a, b, t).map(linear_to_srgb);
                assert!((0..3).all(|i| (c[i] - end[i]).abs() < 1e-6), "{space:?} {c:?}");
            }
        }
    }
}
