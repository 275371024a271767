//! Recipes of presets: the numbers from which their control points are made.

use crate::shading::Shading;
use crate::transfer::{ControlPoint, srgb_to_linear};

use super::PresetFamily;

/// Value, sRGB colour and opacity of a control point.
pub(super) type Row = (f64, [f64; 3], f64);

/// Everything that tells one preset from another.
pub(super) struct Recipe {
    pub name: &'static str,
    /// Content of the picture, in one line.
    pub title: &'static str,
    pub family: PresetFamily,
    pub curve: Curve,
    pub gloss: Option<Gloss>,
    /// True if the largest value along a ray is meant, not light and absorption.
    pub is_projection: bool,
}

/// The course of colour and opacity.
pub(super) enum Curve {
    /// Values in Hounsfield units.
    Hounsfield(&'static [Row]),
    /// Values as fractions of the signal, from the background to the brightest that is not rare.
    Signal(&'static [Row]),
    /// A colour map over all values, and the opacity at its end.
    Map { color: fn(f64) -> [f64; 3], points: usize, opacity: f64 },
    /// A colour map with a middle: at zero where values have both signs, and clear there.
    Diverging { color: fn(f64) -> [f64; 3], points: usize, opacity: f64 },
}

/// Reflection of the surfaces that a preset shows.
pub(super) enum Gloss {
    /// Dry bone, skin, tissue in a scan of coarse voxels.
    Matte,
    /// Wet tissue, vessels.
    Moist,
    /// Haze with some relief: so much ambient light that noise does not darken it.
    Soft,
}

impl Gloss {
    pub fn shading(&self) -> Shading {
        let (ambient, diffuse, specular, power) = match self {
            Self::Matte => (0.25, 0.80, 0.15, 12.0),
            Self::Moist => (0.25, 0.75, 0.35, 30.0),
            Self::Soft => (0.50, 0.60, 0.10, 10.0),
        };
        Shading { ambient, diffuse, specular, power, ..Shading::default() }
    }
}

/// The control points of rows whose positions `value` turns into values.
pub(super) fn points(rows: &[Row], value: impl Fn(f64) -> f64) -> Vec<ControlPoint> {
    let point =
        |&(position, srgb, opacity): &Row| ControlPoint::new(value(position), srgb.map(srgb_to_linear), opacity);
    rows.iter().map(point).collect()
}

/// `count` points, evenly spaced over a range.
pub(super) fn ramp(
    (low, high): (f64, f64),
    count: usize,
    color: impl Fn(f64) -> [f64; 3],
    opacity: impl Fn(f64) -> f64,
) -> Vec<ControlPoint> {
    let fractions = (0..count).map(|k| k as f64 / (count - 1) as f64);
    fractions.map(|t| ControlPoint::new(low + t * (high - low), color(t), opacity(t))).collect()
}
